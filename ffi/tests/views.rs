//! Memory that is shown without a copy, and what a host may set about a context: its limits and its threads.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ffi::c_void;
use std::ptr;
use std::sync::Mutex;
use std::thread::JoinHandle;

use common::*;
use marey_ffi::mry_status_code::*;
use marey_ffi::*;

fn image_view() -> mry_image_view {
    let mut view = unsafe { std::mem::zeroed::<mry_image_view>() };
    unsafe { mry_image_view_init(&mut view, size_of::<mry_image_view>() as u32) };
    view
}

fn mesh_view() -> mry_mesh_view {
    let mut view = unsafe { std::mem::zeroed::<mry_mesh_view>() };
    unsafe { mry_mesh_view_init(&mut view, size_of::<mry_mesh_view>() as u32) };
    view
}

fn bytes(view: &mry_image_view) -> &[u8] {
    assert_eq!((view.format, view.stride_bytes), (MRY_FORMAT_RGB8, 3 * u64::from(view.width)));
    unsafe { std::slice::from_raw_parts(view.data, view.stride_bytes as usize * view.height as usize) }
}

#[test]
fn a_mapped_frame_is_the_frame_itself_and_outlives_its_clip() {
    let f = fixture();
    let (c, clip) = (f.context, f.clip());
    let mut read = vec![0; 3 * (SIZE.0 * SIZE.1) as usize];
    let (mut one, mut two) = (image_view(), image_view());
    unsafe {
        assert_eq!(mry_clip_read_frame(c, clip, 2, read.as_mut_ptr(), read.len(), 0, ptr::null_mut()), OK);
        assert_eq!(mry_clip_map_frame(c, clip, 2, &mut one, ptr::null_mut()), OK);
        assert_eq!(mry_clip_map_frame(c, clip, 2, &mut two, ptr::null_mut()), OK);
        assert_eq!(one.data, two.data, "two maps of a frame show the same memory: nothing was copied");
        assert_eq!(mry_clip_close(c, clip), OK);
        assert_eq!(mry_unmap(c, two.map), OK);
        assert_eq!((one.width, one.height), SIZE);
        assert_eq!(bytes(&one), read);
        assert_eq!((mry_unmap(c, one.map), mry_unmap(c, one.map)), (OK, code(MRY_E_STALE)));
        assert_eq!(mry_unmap(c, mry_map::default()), OK);
    }
}

#[test]
fn a_mapped_surface_is_what_is_read_in_every_pose() {
    let f = fixture();
    let (c, mut creature, mut err) = (f.context, mry_creature::default(), error());
    unsafe {
        assert_eq!(mry_run_creature(c, &f.creature_desc(), &mut creature, &mut err), OK, "{}", text(&err.message));
        for frame in [0, FRAMES - 1, MRY_REST_POSE] {
            let (mut one, mut two) = (mesh_view(), mesh_view());
            assert_eq!(mry_creature_map_part(c, creature, 0, frame, &mut one, &mut err), OK);
            assert_eq!(mry_creature_map_part(c, creature, 0, frame, &mut two, &mut err), OK);
            assert_eq!((one.positions, one.triangles), (two.positions, two.triangles), "nothing was copied");
            let n = one.vertex_count as usize;
            let (mut positions, mut normals, mut uvs) = (vec![0.0f32; 3 * n], vec![0.0f32; 3 * n], vec![0.0f32; 2 * n]);
            let lists = (positions.as_mut_ptr(), normals.as_mut_ptr(), uvs.as_mut_ptr());
            let mut count = 0;
            let status =
                mry_creature_read_vertices(c, creature, 0, frame, lists.0, lists.1, lists.2, n, &mut count, &mut err);
            assert_eq!((status, count), (OK, n));
            assert_eq!(std::slice::from_raw_parts(one.positions, 3 * n), positions);
            assert_eq!(std::slice::from_raw_parts(one.normals, 3 * n), normals);
            assert_eq!(std::slice::from_raw_parts(one.uvs, 2 * n), uvs);
            let indices = std::slice::from_raw_parts(one.triangles, 3 * one.triangle_count as usize);
            assert!(!indices.is_empty() && indices.iter().all(|i| (*i as usize) < n));
            mry_unmap(c, one.map);
            mry_unmap(c, two.map);
        }
        let mut view = image_view();
        assert_eq!(mry_creature_map_texture(c, creature, 0, &mut view, &mut err), OK);
        let mut read = vec![0; bytes(&view).len()];
        assert_eq!(mry_creature_read_texture(c, creature, 0, read.as_mut_ptr(), read.len(), 0, &mut err), OK);
        mry_creature_destroy(c, creature);
        assert_eq!(bytes(&view), read, "the map outlives the creature");
        assert_eq!(mry_creature_map_part(c, creature, 0, 0, &mut mesh_view(), &mut err), code(MRY_E_STALE));
    }
}

