//! The default segmenter: learned limb shapes, local colours, exact cuts.
//!
//! Masks and models are refined in turn. In the beginning only the strokes and what is far from all of them teach
//! colours, and limb radii come from the colours over all frames; every later pass learns colours from the masks of
//! the last one, and carries those masks from frame to frame in limb coordinates. Every pass ends with a minimum cut
//! per frame over colour evidence, shape and contrast (Boykov and Jolly 2001; Rother, Kolmogorov and Blake 2004).

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::evidence::{LIMIT, Lesson, Lessons, Tiles, colour_evidence};
use super::grid_cut::{GridCut, Neighbour};
use super::limb_shape::{Cells, Profile, carried, occupancy};
use super::painted::{Known, Painted};
use super::params::SegmentParams;
use super::stroke_field::{NOWHERE, Place, stroke_field};
use super::working::{Limbs, Working};
use crate::error::Result;
use crate::job::Stage;
use crate::raster::morphology::{parts, without_holes};
use crate::raster::{Grid, Mask};

/// Distance between samples along limbs, in working pixels.
pub(super) const SPACING: f32 = 3.0;
/// Pixels this near to a visible stroke teach the first colours, in working pixels.
const STROKE_WIDTH: f32 = 1.5;
/// Fixed point of the cut's capacities.
const UNIT: f32 = 256.0;
/// How soft a limb's border is, as a share of its radius and in pixels.
const SOFTNESS: (f32, f32) = (0.2, 1.5);
/// Prior knowledge is never surer than this (natural logarithm of odds).
const SURE: f32 = 3.0;

/// The weight of a limb's shape where its track cannot be trusted at all.
const DOUBTED: f32 = 0.25;

/// More than all other costs of a pixel together.
const CERTAIN: i32 = 1 << 20;
/// Holes of at most this share of the mask are filled; larger ones are seen between limbs.
const HOLE_SHARE: f32 = 0.002;
/// Parts without a stroke that are this large, compared with the largest, are a limb whose track has been lost.
const ISLAND_SHARE: f32 = 0.1;

/// Who says what is creature.
#[derive(Clone, Copy)]
enum Teacher<'m> {
    /// The strokes as drawn on key frames.
    Drawn,
    /// These pixels of tracked strokes.
    Accepted(&'m [Mask]),
    /// The masks of the last pass.
    Masks(&'m [Mask]),
}

/// What all passes share.
pub(super) struct Layers<'a> {
    pub(super) working: &'a Working,
    pub(super) limbs: &'a Limbs,
    pub(super) params: &'a SegmentParams,
    cells: Cells,
    fields: Vec<Grid<Place>>,
    /// What the user painted, at working size.
    known: BTreeMap<usize, Grid<Known>>,
}

impl<'a> Layers<'a> {
    /// Limb coordinates of every pixel of every frame.
    pub(super) fn new(
        working: &'a Working,
        limbs: &'a Limbs,
        params: &'a SegmentParams,
        painted: &Painted,
        stage: Stage<'_>,
    ) -> Result<Self> {
        let reach = params.reach * limbs.extent();
        let fields = each_frame(working.frames.len(), stage, |frame| {
            Ok(stroke_field(limbs, frame, working.width, working.height))
        })?;
        let known = painted.reduced(working.width, working.height);
        Ok(Self { known, working, limbs, params, cells: Cells::new(limbs.len(), reach), fields })
    }

    /// The creature in every frame, at working size.
    pub(super) fn masks(&self, stage: Stage<'_>) -> Result<Vec<Mask>> {
        let passes = self.params.passes.max(1);
        let share = |p: usize| stage.part(p as f64 / (passes + 1) as f64, (p + 1) as f64 / (passes + 1) as f64);
        let (accepted, trust) = self.agreement(share(0).part(0.0, 0.5))?;
        let radii = self.radii(&accepted, share(0).part(0.5, 1.0))?;
        let mut masks: Option<Vec<Mask>> = None;
        for pass in 0..passes {
            let teacher = masks.as_deref().map_or(Teacher::Accepted(&accepted), Teacher::Masks);
            masks = Some(self.pass(&radii, &trust, teacher, share(pass + 1))?);
        }
        Ok(masks.unwrap_or_default())
    }

    fn each_frame<T: Send>(&self, stage: Stage<'_>, work: impl Fn(usize) -> T + Sync) -> Result<Vec<T>> {
        each_frame(self.working.frames.len(), stage, |frame| Ok(work(frame)))
    }

