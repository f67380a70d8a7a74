//! Plugins. Trackers, segmenters and deformers from shared libraries that are written against plugin.h or with the Rust
//! sdk. A context has none before mry_plugins_open; then whatever names a tracker or a segmenter takes the id of a
//! plugin too, such as "org.example.nearest".
//!
//! A plugin works on a thread of its own. One that fails, panics, hangs or returns nonsense fails the job with a status
//! of the MRY_E_PLUGIN block; but it shares the process, and can crash it: name a probe to try files in another process
//! first. Nothing is ever unloaded; a new build of a file is loaded beside the old one.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, RwLock};
use std::time::Duration;

use marey_plugin_loader::{
    LogLevel, Options, PluginKind, Policy, ProbeMode, Refusal, Registry, Rescan, Slot, probe_main, standard_folders,
};

use crate::border::{self, Out, Text, Versioned};
use crate::context::{Context, MRY_LOG_ERROR, MRY_LOG_INFO, MRY_LOG_WARNING, mry_context};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Log level: a plugin did what it must not.
pub const MRY_LOG_PLUGIN_MISBEHAVING: i32 = 11;

/// Look where the environment says: MAREY_PLUGIN_PATH, the user's folder ($XDG_DATA_HOME/marey/plugins), then
/// /usr/lib/marey/plugins; and keep copies in the user's cache. Without it nothing is read from the environment.
pub const MRY_PLUGINS_ENVIRONMENT: u32 = 1;

/// Where plugins come from. Start from MRY_PLUGINS_DESC_INIT.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_plugins_desc {
    /// sizeof(mry_plugins_desc).
    pub struct_size: u32,
    /// MRY_PLUGINS_ENVIRONMENT, or 0.
    pub flags: u32,
    /// Folders to look in before all others, a line each; may be empty.
    pub folders: mry_str,
    /// The folder for private copies and the list of files that failed too often; files in it must be allowed to run.
    /// It may be empty only with MRY_PLUGINS_ENVIRONMENT.
    pub cache: mry_str,
    /// The program that tries a file in another process before it is loaded: marey or marey-plugin-probe; empty for
    /// none.
    pub probe: mry_str,
    /// How long a plugin at work may be silent before it is taken to hang; 0 for 30 s.
    pub silence_ms: u32,
    /// How long trying and loading a file may take; 0 for 5 s.
    pub load_ms: u32,
    /// How many builds are loaded at most while the process lives; 0 for 64.
    pub max_generations: u32,
    /// Zero.
    pub reserved0: u32,
}

// SAFETY: repr(C), starts with its u32 size; integers, and strings that the host vouches for.
unsafe impl Versioned for mry_plugins_desc {
    const FIRST_SIZE: usize = 72;
}
const _: () = assert!(size_of::<mry_plugins_desc>() == 72);

type Line = Box<dyn Fn(i32, &str) + Send + Sync>;
type Slots = Mutex<BTreeMap<String, Arc<Slot>>>;

/// The plugins of a context.
#[derive(Default)]
pub(crate) struct Plugins {
    registry: OnceLock<Registry>,
    /// One for each plugin that was used: it keeps what the plugin has learnt, and goes from build to build.
    slots: Slots,
    /// The way to the host's log, until the context ends: a plugin's thread may outlive it.
    log: Arc<RwLock<Option<Line>>>,
}

impl Drop for Plugins {
    fn drop(&mut self) {
        *self.log.write().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        Self { status: refusal.status as mry_status, param: "", message: refusal.to_string() }
    }
}

impl Plugins {
    pub(crate) fn registry(&self) -> Outcome<&Registry> {
        let none =
            || Failure::new(Code::MRY_E_PLUGIN_NOT_FOUND, "", "the context has no plugins; mry_plugins_open first");
        self.registry.get().ok_or_else(none)
    }

