//! How thick limbs are: for every stroke sample and side a radius, found from all frames at once.
//!
//! Evidence for creature and the contrast across the limb are averaged over all frames in limb coordinates, where an
//! outline stays in place while the background passes. A radius gains the evidence from the stroke outward and the
//! contrast where it ends, and loses by being unlike limbs in general; radii of neighbouring samples are held together
//! by dynamic programming (the paper's radius votes, Reinert 2016, section 3.7.1, taken before the segmentation
//! instead of after it). Where colours and contrast say nothing, what limbs are like in general decides.
//!
//! Known limits: a limb that is never the nearest one over all of its thickness is judged by what is seen of it.

use rayon::prelude::*;

use super::evidence::Evidence;
use super::scene::Scene;
use super::stroke_field::{Cells, Place};
use crate::error::Result;
use crate::job::Stage;
use crate::raster::Grid;

/// Radii in working pixels, `[sample][side]`.
pub(super) type Radii = Vec<[f32; 2]>;

/// Least radius of a limb, as a share of the creature's extent.
const LEAST_RADIUS: f32 = 0.015;
/// Fixed point of summed evidence and contrast.
const UNIT: f32 = 1024.0;
/// Evidence that a pixel of creature must exceed: what is no better than chance does not widen a limb.
const BIAS: f32 = 0.14;
/// What a step of the radius between neighbouring samples costs, in evidence for one pixel.
const STIFFNESS: f32 = 0.6;
/// The radius of a sample is also judged by its twin's evidence, with this weight.
const TWIN_WEIGHT: f32 = 0.7;
/// What contrast at the radius gains that is as strong as contrast is on average around the creature.
const CONTRAST: f32 = 1.5;
/// Contrast in one frame counts no more than this, so that one hard shadow cannot outvote the rest.
const STRONGEST: f32 = 4.0;
/// The usual radius of a limb as a share of the geometric mean of its length and the creature's extent, what a radius
/// `e` times larger or smaller costs.
const USUAL: f32 = 0.12;
const UNUSUAL: f32 = 1.5;

/// Limb radii from the evidence of all frames, which counts no further than `clip` (low, high) at a pixel.
/// No radius is below a least one: a stroke is drawn inside its limb, however little the colours say.
pub(super) fn radii(scene: &Scene<'_>, evidence: &[Evidence], clip: (f32, f32), stage: Stage<'_>) -> Result<Radii> {
    let frames = evidence.len();
    let all = (0..frames)
        .into_par_iter()
        .try_fold(
            || Profile::new(scene.cells),
            |mut profile, frame| {
                stage.at(frame as f64 / frames as f64)?;
                profile.add(scene, frame, &evidence[frame], clip);
                Ok(profile)
            },
        )
        .try_reduce(
            || Profile::new(scene.cells),
            |mut a, b| {
                a.merge(&b);
                Ok(a)
            },
        )?;
    Ok(all.radii(scene, frames))
}

/// Evidence and contrast summed in limb coordinates.
struct Profile {
    cells: Cells,
    evidence: Vec<i64>,
    contrast: Vec<i64>,
    counts: Vec<u32>,
}

impl Profile {
    fn new(cells: Cells) -> Self {
        let n = cells.count();
        Self { cells, evidence: vec![0; n], contrast: vec![0; n], counts: vec![0; n] }
    }

    fn add(&mut self, scene: &Scene<'_>, frame: usize, evidence: &Evidence, clip: (f32, f32)) {
        // A few painted frames must be heard among many that only suppose.
        let weight = if scene.painted.contains_key(&frame) { 1 + scene.working.frames.len() as u32 / 4 } else { 1 };
        let (columns, rows) = &scene.windows[frame];
        let image = &scene.working.frames[frame];
        let mut contrasts = Vec::new();
        let mut mean = 0.0f64;
        for y in rows.clone() {
            for x in columns.clone() {
                let place = scene.fields[frame].get(x, y);
                let Some(cell) = self.cells.of(place) else { continue };
                self.evidence[cell] += (evidence.at(x, y).clamp(clip.0, clip.1) * UNIT) as i64 * i64::from(weight);
                self.counts[cell] += weight;
                let contrast = contrast_across(image, x, y, place, scene, frame);
                mean += f64::from(contrast);
                contrasts.push((cell, contrast));
            }
        }
        let scale = contrasts.len() as f32 / mean.max(1e-3) as f32;
        for (cell, contrast) in contrasts {
            self.contrast[cell] += ((contrast * scale).min(STRONGEST) * UNIT) as i64 * i64::from(weight);
        }
    }

