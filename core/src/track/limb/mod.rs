//! The built-in limb tracker. Base: Reinert 2016, section 3.5.

mod candidates;
mod limb_width;
mod params;
mod patch;
#[cfg(test)]
mod stage_set;
mod templates;
mod tree_dp;

pub use candidates::{Candidate, CostMap};
pub use params::{LimbParams, Method, PaperParams, TemplateParams};
pub use templates::{Detection, KeyTemplates, MatchImage};
pub use tree_dp::{TreeOptimum, tree_optimum};

use glam::Vec2;

use super::Tracker;
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::{Motion, Track, TrackFrame, TrackKind};
use crate::rig::{Rig, Skeleton};

/// Tracks limbs. (First floor: key frames joined by straight lines.)
#[derive(Clone, Debug, Default)]
pub struct LimbTracker {
    /// How.
    pub params: LimbParams,
}

impl Tracker for LimbTracker {
    fn track(&self, clip: &Clip, rig: &Rig, stage: Stage<'_>) -> Result<Motion> {
        let info = clip.info();
        rig.validate(Some(((info.width, info.height), info.frames)))?;
        stage.name("tracking")?;
        let skeleton = Skeleton::new(rig, self.params.spacing);
        let tracks = (0..rig.limbs.len()).map(|l| {
            let keys: Vec<(usize, Vec<Vec2>)> =
                rig.keys_of(l).filter_map(|(f, _)| Some((f, skeleton.drawn(rig, l, f)?))).collect();
            let frames = (0..info.frames).map(|f| {
                let after = keys.iter().position(|k| k.0 >= f).unwrap_or(keys.len() - 1);
                let before = keys.iter().rposition(|k| k.0 <= f).unwrap_or(0);
                let (a, b) = (&keys[before], &keys[after]);
                let t = if b.0 > a.0 { (f as f32 - a.0 as f32) / (b.0 - a.0) as f32 } else { 0.0 };
                TrackFrame::certain(a.1.iter().zip(&b.1).map(|(p, q)| p.lerp(*q, t)).collect())
            });
            Track { name: rig.limbs[l].label.clone(), kind: TrackKind::Stroke, frames: frames.collect() }
        });
        let tracks = tracks.collect();
        let bones = skeleton
            .limbs
            .iter()
            .enumerate()
            .filter_map(|(l, c)| Some((rig.limbs[c.parent?].label.clone(), rig.limbs[l].label.clone())));
        Ok(Motion { size: rig.size, fps: info.fps, frames: info.frames, tracks, bones: bones.collect() })
    }
}
