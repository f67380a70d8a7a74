//! The C ABI as safe functions: the only unsafe code of the hosts.
//!
//! Each function here passes pointers that come from live references, and counts that come from the same slices, so
//! that what the header asks of its caller holds by construction.

use std::ffi::{CStr, c_char};
use std::ptr;

use marey_ffi::*;

use crate::error::{Error, Result};
use crate::job::{CreatureOptions, CreatureSurface};

/// A live context. Destroyed when dropped.
#[derive(Debug)]
pub(crate) struct Handle(*mut mry_context);

// SAFETY: the header allows every call from any thread; the log callback, the one exception, is not used here.
unsafe impl Send for Handle {}
// SAFETY: as above.
unsafe impl Sync for Handle {}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: made by mry_context_create, and nothing else holds it once this runs.
        unsafe { mry_context_destroy(self.0) };
    }
}

/// What every call leads to: its status where it is no error.
fn check(status: mry_status, error: &mry_error) -> Result<mry_status> {
    if status >= 0 {
        return Ok(status);
    }
    let mut message = text(&error.message);
    if message.is_empty() {
        // SAFETY: the function gives a NUL-terminated text that lives for ever.
        message = unsafe { CStr::from_ptr(mry_status_text(status)) }.to_string_lossy().into_owned();
    }
    Err(Error::new(status, message, text(&error.param)))
}

/// The text up to the NUL.
pub(crate) fn text(bytes: &[c_char]) -> String {
    let bytes: Vec<u8> = bytes.iter().take_while(|c| **c != 0).map(|c| *c as u8).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

pub(crate) fn version() -> &'static str {
    // SAFETY: the function gives a NUL-terminated text that lives for ever.
    unsafe { CStr::from_ptr(mry_version_string()) }.to_str().unwrap_or_default()
}

/// A string that lives as long as the argument list it is in.
fn str(text: &str) -> mry_str {
    mry_str { data: text.as_ptr().cast(), len: text.len() }
}

/// A struct of the ABI that starts with its size: zeroed, sized.
macro_rules! sized {
    ($init:ident, $kind:ty) => {{
        let mut value = std::mem::MaybeUninit::<$kind>::zeroed();
        // SAFETY: the init function gets as many bytes as there are; zeros are a value of every struct of the ABI.
        unsafe {
            $init(value.as_mut_ptr(), size_of::<$kind>() as u32);
            value.assume_init()
        }
    }};
}

/// Calls a function with the context before its arguments and an error behind them.
macro_rules! call {
    ($name:ident($handle:expr $(, $argument:expr)* $(,)?)) => {{
        let mut error = sized!(mry_error_init, mry_error);
        // SAFETY: the context is alive while its handle is; the arguments are as this module's head says.
        let status = unsafe { $name($handle.0, $($argument,)* &mut error) };
        check(status, &error)
    }};
}

mod control_points;
mod drawing;
mod joints;
mod motion_shaping;
mod plugin;
mod print;
mod render;
mod reposing;
mod retiming;
mod session;
mod sketch;
mod surface;
pub(crate) use control_points::*;
pub(crate) use drawing::*;
pub(crate) use joints::*;
pub(crate) use motion_shaping::*;
pub(crate) use plugin::*;
pub(crate) use print::*;
pub(crate) use render::*;
pub(crate) use reposing::*;
pub(crate) use retiming::*;
pub(crate) use session::*;
pub(crate) use sketch::*;
pub(crate) use surface::*;

/// An object of the ABI, destroyed by its function. An id that is stale by then has nothing left to destroy.
macro_rules! destroy {
    ($name:ident, $function:ident, $id:ty) => {
        pub(crate) fn $name(handle: &Handle, id: $id) {
            // SAFETY: the context is alive while its handle is.
            unsafe { $function(handle.0, id) };
        }
    };
}

