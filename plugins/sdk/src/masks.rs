//! What a segmenter gives back.

use std::fmt;

use crate::error::{Error, Result};
use crate::room::Host;

/// Which pixels of a frame are the creature's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// A byte a pixel, 0 for out and anything else for in, rows from the top without gaps.
    pub pixels: Vec<u8>,
}

impl Mask {
    /// A mask of a size with nothing in it.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![0; width * height] }
    }

    /// Whether the pixel is in; false outside the mask.
    pub fn get(&self, x: usize, y: usize) -> bool {
        x < self.width && self.pixels.get(y * self.width + x).is_some_and(|v| *v != 0)
    }

    /// Puts the pixel in or out; outside the mask it does nothing.
    pub fn set(&mut self, x: usize, y: usize, inside: bool) {
        if x < self.width
            && let Some(pixel) = self.pixels.get_mut(y * self.width + x)
        {
            *pixel = if inside { 255 } else { 0 };
        }
    }
}

/// Where the masks go: each is copied by the host at once, so that no more than one need be in memory.
#[derive(Clone, Copy)]
pub struct MaskSink<'a> {
    host: &'a dyn Host,
}

impl fmt::Debug for MaskSink<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("MaskSink")
    }
}

impl<'a> MaskSink<'a> {
    pub(crate) fn new(host: &'a dyn Host) -> Self {
        Self { host }
    }

    /// Gives the mask of `frame`. Every frame of the clip needs one; the order is free, and threads may share the sink.
    ///
    /// # Errors
    /// The mask is not of the clip's size, there is no such frame, or the host asked to stop.
    pub fn put(&self, frame: usize, mask: &Mask) -> Result<()> {
        if mask.width.checked_mul(mask.height) != Some(mask.pixels.len()) {
            let message = format!("the mask of frame {frame} has {} pixels, not its size's", mask.pixels.len());
            return Err(Error::failed(message));
        }
        self.host.put_mask(frame as u64, &mask.pixels, mask.width as u32, mask.height as u32, mask.width)
    }
}
