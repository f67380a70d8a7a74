//! The default segmenter: learned limb shapes, local colours, exact cuts.
//!
//! Masks and models are refined in turn. In the beginning only the strokes and what is far from all of them teach
//! colours; limb radii come from those colours and from contrast, over all frames. Limbs of these radii then teach
//! better colours, which give better radii and the first masks. Every later pass learns colours from the masks of the
//! last one, and carries those masks from frame to frame in limb coordinates.

use super::carried::{carried, occupancy};
use super::cut::cut;
use super::evidence::Evidence;
use super::limb_radius::{Radii, radii};
use super::scene::Scene;
use super::teaching::{Teacher, evidence};
use super::track_trust::agreement;
use crate::error::Result;
use crate::job::Stage;
use crate::raster::Mask;

/// How soft a limb's border is, as a share of its radius and in pixels.
const SOFTNESS: (f32, f32) = (0.2, 1.5);
/// Prior knowledge is never surer than this (natural logarithm of odds).
const SURE: f32 = 2.2;
/// The weight of a limb's shape where its track cannot be trusted at all.
const DOUBTED: f32 = 0.25;

/// How far evidence counts in the search for radii, against creature and for it, when only strokes have taught it and
/// later. Strokes show few of the creature's colours: that a colour is not among them says little.
const BY_STROKES: (f32, f32) = (-0.3, 0.6);
const BY_SHAPE: (f32, f32) = (-1.0, 1.0);

/// The creature in every frame, at working size.
pub(super) fn masks(scene: &Scene<'_>, stage: Stage<'_>) -> Result<Vec<Mask>> {
    let passes = scene.params.passes.max(1);
    let share = |p: usize| stage.part(p as f64 / (passes + 1) as f64, (p + 1) as f64 / (passes + 1) as f64);
    let first = share(0);
    let (accepted, trust) = agreement(scene, first.part(0.0, 0.2))?;
    let by_strokes = evidence(scene, Teacher::Accepted(&accepted), f32::INFINITY, first.part(0.2, 0.5))?;
    let rough = radii(scene, &by_strokes, BY_STROKES, first.part(0.5, 0.6))?;
    drop(by_strokes);
    let by_shape = evidence(scene, Teacher::Shape(&rough, &trust), f32::INFINITY, first.part(0.6, 0.9))?;
    let radii = radii(scene, &by_shape, BY_SHAPE, first.part(0.9, 1.0))?;
    let mut masks = pass(scene, &radii, &trust, &by_shape, None, share(1))?;
    drop(by_shape);
    for pass_number in 1..passes {
        let stage = share(pass_number + 1);
        let evidence = evidence(scene, Teacher::Masks(&masks), f32::INFINITY, stage.part(0.0, 0.5))?;
        masks = pass(scene, &radii, &trust, &evidence, Some(&masks), stage.part(0.5, 1.0))?;
    }
    Ok(masks)
}

/// One pass over all frames; `masks` are those of the last pass.
fn pass(
    scene: &Scene<'_>,
    radii: &Radii,
    trust: &[Vec<f32>],
    evidence: &[Evidence],
    masks: Option<&[Mask]>,
    stage: Stage<'_>,
) -> Result<Vec<Mask>> {
    let occupied = scene.each_frame(stage.part(0.0, 0.1), |frame| {
        let mask = masks.map(|m| &m[frame]).or_else(|| scene.painted.get(&frame));
        mask.map_or_else(Vec::new, |m| occupancy(m, &scene.fields[frame], scene.cells))
    })?;
    let reach = scene.cells.reach;
    scene.each_frame(stage.part(0.1, 1.0), |frame| {
        let by_radius = |cell: usize| {
            let (sample, side, distance) = (cell / reach / 2, cell / reach % 2, (cell % reach) as f32);
            let r = radii[sample][side];
            ((r - distance - 0.5) / (SOFTNESS.0 * r + SOFTNESS.1)).clamp(-SURE, SURE)
        };
        let chance = |cell: usize| 1.0 / (1.0 + (-by_radius(cell)).exp());
        let painted = |f: usize| scene.painted.contains_key(&f);
        let shares = carried(&occupied, scene.cells, frame, scene.params.memory, painted, chance);
        let odds = |share: f32| (share / (1.0 - share)).ln().clamp(-SURE, SURE);
        let prior = shares.iter().map(|&s| odds(s.clamp(1e-3, 0.999)));
        let weighed = prior.enumerate().map(|(cell, p)| {
            let limb = usize::from(scene.limbs.limb[cell / reach / 2]);
            p * (DOUBTED + (1.0 - DOUBTED) * trust[frame][limb].powi(2))
        });
        cut(scene, frame, &evidence[frame], &weighed.collect::<Vec<f32>>())
    })
}
