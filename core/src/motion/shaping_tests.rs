//! Cycles, loops, smoothing, planting, other times and limb maps on gaits whose truth is known, and on the bundled fox.

use std::f32::consts::TAU;

use glam::{DVec2, Vec2, vec2};
use proptest::prelude::*;

use super::limb_map::{LimbMap, LimbMapParams, LimbSource, map_limbs, propose_map, rest_limbs};
use super::*;
use crate::geometry::polyline;

/// Numbers that look like noise: the same every time.
fn noise(seed: usize) -> f32 {
    let mut x = seed as u64 + 0x9E37_79B9_7F4A_7C15;
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ (x >> 31)) >> 40) as f32 / (1 << 23) as f32 - 1.0
}

fn jittered(p: Vec2, seed: usize, amount: f32) -> Vec2 {
    p + amount * vec2(noise(2 * seed), noise(2 * seed + 1))
}

/// A four-legged walk to the right: a body, a tail and four legs, each a quarter of a stride after the one before.
fn walk(frames: usize, period: f32, speed: Vec2, jitter: f32) -> Motion {
    let legs = [("hind_near", 0.0), ("fore_near", 0.25), ("hind_far", 0.5), ("fore_far", 0.75)];
    let body = |f: f32| vec2(100.0, 100.0) + speed * f + vec2(0.0, 3.0 * (2.0 * TAU * f / period).sin());
    let track = |name: &str, line: &dyn Fn(f32) -> Vec<Vec2>| Track {
        name: name.into(),
        kind: TrackKind::Stroke,
        frames: (0..frames)
            .map(|f| {
                let points = polyline::resample(&line(f as f32), 9);
                let seed =
                    |i: usize| 1000 * name.len() + 31 * name.bytes().map(usize::from).sum::<usize>() + 10 * f + i;
                let points = points.into_iter().enumerate().map(|(i, p)| jittered(p, seed(i), jitter)).collect();
                TrackFrame { confidence: vec![0.8; 9], ..TrackFrame::certain(points) }
            })
            .collect(),
    };
    let mut tracks = vec![
        track("body", &|f| vec![body(f), body(f) + vec2(120.0, 0.0)]),
        track("tail", &|f| vec![body(f), body(f) + Vec2::from_angle(2.6 + 0.3 * (TAU * f / period).cos()) * 60.0]),
    ];
    for (name, phase) in legs {
        let hip = if name.starts_with("hind") { Vec2::ZERO } else { vec2(120.0, 0.0) };
        tracks.push(track(name, &|f| {
            let turn = TAU * (f / period - phase);
            let (swing, knee) = (1.57 - 0.45 * turn.cos(), 0.5 * (-turn.sin()).max(0.0));
            let root = body(f) + hip;
            let middle = root + Vec2::from_angle(swing) * 50.0;
            vec![root, middle, middle + Vec2::from_angle(swing + knee) * 50.0]
        }));
    }
    let bones = ["tail", "hind_near", "fore_near", "hind_far", "fore_far"].map(|t| ("body".to_owned(), t.to_owned()));
    Motion { size: (800, 400), fps: 24.0, frames, tracks, bones: bones.to_vec() }
}

/// The true limbs of the bundled fox as a motion.
fn fox() -> Motion {
    #[derive(serde::Deserialize)]
    struct Limb {
        axis: Vec<Vec<[f32; 3]>>,
    }
    #[derive(serde::Deserialize)]
    struct Truth {
        frames: usize,
        limbs: std::collections::BTreeMap<String, Limb>,
    }
    let truth: Truth = serde_json::from_str(include_str!("../../../data/fox/truth.json")).expect("the bundled truth");
    let track = |(name, limb): (&String, &Limb)| {
        let mut lines: Vec<Vec<Vec2>> =
            limb.axis.iter().map(|f| f.iter().map(|p| vec2(p[0], p[1])).collect()).collect();
        // Every limb from the body outward.
        let hips = [vec2(314.0, 243.0), vec2(426.0, 255.0)];
        let near = |p: Vec2| hips.iter().map(|h| h.distance(p)).fold(f32::INFINITY, f32::min);
        if name != "body" && near(lines[0][lines[0].len() - 1]) < near(lines[0][0]) {
            lines.iter_mut().for_each(|l| l.reverse());
        }
        let frame = |l: Vec<Vec2>| TrackFrame { confidence: vec![0.9; l.len()], ..TrackFrame::certain(l) };
        Track { name: name.clone(), kind: TrackKind::Stroke, frames: lines.into_iter().map(frame).collect() }
    };
    let tracks: Vec<Track> = truth.limbs.iter().map(track).collect();
    let hang = tracks.iter().filter(|t| t.name != "body").map(|t| ("body".to_owned(), t.name.clone()));
    Motion { size: (768, 576), fps: 24.0, frames: truth.frames, bones: hang.collect(), tracks }
}

