//! What paths through lists of poses cost, one list a frame: exact, by dynamic programming (forward and backward).

use glam::Vec2;
use rayon::prelude::*;

use super::carry::Carried;
use super::params::SpaceTimeParams;
use crate::error::Result;
use crate::job::Stage;

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

/// The possible poses of one limb, frame by frame. Lists are not empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chain<'a> {
    pub(super) lists: &'a [Vec<Candidate>],
    /// Where the limb would go without moving of its own, in every frame.
    pub(super) rest: &'a [Vec2],
}

/// One or two limbs that are solved together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group<'a> {
    pub(super) first: Chain<'a>,
    pub(super) second: Option<Chain<'a>>,
    /// For every frame, for every candidate of the first limb and within it for every one of the second, what the two
    /// cost beyond their own costs. Empty for one limb.
    pub(super) together: &'a [Vec<f32>],
}

impl Group<'_> {
    pub(super) fn frames(&self) -> usize {
        self.first.lists.len()
    }

    pub(super) fn chains(&self) -> impl Iterator<Item = Chain<'_>> {
        [Some(self.first), self.second].into_iter().flatten()
    }

    /// How many candidates the limbs have in frame `f`.
    pub(super) fn counts(&self, f: usize) -> [usize; 2] {
        [self.first.lists[f].len(), self.second.map_or(1, |s| s.lists[f].len())]
    }

    /// The cost of every pair of candidates in frame `f`.
    pub(super) fn own(&self, f: usize) -> Vec<f32> {
        let first = self.first.lists[f].iter().map(|c| c.cost);
        match self.second {
            None => first.collect(),
            Some(second) => first
                .flat_map(|a| second.lists[f].iter().map(move |b| a + b.cost))
                .zip(&self.together[f])
                .map(|(own, both)| own + both)
                .collect(),
        }
    }
}

/// What is known of a group's paths, inertia aside.
#[derive(Clone, Debug)]
pub(super) struct Costs {
    /// For every frame and every pair of candidates, the cost of the best path through it.
    pub(super) through: Vec<Vec<f32>>,
    /// For every frame but the first and every limb, for every candidate there, the cost of coming from every one of
    /// the frame before.
    pub(super) steps: Vec<[Vec<f32>; 2]>,
}

/// The costs of a group's paths. The two limbs' steps are independent, so each is minimised on its own.
pub(super) fn costs_through(group: &Group<'_>, params: &SpaceTimeParams, stage: Stage<'_>) -> Result<Costs> {
    let frames = group.frames();
    let steps: Vec<[Vec<f32>; 2]> = (1..frames)
        .into_par_iter()
        .map(|f| [step_costs(&group.first, f, params), group.second.map_or(vec![0.0], |s| step_costs(&s, f, params))])
        .collect();
    let mut through = vec![group.own(0)];
    for f in 1..frames {
        stage.at(0.5 * f as f64 / frames as f64)?;
        let ([an, bn], [am, bm]) = (group.counts(f - 1), group.counts(f));
        let [first, second] = &steps[f - 1];
        let reached =
            min_plus(&through[f - 1], [an, bn], [am, bm], |i, k| first[k * an + i], |j, l| second[l * bn + j]);
        through.push(reached.into_iter().zip(group.own(f)).map(|(r, o)| r + o).collect());
    }
    let mut rest = vec![0.0f32; through[frames - 1].len()];
    for f in (1..frames).rev() {
        stage.at(1.0 - 0.5 * f as f64 / frames as f64)?;
        let ([an, bn], [am, bm]) = (group.counts(f - 1), group.counts(f));
        let [first, second] = &steps[f - 1];
        let after: Vec<f32> = rest.iter().zip(group.own(f)).map(|(r, o)| r + o).collect();
        through[f].iter_mut().zip(&rest).for_each(|(t, r)| *t += r);
        rest = min_plus(&after, [am, bm], [an, bn], |k, i| first[k * an + i], |l, j| second[l * bn + j]);
    }
    through[0].iter_mut().zip(&rest).for_each(|(t, r)| *t += r);
    Ok(Costs { through, steps })
}

/// `out[i, j] = min over k, l of cost[k, l] + a(k, i) + b(l, j)`.
fn min_plus(
    cost: &[f32],
    [ks, ls]: [usize; 2],
    [is, js]: [usize; 2],
    a: impl Fn(usize, usize) -> f32,
    b: impl Fn(usize, usize) -> f32,
) -> Vec<f32> {
    let mut half = vec![f32::INFINITY; is * ls];
    for i in 0..is {
        for k in 0..ks {
            let step = a(k, i);
            for l in 0..ls {
                half[i * ls + l] = half[i * ls + l].min(cost[k * ls + l] + step);
            }
        }
    }
    let mut out = vec![f32::INFINITY; is * js];
    for i in 0..is {
        for j in 0..js {
            out[i * js + j] = (0..ls).map(|l| half[i * ls + l] + b(l, j)).fold(f32::INFINITY, f32::min);
        }
    }
    out
}

