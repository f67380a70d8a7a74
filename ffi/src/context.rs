//! Contexts. A context holds everything that the library knows: objects, threads, the log sink. Two contexts never
//! see each other, and the library has no state outside of them.
//!
//! Everything below a context is an id: a small value, typed, where {0} is no object. An id whose object was
//! destroyed is answered with MRY_E_STALE, never followed. Destroying a context destroys all in it; destroying in any
//! order is fine, and destroying no object is no error.
//!
//! Besides the statuses each function lists, every function that takes a context may return MRY_E_NULL (a pointer
//! that must point somewhere is NULL), MRY_E_STALE, MRY_E_POISONED and MRY_E_PANIC. Outputs are written only on
//! MRY_OK, the needed count of a buffer that is too small excepted.
//!
//! Threads: calls marked [any-thread] may be made from any thread at any time while the context lives, on the same
//! objects too; a call that finds its object being changed by another returns MRY_E_BUSY at once. Calls marked
//! [outside-callbacks] are the same, but return MRY_E_REENTRANT inside a callback of the library.

use std::ffi::c_void;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use marey::clip::{ClipOptions, FrameMemory};

use crate::allocator::{self, mry_allocator};
use crate::binding::BindingTable;
use crate::border::{self, Out, Versioned};
use crate::character::CharacterTable;
use crate::clip::ClipTable;
use crate::control_points::ControlPointsTable;
use crate::creature::CreatureTable;
use crate::crowd::CrowdTable;
use crate::deforming::DeformationTable;
use crate::error::{Failure, mry_error};
use crate::executor::{Executor, MAX_THREADS};
use crate::guard::{contain, entry};
use crate::job::JobTable;
use crate::joints::JointsTable;
use crate::limits::{Limits, mry_limits};
use crate::maps::MapTable;
use crate::masks::MasksTable;
use crate::motion::MotionTable;
use crate::plugins::Plugins;
use crate::point_tracking::Footages;
use crate::poses::PosesTable;
use crate::posing::PoserTable;
use crate::printing::SolidTable;
use crate::rendering::Renderers;
use crate::rig::RigTable;
use crate::session::SessionTable;
use crate::sketch_take::SketchTakeTable;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;
use crate::take::TakeTable;
use crate::threads::{Spawn, mry_executor};
use crate::vector::DrawingTable;
use crate::version;

/// The library's whole state for one user. Opaque.
pub struct mry_context(pub(crate) Context);

/// Log level: a contained defect of the library.
pub const MRY_LOG_ERROR: i32 = 1;
/// Log level: something a person should know, such as a clip that ends early.
pub const MRY_LOG_WARNING: i32 = 2;
/// Log level: what the library did, such as a job that ended and its seconds.
pub const MRY_LOG_INFO: i32 = 3;
/// Log level: the host made a call that can never be right, such as one with a stale id.
pub const MRY_LOG_HOST_MISBEHAVING: i32 = 10;

/// Takes one line of the log. It is called on the thread of the call that logs, or on a thread of the library for a
/// job; from several threads at a time; without any lock held. The message is valid until it returns. It must not
/// throw, and must not make calls marked [outside-callbacks].
///
/// @param level    MRY_LOG_ERROR, ...; accept ones you do not know.
/// @param message  The line, without a line end; not NUL-terminated.
/// @param user     log_user of the description.
/// Thread: [worker-thread].
pub type mry_log_fn = Option<unsafe extern "C" fn(level: i32, message: mry_str, user: *mut c_void)>;

/// What to create a context with. Start from MRY_CONTEXT_DESC_INIT.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_context_desc {
    /// sizeof(mry_context_desc).
    pub struct_size: u32,
    /// MRY_ABI_VERSION.
    pub abi_version: u32,
    /// Worker threads for jobs; 0 for one a core. Results do not depend on it.
    pub threads: u32,
    /// Zero.
    pub reserved0: u32,
    /// Where log lines go; NULL for nowhere.
    pub log: mry_log_fn,
    /// Handed to log.
    pub log_user: *mut c_void,
    /// What the context will work on at most; NULL for the defaults. Read by mry_context_create only.
    pub limits: *const mry_limits,
    /// Where threads come from; NULL for the library's own. Read by mry_context_create only.
    pub executor: *const mry_executor,
    /// Where the memory for decoded frames comes from; NULL for the library's own. Read by mry_context_create only.
    pub allocator: *const mry_allocator,
}

