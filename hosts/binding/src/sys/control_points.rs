//! Marked control points, and what is tracked from them.

use marey_ffi::*;

use super::{Handle, check, sized_text, str, taken};
use crate::error::Result;

pub(crate) fn control_points_create(handle: &Handle, width: u32, height: u32) -> Result<mry_control_points> {
    let mut points = mry_control_points::default();
    call!(mry_control_points_create(handle, width, height, &mut points))?;
    Ok(points)
}

pub(crate) fn control_points_read(handle: &Handle, path: &str) -> Result<mry_control_points> {
    let mut points = mry_control_points::default();
    call!(mry_control_points_read(handle, str(path), &mut points))?;
    Ok(points)
}

pub(crate) fn control_points_from_json(handle: &Handle, json: &str) -> Result<mry_control_points> {
    let mut points = mry_control_points::default();
    call!(mry_control_points_from_json(handle, str(json), &mut points))?;
    Ok(points)
}

pub(crate) fn control_points_write(handle: &Handle, points: mry_control_points, path: &str) -> Result<()> {
    call!(mry_control_points_write(handle, points, str(path))).map(drop)
}

pub(crate) fn control_points_to_json(handle: &Handle, points: mry_control_points) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_control_points_to_json(handle, points, text, capacity, size)))
}

pub(crate) fn control_points_mark(
    handle: &Handle,
    points: mry_control_points,
    name: &str,
    frame: u64,
    (x, y): (f32, f32),
) -> Result<()> {
    call!(mry_control_points_mark(handle, points, str(name), frame, mry_point { x, y })).map(drop)
}

pub(crate) fn control_points_unmark(handle: &Handle, points: mry_control_points, name: &str, frame: u64) -> Result<()> {
    call!(mry_control_points_unmark(handle, points, str(name), frame)).map(drop)
}

pub(crate) fn control_points_validate(handle: &Handle, points: mry_control_points, clip: mry_clip) -> Result<()> {
    call!(mry_control_points_validate(handle, points, clip)).map(drop)
}

pub(crate) fn start_propose_points(handle: &Handle, clip: mry_clip, frame_from_one: u64, most: u32) -> Result<mry_job> {
    let mut job = mry_job::default();
    call!(mry_job_start_propose_points(handle, clip, frame_from_one, most, &mut job))?;
    Ok(job)
}

pub(crate) fn take_control_points(handle: &Handle, job: mry_job) -> Result<mry_control_points> {
    taken(|out| call!(mry_job_take_control_points(handle, job, out)))
}

pub(crate) fn start_point_track(
    handle: &Handle,
    (clip, points): (mry_clip, mry_control_points),
    keep: bool,
) -> Result<mry_job> {
    let mut desc = sized!(mry_point_track_desc_init, mry_point_track_desc);
    (desc.clip, desc.points) = (clip, points);
    desc.keep = keep.into();
    let mut job = mry_job::default();
    call!(mry_job_start_point_track(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn point_report(handle: &Handle, motion: mry_motion, points: mry_control_points) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_motion_get_point_report(handle, motion, points, text, capacity, size)))
}
