//! The cheapest path through lists of poses, one list a frame: exact, by dynamic programming (Viterbi).

use glam::Vec2;

use super::carry::Carried;

/// A pose that a limb may have had in one frame.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) pose: Vec<Vec2>,
    /// How badly it fits the frame, about 0..=1.
    pub(super) cost: f32,
    /// Where flow takes it in the next and the last frame.
    pub(super) next: Option<Carried>,
    pub(super) last: Option<Carried>,
}

/// How the path weighs what it sees. Costs are of one vertex, at most.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathWeights {
    /// Of leaving the flow, where it is trusted.
    pub(super) flow: f32,
    /// Distance from the flow's target that counts in full, as a share of the limb's length.
    pub(super) flow_reach: f32,
    /// Of moving with respect to the joint it hangs by.
    pub(super) still: f32,
    /// Movement that counts in full, as a share of the limb's length.
    pub(super) still_reach: f32,
}

impl Default for PathWeights {
    fn default() -> Self {
        Self { flow: 0.25, flow_reach: 0.08, still: 0.15, still_reach: 0.5 }
    }
}

/// The index of the best candidate of every frame. Lists are not empty.
pub(super) fn best_path(lists: &[Vec<Candidate>], weights: &PathWeights, roots: Option<&[Vec2]>) -> Vec<usize> {
    let mut cost: Vec<f32> = lists[0].iter().map(|c| c.cost).collect();
    let mut from: Vec<Vec<usize>> = Vec::with_capacity(lists.len());
    for f in 1..lists.len() {
        let drift = roots.map_or(Vec2::ZERO, |r| r[f] - r[f - 1]);
        let (mut new, mut links) = (Vec::with_capacity(lists[f].len()), Vec::with_capacity(lists[f].len()));
        for b in &lists[f] {
            let best = lists[f - 1]
                .iter()
                .zip(&cost)
                .map(|(a, c)| c + step_cost(a, b, weights, drift))
                .enumerate()
                .min_by(|x, y| x.1.total_cmp(&y.1))
                .unwrap_or((0, 0.0));
            links.push(best.0);
            new.push(best.1 + b.cost);
        }
        from.push(links);
        cost = new;
    }
    let mut path = vec![0; lists.len()];
    let last = cost.iter().enumerate().min_by(|x, y| x.1.total_cmp(y.1)).map_or(0, |b| b.0);
    path[lists.len() - 1] = last;
    for f in (1..lists.len()).rev() {
        path[f - 1] = from[f - 1][path[f]];
    }
    path
}

fn step_cost(a: &Candidate, b: &Candidate, weights: &PathWeights, drift: Vec2) -> f32 {
    let n = a.pose.len();
    let length: f32 = a.pose.windows(2).map(|p| p[0].distance(p[1])).sum();
    let (flow_reach, still_reach) = (1.0 / (weights.flow_reach * length), 1.0 / (weights.still_reach * length));
    let mut sum = 0.0;
    for (carried, other) in [(&a.next, &b.pose), (&b.last, &a.pose)] {
        if let Some(carried) = carried {
            for v in 0..n {
                let miss = (carried.points[v].distance(other[v]) * flow_reach).min(1.0);
                sum += 0.5 * weights.flow * carried.trust[v] * miss;
            }
        }
    }
    for v in 0..n {
        let moved = ((b.pose[v] - a.pose[v] - drift).length() * still_reach).min(1.0);
        sum += weights.still * moved * moved;
    }
    sum / n as f32
}
