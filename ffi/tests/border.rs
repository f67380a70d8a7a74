//! Every exported function against a host that gets it wrong: no context, no outputs, dead ids, bad numbers, short
//! buffers, wrong sizes; and against a defect of the library itself.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ffi::c_char;
use std::ptr;

use common::*;
use marey_ffi::mry_status_code::*;
use marey_ffi::*;

/// One of each kind of object.
#[derive(Clone, Copy, Default)]
struct Ids {
    clip: mry_clip,
    rig: mry_rig,
    motion: mry_motion,
    masks: mry_masks,
    creature: mry_creature,
    job: mry_job,
    session: mry_session,
    deformation: mry_deformation,
    character: mry_character,
    poser: mry_poser,
    poses: mry_poses,
    take: mry_take,
    joints: mry_joints,
    control_points: mry_control_points,
    drawing: mry_drawing,
    binding: mry_binding,
    sketch_take: mry_sketch_take,
    crowd: mry_crowd,
    solid: mry_solid,
}

fn ids(f: &Fixture) -> Ids {
    let mut ids = Ids { clip: f.clip(), rig: f.rig(), motion: f.motion(), ..Ids::default() };
    let mut err = error();
    unsafe {
        let status = mry_run_creature(f.context, &f.creature_desc(), &mut ids.creature, &mut err);
        assert_eq!(status, OK, "{}", text(&err.message));
        assert_eq!(mry_creature_get_masks(f.context, ids.creature, &mut ids.masks, &mut err), OK);
        assert_eq!(mry_job_start_track(f.context, &f.track_desc(), &mut ids.job, &mut err), OK);
        ids.session = f.session();
        assert_eq!(mry_deformation_create(f.context, deform(), &mut ids.deformation, &mut err), OK);
        ids.character = f.character();
        assert_eq!(mry_poser_create(f.context, ids.character, str(""), 0, &mut ids.poser, &mut err), OK);
        assert_eq!(mry_poses_create(f.context, ids.character, 24.0, 1, &mut ids.poses, &mut err), OK);
        assert_eq!(mry_poses_set_key(f.context, ids.poses, 0, three(), 3, 0, &mut err), OK);
        let status = mry_run_take(f.context, take(ids), &mut ids.take, &mut err);
        assert_eq!(status, OK, "{}", text(&err.message));
        assert_eq!(mry_joints_from_json(f.context, str(JOINTS), &mut ids.joints, &mut err), OK);
        assert_eq!(mry_drawing_from_svg(f.context, str(SVG), &mut ids.drawing, &mut err), OK);
        assert_eq!(mry_binding_from_json(f.context, str(BIND), &mut ids.binding, &mut err), OK);
        let (mut paths, loose) = (mry_motion::default(), ids.motion);
        assert_eq!(mry_motion_from_paths(f.context, str(PATHS), &mut paths, &mut err), OK);
        ids.motion = paths;
        assert_eq!(mry_crowd_create_herd(f.context, ids.creature, 3, 2, &mut ids.crowd, &mut err), OK);
        let status = mry_run_sketch_take(f.context, sketch_take(ids), &mut ids.sketch_take, &mut err);
        assert_eq!(status, OK, "{}", text(&err.message));
        ids.motion = loose;
        let status = mry_run_print(f.context, print(ids, ""), &mut ids.solid, &mut err);
        assert_eq!(status, OK, "{}", text(&err.message));
        assert_eq!(mry_control_points_from_json(f.context, str(POINTS), &mut ids.control_points, &mut err), OK);
    }
    ids
}

/// Room for every output, or NULL in its place.
struct Outs {
    null: bool,
}

impl Outs {
    fn at<T>(&self) -> *mut T {
        // Never freed: a test's worth of small buffers.
        if self.null {
            ptr::null_mut()
        } else {
            Box::leak(Box::new([const { std::mem::MaybeUninit::<T>::zeroed() }; 4096])).as_mut_ptr().cast()
        }
    }

    fn sized<T>(&self) -> *mut T {
        let at = self.at::<T>();
        if !at.is_null() {
            unsafe { at.cast::<u32>().write(size_of::<T>() as u32) };
        }
        at
    }
}

type Run = fn(*mut mry_context, Ids, &Outs, *mut mry_error, &str) -> mry_status;

/// What a function has beside its context.
#[derive(Clone, Copy, PartialEq)]
enum Has {
    /// An id and outputs.
    IdAndOut,
    /// An id, no output.
    Id,
    /// Outputs, no id.
    Out,
    /// Neither.
    Neither,
}

macro_rules! calls {
    ($($has:ident $name:ident($c:ident, $i:ident, $o:ident, $e:ident, $p:ident) => [$($argument:expr),* $(,)?];)*) => {
        &[$((
            stringify!($name),
            Has::$has,
            // Not every function has ids, outputs or a path.
            |$c: *mut mry_context, $i: Ids, $o: &Outs, $e: *mut mry_error, $p: &str| -> mry_status {
                let _ = ($i, $o, $p);
                unsafe { $name($c, $($argument,)* $e) }
            },
        )),*]
    };
}

fn point() -> *const mry_point {
    const POINTS: [mry_point; 2] = [mry_point { x: 5.0, y: 5.0 }, mry_point { x: 50.0, y: 40.0 }];
    POINTS.as_ptr()
}

fn pen() -> *const mry_pen_sample {
    const SAMPLES: [mry_pen_sample; 2] =
        [mry_pen_sample { x: 5.0, y: 5.0, pressure: 0.5 }, mry_pen_sample { x: 50.0, y: 30.0, pressure: 1.0 }];
    SAMPLES.as_ptr()
}

fn track(i: Ids) -> *const mry_track_desc {
    let mut desc = zeroed_track();
    (desc.clip, desc.rig) = (i.clip, i.rig);
    Box::leak(Box::new(desc))
}

const PATHS: &str = r#"{"format":"marey-paths","version":1,"size":[60,40],"fps":4,"seconds":0.5,"points":[
    {"name":"hip","path":"M5 20 V30"},{"name":"knee","path":"M55 20 V10"},{"name":"toe","path":"M30 38 H34"}]}"#;

const BIND: &str = r#"{"format":"marey-bind","version":1,"size":[60,40],"motions":[{"name":"walk"}],
    "points":[{"track":"hip","at":[5,20]},{"track":"knee","at":[55,20]},{"track":"toe","at":[30,38],"layer":"leg"}],
    "pins":[{"at":[30,20],"layer":"body"}],"strokes":[{"stroke":"a","rigidity":2}],
    "layers":[{"name":"body","strokes":["a"]},{"name":"leg","strokes":["b"]}],
    "joints":[{"layers":["body","leg"],"at":[30,20]}]}"#;

const AT: mry_point = mry_point { x: 20.0, y: 20.0 };

fn motion_use() -> *const mry_motion_use {
    let mut used = unsafe { std::mem::zeroed::<mry_motion_use>() };
    unsafe { mry_motion_use_init(&mut used, size_of::<mry_motion_use>() as u32) };
    used.scale = 1.0;
    Box::leak(Box::new(used))
}

fn point_track(i: Ids) -> *const mry_point_track_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_point_track_desc>() };
    unsafe { mry_point_track_desc_init(&mut desc, size_of::<mry_point_track_desc>() as u32) };
    (desc.clip, desc.points) = (i.clip, i.control_points);
    Box::leak(Box::new(desc))
}

fn bind(i: Ids) -> *const mry_bind_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_bind_desc>() };
    unsafe { mry_bind_desc_init(&mut desc, size_of::<mry_bind_desc>() as u32) };
    (desc.drawing, desc.motion) = (i.drawing, i.motion);
    Box::leak(Box::new(desc))
}

fn sketch_take(i: Ids) -> *const mry_sketch_take_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_sketch_take_desc>() };
    unsafe { mry_sketch_take_desc_init(&mut desc, size_of::<mry_sketch_take_desc>() as u32) };
    (desc.drawing, desc.binding) = (i.drawing, i.binding);
    (desc.motions, desc.motion_count) = (Box::leak(Box::new(i.motion)), 1);
    Box::leak(Box::new(desc))
}

fn sketch_file(i: Ids, path: &str) -> *const mry_sketch_file_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_sketch_file_desc>() };
    unsafe { mry_sketch_file_desc_init(&mut desc, size_of::<mry_sketch_file_desc>() as u32) };
    (desc.take, desc.path, desc.format) = (i.sketch_take, str(path), str("svg"));
    Box::leak(Box::new(desc))
}

const SVG: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" width="60" height="40"><path id="a" d="M5 20 C20 5 40 35 55 20"
    fill="none" stroke="#000" stroke-width="4"/><path id="b" d="M30 20 V38" stroke="#c00"/></svg>"##;

const POINTS: &str = r#"{"format":"marey-points","version":1,"size":[96,64],
    "points":[{"name":"hip","keys":[{"frame":0,"at":[24,24]},{"frame":1,"at":[25,24]}]}]}"#;

const JOINTS: &str = r#"{"format":"marey-joints","version":1,"size":[96,64],
    "joints":[{"name":"hip","frame":0,"rect":[20,20,8,8]},{"name":"knee","frame":0,"rect":[20,40,8,8]},
    {"name":"hip","frame":1,"rect":[21,20,8,8]}],"bones":[["hip","knee"]]}"#;

fn capture(i: Ids) -> *const mry_capture_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_capture_desc>() };
    unsafe { mry_capture_desc_init(&mut desc, size_of::<mry_capture_desc>() as u32) };
    (desc.clip, desc.joints) = (i.clip, i.joints);
    Box::leak(Box::new(desc))
}

