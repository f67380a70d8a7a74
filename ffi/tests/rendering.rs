//! Pictures through the C ABI: what they show, what files are made, and what a host gets wrong.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ptr;

use common::*;
use marey_ffi::mry_status_code::*;
use marey_ffi::*;

fn made(f: &Fixture) -> mry_creature {
    let (mut creature, mut err) = (mry_creature::default(), error());
    let status = unsafe { mry_run_creature(f.context, &f.creature_desc(), &mut creature, &mut err) };
    assert_eq!(status, OK, "{}", text(&err.message));
    creature
}

fn camera() -> mry_camera {
    let mut camera = unsafe { std::mem::zeroed::<mry_camera>() };
    unsafe { mry_camera_init(&mut camera, size_of::<mry_camera>() as u32) };
    camera
}

fn on_cpu() -> mry_render_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_render_desc>() };
    unsafe { mry_render_desc_init(&mut desc, size_of::<mry_render_desc>() as u32) };
    desc.adapter = MRY_ADAPTER_CPU;
    desc
}

fn file(creature: mry_creature, path: &str, look: &mry_render_desc) -> mry_render_file_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_render_file_desc>() };
    unsafe { mry_render_file_desc_init(&mut desc, size_of::<mry_render_file_desc>() as u32) };
    (desc.creature, desc.path, desc.picture) = (creature, str(path), look);
    desc
}

/// The status, the parameter at fault, and the picture.
fn render(f: &Fixture, creature: mry_creature, look: &mry_render_desc) -> (mry_status, String, Vec<u8>) {
    let (mut count, mut err) = (0, error());
    unsafe {
        let status = mry_creature_render(f.context, creature, look, ptr::null_mut(), 0, &mut count, &mut err);
        if status != code(MRY_E_BUFFER_TOO_SMALL) {
            return (status, text(&err.param), Vec::new());
        }
        let mut pixels = vec![7; count];
        let status =
            mry_creature_render(f.context, creature, look, pixels.as_mut_ptr(), pixels.len(), &mut count, &mut err);
        (status, text(&err.param), pixels)
    }
}

#[test]
fn the_clips_camera_shows_the_creature_where_the_clip_does() {
    let f = fixture();
    let creature = made(&f);
    let mut over = camera();
    over.kind = MRY_CAMERA_CLIP;
    let mut look = on_cpu();
    (look.camera, look.frame) = (&over, 3);
    let (status, _, pixels) = render(&f, creature, &look);
    assert_eq!((status, pixels.len()), (OK, 4 * 96 * 64));
    // The bar: dark and opaque inside, nothing outside.
    let at = |x: usize, y: usize| &pixels[4 * (96 * y + x)..][..4];
    assert!(at(50, 32)[3] == 255 && at(50, 32)[0] < 110, "{:?}", at(50, 32));
    assert_eq!((at(5, 5), at(90, 60)), (&[0; 4][..], &[0; 4][..]));
}

fn crowd(f: &Fixture, instances: &[mry_instance]) -> Result<mry_crowd, (mry_status, String)> {
    let (mut crowd, mut err) = (mry_crowd::default(), error());
    let status =
        unsafe { mry_crowd_create(f.context, instances.as_ptr(), instances.len(), 0, 0.0, &mut crowd, &mut err) };
    if status == OK { Ok(crowd) } else { Err((status, text(&err.param))) }
}

#[test]
fn instances_stand_where_they_are_placed() {
    let f = fixture();
    let creature = made(&f);
    let alone = mry_instance { creature, ..mry_instance::default() };
    let moved = mry_instance { at: [80.0, 0.0, 0.0], start: 2.5, ..alone };
    let mut look = on_cpu();
    (look.width, look.height) = (120, 60);
    look.crowd = crowd(&f, &[alone, moved]).expect("a crowd");
    let covered = |pixels: &[u8], half: usize| {
        pixels.chunks(4).enumerate().filter(|(i, p)| (i % 120) / 60 == half && p[3] > 127).count()
    };
    let (status, _, pixels) = render(&f, creature, &look);
    assert_eq!(status, OK);
    let (left, right) = (covered(&pixels, 0), covered(&pixels, 1));
    assert!(left > 100 && right > 100 && left.abs_diff(right) * 5 < left, "{left} {right}");
    let refused = |instance: mry_instance| crowd(&f, &[alone, instance]).expect_err("no crowd").0;
    assert_eq!(refused(mry_instance { at: [f32::NAN; 3], ..alone }), code(MRY_E_INPUT));
    assert_eq!(refused(mry_instance { scale: -1.0, ..alone }), code(MRY_E_INPUT));
    assert_eq!(refused(mry_instance { play: 7, ..alone }), code(MRY_E_ARGUMENT));
    let dead = mry_instance { creature: mry_creature { v: 99 }, ..alone };
    assert_eq!(crowd(&f, &[dead]).expect_err("no crowd"), (code(MRY_E_STALE), "instances".into()));
    look.crowd.v = 99;
    assert_eq!(render(&f, creature, &look).0, code(MRY_E_STALE));
}

