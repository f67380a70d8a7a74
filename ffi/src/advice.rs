//! Advice. What a person should draw next, and what there is to say about tracking.

use std::ffi::c_char;

use marey::export::report::{Report, corrections};
use marey::rig::Rig;

use crate::border::{self, OutStruct, Text, Versioned};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, mry_error};
use crate::guard::entry;
use crate::motion::mry_motion;
use crate::rig::mry_rig;
use crate::status::{mry_status, mry_status_code as Code};

/// A stroke that is worth drawing next.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_correction {
    /// sizeof(mry_correction).
    pub struct_size: u32,
    /// The track, that is the limb, to draw.
    pub track: u32,
    /// The frame to draw it on.
    pub frame: u64,
    /// How far it is trusted there now, in 0..1.
    pub confidence: f32,
    /// Zero.
    pub reserved0: u32,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_correction {
    const FIRST_SIZE: usize = 24;
}
const _: () = assert!(size_of::<mry_correction>() == 24);

/// Fills in a correction with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param correction  Where to write; NULL does nothing.
/// @param size        sizeof(mry_correction) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_correction_init(correction: *mut mry_correction, size: u32) {
    // SAFETY: the caller owns `size` bytes at `correction`, or passes NULL.
    unsafe { border::init(correction.cast(), size) }
}

/// The strokes that would help most, the most helpful first: the limbs and frames that are trusted least.
///
/// @param context         The context.
/// @param motion          The motion.
/// @param rig             The rig it came from, so that what is drawn already is left out; or {0}.
/// @param index           0 for the best, then the next.
/// @param out_correction  The answer; its struct_size must be set.
/// @param err             Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there are no more), MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_correction(
    context: *mut mry_context,
    motion: mry_motion,
    rig: mry_rig,
    index: u32,
    out_correction: *mut mry_correction,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_correction, "out_correction")?;
        let motion = call.motion(motion)?;
        let list = if rig.v == 0 {
            corrections(&motion, &Rig { size: motion.size, limbs: Vec::new(), keyframes: Vec::new() })
        } else {
            call.rig(rig, |rig| Ok(corrections(&motion, rig)))?
        };
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "index", format!("there are {} corrections", list.len()));
        let correction = list.get(index as usize).ok_or_else(none)?;
        let track = motion.tracks.iter().position(|t| t.name == correction.limb).ok_or_else(none)?;
        out.set(&mry_correction {
            struct_size: 0,
            track: track as u32,
            frame: correction.frame as u64,
            confidence: correction.confidence,
            reserved0: 0,
        });
        Ok(Code::MRY_OK)
    })
}

/// What there is to say about tracking, as the text of a report.json: counts, warnings, how far each limb is to be
/// trusted, corrections.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param clip      The clip it came from.
/// @param rig       The rig it came from.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_report(
    context: *mut mry_context,
    motion: mry_motion,
    clip: mry_clip,
    rig: mry_rig,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let (motion, clip) = (call.motion(motion)?, call.clip(clip, "clip")?);
        let report = call.rig(rig, |rig| Ok(Report::new(clip.info(), rig, &motion)))?;
        text.fill(&report.to_json())
    })
}
