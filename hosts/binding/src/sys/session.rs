//! The session part of the C ABI as safe functions.

use std::ptr;

use marey_ffi::*;

use super::{Handle, check, sized_list, sized_text, str};
use crate::error::Result;

pub(crate) fn session_create(handle: &Handle, path: &str) -> Result<mry_session> {
    let mut session = mry_session::default();
    call!(mry_session_create(handle, str(path), &mut session))?;
    Ok(session)
}

pub(crate) fn session_create_untitled(handle: &Handle, folder: &str) -> Result<mry_session> {
    let mut session = mry_session::default();
    call!(mry_session_create_untitled(handle, str(folder), &mut session))?;
    Ok(session)
}

pub(crate) fn session_find_left(handle: &Handle, folder: &str, index: u32) -> Result<String> {
    sized_text(|path, capacity, size| call!(mry_session_find_left(handle, str(folder), index, path, capacity, size)))
}

pub(crate) fn session_open(handle: &Handle, path: &str, access: i32) -> Result<mry_session> {
    let mut session = mry_session::default();
    call!(mry_session_open(handle, str(path), access, &mut session))?;
    Ok(session)
}

pub(crate) fn session_set_embedded(handle: &Handle, session: mry_session, embedded: bool) -> Result<()> {
    call!(mry_session_set_embedded(handle, session, embedded.into())).map(drop)
}

pub(crate) fn session_start_recording(handle: &Handle, session: mry_session, path: &str) -> Result<()> {
    call!(mry_session_start_recording(handle, session, str(path))).map(drop)
}

pub(crate) fn session_stop_recording(handle: &Handle, session: mry_session) -> Result<()> {
    call!(mry_session_stop_recording(handle, session)).map(drop)
}

pub(crate) fn session_replay(handle: &Handle, path: &str, most: u64) -> Result<mry_session> {
    let mut session = mry_session::default();
    call!(mry_session_replay(handle, str(path), most, &mut session))?;
    Ok(session)
}

pub(crate) fn session_fingerprint(handle: &Handle, session: mry_session) -> Result<u64> {
    let mut number = 0;
    call!(mry_session_get_fingerprint(handle, session, &mut number))?;
    Ok(number)
}

pub(crate) fn session_set_part(handle: &Handle, session: mry_session, part: i32, bytes: &[u8]) -> Result<()> {
    call!(mry_session_set_part(handle, session, part, bytes.as_ptr(), bytes.len())).map(drop)
}

pub(crate) fn session_part(handle: &Handle, session: mry_session, part: i32) -> Result<Vec<u8>> {
    sized_list(|bytes, capacity, count| call!(mry_session_get_part(handle, session, part, bytes, capacity, count)))
}

pub(crate) fn session_discard(handle: &Handle, session: mry_session) -> Result<()> {
    call!(mry_session_discard(handle, session)).map(drop)
}

pub(crate) fn session_save(handle: &Handle, session: mry_session) -> Result<()> {
    call!(mry_session_save(handle, session)).map(drop)
}

pub(crate) fn session_save_as(handle: &Handle, session: mry_session, path: &str) -> Result<()> {
    call!(mry_session_save_as(handle, session, str(path))).map(drop)
}

pub(crate) fn session_state(handle: &Handle, session: mry_session) -> Result<mry_session_state> {
    let mut state = sized!(mry_session_state_init, mry_session_state);
    call!(mry_session_get_state(handle, session, &mut state))?;
    Ok(state)
}

pub(crate) fn session_path(handle: &Handle, session: mry_session) -> Result<String> {
    sized_text(|path, capacity, size| call!(mry_session_get_path(handle, session, path, capacity, size)))
}

pub(crate) fn session_warning(handle: &Handle, session: mry_session, index: u32) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_session_get_warning(handle, session, index, text, capacity, size)))
}

pub(crate) fn session_begin_gesture(handle: &Handle, session: mry_session, label: &str) -> Result<()> {
    call!(mry_session_begin_gesture(handle, session, str(label))).map(drop)
}

pub(crate) fn session_end_gesture(handle: &Handle, session: mry_session) -> Result<()> {
    call!(mry_session_end_gesture(handle, session)).map(drop)
}

pub(crate) fn session_cancel_gesture(handle: &Handle, session: mry_session) -> Result<()> {
    call!(mry_session_cancel_gesture(handle, session)).map(drop)
}

pub(crate) fn session_undo(handle: &Handle, session: mry_session) -> Result<()> {
    call!(mry_session_undo(handle, session)).map(drop)
}

pub(crate) fn session_redo(handle: &Handle, session: mry_session) -> Result<()> {
    call!(mry_session_redo(handle, session)).map(drop)
}

pub(crate) fn session_undo_label(handle: &Handle, session: mry_session) -> Result<String> {
    sized_text(|label, capacity, size| call!(mry_session_get_undo_label(handle, session, label, capacity, size)))
}

pub(crate) fn session_redo_label(handle: &Handle, session: mry_session) -> Result<String> {
    sized_text(|label, capacity, size| call!(mry_session_get_redo_label(handle, session, label, capacity, size)))
}

pub(crate) fn session_set_clip(handle: &Handle, session: mry_session, clip: mry_clip) -> Result<()> {
    call!(mry_session_set_clip(handle, session, clip)).map(drop)
}

pub(crate) fn session_clip(handle: &Handle, session: mry_session) -> Result<mry_clip> {
    let mut clip = mry_clip::default();
    call!(mry_session_get_clip(handle, session, ptr::null(), &mut clip))?;
    Ok(clip)
}

