//! Exporting. A creature's files, written by a job.

use crate::border::{self, Out, Versioned};
use crate::context::mry_context;
use crate::creature::mry_creature;
use crate::creature_files::{Export, folder_options, metres};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::running::{Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Export: one glTF 2.0 binary, as mry_creature_write_glb.
pub const MRY_EXPORT_GLB: i32 = 1;
/// Export: a folder of OBJ files, as mry_creature_write_obj.
pub const MRY_EXPORT_OBJ: i32 = 2;
/// Export: a GIF of the clip with the limbs and the masks drawn over it.
pub const MRY_EXPORT_OVERLAY: i32 = 3;
/// Export: a GIF of the creature in motion, as the clip shows it and from another side.
pub const MRY_EXPORT_PREVIEW: i32 = 4;
/// Export: the folder with everything, as mry_creature_write_folder.
pub const MRY_EXPORT_FOLDER: i32 = 5;

/// What to export. Start from MRY_EXPORT_DESC_INIT; what, creature and path must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_export_desc {
    /// sizeof(mry_export_desc).
    pub struct_size: u32,
    /// MRY_EXPORT_GLB, ...
    pub what: i32,
    /// The creature.
    pub creature: mry_creature,
    /// The file or folder.
    pub path: mry_str,
    /// With MRY_EXPORT_FOLDER: 1 to write also meshes/00000.obj, ...
    pub write_obj: u32,
    /// Metres a world unit in glTF; 0 for 1.
    pub scale: f32,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and a string that the host vouches for.
unsafe impl Versioned for mry_export_desc {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_export_desc>() == 40);

impl Call<'_> {
    unsafe fn export_work(&self, desc: *const mry_export_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        // SAFETY: as above.
        let path = unsafe { desc.path.name("desc.path")? }.to_owned();
        let export = match desc.what {
            MRY_EXPORT_GLB => Export::Glb(metres(desc.scale)?),
            MRY_EXPORT_OBJ => Export::Obj,
            MRY_EXPORT_OVERLAY => Export::Overlay,
            MRY_EXPORT_PREVIEW => Export::Preview,
            MRY_EXPORT_FOLDER => Export::Folder(folder_options(desc.write_obj, desc.scale)?),
            what => return Err(Failure::argument("desc.what", format!("desc.what is {what}, which is no MRY_EXPORT"))),
        };
        let creature = self.creature(desc.creature)?;
        Ok(Box::new(move |progress| {
            export.write(&creature, path.as_ref(), progress.whole())?;
            Ok(Product::default())
        }))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_export_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_export_desc_init(desc: *mut mry_export_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts writing a creature's files. A file or folder appears whole or not at all. There is nothing to take.
///
/// @param context  The context.
/// @param desc     What to export.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (what, scale, path), MRY_E_NON_FINITE, MRY_E_STRUCT_SIZE, MRY_E_STRING.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_export(
    context: *mut mry_context,
    desc: *const mry_export_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.export_work(desc)?;
        out.set(call.keep_job(&call.start("export", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Writes a creature's files, and returns when it is done. Work that was started before comes first.
///
/// @param context  The context.
/// @param desc     What to export.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_export and mry_job_wait return.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_export(
    context: *mut mry_context,
    desc: *const mry_export_desc,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let work = call.export_work(desc)?;
        call.run("export", work).map(|(code, _)| code)
    })
}
