//! Watching a job: a bar on stderr when it is a terminal, and Ctrl-C.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use marey_binding::Job;

use crate::failure::{CANCELLED, FAILED, Failure};

/// Often enough for a bar that moves and a cancel that is felt at once.
const TICK: Duration = Duration::from_millis(30);
const STEPS: u64 = 1000;

/// Set by Ctrl-C and by the signals that ask a process to end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on. The second signal ends the process there and then.
    pub(crate) fn listen() -> Result<Self, Failure> {
        let interrupt = Self::default();
        let asked = interrupt.0.clone();
        let on_signal = move || {
            if asked.swap(true, Ordering::SeqCst) {
                std::process::exit(CANCELLED);
            }
        };
        ctrlc::set_handler(on_signal).map_err(|e| Failure::new(FAILED, format!("cannot listen for Ctrl-C: {e}")))?;
        Ok(interrupt)
    }

    /// Fails once a signal has come.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        if self.0.load(Ordering::SeqCst) {
            Err(Failure::new(CANCELLED, "cancelled; nothing was written"))
        } else {
            Ok(())
        }
    }
}

/// Waits for the job's end, showing how it goes; cancels it when a signal comes.
pub(crate) fn watch(job: &Job, interrupt: &Interrupt) -> Result<(), Failure> {
    // Draws nothing when stderr is no terminal.
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{msg:>16} {wide_bar} {percent:>3}% {elapsed}") {
        bar.set_style(style);
    }
    let mut seen = 0;
    let ended = loop {
        if interrupt.check().is_err() {
            job.cancel()?;
        }
        let state = job.poll()?;
        if state.revision != seen {
            seen = state.revision;
            bar.set_message(state.stage);
            bar.set_position((state.fraction * STEPS as f64) as u64);
        }
        match job.wait(Some(TICK)) {
            Ok(false) => {}
            Ok(true) => break Ok(()),
            Err(e) => break Err(e),
        }
    };
    bar.finish_and_clear();
    match ended {
        Ok(()) => Ok(()),
        Err(e) if e.status() == marey_binding::Status::Cancelled => {
            Err(Failure::new(CANCELLED, "cancelled; nothing was written"))
        }
        Err(e) => Err(e.into()),
    }
}
