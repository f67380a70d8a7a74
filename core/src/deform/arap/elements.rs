//! The energy of a mesh's triangles and its gradient, several triangles at once.
//!
//! Chao et al. 2010, "A Simple Geometric Model for Elastic Deformations", in the plane: `E = sum A |J - R|^2` over
//! triangles of rest area A, with J the linear map of a triangle and R the rotation nearest to it. As complex numbers
//! a map is `J z = f z + g conj(z)`, the nearest rotation is `f / |f|` and the determinant `|f|^2 - |g|^2`, so that no
//! decomposition is needed. With `q` a corner's opposite rest edge, halved and turned by 90 degrees,
//! `2A f = sum conj(q) z` and `2A g = sum q z` over the corners.

use glam::Vec2;

/// Triangles that are worked on together: two registers of four.
const LANES: usize = 8;
type Lanes = [f32; LANES];

/// Eight triangles. Those that fill up the last group have no extent and pull at nothing.
#[derive(Clone, Debug)]
struct Group {
    corners: [[u32; LANES]; 3],
    /// `q` of the second and third corner; that of the first is minus their sum.
    q1: [Lanes; 2],
    q2: [Lanes; 2],
    /// Twice the rest area.
    double_area: Lanes,
}

/// The triangles of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Elements {
    groups: Vec<Group>,
}

/// What a shape costs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Measure {
    /// The energy, in squared pixels.
    pub(super) energy: f64,
    /// Triangles that are turned over or have no area.
    pub(super) flipped: usize,
}

/// What a group of triangles does to its corners.
struct Pull {
    /// On the second and third corner; the first bears the opposite of both.
    p1: [Lanes; 2],
    p2: [Lanes; 2],
}

impl Elements {
    /// The triangles, with vertices at `points`; `orientation` is 1 where they turn from x to y, else -1.
    pub(super) fn new(points: &[Vec2], triangles: &[[u32; 3]], orientation: f32) -> Self {
        let groups = triangles.chunks(LANES).map(|chunk| {
            let zero = [0.0; LANES];
            let mut group =
                Group { corners: [[chunk[0][0]; LANES]; 3], q1: [zero; 2], q2: [zero; 2], double_area: zero };
            for (l, triangle) in chunk.iter().enumerate() {
                let [a, b, c] = triangle.map(|v| points[v as usize]);
                let half = |edge: Vec2| 0.5 * orientation * edge.perp();
                let (q1, q2) = (half(a - c), half(b - a));
                for (slot, v) in group.corners.iter_mut().zip(triangle) {
                    slot[l] = *v;
                }
                (group.q1[0][l], group.q1[1][l]) = (q1.x, q1.y);
                (group.q2[0][l], group.q2[1][l]) = (q2.x, q2.y);
                group.double_area[l] = orientation * (b - a).perp_dot(c - a);
            }
            group
        });
        Self { groups: groups.collect() }
    }

    /// Twice the rest area of triangle `t`, and `q` of its corners.
    pub(super) fn rest_of(&self, t: usize) -> (f32, [Vec2; 3]) {
        let (group, l) = (&self.groups[t / LANES], t % LANES);
        let q1 = Vec2::new(group.q1[0][l], group.q1[1][l]);
        let q2 = Vec2::new(group.q2[0][l], group.q2[1][l]);
        (group.double_area[l], [-q1 - q2, q1, q2])
    }

    /// The turn of each triangle with the shape `u`, not normalised: `2A f`.
    pub(super) fn turns(&self, u: &[Vec2], turns: &mut [Vec2]) {
        for (g, group) in self.groups.iter().enumerate() {
            let (d1, d2) = group.edges(u);
            let (sx, sy) = group.conformal(&d1, &d2);
            for (l, turn) in turns[g * LANES..(g + 1) * LANES].iter_mut().enumerate() {
                *turn = Vec2::new(sx[l], sy[l]);
            }
        }
    }

    /// Room for one value a triangle, filled up to whole groups.
    pub(super) fn room(&self) -> Vec<Vec2> {
        vec![Vec2::ZERO; self.groups.len() * LANES]
    }

    /// Adds to `sum` what triangles turned by `turns`, of any length, pull at their corners: `sum q r / |r|`.
    pub(super) fn pulls(&self, turns: &[Vec2], sum: &mut [Vec2]) {
        for (g, group) in self.groups.iter().enumerate() {
            let (mut rx, mut ry) = ([0.0; LANES], [0.0; LANES]);
            for (l, turn) in turns[g * LANES..(g + 1) * LANES].iter().enumerate() {
                (rx[l], ry[l]) = (turn.x, turn.y);
            }
            normalise(&mut rx, &mut ry);
            let mut pull = Pull { p1: [[0.0; LANES]; 2], p2: [[0.0; LANES]; 2] };
            for l in 0..LANES {
                pull.p1[0][l] = group.q1[0][l] * rx[l] - group.q1[1][l] * ry[l];
                pull.p1[1][l] = group.q1[0][l] * ry[l] + group.q1[1][l] * rx[l];
                pull.p2[0][l] = group.q2[0][l] * rx[l] - group.q2[1][l] * ry[l];
                pull.p2[1][l] = group.q2[0][l] * ry[l] + group.q2[1][l] * rx[l];
            }
            group.scatter(&pull, sum);
        }
    }

