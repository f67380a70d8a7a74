//! Sessions through the C ABI: edited, undone, saved, lost and found again, tracked and made creatures of.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ffi::c_char;
use std::ptr;

use common::*;
use marey_ffi::mry_status_code::*;
use marey_ffi::*;

const NO_ERROR: *mut mry_error = ptr::null_mut();

fn state(f: &Fixture, session: mry_session) -> mry_session_state {
    let mut state = unsafe { std::mem::zeroed::<mry_session_state>() };
    unsafe { mry_session_state_init(&mut state, size_of::<mry_session_state>() as u32) };
    assert_eq!(unsafe { mry_session_get_state(f.context, session, &mut state, NO_ERROR) }, OK);
    state
}

/// The text that a two-call function gives, or its status.
fn read(ask: impl Fn(*mut c_char, usize, *mut usize) -> mry_status) -> Result<String, mry_status> {
    let mut size = 0;
    match ask(ptr::null_mut(), 0, &mut size) {
        status if status == code(MRY_E_BUFFER_TOO_SMALL) => {}
        status => return Err(status),
    }
    let mut bytes: Vec<c_char> = vec![1; size];
    assert_eq!(ask(bytes.as_mut_ptr(), size, &mut size), OK);
    Ok(text(&bytes))
}

fn draw(f: &Fixture, session: mry_session, frame: u64, y: f32) {
    let points = [mry_point { x: 33.0, y }, mry_point { x: 57.0, y: 32.0 }];
    let mut err = error();
    let status = unsafe { mry_session_set_stroke(f.context, session, 0, frame, points.as_ptr(), 2, 0, &mut err) };
    assert_eq!(status, OK, "{}", text(&err.message));
}

fn rig_json(f: &Fixture, session: mry_session) -> String {
    let mut rig = mry_rig::default();
    assert_eq!(unsafe { mry_session_get_rig(f.context, session, &mut rig, NO_ERROR) }, OK);
    read(|t, n, size| unsafe { mry_rig_to_json(f.context, rig, t, n, size, NO_ERROR) }).unwrap()
}

fn outdated(f: &Fixture, session: mry_session) -> Vec<(u64, u64)> {
    let (mut ranges, mut count) = ([mry_frame_range::default(); 8], 0);
    let status =
        unsafe { mry_session_get_outdated(f.context, session, 0, ranges.as_mut_ptr(), 8, &mut count, NO_ERROR) };
    assert_eq!(status, OK);
    ranges[..count].iter().map(|r| (r.first, r.count)).collect()
}

#[test]
fn gestures_are_steps_that_undo_and_redo_by_their_labels() {
    let f = fixture();
    let (c, session) = (f.context, f.session());
    let undo_label = || read(|t, n, size| unsafe { mry_session_get_undo_label(c, session, t, n, size, NO_ERROR) });
    let redo_label = || read(|t, n, size| unsafe { mry_session_get_redo_label(c, session, t, n, size, NO_ERROR) });
    let before = rig_json(&f, session);
    let revision = state(&f, session).revision;
    unsafe {
        assert_eq!(mry_session_begin_gesture(c, session, str("draw and smooth"), NO_ERROR), OK);
        for value in 0..50 {
            let value = f64::from(value) / 100.0;
            assert_eq!(mry_session_set_parameter(c, session, str("creature.smoothing"), value, NO_ERROR), OK);
        }
        draw(&f, session, 4, 30.0);
        assert_eq!(state(&f, session).in_gesture, 1);
        assert_eq!(mry_session_undo(c, session, NO_ERROR), code(MRY_E_INPUT), "not in the middle of a gesture");
        assert_eq!(mry_session_end_gesture(c, session, NO_ERROR), OK);
        assert_eq!(undo_label().unwrap(), "draw and smooth");
        assert!(state(&f, session).revision > revision);
        let after = rig_json(&f, session);
        assert_ne!(after, before);

        assert_eq!(mry_session_undo(c, session, NO_ERROR), OK);
        let mut value = 9.0;
        assert_eq!(mry_session_get_parameter(c, session, str("creature.smoothing"), &mut value, NO_ERROR), OK);
        assert_eq!((value, rig_json(&f, session)), (0.04, before));
        assert_eq!(redo_label().unwrap(), "draw and smooth");
        assert_eq!(mry_session_redo(c, session, NO_ERROR), OK);
        assert_eq!(rig_json(&f, session), after);
        assert_eq!(mry_session_redo(c, session, NO_ERROR), code(MRY_E_NOT_FOUND));
        assert_eq!(redo_label().unwrap_err(), code(MRY_E_NOT_FOUND));

        assert_eq!(mry_session_begin_gesture(c, session, str("oops"), NO_ERROR), OK);
        assert_eq!(mry_session_remove_limb(c, session, 0, NO_ERROR), OK);
        assert_eq!(mry_session_cancel_gesture(c, session, NO_ERROR), OK);
        assert_eq!(rig_json(&f, session), after);
        assert_eq!(mry_session_end_gesture(c, session, NO_ERROR), code(MRY_E_INPUT));
        while mry_session_undo(c, session, NO_ERROR) == OK {}
    }
    let state = state(&f, session);
    assert_eq!((state.can_undo, state.has_clip, state.modified), (0, 0, 0), "back to an empty session");
}

