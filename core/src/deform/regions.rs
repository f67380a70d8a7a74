//! Which bone each vertex belongs to, and what lies between bones.
//!
//! Pan and Zhang 2011, section 3.2: regions grow from the bones over the mesh, so that a hand beside the hip stays a
//! hand's. A triangle whose corners belong to one bone is interior, else it joins. Growth is by Dijkstra's shortest ways
//! along the mesh's edges; equal ones go to the lower bone.
//!
//! A bone that lies outside the mesh owns nothing. Vertices that no bone reaches, those of pieces without one, go to
//! the bone that is nearest in the plane.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec2;

use crate::geometry::{PlaneMesh, polygon};

/// What a vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexClass {
    /// On the rim of the mesh.
    Silhouette,
    /// Within one bone's region: none of its triangles joins regions.
    Interior,
    /// Where regions join.
    Joint,
}

/// The mesh parted among the bones.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    /// The bone of each vertex.
    pub bone: Vec<u32>,
    /// What each vertex is.
    pub class: Vec<VertexClass>,
    /// Whether each triangle joins regions.
    pub joins: Vec<bool>,
}

#[derive(PartialEq)]
struct Reached {
    way: f32,
    bone: u32,
    vertex: u32,
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.way.total_cmp(&other.way).then(self.bone.cmp(&other.bone)).then(self.vertex.cmp(&other.vertex))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Regions {
    /// Parts `mesh` among `segments`, the bones at rest, of which there is at least one.
    pub fn grow(mesh: &PlaneMesh, segments: &[(Vec2, Vec2)]) -> Self {
        let n = mesh.points.len();
        let gap = |v: usize, bone: usize| {
            let (a, b) = segments[bone];
            polygon::nearest_on_segment(a, b, mesh.points[v]).1.distance(mesh.points[v])
        };
        let mut beside: Vec<Vec<(u32, f32)>> = vec![Vec::new(); n];
        let edges = mesh.edges();
        for &([a, b], _) in &edges {
            let length = mesh.points[a as usize].distance(mesh.points[b as usize]);
            beside[a as usize].push((b, length));
            beside[b as usize].push((a, length));
        }
        let mut queue = BinaryHeap::new();
        for t in &mesh.triangles {
            let corners = t.map(|v| mesh.points[v as usize]);
            for (bone, &(a, b)) in segments.iter().enumerate() {
                if crosses(corners, a, b) {
                    for &v in t {
                        queue.push(Reverse(Reached { way: gap(v as usize, bone), bone: bone as u32, vertex: v }));
                    }
                }
            }
        }
        const FREE: u32 = u32::MAX;
        let mut bone = vec![FREE; n];
        while let Some(Reverse(Reached { way, bone: own, vertex })) = queue.pop() {
            if bone[vertex as usize] != FREE {
                continue;
            }
            bone[vertex as usize] = own;
            for &(next, length) in &beside[vertex as usize] {
                if bone[next as usize] == FREE {
                    queue.push(Reverse(Reached { way: way + length, bone: own, vertex: next }));
                }
            }
        }
        for v in 0..n {
            if bone[v] == FREE {
                let nearest = (0..segments.len()).min_by(|&a, &b| gap(v, a).total_cmp(&gap(v, b)).then(a.cmp(&b)));
                bone[v] = nearest.unwrap_or(0) as u32;
            }
        }
        let joins: Vec<bool> =
            mesh.triangles.iter().map(|t| t.iter().any(|&v| bone[v as usize] != bone[t[0] as usize])).collect();
        let mut class = vec![VertexClass::Interior; n];
        for (t, joins) in mesh.triangles.iter().zip(&joins) {
            if *joins {
                t.iter().for_each(|&v| class[v as usize] = VertexClass::Joint);
            }
        }
        for ([a, b], count) in edges {
            if count == 1 {
                class[a as usize] = VertexClass::Silhouette;
                class[b as usize] = VertexClass::Silhouette;
            }
        }
        Self { bone, class, joins }
    }
}

/// Whether the segment from `a` to `b` has a point within the triangle.
fn crosses(corners: [Vec2; 3], a: Vec2, b: Vec2) -> bool {
    // Cut off what lies outside each side in turn.
    let turn = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]).signum();
    let (mut from, mut to) = (0f32, 1f32);
    for i in 0..3 {
        let side = corners[(i + 1) % 3] - corners[i];
        let (at_a, at_b) = (turn * side.perp_dot(a - corners[i]), turn * side.perp_dot(b - corners[i]));
        match (at_a >= 0.0, at_b >= 0.0) {
            (false, false) => return false,
            (false, true) => from = from.max(at_a / (at_a - at_b)),
            (true, false) => to = to.min(at_a / (at_a - at_b)),
            (true, true) => {}
        }
    }
    from <= to
}
