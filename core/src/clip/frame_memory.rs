//! Where the pixels of decoded frames lie: in memory of the engine's own, or in memory that a host lends, who may count
//! it, pool it, or share it with a device.
//!
//! Frames are what a clip keeps most of. A frame that is decoded is copied once into what the host lends.

use std::fmt::{Debug, Formatter};
use std::ops::Deref;

use image::{ImageBuffer, Rgb, RgbImage};

use crate::error::{Error, Result};

/// Bytes that somebody lends; dropping them gives them back.
pub trait LentBytes: Deref<Target = [u8]> + Send + Sync {}

/// Somebody who lends memory for frames.
pub trait FrameMemory: Debug + Send + Sync {
    /// A copy of `contents`, or [`None`] when there is no memory for it.
    fn lend(&self, contents: &[u8]) -> Option<Box<dyn LentBytes>>;
}

/// The bytes of a frame.
pub struct FrameBytes(Kept);

enum Kept {
    Own(Vec<u8>),
    Lent(Box<dyn LentBytes>),
}

/// The colours of a frame, 3 bytes a pixel, sRGB.
pub type FrameImage = ImageBuffer<Rgb<u8>, FrameBytes>;

impl FrameBytes {
    /// A copy in memory that is lent.
    ///
    /// # Errors
    /// There is none to be had.
    pub(super) fn lent(&self, memory: &dyn FrameMemory) -> Result<Self> {
        let lent = memory.lend(self).filter(|lent| lent.len() == self.len());
        Ok(Self(Kept::Lent(lent.ok_or(Error::Memory { bytes: self.len() })?)))
    }
}

/// The picture in a frame's memory.
pub(super) fn frame_image(image: RgbImage) -> FrameImage {
    let (width, height) = image.dimensions();
    let bytes = FrameBytes::from(image.into_raw());
    FrameImage::from_raw(width, height, bytes).expect("an image has as many bytes as its size says")
}

/// As [`FrameBytes::lent`].
pub(super) fn lent_image(image: &FrameImage, memory: &dyn FrameMemory) -> Result<FrameImage> {
    let bytes = image.as_raw().lent(memory)?;
    Ok(FrameImage::from_raw(image.width(), image.height(), bytes).expect("a copy has as many bytes"))
}

impl From<Vec<u8>> for FrameBytes {
    fn from(bytes: Vec<u8>) -> Self {
        Self(Kept::Own(bytes))
    }
}

impl Deref for FrameBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match &self.0 {
            Kept::Own(bytes) => bytes,
            Kept::Lent(bytes) => bytes,
        }
    }
}

impl PartialEq for FrameBytes {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl Debug for FrameBytes {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let whose = if matches!(self.0, Kept::Own(_)) { "own" } else { "lent" };
        write!(f, "{} {whose} bytes", self.len())
    }
}
