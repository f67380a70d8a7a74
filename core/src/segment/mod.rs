//! Segmenters: from tracked strokes to the creature's mask in every frame, and from a mask to its limbs.

mod backdrop;
mod carried;
mod colour_model;
mod contrast;
mod cost_volume;
mod cut;
mod evidence;
pub(crate) mod figure;
pub mod grab_cut;
mod grid_cut;
mod layered;
mod limb_radius;
mod limbs;
mod painted;
mod paper;
mod params;
mod refine;
mod scene;
mod stroke_field;
mod teaching;
mod track_trust;
mod working;

pub use cost_volume::CostVolumeSegmenter;
pub use limbs::{label_limbs, label_limbs_by_depth, limb_sides};
pub use params::{Method, PaperParams, SegmentParams};

use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::Motion;
use crate::raster::Mask;
use crate::rig::Rig;

/// Anything that cuts the creature out of every frame.
pub trait Segmenter: Send + Sync {
    /// One mask a frame, of the clip's size. `motion` is the rig's limbs, tracked.
    fn segment(&self, clip: &Clip, rig: &Rig, motion: &Motion, stage: Stage<'_>) -> Result<Vec<Mask>>;
}
