//! Animal that no limb covers, as a cost for a pair of limbs: two legs on one leg's pixels leave the other's over.

use glam::Vec2;

use super::claims::Claims;
use super::space_time::Task;
use super::strip::CLAIM_CELL;
use crate::raster::Mask;

/// Distance between the places looked at, as a share of the limb's length.
const GRID: f32 = 0.035;
/// Colours at least this likely to be the animal's want an explanation.
const ANIMAL: f32 = 0.6;
/// Cost when as much is left over as one of the limbs would cover.
const LEFT_OVER: f32 = 0.15;

/// The places of one frame that want an explanation by one of two limbs.
#[derive(Clone, Debug)]
pub(super) struct Unexplained {
    /// In claim cells.
    places: Vec<Vec2>,
    /// How many places one limb covers, seen as a whole.
    limb: f32,
}

impl Unexplained {
    /// Looks within the limbs' reach around their joints, where nothing solved already is.
    pub(super) fn new(tasks: [&Task<'_>; 2], claims: &Claims, frame: usize) -> Self {
        let lengths = tasks[0].lengths(frame);
        let length: f32 = lengths.iter().sum();
        let step = (GRID * length).max(2.0);
        let radii = &tasks[0].strip.radii;
        let area: f32 = lengths.iter().zip(radii.windows(2)).map(|(l, r)| l * (r[0] + r[1])).sum();
        let mut places = Vec::new();
        if let Some(roots) = &tasks[0].roots {
            let root = roots[frame];
            let view = tasks[0].view(frame);
            let claimed = claims.frame(frame);
            let steps = (length / step).min(64.0) as i32;
            for y in -steps..=steps {
                for x in -steps..=steps {
                    let p = root + Vec2::new(x as f32, y as f32) * step;
                    let cell = p / CLAIM_CELL;
                    if p.distance_squared(root) <= length * length
                        && let Some((_, animal)) = view.at(p)
                        && animal >= ANIMAL
                        && !claimed.at(cell.x as isize, cell.y as isize)
                    {
                        places.push(cell);
                    }
                }
            }
        }
        Self { places, limb: (area / (step * step)).max(1.0) }
    }

    /// Which places a mask covers, a bit each.
    pub(super) fn covered(&self, mask: &Mask) -> Vec<u64> {
        let word = |places: &[Vec2]| {
            places.iter().enumerate().fold(0, |bits, (i, p)| bits | u64::from(mask.at(p.x as isize, p.y as isize)) << i)
        };
        self.places.chunks(64).map(word).collect()
    }

    /// The cost of what neither covers.
    pub(super) fn cost(&self, first: &[u64], second: &[u64]) -> f32 {
        let covered: u32 = first.iter().zip(second).map(|(a, b)| (a | b).count_ones()).sum();
        LEFT_OVER * (self.places.len() as f32 - covered as f32) / self.limb
    }
}
