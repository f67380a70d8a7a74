//! How handles hold a mesh: vertices that cannot move, and places within triangles that are gripped.
//!
//! A point on a vertex holds it exactly. A point elsewhere grips the corners of its triangle by their barycentric
//! weights. A bone grips every place along it that lies on the mesh. Vertices that hang together with no handle stay
//! where they are at rest. Where handles hold one spot, it goes midway between their targets.

use glam::Vec2;

use super::GRIP;
use crate::deform::Handle;
use crate::error::{Error, Result};

/// A handle this near to a vertex is on it; lengths are in mean edges.
const ON_VERTEX: f32 = 1e-3;
/// A point this far outside the mesh still counts as on it: drawn outlines are cut by chords.
const OUTSIDE: f32 = 2.0;
/// Steps along a bone.
const ALONG_BONE: f32 = 1.0;

/// A place within a triangle that a handle grips.
#[derive(Clone, Debug)]
struct Grip {
    triangle: [u32; 3],
    weights: [f32; 3],
    spot: usize,
}

/// Where on a handle a spot lies: which one, and how far from a bone's root to its tip.
#[derive(Clone, Copy, Debug)]
struct Share {
    handle: usize,
    along: f32,
    /// What it keeps of the way from its handle: its distance from it at rest.
    offset: Vec2,
}

/// Everything that holds a mesh. Targets are a place for each spot.
#[derive(Clone, Debug)]
pub(super) struct Anchors {
    handles: Vec<Handle>,
    shares: Vec<Vec<Share>>,
    rest: Vec<Vec2>,
    /// The vertex of a spot that holds one.
    vertex: Vec<Option<u32>>,
    grips: Vec<Grip>,
    /// Vertices of parts without handles, with their places at rest.
    idle: Vec<(u32, Vec2)>,
    held: Vec<bool>,
    /// A free vertex, a held one beside it, and their entry in the matrix.
    couplings: Vec<(u32, u32, f32)>,
    /// Where held vertices are: spots and idle ones.
    fixed: Vec<u32>,
    place: Vec<Vec2>,
}

impl Anchors {
    pub(super) fn new(points: &[Vec2], triangles: &[[u32; 3]], handles: &[Handle]) -> Result<Self> {
        let n = points.len();
        let mut own = Self {
            handles: handles.to_vec(),
            shares: Vec::new(),
            rest: Vec::new(),
            vertex: Vec::new(),
            grips: Vec::new(),
            idle: Vec::new(),
            held: vec![false; n],
            couplings: Vec::new(),
            fixed: Vec::new(),
            place: vec![Vec2::ZERO; n],
        };
        for (handle, h) in handles.iter().enumerate() {
            let bad = |problem: &str, remedy: &str| Err(Error::invalid(format!("handle {handle}"), problem, remedy));
            if !h.is_finite() {
                return bad("is not a number", "give finite places");
            }
            let found = match *h {
                Handle::Point(at) => {
                    own.hold(points, triangles, at, Share { handle, along: 0.0, offset: Vec2::ZERO }, OUTSIDE)
                }
                Handle::Bone(root, tip) => {
                    // A bone longer than the mesh is wide has most of it outside.
                    let steps = (root.distance(tip) / ALONG_BONE).ceil().clamp(1.0, 4.0 * n as f32) as usize;
                    let spot = |k: usize| k as f32 / steps as f32;
                    (0..=steps)
                        .map(|k| {
                            let share = Share { handle, along: spot(k), offset: Vec2::ZERO };
                            own.hold(points, triangles, root.lerp(tip, spot(k)), share, 1e-3)
                        })
                        .fold(false, |any, on| any | on)
                }
            };
            if !found {
                return bad("lies outside the mesh", "move it onto the mesh");
            }
        }
        own.hold_idle(points, triangles);
        own.fixed = (0..n as u32).filter(|&v| own.held[v as usize]).collect();
        Ok(own)
    }