fn foot(motion: &Motion, track: &str, f: usize) -> Vec2 {
    *motion.track(track).expect("a track").frames[f].points.last().expect("points")
}

fn message(result: Result<impl std::fmt::Debug, crate::error::Error>) -> String {
    result.expect_err("refused").to_string()
}

#[test]
fn periods_are_found_under_drift_noise_and_hidden_spans() {
    for (frames, period) in [(60, 20.0), (48, 36.5), (100, 25.6), (40, 12.25)] {
        for (speed, jitter) in [(Vec2::ZERO, 0.0), (vec2(4.0, -0.5), 0.0), (vec2(-3.0, 0.3), 2.0)] {
            let cycle = find_cycle(&walk(frames, period, speed, jitter)).expect("a cycle");
            let off = (cycle.period - f64::from(period)).abs();
            assert!(off < 0.15 + 0.15 * f64::from(jitter), "{frames} {period} {speed} {jitter}: {}", cycle.period);
            assert!(cycle.start >= 0.0 && cycle.start + cycle.period <= frames as f64);
            assert!(cycle.confidence > 0.7, "{}", cycle.confidence);
        }
    }
    // A leg that is lost for a third of the clip, and said to be.
    let mut motion = walk(60, 20.0, vec2(2.0, 0.0), 1.0);
    for f in 20..40 {
        let frame = &mut motion.tracks[2].frames[f];
        frame.points.iter_mut().for_each(|p| *p += vec2(60.0, -40.0));
        (frame.confidence, frame.visible) = (vec![0.1; 9], vec![false; 9]);
    }
    let cycle = find_cycle(&motion).expect("a cycle");
    assert!((cycle.period - 20.0).abs() < 0.3, "{}", cycle.period);
}

#[test]
fn phases_say_which_foot_is_when() {
    let cycle = find_cycle(&walk(60, 20.0, vec2(3.0, 0.0), 0.5)).expect("a cycle");
    let phase = |name: &str| cycle.limbs.iter().find(|l| l.track == name).expect("a limb").phase;
    for (name, later) in [("fore_near", 0.25), ("hind_far", 0.5), ("fore_far", 0.75)] {
        let lag = (phase(name) - phase("hind_near") - later).rem_euclid(1.0);
        assert!(!(0.04..=0.96).contains(&lag), "{name}: {lag}");
    }
    let swing = cycle.limbs.iter().find(|l| l.track == "hind_near").expect("a limb").swing;
    assert!((35.0..55.0).contains(&swing), "{swing}");
}

#[test]
fn what_has_no_cycle_says_so_and_what_to_do() {
    let still = walk(1, 20.0, Vec2::ZERO, 0.0).at_times(&[0.0; 50], sampling::Ends::Open, 24.0);
    let mut drifting = still.clone();
    for (f, frame) in drifting.tracks[2].frames.iter_mut().enumerate() {
        let root = frame.points[0];
        frame.points.iter_mut().for_each(|p| *p = root + Vec2::from_angle(0.02 * f as f32).rotate(*p - root));
    }
    let mut shaking = still.clone();
    for track in &mut shaking.tracks {
        for (f, frame) in track.frames.iter_mut().enumerate() {
            frame.points.iter_mut().enumerate().for_each(|(i, p)| *p = jittered(*p, 100 * f + i, 20.0));
        }
    }
    let short = walk(6, 20.0, Vec2::ZERO, 0.0);
    let part = walk(18, 20.0, Vec2::ZERO, 0.0);
    for motion in [still, drifting, shaking, short, part] {
        for text in [message(find_cycle(&motion)), message(close_loop(&motion, &LoopParams::default()))] {
            assert!(text.contains("cycle of the motion") && text.contains("where the loop begins"), "{text}");
        }
    }
}

#[test]
fn a_loop_of_a_perfect_gait_is_that_gait() {
    let motion = walk(60, 20.0, vec2(3.0, 0.0), 0.0);
    let closed = close_loop(&motion, &LoopParams::default()).expect("a loop");
    assert_eq!(closed.motion.frames, 20);
    assert!((closed.travel - DVec2::new(60.0, 0.0)).length() < 0.5, "{}", closed.travel);
    // In place: as one that never went anywhere.
    let truth = walk(60, 20.0, Vec2::ZERO, 0.0);
    let start = closed.start as usize;
    let shift = closed.motion.tracks[0].frames[0].points[0] - truth.tracks[0].frames[start].points[0];
    for (made, true_) in closed.motion.tracks.iter().zip(&truth.tracks) {
        for f in 0..20 {
            for (p, q) in made.frames[f].points.iter().zip(&true_.frames[start + f].points) {
                assert!(p.distance(*q + shift) < 0.5, "{} {f}: {p} {q}", made.name);
            }
        }
    }
    // With its way: repeated, it goes on.
    let going = close_loop(&motion, &LoopParams { in_place: false, ..LoopParams::default() }).expect("a loop");
    let step = foot(&going.motion, "tail", 0) + going.travel.as_vec2() - foot(&going.motion, "tail", 19);
    assert!(step.distance(vec2(3.0, 0.0)) < 4.0, "{step}");
}

