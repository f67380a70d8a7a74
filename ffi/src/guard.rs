//! What every function does before and after its own work: check the context and the error, contain panics, fill the
//! error. Here the contract of all the `unsafe` functions is stated once.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::border::{OutStruct, Versioned};
use crate::context::{Context, MRY_LOG_ERROR, MRY_LOG_HOST_MISBEHAVING, mry_context};
use crate::error::{Failure, Outcome, copy_text, mry_error};
use crate::status::{mry_status, mry_status_code as Code};
use crate::table::{Slot, Table};

// SAFETY: repr(C), starts with its u32 size, and holds integers only.
unsafe impl Versioned for mry_error {
    const FIRST_SIZE: usize = size_of::<Self>();
}

/// The body of an exported function that works on a context.
macro_rules! entry {
    ($context:expr, $err:expr, |$call:ident| $body:block) => {
        // SAFETY: by the header's contract the context is NULL or alive, and every other pointer is NULL or valid for
        // the size that is stated for it, until the call returns. The body checks each for NULL through `border`.
        unsafe { $crate::guard::guard($context, $err, false, |$call| $body) }
    };
}
/// The body of a function that destroys an object: it works in a poisoned context too, and has no error to fill.
macro_rules! ending {
    ($context:expr, |$call:ident| $body:block) => {
        // SAFETY: as for `entry`.
        unsafe { $crate::guard::guard($context, std::ptr::null_mut(), true, |$call| $body) }
    };
}
pub(crate) use {ending, entry};

/// One call in progress: its context, and the objects it may leave half-changed.
pub(crate) struct Call<'a> {
    pub(crate) context: &'a Context,
    touched: Touched,
}

/// The ids of the objects of one call. Most calls have one object, and allocate nothing for it.
#[derive(Default)]
struct Touched {
    first: Cell<u64>,
    more: RefCell<Vec<u64>>,
}

impl Call<'_> {
    /// The object of `id`, which a panic of this call will poison.
    pub(crate) fn get<T>(&self, table: &Table<T>, id: u64, param: &'static str) -> Outcome<Arc<Slot<T>>> {
        let slot = table.get(id, param)?;
        match self.touched.first.get() {
            0 => self.touched.first.set(id),
            _ => self.touched.more.borrow_mut().push(id),
        }
        #[cfg(feature = "test-panic")]
        crate::test_panic::at_lookup(self.context);
        Ok(slot)
    }

    fn poison(&self) {
        match self.touched.first.get() {
            0 => self.context.poisoned.store(true, Ordering::Release),
            first => self.touched.more.borrow().iter().chain([&first]).for_each(|id| self.context.poison(*id)),
        }
    }
}

/// What a panic says.
pub(crate) fn panic_text(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
    format!("a defect of the library: {text}; please report it")
}

/// Runs `body` with panics contained. Without a context, for the functions that make one.
///
/// # Safety
/// `err` is null or points at an mry_error of its own struct_size.
pub(crate) unsafe fn contain(err: *mut mry_error, body: impl FnOnce() -> Outcome<Code>) -> mry_status {
    // SAFETY: as this function's own.
    let error = match unsafe { OutStruct::optional(err, "err") } {
        Ok(error) => error,
        // There is nowhere to put the detail.
        Err(failure) => return failure.status,
    };
    let result = catch_unwind(AssertUnwindSafe(body))
        .unwrap_or_else(|payload| Err(Failure::new(Code::MRY_E_PANIC, "", panic_text(&*payload))));
    match result {
        Ok(code) => code as mry_status,
        Err(failure) => {
            if let Some(error) = error
                && failure.status < 0
            {
                error.set(&detail(&failure));
            }
            failure.status
        }
    }
}

fn detail(failure: &Failure) -> mry_error {
    let mut detail = mry_error { struct_size: 0, status: failure.status, message: [0; 512], param: [0; 64] };
    copy_text(&failure.message, &mut detail.message);
    copy_text(failure.param, &mut detail.param);
    detail
}

/// Runs `body` on a context. See [`entry`] and [`ending`].
///
/// # Safety
/// `context` is null or alive until the call returns; `err` as for [`contain`].
pub(crate) unsafe fn guard(
    context: *mut mry_context,
    err: *mut mry_error,
    even_poisoned: bool,
    body: impl FnOnce(&Call<'_>) -> Outcome<Code>,
) -> mry_status {
    let run = || {
        // SAFETY: as this function's own.
        let Some(context) = (unsafe { context.as_ref() }) else {
            return Err(Failure::new(Code::MRY_E_NULL, "context", "context is NULL"));
        };
        let context = &context.0;
        if !even_poisoned && context.poisoned.load(Ordering::Acquire) {
            let message = "the context was poisoned by an earlier defect; destroy it and create another";
            return Err(Failure::new(Code::MRY_E_POISONED, "context", message));
        }
        let call = Call { context, touched: Touched::default() };
        let result = catch_unwind(AssertUnwindSafe(|| {
            #[cfg(feature = "test-panic")]
            crate::test_panic::at_start(context);
            body(&call)
        }));
        let result = result.unwrap_or_else(|payload| {
            call.poison();
            let failure = Failure::new(Code::MRY_E_PANIC, "", panic_text(&*payload));
            context.log(MRY_LOG_ERROR, &failure.message);
            Err(failure)
        });
        if let Err(failure) = &result
            && is_misuse(failure.status)
        {
            context.log(MRY_LOG_HOST_MISBEHAVING, &failure.message);
        }
        result
    };
    // SAFETY: as this function's own.
    unsafe { contain(err, run) }
}

/// Whether a status tells of a mistake in the host's code, rather than of its data or of a fair question.
fn is_misuse(status: mry_status) -> bool {
    [
        Code::MRY_E_NULL,
        Code::MRY_E_STRUCT_SIZE,
        Code::MRY_E_STALE,
        Code::MRY_E_ARGUMENT,
        Code::MRY_E_NON_FINITE,
        Code::MRY_E_STRING,
        Code::MRY_E_TAKEN,
        Code::MRY_E_KIND,
        Code::MRY_E_REENTRANT,
    ]
    .iter()
    .any(|code| *code as mry_status == status)
}
