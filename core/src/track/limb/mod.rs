//! The built-in limb tracker. Base: Reinert 2016, section 3.5.

pub(in crate::track) mod camera;
mod candidates;
mod carry;
mod chains;
mod claims;
mod confidence;
mod crossings;
mod drawn;
pub(in crate::track) mod footage;
mod foreground;
mod gait;
mod inertia;
mod kept;
mod limb_keys;
mod limb_width;
mod median;
mod paper;
mod params;
mod patch;
mod pose_path;
mod pose_search;
mod solving_order;
mod space_time;
#[cfg(test)]
mod space_time_tests;
#[cfg(test)]
mod stage_set;
mod strip;
mod templates;
mod tree_dp;
mod unexplained;

pub use candidates::{Candidate, CostMap};
pub use params::{LimbParams, Method, PaperParams, SpaceTimeParams, TemplateParams};
pub use templates::{Detection, KeyTemplates, MatchImage};
pub use tree_dp::{TreeOptimum, tree_optimum};

use super::{Earlier, Tracker};
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::{Motion, Track, TrackFrame, TrackKind};
use crate::rig::{Rig, Skeleton};
use footage::Footage;
use kept::Kept;
pub(in crate::track) use space_time::Trajectory;

/// Tracks limbs between key frames.
#[derive(Clone, Debug, Default)]
pub struct LimbTracker {
    /// How.
    pub params: LimbParams,
}

impl Tracker for LimbTracker {
    fn track(&self, clip: &Clip, rig: &Rig, stage: Stage<'_>) -> Result<Motion> {
        self.follow(clip, rig, None, stage)
    }

    /// The paper's method blends passes over the whole clip, so that it tracks all of it.
    fn retrack(&self, clip: &Clip, rig: &Rig, earlier: Earlier<'_>, stage: Stage<'_>) -> Result<Motion> {
        self.follow(clip, rig, Some(earlier).filter(|_| self.params.method == Method::SpaceTime), stage)
    }
}

impl LimbTracker {
    /// Where every limb of a rig in `footage` goes, which is of `clip` at its own size.
    pub(in crate::track) fn trajectories(
        &self,
        footage: &Footage,
        clip: &Clip,
        rig: &Rig,
        stage: Stage<'_>,
    ) -> Result<Vec<Trajectory>> {
        let info = clip.info();
        rig.validate(Some(((info.width, info.height), info.frames)))?;
        let spacing = self.params.spacing * LimbParams::scale(info.width as usize, info.height as usize);
        let skeleton = Skeleton::new(rig, spacing);
        space_time::solve_in(footage, clip, rig, &skeleton, None, &self.params.space_time, stage)
    }

    fn follow(&self, clip: &Clip, rig: &Rig, earlier: Option<Earlier<'_>>, stage: Stage<'_>) -> Result<Motion> {
        let info = clip.info();
        rig.validate(Some(((info.width, info.height), info.frames)))?;
        stage.name("tracking")?;
        let spacing = self.params.spacing * LimbParams::scale(info.width as usize, info.height as usize);
        let skeleton = Skeleton::new(rig, spacing);
        let kept = earlier.map(|earlier| Kept::of(&earlier, rig, &skeleton, info.frames));
        let trajectories = match self.params.method {
            Method::SpaceTime => space_time::solve(clip, rig, &skeleton, kept.as_ref(), &self.params, stage)?,
            Method::Paper => paper::solve(clip, rig, &skeleton, &self.params, stage)?,
        };
        let tracks = trajectories.into_iter().enumerate().map(|(l, trajectory)| Track {
            name: rig.limbs[l].label.clone(),
            kind: TrackKind::Stroke,
            frames: frames_of(rig, &skeleton, l, trajectory, kept.as_ref()),
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

/// The trajectory as track frames; key frames get exactly what was drawn, and kept frames what they had.
fn frames_of(
    rig: &Rig,
    skeleton: &Skeleton,
    limb: usize,
    trajectory: Trajectory,
    kept: Option<&Kept>,
) -> Vec<TrackFrame> {
    let Trajectory { poses, visible, confidence } = trajectory;
    let tracked = poses.into_iter().zip(visible).zip(confidence).enumerate();
    tracked
        .map(|(f, ((points, visible), confidence))| {
            if let Some(drawn) = skeleton.drawn(rig, limb, f) {
                return TrackFrame::certain(drawn);
            }
            let kept = kept.and_then(|kept| kept.limb(limb)[f].clone());
            kept.unwrap_or(TrackFrame { points, visible, confidence })
        })
        .collect()
}
