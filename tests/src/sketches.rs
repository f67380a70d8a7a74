//! Sketches that move by formulas, for checks of what plays them.

use std::path::Path;

use anyhow::{Context as _, Result};
use kurbo::{Affine, BezPath, Circle, CubicBez, ParamCurve, PathEl, Point, QuadBez, Rect, Shape, Vec2};
use marey::export::sketch::{SketchFormat, SketchOptions, SketchSubject, write_sketch};
use marey::job::Progress;
use marey::shape::sketch::{
    Cap, Clip, Drawing, Fill, Gradient, GradientShape, Group, Join, Paint, Pen, SketchFrame, SketchTake, Spread, Stop,
    Stroke,
};

/// A drawing and what it does.
#[derive(Clone, Debug)]
pub struct SketchCase {
    /// Its name, also of its folder.
    pub name: String,
    /// The drawing.
    pub drawing: Drawing,
    /// What it does.
    pub take: SketchTake,
}

/// Three seconds at 24 frames a second.
const FRAMES: usize = 72;

/// Drawn here: sixteen lines, and one of every kind of paint.
pub fn drawn() -> Vec<SketchCase> {
    vec![bent("lines", sixteen_lines(), FRAMES), bent("paints", paints(), FRAMES)]
}

/// The drawings of a folder, as SVG.
///
/// # Errors
/// A folder that cannot be read, and a file that is no drawing.
pub fn read(folder: &Path) -> Result<Vec<SketchCase>> {
    let mut files: Vec<_> = std::fs::read_dir(folder)?.map(|e| Ok(e?.path())).collect::<Result<_>>()?;
    files.retain(|f| f.extension().is_some_and(|e| e == "svg"));
    files.sort();
    let one = |file: &std::path::PathBuf| {
        let name = file.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let drawing = Drawing::read_svg(file).with_context(|| name.clone())?.drawing;
        Ok(bent(&name, drawing, FRAMES))
    };
    files.iter().map(one).collect()
}

/// Writes the takes of a case, and its frames as pictures.
///
/// # Errors
/// What cannot be written.
pub fn write(out: &Path, case: &SketchCase, scale: f64) -> Result<()> {
    let folder = out.join(&case.name);
    std::fs::create_dir_all(&folder)?;
    let subject = SketchSubject { name: &case.name, drawing: &case.drawing, take: &case.take };
    let options = SketchOptions { scale, ..SketchOptions::default() };
    for (format, file) in
        [(SketchFormat::Svg, "sketch.svg"), (SketchFormat::Lottie, "sketch.json"), (SketchFormat::PngFolder, "frames")]
    {
        write_sketch(&folder.join(file), format, subject, &options, Progress::new().whole())?;
    }
    let truth = serde_json::json!({ "fps": case.take.fps, "frames": case.take.frames.len(), "strokes": case.drawing.strokes.len() });
    std::fs::write(folder.join("sketch-truth.json"), truth.to_string())?;
    Ok(())
}

/// A drawing that sways, waves and breathes. Curves are cut so that they can bend.
pub fn bent(name: &str, drawing: Drawing, frames: usize) -> SketchCase {
    let size = drawing.size.0.max(drawing.size.1);
    let (curves, widths): (Vec<BezPath>, Vec<Vec<f32>>) =
        drawing.strokes.iter().map(|s| cut(&s.path, s.pen.as_ref().map_or(&[][..], |p| &p.widths), 3)).unzip();
    let clips: Vec<BezPath> =
        drawing.groups.iter().map(|g| g.clip.as_ref().map_or_else(BezPath::new, |c| c.path.clone())).collect();
    let frame = |f: usize| {
        let time = std::f64::consts::TAU * f as f64 / 24.0;
        let place = move |p: Point| {
            let (u, v) = (p.x / size, p.y / size);
            let dx = 0.05 * (time + 4.0 * v).sin() + 0.02 * (2.0 * time + 7.0 * u).sin();
            let dy = 0.04 * (time + 5.0 * u).cos() + 0.015 * (2.0 * time - 6.0 * v).sin();
            p + Vec2::new(dx, dy) * size
        };
        let map = |path: &BezPath| BezPath::from_vec(path.elements().iter().map(|el| moved(*el, &place)).collect());
        let affine = |path: &BezPath| {
            let center = path.bounding_box().center();
            let step = 0.05 * size;
            let [o, x, y] = [center, center + Vec2::new(step, 0.0), center + Vec2::new(0.0, step)].map(place);
            let (x, y) = ((x - o) / step, (y - o) / step);
            Affine::translate(o.to_vec2())
                * Affine::new([x.x, x.y, y.x, y.y, 0.0, 0.0])
                * Affine::translate(-center.to_vec2())
        };
        SketchFrame {
            paths: curves.iter().map(map).collect(),
            clips: clips.iter().map(map).collect(),
            affines: curves.iter().map(affine).collect(),
        }
    };
    let order = (0..drawing.strokes.len()).collect();
    let take = SketchTake { fps: 24.0, frames: (0..frames).map(frame).collect(), order, widths };
    SketchCase { name: name.into(), drawing, take }
}

