//! Cycles and loops. A gait comes back after a stride: how long it is, which limb is when, and a range of it closed into a
//! loop that goes on from its last frame to its first without a visible seam.

use std::sync::Arc;

use marey::motion::{ClosedLoop, GaitCycle, LoopParams, close_loop, find_cycle};

use crate::border::{self, Lists, Out, OutStruct, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::motion::mry_motion;
use crate::status::{mry_status, mry_status_code as Code};

/// The cycle of a motion.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_cycle {
    /// sizeof(mry_cycle).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// After so many frames all is the same again; no whole number.
    pub period: f64,
    /// The frame at which a period begins whose surroundings are most like those where it ends.
    pub start: f64,
    /// How surely this is a cycle, 0..1.
    pub confidence: f64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_cycle {
    const FIRST_SIZE: usize = 32;
}
const _: () = assert!(size_of::<mry_cycle>() == 32);

/// How a loop is closed. Start from MRY_LOOP_DESC_INIT; nothing must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_loop_desc {
    /// sizeof(mry_loop_desc).
    pub struct_size: u32,
    /// 1 to keep the way of the whole; 0 to stay in place.
    pub keep_travel: u32,
    /// The frame it begins at, where a period is given.
    pub start: f64,
    /// Frames until it begins again, 3 at least; 0 for the cycle that is found.
    pub period: f64,
    /// Cycles in the loop, where the cycle is found; 0 for 1.
    pub cycles: u32,
    /// 1 to fade nothing; else the share below.
    pub no_fade: u32,
    /// The share of the loop over which the frames of both ends are faded, up to 1; 0 for 0.25.
    pub fade: f64,
    /// Frames of the loop; 0 for as many as keep the pace best.
    pub frame_count: u64,
    /// Frames a second; 0 for the motion's own.
    pub fps: f64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_loop_desc {
    const FIRST_SIZE: usize = 56;
}
const _: () = assert!(size_of::<mry_loop_desc>() == 56);

/// How a loop was closed: what steps from frame to frame, over the seam and wherever both ends are faded, differ by from the
/// motion's own. Shares are of the figure's extent, the longer side of what it covers.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_seam {
    /// sizeof(mry_seam).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// The frame of the motion that the loop begins at.
    pub start: f64,
    /// How many frames of the motion it takes.
    pub period: f64,
    /// How far the whole goes to the right in a loop, in pixels, kept or not.
    pub travel_x: f64,
    /// How far it goes down.
    pub travel_y: f64,
    /// How far a step is from the motion's, the mean over points, in the frame where it is most.
    pub pose: f64,
    /// The same of the point where it is most.
    pub pose_most: f64,
    /// How far the change of a step is from the motion's, the mean over points, in the frame where it is most.
    pub speed: f64,
    /// The same of the point where it is most.
    pub speed_most: f64,
    /// How far a point goes from frame to frame of the loop, the mean.
    pub usual_step: f64,
    /// How much a step differs from the one before, the mean.
    pub usual_change: f64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_seam {
    const FIRST_SIZE: usize = 88;
}
const _: () = assert!(size_of::<mry_seam>() == 88);

/// A switch that is 0 or 1.
pub(crate) fn switch(value: u32, param: &'static str) -> Outcome<bool> {
    match value {
        0 | 1 => Ok(value == 1),
        _ => Err(Failure::argument(param, format!("{param} is {value}; give 0 or 1"))),
    }
}

/// A number where 0 stands for the default.
pub(crate) fn given(value: f64, param: &'static str) -> Outcome<Option<f64>> {
    if !value.is_finite() {
        return Err(Failure::new(Code::MRY_E_NON_FINITE, param, format!("{param} is {value}")));
    }
    Ok((value != 0.0).then_some(value))
}

unsafe fn loop_params(desc: *const mry_loop_desc) -> Outcome<LoopParams> {
    let mut params = LoopParams::default();
    if desc.is_null() {
        return Ok(params);
    }
    // SAFETY: by the header's contract, as for all descriptions; see `entry`.
    let desc = unsafe { border::read(desc, "desc")? };
    params.in_place = !switch(desc.keep_travel, "desc.keep_travel")?;
    let start = given(desc.start, "desc.start")?.unwrap_or(0.0);
    params.range = given(desc.period, "desc.period")?.map(|period| (start, period));
    params.cycles = desc.cycles.max(1);
    params.fade = given(desc.fade, "desc.fade")?.unwrap_or(params.fade);
    if switch(desc.no_fade, "desc.no_fade")? {
        params.fade = 0.0;
    }
    if desc.frame_count > 0 {
        params.frames = Some(usize::try_from(desc.frame_count).unwrap_or(usize::MAX));
    }
    params.fps = given(desc.fps, "desc.fps")?;
    Ok(params)
}

/// Fills in a cycle with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param cycle  Where to write; NULL does nothing.
/// @param size   sizeof(mry_cycle) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_cycle_init(cycle: *mut mry_cycle, size: u32) {
    // SAFETY: the caller owns `size` bytes at `cycle`, or passes NULL.
    unsafe { border::init(cycle.cast(), size) }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_loop_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_loop_desc_init(desc: *mut mry_loop_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a seam with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param seam  Where to write; NULL does nothing.
/// @param size  sizeof(mry_seam) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_seam_init(seam: *mut mry_seam, size: u32) {
    // SAFETY: the caller owns `size` bytes at `seam`, or passes NULL.
    unsafe { border::init(seam.cast(), size) }
}

/// Finds the cycle of a motion: after how many frames all of it moves the same way again.
///
/// @param context    The context.
/// @param motion     The motion.
/// @param out_cycle  The cycle.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (it stands still or shows no cycle, no tracks), MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_find_cycle(
    context: *mut mry_context,
    motion: mry_motion,
    out_cycle: *mut mry_cycle,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_cycle, "out_cycle")?;
        let GaitCycle { period, start, confidence, .. } = find_cycle(&*call.motion(motion)?)?;
        out.set(&mry_cycle { struct_size: 0, reserved0: 0, period, start, confidence });
        Ok(Code::MRY_OK)
    })
}

