//! Paths that bend: sampled where they are drawn, and drawn again through where the samples go.
//!
//! Curves and lines are cut into parts at rest, as many as the take needs: one curve each, from the first sample of the part
//! to its last exactly. Its handles point where those of the drawn curve do, turned as the line around them turns (a
//! complex least squares over the neighbouring samples, shared by both sides of a smooth place, so that it stays smooth),
//! and are as long as meets the samples between best (least squares, as in Schneider 1990, at the parameters of the drawn
//! curve).
//!
//! Known limits: a curve is cut at equal lengths, not where it bends most; quadratic curves become cubic ones.

use glam::{DVec2, Vec2, dvec2};
use kurbo::{BezPath, CubicBez, Line, ParamCurve, ParamCurveArclen, ParamCurveDeriv, PathEl, Point};

/// A curve is sampled at least once for so much turning, in radians: an arc of 90 degrees twice.
const TURN: f64 = 1.0;
/// Curves shorter than this share of the spacing have no samples between their ends.
const TINY: f64 = 0.25;
/// Samples of one curve at most.
const MANY: usize = 1024;
/// Where the drawn line turns more than this cosine says, it has a corner: about 10 degrees.
const CORNER: f64 = 0.985;
/// How much a handle's length prefers to change as the chord does, against the samples between.
const PREFERENCE: f64 = 0.02;

/// A path and its samples.
#[derive(Clone, Debug)]
pub(super) struct Bending {
    samples: Vec<Vec2>,
    contours: Vec<Contour>,
    pieces: usize,
}

/// A subpath.
#[derive(Clone, Debug)]
struct Contour {
    /// Its first sample, and how many steps there are from each to the next.
    first: usize,
    steps: usize,
    /// Whether the last step leads to the first sample.
    round: bool,
    /// Whether it is closed by a close.
    closed: bool,
    /// Number of the element that moves to its start, not counting closes.
    element: usize,
    pieces: Vec<Piece>,
}

/// One curve or line of the drawn path.
#[derive(Clone, Debug)]
struct Piece {
    curve: CubicBez,
    straight: bool,
    /// Whether it is the line that a close implies.
    implied: bool,
    /// The step with which it begins, and the parameters of its samples.
    from: usize,
    params: Vec<f64>,
    /// Whether the line goes on smoothly before and behind it.
    smooth: [bool; 2],
    /// Number of its element, not counting closes.
    element: usize,
}

/// Into how many parts each piece is cut; 0 for a line that stays one.
pub(super) type Cuts = Vec<u16>;

impl Piece {
    fn steps(&self) -> usize {
        self.params.len() - 1
    }

    /// The step, counted from its first, at which part `part` of `parts` begins.
    fn cut(&self, part: usize, parts: usize) -> usize {
        (part * self.steps() + parts / 2) / parts
    }
}

impl Bending {
    /// The path with samples about `spacing` apart.
    pub(super) fn new(path: &BezPath, spacing: f64) -> Self {
        let mut own = Self { samples: Vec::new(), contours: Vec::new(), pieces: 0 };
        let mut open: Option<Contour> = None;
        let (mut start, mut at, mut element) = (Point::ZERO, Point::ZERO, 0);
        for el in path.elements() {
            if let PathEl::MoveTo(p) = *el {
                own.finish(open.take());
                (start, at) = (p, p);
                open = Some(own.begin(p, element));
                element += 1;
                continue;
            }
            // What goes on after a close goes on where it closed.
            let contour = open.get_or_insert_with(|| own.begin(start, element.saturating_sub(1)));
            let (curve, straight) = match *el {
                PathEl::MoveTo(_) | PathEl::ClosePath => (line(at, start), true),
                PathEl::LineTo(p) => (line(at, p), true),
                PathEl::QuadTo(c, p) => (kurbo::QuadBez::new(at, c, p).raise(), false),
                PathEl::CurveTo(c, d, p) => (CubicBez::new(at, c, d, p), false),
            };
            let implied = matches!(el, PathEl::ClosePath);
            // A close that has no way to go is no piece.
            if !implied || at.distance(start) > 1e-6 * spacing {
                own.add(contour, Piece::new(curve, straight, implied, spacing, contour.steps, element));
            }
            at = curve.p3;
            if implied {
                contour.closed = true;
                at = start;
                own.finish(open.take());
            } else {
                element += 1;
            }
        }
        own.finish(open);
        own
    }

