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
        let steps = step_costs(&lists[f - 1], &lists[f], weights, drift(roots, f));
        let (mut new, mut links) = (Vec::with_capacity(lists[f].len()), Vec::with_capacity(lists[f].len()));
        for (b, row) in lists[f].iter().zip(steps.chunks_exact(lists[f - 1].len())) {
            let (link, best) = least(row.iter().zip(&cost).map(|(s, c)| s + c));
            links.push(link);
            new.push(best + b.cost);
        }
        from.push(links);
        cost = new;
    }
    let mut path = vec![0; lists.len()];
    path[lists.len() - 1] = least(cost.iter().copied()).0;
    for f in (1..lists.len()).rev() {
        path[f - 1] = from[f - 1][path[f]];
    }
    path
}

/// For every candidate of every frame, the cost of the best path through it.
pub(super) fn path_costs(lists: &[Vec<Candidate>], weights: &PathWeights, roots: Option<&[Vec2]>) -> Vec<Vec<f32>> {
    let steps: Vec<Vec<f32>> =
        (1..lists.len()).map(|f| step_costs(&lists[f - 1], &lists[f], weights, drift(roots, f))).collect();
    let own = |f: usize| lists[f].iter().map(|c| c.cost).collect::<Vec<f32>>();
    let mut totals = vec![own(0)];
    for f in 1..lists.len() {
        let rows = steps[f - 1].chunks_exact(lists[f - 1].len());
        let reached = rows.zip(own(f)).map(|(row, c)| c + least(row.iter().zip(&totals[f - 1]).map(|(s, t)| s + t)).1);
        let reached = reached.collect();
        totals.push(reached);
    }
    // Backward: what remains after each candidate.
    let mut rest = vec![0.0f32; lists.last().map_or(0, Vec::len)];
    for f in (1..lists.len()).rev() {
        let (n, after) = (lists[f - 1].len(), own(f));
        totals[f].iter_mut().zip(&rest).for_each(|(t, r)| *t += r);
        rest =
            (0..n).map(|a| least((0..after.len()).map(|b| steps[f - 1][b * n + a] + after[b] + rest[b])).1).collect();
    }
    totals[0].iter_mut().zip(&rest).for_each(|(t, r)| *t += r);
    totals
}

/// The best candidates of two limbs at once. `together[f]` holds for every candidate of the first limb, and within it for every
/// one of the second, what the two cost in frame `f` beyond their own costs.
pub(super) fn best_paths(
    lists: [&[Vec<Candidate>]; 2],
    together: &[Vec<f32>],
    weights: &PathWeights,
    roots: [Option<&[Vec2]>; 2],
) -> [Vec<usize>; 2] {
    let frames = lists[0].len();
    let own = |f: usize, i: usize, j: usize| {
        lists[0][f][i].cost + lists[1][f][j].cost + together[f][i * lists[1][f].len() + j]
    };
    let mut cost: Vec<f32> = (0..lists[0][0].len())
        .flat_map(|i| (0..lists[1][0].len()).map(move |j| (i, j)))
        .map(|(i, j)| own(0, i, j))
        .collect();
    let mut links: Vec<Vec<(u16, u16)>> = Vec::with_capacity(frames);
    for f in 1..frames {
        let (an, bn) = (lists[0][f - 1].len(), lists[1][f - 1].len());
        let (am, bm) = (lists[0][f].len(), lists[1][f].len());
        let first = step_costs(&lists[0][f - 1], &lists[0][f], weights, drift(roots[0], f));
        let second = step_costs(&lists[1][f - 1], &lists[1][f], weights, drift(roots[1], f));
        // The two limbs' steps are independent, so each is minimised on its own: first limb, then second.
        let mut half = Vec::with_capacity(am * bn);
        for row in first.chunks_exact(an) {
            for j in 0..bn {
                half.push(least((0..an).map(|i| row[i] + cost[i * bn + j])));
            }
        }
        let (mut new, mut link) = (Vec::with_capacity(am * bm), Vec::with_capacity(am * bm));
        for i in 0..am {
            let reached = &half[i * bn..(i + 1) * bn];
            for (j, row) in second.chunks_exact(bn).enumerate() {
                let (before, c) = least(row.iter().zip(reached).map(|(s, r)| s + r.1));
                new.push(c + own(f, i, j));
                link.push((reached[before].0 as u16, before as u16));
            }
        }
        links.push(link);
        cost = new;
    }
    let columns = |f: usize| lists[1][f].len();
    let last = least(cost.iter().copied()).0;
    let mut paths = [vec![0; frames], vec![0; frames]];
    let mut at = (last / columns(frames - 1), last % columns(frames - 1));
    for f in (0..frames).rev() {
        (paths[0][f], paths[1][f]) = at;
        if f > 0 {
            let (i, j) = links[f - 1][at.0 * columns(f) + at.1];
            at = (usize::from(i), usize::from(j));
        }
    }
    paths
}

fn least(values: impl Iterator<Item = f32>) -> (usize, f32) {
    let mut best = (0, f32::INFINITY);
    for (i, v) in values.enumerate() {
        if v < best.1 {
            best = (i, v);
        }
    }
    best
}

fn drift(roots: Option<&[Vec2]>, f: usize) -> Vec2 {
    roots.map_or(Vec2::ZERO, |r| r[f] - r[f - 1])
}

/// For every candidate of the later frame, the cost of coming from every one of the earlier.
fn step_costs(earlier: &[Candidate], later: &[Candidate], weights: &PathWeights, drift: Vec2) -> Vec<f32> {
    later.iter().flat_map(|b| earlier.iter().map(move |a| step_cost(a, b, weights, drift))).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

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
        let weights = PathWeights::default();
        let step = |f: usize| step_cost(&lists[f - 1][path[f - 1]], &lists[f][path[f]], &weights, Vec2::ZERO);
        own + (1..lists.len()).map(step).sum::<f32>()
    }

    fn all_paths() -> impl Iterator<Item = Vec<usize>> {
        (0..256).map(|n| (0..4).map(|f| n >> (2 * f) & 3).collect())
    }

    #[test]
    fn the_path_is_the_cheapest_of_all_and_path_costs_say_so() {
        let lists = lists(0);
        let weights = PathWeights::default();
        let path = best_path(&lists, &weights, None);
        let least = all_paths().map(|p| cost(&lists, &p)).fold(f32::INFINITY, f32::min);
        assert!((cost(&lists, &path) - least).abs() < 1e-5);
        let through = path_costs(&lists, &weights, None);
        for f in 0..4 {
            for i in 0..4 {
                let best = all_paths().filter(|p| p[f] == i).map(|p| cost(&lists, &p)).fold(f32::INFINITY, f32::min);
                assert!((through[f][i] - best).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn two_limbs_are_solved_exactly_together() {
        let (a, b) = (lists(0), lists(7));
        // The same index for both is forbidden.
        let together: Vec<Vec<f32>> =
            (0..4).map(|_| (0..16).map(|k| if k / 4 == k % 4 { 5.0 } else { 0.0 }).collect()).collect();
        let [first, second] = best_paths([&a, &b], &together, &PathWeights::default(), [None, None]);
        assert!(first.iter().zip(&second).all(|(i, j)| i != j));
        let least = all_paths()
            .flat_map(|p| all_paths().map(move |q| (p.clone(), q)))
            .filter(|(p, q)| p.iter().zip(q).all(|(i, j)| i != j))
            .map(|(p, q)| cost(&a, &p) + cost(&b, &q))
            .fold(f32::INFINITY, f32::min);
        assert!((cost(&a, &first) + cost(&b, &second) - least).abs() < 1e-4);
    }
}
