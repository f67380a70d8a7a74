//! Long work: progress out, cancel in.
//!
//! The engine's long functions take a [`Progress`]; whoever started them holds a clone and reads it or cancels from
//! any thread. Work checks for a cancel at least every 100 ms. Stages nest: a pipeline gives each step its
//! [`Stage`], a share of the whole.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use crate::error::{Error, Result};

/// Shared state of one piece of long work. Clones see the same work.
#[derive(Clone, Debug, Default)]
pub struct Progress(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    cancelled: AtomicBool,
    /// Bits of an f64 in 0..=1; such bits order like the numbers, so `fetch_max` keeps it from going backwards.
    fraction: AtomicU64,
    stage: Mutex<Named>,
}

/// The stage that was named last, and its share of the whole.
#[derive(Clone, Copy, Debug, Default)]
struct Named {
    name: &'static str,
    from: f64,
    to: f64,
}

impl Progress {
    /// Progress of work that has not begun.
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the work to stop. Takes effect at its next check; cannot be taken back.
    pub fn cancel(&self) {
        self.0.cancelled.store(true, Ordering::Relaxed);
    }

    /// [`Error::Cancelled`] once [`Self::cancel`] was called.
    pub fn check(&self) -> Result<()> {
        if self.0.cancelled.load(Ordering::Relaxed) { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// The share of the work that is done, in 0..=1; never goes back.
    pub fn fraction(&self) -> f64 {
        f64::from_bits(self.0.fraction.load(Ordering::Relaxed))
    }

    /// The name of the current stage, a word or two for a person; empty before the first.
    pub fn stage_name(&self) -> &'static str {
        self.named().name
    }

    /// The share of the current stage that is done, in 0..=1; begins anew with each stage.
    pub fn stage_fraction(&self) -> f64 {
        let Named { from, to, .. } = self.named();
        let share = (self.fraction() - from) / (to - from);
        if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
    }

    fn named(&self) -> Named {
        *self.0.stage.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// All of the work as one stage.
    pub fn whole(&self) -> Stage<'_> {
        Stage { progress: self, from: 0.0, to: 1.0 }
    }
}

/// A share of some work, `from..to` of the whole.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    progress: &'a Progress,
    from: f64,
    to: f64,
}

impl Stage<'_> {
    /// The share `from..to` of this one.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let at = |f: f64| self.from + (self.to - self.from) * f.clamp(0.0, 1.0);
        Self { progress: self.progress, from: at(from), to: at(to) }
    }

    /// Names what is being done.
    pub fn name(&self, name: &'static str) -> Result<()> {
        *self.progress.0.stage.lock().unwrap_or_else(std::sync::PoisonError::into_inner) =
            Named { name, from: self.from, to: self.to };
        self.at(0.0)
    }

    /// Says that `fraction` (0..=1) of this stage is done, and fails with [`Error::Cancelled`] when asked to stop.
    /// Threads may call it out of order.
    pub fn at(&self, fraction: f64) -> Result<()> {
        let f = self.from + (self.to - self.from) * fraction.clamp(0.0, 1.0);
        self.progress.0.fraction.fetch_max(f.to_bits(), Ordering::Relaxed);
        self.progress.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_nest_and_never_go_back() {
        let progress = Progress::new();
        let second = progress.whole().part(0.5, 1.0);
        second.part(0.0, 0.5).at(1.0).expect("not cancelled");
        assert_eq!(progress.fraction(), 0.75);
        second.at(0.1).expect("not cancelled");
        assert_eq!(progress.fraction(), 0.75);
        assert_eq!((progress.stage_name(), progress.stage_fraction()), ("", 0.0));
        second.part(0.5, 1.0).name("last").expect("not cancelled");
        assert_eq!(progress.stage_fraction(), 0.0);
        second.at(0.75).expect("not cancelled");
        assert_eq!((progress.stage_name(), progress.stage_fraction()), ("last", 0.5));
        progress.cancel();
        assert!(matches!(second.at(0.9), Err(Error::Cancelled)));
    }
}