destroy!(clip_close, mry_clip_close, mry_clip);
destroy!(rig_destroy, mry_rig_destroy, mry_rig);
destroy!(motion_destroy, mry_motion_destroy, mry_motion);
destroy!(masks_destroy, mry_masks_destroy, mry_masks);
destroy!(creature_destroy, mry_creature_destroy, mry_creature);
destroy!(crowd_destroy, mry_crowd_destroy, mry_crowd);
destroy!(job_destroy, mry_job_destroy, mry_job);
destroy!(joints_destroy, mry_joints_destroy, mry_joints);
destroy!(binding_destroy, mry_binding_destroy, mry_binding);
destroy!(sketch_take_destroy, mry_sketch_take_destroy, mry_sketch_take);
destroy!(solid_destroy, mry_solid_destroy, mry_solid);
destroy!(drawing_destroy, mry_drawing_destroy, mry_drawing);
destroy!(control_points_destroy, mry_control_points_destroy, mry_control_points);
destroy!(session_destroy, mry_session_destroy, mry_session);
destroy!(deformation_destroy, mry_deformation_destroy, mry_deformation);

mod character;
pub(crate) use character::*;

/// Asks for a size, then for that many values.
fn sized_list<T: Copy + Default>(
    mut read: impl FnMut(*mut T, usize, &mut usize) -> Result<mry_status>,
) -> Result<Vec<T>> {
    let mut count = 0;
    match read(ptr::null_mut(), 0, &mut count) {
        Err(e) if e.code() != mry_status_code::MRY_E_BUFFER_TOO_SMALL as i32 => return Err(e),
        _ => {}
    }
    let mut values = vec![T::default(); count];
    read(values.as_mut_ptr(), values.len(), &mut count)?;
    values.truncate(count);
    Ok(values)
}

fn sized_text(read: impl FnMut(*mut c_char, usize, &mut usize) -> Result<mry_status>) -> Result<String> {
    sized_list(read).map(|bytes| text(&bytes))
}

pub(crate) fn context_create(threads: u32) -> Result<Handle> {
    let mut desc = sized!(mry_context_desc_init, mry_context_desc);
    // The header's MRY_ABI_VERSION; the library is linked into the same program.
    desc.abi_version = env!("CARGO_PKG_VERSION_MAJOR").parse().unwrap_or(0) << 16
        | env!("CARGO_PKG_VERSION_MINOR").parse().unwrap_or(0);
    desc.threads = threads;
    let (mut context, mut error) = (ptr::null_mut(), sized!(mry_error_init, mry_error));
    // SAFETY: three live locals of the right types.
    let status = unsafe { mry_context_create(&desc, &mut context, &mut error) };
    check(status, &error)?;
    Ok(Handle(context))
}

pub(crate) fn context_threads(handle: &Handle) -> Result<u32> {
    let mut threads = 0;
    call!(mry_context_get_threads(handle, &mut threads))?;
    Ok(threads)
}

pub(crate) fn clip_open(handle: &Handle, path: &str) -> Result<mry_clip> {
    let mut clip = mry_clip::default();
    call!(mry_clip_open(handle, str(path), ptr::null(), &mut clip))?;
    Ok(clip)
}

pub(crate) fn clip_info(handle: &Handle, clip: mry_clip) -> Result<mry_clip_info> {
    let mut info = sized!(mry_clip_info_init, mry_clip_info);
    call!(mry_clip_get_info(handle, clip, &mut info))?;
    Ok(info)
}

pub(crate) fn clip_warning(handle: &Handle, clip: mry_clip, index: u32) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_clip_get_warning(handle, clip, index, text, capacity, size)))
}

pub(crate) fn clip_frame(handle: &Handle, clip: mry_clip, frame: u64, pixels: &mut [u8]) -> Result<()> {
    call!(mry_clip_read_frame(handle, clip, frame, pixels.as_mut_ptr(), pixels.len(), 0)).map(drop)
}

pub(crate) fn clip_alpha(handle: &Handle, clip: mry_clip, frame: u64, pixels: &mut [u8]) -> Result<()> {
    call!(mry_clip_read_alpha(handle, clip, frame, pixels.as_mut_ptr(), pixels.len(), 0)).map(drop)
}

