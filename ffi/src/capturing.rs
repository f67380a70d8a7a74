//! Capture. From joints marked on one frame to joints on every frame.

use std::ffi::c_char;
use std::sync::Arc;

use marey::track::TrackJoints;
use marey::track::joint::{CaptureReport, EarlierCapture, JointTracker};

use crate::border::{self, Out, Text, Versioned, reserved};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::joints::mry_joints;
use crate::motion::mry_motion;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};

/// What to capture. Start from MRY_CAPTURE_DESC_INIT; clip and joints must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_capture_desc {
    /// sizeof(mry_capture_desc).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// The clip.
    pub clip: mry_clip,
    /// The joints; they must be valid for the clip.
    pub joints: mry_joints,
    /// What was captured before from earlier_joints on the same clip; {0} to capture everything. Only what differs
    /// between the joints is captured again, between the marked frames around it; the rest stays to the bit.
    pub earlier: mry_motion,
    /// What was marked then; {0} without earlier.
    pub earlier_joints: mry_joints,
}

// SAFETY: repr(C), starts with its u32 size, and holds integers only.
unsafe impl Versioned for mry_capture_desc {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_capture_desc>() == 40);

impl Call<'_> {
    unsafe fn capture_work(&self, desc: *const mry_capture_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        reserved(desc.reserved0)?;
        let clip = self.clip(desc.clip, "desc.clip")?;
        let info = clip.info();
        let fit = Some(((info.width, info.height), info.frames));
        let marks = self.joints(desc.joints, |joints| {
            joints.validate(fit).map_err(|e| Failure::from(e).about("desc.joints"))?;
            Ok(joints.clone())
        })?;
        let earlier = if desc.earlier.v == 0 && desc.earlier_joints.v == 0 {
            None
        } else {
            let motion = self.motion(desc.earlier).map_err(|e| e.about("desc.earlier"))?;
            let marks = self.joints(desc.earlier_joints, |joints| Ok(joints.clone()));
            Some((motion, marks.map_err(|e| e.about("desc.earlier_joints"))?))
        };
        Ok(Box::new(move |progress| {
            let tracker = JointTracker::default();
            let motion = match &earlier {
                None => tracker.track_joints(&clip, &marks, progress.whole())?,
                Some((motion, before)) => {
                    let earlier = EarlierCapture { motion, marks: before };
                    tracker.retrack_joints(&clip, &marks, earlier, progress.whole())?
                }
            };
            Ok(Product { motion: Part::Made(Arc::new(motion)), ..Product::default() })
        }))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_capture_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_capture_desc_init(desc: *mut mry_capture_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts capture: from joints marked on one frame to joints on every frame. Gives a motion, one track a joint.
///
/// @param context  The context.
/// @param desc     What to capture.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the joints are not valid for the clip), MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_capture(
    context: *mut mry_context,
    desc: *const mry_capture_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.capture_work(desc)?;
        out.set(call.keep_job(&call.start("capture", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Captures, and returns when it is done. Work that was started before comes first.
///
/// @param context     The context.
/// @param desc        What to capture.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_capture and mry_job_wait return.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_capture(
    context: *mut mry_context,
    desc: *const mry_capture_desc,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let work = call.capture_work(desc)?;
        let (_, job) = call.run("capture", work)?;
        job.take(|p| &mut p.motion, |motion| call.keep_motion(motion).map(|id| out.set(id)))
    })
}

/// What there is to say about captured joints, as JSON: how far each is to be trusted, how bones squash and stretch,
/// which joint to correct next, and on which frame.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param clip      The clip it came from.
/// @param joints    The joints it came from.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_capture_report(
    context: *mut mry_context,
    motion: mry_motion,
    clip: mry_clip,
    joints: mry_joints,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let (motion, clip) = (call.motion(motion)?, call.clip(clip, "clip")?);
        let report = call.joints(joints, |joints| Ok(CaptureReport::new(clip.info(), joints, &motion)))?;
        text.fill(&report.to_json())
    })
}
