//! Jobs and contexts over their lives: poll, wait, cancel, take, destroy, in every order.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ffi::c_void;
use std::ptr;
use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use common::*;
use marey_ffi::mry_status_code::*;
use marey_ffi::*;

const FOREVER: u64 = u64::MAX;

fn start(f: &Fixture) -> mry_job {
    let (mut job, mut err) = (mry_job::default(), error());
    let status = unsafe { mry_job_start_track(f.context, &f.track_desc(), &mut job, &mut err) };
    assert_eq!(status, OK, "{}", text(&err.message));
    job
}

fn poll(f: &Fixture, job: mry_job) -> mry_job_state {
    let mut state = unsafe { std::mem::zeroed::<mry_job_state>() };
    unsafe { mry_job_state_init(&mut state, size_of::<mry_job_state>() as u32) };
    assert_eq!(unsafe { mry_job_poll(f.context, job, &mut state, ptr::null_mut()) }, OK);
    state
}

#[test]
fn a_job_runs_is_polled_and_gives_its_result_once() {
    let f = fixture();
    let job = start(&f);
    let (mut last, mut motion) = (poll(&f, job), mry_motion::default());
    assert!(last.revision > 0);
    loop {
        let status = unsafe { mry_job_wait(f.context, job, 1_000_000, ptr::null_mut()) };
        let now = poll(&f, job);
        assert!(now.fraction >= last.fraction && now.revision >= last.revision);
        let of = |s: &mry_job_state| (s.fraction, s.stage_fraction, s.status, s.stage);
        let same = of(&now) == of(&last);
        assert!((0.0..=1.0).contains(&now.stage_fraction));
        assert_eq!(now.revision == last.revision, same, "the revision rises with every change, and only then");
        last = now;
        if status == OK {
            break;
        }
        assert_eq!(status, code(MRY_PENDING));
    }
    let ended = poll(&f, job);
    assert_eq!((ended.status, ended.fraction, ended.stage_fraction), (OK, 1.0, 1.0));
    let mut err = error();
    assert_eq!(unsafe { mry_job_take_motion(f.context, job, &mut motion, &mut err) }, OK);
    let mut again = mry_motion { v: 7 };
    assert_eq!(unsafe { mry_job_take_motion(f.context, job, &mut again, &mut err) }, code(MRY_E_TAKEN));
    assert_eq!(again.v, 7, "an output is written only on success");
    let mut masks = mry_masks::default();
    assert_eq!(unsafe { mry_job_take_masks(f.context, job, &mut masks, &mut err) }, code(MRY_E_KIND));
    assert_eq!(unsafe { mry_job_cancel(f.context, job, &mut err) }, OK);
    assert_eq!(unsafe { mry_job_wait(f.context, job, FOREVER, &mut err) }, OK, "a cancel does not undo what is done");
    assert_eq!(unsafe { mry_job_destroy(f.context, job) }, OK);
    assert_eq!(unsafe { mry_job_destroy(f.context, job) }, code(MRY_E_STALE));
    let (mut count, mut visible) = (0, [9u8; 256]);
    let none = ptr::null_mut();
    let status = unsafe {
        let visible = visible.as_mut_ptr();
        mry_motion_read_frame(f.context, motion, 0, 0, none, visible, ptr::null_mut(), 256, &mut count, &mut err)
    };
    assert_eq!(status, OK, "the motion outlives its job");
    assert!(count >= 2 && visible[..count].iter().all(|v| *v == 1));
}

#[test]
fn inputs_are_copied_when_the_job_starts() {
    let f = fixture();
    let (mut job, desc) = (mry_job::default(), f.track_desc());
    assert_eq!(unsafe { mry_job_start_track(f.context, &desc, &mut job, ptr::null_mut()) }, OK);
    unsafe {
        mry_rig_destroy(f.context, desc.rig);
        mry_clip_close(f.context, desc.clip);
    }
    assert_eq!(unsafe { mry_job_wait(f.context, job, FOREVER, ptr::null_mut()) }, OK);
}

