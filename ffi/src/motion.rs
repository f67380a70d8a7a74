//! Motions. A motion is named tracks over time, one a limb in the rig's order: for each frame where the limb's points
//! are, which are seen, and how far each is to be trusted. A track has the same number of points in every frame, from
//! the stroke's start to its end. Motions do not change.

use std::ffi::c_char;
use std::sync::Arc;

use marey::export::report::{Report, corrections};
use marey::export::write_aside;
use marey::motion::{Motion, TrackKind};
use marey::rig::Rig;

use crate::border::{self, Buffer, Out, OutStruct, Versioned};
use crate::clip::{frame_index, mry_clip};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::rig::{mry_point, mry_rig, points_out};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;

pub(crate) type MotionTable = Table<Arc<Motion>>;

/// A motion.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_motion {
    /// The id; 0 is no motion.
    pub v: u64,
}

/// Kind of a track: points along a limb's stroke.
pub const MRY_TRACK_STROKE: i32 = 1;
/// Kind of a track: one control point.
pub const MRY_TRACK_POINT: i32 = 2;
/// Kind of a track: one joint of a skeleton.
pub const MRY_TRACK_JOINT: i32 = 3;

/// What a motion is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_motion_info {
    /// sizeof(mry_motion_info).
    pub struct_size: u32,
    /// The clip's pixels across.
    pub width: u32,
    /// The clip's pixels down.
    pub height: u32,
    /// How many tracks there are.
    pub track_count: u32,
    /// How many frames every track has.
    pub frame_count: u64,
    /// Frames a second.
    pub fps: f64,
    /// How many pairs of tracks mry_motion_get_bone has.
    pub bone_count: u32,
    /// Zero.
    pub reserved0: u32,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_motion_info {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_motion_info>() == 40);

/// A stroke that is worth drawing next.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_correction {
    /// sizeof(mry_correction).
    pub struct_size: u32,
    /// The track, that is the limb, to draw.
    pub track: u32,
    /// The frame to draw it on.
    pub frame: u64,
    /// How far it is trusted there now, in 0..1.
    pub confidence: f32,
    /// Zero.
    pub reserved0: u32,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_correction {
    const FIRST_SIZE: usize = 24;
}
const _: () = assert!(size_of::<mry_correction>() == 24);

impl Call<'_> {
    pub(crate) fn motion(&self, motion: mry_motion) -> Outcome<Arc<Motion>> {
        Ok(self.get(&self.context.motions, motion.v, "motion")?.value.clone())
    }

    pub(crate) fn keep_motion(&self, motion: Arc<Motion>) -> Outcome<mry_motion> {
        Ok(mry_motion { v: self.context.motions.insert(motion)? })
    }
}

/// An index of a track.
fn track_index(motion: &Motion, track: u32) -> Outcome<usize> {
    let count = motion.tracks.len();
    let message = || format!("track is {track}, and there are {count}");
    if (track as usize) < count { Ok(track as usize) } else { Err(Failure::argument("track", message())) }
}

/// Fills in a motion info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_motion_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_info_init(info: *mut mry_motion_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Fills in a correction with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param correction  Where to write; NULL does nothing.
/// @param size        sizeof(mry_correction) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_correction_init(correction: *mut mry_correction, size: u32) {
    // SAFETY: the caller owns `size` bytes at `correction`, or passes NULL.
    unsafe { border::init(correction.cast(), size) }
}

/// Reads a motion.json file.
///
/// @param context     The context.
/// @param path        The file.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_read(
    context: *mut mry_context,
    path: mry_str,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_motion, "out_motion")?;
        let motion = Motion::read(path).map_err(|e| Failure::from(e).about("path"))?;
        out.set(call.keep_motion(Arc::new(motion))?);
        Ok(Code::MRY_OK)
    })
}

/// Reads the text of a motion.json.
///
/// @param context     The context.
/// @param json        The text.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_STRING.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_from_json(
    context: *mut mry_context,
    json: mry_str,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let json = json.text("json")?;
        let out = Out::new(out_motion, "out_motion")?;
        let motion = Motion::from_json(json).map_err(|e| Failure::from(e).about("json"))?;
        out.set(call.keep_motion(Arc::new(motion))?);
        Ok(Code::MRY_OK)
    })
}

/// Writes a motion as motion.json; the file appears whole or not at all.
///
/// @param context  The context.
/// @param motion   The motion.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_write(
    context: *mut mry_context,
    motion: mry_motion,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = call.motion(motion)?.to_json();
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// The motion as the text of a motion.json.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_to_json(
    context: *mut mry_context,
    motion: mry_motion,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (text, out) = (Buffer::new(text, capacity, "text")?, Out::new(out_size, "out_size")?);
        text.fill_text(&call.motion(motion)?.to_json(), &out)?;
        Ok(Code::MRY_OK)
    })
}

