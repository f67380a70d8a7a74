//! The cheapest choice of one candidate for every vertex of a forest, exactly, by dynamic programming from the leaves
//! to the roots (Reinert 2016, section 3.5; Felzenszwalb & Huttenlocher 2005 for trees), and what every other choice
//! would cost.
//!
//! Costs of a choice: one for every vertex's candidate and one for every edge's pair of candidates. With `n`
//! vertices of `k` candidates both passes take `n k^2` pair costs, each computed once.
//!
//! The *min-marginal* of a candidate is the cost of the cheapest choice that contains it. Its gap to the optimum says
//! how sure the optimum is of the candidate it took: where another place far away costs hardly more, the vertex is
//! uncertain, whatever the reason.

use rayon::prelude::*;

/// Costs beyond this count as this: sums stay finite, and forbidden candidates stay comparable.
const FORBIDDEN: f32 = 1e12;

/// The cheapest choice.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeOptimum {
    /// The chosen candidate of every vertex; the first of several equals.
    pub chosen: Vec<usize>,
    /// Its cost, over all trees.
    pub cost: f32,
    /// For every vertex and candidate the cost of its tree's cheapest choice with it.
    pub min_marginals: Vec<Vec<f32>>,
}

/// Solves the forest in which `parent[v]` is the parent of vertex `v` and `order` lists parents before children.
/// `own[v]` holds the costs of the candidates of `v`; `pair(v, p, c)` is the cost of candidate `c` at `v` with candidate
/// `p` at its parent, called from many threads. Costs that are not finite forbid. `None` when a vertex has no candidate.
pub fn tree_optimum(
    order: &[usize],
    parent: &[Option<usize>],
    own: &[Vec<f32>],
    pair: impl Fn(usize, usize, usize) -> f32 + Sync,
) -> Option<TreeOptimum> {
    if own.iter().any(Vec::is_empty) || own.len() != parent.len() {
        return None;
    }
    let bounded = |cost: f32| if cost < FORBIDDEN { cost } else { FORBIDDEN };
    // Edge costs, a row for each of the parent's candidates.
    let edges: Vec<Vec<f32>> = (0..own.len())
        .into_par_iter()
        .map(|v| match parent[v] {
            None => Vec::new(),
            Some(p) => {
                (0..own[p].len() * own[v].len()).map(|i| bounded(pair(v, i / own[v].len(), i % own[v].len()))).collect()
            }
        })
        .collect();
    // Up: the cost of the cheapest choice below and including each candidate, and what each edge tells its parent.
    let mut below: Vec<Vec<f32>> = own.iter().map(|c| c.iter().map(|&x| bounded(x)).collect()).collect();
    let mut told: Vec<Vec<f32>> = vec![Vec::new(); own.len()];
    let mut best: Vec<Vec<usize>> = vec![Vec::new(); own.len()];
    for &v in order.iter().rev() {
        let Some(p) = parent[v] else { continue };
        let (message, choice) = edges[v].chunks_exact(own[v].len()).map(|row| cheapest(row, &below[v])).unzip();
        told[v] = message;
        best[v] = choice;
        for (sum, m) in below[p].iter_mut().zip(&told[v]) {
            *sum += m;
        }
    }
    // Down: the chosen candidates, and the cheapest choice of all the rest of the tree.
    let mut min_marginals = below;
    let mut chosen = vec![0; own.len()];
    let mut cost = 0.0;
    for &v in order {
        let Some(p) = parent[v] else {
            let (least, index) = min_marginals[v]
                .iter()
                .enumerate()
                .fold((f32::INFINITY, 0), |a, (i, &c)| if c < a.0 { (c, i) } else { a });
            chosen[v] = index;
            cost += least;
            continue;
        };
        chosen[v] = best[v][chosen[p]];
        let rest: Vec<f32> = min_marginals[p].iter().zip(&told[v]).map(|(all, ours)| all - ours).collect();
        let mut above = vec![f32::INFINITY; own[v].len()];
        for (row, rest) in edges[v].chunks_exact(own[v].len()).zip(&rest) {
            for (a, e) in above.iter_mut().zip(row) {
                *a = a.min(rest + e);
            }
        }
        for (m, a) in min_marginals[v].iter_mut().zip(&above) {
            *m += a;
        }
    }
    Some(TreeOptimum { chosen, cost, min_marginals })
}

