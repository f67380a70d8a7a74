//! Closed polygons, given by their corners without the first one again.

use glam::Vec2;

/// The area, positive where the corners turn from x to y.
pub fn signed_area(polygon: &[Vec2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let double: f64 = polygon.iter().zip(next).map(|(a, b)| a.as_dvec2().perp_dot(b.as_dvec2())).sum();
    0.5 * double
}

/// The lowest and the highest corner of the box around some places; `None` around none.
pub fn extent(places: &[Vec2]) -> Option<(Vec2, Vec2)> {
    let first = *places.first()?;
    Some(places.iter().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p))))
}

/// The place on the polygon's edges that is nearest to `p`; `p` for a polygon without corners.
pub fn nearest(polygon: &[Vec2], p: Vec2) -> Vec2 {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let places = edges.map(|(a, b)| nearest_on_segment(*a, *b, p).1);
    places.min_by(|a, b| a.distance_squared(p).total_cmp(&b.distance_squared(p))).unwrap_or(p)
}

/// Whether `p` lies inside an odd number of the polygons: within one, and not in its holes.
pub fn contain(polygons: &[Vec<Vec2>], p: Vec2) -> bool {
    let mut inside = false;
    for polygon in polygons {
        for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) * (b.x - a.x) / (b.y - a.y) {
                inside = !inside;
            }
        }
    }
    inside
}

/// The place on the segment from `a` to `b` that is nearest to `p`: how far along, in 0..=1, and where.
pub fn nearest_on_segment(a: Vec2, b: Vec2, p: Vec2) -> (f32, Vec2) {
    let along = b - a;
    let square = along.length_squared();
    let t = if square > 0.0 { ((p - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (t, a + along * t)
}

/// Corners about `spacing(corner)` apart along the closed polygon, evenly, at least three.
pub fn resample(polygon: &[Vec2], spacing: impl Fn(Vec2) -> f32) -> Vec<Vec2> {
    if polygon.is_empty() {
        return Vec::new();
    }
    let closed = || polygon.iter().zip(polygon.iter().cycle().skip(1));
    // Length counted in steps, so that a graded spacing is met on average and the last step is as long as the first.
    let steps: Vec<f32> = closed().map(|(a, b)| a.distance(*b) / spacing(a.midpoint(*b)).max(1e-3)).collect();
    let total: f32 = steps.iter().sum();
    let count = (total.round() as usize).max(3);
    let step = total / count as f32;
    let mut out = Vec::with_capacity(count);
    let mut travelled = 0.0;
    for ((a, b), own) in closed().zip(steps) {
        while out.len() < count && out.len() as f32 * step <= travelled + own {
            let share = if own > 0.0 { (out.len() as f32 * step - travelled) / own } else { 0.0 };
            out.push(a.lerp(*b, share.clamp(0.0, 1.0)));
        }
        travelled += own;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn a_square_keeps_its_area_and_knows_its_inside() {
        let square = vec![vec2(0.0, 0.0), vec2(8.0, 0.0), vec2(8.0, 8.0), vec2(0.0, 8.0)];
        let hole = vec![vec2(3.0, 3.0), vec2(3.0, 5.0), vec2(5.0, 5.0), vec2(5.0, 3.0)];
        assert_eq!(signed_area(&square), 64.0);
        assert_eq!(signed_area(&hole), -4.0);
        let fine = resample(&square, |_| 1.0);
        assert_eq!(fine.len(), 32);
        assert!((signed_area(&fine) - 64.0).abs() < 1e-3);
        let both = [square, hole];
        assert!(contain(&both, vec2(1.0, 1.0)) && !contain(&both, vec2(4.0, 4.0)) && !contain(&both, vec2(9.0, 4.0)));
    }
}
