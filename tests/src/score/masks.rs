//! Masks against true masks: region J of DAVIS (Perazzi et al. 2016), intersection over union per frame.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use marey::raster::Mask;

/// How well the creature was cut out.
#[derive(Clone, Debug)]
pub struct MaskScore {
    /// Mean J over all frames but the first, per cent.
    pub mean: f64,
    /// The worst frame's J, per cent.
    pub worst: f64,
}

/// All masks of a folder, in the order of their names.
fn files(dir: &Path) -> Result<Vec<PathBuf>> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(dir)
        .with_context(|| dir.display().to_string())?
        .filter_map(|e| Some(e.ok()?.path()))
        .filter(|p| p.extension().is_some_and(|e| e == "png"))
        .collect();
    paths.sort();
    Ok(paths)
}

/// Reads a mask image.
pub(super) fn read(path: &Path) -> Result<Mask> {
    Ok(Mask::from_image(&image::open(path).with_context(|| path.display().to_string())?.to_luma8()))
}

/// Scores the masks of `dir` against those of `truth`; a missing one counts as wrong altogether.
pub fn masks(dir: &Path, truth: &Path) -> Result<MaskScore> {
    let mut scores = Vec::new();
    for path in files(truth)?.iter().skip(1) {
        let found = dir.join(path.file_name().context("a mask has a name")?);
        if !found.exists() {
            scores.push(0.0);
            continue;
        }
        let (found, path) = (read(&found)?, read(path)?);
        ensure!((found.width(), found.height()) == (path.width(), path.height()), "masks of another size");
        scores.push(100.0 * found.iou(&path));
    }
    ensure!(!scores.is_empty(), "{}: no masks to compare with", truth.display());
    Ok(MaskScore {
        mean: scores.iter().sum::<f64>() / scores.len() as f64,
        worst: scores.iter().copied().fold(f64::INFINITY, f64::min),
    })
}
