//! Plugins: found, checked, loaded, reloaded, and handed to the engine as its own trackers, segmenters and deformers.
//!
//! A plugin is data, not trusted code: its file is checked before it is loaded, what it says of itself before it is
//! listed, what it returns before the engine uses it. It works on a thread of its own under a deadline, and a panic,
//! a hang or a wrong result is an error of the job. Nothing is ever unloaded: a new build of a file is loaded beside
//! the old one, under a name that was never used, as another generation.
//!
//! The honest limit: a plugin shares the process. One that writes where it should not, overflows its stack or calls
//! `exit` ends the host; only [`Options::probe`] tries it out in another process first.
//!
//! Unsafe code: `c_door` and `rust_door` call through the doors, `library` opens files, `post` answers
//! a plugin's calls, `describe` reads its tables.

mod brief;
mod c_door;
mod conformance;
mod describe;
mod discover;
mod door;
mod elf;
mod generation;
mod library;
mod loading;
mod manifest;
mod options;
#[cfg(test)]
mod overhead_tests;
mod post;
mod probe;
mod quarantine;
mod refusal;
mod registry;
mod rust_door;
mod slot;
mod stable;
mod values;
mod worker;
mod works;

pub use describe::{ParameterInfo, ParameterKind, PluginInfo, PluginKind};
pub use door::DoorKind;
pub use options::{LogLevel, Options, standard_folders};
pub use probe::{ProbeMode, probe_main};
pub use refusal::{Refusal, Status};
pub use registry::{Listed, Registry, Rescan};
pub use slot::{Carried, Policy, Slot};
pub use values::Value;
