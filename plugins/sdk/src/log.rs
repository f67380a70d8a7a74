//! The way to the host's log.

use std::sync::{PoisonError, RwLock};

use crate::job::Level;

type Sink = Box<dyn Fn(i32, &str) + Send + Sync>;

/// The host's log, once it has loaded the plugin. One for the library: a library is loaded by one host.
static SINK: RwLock<Option<Sink>> = RwLock::new(None);

/// A line for the host's log; nowhere before the host has loaded the plugin. Any thread may call it, at any time.
pub fn log(level: Level, line: &str) {
    // A sink that panics and logs in turn must not wait for itself.
    if let Ok(sink) = SINK.try_read()
        && let Some(sink) = &*sink
    {
        sink(level.code(), line);
    }
}

pub(crate) fn set(sink: Sink) {
    *SINK.write().unwrap_or_else(PoisonError::into_inner) = Some(sink);
}