    /// The place for a plugin to work in; [`None`] where no plugin has this id.
    pub(crate) fn slot(&self, id: &str, kind: PluginKind) -> Outcome<Option<Arc<Slot>>> {
        let Some(registry) = self.registry.get() else { return Ok(None) };
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        match registry.slot(id, kind, Policy::Migrate) {
            Ok(fresh) => Ok(Some(slots.entry(id.to_owned()).or_insert_with(|| Arc::new(fresh)).clone())),
            Err(refusal) if refusal.status as i32 == Code::MRY_E_PLUGIN_NOT_FOUND as i32 => {
                slots.remove(id);
                let of_other_kind = registry.plugins().iter().any(|p| p.info.id == id);
                if of_other_kind { Err(refusal.into()) } else { Ok(None) }
            }
            Err(refusal) => Err(refusal.into()),
        }
    }

    /// The ids of all plugins of a kind, for messages.
    pub(crate) fn ids(&self, kind: PluginKind) -> Vec<String> {
        let plugins = self.registry.get().map(Registry::plugins).unwrap_or_default();
        plugins.into_iter().filter(|p| p.info.kind == kind).map(|p| p.info.id).collect()
    }
}

/// # Safety
/// The strings are valid, as the header asks.
unsafe fn open(context: &Context, desc: &mry_plugins_desc) -> Outcome<()> {
    border::reserved(desc.reserved0)?;
    let environment = desc.flags == MRY_PLUGINS_ENVIRONMENT;
    if desc.flags != 0 && !environment {
        return Err(Failure::new(Code::MRY_E_UNSUPPORTED, "desc", "desc.flags has a bit that is not known"));
    }
    // SAFETY: as this function's own.
    let (folders, cache, probe) =
        unsafe { (desc.folders.text("desc.folders")?, desc.cache.text("desc.cache")?, desc.probe.text("desc.probe")?) };
    let read = |name: &str| std::env::var_os(name);
    let cache = match cache {
        "" if environment => {
            let absolute = |name: &str| read(name).map(PathBuf::from).filter(|p| p.is_absolute());
            let user = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")));
            user.unwrap_or_else(std::env::temp_dir).join("marey/plugins")
        }
        "" => return Err(Failure::argument("desc", "desc.cache is empty; name a folder for private copies")),
        named => PathBuf::from(named),
    };
    let mut options = Options::new(cache);
    options.folders = folders.lines().filter(|l| !l.is_empty()).map(PathBuf::from).collect();
    if environment {
        options.folders.extend(standard_folders(read));
    }
    options.probe = (!probe.is_empty()).then(|| PathBuf::from(probe));
    if desc.silence_ms > 0 {
        options.silence = Duration::from_millis(desc.silence_ms.into());
    }
    if desc.load_ms > 0 {
        options.load_deadline = Duration::from_millis(desc.load_ms.into());
    }
    if desc.max_generations > 0 {
        options.max_generations = desc.max_generations as usize;
    }
    let sink = context.plugins.log.clone();
    options.log = Arc::new(move |level, line| {
        let level = match level {
            LogLevel::Error => MRY_LOG_ERROR,
            LogLevel::Warning => MRY_LOG_WARNING,
            LogLevel::Info => MRY_LOG_INFO,
            LogLevel::PluginMisbehaving => MRY_LOG_PLUGIN_MISBEHAVING,
        };
        if let Some(sink) = &*sink.read().unwrap_or_else(PoisonError::into_inner) {
            sink(level, line);
        }
    });
    *context.plugins.log.write().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(context.logger()));
    let registry = Registry::new(options).map_err(|refusal| Failure::from(refusal).about("desc"))?;
    let again = |_| Failure::new(Code::MRY_E_TAKEN, "context", "the context has plugins already; one call opens them");
    context.plugins.registry.set(registry).map_err(again)
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_plugins_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugins_desc_init(desc: *mut mry_plugins_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Lets a context use plugins, from the described places and no others. Once for a context; loads nothing yet.
///
/// @param context  The context.
/// @param desc     Where plugins come from.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_TAKEN (it has plugins already), MRY_E_PLUGIN_COPY (the cache cannot be written),
///         MRY_E_ARGUMENT, MRY_E_STRUCT_SIZE, MRY_E_UNSUPPORTED, MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugins_open(
    context: *mut mry_context,
    desc: *const mry_plugins_desc,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let desc = border::read(desc, "desc")?;
        open(call.context, &desc)?;
        Ok(Code::MRY_OK)
    })
}