    /// What a pixel teaches.
    fn lesson(&self, teacher: Teacher<'_>, frame: usize, index: usize) -> Lesson {
        let place = self.fields[frame].data()[index];
        match self.known.get(&frame).map_or(Known::Nothing, |k| k.data()[index]) {
            Known::Creature => return Lesson::Creature,
            Known::Background => return Lesson::Background,
            Known::Nothing => {}
        }
        let at = (index % self.working.width, index / self.working.width);
        if let Teacher::Masks(masks) = teacher {
            return if masks[frame].get(at.0, at.1) { Lesson::Creature } else { Lesson::Background };
        }
        if self.cells.of(place).is_none() {
            return Lesson::Background;
        }
        if !self.on_stroke(frame, place) {
            return Lesson::Nothing;
        }
        let limb = usize::from(self.limbs.limb[usize::from(place.sample)]);
        let taught = match teacher {
            Teacher::Accepted(accepted) => accepted[frame].get(at.0, at.1),
            _ => self.limbs.drawn[frame][limb],
        };
        if taught { Lesson::Creature } else { Lesson::Nothing }
    }

    /// Whether a pixel lies on a part of a stroke that should show creature.
    fn on_stroke(&self, frame: usize, place: Place) -> bool {
        place.sample != NOWHERE && place.distance() <= STROKE_WIDTH && {
            let sample = usize::from(place.sample);
            self.limbs.trusted[sample] && self.limbs.visible[frame][sample]
        }
    }

    /// Evidence of every frame under the models that are taught, handed to `take`.
    fn with_evidence<T: Send>(
        &self,
        teacher: Teacher<'_>,
        stage: Stage<'_>,
        take: impl Fn(usize, Vec<f32>) -> T + Sync,
    ) -> Result<Vec<T>> {
        let counted = self.each_frame(stage.part(0.0, 0.3), |frame| {
            let mut lessons = Lessons::new(self.limbs);
            for (index, &colour) in self.working.frames[frame].data().iter().enumerate() {
                let place = self.fields[frame].data()[index];
                lessons.add(colour, place, self.limbs, self.lesson(teacher, frame, index), 1);
            }
            lessons
        })?;
        let mut all = Lessons::new(self.limbs);
        counted.iter().for_each(|l| all.merge(l));
        drop(counted);
        let colours = all.learn();
        let last = self.working.frames.len() - 1;
        self.each_frame(stage.part(0.3, 1.0), |frame| {
            let near = [frame.checked_sub(2), Some(frame), Some(frame + 2).filter(|&f| f <= last)];
            let tiles =
                Tiles::learn(self.working, near.into_iter().flatten(), |f, index| self.lesson(teacher, f, index));
            let image = &self.working.frames[frame];
            let mut evidence = colour_evidence(image, &self.fields[frame], self.cells, self.limbs, &colours, &tiles);
            for (e, known) in evidence.iter_mut().zip(self.known.get(&frame).iter().flat_map(|k| k.data())) {
                match known {
                    Known::Creature => *e = LIMIT,
                    Known::Background => *e = -LIMIT,
                    Known::Nothing => {}
                }
            }
            take(frame, evidence)
        })
    }

    /// Stroke pixels whose colours agree with those of the drawn strokes, and for every frame and limb how large a
    /// share of the stroke they are: how far the track can be trusted there.
    fn agreement(&self, stage: Stage<'_>) -> Result<(Vec<Mask>, Vec<Vec<f32>>)> {
        let limbs = self.limbs.first.len() - 1;
        let found = self.with_evidence(Teacher::Drawn, stage, |frame, evidence| {
            let mut accepted = Mask::new(self.working.width, self.working.height);
            let (mut agreed, mut all) = (vec![0u32; limbs], vec![0u32; limbs]);
            for (index, &place) in self.fields[frame].data().iter().enumerate() {
                if !self.on_stroke(frame, place) {
                    continue;
                }
                let limb = usize::from(self.limbs.limb[usize::from(place.sample)]);
                let drawn = self.limbs.drawn[frame][limb];
                all[limb] += 1;
                if drawn || evidence[index] > 0.0 {
                    accepted.set(index % self.working.width, index / self.working.width, true);
                }
                agreed[limb] += u32::from(evidence[index] > 0.0);
            }
            let share = |l: usize| if all[l] == 0 { 1.0 } else { agreed[l] as f32 / all[l] as f32 };
            (accepted, (0..limbs).map(share).collect::<Vec<f32>>())
        })?;
        let (accepted, mut trust): (Vec<Mask>, Vec<Vec<f32>>) = found.into_iter().unzip();
        for limb in 0..limbs {
            // Colours that creature and background share cannot agree even where the stroke is right.
            let drawn = (0..trust.len()).filter(|&f| self.limbs.drawn[f][limb]);
            let best = drawn.map(|f| trust[f][limb]).fold(0.0f32, f32::max).max(0.1);
            for (frame, t) in trust.iter_mut().enumerate() {
                t[limb] = if self.limbs.drawn[frame][limb] { 1.0 } else { (t[limb] / best).min(1.0) };
            }
        }
        Ok((accepted, trust))
    }

