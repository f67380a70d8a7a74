//! Motions made and corrected by hand, and tracked again in part.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ptr;

use common::*;
use marey_ffi::mry_status_code::*;
use marey_ffi::*;

const NO_ERROR: *mut mry_error = ptr::null_mut();

fn frame(f: &Fixture, motion: mry_motion, track: u32, frame: u64) -> (Vec<mry_point>, Vec<u8>, Vec<f32>) {
    let mut count = 0;
    let (mut points, mut visible, mut confidence) = (vec![mry_point::default(); 64], vec![0; 64], vec![0.0; 64]);
    let lists = (points.as_mut_ptr(), visible.as_mut_ptr(), confidence.as_mut_ptr());
    let read = unsafe {
        mry_motion_read_frame(f.context, motion, track, frame, lists.0, lists.1, lists.2, 64, &mut count, NO_ERROR)
    };
    assert_eq!(read, OK);
    points.truncate(count);
    visible.truncate(count);
    confidence.truncate(count);
    (points, visible, confidence)
}

#[test]
fn a_motion_is_made_by_hand() {
    let f = fixture();
    let (c, mut motion, mut err) = (f.context, mry_motion::default(), error());
    let (mut body, mut nose) = (9, 9);
    let place = [mry_point { x: 4.0, y: 5.5 }];
    unsafe {
        assert_eq!(mry_motion_create(c, 64, 48, 3, 24.0, &mut motion, &mut err), OK);
        assert_eq!(mry_motion_add_track(c, motion, str("body"), MRY_TRACK_STROKE, 2, &mut body, &mut err), OK);
        assert_eq!(mry_motion_add_track(c, motion, str("nose"), MRY_TRACK_POINT, 1, &mut nose, &mut err), OK);
        assert_eq!((body, nose), (0, 1));
        let set = |p: &[mry_point], v: *const u8, s: *const f32, count| {
            mry_motion_set_frame(c, motion, nose, 2, p.as_ptr(), v, s, count, NO_ERROR)
        };
        assert_eq!(set(&place, &0, &0.25, 1), OK);
        assert_eq!(frame(&f, motion, nose, 2), (place.to_vec(), vec![0], vec![0.25]));
        assert_eq!(set(&place, ptr::null(), ptr::null(), 1), OK);
        assert_eq!(frame(&f, motion, nose, 2), (place.to_vec(), vec![1], vec![1.0]));
        assert_eq!(mry_motion_add_bone(c, motion, body, nose, &mut err), OK);
        assert_eq!(mry_motion_add_bone(c, motion, nose, body, &mut err), code(MRY_E_INPUT), "a circle");

        let nan = [mry_point { x: f32::NAN, y: 0.0 }];
        assert_eq!(set(&nan, ptr::null(), ptr::null(), 1), code(MRY_E_NON_FINITE));
        assert_eq!(set(&place, ptr::null(), &f32::INFINITY, 1), code(MRY_E_INPUT));
        assert_eq!(set(&place, ptr::null(), ptr::null(), usize::MAX), code(MRY_E_LIMIT));
        assert_eq!(set(&[place[0]; 2], ptr::null(), ptr::null(), 2), code(MRY_E_INPUT), "the track has one point");
        assert_eq!(mry_motion_create(c, 64, 48, u64::MAX, 24.0, &mut motion, &mut err), code(MRY_E_LIMIT));
        assert_eq!(mry_motion_create(c, 64, 48, 3, f64::NAN, &mut motion, &mut err), code(MRY_E_INPUT));
        let add =
            |name: &str, kind, points| mry_motion_add_track(c, motion, str(name), kind, points, &mut { 0 }, NO_ERROR);
        assert_eq!(add("nose", MRY_TRACK_JOINT, 1), code(MRY_E_INPUT));
        assert_eq!(add("", MRY_TRACK_JOINT, 1), code(MRY_E_ARGUMENT));
        assert_eq!(add("tail", 7, 1), code(MRY_E_ARGUMENT));
        assert_eq!(add("tail", MRY_TRACK_JOINT, 0), code(MRY_E_ARGUMENT));
        assert_eq!(add("tail", MRY_TRACK_JOINT, usize::MAX), code(MRY_E_LIMIT));
        assert_eq!(mry_motion_remove_bone(c, motion, 1, &mut err), code(MRY_E_INPUT));
        assert_eq!(mry_motion_remove_track(c, motion, 2, &mut err), code(MRY_E_ARGUMENT));

        let path = f.path("hand.json");
        assert_eq!(mry_motion_write(c, motion, str(&path), &mut err), OK);
        let mut read = mry_motion::default();
        assert_eq!(mry_motion_read(c, str(&path), &mut read, &mut err), OK);
        assert_eq!(frame(&f, read, nose, 2), frame(&f, motion, nose, 2));
        assert_eq!(mry_motion_remove_track(c, read, body, &mut err), OK);
        let mut info = std::mem::zeroed::<mry_motion_info>();
        mry_motion_info_init(&mut info, size_of::<mry_motion_info>() as u32);
        assert_eq!(mry_motion_get_info(c, read, &mut info, &mut err), OK);
        assert_eq!((info.track_count, info.bone_count), (1, 0));
    }
}

