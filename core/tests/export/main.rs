//! What leaves the engine, read back by somebody else, and the whole job that makes it.

mod animations;
mod crowd;
mod folder;
mod gltf;
mod gltf_back;
mod gltf_reader;
mod model;
mod obj;
mod pictures;
mod pipeline;
mod scene;
mod take_scenes;
mod takes;
