//! The joint tracker on a drawn puppet and on a painted robot, both with ground truth.

use std::path::Path;

use glam::Vec2;
use image::{Rgb, RgbImage};

use super::{CaptureReport, EarlierCapture, JointTracker};
use crate::clip::Clip;
use crate::error::Error;
use crate::job::Progress;
use crate::motion::Motion;
use crate::rig::{JointMark, JointMarks};
use crate::track::TrackJoints;

const SIZE: u32 = 120;
const NAMES: [&str; 6] = ["neck", "hip", "near knee", "near foot", "far knee", "far foot"];

/// Where the puppet's joints are in a frame: it bobs, and swings two legs against each other.
fn places(frame: usize) -> [Vec2; 6] {
    let phase = frame as f32 * 0.45;
    let hip = Vec2::new(60.0 + 0.5 * frame as f32, 55.0 + 2.0 * phase.sin());
    let leg = |phase: f32| {
        let swing = 0.6 * phase.cos();
        let knee = hip + 24.0 * Vec2::new(swing.sin(), swing.cos());
        let shin = swing - 0.35 - 0.3 * phase.sin();
        (knee, knee + 24.0 * Vec2::new(shin.sin(), shin.cos()))
    };
    let (near, far) = (leg(phase), leg(phase + std::f32::consts::PI));
    [hip - Vec2::new(0.0, 30.0), hip, near.0, near.1, far.0, far.1]
}

fn picture(frame: usize) -> RgbImage {
    let mut image = RgbImage::from_pixel(SIZE, SIZE, Rgb([240, 240, 235]));
    let [neck, hip, near_knee, near_foot, far_knee, far_foot] = places(frame);
    let mut limb = |a: Vec2, b: Vec2, radius: f32, colours: [[u8; 3]; 2]| {
        for (x, y, pixel) in image.enumerate_pixels_mut() {
            let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            if p.distance(a.lerp(b, along)) < radius {
                *pixel = Rgb(colours[usize::from((along * 4.0) as usize % 2 == 1)]);
            }
        }
    };
    limb(hip, far_knee, 5.0, [[90, 60, 120], [70, 40, 100]]);
    limb(far_knee, far_foot, 4.0, [[110, 80, 140], [60, 40, 80]]);
    limb(neck, hip, 10.0, [[200, 60, 50], [230, 190, 60]]);
    limb(hip, near_knee, 5.0, [[40, 90, 160], [60, 140, 200]]);
    limb(near_knee, near_foot, 4.0, [[30, 120, 90], [20, 70, 60]]);
    image
}

fn clip(frames: usize) -> Clip {
    Clip::from_frames((0..frames).map(picture).collect(), 24.0).expect("frames")
}

fn mark(name: &str, frame: usize, at: Vec2) -> JointMark {
    JointMark { name: name.to_owned(), frame, rect: [at.x - 4.0, at.y - 4.0, 8.0, 8.0] }
}

fn marks() -> JointMarks {
    let bones = [
        ("neck", "hip"),
        ("hip", "near knee"),
        ("near knee", "near foot"),
        ("hip", "far knee"),
        ("far knee", "far foot"),
    ];
    JointMarks {
        size: (SIZE, SIZE),
        marks: NAMES.iter().zip(places(0)).map(|(name, at)| mark(name, 0, at)).collect(),
        bones: bones.map(|(a, b)| (a.to_owned(), b.to_owned())).to_vec(),
    }
}

fn captured(clip: &Clip, marks: &JointMarks) -> Motion {
    let motion = JointTracker::default().track_joints(clip, marks, Progress::new().whole()).expect("captured");
    motion.validate().expect("a whole motion");
    motion
}

#[test]
fn a_puppet_is_followed_and_its_bones_keep_their_lengths() {
    let clip = clip(16);
    let motion = captured(&clip, &marks());
    for (name, j) in NAMES.iter().zip(0..) {
        let track = motion.track(name).expect("a track");
        let errors: Vec<f32> = (0..16).map(|f| track.frames[f].points[0].distance(places(f)[j])).collect();
        let good = errors.iter().filter(|e| **e < 4.0).count();
        assert!(good >= 14, "{name}: {errors:?}");
    }
    let report = CaptureReport::new(clip.info(), &marks(), &motion);
    assert!(report.visible > 0.5 && report.bones.len() == 5, "{report:?}");
    assert!(
        report.bones.iter().all(|b| b.longest < 1.3 * b.marked && b.shortest > 0.7 * b.marked),
        "{:?}",
        report.bones
    );
}

