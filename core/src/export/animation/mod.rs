//! Pictures over time as files: one way for everything that is drawn frame by frame.
//!
//! Frames are drawn and packed in parallel, a few at a time, so that memory stays small however long the animation, and
//! files are written aside and renamed. What is lossless and has opacity keeps both to the bit: PNG folders, sprite sheets,
//! animated PNG and WebP. A GIF's pixels are clear or opaque, and of 255 colours; mp4 has neither opacity nor full chroma.

mod apng;
#[cfg(feature = "h264")]
mod h264;
#[cfg(feature = "h264")]
mod mp4;
mod png_folder;
mod rate;
mod sprite_sheet;
mod webp;

use std::path::{Path, PathBuf};

use image::{RgbaImage, imageops};
use rayon::prelude::*;

use super::write_aside::write_aside;
use super::{format_name, gif};
use crate::error::{Error, Result};
use crate::job::Stage;

/// Frames that are drawn at once.
const CHUNK: usize = 8;
/// What frames that are drawn at once may take together, in bytes.
const CHUNK_BYTES: usize = 256 << 20;
/// Frames a second: shorter delays than these no format holds, longer ones nobody means.
pub(super) const RATES: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// What pictures over time can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnimationFormat {
    /// A folder of PNG pictures, 00000.png and so on.
    PngFolder,
    /// PNG pictures with all frames on them, trimmed, and JSON files that say where each is.
    SpriteSheet,
    /// A looping GIF. More than 50 frames a second are thinned out.
    Gif,
    /// A looping animated PNG.
    Apng,
    /// A looping animated WebP, lossless.
    WebP,
    /// H.264 in mp4, over white where nothing is behind.
    Mp4,
}

impl AnimationFormat {
    /// All of them with their names.
    pub const ALL: [(Self, &'static str); 6] = [
        (Self::PngFolder, "png-dir"),
        (Self::SpriteSheet, "sprite-sheet"),
        (Self::Gif, "gif"),
        (Self::Apng, "apng"),
        (Self::WebP, "webp"),
        (Self::Mp4, "mp4"),
    ];

    /// The format called `name`, or else the one that the path's ending stands for: `.png` is an animated PNG, no ending a
    /// folder of pictures.
    ///
    /// # Errors
    /// A name or an ending that is not known.
    pub fn choose(name: Option<&str>, path: &Path) -> Result<Self> {
        format_name::choose(&Self::ALL, name, path)
    }
}

/// An animation to be written.
pub struct Animation<'a> {
    /// A name for what is inside the file.
    pub name: &'a str,
    /// How many frames there are.
    pub frames: usize,
    /// Frames a second.
    pub fps: f64,
    /// Width and height of every frame.
    pub size: (u32, u32),
    /// The point that stays when the picture is turned or placed, in shares of the size.
    pub pivot: [f32; 2],
    /// Gives the picture of a frame, straight alpha; called from several threads.
    pub draw: &'a (dyn Fn(usize) -> Result<RgbaImage> + Sync),
}

impl std::fmt::Debug for Animation<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, frames, fps, size, pivot, .. } = self;
        write!(f, "Animation {{ {name:?}, {frames} frames at {fps}, {size:?}, pivot {pivot:?} }}")
    }
}

/// Writes an animation, and says which files that made; of a folder of pictures, the folder.
///
/// # Errors
/// An animation without frames or without pixels, a rate that is no rate, what the format cannot hold, what drawing says,
/// a file that cannot be written, a cancel. What was there before then stays as it was.
pub fn write(
    path: &Path,
    format: AnimationFormat,
    animation: &Animation<'_>,
    stage: Stage<'_>,
) -> Result<Vec<PathBuf>> {
    stage.name("writing frames")?;
    if animation.frames == 0 {
        return Err(Error::invalid("animation", "has no frames", "give at least one"));
    }
    if !RATES.contains(&animation.fps) {
        let problem = format!("is {}", animation.fps);
        let remedy = format!("give {} to {} frames a second", RATES.start(), RATES.end());
        return Err(Error::invalid("the animation's rate", problem, remedy));
    }
    if animation.size.0 == 0 || animation.size.1 == 0 {
        return Err(Error::invalid("animation", "has no pixels", "draw it larger"));
    }
    match format {
        AnimationFormat::PngFolder => png_folder::write(path, animation, stage),
        AnimationFormat::SpriteSheet => sprite_sheet::write(path, animation, stage),
        AnimationFormat::Apng => apng::write(path, animation, stage),
        AnimationFormat::WebP => webp::write(path, animation, stage),
        AnimationFormat::Gif => {
            let schedule = gif::Schedule::new(animation.frames, animation.fps, usize::MAX);
            let bytes = gif::encode_clear(&schedule, |frame| animation.draw(frame), stage)?;
            write_aside(path, &bytes)?;
            Ok(vec![path.to_owned()])
        }
        #[cfg(feature = "h264")]
        AnimationFormat::Mp4 => h264::write(path, animation, stage),
        #[cfg(not(feature = "h264"))]
        AnimationFormat::Mp4 => {
            Err(Error::invalid("format", "is mp4, and this build has no H.264 encoder", "choose another format"))
        }
    }
}

