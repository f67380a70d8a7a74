//! Jobs. Long work runs on the context's threads while the host goes on: start it, poll or wait, take the result,
//! destroy the job. What a job works on is copied when it starts, so clips may be closed and rigs edited meanwhile.
//! Jobs of one context run one after another, each on all threads; those of two contexts run side by side. Results
//! are the same, bit for bit, with any number of threads.
//!
//! A cancel takes effect within 100 ms; a job that has ended is not changed by it. The mry_run functions do the same
//! work as a job and return when it is done.

use std::ffi::c_char;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::binding::mry_binding;
use crate::border::{self, Out, OutStruct, Text, Versioned};
use crate::character::mry_character;
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::control_points::mry_control_points;
use crate::creature::mry_creature;
use crate::error::{copy_text, mry_error};
use crate::guard::{ending, entry};
use crate::masks::mry_masks;
use crate::motion::mry_motion;
use crate::printing::mry_solid;
use crate::running::Job;
use crate::sketch_take::mry_sketch_take;
use crate::status::{mry_status, mry_status_code as Code};
use crate::table::Table;
use crate::take::mry_take;

pub(crate) type JobTable = Table<Arc<Job>>;

/// A job.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_job {
    /// The id; 0 is no job.
    pub v: u64,
}

/// How a job is doing.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_job_state {
    /// sizeof(mry_job_state).
    pub struct_size: u32,
    /// MRY_PENDING, MRY_OK, MRY_CANCELLED, or the error it ended with.
    pub status: mry_status,
    /// The share of the work that is done, 0..1; never goes back.
    pub fraction: f64,
    /// Rises whenever anything else in this struct has changed since the last poll.
    pub revision: u64,
    /// What is being done, a word or two, NUL-terminated: "waiting" before the job's turn.
    pub stage: [c_char; 48],
    /// The share of that stage that is done, 0..1; begins anew with each stage.
    pub stage_fraction: f64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_job_state {
    const FIRST_SIZE: usize = 72;
}
const _: () = assert!(size_of::<mry_job_state>() == 80);

/// Fills in a job state with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param state  Where to write; NULL does nothing.
/// @param size   sizeof(mry_job_state) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_state_init(state: *mut mry_job_state, size: u32) {
    // SAFETY: the caller owns `size` bytes at `state`, or passes NULL.
    unsafe { border::init(state.cast(), size) }
}

/// How a job is doing. Never waits.
///
/// @param context    The context.
/// @param job        The job.
/// @param out_state  The answer; its struct_size must be set.
/// @param err        Detail of a failure of the poll, not of the job; or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_poll(
    context: *mut mry_context,
    job: mry_job,
    out_state: *mut mry_job_state,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_state, "out_state")?;
        let (now, revision) = call.job(job)?.poll();
        let mut state = mry_job_state {
            struct_size: 0,
            status: now.status,
            fraction: now.fraction,
            revision,
            stage: [0; 48],
            stage_fraction: now.stage_fraction,
        };
        copy_text(now.stage, &mut state.stage);
        out.set(&state);
        Ok(Code::MRY_OK)
    })
}

/// Waits for a job's end.
///
/// @param context     The context.
/// @param job         The job.
/// @param timeout_ns  Nanoseconds to wait at most; 0 not to wait, MRY_FOREVER without an end.
/// @param err         Detail of the job's failure, or NULL.
/// @return MRY_OK when it is done, MRY_CANCELLED, the error it ended with, MRY_PENDING when the time is over;
///         MRY_E_REENTRANT.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_wait(
    context: *mut mry_context,
    job: mry_job,
    timeout_ns: u64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let job = call.job(job)?;
        // A time past what the clock can count is no end either.
        let until =
            if timeout_ns == u64::MAX { None } else { Instant::now().checked_add(Duration::from_nanos(timeout_ns)) };
        job.wait(until)
    })
}

/// Asks a job to stop and returns at once. The job ends within 100 ms with MRY_CANCELLED, or with its result when it
/// was just done; nothing half-written stays. On a job that has ended, and a second time, it does nothing.
///
/// @param context  The context.
/// @param job      The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_cancel(context: *mut mry_context, job: mry_job, err: *mut mry_error) -> mry_status {
    entry!(context, err, |call| {
        call.job(job)?.cancel();
        Ok(Code::MRY_OK)
    })
}

/// Takes the clip that an open job opened; once.
///
/// @param context   The context.
/// @param job       The job.
/// @param out_clip  The clip.
/// @param err       Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_clip_close or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_clip(
    context: *mut mry_context,
    job: mry_job,
    out_clip: *mut mry_clip,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_clip, "out_clip")?;
        call.job(job)?.take(|p| &mut p.clip, |clip| call.keep_clip(clip).map(|id| out.set(id)))
    })
}

