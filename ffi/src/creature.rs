//! Creatures. A creature is a textured mesh, one skin or a tube a limb, on bones that move over the clip's frames: linear
//! blend skinning as glTF 2.0 has it. World coordinates: right-handed, x right, y up, z toward the viewer, 1 unit =
//! 1 pixel of the clip, origin at the clip's bottom left. Creatures do not change. They come from jobs, or from files
//! (mry_creature_open).

use std::ffi::c_char;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use marey::clip::Clip;
use marey::geometry::TriMesh;
use marey::motion::Motion;
use marey::rig::Rig;
use marey::shape::creature;
use marey::shape::{RiggedModel, SkinnedPart};

use crate::border::{self, Out, OutStruct, Text, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::masks::{MaskSet, mry_masks};
use crate::motion::mry_motion;
use crate::status::{mry_status, mry_status_code as Code};
use crate::table::Table;

/// What a creature was reconstructed from, so that its folder can be written at any time.
pub(crate) struct Origin {
    pub(crate) clip: Arc<Clip>,
    pub(crate) rig: Rig,
    pub(crate) masks: Arc<MaskSet>,
}

/// A creature and what moves it.
pub(crate) struct Creature {
    /// None for one that was opened from a file.
    pub(crate) origin: Option<Origin>,
    pub(crate) motion: Arc<Motion>,
    pub(crate) creature: Arc<creature::Creature>,
    /// The frame that was posed last: a host reads all parts of one frame in turn.
    posed: Mutex<Option<(usize, Arc<Vec<TriMesh>>)>>,
    /// The model made ready for drawing, once it was drawn.
    drawable: OnceLock<marey_render::Model>,
}

impl Creature {
    pub(crate) fn new(origin: Option<Origin>, motion: Arc<Motion>, creature: creature::Creature) -> Self {
        let creature = Arc::new(creature);
        Self { origin, motion, creature, posed: Mutex::new(None), drawable: OnceLock::new() }
    }

    pub(crate) fn model(&self) -> &RiggedModel {
        &self.creature.model
    }

    /// The model made ready for drawing.
    pub(crate) fn drawable(&self) -> marey::Result<marey_render::Model> {
        if let Some(drawable) = self.drawable.get() {
            return Ok(drawable.clone());
        }
        let drawable = marey_render::Model::new(self.model().clone())?;
        Ok(self.drawable.get_or_init(|| drawable).clone())
    }

    /// What it was reconstructed from.
    pub(crate) fn origin(&self) -> marey::Result<&Origin> {
        let problem = "was opened from a file, which holds no clip, masks or report";
        let remedy = "ask the creature that was reconstructed";
        self.origin.as_ref().ok_or_else(|| marey::Error::invalid("the creature", problem, remedy))
    }

    pub(crate) fn pose(&self, frame: usize) -> Arc<Vec<TriMesh>> {
        let last = self.posed.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match last {
            Some((posed, meshes)) if posed == frame => meshes,
            _ => {
                let meshes = Arc::new(self.model().pose(frame));
                *self.posed.lock().unwrap_or_else(PoisonError::into_inner) = Some((frame, meshes.clone()));
                meshes
            }
        }
    }

    pub(crate) fn part(&self, part: u32) -> Outcome<&SkinnedPart> {
        let count = self.model().parts.len();
        let none = || Failure::argument("part", format!("part is {part}, and there are {count}"));
        self.model().parts.get(part as usize).ok_or_else(none)
    }
}

pub(crate) type CreatureTable = Table<Arc<Creature>>;

/// A creature.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_creature {
    /// The id; 0 is no creature.
    pub v: u64,
}

/// What a creature is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_creature_info {
    /// sizeof(mry_creature_info).
    pub struct_size: u32,
    /// The clip's pixels across.
    pub width: u32,
    /// The clip's pixels down.
    pub height: u32,
    /// How many bones there are.
    pub bone_count: u32,
    /// How many parts there are.
    pub part_count: u32,
    /// How many limbs there are, see mry_creature_get_limb.
    pub limb_count: u32,
    /// How many frames the animation has.
    pub frame_count: u64,
    /// Frames a second.
    pub fps: f64,
    /// Vertices of all parts.
    pub vertex_count: u64,
    /// Triangles of all parts.
    pub triangle_count: u64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_creature_info {
    const FIRST_SIZE: usize = 56;
}
const _: () = assert!(size_of::<mry_creature_info>() == 56);

impl Call<'_> {
    pub(crate) fn creature(&self, creature: mry_creature) -> Outcome<Arc<Creature>> {
        Ok(self.get(&self.context.creatures, creature.v, "creature")?.value.clone())
    }

    pub(crate) fn keep_creature(&self, creature: Arc<Creature>) -> Outcome<mry_creature> {
        Ok(mry_creature { v: self.context.creatures.insert(creature)? })
    }
}

/// Fills in a creature info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_creature_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_info_init(info: *mut mry_creature_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Destroys a creature. A motion and masks that were got from it live on.
///
/// @param context   The context.
/// @param creature  The creature; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_destroy(context: *mut mry_context, creature: mry_creature) -> mry_status {
    ending!(context, |call| {
        if creature.v != 0 {
            call.context.creatures.remove(creature.v, "creature")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// What a creature is: counts, frames, rate.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_info(
    context: *mut mry_context,
    creature: mry_creature,
    out_info: *mut mry_creature_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let creature = call.creature(creature)?;
        let model = creature.model();
        out.set(&mry_creature_info {
            struct_size: 0,
            width: model.size.0,
            height: model.size.1,
            bone_count: model.bones.len() as u32,
            part_count: model.parts.len() as u32,
            limb_count: creature.creature.limbs.len() as u32,
            frame_count: model.animation.len() as u64,
            fps: model.fps,
            vertex_count: model.parts.iter().map(|p| p.mesh.positions.len() as u64).sum(),
            triangle_count: model.parts.iter().map(|p| p.mesh.triangles.len() as u64).sum(),
        });
        Ok(Code::MRY_OK)
    })
}

/// The motion that drives the creature.
///
/// @param context     The context.
/// @param creature    The creature.
/// @param out_motion  The motion, an object of its own.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_LIMIT.
/// Lifetime: until mry_motion_destroy or the end of the context; the creature may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_motion(
    context: *mut mry_context,
    creature: mry_creature,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let creature = call.creature(creature)?;
        out.set(call.keep_motion(creature.motion.clone())?);
        Ok(Code::MRY_OK)
    })
}

/// The masks that the creature was built from.
///
/// @param context    The context.
/// @param creature   The creature.
/// @param out_masks  The masks, an object of their own.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_LIMIT.
/// Lifetime: until mry_masks_destroy or the end of the context; the creature may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_masks(
    context: *mut mry_context,
    creature: mry_creature,
    out_masks: *mut mry_masks,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_masks, "out_masks")?;
        let creature = call.creature(creature)?;
        out.set(call.keep_masks(creature.origin()?.masks.clone())?);
        Ok(Code::MRY_OK)
    })
}

/// The report of the job that made the creature, as the text of its report.json: counts, seconds, warnings,
/// corrections.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_report(
    context: *mut mry_context,
    creature: mry_creature,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        text.fill(&call.creature(creature)?.origin()?.masks.report.to_json())
    })
}