/// Two triangles held at three corners.
fn deform() -> *const mry_deform_desc {
    const POINTS: [mry_point; 4] = [
        mry_point { x: 0.0, y: 0.0 },
        mry_point { x: 9.0, y: 0.0 },
        mry_point { x: 9.0, y: 9.0 },
        mry_point { x: 0.0, y: 9.0 },
    ];
    const TRIANGLES: [u32; 6] = [0, 1, 2, 0, 2, 3];
    let mut desc = unsafe { std::mem::zeroed::<mry_deform_desc>() };
    unsafe { mry_deform_desc_init(&mut desc, size_of::<mry_deform_desc>() as u32) };
    (desc.points, desc.point_count) = (POINTS.as_ptr(), 4);
    (desc.triangles, desc.triangle_count) = (TRIANGLES.as_ptr(), 2);
    (desc.handles, desc.handle_count) = (held(), 3);
    Box::leak(Box::new(desc))
}

fn held() -> *const mry_handle {
    const fn point(x: f32, y: f32) -> mry_handle {
        let at = mry_point { x, y };
        mry_handle { kind: MRY_HANDLE_POINT, reserved0: 0, a: at, b: at }
    }
    const HANDLES: [mry_handle; 3] = [point(0.0, 0.0), point(9.0, 0.0), point(9.0, 9.0)];
    HANDLES.as_ptr()
}

/// Places for the joints of the small character.
fn three() -> *const mry_point {
    const PLACES: [mry_point; 3] =
        [mry_point { x: 10.0, y: 10.0 }, mry_point { x: 20.0, y: 10.0 }, mry_point { x: 30.0, y: 12.0 }];
    PLACES.as_ptr()
}

fn character(path: &str) -> *const mry_character_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_character_desc>() };
    unsafe { mry_character_desc_init(&mut desc, size_of::<mry_character_desc>() as u32) };
    desc.picture = str(path);
    Box::leak(Box::new(desc))
}

fn take(i: Ids) -> *const mry_take_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_take_desc>() };
    unsafe { mry_take_desc_init(&mut desc, size_of::<mry_take_desc>() as u32) };
    // Garbage has no poses either, and is told by what comes first.
    desc.poses = i.poses;
    Box::leak(Box::new(desc))
}

fn take_file(i: Ids, path: &str) -> *const mry_take_file_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_take_file_desc>() };
    unsafe { mry_take_file_desc_init(&mut desc, size_of::<mry_take_file_desc>() as u32) };
    (desc.take, desc.path, desc.format) = (i.take, str(path), str("gif"));
    Box::leak(Box::new(desc))
}

fn texture(i: Ids, path: &str) -> *const mry_texture_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_texture_desc>() };
    unsafe { mry_texture_desc_init(&mut desc, size_of::<mry_texture_desc>() as u32) };
    (desc.creature, desc.from, desc.picture) = (i.creature, MRY_TEXTURE_SIDE, str(path));
    Box::leak(Box::new(desc))
}

fn edit(i: Ids, path: &str) -> *const mry_edit_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_edit_desc>() };
    unsafe { mry_edit_desc_init(&mut desc, size_of::<mry_edit_desc>() as u32) };
    (desc.creature, desc.path) = (i.creature, str(path));
    Box::leak(Box::new(desc))
}

fn render() -> *const mry_render_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_render_desc>() };
    unsafe { mry_render_desc_init(&mut desc, size_of::<mry_render_desc>() as u32) };
    (desc.width, desc.height, desc.adapter) = (64, 48, MRY_ADAPTER_CPU);
    Box::leak(Box::new(desc))
}

fn render_file(i: Ids, path: &str) -> *const mry_render_file_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_render_file_desc>() };
    unsafe { mry_render_file_desc_init(&mut desc, size_of::<mry_render_file_desc>() as u32) };
    (desc.creature, desc.path, desc.format, desc.picture) = (i.creature, str(path), str("gif"), render());
    Box::leak(Box::new(desc))
}

fn segment(i: Ids) -> *const mry_segment_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_segment_desc>() };
    unsafe { mry_segment_desc_init(&mut desc, size_of::<mry_segment_desc>() as u32) };
    (desc.clip, desc.rig, desc.motion) = (i.clip, i.rig, i.motion);
    Box::leak(Box::new(desc))
}

fn creature(i: Ids) -> *const mry_creature_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_creature_desc>() };
    unsafe { mry_creature_desc_init(&mut desc, size_of::<mry_creature_desc>() as u32) };
    (desc.clip, desc.rig) = (i.clip, i.rig);
    Box::leak(Box::new(desc))
}

fn plugins(path: &str) -> *const mry_plugins_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_plugins_desc>() };
    unsafe { mry_plugins_desc_init(&mut desc, size_of::<mry_plugins_desc>() as u32) };
    desc.cache = str(path);
    Box::leak(Box::new(desc))
}

fn export(i: Ids, path: &str) -> *const mry_export_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_export_desc>() };
    unsafe { mry_export_desc_init(&mut desc, size_of::<mry_export_desc>() as u32) };
    // The path lives as long as the test's call.
    (desc.what, desc.creature, desc.path) = (MRY_EXPORT_GLB, i.creature, str(path));
    Box::leak(Box::new(desc))
}

fn print(i: Ids, path: &str) -> *const mry_print_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_print_desc>() };
    unsafe { mry_print_desc_init(&mut desc, size_of::<mry_print_desc>() as u32) };
    // Coarse, and so quick.
    (desc.creature, desc.size, desc.detail, desc.min_thickness) = (i.creature, 20.0, 1.0, -1.0);
    if !path.is_empty() {
        desc.path = str(path);
    }
    Box::leak(Box::new(desc))
}

