//! Frames that are in memory already.

use std::sync::Arc;

use image::RgbImage;

use super::source::{Decoded, Source, Stream};
use super::{ClipInfo, Opened, Picture};
use crate::error::{Error, Result};

struct Memory(Arc<[Arc<Picture>]>);

struct Reading {
    frames: Arc<[Arc<Picture>]>,
    next: usize,
}

pub(super) fn open(frames: Vec<RgbImage>, fps: f64) -> Result<Opened> {
    let Some((width, height)) = frames.first().map(RgbImage::dimensions) else {
        return Err(Error::invalid("frames", "there are none", "expected at least one"));
    };
    if let Some(odd) = frames.iter().position(|f| f.dimensions() != (width, height)) {
        let (w, h) = frames[odd].dimensions();
        let problem = format!("is {w}x{h} pixels, unlike the {width}x{height} of frame 0");
        return Err(Error::invalid(format!("frame {odd}"), problem, "all frames of a clip need one size"));
    }
    if width == 0 || height == 0 {
        return Err(Error::invalid("frame 0", format!("is {width}x{height} pixels"), "expected at least one pixel"));
    }
    if !(fps.is_finite() && fps > 0.0) {
        return Err(Error::invalid("frames a second", format!("is {fps}"), "expected a number above 0"));
    }
    let times = (0..frames.len()).map(|i| i as f64 / fps).collect();
    let info = ClipInfo { width, height, frames: frames.len(), fps, source: "memory", warnings: Vec::new() };
    let frames = frames.into_iter().map(|rgb| Arc::new(Picture::new(rgb, None))).collect();
    Ok(Opened { info, times, pictures: None, source: Box::new(Memory(frames)) })
}

impl Source for Memory {
    fn restart(&self, picture: usize) -> usize {
        picture
    }

    fn stream(&self, picture: usize) -> Result<Box<dyn Stream>> {
        Ok(Box::new(Reading { frames: Arc::clone(&self.0), next: picture }))
    }

    fn max_streams(&self) -> usize {
        64
    }
}

impl Stream for Reading {
    fn next(&mut self) -> Result<Option<(usize, Decoded)>> {
        let Some(frame) = self.frames.get(self.next) else { return Ok(None) };
        let number = self.next;
        self.next += 1;
        Ok(Some((number, Decoded::Picture(Arc::clone(frame)))))
    }
}