    fn begin(&mut self, p: Point, element: usize) -> Contour {
        self.samples.push(vec2(p));
        let first = self.samples.len() - 1;
        Contour { first, steps: 0, round: false, closed: false, element, pieces: Vec::new() }
    }

    fn add(&mut self, contour: &mut Contour, piece: Piece) {
        self.samples.extend(piece.params[1..].iter().map(|&t| vec2(piece.curve.eval(t))));
        contour.steps += piece.steps();
        contour.pieces.push(piece);
        self.pieces += 1;
    }

    fn finish(&mut self, contour: Option<Contour>) {
        let Some(mut contour) = contour else { return };
        // A path that ends where it began goes round, whether or not it says so.
        let last = self.samples[self.samples.len() - 1];
        if contour.steps > 2 && self.samples[contour.first].distance(last) < 1e-4 {
            self.samples.pop();
            contour.round = true;
        }
        let n = contour.pieces.len();
        for i in 0..n {
            let next = (i + 1) % n;
            if next == 0 && !contour.round {
                break;
            }
            let leaves = end_tangent(&contour.pieces[i].curve);
            let arrives = start_tangent(&contour.pieces[next].curve);
            let smooth = leaves.dot(arrives) >= CORNER;
            contour.pieces[i].smooth[1] = smooth;
            contour.pieces[next].smooth[0] = smooth;
        }
        self.contours.push(contour);
    }

    /// Where the samples are at rest.
    pub(super) fn samples(&self) -> &[Vec2] {
        &self.samples
    }

    /// The samples of each subpath, in order, and whether the first follows the last.
    pub(super) fn lines(&self) -> impl Iterator<Item = (&[Vec2], bool)> {
        self.contours.iter().map(|c| {
            let count = if c.round { c.steps } else { c.steps + 1 };
            (&self.samples[c.first..c.first + count], c.round)
        })
    }

    /// Parts of about `steps` samples.
    pub(super) fn even_cuts(&self, steps: usize) -> Cuts {
        let pieces = self.contours.iter().flat_map(|c| &c.pieces);
        pieces.map(|p| if p.steps() == 1 && p.straight { 0 } else { p.steps().div_ceil(steps) as u16 }).collect()
    }

    /// The fewest parts that follow the samples in all `frames` to within `tolerance`.
    pub(super) fn cuts<'a, F: Iterator<Item = &'a [Vec2]>>(&self, frames: impl Fn() -> F, tolerance: f64) -> Cuts {
        let mut cuts = Cuts::with_capacity(self.pieces);
        for contour in &self.contours {
            for piece in &contour.pieces {
                let n = piece.steps();
                let fits = |parts: usize| frames().all(|at| self.misses(contour, piece, parts, at) <= tolerance);
                let tries = (0..=4).chain((3..).map(|k| 2 * k)).map(|parts: usize| parts.min(n));
                let least = usize::from(!piece.straight);
                let found = tries.filter(|&parts| parts >= least).find(|&parts| parts == n || fits(parts));
                cuts.push(found.unwrap_or(n) as u16);
            }
        }
        cuts
    }