pub(crate) fn rig_create(handle: &Handle, width: u32, height: u32) -> Result<mry_rig> {
    let mut rig = mry_rig::default();
    call!(mry_rig_create(handle, width, height, &mut rig))?;
    Ok(rig)
}

pub(crate) fn rig_read(handle: &Handle, path: &str) -> Result<mry_rig> {
    let mut rig = mry_rig::default();
    call!(mry_rig_read(handle, str(path), &mut rig))?;
    Ok(rig)
}

pub(crate) fn rig_from_json(handle: &Handle, json: &str) -> Result<mry_rig> {
    let mut rig = mry_rig::default();
    call!(mry_rig_from_json(handle, str(json), &mut rig))?;
    Ok(rig)
}

pub(crate) fn rig_to_json(handle: &Handle, rig: mry_rig) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_rig_to_json(handle, rig, text, capacity, size)))
}

pub(crate) fn rig_write(handle: &Handle, rig: mry_rig, path: &str) -> Result<()> {
    call!(mry_rig_write(handle, rig, str(path))).map(drop)
}

pub(crate) fn rig_validate(handle: &Handle, rig: mry_rig, clip: mry_clip) -> Result<()> {
    call!(mry_rig_validate(handle, rig, clip)).map(drop)
}

pub(crate) fn rig_add_limb(handle: &Handle, rig: mry_rig, label: &str, side: i32) -> Result<u32> {
    let mut limb = 0;
    call!(mry_rig_add_limb(handle, rig, str(label), side, &mut limb))?;
    Ok(limb)
}

pub(crate) fn rig_set_stroke(
    handle: &Handle,
    rig: mry_rig,
    limb: u32,
    frame: u64,
    points: &[mry_point],
    facing: i32,
) -> Result<()> {
    call!(mry_rig_set_stroke(handle, rig, limb, frame, points.as_ptr(), points.len(), facing)).map(drop)
}

pub(crate) fn rig_remove_stroke(handle: &Handle, rig: mry_rig, limb: u32, frame: u64) -> Result<()> {
    call!(mry_rig_remove_stroke(handle, rig, limb, frame)).map(drop)
}

pub(crate) fn rig_set_depth(
    handle: &Handle,
    rig: mry_rig,
    (limb, frame): (u32, u64),
    (said, depth, bend): (u32, f32, f32),
) -> Result<()> {
    call!(mry_rig_set_depth(handle, rig, limb, frame, said, depth, bend)).map(drop)
}

/// What is said, and the depth and the bend.
pub(crate) fn rig_depth(handle: &Handle, rig: mry_rig, limb: u32, frame: u64) -> Result<(u32, f32, f32)> {
    let (mut said, mut depth, mut bend) = (0, 0.0, 0.0);
    call!(mry_rig_get_depth(handle, rig, limb, frame, &mut said, &mut depth, &mut bend))?;
    Ok((said, depth, bend))
}

pub(crate) fn rig_limb_count(handle: &Handle, rig: mry_rig) -> Result<u32> {
    let mut count = 0;
    call!(mry_rig_get_limb_count(handle, rig, &mut count))?;
    Ok(count)
}

/// Label and side.
pub(crate) fn rig_limb(handle: &Handle, rig: mry_rig, limb: u32) -> Result<(String, i32)> {
    let mut side = 0;
    let label =
        sized_text(|text, capacity, size| call!(mry_rig_get_limb(handle, rig, limb, text, capacity, size, &mut side)))?;
    Ok((label, side))
}

pub(crate) fn rig_key_frames(handle: &Handle, rig: mry_rig) -> Result<Vec<u64>> {
    sized_list(|frames, capacity, count| call!(mry_rig_get_keyframes(handle, rig, frames, capacity, count)))
}

/// Points and facing.
pub(crate) fn rig_stroke(handle: &Handle, rig: mry_rig, limb: u32, frame: u64) -> Result<(Vec<mry_point>, i32)> {
    let mut facing = 0;
    let points = sized_list(|points, capacity, count| {
        call!(mry_rig_get_stroke(handle, rig, limb, frame, points, capacity, count, &mut facing))
    })?;
    Ok((points, facing))
}

