//! The default segmenter: learned limb shapes, local colours, exact cuts.
//!
//! Masks and models are refined in turn. In the beginning only the strokes and what is far from all of them teach
//! colours, and limb radii come from the colours over all frames; every later pass learns colours from the masks of
//! the last one, and carries those masks from frame to frame in limb coordinates. Every pass ends with a minimum cut
//! per frame over colour evidence, shape and contrast (Boykov and Jolly 2001; Rother, Kolmogorov and Blake 2004).

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::evidence::{Evidence, Lesson, Lessons, Tiles, colour_evidence};
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
const SURE: f32 = 2.2;

/// The weight of a limb's shape where its track cannot be trusted at all.
const DOUBTED: f32 = 0.25;

/// Least radius of a limb, as a share of the creature's extent.
const LEAST_RADIUS: f32 = 0.015;
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
    /// For every frame the columns and rows within which creature can be.
    windows: Vec<(Range<usize>, Range<usize>)>,
    /// What the user painted, at working size.
    known: BTreeMap<usize, Grid<Known>>,
    /// The masks of frames that are painted all over.
    painted: BTreeMap<usize, Mask>,
    /// Radii below this are not believed.
    least_radius: f32,
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
        let cells = Cells::new(limbs.len(), params.reach * limbs.extent());
        let known = painted.reduced(working.width, working.height);
        let prepared = each_frame(working.frames.len(), stage, |frame| {
            let field = stroke_field(limbs, frame, working.width, working.height);
            // Creature may be painted anywhere.
            let window = match known.contains_key(&frame) {
                true => (0..working.width, 0..working.height),
                false => window(&field, cells),
            };
            Ok((field, window))
        })?;
        let (fields, windows) = prepared.into_iter().unzip();
        let whole = known.iter().filter(|(_, k)| k.data().iter().all(|&p| p != Known::Nothing));
        let mask = |k: &Grid<Known>| Mask::from_fn(k.width(), k.height(), |x, y| k.get(x, y) == Known::Creature);
        let painted = whole.map(|(&frame, k)| (frame, mask(k))).collect();
        let least_radius = LEAST_RADIUS * limbs.extent();
        Ok(Self { working, limbs, params, cells, fields, windows, known, painted, least_radius })
    }

    /// The creature in every frame, at working size.
    pub(super) fn masks(&self, stage: Stage<'_>) -> Result<Vec<Mask>> {
        let passes = self.params.passes.max(1);
        let share = |p: usize| stage.part(p as f64 / (passes + 1) as f64, (p + 1) as f64 / (passes + 1) as f64);
        let (accepted, trust) = self.agreement(share(0).part(0.0, 0.4))?;
        // The first pass judges by the same colours as the radii.
        let mut evidence = self.evidence(Teacher::Accepted(&accepted), f32::INFINITY, share(0).part(0.4, 0.9))?;
        let radii = self.radii(&evidence, share(0).part(0.9, 1.0))?;
        let mut masks = self.pass(&radii, &trust, &evidence, None, share(1))?;
        for pass in 1..passes {
            let stage = share(pass + 1);
            evidence = self.evidence(Teacher::Masks(&masks), f32::INFINITY, stage.part(0.0, 0.5))?;
            masks = self.pass(&radii, &trust, &evidence, Some(&masks), stage.part(0.5, 1.0))?;
        }
        Ok(masks)
    }

    fn each_frame<T: Send>(&self, stage: Stage<'_>, work: impl Fn(usize) -> T + Sync) -> Result<Vec<T>> {
        each_frame(self.working.frames.len(), stage, |frame| Ok(work(frame)))
    }

    /// What a pixel teaches.
    fn lesson(&self, teacher: Teacher<'_>, frame: usize, x: usize, y: usize) -> Lesson {
        match self.known.get(&frame).map_or(Known::Nothing, |k| k.get(x, y)) {
            Known::Creature => return Lesson::Creature,
            Known::Background => return Lesson::Background,
            Known::Nothing => {}
        }
        if let Teacher::Masks(masks) = teacher {
            return if masks[frame].get(x, y) { Lesson::Creature } else { Lesson::Background };
        }
        let place = self.fields[frame].get(x, y);
        if self.cells.of(place).is_none() {
            return Lesson::Background;
        }
        if !self.on_stroke(frame, place) {
            return Lesson::Nothing;
        }
        let limb = usize::from(self.limbs.limb[usize::from(place.sample)]);
        let taught = match teacher {
            Teacher::Accepted(accepted) => accepted[frame].get(x, y),
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

    /// Evidence of every frame under the models that are taught, for pixels at most `within` from a stroke.
    fn evidence(&self, teacher: Teacher<'_>, within: f32, stage: Stage<'_>) -> Result<Vec<Evidence>> {
        let frames = self.working.frames.len();
        // Counts are whole numbers: the sum does not depend on how the frames are shared out.
        let all = (0..frames)
            .into_par_iter()
            .try_fold(
                || Lessons::new(self.limbs),
                |mut lessons, frame| {
                    stage.at(0.4 * frame as f64 / frames as f64)?;
                    self.teach(teacher, frame, &mut lessons);
                    Ok(lessons)
                },
            )
            .try_reduce(
                || Lessons::new(self.limbs),
                |mut a, b| {
                    a.merge(&b);
                    Ok(a)
                },
            )?;
        let colours = all.learn();
        self.each_frame(stage.part(0.4, 1.0), |frame| {
            let near = [frame.checked_sub(2), Some(frame), Some(frame + 2).filter(|&f| f < frames)];
            let lesson = |f: usize, x: usize, y: usize| self.lesson(teacher, f, x, y);
            let window = &self.windows[frame];
            let tiles = Tiles::learn(self.working, near.into_iter().flatten(), window, lesson);
            let place = |x: usize, y: usize| {
                let place = self.fields[frame].get(x, y);
                (self.cells.of(place).is_some() && place.distance() <= within).then_some(place)
            };
            let mut evidence =
                colour_evidence(&self.working.frames[frame], window, place, self.limbs, &colours, &tiles);
            if let Some(known) = self.known.get(&frame) {
                evidence.overrule(known.data());
            }
            evidence
        })
    }

    /// Counts what the pixels of a frame teach.
    fn teach(&self, teacher: Teacher<'_>, frame: usize, lessons: &mut Lessons) {
        let (image, field) = (&self.working.frames[frame], &self.fields[frame]);
        let (columns, rows) = &self.windows[frame];
        for y in 0..self.working.height {
            let row = image.row(y);
            if !rows.contains(&y) {
                row.iter().for_each(|&colour| lessons.add_background(colour));
                continue;
            }
            row[..columns.start].iter().for_each(|&colour| lessons.add_background(colour));
            row[columns.end..].iter().for_each(|&colour| lessons.add_background(colour));
            for x in columns.clone() {
                match self.lesson(teacher, frame, x, y) {
                    Lesson::Background => lessons.add_background(row[x]),
                    Lesson::Creature => lessons.add_creature(row[x], field.get(x, y), self.limbs),
                    Lesson::Nothing => {}
                }
            }
        }
    }

    /// Stroke pixels whose colours agree with those of the drawn strokes, and for every frame and limb how large a
    /// share of the stroke they are: how far the track can be trusted there.
    fn agreement(&self, stage: Stage<'_>) -> Result<(Vec<Mask>, Vec<Vec<f32>>)> {
        let limbs = self.limbs.first.len() - 1;
        let evidence = self.evidence(Teacher::Drawn, STROKE_WIDTH, stage.part(0.0, 0.9))?;
        let found = self.each_frame(stage.part(0.9, 1.0), |frame| {
            let mut accepted = Mask::new(self.working.width, self.working.height);
            let (mut agreed, mut all) = (vec![0u32; limbs], vec![0u32; limbs]);
            for (index, &place) in self.fields[frame].data().iter().enumerate() {
                if !self.on_stroke(frame, place) {
                    continue;
                }
                let (x, y) = (index % self.working.width, index / self.working.width);
                let limb = usize::from(self.limbs.limb[usize::from(place.sample)]);
                let agrees = evidence[frame].at(x, y) > 0.0;
                all[limb] += 1;
                accepted.set(x, y, agrees || self.limbs.drawn[frame][limb]);
                agreed[limb] += u32::from(agrees);
            }
            let share = |l: usize| if all[l] == 0 { 1.0 } else { agreed[l] as f32 / all[l] as f32 };
            (accepted, (0..limbs).map(share).collect::<Vec<f32>>())
        })?;
        let (accepted, mut trust): (Vec<Mask>, Vec<Vec<f32>>) = found.into_iter().unzip();
        for limb in 0..limbs {
            // Colours that creature and background share cannot agree even where the stroke is right. A painted frame
            // agrees with itself, which says nothing.
            let honest = |f: &usize| !self.painted.contains_key(f);
            let drawn = (0..trust.len()).filter(honest).filter(|&f| self.limbs.drawn[f][limb]);
            let any = (0..trust.len()).filter(honest).map(|f| trust[f][limb]).fold(0.0f32, f32::max);
            let best = drawn.map(|f| trust[f][limb]).reduce(f32::max).unwrap_or(any).max(0.1);
            for (frame, t) in trust.iter_mut().enumerate() {
                t[limb] = if self.limbs.drawn[frame][limb] { 1.0 } else { (t[limb] / best).min(1.0) };
            }
        }
        Ok((accepted, trust))
    }

    /// Limb radii from the evidence of all frames.
    fn radii(&self, evidence: &[Evidence], stage: Stage<'_>) -> Result<Vec<[f32; 2]>> {
        let frames = evidence.len();
        let all = (0..frames)
            .into_par_iter()
            .try_fold(
                || Profile::new(self.cells),
                |mut profile, frame| {
                    stage.at(frame as f64 / frames as f64)?;
                    // A few painted frames must be heard among many that only suppose.
                    let weight = if self.painted.contains_key(&frame) { 1 + frames as u32 / 4 } else { 1 };
                    let (columns, rows) = &self.windows[frame];
                    for y in rows.clone() {
                        for x in columns.clone() {
                            if let Some(cell) = self.cells.of(self.fields[frame].get(x, y)) {
                                profile.add(cell, evidence[frame].at(x, y), weight);
                            }
                        }
                    }
                    Ok(profile)
                },
            )
            .try_reduce(
                || Profile::new(self.cells),
                |mut a, b| {
                    a.merge(&b);
                    Ok(a)
                },
            )?;
        Ok(all.radii(self.limbs, frames, self.least_radius))
    }

    /// One pass over all frames; `masks` are those of the last pass.
    fn pass(
        &self,
        radii: &[[f32; 2]],
        trust: &[Vec<f32>],
        evidence: &[Evidence],
        masks: Option<&[Mask]>,
        stage: Stage<'_>,
    ) -> Result<Vec<Mask>> {
        let occupied = self.each_frame(stage.part(0.0, 0.1), |frame| {
            let mask = masks.map(|m| &m[frame]).or_else(|| self.painted.get(&frame));
            mask.map_or_else(Vec::new, |m| occupancy(m, &self.fields[frame], self.cells))
        })?;
        let reach = self.cells.reach;
        self.each_frame(stage.part(0.1, 1.0), |frame| {
            let by_radius = |cell: usize| {
                let (sample, side, distance) = (cell / reach / 2, cell / reach % 2, (cell % reach) as f32);
                let r = radii[sample][side];
                ((r - distance - 0.5) / (SOFTNESS.0 * r + SOFTNESS.1)).clamp(-SURE, SURE)
            };
            let chance = |cell: usize| 1.0 / (1.0 + (-by_radius(cell)).exp());
            let painted = |f: usize| self.painted.contains_key(&f);
            let shares = carried(&occupied, self.cells, frame, self.params.memory, painted, chance);
            let odds = |share: f32| (share / (1.0 - share)).ln().clamp(-SURE, SURE);
            let prior = shares.iter().map(|&s| odds(s.clamp(1e-3, 0.999)));
            let weighed = prior.enumerate().map(|(cell, p)| {
                let limb = usize::from(self.limbs.limb[cell / reach / 2]);
                p * (DOUBTED + (1.0 - DOUBTED) * trust[frame][limb].powi(2))
            });
            self.cut(frame, &evidence[frame], &weighed.collect::<Vec<f32>>())
        })
    }

    /// The best mask of a frame.
    fn cut(&self, frame: usize, evidence: &Evidence, prior: &[f32]) -> Mask {
        let image = &self.working.frames[frame];
        let field = &self.fields[frame];
        let (columns, rows) = self.windows[frame].clone();
        let (width, height) = (columns.len(), rows.len());
        let (left, top) = (columns.start, rows.start);
        let mut near = vec![FAR; width * height];
        for (line, y) in near.chunks_exact_mut(width.max(1)).zip(rows) {
            for (cell, &place) in line.iter_mut().zip(&field.row(y)[columns.clone()]) {
                *cell = self.cells.of(place).map_or(FAR, |c| c as u32);
            }
        }
        let contrast = Contrast::of(image, &self.windows[frame]);
        let closeness = EDGES.map(|(_, dx, dy)| if dx != 0 && dy != 0 { std::f32::consts::FRAC_1_SQRT_2 } else { 1.0 });
        let closeness = closeness.map(|c| c * self.params.edge_weight * UNIT);
        let mut problem = GridCut::new(width, height);
        for y in 0..height {
            for x in 0..width {
                let own = near[y * width + x];
                if own != FAR {
                    let odds = self.params.colour_weight * evidence.at(x + left, y + top)
                        + self.params.shape_weight * prior[own as usize];
                    problem.add_terminal(x, y, (odds * UNIT) as i32);
                }
                let here = image.get(x + left, y + top);
                for ((to, dx, dy), closeness) in EDGES.into_iter().zip(closeness) {
                    let (nx, ny) = (x.wrapping_add_signed(dx), y + dy);
                    if nx >= width || ny >= height {
                        continue;
                    }
                    let other = near[ny * width + nx];
                    if own == FAR && other == FAR {
                        continue;
                    }
                    let cost = (contrast.weight(here, image.get(nx + left, ny + top)) * closeness) as i32;
                    // What is out of reach is background: its edges are pulls towards it.
                    match (own != FAR, other != FAR) {
                        (true, true) => problem.set_edge(x, y, to, cost),
                        (true, false) => problem.add_terminal(x, y, -cost),
                        _ => problem.add_terminal(nx, ny, -cost),
                    }
                }
            }
        }
        if let Some(known) = self.known.get(&frame) {
            for y in 0..height {
                for x in 0..width {
                    match known.get(x + left, y + top) {
                        Known::Creature => problem.add_terminal(x, y, CERTAIN),
                        Known::Background => problem.add_terminal(x, y, -CERTAIN),
                        Known::Nothing => {}
                    }
                }
            }
        }
        problem.solve();
        let mut mask = Mask::new(self.working.width, self.working.height);
        for y in 0..height {
            for x in 0..width {
                if problem.on_source_side(x, y) {
                    mask.set(x + left, y + top, true);
                }
            }
        }
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

/// The columns and rows that have a cell.
fn window(field: &Grid<Place>, cells: Cells) -> (Range<usize>, Range<usize>) {
    let mut found: Option<(Range<usize>, Range<usize>)> = None;
    for y in 0..field.height() {
        for (x, &place) in field.row(y).iter().enumerate() {
            if cells.of(place).is_some() {
                let (columns, rows) = found.unwrap_or((x..x + 1, y..y + 1));
                found = Some((columns.start.min(x)..columns.end.max(x + 1), rows.start..y + 1));
            }
        }
    }
    found.unwrap_or((0..0, 0..0))
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
    scale: f32,
    table: Vec<f32>,
}

impl Contrast {
    fn of(image: &Grid<[u8; 3]>, (columns, rows): &(Range<usize>, Range<usize>)) -> Self {
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
    fn weight(&self, a: [u8; 3], b: [u8; 3]) -> f32 {
        self.table[((difference(a, b) as f32 * self.scale) as usize).min(TABLE)]
    }
}

/// Entries of the contrast table; beyond its last exponent edges weigh the least they can.
const TABLE: usize = 512;
const FALL: f32 = 6.0;
/// The weight of an edge across any contrast: outlines have a price of their own.
const FLOOR: f32 = 0.05;
/// No cell: out of reach.
const FAR: u32 = u32::MAX;

fn difference(a: [u8; 3], b: [u8; 3]) -> u32 {
    a.iter().zip(b).map(|(&x, y)| u32::from(x.abs_diff(y)).pow(2)).sum()
}
