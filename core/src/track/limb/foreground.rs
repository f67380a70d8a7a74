//! Which colours are the animal's: histograms from what lies on the strokes and what lies far from them.

use glam::Vec2;

use super::footage::LabImage;
use crate::raster::Grid;

/// Histogram cells along each channel.
const CELLS: usize = 32;
/// Mass that every colour gets, as a share of an even histogram: unseen colours are undecided.
const FLOOR: f32 = 0.3;

/// The probability of being animal for every colour.
#[derive(Clone, Debug)]
pub(super) struct Foreground {
    table: Vec<u8>,
}

#[inline]
fn cell(colour: [u8; 3]) -> usize {
    let [l, a, b] = colour.map(|v| usize::from(v) * CELLS / 256);
    (l * CELLS + a) * CELLS + b
}

impl Foreground {
    /// Learns from key frames and their strokes (working pixels). Pixels within `core` of a stroke are animal, those
    /// beyond `far` from all strokes are background.
    pub(super) fn learn(keys: &[(&LabImage, Vec<Vec<Vec2>>)], core: f32, far: f32) -> Self {
        let (mut animal, mut ground) = (vec![0.0f32; CELLS.pow(3)], vec![0.0f32; CELLS.pow(3)]);
        for (image, strokes) in keys {
            let points: Vec<Vec2> = strokes.iter().flatten().copied().collect();
            for y in 0..image.height() {
                for x in (y % 2..image.width()).step_by(2) {
                    let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                    let Some(colour) = image.at(p) else { continue };
                    let distance = points.iter().map(|q| q.distance_squared(p)).fold(f32::INFINITY, f32::min).sqrt();
                    if distance <= core {
                        animal[cell(colour)] += 1.0;
                    } else if distance >= far {
                        ground[cell(colour)] += 1.0;
                    }
                }
            }
        }
        for histogram in [&mut animal, &mut ground] {
            blur(histogram);
            let sum: f32 = histogram.iter().sum();
            histogram.iter_mut().for_each(|v| *v /= sum.max(1.0));
        }
        let floor = FLOOR / animal.len() as f32;
        let table = animal.iter().zip(&ground).map(|(a, g)| (255.0 * (a + floor) / (a + g + 2.0 * floor)) as u8);
        Self { table: table.collect() }
    }

    /// How likely every pixel of a picture is the animal's, in bytes.
    pub(super) fn seen(&self, image: &LabImage) -> Grid<u8> {
        let likely = image.pixels().data().iter().map(|colour| self.table[cell(*colour)]);
        Grid::from_vec(image.width(), image.height(), likely.collect())
    }

    /// The probability, over 0..=1, that such a byte says.
    #[inline]
    pub(super) fn probability_of(likely: u8) -> f32 {
        f32::from(likely) * (1.0 / 255.0)
    }
}

/// Binomial (1 2 1) / 4 along each channel.
fn blur(histogram: &mut [f32]) {
    for stride in [1, CELLS, CELLS * CELLS] {
        let old = histogram.to_vec();
        for (i, out) in histogram.iter_mut().enumerate() {
            let place = i / stride % CELLS;
            let before = if place > 0 { old[i - stride] } else { old[i] };
            let after = if place + 1 < CELLS { old[i + stride] } else { old[i] };
            *out = 0.25 * (before + 2.0 * old[i] + after);
        }
    }
}
