//! Opening. A clip opened by a job: listing thousands of images, or the frames of a long video, takes its time.

use std::sync::Arc;

use marey::clip::Clip;

use crate::border::Out;
use crate::clip::{mry_clip_options, options_in};
use crate::context::mry_context;
use crate::error::mry_error;
use crate::guard::entry;
use crate::job::mry_job;
use crate::running::{Part, Product};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Starts opening a clip. Gives a clip, whose warnings mry_clip_get_warning has.
///
/// @param context  The context.
/// @param path     The file or folder.
/// @param options  How to open it; NULL for the defaults.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRUCT_SIZE.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_open(
    context: *mut mry_context,
    path: mry_str,
    options: *const mry_clip_options,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?.to_owned();
        let out = Out::new(out_job, "out_job")?;
        let options = options_in(options, call.context)?;
        let job = call.start(
            "open",
            Box::new(move |progress| {
                let clip = Clip::open_staged(&path, &options, progress.whole())?;
                Ok(Product { clip: Part::Made(Arc::new(clip)), ..Product::default() })
            }),
        )?;
        out.set(call.keep_job(&job)?);
        Ok(Code::MRY_OK)
    })
}
