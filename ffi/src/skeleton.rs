//! Skeletons. A character's joints, and the straight bones between them, each from the joint nearer to the root outward and
//! after the one that it hangs from. A change grows the regions anew, a few milliseconds for thousands of vertices; one
//! that fails changes nothing. Joints may lie anywhere; a bone wholly outside the drawing moves nothing.

use std::ffi::c_char;

use marey::shape::character::Skeleton;

use crate::border::{self, Out, Text};
use crate::character::mry_character;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_in};

/// Joints of a character at most; a drawing of a person has some twenty.
pub(crate) const MOST_JOINTS: usize = 10_000;

pub(crate) fn place(at: mry_point, param: &'static str) -> Outcome<marey::Vec2> {
    points_in(&[at]).map(|p| p[0]).map_err(|e| e.about(param))
}

fn below(index: u32, count: usize, param: &'static str) -> Outcome<usize> {
    if (index as usize) < count {
        return Ok(index as usize);
    }
    Err(Failure::argument(param, format!("{param} is {index}, and there are {count}")))
}

impl Call<'_> {
    fn change_skeleton(
        &self,
        character: mry_character,
        change: impl FnOnce(&Skeleton) -> Outcome<Skeleton>,
    ) -> Outcome<Code> {
        self.character_mut(character, |own| {
            let skeleton = change(&own.skeleton)?;
            if skeleton.joints.len() > MOST_JOINTS {
                let message = format!("the skeleton has {MOST_JOINTS} joints, and no more are allowed");
                return Err(Failure::new(Code::MRY_E_LIMIT, "character", message));
            }
            *own = self.context.executor.run(|| own.with_skeleton(skeleton))?;
            Ok(Code::MRY_OK)
        })
    }
}

/// A joint's name and place at rest.
///
/// @param context    The context.
/// @param character  The character.
/// @param joint      Which, below joint_count.
/// @param name       Where the name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity   Bytes at name.
/// @param out_size   Bytes needed, with the NUL.
/// @param out_at     Its place; or NULL.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (joint), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_get_joint(
    context: *mut mry_context,
    character: mry_character,
    joint: u32,
    name: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_at: *mut mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = Text::new(name, capacity, out_size, "name")?;
        let out_at = Out::optional(out_at, "out_at")?;
        let drawn = call.character(character)?;
        let joints = &drawn.character.skeleton.joints;
        let joint = &joints[below(joint, joints.len(), "joint")?];
        name.fill(&joint.name)?;
        out_at.inspect(|out| out.set(mry_point { x: joint.at.x, y: joint.at.y }));
        Ok(Code::MRY_OK)
    })
}

/// The joint of a name.
///
/// @param context    The context.
/// @param character  The character.
/// @param name       Its name.
/// @param out_joint  Its index.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_find_joint(
    context: *mut mry_context,
    character: mry_character,
    name: mry_str,
    out_joint: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.text("name")?;
        let out = Out::new(out_joint, "out_joint")?;
        let drawn = call.character(character)?;
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "name", format!("no joint is called `{name}`"));
        out.set(drawn.character.skeleton.joint(name).ok_or_else(none)? as u32);
        Ok(Code::MRY_OK)
    })
}

/// The two joints of a bone.
///
/// @param context    The context.
/// @param character  The character.
/// @param bone       Which, below bone_count.
/// @param out_from   The joint nearer to the root.
/// @param out_to     The joint that hangs from it.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (bone), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_get_bone(
    context: *mut mry_context,
    character: mry_character,
    bone: u32,
    out_from: *mut u32,
    out_to: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (from, to) = (Out::new(out_from, "out_from")?, Out::new(out_to, "out_to")?);
        let drawn = call.character(character)?;
        let bones = &drawn.character.skeleton.bones;
        let bone = bones[below(bone, bones.len(), "bone")?];
        from.set(bone[0] as u32);
        to.set(bone[1] as u32);
        Ok(Code::MRY_OK)
    })
}

