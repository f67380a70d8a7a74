//! Characters through the C ABI: made, changed, posed, animated, and written.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ffi::c_char;
use std::ptr;

use common::*;
use marey_ffi::mry_status_code::*;
use marey_ffi::*;

fn sample(name: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/characters/child").join(name);
    path.to_str().unwrap().to_owned()
}

fn make(f: &Fixture, desc: &mry_character_desc) -> Result<mry_character, (mry_status, String)> {
    let (mut character, mut err) = (mry_character::default(), error());
    match unsafe { mry_run_character(f.context, desc, &mut character, &mut err) } {
        OK => Ok(character),
        status => Err((status, text(&err.message))),
    }
}

/// The bundled child with its picture.
fn child(f: &Fixture) -> mry_character {
    let (picture, rig) = (sample("drawing.png"), sample("rig.json"));
    let mut desc = character_desc();
    (desc.picture, desc.rig) = (str(&picture), str(&rig));
    make(f, &desc).unwrap()
}

fn info(f: &Fixture, character: mry_character) -> mry_character_info {
    let mut info = unsafe { std::mem::zeroed::<mry_character_info>() };
    unsafe {
        mry_character_info_init(&mut info, size_of::<mry_character_info>() as u32);
        assert_eq!(mry_character_get_info(f.context, character, &mut info, ptr::null_mut()), OK);
    }
    info
}

fn rest(f: &Fixture, character: mry_character) -> Vec<mry_point> {
    (0..info(f, character).joint_count)
        .map(|joint| {
            let (mut at, mut size) = (mry_point::default(), 0);
            let (mut name, c) = ([0 as c_char; 64], f.context);
            let status = unsafe {
                mry_character_get_joint(c, character, joint, name.as_mut_ptr(), 64, &mut size, &mut at, ptr::null_mut())
            };
            assert_eq!(status, OK);
            at
        })
        .collect()
}

fn string(read: impl Fn(*mut c_char, usize, *mut usize) -> mry_status) -> String {
    let mut size = 0;
    read(ptr::null_mut(), 0, &mut size);
    let mut bytes = vec![0; size];
    assert_eq!(read(bytes.as_mut_ptr(), size, &mut size), OK);
    text(&bytes)
}

fn shape(f: &Fixture, character: mry_character) -> Vec<mry_point> {
    let mut points = vec![mry_point::default(); info(f, character).vertex_count as usize];
    let (mut count, none) = (0, ptr::null_mut());
    let (to, capacity) = (points.as_mut_ptr(), points.len());
    let status = unsafe {
        mry_character_read_vertices(
            f.context,
            character,
            to,
            none,
            ptr::null_mut(),
            capacity,
            &mut count,
            ptr::null_mut(),
        )
    };
    assert_eq!(status, OK);
    points
}

fn apart(a: &[mry_point], b: &[mry_point]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a.x - b.x).hypot(a.y - b.y)).fold(0.0, f32::max)
}

fn poser(f: &Fixture, character: mry_character, deformer: &str) -> mry_poser {
    let (mut poser, mut err) = (mry_poser::default(), error());
    let status = unsafe { mry_poser_create(f.context, character, str(deformer), 0, &mut poser, &mut err) };
    assert_eq!(status, OK, "{}", text(&err.message));
    poser
}

fn pose(f: &Fixture, poser: mry_poser, joints: &[mry_point], points: &mut [mry_point]) -> mry_status {
    let (to, count) = (points.as_mut_ptr(), points.len());
    unsafe { mry_poser_pose(f.context, poser, joints.as_ptr(), joints.len(), to, count, ptr::null_mut()) }
}