    /// Limb radii from the colours that strokes and surroundings teach.
    fn radii(&self, accepted: &[Mask], stage: Stage<'_>) -> Result<Vec<[f32; 2]>> {
        let profiles = self.with_evidence(Teacher::Accepted(accepted), stage, |frame, evidence| {
            let mut profile = Profile::new(self.cells);
            for (&place, e) in self.fields[frame].data().iter().zip(evidence) {
                if let Some(cell) = self.cells.of(place) {
                    profile.add(cell, e);
                }
            }
            profile
        })?;
        let mut all = Profile::new(self.cells);
        profiles.iter().for_each(|p| all.merge(p));
        Ok(all.radii(self.limbs, self.working.frames.len()))
    }

    /// One pass over all frames.
    fn pass(
        &self,
        radii: &[[f32; 2]],
        trust: &[Vec<f32>],
        teacher: Teacher<'_>,
        stage: Stage<'_>,
    ) -> Result<Vec<Mask>> {
        let occupied = match teacher {
            Teacher::Masks(masks) => {
                self.each_frame(stage.part(0.0, 0.1), |f| occupancy(&masks[f], &self.fields[f], self.cells))?
            }
            _ => Vec::new(),
        };
        let reach = self.cells.reach;
        self.with_evidence(teacher, stage.part(0.1, 1.0), |frame, evidence| {
            let by_radius = |cell: usize| {
                let (sample, side, distance) = (cell / reach / 2, cell / reach % 2, (cell % reach) as f32);
                let r = radii[sample][side];
                ((r - distance - 0.5) / (SOFTNESS.0 * r + SOFTNESS.1)).clamp(-SURE, SURE)
            };
            let prior: Vec<f32> = if occupied.is_empty() {
                (0..self.limbs.len() * 2 * reach).map(by_radius).collect()
            } else {
                let chance = |cell: usize| 1.0 / (1.0 + (-by_radius(cell)).exp());
                let shares = carried(&occupied, frame, self.params.memory, |f| self.known.contains_key(&f), chance);
                shares
                    .iter()
                    .map(|&s| (s.clamp(1e-3, 0.999) / (1.0 - s.clamp(1e-3, 0.999))).ln().clamp(-SURE, SURE))
                    .collect()
            };
            let weighed = prior.iter().enumerate().map(|(cell, p)| {
                let limb = usize::from(self.limbs.limb[cell / reach / 2]);
                p * (DOUBTED + (1.0 - DOUBTED) * trust[frame][limb].powi(2))
            });
            self.cut(frame, &evidence, &weighed.collect::<Vec<f32>>())
        })
    }

