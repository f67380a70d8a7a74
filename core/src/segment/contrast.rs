//! Contrast-sensitive edge weights (Boykov and Jolly 2001): outlines are cheap where colours change.

use std::ops::Range;

use crate::raster::Grid;

/// Entries of the contrast table; beyond its last exponent edges weigh the least they can.
const TABLE: usize = 512;
const FALL: f32 = 6.0;
/// The weight of an edge across any contrast: outlines have a price of their own.
const FLOOR: f32 = 0.05;

/// Contrast-sensitive edge weights: 1 between equal colours, falling with the squared difference relative to its mean
/// around the creature.
pub(super) struct Contrast {
    scale: f32,
    table: Vec<f32>,
}

impl Contrast {
    pub(super) fn of(image: &Grid<[u8; 3]>, (columns, rows): &(Range<usize>, Range<usize>)) -> Self {
        let (mut sum, mut count) = (0u64, 0u64);
        for y in rows.start.max(1)..rows.end {
            let (row, above) = (image.row(y), image.row(y - 1));
            for x in columns.start.max(1)..columns.end {
                sum += u64::from(difference(row[x], row[x - 1]) + difference(row[x], above[x]));
                count += 2;
            }
        }
        let mean = (sum as f32 / count.max(1) as f32).max(4.0);
        let scale = TABLE as f32 / (2.0 * mean * FALL);
        let weight = |i: usize| FLOOR + (1.0 - FLOOR) * (-(i as f32) * FALL / TABLE as f32).exp();
        Self { scale, table: (0..=TABLE).map(weight).collect() }
    }

    #[inline]
    pub(super) fn weight(&self, a: [u8; 3], b: [u8; 3]) -> f32 {
        self.table[((difference(a, b) as f32 * self.scale) as usize).min(TABLE)]
    }
}

fn difference(a: [u8; 3], b: [u8; 3]) -> u32 {
    a.iter().zip(b).map(|(&x, y)| u32::from(x.abs_diff(y)).pow(2)).sum()
}
