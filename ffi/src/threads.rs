//! Threads of the host's. A host that has an executor of its own can lend its threads to a context instead of letting
//! the library start some: each worker of the library then runs on one thread of the host's until the context is
//! destroyed. Results do not depend on whose threads they are.

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

use crate::border::{self, Versioned};
use crate::error::Outcome;

/// What a lent thread runs, once. It returns when the context is destroyed, and throws nothing.
///
/// @param worker  What mry_spawn_fn was given.
/// Thread: [worker-thread].
pub type mry_worker_fn = Option<unsafe extern "C" fn(worker: *mut c_void)>;

/// Lends a thread: has run(worker) called, soon, on a thread that does nothing else until that returns. It is called
/// by mry_context_create, once for each worker and once for the thread that hands out the jobs, and must not throw. A
/// worker must be run exactly once when the answer is 0, and never when it is not.
///
/// @param run     What to call.
/// @param worker  What to hand to it.
/// @param user    user of the description.
/// @return 0; anything else when there is no thread to lend, which makes the context fail with MRY_E_THREADS.
/// Thread: [any-thread].
pub type mry_spawn_fn = Option<unsafe extern "C" fn(run: mry_worker_fn, worker: *mut c_void, user: *mut c_void) -> i32>;

/// Where a context's threads come from. Start from MRY_EXECUTOR_INIT.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_executor {
    /// sizeof(mry_executor).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// Lends a thread.
    pub spawn: mry_spawn_fn,
    /// Handed to spawn.
    pub user: *mut c_void,
}

// SAFETY: repr(C), starts with its u32 size; an integer, a nullable function and a pointer, which the host vouches for.
unsafe impl Versioned for mry_executor {
    const FIRST_SIZE: usize = 24;
}
const _: () = assert!(size_of::<mry_executor>() == 24);

/// Fills in an executor with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param executor  Where to write; NULL does nothing.
/// @param size      sizeof(mry_executor) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_executor_init(executor: *mut mry_executor, size: u32) {
    // SAFETY: the caller owns `size` bytes at `executor`, or passes NULL.
    unsafe { border::init(executor.cast(), size) }
}

/// What a thread of a context does.
pub(crate) type Body = Box<dyn FnOnce() + Send>;

/// Starts threads, or has the host lend them.
pub(crate) enum Spawn {
    Own,
    Lent(mry_executor),
}

/// A running thread, waited for by [`Self::join`].
pub(crate) enum Running {
    Own(JoinHandle<()>),
    Lent(Arc<Ended>),
}

/// Whether a lent thread has come to the end of its work.
#[derive(Default)]
pub(crate) struct Ended {
    done: Mutex<bool>,
    changed: Condvar,
}

/// What a lent thread is handed.
struct Worker {
    body: Body,
    ended: Arc<Ended>,
}

impl Spawn {
    /// The executor at `ptr`, or the library's own threads for NULL.
    ///
    /// # Safety
    /// As for [`border::read`].
    pub(crate) unsafe fn read(ptr: *const mry_executor) -> Outcome<Self> {
        if ptr.is_null() {
            return Ok(Self::Own);
        }
        // SAFETY: as this function's own.
        let executor = unsafe { border::read(ptr, "desc.executor")? };
        border::reserved(executor.reserved0)?;
        if executor.spawn.is_none() {
            return Err(border::null("desc.executor.spawn"));
        }
        Ok(Self::Lent(executor))
    }

    pub(crate) fn start(&self, name: String, stack: Option<usize>, body: Body) -> std::io::Result<Running> {
        match self {
            Self::Own => {
                let mut builder = Builder::new().name(name);
                if let Some(size) = stack {
                    builder = builder.stack_size(size);
                }
                Ok(Running::Own(builder.spawn(body)?))
            }
            Self::Lent(executor) => {
                let refused = || std::io::Error::other("the host lends no thread");
                let spawn = executor.spawn.ok_or_else(refused)?;
                let ended = Arc::new(Ended::default());
                let worker = Box::into_raw(Box::new(Worker { body, ended: ended.clone() }));
                // SAFETY: the host gave the function for this; the worker lives until it is run, which the host does
                // exactly once when it answers 0.
                if unsafe { spawn(Some(run), worker.cast(), executor.user) } == 0 {
                    return Ok(Running::Lent(ended));
                }
                // SAFETY: the host has not run it, and will not.
                drop(unsafe { Box::from_raw(worker) });
                Err(refused())
            }
        }
    }
}

impl Running {
    /// Waits for its end. A thread that panicked has nothing more to say.
    pub(crate) fn join(self) {
        match self {
            Self::Own(thread) => drop(thread.join()),
            Self::Lent(ended) => {
                let mut done = ended.done.lock().unwrap_or_else(PoisonError::into_inner);
                while !*done {
                    done = ended.changed.wait(done).unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
    }
}

/// # Safety
/// `worker` comes from [`Spawn::start`], and has not been run.
unsafe extern "C" fn run(worker: *mut c_void) {
    // SAFETY: as this function's own.
    let Worker { body, ended } = *unsafe { Box::from_raw(worker.cast::<Worker>()) };
    // A panic must not reach the host; jobs contain their own, so that nobody is left to be told.
    catch_unwind(AssertUnwindSafe(body)).ok();
    *ended.done.lock().unwrap_or_else(PoisonError::into_inner) = true;
    ended.changed.notify_all();
}