    /// The best mask of a frame.
    fn cut(&self, frame: usize, evidence: &[f32], prior: &[f32]) -> Mask {
        let (width, height) = (self.working.width, self.working.height);
        let image = &self.working.frames[frame];
        let field = &self.fields[frame];
        let known = self.known.get(&frame);
        let known = |x: usize, y: usize| known.map_or(Known::Nothing, |k| k.get(x, y));
        let near = |x: usize, y: usize| self.cells.of(field.get(x, y));
        let mut problem = GridCut::new(width, height);
        let contrast = Contrast::of(image, |x, y| near(x, y).is_some());
        for y in 0..height {
            for x in 0..width {
                let own = near(x, y);
                if let Some(cell) = own {
                    let odds =
                        self.params.colour_weight * evidence[y * width + x] + self.params.shape_weight * prior[cell];
                    problem.add_terminal(x, y, (odds * UNIT) as i32);
                }
                match known(x, y) {
                    Known::Creature => problem.add_terminal(x, y, CERTAIN),
                    Known::Background => problem.add_terminal(x, y, -CERTAIN),
                    Known::Nothing => {}
                }
                for (to, dx, dy) in EDGES {
                    let (nx, ny) = (x.wrapping_add_signed(dx), y + dy);
                    if nx >= width || ny >= height {
                        continue;
                    }
                    let other = near(nx, ny);
                    if own.is_none() && other.is_none() {
                        continue;
                    }
                    let length = if dx != 0 && dy != 0 { std::f32::consts::SQRT_2 } else { 1.0 };
                    let weight = contrast.weight(image.get(x, y), image.get(nx, ny)) / length;
                    let cost = (self.params.edge_weight * weight * UNIT) as i32;
                    // What is out of reach is background: its edges are pulls towards it.
                    match (own.is_some(), other.is_some()) {
                        (true, true) => problem.set_edge(x, y, to, cost),
                        (true, false) => problem.add_terminal(x, y, -cost),
                        _ => problem.add_terminal(nx, ny, -cost),
                    }
                }
            }
        }
        problem.solve();
        let mask = Mask::from_fn(width, height, |x, y| problem.on_source_side(x, y));
        self.tidied(frame, &mask)
    }

    /// The mask without specks and pinholes, and without parts that no stroke passes through.
    fn tidied(&self, frame: usize, mask: &Mask) -> Mask {
        let mask = without_holes(mask, (mask.count() as f32 * HOLE_SHARE) as usize);
        let parts = parts(&mask);
        let mut kept: Vec<bool> = vec![false; parts.areas.len() + 1];
        let largest = parts.areas.iter().max().copied().unwrap_or(0);
        for (part, &area) in parts.areas.iter().enumerate() {
            kept[part + 1] = area as f32 >= ISLAND_SHARE * largest as f32;
        }
        for (index, place) in self.fields[frame].data().iter().enumerate() {
            let painted = self.known.get(&frame).is_some_and(|k| k.data()[index] == Known::Creature);
            if painted || (place.sample != NOWHERE && place.distance() <= STROKE_WIDTH) {
                kept[parts.labels.data()[index] as usize] = true;
            }
        }
        kept[0] = false;
        Mask::from_fn(mask.width(), mask.height(), |x, y| kept[parts.labels.get(x, y) as usize])
    }
}

/// Runs `work` for every frame side by side; results in order.
pub(super) fn each_frame<T: Send>(
    frames: usize,
    stage: Stage<'_>,
    work: impl Fn(usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let done: Vec<Result<T>> = (0..frames)
        .into_par_iter()
        .map(|frame| {
            stage.at(frame as f64 / frames as f64)?;
            work(frame)
        })
        .collect();
    done.into_iter().collect()
}

const EDGES: [(Neighbour, isize, usize); 4] =
    [(Neighbour::Right, 1, 0), (Neighbour::Below, 0, 1), (Neighbour::BelowRight, 1, 1), (Neighbour::BelowLeft, -1, 1)];

/// Contrast-sensitive edge weights: 1 between equal colours, falling with the squared difference relative to its mean
/// around the creature.
struct Contrast {
    table: Vec<f32>,
}

impl Contrast {
    fn of(image: &Grid<[u8; 3]>, near: impl Fn(usize, usize) -> bool) -> Self {
        let (mut sum, mut count) = (0u64, 0u64);
        for y in 1..image.height() {
            for x in 1..image.width() {
                if near(x, y) {
                    let here = image.get(x, y);
                    sum += u64::from(difference(here, image.get(x - 1, y)) + difference(here, image.get(x, y - 1)));
                    count += 2;
                }
            }
        }
        let mean = (sum as f32 / count.max(1) as f32).max(4.0);
        let largest = 3 * 255 * 255 / TABLE_STEP;
        let table = (0..=largest).map(|i| 0.05 + 0.95 * (-((i * TABLE_STEP) as f32) / (2.0 * mean)).exp()).collect();
        Self { table }
    }

    #[inline]
    fn weight(&self, a: [u8; 3], b: [u8; 3]) -> f32 {
        self.table[(difference(a, b) / TABLE_STEP as u32) as usize]
    }
}

/// Squared differences for one entry of the contrast table.
const TABLE_STEP: usize = 4;

fn difference(a: [u8; 3], b: [u8; 3]) -> u32 {
    a.iter().zip(b).map(|(&x, y)| u32::from(x.abs_diff(y)).pow(2)).sum()
}