#[test]
fn seams_of_noisy_and_of_real_gaits_do_not_show() {
    // Jitter of a pixel and a half changes steps by a hundredth of the figure anywhere: it may do so at the seam.
    let motions =
        [(walk(48, 36.5, vec2(3.0, 0.2), 1.5), 0.05), (walk(90, 25.6, vec2(-2.0, 0.0), 1.5), 0.05), (fox(), 0.01)];
    for (motion, most) in motions {
        for (frames, fade) in [(None, 0.25), (Some(40), 0.25), (None, 0.0)] {
            let params = LoopParams { frames, fade, ..LoopParams::default() };
            let closed = close_loop(&motion, &params).expect("a loop");
            closed.motion.validate().expect("valid");
            assert!(closed.seam.pose < 0.01 && closed.seam.pose_most < most, "{:?}", closed.seam);
            assert!(closed.seam.speed < 0.015 && closed.seam.speed_most < most, "{:?}", closed.seam);
        }
    }
    let cycle = find_cycle(&fox()).expect("a cycle");
    assert!((25.0..26.2).contains(&cycle.period), "{}", cycle.period);
}

#[test]
fn a_gap_between_ends_is_taken_up_without_tearing_limbs_off() {
    // A stride that ends with the head turned: the tail is 0.4 radians off after a period, and nothing lies beyond.
    let mut motion = walk(30, 29.0, vec2(2.0, 0.0), 0.0);
    let body: Vec<Vec2> = motion.tracks[0].frames.iter().map(|f| f.points[0]).collect();
    for (f, frame) in motion.tracks[1].frames.iter_mut().enumerate() {
        let turn = Vec2::from_angle(0.4 * f as f32 / 29.0);
        frame.points.iter_mut().for_each(|p| *p = body[f] + turn.rotate(*p - body[f]));
    }
    let params = LoopParams { range: Some((0.0, 29.0)), ..LoopParams::default() };
    let closed = close_loop(&motion, &params).expect("a loop");
    for f in 0..closed.motion.frames {
        let at = |t: usize, p: usize| closed.motion.tracks[t].frames[f].points[p];
        assert!(at(1, 0).distance(at(0, 0)) < 1e-3, "the tail comes off in frame {f}");
        let length = polyline::length(&closed.motion.tracks[1].frames[f].points);
        // Half the gap is bridged by places, not by angles.
        assert!((length - 60.0).abs() < 4.0, "{length}");
    }
    // The step over the seam is like its neighbours.
    let step = |a: usize, b: usize| foot(&closed.motion, "tail", a).distance(foot(&closed.motion, "tail", b));
    let usual = (0..28).map(|f| step(f, f + 1)).fold(0.0, f32::max);
    assert!(step(28, 0) <= usual + 0.5, "{} {usual}", step(28, 0));
    // One that ends right after the last frame.
    let params = LoopParams { range: Some((0.0, 30.0)), ..LoopParams::default() };
    assert_eq!(close_loop(&motion, &params).expect("a loop").motion.frames, 30);
}

#[test]
fn loops_that_cannot_be_are_refused() {
    let motion = walk(60, 20.0, Vec2::ZERO, 0.0);
    let range = |start: f64, period: f64| LoopParams { range: Some((start, period)), ..LoopParams::default() };
    for params in [
        range(50.0, 20.0),
        range(-1.0, 20.0),
        range(0.0, 2.0),
        range(f64::NAN, 20.0),
        range(0.0, f64::INFINITY),
        LoopParams { cycles: 0, ..LoopParams::default() },
        LoopParams { cycles: 9, ..LoopParams::default() },
        LoopParams { frames: Some(2), ..LoopParams::default() },
        LoopParams { frames: Some(usize::MAX), ..LoopParams::default() },
        LoopParams { fps: Some(0.0), ..LoopParams::default() },
        LoopParams { fps: Some(1e300), ..LoopParams::default() },
        LoopParams { fade: f64::NAN, ..LoopParams::default() },
    ] {
        assert!(close_loop(&motion, &params).is_err(), "{params:?}");
    }
    let two = close_loop(&motion, &LoopParams { cycles: 2, ..LoopParams::default() }).expect("two strides");
    assert_eq!(two.motion.frames, 40);
    let mut empty = motion.clone();
    empty.tracks.clear();
    let one = motion.at_times(&[0.0], sampling::Ends::Open, 24.0);
    let mut odd = motion.clone();
    odd.tracks[0].frames[3].points[0].x = f32::NAN;
    for motion in [&empty, &one, &odd] {
        assert!(find_cycle(motion).is_err() && close_loop(motion, &LoopParams::default()).is_err());
        assert!(plant(motion, &PlantParams::default()).is_err());
    }
    for motion in [&empty, &odd] {
        assert!(smooth(motion, &SmoothParams::default()).is_err() && retime(motion, &Retime::default()).is_err());
    }
}

