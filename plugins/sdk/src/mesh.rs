//! A plane mesh and the handles that move it.

use crate::point::Point;

/// A plane mesh at rest, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mesh<'a> {
    /// Vertices.
    pub points: &'a [Point],
    /// Vertex indices, three a triangle, all turned the same way. Every index has its vertex.
    pub triangles: &'a [[u32; 3]],
}

/// What a person moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Handle {
    /// A point of the mesh.
    Point(Point),
    /// A straight bone from its root to its tip; the mesh around it turns and stretches with it.
    Bone(Point, Point),
}