#[test]
fn a_correction_re_solves_what_is_between_the_marked_frames_beside_it_and_nothing_else() {
    let clip = clip(14);
    let mut first = marks();
    first.put(mark("near foot", 5, places(5)[3]));
    let before = captured(&clip, &first);
    let mut second = first.clone();
    let moved = places(9)[5] + Vec2::new(6.0, -3.0);
    second.put(mark("far foot", 9, moved));
    let after = captured(&clip, &second);
    let again = JointTracker::default()
        .retrack_joints(&clip, &second, EarlierCapture { motion: &before, marks: &first }, Progress::new().whole())
        .expect("captured again");
    assert_eq!(after, again, "it does not matter when a correction is made");
    let corrected = &after.track("far foot").expect("a track").frames[9];
    assert!(corrected.points[0].distance(moved) < 1e-4 && corrected.confidence[0] == 1.0 && corrected.visible[0]);
    for (old, new) in before.tracks.iter().zip(&after.tracks) {
        assert_eq!(old.frames[..=5], new.frames[..=5], "{}", old.name);
    }
    assert_ne!(before.tracks[5].frames[8], after.tracks[5].frames[8], "its neighbours follow");
    let mut back = second;
    assert!(back.remove("far foot", 9));
    let without = JointTracker::default()
        .retrack_joints(
            &clip,
            &back,
            EarlierCapture {
                motion: &after,
                marks: &{
                    let mut m = first;
                    m.put(mark("far foot", 9, moved));
                    m
                },
            },
            Progress::new().whole(),
        )
        .expect("captured again");
    assert!(without.track("far foot").expect("a track").frames[9].points[0].distance(moved) > 1.0, "taken back");
}

#[test]
fn the_same_bits_with_any_number_of_threads() {
    let clip = clip(6);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| captured(&clip, &marks()))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn odd_skeletons_and_short_clips_work() {
    let one = captured(&clip(1), &marks());
    assert_eq!(one.tracks[2].frames[0].points[0], places(0)[2]);
    let clip = clip(4);
    let mut loose = marks();
    loose.bones.clear();
    assert_eq!(captured(&clip, &loose).tracks.len(), 6, "joints without bones");
    let mut spot = marks();
    let hip = spot.marks[1].rect;
    spot.marks.push(JointMark { name: "pelvis".into(), frame: 0, rect: hip });
    spot.bones.push(("hip".into(), "pelvis".into()));
    captured(&clip, &spot);
    let mut edge = marks();
    edge.put(JointMark { name: "tail".into(), frame: 0, rect: [-3.0, 100.0, 4.0, 4.0] });
    edge.bones.push(("hip".into(), "tail".into()));
    captured(&clip, &edge);
}

#[test]
fn marks_that_do_not_fit_the_clip_and_a_cancel_are_errors() {
    let clip = clip(3);
    let track =
        |marks: &JointMarks, progress: &Progress| JointTracker::default().track_joints(&clip, marks, progress.whole());
    let mut late = marks();
    late.put(mark("hip", 3, places(0)[1]));
    let mut other = marks();
    other.size = (SIZE, SIZE + 1);
    for (marks, says) in
        [(late, "last frame 2"), (other, "the clip is 120x120"), (JointMarks::default(), "but the clip")]
    {
        let message = track(&marks, &Progress::new()).expect_err(says).to_string();
        assert!(message.contains(says), "{message}");
    }
    let progress = Progress::new();
    let watcher = progress.clone();
    let cancelled = std::thread::scope(|scope| {
        let work = scope.spawn(|| track(&marks(), &progress));
        while watcher.fraction() < 0.3 && !work.is_finished() {
            std::thread::yield_now();
        }
        watcher.cancel();
        work.join().expect("no panic")
    });
    assert!(matches!(cancelled, Err(Error::Cancelled)));
}

#[test]
fn a_painted_robot_is_captured() {
    #[derive(serde::Deserialize)]
    struct Truth {
        frames: std::collections::BTreeMap<usize, std::collections::BTreeMap<String, [f32; 3]>>,
    }
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/gbot-walk");
    let clip = Clip::open(data.join("frames")).expect("frames");
    let marks = JointMarks::read(data.join("joints.json")).expect("marks");
    let truth = std::fs::read_to_string(data.join("truth.json")).expect("truth");
    let truth: Truth = serde_json::from_str(&truth).expect("truth");
    let motion = captured(&clip, &marks);
    let (mut near, mut all) = (0, 0);
    for (f, joints) in truth.frames.iter().filter(|(f, _)| **f > 0) {
        for (name, [x, y, seen]) in joints {
            if *seen > 0.0 {
                all += 1;
                // 10 pixels at 512.
                near += usize::from(
                    motion.track(name).expect("a track").frames[*f].points[0].distance(Vec2::new(*x, *y)) < 5.0,
                );
            }
        }
    }
    assert!(near * 100 >= all * 95, "{near} of {all} joints within 10 pixels at 512");
}
