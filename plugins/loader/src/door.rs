//! What is behind a library's entry, whichever door it came in by.

use marey_plugin::raw;

use crate::brief::Brief;
use crate::describe::PluginInfo;
use crate::post::Post;
use crate::refusal::{Refusal, Status};
use crate::values::Value;

/// By which door a library came in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DoorKind {
    /// The table of `plugin.h`.
    C,
    /// The types that abi_stable checks.
    Rust,
}

/// Why a call of a plugin failed, as the plugin says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) kind: FaultKind,
    pub(crate) message: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FaultKind {
    Cancelled,
    Invalid,
    Failed,
    Unsupported,
    Panicked,
    Poisoned,
    /// An answer that the interface does not have.
    Absurd,
}

impl Fault {
    pub(crate) fn new(kind: FaultKind, message: impl Into<String>) -> Self {
        Self { kind, message: message.into() }
    }

    /// The fault of an answer; `message` is the plugin's own.
    pub(crate) fn of(status: i32, message: String) -> Self {
        let kind = match status {
            raw::CANCELLED => FaultKind::Cancelled,
            raw::E_INVALID => FaultKind::Invalid,
            raw::E_FAILED => FaultKind::Failed,
            raw::E_UNSUPPORTED => FaultKind::Unsupported,
            raw::E_PANICKED => FaultKind::Panicked,
            raw::E_POISONED => FaultKind::Poisoned,
            other => return Self::new(FaultKind::Absurd, format!("returned {other}, which is no status: {message}")),
        };
        let silent = || "failed without a reason".to_owned();
        Self { kind, message: if message.trim().is_empty() { silent() } else { message } }
    }

    /// As an error of the plugin `id`.
    pub(crate) fn refusal(self, id: &str) -> Refusal {
        let what = format!("plugin {id}");
        let (status, remedy) = match self.kind {
            FaultKind::Invalid | FaultKind::Failed => (Status::Failed, "see what it asks for, or choose another"),
            FaultKind::Unsupported => (Status::Failed, "choose another plugin"),
            FaultKind::Panicked => (Status::Panicked, "tell its author; your work is untouched"),
            FaultKind::Poisoned => (Status::Poisoned, "start again"),
            FaultKind::Cancelled => (Status::Failed, "it stopped though nobody asked it to: tell its author"),
            FaultKind::Absurd => (Status::Output, "tell its author"),
        };
        Refusal::new(status, what, self.message, remedy)
    }
}

/// A loaded library.
pub(crate) trait Door: Send + Sync {
    fn create(&self, index: usize, values: &[(String, Value)]) -> Result<Box<dyn Instance>, Fault>;
}

/// A library as it came in: its door, what is behind it, and which door it was.
pub(crate) struct Opened {
    pub(crate) door: Box<dyn Door>,
    pub(crate) kind: DoorKind,
    pub(crate) plugins: Vec<PluginInfo>,
}

/// One plugin at work. Used on one thread at a time.
pub(crate) trait Instance: Send {
    fn track(&mut self, brief: &Brief, post: &Post) -> Result<(), Fault>;
    fn segment(&mut self, brief: &Brief, post: &Post) -> Result<(), Fault>;
    /// Gives the number by which the others know what was bound.
    fn bind(&mut self, mesh: &MeshBrief, handles: &[raw::Handle], post: &Post) -> Result<u64, Fault>;
    fn solve(
        &mut self,
        bound: u64,
        targets: &[raw::Handle],
        points: &mut [raw::Point],
        post: &Post,
    ) -> Result<(), Fault>;
    fn unbind(&mut self, bound: u64);
    /// [`None`] where the plugin keeps no state.
    fn save(&mut self) -> Result<Option<Vec<u8>>, Fault>;
    fn load(&mut self, version: u32, state: &[u8]) -> Result<(), Fault>;
}

/// A mesh for a deformer.
#[derive(Clone, Debug)]
pub(crate) struct MeshBrief {
    pub(crate) points: Vec<raw::Point>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// A state of more bytes is a mistake.
pub(crate) const MAX_STATE: usize = 256 << 20;
