//! A drawing, a binding and a motion through to a take.

use glam::{Vec2, vec2};
use kurbo::{Affine, BezPath, Point, Rect, Shape as _};

use super::{
    BindPoint, Binding, Clip, Drawing, Fill, Group, LayerJoint, Paint, Pen, Pin, Sketch, SketchFrame, SketchLayer,
    SketchParams, SketchTake, Stroke, StrokeSetting,
};
use crate::error::{Error, Result};
use crate::job::Progress;
use crate::motion::{Motion, Track, TrackFrame, TrackKind};

fn drawing(paths: &[&str]) -> Drawing {
    let stroke = |(i, path): (usize, &&str)| Stroke {
        name: format!("s{i}"),
        path: BezPath::from_svg(path).expect("a path"),
        pen: Some(Pen::plain(2.0)),
        ..Stroke::default()
    };
    Drawing { size: (200.0, 200.0), strokes: paths.iter().enumerate().map(stroke).collect(), groups: Vec::new() }
}

fn motion(frames: usize, ways: &[&dyn Fn(f32) -> Vec2]) -> Motion {
    let track = |(i, way): (usize, &&dyn Fn(f32) -> Vec2)| Track {
        name: format!("p{i}"),
        kind: TrackKind::Point,
        frames: (0..frames).map(|t| TrackFrame::certain(vec![way(t as f32)])).collect(),
    };
    let tracks = ways.iter().enumerate().map(track).collect();
    Motion { size: (10, 10), fps: 25.0, frames, tracks, bones: Vec::new() }
}

fn bound(places: &[Vec2]) -> Binding {
    let point = |(i, at): (usize, &Vec2)| BindPoint { track: format!("p{i}"), at: *at, ..BindPoint::default() };
    Binding { points: places.iter().enumerate().map(point).collect(), ..Binding::default() }
}

fn sketch(drawing: &Drawing, binding: &Binding) -> Sketch {
    let progress = Progress::new();
    Sketch::new(drawing.clone(), binding.clone(), SketchParams::default(), progress.whole()).expect("valid")
}

fn take(drawing: &Drawing, binding: &Binding, motions: &[&Motion]) -> SketchTake {
    sketch(drawing, binding).take(motions, Progress::new().whole()).expect("valid")
}

fn middle(path: &BezPath) -> Vec2 {
    let Point { x, y } = path.bounding_box().center();
    vec2(x as f32, y as f32)
}

fn ends(path: &BezPath) -> (Vec2, Vec2) {
    let points: Vec<Point> =
        path.segments().flat_map(|s| [kurbo::ParamCurve::eval(&s, 0.0), kurbo::ParamCurve::eval(&s, 1.0)]).collect();
    let of = |p: &Point| vec2(p.x as f32, p.y as f32);
    (of(&points[0]), of(&points[points.len() - 1]))
}

/// A head with an eye that touches nothing, a body, a leg.
const FIGURE: [&str; 4] = [
    "M 60 20 C 80 20 90 30 90 45 C 90 60 80 70 60 70 C 40 70 30 60 30 45 C 30 30 40 20 60 20 Z",
    "M 50 40 L 54 40",
    "M 70 68 C 90 90 130 90 160 80 C 175 95 165 115 150 120 L 90 122 C 75 110 70 90 70 68 Z",
    "M 100 110 C 102 130 96 150 100 180",
];

#[test]
fn points_are_where_they_should_be_and_what_has_none_goes_along() {
    let own = drawing(&FIGURE);
    let binding = bound(&[vec2(60.0, 70.0), vec2(60.0, 20.0), vec2(160.0, 80.0), vec2(100.0, 180.0)]);
    // The head turns about its chin, the foot swings.
    let turned = |t: f32| Vec2::from_angle(0.05 * t).rotate(vec2(0.0, -50.0)) + vec2(0.0, 50.0);
    let swing = |t: f32| vec2(4.0 * t, -0.5 * t);
    let still = |_: f32| Vec2::ZERO;
    let motion = motion(11, &[&still, &turned, &still, &swing]);
    let found = take(&own, &binding, &[&motion]);
    assert_eq!((found.frames.len(), found.fps, &found.order[..]), (11, 25.0, &[0, 1, 2, 3][..]));
    let kinds = |f: &SketchFrame| -> Vec<Vec<_>> {
        f.paths.iter().map(|p| p.elements().iter().map(std::mem::discriminant).collect()).collect()
    };
    assert!(found.frames.iter().all(|f| kinds(f) == kinds(&found.frames[0])), "other elements in other frames");
    for (path, stroke) in found.frames[0].paths.iter().zip(&own.strokes) {
        assert!((path.area() - stroke.path.area()).abs() < 0.05 && middle(path).distance(middle(&stroke.path)) < 1.0);
    }
    let last = &found.frames[10];
    let foot = ends(&last.paths[3]).1;
    assert!(foot.distance(vec2(140.0, 175.0)) < 0.5, "{foot}");
    let expected = vec2(60.0, 70.0) + Vec2::from_angle(0.5).rotate(vec2(-8.0, -30.0));
    let eye = middle(&last.paths[1]);
    assert!(eye.distance(expected) < 4.0, "the eye is at {eye} rather than about {expected}");
    let linear = last.affines[1].as_coeffs();
    assert!((linear[1].atan2(linear[0]) - 0.5).abs() < 0.15, "{linear:?}");
    // Of a leg that swings, nothing is torn from the body.
    assert!(ends(&last.paths[3]).0.distance(vec2(100.0, 110.0)) < 8.0);
    assert_eq!(found, take(&own, &binding, &[&motion]), "the same again");
}

