//! Motions made smoother and steadier on their feet. Each gives a new motion; what was given stays.

use std::ffi::c_char;
use std::sync::Arc;

use marey::motion::{Held, PlantParams, Planted, SmoothParams, plant, smooth};

use crate::border::{self, Out, Text, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::motion::mry_motion;
use crate::motion_cycle::{given, switch};
use crate::retiming::MOST_KEYS;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// How a motion is smoothed. Start from MRY_SMOOTH_DESC_INIT; nothing must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_smooth_desc {
    /// sizeof(mry_smooth_desc).
    pub struct_size: u32,
    /// 1 to hold the frames below, maybe none; 0 to hold those where a track is certain: key frames.
    pub only_frames: u32,
    /// The period in frames of the swing that is halved, 2..200: shorter ones vanish; 0 for 5.
    pub period: f64,
    /// Frames that are gone through exactly, in all tracks.
    pub frames: *const u64,
    /// How many.
    pub frame_count: usize,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and a pointer that the host vouches for.
unsafe impl Versioned for mry_smooth_desc {
    const FIRST_SIZE: usize = 32;
}
const _: () = assert!(size_of::<mry_smooth_desc>() == 32);

/// How feet are planted. Start from MRY_PLANT_DESC_INIT; nothing must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_plant_desc {
    /// sizeof(mry_plant_desc).
    pub struct_size: u32,
    /// 1 if the ground stands still in the picture; 0 to measure how it goes, as where the camera follows.
    pub still: u32,
    /// 1 if the motion is a loop in place.
    pub closed: u32,
    /// 1 if `ground` says where the ground is; 0 for where each foot comes down.
    pub has_ground: u32,
    /// Where the ground is, in pixels from the top.
    pub ground: f64,
    /// Frames before and after over which a foot is let go; 0 for 4.
    pub ease: f64,
    /// Names of the tracks that end in feet: limbs, or joints.
    pub feet: *const mry_str,
    /// How many; 0 for those that are found.
    pub foot_count: usize,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and a pointer that the host vouches for.
unsafe impl Versioned for mry_plant_desc {
    const FIRST_SIZE: usize = 48;
}
const _: () = assert!(size_of::<mry_plant_desc>() == 48);

unsafe fn smooth_params(desc: *const mry_smooth_desc) -> Outcome<SmoothParams> {
    let mut params = SmoothParams::default();
    if desc.is_null() {
        return Ok(params);
    }
    // SAFETY: by the header's contract, as for all descriptions; see `entry`.
    let (desc, frames) = unsafe {
        let desc = border::read(desc, "desc")?;
        (desc, border::slice(desc.frames, desc.frame_count, MOST_KEYS, "desc.frames")?)
    };
    params.period = given(desc.period, "desc.period")?.unwrap_or(params.period);
    if switch(desc.only_frames, "desc.only_frames")? {
        params.held = Held::Frames(frames.iter().map(|f| usize::try_from(*f).unwrap_or(usize::MAX)).collect());
    } else if !frames.is_empty() {
        let message = "desc.frames are given; set desc.only_frames to hold them".to_owned();
        return Err(Failure::argument("desc.only_frames", message));
    }
    Ok(params)
}

unsafe fn plant_params(desc: *const mry_plant_desc) -> Outcome<PlantParams> {
    let mut params = PlantParams::default();
    if desc.is_null() {
        return Ok(params);
    }
    // SAFETY: by the header's contract, as for all descriptions; see `entry`.
    let desc = unsafe { border::read(desc, "desc")? };
    params.still = switch(desc.still, "desc.still")?;
    params.closed = switch(desc.closed, "desc.closed")?;
    let ground = given(desc.ground, "desc.ground")?.unwrap_or(0.0);
    params.ground = switch(desc.has_ground, "desc.has_ground")?.then_some(ground);
    params.ease = given(desc.ease, "desc.ease")?.unwrap_or(params.ease);
    // SAFETY: as above.
    unsafe {
        for name in border::slice(desc.feet, desc.foot_count, crate::skeleton::MOST_JOINTS, "desc.feet")? {
            params.feet.push(name.text("desc.feet")?.to_owned());
        }
    }
    Ok(params)
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_smooth_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_smooth_desc_init(desc: *mut mry_smooth_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_plant_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plant_desc_init(desc: *mut mry_plant_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Takes the jitter out of a motion. Key frames stay as they are, and where a track is trusted it stays nearer.
///
/// @param context     The context.
/// @param motion      The motion.
/// @param desc        How; NULL for the defaults.
/// @param out_motion  The smooth motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a period out of range, a frame beyond the end, no tracks), MRY_E_ARGUMENT,
///         MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_smooth(
    context: *mut mry_context,
    motion: mry_motion,
    desc: *const mry_smooth_desc,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let params = smooth_params(desc)?;
        let made = smooth(&*call.motion(motion)?, &params)?;
        out.set(call.keep_motion(Arc::new(made))?);
        Ok(Code::MRY_OK)
    })
}

/// Keeps the feet of a motion where they come down: while a foot is low and goes with the ground it goes as the ground
/// does, and its limb, which keeps its lengths, reaches for it.
///
/// @param context     The context.
/// @param motion      The motion.
/// @param desc        How; NULL for the defaults.
/// @param out_motion  The motion with planted feet.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a foot that is no track or has nothing to bend, no feet, an ease out of range),
///         MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_STRING, MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_plant(
    context: *mut mry_context,
    motion: mry_motion,
    desc: *const mry_plant_desc,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let params = plant_params(desc)?;
        let Planted { motion, .. } = plant(&*call.motion(motion)?, &params)?;
        out.set(call.keep_motion(Arc::new(motion))?);
        Ok(Code::MRY_OK)
    })
}

/// When the feet of a motion are down, and how they slide, as JSON: `{"ground": [x, y], "feet": [{"track": "fore_near",
/// "spans": [[first, last], ...], "slide": [before, after]}, ...]}`, the ground's way and slides in pixels a frame.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param desc      How feet would be planted; NULL for the defaults.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, and what mry_motion_plant returns.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_contacts(
    context: *mut mry_context,
    motion: mry_motion,
    desc: *const mry_plant_desc,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let params = plant_params(desc)?;
        text.fill(&plant(&*call.motion(motion)?, &params)?.contacts_json())
    })
}
