//! How far the creature reaches beside its strokes, learned from all frames.
//!
//! First without any mask: beside every stroke sample, on either side, the evidence for creature is averaged over all
//! frames at every distance; the limb's radius is where the sum from the stroke outward is largest, with radii of
//! neighbouring samples held together by dynamic programming (the paper's radius votes, section 3.7.1, taken before
//! the segmentation instead of after it). Then with masks: the share of frames, near in time, in which a place in limb
//! coordinates was creature; this is the previous and the next mask, carried by the limbs.

use rayon::prelude::*;

use super::stroke_field::{NOWHERE, Place};
use super::working::Limbs;
use crate::raster::{Grid, Mask};

/// Evidence beyond this counts no more, so that one frame or one odd colour cannot outvote the rest.
const CLIP: f32 = 1.0;
/// Fixed point of summed evidence.
const UNIT: f32 = 1024.0;
/// Evidence that a pixel of creature must exceed: what is no better than chance does not widen a limb.
const BIAS: f32 = 0.14;
/// What a step of the radius between neighbouring samples costs, in evidence for one pixel.
const STIFFNESS: f32 = 0.6;
/// The radius of a sample is also judged by its twin's evidence, with this weight.
const TWIN_WEIGHT: f32 = 0.7;
/// Weights of carried masks, where 1 is the frame next to the one looked at (nearly).
const OWN_WEIGHT: f32 = 0.3;
const FALLBACK_WEIGHT: f32 = 0.2;
const PAINTED_WEIGHT: f32 = 10.0;
/// How much longer painted masks are remembered.
const PAINTED_MEMORY: f32 = 3.0;
/// Places with fewer pixels than this over all frames say nothing.
const UNKNOWN: u8 = u8::MAX;
/// Full occupancy in the stored bytes.
const FULL: f32 = 250.0;

/// Bounds what is kept for a frame, for rigs of very many limbs.
const MAX_CELLS: usize = 1 << 19;

/// Cells of limb coordinates: sample, side, distance in whole working pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    samples: usize,
    /// Distances kept.
    pub(super) reach: usize,
}

impl Cells {
    pub(super) fn new(samples: usize, reach: f32) -> Self {
        let bound = MAX_CELLS / (2 * samples.max(1));
        Self { samples, reach: (reach.ceil() as usize).min(bound).clamp(4, 400) }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.samples * 2 * self.reach
    }

    /// The cell of a pixel, `None` beyond the reach.
    #[inline]
    pub(super) fn of(&self, place: Place) -> Option<usize> {
        let distance = place.distance() as usize;
        let inside = place.sample != NOWHERE && distance < self.reach;
        inside.then(|| (usize::from(place.sample) * 2 + place.side()) * self.reach + distance)
    }
}

/// Evidence summed in limb coordinates.
pub(super) struct Profile {
    cells: Cells,
    sums: Vec<i64>,
    counts: Vec<u32>,
}

impl Profile {
    pub(super) fn new(cells: Cells) -> Self {
        Self { cells, sums: vec![0; cells.count()], counts: vec![0; cells.count()] }
    }

