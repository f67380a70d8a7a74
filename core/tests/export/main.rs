//! What leaves the engine, read back by somebody else.

mod gltf;
mod model;
