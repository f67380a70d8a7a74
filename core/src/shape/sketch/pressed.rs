//! The outline of a line whose width was pressed: a filled shape for whoever draws or writes filled paths only.
//!
//! The line is cut into short pieces, and each becomes a closed shape with round ends, all turning the same way: filled by
//! the nonzero rule they join without seams or holes, however tightly the line turns. A piece's sides are offset cubics
//! (Tiller and Hanson 1984); where a side would run backwards, inside a turn tighter than the pen, the piece is the convex
//! hull of the discs at its ends. Every piece has the same elements, and their count depends only on the kinds of the
//! path's elements: outlines of a path that moves can be blended element by element.
//! Ends and corners are round, whatever the pen's cap and join; dashes are not cut.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};

use kurbo::{BezPath, CubicBez, ParamCurve, PathEl, Point, Vec2};

use super::drawing::Pen;

/// Pieces of a curve. A quarter turn is cut into turns of 22 degrees, which cubics follow to 1e-4 of the radius.
const PIECES: usize = 4;

/// The cosine between a piece's ends and its chord, its length in chords, and how short its inner side may be for its sides
/// to be offset cubics; found by outlines of random curves without holes.
const LEAN: f64 = 0.7;
const DETOUR: f64 = 1.25;
const SHRUNK: f64 = 0.35;

/// The outline of `path` as drawn by a pen whose width changes, to be filled by the nonzero rule. `widths` has one width
/// for each element of the path that is not a close; where it is too short `pen.width` holds.
pub fn outline(path: &BezPath, widths: &[f32], pen: &Pen) -> BezPath {
    let radii: Vec<f64> = widths.iter().map(|w| f64::from(*w) / 2.0).collect();
    let radius = |i: usize| radii.get(i).copied().unwrap_or(pen.width / 2.0);
    let mut out = BezPath::new();
    let (mut start, mut at, mut passed) = ((Point::ZERO, 0.0), (Point::ZERO, 0.0), 0);
    let elements = path.elements();
    for (i, el) in elements.iter().enumerate() {
        let line = |from: Point, to: Point| CubicBez::new(from, from.lerp(to, 1.0 / 3.0), from.lerp(to, 2.0 / 3.0), to);
        let (curve, pieces) = match *el {
            PathEl::MoveTo(p) => {
                at = (p, radius(passed));
                start = at;
                passed += 1;
                // A lone point is a dot.
                if matches!(elements.get(i + 1), None | Some(PathEl::MoveTo(_) | PathEl::ClosePath)) {
                    piece(&mut out, line(p, p), at.1, at.1);
                }
                continue;
            }
            PathEl::ClosePath => {
                piece(&mut out, line(at.0, start.0), at.1, start.1);
                at = start;
                continue;
            }
            PathEl::LineTo(p) => (line(at.0, p), 1),
            PathEl::QuadTo(c, p) => (CubicBez::new(at.0, at.0.lerp(c, 2.0 / 3.0), p.lerp(c, 2.0 / 3.0), p), PIECES),
            PathEl::CurveTo(c, d, p) => (CubicBez::new(at.0, c, d, p), PIECES),
        };
        let (from, to) = (at.1, radius(passed));
        passed += 1;
        for k in 0..pieces {
            let (a, b) = (k as f64 / pieces as f64, (k + 1) as f64 / pieces as f64);
            piece(&mut out, curve.subsegment(a..b), from + (to - from) * a, from + (to - from) * b);
        }
        at = (curve.p3, to);
    }
    out
}

/// One piece: a side, its end, the other side back and its beginning.
fn piece(out: &mut BezPath, c: CubicBez, r0: f64, r1: f64) {
    let way = c.p3 - c.p0;
    let straight = CubicBez::new(c.p0, c.p0.lerp(c.p3, 1.0 / 3.0), c.p0.lerp(c.p3, 2.0 / 3.0), c.p3);
    if (r0 - r1).abs() >= way.hypot() {
        // One disc holds the other.
        let (center, r) = if r0 > r1 { (c.p0, r0) } else { (c.p3, r1) };
        out.move_to(center + Vec2::new(r, 0.0));
        (0..3).for_each(|k| arc(out, center, Vec2::from_angle(-2.0 * FRAC_PI_3 * f64::from(k)) * r, -2.0 * FRAC_PI_3));
        out.close_path();
        return;
    }
    let ([left, right], turn) = even(c)
        .then(|| sides(c, r0, r1))
        .filter(|(sides, _)| sides.iter().all(|s| (s.p3 - s.p0).dot(way) > SHRUNK * way.hypot2()))
        .unwrap_or_else(|| sides(straight, r0, r1));
    out.move_to(left.p0);
    out.curve_to(left.p1, left.p2, left.p3);
    arc(out, c.p3, left.p3 - c.p3, -2.0 * turn);
    out.curve_to(right.p2, right.p1, right.p0);
    arc(out, c.p0, right.p0 - c.p0, 2.0 * turn - 2.0 * PI);
    out.close_path();
}

/// Whether a piece turns little, and evenly.
fn even(c: CubicBez) -> bool {
    let way = c.p3 - c.p0;
    let along = |t: Vec2| t.dot(way) > LEAN * t.hypot() * way.hypot();
    along(c.p1 - c.p0) && along(c.p3 - c.p2) && legs(c) < DETOUR * way.hypot()
}