    /// Holds the place `at`; whether the mesh is there, or within `outside` of it.
    fn hold(&mut self, points: &[Vec2], triangles: &[[u32; 3]], at: Vec2, share: Share, outside: f32) -> bool {
        let near = |v: usize| points[v].distance_squared(at);
        let on = (0..points.len())
            .filter(|&v| near(v) <= ON_VERTEX * ON_VERTEX)
            .min_by(|&a, &b| near(a).total_cmp(&near(b)));
        if let Some(v) = on.filter(|&v| triangles.iter().any(|t| t.contains(&(v as u32)))) {
            match self.vertex.iter().position(|w| *w == Some(v as u32)) {
                Some(spot) => self.shares[spot].push(share),
                None => {
                    self.held[v] = true;
                    self.spot(share, points[v], Some(v as u32));
                }
            }
            return true;
        }
        let mut best = (f32::INFINITY, 0, [0.0; 3]);
        for (t, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(|v| points[v as usize]);
            let (weights, gap) = nearest_in(corners, at);
            if gap < best.0 {
                best = (gap, t, weights);
                if gap == 0.0 {
                    break;
                }
            }
        }
        if best.0 > outside {
            return false;
        }
        let triangle = triangles[best.1];
        let on: Vec2 = triangle.iter().zip(best.2).map(|(&v, w)| points[v as usize] * w).sum();
        let share = Share { offset: on - at, ..share };
        let spot = self.spot(share, on, None);
        self.grips.push(Grip { triangle, weights: best.2, spot });
        true
    }

    fn spot(&mut self, share: Share, rest: Vec2, vertex: Option<u32>) -> usize {
        self.shares.push(vec![share]);
        self.rest.push(rest);
        self.vertex.push(vertex);
        self.rest.len() - 1
    }

    /// Holds every vertex that hangs together with no handle.
    fn hold_idle(&mut self, points: &[Vec2], triangles: &[[u32; 3]]) {
        let mut root: Vec<u32> = (0..points.len() as u32).collect();
        fn find(root: &mut [u32], mut v: u32) -> u32 {
            while root[v as usize] != v {
                root[v as usize] = root[root[v as usize] as usize];
                v = root[v as usize];
            }
            v
        }
        for t in triangles {
            for v in [t[1], t[2]] {
                let (a, b) = (find(&mut root, t[0]), find(&mut root, v));
                root[a.max(b) as usize] = a.min(b);
            }
        }
        let mut driven = vec![false; points.len()];
        let spots = self.vertex.iter().flatten().copied().chain(self.grips.iter().map(|g| g.triangle[0]));
        for v in spots.collect::<Vec<_>>() {
            driven[find(&mut root, v) as usize] = true;
        }
        for v in 0..points.len() as u32 {
            if !driven[find(&mut root, v) as usize] {
                self.held[v as usize] = true;
                self.idle.push((v, points[v as usize]));
            }
        }
    }

    /// Which vertices cannot move.
    pub(super) fn held(&self) -> &[bool] {
        &self.held
    }

    /// The vertices that cannot move, rising.
    pub(super) fn fixed(&self) -> &[u32] {
        &self.fixed
    }

    /// The gripped triangles and the weights of their corners.
    pub(super) fn grips(&self) -> impl ExactSizeIterator<Item = (&[u32; 3], [f32; 3])> {
        self.grips.iter().map(|g| (&g.triangle, g.weights))
    }

    /// Remembers the matrix entry between a free and a held vertex.
    pub(super) fn couple(&mut self, free: u32, held: u32, value: f64) {
        self.couplings.push((free, held, value as f32));
    }

    /// The place of every spot when the handles are at `handles`, each place passed through `map`.
    pub(super) fn targets(&self, handles: &[Handle], map: impl Fn(Vec2) -> Vec2 + Copy) -> Result<Vec<Vec2>> {
        if handles.len() != self.handles.len() {
            let problem = format!("{} were given and {} bound", handles.len(), self.handles.len());
            return Err(Error::invalid("handles", problem, "pass a target for each handle"));
        }
        for (i, (new, bound)) in handles.iter().zip(&self.handles).enumerate() {
            if std::mem::discriminant(new) != std::mem::discriminant(bound) {
                return Err(Error::invalid(
                    format!("handle {i}"),
                    "is of another kind than was bound",
                    "keep its kind",
                ));
            }
            if !new.is_finite() {
                return Err(Error::invalid(format!("handle {i}"), "is not a number", "give finite places"));
            }
        }
        let place = |s: &Share| {
            s.offset
                + match handles[s.handle] {
                    Handle::Point(at) => map(at),
                    Handle::Bone(root, tip) => map(root.lerp(tip, s.along)),
                }
        };
        let mean = |shares: &Vec<Share>| shares.iter().map(place).sum::<Vec2>() / shares.len() as f32;
        Ok(self.shares.iter().map(mean).collect())
    }

