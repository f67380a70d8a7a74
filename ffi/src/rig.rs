//! Rigs. A rig is what a person draws on a clip: labelled limbs, one stroke a limb on each key frame, and hints for
//! the segmenter. Strokes that start or end near another's start or end are joined there. Limbs count from 0 in the
//! order they were added. A rig under construction may be incomplete; mry_rig_validate says what is missing, and every
//! job validates its copy first.

use std::ffi::c_char;
use std::path::PathBuf;
use std::sync::{Arc, RwLock, TryLockError};

use marey::export::write_aside;
use marey::rig::{Facing, KeyFrame, Limb, Paint, Rig, Side, Stroke};

use crate::border::{self, Buffer, Out};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::{Slot, Table};

pub(crate) type RigTable = Table<RwLock<Rig>>;

/// A rig.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_rig {
    /// The id; 0 is no rig.
    pub v: u64,
}

/// A place in clip pixels: x right, y down, the centre of the top-left pixel is (0.5, 0.5).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_point {
    /// Pixels from the left edge.
    pub x: f32,
    /// Pixels from the top edge.
    pub y: f32,
}

/// Side of a limb: not said.
pub const MRY_SIDE_UNKNOWN: i32 = 0;
/// Side of a limb: of a pair, the one toward the viewer.
pub const MRY_SIDE_NEAR: i32 = 1;
/// Side of a limb: of a pair, the one away from the viewer, often hidden.
pub const MRY_SIDE_FAR: i32 = 2;
/// Side of a limb: not of a pair, such as body, neck, head, tail.
pub const MRY_SIDE_MID: i32 = 3;

/// Facing of a stroke: in the image plane, or not said.
pub const MRY_FACING_UNKNOWN: i32 = 0;
/// Facing of a stroke: its end is nearer to the viewer than its start.
pub const MRY_FACING_TOWARD: i32 = 1;
/// Facing of a stroke: its end is farther from the viewer than its start.
pub const MRY_FACING_AWAY: i32 = 2;

/// Paint that marks background.
pub const MRY_PAINT_BACKGROUND: i32 = 0;
/// Paint that marks the creature.
pub const MRY_PAINT_FOREGROUND: i32 = 1;

/// A stroke or a brush path of more points is a mistake of the host's.
const MAX_POINTS: usize = 10_000;
/// Bounds for a rig that grows call by call; the engine's own bound on limbs is lower.
const MAX_KEYFRAMES: usize = 100_000;
const MAX_LIMBS: usize = 256;

impl Call<'_> {
    fn rig_slot(&self, rig: mry_rig) -> Outcome<Arc<Slot<RwLock<Rig>>>> {
        self.get(&self.context.rigs, rig.v, "rig")
    }

    /// Reads a rig, unless it is being changed.
    pub(crate) fn rig<T>(&self, rig: mry_rig, read: impl FnOnce(&Rig) -> Outcome<T>) -> Outcome<T> {
        let slot = self.rig_slot(rig)?;
        match slot.value.try_read() {
            Ok(rig) => read(&rig),
            Err(e) => Err(busy(&e)),
        }
    }

    fn rig_mut<T>(&self, rig: mry_rig, change: impl FnOnce(&mut Rig) -> Outcome<T>) -> Outcome<T> {
        let slot = self.rig_slot(rig)?;
        match slot.value.try_write() {
            Ok(mut rig) => change(&mut rig),
            Err(e) => Err(busy(&e)),
        }
    }
}

fn busy<T>(error: &TryLockError<T>) -> Failure {
    match error {
        TryLockError::WouldBlock => Failure::new(Code::MRY_E_BUSY, "rig", "another thread is changing the rig"),
        TryLockError::Poisoned(_) => Failure::new(Code::MRY_E_POISONED, "rig", "the rig was poisoned; destroy it"),
    }
}

