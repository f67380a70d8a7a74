//! Shape contexts: what the whole of a contour looks like from each of its points.
//!
//! Belongie, Malik and Puzicha 2002, "Shape Matching and Object Recognition Using Shape Contexts": a histogram of the
//! places of all other samples over direction and logarithm of distance, distances as shares of their mean, compared by
//! chi square. Directions are the picture's, not the contour's own: with those left and right limbs look alike. A sample
//! counts for the bins around it by nearness, so that a contour sampled from another start looks the same.

use std::f32::consts::TAU;

use glam::Vec2;

/// Bins over direction and distance, and the distances of the first and the last as shares of the mean: the authors'.
const DIRECTIONS: usize = 12;
const DISTANCES: usize = 5;
const NEAREST: f32 = 0.125;
const FARTHEST: f32 = 2.0;

/// One histogram, summing to 1.
type Histogram = [f32; DIRECTIONS * DISTANCES];

/// The shape context of every sample of a contour.
#[derive(Clone, Debug)]
pub(crate) struct ShapeContexts(Vec<Histogram>);

impl ShapeContexts {
    /// Of `samples`, evenly spaced along a contour.
    pub(crate) fn of(samples: &[Vec2]) -> Self {
        let pairs = samples.len() * samples.len().saturating_sub(1);
        let sum: f64 = samples.iter().flat_map(|a| samples.iter().map(|b| f64::from(a.distance(*b)))).sum();
        let mean = (sum / pairs.max(1) as f64).max(1e-12) as f32;
        let step = (FARTHEST / NEAREST).ln() / (DISTANCES - 1) as f32;
        let histogram = |a: &Vec2| {
            let mut bins: Histogram = [0.0; DIRECTIONS * DISTANCES];
            let mut total = 0.0;
            for b in samples {
                let way = *b - *a;
                let far = way.length() / mean;
                if far <= 1e-6 || far > FARTHEST {
                    continue;
                }
                let ring = ((far / NEAREST).ln() / step).max(0.0);
                let turn = way.to_angle().rem_euclid(TAU) / TAU * DIRECTIONS as f32;
                for (direction, share) in [(turn as usize, 1.0 - turn.fract()), (turn as usize + 1, turn.fract())] {
                    for (distance, part) in [(ring as usize, 1.0 - ring.fract()), (ring as usize + 1, ring.fract())] {
                        let bin = distance.min(DISTANCES - 1) * DIRECTIONS + direction % DIRECTIONS;
                        bins[bin] += share * part;
                    }
                }
                total += 1.0;
            }
            bins.map(|v| v / f32::max(total, 1.0))
        };
        Self(samples.iter().map(histogram).collect())
    }

    /// How unlike what is seen from a sample here and from one there is, in 0..=1.
    pub(crate) fn difference(&self, here: usize, other: &Self, there: usize) -> f32 {
        let chi = |(a, b): (&f32, &f32)| if a + b > 0.0 { (a - b) * (a - b) / (a + b) } else { 0.0 };
        0.5 * self.0[here].iter().zip(&other.0[there]).map(chi).sum::<f32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn size_and_place_do_not_matter_and_direction_does() {
        let shape: Vec<Vec2> = (0..40).map(|i| Vec2::from_angle(i as f32 * TAU / 40.0) * vec2(3.0, 1.0)).collect();
        let larger: Vec<Vec2> = shape.iter().map(|p| *p * 70.0 + vec2(900.0, -20.0)).collect();
        let (here, there) = (ShapeContexts::of(&shape), ShapeContexts::of(&larger));
        for i in 0..40 {
            assert!(here.difference(i, &there, i) < 1e-3);
        }
        assert!(here.difference(0, &there, 20) > 0.9, "one end sees the rest at its left, the other at its right");
        let same = ShapeContexts::of(&[vec2(1.0, 1.0); 5]);
        assert_eq!(same.difference(0, &same, 3), 0.0);
    }
}
