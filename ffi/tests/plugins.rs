//! Plugins through the C ABI, as a C host would use them.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ffi::c_void;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::ptr;
use std::sync::Mutex;

use common::{Fixture, OK, code, error, fixture, str, text};
use marey_ffi::mry_status_code::*;
use marey_ffi::*;

fn build(source: &str, flags: &[&str], to: &Path) {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-O1", "-std=gnu11", "-fvisibility=hidden"]).args(flags);
    cc.arg("-I").arg(root.join("include")).arg(root.join("plugins").join(source)).arg("-o").arg(to);
    assert!(cc.status().unwrap().success());
}

fn open(f: &Fixture, folder: &str) {
    let mut desc = unsafe { std::mem::zeroed::<mry_plugins_desc>() };
    unsafe { mry_plugins_desc_init(&mut desc, size_of::<mry_plugins_desc>() as u32) };
    let cache = f.path("cache");
    (desc.folders, desc.cache, desc.silence_ms) = (str(folder), str(&cache), 500);
    let mut err = error();
    assert_eq!(unsafe { mry_plugins_open(f.context, &desc, &mut err) }, OK, "{}", text(&err.message));
    assert_eq!(unsafe { mry_plugins_open(f.context, &desc, &mut err) }, code(MRY_E_TAKEN));
}

fn rescan(f: &Fixture) -> u32 {
    let (mut changes, mut err) = (0, error());
    assert_eq!(unsafe { mry_plugins_rescan(f.context, &mut changes, &mut err) }, OK, "{}", text(&err.message));
    changes
}

fn track(f: &Fixture, tracker: &str) -> Result<mry_motion, (mry_status, String)> {
    let (mut desc, mut motion, mut err) = (f.track_desc(), mry_motion::default(), error());
    desc.tracker = str(tracker);
    match unsafe { mry_run_track(f.context, &desc, &mut motion, &mut err) } {
        OK => Ok(motion),
        status => Err((status, text(&err.message))),
    }
}

const NEAREST: &str = "org.marey.example-c.nearest";

#[test]
fn a_host_finds_lists_chooses_and_runs_a_plugin() {
    let f = fixture();
    let mut err = error();
    let mut info = unsafe { std::mem::zeroed::<mry_plugin_info>() };
    unsafe { mry_plugin_info_init(&mut info, size_of::<mry_plugin_info>() as u32) };
    unsafe {
        assert_eq!(mry_plugin_get_info(f.context, 0, &mut info, &mut err), code(MRY_E_PLUGIN_NOT_FOUND));
    }
    assert_eq!(track(&f, NEAREST).expect_err("no plugins yet").0, code(MRY_E_UNSUPPORTED));
    let folder = f.path("plugins");
    std::fs::create_dir(&folder).unwrap();
    open(&f, &folder);
    assert_eq!(rescan(&f), 0);
    let (good, bad) = (Path::new(&folder).join("nearest.so"), Path::new(&folder).join("text.so"));
    build("example-c/nearest.c", &[], &good);
    std::fs::write(&bad, "no library").unwrap();
    assert_eq!((rescan(&f), rescan(&f)), (2, 0));
    unsafe {
        assert_eq!(mry_plugin_get_info(f.context, 0, &mut info, &mut err), OK);
        assert_eq!(mry_plugin_get_info(f.context, 1, &mut info, &mut err), code(MRY_E_NOT_FOUND));
    }
    assert_eq!((text(&info.id).as_str(), info.kind, info.enabled), (NEAREST, MRY_PLUGIN_KIND_TRACKER, 1));
    assert_eq!((info.door, info.generation, info.parameter_count), (MRY_PLUGIN_DOOR_C, 1, 1));
    let (mut line, mut size, mut why) = ([0; 512], 0, 0);
    unsafe {
        let status = mry_plugin_get_failure(f.context, 0, &mut why, line.as_mut_ptr(), 512, &mut size, &mut err);
        assert_eq!((status, why), (OK, code(MRY_E_PLUGIN_FORMAT)));
        assert!(text(&line).contains("text.so") && text(&line).contains("no ELF"), "{}", text(&line));
        let none = mry_plugin_get_failure(f.context, 1, &mut why, line.as_mut_ptr(), 512, &mut size, &mut err);
        assert_eq!(none, code(MRY_E_NOT_FOUND));
    }

    let mut parameter = unsafe { std::mem::zeroed::<mry_plugin_parameter_info>() };
    unsafe { mry_plugin_parameter_info_init(&mut parameter, size_of::<mry_plugin_parameter_info>() as u32) };
    let mut value = 0.0;
    unsafe {
        assert_eq!(mry_plugin_get_parameter(f.context, str(NEAREST), 0, &mut parameter, &mut err), OK);
        assert_eq!(mry_plugin_get_number(f.context, str(NEAREST), str("reach"), &mut value, &mut err), OK);
        assert_eq!((text(&parameter.unit).as_str(), parameter.kind, value), ("px", MRY_PARAMETER_WHOLE, 8.0));
        assert_eq!(mry_plugin_set_number(f.context, str(NEAREST), str("reach"), 3.0, &mut err), OK);
        assert_eq!(mry_plugin_get_number(f.context, str(NEAREST), str("reach"), &mut value, &mut err), OK);
        assert_eq!(value, 3.0);
        for wrong in [0.0, 65.0, 1.5, f64::NAN] {
            let status = mry_plugin_set_number(f.context, str(NEAREST), str("reach"), wrong, &mut err);
            assert_eq!(status, code(MRY_E_ARGUMENT), "{wrong}");
        }
        let set = |id, name| mry_plugin_set_number(f.context, str(id), str(name), 3.0, &mut error());
        assert_eq!((set("org.none", "x"), set(NEAREST, "x")), (code(MRY_E_PLUGIN_NOT_FOUND), code(MRY_E_NOT_FOUND)));
        let text_of = mry_plugin_set_text(f.context, str(NEAREST), str("reach"), str("far"), &mut err);
        assert_eq!(text_of, code(MRY_E_ARGUMENT));
    }

    let motion = track(&f, NEAREST).expect("tracked");
    let (mut points, mut count) = ([mry_point { x: 0.0, y: 0.0 }; 64], 0);
    unsafe {
        let (visible, confidence) = (ptr::null_mut(), ptr::null_mut());
        let at = points.as_mut_ptr();
        let status = mry_motion_read_frame(f.context, motion, 0, 5, at, visible, confidence, 64, &mut count, &mut err);
        assert_eq!(status, OK, "{}", text(&err.message));
    }
    assert!((points[0].x - 43.0).abs() < 2.0, "it followed the bar by 10 pixels: {}", points[0].x);

    unsafe {
        assert_eq!(mry_plugin_set_enabled(f.context, str(NEAREST), 0, &mut err), OK);
        assert_eq!(track(&f, NEAREST).expect_err("off").0, code(MRY_E_PLUGIN_DISABLED));
        assert_eq!(mry_plugin_set_enabled(f.context, str(NEAREST), 1, &mut err), OK);
        assert_eq!(mry_plugin_set_enabled(f.context, str(NEAREST), 2, &mut err), code(MRY_E_ARGUMENT));
    }
    track(&f, NEAREST).expect("on again");
    let (status, message) = track(&f, "org.none").expect_err("unknown");
    assert!(status == code(MRY_E_UNSUPPORTED) && message.contains(NEAREST), "{message}");
}

