//! Strokes drawn by hand: the samples of a pen become a smooth path with widths.
//!
//! Samples that repeat a place are joined, corners are found, and between them cubics are fitted within a tolerance
//! (Schneider 1990, "An Algorithm for Automatically Fitting Digitized Curves": least squares with the tangents at both
//! ends given, parameters improved by Newton's method, split at the worst sample), so that jitter below the tolerance is
//! smoothed. Where the pressure changes between two points of the path by more than widths in a row can say, the path is
//! split too.
//!
//! The file: `{"format":"marey-drawing","version":1,"size":[W,H],"strokes":[{"name","points":[[x,y,pressure],..],"width",
//! "color":"#rrggbb"}]}`; name, pressure, width and colour may be left out. Unknown keys are ignored, an unknown version is
//! an error.

use std::path::Path;

use kurbo::{BezPath, CubicBez, ParamCurve, ParamCurveDeriv, Point, Vec2};
use serde::Deserialize;

use super::drawing::{Drawing, MAX_PIXELS, MAX_STROKES, Paint, Pen, Stroke};
use crate::error::{Error, Result};

const FORMAT: &str = "marey-drawing";
const VERSION: u32 = 1;
/// Samples of a drawing: five hours of a pen at 240 a second.
const MAX_SAMPLES: usize = 4_000_000;
/// The pressure that draws at the pen's own width, as a mouse reports it.
const PLAIN: f64 = 0.5;
/// Width in pen widths at no pressure, and at the plain one 1: full pressure draws 1.75.
const LIGHTEST: f64 = 0.25;
/// The turn, in radians, from which a place is a corner: 60 degrees within a few tolerances is no arc by hand.
const CORNER: f64 = std::f64::consts::FRAC_PI_3;
/// How far before and behind a place its turn is measured, in tolerances: beyond the jitter.
const ARM: f64 = 6.0;
/// Rounds of improving parameters; more change nothing visible.
const ROUNDS: usize = 4;
/// The width, in pen widths, by which a straight change of width may miss the pressure.
const WIDTH_TOLERANCE: f64 = 0.06;

/// What a pen reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PenSample {
    /// Where it is, in pixels of the page.
    pub at: Point,
    /// How hard it is pressed, 0..=1; 0.5 where the device cannot tell.
    pub pressure: f64,
}

impl Stroke {
    /// The stroke that a pen drew, no farther than about `tolerance` pixels from its samples. `pen` has the width at a
    /// pressure of 0.5; where the pressure changes the stroke gets widths. A pen that does not move leaves a dot.
    ///
    /// # Errors
    /// There is no sample, or one is no number, or the tolerance is not above 0.
    pub fn freehand(name: impl Into<String>, samples: &[PenSample], mut pen: Pen, tolerance: f64) -> Result<Self> {
        let name = name.into();
        let bad = |problem: String, remedy: &str| Error::invalid(format!("stroke `{name}`"), problem, remedy);
        if samples.is_empty() {
            return Err(bad("it has no points".into(), "give one at least"));
        }
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(bad(format!("a tolerance of {tolerance}"), "use one above 0 pixels"));
        }
        let near = |v: f64| v.abs() <= MAX_PIXELS;
        if let Some(i) =
            samples.iter().position(|s| !(near(s.at.x) && near(s.at.y) && (0.0..=1.0).contains(&s.pressure)))
        {
            return Err(bad(
                format!("point {i} is no place near the page with a pressure in 0..=1"),
                "give finite numbers in pixels",
            ));
        }
        let samples = joined(samples, tolerance);
        let (path, pressures) = fitted(&samples, tolerance);
        let widths: Vec<f32> = pressures.iter().map(|p| (pen.width * width_of(*p)) as f32).collect();
        let even = widths.iter().all(|w| (w - widths[0]).abs() <= 0.01 * widths[0]);
        if even {
            pen.width = widths[0].into();
        } else {
            pen.widths = widths;
        }
        Ok(Self { name, path, pen: Some(pen), ..Self::default() })
    }
}

