//! Reconstructing. The whole job: track, segment, and build the creature.

use std::sync::Arc;

use marey::pipeline::{self, PipelineOptions};
use marey::shape::creature::{CreatureParams, Surface};

use crate::border::{self, Out, Versioned};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::creature::{Creature, Origin, mry_creature};
use crate::creature_files::folder_options;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::masks::MaskSet;
use crate::methods::settings;
use crate::rig::mry_rig;
use crate::running::{Part, Product, Work};
use crate::segmenting::folder;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// One connected skin over all limbs. See mry_creature_desc.
pub const MRY_SURFACE_SKIN: u32 = 1;
/// A closed tube around each limb, with a texture each.
pub const MRY_SURFACE_TUBES: u32 = 2;

/// What to make a creature of. Start from MRY_CREATURE_DESC_INIT; clip and rig must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_creature_desc {
    /// sizeof(mry_creature_desc).
    pub struct_size: u32,
    /// With a folder: 1 to write also meshes/00000.obj, ... in world coordinates.
    pub write_obj: u32,
    /// The clip.
    pub clip: mry_clip,
    /// The rig; it must be valid for the clip.
    pub rig: mry_rig,
    /// The tracker: as in mry_track_desc.
    pub tracker: mry_str,
    /// The segmenter: as in mry_segment_desc.
    pub segmenter: mry_str,
    /// Where to write everything, see mry_creature_write_folder; empty for nowhere.
    pub folder: mry_str,
    /// How deep limbs are toward the viewer for their width: "body=0.8,tail=1.2"; empty for what is usual.
    pub depths: mry_str,
    /// How far limbs of a pair stand apart, times what is usual, up to 10; 0 for 1.
    pub spread: f32,
    /// What covers the limbs: MRY_SURFACE_SKIN or MRY_SURFACE_TUBES; 0 for what is usual, the skin.
    pub surface: u32,
}

// SAFETY: repr(C), starts with its u32 size; integers, and strings that the host vouches for.
unsafe impl Versioned for mry_creature_desc {
    const FIRST_SIZE: usize = 72;
}
const _: () = assert!(size_of::<mry_creature_desc>() == 96);

impl Call<'_> {
    unsafe fn creature_work(&self, desc: *const mry_creature_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        // SAFETY: as above.
        let (tracker, segmenter) = unsafe { (self.tracker(desc.tracker)?, self.segmenter(desc.segmenter)?) };
        // SAFETY: as above.
        let (settings, folder) = unsafe { (settings(desc.tracker, desc.segmenter)?, folder(desc.folder)?) };
        let files = folder_options(desc.write_obj, 0.0)?;
        let mut shape = CreatureParams::default();
        shape.surface = match desc.surface {
            0 => shape.surface,
            MRY_SURFACE_SKIN => Surface::Skin,
            MRY_SURFACE_TUBES => Surface::Tubes,
            other => return Err(Failure::argument("desc.surface", format!("desc.surface is {other}; there is none"))),
        };
        if desc.depths.len != 0 {
            // SAFETY: as above.
            let depths = unsafe { desc.depths.text("desc.depths")? };
            shape.depths = CreatureParams::depths_from(depths).map_err(|e| Failure::from(e).about("desc.depths"))?;
        }
        if !desc.spread.is_finite() {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "desc.spread", format!("desc.spread is {}", desc.spread)));
        }
        if !(0.0..=10.0).contains(&desc.spread) {
            return Err(Failure::argument("desc.spread", format!("desc.spread is {}; give up to 10", desc.spread)));
        }
        if desc.spread > 0.0 {
            shape.spread = desc.spread;
        }
        let (clip, rig) = self.clip_and_rig(desc.clip, desc.rig)?;
        Ok(Box::new(move |progress| {
            let mut options = PipelineOptions::new(&*tracker, &*segmenter);
            (options.settings, options.creature) = (settings, shape);
            let made = match &folder {
                None => pipeline::creature(&clip, &rig, &options, progress.whole())?,
                Some(folder) => {
                    pipeline::creature_to_folder(&clip, &rig, &options, folder.as_ref(), &files, progress.whole())?
                }
            };
            let motion = Arc::new(made.motion);
            let masks = Arc::new(MaskSet { masks: made.masks, report: made.report });
            let origin = Origin { clip, rig, masks: masks.clone() };
            let creature = Creature::new(Some(origin), motion.clone(), made.creature);
            Ok(Product {
                motion: Part::Made(motion),
                masks: Part::Made(masks),
                creature: Part::Made(Arc::new(creature)),
                ..Product::default()
            })
        }))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_creature_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_desc_init(desc: *mut mry_creature_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts the whole job: track, segment, reconstruct, and write into a folder where one is given. Gives a motion,
/// masks and a creature.
///
/// @param context  The context.
/// @param desc     What to make a creature of.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the rig is not valid for the clip), MRY_E_UNSUPPORTED (no such tracker or
///         segmenter), MRY_E_STRUCT_SIZE, MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_creature(
    context: *mut mry_context,
    desc: *const mry_creature_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.creature_work(desc)?;
        out.set(call.keep_job(&call.start("creature", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Makes a creature, and returns when it is done. Work that was started before comes first.
///
/// @param context       The context.
/// @param desc          What to make a creature of.
/// @param out_creature  The creature; its motion and masks come from mry_creature_get_motion and _get_masks.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_creature and mry_job_wait return.
/// Lifetime: until mry_creature_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_creature(
    context: *mut mry_context,
    desc: *const mry_creature_desc,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        let work = call.creature_work(desc)?;
        let (_, job) = call.run("creature", work)?;
        job.take(|p| &mut p.creature, |creature| call.keep_creature(creature).map(|id| out.set(id)))
    })
}
