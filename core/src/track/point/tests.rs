//! The point tracker on drawn pictures whose motion is known.

use image::{Rgb, RgbImage};

use super::{EarlierPoints, PointFootage, PointParams, PointTracker};
use crate::clip::Clip;
use crate::error::Error;
use crate::job::Progress;
use crate::motion::Motion;
use crate::rig::{PointKey, PointMarks};
use crate::track::TrackPoints;
use crate::{Vec2, vec2};

const SIZE: u32 = 160;

/// A patterned disc: its centre, its radius, and what sets its colours apart.
type Disc = (Vec2, f32, f32);

/// Discs before a patterned ground, the last in front.
fn picture(discs: &[Disc]) -> RgbImage {
    let wave = |p: Vec2, k: f32| (p.x * 0.35 + k).sin() + (p.y * 0.28 - 2.0 * k).sin() + (0.2 * (p.x + p.y) + k).sin();
    RgbImage::from_fn(SIZE, SIZE, |x, y| {
        let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
        match discs.iter().rev().find(|d| p.distance(d.0) < d.1) {
            Some(&(centre, _, k)) => {
                let v = 25.0 * wave(p - centre, k);
                Rgb([(150.0 + v) as u8, (90.0 + 20.0 * k + v) as u8, (60.0 + 40.0 * k) as u8])
            }
            None => {
                let v = 8.0 * wave(0.4 * p, 9.0);
                Rgb([(120.0 + v) as u8, (140.0 + v) as u8, (120.0 - v) as u8])
            }
        }
    })
}

fn clip(frames: usize, discs: impl Fn(usize) -> Vec<Disc>) -> Clip {
    Clip::from_frames((0..frames).map(|f| picture(&discs(f))).collect(), 24.0).expect("frames")
}

fn marks(points: &[(&str, usize, Vec2)]) -> PointMarks {
    let mut marks = PointMarks { size: (SIZE, SIZE), points: Vec::new() };
    for (name, frame, at) in points {
        marks.put(name, PointKey { frame: *frame, at: *at });
    }
    marks
}

fn track(clip: &Clip, marks: &PointMarks) -> Motion {
    PointTracker::default().track_points(clip, marks, Progress::new().whole()).expect("tracked")
}

fn place(motion: &Motion, name: &str, frame: usize) -> Vec2 {
    motion.track(name).expect("a track").frames[frame].points[0]
}

/// A disc that goes round.
fn round(frame: usize) -> Vec2 {
    vec2(80.0, 80.0) + 40.0 * Vec2::from_angle(0.12 * frame as f32)
}

fn shape(motion: &Motion) -> Vec<(usize, Vec<Vec2>)> {
    motion.tracks.iter().map(|t| (t.frames.len(), t.frames.iter().map(|f| f.points[0]).collect())).collect()
}

#[test]
fn a_moving_pattern_is_followed_to_a_pixel_both_ways_from_its_key() {
    let clip = clip(24, |f| vec![(round(f), 18.0, 1.0)]);
    let motion = track(&clip, &marks(&[("dot", 10, round(10) + vec2(4.0, -3.0))]));
    for f in 0..24 {
        let miss = place(&motion, "dot", f).distance(round(f) + vec2(4.0, -3.0));
        assert!(miss < 1.0, "frame {f}: {miss}");
    }
    let frames = &motion.track("dot").expect("a track").frames;
    assert!(frames.iter().all(|f| f.visible[0]) && frames[10].confidence[0] == 1.0);
}

#[test]
fn a_hidden_point_is_bridged_and_said_to_be_hidden() {
    // A disc goes behind a standing one, some frames of it wholly, and comes out.
    let behind = |f: usize| vec2(20.0 + 4.0 * f as f32, 80.0);
    let middle = vec2(80.0, 80.0);
    let clip = clip(32, |f| vec![(behind(f), 8.0, 2.0), (middle, 16.0, -0.5)]);
    let params = PointParams { looks: 1.0, hide: 0.4, hidden: 0.2, ..PointParams::default() };
    let marks = marks(&[("dot", 0, behind(0))]);
    let motion = PointTracker { params }.track_points(&clip, &marks, Progress::new().whole()).expect("tracked");
    let frames = &motion.track("dot").expect("a track").frames;
    for f in 0..32 {
        let miss = place(&motion, "dot", f).distance(behind(f));
        let concealed = behind(f).distance(middle) < 20.0;
        assert!(miss < if concealed { 10.0 } else { 2.5 }, "frame {f}: {miss}");
        if behind(f).distance(middle) < 7.0 {
            assert!(!frames[f].visible[0] && frames[f].confidence[0] < 0.5, "frame {f}");
        }
    }
    assert!(frames[3].visible[0] && frames[28].visible[0]);
}