/// Looks through the folders: loads libraries that are new and new builds of those that are known. It takes as long as
/// trying and loading them takes. What came of it is in the log, and in mry_plugin_get_info and _get_failure.
///
/// @param context      The context.
/// @param out_changes  How many files are loaded, refused or gone since the last time.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK, also where files were refused; MRY_E_PLUGIN_NOT_FOUND (the context has no plugins).
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugins_rescan(
    context: *mut mry_context,
    out_changes: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_changes, "out_changes")?;
        let changes: Vec<Rescan> = call.context.plugins.registry()?.rescan();
        out.set(changes.len() as u32);
        Ok(Code::MRY_OK)
    })
}

/// Loads one library (*.so) or bundle (*.marey) by its name, wherever it lies; looks at it again when it is known.
///
/// @param context  The context.
/// @param file     The file.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; a status of the MRY_E_PLUGIN block, MRY_E_STRING, MRY_E_ARGUMENT.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugins_load(context: *mut mry_context, file: mry_str, err: *mut mry_error) -> mry_status {
    entry!(context, err, |call| {
        let file = file.name("file")?;
        call.context.plugins.registry()?.load(file.as_ref()).map_err(|e| Failure::from(e).about("file"))?;
        Ok(Code::MRY_OK)
    })
}

/// Takes a file out of quarantine and looks at it again at the next mry_plugins_rescan or mry_plugins_load.
///
/// @param context  The context.
/// @param file     The file, as mry_plugin_get_failure names it.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_PLUGIN_NOT_FOUND (the context has no plugins), MRY_E_STRING, MRY_E_ARGUMENT.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugins_retry(
    context: *mut mry_context,
    file: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let file = file.name("file")?;
        call.context.plugins.registry()?.retry(file.as_ref());
        Ok(Code::MRY_OK)
    })
}

/// Puts a library or a bundle through the conformance suite, in another process where the context has a probe: loads
/// it, runs each of its plugins on little scenes, cancels them, and compares what they give with what plugin.h asks.
///
/// @param context   The context.
/// @param file      The file.
/// @param text      Where the report goes, JSON in UTF-8 with a NUL; NULL with capacity 0 to ask for the size (the
///                  suite runs each time: offer room at once).
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK, also where the plugin fails the suite; MRY_E_BUFFER_TOO_SMALL; a status of the MRY_E_PLUGIN block
///         where it cannot even be loaded; MRY_E_STRING, MRY_E_ARGUMENT.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugins_check(
    context: *mut mry_context,
    file: mry_str,
    text: *mut std::ffi::c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let file = file.name("file")?;
        let registry = call.context.plugins.registry()?;
        let report = registry.check(file.as_ref()).map_err(|e| Failure::from(e).about("file"))?;
        text.fill(&report.to_string())
    })
}

/// What a probe program does, which mry_plugins_desc names: it is started as `PROGRAM plugin probe MODE FILE`, passes
/// the two last words to this function, and prints the text on its standard output. The library may crash it.
///
/// @param context   A context; it needs no plugins.
/// @param mode      The mode.
/// @param file      The file.
/// @param text      Where the text goes, UTF-8 with a NUL; 65536 bytes do.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_UNSUPPORTED (no such mode), MRY_E_BUFFER_TOO_SMALL, MRY_E_STRING, MRY_E_ARGUMENT.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugins_probe(
    context: *mut mry_context,
    mode: mry_str,
    file: mry_str,
    text: *mut std::ffi::c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |_call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let (mode, file) = (mode.name("mode")?, file.name("file")?);
        let unknown = || Failure::new(Code::MRY_E_UNSUPPORTED, "mode", format!("mode: `{mode}` is not known"));
        let mode = ProbeMode::of(mode).ok_or_else(unknown)?;
        text.fill(&probe_main(mode, file.as_ref()))
    })
}
