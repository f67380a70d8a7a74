//! Deformers: a few handles move, and a plane mesh follows. Knows nothing of drawings, characters or sketches.

pub mod arap;
pub mod needles;
mod regions;
pub(crate) mod sparse;
pub mod stroke_preserving;

use glam::Vec2;

pub use regions::{Regions, VertexClass};

use crate::error::Result;
use crate::job::Stage;

/// A plane mesh at rest, in pixels.
#[derive(Clone, Copy, Debug)]
pub struct RestMesh<'a> {
    /// Vertices.
    pub points: &'a [Vec2],
    /// Vertex indices, three a triangle, all turned the same way.
    pub triangles: &'a [[u32; 3]],
}

/// What a person moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Handle {
    /// A point of the mesh.
    Point(Vec2),
    /// A straight bone from its root to its tip; the mesh around it turns and stretches with it.
    Bone(Vec2, Vec2),
}

impl Handle {
    /// The handle with every place passed through `map`.
    #[must_use]
    pub fn map(self, map: impl Fn(Vec2) -> Vec2) -> Self {
        match self {
            Self::Point(at) => Self::Point(map(at)),
            Self::Bone(root, tip) => Self::Bone(map(root), map(tip)),
        }
    }

    /// Whether all its numbers are finite.
    pub fn is_finite(self) -> bool {
        match self {
            Self::Point(at) => at.is_finite(),
            Self::Bone(root, tip) => root.is_finite() && tip.is_finite(),
        }
    }
}

/// Anything that moves a mesh by handles.
pub trait Deformer: Send + Sync {
    /// Prepares all that does not change while the handles move. `handles` are where they lie on the mesh at rest.
    ///
    /// # Errors
    /// No triangles, an index without its vertex, a number that is not finite, a handle that cannot be used.
    fn bind(&self, mesh: RestMesh<'_>, handles: &[Handle], stage: Stage<'_>) -> Result<Box<dyn Deformation>>;
}

/// A mesh bound to its handles.
pub trait Deformation: Send {
    /// Moves the mesh so that every handle is where `targets` say, of the same kinds and in the same order as it was
    /// bound. `points` hold the shape to start from, the rest shape or the one of the frame before, and are given the
    /// new one; after an error they are as they were.
    ///
    /// # Errors
    /// Other handles than were bound, a number that is not finite, or a cancel.
    fn solve(&mut self, targets: &[Handle], points: &mut [Vec2], stage: Stage<'_>) -> Result<()>;
}
