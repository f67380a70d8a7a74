//! Turning back the triangles that a solve leaves turned over.
//!
//! The as-rigid-as-possible energy of a turned triangle is finite, and next to a handle that pulls hard it is even the
//! least: finer meshes fold there with any solver. Around such triangles the vertices are moved one after the other to
//! the least of the same energy plus `weight A max(0, SOUND - det J)^2`: the determinant is linear in one vertex, so
//! that each move is one small linear system, and what it lowers is bounded below.
//!
//! Known limits: what handles themselves turn over, with both ends of an edge held, stays.

use glam::{DMat2, DVec2, Vec2};

use super::elements::Elements;

/// Triangles smaller than this share of their rest area are pushed back.
const SOUND: f64 = 0.2;
/// Triangles above this share count as put right: well clear of what rounding to pixels in 32 bits can turn.
const CLEAR: f64 = 0.02;
/// How hard they are pushed at first. Weaker, some stay; from 100 on each vertex holds the next one fast.
const WEIGHT: f64 = 40.0;
/// How far around a turned triangle vertices may move, in edges.
const RINGS: usize = 2;
/// Rounds at most, and sweeps over the vertices in each.
const ROUNDS: usize = 60;
const SWEEPS: usize = 3;
/// After so many rounds the surroundings of handles that still pull something over follow them.
const PATIENCE: usize = 8;
/// What counts as a handle's neighbours, in edges.
const BESIDE: f32 = 2.0;
/// They follow within this many times the way: three edges for an edge turn nothing over.
const GENTLE: f32 = 3.0;
/// Sweeps over what followed, once nothing is turned.
const RELAXED: usize = 10;

/// Which triangles every vertex belongs to.
#[derive(Clone, Debug)]
pub(super) struct Stars {
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Stars {
    pub(super) fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0u32; vertices + 1];
        triangles.iter().flatten().for_each(|&v| starts[v as usize + 1] += 1);
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut filled = starts.clone();
        let mut all = vec![0; 3 * triangles.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            for &v in triangle {
                all[filled[v as usize] as usize] = t as u32;
                filled[v as usize] += 1;
            }
        }
        Self { starts, triangles: all }
    }

    fn of(&self, v: usize) -> &[u32] {
        &self.triangles[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
}

/// A bound mesh, as far as putting triangles right needs it.
pub(super) struct Mesh<'a> {
    pub(super) elements: &'a Elements,
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) stars: &'a Stars,
    pub(super) rest: &'a [Vec2],
    pub(super) held: &'a [bool],
    pub(super) orientation: f32,
}