#[test]
fn a_picture_in_memory_becomes_a_character_and_its_rig_comes_back() {
    let f = fixture();
    let picture = bar_picture();
    let (pixels, mut desc) = (view(&picture), character_desc());
    (desc.pixels, desc.vertices) = (&pixels, 60);
    let made = make(&f, &desc).unwrap();
    let first = info(&f, made);
    assert_eq!((first.width, first.height, first.has_picture), (48, 20, 1));
    assert!(first.joint_count >= 2 && first.bone_count == first.joint_count - 1);
    let c = f.context;
    let json = string(|t, n, size| unsafe { mry_character_to_json(c, made, t, n, size, ptr::null_mut()) });
    let mut desc = character_desc();
    desc.rig_json = str(&json);
    let again = make(&f, &desc).unwrap();
    assert_eq!(info(&f, again).has_picture, 0);
    assert_eq!(string(|t, n, size| unsafe { mry_character_to_json(c, again, t, n, size, ptr::null_mut()) }), json);
    let mut triangles = vec![[0u32; 3]; first.triangle_count as usize];
    let mut count = 0;
    let status = unsafe {
        let to = triangles.as_mut_ptr().cast();
        mry_character_read_triangles(c, again, to, triangles.len(), &mut count, ptr::null_mut())
    };
    assert_eq!((status, count), (OK, triangles.len()));
    assert!(triangles.iter().flatten().all(|v| u64::from(*v) < first.vertex_count));
    // Rows with gaps say the same.
    let mut wide = vec![0u8; 20 * 200];
    for (y, row) in picture.as_raw().chunks_exact(4 * 48).enumerate() {
        wide[200 * y..200 * y + 192].copy_from_slice(row);
    }
    let mut gaps = view(&picture);
    (gaps.stride_bytes, gaps.data) = (200, wide.as_ptr());
    let mut desc = character_desc();
    (desc.pixels, desc.vertices) = (&gaps, 60);
    assert_eq!(shape(&f, make(&f, &desc).unwrap()), shape(&f, made));
}

#[test]
fn what_cannot_become_a_character_is_said() {
    let f = fixture();
    let (picture, rig) = (bar_picture(), bar_rig());
    let refuses =
        |change: &dyn Fn(&mut mry_character_desc, &mut mry_image_view), expected: mry_status_code, says: &str| {
            let (mut pixels, mut desc) = (view(&picture), character_desc());
            change(&mut desc, &mut pixels);
            if desc.pixels.is_null() && desc.picture.len == 0 && desc.reserved0 == 0 {
                desc.pixels = &pixels;
            }
            desc.reserved0 = 0;
            let (status, said) = make(&f, &desc).unwrap_err();
            assert_eq!(status, code(expected), "{said}");
            assert!(said.contains(says), "{said}");
        };
    refuses(&|d, _| d.reserved0 = 1, MRY_E_ARGUMENT, "give a picture");
    refuses(&|_, p| p.format = 9, MRY_E_ARGUMENT, "format");
    refuses(&|_, p| p.stride_bytes = 7, MRY_E_ARGUMENT, "stride");
    refuses(&|_, p| p.stride_bytes = u64::MAX, MRY_E_ARGUMENT, "stride");
    refuses(&|_, p| (p.width, p.height) = (u32::MAX, u32::MAX), MRY_E_LIMIT, "pixels");
    refuses(&|_, p| (p.width, p.height) = (0, 0), MRY_E_INPUT, "no pixels");
    refuses(&|_, p| p.data = ptr::null(), MRY_E_NULL, "NULL");
    refuses(&|d, _| d.finer_at_joints = f32::NAN, MRY_E_NON_FINITE, "finer");
    refuses(&|d, _| d.finer_at_joints = 99.0, MRY_E_INPUT, "finer");
    refuses(&|d, _| d.vertices = u32::MAX, MRY_E_LIMIT, "vertex count");
    refuses(&|d, _| d.rig_json = str("{\"format\": \"marey-rig\", \"ver"), MRY_E_INPUT, "not readable");
    refuses(&|d, _| d.rig = str("/no/such/rig.json"), MRY_E_NO_FILE, "/no/such/rig.json");
    refuses(&|d, _| d.picture = str("/no/such.png"), MRY_E_NO_FILE, "/no/such.png");
    refuses(
        &|d, p| {
            (p.width, p.height) = (24, 20);
            p.stride_bytes = 192;
            d.rig_json = str(&rig);
        },
        MRY_E_INPUT,
        "48x20",
    );
}

