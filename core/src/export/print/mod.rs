//! Solids as files for printers and slicers: STL, which every slicer reads, and 3MF, which also has units and colours.

mod stl;
mod three_mf;

use std::path::Path;

pub use stl::stl;
pub use three_mf::three_mf;

use super::write_aside;
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::shape::solid::Solid;

/// What a solid can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrintFormat {
    /// Binary STL, in mm, without colours.
    Stl,
    /// 3MF with a colour a vertex.
    ThreeMf,
}

impl PrintFormat {
    /// The format that the path's ending stands for.
    ///
    /// # Errors
    /// Another ending.
    pub fn of(path: &Path) -> Result<Self> {
        match path.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
            Some("stl") => Ok(Self::Stl),
            Some("3mf") => Ok(Self::ThreeMf),
            _ => Err(Error::file(path, "its ending says no format for printing", "name it .stl or .3mf")),
        }
    }
}

/// Writes a solid to `path`, whole or not at all, in the format that its ending stands for.
///
/// # Errors
/// Another ending, a file that cannot be written, or a cancel.
pub fn write_print(path: &Path, solid: &Solid, stage: Stage<'_>) -> Result<()> {
    let bytes = match PrintFormat::of(path)? {
        PrintFormat::Stl => stl(solid, stage)?,
        PrintFormat::ThreeMf => three_mf(solid, stage)?,
    };
    stage.at(1.0)?;
    write_aside(path, &bytes)
}
