//! Plane curves and triangle meshes. Knows nothing of clips, rigs or creatures.

mod plane_mesh;
pub mod polygon;
pub mod polyline;
mod tri_mesh;

pub use plane_mesh::PlaneMesh;
pub use tri_mesh::TriMesh;