#[test]
fn joints_are_moved_added_renamed_and_taken_away() {
    let f = fixture();
    let (c, character, mut err) = (f.context, f.character(), error());
    let (mut joint, mut at) = (9, mry_point::default());
    unsafe {
        let near = mry_point { x: 20.0, y: 30.0 };
        assert_eq!(mry_character_on_curve(c, character, near, &mut at, &mut err), OK);
        assert_eq!((at.x, at.y), (20.0, 10.0));
        assert_eq!(mry_character_split_bone(c, character, str("mid"), at, 0, &mut joint, &mut err), OK);
        assert_eq!((joint, info(&f, character).bone_count), (3, 3));
        assert_eq!(mry_character_add_joint(c, character, str("fin"), near, joint, &mut joint, &mut err), OK);
        assert_eq!(mry_character_rename_joint(c, character, 0, str("root"), &mut err), OK);
        assert_eq!(mry_character_find_joint(c, character, str("fin"), &mut joint, &mut err), OK);
        assert_eq!(joint, 4);
        let mut places = rest(&f, character);
        places[1].y += 3.0;
        assert_eq!(mry_character_set_joints(c, character, places.as_ptr(), places.len(), &mut err), OK);
        assert_eq!(rest(&f, character)[1].y, 13.0);
        assert_eq!(mry_character_remove_joint(c, character, 3, &mut err), OK);
        assert_eq!((info(&f, character).joint_count, info(&f, character).bone_count), (4, 3));
        let before = string(|t, n, size| mry_character_to_json(c, character, t, n, size, ptr::null_mut()));
        assert!(before.contains("\"root\""));
        // What is refused changes nothing.
        let nan = mry_point { x: f32::NAN, y: 0.0 };
        for status in [
            mry_character_add_joint(c, character, str("root"), near, 0, &mut joint, &mut err),
            mry_character_add_joint(c, character, str("new"), nan, 0, &mut joint, &mut err),
            mry_character_add_joint(c, character, str("new"), near, 99, &mut joint, &mut err),
            mry_character_split_bone(c, character, str("new"), near, 99, &mut joint, &mut err),
            mry_character_rename_joint(c, character, 1, str("root"), &mut err),
            mry_character_rename_joint(c, character, 1, str(""), &mut err),
            mry_character_remove_joint(c, character, 99, &mut err),
            mry_character_set_joints(c, character, places.as_ptr(), 1, &mut err),
            mry_character_set_joints(c, character, [nan; 4].as_ptr(), 4, &mut err),
        ] {
            assert!(status < 0, "{}", text(&err.message));
        }
        assert_eq!(mry_character_find_joint(c, character, str("new"), &mut joint, &mut err), code(MRY_E_NOT_FOUND));
        assert_eq!(string(|t, n, size| mry_character_to_json(c, character, t, n, size, ptr::null_mut())), before);
        // A copy goes its own way.
        let mut copy = mry_character::default();
        assert_eq!(mry_character_copy(c, character, &mut copy, &mut err), OK);
        assert_eq!(mry_character_remove_joint(c, copy, 2, &mut err), OK);
        assert_eq!(info(&f, character).joint_count, 4);
    }
}

#[test]
fn a_drag_moves_the_mesh_and_back_at_rest_it_is_at_rest() {
    let f = fixture();
    let character = child(&f);
    let (still, at) = (shape(&f, character), rest(&f, character));
    for (deformer, exact) in [("", 1e-3), ("needles", 1e-3), ("arap", 0.05)] {
        let poser = poser(&f, character, deformer);
        let mut points = still.clone();
        assert_eq!(pose(&f, poser, &at, &mut points), OK);
        assert!(apart(&points, &still) < exact, "{deformer}: {}", apart(&points, &still));
        let mut moved = at.clone();
        let mut hand = 0;
        assert_eq!(
            unsafe { mry_character_find_joint(f.context, character, str("left_hand"), &mut hand, ptr::null_mut()) },
            OK
        );
        moved[hand as usize].y -= 60.0;
        let (to, count) = (points.as_mut_ptr(), points.len());
        let (from, joints) = (moved.as_ptr(), moved.len());
        let status = unsafe { mry_poser_drag(f.context, poser, from, joints, to, count, ptr::null_mut()) };
        assert_eq!(status, OK);
        let dragged = points.clone();
        assert_eq!(pose(&f, poser, &moved, &mut points), OK);
        assert!(apart(&points, &dragged) < 3.0, "{deformer}: {}", apart(&points, &dragged));
        assert!(apart(&points, &still) > 30.0, "{deformer}");
        assert_eq!(pose(&f, poser, &at, &mut points), OK);
        assert!(apart(&points, &still) < 60.0 * exact.max(0.01), "{deformer}: {}", apart(&points, &still));
        // Nothing is written where something is wrong.
        let before = points.clone();
        moved[0].x = f32::INFINITY;
        assert_eq!(pose(&f, poser, &moved, &mut points), code(MRY_E_NON_FINITE));
        assert_eq!(pose(&f, poser, &at[1..], &mut points), code(MRY_E_ARGUMENT));
        assert_eq!(pose(&f, poser, &at, &mut points[1..]), code(MRY_E_BUFFER_TOO_SMALL));
        assert_eq!(points, before);
    }
    let (mut none, mut err) = (mry_poser::default(), error());
    let status = unsafe { mry_poser_create(f.context, character, str("clay"), 0, &mut none, &mut err) };
    assert_eq!(status, code(MRY_E_UNSUPPORTED));
    let status = unsafe { mry_poser_create(f.context, character, str(""), 7, &mut none, &mut err) };
    assert_eq!((status, text(&err.param).as_str()), (code(MRY_E_ARGUMENT), "area"));
}

