//! Strokes. A stroke is a limb as it is drawn on one frame, from its start to its end; the frames that are drawn on are
//! the key frames. Strokes that start or end near another's start or end are joined there.

use marey::rig::{Facing, KeyFrame, Rig, Stroke};

use crate::border::{self, List, Out};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::limb::limb_index;
use crate::rig::mry_rig;
use crate::status::{mry_status, mry_status_code as Code};

/// A place in clip pixels: x right, y down, the centre of the top-left pixel is (0.5, 0.5).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_point {
    /// Pixels from the left edge.
    pub x: f32,
    /// Pixels from the top edge.
    pub y: f32,
}

impl mry_point {
    /// The place, if it is one.
    pub(crate) fn place(self, param: &'static str) -> Outcome<marey::Vec2> {
        if self.x.is_finite() && self.y.is_finite() {
            return Ok(marey::vec2(self.x, self.y));
        }
        Err(Failure::new(Code::MRY_E_NON_FINITE, param, format!("{param} is ({}, {})", self.x, self.y)))
    }
}

/// Facing of a stroke: in the image plane, or not said.
pub const MRY_FACING_UNKNOWN: i32 = 0;
/// Facing of a stroke: its end is nearer to the viewer than its start.
pub const MRY_FACING_TOWARD: i32 = 1;
/// Facing of a stroke: its end is farther from the viewer than its start.
pub const MRY_FACING_AWAY: i32 = 2;

pub(crate) fn points_in(points: &[mry_point]) -> Outcome<Vec<marey::Vec2>> {
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
pub(crate) fn key_frame(rig: &mut Rig, frame: u64, most: usize) -> Outcome<&mut KeyFrame> {
    let frame = usize::try_from(frame).map_err(|_| Failure::argument("frame", format!("frame is {frame}")))?;
    let at = rig.keyframes.partition_point(|k| k.frame < frame);
    if rig.keyframes.get(at).is_none_or(|k| k.frame != frame) {
        if rig.keyframes.len() >= most {
            let message = format!("the rig has {most} key frames, and no more are allowed");
            return Err(Failure::new(Code::MRY_E_LIMIT, "frame", message));
        }
        rig.keyframes.insert(at, KeyFrame { frame, ..KeyFrame::default() });
    }
    Ok(&mut rig.keyframes[at])
}

/// Drops key frames on which nothing is left.
pub(crate) fn tidy(rig: &mut Rig) {
    rig.keyframes.retain(|k| !(k.strokes.is_empty() && k.paint.is_empty() && k.mask.is_none()));
}

pub(crate) fn facing_in(facing: i32) -> Outcome<Option<Facing>> {
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

fn not_drawn(rig: &Rig, limb: usize, frame: u64) -> Failure {
    let label = rig.limbs.get(limb).map_or("", |l| &l.label);
    Failure::new(Code::MRY_E_NOT_FOUND, "frame", format!("limb `{label}` is not drawn on frame {frame}"))
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
        let points = points_in(border::slice(points, point_count, call.context.limits.points, "points")?)?;
        if points.len() < 2 {
            return Err(Failure::argument(
                "point_count",
                format!("point_count is {point_count}, and a stroke has 2 or more"),
            ));
        }
        let facing = facing_in(facing)?;
        call.rig_mut(rig, |rig| {
            let limb = limb_index(rig, limb)?;
            let key = key_frame(rig, frame, call.context.limits.key_frames)?;
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
        let points = List::new(points, capacity, out_count, "points")?;
        let out_facing = Out::optional(out_facing, "out_facing")?;
        call.rig(rig, |rig| {
            let limb = limb_index(rig, limb)?;
            let stroke = usize::try_from(frame).ok().and_then(|f| rig.stroke(limb, f));
            let stroke = stroke.ok_or_else(|| not_drawn(rig, limb, frame))?;
            points.fill(&points_out(&stroke.points))?;
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
        let frames = List::new(frames, capacity, out_count, "frames")?;
        let keys: Vec<u64> = call.rig(rig, |rig| Ok(rig.keyframes.iter().map(|k| k.frame as u64).collect()))?;
        frames.fill(&keys)
    })
}
