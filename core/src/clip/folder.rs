//! A folder of numbered images as a clip.

use std::path::{Path, PathBuf};

use super::{ClipInfo, FrameSource, Picture};
use crate::error::{Error, Result};

struct Folder {
    paths: Vec<PathBuf>,
}

pub(super) fn open(path: &Path) -> Result<(ClipInfo, Box<dyn FrameSource>)> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(path)
        .map_err(|e| Error::io(path, "read", e))?
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|p| p.extension().is_some_and(|e| e == "png" || e == "jpg"))
        .collect();
    paths.sort();
    let Some(first) = paths.first() else {
        return Err(Error::file(path, "holds no images", "expected 00000.png, 00001.png, ..."));
    };
    let (width, height) =
        image::image_dimensions(first).map_err(|e| Error::file(first, e.to_string(), "expected an image"))?;
    let info = ClipInfo { width, height, frames: paths.len(), fps: 24.0, source: "images", warnings: Vec::new() };
    Ok((info, Box::new(Folder { paths })))
}

impl FrameSource for Folder {
    fn read(&mut self, index: usize) -> Result<Picture> {
        let path = &self.paths[index];
        let image = image::open(path).map_err(|e| Error::file(path, e.to_string(), "expected an image"))?;
        let rgb = image.to_rgb8();
        Ok(Picture { rgb, alpha: None })
    }
}