/// A rig on a clip that is long enough to be caught in the middle.
fn long_job(f: &Fixture) -> mry_job {
    let folder = f.folder.path().join("long");
    std::fs::create_dir_all(&folder).unwrap();
    for frame in 0..40u32 {
        let grain = |x: u32, y: u32| ((x * 7919 + y * 104_729 + frame * 13) % 251) as u8;
        let picture = image::RgbImage::from_fn(480, 320, |x, y| image::Rgb([grain(x, y), grain(y, x), 90]));
        picture.save(folder.join(format!("{frame:05}.png"))).unwrap();
    }
    let strokes = STROKES.replace("[96,64]", "[480,320]").replace("[[33,32],[57,32]]", "[[60,60],[400,250]]");
    let (mut clip, mut rig, mut job) = (mry_clip::default(), mry_rig::default(), mry_job::default());
    let path = f.path("long");
    unsafe {
        assert_eq!(mry_clip_open(f.context, str(&path), ptr::null(), &mut clip, ptr::null_mut()), OK);
        assert_eq!(mry_rig_from_json(f.context, str(&strokes), &mut rig, ptr::null_mut()), OK);
        let mut desc = f.creature_desc();
        (desc.clip, desc.rig) = (clip, rig);
        assert_eq!(mry_job_start_creature(f.context, &desc, &mut job, ptr::null_mut()), OK);
    }
    job
}

#[test]
fn a_running_job_is_cancelled_at_once_and_the_next_one_runs() {
    let f = fixture();
    let job = long_job(&f);
    while text(&poll(&f, job).stage) == "waiting" || poll(&f, job).fraction == 0.0 {
        assert_eq!(poll(&f, job).status, code(MRY_PENDING), "it ended before it could be cancelled");
        std::thread::sleep(Duration::from_millis(1));
    }
    let waiting = start(&f);
    assert_eq!(text(&poll(&f, waiting).stage), "waiting");
    let asked = Instant::now();
    assert_eq!(unsafe { mry_job_cancel(f.context, job, ptr::null_mut()) }, OK);
    assert_eq!(unsafe { mry_job_cancel(f.context, job, ptr::null_mut()) }, OK);
    assert_eq!(unsafe { mry_job_wait(f.context, job, FOREVER, ptr::null_mut()) }, code(MRY_CANCELLED));
    // 100 ms is the promise; a shared machine may stop this thread for longer than that.
    assert!(asked.elapsed() < Duration::from_millis(400), "{:?}", asked.elapsed());
    let mut creature = mry_creature { v: 5 };
    let status = unsafe { mry_job_take_creature(f.context, job, &mut creature, ptr::null_mut()) };
    assert_eq!((status, creature.v), (code(MRY_CANCELLED), 5));
    assert_eq!(unsafe { mry_job_wait(f.context, waiting, FOREVER, ptr::null_mut()) }, OK);
}

#[test]
fn a_job_that_waits_for_its_turn_is_cancelled_without_it() {
    let f = fixture();
    let (running, waiting) = (long_job(&f), start(&f));
    assert_eq!(unsafe { mry_job_cancel(f.context, waiting, ptr::null_mut()) }, OK);
    assert_eq!(unsafe { mry_job_wait(f.context, waiting, 0, ptr::null_mut()) }, code(MRY_CANCELLED));
    assert_eq!(unsafe { mry_job_destroy(f.context, running) }, OK, "a running job may be destroyed");
}

#[test]
fn a_context_is_destroyed_over_its_running_jobs() {
    let f = fixture();
    long_job(&f);
    start(&f);
    let began = Instant::now();
    drop(f);
    assert!(began.elapsed() < Duration::from_secs(2), "{:?}", began.elapsed());
}