    /// How far the samples of a piece in `parts` parts are from its curves.
    fn misses(&self, contour: &Contour, piece: &Piece, parts: usize, at: &[Vec2]) -> f64 {
        let mut most = 0f64;
        for part in 0..parts.max(1) {
            let (a, b) = (piece.cut(part, parts.max(1)), piece.cut(part + 1, parts.max(1)));
            if b - a < 2 {
                continue;
            }
            let curve = if parts == 0 {
                line(point(self.moved(contour, piece.from, at)), point(self.moved(contour, piece.from + b, at)))
            } else {
                self.part(contour, piece, (a, b), at)
            };
            for k in a + 1..b {
                let t = (piece.params[k] - piece.params[a]) / (piece.params[b] - piece.params[a]);
                let gap = self.moved(contour, piece.from + k, at) - dvec2(curve.eval(t).x, curve.eval(t).y);
                // Along the line nothing shows.
                let along = curve.deriv().eval(t).to_vec2();
                let across = match dvec2(along.x, along.y).try_normalize() {
                    Some(d) => gap.perp_dot(d).abs(),
                    None => gap.length(),
                };
                most = most.max(across);
            }
        }
        most
    }

    /// The path through the samples where they are `at`.
    pub(super) fn path(&self, at: &[Vec2], cuts: &[u16]) -> BezPath {
        let mut path = BezPath::new();
        let mut cuts = cuts.iter();
        for contour in &self.contours {
            path.move_to(point(self.moved(contour, 0, at)));
            for piece in &contour.pieces {
                match (*cuts.next().unwrap_or(&1) as usize, piece.implied) {
                    (0, true) => {}
                    (0, false) => path.line_to(point(self.moved(contour, piece.from + piece.steps(), at))),
                    (parts, _) => {
                        for part in 0..parts {
                            let curve =
                                self.part(contour, piece, (piece.cut(part, parts), piece.cut(part + 1, parts)), at);
                            path.curve_to(curve.p1, curve.p2, curve.p3);
                        }
                    }
                }
            }
            if contour.closed {
                path.close_path();
            }
        }
        path
    }

    /// The pen's widths at the points of [`Self::path`], from those at the drawn path's.
    pub(super) fn widths(&self, widths: &[f32], cuts: &[u16]) -> Vec<f32> {
        let width = |element: usize| widths.get(element).copied().unwrap_or(0.0);
        let mut out = Vec::new();
        let mut cuts = cuts.iter();
        for contour in &self.contours {
            let first = width(contour.element);
            out.push(first);
            let mut from = first;
            for piece in &contour.pieces {
                let to = if piece.implied { first } else { width(piece.element) };
                match (*cuts.next().unwrap_or(&1) as usize, piece.implied) {
                    (0, true) => {}
                    (0, false) => out.push(to),
                    (parts, _) => out.extend((1..=parts).map(|part| {
                        let share = piece.cut(part, parts) as f32 / piece.steps() as f32;
                        from + (to - from) * share
                    })),
                }
                from = to;
            }
        }
        out
    }

    /// Where the sample after `step` steps is.
    fn moved(&self, contour: &Contour, step: usize, at: &[Vec2]) -> DVec2 {
        at[contour.first + if contour.round { step % contour.steps } else { step }].as_dvec2()
    }

    /// How the chord of a step turned and stretched, as a complex number; `None` at an end and where it has no length.
    fn chord(&self, contour: &Contour, step: isize, at: &[Vec2]) -> Option<DVec2> {
        let n = contour.steps as isize;
        let step = if contour.round { step.rem_euclid(n) } else { step };
        if step < 0 || step >= n {
            return None;
        }
        let (i, j) = (step as usize, step as usize + 1);
        let rest = self.moved(contour, j, &self.samples) - self.moved(contour, i, &self.samples);
        let now = self.moved(contour, j, at) - self.moved(contour, i, at);
        let square = rest.length_squared();
        (square > 1e-12).then(|| dvec2(rest.dot(now), rest.perp_dot(now)) / square)
    }

