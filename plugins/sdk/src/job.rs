//! The host's end of a piece of work: progress, cancel, log.

use std::fmt;

use crate::error::{Error, Result};
use crate::room::Host;

/// How much a line of the log matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Something failed.
    Error,
    /// Something a person should know.
    Warning,
    /// What was done.
    Info,
}

impl Level {
    pub(crate) fn code(self) -> i32 {
        match self {
            Self::Error => crate::raw::LOG_ERROR,
            Self::Warning => crate::raw::LOG_WARNING,
            Self::Info => crate::raw::LOG_INFO,
        }
    }
}

/// A piece of work, or a share of it. Threads may share it.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    host: &'a dyn Host,
    from: f64,
    to: f64,
}

impl fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Job({}..{})", self.from, self.to)
    }
}

impl<'a> Job<'a> {
    pub(crate) fn new(host: &'a dyn Host) -> Self {
        Self { host, from: 0.0, to: 1.0 }
    }

    /// The share `from..to` of this one, for a step of the work.
    #[must_use]
    pub fn part(&self, from: f64, to: f64) -> Self {
        let at = |f: f64| self.from + (self.to - self.from) * f.clamp(0.0, 1.0);
        Self { host: self.host, from: at(from), to: at(to) }
    }

    /// Names what is being done, a word or two.
    ///
    /// # Errors
    /// The host asked to stop.
    pub fn stage(&self, name: &str) -> Result<()> {
        self.tell(0.0, Some(name))
    }

    /// Says that `fraction` (0 to 1) of this share is done, and asks whether to go on. Call it at least every 100 ms:
    /// a plugin that is silent for long is taken to hang.
    ///
    /// # Errors
    /// The host asked to stop: pass it on with `?`.
    pub fn at(&self, fraction: f64) -> Result<()> {
        self.tell(fraction, None)
    }

    fn tell(&self, fraction: f64, stage: Option<&str>) -> Result<()> {
        let fraction = self.from + (self.to - self.from) * fraction.clamp(0.0, 1.0);
        if self.host.progress(fraction, stage) { Ok(()) } else { Err(Error::cancelled()) }
    }
}