impl TreeOptimum {
    /// How much dearer the cheapest choice is that puts vertex `v` on a candidate for which `elsewhere` holds; infinite
    /// when there is none.
    pub fn gap(&self, v: usize, elsewhere: impl Fn(usize) -> bool) -> f32 {
        let least = |i: &(usize, &f32)| elsewhere(i.0);
        let other =
            self.min_marginals[v].iter().enumerate().filter(least).map(|(_, &c)| c).fold(f32::INFINITY, f32::min);
        (other - self.min_marginals[v][self.chosen[v]]).max(0.0)
    }
}

/// The least sum of an edge's row and the costs below, and where it is.
fn cheapest(row: &[f32], below: &[f32]) -> (f32, usize) {
    let sums = row.iter().zip(below).map(|(e, b)| e + b).enumerate();
    sums.fold((f32::INFINITY, 0), |a, (i, c)| if c < a.0 { (c, i) } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A random forest of up to 6 vertices with up to 4 candidates each, and costs.
    fn forest() -> impl Strategy<Value = (Vec<Option<usize>>, Vec<Vec<f32>>, Vec<f32>)> {
        (1usize..6).prop_flat_map(|n| {
            let parents: Vec<_> = (0..n).map(|v| prop::option::weighted(0.8, 0..v.max(1))).collect();
            let own = prop::collection::vec(prop::collection::vec(0f32..10.0, 1..4), n);
            (parents, own, prop::collection::vec(0f32..10.0, 64))
        })
    }

    proptest! {
        #[test]
        fn optimum_and_marginals_are_those_of_trying_everything((parents, own, costs) in forest()) {
            let parent: Vec<Option<usize>> =
                parents.iter().enumerate().map(|(v, p)| p.filter(|&p| p < v)).collect();
            let order: Vec<usize> = (0..own.len()).collect();
            let pair = |v: usize, p: usize, c: usize| costs[(v * 31 + p * 7 + c * 3) % costs.len()];
            let solved = tree_optimum(&order, &parent, &own, pair).expect("candidates");
            let total: usize = own.iter().map(Vec::len).product();
            let mut least = vec![vec![f32::INFINITY; 4]; own.len()];
            let mut optimum = f32::INFINITY;
            let root_of = |mut v: usize| { while let Some(p) = parent[v] { v = p; } v };
            for code in 0..total {
                let mut rest = code;
                let choice: Vec<usize> = own.iter().map(|c| { let i = rest % c.len(); rest /= c.len(); i }).collect();
                let mut per_tree = vec![0.0f32; own.len()];
                for v in 0..own.len() {
                    per_tree[root_of(v)] += own[v][choice[v]] + parent[v].map_or(0.0, |p| pair(v, choice[p], choice[v]));
                }
                optimum = optimum.min(per_tree.iter().sum());
                for v in 0..own.len() {
                    least[v][choice[v]] = least[v][choice[v]].min(per_tree[root_of(v)]);
                }
            }
            prop_assert!((solved.cost - optimum).abs() < 1e-3);
            for v in 0..own.len() {
                for c in 0..own[v].len() {
                    prop_assert!((solved.min_marginals[v][c] - least[v][c]).abs() < 1e-3);
                }
                let chosen = solved.min_marginals[v][solved.chosen[v]];
                prop_assert!(solved.min_marginals[v].iter().all(|m| *m >= chosen - 1e-3));
            }
        }
    }

    #[test]
    fn forbidden_candidates_are_not_taken_and_missing_ones_are_said() {
        let own = [vec![f32::INFINITY, 5.0], vec![f32::NAN, 1.0]];
        let solved = tree_optimum(&[0, 1], &[None, Some(0)], &own, |_, _, _| 0.0).expect("candidates");
        assert_eq!(solved.chosen, [1, 1]);
        assert!((solved.cost - 6.0).abs() < 1e-5 && solved.gap(0, |c| c != 1) > 1e6);
        assert!(tree_optimum(&[0], &[None], &[vec![]], |_, _, _| 0.0).is_none());
    }
}
