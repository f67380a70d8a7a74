//! Where the control points of a motion hold a drawing of quite another shape.
//!
//! Live Sketch (Su et al. 2018, "Motion Transfer"): the contour of the object in the clip is matched with the outline of
//! the drawing, whichever way either faces, and points are carried over by their coordinates in the contour. Where nothing
//! but the motion is known, a figure is guessed from the points themselves, which is right less often: of 233 points of 19
//! pairs placed by eye, 79 in 100 lie within a tenth of the drawing's height of where they belong with the contour, and 52
//! without. The way it faces is told right for 17 of the 19 with the contour and for 15 without; it
//! can be given. Nothing is turned upside down. Places are proposals; a person moves what is wrong.

use glam::Vec2;

use super::binding::{BindPoint, Binding, MotionUse};
use crate::error::{Error, Result};
use crate::geometry::contour_map::ContourMap;
use crate::geometry::polygon;
use crate::job::Stage;
use crate::motion::{Motion, TrackKind};
use crate::segment::figure;

/// What the bends of a contour count for that is seen, and of one that is guessed.
const TURNING: f32 = 0.33;
const TURNING_GUESSED: f32 = 0.1;
/// The cost of a match at which a place is as likely wrong as right.
const DOUBTFUL: f32 = 0.35;
/// Points of a stroke that hold a drawing.
const STROKE_POINTS: usize = 4;
/// A point nearer to one before it than this share of the figure's diagonal holds the same place.
const SAME: f32 = 0.02;

/// A point to be placed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControlPoint {
    /// Its track.
    pub track: String,
    /// Which point of the track.
    pub index: usize,
    /// Where it is in the frame of the clip, in clip pixels.
    pub at: Vec2,
}

/// What shows where the points are on the object.
#[derive(Clone, Copy, Debug)]
pub enum ObjectShape<'a> {
    /// The object's contour in the frame, closed, in clip pixels.
    Contour(&'a [Vec2]),
    /// Nothing but the points, of which pairs of numbers are joined.
    Points(&'a [(usize, usize)]),
}

/// Points on a drawing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Placing {
    /// Where each point holds the drawing, on or within its outline, in its pixels.
    pub places: Vec<Vec2>,
    /// How far each place is to be trusted, in 0..=1.
    pub confidence: Vec<f32>,
    /// Whether left and right are exchanged.
    pub mirror: bool,
    /// Pixels of the drawing for one of the clip.
    pub scale: f32,
}

/// Places points on a drawing with this closed outline. `mirror` says which way the drawing faces, where that is known.
///
/// # Errors
/// A contour has fewer than three corners, no size, or something that is no number; there are no points, or without a contour
/// fewer than three; or the work is cancelled.
pub fn place_points(
    shape: ObjectShape<'_>,
    points: &[Vec2],
    outline: &[Vec2],
    mirror: Option<bool>,
    stage: Stage<'_>,
) -> Result<Placing> {
    stage.name("placing points")?;
    if let Some(i) = points.iter().position(|p| !p.is_finite()) {
        return Err(Error::invalid(format!("point {i}"), "its place is no number", "give x and y in clip pixels"));
    }
    let (needed, remedy) = match shape {
        ObjectShape::Contour(_) => (1, "mark points on the object"),
        ObjectShape::Points(_) => (3, "mark more points, or give the object's contour"),
    };
    if points.len() < needed {
        return Err(Error::invalid("control points", format!("there are {}", points.len()), remedy));
    }
    let guessed;
    let (contour, turning) = match shape {
        ObjectShape::Contour(contour) => (contour, TURNING),
        ObjectShape::Points(joined) => {
            let known = |&&(a, b): &&(usize, usize)| a < points.len() && b < points.len();
            guessed =
                figure::suggested(points, &joined.iter().filter(known).copied().collect::<Vec<_>>(), figure::CLOSING);
            (&guessed[..], TURNING_GUESSED)
        }
    };
    check("the object's contour", contour)?;
    check("the drawing's outline", outline)?;
    let mut best: Option<(bool, ContourMap)> = None;
    for (i, way) in [false, true].into_iter().enumerate().filter(|(_, way)| mirror.is_none_or(|m| m == *way)) {
        let part = stage.part(0.5 * i as f64, 0.5 * (i + 1) as f64);
        let map = ContourMap::between(contour, outline, way, turning, part)?;
        let Some(map) = map else { return Err(flat("the contour or the outline")) };
        if best.as_ref().is_none_or(|(_, b)| map.cost < b.cost) {
            best = Some((way, map));
        }
    }
    let Some((mirror, map)) = best else { return Err(flat("the outline")) };
    let shown = [outline.to_vec()];
    let placed = |p: &Vec2| {
        let (place, cost) = map.at(*p);
        let place = if polygon::contain(&shown, place) { place } else { polygon::nearest(outline, place) };
        (place, (-std::f32::consts::LN_2 * (cost / DOUBTFUL).powi(2)).exp())
    };
    let (places, confidence) = points.iter().map(placed).unzip();
    Ok(Placing { places, confidence, mirror, scale: map.scale })
}