// SAFETY: repr(C), starts with its u32 size; integers, a nullable function and a pointer, which the host vouches for.
unsafe impl Versioned for mry_context_desc {
    const FIRST_SIZE: usize = 32;
}
const _: () = assert!(size_of::<mry_context_desc>() == 56);

struct LogSink {
    sink: mry_log_fn,
    user: *mut c_void,
    /// How many threads are inside the sink.
    inside: AtomicU32,
}

// SAFETY: mry_log_fn's contract says that it is called from any thread; the pointer is only handed to it.
unsafe impl Send for LogSink {}
// SAFETY: as above.
unsafe impl Sync for LogSink {}

/// What C sees as mry_context.
pub(crate) struct Context {
    pub(crate) poisoned: AtomicBool,
    pub(crate) clips: ClipTable,
    pub(crate) rigs: RigTable,
    pub(crate) motions: MotionTable,
    pub(crate) masks: MasksTable,
    pub(crate) creatures: CreatureTable,
    pub(crate) jobs: JobTable,
    pub(crate) sessions: SessionTable,
    pub(crate) maps: MapTable,
    pub(crate) deformations: DeformationTable,
    pub(crate) characters: CharacterTable,
    pub(crate) posers: PoserTable,
    pub(crate) poses: PosesTable,
    pub(crate) takes: TakeTable,
    pub(crate) joints: JointsTable,
    pub(crate) control_points: ControlPointsTable,
    pub(crate) drawings: DrawingTable,
    pub(crate) bindings: BindingTable,
    pub(crate) sketch_takes: SketchTakeTable,
    pub(crate) crowds: CrowdTable,
    pub(crate) solids: SolidTable,
    pub(crate) footages: Footages,
    pub(crate) plugins: Plugins,
    pub(crate) renderers: Renderers,
    pub(crate) limits: Limits,
    memory: Option<Arc<dyn FrameMemory>>,
    log: Arc<LogSink>,
    pub(crate) executor: Executor,
    #[cfg(feature = "test-panic")]
    pub(crate) armed: crate::test_panic::Armed,
}

impl Context {
    /// How a clip may be opened: as `asked`, within the limits, with frames where the host wants them.
    pub(crate) fn clip_options(&self, asked: ClipOptions) -> ClipOptions {
        ClipOptions { memory: self.memory.clone(), ..self.limits.clip_options(asked) }
    }

    /// Hands a line to the host's sink.
    pub(crate) fn log(&self, level: i32, message: &str) {
        log(&self.log, level, message);
    }

    /// The way to the host's sink for a job, which may outlive the call that starts it.
    pub(crate) fn logger(&self) -> impl Fn(i32, &str) + Send + Sync + use<> {
        let sink = self.log.clone();
        move |level, message| log(&sink, level, message)
    }

    /// Lets only the destruction of an object go on: a panic may have left it half-changed.
    pub(crate) fn poison(&self, id: u64) {
        self.clips.poison(id);
        self.rigs.poison(id);
        self.motions.poison(id);
        self.masks.poison(id);
        self.creatures.poison(id);
        self.jobs.poison(id);
        self.sessions.poison(id);
        self.maps.poison(id);
        self.deformations.poison(id);
        self.characters.poison(id);
        self.posers.poison(id);
        self.poses.poison(id);
        self.takes.poison(id);
        self.joints.poison(id);
        self.control_points.poison(id);
        self.drawings.poison(id);
        self.bindings.poison(id);
        self.sketch_takes.poison(id);
        self.crowds.poison(id);
        self.solids.poison(id);
    }

    /// Refuses calls that wait for the context's threads from inside a callback.
    pub(crate) fn refuse_callbacks(&self) -> Result<(), Failure> {
        if self.executor.is_own_thread() {
            let message = "the call waits for the library's threads, and was made on one: not inside a callback";
            return Err(Failure::new(Code::MRY_E_REENTRANT, "context", message));
        }
        Ok(())
    }
}

