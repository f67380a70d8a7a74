//! A limb that reaches for a place: its root stays, its lengths stay, its end goes there.
//!
//! All its bends are scaled by one factor until root and end are as far apart as they must be, and the limb is turned
//! toward the place: for two bones this is the law of cosines, for a stroke it is a leg that folds where it folds already.
//! A straight limb folds to the side it is bent to, however little.
//!
//! Known limits: what the limb's length cannot reach stays out of reach; the limb then points there, stretched out.

use glam::DVec2;

/// How far a straight limb is taken to be bent in all, in radians, so that it has a side to fold to.
const HINT: f64 = 0.05;
/// The factor that bends are scaled by at most, and bisections of it: to a thousandth of a pixel of a long limb.
const MOST: f64 = 64.0;
const STEPS: usize = 48;

/// The limb with `points`, from its root to its end, with the end at `target` or as near as its length allows.
pub(super) fn reach(points: &[DVec2], target: DVec2) -> Vec<DVec2> {
    let (Some(&root), Some(&end)) = (points.first(), points.last()) else { return points.to_vec() };
    if points.len() < 2 || end.distance_squared(target) < 1e-18 {
        return points.to_vec();
    }
    let segments: Vec<DVec2> = points.windows(2).map(|p| p[1] - p[0]).collect();
    // A segment without length points where the one before does.
    let mut bends = vec![0.0];
    let mut before = segments.iter().copied().find(|s| s.length() > 1e-9).unwrap_or(DVec2::X);
    let first = before;
    for segment in &segments[1..] {
        let here = if segment.length() > 1e-9 { *segment } else { before };
        bends.push(before.perp_dot(here).atan2(before.dot(here)));
        before = here;
    }
    let all: f64 = bends.iter().sum();
    let hint = if all < 0.0 { -HINT } else { HINT } / (bends.len() - 1).max(1) as f64;
    // At -1 it is straight, at 0 as it is.
    let bent = |factor: f64| {
        let mut way = vec![DVec2::ZERO];
        let mut turn = first.to_angle();
        for (i, (segment, bend)) in segments.iter().zip(&bends).enumerate() {
            if i > 0 {
                turn += bend + factor * (bend + if factor > 0.0 { hint } else { 0.0 });
            }
            way.push(way[i] + DVec2::from_angle(turn) * segment.length());
        }
        way
    };
    let span = |way: &[DVec2]| way[way.len() - 1].length();
    let wished = root.distance(target);
    let now = root.distance(end);
    // Straighter is longer; more bent is shorter until the limb has curled up.
    let (mut low, mut high) = if wished >= now { (-1.0, 0.0) } else { (0.0, 0.0) };
    if wished < now {
        let mut step = 0.125;
        while high < MOST && span(&bent(high)) > wished {
            low = high;
            high += step;
            step *= 1.25;
        }
    }
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if span(&bent(middle)) > wished { low = middle } else { high = middle }
    }
    let way = bent(0.5 * (low + high));
    let (from, to) = (way[way.len() - 1], target - root);
    let turn = if from.length() > 1e-9 && to.length() > 1e-9 { from.perp_dot(to).atan2(from.dot(to)) } else { 0.0 };
    let turn = DVec2::from_angle(turn);
    way.into_iter().map(|p| root + turn.rotate(p)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lengths(points: &[DVec2]) -> Vec<f64> {
        points.windows(2).map(|p| p[0].distance(p[1])).collect()
    }

    proptest! {
        #[test]
        fn the_end_is_where_it_can_be_and_lengths_stay(
            bends in prop::collection::vec(-0.35f64..0.35, 3..12),
            step in (-40.0f64..40.0, -40.0f64..40.0),
        ) {
            let mut points = vec![DVec2::new(50.0, 20.0)];
            let mut turn = 1.5;
            for bend in &bends {
                turn += bend;
                points.push(points[points.len() - 1] + DVec2::from_angle(turn) * 20.0);
            }
            let end = points[points.len() - 1];
            let target = end + DVec2::from(step) * 0.5;
            let out = reach(&points, target);
            for (a, b) in lengths(&points).iter().zip(lengths(&out)) {
                prop_assert!((a - b).abs() < 1e-6);
            }
            prop_assert!(out[0].distance(points[0]) < 1e-9);
            let whole: f64 = lengths(&points).iter().sum();
            let wished = points[0].distance(target);
            let missed = out[out.len() - 1].distance(target);
            prop_assert!(missed < 1e-3 || (missed - (wished - whole)).abs() < 1e-3, "{missed} {wished} {whole}");
        }
    }

    #[test]
    fn two_bones_fold_by_the_law_of_cosines_and_a_straight_limb_folds_too() {
        let leg = [DVec2::ZERO, DVec2::new(1.0, 10.0), DVec2::new(0.0, 20.0)];
        let out = reach(&leg, DVec2::new(0.0, 15.0));
        assert!(out[2].distance(DVec2::new(0.0, 15.0)) < 1e-6 && out[1].x > 1.0, "{out:?}");
        let straight: Vec<DVec2> = (0..6).map(|i| DVec2::new(0.0, 10.0 * f64::from(i))).collect();
        let out = reach(&straight, DVec2::new(0.0, 40.0));
        assert!(out[5].distance(DVec2::new(0.0, 40.0)) < 1e-3, "{out:?}");
        let out = reach(&straight, DVec2::new(70.0, 0.0));
        assert!(out[5].distance(DVec2::new(50.0, 0.0)) < 1e-3, "{out:?}");
        for odd in [&[][..], &[DVec2::ONE], &[DVec2::ONE; 3]] {
            assert!(reach(odd, DVec2::ZERO).iter().all(|p| p.is_finite()));
        }
    }
}