fn legs(c: CubicBez) -> f64 {
    c.p0.distance(c.p1) + c.p1.distance(c.p2) + c.p2.distance(c.p3)
}

/// Both sides along the curve, and how far from its direction they touch the discs at its ends.
fn sides(c: CubicBez, r0: f64, r1: f64) -> ([CubicBez; 2], f64) {
    let turn = ((r0 - r1) / legs(c)).clamp(-1.0, 1.0).acos();
    let (t0, t1) = (c.p1 - c.p0, c.p3 - c.p2);
    let way = c.p3 - c.p0;
    let side = |s: f64| {
        let at = |t: Vec2, angle: f64| Vec2::from_angle(t.atan2() + s * angle);
        let (a, b) = (c.p0 + at(t0, turn) * r0, c.p3 + at(t1, turn) * r1);
        let scale = (b - a).dot(way) / way.hypot2();
        let (ahead, back) = (at(t0, turn - FRAC_PI_2) * t0.hypot(), at(t1, turn - FRAC_PI_2) * t1.hypot());
        CubicBez::new(a, a + ahead * scale, b - back * scale, b)
    };
    ([side(1.0), side(-1.0)], turn)
}

/// An arc of two cubics around `center` from `center + from`, turned by `sweep`.
fn arc(out: &mut BezPath, center: Point, from: Vec2, sweep: f64) {
    let half = sweep / 2.0;
    let handle = 4.0 / 3.0 * (half / 4.0).tan();
    let turned = |v: Vec2, angle: f64| {
        let (sin, cos) = angle.sin_cos();
        Vec2::new(v.x * cos - v.y * sin, v.x * sin + v.y * cos)
    };
    for k in 0..2 {
        let (a, b) = (turned(from, half * f64::from(k)), turned(from, half * f64::from(k + 1)));
        out.curve_to(center + a + a.turn_90() * handle, center + b - b.turn_90() * handle, center + b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kurbo::{ParamCurveNearest, PathSeg, Shape};
    use proptest::prelude::*;

    fn near_line(path: &BezPath, p: Point) -> f64 {
        path.segments().map(|s| s.nearest(p, 1e-6).distance_sq.sqrt()).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_straight_line_of_one_width_is_a_bar_with_round_ends() {
        let path = BezPath::from_svg("M10 10L110 10").expect("a path");
        let out = outline(&path, &[], &Pen::plain(8.0));
        assert!((out.area().abs() - (800.0 + PI * 16.0)).abs() < 0.05);
        let bounds = out.bounding_box();
        assert!((bounds.x0 - 6.0).abs() < 1e-6 && (bounds.y1 - 14.0).abs() < 1e-6);
    }

    #[test]
    fn a_dot_is_a_disc() {
        for path in ["M10 10", "M10 10L10 10", "M10 10Z"] {
            let out = outline(&BezPath::from_svg(path).expect("a path"), &[], &Pen::plain(8.0));
            assert!(out.contains(Point::new(13.9, 10.0)) && !out.contains(Point::new(14.1, 10.0)), "{path}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        // Whatever the line does: all within the lesser half width is inside, nothing beyond the greater is, no place is
        // wound around to nothing, and the elements are those of any other line of these kinds.
        #[test]
        fn no_holes_however_it_turns(
            p in prop::collection::vec((0.0..100.0f64, 0.0..100.0f64), 7),
            widths in prop::collection::vec(1.0f32..40.0, 3),
        ) {
            let at = |i: usize| Point::new(p[i].0, p[i].1);
            let mut path = BezPath::new();
            path.move_to(at(0));
            path.curve_to(at(1), at(2), at(3));
            path.curve_to(at(4), at(5), at(6));
            let out = outline(&path, &widths, &Pen::plain(1.0));
            let kinds = |b: &BezPath| b.elements().iter().map(std::mem::discriminant).collect::<Vec<_>>();
            let simple = BezPath::from_svg("M0 0C1 0 2 0 3 0C4 0 5 0 6 0").expect("a path");
            prop_assert_eq!(kinds(&out).len(), kinds(&outline(&simple, &widths, &Pen::plain(1.0))).len());
            for (k, segment) in path.segments().enumerate() {
                let PathSeg::Cubic(c) = segment else { continue };
                for i in 0..=20 {
                    let t = f64::from(i) / 20.0;
                    let r = (f64::from(widths[k]) * (1.0 - t) + f64::from(widths[k + 1]) * t) / 2.0;
                    for angle in 0..8 {
                        let place = c.eval(t) + Vec2::from_angle(f64::from(angle)) * (0.9 * r - 0.3).max(0.0);
                        // Between its ends the discs of a piece are those of its chord.
                        if i % 5 == 0 {
                            prop_assert!(out.winding(place) != 0, "a hole at {:?}", place);
                        }
                        let beyond = c.eval(t) + Vec2::from_angle(f64::from(angle)) * (r + 60.0);
                        if near_line(&path, beyond) > 20.3 {
                            prop_assert_eq!(out.winding(beyond), 0);
                        }
                    }
                }
            }
        }
    }
}
