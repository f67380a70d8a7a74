//! Variational refinement of a flow: robust constancy of brightness and gradient, robust smoothness, solved by
//! successive over-relaxation around the current warp.
//!
//! Brox, Bruhn, Papenberg, Weickert 2004, "High accuracy optical flow estimation based on a theory for warping", with
//! the normalised data terms that Kroeger 2016 (section 2.3) uses.

use glam::Vec2;

use super::pyramid::{Level, PAD};
use crate::raster::Grid;

/// Weight of smoothness (α), brightness (δ) and gradient (γ) constancy.
const ALPHA: f32 = 10.0;
const DELTA: f32 = 5.0;
const GAMMA: f32 = 10.0;
/// Re-weightings, and sweeps in each.
const ROUNDS: usize = 2;
const SWEEPS: usize = 4;
const RELAXATION: f32 = 1.6;
/// Square of the robust penalty's linear onset.
const EPSILON: f32 = 1e-3;
/// Gradients (in brightness levels) below this do not blow up their normalised terms.
const FLAT: f32 = 0.1;
/// Pixels that are worked on at once; rows are padded to whole blocks of them.
const LANES: usize = 8;

type Lanes = [f32; LANES];

/// One linear equation a pixel in the increment, `w (c + x du + y dv)^2`.
#[derive(Clone, Copy, Default)]
struct Term {
    c: Lanes,
    x: Lanes,
    y: Lanes,
    norm: Lanes,
}

/// What a pixel's flow is moved to with its neighbours fixed, all of it times the relaxation: `base + inverse * (sum of
/// link * neighbour)`.
#[derive(Clone, Copy, Default)]
struct Pull {
    /// How strongly it hangs on its neighbours on the right, above and below.
    links: [Lanes; 3],
    base: [Lanes; 2],
    /// Of the 2x2 system: xx, xy, yy.
    inverse: [Lanes; 3],
    /// The same times the link with the neighbour on the left.
    left: [Lanes; 3],
}

/// A plane with a border of one pixel around it, its rows padded to whole blocks.
struct Bordered {
    stride: usize,
    values: Vec<f32>,
}

impl Bordered {
    fn new(width: usize, height: usize) -> Self {
        let stride = width.next_multiple_of(LANES) + 2;
        Self { stride, values: vec![0.0; stride * (height + 2)] }
    }

    /// Where column 0 of row `y` is.
    fn start(&self, y: usize) -> usize {
        (y + 1) * self.stride + 1
    }

    #[inline]
    fn row_mut(&mut self, y: usize, width: usize) -> &mut [f32] {
        let start = self.start(y);
        &mut self.values[start..start + width]
    }
}

#[inline]
fn lanes(values: &[f32], start: usize) -> &Lanes {
    values[start..].first_chunk().unwrap_or(&[0.0; LANES])
}

/// Moves `flow` toward the energy's minimum near it.
pub(super) fn refine(a: &Level, b: &Level, flow: &mut Grid<Vec2>) {
    let (w, h) = (a.width, a.height);
    let terms = linearise(a, b, flow);
    let mut at = [Bordered::new(w, h), Bordered::new(w, h)];
    for y in 0..h {
        for (x, f) in flow.row(y).iter().enumerate() {
            let i = at[0].start(y) + x;
            (at[0].values[i], at[1].values[i]) = (f.x, f.y);
        }
    }
    let first = [at[0].values.clone(), at[1].values.clone()];
    // Link `x` of a row is with the pixel before `x`; row `y` of links is with the row before `y`.
    let (mut beside, mut above) = (Bordered::new(w, h), Bordered::new(w, h));
    let mut moved = vec![[0.0f32; 2]; w.next_multiple_of(LANES)];
    let mut pulls = vec![Pull::default(); terms.len() / 3];
    for _ in 0..ROUNDS {
        link(&at, &mut beside, &mut above, w, h);
        let blocks = w.div_ceil(LANES);
        for (i, (pull, terms)) in pulls.iter_mut().zip(terms.chunks_exact(3)).enumerate() {
            let start = at[0].start(i / blocks) + i % blocks * LANES;
            let links = [
                lanes(&beside.values, start),
                lanes(&beside.values, start + 1),
                lanes(&above.values, start),
                lanes(&above.values, start + above.stride),
            ];
            let now = [0, 1].map(|c| lanes(&at[c].values, start));
            *pull = Pull::new(terms, links.map(|l| *l), now, [0, 1].map(|c| lanes(&first[c], start)));
        }
        for _ in 0..SWEEPS {
            relax(&mut at, &pulls, blocks, &mut moved);
        }
    }
    for y in 0..h {
        let start = at[0].start(y);
        for (x, f) in flow.row_mut(y).iter_mut().enumerate() {
            // A step beyond the linearisation's reach is no information.
            *f += (Vec2::new(at[0].values[start + x], at[1].values[start + x]) - *f).clamp_length_max(2.0);
        }
    }
}