#[test]
fn smoothing_takes_jitter_and_keeps_key_frames_and_the_gait() {
    let (truth, mut noisy) = (walk(60, 20.0, vec2(2.0, 0.0), 0.0), walk(60, 20.0, vec2(2.0, 0.0), 2.0));
    for key in [0, 24, 25, 59] {
        for track in &mut noisy.tracks {
            track.frames[key].confidence.fill(1.0);
        }
    }
    let made = smooth(&noisy, &SmoothParams::default()).expect("smooth");
    let (mut before, mut after) = (0.0, 0.0);
    for ((track, raw), true_) in made.tracks.iter().zip(&noisy.tracks).zip(&truth.tracks) {
        for key in [0, 24, 25, 59] {
            assert_eq!(track.frames[key], raw.frames[key]);
        }
        for f in 0..60 {
            for i in 0..9 {
                before += raw.frames[f].points[i].distance_squared(true_.frames[f].points[i]);
                after += track.frames[f].points[i].distance_squared(true_.frames[f].points[i]);
            }
        }
    }
    assert!(after < 0.45 * before, "{after} {before}");
    // Frames that are named are held instead; a slip that nobody trusts is bridged.
    let mut slipped = truth.clone();
    slipped.tracks[0].frames[30].points.iter_mut().for_each(|p| *p += 50.0);
    slipped.tracks[0].frames[30].confidence.fill(0.0);
    let params = SmoothParams { held: Held::Frames(vec![7]), ..SmoothParams::default() };
    let made = smooth(&slipped, &params).expect("smooth");
    assert_eq!(made.tracks[3].frames[7], truth.tracks[3].frames[7]);
    let off = made.tracks[0].frames[30].points[0].distance(truth.tracks[0].frames[30].points[0]);
    assert!(off < 6.0, "{off}");
    for params in [
        SmoothParams { period: f64::NAN, ..SmoothParams::default() },
        SmoothParams { period: 1e9, ..SmoothParams::default() },
        SmoothParams { held: Held::Frames(vec![60]), ..SmoothParams::default() },
    ] {
        assert!(smooth(&truth, &params).is_err());
    }
    for frames in 1..5 {
        smooth(&walk(frames, 20.0, Vec2::ZERO, 1.0), &SmoothParams::default()).expect("short ones too");
    }
}

/// A walk whose feet stand on the ground for half a stride, seen by a camera that goes along, with feet that slide.
fn striding(frames: usize, slide: f32) -> Motion {
    let mut motion = walk(frames, 20.0, Vec2::ZERO, 0.0);
    for (leg, phase) in [(2, 0.0), (3, 0.25), (4, 0.5), (5, 0.75)] {
        for f in 0..frames {
            let share = (f as f32 / 20.0 + phase).fract();
            let points = &mut motion.tracks[leg].frames[f].points;
            let root = points[0];
            let foot = match share {
                // On the ground, which goes to the left by 6 pixels a frame.
                s if s < 0.5 => vec2(root.x + 30.0 - 120.0 * s, 190.0),
                s => {
                    let up = (s - 0.5) * 2.0;
                    vec2(root.x - 30.0 + 60.0 * up * up * (3.0 - 2.0 * up), 190.0 - 25.0 * (up * TAU / 2.0).sin())
                }
            };
            let foot = jittered(foot, 7 * f + leg, slide);
            let limb: Vec<DVec2> = points.iter().map(|p| p.as_dvec2()).collect();
            let bent = limb_reach::reach(&limb, foot.as_dvec2());
            points.iter_mut().zip(bent).for_each(|(p, q)| *p = q.as_vec2());
        }
    }
    motion
}

