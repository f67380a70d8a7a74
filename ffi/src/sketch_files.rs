//! Sketch files. What players, browsers and editors read of a drawing in motion: animated SVG, Lottie, pictures and video. Each
//! appears whole or not at all.

use std::path::Path;

use marey::export::sketch::{SketchFormat, SketchOptions, SketchSubject, write_sketch};
use serde_json::json;

use crate::border::{self, Out, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::running::{Product, Work};
use crate::sketch_take::mry_sketch_take;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// What to write. Start from MRY_SKETCH_FILE_DESC_INIT; take and path must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_sketch_file_desc {
    /// sizeof(mry_sketch_file_desc).
    pub struct_size: u32,
    /// 1 to show the drawing's page; 0 to show all of every frame.
    pub crop: u32,
    /// The take.
    pub take: mry_sketch_take,
    /// The file, or the folder.
    pub path: mry_str,
    /// "svg", "lottie", "png-dir", "sprite-sheet", "gif", "apng", "webp", "mp4" or "mp4-alpha" (colours above, opacity
    /// below); empty to go by the path's ending, where .json is Lottie, .png an animated PNG, and no ending a folder of PNG
    /// pictures.
    pub format: mry_str,
    /// A name for what is inside the file; empty for the path's.
    pub name: mry_str,
    /// Pixels a pixel of the drawing; 0 for 1.
    pub scale: f32,
    /// What lies behind: red, green, blue, alpha. Formats without alpha show it over white.
    pub background: [u8; 4],
}

// SAFETY: repr(C), starts with its u32 size; numbers, and strings that the host vouches for.
unsafe impl Versioned for mry_sketch_file_desc {
    const FIRST_SIZE: usize = 72;
}
const _: () = assert!(size_of::<mry_sketch_file_desc>() == 72);

impl Call<'_> {
    unsafe fn sketch_file_work(&self, desc: *const mry_sketch_file_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        // SAFETY: as above.
        let (path, format, name) =
            unsafe { (desc.path.name("desc.path")?, desc.format.text("desc.format")?, desc.name.text("desc.name")?) };
        if desc.crop > 1 {
            return Err(Failure::argument("desc.crop", format!("desc.crop is {}; give 0 or 1", desc.crop)));
        }
        if !desc.scale.is_finite() {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "desc.scale", format!("desc.scale is {}", desc.scale)));
        }
        if desc.scale < 0.0 {
            return Err(Failure::argument("desc.scale", format!("desc.scale is {}, and must be above 0", desc.scale)));
        }
        let file = Path::new(path);
        let format = SketchFormat::choose(Some(format).filter(|f| !f.is_empty()), file);
        let format = format.map_err(|e| Failure::from(e).about("desc.format"))?;
        let sketched = self.sketch_take(desc.take).map_err(|e| e.about("desc.take"))?;
        let stem = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let (path, name) = (file.to_owned(), if name.is_empty() { stem } else { name.to_owned() });
        let options = SketchOptions {
            grow: desc.crop == 0,
            scale: if desc.scale == 0.0 { 1.0 } else { f64::from(desc.scale) },
            background: desc.background,
            ..SketchOptions::default()
        };
        Ok(Box::new(move |progress| {
            let began = std::time::Instant::now();
            progress.whole().name("writing")?;
            let subject = SketchSubject { name: &name, drawing: &sketched.vector.drawing, take: &sketched.take };
            let files = write_sketch(&path, format, subject, &options, progress.whole())?;
            let report = json!({ "files": files.files, "timings": { "writing": began.elapsed().as_secs_f64() } });
            Ok(Product { report: Some(report.to_string()), ..Product::default() })
        }))
    }
}

/// Fills in a struct with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_sketch_file_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_file_desc_init(desc: *mut mry_sketch_file_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts writing a sketch take. There is nothing to take; mry_job_get_report names the files.
///
/// @param context  The context.
/// @param desc     What to write.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no such format), MRY_E_ARGUMENT (crop, scale, path), MRY_E_NON_FINITE,
///         MRY_E_STRUCT_SIZE, MRY_E_STRING.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_sketch_file(
    context: *mut mry_context,
    desc: *const mry_sketch_file_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.sketch_file_work(desc)?;
        out.set(call.keep_job(&call.start("sketch file", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Writes a sketch take, and returns when it is done. Work that was started before comes first.
///
/// @param context  The context.
/// @param desc     What to write.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_sketch_file and mry_job_wait return; MRY_E_INPUT (what the format cannot hold), MRY_E_IO.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_sketch_file(
    context: *mut mry_context,
    desc: *const mry_sketch_file_desc,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let work = call.sketch_file_work(desc)?;
        call.run("sketch file", work).map(|(code, _)| code)
    })
}