#[test]
fn a_creature_has_the_surface_that_is_asked_for() {
    let f = fixture();
    let (c, mut creature, mut err) = (f.context, mry_creature::default(), error());
    let mut info = unsafe { std::mem::zeroed::<mry_creature_info>() };
    unsafe {
        mry_creature_info_init(&mut info, size_of::<mry_creature_info>() as u32);
        for (surface, one) in [(0, true), (MRY_SURFACE_SKIN, true), (MRY_SURFACE_TUBES, false)] {
            let desc = mry_creature_desc { surface, ..f.creature_desc() };
            assert_eq!(mry_run_creature(c, &desc, &mut creature, &mut err), OK, "{}", text(&err.message));
            assert_eq!(mry_creature_get_info(c, creature, &mut info, &mut err), OK);
            assert_eq!(info.part_count, if one { 1 } else { info.limb_count });
            mry_creature_destroy(c, creature);
        }
        let desc = mry_creature_desc { surface: 3, ..f.creature_desc() };
        assert_eq!(mry_run_creature(c, &desc, &mut creature, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(text(&err.param), "desc.surface");
    }
}

fn limited(change: impl FnOnce(&mut mry_limits)) -> Fixture {
    let mut limits = unsafe { std::mem::zeroed::<mry_limits>() };
    unsafe { mry_limits_init(&mut limits, size_of::<mry_limits>() as u32) };
    change(&mut limits);
    let desc = mry_context_desc { limits: &limits, ..context_desc(1) };
    let mut context = ptr::null_mut();
    assert_eq!(unsafe { mry_context_create(&desc, &mut context, ptr::null_mut()) }, OK);
    Fixture { context, folder: tempfile::tempdir().unwrap() }
}

#[test]
fn what_exceeds_a_limit_of_the_context_is_refused() {
    let open = |f: &Fixture| {
        let (path, mut clip) = (f.path("clip"), mry_clip::default());
        std::fs::create_dir(&path).unwrap();
        write_clip(path.as_ref());
        let status = unsafe { mry_clip_open(f.context, str(&path), ptr::null(), &mut clip, ptr::null_mut()) };
        assert_eq!(status == OK, clip.v != 0);
        status
    };
    assert_eq!(open(&limited(|l| l.frames = FRAMES)), OK);
    assert_eq!(open(&limited(|l| l.frames = FRAMES - 1)), code(MRY_E_LIMIT));
    let pixels = u64::from(SIZE.0 * SIZE.1);
    assert_eq!(open(&limited(|l| l.frame_pixels = pixels)), OK);
    assert_eq!(open(&limited(|l| l.frame_pixels = pixels - 1)), code(MRY_E_LIMIT));

    let f = limited(|l| (l.objects, l.points, l.key_frames) = (2, 3, 1));
    let (c, mut rig, mut limb) = (f.context, mry_rig::default(), 0);
    let points = [mry_point { x: 1.0, y: 1.0 }; 4];
    unsafe {
        let none = ptr::null_mut();
        assert_eq!(mry_rig_create(c, 9, 9, &mut rig, none), OK);
        let mut second = mry_rig::default();
        assert_eq!(mry_rig_create(c, 9, 9, &mut second, none), OK);
        assert_eq!(mry_rig_create(c, 9, 9, &mut mry_rig::default(), none), code(MRY_E_LIMIT));
        assert_eq!(mry_rig_destroy(c, second), OK);
        assert_eq!(mry_rig_create(c, 9, 9, &mut second, none), OK, "room again");
        assert_eq!(mry_rig_add_limb(c, rig, str("body"), 0, &mut limb, none), OK);
        assert_eq!(mry_rig_set_stroke(c, rig, limb, 0, points.as_ptr(), 3, 0, none), OK);
        assert_eq!(mry_rig_set_stroke(c, rig, limb, 0, points.as_ptr(), 4, 0, none), code(MRY_E_LIMIT));
        assert_eq!(mry_rig_set_stroke(c, rig, limb, 1, points.as_ptr(), 2, 0, none), code(MRY_E_LIMIT));
        let mut limits = std::mem::zeroed::<mry_limits>();
        mry_limits_init(&mut limits, size_of::<mry_limits>() as u32);
        limits.objects = (1 << 16) + 1;
        let (desc, mut other) = (mry_context_desc { limits: &limits, ..context_desc(1) }, ptr::null_mut());
        assert_eq!(mry_context_create(&desc, &mut other, none), code(MRY_E_ARGUMENT), "past the library's own bound");
    }
}

#[test]
fn a_mask_given_as_pixels_is_kept_as_a_file_and_is_the_mask_of_its_frame() {
    let f = fixture();
    let (c, clip, rig, path, mut err) = (f.context, f.clip(), f.rig(), f.path("mask.png"), error());
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    // A block that no segmenter would find by itself.
    let inside = |x: usize, y: usize| (60..90).contains(&x) && (10..50).contains(&y);
    let stride = width + 5;
    let mut pixels = vec![255u8; stride * (height - 1) + width];
    for (y, row) in pixels.chunks_mut(stride).enumerate() {
        row.iter_mut().take(width).enumerate().for_each(|(x, p)| *p = if inside(x, y) { 255 } else { 0 });
    }
    unsafe {
        let mut give = |size: usize, stride: usize| {
            mry_rig_paint_mask(c, rig, 2, pixels.as_ptr(), size, stride, str(&path), &mut err)
        };
        assert_eq!(give(pixels.len() - 1, stride), code(MRY_E_ARGUMENT));
        assert_eq!(give(pixels.len(), width - 1), code(MRY_E_ARGUMENT));
        assert_eq!(give(pixels.len(), usize::MAX), code(MRY_E_ARGUMENT));
        assert!(!std::path::Path::new(&path).exists());
        assert_eq!(give(pixels.len(), stride), OK);
        let mut desc = std::mem::zeroed::<mry_segment_desc>();
        mry_segment_desc_init(&mut desc, size_of::<mry_segment_desc>() as u32);
        (desc.clip, desc.rig) = (clip, rig);
        let mut masks = mry_masks::default();
        assert_eq!(mry_run_segment(c, &desc, &mut masks, &mut err), OK, "{}", text(&err.message));
        let mut read = vec![0u8; width * height];
        assert_eq!(mry_masks_read(c, masks, 2, read.as_mut_ptr(), read.len(), 0, &mut err), OK);
        let wrong = (0..read.len()).filter(|i| (read[*i] > 0) != inside(i % width, i / width)).count();
        assert_eq!(wrong, 0, "what a person painted is the mask");
    }
}

/// Lends threads, and keeps them to see that they end.
#[derive(Default)]
struct Lender {
    threads: Mutex<Vec<JoinHandle<()>>>,
    left: Mutex<u32>,
}

struct Lent(mry_worker_fn, *mut c_void);

unsafe impl Send for Lent {}

unsafe extern "C" fn lend(run: mry_worker_fn, worker: *mut c_void, user: *mut c_void) -> i32 {
    let lender = unsafe { &*user.cast::<Lender>() };
    let mut left = lender.left.lock().unwrap();
    if *left == 0 {
        return 1;
    }
    *left -= 1;
    let lent = Lent(run, worker);
    let body = move || {
        let Lent(run, worker) = { lent };
        unsafe { run.unwrap()(worker) }
    };
    lender.threads.lock().unwrap().push(std::thread::spawn(body));
    0
}

fn on_lent_threads(lender: &Lender, threads: u32) -> (mry_status, *mut mry_context) {
    let mut executor = unsafe { std::mem::zeroed::<mry_executor>() };
    unsafe { mry_executor_init(&mut executor, size_of::<mry_executor>() as u32) };
    executor.spawn = Some(lend);
    executor.user = ptr::from_ref(lender).cast_mut().cast();
    let desc = mry_context_desc { executor: &executor, ..context_desc(threads) };
    let mut context = ptr::null_mut();
    (unsafe { mry_context_create(&desc, &mut context, ptr::null_mut()) }, context)
}

fn json(f: &Fixture, motion: mry_motion) -> String {
    let mut json = vec![0; 1 << 20];
    let mut size = 0;
    let status =
        unsafe { mry_motion_to_json(f.context, motion, json.as_mut_ptr(), json.len(), &mut size, ptr::null_mut()) };
    assert_eq!(status, OK);
    text(&json)
}

#[test]
fn work_on_lent_threads_gives_the_same_bits_and_gives_the_threads_back() {
    let own = fixture();
    let lender = Lender { left: Mutex::new(4), ..Lender::default() };
    let (status, context) = on_lent_threads(&lender, 3);
    assert_eq!(status, OK);
    let f = Fixture { context, folder: tempfile::tempdir().unwrap() };
    assert_eq!(json(&f, f.motion()), json(&own, own.motion()));
    let mut threads = 0;
    assert_eq!(unsafe { mry_context_get_threads(context, &mut threads, ptr::null_mut()) }, OK);
    assert_eq!((threads, lender.threads.lock().unwrap().len()), (3, 4), "one for each worker, one for the jobs");
    drop(f);
    // Each comes back; a lent thread that did not would hold this test for ever.
    lender.threads.into_inner().unwrap().into_iter().for_each(|t| t.join().unwrap());
}

#[test]
fn a_host_that_lends_too_few_threads_gets_no_context() {
    for left in 0..4 {
        let lender = Lender { left: Mutex::new(left), ..Lender::default() };
        let (status, context) = on_lent_threads(&lender, 3);
        assert_eq!((status, context.is_null()), (code(MRY_E_THREADS), true), "{left} of 4 threads");
        lender.threads.into_inner().unwrap().into_iter().for_each(|t| t.join().unwrap());
    }
}

/// Lends memory for frames, and keeps count.
#[derive(Default)]
struct FrameLender {
    out: Mutex<std::collections::HashMap<usize, usize>>,
    most: Mutex<usize>,
}

unsafe extern "C" fn lend_memory(size: usize, alignment: usize, user: *mut c_void) -> *mut c_void {
    let lender = unsafe { &*user.cast::<FrameLender>() };
    let mut out = lender.out.lock().unwrap();
    if out.values().sum::<usize>() + size > *lender.most.lock().unwrap() {
        return ptr::null_mut();
    }
    let memory = unsafe { std::alloc::alloc(std::alloc::Layout::from_size_align(size, alignment).unwrap()) };
    out.insert(memory as usize, size);
    memory.cast()
}

unsafe extern "C" fn take_memory_back(memory: *mut c_void, size: usize, alignment: usize, user: *mut c_void) {
    let lender = unsafe { &*user.cast::<FrameLender>() };
    assert_eq!(lender.out.lock().unwrap().remove(&(memory as usize)), Some(size));
    unsafe { std::alloc::dealloc(memory.cast(), std::alloc::Layout::from_size_align(size, alignment).unwrap()) };
}

#[test]
fn frames_lie_in_the_hosts_memory_and_all_of_it_comes_back() {
    let lender = FrameLender { most: Mutex::new(usize::MAX), ..FrameLender::default() };
    let mut allocator = unsafe { std::mem::zeroed::<mry_allocator>() };
    unsafe { mry_allocator_init(&mut allocator, size_of::<mry_allocator>() as u32) };
    allocator.user = ptr::from_ref(&lender).cast_mut().cast();
    let create = |allocator: &mry_allocator| {
        let desc = mry_context_desc { allocator, ..context_desc(2) };
        let mut context = ptr::null_mut();
        (unsafe { mry_context_create(&desc, &mut context, ptr::null_mut()) }, context)
    };
    assert_eq!(create(&allocator).0, code(MRY_E_NULL), "an allocator without functions");
    allocator.alloc = Some(lend_memory);
    allocator.free = Some(take_memory_back);
    let (status, context) = create(&allocator);
    assert_eq!(status, OK);
    let f = Fixture { context, folder: tempfile::tempdir().unwrap() };
    let (own, clip) = (fixture(), f.clip());
    assert_eq!(json(&f, f.motion()), json(&own, own.motion()), "results do not depend on whose memory it is");
    let frame = 3 * (SIZE.0 * SIZE.1) as usize;
    unsafe {
        let mut view = image_view();
        assert_eq!(mry_clip_map_frame(context, clip, 2, &mut view, ptr::null_mut()), OK);
        assert_eq!(lender.out.lock().unwrap().get(&(view.data as usize)), Some(&frame), "the map is the host's memory");
        assert_eq!(view.data as usize % 64, 0);
        mry_clip_close(context, clip);
        assert!(lender.out.lock().unwrap().contains_key(&(view.data as usize)), "mapped still");
        mry_unmap(context, view.map);

        *lender.most.lock().unwrap() = 0;
        let (mut refused, mut err) = (mry_clip::default(), error());
        let status = mry_clip_open(context, str(&f.path("clip")), ptr::null(), &mut refused, &mut err);
        assert_eq!(status, code(MRY_E_MEMORY), "{}", text(&err.message));
        *lender.most.lock().unwrap() = usize::MAX;
        assert_eq!(mry_clip_open(context, str(&f.path("clip")), ptr::null(), &mut refused, &mut err), OK);
    }
    drop(f);
    assert!(lender.out.lock().unwrap().is_empty(), "all is given back with the context");
}
