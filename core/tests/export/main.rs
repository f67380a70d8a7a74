//! What leaves the engine, read back by somebody else, and the whole job that makes it.

mod animations;
mod folder;
mod gltf;
mod model;
mod obj;
mod pictures;
mod pipeline;
mod scene;
mod takes;