fn check(what: &str, contour: &[Vec2]) -> Result<()> {
    if let Some(i) = contour.iter().position(|p| !p.is_finite()) {
        let remedy = "give x and y of every corner";
        return Err(Error::invalid(format!("{what}, corner {i}"), "is no number", remedy));
    }
    match polygon::extent(contour) {
        Some((low, high)) if contour.len() >= 3 && (high - low).min_element() > 0.0 => Ok(()),
        _ => Err(flat(what)),
    }
}

fn flat(what: &str) -> Error {
    Error::invalid(what, "encloses nothing", "give a closed line around something, of three corners or more")
}

/// The points of a motion in one of its frames that hold a drawing: joints and control points all, strokes by a few points
/// along them, without those that lie where another does.
pub fn control_points(motion: &Motion, frame: usize) -> Vec<ControlPoint> {
    let places: Vec<Vec2> =
        motion.tracks.iter().filter_map(|t| t.frames.get(frame)).flat_map(|f| f.points.clone()).collect();
    let diagonal = polygon::extent(&places).map_or(0.0, |(low, high)| low.distance(high));
    let mut chosen: Vec<ControlPoint> = Vec::new();
    for track in &motion.tracks {
        let Some(at) = track.frames.get(frame).map(|f| &f.points) else { continue };
        let count = if track.kind == TrackKind::Stroke { at.len().min(STROKE_POINTS) } else { at.len() };
        for i in 0..count {
            let index = i * (at.len() - 1) / (count - 1).max(1);
            if chosen.iter().all(|c| c.at.distance(at[index]) > SAME * diagonal) {
                chosen.push(ControlPoint { track: track.name.clone(), index, at: at[index] });
            }
        }
    }
    chosen
}

/// The frame in which most points of a motion are certain, as they are where they were marked, and among such frames the one
/// in which they lie farthest apart, so that limbs hide each other least; 0 for a motion without frames.
pub fn most_telling_frame(motion: &Motion) -> usize {
    let telling = |frame: usize| {
        let seen = || motion.tracks.iter().filter_map(|t| t.frames.get(frame));
        let certain = seen().flat_map(|f| &f.confidence).filter(|c| **c >= 1.0).count();
        let places: Vec<Vec2> = seen().flat_map(|f| f.points.iter().copied()).collect();
        let mean = places.iter().sum::<Vec2>() / places.len().max(1) as f32;
        (certain, places.iter().map(|p| p.distance(mean)).sum::<f32>())
    };
    let (mut best, mut most) = (0, (0, 0.0));
    for frame in 0..motion.frames {
        let now = telling(frame);
        // The first of equals.
        if now.0 > most.0 || now.0 == most.0 && now.1 > most.1 {
            (best, most) = (frame, now);
        }
    }
    best
}

