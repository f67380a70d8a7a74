//! Drawing. Edits of what is drawn in a session. Each is a gesture of its own, or part of the one in progress; one that
//! fails changes nothing. Limbs count from 0 in the rig's order. mry_session_get_rig gives what is drawn.

use std::path::Path;

use marey::rig::Paint;
use marey::session::Session;

use crate::border::{self, Out};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::limb::{limb_index, side_in};
use crate::paint::{foreground_in, radius_in};
use crate::session::mry_session;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{depth_in, facing_in, mry_point, points_in};

impl Call<'_> {
    /// Draws in a session.
    fn draw(
        &self,
        session: mry_session,
        edit: impl FnOnce(&mut Session) -> Outcome<marey::session::Outdated>,
    ) -> Outcome<Code> {
        self.session_mut(session, |document| edit(&mut document.session).map(|_| Code::MRY_OK))
    }
}

fn index_of(session: &Session, limb: u32) -> Outcome<usize> {
    limb_index(&session.document().inputs.rig, limb)
}

fn frame_in(frame: u64) -> Outcome<usize> {
    usize::try_from(frame).map_err(|_| Failure::argument("frame", format!("frame is {frame}")))
}

/// Adds a limb behind the others, without a stroke yet.
///
/// @param context   The context.
/// @param session   The session.
/// @param label     Its name, unique in the rig.
/// @param side      MRY_SIDE_UNKNOWN, ...
/// @param out_limb  Its index.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the label is in use, or the session is read-only), MRY_E_ARGUMENT, MRY_E_STRING,
///         MRY_E_LIMIT, MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_add_limb(
    context: *mut mry_context,
    session: mry_session,
    label: mry_str,
    side: i32,
    out_limb: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let label = label.name("label")?;
        let side = side_in(side)?;
        let out = Out::new(out_limb, "out_limb")?;
        call.draw(session, |session| {
            let outdated = session.add_limb(label, side)?;
            out.set(session.document().inputs.rig.limbs.len() as u32 - 1);
            Ok(outdated)
        })
    })
}

/// Removes a limb with its strokes; the indices of those behind it go down.
///
/// @param context  The context.
/// @param session  The session.
/// @param limb     Its index.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_INPUT (the session is read-only), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_remove_limb(
    context: *mut mry_context,
    session: mry_session,
    limb: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| { call.draw(session, |session| Ok(session.remove_limb(index_of(session, limb)?)?)) })
}

/// Gives a limb another label and side. Its track, where it has one, goes with the label.
///
/// @param context  The context.
/// @param session  The session.
/// @param limb     Its index.
/// @param label    Its name, unique in the rig.
/// @param side     MRY_SIDE_UNKNOWN, ...
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the label is in use, or the session is read-only), MRY_E_ARGUMENT, MRY_E_STRING,
///         MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_limb(
    context: *mut mry_context,
    session: mry_session,
    limb: u32,
    label: mry_str,
    side: i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let label = label.name("label")?;
        let side = side_in(side)?;
        call.draw(session, |session| Ok(session.set_limb(index_of(session, limb)?, label, side)?))
    })
}

/// Draws a limb on a frame, which becomes a key frame; an earlier stroke of the limb there is replaced.
///
/// @param context      The context.
/// @param session      The session.
/// @param limb         Its index.
/// @param frame        The frame, counted from 0.
/// @param points       The stroke, from the limb's start to its end; it may leave the image.
/// @param point_count  2 to 10000.
/// @param facing       MRY_FACING_UNKNOWN, ...
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the points make no stroke, or the session is read-only), MRY_E_ARGUMENT (limb, frame,
///         facing), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_stroke(
    context: *mut mry_context,
    session: mry_session,
    limb: u32,
    frame: u64,
    points: *const mry_point,
    point_count: usize,
    facing: i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let points = points_in(border::slice(points, point_count, call.context.limits.points, "points")?)?;
        let (frame, facing) = (frame_in(frame)?, facing_in(facing)?);
        call.draw(session, |session| {
            let limb = index_of(session, limb)?;
            session.set_stroke(limb, frame, points, facing).map_err(|e| Failure::from(e).about("points"))
        })
    })
}

