//! Files are read back by readers that are not ours, and every frame is compared.

use std::collections::HashMap;

use kurbo::{Affine, BezPath, Circle, ParamCurve, PathEl, Point, Rect, Shape, Vec2};
use serde_json::Value;

use super::*;
use crate::error::Category;
use crate::job::Progress;
use crate::shape::sketch::{
    Cap, Clip, Fill, Gradient, GradientShape, Group, Join, Paint, Pen, SketchFrame, Spread, Stop, Stroke,
};

const FRAMES: usize = 30;

fn pen(width: f64) -> Pen {
    Pen {
        paint: Paint::Color([200, 30, 60]),
        opacity: 0.5,
        width,
        widths: vec![],
        cap: Cap::Round,
        join: Join::Bevel,
        miter_limit: 4.0,
        dashes: vec![],
        dash_offset: 0.0,
    }
}

/// A line, a star with a quadratic piece, a gradient, a pressed line, and a ring that is seen through in a clip.
fn drawing() -> Drawing {
    let line = BezPath::from_svg("M10 20C30 5 50 60 80 30S90 80 60 90").expect("a path");
    let star = BezPath::from_svg("M100 20L120 60Q140 70 150 60L160 100L100 90Z").expect("a path");
    let stop = |offset, opacity| Stop { offset, color: [10, 120, 240], opacity };
    let gradient = Gradient {
        shape: GradientShape::Linear { from: Point::ZERO, to: Point::new(1.0, 0.0) },
        transform: Affine::translate((20.0, 100.0)) * Affine::new([40.0, 10.0, -8.0, 30.0, 0.0, 0.0]),
        spread: Spread::Pad,
        stops: vec![stop(0.0, 1.0), stop(1.0, 0.2)],
    };
    let fill = |paint, even_odd| Some(Fill { paint, opacity: 1.0, even_odd });
    let color = Paint::Color([20, 140, 90]);
    let mut ring = Circle::new((140.0, 140.0), 30.0).to_path(0.01);
    ring.extend(Circle::new((140.0, 140.0), 12.0).to_path(0.01));
    let named = |name: &str, path: BezPath| Stroke { name: name.into(), path, ..Stroke::default() };
    let pressed = Pen { widths: vec![1.0, 6.0, 3.0], ..pen(3.0) };
    let strokes = vec![
        Stroke { pen: Some(pen(4.0)), ..named("line & <curve>", line) },
        Stroke { fill: fill(color.clone(), false), pen: Some(pen(3.0)), pen_below: true, ..named("star", star) },
        Stroke {
            fill: fill(Paint::Gradient(gradient), false),
            ..named("sky", Rect::new(20.0, 100.0, 70.0, 140.0).to_path(0.1))
        },
        Stroke {
            pen: Some(pressed),
            ..named("pressed", BezPath::from_svg("M20 170C40 150 60 190 80 170L95 150").expect("a path"))
        },
        Stroke { fill: fill(color, true), group: Some(1), ..named("ring", ring) },
    ];
    let clip = Some(Clip { path: Circle::new((150.0, 140.0), 28.0).to_path(0.01), even_odd: false });
    let groups = vec![
        Group { name: "outer".into(), parent: None, opacity: 0.5, clip: None },
        Group { name: "inner".into(), parent: Some(0), opacity: 1.0, clip },
    ];
    Drawing { size: (200.0, 200.0), strokes, groups }
}

fn swaying(drawing: &Drawing, frames: usize) -> SketchTake {
    let still = SketchTake::still(drawing);
    let frame = |f: usize| {
        let time = f as f64 / 5.0;
        let place = |p: Point| p + Vec2::new(6.0 * (time + p.y / 40.0).sin(), 4.0 * (time + p.x / 50.0).cos());
        let moved = |path: &BezPath| {
            let one = |el: &PathEl| match *el {
                PathEl::MoveTo(p) => PathEl::MoveTo(place(p)),
                PathEl::LineTo(p) => PathEl::LineTo(place(p)),
                PathEl::QuadTo(a, p) => PathEl::QuadTo(place(a), place(p)),
                PathEl::CurveTo(a, b, p) => PathEl::CurveTo(place(a), place(b), place(p)),
                PathEl::ClosePath => PathEl::ClosePath,
            };
            BezPath::from_vec(path.elements().iter().map(one).collect())
        };
        let own = &still.frames[0];
        SketchFrame {
            paths: own.paths.iter().map(moved).collect(),
            clips: own.clips.iter().map(moved).collect(),
            affines: own
                .paths
                .iter()
                .map(|p| Affine::translate(place(p.bounding_box().center()) - p.bounding_box().center()))
                .collect(),
        }
    };
    SketchTake { fps: 24.0, frames: (0..frames).map(frame).collect(), ..still }
}