#[test]
fn a_correction_of_a_copy_touches_nobody_elses_motion() {
    let f = fixture();
    let (c, mut creature, mut err) = (f.context, mry_creature::default(), error());
    let (mut theirs, mut copy) = (mry_motion::default(), mry_motion::default());
    unsafe {
        assert_eq!(mry_run_creature(c, &f.creature_desc(), &mut creature, &mut err), OK);
        assert_eq!(mry_creature_get_motion(c, creature, &mut theirs, &mut err), OK);
        assert_eq!(mry_motion_copy(c, theirs, &mut copy, &mut err), OK);
        let before = frame(&f, theirs, 0, 3);
        let moved: Vec<mry_point> = before.0.iter().map(|p| mry_point { x: p.x + 9.0, ..*p }).collect();
        let set = |motion| {
            mry_motion_set_frame(c, motion, 0, 3, moved.as_ptr(), ptr::null(), ptr::null(), moved.len(), NO_ERROR)
        };
        assert_eq!(set(copy), OK);
        assert_eq!((frame(&f, theirs, 0, 3), frame(&f, copy, 0, 3).0), (before.clone(), moved.clone()));
        // A motion that was given out is a copy of its own, too.
        let mut again = mry_motion::default();
        assert_eq!(set(theirs), OK);
        assert_eq!(mry_creature_get_motion(c, creature, &mut again, &mut err), OK);
        assert_eq!(frame(&f, again, 0, 3), before);
    }
}