fn width_of(pressure: f64) -> f64 {
    LIGHTEST + (1.0 - LIGHTEST) / PLAIN * pressure
}

#[derive(Deserialize)]
struct FreehandFile {
    format: String,
    version: u32,
    size: (f64, f64),
    strokes: Vec<FreehandStroke>,
}

#[derive(Deserialize)]
struct FreehandStroke {
    #[serde(default)]
    name: String,
    points: Vec<Vec<f64>>,
    width: Option<f64>,
    color: Option<String>,
}

impl Drawing {
    /// Reads a file of freehand strokes.
    ///
    /// # Errors
    /// The file cannot be read, or what it says is no drawing.
    pub fn read_freehand(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_freehand_json(&text).map_err(|e| e.in_file(path))
    }

    /// The drawing that the text of a file of freehand strokes says. Strokes follow the pen within a thousandth of the
    /// page's diagonal.
    ///
    /// # Errors
    /// It is no such file, or what it says is no drawing.
    pub fn from_freehand_json(text: &str) -> Result<Self> {
        let file: FreehandFile = serde_json::from_str(text)
            .map_err(|e| Error::invalid("drawing", format!("not readable: {e}"), "expected a marey-drawing file"))?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(Error::invalid(
                "drawing",
                format!("the file says {} version {}", file.format, file.version),
                format!("expected {FORMAT} version {VERSION}"),
            ));
        }
        super::drawing::check_page(file.size)?;
        let bound = |what: &str, value: usize, max: usize| {
            let remedy = "simplify the drawing".to_owned();
            (value > max).then(|| Error::Limit { what: what.into(), value: value as u64, max: max as u64, remedy })
        };
        let count = file.strokes.iter().map(|s| s.points.len()).sum();
        let over = bound("strokes of a drawing", file.strokes.len(), MAX_STROKES);
        over.or(bound("points of a drawing", count, MAX_SAMPLES)).map_or(Ok(()), Err)?;
        let mut names: std::collections::HashSet<String> = file.strokes.iter().map(|s| s.name.clone()).collect();
        let tolerance = file.size.0.hypot(file.size.1) / 1000.0;
        let mut drawing = Self { size: file.size, ..Self::default() };
        let mut unnamed = 0;
        for (i, stroke) in file.strokes.into_iter().enumerate() {
            let mut name = stroke.name;
            while name.is_empty() {
                unnamed += 1;
                let next = format!("stroke{unnamed}");
                if names.insert(next.clone()) {
                    name = next;
                }
            }
            let bad = |problem: String, remedy: &str| Error::invalid(format!("stroke {i} `{name}`"), problem, remedy);
            let sample = |p: &Vec<f64>| match p[..] {
                [x, y] => Some(PenSample { at: Point::new(x, y), pressure: PLAIN }),
                [x, y, pressure] => Some(PenSample { at: Point::new(x, y), pressure }),
                _ => None,
            };
            let samples: Option<Vec<PenSample>> = stroke.points.iter().map(sample).collect();
            let samples = samples.ok_or_else(|| bad("a point is not [x, y] or [x, y, pressure]".into(), "mend it"))?;
            // As wide as a felt pen on a page.
            let mut pen = Pen::plain(stroke.width.unwrap_or(4.0 * tolerance));
            if let Some(color) = &stroke.color {
                pen.paint =
                    Paint::Color(color_of(color).ok_or_else(|| bad(format!("the colour `{color}`"), "use #rrggbb"))?);
            }
            drawing.strokes.push(Stroke::freehand(name, &samples, pen, tolerance)?);
        }
        drawing.validate()?;
        Ok(drawing)
    }
}

fn color_of(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let part = |i: usize| u8::from_str_radix(&digits[i..i + 2], 16).ok();
    Some([part(0)?, part(2)?, part(4)?])
}

