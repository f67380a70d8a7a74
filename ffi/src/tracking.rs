//! Tracking. From strokes on key frames to strokes on every frame.

use std::ops::Range;
use std::sync::Arc;

use marey::clip::Clip;
use marey::motion::Motion;
use marey::rig::Rig;
use marey::track::{Earlier, outdated_frames};

use crate::border::{self, Out, Versioned, reserved};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::motion::mry_motion;
use crate::rig::mry_rig;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// What to track. Start from MRY_TRACK_DESC_INIT; clip and rig must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_track_desc {
    /// sizeof(mry_track_desc).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// The clip.
    pub clip: mry_clip,
    /// The rig; it must be valid for the clip.
    pub rig: mry_rig,
    /// The tracker: "space-time", "paper" (Reinert 2016, section 3.5); or a plugin's
    /// id; empty for the best.
    pub tracker: mry_str,
    /// What was tracked before with the same tracker from earlier_rig on the same clip; {0} to track everything. Only
    /// what differs between the rigs is tracked again, between the key frames around it; the rest stays to the bit.
    pub earlier: mry_motion,
    /// What was drawn then; {0} without earlier.
    pub earlier_rig: mry_rig,
}

// SAFETY: repr(C), starts with its u32 size; integers, and a string that the host vouches for.
unsafe impl Versioned for mry_track_desc {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_track_desc>() == 56);

/// A motion, and for every limb the frames in which it no longer holds.
type Before = (Arc<Motion>, Vec<Vec<Range<usize>>>);

impl Call<'_> {
    unsafe fn track_work(&self, desc: *const mry_track_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        reserved(desc.reserved0)?;
        // SAFETY: as above.
        let tracker = unsafe { self.tracker(desc.tracker)? };
        let (clip, rig) = self.clip_and_rig(desc.clip, desc.rig)?;
        let earlier = self.earlier(&desc, &clip, &rig)?;
        Ok(Box::new(move |progress| {
            let motion = match &earlier {
                None => tracker.track(&clip, &rig, progress.whole())?,
                Some((motion, outdated)) => {
                    tracker.retrack(&clip, &rig, Earlier { motion, outdated }, progress.whole())?
                }
            };
            Ok(Product { motion: Part::Made(Arc::new(motion)), ..Product::default() })
        }))
    }

    /// What was tracked before and where it no longer holds, where that is given.
    fn earlier(&self, desc: &mry_track_desc, clip: &Clip, rig: &Rig) -> Outcome<Option<Before>> {
        if desc.earlier.v == 0 && desc.earlier_rig.v == 0 {
            return Ok(None);
        }
        let motion = self.motion(desc.earlier).map_err(|e| e.about("desc.earlier"))?;
        let frames = clip.info().frames;
        let outdated = self
            .rig(desc.earlier_rig, |old| Ok(outdated_frames(old, rig, frames)))
            .map_err(|e| e.about("desc.earlier_rig"))?;
        Ok(Some((motion, outdated)))
    }

    /// The clip and a copy of the rig, which fits it.
    pub(crate) fn clip_and_rig(&self, clip: mry_clip, rig: mry_rig) -> Outcome<(Arc<Clip>, Rig)> {
        let clip = self.clip(clip, "desc.clip")?;
        let info = clip.info();
        let fit = Some(((info.width, info.height), info.frames));
        let rig = self.rig(rig, |rig| {
            rig.validate(fit).map_err(|e| Failure::from(e).about("desc.rig"))?;
            Ok(rig.clone())
        })?;
        Ok((clip, rig))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_track_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_track_desc_init(desc: *mut mry_track_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts tracking: from strokes on key frames to strokes on every frame. Gives a motion.
///
/// @param context  The context.
/// @param desc     What to track.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the rig is not valid for the clip), MRY_E_UNSUPPORTED (no such tracker),
///         MRY_E_STRUCT_SIZE, MRY_E_STRING, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_track(
    context: *mut mry_context,
    desc: *const mry_track_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.track_work(desc)?;
        out.set(call.keep_job(&call.start("track", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Tracks, and returns when it is done. Work that was started before comes first.
///
/// @param context     The context.
/// @param desc        What to track.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_track and mry_job_wait return.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_track(
    context: *mut mry_context,
    desc: *const mry_track_desc,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let work = call.track_work(desc)?;
        let (_, job) = call.run("track", work)?;
        job.take(|p| &mut p.motion, |motion| call.keep_motion(motion).map(|id| out.set(id)))
    })
}