#[test]
fn planted_feet_go_with_the_ground_and_limbs_keep_their_lengths() {
    let motion = striding(80, 2.5);
    for closed in [false, true] {
        let planted = plant(&motion, &PlantParams { closed, ..PlantParams::default() }).expect("planted");
        assert!((planted.ground - DVec2::new(-6.0, 0.0)).length() < 0.4, "{}", planted.ground);
        let feet: Vec<&str> = planted.feet.iter().map(|f| f.track.as_str()).collect();
        assert_eq!(feet, ["hind_near", "fore_near", "hind_far", "fore_far"]);
        for contacts in &planted.feet {
            assert!((3..=6).contains(&contacts.spans.len()), "{contacts:?}");
            let down: usize = contacts.spans.iter().map(|s| s.1 - s.0 + 1).sum();
            assert!((24..=48).contains(&down), "{contacts:?}");
            assert!(contacts.slide.0 > 1.0 && contacts.slide.1 < 0.1, "{contacts:?}");
        }
        for (made, was) in planted.motion.tracks.iter().zip(&motion.tracks) {
            for (a, b) in made.frames.iter().zip(&was.frames) {
                assert_eq!(a.points[0], b.points[0]);
                assert!((polyline::length(&a.points) - polyline::length(&b.points)).abs() < 0.05);
            }
        }
        // Let go without a jump: no step is longer than the longest there was, and a little.
        let longest = |m: &Motion| {
            (1..m.frames).map(|f| foot(m, "hind_near", f).distance(foot(m, "hind_near", f - 1))).fold(0.0, f32::max)
        };
        assert!(longest(&planted.motion) < longest(&motion) + 1.5);
    }
    let grounded = plant(&motion, &PlantParams { ground: Some(188.0), ..PlantParams::default() }).expect("planted");
    for contacts in &grounded.feet {
        for f in contacts.spans.iter().flat_map(|s| s.0..=s.1) {
            assert!((foot(&grounded.motion, &contacts.track, f).y - 188.0).abs() < 0.05);
        }
        assert!((0..80).all(|f| foot(&grounded.motion, &contacts.track, f).y < 188.1));
    }
    let named = |name: &str| PlantParams { feet: vec![name.into()], ..PlantParams::default() };
    assert_eq!(plant(&motion, &named("fore_far")).expect("planted").feet.len(), 1);
    assert!(message(plant(&motion, &named("hoof"))).contains("`hoof`"));
    assert!(plant(&motion, &PlantParams { ground: Some(f64::NAN), ..PlantParams::default() }).is_err());
    assert!(plant(&motion, &PlantParams { ease: -1.0, ..PlantParams::default() }).is_err());
}

#[test]
fn a_characters_foot_is_planted_by_its_knee() {
    // Joints at the ends and the middle of a leg, on ground that stands still.
    let strokes = striding(60, 2.0);
    let mut motion = Motion::new((800, 400), 24.0, 60).expect("a motion");
    for (name, point) in [("hip", 0), ("knee", 4), ("foot", 8), ("toe", 8)] {
        let track = motion.add_track(name, TrackKind::Joint, 1).expect("a track");
        for f in 0..60 {
            let mut at = strokes.tracks[2].frames[f].points[point] + vec2(6.0 * f as f32, 0.0);
            if name == "toe" {
                at.x += 8.0;
            }
            motion.set_frame(track, f, TrackFrame::certain(vec![at])).expect("set");
        }
        if track > 0 {
            motion.join(track - 1, track).expect("joined");
        }
    }
    let params = PlantParams { feet: vec!["foot".into()], still: true, ..PlantParams::default() };
    let planted = plant(&motion, &params).expect("planted");
    let slide = planted.feet[0].slide;
    assert!(slide.0 > 1.0 && slide.1 < 0.05, "{slide:?}");
    // Without a name the foot is found, not the toe that hangs from it.
    let found = plant(&motion, &PlantParams { still: true, ..PlantParams::default() }).expect("planted");
    assert_eq!(found, planted);
    for f in 0..60 {
        let at = |m: &Motion, name: &str| m.track(name).expect("a track").frames[f].points[0];
        for (a, b) in [("hip", "knee"), ("knee", "foot"), ("foot", "toe")] {
            let length = |m: &Motion| at(m, a).distance(at(m, b));
            assert!((length(&planted.motion) - length(&motion)).abs() < 0.01, "{f} {a}");
        }
    }
}

#[test]
fn times_are_what_was_asked_for() {
    let motion = walk(49, 20.0, vec2(2.0, 0.0), 1.0);
    let frames = |how: &Retime| retime(&motion, how).expect("another time").frames;
    let how = Retime::default;
    assert_eq!(retime(&motion, &how()).expect("as it was"), motion);
    assert_eq!(frames(&Retime { speed: 2.0, ..how() }), 25);
    assert_eq!(frames(&Retime { speed: 0.5, ..how() }), 97);
    assert_eq!(frames(&Retime { seconds: Some(1.0), ..how() }), 24);
    assert_eq!(frames(&Retime { fps: Some(12.0), ..how() }), 25);
    let back = Retime { direction: Direction::Backward, ..how() };
    let turned = retime(&motion, &back).expect("backwards");
    assert_eq!(foot(&turned, "tail", 0), foot(&motion, "tail", 48));
    assert_eq!(retime(&turned, &back).expect("forwards"), motion);
    let there = retime(&motion, &Retime { direction: Direction::ThereAndBack, ..how() }).expect("there and back");
    assert_eq!((there.frames, foot(&there, "tail", 49)), (96, foot(&motion, "tail", 47)));
    let twos = retime(&motion, &Retime { hold: 2, ..how() }).expect("on twos");
    assert!((0..49).all(|f| foot(&twos, "tail", f) == foot(&motion, "tail", f - f % 2)));
    // What is between frames is not certain, what is a frame stays as it was.
    let mut drawn = motion.clone();
    drawn.tracks.iter_mut().flat_map(|t| &mut t.frames).for_each(|f| f.confidence.fill(1.0));
    drawn.tracks[0].frames[10].visible[3] = false;
    let slow = retime(&drawn, &Retime { speed: 0.5, ..how() }).expect("slow");
    assert_eq!(slow.tracks[0].frames[20], drawn.tracks[0].frames[10]);
    assert!(slow.tracks[0].frames[21].confidence.iter().all(|c| *c < 1.0));
}