#[test]
fn a_plugin_that_fails_fails_its_job_with_its_own_status() {
    let f = fixture();
    open(&f, "");
    for (i, (flag, expected, says)) in [
        ("FAILS", MRY_E_PLUGIN_FAILED, "the model is not there"),
        ("NOT_A_NUMBER", MRY_E_PLUGIN_OUTPUT, "NaN"),
        ("SLOW", MRY_E_PLUGIN_TIMEOUT, "no sign of life"),
    ]
    .into_iter()
    .enumerate()
    {
        let (file, id) = (f.path(&format!("{flag}.so")), format!("org.marey.bad{i}"));
        build("bad/bad.c", &[&format!("-D{flag}"), &format!("-DID=\"{id}\"")], Path::new(&file));
        let mut err = error();
        assert_eq!(unsafe { mry_plugins_load(f.context, str(&file), &mut err) }, OK, "{}", text(&err.message));
        let (status, message) = track(&f, &id).expect_err(flag);
        assert_eq!(status, code(expected), "{message}");
        assert!(message.contains(says) && message.contains(&id), "{message}");
    }
    let mut err = error();
    let status = unsafe { mry_plugins_load(f.context, str("/nowhere.so"), &mut err) };
    assert_eq!((status, text(&err.param).as_str()), (code(MRY_E_PLUGIN_NOT_FOUND), "file"));
    // The context works on.
    track(&f, "").expect("tracked");
}

#[test]
fn a_new_build_takes_over_with_the_state_of_the_old_one() {
    let f = fixture();
    let folder = f.path("plugins");
    std::fs::create_dir(&folder).unwrap();
    open(&f, &folder);
    let file = Path::new(&folder).join("bad.so");
    build("bad/bad.c", &[], &file);
    let bytes = std::fs::read(&file).unwrap();
    let mark = 0x5952_4d56_u32.to_le_bytes();
    let at = bytes.windows(4).position(|w| w == mark).unwrap() + 4;
    // Each build shifts by its own number, and lifts by a thousand for each call that it knows of.
    for (call, version) in [3u32, 9].into_iter().enumerate() {
        let mut bytes = bytes.clone();
        bytes[at..at + 4].copy_from_slice(&version.to_le_bytes());
        std::fs::write(file.with_extension("tmp"), bytes).unwrap();
        std::fs::rename(file.with_extension("tmp"), &file).unwrap();
        assert_eq!(rescan(&f), 1);
        let motion = track(&f, "org.marey.bad").expect("tracked");
        let mut ends = [[mry_point { x: 0.0, y: 0.0 }; 64]; 2];
        for (frame, points) in ends.iter_mut().enumerate() {
            let (at, none, nothing) = (points.as_mut_ptr(), ptr::null_mut(), ptr::null_mut());
            let (mut count, mut err) = (0, error());
            let frame = frame as u64;
            let status = unsafe {
                mry_motion_read_frame(f.context, motion, 0, frame, at, none, nothing, 64, &mut count, &mut err)
            };
            assert_eq!(status, OK, "{}", text(&err.message));
        }
        let moved = (ends[1][0].x - ends[0][0].x, ends[1][0].y - ends[0][0].y);
        assert_eq!(moved, (version as f32, 1000.0 * call as f32));
    }
}

