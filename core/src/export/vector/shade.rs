//! A gradient that goes along with its stroke, as players can hold it: places that move.
//!
//! Along a line this is exact under any affine map: colours depend on one linear function of the place, and so they do
//! afterwards. A circle becomes an ellipse that turns, which no player can move: its form stays as it was drawn and only
//! its place, size and direction follow (the similarity nearest in area).

use kurbo::{Affine, Point, Vec2};

use crate::shape::sketch::{Gradient, GradientShape, Spread, Stop};

/// How often colours that go on beyond the ends are told on either side, for players that know no such thing.
const ROUNDS: i32 = 4;
/// Between the longer and the shorter axis of what counts as a circle.
const ROUND: f64 = 1.01;

/// A gradient over time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shade {
    pub(super) radial: bool,
    /// From the space of the places to the picture.
    pub(super) space: Ellipse,
    /// In each frame: x and y where the gradient is 0 and where it is 1; of a circle its centre, the end of a radius, and
    /// its focus.
    pub(super) frames: Vec<Vec<f64>>,
}

/// A map that makes ellipses of circles, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ellipse {
    /// In radians.
    pub(super) turn: f64,
    /// Along the turned axes.
    pub(super) scale: (f64, f64),
}

impl Ellipse {
    pub(super) const NONE: Self = Self { turn: 0.0, scale: (1.0, 1.0) };

    pub(super) fn affine(self) -> Affine {
        Affine::rotate(self.turn) * Affine::scale_non_uniform(self.scale.0, self.scale.1)
    }

    /// Of a map: what it does to a circle, its size apart.
    fn of(map: Affine) -> Self {
        let ([a, b, c, d, ..], near) = (map.as_coeffs(), 1e-12);
        // Singular values and the left rotation, from the symmetric product of the matrix with itself.
        let (p, q, r) = (a * a + c * c, a * b + c * d, b * b + d * d);
        let turn = 0.5 * (2.0 * q).atan2(p - r);
        let root = ((p - r).hypot(2.0 * q), p + r);
        let (long, short) = (((root.1 + root.0) / 2.0).sqrt(), ((root.1 - root.0).max(0.0) / 2.0).sqrt());
        if long.is_finite() && short > near && long / short > ROUND && long / short < 1e4 {
            Self { turn, scale: (1.0, short / long) }
        } else {
            Self::NONE
        }
    }
}

impl Shade {
    /// Under what its stroke's surroundings do in each frame. Without `ellipses` circles stay circles, of the same area.
    pub(super) fn new(
        gradient: &Gradient,
        affines: impl Iterator<Item = Affine>,
        view: Affine,
        ellipses: bool,
    ) -> Self {
        match gradient.shape {
            GradientShape::Linear { from, to } => {
                let frames = affines.map(|affine| {
                    let map = view * affine * gradient.transform;
                    let start = map * from;
                    let end = start + steepest(map, to - from);
                    vec![start.x, start.y, end.x, end.y]
                });
                Self { radial: false, space: Ellipse::NONE, frames: frames.collect() }
            }
            GradientShape::Radial { center, radius, focus } => {
                let space = if ellipses { Ellipse::of(view * gradient.transform) } else { Ellipse::NONE };
                let frames = affines.map(|affine| {
                    let map = space.affine().inverse() * view * affine * gradient.transform;
                    let [a, b, c, d, ..] = map.as_coeffs();
                    let size = map.determinant().abs().sqrt();
                    // The direction that both axes agree on.
                    let axis = if map.determinant() < 0.0 { Vec2::new(a - d, b + c) } else { Vec2::new(a + d, b - c) };
                    let axis = if axis.hypot() > 0.0 { axis.normalize() * size } else { Vec2::new(size, 0.0) };
                    let side = if map.determinant() < 0.0 { -axis.turn_90() } else { axis.turn_90() };
                    let at = map * center;
                    let focus = at + axis * (focus.x - center.x) + side * (focus.y - center.y);
                    let end = at + axis * radius;
                    vec![at.x, at.y, end.x, end.y, focus.x, focus.y]
                });
                Self { radial: true, space, frames: frames.collect() }
            }
        }
    }

