//! Statuses. Every call that can fail returns one. Numbers stay for ever; new ones are added at the end of their block.

use std::ffi::{CStr, c_char};

/// What a call came to: 0 is success, above 0 an outcome that is no error, below 0 an error. Values are those of
/// mry_status_code; accept ones you do not know, by their sign.
pub type mry_status = i32;

/// The values of mry_status, errors in blocks of a hundred by whose they are.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum mry_status_code {
    /// Done.
    MRY_OK = 0,
    /// The job is waiting or running.
    MRY_PENDING = 1,
    /// The job was cancelled.
    MRY_CANCELLED = 2,

    /// A pointer that must point somewhere is NULL.
    MRY_E_NULL = -101,
    /// A struct_size is smaller than the first version of the struct, or absurd.
    MRY_E_STRUCT_SIZE = -102,
    /// Something is asked for that this version of the library does not know.
    MRY_E_UNSUPPORTED = -103,
    /// An id is null, of another context, or of an object that was destroyed.
    MRY_E_STALE = -104,
    /// A value is outside its range.
    MRY_E_ARGUMENT = -105,
    /// A number is NaN or infinite.
    MRY_E_NON_FINITE = -106,
    /// A string is not UTF-8, or has a NUL where none may be.
    MRY_E_STRING = -107,
    /// The buffer is too small; where the function has an out_count it holds the count that is needed.
    MRY_E_BUFFER_TOO_SMALL = -108,
    /// Another thread is changing the object.
    MRY_E_BUSY = -109,
    /// The job's result was taken before.
    MRY_E_TAKEN = -110,
    /// The job makes a result of another kind.
    MRY_E_KIND = -111,
    /// There is no such thing, though the question was a fair one.
    MRY_E_NOT_FOUND = -112,
    /// The host was compiled with a header of another ABI.
    MRY_E_ABI = -113,
    /// The call is not allowed inside a callback.
    MRY_E_REENTRANT = -114,

    /// A file or a value in it is not what it should be; the message says where and what to do.
    MRY_E_INPUT = -201,
    /// A file or folder does not exist.
    MRY_E_NO_FILE = -202,

    /// Something is larger than the library allows.
    MRY_E_LIMIT = -301,
    /// The host's allocator had no memory to lend.
    MRY_E_MEMORY = -302,

    /// The operating system refused: disk full, no permission, a failing device.
    MRY_E_IO = -401,
    /// No thread could be started.
    MRY_E_THREADS = -402,
    /// There is no GPU, or it failed.
    MRY_E_GPU = -403,

    /// There is no plugin of that name, or no file.
    MRY_E_PLUGIN_NOT_FOUND = -501,
    /// The plugin's file is being written.
    MRY_E_PLUGIN_UNSTABLE_FILE = -502,
    /// The plugin's file ends before it should.
    MRY_E_PLUGIN_TRUNCATED = -503,
    /// The plugin's file is not the one that its manifest describes.
    MRY_E_PLUGIN_HASH = -504,
    /// The file is no plugin for this machine, or its manifest is damaged.
    MRY_E_PLUGIN_FORMAT = -505,
    /// The system's loader refused the plugin's file.
    MRY_E_PLUGIN_DLOPEN = -506,
    /// The library exports no plugin.
    MRY_E_PLUGIN_NO_ENTRY = -507,
    /// The plugin is made for another version of the interface.
    MRY_E_PLUGIN_ABI_VERSION = -508,
    /// The plugin's types are laid out in another way.
    MRY_E_PLUGIN_LAYOUT = -509,
    /// What the library says of its plugins cannot be.
    MRY_E_PLUGIN_DESCRIPTOR = -510,
    /// The plugin did not start.
    MRY_E_PLUGIN_INIT = -511,
    /// The plugin panicked, and was contained.
    MRY_E_PLUGIN_PANICKED = -512,
    /// The plugin's instance panicked before.
    MRY_E_PLUGIN_POISONED = -513,
    /// The plugin gave no sign of life in time.
    MRY_E_PLUGIN_TIMEOUT = -514,
    /// The plugin's file failed too often.
    MRY_E_PLUGIN_QUARANTINED = -515,
    /// The plugin is switched off.
    MRY_E_PLUGIN_DISABLED = -516,
    /// The plugin ended the process that tried it.
    MRY_E_PLUGIN_CRASHED = -517,
    /// What the plugin returned cannot be used.
    MRY_E_PLUGIN_OUTPUT = -518,
    /// The plugin said that it failed.
    MRY_E_PLUGIN_FAILED = -519,
    /// A private copy of the plugin could not be made, or not be run.
    MRY_E_PLUGIN_COPY = -520,
    /// Too many builds of plugins were loaded.
    MRY_E_PLUGIN_GENERATIONS = -521,

    /// A defect of the library, contained; the object, or else the context, is poisoned.
    MRY_E_PANIC = -901,
    /// The object or the context was poisoned by an earlier MRY_E_PANIC; it can only be destroyed.
    MRY_E_POISONED = -902,
}

