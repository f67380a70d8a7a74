//! Trackers: from what the user marked on a few frames to a [`Motion`] over all of them.

mod confidence;
mod earlier;
pub mod flow;
pub mod joint;
pub mod limb;
pub(crate) mod moving;
pub mod point;

pub use earlier::{Earlier, outdated_frames};

use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::Motion;
use crate::rig::{JointMarks, PointMarks, Rig};

/// Anything that turns key-frame strokes into strokes on every frame.
pub trait Tracker: Send + Sync {
    /// Tracks every limb of `rig` over `clip`. The motion has one track a limb, in the rig's order, with the same
    /// number of points in every frame, from the stroke's start to its end; key frames keep the drawn strokes.
    fn track(&self, clip: &Clip, rig: &Rig, stage: Stage<'_>) -> Result<Motion>;

    /// Tracks again what an edit put out of date, and keeps the rest of `earlier` as it is. A tracker that solves the
    /// clip as a whole tracks all of it, which is what this does unless a tracker knows better.
    fn retrack(&self, clip: &Clip, rig: &Rig, earlier: Earlier<'_>, stage: Stage<'_>) -> Result<Motion> {
        let _ = earlier;
        self.track(clip, rig, stage)
    }
}

/// Anything that turns marked joints into joints on every frame.
pub trait TrackJoints: Send + Sync {
    /// Tracks every joint of `marks` over `clip`: a motion with one track a joint, of one point, in the order of
    /// [`JointMarks::names`]. Where a joint is marked it is exactly at its mark.
    ///
    /// # Errors
    /// The marks are not of this clip or not valid, a frame cannot be read, or the caller cancelled.
    fn track_joints(&self, clip: &Clip, marks: &JointMarks, stage: Stage<'_>) -> Result<Motion>;

    /// Tracks again what other marks put out of date, and keeps the rest of `earlier` as it is. A tracker that solves
    /// the clip as a whole tracks all of it, which is what this does unless a tracker knows better.
    ///
    /// # Errors
    /// As for [`Self::track_joints`].
    fn retrack_joints(
        &self,
        clip: &Clip,
        marks: &JointMarks,
        earlier: joint::EarlierCapture<'_>,
        stage: Stage<'_>,
    ) -> Result<Motion> {
        let _ = earlier;
        self.track_joints(clip, marks, stage)
    }
}

/// Anything that turns marked points into points on every frame.
pub trait TrackPoints: Send + Sync {
    /// Tracks every point of `marks` over `clip`: a motion with one track a point, of one point, in the marks' order.
    /// Where a point is marked it is exactly at its mark.
    ///
    /// # Errors
    /// The marks are not of this clip or not valid, a frame cannot be read, or the caller cancelled.
    fn track_points(&self, clip: &Clip, marks: &PointMarks, stage: Stage<'_>) -> Result<Motion>;

    /// Tracks again what other marks put out of date, and keeps the rest of `earlier` as it is. A tracker that solves
    /// the clip as a whole tracks all of it, which is what this does unless a tracker knows better.
    ///
    /// # Errors
    /// As for [`Self::track_points`].
    fn retrack_points(
        &self,
        clip: &Clip,
        marks: &PointMarks,
        earlier: point::EarlierPoints<'_>,
        stage: Stage<'_>,
    ) -> Result<Motion> {
        let _ = earlier;
        self.track_points(clip, marks, stage)
    }
}
