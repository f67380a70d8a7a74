//! Everything that leaves the engine: files for other programs and pictures for people.

pub mod animation;
mod bind_preview;
mod canvas;
mod creature_folder;
mod folder;
mod format_name;
pub mod gif;
pub mod gltf;
mod masks;
mod obj;
mod overlay;
mod palette;
mod png;
mod preview;
pub mod print;
pub mod report;
mod rig_preview;
pub mod scene;
pub mod sketch;
pub mod take;
mod textures;
mod vector;
mod write_aside;

pub use bind_preview::bind_preview;
pub use creature_folder::{CreatureFiles, FolderOptions, check_creature_folder, write_creature};
pub use folder::StagedFolder;
pub use masks::{check_mask_folder, write_mask_folder, write_masks};
pub use obj::{write_obj, write_obj_folder};
pub use overlay::overlay;
pub use png::{encode_mask, write_picture};
pub use preview::preview;
pub use rig_preview::rig_preview;
pub use textures::{painted_on, read_textures, texture_names, write_textures};
pub use write_aside::write_aside;
