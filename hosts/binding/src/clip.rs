//! Clips.

use marey_ffi::mry_clip;

use crate::{Context, Result, sys};

/// An open clip.
#[derive(Debug)]
pub struct Clip {
    pub(crate) id: mry_clip,
    pub(crate) context: Context,
}

/// What a clip is.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipInfo {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// How many frames can be read.
    pub frames: u64,
    /// Mean frames a second.
    pub fps: f64,
    /// What reads it: "mp4", "gif", "images", ...
    pub source: String,
    /// What a person should know, such as "truncated after frame 31".
    pub warnings: Vec<String>,
}

impl Clip {
    /// What the clip is.
    pub fn info(&self) -> Result<ClipInfo> {
        let info = sys::clip_info(&self.context.0, self.id)?;
        let warning = |index| sys::clip_warning(&self.context.0, self.id, index);
        Ok(ClipInfo {
            width: info.width,
            height: info.height,
            frames: info.frame_count,
            fps: info.fps,
            source: sys::text(&info.source),
            warnings: (0..info.warning_count).map(warning).collect::<Result<_>>()?,
        })
    }

    /// One frame as RGB, 8 bits a channel, rows from the top without gaps.
    pub fn frame(&self, frame: u64) -> Result<Vec<u8>> {
        let info = sys::clip_info(&self.context.0, self.id)?;
        let mut pixels = vec![0; 3 * info.width as usize * info.height as usize];
        sys::clip_frame(&self.context.0, self.id, frame, &mut pixels)?;
        Ok(pixels)
    }

    /// How opaque one frame is, a byte a pixel, 255 for what hides all behind it.
    pub fn alpha(&self, frame: u64) -> Result<Vec<u8>> {
        let info = sys::clip_info(&self.context.0, self.id)?;
        let mut pixels = vec![0; info.width as usize * info.height as usize];
        sys::clip_alpha(&self.context.0, self.id, frame, &mut pixels)?;
        Ok(pixels)
    }
}

impl Drop for Clip {
    fn drop(&mut self) {
        sys::clip_close(&self.context.0, self.id);
    }
}