#[test]
fn a_corrected_stroke_is_tracked_again_between_its_neighbours() {
    let f = fixture();
    let (c, mut err) = (f.context, error());
    let draw = |rig, frame: u64, x: f32| {
        let points = [mry_point { x, y: 32.0 }, mry_point { x: x + 24.0, y: 32.0 }];
        let status = unsafe { mry_rig_set_stroke(c, rig, 0, frame, points.as_ptr(), 2, 0, NO_ERROR) };
        assert_eq!(status, OK);
    };
    let (old, new) = (f.rig(), f.rig());
    for (frame, x) in [(2, 37.0), (4, 41.0)] {
        draw(old, frame, x);
        draw(new, frame, x);
    }
    draw(new, 4, 44.0);
    let track = |rig, earlier, earlier_rig| {
        let mut desc = zeroed_track();
        (desc.clip, desc.rig, desc.earlier, desc.earlier_rig) = (f.clip(), rig, earlier, earlier_rig);
        let (mut motion, mut err) = (mry_motion::default(), error());
        let status = unsafe { mry_run_track(c, &desc, &mut motion, &mut err) };
        (status, motion)
    };
    let (status, before) = track(old, mry_motion::default(), mry_rig::default());
    assert_eq!(status, OK);
    let (status, after) = track(new, before, old);
    assert_eq!(status, OK);
    let changed: Vec<u64> = (0..FRAMES).filter(|&n| frame(&f, before, 0, n) != frame(&f, after, 0, n)).collect();
    assert!(changed.contains(&4) && changed.iter().all(|n| *n > 2), "{changed:?}");
    assert_eq!(frame(&f, after, 0, 4).0[0].x, 44.0);
    assert_eq!(track(new, before, mry_rig::default()).0, code(MRY_E_STALE), "one without the other");

    // A session does so by itself.
    unsafe {
        let session = f.session();
        assert_eq!(mry_session_set_rig(c, session, old, &mut err), OK);
        assert_eq!(mry_session_run_track(c, session, &mut err), OK, "{}", text(&err.message));
        let points = [mry_point { x: 44.0, y: 32.0 }, mry_point { x: 68.0, y: 32.0 }];
        assert_eq!(mry_session_set_stroke(c, session, 0, 4, points.as_ptr(), 2, 0, &mut err), OK);
        assert_eq!(mry_session_run_track(c, session, &mut err), OK, "{}", text(&err.message));
        let mut motion = mry_motion::default();
        assert_eq!(mry_session_get_motion(c, session, &mut motion, &mut err), OK);
        for n in 0..FRAMES {
            assert_eq!(frame(&f, motion, 0, n), frame(&f, after, 0, n), "frame {n}");
        }
    }
}

#[test]
fn joints_are_marked_by_hand_captured_and_corrected() {
    let f = fixture();
    let (c, mut joints, mut earlier, mut err) = (f.context, mry_joints::default(), mry_joints::default(), error());
    let (mut motion, mut again, mut size) = (mry_motion::default(), mry_motion::default(), 0);
    unsafe {
        assert_eq!(mry_joints_create(c, SIZE.0, SIZE.1, &mut joints, &mut err), OK);
        let clip = f.clip();
        assert_eq!(mry_joints_validate(c, joints, clip, &mut err), code(MRY_E_INPUT), "nothing is marked");
        let mark = |name: &str, frame, x: f32, y: f32, side: f32| {
            mry_joints_mark(c, joints, str(name), frame, x, y, side, side, NO_ERROR)
        };
        assert_eq!((mark("left", 0, 31.0, 28.0, 8.0), mark("right", 0, 51.0, 28.0, 8.0)), (OK, OK));
        assert_eq!(mark("left", 0, f32::NAN, 28.0, 8.0), code(MRY_E_NON_FINITE));
        assert_eq!(mark("left", 0, 500.0, 28.0, 8.0), code(MRY_E_INPUT), "outside");
        assert_eq!(mark("left", 0, 31.0, 28.0, 0.0), code(MRY_E_INPUT), "no rectangle");
        assert_eq!(mark("", 0, 31.0, 28.0, 8.0), code(MRY_E_INPUT));
        assert_eq!(mry_joints_unmark(c, joints, str("left"), 3, &mut err), code(MRY_E_NOT_FOUND));
        assert_eq!(mry_joints_add_bone(c, joints, str("left"), str("right"), &mut err), OK);
        assert_eq!(mry_joints_add_bone(c, joints, str("right"), str("left"), &mut err), code(MRY_E_INPUT), "a circle");
        assert_eq!(mry_joints_add_bone(c, joints, str("left"), str("nose"), &mut err), code(MRY_E_INPUT));
        assert_eq!(mry_joints_unmark(c, joints, str("right"), 0, &mut err), code(MRY_E_INPUT), "its bone needs it");
        assert_eq!(mry_joints_validate(c, joints, clip, &mut err), OK, "{}", text(&err.message));
        let path = f.path("joints.json");
        assert_eq!(mry_joints_write(c, joints, str(&path), &mut err), OK);
        assert_eq!(mry_joints_read(c, str(&path), &mut earlier, &mut err), OK);

        let mut desc = std::mem::zeroed::<mry_capture_desc>();
        mry_capture_desc_init(&mut desc, size_of::<mry_capture_desc>() as u32);
        (desc.clip, desc.joints) = (clip, joints);
        assert_eq!(mry_run_capture(c, &desc, &mut motion, &mut err), OK, "{}", text(&err.message));
        let at = |motion, joint, number| frame(&f, motion, joint, number).0[0];
        assert!((at(motion, 0, 5).x - 45.0).abs() < 3.0 && (at(motion, 1, 5).x - 65.0).abs() < 3.0, "10 to the right");

        assert_eq!(mark("right", 4, 60.0, 30.0, 8.0), OK);
        (desc.earlier, desc.earlier_joints) = (motion, earlier);
        assert_eq!(mry_run_capture(c, &desc, &mut again, &mut err), OK, "{}", text(&err.message));
        assert_eq!(at(again, 1, 4), mry_point { x: 64.0, y: 34.0 });
        assert_eq!(frame(&f, again, 0, 0), frame(&f, motion, 0, 0));
        let asked = mry_motion_get_capture_report(c, again, clip, joints, ptr::null_mut(), 0, &mut size, &mut err);
        assert!(asked == code(MRY_E_BUFFER_TOO_SMALL) && size > 100, "{asked}");
    }
}

