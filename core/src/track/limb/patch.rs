//! Square colour patches and what it costs to find one at a place of an image.
//!
//! The cost is a weighted mean of squared colour differences, each truncated where asked (a robust M-estimate after
//! Black & Anandan 1996), so that a pixel hidden by something else costs no more than one that merely differs.
//! Patches are turned once and then slid over whole pixels; places between pixels come from the costs' parabola.

use glam::Vec2;

use super::candidates::CostMap;
use crate::raster::{Grid, Planes};

/// Sums run in this many lanes, in one fixed order on every machine.
const LANES: usize = 8;

/// A square patch ready to be slid: rows padded to whole lanes with weight 0.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    side: usize,
    stride: usize,
    /// Row by row the three channels, then the weights.
    rows: Vec<f32>,
    total: f32,
}

impl Patch {
    /// The patch of `side` x `side` pixels around the centre of a pixel, as `colour_and_weight` gives it for offsets
    /// from that centre. An even side is raised by one, so that there is a middle.
    pub(crate) fn from_fn(side: usize, colour_and_weight: impl Fn(Vec2) -> ([f32; 3], f32)) -> Self {
        let half = side / 2;
        let side = 2 * half + 1;
        let stride = side.next_multiple_of(LANES);
        let mut rows = vec![0.0; side * 4 * stride];
        let mut total = 0.0;
        for (y, row) in rows.chunks_exact_mut(4 * stride).enumerate() {
            for x in 0..side {
                let offset = Vec2::new(x as f32 - half as f32, y as f32 - half as f32);
                let (colour, weight) = colour_and_weight(offset);
                for c in 0..3 {
                    row[c * stride + x] = colour[c];
                }
                row[3 * stride + x] = weight;
                total += weight;
            }
        }
        Self { side, stride, rows, total }
    }

    /// The patch of an image around `centre`, turned so that what points along `turn` (a unit vector) in the patch
    /// pointed along x in the image; all pixels weigh the same.
    pub(crate) fn cut(image: &Planes, centre: Vec2, turn: Vec2, side: usize) -> Self {
        let unturn = Vec2::new(turn.x, -turn.y);
        Self::from_fn(side, |offset| (image.at(centre + unturn.rotate(offset)), 1.0))
    }

    /// Pixels along a side, odd.
    pub(crate) fn side(&self) -> usize {
        self.side
    }

    /// The weighted mean of squared differences to another patch of this side, each at most `truncation`.
    pub(crate) fn difference(&self, other: &Self, truncation: f32) -> f32 {
        if self.total <= 0.0 || self.side != other.side {
            return f32::INFINITY;
        }
        let mut sum = 0.0;
        for (ours, theirs) in self.rows.chunks_exact(4 * self.stride).zip(other.rows.chunks_exact(4 * self.stride)) {
            for x in 0..self.side {
                let squared = |c: usize| (ours[c * self.stride + x] - theirs[c * self.stride + x]).powi(2);
                sum += ours[3 * self.stride + x] * (squared(0) + squared(1) + squared(2)).min(truncation);
            }
        }
        sum / self.total
    }
}

/// A part of an image copied out with its border repeated, so that patches slide over it without looking where they are.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    origin: (isize, isize),
    width: usize,
    height: usize,
    side: usize,
    stride: usize,
    /// Row by row the three channels.
    rows: Vec<f32>,
}

impl Region {
    /// What patches of `side` pixels see when their middle is on a pixel of the rectangle `width` x `height` from
    /// column and row `origin`.
    pub(crate) fn around(image: &Planes, origin: (isize, isize), width: usize, height: usize, side: usize) -> Self {
        let half = (side / 2) as isize;
        let side = 2 * (side / 2) + 1;
        // Padded lanes of a patch read past the last column; they weigh nothing.
        let stride = width + side.next_multiple_of(LANES);
        let (columns, lines) = (width + side - 1, height + side - 1);
        let mut rows = vec![0.0; lines * 3 * stride];
        let last = image.width() as isize - 1;
        for (line, row) in rows.chunks_exact_mut(3 * stride).enumerate() {
            let y = (origin.1 - half + line as isize).clamp(0, image.height() as isize - 1) as usize;
            for (c, target) in row.chunks_exact_mut(stride).enumerate() {
                let source = image.channel(c).row(y);
                for (x, value) in target[..columns].iter_mut().enumerate() {
                    *value = source[(origin.0 - half + x as isize).clamp(0, last) as usize];
                }
            }
        }
        Self { origin, width, height, side, stride, rows }
    }

    /// The cost of the patch, of this region's side, at every pixel of the rectangle.
    pub(crate) fn costs(&self, patch: &Patch, truncation: f32) -> CostMap {
        let mut costs = Grid::new(self.width, self.height, f32::INFINITY);
        for y in 0..self.height {
            for x in 0..self.width {
                costs.set(x, y, self.cost(patch, x, y, truncation));
            }
        }
        CostMap { origin: self.origin, costs }
    }

    /// The cost of the patch, of this region's side, at column `x` and row `y` of the rectangle.
    #[inline]
    pub(crate) fn cost(&self, patch: &Patch, x: usize, y: usize, truncation: f32) -> f32 {
        debug_assert!(patch.side == self.side && x < self.width && y < self.height);
        if patch.total <= 0.0 {
            return f32::INFINITY;
        }
        let mut sums = [0.0f32; LANES];
        let seen = self.rows[y * 3 * self.stride..].chunks_exact(3 * self.stride);
        for (ours, theirs) in patch.rows.chunks_exact(4 * patch.stride).zip(seen) {
            let (ours, _) = ours.as_chunks::<LANES>();
            let blocks = patch.stride / LANES;
            let channel = |c: usize| theirs[c * self.stride + x..][..patch.stride].as_chunks::<LANES>().0;
            let (s0, s1, s2) = (channel(0), channel(1), channel(2));
            let (t0, rest) = ours.split_at(blocks);
            let (t1, rest) = rest.split_at(blocks);
            let (t2, weights) = rest.split_at(blocks);
            for (((((a0, a1), a2), b0), b1), (b2, w)) in
                t0.iter().zip(t1).zip(t2).zip(s0).zip(s1).zip(s2.iter().zip(weights))
            {
                for i in 0..LANES {
                    let (d0, d1, d2) = (a0[i] - b0[i], a1[i] - b1[i], a2[i] - b2[i]);
                    let squared = d0 * d0 + d1 * d1 + d2 * d2;
                    sums[i] += w[i] * if squared < truncation { squared } else { truncation };
                }
            }
        }
        let pairs = [sums[0] + sums[4], sums[1] + sums[5], sums[2] + sums[6], sums[3] + sums[7]];
        ((pairs[0] + pairs[2]) + (pairs[1] + pairs[3])) / patch.total
    }
}