fn limb_index(rig: &Rig, limb: u32) -> Outcome<usize> {
    let count = rig.limbs.len();
    let inside = (limb as usize) < count;
    if inside {
        Ok(limb as usize)
    } else {
        Err(Failure::argument("limb", format!("limb is {limb}, and there are {count}")))
    }
}

fn points_in(points: &[mry_point]) -> Outcome<Vec<marey::Vec2>> {
    let place = |(i, p): (usize, &mry_point)| {
        if p.x.is_finite() && p.y.is_finite() {
            return Ok(marey::vec2(p.x, p.y));
        }
        Err(Failure::new(Code::MRY_E_NON_FINITE, "points", format!("points[{i}] is ({}, {})", p.x, p.y)))
    };
    points.iter().enumerate().map(place).collect()
}

pub(crate) fn points_out(points: &[marey::Vec2]) -> Vec<mry_point> {
    points.iter().map(|p| mry_point { x: p.x, y: p.y }).collect()
}

/// The key frame at `frame`, made where there is none.
fn key_frame(rig: &mut Rig, frame: u64) -> Outcome<&mut KeyFrame> {
    let frame = usize::try_from(frame).map_err(|_| Failure::argument("frame", format!("frame is {frame}")))?;
    let at = rig.keyframes.partition_point(|k| k.frame < frame);
    if rig.keyframes.get(at).is_none_or(|k| k.frame != frame) {
        if rig.keyframes.len() >= MAX_KEYFRAMES {
            let message = format!("the rig has {MAX_KEYFRAMES} key frames, and no more are allowed");
            return Err(Failure::new(Code::MRY_E_LIMIT, "frame", message));
        }
        rig.keyframes.insert(at, KeyFrame { frame, ..KeyFrame::default() });
    }
    Ok(&mut rig.keyframes[at])
}

/// Drops key frames on which nothing is left.
fn tidy(rig: &mut Rig) {
    rig.keyframes.retain(|k| !(k.strokes.is_empty() && k.paint.is_empty() && k.mask.is_none()));
}

fn side_in(side: i32) -> Outcome<Option<Side>> {
    match side {
        MRY_SIDE_UNKNOWN => Ok(None),
        MRY_SIDE_NEAR => Ok(Some(Side::Near)),
        MRY_SIDE_FAR => Ok(Some(Side::Far)),
        MRY_SIDE_MID => Ok(Some(Side::Mid)),
        _ => Err(Failure::argument("side", format!("side is {side}, which is no MRY_SIDE"))),
    }
}

fn side_out(side: Option<Side>) -> i32 {
    match side {
        None => MRY_SIDE_UNKNOWN,
        Some(Side::Near) => MRY_SIDE_NEAR,
        Some(Side::Far) => MRY_SIDE_FAR,
        Some(Side::Mid) => MRY_SIDE_MID,
    }
}

fn facing_in(facing: i32) -> Outcome<Option<Facing>> {
    match facing {
        MRY_FACING_UNKNOWN => Ok(None),
        MRY_FACING_TOWARD => Ok(Some(Facing::Toward)),
        MRY_FACING_AWAY => Ok(Some(Facing::Away)),
        _ => Err(Failure::argument("facing", format!("facing is {facing}, which is no MRY_FACING"))),
    }
}

fn facing_out(facing: Option<Facing>) -> i32 {
    match facing {
        None => MRY_FACING_UNKNOWN,
        Some(Facing::Toward) => MRY_FACING_TOWARD,
        Some(Facing::Away) => MRY_FACING_AWAY,
    }
}

/// Creates an empty rig.
///
/// @param context  The context.
/// @param width    The clip's pixels across, at least 1.
/// @param height   The clip's pixels down, at least 1.
/// @param out_rig  The rig.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT.
/// Lifetime: until mry_rig_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_create(
    context: *mut mry_context,
    width: u32,
    height: u32,
    out_rig: *mut mry_rig,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_rig, "out_rig")?;
        for (value, param) in [(width, "width"), (height, "height")] {
            if value == 0 {
                return Err(Failure::argument(param, format!("{param} is 0; give the clip's")));
            }
        }
        let rig = Rig { size: (width, height), limbs: Vec::new(), keyframes: Vec::new() };
        out.set(mry_rig { v: call.context.rigs.insert(RwLock::new(rig))? });
        Ok(Code::MRY_OK)
    })
}

