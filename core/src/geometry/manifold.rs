//! Whether a triangle mesh is a closed manifold: the surface of a solid.
//!
//! Looks at indices alone, so that vertices in one place with two numbers are two vertices. Says nothing of triangles that
//! pass through each other.

use glam::Vec3;

/// What is wrong with a mesh that should be closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defect {
    /// A triangle names a vertex that is not there, or one vertex twice.
    Triangle(usize),
    /// An edge has not one triangle on either side that agree on what is outside.
    Edge(u32, u32),
    /// The triangles around a vertex are more than one ring, or there are none.
    Vertex(u32),
}

/// The first reason why `triangles` over `vertices` vertices are no closed, oriented 2-manifold that uses every vertex;
/// `None` when they are one.
pub fn manifold_defect(vertices: usize, triangles: &[[u32; 3]]) -> Option<Defect> {
    if let Some(bad) = triangles
        .iter()
        .position(|&[a, b, c]| a == b || b == c || c == a || [a, b, c].iter().any(|&v| v as usize >= vertices))
    {
        return Some(Defect::Triangle(bad));
    }
    let half_edges = half_edges(triangles);
    if let Some(twice) = half_edges.windows(2).find(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1)) {
        return Some(Defect::Edge(twice[0].0, twice[0].1));
    }
    let triangle_of = |from: u32, to: u32| {
        half_edges.binary_search_by_key(&(from, to), |&(a, b, _)| (a, b)).ok().map(|at| half_edges[at].2)
    };
    if let Some(open) = half_edges.iter().find(|&&(a, b, _)| triangle_of(b, a).is_none()) {
        return Some(Defect::Edge(open.0, open.1));
    }
    let mut valence = vec![0u32; vertices];
    let mut start = vec![0u32; vertices];
    for &[a, b, c] in triangles {
        for (v, next) in [(a, b), (b, c), (c, a)] {
            valence[v as usize] += 1;
            start[v as usize] = next;
        }
    }
    // One turn around the vertex must meet all of its triangles.
    (0..vertices as u32).find_map(|v| {
        let (mut met, mut next) = (0, start[v as usize]);
        while met < valence[v as usize] {
            met += 1;
            let [a, b, c] = triangles[triangle_of(v, next)? as usize];
            next = if a == v {
                c
            } else if b == v {
                a
            } else {
                b
            };
            if next == start[v as usize] {
                break;
            }
        }
        (met == 0 || met != valence[v as usize] || next != start[v as usize]).then_some(Defect::Vertex(v))
    })
}

/// All directed edges with their triangle, sorted.
fn half_edges(triangles: &[[u32; 3]]) -> Vec<(u32, u32, u32)> {
    let mut edges = Vec::with_capacity(triangles.len() * 3);
    for (i, &[a, b, c]) in triangles.iter().enumerate() {
        edges.extend([(a, b, i as u32), (b, c, i as u32), (c, a, i as u32)]);
    }
    edges.sort_unstable();
    edges
}

/// The volume that a closed mesh holds, in cubed units of its positions; negative when it is inside out.
pub fn volume(positions: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let corner = |v: u32| positions[v as usize].as_dvec3();
    triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum::<f64>() / 6.0
}

/// For every triangle the number of its connected piece, from 0 in the order of first triangles.
pub fn pieces(vertices: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..vertices as u32).collect();
    let root = |parent: &mut Vec<u32>, mut v: u32| {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    };
    for &[a, b, c] in triangles {
        for other in [b, c] {
            let (p, q) = (root(&mut parent, a), root(&mut parent, other));
            parent[p.max(q) as usize] = p.min(q);
        }
    }
    let mut number = vec![u32::MAX; vertices];
    let mut count = 0;
    triangles
        .iter()
        .map(|t| {
            let r = root(&mut parent, t[0]) as usize;
            if number[r] == u32::MAX {
                number[r] = count;
                count += 1;
            }
            number[r]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn tells_a_solid_from_what_is_none() {
        assert_eq!(manifold_defect(4, &TETRAHEDRON), None);
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        assert!((volume(&corners, &TETRAHEDRON) - 1.0 / 6.0).abs() < 1e-9);
        assert!(matches!(manifold_defect(4, &TETRAHEDRON[..3]), Some(Defect::Edge(..))));
        assert_eq!(manifold_defect(3, &TETRAHEDRON), Some(Defect::Triangle(1)));
        assert_eq!(manifold_defect(5, &TETRAHEDRON), Some(Defect::Vertex(4)));
        let mut turned = TETRAHEDRON;
        turned[0].swap(0, 1);
        assert!(matches!(manifold_defect(4, &turned), Some(Defect::Edge(..))));
    }

    #[test]
    fn two_solids_that_touch_in_a_vertex_are_none() {
        let other = TETRAHEDRON.map(|t| t.map(|v| if v == 0 { 0 } else { v + 3 }));
        let both = [TETRAHEDRON, other].concat();
        assert_eq!(manifold_defect(7, &both), Some(Defect::Vertex(0)));
        assert_eq!(pieces(7, &both), [0; 8]);
        let apart = [TETRAHEDRON, TETRAHEDRON.map(|t| t.map(|v| v + 4))].concat();
        assert_eq!(manifold_defect(8, &apart), None);
        assert_eq!(pieces(8, &apart), [0, 0, 0, 0, 1, 1, 1, 1]);
    }
}