impl Mesh<'_> {
    /// Puts right the turned triangles of the shape `u`. `grip` brings gripped places back to their targets.
    pub(super) fn unfold(&self, u: &mut [Vec2], grip: impl Fn(&mut [Vec2])) {
        let mut turned: Vec<usize> = (0..self.triangles.len()).filter(|&t| self.determinant(t, u) < CLEAR).collect();
        let mut weight = WEIGHT;
        let mut moved: Vec<usize> = Vec::new();
        for round in 1..=ROUNDS {
            if turned.is_empty() {
                break;
            }
            if round % PATIENCE == 0 {
                let mut pulled: Vec<u32> = self.near(&turned, 2);
                pulled.retain(|&v| self.held[v as usize]);
                pulled.iter().for_each(|&v| moved.extend(self.follow(v as usize, u)));
                weight = WEIGHT;
            }
            let mut around = self.near(&turned, RINGS);
            around.retain(|&v| !self.held[v as usize]);
            for _ in 0..SWEEPS {
                for &v in &around {
                    self.settle(v as usize, weight, u);
                }
                grip(u);
            }
            weight *= 1.1;
            // Others may have turned for those that are right now.
            turned = around.iter().flat_map(|&v| self.stars.of(v as usize)).map(|&t| t as usize).collect();
            turned.retain(|&t| self.determinant(t, u) < CLEAR);
            turned.sort_unstable();
            turned.dedup();
        }
        // What followed went further than it needs to: back, but over nothing.
        moved.sort_unstable();
        moved.dedup();
        for _ in 0..RELAXED {
            moved.iter().for_each(|&v| self.settle(v, WEIGHT, u));
            grip(u);
        }
    }

    /// Lets the surroundings follow the held vertex `v` a part of the way that it was pulled out of them. One vertex at a
    /// time they cannot: each is held back by the next. The way fades with the distance.
    /// Gives who moved.
    fn follow(&self, v: usize, u: &mut [Vec2]) -> Vec<usize> {
        let (mut middle, mut count) = (Vec2::ZERO, 0.0);
        for (w, d) in self.within(v, BESIDE).into_iter().filter(|(w, _)| *w != v) {
            middle += u[w] * (BESIDE - d);
            count += BESIDE - d;
        }
        if count == 0.0 {
            return Vec::new();
        }
        let lacking = u[v] - middle / count;
        let reach = (GENTLE * lacking.length()).max(2.0 * BESIDE);
        let mut around = self.within(v, reach);
        around.retain(|(w, _)| !self.held[*w]);
        for &(w, d) in &around {
            u[w] += lacking * (1.0 - d / reach);
        }
        around.into_iter().map(|(w, _)| w).collect()
    }

    /// The vertices that hang together with `v` within `reach` of it at rest, and how far they are.
    fn within(&self, v: usize, reach: f32) -> Vec<(usize, f32)> {
        let mut found = vec![(v, 0.0)];
        let mut seen = std::collections::HashSet::from([v]);
        let mut next = 0;
        while next < found.len() {
            for &w in self.stars.of(found[next].0).iter().flat_map(|&t| &self.triangles[t as usize]) {
                let d = self.rest[w as usize].distance(self.rest[v]);
                if d <= reach && seen.insert(w as usize) {
                    found.push((w as usize, d));
                }
            }
            next += 1;
        }
        found
    }

    /// Vertices at most `rings` edges from the triangles, rising.
    fn near(&self, triangles: &[usize], rings: usize) -> Vec<u32> {
        let mut near: Vec<u32> = triangles.iter().flat_map(|&t| self.triangles[t]).collect();
        for _ in 0..rings {
            near.sort_unstable();
            near.dedup();
            let around = near.iter().flat_map(|&v| self.stars.of(v as usize));
            near = around.flat_map(|&t| self.triangles[t as usize]).collect();
        }
        near.sort_unstable();
        near.dedup();
        near
    }

    /// The triangle's area over its area at rest.
    fn determinant(&self, t: usize, u: &[Vec2]) -> f64 {
        let [a, b, c] = self.triangles[t].map(|v| u[v as usize].as_dvec2());
        f64::from(self.orientation) * (b - a).perp_dot(c - a) / f64::from(self.elements.rest_of(t).0)
    }

    /// Moves one vertex to where its triangles cost least, with their rotations as they are.
    fn settle(&self, v: usize, weight: f64, u: &mut [Vec2]) {
        let (mut gradient, mut hessian, mut cost, mut least) = (DVec2::ZERO, DMat2::ZERO, 0.0, f64::INFINITY);
        for &t in self.stars.of(v) {
            let state = self.state(t as usize, u);
            let Some(k) = self.triangles[t as usize].iter().position(|&w| w as usize == v) else { continue };
            cost += state.cost(weight);
            least = least.min(state.determinant());
            let q = state.q[k];
            gradient += q.rotate(state.f - state.rotation) + DVec2::new(q.x, -q.y).rotate(state.g);
            hessian += DMat2::from_diagonal(DVec2::splat(2.0 * q.length_squared() / state.double_area));
            let missing = SOUND - state.determinant();
            if missing > 0.0 {
                let opposite = state.corners[(k + 1) % 3] - state.corners[(k + 2) % 3];
                let slope = f64::from(self.orientation) * DVec2::new(opposite.y, -opposite.x) / state.double_area;
                let push = 0.5 * weight * state.double_area;
                gradient -= push * missing * slope;
                hessian += push * DMat2::from_cols(slope * slope.x, slope * slope.y);
            }
        }
        if hessian.determinant() <= 0.0 {
            return;
        }
        let (from, mut step) = (u[v], hessian.inverse() * gradient);
        // A triangle that was sound may turn on the way: the step is cut until the sum goes down.
        for _ in 0..6 {
            u[v] = (from.as_dvec2() - step).as_vec2();
            let now = self.stars.of(v).iter().map(|&t| self.state(t as usize, u));
            let (now, low) =
                now.fold((0.0, f64::INFINITY), |(sum, low), s| (sum + s.cost(weight), s.determinant().min(low)));
            if now < cost && low >= least.min(CLEAR) {
                return;
            }
            step *= 0.4;
        }
        u[v] = from;
    }

    fn state(&self, t: usize, u: &[Vec2]) -> State {
        let corners = self.triangles[t].map(|v| u[v as usize].as_dvec2());
        let (double_area, q) = self.elements.rest_of(t);
        let (double_area, q) = (f64::from(double_area), q.map(Vec2::as_dvec2));
        let conformal: DVec2 = (0..3).map(|i| DVec2::new(q[i].dot(corners[i]), q[i].perp_dot(corners[i]))).sum();
        let anti: DVec2 = (0..3).map(|i| q[i].rotate(corners[i])).sum();
        let rotation = conformal.try_normalize().unwrap_or(DVec2::X);
        State { corners, double_area, q, f: conformal / double_area, g: anti / double_area, rotation }
    }
}

/// One triangle: its map as complex numbers, `J z = f z + g conj(z)`, and the rotation nearest to it.
struct State {
    corners: [DVec2; 3],
    double_area: f64,
    q: [DVec2; 3],
    f: DVec2,
    g: DVec2,
    rotation: DVec2,
}

impl State {
    fn determinant(&self) -> f64 {
        self.f.length_squared() - self.g.length_squared()
    }

    fn cost(&self, weight: f64) -> f64 {
        let missing = (SOUND - self.determinant()).max(0.0);
        let bent = (self.f - self.rotation).length_squared() + self.g.length_squared();
        self.double_area * (bent + 0.5 * weight * missing * missing)
    }
}
