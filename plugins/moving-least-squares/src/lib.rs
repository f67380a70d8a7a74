//! Moves a mesh by points and bones: rigid moving least squares.
//!
//! Schaefer, McPhail and Warren 2006, "Image Deformation Using Moving Least Squares": every vertex takes the rigid
//! motion that carries the handles best, near handles counting most. Binding does all that depends on the shape at
//! rest; a pose then costs two weighed sums a vertex, no iterations, and depends on nothing but the handles.
//!
//! The paper measures distance through empty space, so that an arm drags the body beside it. Here a handle that is
//! farther away inside the mesh than through the air counts for less by that much.
//!
//! Limits: the paper's. Nothing keeps triangles from folding where near handles turn against each other by more than
//! a right angle, and area is kept only as far as handles keep their distances.

mod bone;
mod deformation;
mod inside;
mod plugin;

pub use deformation::{Deformation, Falloff, Handle, Settings};
pub use plugin::MovingLeastSquares;

/// What can go wrong.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// There is nothing to move, or nothing to move it by.
    #[error("no {0}; give at least one")]
    Empty(&'static str),
    /// A number that is not finite, or too large to calculate with.
    #[error("{what} {index} is no place; give finite numbers below a billion")]
    NotFinite {
        /// What.
        what: &'static str,
        /// Which.
        index: usize,
    },
    /// A triangle without its vertex.
    #[error("triangle {triangle} names vertex {vertex}, and there are {vertices}")]
    Triangle {
        /// Which.
        triangle: usize,
        /// What it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// Other handles than were bound.
    #[error("the handles are not those that were bound: {0}; bind again")]
    Handles(String),
    /// Asked to stop.
    #[error("cancelled")]
    Cancelled,
}
