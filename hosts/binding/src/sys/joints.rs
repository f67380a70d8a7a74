//! Marked joints, and what is captured from them.

use marey_ffi::*;

use super::{Handle, check, sized_text, str};
use crate::error::Result;

pub(crate) fn joints_create(handle: &Handle, width: u32, height: u32) -> Result<mry_joints> {
    let mut joints = mry_joints::default();
    call!(mry_joints_create(handle, width, height, &mut joints))?;
    Ok(joints)
}

pub(crate) fn joints_read(handle: &Handle, path: &str) -> Result<mry_joints> {
    let mut joints = mry_joints::default();
    call!(mry_joints_read(handle, str(path), &mut joints))?;
    Ok(joints)
}

pub(crate) fn joints_from_json(handle: &Handle, json: &str) -> Result<mry_joints> {
    let mut joints = mry_joints::default();
    call!(mry_joints_from_json(handle, str(json), &mut joints))?;
    Ok(joints)
}

pub(crate) fn joints_write(handle: &Handle, joints: mry_joints, path: &str) -> Result<()> {
    call!(mry_joints_write(handle, joints, str(path))).map(drop)
}

pub(crate) fn joints_to_json(handle: &Handle, joints: mry_joints) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_joints_to_json(handle, joints, text, capacity, size)))
}

pub(crate) fn joints_mark(
    handle: &Handle,
    joints: mry_joints,
    name: &str,
    frame: u64,
    [x, y, width, height]: [f32; 4],
) -> Result<()> {
    call!(mry_joints_mark(handle, joints, str(name), frame, x, y, width, height)).map(drop)
}

pub(crate) fn joints_unmark(handle: &Handle, joints: mry_joints, name: &str, frame: u64) -> Result<()> {
    call!(mry_joints_unmark(handle, joints, str(name), frame)).map(drop)
}

pub(crate) fn joints_add_bone(handle: &Handle, joints: mry_joints, parent: &str, child: &str) -> Result<()> {
    call!(mry_joints_add_bone(handle, joints, str(parent), str(child))).map(drop)
}

pub(crate) fn joints_validate(handle: &Handle, joints: mry_joints, clip: mry_clip) -> Result<()> {
    call!(mry_joints_validate(handle, joints, clip)).map(drop)
}

pub(crate) fn start_capture(
    handle: &Handle,
    (clip, joints): (mry_clip, mry_joints),
    earlier: Option<(mry_motion, mry_joints)>,
) -> Result<mry_job> {
    let mut desc = sized!(mry_capture_desc_init, mry_capture_desc);
    (desc.clip, desc.joints) = (clip, joints);
    (desc.earlier, desc.earlier_joints) = earlier.unwrap_or_default();
    let mut job = mry_job::default();
    call!(mry_job_start_capture(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn capture_report(
    handle: &Handle,
    motion: mry_motion,
    clip: mry_clip,
    joints: mry_joints,
) -> Result<String> {
    sized_text(|text, capacity, size| {
        call!(mry_motion_get_capture_report(handle, motion, clip, joints, text, capacity, size))
    })
}
