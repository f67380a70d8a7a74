//! GrabCut over a clip: a creature's mask in every frame, from where its limbs are.
//!
//! Rother, Kolmogorov and Blake 2004, "GrabCut: interactive foreground extraction using iterated graph cuts", with
//! three things added for moving creatures: samples are colours at places, so that colours that both sides share do
//! not count against either; limbs take the user's rectangle's part, and their radii are learnt; and what was creature
//! around a limb in other frames is likely to be creature around it in this.
//!
//! Limits: a creature without contrast to what is behind it is cut by its shape alone. What never appears in the
//! frames from which is learnt (at most 96 of a clip) counts for neither side.

mod cut;
mod footage;
mod limb_field;
mod max_flow;
mod mixture;
mod models;
mod occupancy;
mod paint;
mod parameters;
mod plugin;
mod segment;
mod tidy;
mod window;

pub use footage::{Footage, Frames, Known, Limb};
pub use paint::brush;
pub use parameters::Parameters;
pub use plugin::GrabCutPlugin;
pub use segment::GrabCut;

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