/// The samples with those that stay within a twentieth of the tolerance made one; the mean of their pressures.
fn joined(samples: &[PenSample], tolerance: f64) -> Vec<PenSample> {
    let mut out: Vec<PenSample> = Vec::with_capacity(samples.len());
    let mut weight = 1.0;
    for &sample in samples {
        match out.last_mut() {
            Some(last) if last.at.distance(sample.at) < tolerance / 20.0 => {
                weight += 1.0;
                last.pressure += (sample.pressure - last.pressure) / weight;
            }
            _ => {
                out.push(sample);
                weight = 1.0;
            }
        }
    }
    out
}

/// The path through samples, and the pressure at each of its points.
fn fitted(samples: &[PenSample], tolerance: f64) -> (BezPath, Vec<f64>) {
    let mut path = BezPath::new();
    path.move_to(samples[0].at);
    if samples.iter().all(|s| s.at.distance(samples[0].at) < tolerance / 4.0) {
        // A line of no length: drawn as a dot by round ends.
        path.line_to(samples[0].at);
        let pressure = samples.iter().map(|s| s.pressure).fold(0.0, f64::max);
        return (path, vec![pressure; 2]);
    }
    let pressures = smoothed(samples);
    let mut at = vec![pressures[0]];
    let corners = corners(samples, ARM * tolerance);
    for ends in corners.windows(2) {
        let piece = Piece { samples: &samples[ends[0]..=ends[1]], pressures: &pressures[ends[0]..=ends[1]], tolerance };
        let last = piece.samples.len() - 1;
        piece.fit(0, last, piece.tangent(0, 1), piece.tangent(last, -1), &mut path, &mut at);
    }
    (path, at)
}

/// Pressures without the noise of single samples.
fn smoothed(samples: &[PenSample]) -> Vec<f64> {
    let p = |i: usize| samples[i.min(samples.len() - 1)].pressure;
    (0..samples.len()).map(|i| 0.25 * p(i.saturating_sub(1)) + 0.5 * p(i) + 0.25 * p(i + 1)).collect()
}

/// Where the way turns sharply, and both ends.
fn corners(samples: &[PenSample], arm: f64) -> Vec<usize> {
    let last = samples.len() - 1;
    // The first place at least an arm away, on either side; the end where there is none.
    let reach = |i: usize, step: isize| {
        let mut k = i;
        while let Some(next) = k.checked_add_signed(step).filter(|&k| k <= last) {
            k = next;
            if samples[k].at.distance(samples[i].at) >= arm {
                break;
            }
        }
        k
    };
    let turn = |i: usize| {
        let (before, behind) = (samples[i].at - samples[reach(i, -1)].at, samples[reach(i, 1)].at - samples[i].at);
        before.cross(behind).atan2(before.dot(behind)).abs()
    };
    let turns: Vec<f64> = (0..=last).map(|i| if i == 0 || i == last { 0.0 } else { turn(i) }).collect();
    let mut out = vec![0];
    for i in 1..last {
        if turns[i] < CORNER {
            continue;
        }
        let (from, to) = (reach(i, -1), reach(i, 1));
        // The sharpest within an arm; the first of equals.
        let sharpest = (from..i).all(|k| turns[k] < turns[i]) && (i + 1..=to).all(|k| turns[k] <= turns[i]);
        if sharpest {
            out.push(i);
        }
    }
    out.push(last);
    out
}

/// Samples between two corners.
struct Piece<'a> {
    samples: &'a [PenSample],
    pressures: &'a [f64],
    tolerance: f64,
}