    #[inline]
    pub(super) fn add(&mut self, cell: usize, evidence: f32, weight: u32) {
        self.sums[cell] += (evidence.clamp(-CLIP, CLIP) * UNIT) as i64 * i64::from(weight);
        self.counts[cell] += weight;
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| *a += b);
        self.counts.iter_mut().zip(&other.counts).for_each(|(a, b)| *a += b);
    }

    /// The radius beside every sample on either side, in working pixels: `[sample][side]`.
    /// None is below `least`: a stroke is drawn inside its limb, however little the colours say.
    pub(super) fn radii(&self, limbs: &Limbs, frames: usize, least: f32) -> Vec<[f32; 2]> {
        let mut radii = vec![[0.0; 2]; self.cells.samples];
        let jobs: Vec<(usize, usize)> = (0..limbs.first.len() - 1)
            .flat_map(|l| [(l, 0), (l, 1)])
            .filter(|&(l, _)| !limbs.of(l).is_empty())
            .collect();
        let solved: Vec<Vec<usize>> = jobs.par_iter().map(|&(l, side)| self.solve(limbs, l, side, frames)).collect();
        for (&(limb, side), solution) in jobs.iter().zip(solved) {
            for (sample, r) in limbs.of(limb).zip(solution) {
                radii[sample][side] = (r as f32 + 0.5).max(least);
            }
        }
        radii
    }

    /// Dynamic programming over the samples of one side of a limb.
    fn solve(&self, limbs: &Limbs, limb: usize, side: usize, frames: usize) -> Vec<usize> {
        let reach = self.cells.reach;
        let range = limbs.of(limb);
        let mut value: Vec<f32> = vec![0.0; reach];
        let mut choice: Vec<Vec<u16>> = Vec::with_capacity(range.len());
        for (i, sample) in range.clone().enumerate() {
            let mut gain = self.gain(sample, side, frames);
            if let Some(twin) = limbs.twin[limb].map(|t| limbs.of(t)).filter(|t| !t.is_empty()) {
                // Twins are drawn from the body outward alike; their samples correspond by share of length.
                let other = twin.start + i * (twin.len() - 1) / (range.len() - 1).max(1);
                for (g, t) in gain.iter_mut().zip(self.gain(other, side, frames)) {
                    *g = (*g + TWIN_WEIGHT * t) / (1.0 + TWIN_WEIGHT);
                }
            }
            // The best previous radius for each radius under a linear price of change: two sweeps.
            let mut from: Vec<u16> = (0..reach as u16).collect();
            if i > 0 {
                for r in 1..reach {
                    if value[r - 1] - STIFFNESS > value[r] {
                        value[r] = value[r - 1] - STIFFNESS;
                        from[r] = from[r - 1];
                    }
                }
                for r in (0..reach - 1).rev() {
                    if value[r + 1] - STIFFNESS > value[r] {
                        value[r] = value[r + 1] - STIFFNESS;
                        from[r] = from[r + 1];
                    }
                }
            }
            value.iter_mut().zip(&gain).for_each(|(v, g)| *v += g);
            choice.push(from);
        }
        let mut best = (0..reach).max_by(|&a, &b| value[a].total_cmp(&value[b]).then(b.cmp(&a))).unwrap_or(0);
        let mut path = vec![0; range.len()];
        for i in (0..range.len()).rev() {
            path[i] = best;
            best = usize::from(choice[i][best]);
        }
        path
    }

    /// What each radius gains at a sample: the evidence from the stroke outward.
    fn gain(&self, sample: usize, side: usize, frames: usize) -> Vec<f32> {
        let start = (sample * 2 + side) * self.cells.reach;
        let mut sum = 0.0;
        (start..start + self.cells.reach)
            .map(|cell| {
                let before = sum;
                let count = self.counts[cell];
                if count > 0 {
                    let mean = self.sums[cell] as f32 / UNIT / count as f32;
                    // Places that belong to the limb in few frames only (another is nearer in the rest) say little.
                    sum += (mean - BIAS) * (count as f32 / frames.max(1) as f32).min(1.0);
                }
                before
            })
            .collect()
    }
}

/// In which cells one frame's mask was creature, a byte a cell.
pub(super) fn occupancy(mask: &Mask, field: &Grid<Place>, cells: Cells) -> Vec<u8> {
    let mut inside = vec![0u16; cells.count()];
    let mut all = vec![0u16; cells.count()];
    for y in 0..field.height() {
        for (x, &place) in field.row(y).iter().enumerate() {
            if let Some(cell) = cells.of(place) {
                all[cell] = all[cell].saturating_add(1);
                inside[cell] = inside[cell].saturating_add(u16::from(mask.get(x, y)));
            }
        }
    }
    inside
        .iter()
        .zip(&all)
        .map(|(&i, &n)| if n == 0 { UNKNOWN } else { (f32::from(i) / f32::from(n) * FULL) as u8 })
        .collect()
}

/// The share of creature in every cell around `frame`: frames weigh `exp(-distance / memory)`, the frame itself
/// little, because its mask is what is to be found; `painted` frames weigh more and are remembered for longer. Frames
/// whose entry is empty have no mask yet. Cells that no frame knows take `fallback`.
pub(super) fn carried(
    occupied: &[Vec<u8>],
    cells: Cells,
    frame: usize,
    memory: f32,
    painted: impl Fn(usize) -> bool,
    fallback: impl Fn(usize) -> f32,
) -> Vec<f32> {
    let count = cells.count();
    let (mut sums, mut totals) = (vec![0.0f32; count], vec![0.0f32; count]);
    let span = (memory * 3.0 * PAINTED_MEMORY).ceil() as usize;
    for other in frame.saturating_sub(span)..=(frame + span).min(occupied.len().saturating_sub(1)) {
        let distance = other.abs_diff(frame) as f32;
        let weight = match painted(other) {
            true => PAINTED_WEIGHT * (-distance / (memory * PAINTED_MEMORY)).exp(),
            false if other == frame => OWN_WEIGHT,
            false if distance <= 3.0 * memory => (-distance / memory).exp(),
            false => continue,
        };
        for ((s, t), &o) in sums.iter_mut().zip(&mut totals).zip(&occupied[other]) {
            if o != UNKNOWN {
                *s += weight / FULL * f32::from(o);
                *t += weight;
            }
        }
    }
    sums.iter()
        .zip(&totals)
        .enumerate()
        // Thin evidence leans on the fallback.
        .map(|(cell, (s, t))| (s + FALLBACK_WEIGHT * fallback(cell)) / (t + FALLBACK_WEIGHT))
        .collect()
}
