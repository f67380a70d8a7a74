//! One build of a library, loaded for ever.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::describe::PluginInfo;
use crate::door::{Door, DoorKind};

/// Names of stages that are kept for ever, for each build: a plugin has a few.
const MAX_STAGES: usize = 64;

/// One build of a library. Instances hold it; without any, and with a newer build beside it, it is retired, and stays.
pub(crate) struct Generation {
    /// Counted over all files of the registry, from 1.
    pub(crate) number: u64,
    pub(crate) file: PathBuf,
    pub(crate) hash: String,
    pub(crate) bytes: u64,
    pub(crate) door: Box<dyn Door>,
    pub(crate) kind: DoorKind,
    pub(crate) plugins: Vec<PluginInfo>,
    pub(crate) instances: AtomicUsize,
    pub(crate) stages: Mutex<Vec<&'static str>>,
}

impl Generation {
    /// How many instances of it there are.
    pub(crate) fn count(&self) -> usize {
        self.instances.load(Ordering::Acquire)
    }

    /// The name of a stage, as the engine wants it: for ever.
    pub(crate) fn stage(&self, name: &str) -> &'static str {
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = stages.iter().find(|s| **s == name) {
            return known;
        }
        if stages.len() >= MAX_STAGES {
            return "working";
        }
        let kept: &'static str = Box::leak(name.to_owned().into_boxed_str());
        stages.push(kept);
        kept
    }
}
