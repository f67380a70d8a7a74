//! Draws animated models: pictures and animations of [`RiggedModel`](marey::shape::RiggedModel)s from any side.
//!
//! A [`Renderer`] holds what is costly to make: a device and its pipelines, or nothing on the CPU. A [`Scene`] says what is
//! there, a [`Picture`] how it is looked at; both are plain values. [`Film`] puts pictures over time into files through
//! [`marey::export::animation`]. A host with a window of its own hands its device to [`gpu::Gpu::with_device`] and draws into
//! its own textures.
//!
//! Both paths draw the same: light, colours and depth are functions of the vertex, written once for each path
//! (`shading` and `gpu/shader.wgsl`), so that pictures differ by the smoothing of edges only. Colours are mixed as they
//! are stored, sRGB: textures come out as they went in, which is what tracking and texturing are measured by.
//!
//! Limits: nothing is see-through; shadows are hard and fall on a level floor; a texture's opacity is not looked at.

#![forbid(unsafe_code)]

mod bone_shapes;
mod camera;
mod cpu;
mod extent;
mod film;
#[cfg(feature = "gpu")]
pub mod gpu;
mod in_clip;
mod model;
mod picture;
mod renderer;
mod scene;
mod shading;
mod style;
mod texture;

#[cfg(feature = "gpu")]
pub use wgpu;

pub use camera::{Camera, Lens};
pub use extent::Extent;
pub use film::Film;
pub use in_clip::InClip;
pub use model::Model;
pub use picture::{MAX_SIDE, Picture};
pub use renderer::{Adapter, Renderer};
pub use scene::{Instance, Scene};
pub use style::Style;