#[test]
fn few_points_and_none() {
    let own = drawing(&FIGURE);
    let away = |t: f32| vec2(3.0 * t, -2.0 * t);
    let one = take(&own, &bound(&[vec2(60.0, 20.0)]), &[&motion(5, &[&away])]);
    for (path, stroke) in one.frames[4].paths.iter().zip(&own.strokes) {
        let moved = middle(path) - middle(&stroke.path);
        assert!(moved.distance(vec2(12.0, -8.0)) < 0.2, "{moved}");
    }
    let turn = |t: f32| Vec2::from_angle(t).rotate(vec2(40.0, 160.0)) - vec2(40.0, 160.0);
    let two = take(&own, &bound(&[vec2(60.0, 20.0), vec2(100.0, 180.0)]), &[&motion(2, &[&|_| Vec2::ZERO, &turn])]);
    let leg = ends(&two.frames[1].paths[3]).0;
    let expected = vec2(60.0, 20.0) + Vec2::from_angle(1.0).rotate(vec2(40.0, 90.0));
    assert!(leg.distance(expected) < 2.0, "{leg} {expected}");
    let none = take(&own, &Binding::default(), &[&motion(3, &[&away])]);
    assert!(none.frames.iter().all(|f| *f == none.frames[0]) && none.frames.len() == 3);
    // All of it decoration: nothing to mesh.
    let strokes = own.strokes.iter().map(|s| StrokeSetting { stroke: s.name.clone(), decoration: true, rigidity: 1.0 });
    let still = Binding { strokes: strokes.collect(), ..bound(&[vec2(60.0, 20.0)]) };
    let still = take(&own, &still, &[&motion(2, &[&away])]);
    assert_eq!(still.frames[1].paths, own.strokes.iter().map(|s| s.path.clone()).collect::<Vec<_>>());
}

#[test]
fn decoration_stands_still_and_pins_hold() {
    let own = drawing(&FIGURE);
    let mut binding = bound(&[vec2(160.0, 80.0)]);
    binding.set_decoration("s1", true);
    binding.pins.push(Pin { at: vec2(60.0, 20.0), layer: String::new() });
    let found = take(&own, &binding, &[&motion(6, &[&|t| vec2(4.0 * t, 3.0 * t)])]);
    let last = &found.frames[5];
    assert_eq!((&last.paths[1], last.affines[1]), (&own.strokes[1].path, Affine::IDENTITY));
    let top = ends(&last.paths[0]).0;
    assert!(top.distance(vec2(60.0, 20.0)) < 0.5, "{top}");
}

#[test]
fn layers_part_and_joints_hold_them() {
    let own = drawing(&FIGURE);
    let mut binding = bound(&[vec2(60.0, 20.0), vec2(160.0, 80.0), vec2(100.0, 180.0)]);
    binding.put_in_layer(&own, &[2], "body");
    binding.put_in_layer(&own, &[0, 1], "head");
    let kick = |t: f32| vec2(-8.0 * t, -2.0 * t);
    let still = |_: f32| Vec2::ZERO;
    let motion = motion(6, &[&still, &still, &kick]);
    let free = take(&own, &binding, &[&motion]);
    assert_eq!(free.order, [3, 2, 0, 1]);
    let gap = |t: &SketchTake| ends(&t.frames[5].paths[3]).0.distance(vec2(100.0, 110.0));
    binding.joints = own.propose_joints(&binding, Progress::new().whole()).expect("valid");
    assert!(!binding.joints.is_empty());
    let held = take(&own, &binding, &[&motion]);
    assert!(gap(&free) > 30.0 && gap(&held) < 5.0, "{} {}", gap(&free), gap(&held));
    // Layers whose strokes are all still, and joints of them, are no trouble.
    binding.layers.push(SketchLayer { name: "empty".into(), strokes: Vec::new() });
    binding.joints.push(LayerJoint { layers: ("empty".into(), "body".into()), at: vec2(1.0, 1.0) });
    binding.points[0].layer = "empty".into();
    assert_eq!(take(&own, &binding, &[&motion]).frames.len(), 6);
}

