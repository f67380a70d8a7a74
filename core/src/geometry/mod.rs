//! Plane curves and triangle meshes. Knows nothing of clips, rigs or creatures.

pub mod polyline;
mod tri_mesh;

pub use tri_mesh::TriMesh;
