//! Strokes. A stroke is a limb as it is drawn on one frame, from its start to its end; the frames that are drawn on are
//! the key frames. Strokes that start or end near another's start or end are joined there.

use marey::rig::{Facing, KeyFrame, LimbDepth, Rig, Stroke};

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

/// Said of a limb on a frame: how far its free part stands from where it would, toward the viewer.
pub const MRY_SAID_DEPTH: u32 = 1;
/// Said of a limb on a frame: how far its free end stands from where the limb is held, toward the viewer, whatever its
/// length in the image says.
pub const MRY_SAID_BEND: u32 = 2;

/// A mark of the bits of `said`; none for none.
pub(crate) fn depth_in(said: u32, depth: f32, bend: f32) -> Outcome<Option<LimbDepth>> {
    if said & !(MRY_SAID_DEPTH | MRY_SAID_BEND) != 0 {
        return Err(Failure::argument("said", format!("said is {said}, which is more than the MRY_SAID bits")));
    }
    let of = |bit: u32, value: f32, param: &'static str| match (said & bit != 0, value.is_finite()) {
        (false, _) => Ok(None),
        (true, true) => Ok(Some(value)),
        (true, false) => Err(Failure::new(Code::MRY_E_NON_FINITE, param, format!("{param} is {value}"))),
    };
    let mark =
        LimbDepth { limb: 0, depth: of(MRY_SAID_DEPTH, depth, "depth")?, bend: of(MRY_SAID_BEND, bend, "bend")? };
    Ok((said != 0).then_some(mark))
}

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
    rig.keyframes.retain(|k| !(k.strokes.is_empty() && k.depths.is_empty() && k.paint.is_empty() && k.mask.is_none()));
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

/// Says where a limb is in depth on a frame, which becomes a key frame; the limb need not be drawn there. It holds on
/// that frame and fades toward the limb's key frames around it.
///
/// @param context  The context.
/// @param rig      The rig.
/// @param limb     Its index.
/// @param frame    The frame, counted from 0.
/// @param said     MRY_SAID_DEPTH and MRY_SAID_BEND, or 0 to take back what was said.
/// @param depth    How far its free part stands from where it would, in clip pixels toward the viewer.
/// @param bend     How far its free end stands from where it is held, in clip pixels toward the viewer.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb, said), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_set_depth(
    context: *mut mry_context,
    rig: mry_rig,
    limb: u32,
    frame: u64,
    said: u32,
    depth: f32,
    bend: f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let mark = depth_in(said, depth, bend)?;
        call.rig_mut(rig, |rig| {
            let limb = limb_index(rig, limb)?;
            let key = key_frame(rig, frame, call.context.limits.key_frames)?;
            key.depths.retain(|d| d.limb != limb);
            key.depths.extend(mark.map(|mark| LimbDepth { limb, ..mark }));
            key.depths.sort_by_key(|d| d.limb);
            tidy(rig);
            Ok(Code::MRY_OK)
        })
    })
}

/// Where a limb is said to be in depth on a frame.
///
/// @param context    The context.
/// @param rig        The rig.
/// @param limb       Its index.
/// @param frame      The frame.
/// @param out_said   MRY_SAID_DEPTH and MRY_SAID_BEND; 0 where nothing is said.
/// @param out_depth  As for mry_rig_set_depth, 0 where it is not said; or NULL.
/// @param out_bend   As for mry_rig_set_depth, 0 where it is not said; or NULL.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_get_depth(
    context: *mut mry_context,
    rig: mry_rig,
    limb: u32,
    frame: u64,
    out_said: *mut u32,
    out_depth: *mut f32,
    out_bend: *mut f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out_said = Out::new(out_said, "out_said")?;
        let outs = (Out::optional(out_depth, "out_depth")?, Out::optional(out_bend, "out_bend")?);
        call.rig(rig, |rig| {
            let limb = limb_index(rig, limb)?;
            let key = rig.keyframes.iter().find(|k| k.frame as u64 == frame);
            let mark = key.and_then(|k| k.depths.iter().find(|d| d.limb == limb)).copied().unwrap_or_default();
            let bit = |value: Option<f32>, bit: u32| value.map_or(0, |_| bit);
            out_said.set(bit(mark.depth, MRY_SAID_DEPTH) | bit(mark.bend, MRY_SAID_BEND));
            outs.0.inspect(|out| out.set(mark.depth.unwrap_or(0.0)));
            outs.1.inspect(|out| out.set(mark.bend.unwrap_or(0.0)));
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