/// Binds a motion to a drawing of this page size and outline as [`place_points`] proposes. `object` is the contour of the
/// object in a frame of the motion's clip; without it, a figure is guessed in [`most_telling_frame`].
/// Also says how far each place is to be trusted, 0..=1.
///
/// # Errors
/// As [`place_points`]; or the motion has no such frame.
pub fn bind_automatically(
    size: (f64, f64),
    outline: &[Vec2],
    motion: &Motion,
    object: Option<(usize, &[Vec2])>,
    mirror: Option<bool>,
    stage: Stage<'_>,
) -> Result<(Binding, Vec<f32>)> {
    let frame = object.map_or_else(|| most_telling_frame(motion), |(frame, _)| frame);
    if frame >= motion.frames {
        let problem = format!("the motion has {} frames", motion.frames);
        return Err(Error::invalid(format!("frame {frame}"), problem, "frames count from 0"));
    }
    let points = control_points(motion, frame);
    let places: Vec<Vec2> = points.iter().map(|p| p.at).collect();
    let joined = joined(motion, &points);
    let shape = object.map_or(ObjectShape::Points(&joined), |(_, contour)| ObjectShape::Contour(contour));
    let placed = place_points(shape, &places, outline, mirror, stage)?;
    let hold = |(p, at): (ControlPoint, Vec2)| BindPoint { track: p.track, index: p.index, at, ..BindPoint::default() };
    let binding = Binding {
        size,
        motions: vec![MotionUse { scale: placed.scale, mirror: placed.mirror, frame, ..MotionUse::default() }],
        points: points.into_iter().zip(placed.places).map(hold).collect(),
        ..Binding::default()
    };
    Ok((binding, placed.confidence))
}