fn written(format: SketchFormat, drawing: &Drawing, take: &SketchTake, options: &SketchOptions) -> Result<Vec<u8>> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sketch.out");
    let subject = SketchSubject { name: "a \"sketch\" & more", drawing, take };
    let files = write_sketch(&path, format, subject, options, Progress::new().whole());
    let left: Vec<_> = std::fs::read_dir(folder.path()).expect("the folder").collect();
    assert_eq!(left.len(), usize::from(files.is_ok()), "{left:?}");
    files.map(|files| std::fs::read(&files.files[0]).expect("the file"))
}

/// Places along the flattened outline of a path.
fn along(path: &BezPath) -> Vec<Point> {
    let mut out = Vec::new();
    // A close over no way is a segment or none, by rounding.
    for segment in path.segments().filter(|s| s.start().distance(s.end()) > 0.05) {
        // Lines as curves with their handles at their ends, as Lottie has them.
        let curve = match segment {
            kurbo::PathSeg::Line(l) => kurbo::PathSeg::Cubic(kurbo::CubicBez::new(l.p0, l.p0, l.p1, l.p1)),
            other => other,
        };
        out.extend((0..8).map(|k| curve.eval(f64::from(k) / 8.0)));
    }
    out
}

fn farthest(a: &BezPath, b: &BezPath) -> f64 {
    let (a, b) = (along(a), along(b));
    assert_eq!(a.len(), b.len(), "places along both");
    a.iter().zip(&b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

fn flattened(node: &usvg::Group, out: &mut Vec<BezPath>) {
    for child in node.children() {
        match child {
            usvg::Node::Group(group) => flattened(group, out),
            usvg::Node::Path(path) => {
                let mut bezier = BezPath::new();
                let at = |p: usvg::tiny_skia_path::Point| Point::new(p.x.into(), p.y.into());
                for segment in path.data().segments() {
                    match segment {
                        usvg::tiny_skia_path::PathSegment::MoveTo(p) => bezier.move_to(at(p)),
                        usvg::tiny_skia_path::PathSegment::LineTo(p) => bezier.line_to(at(p)),
                        usvg::tiny_skia_path::PathSegment::QuadTo(a, p) => bezier.quad_to(at(a), at(p)),
                        usvg::tiny_skia_path::PathSegment::CubicTo(a, b, p) => bezier.curve_to(at(a), at(b), at(p)),
                        usvg::tiny_skia_path::PathSegment::Close => bezier.close_path(),
                    }
                }
                out.push(bezier);
            }
            _ => panic!("neither a group nor a path"),
        }
    }
}

#[test]
fn without_animation_an_svg_shows_the_first_frame() {
    let drawing = drawing();
    let mut take = swaying(&drawing, FRAMES);
    take.order = vec![4, 0, 1, 2, 3];
    let options = SketchOptions { grow: false, scale: 2.0, ..SketchOptions::default() };
    let bytes = written(SketchFormat::Svg, &drawing, &take, &options).expect("written");
    let tree = usvg::Tree::from_data(&bytes, &usvg::Options::default()).expect("an SVG");
    assert_eq!((tree.size().width(), tree.size().height()), (400.0, 400.0));
    let mut paths = Vec::new();
    flattened(tree.root(), &mut paths);
    for (own, stroke) in paths.iter().zip([4, 0, 1, 2]) {
        let off = farthest(own, &(Affine::scale(2.0) * take.frames[0].paths[stroke].clone()));
        assert!(off < 0.2, "{stroke}: {off}");
    }
    assert_eq!(paths.len(), 5);
    // The same picture, as another way of drawing sees it.
    let again = Drawing::from_svg(&bytes).expect("a drawing").drawing;
    let canvas = SketchCanvas::page(&again, 1.0).expect("a page");
    let theirs = draw_sketch(&again, &SketchTake::still(&again), 0, &canvas);
    let ours = draw_sketch(&drawing, &take, 0, &SketchCanvas::page(&drawing, 2.0).expect("a page"));
    assert!(difference(&ours, &theirs) < 0.2, "{}", difference(&ours, &theirs));
}

/// The mean difference of premultiplied pictures.
fn difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let seen = |p: &image::Rgba<u8>, c: usize| f64::from(p.0[c]) * if c < 3 { f64::from(p.0[3]) / 255.0 } else { 1.0 };
    let sum: f64 =
        a.pixels().zip(b.pixels()).map(|(a, b)| (0..4).map(|c| (seen(a, c) - seen(b, c)).abs()).sum::<f64>()).sum();
    sum / 4.0 / f64::from(a.width() * a.height())
}

/// All values of an attribute of an element's animation, at a time in 0..1 blended as players do.
fn animated(element: usvg::roxmltree::Node<'_, '_>, share: f64) -> Option<BezPath> {
    let animation = element.children().find(|c| c.has_tag_name("animate"));
    let path = |text: &str| BezPath::from_svg(text).expect("a path");
    let Some(animation) = animation else { return element.attribute("d").map(path) };
    let times: Vec<f64> = animation.attribute("keyTimes")?.split(';').map(|t| t.parse().expect("a time")).collect();
    let values: Vec<&str> = animation.attribute("values")?.split(';').collect();
    assert_eq!(times.len(), values.len());
    assert!(times[0] == 0.0 && times[times.len() - 1] == 1.0 && times.is_sorted_by(|a, b| a < b), "{times:?}");
    assert_eq!(element.attribute("d"), Some(values[0]));
    let next = times.iter().position(|t| *t > share)?;
    let part = (share - times[next - 1]) / (times[next] - times[next - 1]);
    let (a, b) = (path(values[next - 1]), path(values[next]));
    let mix = |(a, b): (&PathEl, &PathEl)| match (*a, *b) {
        (PathEl::MoveTo(a), PathEl::MoveTo(b)) => PathEl::MoveTo(a.lerp(b, part)),
        (PathEl::LineTo(a), PathEl::LineTo(b)) => PathEl::LineTo(a.lerp(b, part)),
        (PathEl::QuadTo(a, c), PathEl::QuadTo(b, d)) => PathEl::QuadTo(a.lerp(b, part), c.lerp(d, part)),
        (PathEl::CurveTo(a, c, e), PathEl::CurveTo(b, d, f)) => {
            PathEl::CurveTo(a.lerp(b, part), c.lerp(d, part), e.lerp(f, part))
        }
        (PathEl::ClosePath, PathEl::ClosePath) => PathEl::ClosePath,
        other => panic!("{other:?}"),
    };
    Some(BezPath::from_vec(a.elements().iter().zip(b.elements()).map(mix).collect()))
}

#[test]
fn every_frame_of_an_svg_is_within_its_tolerance() {
    let drawing = drawing();
    let take = swaying(&drawing, FRAMES);
    let options = SketchOptions { grow: false, ..SketchOptions::default() };
    let bytes = written(SketchFormat::Svg, &drawing, &take, &options).expect("written");
    let text = std::str::from_utf8(&bytes).expect("text");
    let xml = usvg::roxmltree::Document::parse(text).expect("XML");
    let elements: HashMap<&str, _> =
        xml.descendants().filter_map(|n| n.attribute("data-name").map(|name| (name, n))).collect();
    for (s, stroke) in drawing.strokes.iter().enumerate().filter(|(_, s)| s.name != "pressed") {
        for (f, frame) in take.frames.iter().enumerate() {
            let seen = animated(elements[stroke.name.as_str()], f as f64 / FRAMES as f64).expect("a path");
            let off = farthest(&seen, &frame.paths[s]);
            assert!(off < 2f64.sqrt() * SVG_TOLERANCE + 1e-3, "{} {f}: {off}", stroke.name);
        }
    }
    let once =
        written(SketchFormat::Svg, &drawing, &take, &SketchOptions { repeat: false, ..options }).expect("written");
    assert!(text.contains("repeatCount") && !std::str::from_utf8(&once).expect("text").contains("repeatCount"));
    assert!(!text.contains("<script") && text.contains("dur=\"1.25s\""));
}

/// The path of a Lottie `ks` at a frame, in units of its layer.
fn lottie_path(property: &Value, frame: f64) -> BezPath {
    let point = |v: &Value| Vec2::new(v[0].as_f64().expect("x"), v[1].as_f64().expect("y"));
    let list = |shape: &Value, key: &str| shape[key].as_array().expect("a list").iter().map(point).collect::<Vec<_>>();
    let shape = |a: &Value, b: &Value, share: f64| {
        let mixed =
            |key| list(a, key).into_iter().zip(list(b, key)).map(|(a, b)| a + (b - a) * share).collect::<Vec<_>>();
        let (v, before, after) = (mixed("v"), mixed("i"), mixed("o"));
        let mut path = BezPath::new();
        path.move_to(v[0].to_point());
        let closed = a["c"].as_bool().unwrap_or(false);
        for k in 1..v.len() + usize::from(closed) {
            let (from, to) = (k - 1, k % v.len());
            path.curve_to((v[from] + after[from]).to_point(), (v[to] + before[to]).to_point(), v[to].to_point());
        }
        if closed {
            path.close_path();
        }
        path
    };
    if property["a"] == 0 {
        return shape(&property["k"], &property["k"], 0.0);
    }
    let keys = property["k"].as_array().expect("keys");
    let time = |k: usize| keys[k]["t"].as_f64().expect("a time");
    assert!((1..keys.len()).all(|k| time(k - 1) < time(k)));
    assert!(
        keys[..keys.len() - 1]
            .iter()
            .all(|k| k["i"] == serde_json::json!({"x": 1, "y": 1}) && k["o"] == serde_json::json!({"x": 0, "y": 0}))
    );
    let next = (0..keys.len()).find(|k| time(*k) > frame).unwrap_or(keys.len() - 1).max(1);
    let share = ((frame - time(next - 1)) / (time(next) - time(next - 1))).min(1.0);
    shape(&keys[next - 1]["s"][0], &keys[next]["s"][0], share)
}

#[test]
fn every_frame_of_lottie_is_within_its_tolerance() {
    let drawing = drawing();
    let mut take = swaying(&drawing, FRAMES);
    take.order = vec![1, 0, 2, 3, 4];
    let options = SketchOptions { grow: false, scale: 2.0, tolerance: Some(0.25), ..SketchOptions::default() };
    let bytes = written(SketchFormat::Lottie, &drawing, &take, &options).expect("written");
    let scene: Value = serde_json::from_slice(&bytes).expect("JSON");
    assert_eq!((&scene["w"], &scene["op"], &scene["fr"]), (&400.into(), &FRAMES.into(), &24.into()));
    // The front comes first: the group, a composition as it holds a group, then the other strokes, the nearest first.
    let layers = scene["layers"].as_array().expect("layers");
    assert_eq!(layers.len(), 2);
    assert_eq!(layers[0]["ks"]["o"]["k"], 50);
    let shapes = layers[1]["shapes"].as_array().expect("shapes");
    let names: Vec<&str> = shapes.iter().map(|s| s["nm"].as_str().expect("a name")).collect();
    assert_eq!(names, ["pressed", "sky", "line & <curve>", "star"]);
    let kinds = |of: &Value| {
        of["it"]
            .as_array()
            .expect("items")
            .iter()
            .map(|i| i["ty"].as_str().expect("a type").to_owned())
            .collect::<Vec<_>>()
    };
    // The star's line lies below its fill.
    assert_eq!(kinds(&shapes[3]), ["sh", "fl", "st", "tr"]);
    let group = if layers[0]["ty"] == 0 { &scene["assets"][0]["layers"][0] } else { &layers[0] };
    let scale = layers[1]["ks"]["s"]["k"][0].as_f64().expect("a scale") / 100.0;
    let mut checked = 0;
    let mut check = |name: &str, item: &Value, own: &dyn Fn(usize) -> BezPath| {
        for f in 0..FRAMES {
            let seen = Affine::scale(scale) * lottie_path(&item["ks"], f as f64);
            let off = farthest(&seen, &(Affine::scale(2.0) * own(f)));
            assert!(off <= 2f64.sqrt() * 0.25 + 1e-6, "{name}, {f}: {off}");
            checked += 1;
        }
    };
    check("line", &shapes[2]["it"][0], &|f| take.frames[f].paths[0].clone());
    check("star", &shapes[3]["it"][0], &|f| take.frames[f].paths[1].clone());
    check("sky", &shapes[1]["it"][0], &|f| take.frames[f].paths[2].clone());
    let ring = |f: usize, k: usize| BezPath::from_vec(take.frames[f].paths[4].elements()[6 * k..6 * k + 6].to_vec());
    let cut = group["shapes"].as_array().map_or(&Value::Null, |s| &s[0]);
    check("ring", &cut["it"][0], &|f| ring(f, 0));
    check("hole", &cut["it"][1], &|f| ring(f, 1));
    let mask = serde_json::json!({ "ks": group["masksProperties"][0]["pt"] });
    check("mask", &mask, &|f| take.frames[f].clips[1].clone());
    assert_eq!(checked, 6 * FRAMES);
}

#[test]
fn sixteen_strokes_of_three_seconds_are_small() {
    let line = |i: usize| {
        let path = BezPath::from_svg("M10 20C30 5 50 60 80 30S90 80 60 90S30 150 90 140").expect("a path");
        let path = Affine::translate((5.0 * i as f64, 3.0 * i as f64)) * path;
        Stroke { name: format!("line {i}"), path, pen: Some(pen(3.0)), ..Stroke::default() }
    };
    let drawing = Drawing { size: (200.0, 200.0), strokes: (0..16).map(line).collect(), groups: vec![] };
    let take = swaying(&drawing, 72);
    let options = SketchOptions { scale: 512.0 / 200.0, ..SketchOptions::default() };
    let bytes = written(SketchFormat::Lottie, &drawing, &take, &options).expect("written");
    assert!(bytes.len() <= 150_000, "{}", bytes.len());
}

#[test]
fn pictures_and_video_hold_every_frame() {
    let drawing = drawing();
    let take = swaying(&drawing, 6);
    let folder = tempfile::tempdir().expect("a folder");
    let subject = SketchSubject { name: "sketch", drawing: &drawing, take: &take };
    let options = SketchOptions::default();
    for (format, name) in SketchFormat::ALL {
        let path = folder.path().join(name);
        let files = write_sketch(&path, format, subject, &options, Progress::new().whole()).expect(name);
        assert!(files.frames == 6 && files.files.iter().all(|f| f.exists()), "{name}");
        assert!(files.shown[2] >= 200.0 && files.size.0 >= 200, "{name}");
    }
    let first = image::open(folder.path().join("png-dir/00003.png")).expect("a picture").to_rgba8();
    let canvas = SketchCanvas::around(&drawing, &take, 1.0).expect("a page");
    assert!(difference(&first, &draw_sketch(&drawing, &take, 3, &canvas)) < 1e-9);
}

#[test]
fn opacity_lies_below_the_colours() {
    let picture = RgbaImage::from_fn(5, 3, |x, _| image::Rgba(if x == 2 { [200, 10, 20, 128] } else { [0; 4] }));
    let stacked = stacked(&picture);
    assert_eq!(stacked.dimensions(), (6, 8));
    assert_eq!((stacked.get_pixel(0, 1).0, stacked.get_pixel(4, 1).0), ([200, 10, 20, 255], [200, 10, 20, 255]));
    assert_eq!((stacked.get_pixel(2, 5).0, stacked.get_pixel(0, 5).0), ([128, 128, 128, 255], [0, 0, 0, 255]));
}

#[test]
fn what_cannot_be_written_is_told_and_leaves_nothing() {
    let drawing = drawing();
    let take = swaying(&drawing, 3);
    let told = |take: &SketchTake, options: SketchOptions, wanted: &str| {
        for format in [SketchFormat::Svg, SketchFormat::Lottie, SketchFormat::Apng] {
            let message = written(format, &drawing, take, &options).map(|b| b.len()).expect_err(wanted).to_string();
            assert!(message.contains(wanted), "{message}");
        }
    };
    let usual = SketchOptions::default();
    let changed = |change: &dyn Fn(&mut SketchTake)| {
        let mut take = take.clone();
        change(&mut take);
        take
    };
    told(&changed(&|t| t.frames.clear()), usual, "no frames");
    told(&changed(&|t| t.frames[1].paths[0] = BezPath::new()), usual, "other elements");
    told(&changed(&|t| t.frames[2].clips[1] = BezPath::new()), usual, "other elements");
    told(&changed(&|t| t.frames[1].paths[1].apply_affine(Affine::scale(f64::NAN))), usual, "not a number");
    told(&changed(&|t| t.frames[1].affines[0] = Affine::scale(f64::INFINITY)), usual, "not a number");
    told(&changed(&|t| drop(t.frames[1].paths.pop())), usual, "4 paths");
    told(&changed(&|t| t.order = vec![0, 0, 1, 2, 3]), usual, "each once");
    told(&changed(&|t| drop(t.widths.pop())), usual, "widths");
    told(&changed(&|t| t.fps = 0.0), usual, "frames a second");
    told(&changed(&|t| t.fps = 1e9), usual, "frames a second");
    told(&take, SketchOptions { scale: 0.0, ..usual }, "scale");
    told(&take, SketchOptions { scale: 1e5, ..usual }, "pixel count");
    told(&take, SketchOptions { tolerance: Some(f64::NAN), ..usual }, "tolerance");
    assert!(SketchFormat::choose(Some("swf"), Path::new("x")).is_err());
    assert_eq!(SketchFormat::choose(None, Path::new("a/b.JSON")).expect("Lottie"), SketchFormat::Lottie);
    let progress = Progress::new();
    progress.cancel();
    let folder = tempfile::tempdir().expect("a folder");
    let subject = SketchSubject { name: "sketch", drawing: &drawing, take: &take };
    let error = write_sketch(&folder.path().join("x.svg"), SketchFormat::Svg, subject, &usual, progress.whole());
    assert_eq!(error.expect_err("cancelled").category(), Category::Cancelled);
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}

#[test]
fn far_places_and_slow_rates_are_written() {
    let drawing = drawing();
    let mut take = swaying(&drawing, 2);
    take.frames[1].paths[0].apply_affine(Affine::scale(1e200));
    take.fps = 0.01;
    let options = SketchOptions { grow: false, ..SketchOptions::default() };
    for format in [SketchFormat::Svg, SketchFormat::Lottie] {
        written(format, &drawing, &take, &options).expect("written");
    }
}

#[test]
fn a_file_that_no_player_opens_is_refused() {
    // Every frame elsewhere, so that all are keys: 10,000 strokes.
    let stroke = |i: usize| Stroke {
        name: format!("{i}"),
        path: BezPath::from_svg("M0 0C1 1 2 2 3 3C4 4 5 5 6 6").expect("a path"),
        pen: Some(pen(1.0)),
        ..Stroke::default()
    };
    let drawing = Drawing { size: (500.0, 500.0), strokes: (0..10_000).map(stroke).collect(), groups: vec![] };
    let still = SketchTake::still(&drawing);
    let frame = |f: usize| {
        let jump = Affine::translate((((f * 7919) % 499) as f64, ((f * 104_729) % 491) as f64));
        let paths = still.frames[0].paths.iter().map(|p| jump * p.clone()).collect();
        SketchFrame { paths, ..still.frames[0].clone() }
    };
    let take = SketchTake { fps: 24.0, frames: (0..100).map(frame).collect(), ..still.clone() };
    let error = written(SketchFormat::Lottie, &drawing, &take, &SketchOptions::default())
        .map(|b| b.len())
        .expect_err("too large");
    assert_eq!(error.category(), Category::Limit);
    // What players can open is written.
    let take = SketchTake { frames: take.frames[..3].to_vec(), ..take };
    written(SketchFormat::Svg, &drawing, &take, &SketchOptions::default()).expect("written");
}
