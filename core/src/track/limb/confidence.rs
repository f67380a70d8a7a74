//! How far a tracked place is to be trusted: the probability that it lies within 5 % of the limb's length of the truth.
//!
//! A logistic model of what the tracker knows about its own result. Its coefficients were fitted on rendered and drawn
//! animals with exact truth; they are shares of the limb's length and counts of frames, so no clip's size enters.

use glam::Vec2;

use super::pose_path::Candidate;

/// What is known of one vertex in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Evidence {
    /// Mean distance of the poses that would do nearly as well, as a share of the limb's length.
    pub(super) spread: f32,
    /// How badly the limb's looks fit here, about 0..=1.
    pub(super) misfit: f32,
    /// How far flow agreed on the whole way from the key frames, in 0..=1.
    pub(super) trust: f32,
    /// Place along the limb, from the end it hangs by, in 0..=1.
    pub(super) along: f32,
}

/// Cost beyond the best path's at which a pose counts a third.
const TEMPERATURE: f32 = 0.08;

/// The mean distance at each vertex between the chosen pose and all that would do nearly as well, in working pixels.
/// `costs` are those of the best paths through each candidate.
pub(super) fn spread(chosen: &[Vec2], candidates: &[Candidate], costs: &[f32]) -> Vec<f32> {
    let least = costs.iter().copied().fold(f32::INFINITY, f32::min);
    let weights: Vec<f32> = costs.iter().map(|c| (-(c - least) / TEMPERATURE).exp()).collect();
    let total: f32 = weights.iter().sum();
    (0..chosen.len())
        .map(|v| {
            let sum: f32 = candidates.iter().zip(&weights).map(|(c, w)| w * c.pose[v].distance(chosen[v])).sum();
            sum / total.max(1e-6)
        })
        .collect()
}

impl Evidence {
    /// The probability of being right, in 0..=1.
    pub(super) fn confidence(&self) -> f32 {
        let score = SPREAD * (LEAST_SPREAD + self.spread).ln()
            + MISFIT * self.misfit
            + TRUST * self.trust
            + ALONG * self.along
            + CONSTANT;
        1.0 / (1.0 + (-score).exp())
    }
}

const SPREAD: f32 = -0.54;
const LEAST_SPREAD: f32 = 0.005;
const MISFIT: f32 = -2.7;
const TRUST: f32 = 2.7;
const ALONG: f32 = 0.5;
const CONSTANT: f32 = -1.8;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn doubt_grows_with_spread_and_misfit_and_falls_with_trust() {
        let sure = Evidence { spread: 0.002, misfit: 0.1, trust: 0.9, along: 0.5 };
        assert!(sure.confidence() > 0.9, "{}", sure.confidence());
        for worse in
            [Evidence { spread: 0.3, ..sure }, Evidence { misfit: 0.5, ..sure }, Evidence { trust: 0.1, ..sure }]
        {
            assert!(worse.confidence() < sure.confidence());
        }
        assert!(Evidence { spread: 0.4, misfit: 0.6, trust: 0.0, ..sure }.confidence() < 0.2);
    }

    #[test]
    fn only_poses_that_cost_little_more_spread() {
        let candidate = |x: f32| Candidate { pose: vec![vec2(x, 0.0); 2], cost: 0.0, next: None, last: None };
        let (chosen, all) = (vec![vec2(0.0, 0.0); 2], [candidate(0.0), candidate(10.0)]);
        assert!(spread(&chosen, &all, &[1.0, 3.0])[0] < 0.01);
        assert!((spread(&chosen, &all, &[1.0, 1.0])[0] - 5.0).abs() < 1e-3);
    }
}
