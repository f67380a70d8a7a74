//! The one error of the engine: what was wrong, with what, where, and what to do.

use std::path::{Path, PathBuf};

/// What a caller should make of an error; the command line's exit codes and the C statuses follow it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Category {
    /// The caller's data is wrong: a bad file, a bad rig, a value out of range.
    BadInput,
    /// A bound of the engine or of the caller's limits was met.
    Limit,
    /// The world failed us: disk full, a permission, a missing helper program.
    Failed,
    /// The caller asked to stop.
    Cancelled,
}

/// An error of the engine. Every message names the thing, the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused something about a file.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was attempted, as a verb ("read", "write", "rename").
        action: &'static str,
        /// The system's own reason.
        source: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{}: {problem}; {remedy}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where in the file.
        problem: String,
        /// What was expected, or what to do.
        remedy: String,
    },
    /// A value is not what it should be.
    #[error("{what}: {problem}; {remedy}")]
    Invalid {
        /// The value, named as its user knows it ("limb `tail`, key frame 3, point 2").
        what: String,
        /// What is wrong with it.
        problem: String,
        /// What was expected, or what to do.
        remedy: String,
    },
    /// Something is larger than the engine or the caller allows.
    #[error("{what} is {value}, and at most {max} is allowed; {remedy}")]
    Limit {
        /// The quantity.
        what: String,
        /// Its value.
        value: u64,
        /// Its bound.
        max: u64,
        /// What to do.
        remedy: String,
    },
    /// Whoever lends memory for frames had none.
    #[error("no memory was lent for a frame of {bytes} bytes; close clips, or ask for a smaller cache")]
    Memory {
        /// How much was asked for.
        bytes: usize,
    },
    /// Something that the engine was given to work with failed: a tracker, segmenter or deformer from outside.
    #[error("{what}: {problem}; {remedy}")]
    Helper {
        /// Who failed.
        what: String,
        /// How.
        problem: String,
        /// What to do.
        remedy: String,
        /// What whoever brought the helper calls this failure; the engine only passes it on.
        code: i32,
    },
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
}

/// The engine's result.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An error of the operating system about `path`.
    pub fn io(path: impl AsRef<Path>, action: &'static str, source: std::io::Error) -> Self {
        Self::Io { path: path.as_ref().to_owned(), action, source }
    }

    /// A file that is not what it should be.
    pub fn file(path: impl AsRef<Path>, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::File { path: path.as_ref().to_owned(), problem: problem.into(), remedy: remedy.into() }
    }

    /// A value that is not what it should be.
    pub fn invalid(what: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Invalid { what: what.into(), problem: problem.into(), remedy: remedy.into() }
    }

    /// What is wrong with a value as what is wrong with the file that says it; other errors as they are.
    #[must_use]
    pub fn in_file(self, path: impl AsRef<Path>) -> Self {
        match self {
            Self::Invalid { what, problem, remedy } => Self::file(path, format!("{what}: {problem}"), remedy),
            other => other,
        }
    }

    /// What a caller should make of it.
    pub fn category(&self) -> Category {
        match self {
            Self::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => Category::BadInput,
            Self::Io { .. } | Self::Helper { .. } => Category::Failed,
            Self::File { .. } | Self::Invalid { .. } => Category::BadInput,
            Self::Limit { .. } | Self::Memory { .. } => Category::Limit,
            Self::Cancelled => Category::Cancelled,
        }
    }
}