#[test]
fn a_crowd_goes_back_into_its_clip_and_into_one_file() {
    let f = fixture();
    let creature = made(&f);
    let (clip, mut masks, mut err) = (f.clip(), mry_masks::default(), error());
    assert_eq!(unsafe { mry_creature_get_masks(f.context, creature, &mut masks, &mut err) }, OK);
    let behind = mry_instance { creature, at: [0.0, 0.0, -50.0], ..mry_instance::default() };
    let pictures = |name: &str, masks: mry_masks| {
        let mut look = on_cpu();
        look.crowd = crowd(&f, &[behind]).expect("a crowd");
        let path = f.path(name);
        let mut desc = file(creature, &path, &look);
        (desc.clip, desc.masks, desc.alone) = (clip, masks, 1);
        let mut err = error();
        assert_eq!(unsafe { mry_run_render(f.context, &desc, &mut err) }, OK, "{}", text(&err.message));
        let first = std::fs::read_dir(&path).expect("a folder").map(|e| e.expect("an entry").path()).min();
        let picture = image::open(first.expect("a picture")).expect("a picture").into_rgba8();
        picture.pixels().filter(|p| p.0[3] > 127).count()
    };
    let (open, hidden) = (pictures("open", mry_masks::default()), pictures("hidden", masks));
    // Exactly behind itself it peeps out at its border at most.
    assert!(open > 100 && hidden * 4 < open, "{hidden} of {open} show");

    let path = f.path("crowd.glb");
    let two = crowd(&f, &[behind, mry_instance { creature, ..mry_instance::default() }]).expect("a crowd");
    assert_eq!(unsafe { mry_crowd_write_glb(f.context, two, str(&path), 0.0, &mut err) }, OK);
    assert!(std::fs::read(&path).expect("a file").starts_with(b"glTF"));
}

#[test]
fn what_cannot_be_drawn_is_refused_with_the_parameter() {
    let f = fixture();
    let creature = made(&f);
    let refused = |change: &dyn Fn(&mut mry_render_desc, &mut mry_camera)| {
        let (mut look, mut camera) = (on_cpu(), camera());
        change(&mut look, &mut camera);
        look.camera = &camera;
        let (status, param, _) = render(&f, creature, &look);
        (status, param)
    };
    let argument = |param: &str| (code(MRY_E_ARGUMENT), param.to_owned());
    assert_eq!(refused(&|l, _| l.style = 7), argument("desc.style"));
    assert_eq!(refused(&|l, _| l.style = -1), argument("desc.style"));
    assert_eq!(refused(&|l, _| l.adapter = 3), argument("adapter"));
    assert_eq!(refused(&|l, _| l.hard_edges = 2), argument("desc.hard_edges"));
    assert_eq!(refused(&|l, _| l.frame = 6), argument("frame"));
    assert_eq!(refused(&|_, c| c.kind = 3), argument("desc.camera"));
    assert_eq!(refused(&|_, c| c.fov = 175.0), argument("desc.camera"));
    assert_eq!(refused(&|_, c| c.kind = MRY_CAMERA_PLACED), argument("desc.camera"));
    assert_eq!(refused(&|_, c| c.yaw = f32::NAN), (code(MRY_E_NON_FINITE), "desc.camera".into()));
    assert_eq!(refused(&|l, _| l.width = 100).0, code(MRY_E_INPUT), "a height of 0");
    assert_eq!(refused(&|l, _| (l.width, l.height) = (1, u32::MAX)).0, code(MRY_E_INPUT));
    assert_eq!(refused(&|l, _| l.shadow = 1.5).0, code(MRY_E_INPUT));
    assert_eq!(refused(&|l, _| l.struct_size = 8).0, code(MRY_E_STRUCT_SIZE));
}

