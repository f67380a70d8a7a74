//! Point tracking. From control points marked on a frame or more to points on every frame.

use std::collections::HashMap;
use std::ffi::c_char;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use marey::track::TrackPoints;
use marey::track::point::{PointFootage, PointParams, PointReport, PointTracker};

use crate::border::{self, Out, Text, Versioned};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::control_points::mry_control_points;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::motion::mry_motion;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};

/// What to track. Start from MRY_POINT_TRACK_DESC_INIT; clip and points must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_point_track_desc {
    /// sizeof(mry_point_track_desc).
    pub struct_size: u32,
    /// 1 to keep in memory, until the clip is closed, what was read of it and what was solved: the next time only what
    /// differs between the points is solved again, in a fraction of the time and with the same result. 0 to keep nothing.
    pub keep: u32,
    /// The clip.
    pub clip: mry_clip,
    /// The points; they must be valid for the clip.
    pub points: mry_control_points,
}

// SAFETY: repr(C), starts with its u32 size, and holds integers only.
unsafe impl Versioned for mry_point_track_desc {
    const FIRST_SIZE: usize = 24;
}
const _: () = assert!(size_of::<mry_point_track_desc>() == 24);

/// What was read of clips, by their ids.
#[derive(Default)]
pub(crate) struct Footages(Mutex<HashMap<u64, Kept>>);

type Kept = Arc<Mutex<Option<PointFootage>>>;

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Footages {
    fn of(&self, clip: mry_clip) -> Kept {
        lock(&self.0).entry(clip.v).or_default().clone()
    }

    fn if_kept(&self, clip: mry_clip) -> Option<Kept> {
        lock(&self.0).get(&clip.v).cloned()
    }

    /// Lets go of what was read of a clip.
    pub(crate) fn forget(&self, clip: mry_clip) {
        lock(&self.0).remove(&clip.v);
    }
}

impl Call<'_> {
    unsafe fn point_track_work(&self, desc: *const mry_point_track_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        if desc.keep > 1 {
            return Err(Failure::argument("desc.keep", format!("desc.keep is {}; give 0 or 1", desc.keep)));
        }
        let clip = self.clip(desc.clip, "desc.clip")?;
        let info = clip.info();
        let fit = Some(((info.width, info.height), info.frames));
        let marks = self.control_points(desc.points, |points| {
            points.validate(fit).map_err(|e| Failure::from(e).about("desc.points"))?;
            Ok(points.clone())
        });
        let marks = marks.map_err(|e| e.about("desc.points"))?;
        let footages = &self.context.footages;
        let kept = if desc.keep == 1 { Some(footages.of(desc.clip)) } else { footages.if_kept(desc.clip) };
        Ok(Box::new(move |progress| {
            let stage = progress.whole();
            let motion = match kept {
                None => PointTracker::default().track_points(&clip, &marks, stage)?,
                Some(kept) => {
                    let mut kept = lock(&kept);
                    // What a cancel or an error leaves half-solved is not kept.
                    let mut footage = match kept.take() {
                        Some(footage) => footage,
                        None => PointFootage::read(&clip, &PointParams::default(), stage.part(0.0, 0.6))?,
                    };
                    let motion = footage.track(&marks, stage.part(0.6, 1.0))?;
                    *kept = Some(footage);
                    motion
                }
            };
            Ok(Product { motion: Part::Made(Arc::new(motion)), ..Product::default() })
        }))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_point_track_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_point_track_desc_init(desc: *mut mry_point_track_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts capture: from points marked on one frame to points on every frame. Gives a motion, one track a joint.
///
/// @param context  The context.
/// @param desc     What to track.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the points are not valid for the clip), MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_point_track(
    context: *mut mry_context,
    desc: *const mry_point_track_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.point_track_work(desc)?;
        out.set(call.keep_job(&call.start("points", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Tracks points, and returns when it is done. Work that was started before comes first.
///
/// @param context     The context.
/// @param desc        What to track.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_point_track and mry_job_wait return.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_point_track(
    context: *mut mry_context,
    desc: *const mry_point_track_desc,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let work = call.point_track_work(desc)?;
        let (_, job) = call.run("points", work)?;
        job.take(|p| &mut p.motion, |motion| call.keep_motion(motion).map(|id| out.set(id)))
    })
}

/// What there is to say about tracked points, as JSON: how far each is to be trusted, where it is hidden, and which point
/// to correct next, on which frame.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param points    The points it came from.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_point_report(
    context: *mut mry_context,
    motion: mry_motion,
    points: mry_control_points,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let motion = call.motion(motion)?;
        let report = call.control_points(points, |points| Ok(PointReport::new(points, &motion)))?;
        text.fill(&report.to_json())
    })
}
