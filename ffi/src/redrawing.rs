//! Redrawing. What a pen does to a pose: a skeleton drawn anew as strokes, a stretch of the outline drawn anew as a curve,
//! and a click that brings a part of the drawing before what it lies behind.

use marey::shape::character::Overlap;

use crate::border::{self, Buffer, List, Lists, Out};
use crate::character::mry_character;
use crate::context::mry_context;
use crate::error::{Failure, mry_error};
use crate::guard::entry;
use crate::posing::{Bound, mry_poser};
use crate::skeleton::{MOST_JOINTS, place};
use crate::status::{mry_status, mry_status_code as Code};
use crate::stroke::{mry_point, points_in, points_out};

/// Vertices of a mesh at most, as the engine has it and then some.
const MOST_POINTS: usize = 1 << 22;

/// Two regions that lie over each other.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_overlap {
    /// The bone in front.
    pub front: u32,
    /// The bone behind.
    pub behind: u32,
    /// The area that they share, in square pixels.
    pub area: f64,
    /// The middle of what they share.
    pub at: mry_point,
    /// 1 where depths put one before the other, 0 where the outer bone is in front because they are equal.
    pub ordered: u32,
    /// Zero.
    pub reserved0: u32,
}
const _: () = assert!(size_of::<mry_overlap>() == 32);

/// The pose that strokes draw: the whole skeleton, or some of its bones, in any order and direction.
///
/// @param context       The context.
/// @param character     The character.
/// @param from          Where each joint was; NULL for the skeleton at rest.
/// @param joint_count   Joints at from and at out_joints: joint_count of the character.
/// @param points        The points of all strokes, one stroke behind the other.
/// @param lengths       How many points each stroke has.
/// @param stroke_count  How many strokes there are.
/// @param out_joints    Where each joint is now.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (strokes that fit no bone, too many of them), MRY_E_ARGUMENT (joint_count),
///         MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_sketch(
    context: *mut mry_context,
    character: mry_character,
    from: *const mry_point,
    joint_count: usize,
    points: *const mry_point,
    lengths: *const u32,
    stroke_count: usize,
    out_joints: *mut mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        border::check(out_joints, "out_joints")?;
        let out = Buffer::new(out_joints, joint_count, "out_joints")?;
        let most = call.context.limits.points;
        let lengths = border::slice(lengths, stroke_count, MOST_JOINTS, "lengths")?;
        let total = lengths.iter().fold(0usize, |sum, n| sum.saturating_add(*n as usize));
        let mut left = points_in(border::slice(points, total, most.saturating_mul(64), "points")?)?;
        let mut strokes = Vec::with_capacity(lengths.len());
        for length in lengths {
            let rest = left.split_off(*length as usize);
            strokes.push(std::mem::replace(&mut left, rest));
        }
        let drawn = call.character(character)?;
        let skeleton = &drawn.character.skeleton;
        let count = skeleton.joints.len();
        if joint_count != count {
            let message = format!("joint_count is {joint_count}, and the skeleton has {count}");
            return Err(Failure::argument("joint_count", message));
        }
        let from = if from.is_null() {
            skeleton.rest()
        } else {
            points_in(border::slice(from, count, count, "from")?).map_err(|e| e.about("from"))?
        };
        let sketched = call.context.executor.run(|| skeleton.sketched(&from, &strokes));
        out.write(&points_out(&sketched.map_err(|e| Failure::from(e).about("points"))?.joints))?;
        Ok(Code::MRY_OK)
    })
}

/// A stretch of the outline drawn anew, of a pose: the vertices that follow the curve, as mry_poses_set_moved takes them.
///
/// @param context      The context.
/// @param poser        The poser, of "needles".
/// @param joints       Where each joint is.
/// @param joint_count  How many: joint_count of the character.
/// @param points       The mesh as it is shown, with what was dragged before.
/// @param point_count  How many: vertex_count of the character.
/// @param curve        The curve, from one place on the outline to another.
/// @param curve_count  Its points.
/// @param vertices     Vertices that move; or NULL.
/// @param ways         How far each does from where it is; or NULL.
/// @param capacity     Vertices that fit into each list.
/// @param out_count    How many there are.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a curve that does not begin and end on the outline, another number of joints or points),
///         MRY_E_BUFFER_TOO_SMALL, MRY_E_UNSUPPORTED (a poser of another deformer), MRY_E_NON_FINITE, MRY_E_LIMIT,
///         MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poser_redraw(
    context: *mut mry_context,
    poser: mry_poser,
    joints: *const mry_point,
    joint_count: usize,
    points: *const mry_point,
    point_count: usize,
    curve: *const mry_point,
    curve_count: usize,
    vertices: *mut u32,
    ways: *mut mry_point,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let mut lists = Lists::new(capacity, out_count)?;
        let vertices = lists.list(vertices, 1, "vertices")?;
        let ways = lists.list(ways, 1, "ways")?;
        let most = call.context.limits.points;
        let joints =
            points_in(border::slice(joints, joint_count, MOST_JOINTS, "joints")?).map_err(|e| e.about("joints"))?;
        let points = points_in(border::slice(points, point_count, MOST_POINTS, "points")?)?;
        let curve = points_in(border::slice(curve, curve_count, most, "curve")?).map_err(|e| e.about("curve"))?;
        let slot = call.get(&call.context.posers, poser.v, "poser")?;
        let kept = slot.value.try_lock().map_err(|e| Failure::locked(&e, "poser", "using"))?;
        let Bound::Needles(poser) = &kept.bound else {
            let message = "only a poser of \"needles\" knows how an outline hangs on its bones";
            return Err(Failure::new(Code::MRY_E_UNSUPPORTED, "poser", message));
        };
        let progress = marey::job::Progress::new();
        let redraw = || poser.redrawn(&joints, &points, &curve, progress.whole());
        let moved = call.context.executor.run(redraw).map_err(|e| Failure::from(e).about("curve"))?;
        lists.fit(moved.len())?;
        if let Some(vertices) = vertices {
            vertices.write(&moved.iter().map(|m| m.0).collect::<Vec<u32>>())?;
        }
        if let Some(ways) = ways {
            ways.write(&points_out(&moved.iter().map(|m| m.1).collect::<Vec<_>>()))?;
        }
        Ok(Code::MRY_OK)
    })
}