    /// How the line turned at a sample: by what is before it, behind it, or both.
    fn turn(&self, contour: &Contour, step: usize, before: bool, behind: bool, at: &[Vec2]) -> DVec2 {
        let step = step as isize;
        let one = |near: isize, far: isize| {
            let near = self.chord(contour, near, at)?.try_normalize()?;
            // The chord turned as its middle did, half a step away.
            let half = self.chord(contour, far, at).and_then(DVec2::try_normalize).map(|far| {
                let bend = dvec2(near.dot(far), far.perp_dot(near));
                (bend + DVec2::X).try_normalize().unwrap_or(DVec2::X)
            });
            Some(half.map_or(near, |half| half.rotate(near)))
        };
        let two = || {
            let (a, b) = (self.chord(contour, step - 1, at)?, self.chord(contour, step, at)?);
            (a.try_normalize()? + b.try_normalize()?).try_normalize()
        };
        let found = if before && behind { two() } else { None };
        let side = || if behind { one(step, step + 1) } else { None }.or_else(|| one(step - 1, step - 2));
        found.or_else(side).or_else(|| one(step, step + 1)).unwrap_or(DVec2::X)
    }

    /// The curve from step `a` of a piece to step `b`.
    fn part(&self, contour: &Contour, piece: &Piece, (a, b): (usize, usize), at: &[Vec2]) -> CubicBez {
        let rest = piece.curve.subsegment(piece.params[a]..piece.params[b]);
        let (from, to) = (self.moved(contour, piece.from + a, at), self.moved(contour, piece.from + b, at));
        let turn_from = self.turn(contour, piece.from + a, a > 0 || piece.smooth[0], true, at);
        let turn_to = self.turn(contour, piece.from + b, true, b < piece.steps() || piece.smooth[1], at);
        let way = |p: Point, q: Point| dvec2(q.x - p.x, q.y - p.y);
        let (out, back) = (turn_from.rotate(way(rest.p0, rest.p1)), turn_to.rotate(way(rest.p3, rest.p2)));
        let chord = way(rest.p0, rest.p3).length();
        let scale = if chord > 1e-9 { from.distance(to) / chord } else { 1.0 };
        let (mut matrix, mut right) = ([0.0f64; 3], [0.0f64; 2]);
        for k in a + 1..b {
            let t = (piece.params[k] - piece.params[a]) / (piece.params[b] - piece.params[a]);
            let s = 1.0 - t;
            let (one, two) = (out * (3.0 * s * s * t), back * (3.0 * s * t * t));
            let base = from * (s * s * (s + 3.0 * t)) + to * (t * t * (t + 3.0 * s));
            let gap = self.moved(contour, piece.from + k, at) - base;
            matrix = [matrix[0] + one.dot(one), matrix[1] + one.dot(two), matrix[2] + two.dot(two)];
            right = [right[0] + one.dot(gap), right[1] + two.dot(gap)];
        }
        let prefers = PREFERENCE * (matrix[0] + matrix[2]);
        let (xx, yy) = (matrix[0] + prefers, matrix[2] + prefers);
        let (rx, ry) = (right[0] + prefers * scale, right[1] + prefers * scale);
        let determinant = xx * yy - matrix[1] * matrix[1];
        let fitted = |value: f64| if value.is_finite() { value.clamp(0.25 * scale, 4.0 * scale) } else { scale };
        let (long, back_long) = if determinant > 0.0 {
            (fitted((rx * yy - ry * matrix[1]) / determinant), fitted((ry * xx - rx * matrix[1]) / determinant))
        } else {
            (scale, scale)
        };
        CubicBez::new(point(from), point(from + out * long), point(to + back * back_long), point(to))
    }
}

