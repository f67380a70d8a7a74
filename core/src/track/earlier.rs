//! What an earlier run of a tracker still holds, so that an edit re-does only what depends on it.

use std::ops::Range;

use crate::motion::Motion;
use crate::rig::{Limb, Rig, Stroke};

/// An earlier motion, and where it no longer holds.
#[derive(Clone, Copy, Debug)]
pub struct Earlier<'a> {
    /// The motion; its tracks are found by their limbs' labels.
    pub motion: &'a Motion,
    /// For every limb of the rig the frames to track again, rising and apart. The frames beside them hold.
    pub outdated: &'a [Vec<Range<usize>>],
}

impl Earlier<'_> {
    /// For every limb of `rig` and every frame whether the earlier motion holds there. Limbs that it does not have
    /// hold nowhere, nor does any when the motion is of a clip of another size or length.
    pub fn holds(&self, rig: &Rig, frames: usize) -> Vec<Vec<bool>> {
        let same = self.motion.size == rig.size && self.motion.frames == frames;
        let limb = |(limb, label): (usize, &str)| {
            let known = same && self.motion.track(label).is_some_and(|t| t.frames.len() == frames);
            let mut holds = vec![known; frames];
            match self.outdated.get(limb) {
                Some(ranges) => {
                    for range in ranges {
                        let end = range.end.min(frames);
                        holds[range.start.min(end)..end].fill(false);
                    }
                }
                None => holds.fill(false),
            }
            holds
        };
        rig.limbs.iter().map(|l| l.label.as_str()).enumerate().map(limb).collect()
    }
}

/// For every limb of `new` the frames whose track hangs on something that is otherwise in `old`, rising and apart: from
/// the key frames around each change, which still hold, to the change. Limbs that `old` does not have hold nowhere.
pub fn outdated_frames(old: &Rig, new: &Rig, frames: usize) -> Vec<Vec<Range<usize>>> {
    let limb = |(at, limb): (usize, &Limb)| match old.limbs.iter().position(|l| l.label == limb.label) {
        Some(was) if kinship(old, was) == kinship(new, at) => touched(&keys(old, was), &keys(new, at), frames),
        _ => std::iter::once(0..frames).filter(|all| !all.is_empty()).collect(),
    };
    new.limbs.iter().enumerate().map(limb).collect()
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