#[test]
fn twins_that_cross_keep_their_ways() {
    let one = |f: usize| vec2(30.0 + 4.0 * f as f32, 76.0);
    let other = |f: usize| vec2(130.0 - 4.0 * f as f32, 84.0);
    let clip = clip(26, |f| vec![(one(f), 10.0, 1.0), (other(f), 10.0, 1.0)]);
    let motion = track(&clip, &marks(&[("one", 0, one(0)), ("other", 0, other(0))]));
    for f in 0..26 {
        let miss = place(&motion, "one", f).distance(one(f)).max(place(&motion, "other", f).distance(other(f)));
        assert!(miss < 6.0, "frame {f}: {miss}");
    }
}

#[test]
fn a_correction_holds_changes_only_its_stretch_and_equals_a_new_start() {
    let still = vec2(40.0, 130.0);
    let clip = clip(24, |f| vec![(round(f), 18.0, 1.0), (still, 14.0, 4.0)]);
    let first = marks(&[("dot", 0, round(0)), ("dot", 12, round(12)), ("rest", 0, still)]);
    let before = track(&clip, &first);
    let mut second = first.clone();
    let corrected = round(18) + vec2(5.0, 0.0);
    second.put("dot", PointKey { frame: 18, at: corrected });
    let anew = track(&clip, &second);
    assert_eq!(place(&anew, "dot", 18), corrected);
    assert!((0..=12).all(|f| place(&anew, "dot", f) == place(&before, "dot", f)));
    assert!((0..24).all(|f| place(&anew, "rest", f) == place(&before, "rest", f)));

    let mut footage = PointFootage::read(&clip, &PointParams::default(), Progress::new().whole()).expect("read");
    assert_eq!(footage.track(&first, Progress::new().whole()).expect("tracked"), before);
    assert_eq!(footage.track(&second, Progress::new().whole()).expect("tracked"), anew);
    let earlier = EarlierPoints { motion: &before, marks: &first };
    let again =
        PointTracker::default().retrack_points(&clip, &second, earlier, Progress::new().whole()).expect("tracked");
    assert_eq!(again, anew);
    // What is taken back, removed or new is tracked as from a new start, too.
    let mut third = first.clone();
    third.remove("rest", 0);
    third.put("new", PointKey { frame: 5, at: round(5) });
    let earlier = EarlierPoints { motion: &anew, marks: &second };
    let again =
        PointTracker::default().retrack_points(&clip, &third, earlier, Progress::new().whole()).expect("tracked");
    assert_eq!(again, track(&clip, &third));
}

#[test]
fn points_on_a_swinging_arm_guide_each_other_along_it() {
    let arm = |f: usize, r: f32| vec2(50.0, 60.0) + r * Vec2::from_angle(0.5 - 0.7 * (0.2 * f as f32).cos());
    let clip = clip(24, |f| (0..9).map(|i| (arm(f, 10.0 * i as f32), 7.0, 1.0)).collect());
    let along = [0.0, 30.0, 60.0, 80.0];
    let points = marks(&[0, 1, 2, 3].map(|i| (["a", "b", "c", "d"][i], 0, arm(0, along[i]))));
    let mut footage = PointFootage::read(&clip, &PointParams::default(), Progress::new().whole()).expect("read");
    footage.guide(&points, Progress::new().whole()).expect("guided");
    assert_eq!(footage.guides.len(), 4);
    for (key, guide) in &footage.guides {
        let r = along.into_iter().min_by(|a, b| {
            let far = |r: f32| (arm(0, r) * footage.footage.scale).distance(key.at);
            far(*a).total_cmp(&far(*b))
        });
        for (f, g) in guide.iter().enumerate() {
            let miss = (g.at / footage.footage.scale).distance(arm(f, r.expect("a place")));
            // The arm goes on for 7 pixels beyond the outermost point, which may slide nearly as far.
            assert!(miss < 6.0, "frame {f}: {miss}");
        }
    }
    let first = footage.guides.clone();
    let mut corrected = points.clone();
    corrected.put("d", PointKey { frame: 9, at: vec2(10.0, 10.0) });
    footage.guide(&corrected, Progress::new().whole()).expect("guided");
    assert_eq!(footage.guides, first);
}