#[test]
fn points_outside_hold_the_nearest_place_and_are_told() {
    let own = drawing(&FIGURE);
    let binding = bound(&[vec2(100.0, 180.0), vec2(-300.0, 20.0)]);
    let mut sketch = sketch(&own, &binding);
    assert_eq!(sketch.points_outside(), [1]);
    let moved: Vec<Vec2> = binding.points.iter().map(|p| p.at + vec2(5.0, 7.0)).collect();
    let frame = sketch.frame(&moved, Progress::new().whole()).expect("valid");
    for (path, stroke) in frame.paths.iter().zip(&own.strokes) {
        assert!(middle(path).distance(middle(&stroke.path) + vec2(5.0, 7.0)) < 0.3);
    }
}

#[test]
fn an_edit_gives_what_a_fresh_sketch_gives() {
    let own = drawing(&FIGURE);
    let mut binding = bound(&[vec2(60.0, 20.0), vec2(160.0, 80.0), vec2(100.0, 180.0)]);
    let motion = motion(4, &[&|t| vec2(t, 4.0 * t), &|_| Vec2::ZERO, &|t| vec2(9.0 * t, 0.0)]);
    let mut edited = sketch(&own, &binding);
    let progress = Progress::new();
    edited.take(&[&motion], progress.whole()).expect("valid");
    let mesh = edited.mesh_of(0).expect("a mesh").clone();
    type Edit<'a> = &'a dyn Fn(&mut Binding);
    let edits: [Edit<'_>; 4] = [
        &|b| b.points[2].at = vec2(98.0, 150.0),
        &|b| b.set_rigidity("s3", 200.0),
        &|b| b.put_in_layer(&drawing(&FIGURE), &[3], "leg"),
        &|b| b.set_decoration("s1", true),
    ];
    for (i, edit) in edits.iter().enumerate() {
        edit(&mut binding);
        edited.set_binding(binding.clone(), progress.whole()).expect("valid");
        assert_eq!(*edited.mesh_of(0).expect("a mesh") == mesh, i < 2, "edit {i}");
        let (found, fresh) =
            (edited.take(&[&motion], progress.whole()).expect("valid"), take(&own, &binding, &[&motion]));
        assert_eq!(found, fresh, "edit {i}");
    }
    let before = edited.binding().clone();
    let mut bad = before.clone();
    bad.layers[0].strokes.push("nowhere".into());
    assert!(edited.set_binding(bad, progress.whole()).is_err());
    assert_eq!(*edited.binding(), before);
}

#[test]
fn pressed_widths_clips_and_gradients_go_along() {
    let mut own = drawing(&["M 20 100 C 60 60 120 140 180 100", "M 30 90 H 170 V 110 H 30 Z"]);
    let pen = own.strokes[0].pen.as_mut().expect("a pen");
    pen.widths = vec![1.0, 5.0];
    let clip = Clip { path: Rect::new(40.0, 80.0, 160.0, 120.0).to_path(0.1), even_odd: false };
    own.groups = vec![
        Group { name: String::new(), parent: None, opacity: 1.0, clip: Some(clip) },
        Group { name: String::new(), parent: Some(0), opacity: 1.0, clip: None },
    ];
    own.strokes[1].group = Some(1);
    own.strokes[1].fill = Some(Fill { paint: Paint::Color([0; 3]), opacity: 1.0, even_odd: false });
    let binding = bound(&[vec2(20.0, 100.0), vec2(100.0, 100.0), vec2(180.0, 100.0)]);
    let found =
        take(&own, &binding, &[&motion(8, &[&|t| vec2(0.0, 6.0 * t), &|_| Vec2::ZERO, &|t| vec2(0.0, 6.0 * t)])]);
    let last = &found.frames[7];
    let counted = last.paths[0].elements().len();
    assert!(counted > 2 && found.widths[0].len() == counted && found.widths[1].is_empty(), "{counted}");
    assert_eq!((found.widths[0][0], found.widths[0][counted - 1]), (1.0, 5.0));
    assert!(found.widths[0].windows(2).all(|w| w[1] > w[0]));
    assert!(last.clips[1].elements().is_empty() && last.clips[0].bounding_box().y1 > 125.0, "{:?}", last.clips[0]);
}

