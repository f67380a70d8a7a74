//! Posing. A poser is a character bound to its skeleton: joints in, the mesh out, in milliseconds for thousands of
//! vertices. It keeps its work between calls: drag while the pointer moves, and pose when it is let go. To move a mesh by
//! other handles, see mry_deformation_create.

use std::sync::{Arc, Mutex};

use marey::Vec2;
use marey::deform::needles::{AreaRule, NeedleDeformer};
use marey::deform::{Deformation, Deformer, Handle, RestMesh};
use marey::job::Progress;
use marey::shape::character::{Poser, Skeleton};

use crate::border::{self, Buffer, Out};
use crate::character::mry_character;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::skeleton::MOST_JOINTS;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::mry_point;
use crate::table::Table;

/// Area of "needles": every triangle keeps its area.
pub const MRY_AREA_EXACT: i32 = 0;
/// Area of "needles": across a bone by the reciprocal of its length, as the paper has it.
pub const MRY_AREA_RECIPROCAL: i32 = 1;
/// Area of "needles": nothing keeps it.
pub const MRY_AREA_OFF: i32 = 2;

/// Who poses.
pub(crate) enum Who {
    Needles(NeedleDeformer),
    Other(Arc<dyn Deformer>),
}

impl Call<'_> {
    /// # Safety
    /// The string is valid, as the header asks.
    pub(crate) unsafe fn who_poses(
        &self,
        deformer: mry_str,
        area: i32,
        [deformer_param, area_param]: [&'static str; 2],
    ) -> Outcome<Who> {
        let area = match area {
            MRY_AREA_EXACT => AreaRule::Exact,
            MRY_AREA_RECIPROCAL => AreaRule::Reciprocal,
            MRY_AREA_OFF => AreaRule::Off,
            _ => return Err(Failure::argument(area_param, format!("{area_param} is {area}, which is no MRY_AREA"))),
        };
        // SAFETY: as this function's own.
        Ok(match unsafe { deformer.text(deformer_param)? } {
            "" | "needles" => Who::Needles(NeedleDeformer { area, ..NeedleDeformer::default() }),
            other => Who::Other(self.deformer(other, 10).map_err(|e| e.about(deformer_param))?),
        })
    }
}

pub(crate) enum Bound {
    Needles(Box<Poser>),
    Other(Box<dyn Deformation>, Skeleton),
}

/// A poser as the context keeps it, with what it writes into, so that a drag allocates little.
pub(crate) struct Kept {
    pub(crate) bound: Bound,
    joint_count: usize,
    vertex_count: usize,
    joints: Vec<Vec2>,
    shape: Vec<Vec2>,
    out: Vec<mry_point>,
}

pub(crate) type PoserTable = Table<Mutex<Kept>>;

/// A character bound to its skeleton.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_poser {
    /// The id; 0 is no poser.
    pub v: u64,
}

/// Binds a character, as it is now, to its skeleton: milliseconds for thousands of vertices.
///
/// @param context    The context.
/// @param character  The character.
/// @param deformer   "needles", "arap" or a plugin's id; empty for "needles".
/// @param area       What keeps the area, with "needles": MRY_AREA_EXACT, ...
/// @param out_poser  The poser.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (area), MRY_E_INPUT (a skeleton that the deformer cannot use), MRY_E_UNSUPPORTED (no
///         such deformer), MRY_E_STRING, MRY_E_BUSY, what a plugin's work may return.
/// Lifetime: until mry_poser_destroy or the end of the context; the character may change or go before.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poser_create(
    context: *mut mry_context,
    character: mry_character,
    deformer: mry_str,
    area: i32,
    out_poser: *mut mry_poser,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let out = Out::new(out_poser, "out_poser")?;
        let who = call.who_poses(deformer, area, ["deformer", "area"])?;
        let drawn = call.character(character)?;
        let (character, progress) = (&drawn.character, Progress::new());
        let bind = || match who {
            Who::Needles(needles) => Ok(Bound::Needles(Box::new(character.poser(&needles, progress.whole())?))),
            Who::Other(other) => {
                let mesh = RestMesh { points: &character.mesh.points, triangles: &character.mesh.triangles };
                let bones = bones(&character.skeleton, &character.skeleton.rest());
                Ok(Bound::Other(other.bind(mesh, &bones, progress.whole())?, character.skeleton.clone()))
            }
        };
        let bound: marey::Result<Bound> = call.context.executor.run(bind);
        let kept = Kept {
            bound: bound.map_err(|e| Failure::from(e).about("character"))?,
            joint_count: character.skeleton.joints.len(),
            vertex_count: character.mesh.points.len(),
            joints: Vec::new(),
            shape: character.mesh.points.clone(),
            out: Vec::new(),
        };
        out.set(mry_poser { v: call.context.posers.insert(Mutex::new(kept))? });
        Ok(Code::MRY_OK)
    })
}