pub(crate) fn rig_length_hint(handle: &Handle, rig: mry_rig, limb: u32) -> Result<f32> {
    let mut length = 0.0;
    call!(mry_rig_get_length_hint(handle, rig, limb, &mut length))?;
    Ok(length)
}

pub(crate) fn start_track(handle: &Handle, clip: mry_clip, rig: mry_rig, tracker: &str) -> Result<mry_job> {
    let mut desc = sized!(mry_track_desc_init, mry_track_desc);
    (desc.clip, desc.rig, desc.tracker) = (clip, rig, str(tracker));
    let mut job = mry_job::default();
    call!(mry_job_start_track(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn deformation(
    handle: &Handle,
    points: &[mry_point],
    triangles: &[[u32; 3]],
    handles: &[mry_handle],
    deformer: &str,
    iterations: u32,
) -> Result<mry_deformation> {
    let mut desc = sized!(mry_deform_desc_init, mry_deform_desc);
    (desc.points, desc.point_count) = (points.as_ptr(), points.len() as u64);
    (desc.triangles, desc.triangle_count) = (triangles.as_ptr().cast(), triangles.len() as u64);
    (desc.handles, desc.handle_count) = (handles.as_ptr(), handles.len() as u64);
    (desc.deformer, desc.iterations) = (str(deformer), iterations);
    let mut deformation = mry_deformation::default();
    call!(mry_deformation_create(handle, &desc, &mut deformation))?;
    Ok(deformation)
}

/// Starts from `points` and writes the new shape there.
pub(crate) fn deformation_solve(
    handle: &Handle,
    deformation: mry_deformation,
    targets: &[mry_handle],
    points: &mut [mry_point],
) -> Result<()> {
    let (to, count) = (points.as_mut_ptr(), points.len());
    call!(mry_deformation_solve(handle, deformation, targets.as_ptr(), targets.len(), to, to, count)).map(drop)
}

pub(crate) fn start_segment(
    handle: &Handle,
    (clip, rig, motion): (mry_clip, mry_rig, mry_motion),
    tracker: &str,
    segmenter: &str,
    folder: &str,
) -> Result<mry_job> {
    let mut desc = sized!(mry_segment_desc_init, mry_segment_desc);
    (desc.clip, desc.rig, desc.motion) = (clip, rig, motion);
    (desc.tracker, desc.segmenter, desc.folder) = (str(tracker), str(segmenter), str(folder));
    let mut job = mry_job::default();
    call!(mry_job_start_segment(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn start_creature(
    handle: &Handle,
    (clip, rig): (mry_clip, mry_rig),
    options: &CreatureOptions<'_>,
) -> Result<mry_job> {
    let mut desc = sized!(mry_creature_desc_init, mry_creature_desc);
    (desc.clip, desc.rig, desc.write_obj) = (clip, rig, u32::from(options.write_obj));
    (desc.tracker, desc.segmenter) = (str(options.tracker), str(options.segmenter));
    (desc.folder, desc.depths, desc.spread) = (str(options.folder), str(options.depths), options.spread);
    desc.surface = match options.surface {
        CreatureSurface::Usual => 0,
        CreatureSurface::Skin => MRY_SURFACE_SKIN,
        CreatureSurface::Tubes => MRY_SURFACE_TUBES,
    };
    let mut job = mry_job::default();
    call!(mry_job_start_creature(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn start_export(
    handle: &Handle,
    creature: mry_creature,
    what: i32,
    path: &str,
    (write_obj, scale): (bool, f32),
) -> Result<mry_job> {
    let mut desc = sized!(mry_export_desc_init, mry_export_desc);
    (desc.what, desc.creature, desc.path) = (what, creature, str(path));
    (desc.write_obj, desc.scale) = (u32::from(write_obj), scale);
    let mut job = mry_job::default();
    call!(mry_job_start_export(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn job_poll(handle: &Handle, job: mry_job) -> Result<mry_job_state> {
    let mut state = sized!(mry_job_state_init, mry_job_state);
    call!(mry_job_poll(handle, job, &mut state))?;
    Ok(state)
}

pub(crate) fn job_wait(handle: &Handle, job: mry_job, timeout_ns: u64) -> Result<mry_status> {
    call!(mry_job_wait(handle, job, timeout_ns))
}

pub(crate) fn job_cancel(handle: &Handle, job: mry_job) -> Result<()> {
    call!(mry_job_cancel(handle, job)).map(drop)
}

/// Takes by `take`; a job that was cancelled, or that has not ended, has nothing to give.
fn taken<T: Default>(take: impl FnOnce(&mut T) -> Result<mry_status>) -> Result<T> {
    let mut out = T::default();
    match take(&mut out)? {
        0 => Ok(out),
        other => Err(Error::new(other, text_of(other), String::new())),
    }
}

fn text_of(status: mry_status) -> String {
    // SAFETY: the function gives a NUL-terminated text that lives for ever.
    unsafe { CStr::from_ptr(mry_status_text(status)) }.to_string_lossy().into_owned()
}

pub(crate) fn take_motion(handle: &Handle, job: mry_job) -> Result<mry_motion> {
    taken(|out| call!(mry_job_take_motion(handle, job, out)))
}

pub(crate) fn take_masks(handle: &Handle, job: mry_job) -> Result<mry_masks> {
    taken(|out| call!(mry_job_take_masks(handle, job, out)))
}

pub(crate) fn take_creature(handle: &Handle, job: mry_job) -> Result<mry_creature> {
    taken(|out| call!(mry_job_take_creature(handle, job, out)))
}

pub(crate) fn motion_read(handle: &Handle, path: &str) -> Result<mry_motion> {
    let mut motion = mry_motion::default();
    call!(mry_motion_read(handle, str(path), &mut motion))?;
    Ok(motion)
}

pub(crate) fn motion_write(handle: &Handle, motion: mry_motion, path: &str) -> Result<()> {
    call!(mry_motion_write(handle, motion, str(path))).map(drop)
}

pub(crate) fn motion_to_json(handle: &Handle, motion: mry_motion) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_motion_to_json(handle, motion, text, capacity, size)))
}

pub(crate) fn motion_report(handle: &Handle, motion: mry_motion, clip: mry_clip, rig: mry_rig) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_motion_get_report(handle, motion, clip, rig, text, capacity, size)))
}

pub(crate) fn motion_info(handle: &Handle, motion: mry_motion) -> Result<mry_motion_info> {
    let mut info = sized!(mry_motion_info_init, mry_motion_info);
    call!(mry_motion_get_info(handle, motion, &mut info))?;
    Ok(info)
}

pub(crate) fn motion_track_name(handle: &Handle, motion: mry_motion, track: u32) -> Result<String> {
    let none = ptr::null_mut;
    sized_text(|name, capacity, size| {
        call!(mry_motion_get_track(handle, motion, track, name, capacity, size, none(), ptr::null_mut()))
    })
}

/// Points, visible, confidence of a track in a frame.
pub(crate) fn motion_frame(
    handle: &Handle,
    motion: mry_motion,
    track: u32,
    frame: u64,
) -> Result<(Vec<mry_point>, Vec<u8>, Vec<f32>)> {
    let none = ptr::null_mut::<mry_point>();
    let mut count = 0;
    call!(mry_motion_read_frame(handle, motion, track, frame, none, ptr::null_mut(), ptr::null_mut(), 0, &mut count))?;
    let (mut points, mut visible, mut confidence) =
        (vec![mry_point::default(); count], vec![0; count], vec![0.0; count]);
    let lists = (points.as_mut_ptr(), visible.as_mut_ptr(), confidence.as_mut_ptr());
    call!(mry_motion_read_frame(handle, motion, track, frame, lists.0, lists.1, lists.2, points.len(), &mut count))?;
    Ok((points, visible, confidence))
}

/// The `index`-th best correction, where there are so many.
pub(crate) fn motion_correction(
    handle: &Handle,
    motion: mry_motion,
    rig: mry_rig,
    index: u32,
) -> Result<Option<mry_correction>> {
    let mut correction = sized!(mry_correction_init, mry_correction);
    match call!(mry_motion_get_correction(handle, motion, rig, index, &mut correction)) {
        Ok(_) => Ok(Some(correction)),
        Err(e) if e.code() == mry_status_code::MRY_E_NOT_FOUND as i32 => Ok(None),
        Err(e) => Err(e),
    }
}

pub(crate) fn masks_info(handle: &Handle, masks: mry_masks) -> Result<mry_masks_info> {
    let mut info = sized!(mry_masks_info_init, mry_masks_info);
    call!(mry_masks_get_info(handle, masks, &mut info))?;
    Ok(info)
}

pub(crate) fn masks_read(handle: &Handle, masks: mry_masks, frame: u64, pixels: &mut [u8]) -> Result<()> {
    call!(mry_masks_read(handle, masks, frame, pixels.as_mut_ptr(), pixels.len(), 0)).map(drop)
}

pub(crate) fn masks_write(handle: &Handle, masks: mry_masks, folder: &str) -> Result<()> {
    call!(mry_masks_write_folder(handle, masks, str(folder))).map(drop)
}

pub(crate) fn masks_report(handle: &Handle, masks: mry_masks) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_masks_get_report(handle, masks, text, capacity, size)))
}

pub(crate) fn creature_info(handle: &Handle, creature: mry_creature) -> Result<mry_creature_info> {
    let mut info = sized!(mry_creature_info_init, mry_creature_info);
    call!(mry_creature_get_info(handle, creature, &mut info))?;
    Ok(info)
}

pub(crate) fn creature_report(handle: &Handle, creature: mry_creature) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_creature_get_report(handle, creature, text, capacity, size)))
}

