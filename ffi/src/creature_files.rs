//! Creature files. What other programs read: glTF, OBJ, and the folder with everything. Each appears whole or not at
//! all.

use marey::export::gltf::{self, GltfOptions};
use marey::export::{CreatureFiles, FolderOptions, write_aside, write_creature};
use marey::job::Progress;

use crate::context::mry_context;
use crate::creature::{Creature, mry_creature};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
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
        let mut options = GltfOptions::default();
        options.scale = metres(scale)?;
        let creature = call.creature(creature)?;
        let progress = Progress::new();
        let write = || write_aside(path, &gltf::glb(&creature.model, &options, progress.whole())?);
        call.context.executor.run(write).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
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
        let options = folder_options(write_obj, scale)?;
        let creature = call.creature(creature)?;
        let Creature { clip, rig, motion, masks, model, .. } = &*creature;
        let files = CreatureFiles { clip, rig, motion, masks: &masks.masks, model };
        let mut report = masks.report.clone();
        // It may tell of another folder that the job has written.
        report.outputs.clear();
        let progress = Progress::new();
        let write = || write_creature(folder.as_ref(), &files, &options, &mut report, progress.whole());
        call.context.executor.run(write).map_err(|e| Failure::from(e).about("folder"))?;
        Ok(Code::MRY_OK)
    })
}
