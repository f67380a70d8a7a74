//! Control points. What a person marks to take a motion from a clip: points of the animal or thing, each on one frame, and
//! corrections, which are keys of the same points on other frames. mry_job_start_point_track follows them.

use std::ffi::c_char;
use std::sync::{Arc, RwLock};

use marey::export::write_aside;
use marey::rig::{PointKey, PointMarks};

use crate::border::{Out, Text};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::mry_point;
use crate::table::{Slot, Table};

pub(crate) type ControlPointsTable = Table<RwLock<PointMarks>>;

/// Marked points.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_control_points {
    /// The id; 0 is none.
    pub v: u64,
}

impl Call<'_> {
    fn control_points_slot(&self, points: mry_control_points) -> Outcome<Arc<Slot<RwLock<PointMarks>>>> {
        self.get(&self.context.control_points, points.v, "points")
    }

    /// Reads points, unless they are being changed.
    pub(crate) fn control_points<T>(
        &self,
        points: mry_control_points,
        read: impl FnOnce(&PointMarks) -> Outcome<T>,
    ) -> Outcome<T> {
        let slot = self.control_points_slot(points)?;
        match slot.value.try_read() {
            Ok(points) => read(&points),
            Err(e) => Err(Failure::locked(&e, "points", "changing")),
        }
    }

    /// Changes a copy, which takes the points' place where it is still a draft that makes sense.
    fn control_points_mut(
        &self,
        points: mry_control_points,
        change: impl FnOnce(&mut PointMarks) -> Outcome<()>,
    ) -> Outcome<Code> {
        let slot = self.control_points_slot(points)?;
        match slot.value.try_write() {
            Ok(mut points) => {
                let mut changed = points.clone();
                change(&mut changed)?;
                changed.validate_draft(None)?;
                *points = changed;
                Ok(Code::MRY_OK)
            }
            Err(e) => Err(Failure::locked(&e, "points", "changing")),
        }
    }

    pub(crate) fn keep_control_points(&self, points: PointMarks) -> Outcome<mry_control_points> {
        Ok(mry_control_points { v: self.context.control_points.insert(RwLock::new(points))? })
    }
}

/// Creates points of which none is marked.
///
/// @param context     The context.
/// @param width       The clip's pixels across, at least 1.
/// @param height      The clip's pixels down, at least 1.
/// @param out_points  The points.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT.
/// Lifetime: until mry_control_points_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_control_points_create(
    context: *mut mry_context,
    width: u32,
    height: u32,
    out_points: *mut mry_control_points,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_points, "out_points")?;
        for (value, param) in [(width, "width"), (height, "height")] {
            if value == 0 {
                return Err(Failure::argument(param, format!("{param} is 0; give the clip's")));
            }
        }
        out.set(call.keep_control_points(PointMarks { size: (width, height), points: Vec::new() })?);
        Ok(Code::MRY_OK)
    })
}

/// Reads a points.json file.
///
/// @param context     The context.
/// @param path        The file.
/// @param out_points  The points, valid.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT, MRY_E_LIMIT, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_control_points_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_control_points_read(
    context: *mut mry_context,
    path: mry_str,
    out_points: *mut mry_control_points,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_points, "out_points")?;
        let points = PointMarks::read(path).map_err(|e| Failure::from(e).about("path"))?;
        out.set(call.keep_control_points(points)?);
        Ok(Code::MRY_OK)
    })
}

/// Reads the text of a points.json.
///
/// @param context     The context.
/// @param json        The text.
/// @param out_points  The points, valid.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_STRING.
/// Lifetime: until mry_control_points_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_control_points_from_json(
    context: *mut mry_context,
    json: mry_str,
    out_points: *mut mry_control_points,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let json = json.text("json")?;
        let out = Out::new(out_points, "out_points")?;
        let points = PointMarks::from_json(json).map_err(|e| Failure::from(e).about("json"))?;
        out.set(call.keep_control_points(points)?);
        Ok(Code::MRY_OK)
    })
}

/// Writes points as points.json, complete or not; the file appears whole or not at all.
///
/// @param context  The context.
/// @param points   The points.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_control_points_write(
    context: *mut mry_context,
    points: mry_control_points,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = call.control_points(points, |points| Ok(points.to_json()))?;
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// The points as the text of a points.json.
///
/// @param context   The context.
/// @param points    The points.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_control_points_to_json(
    context: *mut mry_context,
    points: mry_control_points,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let json = call.control_points(points, |points| Ok(points.to_json()))?;
        text.fill(&json)
    })
}

/// Marks a point on a frame, in place of an earlier key there. The first key of a name makes the point.
///
/// @param context  The context.
/// @param points   The points.
/// @param name     The point's name.
/// @param frame    The frame.
/// @param at       Where it is, in clip pixels, inside the clip.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (outside the clip), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_control_points_mark(
    context: *mut mry_context,
    points: mry_control_points,
    name: mry_str,
    frame: u64,
    at: mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.text("name")?.to_owned();
        let at = at.place("at")?;
        let frame = usize::try_from(frame).unwrap_or(usize::MAX);
        call.control_points_mut(points, |points| {
            points.put(&name, PointKey { frame, at });
            Ok(())
        })
    })
}

/// Takes back a point's key on a frame. A point without keys is gone.
///
/// @param context  The context.
/// @param points   The points.
/// @param name     The point's name.
/// @param frame    The frame.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_control_points_unmark(
    context: *mut mry_context,
    points: mry_control_points,
    name: mry_str,
    frame: u64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.text("name")?;
        let found = usize::try_from(frame).unwrap_or(usize::MAX);
        call.control_points_mut(points, |points| {
            if points.remove(name, found) {
                Ok(())
            } else {
                Err(Failure::new(
                    Code::MRY_E_NOT_FOUND,
                    "name",
                    format!("point `{name}` is not marked on frame {frame}"),
                ))
            }
        })
    })
}

/// Destroys points. Jobs that were started with them keep their copy.
///
/// @param context  The context.
/// @param points   The points; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_control_points_destroy(
    context: *mut mry_context,
    points: mry_control_points,
) -> mry_status {
    ending!(context, |call| {
        if points.v != 0 {
            call.context.control_points.remove(points.v, "points")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// Whether jobs can work with the points: each marked, inside the clip, and so on.
///
/// @param context  The context.
/// @param points   The points.
/// @param clip     The clip they are for, whose size and length they must fit; {0} to leave that out.
/// @param err      What is missing or wrong, where, and what to do; or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_control_points_validate(
    context: *mut mry_context,
    points: mry_control_points,
    clip: mry_clip,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let clip = if clip.v == 0 { None } else { Some(call.clip(clip, "clip")?) };
        let fit = clip.map(|c| ((c.info().width, c.info().height), c.info().frames));
        call.control_points(points, |points| points.validate(fit).map_err(|e| Failure::from(e).about("points")))?;
        Ok(Code::MRY_OK)
    })
}
