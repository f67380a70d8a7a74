//! Tracks. A motion has one for each limb, in the rig's order: the same number of points in every frame, from the
//! stroke's start to its end. Tracks, frames and points count from 0.

use std::ffi::c_char;

use marey::motion::{Motion, TrackKind};

use crate::border::{Lists, Out, Text};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::motion::mry_motion;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_out};

/// Kind of a track: points along a limb's stroke.
pub const MRY_TRACK_STROKE: i32 = 1;
/// Kind of a track: one control point.
pub const MRY_TRACK_POINT: i32 = 2;
/// Kind of a track: one joint of a skeleton.
pub const MRY_TRACK_JOINT: i32 = 3;

/// An index of a track.
pub(crate) fn track_index(motion: &Motion, track: u32) -> Outcome<usize> {
    let count = motion.tracks.len();
    let message = || format!("track is {track}, and there are {count}");
    if (track as usize) < count { Ok(track as usize) } else { Err(Failure::argument("track", message())) }
}

/// A track's name, kind and number of points.
///
/// @param context          The context.
/// @param motion           The motion.
/// @param track            Which, below track_count.
/// @param name             Where the name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity         Bytes at name.
/// @param out_size         Bytes needed, with the NUL.
/// @param out_kind         MRY_TRACK_STROKE, ...; or NULL.
/// @param out_point_count  Points of the track in every frame; or NULL.
/// @param err              Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (track), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_track(
    context: *mut mry_context,
    motion: mry_motion,
    track: u32,
    name: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_kind: *mut i32,
    out_point_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = Text::new(name, capacity, out_size, "name")?;
        let out_kind = Out::optional(out_kind, "out_kind")?;
        let out_point_count = Out::optional(out_point_count, "out_point_count")?;
        let motion = call.motion(motion)?;
        let track = &motion.tracks[track_index(&motion, track)?];
        name.fill(&track.name)?;
        out_kind.inspect(|out| {
            out.set(match track.kind {
                TrackKind::Stroke => MRY_TRACK_STROKE,
                TrackKind::Point => MRY_TRACK_POINT,
                TrackKind::Joint => MRY_TRACK_JOINT,
            });
        });
        out_point_count.inspect(|out| out.set(track.frames.first().map_or(0, |f| f.points.len())));
        Ok(Code::MRY_OK)
    })
}

/// The track of a name.
///
/// @param context    The context.
/// @param motion     The motion.
/// @param name       The limb's label.
/// @param out_track  Its index.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND, MRY_E_STRING, MRY_E_ARGUMENT (empty name).
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_find_track(
    context: *mut mry_context,
    motion: mry_motion,
    name: mry_str,
    out_track: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.name("name")?;
        let out = Out::new(out_track, "out_track")?;
        let motion = call.motion(motion)?;
        let track = motion.tracks.iter().position(|t| t.name == name);
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "name", format!("no track is called `{name}`"));
        out.set(track.ok_or_else(none)? as u32);
        Ok(Code::MRY_OK)
    })
}

/// Where a track is in one frame. Lists that are not wanted may be NULL.
///
/// @param context     The context.
/// @param motion      The motion.
/// @param track       Which, below track_count.
/// @param frame       Which, below frame_count.
/// @param points      Places, which may lie outside the image; or NULL.
/// @param visible     1 where the point is seen, 0 where it is hidden or outside the image; or NULL.
/// @param confidence  How far each place is to be trusted, 0..1, 1 on key frames; or NULL.
/// @param capacity    Entries that fit in each list.
/// @param out_count   Points of the track.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (track, frame), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_read_frame(
    context: *mut mry_context,
    motion: mry_motion,
    track: u32,
    frame: u64,
    points: *mut mry_point,
    visible: *mut u8,
    confidence: *mut f32,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let mut lists = Lists::new(capacity, out_count)?;
        let points = lists.list(points, 1, "points")?;
        let visible = lists.list(visible, 1, "visible")?;
        let confidence = lists.list(confidence, 1, "confidence")?;
        let motion = call.motion(motion)?;
        let track = &motion.tracks[track_index(&motion, track)?];
        let frame = &track.frames[frame_index(frame, motion.frames)?];
        lists.fit(frame.points.len())?;
        if let Some(points) = points {
            points.write(&points_out(&frame.points))?;
        }
        if let Some(visible) = visible {
            visible.write(&frame.visible.iter().map(|v| u8::from(*v)).collect::<Vec<u8>>())?;
        }
        if let Some(confidence) = confidence {
            confidence.write(&frame.confidence)?;
        }
        Ok(Code::MRY_OK)
    })
}

/// A pair of tracks that are joined, such as a leg that hangs from the body.
///
/// @param context     The context.
/// @param motion      The motion.
/// @param bone        Which, below bone_count.
/// @param out_parent  The track nearer to the root.
/// @param out_child   The track that hangs from it.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (bone), MRY_E_NOT_FOUND (the motion's file names a track that it lacks).
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_bone(
    context: *mut mry_context,
    motion: mry_motion,
    bone: u32,
    out_parent: *mut u32,
    out_child: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (out_parent, out_child) = (Out::new(out_parent, "out_parent")?, Out::new(out_child, "out_child")?);
        let motion = call.motion(motion)?;
        let pair = motion.bones.get(bone as usize).ok_or_else(|| {
            Failure::argument("bone", format!("bone is {bone}, and there are {}", motion.bones.len()))
        })?;
        let index = |name: &str| {
            let none = || Failure::new(Code::MRY_E_NOT_FOUND, "bone", format!("no track is called `{name}`"));
            motion.tracks.iter().position(|t| t.name == name).map(|t| t as u32).ok_or_else(none)
        };
        let (parent, child) = (index(&pair.0)?, index(&pair.1)?);
        out_parent.set(parent);
        out_child.set(child);
        Ok(Code::MRY_OK)
    })
}
