//! Sketches through the C ABI: drawn, bound, moved, read, drawn and written; points tracked and corrected.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ffi::c_char;
use std::ptr;

use common::*;
use marey_ffi::*;

const PATHS: &str = r#"{"format":"marey-paths","version":1,"size":[200,100],"fps":10,"seconds":1,"points":[
    {"name":"left","path":"M20 50"},{"name":"right","path":"M180 50 L180 20"},{"name":"middle","path":"M100 50 L100 35"}]}"#;

fn string(read: impl Fn(*mut c_char, usize, *mut usize) -> mry_status) -> String {
    let mut size = 0;
    read(ptr::null_mut(), 0, &mut size);
    let mut bytes = vec![0; size];
    assert_eq!(read(bytes.as_mut_ptr(), size, &mut size), OK);
    text(&bytes)
}

/// A line that a pen drew, pressed harder in the middle, and a dot.
fn drawn(f: &Fixture) -> mry_drawing {
    let (mut drawing, mut err) = (mry_drawing::default(), error());
    let sample = |i: usize| {
        let t = i as f32 / 40.0;
        mry_pen_sample { x: 20.0 + 160.0 * t, y: 50.0 + 6.0 * (6.0 * t).sin(), pressure: 0.2 + 0.6 * t * (1.0 - t) }
    };
    let line: Vec<mry_pen_sample> = (0..=40).map(sample).collect();
    let dot = mry_pen_sample { x: 100.0, y: 35.0, pressure: 0.5 };
    unsafe {
        assert_eq!(mry_drawing_create(f.context, 200.0, 100.0, &mut drawing, &mut err), OK);
        let (c, ink) = (f.context, [200u8, 0, 0, 255]);
        let status =
            mry_drawing_add_stroke(c, drawing, str("line"), line.as_ptr(), line.len(), 8.0, ink.as_ptr(), &mut err);
        assert_eq!(status, OK, "{}", text(&err.message));
        assert_eq!(mry_drawing_add_stroke(c, drawing, str(""), &dot, 1, 5.0, ink.as_ptr(), &mut err), OK);
    }
    drawing
}

fn motion(f: &Fixture) -> mry_motion {
    let (mut motion, mut err) = (mry_motion::default(), error());
    assert_eq!(unsafe { mry_motion_from_paths(f.context, str(PATHS), &mut motion, &mut err) }, OK);
    motion
}

/// The ends and the middle held where the motion begins.
fn bound(f: &Fixture, drawing: mry_drawing) -> mry_binding {
    let (mut binding, mut err) = (mry_binding::default(), error());
    unsafe {
        assert_eq!(mry_binding_create(f.context, drawing, &mut binding, &mut err), OK);
        let mut how = std::mem::zeroed::<mry_motion_use>();
        mry_motion_use_init(&mut how, size_of::<mry_motion_use>() as u32);
        (how.scale, how.travel) = (1.0, 1.0);
        assert_eq!(mry_binding_set_motion(f.context, binding, str("wave"), &how, &mut err), OK);
        for (track, x) in [("left", 20.0), ("right", 180.0), ("middle", 100.0)] {
            let at = mry_point { x, y: 50.0 };
            assert_eq!(mry_binding_set_point(f.context, binding, str(""), str(track), 0, at, str(""), &mut err), OK);
        }
    }
    binding
}

fn moved(
    f: &Fixture,
    drawing: mry_drawing,
    binding: mry_binding,
    motion: mry_motion,
) -> Result<mry_sketch_take, String> {
    let mut desc = unsafe { std::mem::zeroed::<mry_sketch_take_desc>() };
    unsafe { mry_sketch_take_desc_init(&mut desc, size_of::<mry_sketch_take_desc>() as u32) };
    (desc.drawing, desc.binding, desc.motions, desc.motion_count) = (drawing, binding, &motion, 1);
    let (mut take, mut err) = (mry_sketch_take::default(), error());
    match unsafe { mry_run_sketch_take(f.context, &desc, &mut take, &mut err) } {
        OK => Ok(take),
        _ => Err(text(&err.message)),
    }
}

fn path(f: &Fixture, take: mry_sketch_take, frame: u64) -> Vec<mry_path_element> {
    let (mut elements, mut count) = (vec![mry_path_element::default(); 512], 0);
    let status = unsafe {
        mry_sketch_take_read_stroke(f.context, take, frame, 0, elements.as_mut_ptr(), 512, &mut count, ptr::null_mut())
    };
    assert_eq!(status, OK);
    elements.truncate(count);
    elements
}