/// Brightness and gradient constancy around the current warp, three terms for every block of a row.
fn linearise(a: &Level, b: &Level, flow: &Grid<Vec2>) -> Vec<Term> {
    let (w, h) = (a.width, a.height);
    let [image, dx, dy] = warp(b, flow);
    let mut terms = Vec::with_capacity(3 * h * w.div_ceil(LANES));
    for y in 0..h {
        let (up, down) = (dx.start(y.saturating_sub(1)), dx.start((y + 1).min(h - 1)));
        let source = (y + PAD) * a.image.width() + PAD;
        for x in (0..w).step_by(LANES) {
            let start = dx.start(y) + x;
            let of = |plane: &Grid<f32>| *lanes(plane.data(), source + x);
            let (a_image, a_dx, a_dy) = (of(&a.image), of(&a.dx), of(&a.dy));
            let (b_image, b_dx, b_dy) = (lanes(&image.values, start), lanes(&dx.values, start), lanes(&dy.values, start));
            let half = |plane: &Bordered, after: usize, before: usize| -> Lanes {
                let (after, before) = (lanes(&plane.values, after), lanes(&plane.values, before));
                std::array::from_fn(|i| 0.5 * (after[i] - before[i]))
            };
            let (xx, xy, yy) = (half(&dx, start + 1, start - 1), half(&dx, down + x, up + x), half(&dy, down + x, up + x));
            let between = |a: &Lanes, b: &Lanes| -> Lanes { std::array::from_fn(|i| 0.5 * (a[i] + b[i])) };
            let (gx, gy) = (between(&a_dx, b_dx), between(&a_dy, b_dy));
            let term = |a: &Lanes, b: &Lanes, x: Lanes, y: Lanes, weight: f32| Term {
                c: std::array::from_fn(|i| b[i] - a[i]),
                norm: std::array::from_fn(|i| weight / (x[i] * x[i] + y[i] * y[i] + FLAT)),
                x,
                y,
            };
            terms.push(term(&a_image, b_image, gx, gy, DELTA));
            terms.push(term(&a_dx, b_dx, xx, xy, GAMMA));
            terms.push(term(&a_dy, b_dy, xy, yy, GAMMA));
        }
    }
    terms
}

/// A level's brightness and differences where `flow` leads; the border repeats what is beside it.
fn warp(level: &Level, flow: &Grid<Vec2>) -> [Bordered; 3] {
    let (w, h) = (flow.width(), flow.height());
    let mut out = [0; 3].map(|_| Bordered::new(w, h));
    let width = level.image.width();
    let (limit_x, limit_y) = ((width - 2) as f32, (level.image.height() - 2) as f32);
    let channels = [level.image.data(), level.dx.data(), level.dy.data()];
    for y in 0..h {
        let start = out[0].start(y);
        for (x, f) in flow.row(y).iter().enumerate() {
            let u = ((x + PAD) as f32 + f.x).clamp(0.0, limit_x);
            let v = ((y + PAD) as f32 + f.y).clamp(0.0, limit_y);
            let (x0, y0) = (u as usize, v as usize);
            let (fx, fy) = (u - x0 as f32, v - y0 as f32);
            let i = y0 * width + x0;
            for (channel, out) in channels.iter().zip(&mut out) {
                let (top, bottom) = (&channel[i..i + 2], &channel[i + width..i + width + 2]);
                let upper = top[0] + fx * (top[1] - top[0]);
                let lower = bottom[0] + fx * (bottom[1] - bottom[0]);
                out.values[start + x] = upper + fy * (lower - upper);
            }
        }
        for out in &mut out {
            out.values[start - 1] = out.values[start];
            out.values[start + w] = out.values[start + w - 1];
        }
    }
    out
}

