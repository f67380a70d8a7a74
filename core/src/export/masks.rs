//! Masks as 8-bit grey PNG files, 0 or 255, at the clip's size.

use std::path::Path;

use rayon::prelude::*;

use super::folder::{REPORT, StagedFolder};
use super::png::encode_mask;
use super::report::Report;
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::raster::Mask;

/// Writes `folder/00000.png` and so on. The folder must exist.
pub fn write_masks(folder: &Path, masks: &[Mask], stage: Stage<'_>) -> Result<()> {
    let done = std::sync::atomic::AtomicUsize::new(0);
    masks.par_iter().enumerate().try_for_each(|(frame, mask)| {
        let n = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        stage.at(n as f64 / masks.len() as f64)?;
        let path = folder.join(frame_name(frame, "png"));
        let bytes = encode_mask(mask)?;
        std::fs::write(&path, bytes).map_err(|e| Error::io(&path, "write", e))
    })
}

/// Whether masks may be written into `target`: better asked before the work than after it.
///
/// # Errors
/// What [`write_mask_folder`] would say of the target.
pub fn check_mask_folder(target: &Path) -> Result<()> {
    StagedFolder::begin(target, is_ours).map(drop)
}

fn is_ours(name: &str) -> bool {
    name == REPORT || is_frame(name, "png")
}

/// The output of a segmentation alone: the masks and report.json, put into `target` whole or not at all.
pub fn write_mask_folder(target: &Path, masks: &[Mask], report: &Report, stage: Stage<'_>) -> Result<()> {
    let folder = StagedFolder::begin(target, is_ours)?;
    write_masks(folder.path(), masks, stage)?;
    folder.write(REPORT, report.to_json().as_bytes())?;
    folder.commit()
}

/// "00042.png".
pub(super) fn frame_name(frame: usize, extension: &str) -> String {
    format!("{frame:05}.{extension}")
}

/// Whether `name` is one that [`frame_name`] makes.
pub(super) fn is_frame(name: &str, extension: &str) -> bool {
    name.strip_suffix(extension)
        .and_then(|n| n.strip_suffix('.'))
        .is_some_and(|n| n.len() >= 5 && n.bytes().all(|b| b.is_ascii_digit()))
}
