//! Where plugins are looked for, and how long they may take.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crate::door::DoorKind;

/// How much a line of the log matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogLevel {
    /// Something failed.
    Error,
    /// Something a person should know.
    Warning,
    /// What was done.
    Info,
    /// A plugin did what it must not.
    PluginMisbehaving,
}

/// Where the lines of the log go.
pub(crate) type Log = Arc<dyn Fn(LogLevel, &str) + Send + Sync>;

/// What a [`crate::Registry`] is made with.
#[derive(Clone)]
pub struct Options {
    /// Folders to look in, the first wins. Nothing else is looked at: see [`standard_folders`].
    pub folders: Vec<PathBuf>,
    /// Where private copies and the quarantine list are kept. Files in it must be allowed to run.
    pub cache: PathBuf,
    /// The program that tries a file in another process before it is loaded into this one: `marey`, or
    /// `marey-plugin-probe`. [`None`]: nothing is tried first.
    pub probe: Option<PathBuf>,
    /// How long trying and loading a file may take.
    pub load_deadline: Duration,
    /// How long a plugin at work may be silent before it is taken to hang.
    pub silence: Duration,
    /// How long a file must have been left alone before it is loaded.
    pub settle: Duration,
    /// How many builds are loaded at most, over all files, while this process lives.
    pub max_generations: usize,
    /// How often the same file may hang, panic or crash before it is no longer loaded.
    pub strikes: u32,
    /// The only door to go through; [`None`] for the C door, or the Rust door of a library that has no other.
    pub door: Option<DoorKind>,
    /// Where the lines of the log go.
    pub log: Log,
}

impl fmt::Debug for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("folders", &self.folders)
            .field("cache", &self.cache)
            .field("probe", &self.probe)
            .field("silence", &self.silence)
            .finish_non_exhaustive()
    }
}

impl Options {
    /// The defaults, with no folder to look in.
    pub fn new(cache: impl Into<PathBuf>) -> Self {
        Self {
            folders: Vec::new(),
            cache: cache.into(),
            probe: None,
            load_deadline: Duration::from_secs(5),
            silence: Duration::from_secs(30),
            settle: Duration::from_millis(300),
            max_generations: 64,
            strikes: 3,
            door: None,
            log: Arc::new(|_, _| {}),
        }
    }
}

/// The folders that the environment names, the first wins: each of `MAREY_PLUGIN_PATH`, then the user's
/// (`$XDG_DATA_HOME/marey/plugins` or `~/.local/share/marey/plugins`), then `/usr/lib/marey/plugins`. `read` is
/// [`std::env::var_os`], or stands in for it.
pub fn standard_folders(read: impl Fn(&str) -> Option<std::ffi::OsString>) -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = Vec::new();
    if let Some(list) = read("MAREY_PLUGIN_PATH") {
        folders.extend(std::env::split_paths(&list).filter(|p| !p.as_os_str().is_empty()));
    }
    let absolute = |name: &str| read(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let data = absolute("XDG_DATA_HOME").or_else(|| Some(absolute("HOME")?.join(".local/share")));
    folders.extend(data.map(|data| data.join("marey/plugins")));
    folders.push(PathBuf::from("/usr/lib/marey/plugins"));
    folders
}
