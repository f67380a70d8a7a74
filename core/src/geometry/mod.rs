//! Plane curves, triangle meshes and fields in space. Knows nothing of clips, rigs or creatures.

pub(crate) mod contour_map;
mod contour_matching;
mod decimate;
mod field3;
mod iso_surface;
pub mod manifold;
mod mean_value;
pub(crate) mod nearest_surface;
mod plane_mesh;
pub mod polygon;
pub mod polyline;
mod shape_context;
pub mod signed_distance;
mod topological_ball;
mod tri_mesh;
pub mod triangle_tree;

pub use decimate::decimate;
pub use field3::Field3;
pub use iso_surface::iso_surface;
pub use plane_mesh::PlaneMesh;
pub use topological_ball::keep_ball;
pub use tri_mesh::TriMesh;