pub(crate) fn creature_motion(handle: &Handle, creature: mry_creature) -> Result<mry_motion> {
    let mut motion = mry_motion::default();
    call!(mry_creature_get_motion(handle, creature, &mut motion))?;
    Ok(motion)
}

pub(crate) fn creature_masks(handle: &Handle, creature: mry_creature) -> Result<mry_masks> {
    let mut masks = mry_masks::default();
    call!(mry_creature_get_masks(handle, creature, &mut masks))?;
    Ok(masks)
}

pub(crate) fn creature_open(handle: &Handle, path: &str) -> Result<mry_creature> {
    let mut creature = mry_creature::default();
    call!(mry_creature_open(handle, str(path), &mut creature))?;
    Ok(creature)
}

/// A bone's parent, or -1.
pub(crate) fn creature_bone_parent(handle: &Handle, creature: mry_creature, bone: u32) -> Result<i32> {
    let mut parent = -1;
    sized_text(|name, capacity, size| {
        call!(mry_creature_get_bone(handle, creature, bone, name, capacity, size, &mut parent))
    })?;
    Ok(parent)
}

pub(crate) fn creature_pose(handle: &Handle, creature: mry_creature, frame: u64) -> Result<Vec<mry_transform>> {
    sized_list(|bones, capacity, count| call!(mry_creature_read_pose(handle, creature, frame, bones, capacity, count)))
}

pub(crate) fn creature_limb(handle: &Handle, creature: mry_creature, limb: u32) -> Result<(String, mry_creature_limb)> {
    let mut info = sized!(mry_creature_limb_init, mry_creature_limb);
    let label = sized_text(|text, capacity, size| {
        call!(mry_creature_get_limb(handle, creature, limb, text, capacity, size, &mut info))
    })?;
    Ok((label, info))
}

pub(crate) fn creature_write_glb(handle: &Handle, creature: mry_creature, path: &str, scale: f32) -> Result<()> {
    call!(mry_creature_write_glb(handle, creature, str(path), scale)).map(drop)
}

pub(crate) fn creature_write_folder(
    handle: &Handle,
    creature: mry_creature,
    folder: &str,
    write_obj: bool,
    scale: f32,
) -> Result<()> {
    call!(mry_creature_write_folder(handle, creature, str(folder), u32::from(write_obj), scale)).map(drop)
}
