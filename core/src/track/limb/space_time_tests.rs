//! The default tracker on made-up clips with exact truth.

use glam::{Vec2, vec2};

use super::LimbTracker;
use super::stage_set::{Bar, scene};
use crate::clip::Clip;
use crate::error::Error;
use crate::job::Progress;
use crate::motion::Motion;
use crate::rig::{KeyFrame, Limb, Rig, Side, Stroke};
use crate::track::Tracker;

const SIZE: (u32, u32) = (260, 200);
const FRAMES: usize = 10;

fn body(frame: usize) -> Bar {
    Bar { from: vec2(70.0 + 1.5 * frame as f32, 60.0), angle: 0.0, length: 110.0, half_width: 16.0 }
}

/// Swings by up to 17 degrees a frame: its tip moves farther than it is wide.
fn leg(frame: usize) -> Bar {
    let angle = std::f32::consts::FRAC_PI_2 + 0.55 * (0.55 * frame as f32).sin();
    Bar { from: body(frame).at(0.0), angle, length: 95.0, half_width: 6.0 }
}

fn clip(frames: usize) -> Clip {
    let picture = |f: usize| scene(SIZE, &[body(f), leg(f)], vec2(2.0 * f as f32, 0.0));
    Clip::from_frames((0..frames).map(picture).collect(), 24.0).expect("a clip")
}

fn drawn(bar: &Bar) -> Vec<Vec2> {
    (0..=10).map(|i| bar.at(i as f32 / 10.0)).collect()
}

fn rig() -> Rig {
    let limb = |label: &str, side| Limb { label: label.into(), side: Some(side) };
    let bars = [body(0), leg(0)];
    let strokes = bars.iter().enumerate().map(|(limb, b)| Stroke { limb, points: drawn(b), facing: None });
    let key = KeyFrame { frame: 0, strokes: strokes.collect(), ..KeyFrame::default() };
    let limbs = vec![limb("body", Side::Mid), limb("leg", Side::Near)];
    Rig { size: SIZE, limbs, keyframes: vec![key] }
}

fn track(clip: &Clip, rig: &Rig) -> Motion {
    LimbTracker::default().track(clip, rig, Progress::new().whole()).expect("tracks")
}

#[test]
fn a_body_and_a_fast_leg_are_followed_from_one_drawing() {
    let motion = track(&clip(FRAMES), &rig());
    motion.validate().expect("a valid motion");
    let error = |name: &str, bar: &dyn Fn(usize) -> Bar| {
        let track = motion.track(name).expect("a track");
        let mut sum = 0.0;
        for (f, frame) in track.frames.iter().enumerate() {
            let last = (frame.points.len() - 1) as f32;
            let errors = frame.points.iter().enumerate().map(|(i, p)| p.distance(bar(f).at(i as f32 / last)));
            sum += errors.sum::<f32>() / (last + 1.0);
        }
        sum / FRAMES as f32
    };
    assert!(error("body", &body) < 3.0, "body {}", error("body", &body));
    assert!(error("leg", &leg) < 6.0, "leg {}", error("leg", &leg));
    let first = &motion.tracks[1].frames[0];
    assert!(first.confidence.iter().all(|&c| c == 1.0) && first.points[0] == leg(0).at(0.0));
}

#[test]
fn one_thread_and_three_give_the_same_bits() {
    let (clip, rig) = (clip(4), rig());
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| track(&clip, &rig))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_clip_of_one_frame_keeps_its_strokes_and_a_cancel_stops() {
    let motion = track(&clip(1), &rig());
    assert_eq!(motion.tracks[1].frames.len(), 1);
    let progress = Progress::new();
    progress.cancel();
    let cancelled = LimbTracker::default().track(&clip(2), &rig(), progress.whole());
    assert!(matches!(cancelled, Err(Error::Cancelled)));
}