#[test]
fn a_guide_that_errs_does_not_tear_a_point_from_a_smooth_way() {
    let slowly = |f: usize| vec2(80.0, 80.0) + 40.0 * Vec2::from_angle(0.06 * f as f32);
    let clip = clip(80, |f| vec![(slowly(f), 18.0, 1.0)]);
    let params = PointParams::default();
    let footage = PointFootage::read(&clip, &params, Progress::new().whole()).expect("read").footage;
    let stretch = super::stretches(&[super::Key { frame: 0, at: slowly(0) * footage.scale }], 80)[0];
    let alone = stretch.alone(&footage, &params, Progress::new().whole()).expect("solved");
    // From the key away over the ground, which looks otherwise.
    let astray = |f: usize| slowly(0).lerp(vec2(20.0, 20.0), (0.1 * f as f32).min(1.0));
    let guide: Vec<_> = (0..80).map(|f| super::Guide { at: astray(f) * footage.scale, trust: 1.0 }).collect();
    let farthest = |params: &PointParams| {
        let solved = alone.guided(&footage, params, &guide, Progress::new().whole()).expect("solved");
        let misses = solved.best.places.iter().enumerate().map(|(f, p)| (p.at / footage.scale).distance(slowly(f)));
        misses.fold(0.0, f32::max)
    };
    let miss = farthest(&params);
    assert!(miss < 1.5, "{miss}");
    let miss = farthest(&PointParams { dear: f32::INFINITY, ..params.clone() });
    assert!(miss > 20.0, "{miss}");
}

#[test]
fn limbs_run_within_the_body_and_its_legs_are_a_pair() {
    // Two legs, nearer to each other than they are long, and a head, of which only the ends are marked.
    let [hips, feet] = [[vec2(60.0, 50.0), vec2(100.0, 50.0)], [vec2(64.0, 130.0), vec2(96.0, 130.0)]];
    let (middle, head) = (vec2(80.0, 50.0), vec2(80.0, 20.0));
    let bars = [[hips[0], hips[1]], [hips[0], feet[0]], [hips[1], feet[1]], [middle, head]];
    let off = |p: Vec2| {
        let to = |[a, b]: &[Vec2; 2]| {
            let t = ((p - *a).dot(*b - *a) / a.distance_squared(*b)).clamp(0.0, 1.0);
            a.lerp(*b, t).distance(p)
        };
        bars.iter().map(to).fold(f32::INFINITY, f32::min)
    };
    let drawn = RgbImage::from_fn(SIZE, SIZE, |x, y| {
        if off(vec2(x as f32, y as f32)) < 6.0 { Rgb([150, 80, 40]) } else { Rgb([120, 150, 120]) }
    });
    let clip = Clip::from_frames(vec![drawn; 3], 24.0).expect("frames");
    let footage = PointFootage::read(&clip, &PointParams::default(), Progress::new().whole()).expect("read");
    let scale = footage.footage.scale;
    let at = [feet[0], head, middle, feet[1]].map(|p| p * scale);
    let limbs = super::skeleton::branches(&footage.footage, 0, &at);
    for (i, place) in at.iter().enumerate() {
        assert!(limbs.iter().any(|l| l.points.iter().any(|&(p, v)| p == i && l.line[v] == *place)), "point {i}");
    }
    for p in limbs.iter().flat_map(|l| &l.line) {
        assert!(off(*p / scale) < 6.0, "{p} is not in the body");
    }
    let on = |l: usize, p: usize| limbs[l].points.iter().any(|q| q.0 == p);
    let pairs = super::skeleton::pairs(&limbs);
    assert_eq!(pairs.len(), 1);
    assert!(pairs[0].iter().any(|&l| on(l, 0)) && pairs[0].iter().any(|&l| on(l, 3)));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let clip = clip(16, |f| vec![(round(f), 18.0, 1.0), (round(f + 20), 12.0, 1.0)]);
    let marks = marks(&[("a", 0, round(0)), ("b", 8, round(28)), ("c", 3, vec2(5.0, 5.0))]);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| track(&clip, &marks))
    };
    let alone = with(1);
    assert_eq!(alone, with(2));
    assert_eq!(alone, with(5));
}

