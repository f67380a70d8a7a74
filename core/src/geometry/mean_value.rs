//! Mean value coordinates of a place in a closed polygon (Floater 2003; Hormann and Floater 2006 for any polygon).
//!
//! A place is a weighed mean of the polygon's corners, the weights being smooth in it; they are exact for
//! linear maps, and defined outside as well. In a concave polygon weights may be below 0.

use glam::Vec2;

/// Nearer to an edge than this share of the polygon's size a place is on it.
const ON_EDGE: f64 = 1e-6;

/// The weights of the corners of `polygon`, summing to 1; the polygon may go either way around, and corners may
/// coincide. Empty for a polygon without corners.
pub(crate) fn coordinates(polygon: &[Vec2], place: Vec2) -> Vec<f64> {
    let count = polygon.len();
    let ways: Vec<_> = polygon.iter().map(|p| p.as_dvec2() - place.as_dvec2()).collect();
    let near = ON_EDGE * ways.iter().map(|w| w.length()).fold(0.0, f64::max);
    let mut weights = vec![0.0; count];
    for i in 0..count {
        let next = (i + 1) % count;
        let (a, b) = (ways[i], ways[next]);
        if a.length() <= near {
            weights.fill(0.0);
            weights[i] = 1.0;
            return weights;
        }
        let edge = b - a;
        let along = -a.dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE);
        if (0.0..=1.0).contains(&along) && (a + edge * along).length() <= near {
            weights.fill(0.0);
            weights[i] = 1.0 - along;
            weights[next] += along;
            return weights;
        }
        let tangent = (0.5 * a.perp_dot(b).atan2(a.dot(b))).tan();
        weights[i] += tangent / a.length();
        weights[next] += tangent / b.length().max(near);
    }
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, vec2};
    use proptest::prelude::*;

    const BAY: [Vec2; 6] =
        [vec2(0.0, 0.0), vec2(9.0, 0.0), vec2(9.0, 9.0), vec2(5.0, 9.0), vec2(4.0, 3.0), vec2(0.0, 8.0)];

    proptest! {
        #[test]
        fn a_place_is_the_weighed_mean_of_the_corners(x in -5f32..15.0, y in -5f32..15.0, backward in any::<bool>()) {
            let mut polygon = BAY.to_vec();
            if backward {
                polygon.reverse();
            }
            let weights = coordinates(&polygon, vec2(x, y));
            prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            let mean: DVec2 = weights.iter().zip(&polygon).map(|(w, p)| p.as_dvec2() * *w).sum();
            let size: f64 = weights.iter().map(|w| w.abs()).sum();
            prop_assert!(mean.distance(DVec2::new(x.into(), y.into())) < 1e-6 * size, "{mean} {size}");
        }
    }

    #[test]
    fn corners_and_edges_are_themselves() {
        assert_eq!(coordinates(&BAY, BAY[4]), [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let edge = coordinates(&BAY, vec2(3.0, 0.0));
        assert!((edge[1] - 1.0 / 3.0).abs() < 1e-9 && edge[2..].iter().all(|w| *w == 0.0));
        assert!(coordinates(&[], Vec2::ONE).is_empty());
        let twice = [BAY[0], BAY[0], BAY[1], BAY[2], BAY[2]];
        assert!(coordinates(&twice, vec2(6.0, 2.0)).iter().all(|w| w.is_finite()));
    }
}
