//! Masks: which pixels are the creature's, frame by frame.

use marey_ffi::mry_masks;

use crate::{Context, Result, sys};

/// One mask a frame.
#[derive(Debug)]
pub struct Masks {
    pub(crate) id: mry_masks,
    pub(crate) context: Context,
}

impl Masks {
    /// How many masks there are.
    pub fn frames(&self) -> Result<u64> {
        Ok(sys::masks_info(&self.context.0, self.id)?.frame_count)
    }

    /// One mask: a byte a pixel, 0 or 255, rows from the top without gaps.
    pub fn frame(&self, frame: u64) -> Result<Vec<u8>> {
        let info = sys::masks_info(&self.context.0, self.id)?;
        let mut pixels = vec![0; info.width as usize * info.height as usize];
        sys::masks_read(&self.context.0, self.id, frame, &mut pixels)?;
        Ok(pixels)
    }

    /// Writes 00000.png, ... and a report, whole or not at all.
    pub fn write(&self, folder: &str) -> Result<()> {
        sys::masks_write(&self.context.0, self.id, folder)
    }

    /// The text of the report of the job that made them.
    pub fn report(&self) -> Result<String> {
        sys::masks_report(&self.context.0, self.id)
    }
}

impl Drop for Masks {
    fn drop(&mut self) {
        sys::masks_destroy(&self.context.0, self.id);
    }
}