#[test]
fn two_contexts_do_not_see_each_other() {
    let (a, b) = (fixture(), fixture());
    let (clip, mut err) = (a.clip(), error());
    let mut info = unsafe { std::mem::zeroed::<mry_clip_info>() };
    unsafe { mry_clip_info_init(&mut info, size_of::<mry_clip_info>() as u32) };
    assert_eq!(unsafe { mry_clip_get_info(b.context, clip, &mut info, &mut err) }, code(MRY_E_STALE));
    assert_eq!(text(&err.param), "clip");
    drop(b);
    assert_eq!(unsafe { mry_clip_get_info(a.context, clip, &mut info, &mut err) }, OK);
    assert_eq!((info.width, info.height, info.frame_count), (SIZE.0, SIZE.1, FRAMES));
}

#[test]
fn results_are_the_same_bits_on_one_thread_and_on_many() {
    let motions: Vec<String> = [1, 3]
        .map(|threads| {
            let f = Fixture { context: context(threads), folder: tempfile::tempdir().unwrap() };
            let motion = f.motion();
            let mut size = 0;
            let too_small =
                unsafe { mry_motion_to_json(f.context, motion, ptr::null_mut(), 0, &mut size, ptr::null_mut()) };
            assert_eq!(too_small, code(MRY_E_BUFFER_TOO_SMALL));
            let mut json = vec![0; size];
            let status =
                unsafe { mry_motion_to_json(f.context, motion, json.as_mut_ptr(), size, &mut size, ptr::null_mut()) };
            assert_eq!(status, OK);
            text(&json)
        })
        .into();
    assert_eq!(motions[0], motions[1]);
}

/// Lines of a log, with the call that each callback tried.
struct Log {
    lines: Mutex<Vec<(i32, String)>>,
    context: Mutex<*mut mry_context>,
    refused: std::sync::mpsc::Sender<(mry_status, mry_status)>,
}

unsafe extern "C" fn take_line(level: i32, message: mry_str, user: *mut c_void) {
    let log = unsafe { &*user.cast::<Log>() };
    let bytes = unsafe { std::slice::from_raw_parts(message.data.cast::<u8>(), message.len) };
    log.lines.lock().unwrap().push((level, String::from_utf8_lossy(bytes).into_owned()));
    let context = *log.context.lock().unwrap();
    if level == MRY_LOG_INFO && !context.is_null() {
        let waited = unsafe { mry_job_wait(context, mry_job::default(), FOREVER, ptr::null_mut()) };
        let destroyed = unsafe { mry_context_destroy(context) };
        log.refused.send((waited, destroyed)).ok();
    }
}

#[test]
fn the_log_tells_and_its_callback_cannot_lock_itself_out() {
    let (refused, results) = channel();
    let log = Log { lines: Mutex::default(), context: Mutex::new(ptr::null_mut()), refused };
    let mut desc = context_desc(1);
    desc.log = Some(take_line);
    desc.log_user = ptr::from_ref(&log).cast_mut().cast();
    let mut context = ptr::null_mut();
    assert_eq!(unsafe { mry_context_create(&desc, &mut context, ptr::null_mut()) }, OK);
    *log.context.lock().unwrap() = context;
    let f = Fixture { context, folder: tempfile::tempdir().unwrap() };
    f.motion();
    let both = results.recv_timeout(Duration::from_secs(60)).expect("a job logs its end");
    assert_eq!(both, (code(MRY_E_REENTRANT), code(MRY_E_REENTRANT)));
    *log.context.lock().unwrap() = ptr::null_mut();
    let mut info = 0;
    assert_eq!(
        unsafe { mry_rig_get_limb_count(context, mry_rig { v: 3 }, &mut info, ptr::null_mut()) },
        code(MRY_E_STALE)
    );
    drop(f);
    let lines = log.lines.into_inner().unwrap();
    assert!(lines.iter().any(|(level, line)| *level == MRY_LOG_INFO && line.starts_with("track: done")), "{lines:?}");
    assert!(lines.iter().any(|(level, line)| *level == MRY_LOG_HOST_MISBEHAVING && line.contains("rig")), "{lines:?}");
}