    /// Where the spots are in the shape `u`.
    pub(super) fn at(&self, u: &[Vec2]) -> Vec<Vec2> {
        let mut at: Vec<Vec2> = self.vertex.iter().map(|v| v.map_or(Vec2::ZERO, |v| u[v as usize])).collect();
        for g in &self.grips {
            at[g.spot] = g.at(u);
        }
        at
    }

    /// Whether the spots are where they are at rest.
    pub(super) fn at_rest(&self, spots: &[Vec2]) -> bool {
        spots.iter().zip(&self.rest).all(|(a, b)| a.distance_squared(*b) < ON_VERTEX * ON_VERTEX)
    }

    /// Adds what held vertices and grips pull at free ones.
    pub(super) fn pull(&mut self, targets: &[Vec2], sum: &mut [Vec2]) {
        let mut place = std::mem::take(&mut self.place);
        self.place(targets, &mut place);
        for &(free, held, value) in &self.couplings {
            sum[free as usize] -= value * place[held as usize];
        }
        self.place = place;
        for g in &self.grips {
            g.add(targets[g.spot] * GRIP as f32, sum);
        }
    }

    /// Puts held vertices in their places.
    pub(super) fn place(&self, targets: &[Vec2], u: &mut [Vec2]) {
        for (v, target) in self.vertex.iter().zip(targets) {
            if let Some(v) = v {
                u[*v as usize] = *target;
            }
        }
        self.idle.iter().for_each(|(v, at)| u[*v as usize] = *at);
    }

    /// Nothing pulls at held vertices.
    pub(super) fn clear(&self, sum: &mut [Vec2]) {
        self.fixed.iter().for_each(|&v| sum[v as usize] = Vec2::ZERO);
    }

    /// Adds the gradient of the grips, halved, and gives their energy.
    pub(super) fn gradient(&self, targets: &[Vec2], u: &[Vec2], gradient: &mut [Vec2]) -> f64 {
        let mut energy = 0.0;
        for g in &self.grips {
            let gap = g.at(u) - targets[g.spot];
            g.add(gap * GRIP as f32, gradient);
            energy += GRIP * f64::from(gap.length_squared());
        }
        energy
    }

    /// Takes the last give out of the grips: the least move of their corners that brings them to their targets.
    pub(super) fn touch(&self, targets: &[Vec2], u: &mut [Vec2]) {
        // Grips that share corners disturb one another; a few rounds settle them.
        for _ in 0..8 {
            for g in &self.grips {
                let square: f32 = g.weights.iter().map(|w| w * w).sum();
                let gap = (targets[g.spot] - g.at(u)) / square;
                g.add_free(gap, &self.held, u);
            }
        }
    }
}

impl Grip {
    fn at(&self, u: &[Vec2]) -> Vec2 {
        self.triangle.iter().zip(self.weights).map(|(&v, w)| u[v as usize] * w).sum()
    }

    fn add(&self, amount: Vec2, sum: &mut [Vec2]) {
        for (&v, w) in self.triangle.iter().zip(self.weights) {
            let v = v as usize;
            sum[v] += amount * w;
        }
    }

    fn add_free(&self, amount: Vec2, held: &[bool], sum: &mut [Vec2]) {
        for (&v, w) in self.triangle.iter().zip(self.weights).filter(|(v, _)| !held[**v as usize]) {
            let v = v as usize;
            sum[v] += amount * w;
        }
    }
}

/// The barycentric weights of the place in a triangle that is nearest to `p`, and how far it is.
fn nearest_in(corners: [Vec2; 3], p: Vec2) -> ([f32; 3], f32) {
    let [a, b, c] = corners;
    let area = (b - a).perp_dot(c - a);
    if area != 0.0 {
        let w = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)].map(|x| x / area);
        if w.iter().all(|w| *w >= 0.0) {
            return (w, 0.0);
        }
    }
    let mut best = ([1.0, 0.0, 0.0], f32::INFINITY);
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let (from, along) = (corners[i], corners[j] - corners[i]);
        let t = ((p - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let gap = p.distance(from + t * along);
        if gap < best.1 {
            let mut w = [0.0; 3];
            (w[i], w[j]) = (1.0 - t, t);
            best = (w, gap);
        }
    }
    best
}