/// Reads a strokes.json file.
///
/// @param context  The context.
/// @param path     The file; masks are looked for beside it.
/// @param out_rig  The rig, valid.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT, MRY_E_LIMIT, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_rig_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_read(
    context: *mut mry_context,
    path: mry_str,
    out_rig: *mut mry_rig,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_rig, "out_rig")?;
        let rig = Rig::read(path).map_err(|e| Failure::from(e).about("path"))?;
        out.set(mry_rig { v: call.context.rigs.insert(RwLock::new(rig))? });
        Ok(Code::MRY_OK)
    })
}

/// Reads the text of a strokes.json.
///
/// @param context  The context.
/// @param json     The text.
/// @param out_rig  The rig, valid.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_STRING.
/// Lifetime: until mry_rig_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_from_json(
    context: *mut mry_context,
    json: mry_str,
    out_rig: *mut mry_rig,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let json = json.text("json")?;
        let out = Out::new(out_rig, "out_rig")?;
        let rig = Rig::from_json(json).map_err(|e| Failure::from(e).about("json"))?;
        out.set(mry_rig { v: call.context.rigs.insert(RwLock::new(rig))? });
        Ok(Code::MRY_OK)
    })
}

/// Writes a rig as strokes.json, complete or not; the file appears whole or not at all.
///
/// @param context  The context.
/// @param rig      The rig.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_write(
    context: *mut mry_context,
    rig: mry_rig,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = call.rig(rig, |rig| Ok(rig.to_json()))?;
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// The rig as the text of a strokes.json.
///
/// @param context   The context.
/// @param rig       The rig.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_to_json(
    context: *mut mry_context,
    rig: mry_rig,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (text, out) = (Buffer::new(text, capacity, "text")?, Out::new(out_size, "out_size")?);
        let json = call.rig(rig, |rig| Ok(rig.to_json()))?;
        text.fill_text(&json, &out)?;
        Ok(Code::MRY_OK)
    })
}

/// Destroys a rig. Jobs that were started with it keep their copy.
///
/// @param context  The context.
/// @param rig      The rig; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_destroy(context: *mut mry_context, rig: mry_rig) -> mry_status {
    ending!(context, |call| {
        if rig.v != 0 {
            call.context.rigs.remove(rig.v, "rig")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// Adds a limb: a body part that does not branch.
///
/// @param context   The context.
/// @param rig       The rig.
/// @param label     Its name, unique in the rig.
/// @param side      MRY_SIDE_UNKNOWN, ...
/// @param out_limb  Its index.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (label in use or empty, side), MRY_E_STRING, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_add_limb(
    context: *mut mry_context,
    rig: mry_rig,
    label: mry_str,
    side: i32,
    out_limb: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let label = label.name("label")?;
        let side = side_in(side)?;
        let out = Out::new(out_limb, "out_limb")?;
        call.rig_mut(rig, |rig| {
            if rig.limbs.iter().any(|l| l.label == label) {
                return Err(Failure::argument("label", format!("limb `{label}` is in the rig already")));
            }
            if rig.limbs.len() >= MAX_LIMBS {
                let message = format!("the rig has {MAX_LIMBS} limbs, and no more are allowed");
                return Err(Failure::new(Code::MRY_E_LIMIT, "rig", message));
            }
            rig.limbs.push(Limb { label: label.to_owned(), side });
            out.set(rig.limbs.len() as u32 - 1);
            Ok(Code::MRY_OK)
        })
    })
}

/// How many limbs the rig has.
///
/// @param context    The context.
/// @param rig        The rig.
/// @param out_count  The number.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_get_limb_count(
    context: *mut mry_context,
    rig: mry_rig,
    out_count: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_count, "out_count")?;
        out.set(call.rig(rig, |rig| Ok(rig.limbs.len() as u32))?);
        Ok(Code::MRY_OK)
    })
}