static LINES: Mutex<Vec<(i32, String)>> = Mutex::new(Vec::new());

unsafe extern "C" fn keep(level: i32, message: mry_str, _user: *mut c_void) {
    let bytes = unsafe { std::slice::from_raw_parts(message.data.cast::<u8>(), message.len) };
    LINES.lock().unwrap().push((level, String::from_utf8_lossy(bytes).into_owned()));
}

#[test]
fn what_plugins_do_is_in_the_hosts_log() {
    let mut desc = common::context_desc(1);
    desc.log = Some(keep);
    let mut context = ptr::null_mut();
    assert_eq!(unsafe { mry_context_create(&desc, &mut context, &mut error()) }, OK);
    let f = Fixture { context, folder: tempfile::tempdir().unwrap() };
    open(&f, "");
    let file = f.path("nearest.so");
    build("example-c/nearest.c", &[], Path::new(&file));
    assert_eq!(unsafe { mry_plugins_load(f.context, str(&file), &mut error()) }, OK);
    let slow = f.path("slow.so");
    build("bad/bad.c", &["-DSLOW"], Path::new(&slow));
    assert_eq!(unsafe { mry_plugins_load(f.context, str(&slow), &mut error()) }, OK);
    assert!(track(&f, "org.marey.bad").is_err());
    let lines = LINES.lock().unwrap().clone();
    let has = |level, part: &str| lines.iter().any(|(l, line)| *l == level && line.contains(part));
    assert!(has(MRY_LOG_INFO, "loaded as build 1"), "{lines:?}");
    assert!(has(MRY_LOG_INFO, "nearest.so: made a tracker"), "a plugin's own line: {lines:?}");
    assert!(has(MRY_LOG_PLUGIN_MISBEHAVING, "strike 1 of 3"), "{lines:?}");
    // The slow plugin's thread outlives the context, whose log it must not reach.
    drop(f);
    let count = LINES.lock().unwrap().len();
    std::thread::sleep(std::time::Duration::from_millis(2500));
    assert_eq!(LINES.lock().unwrap().len(), count);
}

#[test]
fn a_session_is_tracked_by_the_plugin_chosen_in_it_and_knows_when_that_changes() {
    let f = fixture();
    let (session, folder, mut err) = (f.session(), f.path("plugins"), error());
    std::fs::create_dir(&folder).unwrap();
    build("example-c/nearest.c", &[], &Path::new(&folder).join("nearest.so"));
    open(&f, &folder);
    rescan(&f);
    let outdated = || unsafe {
        let mut count = 0;
        let status = mry_session_get_outdated(f.context, session, 0, ptr::null_mut(), 0, &mut count, &mut error());
        assert!(status == OK || status == code(MRY_E_BUFFER_TOO_SMALL));
        count
    };
    let json = || unsafe {
        let (mut motion, mut text_of, mut size, mut err) = (mry_motion::default(), vec![0; 1 << 18], 0, error());
        assert_eq!(mry_session_get_motion(f.context, session, &mut motion, &mut err), OK);
        let at = text_of.as_mut_ptr();
        assert_eq!(mry_motion_to_json(f.context, motion, at, text_of.len(), &mut size, &mut err), OK);
        text(&text_of)
    };
    let choose = |id: &str| unsafe {
        assert_eq!(mry_session_set_text(f.context, session, str("track.plugin"), str(id), &mut error()), OK);
    };
    unsafe {
        assert_eq!(mry_session_run_track(f.context, session, &mut err), OK, "{}", text(&err.message));
        let built_in = json();
        assert_eq!(outdated(), 0);
        choose(NEAREST);
        assert_eq!(outdated(), 1, "another tracker, another motion");
        assert_eq!(mry_session_run_track(f.context, session, &mut err), OK, "{}", text(&err.message));
        assert_ne!(json(), built_in);
        assert_eq!(outdated(), 0);
        assert_eq!(mry_session_undo(f.context, session, &mut err), OK);
        assert_eq!(mry_session_undo(f.context, session, &mut err), OK);
        assert_eq!((outdated(), json() == built_in), (0, true), "both are steps of undo");
        choose("org.example.none");
        assert_eq!(mry_session_run_track(f.context, session, &mut err), code(MRY_E_PLUGIN_NOT_FOUND));
        assert!(text(&err.message).contains("org.example.none"));
    }
}
