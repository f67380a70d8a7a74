//! Plane curves and triangle meshes. Knows nothing of clips, rigs or creatures.

pub(crate) mod contour_map;
mod contour_matching;
mod mean_value;
mod plane_mesh;
pub mod polygon;
pub mod polyline;
mod shape_context;
mod tri_mesh;

pub use plane_mesh::PlaneMesh;
pub use tri_mesh::TriMesh;
