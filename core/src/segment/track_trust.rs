//! How far tracks can be trusted: whether the colours under a tracked stroke are those under the drawn one.

use super::scene::{STROKE_WIDTH, Scene};
use super::teaching::{Teacher, evidence};
use crate::error::Result;
use crate::job::Stage;
use crate::raster::Mask;

/// Stroke pixels whose colours agree with those of the drawn strokes, and for every frame and limb how large a
/// share of the stroke they are, between 0 and 1.
pub(super) fn agreement(scene: &Scene<'_>, stage: Stage<'_>) -> Result<(Vec<Mask>, Vec<Vec<f32>>)> {
    let limbs = scene.limbs.first.len() - 1;
    let evidence = evidence(scene, Teacher::Drawn, STROKE_WIDTH, stage.part(0.0, 0.9))?;
    let found = scene.each_frame(stage.part(0.9, 1.0), |frame| {
        let mut accepted = Mask::new(scene.working.width, scene.working.height);
        let (mut agreed, mut all) = (vec![0u32; limbs], vec![0u32; limbs]);
        for (index, &place) in scene.fields[frame].data().iter().enumerate() {
            if !scene.on_stroke(frame, place) {
                continue;
            }
            let (x, y) = (index % scene.working.width, index / scene.working.width);
            let limb = usize::from(scene.limbs.limb[usize::from(place.sample)]);
            let agrees = evidence[frame].at(x, y) > 0.0;
            all[limb] += 1;
            accepted.set(x, y, agrees || scene.limbs.drawn[frame][limb]);
            agreed[limb] += u32::from(agrees);
        }
        let share = |l: usize| if all[l] == 0 { 1.0 } else { agreed[l] as f32 / all[l] as f32 };
        (accepted, (0..limbs).map(share).collect::<Vec<f32>>())
    })?;
    let (accepted, mut trust): (Vec<Mask>, Vec<Vec<f32>>) = found.into_iter().unzip();
    for limb in 0..limbs {
        // Colours that creature and background share cannot agree even where the stroke is right. A painted frame
        // agrees with itself, which says nothing.
        let honest = |f: &usize| !scene.painted.contains_key(f);
        let drawn = (0..trust.len()).filter(honest).filter(|&f| scene.limbs.drawn[f][limb]);
        let any = (0..trust.len()).filter(honest).map(|f| trust[f][limb]).fold(0.0f32, f32::max);
        let best = drawn.map(|f| trust[f][limb]).reduce(f32::max).unwrap_or(any).max(0.1);
        for (frame, t) in trust.iter_mut().enumerate() {
            t[limb] = if scene.limbs.drawn[frame][limb] { 1.0 } else { (t[limb] / best).min(1.0) };
        }
    }
    Ok((accepted, trust))
}
