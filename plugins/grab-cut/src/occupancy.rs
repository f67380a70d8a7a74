//! What of a limb's surroundings was creature in other frames: the mask, carried along by the limbs.
//!
//! A mask is counted in cells that move with the limbs (part of the limb, distance, side), so that its neighbours in
//! time are compared where the creature is, not where it was. This is what makes the masks of a clip agree.

use crate::limb_field::{PARTS, cells};

/// Counts of one frame.
#[derive(Clone)]
pub(crate) struct Counts {
    /// Creature and all pixels of each cell.
    cells: Vec<[f32; 2]>,
}

impl Counts {
    pub(crate) fn new(limbs: usize) -> Self {
        Self { cells: vec![[0.0; 2]; cells(limbs)] }
    }

    #[inline]
    pub(crate) fn add(&mut self, cell: usize, creature: bool, weight: f32) {
        self.cells[cell][0] += if creature { weight } else { 0.0 };
        self.cells[cell][1] += weight;
    }
}

/// Chances of being creature, seen from one frame.
pub(crate) struct Occupancy {
    cells: Vec<[f32; 2]>,
    limbs: usize,
}

impl Occupancy {
    /// Counts of many frames, each with its weight.
    pub(crate) fn gather<'a>(limbs: usize, frames: impl Iterator<Item = (&'a Counts, f32)>) -> Self {
        let mut sum = vec![[0.0f32; 2]; cells(limbs)];
        for (counts, weight) in frames {
            for (s, c) in sum.iter_mut().zip(&counts.cells) {
                s[0] += weight * c[0];
                s[1] += weight * c[1];
            }
        }
        let across = cells(1) / (PARTS + 2);
        // A cell is a few pixels; its neighbours know as much of it as it does.
        let mut smooth = sum.clone();
        for row in 0..limbs * (PARTS + 2) {
            let line = &sum[row * across..(row + 1) * across];
            for i in 0..across {
                let mut out = [0.0; 2];
                for (step, weight) in [(-1isize, 1.0), (0, 2.0), (1, 1.0)] {
                    if let Some(c) = i.checked_add_signed(step).and_then(|j| line.get(j)) {
                        out[0] += 0.25 * weight * c[0];
                        out[1] += 0.25 * weight * c[1];
                    }
                }
                smooth[row * across + i] = out;
            }
        }
        let blurred = smooth.clone();
        for limb in 0..limbs {
            // Ends keep to themselves: beyond them the creature stops.
            for part in 2..=PARTS {
                let at = (limb * (PARTS + 2) + part) * across;
                for i in 0..across {
                    for k in 0..2 {
                        let link = 0.3 * (blurred[at - across + i][k] - blurred[at + i][k]);
                        smooth[at + i][k] += link;
                        smooth[at - across + i][k] -= link;
                    }
                }
            }
        }
        Self { cells: smooth, limbs }
    }

    /// The chance that a pixel in `cell` is creature, `start` where nothing was counted, which counts for `doubt`
    /// pixels.
    #[inline]
    pub(crate) fn chance(&self, cell: usize, start: f32, doubt: f32) -> f32 {
        let [creature, all] = self.cells[cell];
        (creature + doubt * start) / (all + doubt)
    }

    /// Half the creature's usual width around each limb, in cells' pixels.
    pub(crate) fn radii(&self, pixels: f32) -> Vec<f32> {
        let across = cells(1) / (PARTS + 2);
        let one = |limb: usize| {
            let mut widths: Vec<f32> = (1..=PARTS)
                .map(|part| {
                    let at = (limb * (PARTS + 2) + part) * across;
                    let row = &self.cells[at..at + across];
                    row.iter().filter(|c| c[1] > 0.0 && c[0] > 0.5 * c[1]).count() as f32 * pixels / 2.0
                })
                .collect();
            widths.sort_by(f32::total_cmp);
            widths[PARTS / 2]
        };
        (0..self.limbs).map(one).collect()
    }
}
