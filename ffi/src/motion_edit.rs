//! Making motions. A motion can also be made by hand: from the tracks of another program, or by correcting a copy of
//! what was tracked. What a creature, a session or a job works with is not touched by a change made afterwards.

use std::sync::Arc;

use marey::motion::{Motion, TrackFrame, TrackKind};

use crate::border::{self, Out};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::motion::mry_motion;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_in};
use crate::tracks::{MRY_TRACK_JOINT, MRY_TRACK_POINT, MRY_TRACK_STROKE, track_index};

impl Call<'_> {
    /// Changes a motion; whoever shares it keeps it as it was.
    fn motion_mut<T>(&self, motion: mry_motion, change: impl FnOnce(&mut Motion) -> Outcome<T>) -> Outcome<T> {
        let slot = self.get(&self.context.motions, motion.v, "motion")?;
        let mut motion = slot.value.try_write().map_err(|e| Failure::locked(&e, "motion", "changing"))?;
        change(Arc::make_mut(&mut motion))
    }
}

fn kind_in(kind: i32) -> Outcome<TrackKind> {
    match kind {
        MRY_TRACK_STROKE => Ok(TrackKind::Stroke),
        MRY_TRACK_POINT => Ok(TrackKind::Point),
        MRY_TRACK_JOINT => Ok(TrackKind::Joint),
        _ => Err(Failure::argument("kind", format!("kind is {kind}, which is no MRY_TRACK"))),
    }
}

/// Creates a motion without tracks.
///
/// @param context      The context.
/// @param width        The clip's pixels across, at least 1.
/// @param height       The clip's pixels down, at least 1.
/// @param frame_count  Frames of every track, at least 1.
/// @param fps          Frames a second, above 0.
/// @param out_motion   The motion.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a value that is none), MRY_E_LIMIT (frames).
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_create(
    context: *mut mry_context,
    width: u32,
    height: u32,
    frame_count: u64,
    fps: f64,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let most = call.context.limits.frames;
        let frames = usize::try_from(frame_count).ok().filter(|_| frame_count <= most).ok_or_else(|| {
            let message = format!("frame_count is {frame_count}, and at most {most} are allowed");
            Failure::new(Code::MRY_E_LIMIT, "frame_count", message)
        })?;
        out.set(call.keep_motion(Arc::new(Motion::new((width, height), fps, frames)?))?);
        Ok(Code::MRY_OK)
    })
}

/// Copies a motion, to change it. Tracks are copied when they are changed, not now.
///
/// @param context     The context.
/// @param motion      The motion.
/// @param out_motion  The copy.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUSY.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_copy(
    context: *mut mry_context,
    motion: mry_motion,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let motion = call.motion(motion)?;
        out.set(call.keep_motion(motion)?);
        Ok(Code::MRY_OK)
    })
}

/// Adds a track behind the others. Until they are set its points lie at (0, 0), hidden and not to be trusted.
///
/// @param context      The context.
/// @param motion       The motion.
/// @param name         Its name, unlike any other's.
/// @param kind         MRY_TRACK_STROKE, ...
/// @param point_count  Its points in every frame: 1 to 10000.
/// @param out_track    Its index.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the name is taken), MRY_E_ARGUMENT (kind, empty name, no points), MRY_E_LIMIT (points,
///         or more than 67 million in all frames), MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_add_track(
    context: *mut mry_context,
    motion: mry_motion,
    name: mry_str,
    kind: i32,
    point_count: usize,
    out_track: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.name("name")?;
        let out = Out::new(out_track, "out_track")?;
        let kind = kind_in(kind)?;
        let most = call.context.limits.points;
        if point_count == 0 {
            return Err(Failure::argument("point_count", "point_count is 0; a track has a point at least"));
        }
        if point_count > most {
            let message = format!("point_count is {point_count}, and at most {most} are allowed");
            return Err(Failure::new(Code::MRY_E_LIMIT, "point_count", message));
        }
        let track = call.motion_mut(motion, |motion| Ok(motion.add_track(name, kind, point_count)?))?;
        out.set(track as u32);
        Ok(Code::MRY_OK)
    })
}

/// Removes a track and its bones; the indices of those behind it go down.
///
/// @param context  The context.
/// @param motion   The motion.
/// @param track    Which, below track_count.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (track), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_remove_track(
    context: *mut mry_context,
    motion: mry_motion,
    track: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.motion_mut(motion, |motion| {
            let track = track_index(motion, track)?;
            Ok(motion.remove_track(track)?)
        })?;
        Ok(Code::MRY_OK)
    })
}

/// Sets where a track is in one frame.
///
/// @param context     The context.
/// @param motion      The motion.
/// @param track       Which, below track_count.
/// @param frame       Which, below frame_count.
/// @param points      Places, which may lie outside the image.
/// @param visible     For each point 1 where it is seen and 0 where it is not; NULL for all seen.
/// @param confidence  For each point how far it is to be trusted, 0..1; NULL for all certain.
/// @param count       Entries of each list: as many as the track has points.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (track, frame), MRY_E_INPUT (count, or a confidence outside 0..1),
///         MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_set_frame(
    context: *mut mry_context,
    motion: mry_motion,
    track: u32,
    frame: u64,
    points: *const mry_point,
    visible: *const u8,
    confidence: *const f32,
    count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let most = call.context.limits.points;
        let mut to = TrackFrame::certain(points_in(border::slice(points, count, most, "points")?)?);
        if !visible.is_null() {
            to.visible = border::slice(visible, count, most, "visible")?.iter().map(|v| *v != 0).collect();
        }
        if !confidence.is_null() {
            to.confidence = border::slice(confidence, count, most, "confidence")?.to_vec();
        }
        call.motion_mut(motion, |motion| {
            let (track, frame) = (track_index(motion, track)?, frame_index(frame, motion.frames)?);
            Ok(motion.set_frame(track, frame, to)?)
        })?;
        Ok(Code::MRY_OK)
    })
}

/// Joins two tracks, such as a leg to the body it hangs from; an earlier bone to the same child is replaced.
///
/// @param context  The context.
/// @param motion   The motion.
/// @param parent   The track nearer to the root.
/// @param child    The track that hangs from it.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (no such track), MRY_E_INPUT (the bones would close a circle), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_add_bone(
    context: *mut mry_context,
    motion: mry_motion,
    parent: u32,
    child: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.motion_mut(motion, |motion| {
            let (parent, child) = (track_index(motion, parent)?, track_index(motion, child)?);
            Ok(motion.join(parent, child)?)
        })?;
        Ok(Code::MRY_OK)
    })
}

/// Takes a bone away; the indices of those behind it go down.
///
/// @param context  The context.
/// @param motion   The motion.
/// @param bone     Which, below bone_count.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no such bone), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_remove_bone(
    context: *mut mry_context,
    motion: mry_motion,
    bone: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.motion_mut(motion, |motion| Ok(motion.remove_bone(bone as usize)?))?;
        Ok(Code::MRY_OK)
    })
}
