//! Creature files. What other programs read: glTF, OBJ, pictures, and the folder with everything. Each appears whole or
//! not at all. mry_job_start_export writes the same files as a job. mry_creature_open reads a creature back.

use std::path::Path;
use std::sync::Arc;

use marey::export::gltf::{self, GltfOptions};
use marey::export::{CreatureFiles, FolderOptions, overlay, preview, write_aside, write_creature, write_obj_folder};
use marey::job::{Progress, Stage};
use marey::motion::Motion;

use crate::border::Out;
use crate::context::mry_context;
use crate::creature::{Creature, Origin, mry_creature};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Which files a creature's folder has. A scale of 0 is the default, 1.
pub(crate) fn folder_options(obj: u32, scale: f32) -> Outcome<FolderOptions> {
    if obj > 1 {
        return Err(Failure::argument("write_obj", format!("write_obj is {obj}, and must be 0 or 1")));
    }
    let mut options = FolderOptions::default();
    options.obj = obj == 1;
    options.scale = metres(scale)?;
    Ok(options)
}

/// Metres a world unit. A scale of 0 is the default, 1.
pub(crate) fn metres(scale: f32) -> Outcome<f32> {
    if !scale.is_finite() {
        return Err(Failure::new(Code::MRY_E_NON_FINITE, "scale", format!("scale is {scale}")));
    }
    if scale < 0.0 {
        return Err(Failure::argument("scale", format!("scale is {scale}, and must be above 0")));
    }
    Ok(if scale == 0.0 { 1.0 } else { scale })
}

/// What to write of a creature.
pub(crate) enum Export {
    /// One glTF binary, with so many metres a unit.
    Glb(f32),
    /// A folder of OBJ files.
    Obj,
    /// The overlay GIF.
    Overlay,
    /// The preview GIF.
    Preview,
    /// The folder with everything.
    Folder(FolderOptions),
}

impl Export {
    /// Writes it to `path`, whole or not at all.
    pub(crate) fn write(&self, creature: &Creature, path: &Path, stage: Stage<'_>) -> marey::Result<()> {
        let model = creature.model();
        let most = stage.part(0.0, 0.95);
        match self {
            Self::Glb(scale) => {
                stage.name("writing glTF")?;
                let mut options = GltfOptions::default();
                options.scale = *scale;
                write_aside(path, &gltf::glb(&creature.creature, &options, most)?)?;
            }
            Self::Obj => write_obj_folder(path, model, creature.origin.as_ref().map(|o| &o.masks.report), most)?,
            Self::Overlay => {
                stage.name("writing the overlay")?;
                let Origin { clip, rig, masks } = creature.origin()?;
                write_aside(path, &overlay(clip, rig, &creature.motion, &masks.masks, most)?)?;
            }
            Self::Preview => {
                stage.name("writing the preview")?;
                write_aside(path, &preview(model, most)?)?;
            }
            Self::Folder(options) => {
                let Origin { clip, rig, masks } = creature.origin()?;
                let Creature { motion, creature, .. } = creature;
                let files = CreatureFiles { clip, rig, motion, masks: &masks.masks, creature };
                let mut report = masks.report.clone();
                // It may tell of another folder that the job has written.
                report.outputs.clear();
                write_creature(path, &files, options, &mut report, most)?;
            }
        }
        Ok(())
    }
}

impl Call<'_> {
    fn export(&self, export: &Export, creature: mry_creature, path: &str, param: &'static str) -> Outcome<Code> {
        let creature = self.creature(creature)?;
        let progress = Progress::new();
        let written = self.context.executor.run(|| export.write(&creature, path.as_ref(), progress.whole()));
        written.map_err(|e| Failure::from(e).about(param))?;
        Ok(Code::MRY_OK)
    }
}

/// The motion in a creature's folder, where it has one that fits; else what the bones make.
fn motion_beside(path: &Path, creature: &marey::shape::creature::Creature) -> Motion {
    let file = path.join("motion.json");
    let kept = if file.is_file() { Motion::read(file).ok() } else { None };
    let fits = |m: &Motion| m.frames == creature.model.animation.len() && m.size == creature.model.size;
    kept.filter(fits).unwrap_or_else(|| creature.motion())
}

/// Reads a creature from a creature.glb, from one that a modelling program wrote of it, or from the folder of a
/// creature. Such a creature can be posed, driven, drawn, printed and written as glTF and OBJ; it has no masks and no
/// report, and its motion is that of its bones, or the folder's motion.json. Of files by others: triangles, the first
/// texture coordinates, four weights a vertex, base colours, the first animation; limbs are known by the names of their
/// bones (label.0, label.1, ...).
///
/// @param context       The context.
/// @param path          The file or the folder.
/// @param out_creature  The creature.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_IO, MRY_E_INPUT (damaged, scaled bones, data in other files), MRY_E_LIMIT,
///         MRY_E_STRING.
/// Lifetime: until mry_creature_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_open(
    context: *mut mry_context,
    path: mry_str,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path: &Path = path.name("path")?.as_ref();
        let out = Out::new(out_creature, "out_creature")?;
        let creature = gltf::read_creature(path).map_err(|e| Failure::from(e).about("path"))?;
        let motion = Arc::new(motion_beside(path, &creature));
        out.set(call.keep_creature(Arc::new(Creature::new(None, motion, creature)))?);
        Ok(Code::MRY_OK)
    })
}

/// Writes the creature as one glTF 2.0 binary: meshes, skin, animation, textures. The file appears whole or not at
/// all.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param path      The file, in a folder that exists.
/// @param scale     Metres a world unit; 0 for 1.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_LIMIT, MRY_E_ARGUMENT, MRY_E_NON_FINITE,
///         MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_write_glb(
    context: *mut mry_context,
    creature: mry_creature,
    path: mry_str,
    scale: f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        call.export(&Export::Glb(metres(scale)?), creature, path, "path")
    })
}

/// Writes everything into a folder, which appears whole or not at all: creature.glb, motion.json, masks/, overlay.gif,
/// preview.gif, report.json, and meshes/ on request. A folder that was written before is replaced, anything else in
/// the way is left alone and refused.
///
/// @param context    The context.
/// @param creature   The creature.
/// @param folder     The folder.
/// @param write_obj  1 for meshes/00000.obj, ... in world coordinates; 0 for none.
/// @param scale      Metres a world unit in creature.glb; 0 for 1.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (something is in the way), MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_write_folder(
    context: *mut mry_context,
    creature: mry_creature,
    folder: mry_str,
    write_obj: u32,
    scale: f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let folder = folder.name("folder")?;
        call.export(&Export::Folder(folder_options(write_obj, scale)?), creature, folder, "folder")
    })
}

/// Writes the meshes into a folder: 00000.obj, ... in world coordinates, one a frame, creature.mtl, a PNG for each
/// part, report.json. The folder appears whole or not at all. One that was written before is replaced, anything else
/// in the way is left alone and refused.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param folder    The folder.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (something is in the way), MRY_E_STRING, MRY_E_ARGUMENT.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_write_obj(
    context: *mut mry_context,
    creature: mry_creature,
    folder: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let folder = folder.name("folder")?;
        call.export(&Export::Obj, creature, folder, "folder")
    })
}
