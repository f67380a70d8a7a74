//! Write a tracker, a segmenter or a deformer for Marey in ordinary Rust.
//!
//! ```
//! use marey_plugin::{Clip, Info, Job, Parameter, Plugin, Result, Rig, Tracker, Tracks, Values, marey_plugin};
//!
//! /// Keeps every limb where it was drawn last.
//! struct Still {
//!     shift: f32,
//! }
//!
//! impl Plugin for Still {
//!     const INFO: Info = Info::new("org.example.still", "Still", "0.1.0").about("Keeps limbs where they were drawn.");
//!     const PARAMETERS: &[Parameter] = &[Parameter::number("shift", "Shift", -50.0, 50.0, 0.0).unit("px")];
//!
//!     fn create(values: &Values<'_>) -> Result<Self> {
//!         Ok(Self { shift: values.number("shift")? as f32 })
//!     }
//! }
//!
//! impl Tracker for Still {
//!     fn track(&mut self, clip: &Clip<'_>, rig: &Rig<'_>, job: &Job<'_>) -> Result<Tracks> {
//!         let mut tracks = Tracks::new(clip, rig);
//!         for limb in 0..rig.limbs.len() {
//!             for frame in 0..clip.frames() {
//!                 job.at(frame as f64 / clip.frames() as f64)?;
//!                 if let Some(stroke) = rig.last_stroke(limb, frame) {
//!                     let points: Vec<_> = stroke.points.iter().map(|p| p.moved(self.shift, 0.0)).collect();
//!                     tracks.set(limb, frame, &points);
//!                 }
//!             }
//!         }
//!         Ok(tracks)
//!     }
//! }
//!
//! marey_plugin! { tracker: Still }
//! ```
//!
//! In a crate of type `cdylib` that is a whole plugin. [`marey_plugin!`] makes the C entry of
//! `include/marey/plugin.h` from it, and a second door that is checked by abi_stable. Panics in
//! your code, wherever they happen, become errors of the job; logs and panic messages go to the host. [`testing`] runs
//! your code without a host.
//!
//! This crate does not link the engine: what it gives you are views of the host's memory, and what you give back is
//! copied by the host. Coordinates are clip pixels: x right, y down, the centre of the top-left pixel is (0.5, 0.5).
//! Frames count from 0.

mod c_door;
mod c_input;
mod clip;
mod descriptors;
mod error;
mod export;
mod guard;
mod info;
mod job;
mod log;
mod masks;
mod mesh;
mod motion;
mod parameter;
mod point;
pub mod raw;
mod rig;
#[doc(hidden)]
pub mod room;
#[cfg(feature = "rust-door")]
mod rust_door;
pub mod testing;
mod tracks;
mod traits;
mod values;

pub use clip::{Clip, Frame};
pub use error::{Error, ErrorKind, Result};
pub use info::Info;
pub use job::{Job, Level};
pub use log::log;
pub use masks::{Mask, MaskSink};
pub use mesh::{Handle, Mesh};
pub use motion::{Motion, Track};
pub use parameter::{Kind, Parameter};
pub use point::Point;
pub use rig::{Facing, Limb, Paint, Painted, Rig, Side, Stroke};
pub use tracks::{LimbTrack, Tracks};
pub use traits::{Deformation, Deformer, Plugin, Segmenter, Tracker};
pub use values::Values;

/// The code of the guide.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/plugins/README.md")]
struct Guide;

/// What [`marey_plugin!`] expands to; no part of the interface.
#[doc(hidden)]
pub mod __private {
    pub use crate::c_door::entry;
    pub use crate::export::{Bundle, Registration, State, deformer, segmenter, tracker};
    #[cfg(feature = "rust-door")]
    pub use crate::rust_door::root;
    #[cfg(feature = "rust-door")]
    pub use marey_plugin_abi::{Root1_Ref, export};
}
