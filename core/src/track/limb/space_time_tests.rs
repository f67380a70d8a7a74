//! The default tracker on made-up clips with exact truth.

use glam::{Vec2, vec2};

use super::LimbTracker;
use super::stage_set::{Bar, scene};
use crate::clip::Clip;
use crate::error::Error;
use crate::job::Progress;
use crate::motion::{Motion, TrackFrame};
use crate::rig::{KeyFrame, Limb, Rig, Side, Stroke};
use crate::track::{Earlier, Tracker};

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

/// Both bars as drawn on these frames.
fn rig_on(frames: &[usize]) -> Rig {
    let limb = |label: &str, side| Limb { label: label.into(), side: Some(side) };
    let key = |&frame: &usize| {
        let bars = [body(frame), leg(frame)];
        let strokes = bars.iter().enumerate().map(|(limb, b)| Stroke { limb, points: drawn(b), facing: None });
        KeyFrame { frame, strokes: strokes.collect(), ..KeyFrame::default() }
    };
    let limbs = vec![limb("body", Side::Mid), limb("leg", Side::Near)];
    Rig { size: SIZE, limbs, keyframes: frames.iter().map(key).collect() }
}

fn rig() -> Rig {
    rig_on(&[0])
}

fn track(clip: &Clip, rig: &Rig) -> Motion {
    LimbTracker::default().track(clip, rig, Progress::new().whole()).expect("tracks")
}

/// The mean distance of a track from the truth, in pixels.
fn error(motion: &Motion, name: &str, bar: &dyn Fn(usize) -> Bar) -> f32 {
    let track = motion.track(name).expect("a track");
    let of = |(f, frame): (usize, &TrackFrame)| {
        let last = (frame.points.len() - 1) as f32;
        let errors = frame.points.iter().enumerate().map(|(i, p)| p.distance(bar(f).at(i as f32 / last)));
        errors.sum::<f32>() / (last + 1.0)
    };
    track.frames.iter().enumerate().map(of).sum::<f32>() / track.frames.len() as f32
}

#[test]
fn a_body_and_a_fast_leg_are_followed_from_one_drawing() {
    let motion = track(&clip(FRAMES), &rig());
    motion.validate().expect("a valid motion");
    let (body_error, leg_error) = (error(&motion, "body", &body), error(&motion, "leg", &leg));
    assert!(body_error < 3.0 && leg_error < 6.0, "body {body_error}, leg {leg_error}");
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

fn retrack(clip: &Clip, rig: &Rig, motion: &Motion, outdated: &[Vec<std::ops::Range<usize>>]) -> Motion {
    let earlier = Earlier { motion, outdated };
    LimbTracker::default().retrack(clip, rig, earlier, Progress::new().whole()).expect("tracks")
}

fn range(start: usize, end: usize) -> Vec<std::ops::Range<usize>> {
    vec![std::ops::Range { start, end }]
}

/// The frames of a track that differ.
fn changed(a: &Motion, b: &Motion, name: &str) -> Vec<usize> {
    let frames = [a, b].map(|m| &m.track(name).expect("a track").frames);
    (0..frames[0].len()).filter(|&f| frames[0][f] != frames[1][f]).collect()
}

#[test]
fn an_edit_re_does_its_range_and_nothing_else() {
    let clip = clip(17);
    let mut wrong = rig_on(&[0, 4, 8, 12, 16]);
    wrong.keyframes[2].strokes[1].points.iter_mut().for_each(|p| p.x += 25.0);
    let before = track(&clip, &wrong);
    let right = rig_on(&[0, 4, 8, 12, 16]);
    let after = retrack(&clip, &right, &before, &[vec![], range(5, 12)]);
    after.validate().expect("a valid motion");
    assert_eq!(changed(&before, &after, "body"), [] as [usize; 0]);
    let moved = changed(&before, &after, "leg");
    assert!(moved.contains(&8) && moved.iter().all(|f| (5..12).contains(f)), "{moved:?}");
    // As good as a run over the whole clip.
    let whole = track(&clip, &right);
    let (part, whole) = (error(&after, "leg", &leg), error(&whole, "leg", &leg));
    assert!(part < whole + 0.5, "retracked {part}, tracked {whole}");
}

#[test]
fn what_hangs_on_an_edited_limb_follows_it() {
    let clip = clip(13);
    let rig = rig_on(&[0, 4, 8, 12]);
    let before = track(&clip, &rig);
    let mut longer = rig.clone();
    longer.keyframes[1].strokes[0].points.iter_mut().for_each(|p| p.y += 6.0);
    let after = retrack(&clip, &longer, &before, &[range(1, 8), vec![]]);
    let moved = changed(&before, &after, "leg");
    assert!(moved.iter().any(|f| (1..8).contains(f)) && moved.iter().all(|f| (1..8).contains(f)), "{moved:?}");
}

#[test]
fn nothing_out_of_date_is_nothing_done_and_a_strange_motion_is_no_help() {
    let (clip, rig) = (clip(5), rig_on(&[0, 4]));
    let whole = track(&clip, &rig);
    assert_eq!(retrack(&clip, &rig, &whole, &[vec![], vec![]]), whole);
    let mut other = whole.clone();
    other.size = (10, 10);
    assert_eq!(retrack(&clip, &rig, &other, &[vec![], vec![]]), whole);
    let mut stranger = whole.clone();
    stranger.tracks.clear();
    assert_eq!(retrack(&clip, &rig, &stranger, &[vec![], vec![]]), whole);
    assert_eq!(retrack(&clip, &rig, &whole, &[range(0, 9), range(7, 3)]), whole);
}