    /// Half the energy's gradient at `u`, into `gradient`, and the energy.
    pub(super) fn gradient(&self, u: &[Vec2], gradient: &mut [Vec2]) -> Measure {
        gradient.fill(Vec2::ZERO);
        let mut energy = 0.0;
        let mut flipped = 0;
        for group in &self.groups {
            let (d1, d2) = group.edges(u);
            let (sx, sy) = group.conformal(&d1, &d2);
            let (mut rx, mut ry) = (sx, sy);
            normalise(&mut rx, &mut ry);
            let mut pull = Pull { p1: [[0.0; LANES]; 2], p2: [[0.0; LANES]; 2] };
            let (mut cost, mut down) = ([0f32; LANES], [0f32; LANES]);
            let ([q1x, q1y], [q2x, q2y]) = (&group.q1, &group.q2);
            for l in 0..LANES {
                let inverse = 1.0 / group.double_area[l].max(f32::MIN_POSITIVE);
                let tx = q1x[l] * d1[0][l] - q1y[l] * d1[1][l] + q2x[l] * d2[0][l] - q2y[l] * d2[1][l];
                let ty = q1x[l] * d1[1][l] + q1y[l] * d1[0][l] + q2x[l] * d2[1][l] + q2y[l] * d2[0][l];
                let (fx, fy) = (sx[l] * inverse, sy[l] * inverse);
                let (gx, gy) = (tx * inverse, ty * inverse);
                let (ax, ay) = (fx - rx[l], fy - ry[l]);
                // a q + g conj(q)
                pull.p1[0][l] = (ax + gx) * q1x[l] - (ay - gy) * q1y[l];
                pull.p1[1][l] = (ax - gx) * q1y[l] + (ay + gy) * q1x[l];
                pull.p2[0][l] = (ax + gx) * q2x[l] - (ay - gy) * q2y[l];
                pull.p2[1][l] = (ax - gx) * q2y[l] + (ay + gy) * q2x[l];
                cost[l] = group.double_area[l] * (ax * ax + ay * ay + gx * gx + gy * gy);
                down[l] = (gx * gx + gy * gy) - (fx * fx + fy * fy);
            }
            energy += f64::from(cost.iter().sum::<f32>());
            flipped += (0..LANES).filter(|&l| down[l] >= 0.0 && group.double_area[l] > 0.0).count();
            group.scatter(&pull, gradient);
        }
        Measure { energy, flipped }
    }
}

impl Group {
    /// The second and third corner as seen from the first.
    #[inline(always)]
    fn edges(&self, u: &[Vec2]) -> ([Lanes; 2], [Lanes; 2]) {
        let (mut d1, mut d2) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        for l in 0..LANES {
            let (a, b, c) = (self.corners[0][l] as usize, self.corners[1][l] as usize, self.corners[2][l] as usize);
            let (to_b, to_c) = (u[b] - u[a], u[c] - u[a]);
            (d1[0][l], d1[1][l]) = (to_b.x, to_b.y);
            (d2[0][l], d2[1][l]) = (to_c.x, to_c.y);
        }
        (d1, d2)
    }

    /// `2A f`.
    #[inline(always)]
    fn conformal(&self, d1: &[Lanes; 2], d2: &[Lanes; 2]) -> (Lanes, Lanes) {
        let (mut sx, mut sy) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let (q1x, q1y, q2x, q2y) = (self.q1[0][l], self.q1[1][l], self.q2[0][l], self.q2[1][l]);
            sx[l] = q1x * d1[0][l] + q1y * d1[1][l] + q2x * d2[0][l] + q2y * d2[1][l];
            sy[l] = q1x * d1[1][l] - q1y * d1[0][l] + q2x * d2[1][l] - q2y * d2[0][l];
        }
        (sx, sy)
    }

    #[inline(always)]
    fn scatter(&self, pull: &Pull, sum: &mut [Vec2]) {
        for l in 0..LANES {
            let (a, b, c) = (self.corners[0][l] as usize, self.corners[1][l] as usize, self.corners[2][l] as usize);
            let (p1, p2) = (Vec2::new(pull.p1[0][l], pull.p1[1][l]), Vec2::new(pull.p2[0][l], pull.p2[1][l]));
            sum[a] -= p1 + p2;
            sum[b] += p1;
            sum[c] += p2;
        }
    }
}

/// Makes unit vectors; those without length point along x.
#[inline(always)]
fn normalise(x: &mut Lanes, y: &mut Lanes) {
    for l in 0..LANES {
        let square = x[l] * x[l] + y[l] * y[l];
        let inverse = 1.0 / square.max(f32::MIN_POSITIVE).sqrt();
        x[l] = if square > 0.0 { x[l] * inverse } else { 1.0 };
        y[l] *= inverse;
    }
}
