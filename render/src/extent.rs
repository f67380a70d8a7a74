//! How far something reaches in every direction: a few of its points that no other lies beyond.
//!
//! What a camera has to fit are the outermost points of a whole animation. Of each of [`DIRECTIONS`] directions the farthest
//! point is kept: nothing is more than 13.2 degrees from the nearest of 128, so that at most 2.7 % of a round body's radius
//! (1 - cos 13.2 degrees) lie beyond, which [`crate::Camera`]'s margin covers.

use glam::{Mat4, Vec3};

/// Directions that are looked at.
const DIRECTIONS: usize = 128;

/// The outermost points of something. Empty of nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extent {
    points: Vec<Vec3>,
}

impl Extent {
    /// Of points; what is no number is left out.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        let directions = directions();
        let mut best = [(f32::NEG_INFINITY, Vec3::ZERO); DIRECTIONS];
        for p in points.into_iter().filter(|p| p.is_finite()) {
            for (best, way) in best.iter_mut().zip(&directions) {
                let reach = way.dot(p);
                if reach > best.0 {
                    *best = (reach, p);
                }
            }
        }
        let mut points: Vec<Vec3> = best.iter().filter(|b| b.0.is_finite()).map(|b| b.1).collect();
        points.dedup();
        Self { points }
    }

    /// Of several together.
    pub fn join<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        Self::of(parts.into_iter().flat_map(|e| e.points.iter().copied()))
    }

    /// Of the same thing moved.
    #[must_use]
    pub fn moved(&self, by: &Mat4) -> Self {
        Self { points: self.points.iter().map(|p| by.transform_point3(*p)).collect() }
    }

    /// The outermost points.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// The least and the greatest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let nothing =
            if self.points.is_empty() { (Vec3::ZERO, Vec3::ZERO) } else { (Vec3::INFINITY, Vec3::NEG_INFINITY) };
        self.points.iter().fold(nothing, |(low, high), p| (low.min(*p), high.max(*p)))
    }

    /// The middle of its bounds.
    pub fn center(&self) -> Vec3 {
        let (low, high) = self.bounds();
        (low + high) / 2.0
    }

    /// The length of the diagonal of its bounds.
    pub fn size(&self) -> f32 {
        let (low, high) = self.bounds();
        low.distance(high)
    }
}

/// Directions evenly over the sphere: a Fibonacci lattice, after the six of the axes, whose bounds are then exact.
fn directions() -> [Vec3; DIRECTIONS] {
    const GOLDEN: f32 = 2.399_963_2;
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    std::array::from_fn(|i| {
        axes.get(i).copied().unwrap_or_else(|| {
            let k = (i - axes.len()) as f32 + 0.5;
            let z = 1.0 - 2.0 * k / (DIRECTIONS - axes.len()) as f32;
            let (sin, cos) = (GOLDEN * k).sin_cos();
            let flat = (1.0 - z * z).max(0.0).sqrt();
            Vec3::new(cos * flat, sin * flat, z)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hardly_anything_of_a_ball_lies_beyond_and_nothing_of_a_box() {
        let ball = |i: usize| {
            let (a, z) = (i as f32 * 2.399_963_2, -1.0 + 2.0 * (i as f32 + 0.5) / 5000.0);
            Vec3::new(a.cos() * (1.0 - z * z).sqrt(), a.sin() * (1.0 - z * z).sqrt(), z)
        };
        let extent = Extent::of((0..5000).map(ball));
        for i in 0..777 {
            let way = ball(i * 5 + 2);
            let reach = extent.points().iter().map(|p| p.dot(way)).fold(f32::NEG_INFINITY, f32::max);
            assert!(reach > 0.965, "{reach} toward {way}");
        }
        let corners = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32 * 7.0, (i >> 2) as f32));
        assert_eq!(Extent::of(corners).bounds(), (Vec3::ZERO, Vec3::new(1.0, 7.0, 1.0)));
        assert_eq!(Extent::of([Vec3::NAN]).bounds(), (Vec3::ZERO, Vec3::ZERO));
    }
}
