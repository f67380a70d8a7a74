//! The cheapest path of one limb or a pair when changing one's motion costs, too.
//!
//! Two legs that pass each other look alike where they meet; what tells passing from bouncing off is that a leg goes on
//! as it went. Of three frames in a row the change of motion is charged, which makes the search one of second order: it
//! goes over pairs of successive states. It is exact (Viterbi) over the states that survive a first, exact pass without
//! inertia, see [`costs_through`]: the cheapest that differ.
//!
//! Known limit: time grows with the cube of the states kept.

use glam::Vec2;
use rayon::prelude::*;

use super::params::SpaceTimeParams;
use super::pose_path::{Chain, Costs, Group, costs_through, least};
use crate::error::Result;
use crate::geometry::polyline;
use crate::job::Stage;

/// The candidate of every limb of the group in one frame; the second is 0 where there is one limb.
type State = [usize; 2];

/// The best path: for every limb of the group the index of its candidate in every frame.
pub(super) fn best_path(group: &Group<'_>, params: &SpaceTimeParams, stage: Stage<'_>) -> Result<Vec<Vec<usize>>> {
    let frames = group.frames();
    let costs = costs_through(group, params, stage.part(0.0, 0.4))?;
    let states: Vec<Vec<State>> =
        (0..frames).into_par_iter().map(|f| kept_states(group, f, &costs.through[f], params)).collect();
    let own = |f: usize| {
        let (own, columns) = (group.own(f), group.counts(f)[1]);
        states[f].iter().map(|s| own[s[0] * columns + s[1]]).collect::<Vec<f32>>()
    };
    // value[a * m + b]: the cheapest path that ends with state a of one frame and state b of the next.
    let mut value = own(0);
    let mut links: Vec<Vec<u16>> = Vec::with_capacity(frames);
    for f in 1..frames {
        stage.at(0.4 + 0.6 * f as f64 / frames as f64)?;
        let (n, m) = (states[f - 1].len(), states[f].len());
        let steps = steps(group, f, [&states[f - 1], &states[f]], &own(f), &costs);
        if f == 1 {
            value = steps.iter().enumerate().map(|(s, c)| c + value[s / m]).collect();
            continue;
        }
        let bends: Vec<Bends> = group
            .chains()
            .enumerate()
            .map(|(limb, chain)| {
                Bends::new(&chain, f, &[0, 1, 2].map(|k| states[f - 2 + k].iter().map(|s| s[limb]).collect()), params)
            })
            .collect();
        let rows: Vec<(Vec<f32>, Vec<u16>)> = (0..n)
            .into_par_iter()
            .map(|a| {
                let (mut best, mut link) = (vec![f32::INFINITY; m], vec![0u16; m]);
                let mut cost = vec![0.0f32; m];
                let mut before: Vec<(f32, u16)> =
                    (0..states[f - 2].len()).map(|p| (value[p * n + a], p as u16)).collect();
                before.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let mut worst = f32::INFINITY;
                for (reached, p) in before {
                    // Bends cost nothing at best, so the rest is no cheaper.
                    if reached >= worst {
                        break;
                    }
                    match bends.as_slice() {
                        [first, second] => {
                            let ((u, places), (v, others)) = (first.from(p.into(), a), second.from(p.into(), a));
                            for (cost, (&i, &j)) in cost.iter_mut().zip(places.iter().zip(others)) {
                                *cost = reached + u[i] + v[j];
                            }
                        }
                        alone => {
                            for (u, places) in alone.iter().map(|bend| bend.from(p.into(), a)) {
                                cost.iter_mut().zip(places).for_each(|(cost, &i)| *cost = reached + u[i]);
                            }
                        }
                    }
                    worst = 0.0;
                    for ((best, link), cost) in best.iter_mut().zip(&mut link).zip(&cost) {
                        let better = cost < best;
                        *best = if better { *cost } else { *best };
                        *link = if better { p } else { *link };
                        worst = if *best > worst { *best } else { worst };
                    }
                }
                best.iter_mut().zip(&steps[a * m..]).for_each(|(b, step)| *b += step);
                (best, link)
            })
            .collect();
        let (values, link): (Vec<Vec<f32>>, Vec<Vec<u16>>) = rows.into_iter().unzip();
        value = values.concat();
        links.push(link.concat());
    }
    let last = least(value.iter().copied()).0;
    let columns = states[frames - 1].len();
    let mut path = vec![last; frames];
    if frames > 1 {
        (path[frames - 2], path[frames - 1]) = (last / columns, last % columns);
    }
    for f in (2..frames).rev() {
        path[f - 2] = usize::from(links[f - 2][path[f - 1] * states[f].len() + path[f]]);
    }
    let of = |limb: usize| (0..frames).map(|f| states[f][path[f]][limb]).collect();
    Ok((0..group.chains().count()).map(of).collect())
}

