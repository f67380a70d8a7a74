//! Paint. Hints for the segmenter on key frames: brush strokes that say what is the creature's and what is not, and whole
//! masks that a person painted.

use std::path::PathBuf;

use marey::export::{encode_mask, write_aside};
use marey::raster::Mask;
use marey::rig::Paint;

use crate::border;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::rig::mry_rig;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{key_frame, mry_point, points_in, tidy};

/// Paint that marks background.
pub const MRY_PAINT_BACKGROUND: i32 = 0;
/// Paint that marks the creature.
pub const MRY_PAINT_FOREGROUND: i32 = 1;

pub(crate) fn foreground_in(kind: i32) -> Outcome<bool> {
    match kind {
        MRY_PAINT_FOREGROUND => Ok(true),
        MRY_PAINT_BACKGROUND => Ok(false),
        _ => Err(Failure::argument("kind", format!("kind is {kind}, which is no MRY_PAINT"))),
    }
}

pub(crate) fn radius_in(radius: f32) -> Outcome<f32> {
    if !radius.is_finite() {
        return Err(Failure::new(Code::MRY_E_NON_FINITE, "radius", format!("radius is {radius}")));
    }
    if radius <= 0.0 {
        return Err(Failure::argument("radius", format!("radius is {radius}, and must be above 0")));
    }
    Ok(radius)
}

/// Paints a hint for the segmenter on a frame: what is along the path is the creature's, or is not.
///
/// @param context      The context.
/// @param rig          The rig.
/// @param frame        The frame, counted from 0.
/// @param kind         MRY_PAINT_FOREGROUND or MRY_PAINT_BACKGROUND.
/// @param radius       The brush's radius in clip pixels, above 0.
/// @param points       The brush's path.
/// @param point_count  1 to 10000.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (kind, radius, point_count), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_add_paint(
    context: *mut mry_context,
    rig: mry_rig,
    frame: u64,
    kind: i32,
    radius: f32,
    points: *const mry_point,
    point_count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let points = points_in(border::slice(points, point_count, call.context.limits.points, "points")?)?;
        if points.is_empty() {
            return Err(Failure::argument("point_count", "point_count is 0, and paint has 1 or more"));
        }
        let (foreground, radius) = (foreground_in(kind)?, radius_in(radius)?);
        call.rig_mut(rig, |rig| {
            key_frame(rig, frame, call.context.limits.key_frames)?.paint.push(Paint { foreground, radius, points });
            Ok(Code::MRY_OK)
        })
    })
}

/// Takes all paint off a frame.
///
/// @param context  The context.
/// @param rig      The rig.
/// @param frame    The frame; one without paint is no error.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_clear_paint(
    context: *mut mry_context,
    rig: mry_rig,
    frame: u64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.rig_mut(rig, |rig| {
            rig.keyframes.iter_mut().filter(|k| k.frame as u64 == frame).for_each(|k| k.paint.clear());
            tidy(rig);
            Ok(Code::MRY_OK)
        })
    })
}

/// Gives the whole mask of a frame as an image file, painted by a person: bright is the creature.
///
/// @param context  The context.
/// @param rig      The rig.
/// @param frame    The frame, counted from 0.
/// @param path     An 8-bit image of the clip's size, read when a job starts to need it; empty to take the mask off.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRING, MRY_E_LIMIT, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_set_mask(
    context: *mut mry_context,
    rig: mry_rig,
    frame: u64,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = if path.len == 0 { None } else { Some(PathBuf::from(path.name("path")?)) };
        call.rig_mut(rig, |rig| {
            key_frame(rig, frame, call.context.limits.key_frames)?.mask = path;
            tidy(rig);
            Ok(Code::MRY_OK)
        })
    })
}

/// Gives the whole mask of a frame as pixels, painted by a person. They are written to an image file, whole or not at
/// all, which the rig then refers to as with mry_rig_set_mask: a rig and its masks stay files that can be moved.
///
/// @param context       The context.
/// @param rig           The rig.
/// @param frame         The frame, counted from 0.
/// @param pixels        The rig's width x height, a byte a pixel, rows from the top; above 127 is the creature.
/// @param size          Bytes at pixels: at least stride_bytes * (height - 1) + width.
/// @param stride_bytes  From one row's start to the next's; 0 for rows without gaps.
/// @param path          The PNG file to write, in a folder that exists; best beside the rig's own file.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (size, stride_bytes, path), MRY_E_STRING, MRY_E_IO, MRY_E_INPUT (no place for a
///         file), MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_paint_mask(
    context: *mut mry_context,
    rig: mry_rig,
    frame: u64,
    pixels: *const u8,
    size: usize,
    stride_bytes: usize,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let pixels = border::slice(pixels, size, isize::MAX as usize, "pixels")?;
        let (width, height) = call.rig(rig, |rig| Ok((rig.size.0 as usize, rig.size.1 as usize)))?;
        let stride = if stride_bytes == 0 { width } else { stride_bytes };
        let needed = height.checked_sub(1).and_then(|rows| stride.checked_mul(rows)?.checked_add(width));
        if stride < width || needed.is_none_or(|n| size < n) {
            let message = format!("{size} bytes with {stride} a row are no mask of {width}x{height}");
            return Err(Failure::argument("size", message));
        }
        let mask = Mask::from_fn(width, height, |x, y| pixels[y * stride + x] > 127);
        let png = encode_mask(&mask)?;
        write_aside(path, &png).map_err(|e| Failure::from(e).about("path"))?;
        call.rig_mut(rig, |rig| {
            key_frame(rig, frame, call.context.limits.key_frames)?.mask = Some(path.into());
            Ok(Code::MRY_OK)
        })
    })
}
