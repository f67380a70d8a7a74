//! Masks carried from frame to frame by the limbs.
//!
//! In limb coordinates a mask moves with its limb. What was creature in frames near in time says what is likely creature
//! here, whatever the colours.

use super::stroke_field::{Cells, Place};
use crate::raster::{Grid, Mask};

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
