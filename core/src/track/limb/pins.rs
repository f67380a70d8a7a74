//! Places of a limb that are known in a frame while the rest of it is not: poses that miss them cost, and poses are offered
//! that go through them.

use glam::Vec2;

use crate::geometry::polyline;

/// What missing a known place costs at most, and at which share of the limb's length it does.
const MISSED: f32 = 2.0;
const REACH: f32 = 0.15;
/// How much longer or shorter a limb may become to reach a known place.
const STRETCH: f32 = 1.5;

/// A place that is farther along takes the limb's end with it.
const NEAR_END: f32 = 0.8;

/// A place of a limb that is known in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::track) struct Pin {
    pub(in crate::track) limb: usize,
    pub(in crate::track) frame: usize,
    /// How far along the limb, as a share of its length, from the start of its stroke.
    pub(in crate::track) share: f32,
    /// In clip pixels.
    pub(in crate::track) at: Vec2,
}

impl Pin {
    /// Where a pose has the place.
    fn of(&self, pose: &[Vec2]) -> Vec2 {
        let along = self.share * (pose.len() - 1) as f32;
        let before = (along as usize).min(pose.len() - 2);
        pose[before].lerp(pose[before + 1], along - before as f32)
    }

    /// What a pose costs for missing it.
    pub(super) fn cost(&self, pose: &[Vec2]) -> f32 {
        let miss = self.of(pose).distance(self.at) / polyline::length(pose).max(1.0);
        MISSED * (miss / REACH).min(1.0)
    }

    /// The pose bent so that it goes through and its ends stay, but for an end that is near.
    pub(super) fn bent(&self, pose: &[Vec2]) -> Vec<Vec2> {
        let miss = self.at - self.of(pose);
        let last = (pose.len() - 1) as f32;
        let beyond = if self.share > NEAR_END { f32::INFINITY } else { 1.0 - self.share };
        let moved = |(i, p): (usize, &Vec2)| {
            let along = i as f32 / last;
            let past = (along - self.share).max(0.0) / beyond;
            *p + (along / self.share.max(0.05)).min(1.0 - past) * miss
        };
        pose.iter().enumerate().map(moved).collect()
    }

    /// The pose turned and stretched about the end it hangs by, or moved where it hangs by none, so that it goes through.
    pub(super) fn through(&self, pose: &[Vec2], hung: bool) -> Vec<Vec2> {
        let (root, here) = (pose[0], self.of(pose));
        let (from, to) = (here - root, self.at - root);
        if !hung || self.share < 0.2 || from.length() < 2.0 || to.length() < 2.0 {
            let shift = self.at - here;
            return pose.iter().enumerate().map(|(i, p)| if hung && i == 0 { *p } else { *p + shift }).collect();
        }
        let scale = (to.length() / from.length()).clamp(1.0 / STRETCH, STRETCH);
        let turn = Vec2::from_angle(from.angle_to(to)) * scale;
        pose.iter().map(|p| root + turn.rotate(*p - root)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn poses_are_offered_that_go_through() {
        let pose: Vec<Vec2> = (0..9).map(|i| vec2(10.0 * i as f32, 0.0)).collect();
        for share in [0.1, 0.5, 0.93, 1.0] {
            let pin = Pin { limb: 0, frame: 0, share, at: vec2(75.0 * share, 20.0 * share) };
            assert!(pin.cost(&pose) > 1.0 * share);
            let (turned, moved) = (pin.through(&pose, true), pin.through(&pose, false));
            for other in [&turned, &moved, &pin.bent(&pose)] {
                assert!(pin.cost(other) < 0.15, "{share}: {other:?}");
            }
            assert_eq!(turned[0], pose[0]);
            assert_eq!(moved[8] - moved[0], pose[8] - pose[0]);
        }
        let knee = Pin { limb: 0, frame: 0, share: 0.5, at: vec2(40.0, 25.0) }.bent(&pose);
        assert_eq!((knee[0], knee[4], knee[8]), (pose[0], vec2(40.0, 25.0), pose[8]));
        // Too far away for the limb to get there, or in one place: still finite.
        let far = Pin { limb: 0, frame: 0, share: 0.0, at: vec2(1e4, 1e4) };
        let point = vec![Vec2::ONE; 3];
        for p in [&pose, &point].into_iter().flat_map(|p| [far.through(p, true), far.through(p, false), far.bent(p)]) {
            assert!(p.iter().all(|p| p.is_finite()));
        }
        assert!(far.cost(&pose) == MISSED && far.cost(&point) == MISSED);
    }
}
