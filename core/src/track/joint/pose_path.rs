//! The cheapest path through the poses that every frame offers: looks against a steady motion.
//!
//! Second-order dynamic programming over pairs of poses of neighbouring frames, of which the cheapest are kept. A bone
//! is expected to go on turning as fast as it does, and to keep its length; a joint that nothing holds, to go on
//! straight.

use glam::Vec2;

use super::params::JointParams;

/// A chain's joints in one frame, and what they cost there.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) pose: Vec<Vec2>,
    pub(super) cost: f32,
}

/// What the path has to know of a chain.
pub(super) struct Motion<'a> {
    /// Of every bone, working pixels.
    pub(super) lengths: &'a [f32],
    pub(super) weights: &'a [f32],
    /// How far the chain's first joint usually moves, where nothing holds it.
    pub(super) free: Option<f32>,
    pub(super) params: &'a JointParams,
}

/// Bones shorter than this, in working pixels, are as free as bones of this length.
const SHORT: f32 = 10.0;

#[inline]
fn saturated(square: f32, reach: f32) -> f32 {
    square / (square + reach * reach)
}

impl Motion<'_> {
    /// Cost of going from one pose to the next.
    fn step(&self, from: &[Vec2], to: &[Vec2]) -> f32 {
        let p = self.params;
        let mut cost = 0.0;
        if let Some(unit) = self.free {
            cost += p.still * saturated((to[0] - from[0]).length_squared() / (unit * unit), p.still_reach);
        }
        for (k, (&length, &weight)) in self.lengths.iter().zip(self.weights).enumerate() {
            let unit = length.max(SHORT);
            let (was, is) = (from[k + 1] - from[k], to[k + 1] - to[k]);
            cost += weight * p.still * saturated((is - was).length_squared() / (unit * unit), p.still_reach);
            let grown = (is.length().max(1.0) / was.length().max(1.0)).ln();
            cost += weight * p.length * saturated(grown * grown, 0.5 * p.length_reach);
        }
        cost
    }

    /// Cost of going from the first pose through the second to the third.
    #[inline]
    fn turn(&self, first: &[Vec2], second: &[Vec2], third: &[Vec2]) -> f32 {
        let p = self.params;
        let mut cost = 0.0;
        if let Some(unit) = self.free {
            let change = third[0] - 2.0 * second[0] + first[0];
            cost += p.inertia * saturated(change.length_squared() / (unit * unit), p.inertia_reach);
        }
        for (k, (&length, &weight)) in self.lengths.iter().zip(self.weights).enumerate() {
            let unit = length.max(SHORT);
            let (a, b, c) = (first[k + 1] - first[k], second[k + 1] - second[k], third[k + 1] - third[k]);
            let change = (c - turned_on(a, b)).length_squared() / (unit * unit);
            cost += weight * p.inertia * saturated(change, p.inertia_reach);
        }
        cost
    }
}

/// Where a bone points next that pointed along `a` and now along `b`.
pub(super) fn turned_on(a: Vec2, b: Vec2) -> Vec2 {
    let (la, lb) = (a.length(), b.length());
    if la < 1e-3 || lb < 1e-3 {
        return b;
    }
    let turn = Vec2::new(a.dot(b), a.perp_dot(b)) / (la * lb);
    turn.rotate(b)
}

/// A pair of poses of neighbouring frames, and the cheapest way to it.
#[derive(Clone, Copy)]
struct State {
    before: u32,
    here: u32,
    cost: f32,
    from: u32,
}

/// The places in the lists of the cheapest path, and its cost. Every list has at least one pose.
pub(super) fn best_path(lists: &[Vec<Candidate>], motion: &Motion<'_>) -> (Vec<usize>, f32) {
    let cheapest =
        |list: &[Candidate]| (0..list.len()).min_by(|&a, &b| list[a].cost.total_cmp(&list[b].cost)).unwrap_or(0);
    let [first, second, rest @ ..] = lists else {
        return lists.first().map_or((Vec::new(), 0.0), |l| (vec![cheapest(l)], l[cheapest(l)].cost));
    };
    let mut columns: Vec<Vec<State>> = Vec::with_capacity(lists.len());
    let mut start = Vec::with_capacity(first.len() * second.len());
    for (i, a) in first.iter().enumerate() {
        for (j, b) in second.iter().enumerate() {
            let cost = a.cost + b.cost + motion.step(&a.pose, &b.pose);
            start.push(State { before: i as u32, here: j as u32, cost, from: 0 });
        }
    }
    columns.push(kept(start, motion.params.states));
    let (mut previous, mut current) = (first, second);
    for next in rest {
        let steps: Vec<f32> =
            current.iter().flat_map(|b| next.iter().map(|c| motion.step(&b.pose, &c.pose) + c.cost)).collect();
        let mut best: Vec<State> =
            vec![State { before: 0, here: 0, cost: f32::INFINITY, from: 0 }; current.len() * next.len()];
        for (s, state) in columns[columns.len() - 1].iter().enumerate() {
            let (a, b) = (&previous[state.before as usize].pose, &current[state.here as usize].pose);
            for (k, c) in next.iter().enumerate() {
                let at = state.here as usize * next.len() + k;
                let so_far = state.cost + steps[at];
                if so_far < best[at].cost {
                    let cost = so_far + motion.turn(a, b, &c.pose);
                    if cost < best[at].cost {
                        best[at] = State { before: state.here, here: k as u32, cost, from: s as u32 };
                    }
                }
            }
        }
        best.retain(|s| s.cost.is_finite());
        columns.push(kept(best, motion.params.states));
        (previous, current) = (current, next);
    }
    let last = &columns[columns.len() - 1];
    let mut at = (0..last.len()).min_by(|&a, &b| last[a].cost.total_cmp(&last[b].cost)).unwrap_or(0);
    let total = last[at].cost;
    let mut path = vec![last[at].here as usize];
    for column in columns.iter().rev() {
        path.push(column[at].before as usize);
        at = column[at].from as usize;
    }
    path.reverse();
    (path, total)
}

/// The cheapest states, in the order of their poses.
fn kept(mut states: Vec<State>, count: usize) -> Vec<State> {
    if states.len() > count {
        states.select_nth_unstable_by(count, |a, b| {
            a.cost.total_cmp(&b.cost).then((a.here, a.before).cmp(&(b.here, b.before)))
        });
        states.truncate(count);
        states.sort_unstable_by_key(|s| (s.here, s.before));
    }
    states
}