fn log(sink: &LogSink, level: i32, message: &str) {
    if let Some(line) = sink.sink {
        let text = mry_str { data: message.as_ptr().cast(), len: message.len() };
        sink.inside.fetch_add(1, Ordering::AcqRel);
        // SAFETY: the host gave the function and the pointer for this; the text outlives the call.
        unsafe { line(level, text, sink.user) };
        sink.inside.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros;
/// abi_version is left to the caller.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_context_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_context_desc_init(desc: *mut mry_context_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Creates a context and starts its threads.
///
/// @param desc         What to create it with.
/// @param out_context  The context.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NULL, MRY_E_STRUCT_SIZE, MRY_E_UNSUPPORTED, MRY_E_ABI (the host's header is of another
///         version), MRY_E_ARGUMENT (threads above 1024, a limit above its bound), MRY_E_THREADS.
/// Lifetime: until mry_context_destroy.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_context_create(
    desc: *const mry_context_desc,
    out_context: *mut *mut mry_context,
    err: *mut mry_error,
) -> mry_status {
    let body = || {
        // SAFETY: each is NULL or valid for its type, which the header asks for.
        let (desc, out) = unsafe { (border::read(desc, "desc")?, Out::new(out_context, "out_context")?) };
        version::check(desc.abi_version)?;
        border::reserved(desc.reserved0)?;
        if desc.threads as usize > MAX_THREADS {
            let message = format!("desc.threads is {}, and at most {MAX_THREADS} are allowed", desc.threads);
            return Err(Failure::argument("desc", message));
        }
        // SAFETY: each is NULL or points at a struct of its own size, which the header asks for.
        let (limits, spawn) = unsafe { (Limits::read(desc.limits)?, Spawn::read(desc.executor)?) };
        // SAFETY: as above.
        let memory = unsafe { allocator::read(desc.allocator)? };
        let executor = Executor::new(desc.threads as usize, &spawn)?;
        // Ids of this context are told from another's by where its pool lies.
        let tag = Arc::as_ptr(&executor.pool()) as usize as u64;
        let tag = tag >> 4 ^ tag >> 16;
        let most = limits.objects;
        let context = Context {
            poisoned: AtomicBool::new(false),
            clips: Table::new(1, tag, most),
            rigs: Table::new(2, tag, most),
            motions: Table::new(3, tag, most),
            masks: Table::new(4, tag, most),
            creatures: Table::new(5, tag, most),
            jobs: Table::new(6, tag, most),
            sessions: Table::new(7, tag, most),
            maps: Table::new(14, tag, most),
            deformations: Table::new(8, tag, most),
            characters: Table::new(10, tag, most),
            posers: Table::new(11, tag, most),
            poses: Table::new(12, tag, most),
            takes: Table::new(13, tag, most),
            joints: Table::new(9, tag, most),
            control_points: Table::new(15, tag, most),
            footages: Footages::default(),
            drawings: Table::new(16, tag, most),
            bindings: Table::new(17, tag, most),
            sketch_takes: Table::new(18, tag, most),
            crowds: Table::new(19, tag, most),
            solids: Table::new(20, tag, most),
            plugins: Plugins::default(),
            renderers: Renderers::default(),
            limits,
            memory,
            log: Arc::new(LogSink { sink: desc.log, user: desc.log_user, inside: AtomicU32::new(0) }),
            executor,
            #[cfg(feature = "test-panic")]
            armed: crate::test_panic::Armed::default(),
        };
        out.set(Box::into_raw(Box::new(mry_context(context))));
        Ok(Code::MRY_OK)
    };
    // SAFETY: `err` is NULL or valid, which the header asks for.
    unsafe { contain(err, body) }
}

/// Destroys a context and all in it: cancels its jobs, waits for its threads, frees its objects. No other call on it
/// may be running. Calls on it afterwards are undefined.
///
/// @param context  The context; NULL is no error.
/// @return MRY_OK; MRY_E_REENTRANT inside a callback of this context, which then lives on.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_context_destroy(context: *mut mry_context) -> mry_status {
    let body = || {
        if context.is_null() {
            return Ok(Code::MRY_OK);
        }
        // SAFETY: not NULL, and made by mry_context_create, which the header asks for.
        let inner = unsafe { &(*context).0 };
        inner.refuse_callbacks()?;
        if inner.log.inside.load(Ordering::Acquire) > 0 {
            return Err(Failure::new(Code::MRY_E_REENTRANT, "context", "not inside a callback"));
        }
        inner.jobs.all().iter().for_each(|job| job.value.cancel());
        // SAFETY: made by Box::into_raw in mry_context_create; no other call is running, and none will be made.
        drop(unsafe { Box::from_raw(context) });
        Ok(Code::MRY_OK)
    };
    // SAFETY: there is no error to fill.
    unsafe { contain(std::ptr::null_mut(), body) }
}

/// How many worker threads the context has.
///
/// @param context      The context.
/// @param out_threads  The number, at least 1.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_context_get_threads(
    context: *mut mry_context,
    out_threads: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_threads, "out_threads")?;
        out.set(call.context.executor.threads() as u32);
        Ok(Code::MRY_OK)
    })
}