impl Piece {
    fn new(curve: CubicBez, straight: bool, implied: bool, spacing: f64, from: usize, element: usize) -> Self {
        const TABLE: usize = 32;
        let at = |i: usize| curve.eval(i as f64 / TABLE as f64);
        let mut lengths = [0.0; TABLE + 1];
        for i in 1..=TABLE {
            lengths[i] = lengths[i - 1] + at(i - 1).distance(at(i));
        }
        // A long way that a table of chords would miss counts as it is.
        let length = if lengths[TABLE] > 8.0 * spacing { curve.arclen(0.1 * spacing) } else { lengths[TABLE] };
        let legs = [curve.p1 - curve.p0, curve.p2 - curve.p1, curve.p3 - curve.p2];
        let turned: f64 =
            legs.windows(2)
                .map(|l| {
                    if l[0].hypot2() * l[1].hypot2() > 0.0 { l[0].cross(l[1]).atan2(l[0].dot(l[1])).abs() } else { 0.0 }
                })
                .sum();
        let by_turn = if straight || length < TINY * spacing { 1.0 } else { turned / TURN };
        let n = (length / spacing).max(by_turn).ceil().clamp(1.0, MANY as f64) as usize;
        let mut k = 0;
        let param = |i: usize| {
            if i == n || straight {
                return i as f64 / n as f64;
            }
            let goal = lengths[TABLE] * i as f64 / n as f64;
            while k + 1 < TABLE && lengths[k + 1] < goal {
                k += 1;
            }
            let step = lengths[k + 1] - lengths[k];
            (k as f64 + if step > 0.0 { (goal - lengths[k]) / step } else { 0.0 }) / TABLE as f64
        };
        let params = (0..=n).map(param).collect();
        Self { curve, straight, implied, from, params, smooth: [false; 2], element }
    }
}

fn line(from: Point, to: Point) -> CubicBez {
    let line = Line::new(from, to);
    CubicBez::new(from, line.eval(1.0 / 3.0), line.eval(2.0 / 3.0), to)
}

fn start_tangent(curve: &CubicBez) -> DVec2 {
    let ways = [curve.p1, curve.p2, curve.p3].map(|p| p - curve.p0);
    ways.into_iter().find_map(|w| dvec2(w.x, w.y).try_normalize()).unwrap_or(DVec2::ZERO)
}

fn end_tangent(curve: &CubicBez) -> DVec2 {
    let ways = [curve.p2, curve.p1, curve.p0].map(|p| curve.p3 - p);
    ways.into_iter().find_map(|w| dvec2(w.x, w.y).try_normalize()).unwrap_or(DVec2::ZERO)
}

fn vec2(p: Point) -> Vec2 {
    Vec2::new(p.x as f32, p.y as f32)
}