fn moved(element: PathEl, place: &dyn Fn(Point) -> Point) -> PathEl {
    match element {
        PathEl::MoveTo(p) => PathEl::MoveTo(place(p)),
        PathEl::LineTo(p) => PathEl::LineTo(place(p)),
        PathEl::QuadTo(a, p) => PathEl::QuadTo(place(a), place(p)),
        PathEl::CurveTo(a, b, p) => PathEl::CurveTo(place(a), place(b), place(p)),
        PathEl::ClosePath => PathEl::ClosePath,
    }
}

/// Every line and curve in so many pieces, and the widths at their ends.
fn cut(path: &BezPath, widths: &[f32], pieces: usize) -> (BezPath, Vec<f32>) {
    let (mut out, mut pressed, mut at, mut start, mut passed) =
        (BezPath::new(), Vec::new(), Point::ZERO, Point::ZERO, 0);
    for element in path.elements() {
        let curve = match *element {
            PathEl::MoveTo(p) => {
                out.move_to(p);
                pressed.extend(widths.get(passed));
                (at, start, passed) = (p, p, passed + 1);
                continue;
            }
            PathEl::ClosePath => {
                out.close_path();
                at = start;
                continue;
            }
            PathEl::LineTo(p) => CubicBez::new(at, at.lerp(p, 1.0 / 3.0), at.lerp(p, 2.0 / 3.0), p),
            PathEl::QuadTo(a, p) => QuadBez::new(at, a, p).raise(),
            PathEl::CurveTo(a, b, p) => CubicBez::new(at, a, b, p),
        };
        for k in 0..pieces {
            let [from, to] = [k, k + 1].map(|k| k as f64 / pieces as f64);
            let piece = curve.subsegment(from..to);
            out.curve_to(piece.p1, piece.p2, piece.p3);
            if let (Some(a), Some(b)) = (passed.checked_sub(1).and_then(|p| widths.get(p)), widths.get(passed)) {
                pressed.push(a + (b - a) * to as f32);
            }
        }
        (at, passed) = (curve.p3, passed + 1);
    }
    (out, pressed)
}

fn pen(width: f64, color: [u8; 3]) -> Pen {
    Pen {
        paint: Paint::Color(color),
        opacity: 1.0,
        width,
        widths: vec![],
        cap: Cap::Round,
        join: Join::Round,
        miter_limit: 4.0,
        dashes: vec![],
        dash_offset: 0.0,
    }
}

fn stroke(name: &str, path: BezPath) -> Stroke {
    Stroke { name: name.into(), path, ..Stroke::default() }
}

/// Lines of two curves each, on a page of 512 pixels.
fn sixteen_lines() -> Drawing {
    let line = |i: usize| {
        let at = |k: usize| {
            let angle = 2.4 * i as f64 + 1.1 * k as f64;
            Point::new(256.0, 256.0) + Vec2::from_angle(angle) * (60.0 + 11.0 * i as f64 - 14.0 * k as f64)
        };
        let mut path = BezPath::new();
        path.move_to(at(0));
        path.curve_to(at(1), at(2), at(3));
        path.curve_to(at(4), at(5), at(6));
        Stroke { pen: Some(pen(4.0, [20, 20, 40])), ..stroke(&format!("line {i}"), path) }
    };
    Drawing { size: (512.0, 512.0), strokes: (0..16).map(line).collect(), groups: vec![] }
}

