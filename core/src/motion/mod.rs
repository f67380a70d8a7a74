//! Motion: named tracks over time, whatever made them. Any motion can drive any shape.

mod beside_named;
mod blend;
pub mod bvh;
mod closing;
mod easing;
mod edit;
mod gait_cycle;
pub mod limb_map;
mod limb_reach;
pub mod matching;
mod motion_file;
pub mod paths;
mod planting;
pub mod retarget;
mod retime;
mod sampling;
mod smoothing;

pub use blend::blend_tree;
pub use closing::{ClosedLoop, LoopParams, Seam, close_loop};
pub use easing::Easing;
pub use gait_cycle::{GaitCycle, LimbPhase, find_cycle};
pub(crate) use matching::listed;
pub use planting::{Contacts, PlantParams, Planted, plant};
pub use retime::{Course, Direction, Retime, TimeKey, retime};
pub use smoothing::{Held, SmoothParams, smooth};

use glam::Vec2;

/// What a track follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TrackKind {
    /// A limb: points along a stroke.
    Stroke,
    /// One control point.
    Point,
    /// One joint of a skeleton.
    Joint,
}

/// A track in one frame. The three lists are of one length.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TrackFrame {
    /// Places in clip pixels; they may lie outside the image.
    pub points: Vec<Vec2>,
    /// Whether each point is seen, rather than hidden behind something or outside the image.
    pub visible: Vec<bool>,
    /// How far each place is to be trusted, in 0..=1; 1 on key frames.
    pub confidence: Vec<f32>,
}

impl TrackFrame {
    /// Points that the user drew: all seen, all certain.
    pub fn certain(points: Vec<Vec2>) -> Self {
        Self { visible: vec![true; points.len()], confidence: vec![1.0; points.len()], points }
    }
}

/// One thing followed over all frames.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Track {
    /// The limb's, point's or joint's name, unique in the motion.
    pub name: String,
    /// What it is.
    pub kind: TrackKind,
    /// One entry a frame, all with the same number of points.
    pub frames: Vec<TrackFrame>,
}

/// Named tracks over time.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Motion {
    /// Width and height of the clip.
    pub size: (u32, u32),
    /// Frames a second.
    pub fps: f64,
    /// How many frames every track has.
    pub frames: usize,
    /// The tracks.
    pub tracks: Vec<Track>,
    /// Pairs of track names that are joined: from parent to child.
    pub bones: Vec<(String, String)>,
}

impl Motion {
    /// The track called `name`.
    pub fn track(&self, name: &str) -> Option<&Track> {
        self.tracks.iter().find(|t| t.name == name)
    }
}

#[cfg(test)]
mod shaping_tests;