fn point(p: DVec2) -> Point {
    Point::new(p.x, p.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use kurbo::{ParamCurveNearest, PathSeg};
    use proptest::prelude::*;

    /// The largest distance from points of `a` to `b`.
    fn apart(a: &BezPath, b: &BezPath) -> f64 {
        let others: Vec<PathSeg> = b.segments().collect();
        let near =
            |p: Point| others.iter().map(|s| s.nearest(p, 1e-9).distance_sq).fold(f64::INFINITY, f64::min).sqrt();
        let points = a.segments().flat_map(|s| (0..=8).map(move |k| s.eval(f64::from(k) / 8.0)));
        points.map(near).fold(0.0, f64::max)
    }

    fn kinds(path: &BezPath) -> Vec<std::mem::Discriminant<PathEl>> {
        path.elements().iter().map(std::mem::discriminant).collect()
    }

    const DRAWN: [&str; 6] = [
        "M 10 10 C 60 -40 90 80 140 20",
        "M 10 10 H 90 Q 120 10 120 60 Z",
        "M 100 50 C 100 78 78 100 50 100 S 0 78 0 50 S 22 0 50 0 S 100 22 100 50 Z M 60 60 L 40 60 L 50 40 Z",
        "M 5 5 Z",
        "M 5 5 L 5 5",
        "M 0 0 C 50 50 50 -50 0 0 L 30 -40",
    ];

    #[test]
    fn at_rest_and_moved_as_a_whole_a_path_is_itself() {
        let turn = |p: Vec2| Vec2::from_angle(0.7).rotate(p) * 1.5 + Vec2::new(30.0, -8.0);
        let affine = kurbo::Affine::translate((30.0, -8.0)) * kurbo::Affine::rotate(0.7) * kurbo::Affine::scale(1.5);
        for svg in DRAWN {
            let path = BezPath::from_svg(svg).expect("a path");
            let own = Bending::new(&path, 7.0);
            let moved: Vec<Vec2> = own.samples().iter().map(|p| turn(*p)).collect();
            for cuts in [own.even_cuts(3), own.cuts(|| [own.samples(), &moved[..]].into_iter(), 0.05)] {
                let (rest, there) = (own.path(own.samples(), &cuts), own.path(&moved, &cuts));
                assert_eq!(kinds(&rest), kinds(&there), "{svg}");
                assert_eq!(rest.segments().count() == 0, path.segments().count() == 0);
                if path.segments().count() > 0 {
                    assert!(apart(&rest, &path) < 1e-3 && apart(&path, &rest) < 1e-3, "{svg}: {}", rest.to_svg());
                    assert!(apart(&there, &(affine * path.clone())) < 1e-2, "{svg}");
                }
            }
            let least = own.cuts(|| std::iter::once(own.samples()), 0.01);
            assert_eq!(own.path(own.samples(), &least).elements().len(), path.elements().len(), "{svg} is cut");
        }
    }

    proptest! {
        /// However the plane bends smoothly, the curves follow it, their ends exactly, and smooth places stay smooth.
        #[test]
        fn curves_follow_a_bending_plane(bend in 0.002f32..0.012, which in 0usize..3, phase in 0f32..6.0) {
            let path = BezPath::from_svg(DRAWN[which]).expect("a path");
            let own = Bending::new(&path, 6.0);
            let moves = |p: Vec2| {
                let angle = bend * (p.x + 0.5 * p.y) + phase;
                Vec2::new(p.x + 8.0 * (0.05 * p.y + phase).sin(), p.y + 12.0 * angle.sin() / bend.max(0.01) * 0.05)
            };
            let moved: Vec<Vec2> = own.samples().iter().map(|p| moves(*p)).collect();
            let cuts = own.cuts(|| std::iter::once(&moved[..]), 0.2);
            let found = own.path(&moved, &cuts);
            let mut fine = BezPath::new();
            for (i, s) in path.segments().enumerate() {
                for k in 0..=64 {
                    let p = s.eval(f64::from(k) / 64.0);
                    let q = point(moves(vec2(p)).as_dvec2());
                    if i == 0 && k == 0 { fine.move_to(q) } else { fine.line_to(q) }
                }
            }
            prop_assert!(apart(&found, &fine) < 0.6, "{} {}", apart(&found, &fine), found.to_svg());
            prop_assert!(found.elements().len() < 8 * path.elements().len());
            let segments: Vec<CubicBez> = found.segments().map(|s| s.to_cubic()).collect();
            if which == 0 {
                for pair in segments.windows(2) {
                    prop_assert!(end_tangent(&pair[0]).dot(start_tangent(&pair[1])) > 0.999);
                }
                prop_assert_eq!(segments[0].p0, point(moved[0].as_dvec2()));
            }
        }
    }

    #[test]
    fn widths_are_carried_to_the_cuts() {
        let path = BezPath::from_svg("M 0 0 H 100 C 150 0 150 100 100 100 Z").expect("a path");
        let own = Bending::new(&path, 10.0);
        let cuts = own.even_cuts(5);
        let widths = own.widths(&[1.0, 3.0, 5.0], &cuts);
        let points =
            own.path(own.samples(), &cuts).elements().iter().filter(|e| !matches!(e, PathEl::ClosePath)).count();
        assert_eq!(widths.len(), points);
        assert_eq!((widths[0], widths[1], widths[2]), (1.0, 2.0, 3.0));
        assert_eq!(own.widths(&[1.0, 3.0, 5.0], &own.cuts(|| std::iter::once(own.samples()), 0.1)), [1.0, 3.0, 5.0]);
    }
}