/// Diffusivities between neighbours.
fn link(at: &[Bordered; 2], beside: &mut Bordered, above: &mut Bordered, w: usize, h: usize) {
    let [u, v] = [&at[0].values, &at[1].values];
    let strength = |out: &mut [f32], here: usize, before: usize| {
        let n = out.len();
        let (u0, v0, u1, v1) = (&u[before..][..n], &v[before..][..n], &u[here..][..n], &v[here..][..n]);
        for i in 0..n {
            let (du, dv) = (u1[i] - u0[i], v1[i] - v0[i]);
            out[i] = ALPHA / (du * du + dv * dv + EPSILON).sqrt();
        }
    };
    for y in 0..h {
        let start = at[0].start(y);
        strength(&mut beside.row_mut(y, w)[1..], start + 1, start);
        if y > 0 {
            strength(above.row_mut(y, w), start, start - at[0].stride);
        }
    }
}

impl Pull {
    /// From what is known of the increment since `first` when the flow is `now`.
    #[inline]
    fn new(terms: &[Term], links: [Lanes; 4], now: [&Lanes; 2], first: [&Lanes; 2]) -> Self {
        let [left, right, above, below] = links;
        let mut out = Self { links: [right, above, below], ..Self::default() };
        for i in 0..LANES {
            let weight = left[i] + right[i] + above[i] + below[i];
            let (du, dv) = (now[0][i] - first[0][i], now[1][i] - first[1][i]);
            let (mut xx, mut xy, mut yy) = (weight, 0.0, weight);
            let (mut rx, mut ry) = (-weight * first[0][i], -weight * first[1][i]);
            for t in terms {
                let error = t.c[i] + t.x[i] * du + t.y[i] * dv;
                let weight = t.norm[i] / (t.norm[i] * error * error + EPSILON).sqrt();
                xx += weight * t.x[i] * t.x[i];
                xy += weight * t.x[i] * t.y[i];
                yy += weight * t.y[i] * t.y[i];
                rx -= weight * t.x[i] * t.c[i];
                ry -= weight * t.y[i] * t.c[i];
            }
            let determinant = xx * yy - xy * xy;
            // A pixel without a neighbour on a flat picture stays.
            let one = if determinant > 1e-12 { RELAXATION / determinant } else { 0.0 };
            for (k, part) in [yy * one, -xy * one, xx * one].into_iter().enumerate() {
                out.inverse[k][i] = part;
                out.left[k][i] = part * left[i];
            }
            out.base[0][i] = RELAXATION * first[0][i] + one * (yy * rx - xy * ry);
            out.base[1][i] = RELAXATION * first[1][i] + one * (xx * ry - xy * rx);
        }
        out
    }
}

/// One sweep over all pixels, each solved with its neighbours fixed: for a row first all that does not hang on the pixel
/// before, several pixels at once, then that.
fn relax(at: &mut [Bordered; 2], pulls: &[Pull], blocks: usize, moved: &mut [[f32; 2]]) {
    let [u, v] = at;
    let stride = u.stride;
    for (y, pulls) in pulls.chunks_exact(blocks).enumerate() {
        let row = u.start(y);
        for (x, (p, moved)) in pulls.iter().zip(moved.as_chunks_mut::<LANES>().0).enumerate() {
            let start = row + x * LANES;
            let pulled = |plane: &Bordered| -> Lanes {
                let from = |i: usize| lanes(&plane.values, i);
                let (right, above, below) = (from(start + 1), from(start - stride), from(start + stride));
                std::array::from_fn(|i| p.links[0][i] * right[i] + p.links[1][i] * above[i] + p.links[2][i] * below[i])
            };
            let (pu, pv) = (pulled(u), pulled(v));
            let (old_u, old_v) = (lanes(&u.values, start), lanes(&v.values, start));
            for i in 0..LANES {
                let [xx, xy, yy] = [0, 1, 2].map(|k| p.inverse[k][i]);
                moved[i] = [
                    p.base[0][i] + xx * pu[i] + xy * pv[i] + (1.0 - RELAXATION) * old_u[i],
                    p.base[1][i] + xy * pu[i] + yy * pv[i] + (1.0 - RELAXATION) * old_v[i],
                ];
            }
        }
        let (mut left_u, mut left_v) = (0.0, 0.0);
        for (x, (p, moved)) in pulls.iter().zip(moved.as_chunks::<LANES>().0).enumerate() {
            let start = row + x * LANES;
            for i in 0..LANES {
                let [xx, xy, yy] = [0, 1, 2].map(|k| p.left[k][i]);
                let next_u = moved[i][0] + (xx * left_u + xy * left_v);
                let next_v = moved[i][1] + (xy * left_u + yy * left_v);
                (left_u, left_v) = (next_u, next_v);
                (u.values[start + i], v.values[start + i]) = (next_u, next_v);
            }
        }
    }
}
