//! What a change puts out of date: results are compared by what they were made of, so that an edit that is undone puts
//! nothing out of date.

use std::ops::Range;

use super::document::Inputs;
use crate::rig::{Limb, Rig, Stroke};

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
        let mut limbs = Vec::new();
        for (at, limb) in new.rig.limbs.iter().enumerate() {
            let was = old.rig.limbs.iter().position(|l| l.label == limb.label);
            let ranges = match was {
                Some(was) if !all && kinship(&old.rig, was) == kinship(&new.rig, at) => {
                    touched(&keys(&old.rig, was), &keys(&new.rig, at), frames)
                }
                _ => std::iter::once(0..frames).filter(|r| !r.is_empty()).collect(),
            };
            if !ranges.is_empty() {
                limbs.push(OutdatedLimb { label: limb.label.clone(), frames: ranges });
            }
        }
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

/// What trackers know of a limb beside its strokes: its side and its twin.
fn kinship(rig: &Rig, limb: usize) -> (Option<&Limb>, Option<&str>) {
    (rig.limbs.get(limb), rig.twin(limb).map(|twin| rig.limbs[twin].label.as_str()))
}

fn keys(rig: &Rig, limb: usize) -> Vec<(usize, &Stroke)> {
    rig.keys_of(limb).collect()
}

/// The frames whose track hangs on a key frame that differs.
fn touched(old: &[(usize, &Stroke)], new: &[(usize, &Stroke)], frames: usize) -> Vec<Range<usize>> {
    let at = |keys: &[(usize, &Stroke)], frame: usize| {
        keys.binary_search_by_key(&frame, |k| k.0).ok().map(|i| keys[i].1.points.clone())
    };
    let mut named: Vec<usize> = old.iter().chain(new).map(|k| k.0).collect();
    named.sort_unstable();
    named.dedup();
    let (kept, changed): (Vec<usize>, Vec<usize>) = named.into_iter().partition(|&f| at(old, f) == at(new, f));
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for frame in changed {
        let next = kept.partition_point(|&k| k < frame);
        let from = next.checked_sub(1).map_or(0, |before| kept[before].saturating_add(1));
        let to = kept.get(next).copied().unwrap_or(frames).min(frames);
        if from < to && ranges.last().is_none_or(|last| last.end <= from) {
            ranges.push(from..to);
        }
    }
    ranges
}