#[test]
fn a_pen_draws_poses_outlines_and_orders() {
    let f = fixture();
    let (c, character, mut err) = (f.context, f.character(), error());
    let (at, still) = (rest(&f, character), shape(&f, character));
    unsafe {
        // The whole skeleton as one stroke, bent down behind its middle joint.
        let pen = |x: f32, y: f32| mry_point { x, y };
        let stroke = [at[0], pen(15.0, 10.0), at[1], pen(30.0, 16.0), pen(37.0, 23.0)];
        let (mut joints, none) = ([mry_point::default(); 3], ptr::null());
        let (to, lengths) = (joints.as_mut_ptr(), [5u32]);
        let sketch = |from, n, p: *const mry_point, l: *const u32, count, to, err: &mut mry_error| {
            mry_character_sketch(c, character, from, n, p, l, count, to, err)
        };
        let status = sketch(none, 3, stroke.as_ptr(), lengths.as_ptr(), 1, to, &mut err);
        assert_eq!(status, OK, "{}", text(&err.message));
        assert!(joints[2].y > 18.0 && joints[0].y < 12.0, "{joints:?}");
        assert!(sketch(none, 2, stroke.as_ptr(), lengths.as_ptr(), 1, to, &mut err) < 0);
        assert!(sketch(none, 3, stroke.as_ptr(), [u32::MAX, u32::MAX].as_ptr(), 2, to, &mut err) < 0);
        assert!(sketch(none, 3, stroke.as_ptr(), lengths.as_ptr(), 0, to, &mut err) < 0);

        // A bump drawn on the upper rim.
        let poser = poser(&f, character, "");
        let curve = [pen(12.0, 6.0), pen(18.0, 3.0), pen(24.0, 2.0), pen(30.0, 3.0), pen(36.0, 6.0)];
        let (mut vertices, mut ways, mut count) = ([0u32; 64], [mry_point::default(); 64], 0);
        let status = mry_poser_redraw(
            c,
            poser,
            at.as_ptr(),
            3,
            still.as_ptr(),
            still.len(),
            curve.as_ptr(),
            5,
            vertices.as_mut_ptr(),
            ways.as_mut_ptr(),
            64,
            &mut count,
            &mut err,
        );
        assert_eq!(status, OK, "{}", text(&err.message));
        let up = ways[..count].iter().map(|w| -w.y).fold(0.0, f32::max);
        assert!(count >= 3 && (2.0..6.0).contains(&up), "{count} move, {up} at most");
        let status = mry_poser_redraw(
            c,
            poser,
            at.as_ptr(),
            3,
            still.as_ptr(),
            2,
            curve.as_ptr(),
            5,
            ptr::null_mut(),
            ptr::null_mut(),
            0,
            &mut count,
            &mut err,
        );
        assert!(status < 0);

        // At rest nothing lies over anything; folded over, one half lies on the other.
        let mut overlaps = [mry_overlap::default(); 8];
        let (over, none) = (overlaps.as_mut_ptr(), ptr::null());
        let read = |shape: &[mry_point], count: &mut usize, err: &mut mry_error| {
            mry_character_read_overlaps(c, character, shape.as_ptr(), shape.len(), none, 0, over, 8, count, err)
        };
        assert_eq!(read(&still, &mut count, &mut err), OK);
        assert_eq!(count, 0);
        let folded: Vec<mry_point> = still.iter().map(|p| if p.x > 24.0 { pen(48.0 - p.x, p.y) } else { *p }).collect();
        assert_eq!(read(&folded, &mut count, &mut err), OK);
        assert!(count == 1 && overlaps[0].area > 50.0, "{:?}", &overlaps[..count]);
        assert!(read(&folded[1..], &mut count, &mut err) < 0);
        let (mut depths, mut bone) = ([0i32; 2], 9);
        let (order, shown) = (depths.as_mut_ptr(), folded.as_ptr());
        let status = mry_character_bring_forward(
            c,
            character,
            shown,
            folded.len(),
            order,
            2,
            pen(14.0, 10.0),
            &mut bone,
            &mut err,
        );
        assert_eq!(status, OK, "{}", text(&err.message));
        assert!(bone < 2 && depths[bone as usize] > depths[1 - bone as usize]);
        let status = mry_character_bring_forward(
            c,
            character,
            shown,
            folded.len(),
            order,
            2,
            pen(1.0, 1.0),
            &mut bone,
            &mut err,
        );
        assert_eq!(status, code(MRY_E_NOT_FOUND));
    }
}