/// When in the cycle of a motion each track's end is farthest along its swing, and how far it swings.
///
/// @param context    The context.
/// @param motion     The motion.
/// @param phases     Where the phases go, 0..1 from the cycle's start, one a track; NULL to leave them out.
/// @param swings     Where the swings go, pixels to either side of the middle; NULL to leave them out.
/// @param capacity   Entries that each list has room for.
/// @param out_count  How many there are: as many as tracks.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, and what mry_motion_find_cycle returns.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_read_phases(
    context: *mut mry_context,
    motion: mry_motion,
    phases: *mut f64,
    swings: *mut f64,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let mut lists = Lists::new(capacity, out_count)?;
        let phases = lists.list(phases, 1, "phases")?;
        let swings = lists.list(swings, 1, "swings")?;
        let limbs = find_cycle(&*call.motion(motion)?)?.limbs;
        lists.fit(limbs.len())?;
        if let Some(list) = phases {
            list.write(&limbs.iter().map(|l| l.phase).collect::<Vec<_>>())?;
        }
        if let Some(list) = swings {
            list.write(&limbs.iter().map(|l| l.swing).collect::<Vec<_>>())?;
        }
        Ok(Code::MRY_OK)
    })
}

/// Closes a range of a motion into a loop: a motion whose first frame comes after its last.
///
/// @param context     The context.
/// @param motion      The motion.
/// @param desc        How; NULL for one cycle in place.
/// @param out_motion  The loop.
/// @param out_seam    How it was closed; or NULL.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no cycle, a range that the motion does not have, a fade or a rate out of range),
///         MRY_E_LIMIT (points of all frames), MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_loop(
    context: *mut mry_context,
    motion: mry_motion,
    desc: *const mry_loop_desc,
    out_motion: *mut mry_motion,
    out_seam: *mut mry_seam,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let out_seam = OutStruct::optional(out_seam, "out_seam")?;
        let params = loop_params(desc)?;
        let ClosedLoop { motion, start, period, travel, seam } = close_loop(&*call.motion(motion)?, &params)?;
        out.set(call.keep_motion(Arc::new(motion))?);
        if let Some(out) = out_seam {
            out.set(&mry_seam {
                struct_size: 0,
                reserved0: 0,
                start,
                period,
                travel_x: travel.x,
                travel_y: travel.y,
                pose: seam.pose,
                pose_most: seam.pose_most,
                speed: seam.speed,
                speed_most: seam.speed_most,
                usual_step: seam.usual_step,
                usual_change: seam.usual_change,
            });
        }
        Ok(Code::MRY_OK)
    })
}