impl mry_status_code {
    /// All codes, for the lookup from a number.
    const ALL: [Self; 47] = [
        Self::MRY_OK,
        Self::MRY_PENDING,
        Self::MRY_CANCELLED,
        Self::MRY_E_NULL,
        Self::MRY_E_STRUCT_SIZE,
        Self::MRY_E_UNSUPPORTED,
        Self::MRY_E_STALE,
        Self::MRY_E_ARGUMENT,
        Self::MRY_E_NON_FINITE,
        Self::MRY_E_STRING,
        Self::MRY_E_BUFFER_TOO_SMALL,
        Self::MRY_E_BUSY,
        Self::MRY_E_TAKEN,
        Self::MRY_E_KIND,
        Self::MRY_E_NOT_FOUND,
        Self::MRY_E_ABI,
        Self::MRY_E_REENTRANT,
        Self::MRY_E_INPUT,
        Self::MRY_E_NO_FILE,
        Self::MRY_E_LIMIT,
        Self::MRY_E_MEMORY,
        Self::MRY_E_IO,
        Self::MRY_E_THREADS,
        Self::MRY_E_GPU,
        Self::MRY_E_PLUGIN_NOT_FOUND,
        Self::MRY_E_PLUGIN_UNSTABLE_FILE,
        Self::MRY_E_PLUGIN_TRUNCATED,
        Self::MRY_E_PLUGIN_HASH,
        Self::MRY_E_PLUGIN_FORMAT,
        Self::MRY_E_PLUGIN_DLOPEN,
        Self::MRY_E_PLUGIN_NO_ENTRY,
        Self::MRY_E_PLUGIN_ABI_VERSION,
        Self::MRY_E_PLUGIN_LAYOUT,
        Self::MRY_E_PLUGIN_DESCRIPTOR,
        Self::MRY_E_PLUGIN_INIT,
        Self::MRY_E_PLUGIN_PANICKED,
        Self::MRY_E_PLUGIN_POISONED,
        Self::MRY_E_PLUGIN_TIMEOUT,
        Self::MRY_E_PLUGIN_QUARANTINED,
        Self::MRY_E_PLUGIN_DISABLED,
        Self::MRY_E_PLUGIN_CRASHED,
        Self::MRY_E_PLUGIN_OUTPUT,
        Self::MRY_E_PLUGIN_FAILED,
        Self::MRY_E_PLUGIN_COPY,
        Self::MRY_E_PLUGIN_GENERATIONS,
        Self::MRY_E_PANIC,
        Self::MRY_E_POISONED,
    ];

