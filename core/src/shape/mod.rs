//! Shapes that a motion drives.

pub mod character;
pub mod creature;
pub mod crowd;
mod retiming;
mod rigged_model;
pub mod solid;

pub use rigged_model::{Bone, RiggedModel, SkinnedPart, Transform};
pub mod sketch;