#[test]
fn odd_clips_have_tracks_of_finite_places() {
    let flat = |w: u32, h: u32, frames: usize| {
        Clip::from_frames(vec![RgbImage::from_pixel(w, h, Rgb([7, 90, 200])); frames], 24.0).expect("frames")
    };
    for (w, h, frames) in [(1, 1, 3), (1, 40, 2), (3, 2, 1), (64, 48, 14), (33, 9, 4)] {
        let size = (w, h);
        let mut marks = PointMarks { size, points: Vec::new() };
        marks.put("corner", PointKey { frame: 0, at: Vec2::ZERO });
        marks.put("near the corner", PointKey { frame: 0, at: vec2(0.3, 0.2) });
        marks.put("middle", PointKey { frame: 0, at: 0.5 * vec2(w as f32, h as f32) });
        marks.put("edge", PointKey { frame: frames - 1, at: vec2(w as f32, h as f32) });
        let motion = track(&flat(w, h, frames), &marks);
        for (count, places) in shape(&motion) {
            assert_eq!(count, frames);
            assert!(places.iter().all(|p| p.is_finite()), "{w}x{h}");
        }
        // Nothing moves on a flat picture.
        for f in 0..frames {
            assert!(place(&motion, "corner", f).distance(Vec2::ZERO) < 0.5, "{w}x{h}, frame {f}");
        }
    }
}

#[test]
fn marks_of_another_clip_are_refused_and_a_cancel_stops() {
    let clip = clip(6, |f| vec![(round(f), 18.0, 1.0)]);
    let tracker = PointTracker::default();
    let run = |marks: &PointMarks, progress: &Progress| tracker.track_points(&clip, marks, progress.whole());
    let good = marks(&[("dot", 0, round(0))]);
    let progress = Progress::new();
    progress.cancel();
    assert!(matches!(run(&good, &progress), Err(Error::Cancelled)));
    let late = marks(&[("dot", 6, round(0))]);
    let mut other = good.clone();
    other.size = (80, 80);
    let mut broken = good.clone();
    broken.points[0].keys[0].at.x = f32::NAN;
    for (bad, says) in [(late, "last frame 5"), (other, "but the clip is"), (broken, "no number")] {
        let message = run(&bad, &Progress::new()).expect_err(says).to_string();
        assert!(message.contains(says), "{message}");
    }
    let done = Progress::new();
    run(&good, &done).expect("tracked");
    assert!(done.fraction() > 0.99);
}

#[test]
fn the_tip_of_a_nodding_bar_is_kept() {
    type Paint = fn(f32, f32) -> Rgb<u8>;
    type Turn = fn(f32) -> f32;
    // Small pictures of a bar with a grain as fine as its steps, and of one that is only shaded.
    let grained: Paint = |along, across| {
        let (u, v) = (along as i32, across as i32);
        let grain = ((u / 7 + v / 5).rem_euclid(2) * 60 + (u * 3 + v * 5).rem_euclid(40)) as u8;
        Rgb([30 + grain, 40, 90])
    };
    let shaded: Paint = |along, across| {
        let light = (10.0 * (0.08 * along).sin() + 2.0 * across.abs()) as i32;
        Rgb([90, 60, 50].map(|c| (c + light) as u8))
    };
    let nodding: [(Paint, Turn); 2] = [(grained, |f| 0.06 * f), (shaded, |f| 0.1 + 0.35 * (0.15 * f).sin())];
    for (paint, turn) in nodding {
        let root = vec2(60.0, 60.0);
        let away = |f: usize| Vec2::from_angle(turn(f as f32));
        let bar = |f: usize| {
            RgbImage::from_fn(200, 140, |x, y| {
                let p = vec2(x as f32, y as f32) - root;
                let along = p.dot(away(f)).clamp(0.0, 90.0);
                let inside = p.distance(along * away(f)) < 14.0;
                if inside { paint(along, -p.perp_dot(away(f))) } else { Rgb([225, 225, 220]) }
            })
        };
        let clip = Clip::from_frames((0..8).map(bar).collect(), 24.0).expect("frames");
        let mut marks = PointMarks { size: (200, 140), points: Vec::new() };
        for (name, along) in [("root", 0.0), ("middle", 45.0), ("tip", 86.0)] {
            marks.put(name, PointKey { frame: 0, at: root + along * away(0) });
        }
        let motion = track(&clip, &marks);
        for f in 0..8 {
            let miss = place(&motion, "tip", f).distance(root + 86.0 * away(f));
            assert!(miss < 4.0, "frame {f}: {miss}");
        }
    }
}
