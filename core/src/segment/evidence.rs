//! Colour evidence: how much more likely a pixel's colour is on the creature than behind it.
//!
//! The creature's colours are known over the whole clip, and again for each third of each limb; the background's over
//! the whole clip, and again for each tile of the picture around the time of the frame. Local models count as far as
//! they have seen enough.

use std::ops::Range;

use super::backdrop::Backdrop;
use super::colour_model::{Counts, Density};
use super::painted::Known;
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
/// Share of a local model that has seen enough; the rest is the global one's.
const LOCAL_SHARE: f32 = 0.7;
/// A colour never seen on either side has this density (1 is even).
const FLOOR: f32 = 0.03;
/// Evidence is kept within this: the model is never sure.
const LIMIT: f32 = 2.5;

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

    #[inline]
    pub(super) fn add_background(&mut self, colour: [u8; 3]) {
        self.background.add(colour, 1);
    }

    #[inline]
    pub(super) fn add_creature(&mut self, colour: [u8; 3], place: Place, limbs: &Limbs) {
        self.creature.add(colour, 1);
        if let Some(part) = part_of(limbs, place) {
            self.parts[part].add(colour, 1);
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
    /// Counts the background of frames near in time around `window`; `lesson(frame, x, y)` says what is background.
    pub(super) fn learn(
        working: &Working,
        frames: impl Iterator<Item = usize>,
        (columns, rows): &(Range<usize>, Range<usize>),
        lesson: impl Fn(usize, usize, usize) -> Lesson,
    ) -> Self {
        let size = working.width.max(working.height) as f32 / TILES as f32;
        let across = (working.width as f32 / size).ceil().max(1.0) as usize;
        let down = (working.height as f32 / size).ceil().max(1.0) as usize;
        let mut counts = vec![Counts::new(LOCAL_BINS); across * down];
        let column = |x: usize| ((x as f32 / size) as usize).min(across - 1);
        let row = |y: usize| ((y as f32 / size) as usize).min(down - 1);
        // Evidence in the window reads tiles half a tile beyond it.
        let margin = (0.5 * size).ceil() as usize;
        let rows = rows.start.saturating_sub(margin)..(rows.end + margin).min(working.height);
        let columns = columns.start.saturating_sub(margin)..(columns.end + margin).min(working.width);
        for frame in frames {
            let image = &working.frames[frame];
            // Neighbouring rows teach the same colours.
            for y in rows.clone().step_by(2) {
                let (line, first) = (image.row(y), row(y) * across);
                for x in columns.clone() {
                    if lesson(frame, x, y) == Lesson::Background {
                        counts[first + column(x)].add(line[x], 2);
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

/// Evidence of a frame: how much likelier creature is than background, as a natural logarithm.
pub(super) struct Evidence {
    width: usize,
    /// In fiftieths.
    values: Vec<i8>,
}

/// Fixed point of evidence; [`LIMIT`] must fit a byte.
const STEPS: f32 = 50.0;

impl Evidence {
    #[inline]
    pub(super) fn at(&self, x: usize, y: usize) -> f32 {
        f32::from(self.values[y * self.width + x]) / STEPS
    }

    /// Puts what is known in place of what is likely.
    pub(super) fn overrule(&mut self, known: &[Known]) {
        for (value, known) in self.values.iter_mut().zip(known) {
            match known {
                Known::Creature => *value = (LIMIT * STEPS) as i8,
                Known::Background => *value = (-LIMIT * STEPS) as i8,
                Known::Nothing => {}
            }
        }
    }
}

/// The evidence for creature at every pixel of the window that has a place; minus the limit elsewhere.
pub(super) fn colour_evidence(
    image: &Grid<[u8; 3]>,
    (columns, rows): &(Range<usize>, Range<usize>),
    place: impl Fn(usize, usize) -> Option<Place>,
    limbs: &Limbs,
    colours: &Colours,
    tiles: &Tiles,
    backdrop: Option<&Backdrop>,
) -> Evidence {
    let (width, height) = (image.width(), image.height());
    let mut values = vec![(-LIMIT * STEPS) as i8; width * height];
    for y in rows.clone() {
        for x in columns.clone() {
            let Some(place) = place(x, y) else { continue };
            let colour = image.get(x, y);
            let mut creature = colours.creature.of(colour);
            if let Some(part) = part_of(limbs, place) {
                let (model, trust) = &colours.parts[part];
                creature += LOCAL_SHARE * trust * (model.of(colour) - creature);
            }
            let (near, trust) = tiles.of(x, y, colour);
            let mut background = colours.background.of(colour);
            background += LOCAL_SHARE * trust * (near - background);
            let colour_says = ((creature + FLOOR) / (background + FLOOR)).ln().clamp(-LIMIT, LIMIT);
            let backdrop_says = backdrop.map_or(0.0, |b| b.evidence(x, y, colour));
            let evidence = (colour_says + backdrop_says).clamp(-LIMIT, LIMIT);
            values[y * width + x] = (evidence * STEPS).round() as i8;
        }
    }
    Evidence { width, values }
}