fn play(f: &Fixture, desc: &mry_take_desc) -> Result<mry_take, (mry_status, String)> {
    let (mut take, mut err) = (mry_take::default(), error());
    match unsafe { mry_run_take(f.context, desc, &mut take, &mut err) } {
        OK => Ok(take),
        status => Err((status, text(&err.message))),
    }
}

fn take_desc() -> mry_take_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_take_desc>() };
    unsafe { mry_take_desc_init(&mut desc, size_of::<mry_take_desc>() as u32) };
    desc
}

fn take_info(f: &Fixture, take: mry_take) -> mry_take_info {
    let mut info = unsafe { std::mem::zeroed::<mry_take_info>() };
    unsafe {
        mry_take_info_init(&mut info, size_of::<mry_take_info>() as u32);
        assert_eq!(mry_take_get_info(f.context, take, &mut info, ptr::null_mut()), OK);
    }
    info
}

fn points_of(f: &Fixture, take: mry_take, frame: u64) -> Vec<mry_point> {
    let mut points = vec![mry_point::default(); take_info(f, take).vertex_count as usize];
    let mut count = 0;
    let (to, capacity) = (points.as_mut_ptr(), points.len());
    let status = unsafe { mry_take_read_points(f.context, take, frame, to, capacity, &mut count, ptr::null_mut()) };
    assert_eq!((status, count), (OK, capacity));
    points
}

#[test]
fn key_poses_set_by_hand_become_a_take_and_a_file_of_poses() {
    let f = fixture();
    let (c, character, mut err) = (f.context, child(&f), error());
    let at = rest(&f, character);
    let mut up = at.clone();
    let last = up.len() - 1;
    up[last].x += 20.0;
    unsafe {
        let mut poses = mry_poses::default();
        assert_eq!(mry_poses_create(c, character, 0.0, 0, &mut poses, &mut err), OK);
        let mut desc = take_desc();
        desc.poses = poses;
        assert!(play(&f, &desc).unwrap_err().1.contains("no keys"));
        assert_eq!(mry_poses_set_key(c, poses, 8, at.as_ptr(), at.len(), MRY_EASING_LINEAR, &mut err), OK);
        assert_eq!(mry_poses_set_key(c, poses, 0, at.as_ptr(), at.len(), MRY_EASING_INOUT, &mut err), OK);
        assert_eq!(mry_poses_set_key(c, poses, 4, up.as_ptr(), up.len(), MRY_EASING_HOLD, &mut err), OK);
        assert_eq!(mry_poses_set_key(c, poses, 6, up.as_ptr(), up.len(), MRY_EASING_HOLD, &mut err), OK);
        assert_eq!(mry_poses_remove_key(c, poses, 6, &mut err), OK);
        assert_eq!(mry_poses_remove_key(c, poses, 6, &mut err), code(MRY_E_NOT_FOUND));
        assert_eq!(mry_poses_set_depth(c, poses, 4, 2, 5, &mut err), OK);
        let way = mry_point { x: 3.0, y: 4.0 };
        assert_eq!(mry_poses_set_moved(c, poses, 8, [7].as_ptr(), &way, 1, &mut err), OK);
        for status in [
            mry_poses_set_key(c, poses, 1, at.as_ptr(), 1, 0, &mut err),
            mry_poses_set_key(c, poses, 1, at.as_ptr(), at.len(), 77, &mut err),
            mry_poses_set_key(c, poses, u64::MAX, at.as_ptr(), at.len(), 0, &mut err),
            mry_poses_set_rate(c, poses, -1.0, 1, &mut err),
            mry_poses_set_moved(c, poses, 8, [u32::MAX].as_ptr(), &way, 1, &mut err),
            mry_poses_set_depth(c, poses, 4, 99, 5, &mut err),
        ] {
            assert!(status < 0);
        }
        let take = play(&f, &desc).unwrap();
        let info = take_info(&f, take);
        assert_eq!((info.frame_count, info.fps, info.joint_count as usize), (9, 24.0, at.len()));
        let still = shape(&f, character);
        assert!(apart(&points_of(&f, take, 0), &still) < 1e-3);
        assert!((5.0..19.0).contains(&apart(&points_of(&f, take, 2), &still)));
        assert_eq!(points_of(&f, take, 4), points_of(&f, take, 7), "held");
        let end = points_of(&f, take, 8);
        assert!((apart(&end, &still) - 5.0).abs() < 1e-2, "one vertex was dragged by hand");
        let (mut depths, mut count) = (vec![9i32; info.bone_count as usize], 0);
        let (to, room) = (depths.as_mut_ptr(), depths.len());
        assert_eq!(mry_take_read_depths(c, take, 5, to, room, &mut count, &mut err), OK);
        assert_eq!((depths[2], depths[0]), (5, 0));
        assert_eq!(mry_take_read_depths(c, take, 9, to, room, &mut count, &mut err), code(MRY_E_ARGUMENT));
        let path = f.path("poses.json");
        assert_eq!(mry_poses_write(c, poses, str(&path), &mut err), OK);
        let mut read = mry_poses::default();
        assert_eq!(mry_poses_read(c, character, str(&path), &mut read, &mut err), OK);
        desc.poses = read;
        let again = play(&f, &desc).unwrap();
        assert_eq!(points_of(&f, again, 8), end);
        // With the other deformer the same keys lead to the same joints.
        desc.deformer = str("arap");
        let arap = play(&f, &desc).unwrap();
        assert!((1.0..40.0).contains(&apart(&points_of(&f, arap, 4), &still)));
    }
}

