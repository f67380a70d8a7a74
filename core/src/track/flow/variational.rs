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

/// One linear equation in the increment, `w (c + x du + y dv)^2`, per data term.
#[derive(Clone, Copy, Default)]
struct Term {
    c: f32,
    x: f32,
    y: f32,
    norm: f32,
}

/// Moves `flow` toward the energy's minimum near it.
pub(super) fn refine(a: &Level, b: &Level, flow: &mut Grid<Vec2>) {
    let (w, h) = (a.width, a.height);
    let terms = linearise(a, b, flow);
    let mut step = Grid::new(w, h, Vec2::ZERO);
    let mut right = Grid::new(w, h, 0.0f32);
    let mut down = Grid::new(w, h, 0.0f32);
    // The 2x2 system of a pixel: xx, xy, yy, and the right-hand side.
    let mut system = vec![[0.0f32; 5]; w * h];
    for _ in 0..ROUNDS {
        smoothness(flow, &step, &mut right, &mut down);
        for ((out, t), d) in system.iter_mut().zip(&terms).zip(step.data()) {
            *out = normal_equation(t, *d);
        }
        for _ in 0..SWEEPS {
            relax(flow, &mut step, &right, &down, &system);
        }
    }
    for (f, s) in flow.data_mut().iter_mut().zip(step.data()) {
        // A step beyond the linearisation's reach is no information.
        *f += s.clamp_length_max(2.0);
    }
}

/// Brightness and gradient constancy around the current warp.
fn linearise(a: &Level, b: &Level, flow: &Grid<Vec2>) -> Vec<[Term; 3]> {
    let (w, h) = (a.width, a.height);
    let warped: Vec<Grid<f32>> = [&b.image, &b.dx, &b.dy].into_iter().map(|channel| warp(channel, flow)).collect();
    let mut terms = Vec::with_capacity(w * h);
    for y in 0..h {
        for x in 0..w {
            let (px, py) = (x + PAD, y + PAD);
            let (bx, by) = (warped[1].get(x, y), warped[2].get(x, y));
            let (gx, gy) = (0.5 * (a.dx.get(px, py) + bx), 0.5 * (a.dy.get(px, py) + by));
            let (l, r) = (x.saturating_sub(1), (x + 1).min(w - 1));
            let (u, d) = (y.saturating_sub(1), (y + 1).min(h - 1));
            let xx = 0.5 * (warped[1].get(r, y) - warped[1].get(l, y));
            let xy = 0.5 * (warped[1].get(x, d) - warped[1].get(x, u));
            let yy = 0.5 * (warped[2].get(x, d) - warped[2].get(x, u));
            let term = |c: f32, gx: f32, gy: f32, weight: f32| {
                let norm = weight / (gx * gx + gy * gy + FLAT);
                Term { c, x: gx, y: gy, norm }
            };
            terms.push([
                term(warped[0].get(x, y) - a.image.get(px, py), gx, gy, DELTA),
                term(bx - a.dx.get(px, py), xx, xy, GAMMA),
                term(by - a.dy.get(px, py), xy, yy, GAMMA),
            ]);
        }
    }
    terms
}

fn warp(padded: &Grid<f32>, flow: &Grid<Vec2>) -> Grid<f32> {
    let (w, h) = (flow.width(), flow.height());
    let mut out = Grid::new(w, h, 0.0);
    let (limit_x, limit_y) = ((padded.width() - 2) as f32, (padded.height() - 2) as f32);
    for y in 0..h {
        let flows = flow.row(y);
        for (x, o) in out.row_mut(y).iter_mut().enumerate() {
            let u = ((x + PAD) as f32 + flows[x].x).clamp(0.0, limit_x);
            let v = ((y + PAD) as f32 + flows[x].y).clamp(0.0, limit_y);
            let (x0, y0) = (u as usize, v as usize);
            let (fx, fy) = (u - x0 as f32, v - y0 as f32);
            let (top, bottom) = (padded.row(y0), padded.row(y0 + 1));
            let upper = top[x0] + fx * (top[x0 + 1] - top[x0]);
            let lower = bottom[x0] + fx * (bottom[x0 + 1] - bottom[x0]);
            *o = upper + fy * (lower - upper);
        }
    }
    out
}

/// Diffusivities between neighbours: right and down.
fn smoothness(flow: &Grid<Vec2>, step: &Grid<Vec2>, right: &mut Grid<f32>, down: &mut Grid<f32>) {
    let (w, h) = (flow.width(), flow.height());
    let sum = |x: usize, y: usize| flow.get(x, y) + step.get(x, y);
    for y in 0..h {
        for x in 0..w {
            let here = sum(x, y);
            let strength = |to: Vec2| ALPHA / ((to - here).length_squared() + EPSILON).sqrt();
            right.set(x, y, if x + 1 < w { strength(sum(x + 1, y)) } else { 0.0 });
            down.set(x, y, if y + 1 < h { strength(sum(x, y + 1)) } else { 0.0 });
        }
    }
}

#[inline]
fn normal_equation(terms: &[Term; 3], d: Vec2) -> [f32; 5] {
    let mut out = [0.0; 5];
    for t in terms {
        let error = t.c + t.x * d.x + t.y * d.y;
        let weight = t.norm / (t.norm * error * error + EPSILON).sqrt();
        out[0] += weight * t.x * t.x;
        out[1] += weight * t.x * t.y;
        out[2] += weight * t.y * t.y;
        out[3] -= weight * t.x * t.c;
        out[4] -= weight * t.y * t.c;
    }
    out
}

/// Rows that are swept at once, each a pixel behind the one above: every pixel then meets what it would row by row, and
/// waits only for the pixel before it, while the other rows go on.
const ROWS: usize = 4;

/// One sweep over all pixels, each solved with its neighbours fixed.
fn relax(flow: &Grid<Vec2>, step: &mut Grid<Vec2>, right: &Grid<f32>, down: &Grid<f32>, system: &[[f32; 5]]) {
    let (w, h) = (flow.width(), flow.height());
    for first in (0..h).step_by(ROWS) {
        let rows = ROWS.min(h - first);
        for (x, y) in (0..w + rows - 1).flat_map(|t| (0..rows).map(move |row| (t.wrapping_sub(row), first + row))) {
            if x >= w {
                continue;
            }
            let here = flow.get(x, y);
            let (mut weight, mut pull) = (0.0, Vec2::ZERO);
            let mut link = |strength: f32, nx: usize, ny: usize| {
                weight += strength;
                pull += strength * (flow.get(nx, ny) + step.get(nx, ny) - here);
            };
            if x > 0 {
                link(right.get(x - 1, y), x - 1, y);
            }
            if x + 1 < w {
                link(right.get(x, y), x + 1, y);
            }
            if y > 0 {
                link(down.get(x, y - 1), x, y - 1);
            }
            if y + 1 < h {
                link(down.get(x, y), x, y + 1);
            }
            let [xx, xy, yy, rx, ry] = system[y * w + x];
            let (xx, yy) = (xx + weight, yy + weight);
            let old = step.get(x, y);
            let (rx, ry) = (rx + pull.x, ry + pull.y);
            let determinant = xx * yy - xy * xy;
            if determinant > 1e-12 {
                let solved = Vec2::new(yy * rx - xy * ry, xx * ry - xy * rx) / determinant;
                step.set(x, y, old + RELAXATION * (solved - old));
            }
        }
    }
}