#[test]
fn keys_say_when_what_comes() {
    let motion = walk(49, 20.0, vec2(2.0, 0.0), 0.0);
    let key = |at: f64, frame: f64, easing: Easing| TimeKey { at, frame, easing };
    let keys = vec![
        key(0.0, 0.0, Easing::InOut),
        key(20.0, 30.0, Easing::Hold),
        key(30.0, 30.0, Easing::Linear),
        key(40.0, 48.0, Easing::Linear),
    ];
    for smooth in [false, true] {
        let made = retime(&motion, &Retime { keys: keys.clone(), smooth, ..Retime::default() }).expect("by keys");
        assert_eq!(made.frames, 41);
        for key in &keys {
            assert!(foot(&made, "tail", key.at as usize).distance(foot(&motion, "tail", key.frame as usize)) < 1e-3);
        }
        assert!(
            (20..=30).all(|f| foot(&made, "tail", f).distance(foot(&motion, "tail", 30)) < 1e-3),
            "it runs backwards"
        );
    }
    for (keys, about) in [
        (vec![key(0.0, 49.0, Easing::Linear)], "time key 0"),
        (vec![key(5.0, 1.0, Easing::Linear), key(5.0, 2.0, Easing::Linear)], "time key 1"),
        (vec![key(f64::NAN, 1.0, Easing::Linear)], "time key 0"),
        (vec![key(1e300, 1.0, Easing::Linear)], "the number of frames"),
    ] {
        let text = message(retime(&motion, &Retime { keys, ..Retime::default() }));
        assert!(text.contains(about), "{text}");
    }
    let how = Retime::default;
    for how in [
        Retime { speed: 0.0, ..how() },
        Retime { speed: 1e-300, ..how() },
        Retime { speed: f64::NAN, ..how() },
        Retime { seconds: Some(-1.0), ..how() },
        Retime { fps: Some(f64::INFINITY), ..how() },
        Retime { hold: 0, ..how() },
    ] {
        assert!(retime(&motion, &how).is_err(), "{how:?}");
    }
}

#[test]
fn a_loop_stays_one_at_another_time() {
    let closed = close_loop(&walk(60, 20.0, vec2(3.0, 0.0), 0.0), &LoopParams::default()).expect("a loop").motion;
    let slow = retime(&closed, &Retime { speed: 0.4, closed: true, ..Retime::default() }).expect("slow");
    assert_eq!(slow.frames, 50);
    let steps: Vec<f32> =
        (0..50).map(|f| foot(&slow, "hind_near", f).distance(foot(&slow, "hind_near", (f + 1) % 50))).collect();
    let most = steps[..49].iter().copied().fold(0.0, f32::max);
    assert!(steps[49] <= most, "{} {most}", steps[49]);
    let back = Retime { direction: Direction::Backward, closed: true, ..Retime::default() };
    let turned = retime(&closed, &back).expect("backwards");
    assert_eq!(foot(&turned, "tail", 1), foot(&closed, "tail", 19));
    assert_eq!(retime(&turned, &back).expect("forwards"), closed);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn slower_and_as_much_faster_is_nearly_as_it_was(speed in 0.3f64..1.0) {
        let motion = walk(40, 20.0, vec2(2.0, 0.0), 0.0);
        let slow = retime(&motion, &Retime { speed, ..Retime::default() }).expect("slow");
        let back = retime(&slow, &Retime { speed: 1.0 / speed, ..Retime::default() }).expect("fast");
        prop_assert!(back.frames + 1 >= motion.frames && back.frames <= motion.frames);
        for (a, b) in back.tracks.iter().zip(&motion.tracks) {
            for f in 1..back.frames - 1 {
                for (p, q) in a.frames[f].points.iter().zip(&b.frames[f].points) {
                    prop_assert!(p.distance(*q) < 1.5, "{} {f}: {p} {q}", a.name);
                }
            }
        }
    }
}