    fn merge(&mut self, other: &Self) {
        self.evidence.iter_mut().zip(&other.evidence).for_each(|(a, b)| *a += b);
        self.contrast.iter_mut().zip(&other.contrast).for_each(|(a, b)| *a += b);
        self.counts.iter_mut().zip(&other.counts).for_each(|(a, b)| *a += b);
    }

    fn radii(&self, scene: &Scene<'_>, frames: usize) -> Radii {
        let limbs = scene.limbs;
        let least = LEAST_RADIUS * scene.extent;
        let mut radii = vec![[0.0; 2]; limbs.len()];
        let jobs: Vec<(usize, usize)> = (0..limbs.first.len() - 1)
            .flat_map(|l| [(l, 0), (l, 1)])
            .filter(|&(l, _)| !limbs.of(l).is_empty())
            .collect();
        let solved: Vec<Vec<usize>> = jobs.par_iter().map(|&(l, side)| self.solve(scene, l, side, frames)).collect();
        for (&(limb, side), solution) in jobs.iter().zip(solved) {
            for (sample, r) in limbs.of(limb).zip(solution) {
                radii[sample][side] = (r as f32 + 0.5).max(least);
            }
        }
        radii
    }

    /// Dynamic programming over the samples of one side of a limb.
    fn solve(&self, scene: &Scene<'_>, limb: usize, side: usize, frames: usize) -> Vec<usize> {
        let limbs = scene.limbs;
        let reach = self.cells.reach;
        let range = limbs.of(limb);
        let usual = USUAL * (limbs.length[limb] * scene.extent).sqrt();
        let unusual: Vec<f32> =
            (0..reach).map(|r| UNUSUAL * ((r as f32 + 0.5) / usual.max(1.0)).ln().powi(2)).collect();
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
            for ((v, g), u) in value.iter_mut().zip(&gain).zip(&unusual) {
                *v += g - u;
            }
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

    /// What each radius gains at a sample: the evidence from the stroke outward, and the contrast around the radius.
    fn gain(&self, sample: usize, side: usize, frames: usize) -> Vec<f32> {
        let reach = self.cells.reach;
        let start = (sample * 2 + side) * reach;
        // Places that belong to the limb in few frames only (another is nearer in the rest) say little.
        let share = |cell: usize| (self.counts[cell] as f32 / frames.max(1) as f32).min(1.0);
        let mean = |sums: &[i64], cell: usize| sums[cell] as f32 / UNIT / self.counts[cell].max(1) as f32;
        let contrast = |r: usize| mean(&self.contrast, start + r) * share(start + r);
        let mut sum = 0.0;
        (0..reach)
            .map(|r| {
                let before = sum;
                let cell = start + r;
                if self.counts[cell] > 0 {
                    sum += (mean(&self.evidence, cell) - BIAS) * share(cell);
                }
                before + CONTRAST * 0.5 * (contrast(r.saturating_sub(1)) + contrast(r))
            })
            .collect()
    }
}

/// How fast colours change at a pixel along the line from the stroke to it.
fn contrast_across(image: &Grid<[u8; 3]>, x: usize, y: usize, place: Place, scene: &Scene<'_>, frame: usize) -> f32 {
    let centre = glam::vec2(x as f32 + 0.5, y as f32 + 0.5);
    let across = (centre - scene.limbs.places[frame][usize::from(place.sample)]).normalize_or_zero();
    let (left, right) = (image.get(x.saturating_sub(1), y), image.get((x + 1).min(image.width() - 1), y));
    let (above, below) = (image.get(x, y.saturating_sub(1)), image.get(x, (y + 1).min(image.height() - 1)));
    let along = |c: usize| {
        let horizontal = f32::from(right[c]) - f32::from(left[c]);
        let vertical = f32::from(below[c]) - f32::from(above[c]);
        (horizontal * across.x + vertical * across.y).powi(2)
    };
    (along(0) + along(1) + along(2)).sqrt()
}