/// A limb's label and side.
///
/// @param context   The context.
/// @param rig       The rig.
/// @param limb      Its index.
/// @param label     Where the label goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at label.
/// @param out_size  Bytes needed, with the NUL.
/// @param out_side  MRY_SIDE_UNKNOWN, ...; or NULL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_get_limb(
    context: *mut mry_context,
    rig: mry_rig,
    limb: u32,
    label: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_side: *mut i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (text, out) = (Buffer::new(label, capacity, "label")?, Out::new(out_size, "out_size")?);
        let out_side = Out::optional(out_side, "out_side")?;
        let limb = call.rig(rig, |rig| Ok(rig.limbs[limb_index(rig, limb)?].clone()))?;
        text.fill_text(&limb.label, &out)?;
        out_side.inspect(|out| out.set(side_out(limb.side)));
        Ok(Code::MRY_OK)
    })
}

/// Draws a limb on a frame, which becomes a key frame; an earlier stroke of the limb there is replaced.
///
/// @param context      The context.
/// @param rig          The rig.
/// @param limb         Its index.
/// @param frame        The frame, counted from 0.
/// @param points       The stroke, from the limb's start to its end; it may leave the image.
/// @param point_count  2 to 10000.
/// @param facing       MRY_FACING_UNKNOWN, ...
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb, point_count, facing), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_set_stroke(
    context: *mut mry_context,
    rig: mry_rig,
    limb: u32,
    frame: u64,
    points: *const mry_point,
    point_count: usize,
    facing: i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let points = points_in(border::slice(points, point_count, MAX_POINTS, "points")?)?;
        if points.len() < 2 {
            return Err(Failure::argument(
                "point_count",
                format!("point_count is {point_count}, and a stroke has 2 or more"),
            ));
        }
        let facing = facing_in(facing)?;
        call.rig_mut(rig, |rig| {
            let limb = limb_index(rig, limb)?;
            let key = key_frame(rig, frame)?;
            key.strokes.retain(|s| s.limb != limb);
            key.strokes.push(Stroke { limb, points, facing });
            key.strokes.sort_by_key(|s| s.limb);
            Ok(Code::MRY_OK)
        })
    })
}

/// Takes a limb's stroke off a frame.
///
/// @param context  The context.
/// @param rig      The rig.
/// @param limb     Its index.
/// @param frame    The frame.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_NOT_FOUND (the limb is not drawn there), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_remove_stroke(
    context: *mut mry_context,
    rig: mry_rig,
    limb: u32,
    frame: u64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.rig_mut(rig, |rig| {
            let limb = limb_index(rig, limb)?;
            let key = rig.keyframes.iter_mut().find(|k| k.frame as u64 == frame);
            let drawn = key.and_then(|k| Some((k.strokes.iter().position(|s| s.limb == limb)?, k)));
            let Some((at, key)) = drawn else { return Err(not_drawn(rig, limb, frame)) };
            key.strokes.remove(at);
            tidy(rig);
            Ok(Code::MRY_OK)
        })
    })
}

fn not_drawn(rig: &Rig, limb: usize, frame: u64) -> Failure {
    let label = rig.limbs.get(limb).map_or("", |l| &l.label);
    Failure::new(Code::MRY_E_NOT_FOUND, "frame", format!("limb `{label}` is not drawn on frame {frame}"))
}