impl Call<'_> {
    /// # Safety
    /// The places are valid, as the header asks.
    unsafe fn pose(
        &self,
        poser: mry_poser,
        (joints, joint_count): (*const mry_point, usize),
        (points, point_count): (*mut mry_point, usize),
        drag: bool,
    ) -> Outcome<Code> {
        self.context.refuse_callbacks()?;
        border::check(points, "points")?;
        // SAFETY: as this function's own.
        let (buffer, joints) = unsafe {
            (Buffer::new(points, point_count, "points")?, border::slice(joints, joint_count, MOST_JOINTS, "joints")?)
        };
        let slot = self.get(&self.context.posers, poser.v, "poser")?;
        let mut kept = slot.value.try_lock().map_err(|e| Failure::locked(&e, "poser", "using"))?;
        if joint_count != kept.joint_count {
            let message = format!("joint_count is {joint_count}, and the skeleton has {}", kept.joint_count);
            return Err(Failure::argument("joint_count", message));
        }
        buffer.fits(kept.vertex_count)?;
        if let Some(i) = joints.iter().position(|p| !(p.x.is_finite() && p.y.is_finite())) {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "joints", format!("joints[{i}] is not a number")));
        }
        let Kept { bound, joints: places, shape, out, .. } = &mut *kept;
        places.clear();
        places.extend(joints.iter().map(|p| Vec2::new(p.x, p.y)));
        let progress = Progress::new();
        let pose = || match bound {
            Bound::Needles(poser) if drag => poser.drag(places, shape, progress.whole()),
            Bound::Needles(poser) => poser.pose(places, progress.whole()).map(|posed| *shape = posed),
            Bound::Other(deformation, skeleton) => deformation.solve(&bones(skeleton, places), shape, progress.whole()),
        };
        self.context.executor.run(pose).map_err(|e| Failure::from(e).about("joints"))?;
        out.clear();
        out.extend(shape.iter().map(|p| mry_point { x: p.x, y: p.y }));
        buffer.write(out)?;
        Ok(Code::MRY_OK)
    }
}

fn bones(skeleton: &Skeleton, joints: &[Vec2]) -> Vec<Handle> {
    skeleton.segments(joints).into_iter().map(|(a, b)| Handle::Bone(a, b)).collect()
}

/// The mesh with the joints where they are said to be. With "needles" it depends on nothing else; with "arap" and plugins
/// a pose starts from the one before.
///
/// @param context      The context.
/// @param poser        The poser.
/// @param joints       Where each joint is.
/// @param joint_count  How many: joint_count of the character.
/// @param points       Where the mesh goes.
/// @param point_count  Points that fit: at least vertex_count of the character.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (joint_count), MRY_E_BUFFER_TOO_SMALL, MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUSY
///         (another thread is at it), what a plugin's work may return.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poser_pose(
    context: *mut mry_context,
    poser: mry_poser,
    joints: *const mry_point,
    joint_count: usize,
    points: *mut mry_point,
    point_count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| { call.pose(poser, (joints, joint_count), (points, point_count), false) })
}

/// The mesh with the joints where they are said to be, on from the pose before: for drags, many times as fast as a pose and
/// within a pixel of it, but where flesh is pressed together. Pose when the pointer is let go.
///
/// @param context      The context.
/// @param poser        The poser.
/// @param joints       Where each joint is.
/// @param joint_count  How many: joint_count of the character.
/// @param points       Where the mesh goes.
/// @param point_count  Points that fit: at least vertex_count of the character.
/// @param err          Detail of a failure, or NULL.
/// @return As mry_poser_pose.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poser_drag(
    context: *mut mry_context,
    poser: mry_poser,
    joints: *const mry_point,
    joint_count: usize,
    points: *mut mry_point,
    point_count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| { call.pose(poser, (joints, joint_count), (points, point_count), true) })
}

/// Destroys a poser.
///
/// @param context  The context.
/// @param poser    The poser; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poser_destroy(context: *mut mry_context, poser: mry_poser) -> mry_status {
    ending!(context, |call| {
        if poser.v != 0 {
            call.context.posers.remove(poser.v, "poser")?;
        }
        Ok(Code::MRY_OK)
    })
}