impl Animation<'_> {
    fn draw(&self, frame: usize) -> Result<RgbaImage> {
        let mut picture = (self.draw)(frame)?;
        if picture.dimensions() != self.size {
            let ((w, h), (width, height)) = (picture.dimensions(), self.size);
            let problem = format!("is {w}x{h} pixels and not {width}x{height}");
            return Err(Error::invalid(format!("the picture of frame {frame}"), problem, "draw all at one size"));
        }
        // What cannot be seen has no colour, so that it costs nothing.
        picture.pixels_mut().filter(|p| p.0[3] == 0).for_each(|p| p.0 = [0; 4]);
        Ok(picture)
    }

    /// Draws all frames and hands each, with the one before it, to `pack`, in parallel, and what that makes to `put`, one
    /// after the other.
    fn each<T: Send>(
        &self,
        stage: Stage<'_>,
        pack: impl Fn(usize, Option<&RgbaImage>, &RgbaImage) -> Result<T> + Sync,
        mut put: impl FnMut(usize, T) -> Result<()>,
    ) -> Result<()> {
        let bytes = 4 * self.size.0 as usize * self.size.1 as usize;
        let chunk = (CHUNK_BYTES / bytes).clamp(1, CHUNK);
        let mut last: Option<RgbaImage> = None;
        for from in (0..self.frames).step_by(chunk) {
            let to = (from + chunk).min(self.frames);
            let at = |frame: usize| stage.at(frame as f64 / self.frames as f64);
            let drawn = (from..to).into_par_iter().map(|frame| {
                at(from)?;
                self.draw(frame)
            });
            let drawn: Vec<RgbaImage> = drawn.collect::<Result<_>>()?;
            let packed = (from..to).into_par_iter().map(|frame| {
                at(from)?;
                let before = if frame > from { Some(&drawn[frame - from - 1]) } else { last.as_ref() };
                pack(frame, before, &drawn[frame - from])
            });
            let packed: Vec<T> = packed.collect::<Result<_>>()?;
            for (frame, packed) in (from..to).zip(packed) {
                at(frame)?;
                put(frame, packed)?;
            }
            last = drawn.into_iter().next_back();
        }
        stage.at(1.0)
    }
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Rect {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

impl Rect {
    /// Around the pixels for which `inside` holds; `None` where there are none.
    fn around((width, height): (u32, u32), inside: impl Fn(usize) -> bool) -> Option<Self> {
        let row = |y: &u32| (0..width).any(|x| inside((y * width + x) as usize));
        let top = (0..height).find(row)?;
        let bottom = (top..height).rfind(row)?;
        let column = |x: &u32| (top..=bottom).any(|y| inside((y * width + x) as usize));
        let left = (0..width).find(column)?;
        let right = (left..width).rfind(column)?;
        Some(Self { x: left, y: top, width: right - left + 1, height: bottom - top + 1 })
    }

    /// Of what differs between two pictures of one size; all without a first one. One pixel where nothing does.
    fn changed(before: Option<&RgbaImage>, now: &RgbaImage) -> Self {
        let (width, height) = now.dimensions();
        let Some(before) = before else { return Self { x: 0, y: 0, width, height } };
        let pixel = |i: usize, of: &RgbaImage| -> [u8; 4] { std::array::from_fn(|c| of.as_raw()[4 * i + c]) };
        Self::around((width, height), |i| pixel(i, before) != pixel(i, now)).unwrap_or(Self::ONE)
    }

    const ONE: Self = Self { x: 0, y: 0, width: 1, height: 1 };

    fn cut(self, picture: &RgbaImage) -> RgbaImage {
        imageops::crop_imm(picture, self.x, self.y, self.width, self.height).to_image()
    }
}

/// How long a frame is shown, in thousandths of a second; such times add up to the animation's.
fn milliseconds(frame: usize, fps: f64) -> u32 {
    let at = |frame: usize| (1000.0 * frame as f64 / fps).round() as u64;
    (at(frame + 1) - at(frame)) as u32
}