/// Every function that takes a context and an error, called as a careful host would.
const CALLS: &[(&str, Has, Run)] = calls! {
    Out mry_context_get_threads(c, i, o, e, p) => [o.at()];
    Out mry_clip_open(c, i, o, e, p) => [str(p), ptr::null(), o.at()];
    IdAndOut mry_clip_get_info(c, i, o, e, p) => [i.clip, o.sized()];
    IdAndOut mry_clip_get_time(c, i, o, e, p) => [i.clip, 1, o.at()];
    IdAndOut mry_clip_get_warning(c, i, o, e, p) => [i.clip, 0, o.at(), 4096, o.at()];
    IdAndOut mry_clip_read_frame(c, i, o, e, p) => [i.clip, 0, o.at::<[u8; 8]>().cast(), 4096 * 8, 0];
    IdAndOut mry_clip_read_alpha(c, i, o, e, p) => [i.clip, 0, o.at::<[u8; 8]>().cast(), 4096 * 8, 0];
    Out mry_rig_create(c, i, o, e, p) => [9, 9, o.at()];
    Out mry_rig_read(c, i, o, e, p) => [str(p), o.at()];
    Out mry_rig_from_json(c, i, o, e, p) => [str(STROKES), o.at()];
    Id mry_rig_write(c, i, o, e, p) => [i.rig, str(p)];
    IdAndOut mry_rig_to_json(c, i, o, e, p) => [i.rig, o.at(), 4096, o.at()];
    IdAndOut mry_rig_add_limb(c, i, o, e, p) => [i.rig, str("tail"), MRY_SIDE_MID, o.at()];
    IdAndOut mry_rig_get_limb_count(c, i, o, e, p) => [i.rig, o.at()];
    IdAndOut mry_rig_get_limb(c, i, o, e, p) => [i.rig, 0, o.at(), 4096, o.at(), o.at()];
    Id mry_rig_set_stroke(c, i, o, e, p) => [i.rig, 0, 2, point(), 2, MRY_FACING_TOWARD];
    Id mry_rig_set_depth(c, i, o, e, p) => [i.rig, 0, 2, MRY_SAID_DEPTH, 3.0, 0.0];
    IdAndOut mry_rig_get_depth(c, i, o, e, p) => [i.rig, 0, 2, o.at(), o.at(), o.at()];
    Id mry_rig_remove_stroke(c, i, o, e, p) => [i.rig, 0, 2];
    IdAndOut mry_rig_get_stroke(c, i, o, e, p) => [i.rig, 0, 0, o.at(), 4096, o.at(), o.at()];
    IdAndOut mry_rig_get_keyframes(c, i, o, e, p) => [i.rig, o.at(), 4096, o.at()];
    Id mry_rig_add_paint(c, i, o, e, p) => [i.rig, 0, MRY_PAINT_FOREGROUND, 2.0, point(), 2];
    Id mry_rig_clear_paint(c, i, o, e, p) => [i.rig, 0];
    Id mry_rig_set_mask(c, i, o, e, p) => [i.rig, 3, str("")];
    IdAndOut mry_rig_paint_mask(c, i, o, e, p) => [i.rig, 3, o.at::<[u8; 2]>().cast(), 96 * 64, 0, str(p)];
    IdAndOut mry_rig_get_length_hint(c, i, o, e, p) => [i.rig, 0, o.at()];
    Id mry_rig_validate(c, i, o, e, p) => [i.rig, i.clip];
    Out mry_joints_create(c, i, o, e, p) => [9, 9, o.at()];
    Out mry_joints_read(c, i, o, e, p) => [str(p), o.at()];
    Out mry_joints_from_json(c, i, o, e, p) => [str(JOINTS), o.at()];
    Id mry_joints_write(c, i, o, e, p) => [i.joints, str(p)];
    IdAndOut mry_joints_to_json(c, i, o, e, p) => [i.joints, o.at(), 4096, o.at()];
    Id mry_joints_mark(c, i, o, e, p) => [i.joints, str("foot"), 0, 20.0, 50.0, 8.0, 8.0];
    Id mry_joints_unmark(c, i, o, e, p) => [i.joints, str("hip"), 1];
    Id mry_joints_add_bone(c, i, o, e, p) => [i.joints, str("knee"), str("foot")];
    Id mry_joints_validate(c, i, o, e, p) => [i.joints, i.clip];
    Out mry_motion_from_paths(c, i, o, e, p) => [str(PATHS), o.at()];
    IdAndOut mry_job_start_propose_points(c, i, o, e, p) => [i.clip, 0, 4, o.at()];
    IdAndOut mry_run_propose_points(c, i, o, e, p) => [i.clip, 0, 4, o.at()];
    IdAndOut mry_job_take_control_points(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_job_start_point_track(c, i, o, e, p) => [point_track(i), o.at()];
    IdAndOut mry_run_point_track(c, i, o, e, p) => [point_track(i), o.at()];
    IdAndOut mry_binding_create(c, i, o, e, p) => [i.drawing, o.at()];
    Out mry_binding_read(c, i, o, e, p) => [str(p), o.at()];
    Out mry_binding_from_json(c, i, o, e, p) => [str(BIND), o.at()];
    IdAndOut mry_binding_to_json(c, i, o, e, p) => [i.binding, o.at(), 4096, o.at()];
    Id mry_binding_write(c, i, o, e, p) => [i.binding, str(p)];
    Id mry_binding_validate(c, i, o, e, p) => [i.binding, i.drawing];
    IdAndOut mry_binding_get_info(c, i, o, e, p) => [i.binding, o.sized::<mry_binding_info>()];
    Id mry_binding_set_motion(c, i, o, e, p) => [i.binding, str("other"), motion_use()];
    IdAndOut mry_binding_get_motion(c, i, o, e, p) => [i.binding, 0, o.at(), 4096, o.at(), ptr::null_mut()];
    Id mry_binding_set_point(c, i, o, e, p) => [i.binding, str(""), str("foot"), 0, AT, str("")];
    Id mry_binding_remove_point(c, i, o, e, p) => [i.binding, str(""), str("hip"), 0];
    IdAndOut mry_binding_get_point(c, i, o, e, p) => [i.binding, 0, o.at(), 4096, o.at(), o.at(), o.at()];
    Id mry_binding_add_pin(c, i, o, e, p) => [i.binding, AT, str("")];
    Id mry_binding_remove_pin(c, i, o, e, p) => [i.binding, 0];
    IdAndOut mry_binding_get_pin(c, i, o, e, p) => [i.binding, 0, o.at()];
    Id mry_binding_set_stroke(c, i, o, e, p) => [i.binding, str("a"), 3.0, 0];
    IdAndOut mry_binding_get_stroke(c, i, o, e, p) => [i.binding, str("a"), o.at(), o.at()];
    Id mry_binding_paint_layer(c, i, o, e, p) => [i.binding, i.drawing, str("new"), point(), 2, 3.0, ptr::null_mut()];
    Id mry_binding_set_layer(c, i, o, e, p) => [i.binding, i.drawing, str("new"), &str("b"), 1];
    Id mry_binding_write_preview(c, i, o, e, p) => [i.binding, i.drawing, i.motion, mry_clip::default(), str(p)];
    Id mry_binding_remove_layer(c, i, o, e, p) => [i.binding, str("leg")];
    IdAndOut mry_binding_get_layer(c, i, o, e, p) => [i.binding, 0, o.at(), 4096, o.at()];
    Id mry_binding_propose_joints(c, i, o, e, p) => [i.binding, i.drawing];
    Id mry_binding_add_joint(c, i, o, e, p) => [i.binding, str("body"), str("leg"), AT];
    Id mry_binding_set_joint(c, i, o, e, p) => [i.binding, 0, AT];
    Id mry_binding_remove_joint(c, i, o, e, p) => [i.binding, 0];
    IdAndOut mry_binding_get_joint(c, i, o, e, p) => [i.binding, 0, o.at()];
    IdAndOut mry_job_start_bind(c, i, o, e, p) => [bind(i), o.at()];
    IdAndOut mry_run_bind(c, i, o, e, p) => [bind(i), o.at()];
    IdAndOut mry_job_take_binding(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_job_start_sketch_take(c, i, o, e, p) => [sketch_take(i), o.at()];
    IdAndOut mry_run_sketch_take(c, i, o, e, p) => [sketch_take(i), o.at()];
    IdAndOut mry_job_take_sketch_take(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_job_start_print(c, i, o, e, p) => [print(i, ""), o.at()];
    IdAndOut mry_run_print(c, i, o, e, p) => [print(i, ""), o.at()];
    IdAndOut mry_job_take_solid(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_solid_get_info(c, i, o, e, p) => [i.solid, o.sized::<mry_solid_info>()];
    IdAndOut mry_solid_read_vertices(c, i, o, e, p) => [i.solid, ptr::null_mut(), ptr::null_mut(), 0, o.at()];
    IdAndOut mry_solid_read_triangles(c, i, o, e, p) => [i.solid, ptr::null_mut(), 0, o.at()];
    Id mry_solid_write(c, i, o, e, p) => [i.solid, str(p)];
    IdAndOut mry_sketch_take_get_info(c, i, o, e, p) => [i.sketch_take, o.sized::<mry_sketch_take_info>()];
    IdAndOut mry_sketch_take_read_order(c, i, o, e, p) => [i.sketch_take, o.at(), 512, o.at()];
    IdAndOut mry_sketch_take_read_stroke(c, i, o, e, p) => [i.sketch_take, 0, 0, o.at(), 128, o.at()];
    IdAndOut mry_sketch_take_measure(c, i, o, e, p) => [i.sketch_take, 1.0, 0, o.at(), o.at(), ptr::null_mut()];
    IdAndOut mry_sketch_take_draw_frame(c, i, o, e, p) => [i.sketch_take, 0, 0.1, 1, o.at(), 4096, 0];
    IdAndOut mry_job_start_sketch_file(c, i, o, e, p) => [sketch_file(i, p), o.at()];
    Id mry_run_sketch_file(c, i, o, e, p) => [sketch_file(i, p)];
    Out mry_drawing_read_svg(c, i, o, e, p) => [str(p), o.at()];
    Out mry_drawing_from_svg(c, i, o, e, p) => [str(SVG), o.at()];
    Out mry_drawing_create(c, i, o, e, p) => [9.0, 9.0, o.at()];
    Id mry_drawing_add_stroke(c, i, o, e, p) => [i.drawing, str("new"), pen(), 2, 3.0, [0u8, 0, 0, 255].as_ptr()];
    Id mry_drawing_remove_stroke(c, i, o, e, p) => [i.drawing, str("b")];
    IdAndOut mry_drawing_get_info(c, i, o, e, p) => [i.drawing, o.sized::<mry_drawing_info>()];
    IdAndOut mry_drawing_get_stroke(c, i, o, e, p) => [i.drawing, 0, o.at(), 4096, o.at(), ptr::null_mut()];
    IdAndOut mry_drawing_get_left_out(c, i, o, e, p) => [i.drawing, 0, o.at(), 4096, o.at()];
    IdAndOut mry_drawing_read_outline(c, i, o, e, p) => [i.drawing, o.at(), 512, o.at()];
    IdAndOut mry_drawing_to_svg(c, i, o, e, p) => [i.drawing, o.at(), 4096, o.at()];
    Id mry_drawing_write_svg(c, i, o, e, p) => [i.drawing, str(p)];
    Out mry_control_points_create(c, i, o, e, p) => [9, 9, o.at()];
    Out mry_control_points_read(c, i, o, e, p) => [str(p), o.at()];
    Out mry_control_points_from_json(c, i, o, e, p) => [str(POINTS), o.at()];
    Id mry_control_points_write(c, i, o, e, p) => [i.control_points, str(p)];
    IdAndOut mry_control_points_to_json(c, i, o, e, p) => [i.control_points, o.at(), 4096, o.at()];
    Id mry_control_points_mark(c, i, o, e, p) => [i.control_points, str("foot"), 0, mry_point { x: 24.0, y: 50.0 }];
    Id mry_control_points_unmark(c, i, o, e, p) => [i.control_points, str("hip"), 1];
    Id mry_control_points_validate(c, i, o, e, p) => [i.control_points, i.clip];
    IdAndOut mry_motion_get_point_report(c, i, o, e, p) => [i.motion, i.control_points, o.at(), 8192, o.at()];
    IdAndOut mry_motion_get_capture_report(c, i, o, e, p) => [i.motion, i.clip, i.joints, o.at(), 8192, o.at()];
    IdAndOut mry_job_start_capture(c, i, o, e, p) => [capture(i), o.at()];
    IdAndOut mry_run_capture(c, i, o, e, p) => [capture(i), o.at()];
    Out mry_motion_read(c, i, o, e, p) => [str(p), o.at()];
    Out mry_motion_from_json(c, i, o, e, p) => [str("{}"), o.at()];
    Id mry_motion_write(c, i, o, e, p) => [i.motion, str(p)];
    IdAndOut mry_motion_to_json(c, i, o, e, p) => [i.motion, o.at(), 4096, o.at()];
    IdAndOut mry_motion_get_info(c, i, o, e, p) => [i.motion, o.sized()];
    IdAndOut mry_motion_get_track(c, i, o, e, p) => [i.motion, 0, o.at(), 4096, o.at(), o.at(), o.at()];
    IdAndOut mry_motion_find_track(c, i, o, e, p) => [i.motion, str("body"), o.at()];
    IdAndOut mry_motion_read_frame(c, i, o, e, p) => [i.motion, 0, 0, o.at(), o.at(), o.at(), 4096, o.at()];
    IdAndOut mry_motion_get_bone(c, i, o, e, p) => [i.motion, 0, o.at(), o.at()];
    Out mry_motion_create(c, i, o, e, p) => [64, 48, 9, 24.0, o.at()];
    IdAndOut mry_motion_copy(c, i, o, e, p) => [i.motion, o.at()];
    IdAndOut mry_motion_add_track(c, i, o, e, p) => [i.motion, str("tail"), MRY_TRACK_POINT, 1, o.at()];
    Id mry_motion_set_frame(c, i, o, e, p) => [i.motion, 0, 0, point(), ptr::null(), ptr::null(), 2];
    Id mry_motion_add_bone(c, i, o, e, p) => [i.motion, 0, 1];
    Id mry_motion_remove_bone(c, i, o, e, p) => [i.motion, 0];
    Id mry_motion_remove_track(c, i, o, e, p) => [i.motion, 1];
    IdAndOut mry_motion_get_correction(c, i, o, e, p) => [i.motion, i.rig, 0, o.sized()];
    IdAndOut mry_motion_get_report(c, i, o, e, p) => [i.motion, i.clip, i.rig, o.at(), 4096, o.at()];
    IdAndOut mry_masks_get_info(c, i, o, e, p) => [i.masks, o.sized()];
    IdAndOut mry_masks_read(c, i, o, e, p) => [i.masks, 0, o.at::<[u8; 8]>().cast(), 4096 * 8, 0];
    Id mry_masks_write_folder(c, i, o, e, p) => [i.masks, str(p)];
    IdAndOut mry_masks_get_report(c, i, o, e, p) => [i.masks, o.at(), 4096, o.at()];
    IdAndOut mry_creature_get_info(c, i, o, e, p) => [i.creature, o.sized()];
    IdAndOut mry_creature_get_motion(c, i, o, e, p) => [i.creature, o.at()];
    IdAndOut mry_creature_get_masks(c, i, o, e, p) => [i.creature, o.at()];
    IdAndOut mry_creature_get_report(c, i, o, e, p) => [i.creature, o.at(), 4096, o.at()];
    IdAndOut mry_creature_get_bone(c, i, o, e, p) => [i.creature, 0, o.at(), 4096, o.at(), o.at()];
    IdAndOut mry_creature_read_pose(c, i, o, e, p) => [i.creature, 0, o.at(), 4096, o.at()];
    IdAndOut mry_creature_get_part(c, i, o, e, p) => [i.creature, 0, o.at(), 4096, o.at(), o.sized()];
    IdAndOut mry_creature_read_vertices(c, i, o, e, p) =>
        [i.creature, 0, 1, o.at::<[f32; 3]>().cast(), o.at::<[f32; 3]>().cast(), o.at::<[f32; 3]>().cast(), 4096, o.at()];
    IdAndOut mry_creature_read_triangles(c, i, o, e, p) => [i.creature, 0, o.at::<[u32; 3]>().cast(), 4096, o.at()];
    IdAndOut mry_creature_read_weights(c, i, o, e, p) =>
        [i.creature, 0, o.at::<[u16; 4]>().cast(), o.at::<[f32; 4]>().cast(), 4096, o.at()];
    IdAndOut mry_creature_read_texture(c, i, o, e, p) =>
        [i.creature, 0, o.at::<[u8; 1024]>().cast(), 4096 * 1024, 0];
    Out mry_deformation_create(c, i, o, e, p) => [deform(), o.at()];
    IdAndOut mry_deformation_solve(c, i, o, e, p) => [i.deformation, held(), 3, ptr::null(), o.at(), 4];
    Out mry_job_start_character(c, i, o, e, p) => [character(p), o.at()];
    Out mry_run_character(c, i, o, e, p) => [character(p), o.at()];
    IdAndOut mry_job_take_character(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_character_copy(c, i, o, e, p) => [i.character, o.at()];
    IdAndOut mry_character_get_info(c, i, o, e, p) => [i.character, o.sized()];
    IdAndOut mry_character_read_vertices(c, i, o, e, p) =>
        [i.character, o.at(), o.at(), o.at::<u32>().cast(), 4096, o.at()];
    IdAndOut mry_character_read_triangles(c, i, o, e, p) => [i.character, o.at::<[u32; 3]>().cast(), 4096, o.at()];
    IdAndOut mry_character_to_json(c, i, o, e, p) => [i.character, o.at::<[u8; 64]>().cast(), 4096 * 64, o.at()];
    Id mry_character_write(c, i, o, e, p) => [i.character, str(p)];
    Id mry_character_write_preview(c, i, o, e, p) => [i.character, str(p)];
    IdAndOut mry_character_get_joint(c, i, o, e, p) => [i.character, 0, o.at(), 4096, o.at(), o.at()];
    IdAndOut mry_character_find_joint(c, i, o, e, p) => [i.character, str("a"), o.at()];
    IdAndOut mry_character_get_bone(c, i, o, e, p) => [i.character, 0, o.at(), o.at()];
    Id mry_character_set_joints(c, i, o, e, p) => [i.character, three(), 3];
    Id mry_character_rename_joint(c, i, o, e, p) => [i.character, 0, str("hip")];
    IdAndOut mry_character_add_joint(c, i, o, e, p) =>
        [i.character, str("d"), mry_point { x: 1.0, y: 2.0 }, 0, o.at()];
    IdAndOut mry_character_split_bone(c, i, o, e, p) =>
        [i.character, str("e"), mry_point { x: 1.0, y: 2.0 }, 0, o.at()];
    Id mry_character_remove_joint(c, i, o, e, p) => [i.character, 0];
    IdAndOut mry_character_on_curve(c, i, o, e, p) => [i.character, mry_point { x: 1.0, y: 2.0 }, o.at()];
    IdAndOut mry_poser_create(c, i, o, e, p) => [i.character, str(""), 0, o.at()];
    IdAndOut mry_poser_pose(c, i, o, e, p) => [i.poser, three(), 3, o.at(), 4096];
    IdAndOut mry_poser_drag(c, i, o, e, p) => [i.poser, three(), 3, o.at(), 4096];
    IdAndOut mry_character_sketch(c, i, o, e, p) =>
        [i.character, ptr::null(), 3, three(), [3].as_ptr(), 1, o.at()];
    IdAndOut mry_poser_redraw(c, i, o, e, p) =>
        [i.poser, three(), 3, three(), 3, three(), 3, o.at(), o.at(), 4096, o.at()];
    IdAndOut mry_character_read_overlaps(c, i, o, e, p) =>
        [i.character, three(), 3, ptr::null(), 0, o.at(), 4096, o.at()];
    IdAndOut mry_character_bring_forward(c, i, o, e, p) =>
        [i.character, three(), 3, o.at(), 2, mry_point { x: 1.0, y: 2.0 }, o.at()];
    IdAndOut mry_poses_create(c, i, o, e, p) => [i.character, 24.0, 1, o.at()];
    IdAndOut mry_poses_read(c, i, o, e, p) => [i.character, str(p), o.at()];
    IdAndOut mry_poses_from_json(c, i, o, e, p) => [i.character, str("{}"), o.at()];
    IdAndOut mry_poses_to_json(c, i, o, e, p) => [i.poses, o.at(), 4096, o.at()];
    Id mry_poses_write(c, i, o, e, p) => [i.poses, str(p)];
    IdAndOut mry_poses_get_info(c, i, o, e, p) => [i.poses, o.sized()];
    Id mry_poses_set_rate(c, i, o, e, p) => [i.poses, 12.0, 2];
    Id mry_poses_set_key(c, i, o, e, p) => [i.poses, 3, three(), 3, MRY_EASING_IN];
    Id mry_poses_remove_key(c, i, o, e, p) => [i.poses, 3];
    IdAndOut mry_poses_get_key(c, i, o, e, p) => [i.poses, 0, o.at(), o.at(), o.at(), 4096, o.at()];
    Id mry_poses_set_moved(c, i, o, e, p) => [i.poses, 0, [0].as_ptr(), point(), 1];
    IdAndOut mry_poses_get_moved(c, i, o, e, p) => [i.poses, 0, o.at(), o.at(), 4096, o.at()];
    Id mry_poses_set_depth(c, i, o, e, p) => [i.poses, 0, 0, 1];
    IdAndOut mry_motion_retarget(c, i, o, e, p) => [i.motion, i.character, ptr::null(), o.at()];
    IdAndOut mry_motion_match(c, i, o, e, p) => [i.motion, i.character, ptr::null(), o.at(), 4096, o.at()];
    IdAndOut mry_motion_find_cycle(c, i, o, e, p) => [i.motion, o.sized()];
    IdAndOut mry_motion_read_phases(c, i, o, e, p) => [i.motion, o.at(), o.at(), 4096, o.at()];
    IdAndOut mry_motion_loop(c, i, o, e, p) => [i.motion, ptr::null(), o.at(), ptr::null_mut()];
    IdAndOut mry_motion_smooth(c, i, o, e, p) => [i.motion, ptr::null(), o.at()];
    IdAndOut mry_motion_plant(c, i, o, e, p) => [i.motion, ptr::null(), o.at()];
    IdAndOut mry_motion_get_contacts(c, i, o, e, p) => [i.motion, ptr::null(), o.at(), 4096, o.at()];
    IdAndOut mry_motion_retime(c, i, o, e, p) => [i.motion, ptr::null(), o.at()];
    IdAndOut mry_creature_retime(c, i, o, e, p) => [i.creature, ptr::null(), o.at()];
    IdAndOut mry_take_retime(c, i, o, e, p) => [i.take, ptr::null(), o.at()];
    IdAndOut mry_sketch_take_retime(c, i, o, e, p) => [i.sketch_take, ptr::null(), o.at()];
    Out mry_retime_read_places(c, i, o, e, p) => [3, 24.0, ptr::null(), o.at(), 4096, o.at()];
    IdAndOut mry_motion_map_limbs(c, i, o, e, p) => [i.motion, i.motion, ptr::null(), o.at()];
    IdAndOut mry_motion_match_limbs(c, i, o, e, p) => [i.motion, i.motion, ptr::null(), o.at(), 4096, o.at()];
    Out mry_motion_read_bvh(c, i, o, e, p) => [str(p), 0, 0, o.at()];
    Id mry_motion_write_bvh(c, i, o, e, p) => [i.motion, str(p)];
    IdAndOut mry_job_start_take(c, i, o, e, p) => [take(i), o.at()];
    IdAndOut mry_run_take(c, i, o, e, p) => [take(i), o.at()];
    IdAndOut mry_job_take_take(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_take_get_info(c, i, o, e, p) => [i.take, o.sized()];
    IdAndOut mry_take_read_points(c, i, o, e, p) => [i.take, 0, o.at(), 4096, o.at()];
    IdAndOut mry_take_read_joints(c, i, o, e, p) => [i.take, 0, o.at(), 4096, o.at()];
    IdAndOut mry_take_read_depths(c, i, o, e, p) => [i.take, 0, o.at(), 4096, o.at()];
    IdAndOut mry_take_measure(c, i, o, e, p) => [i.take, 0.0, 0, o.at(), o.at(), o.at()];
    IdAndOut mry_take_draw_frame(c, i, o, e, p) => [i.take, 0, 0.0, 0, o.at::<[u8; 8]>().cast(), 4096 * 8, 0];
    IdAndOut mry_take_get_report(c, i, o, e, p) => [i.take, o.at(), 4096, o.at()];
    IdAndOut mry_job_start_take_file(c, i, o, e, p) => [take_file(i, p), o.at()];
    Id mry_run_take_file(c, i, o, e, p) => [take_file(i, p)];
    IdAndOut mry_job_get_report(c, i, o, e, p) => [i.job, o.at(), 4096, o.at()];
    IdAndOut mry_clip_map_frame(c, i, o, e, p) => [i.clip, 0, o.sized()];
    IdAndOut mry_creature_map_part(c, i, o, e, p) => [i.creature, 0, 1, o.sized()];
    IdAndOut mry_creature_map_texture(c, i, o, e, p) => [i.creature, 0, o.sized()];
    Out mry_creature_open(c, i, o, e, p) => [str(p), o.at()];
    IdAndOut mry_creature_get_limb(c, i, o, e, p) => [i.creature, 0, o.at(), 4096, o.at(), o.sized()];
    Id mry_creature_write_textures(c, i, o, e, p) => [i.creature, str(p)];
    IdAndOut mry_creature_read_textures(c, i, o, e, p) => [i.creature, str(p), o.at()];
    IdAndOut mry_job_start_texture(c, i, o, e, p) => [texture(i, p), o.at()];
    IdAndOut mry_run_texture(c, i, o, e, p) => [texture(i, p), o.at()];
    IdAndOut mry_job_start_edit(c, i, o, e, p) => [edit(i, p), o.at()];
    IdAndOut mry_run_edit(c, i, o, e, p) => [edit(i, p), o.at()];
    IdAndOut mry_crowd_create(c, i, o, e, p) => [&mry_instance { creature: i.creature, ..Default::default() }, 1, 2, 12.0, o.at()];
    IdAndOut mry_crowd_create_herd(c, i, o, e, p) => [i.creature, 2, 2, o.at()];
    Out mry_crowd_read(c, i, o, e, p) => [str(p), o.at()];
    IdAndOut mry_crowd_get_info(c, i, o, e, p) => [i.crowd, o.sized()];
    Id mry_crowd_write_glb(c, i, o, e, p) => [i.crowd, str(p), 0.0];
    Out mry_context_get_renderer(c, i, o, e, p) => [MRY_ADAPTER_CPU, o.at(), 4096, o.at()];
    IdAndOut mry_creature_render(c, i, o, e, p) =>
        [i.creature, render(), o.at::<[u8; 32]>().cast(), 4096 * 32, o.at()];
    IdAndOut mry_job_start_render(c, i, o, e, p) => [render_file(i, p), o.at()];
    Id mry_run_render(c, i, o, e, p) => [render_file(i, p)];
    IdAndOut mry_creature_pose(c, i, o, e, p) => [i.creature, ptr::null(), 0, ptr::null(), o.at(), 4096, o.at()];
    IdAndOut mry_creature_repose(c, i, o, e, p) => [i.creature, str("{}"), ptr::null(), o.at()];
    IdAndOut mry_creature_drive(c, i, o, e, p) => [i.creature, i.motion, str(""), ptr::null(), o.at()];
    IdAndOut mry_creature_match(c, i, o, e, p) => [i.creature, i.motion, str(""), o.at(), 4096, o.at()];
    IdAndOut mry_creature_get_strain(c, i, o, e, p) => [i.creature, o.at(), 4096, o.at()];
    Id mry_creature_write_glb(c, i, o, e, p) => [i.creature, str(p), 0.0];
    Id mry_creature_write_folder(c, i, o, e, p) => [i.creature, str(p), 0, 0.0];
    Id mry_creature_write_obj(c, i, o, e, p) => [i.creature, str(p)];
    Out mry_job_start_open(c, i, o, e, p) => [str(p), ptr::null(), o.at()];
    IdAndOut mry_job_start_export(c, i, o, e, p) => [export(i, p), o.at()];
    Id mry_run_export(c, i, o, e, p) => [export(i, p)];
    IdAndOut mry_job_take_clip(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_job_start_track(c, i, o, e, p) => [track(i), o.at()];
    IdAndOut mry_job_start_segment(c, i, o, e, p) => [segment(i), o.at()];
    IdAndOut mry_job_start_creature(c, i, o, e, p) => [creature(i), o.at()];
    IdAndOut mry_job_poll(c, i, o, e, p) => [i.job, o.sized()];
    Id mry_job_wait(c, i, o, e, p) => [i.job, u64::MAX];
    Id mry_job_cancel(c, i, o, e, p) => [i.job];
    IdAndOut mry_job_take_motion(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_job_take_masks(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_job_take_creature(c, i, o, e, p) => [i.job, o.at()];
    IdAndOut mry_run_track(c, i, o, e, p) => [track(i), o.at()];
    IdAndOut mry_run_segment(c, i, o, e, p) => [segment(i), o.at()];
    IdAndOut mry_run_creature(c, i, o, e, p) => [creature(i), o.at()];
    Out mry_session_create(c, i, o, e, p) => [str(p), o.at()];
    Out mry_session_create_untitled(c, i, o, e, p) => [str(p), o.at()];
    Out mry_session_find_left(c, i, o, e, p) => [str(p), 0, o.at(), 4096, o.at()];
    Out mry_session_open(c, i, o, e, p) => [str(p), MRY_ACCESS_EDIT, o.at()];
    Id mry_session_discard(c, i, o, e, p) => [i.session];
    Id mry_session_save(c, i, o, e, p) => [i.session];
    Id mry_session_save_as(c, i, o, e, p) => [i.session, str(p)];
    IdAndOut mry_session_get_state(c, i, o, e, p) => [i.session, o.sized()];
    IdAndOut mry_session_get_path(c, i, o, e, p) => [i.session, o.at(), 4096, o.at()];
    IdAndOut mry_session_get_warning(c, i, o, e, p) => [i.session, 0, o.at(), 4096, o.at()];
    Id mry_session_begin_gesture(c, i, o, e, p) => [i.session, str("draw")];
    Id mry_session_end_gesture(c, i, o, e, p) => [i.session];
    Id mry_session_cancel_gesture(c, i, o, e, p) => [i.session];
    Id mry_session_undo(c, i, o, e, p) => [i.session];
    Id mry_session_redo(c, i, o, e, p) => [i.session];
    IdAndOut mry_session_get_undo_label(c, i, o, e, p) => [i.session, o.at(), 4096, o.at()];
    IdAndOut mry_session_get_redo_label(c, i, o, e, p) => [i.session, o.at(), 4096, o.at()];
    Id mry_session_set_clip(c, i, o, e, p) => [i.session, i.clip];
    IdAndOut mry_session_get_clip(c, i, o, e, p) => [i.session, ptr::null(), o.at()];
    Id mry_session_set_rig(c, i, o, e, p) => [i.session, i.rig];
    IdAndOut mry_session_get_rig(c, i, o, e, p) => [i.session, o.at()];
    Id mry_session_set_motion(c, i, o, e, p) => [i.session, i.motion];
    IdAndOut mry_session_get_motion(c, i, o, e, p) => [i.session, o.at()];
    IdAndOut mry_session_add_limb(c, i, o, e, p) => [i.session, str("tail"), MRY_SIDE_MID, o.at()];
    Id mry_session_remove_limb(c, i, o, e, p) => [i.session, 0];
    Id mry_session_set_limb(c, i, o, e, p) => [i.session, 0, str("trunk"), MRY_SIDE_MID];
    Id mry_session_set_stroke(c, i, o, e, p) => [i.session, 0, 2, point(), 2, MRY_FACING_TOWARD];
    Id mry_session_set_depth(c, i, o, e, p) => [i.session, 0, 2, MRY_SAID_BEND, 0.0, 3.0];
    Id mry_session_remove_stroke(c, i, o, e, p) => [i.session, 0, 2];
    Id mry_session_add_paint(c, i, o, e, p) => [i.session, 0, MRY_PAINT_FOREGROUND, 2.0, point(), 2];
    Id mry_session_remove_paint(c, i, o, e, p) => [i.session, 0, 0];
    Id mry_session_set_mask(c, i, o, e, p) => [i.session, 3, str("")];
    Out mry_parameter_get_info(c, i, o, e, p) => [0, o.sized()];
    Out mry_parameter_get_choice(c, i, o, e, p) => [0, 0, o.at(), 4096, o.at()];
    Id mry_session_set_parameter(c, i, o, e, p) => [i.session, str("creature.smoothing"), 0.1];
    Id mry_session_set_text(c, i, o, e, p) => [i.session, str("track.plugin"), str("org.example.none")];
    IdAndOut mry_session_get_text(c, i, o, e, p) => [i.session, str("track.plugin"), o.at(), 4096, o.at()];
    Id mry_session_reset_parameter(c, i, o, e, p) => [i.session, str("creature.smoothing")];
    IdAndOut mry_session_get_parameter(c, i, o, e, p) => [i.session, str("creature.smoothing"), o.at()];
    IdAndOut mry_session_start_track(c, i, o, e, p) => [i.session, o.at()];
    IdAndOut mry_session_start_creature(c, i, o, e, p) => [i.session, str(""), o.at()];
    Id mry_session_set_part(c, i, o, e, p) => [i.session, MRY_PART_NOTES, b"text".as_ptr(), 4];
    IdAndOut mry_session_get_part(c, i, o, e, p) => [i.session, MRY_PART_NOTES, o.at(), 4096, o.at()];
    Id mry_session_set_embedded(c, i, o, e, p) => [i.session, 1];
    Id mry_session_start_recording(c, i, o, e, p) => [i.session, str(p)];
    Id mry_session_stop_recording(c, i, o, e, p) => [i.session];
    Out mry_session_replay(c, i, o, e, p) => [str(p), u64::MAX, o.at()];
    IdAndOut mry_session_get_fingerprint(c, i, o, e, p) => [i.session, o.at()];
    Id mry_session_take(c, i, o, e, p) => [i.session, i.job];
    Id mry_session_run_track(c, i, o, e, p) => [i.session];
    IdAndOut mry_session_run_creature(c, i, o, e, p) => [i.session, str(""), o.at()];
    IdAndOut mry_session_get_outdated(c, i, o, e, p) => [i.session, 0, o.at(), 4096, o.at()];
    Neither mry_plugins_open(c, i, o, e, p) => [plugins(p)];
    Out mry_plugins_rescan(c, i, o, e, p) => [o.at()];
    Neither mry_plugins_load(c, i, o, e, p) => [str(p)];
    Neither mry_plugins_retry(c, i, o, e, p) => [str(p)];
    Out mry_plugins_check(c, i, o, e, p) => [str(p), o.at(), 4096, o.at()];
    Out mry_plugins_probe(c, i, o, e, p) => [str("load"), str(p), o.at(), 4096, o.at()];
    Out mry_plugin_get_info(c, i, o, e, p) => [0, o.sized()];
    Out mry_plugin_get_about(c, i, o, e, p) => [0, o.at(), 4096, o.at()];
    Out mry_plugin_get_file(c, i, o, e, p) => [0, o.at(), 4096, o.at()];
    Out mry_plugin_get_failure(c, i, o, e, p) => [0, o.at(), o.at(), 4096, o.at()];
    Neither mry_plugin_set_enabled(c, i, o, e, p) => [str("org.none"), 1];
    Out mry_plugin_get_parameter(c, i, o, e, p) => [str("org.none"), 0, o.sized()];
    Out mry_plugin_get_parameter_choice(c, i, o, e, p) => [str("org.none"), 0, 0, o.at(), 4096, o.at()];
    Neither mry_plugin_set_number(c, i, o, e, p) => [str("org.none"), str("x"), 1.0];
    Neither mry_plugin_set_text(c, i, o, e, p) => [str("org.none"), str("x"), str("y")];
    Out mry_plugin_get_number(c, i, o, e, p) => [str("org.none"), str("x"), o.at()];
    Out mry_plugin_get_text(c, i, o, e, p) => [str("org.none"), str("x"), o.at(), 4096, o.at()];
};

/// Functions that destroy, and functions without a context.
const OTHERS: [&str; 85] = [
    "mry_abi_check",
    "mry_allocator_init",
    "mry_bind_desc_init",
    "mry_binding_destroy",
    "mry_binding_info_init",
    "mry_camera_init",
    "mry_capture_desc_init",
    "mry_character_desc_init",
    "mry_character_destroy",
    "mry_character_info_init",
    "mry_clip_close",
    "mry_clip_info_init",
    "mry_clip_options_init",
    "mry_context_create",
    "mry_context_desc_init",
    "mry_context_destroy",
    "mry_control_points_destroy",
    "mry_correction_init",
    "mry_creature_desc_init",
    "mry_creature_destroy",
    "mry_creature_info_init",
    "mry_creature_limb_init",
    "mry_crowd_destroy",
    "mry_crowd_info_init",
    "mry_cycle_init",
    "mry_deform_desc_init",
    "mry_deformation_destroy",
    "mry_drawing_destroy",
    "mry_drawing_info_init",
    "mry_drawing_stroke_init",
    "mry_error_init",
    "mry_executor_init",
    "mry_export_desc_init",
    "mry_image_view_init",
    "mry_job_destroy",
    "mry_job_state_init",
    "mry_joints_destroy",
    "mry_limb_map_desc_init",
    "mry_limits_init",
    "mry_loop_desc_init",
    "mry_masks_destroy",
    "mry_masks_info_init",
    "mry_mesh_view_init",
    "mry_motion_destroy",
    "mry_motion_info_init",
    "mry_motion_use_init",
    "mry_parameter_info_init",
    "mry_part_info_init",
    "mry_plant_desc_init",
    "mry_plugin_info_init",
    "mry_plugin_parameter_info_init",
    "mry_plugins_desc_init",
    "mry_point_track_desc_init",
    "mry_poser_destroy",
    "mry_poses_destroy",
    "mry_poses_info_init",
    "mry_render_desc_init",
    "mry_render_file_desc_init",
    "mry_repose_desc_init",
    "mry_retarget_desc_init",
    "mry_retime_desc_init",
    "mry_print_desc_init",
    "mry_rig_destroy",
    "mry_seam_init",
    "mry_segment_desc_init",
    "mry_session_destroy",
    "mry_session_state_init",
    "mry_sketch_file_desc_init",
    "mry_sketch_take_desc_init",
    "mry_sketch_take_destroy",
    "mry_sketch_take_info_init",
    "mry_smooth_desc_init",
    "mry_solid_destroy",
    "mry_solid_info_init",
    "mry_status_text",
    "mry_take_desc_init",
    "mry_take_destroy",
    "mry_edit_desc_init",
    "mry_texture_desc_init",
    "mry_take_file_desc_init",
    "mry_take_info_init",
    "mry_track_desc_init",
    "mry_unmap",
    "mry_version",
    "mry_version_string",
];

#[test]
fn the_table_of_calls_is_complete() {
    let mut names: Vec<&str> = CALLS.iter().map(|c| c.0).chain(OTHERS).collect();
    names.sort_unstable();
    let exported: Vec<&str> = include_str!("../abi/symbols.txt").lines().collect();
    assert_eq!(names, exported);
}

#[test]
fn without_a_context_every_function_says_so() {
    for (name, _, run) in CALLS {
        let mut err = error();
        let status = run(ptr::null_mut(), Ids::default(), &Outs { null: false }, &mut err, "x");
        assert_eq!((status, text(&err.param).as_str()), (code(MRY_E_NULL), "context"), "{name}");
        assert_eq!(err.status, status, "{name}");
        let small = &mut error();
        small.struct_size = 8;
        let status = run(ptr::null_mut(), Ids::default(), &Outs { null: false }, small, "x");
        assert_eq!(status, code(MRY_E_STRUCT_SIZE), "{name} with an error that is too small");
    }
}

#[test]
fn without_a_place_for_the_answer_every_function_names_it() {
    let f = fixture();
    let ids = ids(&f);
    for (name, has, run) in CALLS.iter().filter(|c| !matches!(c.1, Has::Id | Has::Neither)) {
        let mut err = error();
        let status = run(f.context, ids, &Outs { null: true }, &mut err, "x");
        assert_eq!(status, code(MRY_E_NULL), "{name}: {}", text(&err.message));
        let param = text(&err.param);
        assert!(text(&err.message).contains(&param) && !param.is_empty(), "{name}: {}", text(&err.message));
        assert!(*has != Has::Id);
    }
}

#[test]
fn dead_and_foreign_ids_are_stale_everywhere() {
    let (f, other) = (fixture(), fixture());
    let dead = ids(&f);
    let ids = ids(&other);
    unsafe {
        mry_clip_close(f.context, dead.clip);
        mry_rig_destroy(f.context, dead.rig);
        mry_motion_destroy(f.context, dead.motion);
        mry_masks_destroy(f.context, dead.masks);
        mry_creature_destroy(f.context, dead.creature);
        mry_job_destroy(f.context, dead.job);
        mry_session_destroy(f.context, dead.session);
        mry_deformation_destroy(f.context, dead.deformation);
        mry_character_destroy(f.context, dead.character);
        mry_poser_destroy(f.context, dead.poser);
        mry_poses_destroy(f.context, dead.poses);
        mry_take_destroy(f.context, dead.take);
        mry_control_points_destroy(f.context, dead.control_points);
        mry_drawing_destroy(f.context, dead.drawing);
        mry_binding_destroy(f.context, dead.binding);
        mry_sketch_take_destroy(f.context, dead.sketch_take);
        mry_crowd_destroy(f.context, dead.crowd);
        mry_solid_destroy(f.context, dead.solid);
        mry_joints_destroy(f.context, dead.joints);
    }
    let garbage = Ids {
        clip: mry_clip { v: u64::MAX },
        rig: mry_rig { v: u64::MAX },
        motion: mry_motion { v: u64::MAX },
        masks: mry_masks { v: u64::MAX },
        creature: mry_creature { v: u64::MAX },
        job: mry_job { v: u64::MAX },
        session: mry_session { v: u64::MAX },
        deformation: mry_deformation { v: u64::MAX },
        character: mry_character { v: u64::MAX },
        poser: mry_poser { v: u64::MAX },
        poses: mry_poses { v: u64::MAX },
        take: mry_take { v: u64::MAX },
        control_points: mry_control_points { v: u64::MAX },
        drawing: mry_drawing { v: u64::MAX },
        binding: mry_binding { v: u64::MAX },
        sketch_take: mry_sketch_take { v: u64::MAX },
        crowd: mry_crowd { v: u64::MAX },
        solid: mry_solid { v: u64::MAX },
        joints: mry_joints { v: u64::MAX },
    };
    for (name, _, run) in CALLS.iter().filter(|c| !matches!(c.1, Has::Out | Has::Neither)) {
        for (what, ids) in [("null", Ids::default()), ("dead", dead), ("foreign", ids), ("garbage", garbage)] {
            let mut err = error();
            let status = run(f.context, ids, &Outs { null: false }, &mut err, "x");
            assert_eq!(status, code(MRY_E_STALE), "{name}, {what}: {}", text(&err.message));
            assert!(!text(&err.param).is_empty(), "{name}, {what}");
        }
    }
    assert!(!f.folder.path().join("x").exists() && !std::path::Path::new("x").exists());
}

#[test]
fn destroying_nothing_is_no_error_and_destroying_twice_is_one() {
    let f = fixture();
    let i = ids(&f);
    let c = f.context;
    unsafe {
        assert_eq!(mry_clip_close(c, mry_clip::default()), OK);
        assert_eq!(mry_rig_destroy(c, mry_rig::default()), OK);
        assert_eq!(mry_motion_destroy(c, mry_motion::default()), OK);
        assert_eq!(mry_masks_destroy(c, mry_masks::default()), OK);
        assert_eq!(mry_creature_destroy(c, mry_creature::default()), OK);
        assert_eq!(mry_job_destroy(c, mry_job::default()), OK);
        assert_eq!(mry_control_points_destroy(c, mry_control_points::default()), OK);
        assert_eq!(mry_drawing_destroy(c, mry_drawing::default()), OK);
        assert_eq!(mry_binding_destroy(c, mry_binding::default()), OK);
        assert_eq!(mry_sketch_take_destroy(c, mry_sketch_take::default()), OK);
        assert_eq!(mry_crowd_destroy(c, mry_crowd::default()), OK);
        assert_eq!(mry_solid_destroy(c, mry_solid::default()), OK);
        assert_eq!(mry_joints_destroy(c, mry_joints::default()), OK);
        assert_eq!(mry_session_destroy(c, mry_session::default()), OK);
        assert_eq!(mry_character_destroy(c, mry_character::default()), OK);
        assert_eq!(mry_poser_destroy(c, mry_poser::default()), OK);
        assert_eq!(mry_poses_destroy(c, mry_poses::default()), OK);
        assert_eq!(mry_take_destroy(c, mry_take::default()), OK);
        assert_eq!(mry_context_destroy(ptr::null_mut()), OK);
        assert_eq!((mry_clip_close(c, i.clip), mry_clip_close(c, i.clip)), (OK, code(MRY_E_STALE)));
        assert_eq!((mry_rig_destroy(c, i.rig), mry_rig_destroy(c, i.rig)), (OK, code(MRY_E_STALE)));
        assert_eq!(mry_clip_close(ptr::null_mut(), i.clip), code(MRY_E_NULL));
    }
}

#[test]
fn a_defect_in_any_function_is_contained_and_poisons_what_it_touched() {
    use marey_ffi::test_panic::{AT_LOOKUP, AT_START, IN_JOB, arm};
    // The panics are meant; their traces would bury a real one.
    std::panic::set_hook(Box::new(|_| {}));
    for (name, _, run) in CALLS {
        let f = fixture();
        let mut err = error();
        unsafe { arm(f.context, AT_START) };
        let status = run(f.context, Ids::default(), &Outs { null: false }, &mut err, "x");
        assert_eq!(status, code(MRY_E_PANIC), "{name}");
        assert!(text(&err.message).contains("a forced defect"), "{name}: {}", text(&err.message));
        let status = run(f.context, Ids::default(), &Outs { null: false }, &mut err, "x");
        assert_eq!(status, code(MRY_E_POISONED), "{name}: only destroying works in a poisoned context");
    }
    let f = fixture();
    let i = ids(&f);
    let mut err = error();
    unsafe {
        arm(f.context, AT_LOOKUP);
        let mut count = 0;
        assert_eq!(mry_rig_get_limb_count(f.context, i.rig, &mut count, &mut err), code(MRY_E_PANIC));
        assert_eq!(mry_rig_get_limb_count(f.context, i.rig, &mut count, &mut err), code(MRY_E_POISONED));
        assert_eq!(text(&err.param), "rig");
        let mut threads = 0;
        assert_eq!(mry_context_get_threads(f.context, &mut threads, &mut err), OK, "the rest of the context lives");
        assert_eq!(mry_rig_destroy(f.context, i.rig), OK);
        arm(f.context, IN_JOB);
        let mut motion = mry_motion { v: 3 };
        assert_eq!(mry_run_track(f.context, &f.track_desc(), &mut motion, &mut err), code(MRY_E_PANIC));
        assert_eq!(motion.v, 3);
        assert_eq!(mry_run_track(f.context, &f.track_desc(), &mut motion, &mut err), OK, "a job's defect is its own");
    }
    drop(std::panic::take_hook());
}

#[test]
fn numbers_that_are_none_and_values_out_of_range_are_refused() {
    let f = fixture();
    let i = ids(&f);
    let (c, mut err) = (f.context, error());
    let bad = [mry_point { x: 1.0, y: 1.0 }, mry_point { x: f32::NAN, y: 2.0 }];
    let far = [mry_point { x: 1.0, y: 1.0 }, mry_point { x: f32::INFINITY, y: 2.0 }];
    let good = [mry_point { x: 1.0, y: 1.0 }, mry_point { x: 30.0, y: 2.0 }];
    let before = {
        let mut n = 0;
        unsafe { mry_rig_get_keyframes(c, i.rig, ptr::null_mut(), 0, &mut n, ptr::null_mut()) };
        n
    };
    let mut stroke = |points: &[mry_point], count: usize, limb: u32, facing: i32| unsafe {
        mry_rig_set_stroke(c, i.rig, limb, 1, points.as_ptr(), count, facing, &mut err)
    };
    assert_eq!(stroke(&bad, 2, 0, 0), code(MRY_E_NON_FINITE));
    assert_eq!(stroke(&far, 2, 0, 0), code(MRY_E_NON_FINITE));
    assert_eq!(stroke(&good, 1, 0, 0), code(MRY_E_ARGUMENT));
    assert_eq!(stroke(&good, 0, 0, 0), code(MRY_E_ARGUMENT));
    assert_eq!(stroke(&good, usize::MAX, 0, 0), code(MRY_E_LIMIT), "a huge count is not read");
    assert_eq!(stroke(&good, 2, 1, 0), code(MRY_E_ARGUMENT), "there is one limb");
    assert_eq!(stroke(&good, 2, 0, 3), code(MRY_E_ARGUMENT));
    unsafe {
        assert_eq!(mry_rig_set_stroke(c, i.rig, 0, 1, ptr::null(), 2, 0, &mut err), code(MRY_E_NULL));
        assert_eq!(text(&err.param), "points");
        let odd = good.as_ptr().cast::<u8>().add(1).cast();
        assert_eq!(mry_rig_set_stroke(c, i.rig, 0, 1, odd, 1, 0, &mut err), code(MRY_E_ARGUMENT), "not aligned");
        for radius in [f32::NAN, f32::INFINITY] {
            let status = mry_rig_add_paint(c, i.rig, 1, 1, radius, good.as_ptr(), 2, &mut err);
            assert_eq!(status, code(MRY_E_NON_FINITE));
        }
        for (kind, radius) in [(1, 0.0), (1, -1.0), (2, 1.0)] {
            let status = mry_rig_add_paint(c, i.rig, 1, kind, radius, good.as_ptr(), 2, &mut err);
            assert_eq!(status, code(MRY_E_ARGUMENT));
        }
        let (mut limb, mut rig) = (0, mry_rig::default());
        assert_eq!(
            mry_rig_add_limb(c, i.rig, str("body"), 0, &mut limb, &mut err),
            code(MRY_E_ARGUMENT),
            "a label twice"
        );
        assert_eq!(mry_rig_add_limb(c, i.rig, str("tail"), 9, &mut limb, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_rig_add_limb(c, i.rig, str("a\0b"), 0, &mut limb, &mut err), code(MRY_E_STRING));
        assert_eq!(mry_rig_create(c, 0, 5, &mut rig, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_rig_remove_stroke(c, i.rig, 0, 5, &mut err), code(MRY_E_NOT_FOUND));
        let not_utf8 = mry_str { data: [0xffu8, 0xfe].as_ptr().cast::<c_char>(), len: 2 };
        assert_eq!(mry_rig_read(c, not_utf8, &mut rig, &mut err), code(MRY_E_STRING));
        let absurd = mry_str { data: STROKES.as_ptr().cast(), len: usize::MAX / 2 };
        assert_eq!(mry_rig_from_json(c, absurd, &mut rig, &mut err), code(MRY_E_LIMIT));
        assert_eq!(mry_rig_read(c, str(""), &mut rig, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_rig_read(c, str("/no/such/strokes.json"), &mut rig, &mut err), code(MRY_E_NO_FILE));
        assert!(text(&err.message).contains("/no/such/strokes.json"));
        let mut pixels = [0u8; 64];
        let (p, n) = (pixels.as_mut_ptr(), pixels.len());
        assert_eq!(mry_clip_read_frame(c, i.clip, FRAMES, p, n, 0, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_clip_read_frame(c, i.clip, u64::MAX, p, n, 0, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_clip_read_frame(c, i.clip, 0, p, n, 0, &mut err), code(MRY_E_BUFFER_TOO_SMALL));
        assert_eq!(mry_clip_read_frame(c, i.clip, 0, p, n, 5, &mut err), code(MRY_E_ARGUMENT), "a stride below a row");
        assert_eq!(mry_clip_read_frame(c, i.clip, 0, p, n, usize::MAX / 2, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_clip_read_alpha(c, i.clip, FRAMES, p, n, 0, &mut err), code(MRY_E_ARGUMENT));
        assert_eq!(mry_clip_read_alpha(c, i.clip, 0, p, n, 0, &mut err), code(MRY_E_BUFFER_TOO_SMALL));
        assert!(pixels.iter().all(|b| *b == 0));
        let glb = f.path("x.glb");
        for (scale, expected) in [(f32::NAN, MRY_E_NON_FINITE), (-1.0, MRY_E_ARGUMENT)] {
            assert_eq!(mry_creature_write_glb(c, i.creature, str(&glb), scale, &mut err), code(expected));
        }
        assert!(!std::path::Path::new(&glb).exists());
        let mut job = mry_job::default();
        let mut desc = f.track_desc();
        desc.tracker = str("nobody");
        assert_eq!(mry_job_start_track(c, &desc, &mut job, &mut err), code(MRY_E_UNSUPPORTED));
        assert!(text(&err.message).contains("space-time"), "it says what there is");
    }
    let after = {
        let mut n = 0;
        unsafe { mry_rig_get_keyframes(c, i.rig, ptr::null_mut(), 0, &mut n, ptr::null_mut()) };
        n
    };
    assert_eq!(before, after, "what was refused has changed nothing");
}

#[test]
fn short_buffers_are_told_the_count_and_left_alone() {
    let f = fixture();
    let i = ids(&f);
    let (c, mut err) = (f.context, error());
    unsafe {
        let (mut bytes, mut size) = ([7 as c_char; 16], 0);
        assert_eq!(
            mry_rig_to_json(c, i.rig, bytes.as_mut_ptr(), 16, &mut size, &mut err),
            code(MRY_E_BUFFER_TOO_SMALL)
        );
        assert!(size > 16 && bytes == [7; 16]);
        let mut json = vec![7 as c_char; size + 1];
        assert_eq!(mry_rig_to_json(c, i.rig, json.as_mut_ptr(), size, &mut size, &mut err), OK);
        assert_eq!((json[size - 1], json[size]), (0, 7), "the NUL is counted, and nothing is written behind it");
        assert_eq!(mry_rig_to_json(c, i.rig, ptr::null_mut(), 5, &mut size, &mut err), code(MRY_E_NULL));

        let (mut points, mut count) = ([mry_point { x: -1.0, y: -1.0 }; 1], 0);
        let status = mry_rig_get_stroke(c, i.rig, 0, 0, points.as_mut_ptr(), 1, &mut count, ptr::null_mut(), &mut err);
        assert_eq!((status, count, points[0].x), (code(MRY_E_BUFFER_TOO_SMALL), 2, -1.0));

        let mut visible = [7u8; 1];
        let none = ptr::null_mut();
        let p = visible.as_mut_ptr();
        let status = mry_motion_read_frame(c, i.motion, 0, 0, none, p, ptr::null_mut(), 1, &mut count, &mut err);
        assert_eq!((status, visible[0]), (code(MRY_E_BUFFER_TOO_SMALL), 7));
        assert!(count > 1);
        let mut positions = [7.0f32; 3];
        let p = positions.as_mut_ptr();
        let (no, nor) = (ptr::null_mut(), ptr::null_mut());
        let status = mry_creature_read_vertices(c, i.creature, 0, 0, p, no, nor, 1, &mut count, &mut err);
        assert_eq!((status, positions), (code(MRY_E_BUFFER_TOO_SMALL), [7.0; 3]));
        let absurd = mry_creature_read_vertices(c, i.creature, 0, 0, p, no, nor, usize::MAX, &mut count, &mut err);
        assert_eq!(absurd, code(MRY_E_ARGUMENT));
    }
}

#[test]
fn rows_keep_what_lies_between_them() {
    let f = fixture();
    let clip = f.clip();
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let stride = 3 * width + 10;
    let mut pixels = vec![7u8; stride * height];
    let mut tight = vec![0u8; 3 * width * height];
    unsafe {
        let last = stride * (height - 1) + 3 * width;
        let status = mry_clip_read_frame(f.context, clip, 0, pixels.as_mut_ptr(), last, stride, ptr::null_mut());
        assert_eq!(status, OK, "the last row needs no gap behind it");
        let status = mry_clip_read_frame(f.context, clip, 0, tight.as_mut_ptr(), tight.len(), 0, ptr::null_mut());
        assert_eq!(status, OK);
    }
    for y in 0..height {
        let row = &pixels[y * stride..(y + 1) * stride];
        assert_eq!(row[..3 * width], tight[y * 3 * width..(y + 1) * 3 * width]);
        assert!(row[3 * width..].iter().all(|b| *b == 7));
    }
    let at = |x: usize, y: usize| tight[3 * (y * width + x)];
    assert!(at(40, 32) < 100 && at(5, 5) > 150, "the picture is the right way round");
}

/// A description from a header of the future: one field more.
#[repr(C)]
struct Newer<T> {
    desc: T,
    more: u64,
}

#[test]
fn structs_of_other_versions_are_met_by_their_size() {
    let (mut context, mut err) = (ptr::null_mut(), error());
    let mut create = |desc: *const mry_context_desc| unsafe { mry_context_create(desc, &mut context, &mut err) };
    assert_eq!(create(ptr::null()), code(MRY_E_NULL));
    for size in [0, 4, 31, 1 << 20, u32::MAX] {
        let desc = mry_context_desc { struct_size: size, ..context_desc(1) };
        assert_eq!(create(&desc), code(MRY_E_STRUCT_SIZE), "size {size}");
    }
    let mut newer = Newer { desc: context_desc(1), more: 1 };
    newer.desc.struct_size = size_of_val(&newer) as u32;
    assert_eq!(create(&newer.desc), code(MRY_E_UNSUPPORTED));
    newer.more = 0;
    assert_eq!(create(ptr::from_ref(&newer).cast()), OK, "a newer header that asks for nothing new");
    let f = Fixture { context, folder: tempfile::tempdir().unwrap() };
    let desc = mry_context_desc { abi_version: 0, ..context_desc(1) };
    let (mut other, mut err) = (ptr::null_mut(), error());
    assert_eq!(unsafe { mry_context_create(&desc, &mut other, &mut err) }, code(MRY_E_ABI));
    let desc = mry_context_desc { threads: 5000, ..context_desc(1) };
    assert_eq!(unsafe { mry_context_create(&desc, &mut other, &mut err) }, code(MRY_E_ARGUMENT));
    let desc = mry_context_desc { reserved0: 1, ..context_desc(1) };
    assert_eq!(unsafe { mry_context_create(&desc, &mut other, &mut err) }, code(MRY_E_UNSUPPORTED));
    assert!(other.is_null());

    let clip = f.clip();
    let mut info = Newer { desc: unsafe { std::mem::zeroed::<mry_clip_info>() }, more: 42 };
    info.desc.struct_size = size_of_val(&info) as u32;
    let out = ptr::from_mut(&mut info).cast();
    assert_eq!(unsafe { mry_clip_get_info(f.context, clip, out, &mut err) }, OK);
    assert_eq!((info.desc.width, info.more), (SIZE.0, 42), "what the library does not know it does not touch");
    assert_eq!(info.desc.struct_size as usize, size_of_val(&info));
    info.desc.struct_size = 8;
    let out = ptr::from_mut(&mut info).cast();
    assert_eq!(unsafe { mry_clip_get_info(f.context, clip, out, &mut err) }, code(MRY_E_STRUCT_SIZE));
}

#[test]
fn a_rig_drawn_by_hand_is_the_rig_that_is_read() {
    let f = fixture();
    let (c, mut err) = (f.context, error());
    let (mut rig, mut limb, mut length) = (mry_rig::default(), 9, 0.0);
    let points = [mry_point { x: 33.0, y: 32.0 }, mry_point { x: 57.0, y: 32.0 }];
    unsafe {
        assert_eq!(mry_rig_create(c, 96, 64, &mut rig, &mut err), OK);
        assert_eq!(mry_rig_validate(c, rig, mry_clip::default(), &mut err), code(MRY_E_INPUT), "nothing is drawn yet");
        assert_eq!(mry_rig_add_limb(c, rig, str("body"), MRY_SIDE_UNKNOWN, &mut limb, &mut err), OK);
        assert_eq!(mry_rig_set_stroke(c, rig, limb, 0, points.as_ptr(), 2, 0, &mut err), OK);
        assert_eq!(mry_rig_validate(c, rig, f.clip(), &mut err), OK, "{}", text(&err.message));
        assert_eq!(mry_rig_get_length_hint(c, rig, limb, &mut length, &mut err), OK);
        assert_eq!(length, 24.0);
        let path = f.path("strokes.json");
        assert_eq!(mry_rig_write(c, rig, str(&path), &mut err), OK);
        let mut read = mry_rig::default();
        assert_eq!(mry_rig_read(c, str(&path), &mut read, &mut err), OK);
        let json = |rig| {
            let (mut bytes, mut size) = (vec![0; 4096], 0);
            assert_eq!(mry_rig_to_json(c, rig, bytes.as_mut_ptr(), 4096, &mut size, ptr::null_mut()), OK);
            text(&bytes)
        };
        assert_eq!(json(read), json(rig));
        assert_eq!(json(f.rig()), json(rig));
        assert_eq!(mry_rig_set_mask(c, rig, 4, str("m.png"), &mut err), OK);
        assert_eq!(mry_rig_add_paint(c, rig, 4, MRY_PAINT_BACKGROUND, 3.0, points.as_ptr(), 2, &mut err), OK);
        assert!(json(rig).contains("m.png") && json(rig).contains("background"));
        assert_eq!(mry_rig_clear_paint(c, rig, 4, &mut err), OK);
        assert_eq!(mry_rig_set_mask(c, rig, 4, str(""), &mut err), OK);
        assert_eq!(json(read), json(rig), "what was taken off leaves no empty key frame");
    }
}

#[test]
fn versions_agree_and_every_status_has_words() {
    let string = unsafe { std::ffi::CStr::from_ptr(mry_version_string()) }.to_str().unwrap();
    let parts: Vec<u32> = string.split('.').map(|p| p.parse().unwrap()).collect();
    assert_eq!(mry_version(), parts[0] << 16 | parts[1] << 8 | parts[2]);
    assert_eq!(string, env!("CARGO_PKG_VERSION"));
    assert_eq!(mry_abi_check(parts[0] << 16 | parts[1]), OK);
    assert_eq!(mry_abi_check((parts[0] << 16 | parts[1]) + 1), code(MRY_E_ABI));
    let header = include_str!("../../include/marey/marey.h");
    let codes = header.lines().filter_map(|l| l.trim().strip_prefix("MRY_")?.split_once(" = ")?.1.strip_suffix(','));
    let codes: Vec<i32> = codes.map(|c| c.parse().unwrap()).collect();
    assert!(codes.len() > 20);
    for code in codes {
        assert_ne!(status_text(code), "unknown status", "{code}");
    }
    assert_eq!(status_text(-12345), "unknown status");
}
