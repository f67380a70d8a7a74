//! A square patch of a picture, and where it is found in another: inverse compositional descent on the mean-free
//! squared difference.
//!
//! Baker and Matthews 2004, "Lucas-Kanade 20 years on": the patch's own gradients make the steps, so its normal
//! matrix is inverted once. Taking means away makes it indifferent to brightness.

use glam::{Mat2, Vec2};

use crate::pyramid::Level;

/// Pixels along a side.
pub(crate) const SIDE: usize = 8;
const AREA: usize = SIDE * SIDE;

/// A patch, ready to be looked for.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    pixels: [f32; AREA],
    dx: [f32; AREA],
    dy: [f32; AREA],
    inverse: Mat2,
    /// Variance of brightness.
    pub(crate) contrast: f32,
}

/// A place found, and how well it fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    pub(crate) at: Vec2,
    /// Mean squared difference, means taken away.
    pub(crate) cost: f32,
}

/// A square of the level around `centre`, turned by `turn` (a unit complex number).
fn cut(level: &Level, centre: Vec2, turn: Vec2, out: &mut [f32]) {
    let side = (out.len() as f32).sqrt() as usize;
    let middle = 0.5 * (side as f32 - 1.0);
    for row in 0..side {
        for column in 0..side {
            let off = turn.rotate(Vec2::new(column as f32 - middle, row as f32 - middle));
            out[row * side + column] = level.sample(centre.x + off.x, centre.y + off.y);
        }
    }
}

impl Patch {
    /// The patch around `centre` (from the first pixel's centre), turned by `turn`: the unit complex number by which
    /// it would have to turn to look as it does where it is searched.
    pub(crate) fn new(level: &Level, centre: Vec2, turn: Vec2) -> Self {
        const WIDE: usize = SIDE + 2;
        let mut wide = [0.0; WIDE * WIDE];
        // Looked for unturned: what was turned by `turn` since is sampled turned back.
        cut(level, centre, Vec2::new(turn.x, -turn.y), &mut wide);
        let (mut pixels, mut dx, mut dy) = ([0.0; AREA], [0.0; AREA], [0.0; AREA]);
        for row in 0..SIDE {
            for column in 0..SIDE {
                let i = (row + 1) * WIDE + column + 1;
                let to = row * SIDE + column;
                pixels[to] = wide[i];
                dx[to] = 0.5 * (wide[i + 1] - wide[i - 1]);
                dy[to] = 0.5 * (wide[i + WIDE] - wide[i - WIDE]);
            }
        }
        for values in [&mut pixels, &mut dx, &mut dy] {
            let mean = values.iter().sum::<f32>() / AREA as f32;
            values.iter_mut().for_each(|v| *v -= mean);
        }
        let dot = |a: &[f32; AREA], b: &[f32; AREA]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
        let (xx, xy, yy) = (dot(&dx, &dx), dot(&dx, &dy), dot(&dy, &dy));
        // Damped, so that a patch with one edge moves across it only.
        let damp = 0.02 * (xx + yy) + 2.0;
        let inverse = Mat2::from_cols_array(&[xx + damp, xy, xy, yy + damp]).inverse();
        let contrast = dot(&pixels, &pixels) / AREA as f32;
        Self { pixels, dx, dy, inverse, contrast }
    }

    /// The difference to what is at `at`, means taken away, and its mean square.
    #[inline]
    fn difference(&self, level: &Level, at: Vec2, out: &mut [f32; AREA]) -> f32 {
        let (left, top) = (at.x - 0.5 * (SIDE as f32 - 1.0), at.y - 0.5 * (SIDE as f32 - 1.0));
        let (w, h) = (level.width, level.height);
        if left >= 0.0 && top >= 0.0 && left + (SIDE as f32) < w as f32 && top + (SIDE as f32) < h as f32 {
            let (x0, y0) = (left as usize, top as usize);
            let (fx, fy) = (left - x0 as f32, top - y0 as f32);
            let (a, b, c, d) = ((1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy);
            for row in 0..SIDE {
                let upper = &level.pixels[(y0 + row) * w + x0..][..SIDE + 1];
                let lower = &level.pixels[(y0 + row + 1) * w + x0..][..SIDE + 1];
                let line = &mut out[row * SIDE..(row + 1) * SIDE];
                for i in 0..SIDE {
                    line[i] = a * upper[i] + b * upper[i + 1] + c * lower[i] + d * lower[i + 1];
                }
            }
        } else {
            cut(level, at, Vec2::X, out);
        }
        let mean = out.iter().sum::<f32>() / AREA as f32;
        let mut sum = 0.0;
        for (o, p) in out.iter_mut().zip(&self.pixels) {
            *o -= mean + p;
            sum += *o * *o;
        }
        sum / AREA as f32
    }

    /// How badly the patch fits at `at`.
    pub(crate) fn cost(&self, level: &Level, at: Vec2) -> f32 {
        self.difference(level, at, &mut [0.0; AREA])
    }

    /// Goes downhill from `start`, no farther than `reach`.
    pub(crate) fn descend(&self, level: &Level, start: Vec2, steps: usize, reach: f32) -> Found {
        let mut out = [0.0; AREA];
        let mut at = start;
        let mut best = Found { at, cost: f32::INFINITY };
        for _ in 0..=steps {
            let cost = self.difference(level, at, &mut out);
            if cost < best.cost {
                best = Found { at, cost };
            } else if cost > 1.3 * best.cost {
                break;
            }
            let (mut gx, mut gy) = (0.0, 0.0);
            for i in 0..AREA {
                gx += self.dx[i] * out[i];
                gy += self.dy[i] * out[i];
            }
            let step = self.inverse * Vec2::new(gx, gy);
            at -= step;
            if step.length_squared() < 1e-4 || at.distance_squared(start) > reach * reach {
                break;
            }
        }
        best
    }
}