    /// For players that show the last colour beyond the ends: the ends farther out, and more stops.
    pub(super) fn unrolled(mut self, gradient: &Gradient) -> (Self, Vec<Stop>) {
        if gradient.spread == Spread::Pad {
            return (self, gradient.stops.clone());
        }
        let first = if self.radial { 0 } else { -ROUNDS };
        let rounds = (ROUNDS + 1 - first) as f64;
        for frame in &mut self.frames {
            let (start, end) = (Point::new(frame[0], frame[1]), Point::new(frame[2], frame[3]));
            let (low, high) = (start.lerp(end, f64::from(first)), start.lerp(end, f64::from(ROUNDS + 1)));
            [frame[0], frame[1], frame[2], frame[3]] = [low.x, low.y, high.x, high.y];
        }
        let stops = (first..=ROUNDS).flat_map(|round| {
            let back = gradient.spread == Spread::Reflect && round.rem_euclid(2) == 1;
            let own: Vec<Stop> =
                if back { gradient.stops.iter().rev().copied().collect() } else { gradient.stops.clone() };
            own.into_iter().map(move |stop| {
                let within = if back { 1.0 - stop.offset } else { stop.offset };
                Stop { offset: ((f64::from(round - first) + f64::from(within)) / rounds) as f32, ..stop }
            })
        });
        let stops = stops.collect();
        (self, stops)
    }
}

/// From where colours along `way` begin to where they end after `map`, straight across the lines of one colour.
fn steepest(map: Affine, way: Vec2) -> Vec2 {
    let [a, b, c, d, ..] = map.as_coeffs();
    let determinant = a * d - b * c;
    // The inverse transposed, times the determinant.
    let slope = Vec2::new(d * way.x - b * way.y, a * way.y - c * way.x);
    let end = slope * (determinant * way.hypot2() / slope.hypot2());
    if end.is_finite() { end } else { Vec2::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient(shape: GradientShape, transform: Affine) -> Gradient {
        let stop = |offset| Stop { offset, color: [0; 3], opacity: 1.0 };
        Gradient { shape, transform, spread: Spread::Reflect, stops: vec![stop(0.25), stop(1.0)] }
    }

    #[test]
    fn colours_along_a_line_stay_with_what_they_colour() {
        let transform = Affine::new([2.0, 0.5, -0.7, 1.5, 3.0, 4.0]);
        let gradient =
            gradient(GradientShape::Linear { from: Point::new(1.0, 2.0), to: Point::new(5.0, 3.0) }, transform);
        let affine = Affine::new([0.8, -0.4, 0.9, 1.1, -6.0, 2.0]);
        let shade = Shade::new(&gradient, std::iter::once(affine), Affine::scale(3.0), true);
        let [x0, y0, x1, y1] = shade.frames[0][..] else { panic!("four numbers") };
        let (from, way) = (Point::new(x0, y0), Vec2::new(x1 - x0, y1 - y0));
        for p in [Point::new(0.0, 0.0), Point::new(7.0, -3.0), Point::new(2.0, 9.0)] {
            let own = (p - Point::new(1.0, 2.0)).dot(Vec2::new(4.0, 1.0)) / 17.0;
            let seen = ((Affine::scale(3.0) * affine * transform * p) - from).dot(way) / way.hypot2();
            assert!((own - seen).abs() < 1e-9, "{own} {seen}");
        }
    }

    #[test]
    fn ellipses_keep_their_form_and_follow_turns() {
        let transform = Affine::rotate(0.4) * Affine::scale_non_uniform(30.0, 10.0);
        let shape = GradientShape::Radial { center: Point::new(0.1, 0.2), radius: 1.0, focus: Point::new(0.3, 0.2) };
        let shade = Shade::new(&gradient(shape, transform), std::iter::once(Affine::IDENTITY), Affine::IDENTITY, true);
        assert!((shade.space.scale.1 - 1.0 / 3.0).abs() < 1e-9 && (shade.space.turn - 0.4).abs() < 1e-9);
        let [cx, cy, ex, ey, fx, fy] = shade.frames[0][..] else { panic!("six numbers") };
        let near = |x, y, p: Point| assert!((shade.space.affine() * Point::new(x, y)).distance(transform * p) < 1e-9);
        near(cx, cy, Point::new(0.1, 0.2));
        near(ex, ey, Point::new(1.1, 0.2));
        near(fx, fy, Point::new(0.3, 0.2));
    }

    #[test]
    fn colours_that_go_back_and_forth_are_told_one_by_one() {
        let shape = GradientShape::Linear { from: Point::ZERO, to: Point::new(9.0, 0.0) };
        let gradient = gradient(shape, Affine::IDENTITY);
        let shade = Shade::new(&gradient, std::iter::once(Affine::IDENTITY), Affine::IDENTITY, true);
        let (shade, stops) = shade.unrolled(&gradient);
        assert_eq!(shade.frames[0], [-36.0, 0.0, 45.0, 0.0]);
        let places: Vec<f32> = stops.iter().map(|s| s.offset * 81.0 - 36.0).collect();
        let near = |i: usize, x: f32| assert!((places[i] - x).abs() < 1e-3, "{places:?}");
        near(8, 2.25);
        near(9, 9.0);
        near(10, 9.0);
        near(11, 15.75);
        assert!(places.is_sorted());
    }
}
