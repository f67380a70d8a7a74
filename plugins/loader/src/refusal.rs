//! Why a plugin is not loaded, or not used any more: a status for programs, and one line for a person.

use std::fmt;
use std::path::PathBuf;

/// What went wrong with a plugin. Numbers are those of the C library's statuses, and stay for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[repr(i32)]
pub enum Status {
    /// There is no plugin of that name, or no file.
    NotFound = -501,
    /// The file is being written.
    UnstableFile = -502,
    /// The file ends before it should.
    Truncated = -503,
    /// The file is not the one that its manifest describes.
    Hash = -504,
    /// The file is no plugin for this machine, or the manifest is damaged.
    Format = -505,
    /// The system's loader refused the file.
    Dlopen = -506,
    /// The library exports no entry.
    NoEntry = -507,
    /// The library is made for another version of the interface.
    AbiVersion = -508,
    /// The library's types are laid out in another way.
    Layout = -509,
    /// What the library says of its plugins cannot be.
    Descriptor = -510,
    /// The library or its plugin did not start.
    Init = -511,
    /// The plugin panicked, and was contained.
    Panicked = -512,
    /// The plugin panicked before.
    Poisoned = -513,
    /// The plugin did not answer in time.
    Timeout = -514,
    /// The file failed too often.
    Quarantined = -515,
    /// The plugin is switched off.
    Disabled = -516,
    /// The plugin ended the process that tried it.
    Crashed = -517,
    /// What the plugin returned cannot be used.
    Output = -518,
    /// The plugin said that it failed.
    Failed = -519,
    /// A private copy could not be made, or not be run.
    Copy = -520,
    /// Too many builds were loaded.
    Generations = -521,
}

/// A plugin that is not loaded or not used, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// What went wrong.
    pub status: Status,
    /// The file, or the plugin's id.
    pub what: String,
    /// What is wrong with it.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Whatever a plugin says ends up in here: one line it stays.
        let line = format!("{}: {}; {}", self.what, self.problem, self.remedy).replace(['\n', '\r'], " ");
        f.write_str(&line)
    }
}

impl std::error::Error for Refusal {}

impl Refusal {
    pub(crate) fn new(
        status: Status,
        what: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { status, what: what.into(), problem: problem.into(), remedy: remedy.into() }
    }

    pub(crate) fn file(
        status: Status,
        file: impl Into<PathBuf>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::new(status, file.into().display().to_string(), problem, remedy)
    }
}

impl From<Refusal> for marey::Error {
    fn from(refusal: Refusal) -> Self {
        let Refusal { status, what, problem, remedy } = refusal;
        let line = |text: String| text.replace(['\n', '\r'], " ");
        Self::Helper { what: line(what), problem: line(problem), remedy: line(remedy), code: status as i32 }
    }
}
