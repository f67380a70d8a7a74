//! The figure that some points on it suggest, where nothing else is known of it.
//!
//! Lines join the points as they are known to be joined, and all of them by their minimum spanning tree (Prim 1957);
//! the lines are grown until gaps between limbs that lie close together fill, and shrunk again (a morphological closing), to
//! a thin body around what is left.
//!
//! Known limits: a limb without a point is missing, limbs nearer than the closing are one.

use glam::Vec2;

use crate::geometry::polygon;
use crate::raster::Mask;
use crate::raster::distance::distance_to;
use crate::raster::marching_squares::outlines;

/// The radius that gaps are closed with and the body left around lines and points, as shares of the diagonal of the
/// points' box: of 0.10 to 0.22 and 0.015 to 0.06 those that carried most points to the right place on drawings.
pub(crate) const CLOSING: f32 = 0.18;
const BODY: f32 = 0.015;
/// The diagonal in working pixels.
const WORKING: f32 = 240.0;

/// The closed contour of the figure around `points`, of which pairs of numbers in `joined` are joined. Empty for fewer than
/// two places.
pub(crate) fn suggested(points: &[Vec2], joined: &[(usize, usize)], closing: f32) -> Vec<Vec2> {
    let Some((low, high)) = polygon::extent(points) else { return Vec::new() };
    let scale = WORKING / low.distance(high);
    if !(scale > 0.0 && scale.is_finite()) {
        return Vec::new();
    }
    let margin = Vec2::splat((closing + BODY) * WORKING + 2.0);
    let places: Vec<Vec2> = points.iter().map(|p| (*p - low) * scale + margin).collect();
    let size = ((high - low) * scale + 2.0 * margin).ceil().as_uvec2();
    let mut drawn = Mask::new(size.x as usize, size.y as usize);
    for (a, b) in spanning_tree(&places).iter().chain(joined) {
        let steps = (2.0 * places[*a].distance(places[*b])).ceil().max(1.0);
        for i in 0..=steps as usize {
            let p = places[*a].lerp(places[*b], i as f32 / steps);
            drawn.set(p.x as usize, p.y as usize, true);
        }
    }
    let away = distance_to(&drawn, true);
    let grown = Mask::from_fn(drawn.width(), drawn.height(), |x, y| away.get(x, y) <= closing * WORKING);
    // Holes count as inside: the outermost outline is the longest way around.
    let found = outlines(&distance_to(&grown, false), (closing - BODY) * WORKING);
    let largest = found.into_iter().max_by(|a, b| polygon::signed_area(a).total_cmp(&polygon::signed_area(b)));
    largest.unwrap_or_default().into_iter().map(|p| (p - margin) / scale + low).collect()
}

fn spanning_tree(points: &[Vec2]) -> Vec<(usize, usize)> {
    let mut nearest: Vec<(f32, usize)> = vec![(f32::INFINITY, 0); points.len()];
    let mut open: Vec<usize> = (1..points.len()).collect();
    let mut tree = Vec::with_capacity(open.len());
    let mut last = 0;
    while !open.is_empty() {
        for &i in &open {
            let away = points[i].distance_squared(points[last]);
            if away < nearest[i].0 {
                nearest[i] = (away, last);
            }
        }
        let next = (0..open.len()).min_by(|a, b| nearest[open[*a]].0.total_cmp(&nearest[open[*b]].0)).unwrap_or(0);
        last = open.swap_remove(next);
        tree.push((nearest[last].1, last));
    }
    tree
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn a_figure_holds_its_points_and_keeps_far_limbs_apart() {
        // A table: two legs far apart.
        let points = [vec2(0.0, 0.0), vec2(100.0, 0.0), vec2(0.0, 80.0), vec2(100.0, 80.0), vec2(50.0, 2.0)];
        let figure = [suggested(&points, &[(0, 2), (1, 3)], CLOSING)];
        assert!(points.iter().all(|p| polygon::contain(&figure, *p)));
        assert!(!polygon::contain(&figure, vec2(50.0, 60.0)) && polygon::contain(&figure, vec2(1.0, 40.0)));
        assert!(suggested(&[], &[], CLOSING).is_empty() && suggested(&[vec2(3.0, 3.0); 4], &[], CLOSING).is_empty());
    }

    #[test]
    fn a_tree_is_as_short_as_can_be() {
        let points = [vec2(0.0, 0.0), vec2(10.0, 0.0), vec2(1.0, 0.0), vec2(11.0, 1.0)];
        let mut tree = spanning_tree(&points);
        tree.sort_unstable();
        assert_eq!(tree, [(0, 2), (1, 3), (2, 1)]);
    }
}