/// One of every kind of paint, pen, group and clip.
fn paints() -> Drawing {
    let star = |x: f64, y: f64, radius: f64| {
        // Around twice: its middle is enclosed twice.
        let at = |k: usize| Point::new(x, y) + Vec2::from_angle(0.3 + 0.8 * std::f64::consts::PI * k as f64) * radius;
        let mut path = BezPath::new();
        path.move_to(at(0));
        (1..5).for_each(|k| path.line_to(at(k)));
        path.close_path();
        path
    };
    let rect = |x: f64, y: f64, w: f64, h: f64| Rect::new(x, y, x + w, y + h).to_path(0.1);
    let circle = |x: f64, y: f64, r: f64| Circle::new((x, y), r).to_path(0.01);
    let stop = |offset, color, opacity| Stop { offset, color, opacity };
    let fill = |paint: Paint, opacity, even_odd| Some(Fill { paint, opacity, even_odd });
    let flat = |color| fill(Paint::Color(color), 1.0, false);
    let line = GradientShape::Linear { from: Point::new(0.0, 0.0), to: Point::new(1.0, 0.0) };
    let gradient = |shape, transform, spread, stops| Paint::Gradient(Gradient { shape, transform, spread, stops });
    let mut strokes = vec![
        Stroke {
            fill: flat([230, 120, 40]),
            pen: Some(pen(6.0, [90, 30, 0])),
            ..stroke("star \"<&>\"", star(90.0, 90.0, 60.0))
        },
        Stroke { fill: fill(Paint::Color([60, 140, 200]), 0.7, true), ..stroke("odd star", star(220.0, 90.0, 60.0)) },
    ];
    let turned = Affine::translate((300.0, 40.0)) * Affine::new([90.0, 30.0, -20.0, 80.0, 0.0, 0.0]);
    let stops = vec![stop(0.0, [255, 240, 0], 1.0), stop(0.6, [220, 0, 90], 1.0), stop(1.0, [40, 0, 120], 0.4)];
    let paint = gradient(line, turned, Spread::Pad, stops);
    strokes.push(Stroke { fill: fill(paint, 1.0, false), ..stroke("linear", rect(300.0, 30.0, 110.0, 110.0)) });
    let shape = GradientShape::Radial { center: Point::new(0.0, 0.0), radius: 1.0, focus: Point::new(0.3, -0.2) };
    let stops = vec![stop(0.0, [255, 255, 255], 1.0), stop(1.0, [0, 90, 60], 1.0)];
    let oval = Affine::translate((90.0, 230.0)) * Affine::rotate(0.5) * Affine::scale_non_uniform(70.0, 40.0);
    strokes.push(Stroke {
        fill: fill(gradient(shape, oval, Spread::Pad, stops.clone()), 1.0, false),
        ..stroke("radial", circle(90.0, 230.0, 65.0))
    });
    let narrow = Affine::translate((180.0, 200.0)) * Affine::scale(22.0);
    strokes.push(Stroke {
        fill: fill(gradient(line, narrow, Spread::Reflect, stops), 1.0, false),
        ..stroke("reflected", rect(175.0, 180.0, 90.0, 100.0))
    });
    let mut corner = BezPath::new();
    corner.move_to((300.0, 270.0));
    corner.line_to((340.0, 180.0));
    corner.line_to((355.0, 265.0));
    corner.quad_to((420.0, 160.0), (430.0, 270.0));
    let sharp = Pen { cap: Cap::Square, join: Join::Miter, miter_limit: 8.0, opacity: 0.6, ..pen(10.0, [10, 60, 90]) };
    strokes.push(Stroke { pen: Some(sharp), ..stroke("corners", corner.clone()) });
    let dashed = Pen {
        cap: Cap::Butt,
        join: Join::Bevel,
        dashes: vec![14.0, 6.0, 3.0],
        dash_offset: 5.0,
        ..pen(5.0, [150, 0, 0])
    };
    strokes.push(Stroke { pen: Some(dashed), ..stroke("dashes", Affine::translate((0.0, 40.0)) * corner.clone()) });
    let below = Stroke {
        fill: flat([250, 200, 210]),
        pen: Some(pen(14.0, [120, 20, 60])),
        pen_below: true,
        ..stroke("below", circle(470.0, 80.0, 30.0))
    };
    strokes.push(below);
    let pressed = Pen { widths: vec![2.0, 14.0, 5.0, 9.0], ..pen(6.0, [30, 80, 30]) };
    strokes.push(Stroke { pen: Some(pressed), ..stroke("pressed", Affine::translate((60.0, 120.0)) * corner.clone()) });
    let inside = |group, stroke: Stroke| Stroke { group: Some(group), ..stroke };
    // Seen through as a whole, with a group in it that a circle cuts.
    strokes.push(inside(0, Stroke { fill: flat([200, 30, 30]), ..stroke("through", circle(90.0, 400.0, 55.0)) }));
    strokes.push(inside(
        0,
        Stroke {
            fill: flat([30, 30, 200]),
            pen: Some(pen(8.0, [0, 0, 0])),
            ..stroke("through too", circle(140.0, 400.0, 45.0))
        },
    ));
    strokes.push(inside(1, Stroke { fill: flat([30, 160, 60]), ..stroke("cut", rect(60.0, 400.0, 130.0, 80.0)) }));
    // Cut by a ring and by a star whose middle is outside.
    strokes.push(inside(
        2,
        Stroke { fill: flat([240, 170, 20]), ..stroke("in a ring", rect(220.0, 340.0, 120.0, 140.0)) },
    ));
    strokes.push(inside(
        3,
        Stroke { fill: flat([120, 60, 180]), ..stroke("in a star", rect(360.0, 330.0, 140.0, 150.0)) },
    ));
    let mut ring = circle(280.0, 410.0, 55.0);
    ring.extend(circle(280.0, 410.0, 25.0));
    let group = |parent, opacity, clip: Option<(BezPath, bool)>| Group {
        name: String::new(),
        parent,
        opacity,
        clip: clip.map(|(path, even_odd)| Clip { path, even_odd }),
    };
    let groups = vec![
        group(None, 0.5, None),
        group(Some(0), 1.0, Some((circle(120.0, 430.0, 45.0), false))),
        group(None, 1.0, Some((ring, true))),
        group(None, 0.8, Some((star(430.0, 400.0, 70.0), true))),
    ];
    Drawing { size: (512.0, 512.0), strokes, groups }
}