#[test]
fn dots_and_strokes_off_the_page_move_with_what_is_near() {
    let own = drawing(&["M 20 100 H 180", "M 100 90", "M 60 95 L 60 95", "M 5000 100 h 50", "M 100 104 Z"]);
    let found = take(&own, &bound(&[vec2(100.0, 100.0)]), &[&motion(3, &[&|t| vec2(0.0, 5.0 * t)])]);
    for (i, path) in found.frames[2].paths.iter().enumerate() {
        let moved = path.control_box().center() - own.strokes[i].path.control_box().center();
        assert!((moved.y - 10.0).abs() < 0.2 && moved.x.abs() < 0.2, "stroke {i} moved by {moved:?}");
    }
}

#[test]
fn ten_thousand_strokes_are_animated() {
    let hair = |i: usize| {
        let (x, y) = (5.0 + (i % 100) as f64 * 1.9, 5.0 + (i / 100) as f64 * 1.9);
        format!("M {x} {y} c 0.5 0.2 0.8 0.9 1.2 1.4")
    };
    let hairs: Vec<String> = (0..10_000).map(hair).collect();
    let paths: Vec<&str> = hairs.iter().map(String::as_str).collect();
    let own = drawing(&paths);
    let binding = bound(&[vec2(10.0, 10.0), vec2(190.0, 10.0), vec2(100.0, 190.0)]);
    let found =
        take(&own, &binding, &[&motion(5, &[&|t| vec2(t, t), &|t| vec2(-3.0 * t, t), &|t| vec2(0.0, -4.0 * t)])]);
    let long = motion(12_000, &[&|_| Vec2::ZERO, &|_| Vec2::ZERO, &|_| Vec2::ZERO]);
    let refused = sketch(&own, &binding).take(&[&long], Progress::new().whole()).expect_err("too much");
    assert!(refused.to_string().contains("use a shorter motion"), "{refused}");
    assert_eq!(found.frames[4].paths.len(), 10_000);
    assert!(found.frames[4].paths.iter().all(|p| p.elements().len() == 2 && p.is_finite()));
}

#[test]
fn nonsense_is_refused_and_a_cancel_obeyed() {
    let own = drawing(&FIGURE);
    let binding = bound(&[vec2(60.0, 20.0)]);
    let progress = Progress::new();
    let made =
        |own: &Drawing, binding: &Binding, params| Sketch::new(own.clone(), binding.clone(), params, progress.whole());
    let params = SketchParams::default;
    let message = |r: Result<Sketch>| r.expect_err("refused").to_string();
    assert!(message(made(&Drawing::default(), &binding, params())).contains("page"));
    assert!(
        message(made(&own, &Binding { size: (9.0, 9.0), ..binding.clone() }, params())).contains("made for a page")
    );
    assert!(message(made(&own, &binding, SketchParams { vertices: 0, ..params() })).contains("from 10"));
    assert!(message(made(&own, &binding, SketchParams { tolerance: f64::NAN, ..params() })).contains("tolerance"));
    assert!(message(made(&own, &binding, SketchParams { smoothing: -1.0, ..params() })).contains("smoothing"));
    let mut nan = own.clone();
    nan.strokes[0].path.line_to((f64::NAN, 0.0));
    assert!(message(made(&nan, &binding, params())).contains("stroke `s0`"));
    let mut sketch = sketch(&own, &binding);
    let rest = sketch.shape_of(0).expect("a mesh").to_vec();
    assert!(sketch.frame(&[], progress.whole()).is_err());
    assert!(sketch.frame(&[vec2(f32::NAN, 0.0)], progress.whole()).is_err());
    sketch.reset();
    let other = motion(3, &[]);
    assert!(sketch.take(&[&other], progress.whole()).expect_err("no track").to_string().contains("no such track"));
    assert_eq!(sketch.shape_of(0).expect("a mesh"), rest);
    progress.cancel();
    let moves = motion(3, &[&|t| vec2(t, 0.0)]);
    assert!(matches!(sketch.take(&[&moves], progress.whole()), Err(Error::Cancelled)));
    assert!(matches!(made(&own, &binding, params()), Err(Error::Cancelled)));
}
