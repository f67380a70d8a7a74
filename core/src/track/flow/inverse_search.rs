//! Patch matching by inverse compositional gradient descent, and the dense field its patches vote for.
//!
//! Kroeger 2016, sections 2.1 and 2.2: every patch starts from the coarser level's flow or a neighbour's result,
//! whichever fits better, descends on the mean-free squared difference with the first picture's gradients, and the
//! dense flow is the mean over covering patches weighted by how well each explains the pixel.

use glam::Vec2;

use super::pyramid::{Level, PAD};
use crate::raster::Grid;

/// Side of a patch in pixels of its level (paper: 8).
const PATCH: usize = 8;
/// Distance between patches.
const STRIDE: usize = 4;
/// Steps of descent (paper: 12).
const STEPS: usize = 12;
const AREA: f32 = (PATCH * PATCH) as f32;

/// What the descent needs of one patch of the first picture.
struct Patch {
    /// Left and top in padded pixels.
    x: usize,
    y: usize,
    pixels: [f32; PATCH * PATCH],
    dx: [f32; PATCH * PATCH],
    dy: [f32; PATCH * PATCH],
    /// Inverse of the mean-free 2x2 normal matrix: xx, xy, yy; zero on flat patches.
    inverse: [f32; 3],
}

/// The dense flow from `a` to `b`, in pixels of this level, started at `start`.
pub(super) fn search(a: &Level, b: &Level, start: &Grid<Vec2>) -> Grid<Vec2> {
    let places = |size: usize| -> Vec<usize> {
        let last = size.saturating_sub(PATCH);
        (0..last).step_by(STRIDE).chain([last]).collect()
    };
    let (xs, ys) = (places(a.width), places(a.height));
    let columns = xs.len();
    let patches: Vec<Patch> =
        ys.iter().flat_map(|&y| xs.iter().map(move |&x| (x, y))).map(|(x, y)| cut(a, x, y)).collect();
    let mut flow: Vec<Vec2> = patches
        .iter()
        .map(|p| {
            let half = PATCH / 2;
            let (x, y) = ((p.x - PAD + half).min(a.width - 1), (p.y - PAD + half).min(a.height - 1));
            start.get(x, y)
        })
        .collect();
    let mut cost: Vec<f32> = patches.iter().zip(&flow).map(|(p, &f)| residual(p, b, f).1).collect();
    // Two passes: down from the top left, and back up, each passing on what its neighbours found.
    for back in [false, true] {
        for step in 0..patches.len() {
            let i = if back { patches.len() - 1 - step } else { step };
            let (column, row) = (i % columns, i / columns);
            let beside =
                if back { (column + 1 < columns).then_some(i + 1) } else { column.checked_sub(1).map(|_| i - 1) };
            let above = if back {
                (row + 1 < ys.len()).then_some(i + columns)
            } else {
                row.checked_sub(1).map(|_| i - columns)
            };
            let mut moved = !back;
            for neighbour in beside.into_iter().chain(above) {
                let c = residual(&patches[i], b, flow[neighbour]).1;
                if c < cost[i] {
                    (flow[i], cost[i]) = (flow[neighbour], c);
                    moved = true;
                }
            }
            if moved {
                (flow[i], cost[i]) = descend(&patches[i], b, flow[i], cost[i]);
            }
        }
    }
    densify(a, b, &patches, &flow)
}

fn cut(a: &Level, x: usize, y: usize) -> Patch {
    let (x, y) = (x + PAD, y + PAD);
    let mut patch = Patch {
        x,
        y,
        pixels: [0.0; PATCH * PATCH],
        dx: [0.0; PATCH * PATCH],
        dy: [0.0; PATCH * PATCH],
        inverse: [0.0; 3],
    };
    for row in 0..PATCH {
        let to = row * PATCH..(row + 1) * PATCH;
        patch.pixels[to.clone()].copy_from_slice(&a.image.row(y + row)[x..x + PATCH]);
        patch.dx[to.clone()].copy_from_slice(&a.dx.row(y + row)[x..x + PATCH]);
        patch.dy[to].copy_from_slice(&a.dy.row(y + row)[x..x + PATCH]);
    }
    let centre = |values: &mut [f32; PATCH * PATCH]| {
        let mean = values.iter().sum::<f32>() / AREA;
        values.iter_mut().for_each(|v| *v -= mean);
    };
    centre(&mut patch.pixels);
    centre(&mut patch.dx);
    centre(&mut patch.dy);
    let dot = |p: &[f32], q: &[f32]| p.iter().zip(q).map(|(a, b)| a * b).sum::<f32>();
    let (xx, xy, yy) = (dot(&patch.dx, &patch.dx), dot(&patch.dx, &patch.dy), dot(&patch.dy, &patch.dy));
    // Damped, so that a patch with one edge moves only across it.
    let damp = 0.01 * (xx + yy) + 1.0;
    let (xx, yy) = (xx + damp, yy + damp);
    let determinant = xx * yy - xy * xy;
    if determinant > 1e-6 {
        patch.inverse = [yy / determinant, -xy / determinant, xx / determinant];
    }
    patch
}