#[test]
fn files_are_written_whole_and_name_who_drew() {
    let f = fixture();
    let creature = made(&f);
    let mut look = on_cpu();
    (look.width, look.height, look.style) = (48, 32, MRY_STYLE_SHADED);
    let mut err = error();
    for (name, frames, still, turns) in [("one.png", 1, 1, 0.0), ("turn.png", 5, 1, 1.0), ("all.gif", 0, 0, 0.5)] {
        let path = f.path(name);
        let mut desc = file(creature, &path, &look);
        (desc.frame_count, desc.still, desc.turns) = (frames, still, turns);
        let mut job = mry_job::default();
        unsafe {
            let status = mry_job_start_render(f.context, &desc, &mut job, &mut err);
            assert_eq!(status, OK, "{name}: {}", text(&err.message));
            let status = mry_job_wait(f.context, job, u64::MAX, &mut err);
            assert_eq!(status, OK, "{name}: {}", text(&err.message));
            let (mut said, mut size) = ([0; 1024], 0);
            assert_eq!(mry_job_get_report(f.context, job, said.as_mut_ptr(), 1024, &mut size, &mut err), OK);
            assert!(text(&said).contains("\"renderer\":\"CPU\"") && text(&said).contains(name), "{}", text(&said));
            let mut clip = mry_clip::default();
            if frames != 1 {
                assert_eq!(mry_clip_open(f.context, str(&path), ptr::null(), &mut clip, &mut err), OK);
                let mut info = std::mem::zeroed::<mry_clip_info>();
                mry_clip_info_init(&mut info, size_of::<mry_clip_info>() as u32);
                assert_eq!(mry_clip_get_info(f.context, clip, &mut info, &mut err), OK);
                let expected = if frames == 0 { FRAMES } else { frames };
                assert_eq!((info.frame_count, info.width, info.height), (expected, 48, 32), "{name}");
            }
        }
        let image = image::open(&path).unwrap();
        assert_eq!((image.width(), image.height()), (48, 32), "{name}");
    }
    let run = |path: &str, change: &dyn Fn(&mut mry_render_file_desc)| {
        let mut desc = file(creature, path, &look);
        change(&mut desc);
        unsafe { mry_run_render(f.context, &desc, &mut error()) }
    };
    assert_eq!(run(&f.path("missing/turn.gif"), &|_| {}), code(MRY_E_INPUT));
    assert_eq!(run(&f.path("turn.bmp"), &|_| {}), code(MRY_E_INPUT));
    assert_eq!(run(&f.path("x.gif"), &|d| d.still = 2), code(MRY_E_ARGUMENT));
    assert_eq!(run(&f.path("x.gif"), &|d| d.turns = f32::NAN), code(MRY_E_NON_FINITE));
    assert_eq!(run(&f.path("x.gif"), &|d| d.fps = -1.0), code(MRY_E_INPUT));
    assert_eq!(run(&f.path("x.gif"), &|d| d.frame_count = u64::MAX), code(MRY_E_LIMIT));
    assert_eq!(run(&f.path("x.gif"), &|d| d.alone = 2), code(MRY_E_ARGUMENT));
    assert_eq!(run(&f.path("x.gif"), &|d| d.clip.v = 99), code(MRY_E_STALE));
    assert!(!std::path::Path::new(&f.path("x.gif")).exists());
}

#[test]
fn a_gpu_draws_or_its_want_is_named() {
    let f = fixture();
    let creature = made(&f);
    let mut look = on_cpu();
    look.adapter = MRY_ADAPTER_GPU;
    let (status, _, pixels) = render(&f, creature, &look);
    if status == code(MRY_E_GPU) {
        assert!(status_text(status).contains("GPU"));
        return;
    }
    assert_eq!(status, OK);
    look.adapter = MRY_ADAPTER_CPU;
    let (_, _, same) = render(&f, creature, &look);
    let apart: u64 = pixels.iter().zip(&same).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    assert!(apart < 3 * same.len() as u64, "{apart}");
}
