//! Bones. A creature's skeleton and where it is in each frame. Bones count from 0, parents come before children.

use std::ffi::c_char;

use marey::shape::Transform;

use crate::border::{List, Out, Text};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::creature::mry_creature;
use crate::error::{Failure, mry_error};
use crate::guard::entry;
use crate::status::{mry_status, mry_status_code as Code};

/// In place of a frame: the rest pose, which the mesh was built in.
pub const MRY_REST_POSE: u64 = u64::MAX;

/// A bone's place relative to its parent; roots are relative to the world. There is no scale.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_transform {
    /// Moved by x, y, z, in world units.
    pub translation: [f32; 3],
    /// Turned by the unit quaternion x, y, z, w.
    pub rotation: [f32; 4],
}

pub(crate) fn transforms_out(transforms: &[Transform]) -> Vec<mry_transform> {
    let out = |t: &Transform| mry_transform { translation: t.translation.into(), rotation: t.rotation.into() };
    transforms.iter().map(out).collect()
}

/// A bone's name and parent.
///
/// @param context     The context.
/// @param creature    The creature.
/// @param bone        Which, below bone_count.
/// @param name        Where the name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity    Bytes at name.
/// @param out_size    Bytes needed, with the NUL.
/// @param out_parent  The parent's index, or -1 for a root; or NULL.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (bone), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_bone(
    context: *mut mry_context,
    creature: mry_creature,
    bone: u32,
    name: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_parent: *mut i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = Text::new(name, capacity, out_size, "name")?;
        let out_parent = Out::optional(out_parent, "out_parent")?;
        let creature = call.creature(creature)?;
        let bones = &creature.model().bones;
        let none = || Failure::argument("bone", format!("bone is {bone}, and there are {}", bones.len()));
        let bone = bones.get(bone as usize).ok_or_else(none)?;
        name.fill(&bone.name)?;
        out_parent.inspect(|out| out.set(bone.parent.map_or(-1, |p| p as i32)));
        Ok(Code::MRY_OK)
    })
}

/// All bones in one frame, or in the rest pose.
///
/// @param context     The context.
/// @param creature    The creature.
/// @param frame       Which, below frame_count, or MRY_REST_POSE.
/// @param transforms  Where they go, one a bone; NULL with capacity 0 to ask for the count.
/// @param capacity    Transforms that fit.
/// @param out_count   Bones of the creature.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_read_pose(
    context: *mut mry_context,
    creature: mry_creature,
    frame: u64,
    transforms: *mut mry_transform,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let transforms = List::new(transforms, capacity, out_count, "transforms")?;
        let creature = call.creature(creature)?;
        let model = creature.model();
        let pose = if frame == MRY_REST_POSE {
            &model.rest
        } else {
            &model.animation[frame_index(frame, model.animation.len())?]
        };
        transforms.fill(&transforms_out(pose))
    })
}