/// The mean-free difference of `b` moved by `flow` and the patch, and its squared sum.
#[inline]
fn residual(patch: &Patch, b: &Level, flow: Vec2) -> ([f32; PATCH * PATCH], f32) {
    let limit = |v: f32, size: usize| v.clamp(0.0, (size - PATCH - 2) as f32);
    let x = limit(patch.x as f32 + flow.x, b.image.width());
    let y = limit(patch.y as f32 + flow.y, b.image.height());
    let (x0, y0) = (x as usize, y as usize);
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    let (w00, w10, w01, w11) = ((1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy);
    let mut out = [0.0; PATCH * PATCH];
    for row in 0..PATCH {
        let top = &b.image.row(y0 + row)[x0..x0 + PATCH + 1];
        let bottom = &b.image.row(y0 + row + 1)[x0..x0 + PATCH + 1];
        let line = &mut out[row * PATCH..(row + 1) * PATCH];
        for i in 0..PATCH {
            line[i] = w00 * top[i] + w10 * top[i + 1] + w01 * bottom[i] + w11 * bottom[i + 1];
        }
    }
    let mean = out.iter().sum::<f32>() / AREA;
    let mut sum = 0.0;
    for (o, p) in out.iter_mut().zip(&patch.pixels) {
        *o -= mean + p;
        sum += *o * *o;
    }
    (out, sum)
}

fn descend(patch: &Patch, b: &Level, start: Vec2, start_cost: f32) -> (Vec2, f32) {
    let (mut flow, mut best, mut best_cost) = (start, start, start_cost);
    for _ in 0..STEPS {
        let (difference, cost) = residual(patch, b, flow);
        if cost < best_cost {
            (best, best_cost) = (flow, cost);
        } else if cost > 1.2 * best_cost {
            break;
        }
        let (mut gx, mut gy) = (0.0, 0.0);
        for i in 0..PATCH * PATCH {
            gx += patch.dx[i] * difference[i];
            gy += patch.dy[i] * difference[i];
        }
        let [xx, xy, yy] = patch.inverse;
        let step = Vec2::new(xx * gx + xy * gy, xy * gx + yy * gy);
        flow -= step;
        if step.length_squared() < 4e-4 || (flow - start).length_squared() > AREA {
            break;
        }
    }
    let cost = residual(patch, b, flow).1;
    if cost < best_cost && (flow - start).length_squared() <= AREA { (flow, cost) } else { (best, best_cost) }
}

fn densify(a: &Level, b: &Level, patches: &[Patch], flow: &[Vec2]) -> Grid<Vec2> {
    let mut sum = Grid::new(a.width, a.height, Vec2::ZERO);
    let mut weight = Grid::new(a.width, a.height, 0.0f32);
    for (patch, &f) in patches.iter().zip(flow) {
        let difference = residual(patch, b, f).0;
        for row in 0..PATCH {
            let y = patch.y - PAD + row;
            if y >= a.height {
                break;
            }
            let x = patch.x - PAD;
            let n = PATCH.min(a.width - x);
            let sums = &mut sum.row_mut(y)[x..x + n];
            let weights = &mut weight.row_mut(y)[x..x + n];
            for i in 0..n {
                let w = 1.0 / difference[row * PATCH + i].abs().max(1.0);
                sums[i] += f * w;
                weights[i] += w;
            }
        }
    }
    for (s, w) in sum.data_mut().iter_mut().zip(weight.data()) {
        *s /= w.max(1e-6);
    }
    sum
}
