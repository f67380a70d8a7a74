//! One limb's drawn poses in working pixels, ordered from the end it hangs by.

use glam::Vec2;

use super::solving_order::Turn;
use crate::rig::{Rig, Skeleton};

/// A limb as drawn on its key frames.
#[derive(Clone, Debug)]
pub(super) struct LimbKeys {
    /// The key frames, rising; at least one.
    pub(super) frames: Vec<usize>,
    /// The vertices on each.
    pub(super) poses: Vec<Vec<Vec2>>,
}

impl LimbKeys {
    pub(super) fn new(rig: &Rig, skeleton: &Skeleton, turn: Turn, scale: f32) -> Self {
        let (mut frames, mut poses) = (Vec::new(), Vec::new());
        for (frame, _) in rig.keys_of(turn.limb) {
            if let Some(drawn) = skeleton.drawn(rig, turn.limb, frame) {
                let mut pose: Vec<Vec2> = drawn.into_iter().map(|p| p * scale).collect();
                if turn.reversed {
                    pose.reverse();
                }
                frames.push(frame);
                poses.push(pose);
            }
        }
        Self { frames, poses }
    }

    /// The keys around `frame`: the last at or before it and the first at or after it.
    pub(super) fn around(&self, frame: usize) -> (Option<usize>, Option<usize>) {
        let before = self.frames.iter().rposition(|&k| k <= frame);
        let after = self.frames.iter().position(|&k| k >= frame);
        (before, after)
    }

    /// A value of the keys around `frame`, mixed by distance in time.
    pub(super) fn mixed<T>(&self, frame: usize, value: impl Fn(usize) -> T, mix: impl Fn(T, T, f32) -> T) -> T {
        match self.around(frame) {
            (Some(a), Some(b)) if a != b => {
                let share = (frame - self.frames[a]) as f32 / (self.frames[b] - self.frames[a]) as f32;
                mix(value(a), value(b), share)
            }
            (Some(a), _) | (None, Some(a)) => value(a),
            (None, None) => value(0),
        }
    }

    /// Edge lengths expected on `frame`.
    pub(super) fn lengths(&self, frame: usize) -> Vec<f32> {
        let of = |key: usize| self.poses[key].windows(2).map(|p| p[0].distance(p[1])).collect::<Vec<f32>>();
        self.mixed(frame, of, |a, b, t| a.iter().zip(&b).map(|(a, b)| a + (b - a) * t).collect())
    }

    /// How many vertices the limb has.
    pub(super) fn vertices(&self) -> usize {
        self.poses[0].len()
    }
}