/// The regions that lie over each other in a pose, the largest areas first.
///
/// @param context      The context.
/// @param character    The character.
/// @param points       The mesh as it is shown.
/// @param point_count  How many: vertex_count of the character.
/// @param depths       How near each bone's region is; NULL for 0 everywhere.
/// @param depth_count  How many: bone_count of the character, or 0.
/// @param overlaps     Where they go; NULL with capacity 0 to ask for the count.
/// @param capacity     Overlaps that fit.
/// @param out_count    How many there are.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (point_count, depth_count), MRY_E_BUFFER_TOO_SMALL, MRY_E_NON_FINITE, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_read_overlaps(
    context: *mut mry_context,
    character: mry_character,
    points: *const mry_point,
    point_count: usize,
    depths: *const i32,
    depth_count: usize,
    overlaps: *mut mry_overlap,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let overlaps = List::new(overlaps, capacity, out_count, "overlaps")?;
        let points = points_in(border::slice(points, point_count, MOST_POINTS, "points")?)?;
        let depths = border::slice(depths, depth_count, MOST_JOINTS, "depths")?;
        let drawn = call.character(character)?;
        let (vertices, bones) = (drawn.character.mesh.points.len(), drawn.character.skeleton.bones.len());
        if points.len() != vertices {
            let message = format!("point_count is {point_count}, and the mesh has {vertices} points");
            return Err(Failure::argument("point_count", message));
        }
        if !depths.is_empty() && depths.len() != bones {
            let message = format!("depth_count is {depth_count}, and the skeleton has {bones} bones");
            return Err(Failure::argument("depth_count", message));
        }
        let found = call.context.executor.run(|| drawn.character.overlaps(&points, depths));
        let one = |o: &Overlap| mry_overlap {
            front: o.bones[0],
            behind: o.bones[1],
            area: o.area,
            at: mry_point { x: o.at.x, y: o.at.y },
            ordered: u32::from(o.ordered),
            reserved0: 0,
        };
        overlaps.fill(&found.iter().map(one).collect::<Vec<_>>())
    })
}

/// Brings the hindmost region at a place of a pose before the others that lie there.
///
/// @param context      The context.
/// @param character    The character.
/// @param points       The mesh as it is shown.
/// @param point_count  How many: vertex_count of the character.
/// @param depths       How near each bone's region is; changed.
/// @param depth_count  How many: bone_count of the character.
/// @param at           The place.
/// @param out_bone     The bone whose region came forward.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (no two regions lie there), MRY_E_ARGUMENT (point_count, depth_count),
///         MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_bring_forward(
    context: *mut mry_context,
    character: mry_character,
    points: *const mry_point,
    point_count: usize,
    depths: *mut i32,
    depth_count: usize,
    at: mry_point,
    out_bone: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let out = Out::new(out_bone, "out_bone")?;
        border::check(depths, "depths")?;
        let points = points_in(border::slice(points, point_count, MOST_POINTS, "points")?)?;
        let buffer = Buffer::new(depths, depth_count, "depths")?;
        let mut depths = border::slice(depths.cast_const(), depth_count, MOST_JOINTS, "depths")?.to_vec();
        let at = place(at, "at")?;
        let drawn = call.character(character)?;
        let (vertices, bones) = (drawn.character.mesh.points.len(), drawn.character.skeleton.bones.len());
        if points.len() != vertices || depths.len() != bones {
            let message =
                format!("there are {vertices} points and {bones} bones; {point_count} and {depth_count} are given");
            return Err(Failure::argument("point_count", message));
        }
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "at", "no two regions lie there");
        let bone = call.context.executor.run(|| drawn.character.bring_forward(&points, &mut depths, at));
        let bone = bone.ok_or_else(none)?;
        buffer.write(&depths)?;
        out.set(bone);
        Ok(Code::MRY_OK)
    })
}