/// The states kept of frame `f`: the cheapest, no two of them the same by sight.
fn kept_states(group: &Group<'_>, f: usize, through: &[f32], params: &SpaceTimeParams) -> Vec<State> {
    let columns = group.counts(f)[1];
    let mut order: Vec<usize> = (0..through.len()).collect();
    let cheaper = |a: &usize, b: &usize| through[*a].total_cmp(&through[*b]).then(a.cmp(b));
    let reach = |pose: &Vec<Vec2>| params.same * polyline::length(pose) * pose.len() as f32;
    let reaches: Vec<Vec<f32>> =
        group.chains().map(|chain| chain.lists[f].iter().map(|c| reach(&c.pose)).collect()).collect();
    let alike = |a: &State, b: &State| {
        group.chains().enumerate().all(|(limb, chain)| {
            let ([p, q], most) = ([a[limb], b[limb]].map(|c| &chain.lists[f][c].pose), reaches[limb][a[limb]]);
            let mut apart = 0.0;
            let mut near = |(p, q): (&Vec2, &Vec2)| {
                apart += p.distance(*q);
                apart < most
            };
            // From the free end, where poses differ most.
            a[limb] == b[limb] || p.iter().zip(q).rev().all(&mut near)
        })
    };
    let most = params.states.clamp(1, usize::from(u16::MAX));
    let mut kept: Vec<State> = Vec::new();
    // Put in order only as far as it is gone through.
    let mut rest = order.as_mut_slice();
    while !rest.is_empty() && kept.len() < most {
        let next = (2 * most).min(rest.len());
        if next < rest.len() {
            rest.select_nth_unstable_by(next, cheaper);
        }
        let (cheapest, dearer) = rest.split_at_mut(next);
        cheapest.sort_unstable_by(cheaper);
        for state in cheapest.iter().map(|s| [s / columns, s % columns]) {
            if kept.len() < most && !kept.iter().any(|k| alike(k, &state)) {
                kept.push(state);
            }
        }
        rest = dearer;
    }
    kept
}

/// The cost of every step from a state before to a state of frame `f`, with what that one costs itself.
fn steps(group: &Group<'_>, f: usize, states: [&[State]; 2], own: &[f32], costs: &Costs) -> Vec<f32> {
    let ([before, here], counts, tables) = (states, group.counts(f - 1), &costs.steps[f - 1]);
    let limbs = group.chains().count();
    before
        .iter()
        .flat_map(|from| {
            here.iter().zip(own).map(move |(to, own)| {
                (0..limbs).fold(*own, |cost, limb| cost + tables[limb][to[limb] * counts[limb] + from[limb]])
            })
        })
        .collect()
}

/// Places along a limb at which its change of motion is looked at.
const SIGHTS: usize = 6;

/// What one limb's change of motion costs, for every three states of successive frames.
struct Bends {
    /// For each of the three frames, every state's row among the poses that differ.
    rows: [Vec<usize>; 3],
    counts: [usize; 3],
    table: Vec<f32>,
}

impl Bends {
    /// Of the frames `f - 2`, `f - 1` and `f`; `used` are the limb's candidates in the states there.
    fn new(chain: &Chain<'_>, f: usize, used: &[Vec<usize>; 3], params: &SpaceTimeParams) -> Self {
        let distinct = used.clone().map(|mut candidates| {
            candidates.sort_unstable();
            candidates.dedup();
            candidates
        });
        let rows = [0, 1, 2].map(|k| used[k].iter().map(|c| distinct[k].partition_point(|d| d < c)).collect());
        let [first, second, third] = [0, 1, 2].map(|k| {
            let frame = f - 2 + k;
            let root = chain.rest[frame];
            let sights = |&c: &usize| -> [Vec2; SIGHTS] {
                let pose = &chain.lists[frame][c].pose;
                std::array::from_fn(|i| pose[(i + 1) * (pose.len() - 1) / SIGHTS] - root)
            };
            distinct[k].iter().map(sights).collect::<Vec<_>>()
        });
        let reach = 1.0 / (params.inertia_reach * polyline::length(&chain.lists[f][0].pose)).max(1e-6);
        let weight = params.inertia / SIGHTS as f32;
        let mut table = Vec::with_capacity(first.len() * second.len() * third.len());
        for a in &first {
            for b in &second {
                let foretold: [Vec2; SIGHTS] = std::array::from_fn(|i| 2.0 * b[i] - a[i]);
                let miss = |c: &[Vec2; SIGHTS]| -> f32 {
                    foretold.iter().zip(c).map(|(x, y)| (x.distance(*y) * reach).min(1.0)).sum()
                };
                table.extend(third.iter().map(|c| weight * miss(c)));
            }
        }
        Self { rows, counts: [first.len(), second.len(), third.len()], table }
    }