/// Takes the motion that a job made; once.
///
/// @param context     The context.
/// @param job         The job.
/// @param out_motion  The motion.
/// @param err         Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_motion_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_motion(
    context: *mut mry_context,
    job: mry_job,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        call.job(job)?.take(|p| &mut p.motion, |motion| call.keep_motion(motion).map(|id| out.set(id)))
    })
}

/// Takes the masks that a segment or creature job made; once.
///
/// @param context    The context.
/// @param job        The job.
/// @param out_masks  The masks.
/// @param err        Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_masks_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_masks(
    context: *mut mry_context,
    job: mry_job,
    out_masks: *mut mry_masks,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_masks, "out_masks")?;
        call.job(job)?.take(|p| &mut p.masks, |masks| call.keep_masks(masks).map(|id| out.set(id)))
    })
}

/// Takes the creature that a creature job made; once.
///
/// @param context       The context.
/// @param job           The job.
/// @param out_creature  The creature.
/// @param err           Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_creature_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_creature(
    context: *mut mry_context,
    job: mry_job,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        call.job(job)?.take(|p| &mut p.creature, |creature| call.keep_creature(creature).map(|id| out.set(id)))
    })
}

/// Takes the character that a character job made; once.
///
/// @param context        The context.
/// @param job            The job.
/// @param out_character  The character.
/// @param err            Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_character_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_character(
    context: *mut mry_context,
    job: mry_job,
    out_character: *mut mry_character,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_character, "out_character")?;
        call.job(job)?.take(|p| &mut p.character, |drawn| call.keep_character(drawn).map(|id| out.set(id)))
    })
}

/// Takes the take that a take job made; once.
///
/// @param context   The context.
/// @param job       The job.
/// @param out_take  The take.
/// @param err       Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_take_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_take(
    context: *mut mry_context,
    job: mry_job,
    out_take: *mut mry_take,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_take, "out_take")?;
        call.job(job)?.take(|p| &mut p.take, |take| call.keep_take(take).map(|id| out.set(id)))
    })
}

/// Takes the control points that a job proposed; once.
///
/// @param context     The context.
/// @param job         The job.
/// @param out_points  The points.
/// @param err         Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_control_points_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_control_points(
    context: *mut mry_context,
    job: mry_job,
    out_points: *mut mry_control_points,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_points, "out_points")?;
        call.job(job)?.take(|p| &mut p.control_points, |points| call.keep_control_points(points).map(|id| out.set(id)))
    })
}

/// Takes the binding that a bind job made; once.
///
/// @param context      The context.
/// @param job          The job.
/// @param out_binding  The binding.
/// @param err          Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_binding_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_binding(
    context: *mut mry_context,
    job: mry_job,
    out_binding: *mut mry_binding,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_binding, "out_binding")?;
        call.job(job)?.take(|p| &mut p.binding, |binding| call.keep_binding(binding).map(|id| out.set(id)))
    })
}

/// Takes the take that a sketch take job made; once.
///
/// @param context   The context.
/// @param job       The job.
/// @param out_take  The take.
/// @param err       Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_sketch_take_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_sketch_take(
    context: *mut mry_context,
    job: mry_job,
    out_take: *mut mry_sketch_take,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_take, "out_take")?;
        call.job(job)?.take(|p| &mut p.sketch_take, |take| call.keep_sketch_take(take).map(|id| out.set(id)))
    })
}

/// Takes the solid that a print job made; once.
///
/// @param context    The context.
/// @param job        The job.
/// @param out_solid  The solid.
/// @param err        Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_solid_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_solid(
    context: *mut mry_context,
    job: mry_job,
    out_solid: *mut mry_solid,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_solid, "out_solid")?;
        call.job(job)?.take(|p| &mut p.solid, |solid| call.keep_solid(solid).map(|id| out.set(id)))
    })
}

/// What a bind, sketch take, print, take file or sketch file job says of its work, as JSON: the files, warnings, how far points are to be
/// trusted. It can be asked for again.
///
/// @param context   The context.
/// @param job       The job.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_KIND,
///         MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_get_report(
    context: *mut mry_context,
    job: mry_job,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        call.job(job)?.report(|report| text.fill(report))
    })
}

/// Destroys a job, cancelling it when it has not ended. Returns at once; the work stops behind it.
///
/// @param context  The context.
/// @param job      The job; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_destroy(context: *mut mry_context, job: mry_job) -> mry_status {
    ending!(context, |call| {
        if job.v != 0 {
            call.context.jobs.remove(job.v, "job")?.value.cancel();
        }
        Ok(Code::MRY_OK)
    })
}
