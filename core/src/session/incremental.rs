//! Tracking a session again after an edit: only what the edit put out of date.

use super::document::{Inputs, Tracked};
use super::outdated::Outdated;
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::Motion;
use crate::rig::Rig;
use crate::track::{Earlier, Tracker};

/// A tracker that starts from what a session has already.
pub struct Incremental<'a> {
    /// Does the work.
    pub tracker: &'a dyn Tracker,
    /// What the session's user made.
    pub inputs: &'a Inputs,
    /// What was tracked last, from these inputs or from earlier ones.
    pub tracked: Option<&'a Tracked>,
}

impl std::fmt::Debug for Incremental<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Incremental").field("tracked", &self.tracked.is_some()).finish_non_exhaustive()
    }
}

impl Tracker for Incremental<'_> {
    /// The motion there is where it is up to date; else a new one that keeps of the old what still holds.
    fn track(&self, clip: &Clip, rig: &Rig, stage: Stage<'_>) -> Result<Motion> {
        let Some(Tracked { motion, inputs }) = self.tracked else { return self.tracker.track(clip, rig, stage) };
        if motion.frames != clip.info().frames || motion.fps != clip.info().fps {
            return self.tracker.track(clip, rig, stage);
        }
        let outdated = Outdated::between(inputs, self.inputs).limbs;
        let same_limbs = motion.tracks.iter().map(|t| &t.name).eq(rig.limbs.iter().map(|l| &l.label));
        if outdated.is_empty() && same_limbs {
            stage.at(1.0)?;
            return Ok((**motion).clone());
        }
        let of = |label: &String| outdated.iter().find(|o| o.label == *label).map_or(Vec::new(), |o| o.frames.clone());
        let outdated: Vec<_> = rig.limbs.iter().map(|limb| of(&limb.label)).collect();
        if outdated.iter().all(|frames| frames.iter().map(ExactSizeIterator::len).sum::<usize>() == motion.frames) {
            return self.tracker.track(clip, rig, stage);
        }
        self.tracker.retrack(clip, rig, Earlier { motion, outdated: &outdated }, stage)
    }
}