#[test]
fn what_was_drawn_is_there_again_whether_it_was_saved_or_not() {
    let f = fixture();
    let (c, path) = (f.context, f.path("walk.marey"));
    let (mut session, mut other, mut err) = (mry_session::default(), mry_session { v: 5 }, error());
    unsafe {
        assert_eq!(mry_session_create(c, str(&path), &mut session, &mut err), OK);
        assert_eq!(mry_session_set_clip(c, session, f.clip(), &mut err), OK);
        assert_eq!(mry_session_set_rig(c, session, f.rig(), &mut err), OK);
        assert_eq!(mry_session_save(c, session, &mut err), OK);
        assert_eq!(state(&f, session).modified, 0);
        draw(&f, session, 4, 30.0);
        let drawn = rig_json(&f, session);

        let status = mry_session_open(c, str(&path), MRY_ACCESS_EDIT, &mut other, &mut err);
        assert_eq!((status, other.v), (code(MRY_E_INPUT), 5));
        assert!(text(&err.message).contains("another program"), "{}", text(&err.message));
        assert_eq!(mry_session_open(c, str(&path), MRY_ACCESS_READ_ONLY, &mut other, &mut err), OK);
        assert_eq!((rig_json(&f, other), state(&f, other).read_only), (drawn.clone(), 1));
        assert_eq!(mry_session_undo(c, other, &mut err), code(MRY_E_INPUT));
        assert_eq!(mry_session_destroy(c, other), OK);

        // Closed without a save: the journal has it.
        assert_eq!(mry_session_destroy(c, session), OK);
        assert_eq!(mry_session_open(c, str(&path), MRY_ACCESS_EDIT, &mut session, &mut err), OK);
        let now = state(&f, session);
        assert_eq!((now.recovered_count, now.modified, now.warning_count, now.can_undo), (1, 1, 0, 1));
        assert_eq!(rig_json(&f, session), drawn);
        let found = read(|t, n, size| mry_session_get_path(c, session, t, n, size, NO_ERROR)).unwrap();
        assert!(found.ends_with("walk.marey"), "{found}");
        let mut clip = mry_clip::default();
        assert_eq!(mry_session_get_clip(c, session, ptr::null(), &mut clip, &mut err), OK, "{}", text(&err.message));

        // Dropped on purpose: it has not.
        assert_eq!(mry_session_discard(c, session, &mut err), OK);
        assert_eq!(mry_session_destroy(c, session), OK);
        std::fs::remove_dir_all(f.folder.path().join("clip")).unwrap();
        assert_eq!(mry_session_open(c, str(&path), MRY_ACCESS_EDIT, &mut session, &mut err), OK);
        assert_ne!(rig_json(&f, session), drawn);
        assert_eq!((state(&f, session).recovered_count, state(&f, session).warning_count), (0, 1));
        let warning = read(|t, n, size| mry_session_get_warning(c, session, 0, t, n, size, NO_ERROR)).unwrap();
        assert!(warning.contains("clip"), "{warning}");
        let status = mry_session_get_warning(c, session, 1, ptr::null_mut(), 0, &mut 0, NO_ERROR);
        assert_eq!(status, code(MRY_E_NOT_FOUND));

        std::fs::write(&path, "{}").unwrap();
        let status = mry_session_open(c, str(&path), MRY_ACCESS_READ_ONLY, &mut other, &mut err);
        assert_eq!(status, code(MRY_E_INPUT));
        assert!(text(&err.message).contains("no session"), "{}", text(&err.message));
        let status = mry_session_open(c, str(&f.path("none")), MRY_ACCESS_EDIT, &mut other, &mut err);
        assert_eq!(status, code(MRY_E_NO_FILE));
        assert_eq!(mry_session_open(c, str(&path), 2, &mut other, &mut err), code(MRY_E_ARGUMENT));
    }
}