/// Where an element ends.
fn end(element: &mry_path_element) -> mry_point {
    match element.kind {
        MRY_PATH_CUBIC => element.points[2],
        MRY_PATH_QUADRATIC => element.points[1],
        _ => element.points[0],
    }
}

#[test]
fn a_drawn_line_follows_the_points_that_hold_it() {
    let f = fixture();
    let (drawing, motion) = (drawn(&f), motion(&f));
    let binding = bound(&f, drawing);
    let take = moved(&f, drawing, binding, motion).unwrap();
    let mut info = unsafe { std::mem::zeroed::<mry_sketch_take_info>() };
    unsafe {
        mry_sketch_take_info_init(&mut info, size_of::<mry_sketch_take_info>() as u32);
        assert_eq!(mry_sketch_take_get_info(f.context, take, &mut info, ptr::null_mut()), OK);
    }
    assert_eq!((info.stroke_count, info.frame_count, info.fps), (2, 10, 10.0));
    let (rest, half) = (path(&f, take, 0), path(&f, take, 5));
    let kinds = |p: &[mry_path_element]| p.iter().map(|e| e.kind).collect::<Vec<_>>();
    assert_eq!(kinds(&rest), kinds(&half));
    let (first, last) = (end(&half[0]), end(half.last().unwrap()));
    // The right end is 30 pixels up, the left one stays.
    assert!((first.x - 20.0).abs() < 3.0 && (first.y - 50.0).abs() < 3.0, "{first:?}");
    assert!((last.y - end(rest.last().unwrap()).y + 30.0).abs() < 3.0, "{last:?}");
    // Pixels: red on nothing, and the same as in files.
    let (mut width, mut height, c) = (0, 0, f.context);
    unsafe {
        let status =
            mry_sketch_take_measure(c, take, 1.0, 1, &mut width, &mut height, ptr::null_mut(), ptr::null_mut());
        assert_eq!((status, width, height), (OK, 200, 100));
        let mut pixels = vec![0u8; 200 * 100 * 4];
        let (to, room) = (pixels.as_mut_ptr(), pixels.len());
        assert_eq!(mry_sketch_take_draw_frame(c, take, 0, 1.0, 1, to, room, 0, ptr::null_mut()), OK);
        assert!(pixels.chunks_exact(4).any(|p| p == [200, 0, 0, 255]));
        let mut order = [9u32; 4];
        let mut count = 0;
        assert_eq!(mry_sketch_take_read_order(c, take, order.as_mut_ptr(), 4, &mut count, ptr::null_mut()), OK);
        assert_eq!((count, &order[..2]), (2, &[0, 1][..]));
    }
    for name in ["wave.svg", "wave.json", "wave.gif"] {
        let file = f.folder.path().join(name);
        let mut desc = unsafe { std::mem::zeroed::<mry_sketch_file_desc>() };
        let mut err = error();
        unsafe {
            mry_sketch_file_desc_init(&mut desc, size_of::<mry_sketch_file_desc>() as u32);
            (desc.take, desc.path) = (take, str(file.to_str().unwrap()));
            assert_eq!(mry_run_sketch_file(f.context, &desc, &mut err), OK, "{name}: {}", text(&err.message));
        }
        assert!(std::fs::metadata(&file).unwrap().len() > 100, "{name}");
    }
}

