//! The part of an earlier motion that an edit leaves standing, as the space-time tracker needs it.
//!
//! A limb whose joint moves moves too, and a pair is solved together: what is out of date of one limb is so of those
//! that hang on it and of its twin. Kept frames enter the search as frames with one pose each, like key frames, so
//! that what is tracked anew meets them without a jump.

use super::solving_order::{groups, solving_order};
use crate::geometry::polyline;
use crate::motion::TrackFrame;
use crate::rig::{Rig, Skeleton};
use crate::track::Earlier;

/// Frames around a range that are looked at, too: its ends are judged by where flow takes them.
const MARGIN: usize = 1;

/// For every limb the frames that stay as they are.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    /// Per limb and frame: what stands there, from the stroke's start to its end in clip pixels.
    limbs: Vec<Vec<Option<TrackFrame>>>,
}

impl Kept {
    /// What stands of `earlier` for a clip of `frames` frames.
    pub(super) fn of(earlier: &Earlier<'_>, rig: &Rig, skeleton: &Skeleton, frames: usize) -> Self {
        let mut holds = earlier.holds(rig, frames);
        for group in groups(rig, &solving_order(rig, skeleton)) {
            let leading = group.iter().flat_map(|turn| [Some(turn.limb), turn.from.map(|f| f.0)]).flatten();
            let all: Vec<bool> = leading
                .fold(vec![true; frames], |all, limb| all.iter().zip(&holds[limb]).map(|(a, b)| *a && *b).collect());
            group.iter().for_each(|turn| holds[turn.limb].clone_from(&all));
        }
        let limb = |(limb, holds): (usize, Vec<bool>)| {
            let track = earlier.motion.track(&rig.limbs[limb].label);
            let count = skeleton.limbs[limb].vertices.len();
            let frame = |(f, holds): (usize, bool)| {
                let frame = track?.frames.get(f).filter(|_| holds)?;
                Some(if frame.points.len() == count { frame.clone() } else { resampled(frame, count) })
            };
            holds.into_iter().enumerate().map(frame).collect()
        };
        Self { limbs: holds.into_iter().enumerate().map(limb).collect() }
    }

    /// What stands of a limb, frame by frame.
    pub(super) fn limb(&self, limb: usize) -> &[Option<TrackFrame>] {
        &self.limbs[limb]
    }

    /// The frames of which anything is to be known: those that are tracked again, and those beside them.
    pub(super) fn looked_at(&self, frames: usize) -> Vec<bool> {
        let mut looked_at = vec![false; frames];
        for f in (0..frames).filter(|&f| self.limbs.iter().any(|l| l[f].is_none())) {
            looked_at[f.saturating_sub(MARGIN)..(f + MARGIN + 1).min(frames)].fill(true);
        }
        looked_at
    }
}

/// The frame with another number of points: every point is as visible and as certain as the nearest old one.
fn resampled(frame: &TrackFrame, count: usize) -> TrackFrame {
    let last = frame.points.len().saturating_sub(1);
    let near = |i: usize| (i * last + (count - 1) / 2) / (count - 1).max(1);
    TrackFrame {
        points: polyline::resample(&frame.points, count),
        visible: (0..count).map(|i| frame.visible[near(i)]).collect(),
        confidence: (0..count).map(|i| frame.confidence[near(i)]).collect(),
    }
}

/// What stands of one limb in working pixels, from the end it hangs by; empty where all frames are tracked.
#[derive(Clone, Debug, Default)]
pub(super) struct KeptLimb(Vec<Option<TrackFrame>>);

impl KeptLimb {
    pub(super) fn new(kept: &[Option<TrackFrame>], reversed: bool, scale: f32) -> Self {
        let frame = |kept: &TrackFrame| {
            let mut frame = kept.clone();
            frame.points.iter_mut().for_each(|p| *p *= scale);
            if reversed {
                frame.points.reverse();
                frame.visible.reverse();
                frame.confidence.reverse();
            }
            frame
        };
        Self(kept.iter().map(|kept| kept.as_ref().map(frame)).collect())
    }

    /// What stands on frame `f`.
    pub(super) fn at(&self, f: usize) -> Option<&TrackFrame> {
        self.0.get(f)?.as_ref()
    }

    /// Whether frame `f` and those beside it stand, so that nothing depends on how well its pose fits.
    pub(super) fn surrounds(&self, f: usize) -> bool {
        let end = (f + MARGIN + 1).min(self.0.len());
        f < end && self.0[f.saturating_sub(MARGIN)..end].iter().all(Option::is_some)
    }

    /// Whether every frame stands.
    pub(super) fn is_whole(&self) -> bool {
        !self.0.is_empty() && self.0.iter().all(Option::is_some)
    }
}
