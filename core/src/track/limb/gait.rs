//! The gait of a limb: how many frames until it moves the same way again, and how much later its twin does.
//!
//! A leg that is hidden now was seen a stride ago, and its twin went the same way a part of a stride before or after:
//! what they showed there is worth trying here. The period is where the limb's places, taken from its joint, come back
//! nearest to what they were; a limb that never comes back has none.
//!
//! Known limits: a steady pace; no turning of the body between strides.

use glam::Vec2;

use super::crossings::as_other;
use super::median::median;
use crate::geometry::polyline;

/// The shortest period, in frames.
const SHORTEST: usize = 6;
/// Share of the frames that must be left to compare.
const COMPARED: f32 = 0.35;
/// A period's poses differ by less than this share of what poses differ by at any lag.
const AGREEMENT: f32 = 0.5;
/// A divisor of the best lag is the period if it fits nearly as well: up to this factor and this share of the length.
const AS_WELL: (f32, f32) = (1.2, 0.01);

/// A limb's cycle, in frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Gait {
    /// After so many it does the same again.
    period: usize,
    /// After so many its twin does the same.
    lag: Option<usize>,
}

impl Gait {
    /// The gait of the limb with `poses`, from its joint outward in every frame, and of its `twin` where it has one.
    pub(super) fn of(poses: &[Vec<Vec2>], twin: Option<&[Vec<Vec2>]>) -> Option<Self> {
        let compared = (poses.len() as f32 * COMPARED).ceil() as usize;
        let misses: Vec<f32> = (0..=poses.len().saturating_sub(compared)).map(|lag| miss(poses, poses, lag)).collect();
        let lows: Vec<usize> = (SHORTEST..misses.len().saturating_sub(1))
            .filter(|&lag| misses[lag] <= misses[lag - 1] && misses[lag] <= misses[lag + 1])
            .collect();
        let least = lows.iter().map(|&lag| misses[lag]).reduce(f32::min)?;
        let usual = median(misses[1..].to_vec());
        let period = lows
            .into_iter()
            .find(|&lag| misses[lag] <= AS_WELL.0 * least + AS_WELL.1)
            .filter(|&lag| misses[lag] < AGREEMENT * usual)?;
        let lag = twin.and_then(|twin| {
            let misses: Vec<f32> = (0..period).map(|lag| miss(poses, twin, lag)).collect();
            (0..period).min_by(|&a, &b| misses[a].total_cmp(&misses[b]))
        });
        Some(Self { period, lag })
    }

    /// What the limb did a stride before and after frame `f`, and its twin a lag away, hung at the limb's joint.
    pub(super) fn foretold(&self, poses: &[Vec<Vec2>], twin: Option<&[Vec<Vec2>]>, f: usize) -> Vec<Vec<Vec2>> {
        let own = [f.checked_sub(self.period), Some(f + self.period)].map(|g| poses.get(g?));
        let later = self.lag.map(|lag| f + lag);
        let others = [later, later.and_then(|g| g.checked_sub(self.period))].map(|g| twin?.get(g?));
        let here = |pose: &Vec<Vec2>| {
            let shift = poses[f][0] - pose[0];
            let moved: Vec<Vec2> = pose.iter().map(|p| *p + shift).collect();
            as_other(&moved, poses[f][0], poses[f].len())
        };
        own.into_iter().chain(others).flatten().map(here).collect()
    }
}

/// The median over frames of how far `later`, `lag` frames on, is from `earlier`, as a share of the limb's length.
fn miss(earlier: &[Vec<Vec2>], later: &[Vec<Vec2>], lag: usize) -> f32 {
    let gap = |(a, b): (&Vec<Vec2>, &Vec<Vec2>)| {
        let (n, m) = (a.len() - 1, b.len() - 1);
        let places: f32 = (1..=4).map(|k| (a[k * n / 4] - a[0]).distance(b[k * m / 4] - b[0])).sum();
        places / (4.0 * polyline::length(a)).max(1e-3)
    };
    median(earlier.iter().zip(later.iter().skip(lag)).map(gap).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    /// A leg that swings once in `period` frames, walking to the right.
    fn leg(frames: usize, period: f32, phase: f32) -> Vec<Vec<Vec2>> {
        (0..frames)
            .map(|f| {
                let angle = std::f32::consts::TAU * (f as f32 / period + phase);
                let (swing, knee) = (1.57 + 0.5 * angle.cos(), 0.4 * angle.sin().max(0.0));
                let root = vec2(40.0 + 3.0 * f as f32, 50.0);
                let middle = root + Vec2::from_angle(swing) * 40.0;
                let end = middle + Vec2::from_angle(swing + knee) * 40.0;
                vec![root, root.lerp(middle, 0.5), middle, middle.lerp(end, 0.5), end]
            })
            .collect()
    }

    #[test]
    fn the_period_and_the_twins_lag_are_found() {
        let (near, far) = (leg(60, 20.0, 0.0), leg(60, 20.0, -0.25));
        assert_eq!(Gait::of(&near, Some(&far)), Some(Gait { period: 20, lag: Some(5) }));
        assert_eq!(Gait::of(&far, Some(&near)), Some(Gait { period: 20, lag: Some(15) }));
    }

    #[test]
    fn a_hidden_leg_is_foretold_from_other_strides_and_from_its_twin() {
        let (truth, twin) = (leg(60, 20.0, 0.0), leg(60, 20.0, 0.5));
        let mut seen = truth.clone();
        let root = seen[30][0];
        seen[30] = (0..5).map(|i| root + 15.0 * i as f32).collect();
        let gait = Gait { period: 20, lag: Some(10) };
        assert_eq!(Gait::of(&seen, Some(&twin)), Some(gait));
        let foretold = gait.foretold(&seen, Some(&twin), 30);
        assert_eq!(foretold.len(), 4);
        for pose in foretold {
            assert!(pose.iter().zip(&truth[30]).all(|(p, q)| p.distance(*q) < 0.5));
        }
    }

    #[test]
    fn what_never_comes_back_has_no_gait() {
        let drifting: Vec<Vec<Vec2>> =
            (0..60).map(|f| vec![Vec2::ZERO, Vec2::from_angle(0.03 * f as f32) * 50.0]).collect();
        assert_eq!(Gait::of(&drifting, None), None);
        let still = vec![vec![Vec2::ZERO, vec2(0.0, 50.0)]; 60];
        assert_eq!(Gait::of(&still, None), None);
        for frames in 1..9 {
            assert_eq!(Gait::of(&leg(frames, 20.0, 0.0), None), None);
        }
    }
}
