//! A triangle mesh with texture coordinates.

use glam::{Vec2, Vec3};

/// Vertices, one normal and one texture coordinate each (v down, as glTF has it), and triangles,
/// counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals, as many as positions.
    pub normals: Vec<Vec3>,
    /// Texture coordinates in 0..=1, as many as positions.
    pub uvs: Vec<Vec2>,
    /// Vertex indices, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}