/// A leg that swings once in `period` frames, on a body that goes to the right.
fn walking(f: &Fixture, frames: u64, period: f32) -> mry_motion {
    let (mut motion, mut body, mut leg) = (mry_motion::default(), 0, 0);
    unsafe {
        assert_eq!(mry_motion_create(f.context, 200, 200, frames, 24.0, &mut motion, NO_ERROR), OK);
        assert_eq!(mry_motion_add_track(f.context, motion, str("body"), MRY_TRACK_STROKE, 2, &mut body, NO_ERROR), OK);
        assert_eq!(mry_motion_add_track(f.context, motion, str("leg"), MRY_TRACK_STROKE, 3, &mut leg, NO_ERROR), OK);
        assert_eq!(mry_motion_add_bone(f.context, motion, body, leg, NO_ERROR), OK);
        for frame in 0..frames {
            let x = 50.0 + frame as f32;
            let swing = 0.5 * (std::f32::consts::TAU * frame as f32 / period).sin();
            let at = |l: f32| mry_point { x: x + l * swing.sin(), y: 50.0 + l * swing.cos() };
            let points = [at(0.0), at(40.0), at(80.0)];
            let line = [at(0.0), mry_point { x: x + 60.0, y: 50.0 }];
            let set = |track, p: &[mry_point]| {
                mry_motion_set_frame(
                    f.context,
                    motion,
                    track,
                    frame,
                    p.as_ptr(),
                    ptr::null(),
                    ptr::null(),
                    p.len(),
                    NO_ERROR,
                )
            };
            assert_eq!((set(body, &line), set(leg, &points)), (OK, OK));
        }
    }
    motion
}