    fn text(self) -> &'static CStr {
        match self {
            Self::MRY_OK => c"ok",
            Self::MRY_PENDING => c"waiting or running",
            Self::MRY_CANCELLED => c"cancelled",
            Self::MRY_E_NULL => c"a pointer is NULL",
            Self::MRY_E_STRUCT_SIZE => c"a struct_size is wrong",
            Self::MRY_E_UNSUPPORTED => c"not supported by this version",
            Self::MRY_E_STALE => c"an id is null, foreign or destroyed",
            Self::MRY_E_ARGUMENT => c"a value is out of range",
            Self::MRY_E_NON_FINITE => c"a number is NaN or infinite",
            Self::MRY_E_STRING => c"a string is not UTF-8 or holds a NUL",
            Self::MRY_E_BUFFER_TOO_SMALL => c"a buffer is too small",
            Self::MRY_E_BUSY => c"another thread is changing the object",
            Self::MRY_E_TAKEN => c"the result was taken before",
            Self::MRY_E_KIND => c"the job makes another kind of result",
            Self::MRY_E_NOT_FOUND => c"not found",
            Self::MRY_E_ABI => c"compiled with a header of another ABI",
            Self::MRY_E_REENTRANT => c"not allowed inside a callback",
            Self::MRY_E_INPUT => c"bad input",
            Self::MRY_E_NO_FILE => c"no such file or folder",
            Self::MRY_E_LIMIT => c"larger than allowed",
            Self::MRY_E_MEMORY => c"no memory was lent",
            Self::MRY_E_IO => c"the operating system refused",
            Self::MRY_E_THREADS => c"no thread could be started",
            Self::MRY_E_GPU => c"there is no GPU, or it failed",
            Self::MRY_E_PLUGIN_NOT_FOUND => c"no such plugin",
            Self::MRY_E_PLUGIN_UNSTABLE_FILE => c"the plugin's file is being written",
            Self::MRY_E_PLUGIN_TRUNCATED => c"the plugin's file is cut off",
            Self::MRY_E_PLUGIN_HASH => c"the plugin's file is not its manifest's",
            Self::MRY_E_PLUGIN_FORMAT => c"no plugin for this machine",
            Self::MRY_E_PLUGIN_DLOPEN => c"the system refused the plugin",
            Self::MRY_E_PLUGIN_NO_ENTRY => c"the library exports no plugin",
            Self::MRY_E_PLUGIN_ABI_VERSION => c"the plugin is made for another version",
            Self::MRY_E_PLUGIN_LAYOUT => c"the plugin's types are laid out otherwise",
            Self::MRY_E_PLUGIN_DESCRIPTOR => c"the plugin's description is wrong",
            Self::MRY_E_PLUGIN_INIT => c"the plugin did not start",
            Self::MRY_E_PLUGIN_PANICKED => c"the plugin panicked",
            Self::MRY_E_PLUGIN_POISONED => c"the plugin panicked before",
            Self::MRY_E_PLUGIN_TIMEOUT => c"the plugin hangs",
            Self::MRY_E_PLUGIN_QUARANTINED => c"the plugin failed too often",
            Self::MRY_E_PLUGIN_DISABLED => c"the plugin is switched off",
            Self::MRY_E_PLUGIN_CRASHED => c"the plugin crashed",
            Self::MRY_E_PLUGIN_OUTPUT => c"the plugin returned nonsense",
            Self::MRY_E_PLUGIN_FAILED => c"the plugin failed",
            Self::MRY_E_PLUGIN_COPY => c"no private copy of the plugin",
            Self::MRY_E_PLUGIN_GENERATIONS => c"too many builds of plugins",
            Self::MRY_E_PANIC => c"a defect of the library",
            Self::MRY_E_POISONED => c"poisoned by an earlier defect",
        }
    }
}

/// A few words for a status, in English; "unknown status" for a number that is none.
///
/// Lifetime: for ever.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn mry_status_text(status: mry_status) -> *const c_char {
    let known = mry_status_code::ALL.iter().find(|code| **code as mry_status == status);
    known.map_or(c"unknown status", |code| code.text()).as_ptr()
}

/// The status for an error of the engine.
pub(crate) fn of(error: &marey::Error) -> mry_status_code {
    use marey::{Category, Error};
    match error {
        Error::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => mry_status_code::MRY_E_NO_FILE,
        Error::Memory { .. } => mry_status_code::MRY_E_MEMORY,
        Error::Helper { code, .. } => {
            let known = mry_status_code::ALL.into_iter().find(|known| *known as mry_status == *code);
            known.unwrap_or(mry_status_code::MRY_E_PLUGIN_FAILED)
        }
        _ => match error.category() {
            Category::BadInput => mry_status_code::MRY_E_INPUT,
            Category::Limit => mry_status_code::MRY_E_LIMIT,
            Category::Cancelled => mry_status_code::MRY_CANCELLED,
            _ => mry_status_code::MRY_E_IO,
        },
    }
}
