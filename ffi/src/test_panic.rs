//! Panics on demand, to prove that every exported function contains one. Only in tests.

use std::sync::atomic::{AtomicU8, Ordering};

use crate::context::{Context, mry_context};

/// When a context's next call panics.
pub(crate) type Armed = AtomicU8;

/// The next call panics before it does anything.
pub const AT_START: u8 = 1;
/// The next call panics once it has found its first object.
pub const AT_LOOKUP: u8 = 2;
/// The next job panics on its worker.
pub const IN_JOB: u8 = 3;

/// Makes the next call (or job) of `context` panic.
///
/// # Safety
/// `context` is alive.
pub unsafe fn arm(context: *mut mry_context, when: u8) {
    // SAFETY: as this function's own.
    unsafe { (*context).0.armed.store(when, Ordering::SeqCst) }
}

fn fire(context: &Context, when: u8) -> bool {
    context.armed.compare_exchange(when, 0, Ordering::SeqCst, Ordering::SeqCst).is_ok()
}

pub(crate) fn at_start(context: &Context) {
    assert!(!fire(context, AT_START), "a forced defect");
}

pub(crate) fn at_lookup(context: &Context) {
    assert!(!fire(context, AT_LOOKUP), "a forced defect");
}

/// Whether the job that is being started is to panic.
pub(crate) fn in_job(context: &Context) -> bool {
    fire(context, IN_JOB)
}