#[test]
fn a_motion_is_closed_smoothed_planted_retimed_and_mapped() {
    let f = fixture();
    let (c, motion, mut err) = (f.context, walking(&f, 50, 20.0), error());
    unsafe {
        let mut cycle = mry_cycle {
            struct_size: size_of::<mry_cycle>() as u32,
            reserved0: 0,
            period: 0.0,
            start: 0.0,
            confidence: 0.0,
        };
        assert_eq!(mry_motion_find_cycle(c, motion, &mut cycle, &mut err), OK);
        assert!((cycle.period - 20.0).abs() < 0.1 && cycle.confidence > 0.8, "{}", cycle.period);
        let (mut phases, mut count) = ([0.0; 2], 0);
        let read = |phases: &mut [f64], count: &mut usize| {
            mry_motion_read_phases(c, motion, phases.as_mut_ptr(), ptr::null_mut(), phases.len(), count, NO_ERROR)
        };
        assert_eq!(read(&mut phases[..1], &mut count), code(MRY_E_BUFFER_TOO_SMALL));
        assert_eq!((read(&mut phases, &mut count), count), (OK, 2));

        let mut made = mry_motion::default();
        assert_eq!(mry_motion_loop(c, motion, ptr::null(), &mut made, ptr::null_mut(), &mut err), OK);
        let mut info = std::mem::zeroed::<mry_motion_info>();
        mry_motion_info_init(&mut info, size_of::<mry_motion_info>() as u32);
        assert_eq!(mry_motion_get_info(c, made, &mut info, &mut err), OK);
        assert_eq!(info.frame_count, 20);
        let mut closing = std::mem::zeroed::<mry_loop_desc>();
        mry_loop_desc_init(&mut closing, size_of::<mry_loop_desc>() as u32);
        (closing.start, closing.period) = (40.0, 20.0);
        assert_eq!(mry_motion_loop(c, motion, &closing, &mut made, ptr::null_mut(), &mut err), code(MRY_E_INPUT));
        closing.period = f64::NAN;
        assert_eq!(mry_motion_loop(c, motion, &closing, &mut made, ptr::null_mut(), &mut err), code(MRY_E_NON_FINITE));

        // Every frame of a motion made by hand is certain: nothing moves, until frames are named.
        let mut smoothing = std::mem::zeroed::<mry_smooth_desc>();
        mry_smooth_desc_init(&mut smoothing, size_of::<mry_smooth_desc>() as u32);
        assert_eq!(mry_motion_smooth(c, motion, &smoothing, &mut made, &mut err), OK);
        assert_eq!(frame(&f, made, 1, 7), frame(&f, motion, 1, 7));
        (smoothing.only_frames, smoothing.period) = (1, 20.0);
        (smoothing.frames, smoothing.frame_count) = ([7u64].as_ptr(), 1);
        assert_eq!(mry_motion_smooth(c, motion, &smoothing, &mut made, &mut err), OK);
        assert_eq!(frame(&f, made, 1, 7), frame(&f, motion, 1, 7));
        assert_ne!(frame(&f, made, 1, 8), frame(&f, motion, 1, 8));

        assert_eq!(mry_motion_plant(c, motion, ptr::null(), &mut made, &mut err), OK);
        let (mut words, mut size) = ([0; 400], 0);
        assert_eq!(
            mry_motion_get_contacts(c, motion, ptr::null(), words.as_mut_ptr(), words.len(), &mut size, &mut err),
            OK
        );
        assert!(text(&words).contains(r#""track":"leg""#), "{}", text(&words));

        let mut retiming = std::mem::zeroed::<mry_retime_desc>();
        mry_retime_desc_init(&mut retiming, size_of::<mry_retime_desc>() as u32);
        retiming.direction = MRY_DIRECTION_BACKWARD;
        assert_eq!(mry_motion_retime(c, motion, &retiming, &mut made, &mut err), OK);
        assert_eq!(frame(&f, made, 1, 0), frame(&f, motion, 1, 49));
        retiming.easing = 9;
        assert_eq!(mry_motion_retime(c, motion, &retiming, &mut made, &mut err), code(MRY_E_ARGUMENT));

        let other = walking(&f, 1, 20.0);
        assert_eq!(mry_motion_map_limbs(c, motion, other, ptr::null(), &mut made, &mut err), OK);
        assert_eq!(mry_motion_get_info(c, made, &mut info, &mut err), OK);
        assert_eq!((info.frame_count, info.track_count), (50, 2));
        assert_eq!(
            mry_motion_match_limbs(c, motion, other, ptr::null(), words.as_mut_ptr(), words.len(), &mut size, &mut err),
            OK
        );
        assert!(text(&words).contains("marey-limb-map"), "{}", text(&words));
    }
}
