//! Textures. What a creature wears: its textures out and in as pictures that a person paints on, and textures taken from
//! other frames, another creature, a picture or a material.

use std::path::PathBuf;
use std::sync::Arc;

use marey::export::{read_textures, write_textures};
use marey::raster::Mask;
use marey::shape::character::{read_cut, read_drawing};
use marey::shape::creature::texturing::{BakeParams, Footage, Material, Region, transfer};

use crate::border::{self, Out, Versioned};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::creature::{Creature, mry_creature};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::masks::mry_masks;
use crate::rendering::masks_of;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Textures come from frames of a clip of the creature.
pub const MRY_TEXTURE_FRAMES: i32 = 0;
/// Textures come from another creature, limb by limb of the same label.
pub const MRY_TEXTURE_CREATURE: i32 = 1;
/// Textures come from a picture of the creature's side, stretched over it as the clip's camera sees it at rest.
pub const MRY_TEXTURE_SIDE: i32 = 2;
/// Textures come from a picture of a material, which repeats over the surface without a seam.
pub const MRY_TEXTURE_REPEATED: i32 = 3;

/// No creature has more limbs.
const MOST_LIMBS: usize = 256;

/// What a creature is to wear. Start from MRY_TEXTURE_DESC_INIT; creature must be set, and what `from` needs.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_texture_desc {
    /// sizeof(mry_texture_desc).
    pub struct_size: u32,
    /// MRY_TEXTURE_FRAMES, ...
    pub from: i32,
    /// The creature.
    pub creature: mry_creature,
    /// With MRY_TEXTURE_FRAMES: the clip that the creature was made of.
    pub clip: mry_clip,
    /// With MRY_TEXTURE_FRAMES: its masks; or mask_clip.
    pub masks: mry_masks,
    /// The same as a clip of pictures that are bright where the creature is, such as the masks/ of its folder.
    pub mask_clip: mry_clip,
    /// With MRY_TEXTURE_FRAMES: the first frame that gives colours.
    pub first_frame: u64,
    /// With MRY_TEXTURE_FRAMES: how many frames give colours; 0 for all from the first on.
    pub frame_count: u64,
    /// With MRY_TEXTURE_CREATURE: the other creature.
    pub source: mry_creature,
    /// With MRY_TEXTURE_SIDE and MRY_TEXTURE_REPEATED: the picture, a file.
    pub picture: mry_str,
    /// With MRY_TEXTURE_REPEATED: how wide one piece is, in world units; 0 for the picture's pixels.
    pub width: f32,
    /// Over so many world units the border of what is replaced runs from the old colours to the new ones.
    pub soft: f32,
    /// Labels of the limbs that are replaced; NULL for all.
    pub limbs: *const mry_str,
    /// How many.
    pub limb_count: usize,
    /// Of those, what lies where this picture, a file of the clip's size, is bright, as the creature is seen at rest; empty
    /// for all.
    pub region: mry_str,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and strings that the host vouches for.
unsafe impl Versioned for mry_texture_desc {
    const FIRST_SIZE: usize = 120;
}
const _: () = assert!(size_of::<mry_texture_desc>() == 120);

/// Where textures come from, with all that is needed for them.
enum From {
    Frames { clip: Arc<marey::clip::Clip>, masks: Vec<Mask>, painted: Option<Arc<marey::clip::Clip>> },
    Creature(Arc<Creature>),
    Side(PathBuf),
    Repeated(PathBuf, f32),
}