#[test]
fn a_session_without_a_name_is_found_after_its_host_is_gone() {
    let f = fixture();
    let (c, folder) = (f.context, f.path(""));
    let left =
        |index| read(|t, n, size| unsafe { mry_session_find_left(c, str(&folder), index, t, n, size, NO_ERROR) });
    let (mut session, mut err) = (mry_session::default(), error());
    unsafe {
        assert_eq!(mry_session_create_untitled(c, str(&folder), &mut session, &mut err), OK);
        let mut limb = 7;
        assert_eq!(mry_session_add_limb(c, session, str("tail"), MRY_SIDE_MID, &mut limb, &mut err), OK);
        assert_eq!((limb, state(&f, session).untitled), (0, 1));
        assert_eq!(left(0).unwrap_err(), code(MRY_E_NOT_FOUND), "it is in use");
        mry_session_destroy(c, session);
        let path = left(0).unwrap();
        assert_eq!(mry_session_open(c, str(&path), MRY_ACCESS_EDIT, &mut session, &mut err), OK);
        assert!(rig_json(&f, session).contains("tail"));
        assert_eq!(mry_session_save_as(c, session, str(&f.path("named.marey")), &mut err), OK);
        assert_eq!((state(&f, session).untitled, state(&f, session).modified), (0, 0));
        assert!(left(0).is_err() && !std::path::Path::new(&path).exists());
    }
}

