//! Which sample of one closed contour goes with which of another, in the order of both.
//!
//! Cyclic dynamic time warping by exact dynamic programming (Sakoe and Chiba 1978, symmetric weights; Marzal and
//! Barrachina 2000 for the cycle): the cheapest monotone way around both contours over all beginnings. Where
//! one contour goes on and the other waits, a price is paid for each sample, so that a limb that only one of them has is
//! passed by.

/// A match of two closed contours.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Matching {
    /// Pairs of samples in the order of both contours, each contour's numbers rising and beginning again once.
    pub(crate) pairs: Vec<(usize, usize)>,
    /// The mean price of a pair, waiting included.
    pub(crate) cost: f32,
}

/// Where a way comes from.
const BOTH: u8 = 0;
const FIRST: u8 = 1;
const SECOND: u8 = 2;

/// The cheapest match of contours with `count` samples, where `cost(i, j)`, row by row, is that of a pair and `wait` that of
/// a sample for which the other contour waits. `None` where either has none.
pub(crate) fn match_contours(cost: &[f32], count: (usize, usize), wait: f32) -> Option<Matching> {
    let (rows, columns) = count;
    if rows == 0 || columns == 0 || cost.len() != rows * columns {
        return None;
    }
    let mut best = (f32::INFINITY, 0);
    let mut previous = vec![0.0f32; columns + 1];
    let mut current = vec![0.0f32; columns + 1];
    // The first sample goes with some sample of the other: every one is tried.
    for start in 0..columns {
        let total = fill(cost, count, wait, start, &mut previous, &mut current, |_, _, _| ());
        if total < best.0 {
            best = (total, start);
        }
    }
    let mut from = vec![BOTH; (rows + 1) * (columns + 1)];
    fill(cost, count, wait, best.1, &mut previous, &mut current, |i, j, way| from[i * (columns + 1) + j] = way);
    let (mut i, mut j) = (rows, columns);
    let mut pairs = Vec::with_capacity(rows + columns);
    while i > 0 || j > 0 {
        match from[i * (columns + 1) + j] {
            BOTH => (i, j) = (i - 1, j - 1),
            FIRST => i -= 1,
            _ => j -= 1,
        }
        pairs.push((i % rows, (j + best.1) % columns));
    }
    pairs.reverse();
    Some(Matching { pairs, cost: best.0 / (rows + columns) as f32 })
}

/// The price of the cheapest way around both contours that begins with the first sample and sample `start`; `say` hears by
/// which step each place is reached.
fn fill(
    cost: &[f32],
    (rows, columns): (usize, usize),
    wait: f32,
    start: usize,
    previous: &mut Vec<f32>,
    current: &mut Vec<f32>,
    mut say: impl FnMut(usize, usize, u8),
) -> f32 {
    for i in 0..=rows {
        let line = &cost[i % rows * columns..][..columns];
        for j in 0..=columns {
            let pair = line[if j + start >= columns { (j + start) % columns } else { j + start }];
            let mut reached = if i == 0 && j == 0 { (0.0, BOTH) } else { (f32::INFINITY, BOTH) };
            if i > 0 && j > 0 {
                reached = (previous[j - 1] + 2.0 * pair, BOTH);
            }
            if i > 0 && previous[j] + pair + wait < reached.0 {
                reached = (previous[j] + pair + wait, FIRST);
            }
            if j > 0 && current[j - 1] + pair + wait < reached.0 {
                reached = (current[j - 1] + pair + wait, SECOND);
            }
            current[j] = reached.0;
            say(i, j, reached.1);
        }
        std::mem::swap(previous, current);
    }
    previous[columns]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The cheapest way around by trying every step from `(i, j)`, with `start` as the beginning.
    fn cheapest(cost: &[f32], count: (usize, usize), wait: f32, start: usize, at: (usize, usize)) -> f32 {
        let (i, j) = at;
        let pair = cost[i % count.0 * count.1 + (j + start) % count.1];
        let go = |next| cheapest(cost, count, wait, start, next);
        match at {
            (0, 0) => 0.0,
            (0, _) => go((0, j - 1)) + pair + wait,
            (_, 0) => go((i - 1, 0)) + pair + wait,
            _ => (go((i - 1, j - 1)) + 2.0 * pair).min(go((i - 1, j)) + pair + wait).min(go((i, j - 1)) + pair + wait),
        }
    }

    proptest! {
        #[test]
        fn no_way_around_is_cheaper_and_the_order_is_kept(cost in prop::collection::vec(0f32..1.0, 20), wait in 0f32..0.5) {
            let count = (4, 5);
            let found = match_contours(&cost, count, wait).expect("samples");
            let best = (0..5).map(|s| cheapest(&cost, count, wait, s, count)).fold(f32::INFINITY, f32::min);
            prop_assert!((found.cost - best / 9.0).abs() < 1e-5);
            for (a, b) in found.pairs.iter().zip(found.pairs.iter().cycle().skip(1)) {
                prop_assert!((b.0 + 4 - a.0) % 4 <= 1 && (b.1 + 5 - a.1) % 5 <= 1, "{:?}", found.pairs);
            }
            prop_assert!((0..4).all(|i| found.pairs.iter().any(|p| p.0 == i)));
            prop_assert!((0..5).all(|j| found.pairs.iter().any(|p| p.1 == j)));
        }
    }

    #[test]
    fn a_turned_list_is_matched_with_itself_and_nothing_with_nothing() {
        let shape = [0.0f32, 1.0, 5.0, 2.0, 9.0, 4.0];
        let cost: Vec<f32> = (0..36).map(|i| (shape[i / 6] - shape[(i % 6 + 4) % 6]).abs()).collect();
        let found = match_contours(&cost, (6, 6), 0.1).expect("samples");
        assert!(found.cost == 0.0 && found.pairs.iter().all(|(i, j)| (j + 4) % 6 == *i));
        assert!(match_contours(&[], (0, 3), 0.1).is_none());
    }
}