/// Moves all joints at rest.
///
/// @param context    The context.
/// @param character  The character.
/// @param places     Where they are to lie, one for each joint.
/// @param count      How many: joint_count.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (count), MRY_E_NON_FINITE, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_set_joints(
    context: *mut mry_context,
    character: mry_character,
    places: *const mry_point,
    count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let places = points_in(border::slice(places, count, MOST_JOINTS, "places")?).map_err(|e| e.about("places"))?;
        call.change_skeleton(character, |skeleton| {
            let mut own = skeleton.clone();
            if places.len() != own.joints.len() {
                let message = format!("count is {count}, and there are {} joints", own.joints.len());
                return Err(Failure::argument("count", message));
            }
            own.joints.iter_mut().zip(places).for_each(|(joint, at)| joint.at = at);
            Ok(own)
        })
    })
}

/// Gives a joint another name.
///
/// @param context    The context.
/// @param character  The character.
/// @param joint      Which, below joint_count.
/// @param name       Its name, unlike any other's.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (joint, an empty name), MRY_E_INPUT (the name is taken), MRY_E_STRING, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_rename_joint(
    context: *mut mry_context,
    character: mry_character,
    joint: u32,
    name: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let name = name.name("name")?;
        call.change_skeleton(character, |skeleton| {
            let mut own = skeleton.clone();
            let joint = below(joint, own.joints.len(), "joint")?;
            own.joints[joint].name = name.into();
            Ok(own)
        })
    })
}

/// Adds a joint behind the others, with a bone from another joint to it.
///
/// @param context    The context.
/// @param character  The character.
/// @param name       Its name, unlike any other's.
/// @param at         Where it lies at rest.
/// @param parent     The joint that its bone begins at.
/// @param out_joint  Its index.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (parent, an empty name), MRY_E_INPUT (the name is taken), MRY_E_NON_FINITE,
///         MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_add_joint(
    context: *mut mry_context,
    character: mry_character,
    name: mry_str,
    at: mry_point,
    parent: u32,
    out_joint: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let name = name.name("name")?;
        let out = Out::new(out_joint, "out_joint")?;
        let at = place(at, "at")?;
        let mut added = 0;
        let code = call.change_skeleton(character, |skeleton| {
            added = skeleton.joints.len();
            Ok(skeleton.with_joint(name, at, below(parent, added, "parent")?)?)
        })?;
        out.set(added as u32);
        Ok(code)
    })
}

/// Adds a joint behind the others, in the middle of a bone: the bone becomes two.
///
/// @param context    The context.
/// @param character  The character.
/// @param name       Its name, unlike any other's.
/// @param at         Where it lies at rest.
/// @param bone       Which, below bone_count.
/// @param out_joint  Its index.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (bone, an empty name), MRY_E_INPUT (the name is taken), MRY_E_NON_FINITE,
///         MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_split_bone(
    context: *mut mry_context,
    character: mry_character,
    name: mry_str,
    at: mry_point,
    bone: u32,
    out_joint: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let name = name.name("name")?;
        let out = Out::new(out_joint, "out_joint")?;
        let at = place(at, "at")?;
        let mut added = 0;
        let code = call.change_skeleton(character, |skeleton| {
            added = skeleton.joints.len();
            Ok(skeleton.with_split(name, at, below(bone, skeleton.bones.len(), "bone")?)?)
        })?;
        out.set(added as u32);
        Ok(code)
    })
}

/// Takes a joint away; the indices of those behind it go down. What hung from it hangs from the joint before it, or, at a
/// root, from the first of what hung.
///
/// @param context    The context.
/// @param character  The character.
/// @param joint      Which, below joint_count.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (joint), MRY_E_INPUT (no bone would be left), MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_remove_joint(
    context: *mut mry_context,
    character: mry_character,
    joint: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        call.change_skeleton(character, |skeleton| {
            Ok(skeleton.without_joint(below(joint, skeleton.joints.len(), "joint")?)?)
        })
    })
}

/// The place on the drawing's curve skeleton, its middle lines, that is nearest to a place: where a joint snaps to.
///
/// @param context    The context.
/// @param character  The character.
/// @param at         The place.
/// @param out_at     The nearest.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (its rig has no curve), MRY_E_NON_FINITE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_on_curve(
    context: *mut mry_context,
    character: mry_character,
    at: mry_point,
    out_at: *mut mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_at, "out_at")?;
        let at = place(at, "at")?;
        let drawn = call.character(character)?;
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "character", "the character has no curve skeleton");
        let nearest = drawn.character.on_curve(at).ok_or_else(none)?;
        out.set(mry_point { x: nearest.x, y: nearest.y });
        Ok(Code::MRY_OK)
    })
}
