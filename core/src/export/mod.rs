//! Everything that leaves the engine: files for other programs and pictures for people.

mod creature_folder;
mod folder;
pub mod gltf;
mod masks;
mod png;
pub mod report;
mod write_aside;

pub use creature_folder::{CreatureFiles, FolderOptions, write_creature};
pub use folder::StagedFolder;
pub use masks::{write_mask_folder, write_masks};
pub use write_aside::write_aside;