#[test]
fn motions_move_the_child_by_names_by_maps_and_by_likeness() {
    let f = fixture();
    let (c, character, mut err) = (f.context, child(&f), error());
    // The hand goes up, all else stays.
    let at = rest(&f, character);
    let tracks: Vec<String> = at
        .iter()
        .enumerate()
        .map(|(joint, at)| {
            let (mut name, mut size) = ([0 as c_char; 64], 0);
            let (to, none) = (name.as_mut_ptr(), ptr::null_mut());
            unsafe { mry_character_get_joint(c, character, joint as u32, to, 64, &mut size, none, &mut err) };
            let frame = |y: f32| format!(r#"{{"points": [[{}, {y}]], "visible": [true], "confidence": [1]}}"#, at.x);
            let name = text(&name);
            let up = if name == "left_hand" { at.y - 40.0 } else { at.y };
            format!(r#"{{"name": "{name}", "kind": "joint", "frames": [{}, {}]}}"#, frame(at.y), frame(up))
        })
        .collect();
    let json = |tracks: &str, bones: &str| {
        format!(
            r#"{{"format": "marey-motion", "version": 1, "size": [400, 400], "fps": 10, "frames": 2,
            "tracks": [{tracks}], "bones": [{bones}]}}"#
        )
    };
    let motion = |json: &str| {
        let (mut motion, mut err) = (mry_motion::default(), error());
        assert_eq!(unsafe { mry_motion_from_json(c, str(json), &mut motion, &mut err) }, OK, "{}", text(&err.message));
        motion
    };
    let named = motion(&json(&tracks.join(", "), ""));
    let mut desc = take_desc();
    (desc.character, desc.motion) = (character, named);
    let take = play(&f, &desc).unwrap();
    let still = shape(&f, character);
    assert!(apart(&points_of(&f, take, 0), &still) < 1e-3);
    assert!(apart(&points_of(&f, take, 1), &still) > 20.0);
    let report = string(|t, n, size| unsafe { mry_take_get_report(c, take, t, n, size, ptr::null_mut()) });
    assert!(report.contains(r#""made_from":"names""#), "{report}");

    // Two strokes of another figure, told where they belong.
    let stroke = |name: &str, turned: f32| {
        let line =
            |x: f32| format!(r#"{{"points": [[10, 10], [{x}, 60]], "visible": [true, true], "confidence": [1, 1]}}"#);
        format!(r#"{{"name": "{name}", "kind": "stroke", "frames": [{}, {}]}}"#, line(10.0), line(turned))
    };
    let other = motion(&json(&stroke("tail", 40.0), ""));
    let map = r#"{"chains": [{"track": "tail", "joints": ["left_shoulder", "left_elbow", "left_hand"]}]}"#;
    let mut how = unsafe { std::mem::zeroed::<mry_retarget_desc>() };
    unsafe { mry_retarget_desc_init(&mut how, size_of::<mry_retarget_desc>() as u32) };
    how.map = str(map);
    (desc.motion, desc.retarget) = (other, &how);
    let take = play(&f, &desc).unwrap();
    assert!(apart(&points_of(&f, take, 1), &points_of(&f, take, 0)) > 20.0);
    // And where nothing is told, the longest way through the child follows the stroke.
    desc.retarget = ptr::null();
    let take = play(&f, &desc).unwrap();
    let report = string(|t, n, size| unsafe { mry_take_get_report(c, take, t, n, size, ptr::null_mut()) });
    assert!(report.contains(r#""made_from":"likeness""#) && report.contains("follow nothing"), "{report}");
    let found =
        string(|t, n, size| unsafe { mry_motion_match(c, other, character, ptr::null(), t, n, size, ptr::null_mut()) });
    assert!(found.contains("marey-map") && found.contains("\"tail\""), "{found}");

    how.map = str(r#"{"joints": {"left_hand": {"track": "fin"}}}"#);
    let refused = |how: mry_retarget_desc| play(&f, &mry_take_desc { retarget: &how, ..desc }).unwrap_err();
    let (status, said) = refused(how);
    assert!(status == code(MRY_E_INPUT) && said.contains("`fin`") && said.contains("`tail`"), "{said}");
    how.map = str(map);
    assert_eq!(refused(mry_retarget_desc { stretch: f32::NAN, ..how }).0, code(MRY_E_NON_FINITE));
    assert!(refused(mry_retarget_desc { reference: 2, ..how }).1.contains("2 frames"));
    let planted = [str("left_wing")];
    let planting = mry_retarget_desc { planted: planted.as_ptr(), planted_count: 1, ..how };
    assert!(refused(planting).1.contains("left_wing"));

    // Through BVH and back, joints keep their way.
    let (path, mut read) = (f.path("walk.bvh"), mry_motion::default());
    unsafe {
        assert_eq!(mry_motion_retarget(c, named, character, ptr::null(), &mut read, &mut err), OK);
        assert_eq!(mry_motion_write_bvh(c, read, str(&path), &mut err), OK);
        assert_eq!(mry_motion_read_bvh(c, str(&path), MRY_VIEW_FRONT, 0, &mut read, &mut err), OK);
        assert_eq!(mry_motion_read_bvh(c, str(&path), 9, 0, &mut read, &mut err), code(MRY_E_ARGUMENT));
        std::fs::write(&path, "HIERARCHY\nROOT").unwrap();
        assert_eq!(mry_motion_read_bvh(c, str(&path), 0, 0, &mut read, &mut err), code(MRY_E_INPUT));
        assert!(text(&err.message).contains("walk.bvh"));
    }
    (desc.motion, desc.retarget) = (read, ptr::null());
    let take = play(&f, &desc).unwrap();
    assert!(apart(&points_of(&f, take, 1), &points_of(&f, take, 0)) > 15.0);
}

#[test]
fn a_take_is_drawn_and_written_and_the_pictures_agree() {
    let f = fixture();
    let (c, character, mut err) = (f.context, child(&f), error());
    let (mut poses, path) = (mry_poses::default(), sample("poses.json"));
    assert_eq!(unsafe { mry_poses_read(c, character, str(&path), &mut poses, &mut err) }, OK, "{}", text(&err.message));
    let mut desc = take_desc();
    desc.poses = poses;
    let take = play(&f, &desc).unwrap();
    let (mut width, mut height, mut corner) = (0, 0, mry_point::default());
    let folder = f.path("frames");
    let mut file = unsafe { std::mem::zeroed::<mry_take_file_desc>() };
    unsafe { mry_take_file_desc_init(&mut file, size_of::<mry_take_file_desc>() as u32) };
    (file.take, file.path, file.scale) = (take, str(&folder), 0.5);
    unsafe {
        assert_eq!(mry_take_measure(c, take, 0.5, 0, &mut width, &mut height, &mut corner, &mut err), OK);
        assert!(corner.x <= 0.0 && corner.y <= 0.0 && width >= 170 && height >= 200, "{width}x{height} at {corner:?}");
        let mut pixels = vec![0u8; 4 * width as usize * height as usize];
        let (to, room) = (pixels.as_mut_ptr(), pixels.len());
        assert_eq!(mry_take_draw_frame(c, take, 9, 0.5, 0, to, room - 1, 0, &mut err), code(MRY_E_BUFFER_TOO_SMALL));
        assert_eq!(mry_take_draw_frame(c, take, 9, 0.5, 0, to, room, 0, &mut err), OK);
        let mut job = mry_job::default();
        assert_eq!(mry_job_start_take_file(c, &file, &mut job, &mut err), OK);
        assert_eq!(mry_job_wait(c, job, u64::MAX, &mut err), OK, "{}", text(&err.message));
        let report = string(|t, n, size| mry_job_get_report(c, job, t, n, size, ptr::null_mut()));
        assert!(report.contains("\"frames\":25") && report.contains("\"shown\""), "{report}");
        let written = image::open(f.folder.path().join("frames/00009.png")).unwrap().into_rgba8();
        assert_eq!(written.dimensions(), (width, height));
        assert_eq!(written.as_raw(), &pixels, "what is drawn is what is written");
        assert!(pixels.chunks_exact(4).filter(|p| p[3] > 250).count() > 2000);
        // What is wrong leaves what is there.
        (file.path, file.format, file.scale) = (str(&folder), str("tape"), 1.0);
        assert_eq!(mry_run_take_file(c, &file, &mut err), code(MRY_E_INPUT));
        assert!(text(&err.message).contains("dragonbones"));
        (file.format, file.scale) = (str(""), f32::NAN);
        assert_eq!(mry_run_take_file(c, &file, &mut err), code(MRY_E_NON_FINITE));
        (file.scale, file.crop) = (1.0, 3);
        assert_eq!(mry_run_take_file(c, &file, &mut err), code(MRY_E_ARGUMENT));
        assert!(f.folder.path().join("frames/00009.png").exists());
    }
    // A rig alone can be moved, and not drawn.
    let rig = sample("rig.json");
    let mut bare = character_desc();
    bare.rig = str(&rig);
    let bare = make(&f, &bare).unwrap();
    unsafe {
        assert_eq!(mry_poses_read(c, bare, str(&path), &mut poses, &mut err), OK);
        desc.poses = poses;
        let take = play(&f, &desc).unwrap();
        let gif = f.path("bare.gif");
        (file.take, file.path, file.crop) = (take, str(&gif), 0);
        assert_eq!(mry_run_take_file(c, &file, &mut err), code(MRY_E_INPUT));
        assert!(text(&err.message).contains("picture"));
        assert!(!std::path::Path::new(&gif).exists());
    }
}

#[test]
fn jobs_give_characters_and_takes_once_and_a_cancel_gives_none() {
    let f = fixture();
    let (c, mut err) = (f.context, error());
    let (picture, mut desc) = (sample("drawing.png"), character_desc());
    (desc.picture, desc.vertices) = (str(&picture), 150_000);
    let (mut job, mut character) = (mry_job::default(), mry_character { v: 5 });
    unsafe {
        assert_eq!(mry_job_start_character(c, &desc, &mut job, &mut err), OK);
        assert_eq!(mry_job_cancel(c, job, &mut err), OK);
        let ended = mry_job_wait(c, job, u64::MAX, &mut err);
        assert!(ended == code(MRY_CANCELLED) || ended == OK);
        if ended != OK {
            assert_eq!(mry_job_take_character(c, job, &mut character, &mut err), code(MRY_CANCELLED));
            assert_eq!(character.v, 5);
        }
        desc.vertices = 300;
        assert_eq!(mry_job_start_character(c, &desc, &mut job, &mut err), OK);
        assert_eq!(mry_job_wait(c, job, u64::MAX, &mut err), OK, "{}", text(&err.message));
        let mut motion = mry_motion::default();
        assert_eq!(mry_job_take_motion(c, job, &mut motion, &mut err), code(MRY_E_KIND));
        let mut size = 0;
        assert_eq!(mry_job_get_report(c, job, ptr::null_mut(), 0, &mut size, &mut err), code(MRY_E_KIND));
        assert_eq!(mry_job_take_character(c, job, &mut character, &mut err), OK);
        assert_eq!(mry_job_take_character(c, job, &mut character, &mut err), code(MRY_E_TAKEN));
        assert!(info(&f, character).joint_count > 5);
    }
}
