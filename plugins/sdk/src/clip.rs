//! The clip and its frames, lent by the host.

use std::fmt;
use std::marker::PhantomData;

use crate::error::{Error, Result};
use crate::raw;
use crate::room::Host;

/// The clip to work on. Threads may share it.
#[derive(Clone, Copy)]
pub struct Clip<'a> {
    host: &'a dyn Host,
    width: usize,
    height: usize,
    frames: usize,
    fps: f64,
}

impl fmt::Debug for Clip<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Clip({}x{}, {} frames)", self.width, self.height, self.frames)
    }
}

impl<'a> Clip<'a> {
    pub(crate) fn new(host: &'a dyn Host, size: (u32, u32), frames: u64, fps: f64) -> Self {
        Self { host, width: size.0 as usize, height: size.1 as usize, frames: frames as usize, fps }
    }

    /// Pixels across.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> usize {
        self.height
    }

    /// How many frames there are.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Mean frames a second.
    pub fn fps(&self) -> f64 {
        self.fps
    }

    /// Frame `index`, decoded now or before. Nothing is copied; the frame goes back to the host when it is dropped.
    ///
    /// # Errors
    /// There is no such frame, it is damaged, or the host asked to stop.
    pub fn frame(&self, index: usize) -> Result<Frame<'a>> {
        let raw = self.host.frame(index as u64)?;
        // A frame that this code cannot trust to be all there is none; hosts are checked as plugins are.
        let rows = raw.height as usize;
        let sound = !raw.pixels.is_null()
            && raw.width as usize == self.width
            && rows == self.height
            && raw.stride_bytes as usize >= 3 * self.width
            && rows > 0
            && raw.width > 0;
        let frame = Frame { host: self.host, raw, _pixels: PhantomData };
        if sound { Ok(frame) } else { Err(Error::failed(format!("the host gave frame {index} in another size"))) }
    }
}

/// One frame: red, green, blue, sRGB.
pub struct Frame<'a> {
    host: &'a dyn Host,
    raw: raw::Frame,
    _pixels: PhantomData<&'a [u8]>,
}

// SAFETY: the pixels are only read, and the host's functions may be called from any thread (plugin.h).
unsafe impl Send for Frame<'_> {}
// SAFETY: as above.
unsafe impl Sync for Frame<'_> {}

impl fmt::Debug for Frame<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Frame({}x{})", self.width(), self.height())
    }
}

impl Frame<'_> {
    /// Pixels across.
    pub fn width(&self) -> usize {
        self.raw.width as usize
    }

    /// Pixels down.
    pub fn height(&self) -> usize {
        self.raw.height as usize
    }

    /// Bytes from one row's start to the next's.
    pub fn stride(&self) -> usize {
        self.raw.stride_bytes as usize
    }

    /// All rows, with the gaps between them: `stride * (height - 1) + 3 * width` bytes.
    pub fn bytes(&self) -> &[u8] {
        let length = self.stride() * (self.height() - 1) + 3 * self.width();
        // SAFETY: `Clip::frame` checked that there are pixels and rows; the host lends them until the frame is dropped.
        unsafe { std::slice::from_raw_parts(self.raw.pixels, length) }
    }

    /// Row `y` from the top, 3 bytes a pixel; empty for a row that there is not.
    pub fn row(&self, y: usize) -> &[u8] {
        if y >= self.height() {
            return &[];
        }
        let start = y * self.stride();
        self.bytes().get(start..start + 3 * self.width()).unwrap_or(&[])
    }

    /// The pixel at column `x` and row `y`; the nearest one for a place outside.
    pub fn pixel(&self, x: isize, y: isize) -> [u8; 3] {
        let x = x.clamp(0, self.width() as isize - 1) as usize;
        let y = y.clamp(0, self.height() as isize - 1) as usize;
        match self.row(y).get(3 * x..3 * x + 3) {
            Some(&[r, g, b]) => [r, g, b],
            _ => [0; 3],
        }
    }
}

impl Drop for Frame<'_> {
    fn drop(&mut self) {
        self.host.release(&mut self.raw);
    }
}
