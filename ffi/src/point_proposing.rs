//! Proposed points. Control points for what a frame of a clip shows, where nobody has marked any: on the ends of what moves,
//! or is opaque, or stands before an even background, and where its limbs meet and bend. They are there to be corrected.

use marey::shape::sketch::propose_points;

use crate::border::Out;
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::control_points::mry_control_points;
use crate::error::{Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};

impl Call<'_> {
    fn propose_points_work(&self, clip: mry_clip, frame_from_one: u64, most: u32) -> Outcome<Work> {
        let clip = self.clip(clip, "clip")?;
        let frame = frame_from_one.checked_sub(1).map(|frame| usize::try_from(frame).unwrap_or(usize::MAX));
        Ok(Box::new(move |progress| {
            let points = propose_points(&clip, frame, most as usize, progress.whole())?;
            Ok(Product { control_points: Part::Made(points), ..Product::default() })
        }))
    }
}

/// Starts looking for points to follow. Gives control points, each with one key, all on one frame, named "1", "2", ...
///
/// @param context         The context.
/// @param clip            The clip.
/// @param frame_from_one  The frame, counted from 1; 0 for the one of a few that shows most ends.
/// @param most            How many points at most, up to 256; 0 for 12.
/// @param out_job         The job. It ends with MRY_E_INPUT where nothing is seen to move.
/// @param err             Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_propose_points(
    context: *mut mry_context,
    clip: mry_clip,
    frame_from_one: u64,
    most: u32,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.propose_points_work(clip, frame_from_one, most)?;
        out.set(call.keep_job(&call.start("propose points", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Looks for points to follow, and returns when it is done. Work that was started before comes first.
///
/// @param context         The context.
/// @param clip            The clip.
/// @param frame_from_one  The frame, counted from 1; 0 for the one of a few that shows most ends.
/// @param most            How many points at most, up to 256; 0 for 12.
/// @param out_points      The points, valid.
/// @param err             Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_propose_points and mry_job_wait return.
/// Lifetime: until mry_control_points_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_propose_points(
    context: *mut mry_context,
    clip: mry_clip,
    frame_from_one: u64,
    most: u32,
    out_points: *mut mry_control_points,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_points, "out_points")?;
        let work = call.propose_points_work(clip, frame_from_one, most)?;
        let (_, job) = call.run("propose points", work)?;
        job.take(|p| &mut p.control_points, |points| call.keep_control_points(points).map(|id| out.set(id)))
    })
}
