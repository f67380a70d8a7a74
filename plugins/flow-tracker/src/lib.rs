//! Follows strokes by dense flow, chained from key frames on both sides and held to their looks.
//!
//! Every point moves with a band of flow across its limb, as far as the flow there and back agrees. It is pulled back
//! to the place that looks as the point did on its key frame, so that errors do not add up where the surface has
//! texture. Between two key frames both sides' tracks are joined, weighed by how far they can be trusted and how far
//! away their key frame is.
//!
//! Limits: a limb that is hidden is carried along stiffly; after a long time hidden it is not found again, since
//! nothing here searches the picture. Surfaces without texture drift.

mod carry;
mod chain;
mod flow;
mod parameters;
mod patch;
mod plugin;
mod pyramid;
mod rig;
mod track;

pub use parameters::Parameters;
pub use plugin::FlowPlugin;
pub use rig::{Footage, Frames, Limb, Pose, Stroke};
pub use track::FlowTracker;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input contradicts itself.
    #[error("{what}: {problem}; {remedy}")]
    Input {
        /// What is wrong.
        what: String,
        /// How.
        problem: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A parameter outside its range.
    #[error("{name} is {value}; give a number from {low} to {high}")]
    Parameter {
        /// Which.
        name: &'static str,
        /// What was given.
        value: f32,
        /// The least allowed.
        low: f32,
        /// The most allowed.
        high: f32,
    },
    /// A frame could not be had.
    #[error("frame {frame}: {problem}")]
    Frame {
        /// Which.
        frame: usize,
        /// Why.
        problem: String,
    },
    /// Asked to stop.
    #[error("cancelled")]
    Cancelled,
}
