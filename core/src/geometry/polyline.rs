//! Open polylines in the plane: length, places by arc length, resampling.

use glam::Vec2;

/// The length of the polyline.
pub fn length(points: &[Vec2]) -> f32 {
    points.windows(2).map(|p| p[0].distance(p[1])).sum()
}

/// `count` points at equal arc-length steps from the first point to the last, both kept exactly.
/// A polyline of one point or of no length repeats its first point; an empty one gives nothing.
pub fn resample(points: &[Vec2], count: usize) -> Vec<Vec2> {
    let Some((&first, &last)) = points.first().zip(points.last()) else { return Vec::new() };
    let total = length(points);
    if count < 2 || total <= 0.0 {
        return vec![first; count];
    }
    let mut out = Vec::with_capacity(count);
    let (mut segment, mut passed) = (0, 0.0);
    out.push(first);
    for i in 1..count - 1 {
        let target = total * i as f32 / (count - 1) as f32;
        let mut step = points[segment].distance(points[segment + 1]);
        while passed + step < target && segment + 2 < points.len() {
            passed += step;
            segment += 1;
            step = points[segment].distance(points[segment + 1]);
        }
        let share = if step > 0.0 { ((target - passed) / step).clamp(0.0, 1.0) } else { 0.0 };
        out.push(points[segment].lerp(points[segment + 1], share));
    }
    out.push(last);
    out
}

/// The unit tangent at every point by central differences; (1, 0) where the polyline does not move.
pub fn tangents(points: &[Vec2]) -> Vec<Vec2> {
    (0..points.len())
        .map(|i| {
            let ahead = points[(i + 1).min(points.len() - 1)];
            (ahead - points[i.saturating_sub(1)]).try_normalize().unwrap_or(Vec2::X)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn resampling_keeps_ends_and_never_lengthens(
            points in prop::collection::vec((0f32..500.0, 0f32..500.0), 2..20),
            count in 2usize..60,
        ) {
            let points: Vec<Vec2> = points.into_iter().map(Vec2::from).collect();
            let out = resample(&points, count);
            prop_assert_eq!(out.len(), count);
            if length(&points) > 0.0 {
                prop_assert_eq!(out[0], points[0]);
                prop_assert_eq!(out[count - 1], points[points.len() - 1]);
            }
            prop_assert!(length(&out) <= length(&points) * 1.0001);
        }
    }

    #[test]
    fn a_straight_line_is_cut_evenly() {
        let out = resample(&[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(10.0, 0.0)], 6);
        for (i, p) in out.iter().enumerate() {
            assert!((p.x - 2.0 * i as f32).abs() < 1e-5);
        }
    }
}