#[test]
fn a_job_works_on_the_session_as_it_was_and_lands_as_one_step() {
    let f = fixture();
    let (c, session) = (f.context, f.session());
    let (mut job, mut err, mut motion) = (mry_job::default(), error(), mry_motion { v: 3 });
    assert_eq!(outdated(&f, session), [(0, FRAMES)], "nothing is tracked yet");
    unsafe {
        assert_eq!(mry_session_get_motion(c, session, &mut motion, &mut err), code(MRY_E_NOT_FOUND));
        assert_eq!(mry_session_start_track(c, session, &mut job, &mut err), OK, "{}", text(&err.message));
        draw(&f, session, 4, 31.0);
        assert_eq!(mry_job_wait(c, job, u64::MAX, &mut err), OK, "{}", text(&err.message));
        let other = f.session();
        assert_eq!(mry_session_take(c, other, job, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_session_take(c, session, job, &mut err), OK, "{}", text(&err.message));
        assert_eq!(mry_session_take(c, session, job, &mut err), code(MRY_E_TAKEN));
        assert_eq!(mry_job_take_motion(c, job, &mut motion, &mut err), OK, "the host may have it as well");
        assert_eq!(outdated(&f, session), [(1, FRAMES - 1)], "what was drawn meanwhile is not tracked");
        assert_eq!(mry_session_undo(c, session, &mut err), OK);
        assert_eq!((state(&f, session).has_motion, outdated(&f, session)), (0, vec![(0, FRAMES)]));
        assert_eq!(mry_session_redo(c, session, &mut err), OK);

        let mut creature = mry_creature::default();
        let status = mry_session_run_creature(c, session, str(&f.path("out")), &mut creature, &mut err);
        assert_eq!(status, OK, "{}", text(&err.message));
        assert!(f.folder.path().join("out/creature.glb").exists());
        let now = state(&f, session);
        assert_eq!((now.motion_outdated, now.creature_outdated, outdated(&f, session)), (0, 0, vec![]));
        assert_eq!(mry_session_set_parameter(c, session, str("creature.around"), 12.0, &mut err), OK);
        let now = state(&f, session);
        assert_eq!((now.motion_outdated, now.creature_outdated), (0, 1));

        let track = mry_track_desc { rig: f.rig(), ..f.track_desc() };
        assert_eq!(mry_job_start_track(c, &track, &mut job, &mut err), OK);
        assert_eq!(mry_job_wait(c, job, u64::MAX, &mut err), OK);
        assert_eq!(mry_session_take(c, session, job, &mut err), code(MRY_E_KIND), "no session's job");
    }
}

#[test]
fn values_that_make_no_sense_are_refused_and_change_nothing() {
    let f = fixture();
    let (c, session, mut err) = (f.context, f.session(), error());
    let before = (rig_json(&f, session), state(&f, session).revision);
    let points = [mry_point { x: 1.0, y: 1.0 }, mry_point { x: 30.0, y: f32::NAN }];
    let p = points.as_ptr();
    unsafe {
        assert_eq!(mry_session_set_stroke(c, session, 0, 1, p, 2, 0, &mut err), code(MRY_E_NON_FINITE));
        assert_eq!(mry_session_set_stroke(c, session, 0, 1, p, 1, 0, &mut err), code(MRY_E_INPUT), "one point");
        assert_eq!(mry_session_set_stroke(c, session, 0, 1, p, usize::MAX, 0, &mut err), code(MRY_E_LIMIT));
        assert_eq!(mry_session_set_stroke(c, session, 1, 1, p, 1, 0, &mut err), code(MRY_E_ARGUMENT), "one limb");
        assert_eq!(mry_session_set_stroke(c, session, 0, 1, p, 1, 9, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_session_add_paint(c, session, 1, 1, f32::NAN, p, 1, &mut err), code(MRY_E_NON_FINITE));
        assert_eq!(mry_session_add_paint(c, session, 1, 1, 2.0, p, 0, &mut err), code(MRY_E_INPUT));
        assert_eq!(mry_session_remove_paint(c, session, 1, 0, &mut err), code(MRY_E_INPUT));
        assert_eq!(mry_session_remove_limb(c, session, u32::MAX, &mut err), code(MRY_E_ARGUMENT));
        let (mut limb, mut index) = (9, 0);
        assert_eq!(mry_session_add_limb(c, session, str("body"), 0, &mut limb, &mut err), code(MRY_E_INPUT));
        assert_eq!(limb, 9);
        let set = |name: &str, value| mry_session_set_parameter(c, session, str(name), value, NO_ERROR);
        assert_eq!(set("creature.wings", 1.0), code(MRY_E_NOT_FOUND));
        assert_eq!(set("creature.smoothing", f64::NAN), code(MRY_E_NON_FINITE));
        for (name, value) in
            [("creature.smoothing", -1.0), ("creature.around", 20.5), ("export.obj", 2.0), ("track.method", 2.0)]
        {
            assert_eq!(set(name, value), code(MRY_E_ARGUMENT), "{name}");
        }
        assert_eq!((rig_json(&f, session), state(&f, session).revision), before);

        // Whatever the table says a parameter takes, it takes.
        let mut info = std::mem::zeroed::<mry_parameter_info>();
        mry_parameter_info_init(&mut info, size_of::<mry_parameter_info>() as u32);
        while mry_parameter_get_info(c, index, &mut info, NO_ERROR) == OK {
            let name = text(&info.name);
            if info.kind == MRY_PARAMETER_TEXT {
                assert_eq!(set(&name, 0.0), code(MRY_E_ARGUMENT), "{name} takes no number");
                let words = |text: &str| mry_session_set_text(c, session, str(&name), str(text), NO_ERROR);
                let long = "x".repeat(128);
                assert_eq!(
                    (words(&long), words("a\tb"), words("org.none")),
                    (code(MRY_E_ARGUMENT), code(MRY_E_ARGUMENT), OK)
                );
                let kept = read(|t, n, size| mry_session_get_text(c, session, str(&name), t, n, size, NO_ERROR));
                assert_eq!(kept.unwrap(), "org.none");
                let mut job = mry_job::default();
                let started = match name.as_str() {
                    "track.plugin" => mry_session_start_track(c, session, &mut job, NO_ERROR),
                    _ => mry_session_start_creature(c, session, str(""), &mut job, NO_ERROR),
                };
                assert_eq!(started, code(MRY_E_PLUGIN_NOT_FOUND), "{name}");
                assert_eq!(words(""), OK);
                index += 1;
                continue;
            }
            for value in [info.low, info.high, info.default_value] {
                assert_eq!(set(&name, value), OK, "{name} {value}");
                let mut read = f64::NAN;
                assert_eq!(mry_session_get_parameter(c, session, str(&name), &mut read, NO_ERROR), OK);
                assert_eq!(read, value, "{name}");
            }
            for choice in 0..=info.choice_count {
                let name = read(|t, n, size| mry_parameter_get_choice(c, index, choice, t, n, size, NO_ERROR));
                assert_eq!(name.is_ok(), choice < info.choice_count);
            }
            assert!(text(&info.about).ends_with('.'), "{name}: cut off");
            index += 1;
        }
        assert!(index > 20);
    }
}

#[test]
fn every_bound_of_a_parameter_makes_a_creature_or_says_why_not() {
    let f = fixture();
    let (c, session, mut index) = (f.context, f.session(), 0);
    let mut info = unsafe { std::mem::zeroed::<mry_parameter_info>() };
    unsafe { mry_parameter_info_init(&mut info, size_of::<mry_parameter_info>() as u32) };
    while unsafe { mry_parameter_get_info(c, index, &mut info, NO_ERROR) } == OK {
        let name = text(&info.name);
        let bounds: &[f64] = if info.kind == MRY_PARAMETER_TEXT { &[] } else { &[info.low, info.high] };
        for &value in bounds {
            let (mut creature, mut err) = (mry_creature::default(), error());
            unsafe {
                assert_eq!(mry_session_set_parameter(c, session, str(&name), value, &mut err), OK);
                let status = mry_session_run_creature(c, session, str(""), &mut creature, &mut err);
                assert!([OK, code(MRY_E_INPUT)].contains(&status), "{name} {value}: {}", text(&err.message));
                assert_eq!(mry_session_reset_parameter(c, session, str(&name), &mut err), OK);
            }
        }
        index += 1;
    }
}

#[test]
fn what_was_recorded_is_played_to_the_same_fingerprint() {
    let f = fixture();
    let (c, session, path) = (f.context, f.session(), f.path("what.recording"));
    let fingerprint = |session| {
        let mut number = 0;
        assert_eq!(unsafe { mry_session_get_fingerprint(c, session, &mut number, NO_ERROR) }, OK);
        number
    };
    unsafe {
        assert_eq!(mry_session_stop_recording(c, session, NO_ERROR), code(MRY_E_NOT_FOUND));
        assert_eq!(mry_session_start_recording(c, session, str(&path), NO_ERROR), OK);
        assert_eq!(state(&f, session).recording, 1);
        draw(&f, session, 4, 30.0);
        draw(&f, session, 5, 31.0);
        assert_eq!(mry_session_undo(c, session, NO_ERROR), OK);
        assert_eq!(mry_session_stop_recording(c, session, NO_ERROR), OK);
        assert_eq!(mry_session_start_recording(c, session, str(&path), NO_ERROR), code(MRY_E_IO), "it exists");
        let mut played = mry_session::default();
        assert_eq!(mry_session_replay(c, str(&path), u64::MAX, &mut played, NO_ERROR), OK);
        assert_eq!((state(&f, played).recovered_count, fingerprint(played)), (3, fingerprint(session)));
        assert_eq!(mry_session_replay(c, str(&path), 2, &mut played, NO_ERROR), OK);
        assert_ne!(fingerprint(played), fingerprint(session));
        assert_eq!(mry_session_replay(c, str(&f.path("none")), 1, &mut played, NO_ERROR), code(MRY_E_NO_FILE));
        std::fs::write(&path, b"nonsense").unwrap();
        assert_eq!(mry_session_replay(c, str(&path), 1, &mut played, NO_ERROR), code(MRY_E_INPUT));
    }
}

#[test]
fn a_session_that_carries_its_clip_is_tracked_where_it_was_taken() {
    let (f, there) = (fixture(), fixture());
    let (c, path, moved) = (f.context, f.path("walk.marey"), there.path("moved.marey"));
    let (mut session, mut err) = (mry_session::default(), error());
    unsafe {
        assert_eq!(mry_session_create(c, str(&path), &mut session, &mut err), OK);
        assert_eq!(mry_session_set_clip(c, session, f.clip(), &mut err), OK);
        assert_eq!(mry_session_set_rig(c, session, f.rig(), &mut err), OK);
        assert_eq!(mry_session_set_embedded(c, session, 2, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_session_set_embedded(c, session, 1, &mut err), OK);
        assert_eq!(mry_session_save(c, session, &mut err), OK, "{}", text(&err.message));
        assert_eq!(mry_session_destroy(c, session), OK);
        std::fs::rename(&path, &moved).unwrap();
        std::fs::remove_dir_all(f.path("clip")).unwrap();

        let c = there.context;
        assert_eq!(mry_session_open(c, str(&moved), MRY_ACCESS_EDIT, &mut session, &mut err), OK);
        let now = state(&there, session);
        assert_eq!((now.embedded, now.warning_count), (1, 0));
        // The job reads on when the session and its folder are gone.
        let (mut job, mut motion) = (mry_job::default(), mry_motion::default());
        assert_eq!(mry_session_start_track(c, session, &mut job, &mut err), OK, "{}", text(&err.message));
        assert_eq!(mry_session_destroy(c, session), OK);
        assert_eq!(mry_job_wait(c, job, u64::MAX, &mut err), OK, "{}", text(&err.message));
        assert_eq!(mry_job_take_motion(c, job, &mut motion, &mut err), OK);
        assert_eq!(mry_job_destroy(c, job), OK);
    }
    let left = std::fs::read_dir(there.folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect::<Vec<_>>();
    assert_eq!(left, ["moved.marey"], "nothing is left lying about");
}
