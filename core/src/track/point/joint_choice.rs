//! Which way each of several points that look alike went: together the cheapest, where two that run in one cost extra
//! (Live Sketch, Su et al. 2018, equation 2).
//!
//! Greedy as there: from the cheapest way of each on, the exchange of one way that lowers the total most, until none does.
//! The total falls with each exchange, so this ends. Known limit: two exchanges that only help together are not found.

/// A way a point may have gone, among others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way<'a, T> {
    /// Its cost a frame.
    pub(super) cost: f32,
    pub(super) way: &'a T,
}

/// For every point the way that it went. `shared` is the share of the frames in which two ways run in one, `weight` what
/// all of them cost.
pub(super) fn chosen<T>(points: &[Vec<Way<'_, T>>], weight: f32, shared: impl Fn(&T, &T) -> f32) -> Vec<usize> {
    let mut choice = vec![0usize; points.len()];
    let cost = |choice: &[usize], i: usize, way: usize| {
        let own = &points[i][way];
        let others = (0..points.len()).filter(|&j| j != i);
        own.cost + weight * others.map(|j| shared(own.way, points[j][choice[j]].way)).sum::<f32>()
    };
    loop {
        let mut best = (-1e-6f32, 0, 0);
        for (i, ways) in points.iter().enumerate() {
            let now = cost(&choice, i, choice[i]);
            for way in (0..ways.len()).filter(|&w| w != choice[i]) {
                let change = cost(&choice, i, way) - now;
                if change < best.0 {
                    best = (change, i, way);
                }
            }
        }
        if best.0 >= -1e-6 {
            return choice;
        }
        choice[best.1] = best.2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_points_on_one_way_part_where_that_is_cheapest() {
        let ways = [vec![(1.0, 'a'), (1.2, 'b'), (3.0, 'c')], vec![(1.0, 'a'), (1.1, 'c')], vec![(0.5, 'd')]];
        let points: Vec<Vec<Way<'_, char>>> =
            ways.iter().map(|p| p.iter().map(|(cost, way)| Way { cost: *cost, way }).collect()).collect();
        let same = |a: &char, b: &char| f32::from(u8::from(a == b));
        assert_eq!(chosen(&points, 0.5, same), [0, 1, 0]);
        assert_eq!(chosen(&points, 0.05, same), [0, 0, 0]);
        assert!(chosen::<char>(&[], 1.0, same).is_empty());
    }
}
