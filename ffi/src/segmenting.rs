//! Segmenting. From tracked strokes to the creature's mask in every frame.

use std::sync::Arc;
use std::time::Instant;

use marey::clip::Clip;
use marey::export::report::Report;
use marey::export::{check_mask_folder, write_mask_folder};
use marey::motion::Motion;
use marey::rig::Rig;

use crate::border::{self, Out, Versioned, reserved};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::masks::{MaskSet, mry_masks};
use crate::methods::settings;
use crate::motion::mry_motion;
use crate::rig::mry_rig;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// What to segment. Start from MRY_SEGMENT_DESC_INIT; clip and rig must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_segment_desc {
    /// sizeof(mry_segment_desc).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// The clip.
    pub clip: mry_clip,
    /// The rig; it must be valid for the clip.
    pub rig: mry_rig,
    /// The rig's limbs, tracked; {0} to track them first.
    pub motion: mry_motion,
    /// The tracker, where motion is {0}: as in mry_track_desc.
    pub tracker: mry_str,
    /// The segmenter: "layered", "paper" (Reinert 2016, section 3.6), or a plugin's id;
    /// empty for the best.
    pub segmenter: mry_str,
    /// Where to write the masks, see mry_masks_write_folder; empty for nowhere.
    pub folder: mry_str,
}

// SAFETY: repr(C), starts with its u32 size; integers, and strings that the host vouches for.
unsafe impl Versioned for mry_segment_desc {
    const FIRST_SIZE: usize = 80;
}
const _: () = assert!(size_of::<mry_segment_desc>() == 80);

/// Where the stages of a segment job end, as shares of its time.
const TRACKED: f64 = 0.6;
const SEGMENTED: f64 = 0.95;

/// A motion from anywhere must be of this clip and rig.
fn fits(motion: &Motion, clip: &Clip, rig: &Rig) -> Outcome<()> {
    let info = clip.info();
    let same = motion.size == (info.width, info.height)
        && motion.frames == info.frames
        && motion.tracks.iter().map(|t| &t.name).eq(rig.limbs.iter().map(|l| &l.label));
    if same {
        return Ok(());
    }
    let message = "the motion is not of this clip and rig: its size, its frames or its track names are others";
    Err(Failure::new(Code::MRY_E_INPUT, "desc.motion", message))
}

/// The folder to write into, where one is named.
///
/// # Safety
/// The string is valid, as the header asks.
pub(crate) unsafe fn folder(folder: mry_str) -> Outcome<Option<String>> {
    if folder.len == 0 {
        return Ok(None);
    }
    // SAFETY: as this function's own.
    unsafe { folder.name("desc.folder").map(|name| Some(name.to_owned())) }
}

impl Call<'_> {
    unsafe fn segment_work(&self, desc: *const mry_segment_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        reserved(desc.reserved0)?;
        // SAFETY: as above.
        let (tracker, segmenter) = unsafe { (self.tracker(desc.tracker)?, self.segmenter(desc.segmenter)?) };
        // SAFETY: as above.
        let (settings, folder) = unsafe { (settings(desc.tracker, desc.segmenter)?, folder(desc.folder)?) };
        let (clip, rig) = self.clip_and_rig(desc.clip, desc.rig)?;
        let given = if desc.motion.v == 0 { None } else { Some(self.motion(desc.motion)?) };
        if let Some(motion) = &given {
            fits(motion, &clip, &rig)?;
        }
        Ok(Box::new(move |progress| {
            if let Some(folder) = &folder {
                check_mask_folder(folder.as_ref())?;
            }
            let stage = progress.whole();
            let began = Instant::now();
            let motion = match given {
                Some(motion) => motion,
                None => Arc::new(tracker.track(&clip, &rig, stage.part(0.0, TRACKED))?),
            };
            let tracked = began.elapsed();
            let segmenting = stage.part(TRACKED, SEGMENTED);
            segmenting.name("segmenting")?;
            let masks = segmenter.segment(&clip, &rig, &motion, segmenting)?;
            let mut report = Report::new(clip.info(), &rig, &motion);
            report.settings = settings;
            report.stage("track", tracked.as_secs_f64());
            report.stage("segment", (began.elapsed() - tracked).as_secs_f64());
            if let Some(folder) = &folder {
                let writing = stage.part(SEGMENTED, 1.0);
                writing.name("writing")?;
                write_mask_folder(folder.as_ref(), &masks, &report, writing)?;
            }
            let masks = Arc::new(MaskSet { masks, report });
            Ok(Product { motion: Part::Made(motion), masks: Part::Made(masks), ..Product::default() })
        }))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_segment_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_segment_desc_init(desc: *mut mry_segment_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts segmenting: from tracked strokes to the creature's mask in every frame. Gives a motion and masks.
///
/// @param context  The context.
/// @param desc     What to segment.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the rig or the motion is not of the clip), MRY_E_UNSUPPORTED (no such tracker or
///         segmenter), MRY_E_STRUCT_SIZE, MRY_E_STRING, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_segment(
    context: *mut mry_context,
    desc: *const mry_segment_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.segment_work(desc)?;
        out.set(call.keep_job(&call.start("segment", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Segments, and returns when it is done. Work that was started before comes first.
///
/// @param context    The context.
/// @param desc       What to segment.
/// @param out_masks  The masks.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_segment and mry_job_wait return.
/// Lifetime: until mry_masks_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_segment(
    context: *mut mry_context,
    desc: *const mry_segment_desc,
    out_masks: *mut mry_masks,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_masks, "out_masks")?;
        let work = call.segment_work(desc)?;
        let (_, job) = call.run("segment", work)?;
        job.take(|p| &mut p.masks, |masks| call.keep_masks(masks).map(|id| out.set(id)))
    })
}
