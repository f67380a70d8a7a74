//! Another time for what moves: motions, creatures and takes that are faster, longer, eased, backwards or held on twos. Each
//! gives a new one; what was given stays.

use std::sync::Arc;

use marey::motion::{Course, Direction, Retime, TimeKey, retime};

use crate::border::{self, List, Out, Versioned};
use crate::context::mry_context;
use crate::creature::{Creature, mry_creature};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::motion::mry_motion;
use crate::motion_cycle::{given, switch};
use crate::poses::easing_in;
use crate::sketch_take::{Sketched, mry_sketch_take};
use crate::status::{mry_status, mry_status_code as Code};
use crate::take::{Played, mry_take};

/// Which way a motion is gone through: as it was.
pub const MRY_DIRECTION_FORWARD: i32 = 0;
/// Which way a motion is gone through: from its end to its beginning.
pub const MRY_DIRECTION_BACKWARD: i32 = 1;
/// Which way a motion is gone through: to its end and back, so that it may be repeated.
pub const MRY_DIRECTION_THERE_AND_BACK: i32 = 2;

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

/// How something that moves is given another time. Start from MRY_RETIME_DESC_INIT; nothing must be set.
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
pub(crate) const MOST_KEYS: usize = 1 << 20;

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
/// @param size  sizeof(mry_retime_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_retime_desc_init(desc: *mut mry_retime_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
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

/// Gives a creature another time. What it was filmed in is not asked any more: the result's folder cannot be written.
///
/// @param context       The context.
/// @param creature      The creature.
/// @param desc          How; NULL for a copy.
/// @param out_creature  The creature at its new time; its motion too.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a speed, time or rate below 0, keys out of order or outside its frames), MRY_E_LIMIT
///         (frames), MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Lifetime: until mry_creature_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_retime(
    context: *mut mry_context,
    creature: mry_creature,
    desc: *const mry_retime_desc,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        let how = retime_params(desc)?;
        let creature = call.creature(creature)?;
        let made = creature.creature.retimed(&how)?;
        // A file that another program wrote says nothing of a motion.
        let motion = match creature.motion.tracks.is_empty() {
            true => creature.motion.clone(),
            false => Arc::new(retime(&creature.motion, &how)?),
        };
        let made = Creature::new(None, motion, made);
        out.set(call.keep_creature(Arc::new(made))?);
        Ok(Code::MRY_OK)
    })
}

/// Gives a character's take another time.
///
/// @param context   The context.
/// @param take      The take.
/// @param desc      How; NULL for a copy.
/// @param out_take  The take at its new time.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; what mry_creature_retime returns.
/// Lifetime: until mry_take_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_retime(
    context: *mut mry_context,
    take: mry_take,
    desc: *const mry_retime_desc,
    out_take: *mut mry_take,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_take, "out_take")?;
        let how = retime_params(desc)?;
        let played = call.take(take)?;
        let made = Played::new(played.drawn.clone(), played.take.retimed(&how)?, played.report.clone());
        out.set(call.keep_take(Arc::new(made))?);
        Ok(Code::MRY_OK)
    })
}

/// Gives a drawing's take another time.
///
/// @param context   The context.
/// @param take      The take.
/// @param desc      How; NULL for a copy.
/// @param out_take  The take at its new time.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; what mry_creature_retime returns.
/// Lifetime: until mry_sketch_take_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_take_retime(
    context: *mut mry_context,
    take: mry_sketch_take,
    desc: *const mry_retime_desc,
    out_take: *mut mry_sketch_take,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_take, "out_take")?;
        let how = retime_params(desc)?;
        let sketched = call.sketch_take(take)?;
        let made = Sketched { vector: sketched.vector.clone(), take: sketched.take.retimed(&how)? };
        out.set(call.keep_sketch_take(Arc::new(made))?);
        Ok(Code::MRY_OK)
    })
}

/// Which frame comes when something is given another time: for each frame of the result the place in what it is made of, in
/// frames from 0, which may lie between two. For what plays it, and shows both at one time.
///
/// @param context      The context.
/// @param frame_count  Frames of what is given another time, 1 or more.
/// @param fps          Its frames a second.
/// @param desc         How; NULL for every frame as it is.
/// @param places       Where the places go; NULL with capacity 0 to ask for their count.
/// @param capacity     Places that fit.
/// @param out_count    How many there are: frames of the result.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no frames, a speed, time or rate below 0, keys out of order or outside the frames),
///         MRY_E_LIMIT (frames), MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRUCT_SIZE, MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_retime_read_places(
    context: *mut mry_context,
    frame_count: u64,
    fps: f64,
    desc: *const mry_retime_desc,
    places: *mut f64,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |_call| {
        let list = List::new(places, capacity, out_count, "places")?;
        let how = retime_params(desc)?;
        let Course { places, .. } = how.course(usize::try_from(frame_count).unwrap_or(usize::MAX), fps)?;
        list.fill(&places)
    })
}