    /// What it costs to go on from states `a` and `b` of the first two frames, and for every state of the third the
    /// place of its cost therein.
    #[inline]
    fn from(&self, a: usize, b: usize) -> (&[f32], &[usize]) {
        let start = (self.rows[0][a] * self.counts[1] + self.rows[1][b]) * self.counts[2];
        (&self.table[start..start + self.counts[2]], &self.rows[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Progress;
    use crate::track::limb::pose_path::{Candidate, step_cost};
    use glam::vec2;

    const STILL: [Vec2; 9] = [Vec2::ZERO; 9];

    fn solve(group: &Group<'_>, params: &SpaceTimeParams) -> Vec<Vec<usize>> {
        best_path(group, params, Progress::new().whole()).unwrap_or_default()
    }

    fn candidate(x: f32, cost: f32) -> Candidate {
        Candidate { pose: vec![vec2(0.0, 0.0), vec2(x, 100.0)], cost, next: None, last: None }
    }

    /// Two tips that pass through each other, the left one of each frame first.
    fn passing() -> Vec<Vec<Candidate>> {
        let x = |f: usize| (10.0 * f as f32 - 40.0).abs();
        (0..9).map(|f| vec![candidate(-x(f), 0.1), candidate(x(f), 0.1)]).collect()
    }

    #[test]
    fn a_pair_passes_and_does_not_bounce() {
        let mut lists = [passing(), passing()];
        // They start where they were drawn; looks alone would have the left one turn back.
        lists[0][0].truncate(1);
        lists[1][0].remove(0);
        lists[0][5..].iter_mut().for_each(|l| l[0].cost -= 0.002);
        let together: Vec<Vec<f32>> = lists[0]
            .iter()
            .zip(&lists[1])
            .map(|(a, b)| {
                let taken = |p: &Candidate, q: &Candidate| if p.pose == q.pose { 0.3 } else { 0.0 };
                a.iter().flat_map(|p| b.iter().map(move |q| taken(p, q))).collect()
            })
            .collect();
        let chain = |i: usize| Chain { lists: &lists[i], rest: &STILL };
        let group = Group { first: chain(0), second: Some(chain(1)), together: &together };
        let tips = |params: &SpaceTimeParams| -> Vec<f32> {
            solve(&group, params)[0].iter().zip(&lists[0]).map(|(&c, list)| list[c].pose[1].x).collect()
        };
        let passed: Vec<f32> = (0..9).map(|f| 10.0 * f as f32 - 40.0).collect();
        assert_eq!(tips(&SpaceTimeParams::default()), passed);
        assert_ne!(tips(&SpaceTimeParams { inertia: 0.0, ..SpaceTimeParams::default() }), passed);
    }

    #[test]
    fn it_is_the_cheapest_of_all_paths() {
        let mut seed = 99u32;
        let mut next = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        let lists: Vec<Vec<Candidate>> =
            (0..5).map(|_| (0..3).map(|_| candidate(80.0 * next(), 0.1 * next())).collect()).collect();
        let params = SpaceTimeParams::default();
        let chain = Chain { lists: &lists, rest: &STILL };
        let used = [0, 1, 2].map(|_| vec![0, 1, 2]);
        let bends: Vec<Bends> = (2..5).map(|f| Bends::new(&chain, f, &used, &params)).collect();
        let cost = |path: &[usize]| {
            let own: f32 = path.iter().zip(&lists).map(|(&c, l)| l[c].cost).sum();
            let step = |f: usize| step_cost(&lists[f - 1][path[f - 1]], &lists[f][path[f]], &params, Vec2::ZERO);
            let bend = |f: usize| {
                let (costs, places) = bends[f - 2].from(path[f - 2], path[f - 1]);
                costs[places[path[f]]]
            };
            own + (1..5).map(step).sum::<f32>() + (2..5).map(bend).sum::<f32>()
        };
        let all = (0..243usize).map(|n| [1, 3, 9, 27, 81].map(|d| n / d % 3));
        let least = all.map(|path| cost(&path)).fold(f32::INFINITY, f32::min);
        let found = solve(&Group { first: chain, second: None, together: &[] }, &params);
        assert!((cost(&found[0]) - least).abs() < 1e-5);
    }

    #[test]
    fn clips_of_one_and_two_frames_have_a_path() {
        for frames in 1..3 {
            let lists: Vec<Vec<Candidate>> =
                (0..frames).map(|_| vec![candidate(0.0, 0.3), candidate(9.0, 0.1)]).collect();
            let group = Group { first: Chain { lists: &lists, rest: &STILL }, second: None, together: &[] };
            assert_eq!(solve(&group, &SpaceTimeParams::default()), [vec![1; frames]]);
        }
    }
}
