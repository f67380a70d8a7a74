//! Motions made smoother, steadier on their feet, faster or slower. Each gives a new motion; what was given stays.

use std::ffi::c_char;
use std::sync::Arc;

use marey::motion::{Direction, Held, PlantParams, Planted, Retime, SmoothParams, TimeKey, plant, retime, smooth};

use crate::border::{self, Out, Text, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::motion::mry_motion;
use crate::motion_cycle::{given, switch};
use crate::poses::easing_in;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Which way a motion is gone through: as it was.
pub const MRY_DIRECTION_FORWARD: i32 = 0;
/// Which way a motion is gone through: from its end to its beginning.
pub const MRY_DIRECTION_BACKWARD: i32 = 1;
/// Which way a motion is gone through: to its end and back, so that it may be repeated.
pub const MRY_DIRECTION_THERE_AND_BACK: i32 = 2;

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

/// At a frame of the result, a frame of the motion comes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_time_key {
    /// The frame of the result, from 0.
    pub at: f64,
    /// The frame of the motion.
    pub frame: f64,
    /// How time passes until the next key: MRY_EASING_LINEAR, ...
    pub easing: i32,
    /// Zero.
    pub reserved0: u32,
}

/// How a motion is given another time. Start from MRY_RETIME_DESC_INIT; nothing must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_retime_desc {
    /// sizeof(mry_retime_desc).
    pub struct_size: u32,
    /// MRY_DIRECTION_FORWARD, ...
    pub direction: i32,
    /// How many times as fast; 0 for 1.
    pub speed: f64,
    /// Seconds in all, in place of a speed; 0 for what the speed leads to.
    pub seconds: f64,
    /// Frames a second, in the same time; 0 for the motion's own.
    pub fps: f64,
    /// How time passes over the whole: MRY_EASING_LINEAR, ...
    pub easing: i32,
    /// Frames that each picture stands: 2 for on twos; 0 for 1.
    pub hold: u32,
    /// 1 if the motion is a loop: its first frame comes after its last, and the result is a loop too.
    pub closed: u32,
    /// 1 if speed changes without jumps from key to key, in place of the keys' easings.
    pub smooth: u32,
    /// When what comes, in order, in place of speed, seconds and easing.
    pub keys: *const mry_time_key,
    /// How many.
    pub key_count: usize,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and a pointer that the host vouches for.
unsafe impl Versioned for mry_retime_desc {
    const FIRST_SIZE: usize = 64;
}
const _: () = assert!(size_of::<mry_retime_desc>() == 64);

/// More keys than frames a motion may have are of no use.
const MOST_KEYS: usize = 1 << 20;

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

unsafe fn retime_params(desc: *const mry_retime_desc) -> Outcome<Retime> {
    let mut how = Retime::default();
    if desc.is_null() {
        return Ok(how);
    }
    // SAFETY: by the header's contract, as for all descriptions; see `entry`.
    let (desc, keys) = unsafe {
        let desc = border::read(desc, "desc")?;
        (desc, border::slice(desc.keys, desc.key_count, MOST_KEYS, "desc.keys")?)
    };
    how.direction = match desc.direction {
        MRY_DIRECTION_FORWARD => Direction::Forward,
        MRY_DIRECTION_BACKWARD => Direction::Backward,
        MRY_DIRECTION_THERE_AND_BACK => Direction::ThereAndBack,
        n => {
            return Err(Failure::argument(
                "desc.direction",
                format!("desc.direction is {n}, which is no MRY_DIRECTION"),
            ));
        }
    };
    how.speed = given(desc.speed, "desc.speed")?.unwrap_or(1.0);
    how.seconds = given(desc.seconds, "desc.seconds")?;
    how.fps = given(desc.fps, "desc.fps")?;
    how.easing = easing_in(desc.easing)?;
    how.hold = desc.hold.max(1) as usize;
    how.closed = switch(desc.closed, "desc.closed")?;
    how.smooth = switch(desc.smooth, "desc.smooth")?;
    for key in keys {
        border::reserved(key.reserved0)?;
        how.keys.push(TimeKey { at: key.at, frame: key.frame, easing: easing_in(key.easing)? });
    }
    Ok(how)
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

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_retime_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_retime_desc_init(desc: *mut mry_retime_desc, size: u32) {
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

/// Gives a motion another time: faster, longer, at another rate, backwards, there and back, on twos, or by keys.
///
/// @param context     The context.
/// @param motion      The motion.
/// @param desc        How; NULL for a copy.
/// @param out_motion  The motion at its new time.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a speed, time or rate below 0, keys out of order or outside the motion), MRY_E_LIMIT
///         (points of all frames), MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_retime(
    context: *mut mry_context,
    motion: mry_motion,
    desc: *const mry_retime_desc,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let how = retime_params(desc)?;
        let made = retime(&*call.motion(motion)?, &how)?;
        out.set(call.keep_motion(Arc::new(made))?);
        Ok(Code::MRY_OK)
    })
}
