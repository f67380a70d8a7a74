//! Video in: any clip as frames on demand, behind one type.

mod folder;

use std::path::Path;
use std::sync::{Arc, Mutex};

use image::{GrayImage, RgbImage};

use crate::error::{Error, Result};

/// What a clip is.
#[derive(Clone, Debug)]
pub struct ClipInfo {
    /// Pixels across, after rotation.
    pub width: u32,
    /// Pixels down, after rotation.
    pub height: u32,
    /// How many frames can be read.
    pub frames: usize,
    /// Mean frames a second.
    pub fps: f64,
    /// What reads it: "images", "mp4", "gif", "apng", "webp", "ffmpeg", "memory".
    pub source: &'static str,
    /// What a person should know: "truncated after frame 31".
    pub warnings: Vec<String>,
}

/// One decoded picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Colours, sRGB.
    pub rgb: RgbImage,
    /// Opacity, where the source has any.
    pub alpha: Option<GrayImage>,
}

/// Where frames come from. Frame sizes are all the same.
pub(crate) trait FrameSource: Send {
    /// Decodes frame `index`, which is below the clip's frame count.
    fn read(&mut self, index: usize) -> Result<Picture>;
}

/// A clip whose frames are decoded when asked for.
pub struct Clip {
    info: ClipInfo,
    source: Mutex<Box<dyn FrameSource>>,
}

impl std::fmt::Debug for Clip {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Clip").field("info", &self.info).finish_non_exhaustive()
    }
}

impl Clip {
    /// Opens a video file or a folder of numbered images.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let (info, source) = folder::open(path.as_ref())?;
        Ok(Self { info, source: Mutex::new(source) })
    }

    /// What the clip is.
    pub fn info(&self) -> &ClipInfo {
        &self.info
    }

    /// Frame `index`, counted from 0.
    pub fn frame(&self, index: usize) -> Result<Arc<Picture>> {
        if index >= self.info.frames {
            return Err(Error::invalid(
                format!("frame {index}"),
                format!("the clip has {} frames", self.info.frames),
                "frames count from 0",
            ));
        }
        let mut source = self.source.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        source.read(index).map(Arc::new)
    }
}
