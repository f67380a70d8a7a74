//! What a change puts out of date: results are compared by what they were made of, so that an edit that is undone puts
//! nothing out of date.

use std::ops::Range;

use super::document::Inputs;
use crate::rig::Rig;
use crate::track::outdated_frames;

/// What was made of other inputs than the present ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outdated {
    /// The limbs whose tracks are, in the rig's order. Limbs that are joined to them may follow.
    pub limbs: Vec<OutdatedLimb>,
    /// Whether masks and creature are. Both learn from all frames, so that there is no smaller part of them.
    pub creature: bool,
}

/// A limb whose track is out of date.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutdatedLimb {
    /// Its label.
    pub label: String,
    /// The frames, rising and apart: from the key frames around each change, which still hold, to the change.
    pub frames: Vec<Range<usize>>,
}

impl Outdated {
    /// Whether everything is up to date.
    pub fn is_empty(&self) -> bool {
        self.limbs.is_empty() && !self.creature
    }

    /// What was made of `old` and is out of date for `new`.
    pub fn between(old: &Inputs, new: &Inputs) -> Self {
        if old == new {
            return Self::default();
        }
        let frames = frame_count(new);
        let same_clip = match (&old.clip, &new.clip) {
            (Some(old), Some(new)) => old.same_content(new),
            (None, None) => true,
            _ => false,
        };
        let all = !same_clip || old.rig.size != new.rig.size || !old.settings.same("track.", &new.settings);
        let nothing = Rig { size: new.rig.size, limbs: Vec::new(), keyframes: Vec::new() };
        let ranges = outdated_frames(if all { &nothing } else { &old.rig }, &new.rig, frames);
        let limbs = new.rig.limbs.iter().zip(ranges).filter(|(_, ranges)| !ranges.is_empty());
        let limbs = limbs.map(|(limb, frames)| OutdatedLimb { label: limb.label.clone(), frames }).collect();
        let creature = all
            || old.rig != new.rig
            || !old.settings.same("segment.", &new.settings)
            || !old.settings.same("creature.", &new.settings);
        Self { limbs, creature }
    }

    /// All that `inputs` have, for results that were never made.
    pub(super) fn all(inputs: &Inputs) -> Self {
        let none = Inputs { rig: Rig { limbs: Vec::new(), ..(*inputs.rig).clone() }.into(), ..inputs.clone() };
        Self { creature: true, ..Self::between(&none, inputs) }
    }
}

/// How many frames there are to track: the clip's, or as many as are drawn on.
fn frame_count(inputs: &Inputs) -> usize {
    let drawn = inputs.rig.keyframes.last().map_or(0, |k| k.frame.saturating_add(1));
    inputs.clip.as_ref().map_or(drawn, |clip| clip.frames)
}