impl Piece<'_> {
    fn at(&self, i: usize) -> Point {
        self.samples[i].at
    }

    /// The direction from sample `i` toward higher (1) or lower (-1) ones, over a stretch longer than the jitter.
    fn tangent(&self, i: usize, step: isize) -> Vec2 {
        let mut sum = Vec2::ZERO;
        let mut k = i;
        while let Some(next) = k.checked_add_signed(step).filter(|&k| k < self.samples.len()) {
            k = next;
            let arm = self.at(k) - self.at(i);
            sum += arm;
            if arm.hypot() > 3.0 * self.tolerance {
                break;
            }
        }
        unit(sum).or_else(|| unit(self.at(k) - self.at(i))).unwrap_or(Vec2::new(step as f64, 0.0))
    }

    fn fit(&self, from: usize, to: usize, t0: Vec2, t1: Vec2, path: &mut BezPath, at: &mut Vec<f64>) {
        // A stack, since a scribble splits deeply.
        let mut waiting = vec![(from, to, t0, t1)];
        while let Some((from, to, t0, t1)) = waiting.pop() {
            let (curve, worst) = self.curve(from, to, t0, t1);
            let Some(split) = worst.filter(|_| to - from > 1) else {
                path.curve_to(curve.p1, curve.p2, curve.p3);
                at.push(self.pressures[to]);
                continue;
            };
            let along =
                unit(self.tangent(split, 1) - self.tangent(split, -1)).unwrap_or_else(|| self.tangent(split, 1));
            waiting.push((split, to, along, t1));
            waiting.push((from, split, t0, -along));
        }
    }

    /// The best cubic over samples `from..=to`, and where to split when it is not good enough.
    fn curve(&self, from: usize, to: usize, t0: Vec2, t1: Vec2) -> (CubicBez, Option<usize>) {
        let (p0, p3) = (self.at(from), self.at(to));
        let mut params = vec![0.0];
        for i in from + 1..=to {
            params.push(params[i - from - 1] + self.at(i).distance(self.at(i - 1)));
        }
        let length = params[to - from].max(1e-12);
        params.iter_mut().for_each(|u| *u /= length);
        let lengths = params.clone();
        let third = length / 3.0;
        let mut best =
            CubicBez::new(p0, p0 + t0 * third.min(p0.distance(p3)), p3 + t1 * third.min(p0.distance(p3)), p3);
        if to - from == 1 {
            return (best, None);
        }
        let mut least = (f64::INFINITY, from + 1);
        for _ in 0..=ROUNDS {
            let curve = self.least_squares(from, to, &params, t0, t1, length);
            let (mut worst, mut place) = (0.0, from + 1);
            for i in from + 1..to {
                let off = curve.eval(params[i - from]).distance(self.at(i));
                if off > worst {
                    (worst, place) = (off, i);
                }
            }
            if worst < least.0 {
                (least, best) = ((worst, place), curve);
            }
            // Newton cannot bridge more.
            if worst <= self.tolerance || worst > 16.0 * self.tolerance {
                break;
            }
            let (d1, d2) = (curve.deriv(), curve.deriv().deriv());
            for i in from + 1..to {
                let u = &mut params[i - from];
                let (off, v, a) = (curve.eval(*u) - self.at(i), d1.eval(*u).to_vec2(), d2.eval(*u).to_vec2());
                let slope = v.hypot2() + off.dot(a);
                if slope.abs() > 1e-12 {
                    *u = (*u - off.dot(v) / slope).clamp(0.0, 1.0);
                }
            }
        }
        if least.0 > self.tolerance {
            return (best, Some(least.1));
        }
        let (w0, w1) = (width_of(self.pressures[from]), width_of(self.pressures[to]));
        let missed = |i: usize| (width_of(self.pressures[i]) - (w0 + (w1 - w0) * lengths[i - from])).abs();
        let worst = (from + 1..to).max_by(|&a, &b| missed(a).total_cmp(&missed(b)));
        (best, worst.filter(|&i| missed(i) > WIDTH_TOLERANCE))
    }

    fn least_squares(&self, from: usize, to: usize, params: &[f64], t0: Vec2, t1: Vec2, length: f64) -> CubicBez {
        let (p0, p3) = (self.at(from), self.at(to));
        let (mut c00, mut c01, mut c11, mut x0, mut x1) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for i in from..=to {
            let u = params[i - from];
            let v = 1.0 - u;
            let (b0, b1, b2, b3) = (v * v * v, 3.0 * u * v * v, 3.0 * u * u * v, u * u * u);
            let (a0, a1) = (t0 * b1, t1 * b2);
            let rest = self.at(i) - (p0.to_vec2() * (b0 + b1) + p3.to_vec2() * (b2 + b3)).to_point();
            c00 += a0.hypot2();
            c01 += a0.dot(a1);
            c11 += a1.hypot2();
            x0 += a0.dot(rest);
            x1 += a1.dot(rest);
        }
        let det = c00 * c11 - c01 * c01;
        let (mut h0, mut h1) = ((x0 * c11 - x1 * c01) / det, (c00 * x1 - c01 * x0) / det);
        // Handles that run backwards or far beyond the way make loops: Wu and Barsky's third of the way instead.
        let usable = |h: f64| h > 1e-3 * length && h < length;
        if !(usable(h0) && usable(h1)) {
            h0 = p0.distance(p3) / 3.0;
            h1 = h0;
        }
        CubicBez::new(p0, p0 + t0 * h0, p3 + t1 * h1, p3)
    }
}

