//! The C library of Marey: `extern "C"` functions over the engine, and nothing else.
//!
//! This crate marshals, guards and hands over: it checks what comes in, calls one function of the engine, and copies
//! the answer out. `include/marey/marey.h` is generated from it by `cargo xtask header`; the first paragraph of each
//! file below is the introduction of that file's group in the header.
//!
//! Unsafe code lives in few places: `border` reads and writes the caller's memory, `guard` states the contract once
//! for all functions, `context` owns the one pointer that C holds, and `threads` and `allocator` hold what hosts lend.
#![allow(non_camel_case_types, reason = "types and constants carry their C names, so that the header is this source")]
#![allow(clippy::missing_safety_doc, reason = "the contract is the same for all functions; guard.rs states it")]

mod advice;
mod allocator;
mod bind_job;
mod binding;
mod bones;
mod border;
mod capturing;
mod character;
mod clip;
mod context;
mod control_points;
mod creature;
mod creature_files;
mod creature_limb;
mod deforming;
mod drawing;
mod error;
mod executor;
mod exporting;
mod gesture;
mod guard;
mod job;
mod joints;
mod limb;
mod limits;
mod maps;
mod masks;
mod methods;
mod motion;
mod motion_edit;
mod motion_paths;
mod opening;
mod paint;
mod parameter;
mod plugin;
mod plugin_parameter;
mod plugins;
mod point_tracking;
mod poses;
mod posing;
mod reconstructing;
mod redrawing;
mod retargeting;
mod rig;
mod rows;
mod running;
mod segmenting;
mod session;
mod session_jobs;
mod session_media;
mod session_recording;
mod skeleton;
mod sketch_files;
mod sketch_take;
mod status;
mod string;
mod stroke;
mod surface;
mod table;
mod take;
mod take_files;
#[cfg(feature = "test-panic")]
pub mod test_panic;
mod threads;
mod tracking;
mod tracks;
mod vector;
mod version;

pub use advice::*;
pub use allocator::*;
pub use bind_job::*;
pub use binding::*;
pub use bones::*;
pub use capturing::*;
pub use character::*;
pub use clip::*;
pub use context::*;
pub use control_points::*;
pub use creature::*;
pub use creature_files::*;
pub use creature_limb::*;
pub use deforming::*;
pub use drawing::*;
pub use error::*;
pub use exporting::*;
pub use gesture::*;
pub use job::*;
pub use joints::*;
pub use limb::*;
pub use limits::*;
pub use maps::*;
pub use masks::*;
pub use motion::*;
pub use motion_edit::*;
pub use motion_paths::*;
pub use opening::*;
pub use paint::*;
pub use parameter::*;
pub use plugin::*;
pub use plugin_parameter::*;
pub use plugins::*;
pub use point_tracking::*;
pub use poses::*;
pub use posing::*;
pub use reconstructing::*;
pub use redrawing::*;
pub use retargeting::*;
pub use rig::*;
pub use segmenting::*;
pub use session::*;
pub use session_jobs::*;
pub use session_media::*;
pub use session_recording::*;
pub use skeleton::*;
pub use sketch_files::*;
pub use sketch_take::*;
pub use status::*;
pub use string::*;
pub use stroke::*;
pub use surface::*;
pub use take::*;
pub use take_files::*;
pub use threads::*;
pub use tracking::*;
pub use tracks::*;
pub use vector::*;
pub use version::*;