#[test]
fn bindings_keep_what_a_person_says_and_refuse_what_makes_no_sense() {
    let f = fixture();
    let drawing = drawn(&f);
    let (binding, c, mut err) = (bound(&f, drawing), f.context, error());
    let json = || string(|t, n, s| unsafe { mry_binding_to_json(c, binding, t, n, s, ptr::null_mut()) });
    let before = json();
    unsafe {
        let refused = [
            mry_binding_set_stroke(c, binding, str("line"), f32::NAN, 0, &mut err),
            mry_binding_set_stroke(c, binding, str("line"), -2.0, 0, &mut err),
            mry_binding_set_stroke(c, binding, str("line"), 1.0, 7, &mut err),
            mry_binding_add_pin(c, binding, mry_point { x: f32::INFINITY, y: 0.0 }, str(""), &mut err),
            mry_binding_add_joint(c, binding, str("no"), str("such"), mry_point::default(), &mut err),
            mry_binding_remove_pin(c, binding, 0, &mut err),
            mry_binding_remove_layer(c, binding, str("none"), &mut err),
            mry_binding_remove_point(c, binding, str(""), str("none"), 0, &mut err),
        ];
        assert!(refused.iter().all(|s| *s < 0), "{refused:?}");
        assert_eq!(json(), before, "what fails changes nothing");
        assert_eq!(mry_binding_set_stroke(c, binding, str("line"), 50.0, 0, &mut err), OK);
        let (mut rigidity, mut still) = (0.0, 9);
        assert_eq!(mry_binding_get_stroke(c, binding, str("line"), &mut rigidity, &mut still, &mut err), OK);
        assert_eq!((rigidity, still), (50.0, 0));
        let brush = [mry_point { x: 100.0, y: 35.0 }];
        let mut touched = 0;
        let painted =
            mry_binding_paint_layer(c, binding, drawing, str("dot"), brush.as_ptr(), 1, 3.0, &mut touched, &mut err);
        assert_eq!((painted, touched), (OK, 1), "{}", text(&err.message));
        let name = string(|t, n, s| mry_binding_get_layer(c, binding, 1, t, n, s, ptr::null_mut()));
        assert_eq!(name, "dot");
        assert_eq!(mry_binding_validate(c, binding, drawing, &mut err), OK, "{}", text(&err.message));
        // The binding of a stroke that is gone does not fit any more.
        assert_eq!(mry_drawing_remove_stroke(c, drawing, str("line"), &mut err), OK);
        assert!(mry_binding_validate(c, binding, drawing, &mut err) < 0);
    }
    assert!(moved(&f, drawing, binding, motion(&f)).unwrap_err().contains("line"));
    let mut other = mry_binding::default();
    unsafe {
        assert_eq!(mry_binding_from_json(c, str(&before), &mut other, &mut err), OK);
        assert_eq!(string(|t, n, s| mry_binding_to_json(c, other, t, n, s, ptr::null_mut())), before);
    }
}

#[test]
fn points_are_tracked_and_a_correction_gives_what_a_fresh_start_would() {
    let f = fixture();
    let (clip, c) = (f.clip(), f.context);
    let marks = r#"{"format":"marey-points","version":1,"size":[96,64],
        "points":[{"name":"a","keys":[{"frame":0,"at":[30,30]}]},{"name":"b","keys":[{"frame":0,"at":[60,40]}]}]}"#;
    let track = |points: mry_control_points, keep: u32| {
        let mut desc = unsafe { std::mem::zeroed::<mry_point_track_desc>() };
        let (mut motion, mut err) = (mry_motion::default(), error());
        unsafe {
            mry_point_track_desc_init(&mut desc, size_of::<mry_point_track_desc>() as u32);
            (desc.clip, desc.points, desc.keep) = (clip, points, keep);
            let status = mry_run_point_track(c, &desc, &mut motion, &mut err);
            assert_eq!(status, OK, "{}", text(&err.message));
            string(|t, n, s| mry_motion_to_json(c, motion, t, n, s, ptr::null_mut()))
        }
    };
    let (mut points, mut err) = (mry_control_points::default(), error());
    unsafe {
        assert_eq!(mry_control_points_from_json(c, str(marks), &mut points, &mut err), OK, "{}", text(&err.message));
        let plain = track(points, 0);
        assert_eq!(track(points, 1), plain);
        let at = mry_point { x: 33.0, y: 31.0 };
        assert_eq!(mry_control_points_mark(c, points, str("a"), 1, at, &mut err), OK);
        let again = track(points, 1);
        assert!(again.contains("33.0,31.0") || again.contains("[33,31]"), "a key is kept to the bit");
        assert_ne!(again, plain);
        // Closing lets go of what was kept; a clip that is opened anew tells the same.
        let fresh = fixture();
        let (mut desc, mut motion) = (std::mem::zeroed::<mry_point_track_desc>(), mry_motion::default());
        mry_point_track_desc_init(&mut desc, size_of::<mry_point_track_desc>() as u32);
        let json = string(|t, n, s| mry_control_points_to_json(c, points, t, n, s, ptr::null_mut()));
        assert_eq!(mry_control_points_from_json(fresh.context, str(&json), &mut desc.points, &mut err), OK);
        desc.clip = fresh.clip();
        assert_eq!(mry_run_point_track(fresh.context, &desc, &mut motion, &mut err), OK);
        assert_eq!(string(|t, n, s| mry_motion_to_json(fresh.context, motion, t, n, s, ptr::null_mut())), again);
    }
}
