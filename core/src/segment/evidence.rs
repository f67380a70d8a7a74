//! Colour evidence: how much more likely a pixel's colour is on the creature than behind it.
//!
//! The creature's colours are known over the whole clip, and again for each third of each limb; the background's over
//! the whole clip, and again for each tile of the picture around the time of the frame. Local models count as far as
//! they have seen enough.

use super::colour_model::{Counts, Density};
use super::limb_shape::Cells;
use super::stroke_field::{NOWHERE, Place};
use super::working::{Limbs, Working};
use crate::raster::Grid;

/// Bins a channel of models over the clip, and of local ones.
const GLOBAL_BINS: usize = 32;
const LOCAL_BINS: usize = 16;
/// Blur in bins of the two.
const GLOBAL_BLUR: f32 = 1.0;
const LOCAL_BLUR: f32 = 0.8;
/// Parts of a limb with colours of their own.
const PARTS: usize = 3;
/// Tiles along the longer side of the picture.
const TILES: usize = 8;
/// A local model of this many pixels counts as much as the global one.
const TRUST: f32 = 120.0;
/// A colour never seen on either side has this density (1 is even).
const FLOOR: f32 = 0.03;
/// Evidence is kept within this: the model is never sure.
pub(super) const LIMIT: f32 = 2.5;

/// What a pixel teaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lesson {
    Creature,
    Background,
    Nothing,
}

/// Colours of one frame or of many, counted.
pub(super) struct Lessons {
    creature: Counts,
    background: Counts,
    parts: Vec<Counts>,
}

impl Lessons {
    pub(super) fn new(limbs: &Limbs) -> Self {
        Self {
            creature: Counts::new(GLOBAL_BINS),
            background: Counts::new(GLOBAL_BINS),
            parts: vec![Counts::new(LOCAL_BINS); (limbs.first.len() - 1) * PARTS],
        }
    }

    pub(super) fn add(&mut self, colour: [u8; 3], place: Place, limbs: &Limbs, lesson: Lesson, weight: u32) {
        match lesson {
            Lesson::Creature => {
                self.creature.add(colour, weight);
                if let Some(part) = part_of(limbs, place) {
                    self.parts[part].add(colour, weight);
                }
            }
            Lesson::Background => self.background.add(colour, weight),
            Lesson::Nothing => {}
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.creature.merge(&other.creature);
        self.background.merge(&other.background);
        self.parts.iter_mut().zip(&other.parts).for_each(|(a, b)| a.merge(b));
    }

    pub(super) fn learn(&self) -> Colours {
        Colours {
            creature: self.creature.density(GLOBAL_BLUR),
            background: self.background.density(GLOBAL_BLUR),
            parts: self.parts.iter().map(|p| (p.density(LOCAL_BLUR), trust(p))).collect(),
        }
    }
}

/// Colours of the clip.
pub(super) struct Colours {
    creature: Density,
    background: Density,
    parts: Vec<(Density, f32)>,
}

/// Colours of the background near a time, for each tile of the picture.
pub(super) struct Tiles {
    across: usize,
    down: usize,
    size: f32,
    models: Vec<(Density, f32)>,
}

impl Tiles {
    /// Counts the background of frames near in time; `lesson(frame, pixel index)` says what is background.
    pub(super) fn learn(
        working: &Working,
        frames: impl Iterator<Item = usize>,
        lesson: impl Fn(usize, usize) -> Lesson,
    ) -> Self {
        let size = working.width.max(working.height) as f32 / TILES as f32;
        let across = (working.width as f32 / size).ceil().max(1.0) as usize;
        let down = (working.height as f32 / size).ceil().max(1.0) as usize;
        let mut counts = vec![Counts::new(LOCAL_BINS); across * down];
        for frame in frames {
            let image = &working.frames[frame];
            for y in 0..working.height {
                let row = (y as f32 / size) as usize * across;
                for (x, &colour) in image.row(y).iter().enumerate() {
                    if lesson(frame, y * working.width + x) == Lesson::Background {
                        counts[row + (x as f32 / size) as usize].add(colour, 1);
                    }
                }
            }
        }
        let models = counts.iter().map(|c| (c.density(LOCAL_BLUR), trust(c))).collect();
        Self { across, down, size, models }
    }

    /// Density and trust at a pixel, interpolated between the middles of tiles.
    #[inline]
    fn of(&self, x: usize, y: usize, colour: [u8; 3]) -> (f32, f32) {
        let u = ((x as f32 + 0.5) / self.size - 0.5).clamp(0.0, (self.across - 1) as f32);
        let v = ((y as f32 + 0.5) / self.size - 0.5).clamp(0.0, (self.down - 1) as f32);
        let (x0, y0) = (u as usize, v as usize);
        let (x1, y1) = ((x0 + 1).min(self.across - 1), (y0 + 1).min(self.down - 1));
        let (fx, fy) = (u - x0 as f32, v - y0 as f32);
        let (mut density, mut total) = (0.0, 0.0);
        for (tx, ty, w) in
            [(x0, y0, (1.0 - fx) * (1.0 - fy)), (x1, y0, fx * (1.0 - fy)), (x0, y1, (1.0 - fx) * fy), (x1, y1, fx * fy)]
        {
            let (model, trust) = &self.models[ty * self.across + tx];
            density += w * trust * model.of(colour);
            total += w * trust;
        }
        (if total > 0.0 { density / total } else { 1.0 }, total)
    }
}

fn trust(counts: &Counts) -> f32 {
    let n = counts.total() as f32;
    n / (n + TRUST)
}

fn part_of(limbs: &Limbs, place: Place) -> Option<usize> {
    if place.sample == NOWHERE {
        return None;
    }
    let sample = usize::from(place.sample);
    let limb = usize::from(limbs.limb[sample]);
    let range = limbs.of(limb);
    Some(limb * PARTS + (sample - range.start) * PARTS / range.len())
}

/// The evidence for creature at every pixel within reach of a stroke, natural logarithm; minus the limit elsewhere.
pub(super) fn colour_evidence(
    image: &Grid<[u8; 3]>,
    field: &Grid<Place>,
    cells: Cells,
    limbs: &Limbs,
    colours: &Colours,
    tiles: &Tiles,
) -> Vec<f32> {
    let (width, height) = (image.width(), image.height());
    let mut out = vec![-LIMIT; width * height];
    for y in 0..height {
        for x in 0..width {
            let place = field.get(x, y);
            if cells.of(place).is_none() {
                continue;
            }
            let colour = image.get(x, y);
            let mut creature = colours.creature.of(colour);
            if let Some(part) = part_of(limbs, place) {
                let (model, trust) = &colours.parts[part];
                creature += 0.7 * trust * (model.of(colour) - creature);
            }
            let (near, trust) = tiles.of(x, y, colour);
            let mut background = colours.background.of(colour);
            background += 0.7 * trust * (near - background);
            out[y * width + x] = ((creature + FLOOR) / (background + FLOOR)).ln().clamp(-LIMIT, LIMIT);
        }
    }
    out
}
