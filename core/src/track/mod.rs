//! Trackers: from what the user marked on a few frames to a [`Motion`] over all of them.

pub mod flow;
pub mod limb;

use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::Motion;
use crate::rig::Rig;

/// Anything that turns key-frame strokes into strokes on every frame.
pub trait Tracker: Send + Sync {
    /// Tracks every limb of `rig` over `clip`. The motion has one track a limb, in the rig's order, with the same
    /// number of points in every frame, from the stroke's start to its end; key frames keep the drawn strokes.
    fn track(&self, clip: &Clip, rig: &Rig, stage: Stage<'_>) -> Result<Motion>;
}