fn unit(v: Vec2) -> Option<Vec2> {
    (v.hypot() > 1e-12).then(|| v.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use kurbo::{ParamCurveNearest, PathEl};
    use proptest::prelude::*;

    fn samples(points: &[(f64, f64)]) -> Vec<PenSample> {
        points.iter().map(|&(x, y)| PenSample { at: Point::new(x, y), pressure: PLAIN }).collect()
    }

    fn drawn(samples: &[PenSample], tolerance: f64) -> Stroke {
        Stroke::freehand("line", samples, Pen::plain(4.0), tolerance).expect("a stroke")
    }

    fn off(path: &BezPath, p: Point) -> f64 {
        path.segments().map(|s| s.nearest(p, 1e-6).distance_sq).fold(f64::INFINITY, f64::min).sqrt()
    }

    /// Noise that is the same on every run, in -1..=1.
    fn noise(i: usize) -> f64 {
        ((i * 7919 + 31) % 2003) as f64 / 1001.0 - 1.0
    }

    #[test]
    fn a_jittered_circle_becomes_a_few_smooth_curves() {
        let circle: Vec<(f64, f64)> = (0..400)
            .flat_map(|i| {
                let a = f64::from(i) / 400.0 * 6.0;
                let p = (
                    100.0 + 60.0 * a.cos() + 0.3 * noise(i as usize),
                    100.0 + 60.0 * a.sin() + 0.3 * noise(i as usize + 77),
                );
                // Every place comes twice.
                [p, p]
            })
            .collect();
        let stroke = drawn(&samples(&circle), 1.0);
        assert!(stroke.path.elements().len() <= 9, "{} elements", stroke.path.elements().len());
        assert!(stroke.pen.as_ref().is_some_and(|p| p.widths.is_empty() && p.width == 4.0));
        for i in 0..100 {
            let a = f64::from(i) / 100.0 * 6.0;
            assert!(off(&stroke.path, Point::new(100.0 + 60.0 * a.cos(), 100.0 + 60.0 * a.sin())) < 1.0);
        }
        // No corner where curves meet.
        for pair in stroke.path.segments().collect::<Vec<_>>().windows(2) {
            let (a, b) = (pair[0].to_cubic(), pair[1].to_cubic());
            let (before, behind) = (unit(a.p3 - a.p2).expect("moves"), unit(b.p1 - b.p0).expect("moves"));
            assert!(before.dot(behind) > 0.999);
        }
    }

    #[test]
    fn corners_stay() {
        let mut points = Vec::new();
        points.extend((0..=50).map(|i| (f64::from(i) * 2.0, 10.0)));
        points.extend((1..=50).map(|i| (100.0, 10.0 + f64::from(i) * 2.0)));
        let stroke = drawn(&samples(&points), 0.5);
        assert!(off(&stroke.path, Point::new(100.0, 10.0)) < 0.05);
        assert_eq!(stroke.path.elements().len(), 3, "two sides");
    }

    #[test]
    fn one_place_is_a_dot() {
        for points in [vec![(5.0, 6.0)], vec![(5.0, 6.0); 9]] {
            let stroke = drawn(&samples(&points), 0.5);
            let at = Point::new(5.0, 6.0);
            assert_eq!(stroke.path.elements(), [PathEl::MoveTo(at), PathEl::LineTo(at)]);
        }
    }

    #[test]
    fn pressure_becomes_width() {
        let pressed: Vec<PenSample> = (0..=200)
            .map(|i| {
                let t = f64::from(i) / 200.0;
                PenSample { at: Point::new(10.0 + 180.0 * t, 50.0), pressure: (t * std::f64::consts::PI).sin() }
            })
            .collect();
        let stroke = drawn(&pressed, 0.5);
        let pen = stroke.pen.as_ref().expect("a pen");
        assert_eq!(pen.widths.len(), stroke.path.elements().len());
        let mut seen = Vec::new();
        for (el, width) in stroke.path.elements().iter().zip(&pen.widths) {
            let x = el.end_point().expect("a place").x;
            let expected = 4.0 * width_of((((x - 10.0) / 180.0) * std::f64::consts::PI).sin());
            assert!((f64::from(*width) - expected).abs() < 0.2, "{width} at {x} for {expected}");
            seen.push(*width);
        }
        assert!(seen.iter().any(|w| *w > 6.5) && seen[0] < 1.2);
    }

    proptest! {
        #[test]
        fn any_scribble_is_followed(points in prop::collection::vec((0.0..200.0f64, 0.0..200.0f64), 1..60)) {
            let stroke = drawn(&samples(&points), 0.5);
            prop_assert!(stroke.path.is_finite());
            for (x, y) in points {
                prop_assert!(off(&stroke.path, Point::new(x, y)) < 0.6, "({}, {}) is missed", x, y);
            }
        }
    }

    #[test]
    fn files_are_read_and_bad_ones_told() {
        let file = |strokes: &str| {
            format!(r#"{{"format":"marey-drawing","version":1,"size":[200,100],"strokes":[{strokes}]}}"#)
        };
        let read = Drawing::from_freehand_json(&file(
            r##"{"points":[[1,2],[30,40]]},{"name":"leg","points":[[1,2,0.1],[30,40,0.9]],"width":3,"color":"#ff8000"}"##,
        ))
        .expect("a drawing");
        assert_eq!(read.strokes.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["stroke1", "leg"]);
        let pen = read.strokes[1].pen.as_ref().expect("a pen");
        assert_eq!(
            (pen.paint.clone(), pen.widths.len()),
            (Paint::Color([255, 128, 0]), read.strokes[1].path.elements().len())
        );
        for (bad, says) in [
            ("", "not readable"),
            (r#"{"format":"marey-points","version":1,"size":[9,9],"strokes":[]}"#, "marey-points"),
            (r#"{"format":"marey-drawing","version":2,"size":[9,9],"strokes":[]}"#, "version 2"),
            (&file(""), "no strokes"),
            (&file(r#"{"points":[]}"#), "no points"),
            (&file(r#"{"points":[[1]]}"#), "not [x, y]"),
            (&file(r#"{"points":[[1,1e300]]}"#), "point 0"),
            (&file(r#"{"points":[[1,1,7]]}"#), "pressure"),
            (&file(r#"{"points":[[1,1]],"color":"red"}"#), "`red`"),
            (&file(r#"{"points":[[1,1]],"width":0}"#), "width 0"),
            (&file(r#"{"points":[[1,1]],"name":"a"},{"points":[[1,1]],"name":"a"}"#), "another's"),
            (&file(r#"{"points":[[1,1]]}"#).replace("200,100", "0,0"), "page"),
        ] {
            let error = Drawing::from_freehand_json(bad).expect_err(bad).to_string();
            assert!(error.contains(says), "{error} for {bad}");
        }
    }

    #[test]
    fn a_pen_of_any_rate_takes_little_time() {
        let began = std::time::Instant::now();
        let long: Vec<(f64, f64)> = (0..200_000)
            .map(|i| {
                let a = f64::from(i) / 2000.0;
                (500.0 + 4.0 * a * a.cos(), 500.0 + 4.0 * a * a.sin())
            })
            .collect();
        let stroke = drawn(&samples(&long), 0.5);
        assert!(stroke.path.elements().len() < 1000);
        assert!(began.elapsed().as_secs() < 20);
    }
}
