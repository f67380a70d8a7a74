//! What posing a finished creature needs to know of a limb: which bones carry it, what it hangs from, how long it is.

use glam::Vec2;
use serde::{Deserialize, Serialize};

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
    /// in the middle. Empty for nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub settled: Vec<Vec2>,
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

    /// Moves places along the limb, from the end nearer to the root, from its stroke to its axis, or `back`.
    pub(super) fn settle(&self, points: &mut [Vec2], back: bool) {
        let (Some(last), true) = (self.settled.len().checked_sub(1), points.len() > 1) else { return };
        let span = (points.len() - 1) as f32;
        let moved = points.iter().enumerate().map(|(i, p)| {
            let at = i as f32 / span * last as f32;
            let k = (at as usize).min(last);
            let offset = self.settled[k].lerp(self.settled[(k + 1).min(last)], at - k as f32);
            let way = direction(points, i) * if back { -1.0 } else { 1.0 };
            *p + way * offset.x + way.perp() * offset.y
        });
        let moved: Vec<Vec2> = moved.collect();
        points.copy_from_slice(&moved);
    }
}

/// Where a line points at one of its points, over a twentieth of its length to both sides.
pub(super) fn direction(points: &[Vec2], i: usize) -> Vec2 {
    let reach = (points.len() / 20).max(1);
    (points[(i + reach).min(points.len() - 1)] - points[i.saturating_sub(reach)]).normalize_or_zero()
}