/// The place and the value of the least; the first of equals.
pub(super) fn least(values: impl Iterator<Item = f32>) -> (usize, f32) {
    values.enumerate().fold((0, f32::INFINITY), |best, (i, v)| if v < best.1 { (i, v) } else { best })
}

/// For every candidate of frame `f`, the cost of coming from every one of the frame before.
fn step_costs(chain: &Chain<'_>, f: usize, params: &SpaceTimeParams) -> Vec<f32> {
    let (earlier, drift) = (&chain.lists[f - 1], chain.rest[f] - chain.rest[f - 1]);
    chain.lists[f].iter().flat_map(|b| earlier.iter().map(move |a| step_cost(a, b, params, drift))).collect()
}

pub(super) fn step_cost(a: &Candidate, b: &Candidate, params: &SpaceTimeParams, drift: Vec2) -> f32 {
    let n = a.pose.len();
    let length: f32 = a.pose.windows(2).map(|p| p[0].distance(p[1])).sum();
    let (flow_reach, still_reach) = (1.0 / (params.flow_reach * length), 1.0 / (params.still_reach * length));
    let mut sum = 0.0;
    for (carried, other) in [(&a.next, &b.pose), (&b.last, &a.pose)] {
        if let Some(carried) = carried {
            for v in 0..n {
                let miss = (carried.points[v].distance(other[v]) * flow_reach).min(1.0);
                sum += 0.5 * params.flow * carried.trust[v] * miss;
            }
        }
    }
    for v in 0..n {
        let moved = ((b.pose[v] - a.pose[v] - drift).length() * still_reach).min(1.0);
        sum += params.still * moved * moved;
    }
    sum / n as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Progress;
    use glam::vec2;

    const STILL: [Vec2; 4] = [Vec2::ZERO; 4];

    fn candidate(x: f32, cost: f32) -> Candidate {
        Candidate { pose: vec![vec2(0.0, 0.0), vec2(x, 100.0)], cost, next: None, last: None }
    }

    fn lists(shift: u32) -> Vec<Vec<Candidate>> {
        // Costs and places from a small multiplicative generator.
        let mut seed = 12_345u32 + shift;
        let mut next = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        (0..4).map(|_| (0..4).map(|_| candidate(80.0 * next(), 0.1 * next())).collect()).collect()
    }

    fn cost(lists: &[Vec<Candidate>], path: &[usize]) -> f32 {
        let own: f32 = path.iter().zip(lists).map(|(&i, l)| l[i].cost).sum();
        let params = SpaceTimeParams::default();
        let step = |f: usize| step_cost(&lists[f - 1][path[f - 1]], &lists[f][path[f]], &params, Vec2::ZERO);
        own + (1..lists.len()).map(step).sum::<f32>()
    }

    fn all_paths() -> impl Iterator<Item = Vec<usize>> + Clone {
        (0..256).map(|n| (0..4).map(|f| n >> (2 * f) & 3).collect())
    }

    #[test]
    fn costs_through_one_limbs_candidates_are_those_of_the_cheapest_paths() {
        let lists = lists(0);
        let group = Group { first: Chain { lists: &lists, rest: &STILL }, second: None, together: &[] };
        let through =
            costs_through(&group, &SpaceTimeParams::default(), Progress::new().whole()).expect("not cancelled").through;
        for f in 0..4 {
            for i in 0..4 {
                let best = all_paths().filter(|p| p[f] == i).map(|p| cost(&lists, &p)).fold(f32::INFINITY, f32::min);
                assert!((through[f][i] - best).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn costs_through_pairs_are_those_of_the_cheapest_pairs_of_paths() {
        let (a, b) = (lists(0), lists(7));
        // The same index for both is forbidden.
        let together: Vec<Vec<f32>> =
            (0..4).map(|_| (0..16).map(|k| if k / 4 == k % 4 { 5.0 } else { 0.0 }).collect()).collect();
        let chain = |lists| Chain { lists, rest: &STILL };
        let group = Group { first: chain(&a), second: Some(chain(&b)), together: &together };
        let through =
            costs_through(&group, &SpaceTimeParams::default(), Progress::new().whole()).expect("not cancelled").through;
        let mut best = vec![[f32::INFINITY; 16]; 4];
        let costs: Vec<(Vec<usize>, f32)> = all_paths()
            .map(|q| {
                let c = cost(&b, &q);
                (q, c)
            })
            .collect();
        for p in all_paths() {
            let own = cost(&a, &p);
            for (q, other) in costs.iter().filter(|(q, _)| p.iter().zip(q).all(|(i, j)| i != j)) {
                for f in 0..4 {
                    let least = &mut best[f][p[f] * 4 + q[f]];
                    *least = least.min(own + other);
                }
            }
        }
        for f in 0..4 {
            for k in (0..16).filter(|k| k / 4 != k % 4) {
                assert!((through[f][k] - best[f][k]).abs() < 1e-4);
            }
        }
    }
}