/// Destroys a motion.
///
/// @param context  The context.
/// @param motion   The motion; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_destroy(context: *mut mry_context, motion: mry_motion) -> mry_status {
    ending!(context, |call| {
        if motion.v != 0 {
            call.context.motions.remove(motion.v, "motion")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// What a motion is: size, tracks, frames.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_info(
    context: *mut mry_context,
    motion: mry_motion,
    out_info: *mut mry_motion_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let motion = call.motion(motion)?;
        out.set(&mry_motion_info {
            struct_size: 0,
            width: motion.size.0,
            height: motion.size.1,
            track_count: motion.tracks.len() as u32,
            frame_count: motion.frames as u64,
            fps: motion.fps,
            bone_count: motion.bones.len() as u32,
            reserved0: 0,
        });
        Ok(Code::MRY_OK)
    })
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
        let (name, out) = (Buffer::new(name, capacity, "name")?, Out::new(out_size, "out_size")?);
        let out_kind = Out::optional(out_kind, "out_kind")?;
        let out_point_count = Out::optional(out_point_count, "out_point_count")?;
        let motion = call.motion(motion)?;
        let track = &motion.tracks[track_index(&motion, track)?];
        name.fill_text(&track.name, &out)?;
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
        let points = Buffer::optional(points, capacity, "points")?;
        let visible = Buffer::optional(visible, capacity, "visible")?;
        let confidence = Buffer::optional(confidence, capacity, "confidence")?;
        let out = Out::new(out_count, "out_count")?;
        let motion = call.motion(motion)?;
        let track = &motion.tracks[track_index(&motion, track)?];
        let frame = &track.frames[frame_index(frame, motion.frames)?];
        let count = frame.points.len();
        // The lists have one capacity: the first that is too small speaks for all, before any is written.
        if (points.is_some() || visible.is_some() || confidence.is_some()) && count > capacity {
            out.set(count);
            let message = format!("capacity is {capacity}, and {count} are needed");
            return Err(Failure::new(Code::MRY_E_BUFFER_TOO_SMALL, "capacity", message));
        }
        if let Some(points) = points {
            points.write(&points_out(&frame.points))?;
        }
        if let Some(visible) = visible {
            visible.write(&frame.visible.iter().map(|v| u8::from(*v)).collect::<Vec<u8>>())?;
        }
        if let Some(confidence) = confidence {
            confidence.write(&frame.confidence)?;
        }
        out.set(count);
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

/// The strokes that would help most, the most helpful first: the limbs and frames that are trusted least.
///
/// @param context         The context.
/// @param motion          The motion.
/// @param rig             The rig it came from, so that what is drawn already is left out; or {0}.
/// @param index           0 for the best, then the next.
/// @param out_correction  The answer; its struct_size must be set.
/// @param err             Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there are no more), MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_correction(
    context: *mut mry_context,
    motion: mry_motion,
    rig: mry_rig,
    index: u32,
    out_correction: *mut mry_correction,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_correction, "out_correction")?;
        let motion = call.motion(motion)?;
        let list = if rig.v == 0 {
            corrections(&motion, &Rig { size: motion.size, limbs: Vec::new(), keyframes: Vec::new() })
        } else {
            call.rig(rig, |rig| Ok(corrections(&motion, rig)))?
        };
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "index", format!("there are {} corrections", list.len()));
        let correction = list.get(index as usize).ok_or_else(none)?;
        let track = motion.tracks.iter().position(|t| t.name == correction.limb).ok_or_else(none)?;
        out.set(&mry_correction {
            struct_size: 0,
            track: track as u32,
            frame: correction.frame as u64,
            confidence: correction.confidence,
            reserved0: 0,
        });
        Ok(Code::MRY_OK)
    })
}

/// What there is to say about tracking, as the text of a report.json: counts, warnings, how far each limb is to be
/// trusted, corrections.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param clip      The clip it came from.
/// @param rig       The rig it came from.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_report(
    context: *mut mry_context,
    motion: mry_motion,
    clip: mry_clip,
    rig: mry_rig,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (text, out) = (Buffer::new(text, capacity, "text")?, Out::new(out_size, "out_size")?);
        let (motion, clip) = (call.motion(motion)?, call.clip(clip, "clip")?);
        let report = call.rig(rig, |rig| Ok(Report::new(clip.info(), rig, &motion)))?;
        text.fill_text(&report.to_json(), &out)?;
        Ok(Code::MRY_OK)
    })
}
