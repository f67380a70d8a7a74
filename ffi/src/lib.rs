//! The C library of Marey: `extern "C"` functions over the engine, and nothing else.
//!
//! This crate marshals, guards and hands over: it checks what comes in, calls one function of the engine, and copies
//! the answer out. `include/marey/marey.h` is generated from it by `cargo xtask header`; the first paragraph of each
//! file below is the introduction of that file's group in the header.
//!
//! Unsafe code lives in three places: `border` reads and writes the caller's memory, `guard` states the contract
//! once for all functions, and `context` owns the one pointer that C holds.
#![allow(non_camel_case_types, reason = "types and constants carry their C names, so that the header is this source")]
#![allow(clippy::missing_safety_doc, reason = "the contract is the same for all functions; guard.rs states it")]

mod border;
mod clip;
mod context;
mod creature;
mod error;
mod executor;
mod guard;
mod job;
mod masks;
mod motion;
mod rig;
mod status;
mod string;
mod table;
#[cfg(feature = "test-panic")]
pub mod test_panic;
mod version;

pub use clip::*;
pub use context::*;
pub use creature::*;
pub use error::*;
pub use job::*;
pub use masks::*;
pub use motion::*;
pub use rig::*;
pub use status::*;
pub use string::*;
pub use version::*;