/// A stout creature that faces left, drawn in the middle of a step, with names of its own.
fn creature() -> Motion {
    let limb = |name: &str, line: &[(f32, f32)]| Track {
        name: name.into(),
        kind: TrackKind::Stroke,
        frames: vec![TrackFrame::certain(polyline::resample(
            &line.iter().map(|p| Vec2::from(*p)).collect::<Vec<_>>(),
            11,
        ))],
    };
    let tracks = vec![
        limb("trunk_body", &[(300.0, 100.0), (120.0, 100.0)]),
        limb("front_left", &[(120.0, 100.0), (130.0, 150.0), (110.0, 200.0)]),
        limb("front_right", &[(120.0, 100.0), (100.0, 150.0), (105.0, 200.0)]),
        limb("back_left", &[(300.0, 100.0), (290.0, 150.0), (310.0, 200.0)]),
        limb("back_right", &[(300.0, 100.0), (320.0, 150.0), (330.0, 195.0)]),
        limb("tail", &[(300.0, 100.0), (340.0, 80.0)]),
        limb("horn", &[(120.0, 100.0), (90.0, 60.0)]),
    ];
    let bones = tracks[1..].iter().map(|t| ("trunk_body".to_owned(), t.name.clone())).collect();
    Motion { size: (400, 300), fps: 12.0, frames: 1, tracks, bones }
}

#[test]
fn a_walk_goes_over_to_a_creature_of_other_names_that_faces_the_other_way() {
    let (source, own) = (walk(40, 20.0, vec2(2.0, 0.0), 0.0), creature());
    let limbs = rest_limbs(&own, None).expect("limbs");
    let map = propose_map(&source, &limbs).expect("a map");
    let follows = |limb: &str| map.limbs.get(limb).map(|s| s.tracks[0].as_str());
    assert_eq!(follows("front_left"), Some("fore_near"));
    assert_eq!(follows("back_right"), Some("hind_far"));
    assert_eq!((follows("tail"), follows("trunk_body")), (Some("tail"), Some("body")));
    assert_eq!(LimbMap::from_json(&map.to_json()).expect("read"), map);
    let made = map_limbs(&source, &limbs, own.size, &map, &LimbMapParams::default()).expect("carried");
    assert_eq!((made.frames, made.tracks.len(), made.fps), (40, 7, 24.0));
    for (track, limb) in made.tracks.iter().zip(&limbs) {
        assert_eq!(track.name, limb.name);
        for (f, frame) in track.frames.iter().enumerate() {
            let (is, was) = (polyline::length(&frame.points), polyline::length(&limb.points));
            assert!((is - was).abs() < 0.02, "{} {f}: {is} {was}", limb.name);
            // Every limb hangs where it hung.
            if let Some(parent) = limb.parent {
                let end = if limb.points[0].distance(limbs[parent].points[0]) < 1.0 { 0 } else { 10 };
                assert!(frame.points[0].distance(made.tracks[parent].frames[f].points[end]) < 0.02);
            }
        }
    }
    // It walks to the left, by the ratio of the figures, and its legs swing as the source's do, mirrored.
    let way = foot(&made, "trunk_body", 39).x - foot(&made, "trunk_body", 0).x;
    assert!(way < -60.0, "{way}");
    let angle = |m: &Motion, limb: &str, f: usize| {
        let points = &m.track(limb).expect("a limb").frames[f].points;
        (*points.last().expect("points") - points[0]).to_angle()
    };
    for f in 0..20 {
        let theirs = angle(&source, "fore_near", f) - angle(&source, "fore_near", f + 10);
        let ours = angle(&made, "front_left", f) - angle(&made, "front_left", f + 10);
        assert!((theirs + ours).abs() < 0.12, "{f}: {theirs} {ours}");
    }
    let placed = LimbMapParams { travel: Some(0.0), ..LimbMapParams::default() };
    let placed = map_limbs(&source, &limbs, own.size, &map, &placed).expect("in place");
    assert!(placed.tracks[0].frames[39].points[0].distance(placed.tracks[0].frames[0].points[0]) < 1e-3);
}

#[test]
fn onto_its_own_limbs_a_motion_comes_back() {
    let source = walk(40, 20.0, vec2(2.0, 0.0), 0.0);
    let limbs = rest_limbs(&source, Some(7)).expect("limbs");
    let map = propose_map(&source, &limbs).expect("a map");
    let params = LimbMapParams { reference: Some(7), ..LimbMapParams::default() };
    let made = map_limbs(&source, &limbs, source.size, &map, &params).expect("carried");
    for (a, b) in made.tracks.iter().zip(&source.tracks) {
        for (p, q) in a.frames.iter().zip(&b.frames).flat_map(|(p, q)| p.points.iter().zip(&q.points)) {
            // Legs are nine points on two bones: the one across the knee changes its length.
            assert!(p.distance(*q) < 4.0, "{}: {p} {q}", a.name);
        }
    }
}