/// Which of the points are joined: neighbours along a track of several, and the ends of bones.
fn joined(motion: &Motion, points: &[ControlPoint]) -> Vec<(usize, usize)> {
    let along = (1..points.len()).filter(|&i| points[i].track == points[i - 1].track).map(|i| (i - 1, i));
    let first = |name: &str| points.iter().position(|p| p.track == name);
    let single = |name: &str| motion.track(name).is_some_and(|t| t.kind != TrackKind::Stroke);
    let bones = motion.bones.iter().filter(|(a, b)| single(a) && single(b));
    along.chain(bones.filter_map(|(a, b)| Some((first(a)?, first(b)?)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::contour_map::tests::beast;
    use crate::job::Progress;
    use crate::motion::{Track, TrackFrame};
    use glam::vec2;

    /// Head, shoulder, hip, tail and paws.
    const POINTS: [Vec2; 6] =
        [vec2(22.0, 20.0), vec2(58.0, 50.0), vec2(116.0, 50.0), vec2(150.0, 22.0), vec2(55.0, 97.0), vec2(119.0, 97.0)];

    fn motion() -> Motion {
        let track = |i: usize| Track {
            name: format!("p{i}"),
            kind: TrackKind::Point,
            // Gathered in the first frame, apart in the second.
            frames: [0.5, 1.0].iter().map(|s| TrackFrame::certain(vec![POINTS[i] * *s])).collect(),
        };
        let leg = [POINTS[1], POINTS[4]];
        let points = (0..20).map(|i| leg[0].lerp(leg[1], i as f32 / 19.0) + vec2(3.0, 0.0)).collect();
        let stroke =
            Track { name: "leg".into(), kind: TrackKind::Stroke, frames: vec![TrackFrame::certain(points); 2] };
        let tracks = (0..POINTS.len()).map(track).chain([stroke]).collect();
        Motion { size: (200, 120), fps: 25.0, frames: 2, tracks, bones: vec![("p1".into(), "p4".into())] }
    }

    #[test]
    fn limbs_land_on_limbs_whichever_way_the_drawing_faces() {
        let progress = Progress::new();
        for mirror in [false, true] {
            let drawn = |p: Vec2| vec2(if mirror { 170.0 - p.x } else { p.x }, 1.3 * p.y) * 4.0;
            let outline: Vec<Vec2> = beast().into_iter().map(drawn).collect();
            for (shape, most) in [(ObjectShape::Contour(&beast()), 0.03), (ObjectShape::Points(&[]), 0.25)] {
                let way = if most > 0.1 { Some(mirror) } else { None };
                let placed = place_points(shape, &POINTS, &outline, way, progress.whole()).expect("placed");
                assert_eq!(placed.mirror, mirror);
                for (p, at) in POINTS.iter().zip(&placed.places) {
                    let away = at.distance(drawn(*p)) / (4.0 * 1.3 * 90.0);
                    assert!(away < most, "{p} is {away} off");
                    let inside = polygon::contain(std::slice::from_ref(&outline), *at);
                    assert!(inside || polygon::nearest(&outline, *at).distance(*at) < 0.01);
                }
                assert!(placed.confidence.iter().all(|c| (0.0..=1.0).contains(c)));
                assert_eq!(place_points(shape, &POINTS, &outline, way, progress.whole()).expect("again"), placed);
            }
        }
    }

    #[test]
    fn a_motion_is_bound_where_its_points_are_spread() {
        let (motion, progress) = (motion(), Progress::new());
        assert_eq!(most_telling_frame(&motion), 1);
        // What was marked goes before what is only spread.
        let mut tracked = motion.clone();
        tracked.tracks.iter_mut().for_each(|t| t.frames[1].confidence.fill(0.9));
        assert_eq!(most_telling_frame(&tracked), 0);
        let outline: Vec<Vec2> = beast().iter().map(|p| *p * 2.0).collect();
        let contour = beast();
        for object in [None, Some((1, &contour[..]))] {
            let (bound, confidence) =
                bind_automatically((400.0, 240.0), &outline, &motion, object, None, progress.whole()).expect("bound");
            assert_eq!(confidence.len(), bound.points.len());
            assert_eq!((bound.size, bound.motions.len(), bound.motions[0].frame), ((400.0, 240.0), 1, 1));
            assert!((1.4..2.8).contains(&bound.motions[0].scale), "{}", bound.motions[0].scale);
            let of =
                |track: &str| bound.points.iter().filter(|p| p.track == track).map(|p| p.index).collect::<Vec<_>>();
            assert_eq!(of("p3"), [0]);
            assert_eq!(of("leg").last(), Some(&19), "a stroke holds by its end");
            assert!(of("leg").len() <= STROKE_POINTS);
        }
        let late = bind_automatically((1.0, 1.0), &outline, &motion, Some((2, &contour)), None, progress.whole());
        assert!(late.expect_err("no such frame").to_string().contains("2 frames"));
    }

    #[test]
    fn mistakes_are_named_and_odd_shapes_are_survived() {
        let progress = Progress::new();
        let message = |shape: ObjectShape<'_>, points: &[Vec2], outline: &[Vec2]| {
            place_points(shape, points, outline, None, progress.whole()).expect_err("wrong").to_string()
        };
        let (beast, nan) = (beast(), Vec2::splat(f32::NAN));
        let contour = ObjectShape::Contour(&beast);
        assert!(message(contour, &[], &beast).contains("there are 0"));
        assert!(message(ObjectShape::Points(&[]), &POINTS[..2], &beast).contains("mark more points"));
        assert!(message(contour, &[POINTS[0], nan], &beast).contains("point 1"));
        assert!(message(contour, &POINTS, &[]).contains("outline: encloses nothing"));
        assert!(message(contour, &POINTS, &[POINTS[0], nan, POINTS[2]]).contains("corner 1"));
        assert!(message(ObjectShape::Contour(&beast[..2]), &POINTS, &beast).contains("contour: encloses nothing"));
        assert!(message(ObjectShape::Points(&[(0, 99)]), &[POINTS[0]; 5], &beast).contains("encloses nothing"));
        // Self-crossing, tiny, and points far outside: no good places, but places on the drawing.
        let crossing = [vec2(0.0, 0.0), vec2(100.0, 100.0), vec2(100.0, 0.0), vec2(0.0, 100.0)];
        let tiny: Vec<Vec2> = beast.iter().map(|p| *p * 1e-3).collect();
        let far = [vec2(-1e5, 3.0), vec2(4.0, 1e6), vec2(50.0, 50.0)];
        for shape in [&crossing[..], &tiny, &beast] {
            let placed =
                place_points(ObjectShape::Contour(shape), &far, &tiny, None, progress.whole()).expect("placed");
            let on = |p: &Vec2| {
                polygon::contain(std::slice::from_ref(&tiny), *p) || polygon::nearest(&tiny, *p).distance(*p) < 1e-5
            };
            assert!(placed.places.iter().all(|p| p.is_finite() && on(p)));
        }
        progress.cancel();
        assert!(matches!(place_points(contour, &POINTS, &beast, None, progress.whole()), Err(Error::Cancelled)));
    }
}
