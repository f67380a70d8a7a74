//! A folder of numbered images as a clip.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::source::{Decoded, Source, Stream};
use super::{Attempt, ClipInfo, ClipOptions, Opened, Picture};
use crate::error::{Error, Result};

struct Folder {
    paths: Arc<[PathBuf]>,
}

struct Images {
    paths: Arc<[PathBuf]>,
    next: usize,
}

pub(super) fn open(path: &Path, options: &ClipOptions) -> Attempt<Opened> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(path)
        .map_err(|e| Error::io(path, "read", e))?
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|p| p.extension().is_some_and(|e| e == "png" || e == "jpg"))
        .collect();
    paths.sort();
    let Some(first) = paths.first() else {
        return Err(Error::file(path, "holds no images", "expected 00000.png, 00001.png, ...").into());
    };
    let (width, height) =
        image::image_dimensions(first).map_err(|e| Error::file(first, e.to_string(), "expected an image"))?;
    let fps = options.images_fps;
    let info = ClipInfo { width, height, frames: paths.len(), fps, source: "images", warnings: Vec::new() };
    let times = (0..paths.len()).map(|i| i as f64 / fps).collect();
    Ok(Opened { info, times, pictures: None, source: Box::new(Folder { paths: paths.into() }) })
}

impl Source for Folder {
    fn restart(&self, picture: usize) -> usize {
        picture
    }

    fn stream(&self, picture: usize) -> Result<Box<dyn Stream>> {
        Ok(Box::new(Images { paths: Arc::clone(&self.paths), next: picture }))
    }

    fn max_streams(&self) -> usize {
        64
    }
}

impl Stream for Images {
    fn next(&mut self) -> Result<Option<(usize, Decoded)>> {
        let Some(path) = self.paths.get(self.next) else { return Ok(None) };
        let number = self.next;
        self.next += 1;
        let image = image::open(path).map_err(|e| Error::file(path, e.to_string(), "expected an image"))?;
        Ok(Some((number, Decoded::Picture(Picture { rgb: image.to_rgb8(), alpha: None }))))
    }
}