impl Call<'_> {
    unsafe fn texture_work(&self, desc: *const mry_texture_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        let creature = self.creature(desc.creature)?;
        if !(desc.width.is_finite() && desc.soft.is_finite()) {
            let message = format!("desc.width is {}, desc.soft is {}", desc.width, desc.soft);
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "desc.width", message));
        }
        // SAFETY: as above.
        let (limbs, region) = unsafe {
            let limbs = border::slice(desc.limbs, desc.limb_count, MOST_LIMBS, "desc.limbs")?;
            let limbs = limbs.iter().map(|l| Ok(l.text("desc.limbs")?.to_owned())).collect::<Outcome<Vec<String>>>()?;
            (limbs, if desc.region.len == 0 { None } else { Some(PathBuf::from(desc.region.name("desc.region")?)) })
        };
        // SAFETY: as above.
        let picture = || Ok::<_, Failure>(PathBuf::from(unsafe { desc.picture.name("desc.picture")? }));
        let from = match desc.from {
            MRY_TEXTURE_FRAMES => From::Frames {
                clip: self.clip(desc.clip, "desc.clip")?,
                masks: if desc.masks.v == 0 { Vec::new() } else { self.masks(desc.masks)?.masks.clone() },
                painted: if desc.masks.v == 0 { Some(self.clip(desc.mask_clip, "desc.mask_clip")?) } else { None },
            },
            MRY_TEXTURE_CREATURE => From::Creature(self.creature(desc.source).map_err(|e| e.about("desc.source"))?),
            MRY_TEXTURE_SIDE => From::Side(picture()?),
            MRY_TEXTURE_REPEATED => From::Repeated(picture()?, desc.width),
            from => {
                return Err(Failure::argument("desc.from", format!("desc.from is {from}, which is no MRY_TEXTURE")));
            }
        };
        let frames = creature.model().animation.len();
        let first = usize::try_from(desc.first_frame).unwrap_or(usize::MAX);
        let last = match desc.frame_count {
            0 => frames.saturating_sub(1),
            count => first.saturating_add(usize::try_from(count).unwrap_or(usize::MAX) - 1),
        };
        if matches!(from, From::Frames { .. }) && (first > last || last >= frames) {
            let message = format!("frames {first} to {last} are asked for, and there are {frames}");
            return Err(Failure::argument("desc.first_frame", message));
        }
        Ok(Box::new(move |progress| {
            let stage = progress.whole();
            stage.name("texturing")?;
            let mut made = (*creature.creature).clone();
            let mut params = BakeParams::of(&made);
            let region = region.map(|path| read_cut(&path)).transpose()?.map(|cut| Mask::from_image(&cut));
            let region = Region { limbs: &limbs, mask: region.as_ref(), soft: desc.soft };
            let model = &mut made.model;
            match &from {
                From::Frames { clip, masks, painted } => {
                    params.frames = (first, last);
                    params.key_frame = params.key_frame.clamp(first, last);
                    let painted = painted.as_ref().map(|p| masks_of(p, frames)).transpose()?;
                    let masks = painted.as_deref().unwrap_or(masks);
                    let footage = Footage { clip, masks, motion: Some(&creature.motion) };
                    transfer(model, &Material::Frames(footage), &region, &params, stage)?;
                }
                From::Creature(other) => {
                    let material = Material::Creature { model: other.model(), limbs: &[] };
                    transfer(model, &material, &region, &params, stage)?;
                }
                From::Side(path) => {
                    transfer(model, &Material::Side(&read_drawing(path)?), &region, &params, stage)?;
                }
                From::Repeated(path, width) => {
                    let picture = image::DynamicImage::from(read_drawing(path)?).into_rgb8();
                    let width = if *width == 0.0 { picture.width() as f32 } else { *width };
                    transfer(model, &Material::Repeated { picture: &picture, width }, &region, &params, stage)?;
                }
            }
            let creature = Creature::new(None, creature.motion.clone(), made);
            Ok(Product { creature: Part::Made(Arc::new(creature)), ..Product::default() })
        }))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_texture_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_texture_desc_init(desc: *mut mry_texture_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts giving a creature other textures. Gives a creature, which mry_job_take_creature takes; the one it came from
/// stays as it is.
///
/// @param context  The context.
/// @param desc     What it is to wear.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (from, frames), MRY_E_NON_FINITE, MRY_E_STRUCT_SIZE, MRY_E_STRING.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_texture(
    context: *mut mry_context,
    desc: *const mry_texture_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.texture_work(desc)?;
        out.set(call.keep_job(&call.start("texture", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Gives a creature other textures, and returns when it is done. Work that was started before comes first.
///
/// @param context       The context.
/// @param desc          What it is to wear.
/// @param out_creature  The creature that wears it.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_texture and mry_job_wait return; MRY_E_INPUT (a label that no limb has, a picture or
///         a region of another size), MRY_E_NO_FILE, MRY_E_IO.
/// Lifetime: until mry_creature_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_texture(
    context: *mut mry_context,
    desc: *const mry_texture_desc,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        let work = call.texture_work(desc)?;
        let (_, job) = call.run("texture", work)?;
        job.take(|p| &mut p.creature, |creature| call.keep_creature(creature).map(|id| out.set(id)))
    })
}

/// Writes the textures of all parts into a folder as PNG pictures, named after the parts: all files or none.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param folder    The folder; it is made where it is not there.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_write_textures(
    context: *mut mry_context,
    creature: mry_creature,
    folder: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let folder = folder.name("folder")?;
        let creature = call.creature(creature)?;
        let written = call.context.executor.run(|| write_textures(creature.model(), folder));
        written.map_err(|e| Failure::from(e).about("folder"))?;
        Ok(Code::MRY_OK)
    })
}

/// A creature with the textures that are in a folder, as mry_creature_write_textures names them: painted on, larger or
/// smaller, clear where the old texture is to stay. Parts without a picture keep theirs.
///
/// @param context       The context.
/// @param creature      The creature.
/// @param folder        The folder.
/// @param out_creature  The creature with these textures; the one it came from stays as it is.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no such picture, one of other proportions), MRY_E_LIMIT, MRY_E_STRING.
/// Lifetime: until mry_creature_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_read_textures(
    context: *mut mry_context,
    creature: mry_creature,
    folder: mry_str,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let folder = folder.name("folder")?;
        let out = Out::new(out_creature, "out_creature")?;
        let creature = call.creature(creature)?;
        let mut painted = (*creature.creature).clone();
        let read = call.context.executor.run(|| read_textures(&mut painted.model, folder));
        read.map_err(|e| Failure::from(e).about("folder"))?;
        out.set(call.keep_creature(Arc::new(Creature::new(None, creature.motion.clone(), painted)))?);
        Ok(Code::MRY_OK)
    })
}