pub(crate) fn session_set_rig(handle: &Handle, session: mry_session, rig: mry_rig) -> Result<()> {
    call!(mry_session_set_rig(handle, session, rig)).map(drop)
}

pub(crate) fn session_rig(handle: &Handle, session: mry_session) -> Result<mry_rig> {
    let mut rig = mry_rig::default();
    call!(mry_session_get_rig(handle, session, &mut rig))?;
    Ok(rig)
}

pub(crate) fn session_set_motion(handle: &Handle, session: mry_session, motion: mry_motion) -> Result<()> {
    call!(mry_session_set_motion(handle, session, motion)).map(drop)
}

pub(crate) fn session_motion(handle: &Handle, session: mry_session) -> Result<mry_motion> {
    let mut motion = mry_motion::default();
    call!(mry_session_get_motion(handle, session, &mut motion))?;
    Ok(motion)
}

pub(crate) fn session_add_limb(handle: &Handle, session: mry_session, label: &str, side: i32) -> Result<u32> {
    let mut limb = 0;
    call!(mry_session_add_limb(handle, session, str(label), side, &mut limb))?;
    Ok(limb)
}

pub(crate) fn session_remove_limb(handle: &Handle, session: mry_session, limb: u32) -> Result<()> {
    call!(mry_session_remove_limb(handle, session, limb)).map(drop)
}

pub(crate) fn session_set_limb(handle: &Handle, session: mry_session, limb: u32, label: &str, side: i32) -> Result<()> {
    call!(mry_session_set_limb(handle, session, limb, str(label), side)).map(drop)
}

pub(crate) fn session_set_stroke(
    handle: &Handle,
    session: mry_session,
    (limb, frame): (u32, u64),
    points: &[mry_point],
    facing: i32,
) -> Result<()> {
    call!(mry_session_set_stroke(handle, session, limb, frame, points.as_ptr(), points.len(), facing)).map(drop)
}

pub(crate) fn session_set_depth(
    handle: &Handle,
    session: mry_session,
    (limb, frame): (u32, u64),
    (said, depth, bend): (u32, f32, f32),
) -> Result<()> {
    call!(mry_session_set_depth(handle, session, limb, frame, said, depth, bend)).map(drop)
}

pub(crate) fn session_remove_stroke(handle: &Handle, session: mry_session, limb: u32, frame: u64) -> Result<()> {
    call!(mry_session_remove_stroke(handle, session, limb, frame)).map(drop)
}

pub(crate) fn session_add_paint(
    handle: &Handle,
    session: mry_session,
    (frame, kind, radius): (u64, i32, f32),
    points: &[mry_point],
) -> Result<()> {
    call!(mry_session_add_paint(handle, session, frame, kind, radius, points.as_ptr(), points.len())).map(drop)
}

pub(crate) fn session_remove_paint(handle: &Handle, session: mry_session, frame: u64, index: u32) -> Result<()> {
    call!(mry_session_remove_paint(handle, session, frame, index)).map(drop)
}

pub(crate) fn session_set_mask(handle: &Handle, session: mry_session, frame: u64, path: &str) -> Result<()> {
    call!(mry_session_set_mask(handle, session, frame, str(path))).map(drop)
}

pub(crate) fn parameter_info(handle: &Handle, index: u32) -> Result<mry_parameter_info> {
    let mut info = sized!(mry_parameter_info_init, mry_parameter_info);
    call!(mry_parameter_get_info(handle, index, &mut info))?;
    Ok(info)
}

pub(crate) fn parameter_choice(handle: &Handle, index: u32, choice: u32) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_parameter_get_choice(handle, index, choice, text, capacity, size)))
}

pub(crate) fn session_set_parameter(handle: &Handle, session: mry_session, name: &str, value: f64) -> Result<()> {
    call!(mry_session_set_parameter(handle, session, str(name), value)).map(drop)
}

pub(crate) fn session_set_text(handle: &Handle, session: mry_session, name: &str, text: &str) -> Result<()> {
    call!(mry_session_set_text(handle, session, str(name), str(text))).map(drop)
}

pub(crate) fn session_text(handle: &Handle, session: mry_session, name: &str) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_session_get_text(handle, session, str(name), text, capacity, size)))
}

pub(crate) fn session_reset_parameter(handle: &Handle, session: mry_session, name: &str) -> Result<()> {
    call!(mry_session_reset_parameter(handle, session, str(name))).map(drop)
}

pub(crate) fn session_parameter(handle: &Handle, session: mry_session, name: &str) -> Result<f64> {
    let mut value = 0.0;
    call!(mry_session_get_parameter(handle, session, str(name), &mut value))?;
    Ok(value)
}

pub(crate) fn session_start_track(handle: &Handle, session: mry_session) -> Result<mry_job> {
    let mut job = mry_job::default();
    call!(mry_session_start_track(handle, session, &mut job))?;
    Ok(job)
}

pub(crate) fn session_start_creature(handle: &Handle, session: mry_session, folder: &str) -> Result<mry_job> {
    let mut job = mry_job::default();
    call!(mry_session_start_creature(handle, session, str(folder), &mut job))?;
    Ok(job)
}

pub(crate) fn session_take(handle: &Handle, session: mry_session, job: mry_job) -> Result<mry_status> {
    call!(mry_session_take(handle, session, job))
}

pub(crate) fn session_outdated(handle: &Handle, session: mry_session, limb: u32) -> Result<Vec<mry_frame_range>> {
    sized_list(|ranges, capacity, count| {
        call!(mry_session_get_outdated(handle, session, limb, ranges, capacity, count))
    })
}