/// A limb's stroke on a key frame.
///
/// @param context     The context.
/// @param rig         The rig.
/// @param limb        Its index.
/// @param frame       The frame.
/// @param points      Where the points go; NULL with capacity 0 to ask for the count.
/// @param capacity    Points that fit.
/// @param out_count   Points of the stroke.
/// @param out_facing  MRY_FACING_UNKNOWN, ...; or NULL.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_NOT_FOUND (the limb is not drawn there), MRY_E_BUFFER_TOO_SMALL,
///         MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_get_stroke(
    context: *mut mry_context,
    rig: mry_rig,
    limb: u32,
    frame: u64,
    points: *mut mry_point,
    capacity: usize,
    out_count: *mut usize,
    out_facing: *mut i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (points, out) = (Buffer::new(points, capacity, "points")?, Out::new(out_count, "out_count")?);
        let out_facing = Out::optional(out_facing, "out_facing")?;
        call.rig(rig, |rig| {
            let limb = limb_index(rig, limb)?;
            let stroke = usize::try_from(frame).ok().and_then(|f| rig.stroke(limb, f));
            let stroke = stroke.ok_or_else(|| not_drawn(rig, limb, frame))?;
            points.fill(&points_out(&stroke.points), &out)?;
            out_facing.inspect(|out| out.set(facing_out(stroke.facing)));
            Ok(Code::MRY_OK)
        })
    })
}

/// The key frames, rising.
///
/// @param context    The context.
/// @param rig        The rig.
/// @param frames     Where they go; NULL with capacity 0 to ask for the count.
/// @param capacity   Frames that fit.
/// @param out_count  Key frames of the rig.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_get_keyframes(
    context: *mut mry_context,
    rig: mry_rig,
    frames: *mut u64,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (frames, out) = (Buffer::new(frames, capacity, "frames")?, Out::new(out_count, "out_count")?);
        let keys: Vec<u64> = call.rig(rig, |rig| Ok(rig.keyframes.iter().map(|k| k.frame as u64).collect()))?;
        frames.fill(&keys, &out)?;
        Ok(Code::MRY_OK)
    })
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
        let points = points_in(border::slice(points, point_count, MAX_POINTS, "points")?)?;
        if points.is_empty() {
            return Err(Failure::argument("point_count", "point_count is 0, and paint has 1 or more"));
        }
        let foreground = match kind {
            MRY_PAINT_FOREGROUND => true,
            MRY_PAINT_BACKGROUND => false,
            _ => return Err(Failure::argument("kind", format!("kind is {kind}, which is no MRY_PAINT"))),
        };
        if !radius.is_finite() {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "radius", format!("radius is {radius}")));
        }
        if radius <= 0.0 {
            return Err(Failure::argument("radius", format!("radius is {radius}, and must be above 0")));
        }
        call.rig_mut(rig, |rig| {
            key_frame(rig, frame)?.paint.push(Paint { foreground, radius, points });
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
            key_frame(rig, frame)?.mask = path;
            tidy(rig);
            Ok(Code::MRY_OK)
        })
    })
}

/// The longest drawn length of a limb: what a drawing tool shows a person who draws it again.
///
/// @param context     The context.
/// @param rig         The rig.
/// @param limb        Its index.
/// @param out_length  Clip pixels; 0 for a limb that is not drawn.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_get_length_hint(
    context: *mut mry_context,
    rig: mry_rig,
    limb: u32,
    out_length: *mut f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_length, "out_length")?;
        out.set(call.rig(rig, |rig| Ok(rig.length_hint(limb_index(rig, limb)?)))?);
        Ok(Code::MRY_OK)
    })
}

/// Whether jobs can work with the rig: each limb drawn somewhere, strokes within reach of the image, and so on.
///
/// @param context  The context.
/// @param rig      The rig.
/// @param clip     The clip it is for, whose size and length it must fit; {0} to leave that out.
/// @param err      What is missing or wrong, where, and what to do; or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_validate(
    context: *mut mry_context,
    rig: mry_rig,
    clip: mry_clip,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let clip = if clip.v == 0 { None } else { Some(call.clip(clip, "clip")?) };
        let fit = clip.map(|c| ((c.info().width, c.info().height), c.info().frames));
        call.rig(rig, |rig| rig.validate(fit).map_err(|e| Failure::from(e).about("rig")))?;
        Ok(Code::MRY_OK)
    })
}