#[test]
fn joints_of_a_biped_move_two_legs() {
    // A figure of joints, as motion capture has it.
    let mut biped = Motion::new((400, 400), 30.0, 30).expect("a motion");
    let joints = [
        ("Hips", (200.0, 150.0), None),
        ("LeftUpLeg", (205.0, 160.0), Some(0)),
        ("LeftLeg", (205.0, 220.0), Some(1)),
        ("LeftFoot", (205.0, 280.0), Some(2)),
        ("RightUpLeg", (195.0, 160.0), Some(0)),
        ("RightLeg", (195.0, 220.0), Some(4)),
        ("RightFoot", (195.0, 280.0), Some(5)),
        ("Spine", (200.0, 110.0), Some(0)),
        ("Neck", (200.0, 70.0), Some(7)),
        ("Head", (200.0, 50.0), Some(8)),
    ];
    for (name, at, parent) in joints {
        let track = biped.add_track(name, TrackKind::Joint, 1).expect("a track");
        for f in 0..30 {
            let turn = Vec2::from_angle(match name {
                "LeftLeg" | "LeftFoot" => 0.5 * (TAU * f as f32 / 15.0).sin(),
                "RightLeg" | "RightFoot" => -0.5 * (TAU * f as f32 / 15.0).sin(),
                _ => 0.0,
            });
            let hip = if name.starts_with("Left") { vec2(205.0, 160.0) } else { vec2(195.0, 160.0) };
            let place = hip + turn.rotate(Vec2::from(at) - hip);
            biped.set_frame(track, f, TrackFrame::certain(vec![place])).expect("set");
        }
        if let Some(parent) = parent {
            biped.join(parent, track).expect("joined");
        }
    }
    let own = creature();
    let limbs: Vec<_> = rest_limbs(&own, None).expect("limbs").into_iter().filter(|l| l.name != "horn").collect();
    let map = propose_map(&biped, &limbs).expect("a map");
    assert_eq!(map.limbs["back_left"].tracks, ["LeftUpLeg", "LeftLeg", "LeftFoot"]);
    assert_eq!(map.limbs["back_right"].tracks, ["RightUpLeg", "RightLeg", "RightFoot"]);
    let made = map_limbs(&biped, &limbs, own.size, &map, &LimbMapParams::default()).expect("carried");
    let swing = |limb: &str| {
        let x: Vec<f32> = (0..30).map(|f| foot(&made, limb, f).x).collect();
        x.iter().copied().fold(f32::MIN, f32::max) - x.iter().copied().fold(f32::MAX, f32::min)
    };
    assert!(swing("back_left") > 60.0, "{}", swing("back_left"));
    let opposed = (0..30).filter(|&f| {
        let from_middle = |limb: &str| foot(&made, limb, f).x - foot(&made, limb, 0).x;
        from_middle("back_left") * from_middle("back_right") <= 1.0
    });
    assert!(opposed.count() == 30);
}

#[test]
fn maps_that_name_what_is_not_there_are_refused() {
    let (source, own) = (walk(20, 20.0, Vec2::ZERO, 0.0), creature());
    let limbs = rest_limbs(&own, None).expect("limbs");
    let carry = |limb: &str, track: &str, params: &LimbMapParams| {
        let source_of = LimbSource { tracks: vec![track.into()], ..LimbSource::default() };
        let map = LimbMap { limbs: [(limb.to_owned(), source_of)].into() };
        map_limbs(&source, &limbs, own.size, &map, params)
    };
    let params = LimbMapParams::default();
    assert!(message(carry("wing", "tail", &params)).contains("`wing`"));
    assert!(message(carry("tail", "wing", &params)).contains("`wing` is no track"));
    assert!(carry("tail", "tail", &LimbMapParams { reference: Some(20), ..params.clone() }).is_err());
    assert!(carry("tail", "tail", &LimbMapParams { stretch: f64::NAN, ..params.clone() }).is_err());
    assert!(carry("tail", "tail", &LimbMapParams { travel: Some(f64::INFINITY), ..params.clone() }).is_err());
    carry("tail", "tail", &params).expect("one limb is enough");
    assert!(map_limbs(&source, &limbs, own.size, &LimbMap::default(), &params).is_err());
    assert!(map_limbs(&source, &[], own.size, &LimbMap::default(), &params).is_err());
    assert!(rest_limbs(&own, Some(1)).is_err());
    for text in ["", "{}", r#"{"limbs": {}}"#, r#"{"format": "marey-map", "limbs": {"a": {"tracks": ["b"]}}}"#] {
        assert!(LimbMap::from_json(text).is_err(), "{text}");
    }
    let mut circle = limbs.clone();
    circle[0].parent = Some(1);
    assert!(propose_map(&source, &limbs).is_ok());
    assert!(carry("tail", "tail", &params).is_ok());
    let map = propose_map(&source, &limbs).expect("a map");
    assert!(message(map_limbs(&source, &circle, own.size, &map, &params)).contains("circle"));
}
