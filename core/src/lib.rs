//! The engine of Marey: video of something alive in, animation out.
//!
//! ```text
//! clip  ->  track what the user marked  ->  Motion  ->  drive a Shape  ->  export
//! ```
//!
//! Data flows one way: [`export`] knows [`shape`], which knows [`segment`] and [`track`], which know [`motion`],
//! [`rig`] and [`clip`], which stand on [`raster`], [`geometry`], [`deform`] and [`job`]. [`session`] is the document
//! that a host edits, saves and undoes.
//!
//! Pixel coordinates: x right, y down, the centre of the top-left pixel is (0.5, 0.5), in the clip's own resolution.
//! World coordinates of a creature: right-handed, x right, y up, z toward the viewer, 1 unit = 1 pixel of the clip,
//! origin at the clip's bottom left. Frames count from 0.
//!
//! Long functions run on the calling rayon pool and give the same bits on any number of threads.
#![forbid(unsafe_code)]

pub mod clip;
pub mod deform;
pub mod error;
pub mod export;
pub mod geometry;
pub mod job;
pub mod motion;
pub mod pipeline;
pub mod raster;
pub mod rig;
pub mod segment;
pub mod session;
pub mod shape;
pub mod track;

pub use error::{Category, Error, Result};
pub use glam::{Vec2, Vec3, vec2, vec3};
pub use kurbo;