/// Says where a limb is in depth on a frame, or takes back what was said: see mry_rig_set_depth.
///
/// @param context  The context.
/// @param session  The session.
/// @param limb     Its index.
/// @param frame    The frame, counted from 0.
/// @param said     MRY_SAID_DEPTH and MRY_SAID_BEND, or 0 to take back what was said.
/// @param depth    How far its free part stands from where it would, in clip pixels toward the viewer.
/// @param bend     How far its free end stands from where it is held, in clip pixels toward the viewer.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (too far from the image plane, or the session is read-only), MRY_E_ARGUMENT (limb, frame,
///         said), MRY_E_NON_FINITE, MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_depth(
    context: *mut mry_context,
    session: mry_session,
    limb: u32,
    frame: u64,
    said: u32,
    depth: f32,
    bend: f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (mark, frame) = (depth_in(said, depth, bend)?, frame_in(frame)?);
        call.draw(session, |session| {
            let limb = index_of(session, limb)?;
            session.set_depth(limb, frame, mark).map_err(|e| Failure::from(e).about("depth"))
        })
    })
}

/// Takes a limb's stroke off a frame.
///
/// @param context  The context.
/// @param session  The session.
/// @param limb     Its index.
/// @param frame    The frame; one on which it is not drawn is no error.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_INPUT (the session is read-only), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_remove_stroke(
    context: *mut mry_context,
    session: mry_session,
    limb: u32,
    frame: u64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let frame = frame_in(frame)?;
        call.draw(session, |session| Ok(session.remove_stroke(index_of(session, limb)?, frame)?))
    })
}

/// Paints a hint for the segmenter on a frame: what is along the path is the creature's, or is not.
///
/// @param context      The context.
/// @param session      The session.
/// @param frame        The frame, counted from 0.
/// @param kind         MRY_PAINT_FOREGROUND or MRY_PAINT_BACKGROUND.
/// @param radius       The brush's radius in clip pixels, above 0.
/// @param points       The brush's path.
/// @param point_count  1 to 10000.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the points make no path, or the session is read-only), MRY_E_ARGUMENT (kind, radius),
///         MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_add_paint(
    context: *mut mry_context,
    session: mry_session,
    frame: u64,
    kind: i32,
    radius: f32,
    points: *const mry_point,
    point_count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let points = points_in(border::slice(points, point_count, call.context.limits.points, "points")?)?;
        let paint = Paint { foreground: foreground_in(kind)?, radius: radius_in(radius)?, points };
        let frame = frame_in(frame)?;
        call.draw(session, |session| session.add_paint(frame, paint).map_err(|e| Failure::from(e).about("points")))
    })
}

/// Removes one painted hint of a frame; the indices of those behind it go down.
///
/// @param context  The context.
/// @param session  The session.
/// @param frame    The frame.
/// @param index    Which, in the order they were painted.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (there is no such hint, or the session is read-only), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_remove_paint(
    context: *mut mry_context,
    session: mry_session,
    frame: u64,
    index: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let frame = frame_in(frame)?;
        call.draw(session, |session| {
            session.remove_paint(frame, index as usize).map_err(|e| Failure::from(e).about("index"))
        })
    })
}

/// Gives the whole mask of a frame as an image file, painted by a person: bright is the creature.
///
/// @param context  The context.
/// @param session  The session.
/// @param frame    The frame, counted from 0.
/// @param path     An 8-bit image of the clip's size, read when a job needs it; empty to take the mask off.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the session is read-only), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_LIMIT, MRY_E_IO,
///         MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_mask(
    context: *mut mry_context,
    session: mry_session,
    frame: u64,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = if path.len == 0 { None } else { Some(Path::new(path.name("path")?)) };
        let frame = frame_in(frame)?;
        call.draw(session, |session| session.set_mask(frame, path).map_err(|e| Failure::from(e).about("path")))
    })
}
