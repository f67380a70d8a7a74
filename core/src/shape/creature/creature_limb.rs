//! What posing a finished creature needs to know of a limb: which bones carry it, what it hangs from, how long it is.

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::SettledPose;
use crate::rig::Side;

/// A limb of a creature. Its bones stand evenly along its stroke, from the end nearer to the root outward, each on the
/// axis and pointing along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CreatureLimb {
    /// The user's name for it, unique in the creature.
    pub label: String,
    /// Its side, where it is one of a pair.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<Side>,
    /// The other of the pair.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twin: Option<usize>,
    /// The limb it hangs from; none for one that holds a root.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<Hold>,
    /// Whether its strokes are drawn from the end away from the root.
    pub reversed: bool,
    /// Its first bone in the model; the others follow.
    pub first_bone: usize,
    /// How many bones it has, two at least.
    pub bones: usize,
    /// Its length when it lies in the image plane, in world units: nearly the longest that it was seen.
    pub length: f32,
    /// Its mean radius in the image plane, in world units.
    pub radius: f32,
    /// How far beyond its hip it stands from what it hangs from, in world units toward the viewer.
    pub offset: f32,
    /// How far each bone stands from the place on the limb's stroke that it belongs to, along the stroke and to its
    /// right as the image shows it, seen from the end nearer to the root: strokes are drawn where it is easy, axes lie
    /// in the middle. This is what is usual; empty for nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub settled: Vec<Vec2>,
    /// The same for poses that were seen.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub settled_poses: Vec<SettledPose>,
}

/// Where a limb hangs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hold {
    /// The limb that holds it.
    pub limb: usize,
    /// Whether at that limb's end away from the root, else at its start.
    pub at_end: bool,
}

impl CreatureLimb {
    /// Its bones in the model.
    pub fn bone_range(&self) -> std::ops::Range<usize> {
        self.first_bone..self.first_bone + self.bones
    }
}
