//! Animated GIFs: one palette for all frames, so that colours do not flicker, and only what changed in each.
//!
//! Frames are drawn and packed in parallel, a few at a time, so that memory stays small however long the clip. A pixel
//! that still looks like what is shown is left alone: noise does not reach the file.
//!
//! Pixels are clear or opaque, from half on, and opaque ones have the colour of the drawing itself, mixed with nothing: there
//! is no halo, whatever the page behind. Where something opaque leaves a pixel clear, the frame before is disposed of.

use gif::{DisposalMethod, Encoder, Frame, Repeat};
use image::{DynamicImage, RgbImage, RgbaImage};
use rayon::prelude::*;

use super::palette::Palette;
use crate::error::{Error, Result};
use crate::job::Stage;

/// Frames that the palette is made from, spread over the clip.
const SAMPLES: usize = 8;
/// Frames drawn at once.
const CHUNK: usize = 8;
/// A pixel stays as it is shown while it is off by no more than this in any channel.
const KEEP: u8 = 7;
/// Opacity from which on a pixel is opaque.
pub(super) const OPAQUE: u8 = 128;
/// Hundredths of a second; viewers slow down what is shorter.
const SHORTEST: u64 = 2;

/// Which of a clip's frames to show, and for how long.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// The clip's frames, rising.
    pub frames: Vec<usize>,
    /// For each of them, hundredths of a second.
    pub delays: Vec<u16>,
}

impl Schedule {
    /// All `frames` at `fps` where that is no more than `most` frames and 50 a second, else evenly chosen ones. The
    /// times add up to the clip's.
    pub fn new(frames: usize, fps: f64, most: usize) -> Self {
        let at = |frame: usize| (100.0 * frame as f64 / fps).round() as u64;
        let step = frames.div_ceil(most.max(1)).max((fps * SHORTEST as f64 / 100.0).ceil() as usize).max(1);
        let chosen: Vec<usize> = (0..frames).step_by(step).collect();
        let end = |i: usize| chosen.get(i + 1).copied().unwrap_or(frames);
        let delays = chosen.iter().enumerate().map(|(i, &f)| (at(end(i)) - at(f)).clamp(SHORTEST, 65_535) as u16);
        let delays = delays.collect();
        Self { frames: chosen, delays }
    }
}

/// The bytes of a looping GIF. `draw` gives the picture of a clip frame of the schedule, all of one size; it is called
/// from several threads. The colours `fixed` are met exactly.
///
/// # Errors
/// What `draw` says, pictures of several sizes or larger than 65,535 pixels a side, or a cancel.
pub fn encode(
    schedule: &Schedule,
    fixed: &[[u8; 3]],
    draw: impl Fn(usize) -> Result<RgbImage> + Sync,
    stage: Stage<'_>,
) -> Result<Vec<u8>> {
    encode_any(schedule, fixed, |frame| Ok(DynamicImage::from(draw(frame)?).into_rgba8()), stage)
}

/// The bytes of a looping GIF of pictures that are clear in places, as [`encode`] makes it of opaque ones.
///
/// # Errors
/// As for [`encode`].
pub fn encode_clear(
    schedule: &Schedule,
    draw: impl Fn(usize) -> Result<RgbaImage> + Sync,
    stage: Stage<'_>,
) -> Result<Vec<u8>> {
    encode_any(schedule, &[], draw, stage)
}

fn encode_any(
    schedule: &Schedule,
    fixed: &[[u8; 3]],
    draw: impl Fn(usize) -> Result<RgbaImage> + Sync,
    stage: Stage<'_>,
) -> Result<Vec<u8>> {
    let count = schedule.frames.len();
    let spread = count.div_ceil(SAMPLES).max(1);
    let drawn = |i: usize| {
        stage.at(i as f64 / count.max(1) as f64)?;
        draw(schedule.frames[i])
    };
    let mut samples: Vec<(usize, RgbaImage)> = (0..count)
        .step_by(spread)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|i| {
            stage.at(0.0)?;
            Ok((i, draw(schedule.frames[i])?))
        })
        .collect::<Result<_>>()?;
    let Some(size) = samples.first().map(|s| s.1.dimensions()) else {
        return Err(Error::invalid("a GIF", "has no frame", "give at least one"));
    };
    let (Ok(width), Ok(height)) = (u16::try_from(size.0), u16::try_from(size.1)) else {
        return Err(Error::invalid("a GIF", format!("of {}x{}", size.0, size.1), "draw it at most 65,535 pixels wide"));
    };
    let pictures: Vec<RgbaImage> = samples.iter().map(|s| s.1.clone()).collect();
    let palette = Palette::build(&pictures, fixed);
    drop(pictures);

    let flat: Vec<u8> = palette.colors().iter().flatten().copied().collect();
    let failed = |e: gif::EncodingError| Error::invalid("a GIF", e.to_string(), "draw it smaller");
    let mut encoder = Encoder::new(Vec::new(), width, height, &flat).map_err(failed)?;
    encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
    let mut shown: Vec<u8> = Vec::new();
    // A frame is packed when the next one is known, which may ask it to go.
    let mut waiting: Option<RgbaImage> = None;
    for from in (0..count).step_by(CHUNK) {
        let chunk: Vec<usize> = (from..(from + CHUNK).min(count)).collect();
        let mut known: Vec<Option<RgbaImage>> = vec![None; chunk.len()];
        samples.retain_mut(|(i, picture)| match known.get_mut(i.wrapping_sub(from)) {
            Some(slot) => {
                *slot = Some(std::mem::take(picture));
                false
            }
            None => true,
        });
        let pictures: Vec<RgbaImage> =
            chunk.par_iter().zip(known).map(|(&i, known)| known.map_or_else(|| drawn(i), Ok)).collect::<Result<_>>()?;
        let mut frames = Vec::with_capacity(chunk.len() + 1);
        for (&i, picture) in chunk.iter().zip(pictures) {
            if picture.dimensions() != size {
                return Err(Error::invalid("a GIF", "has frames of several sizes", "draw them all at one size"));
            }
            if let Some(before) = &waiting {
                frames.push(change(&palette, before, Some(&picture), &mut shown, schedule.delays[i - 1]));
            }
            waiting = Some(picture);
        }
        if let Some(last) = waiting.as_ref().filter(|_| from + chunk.len() == count) {
            frames.push(change(&palette, last, None, &mut shown, schedule.delays[count - 1]));
        }
        frames.par_iter_mut().for_each(Frame::make_lzw_pre_encoded);
        for frame in &frames {
            encoder.write_lzw_pre_encoded_frame(frame).map_err(failed)?;
        }
        stage.at((from + chunk.len()) as f64 / count as f64)?;
    }
    encoder.into_inner().map_err(failed)
}

/// The smallest frame that turns what is `shown` into `picture`, and is disposed of where the `next` one needs it to be.
fn change(
    palette: &Palette,
    picture: &RgbaImage,
    next: Option<&RgbaImage>,
    shown: &mut Vec<u8>,
    delay: u16,
) -> Frame<'static> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let as_before = palette.colors().len() as u8;
    let mut indices = vec![as_before; width * height];
    let first = shown.is_empty();
    if first {
        shown.resize(width * height, as_before);
    }
    let (mut left, mut right, mut top, mut bottom) = if first { (0, width, 0, height) } else { (width, 0, height, 0) };
    let is_opaque = |picture: &RgbaImage, i: usize| picture.as_raw()[4 * i + 3] >= OPAQUE;
    let mut leaves = false;
    for (i, pixel) in picture.as_raw().chunks_exact(4).enumerate() {
        if pixel[3] < OPAQUE {
            continue;
        }
        let now = palette.colors().get(usize::from(shown[i]));
        if !now.is_some_and(|now| (0..3).all(|c| now[c].abs_diff(pixel[c]) <= KEEP)) {
            let best = palette.nearest([pixel[0], pixel[1], pixel[2]]);
            if best != shown[i] {
                indices[i] = best;
                shown[i] = best;
            }
        }
        let leaves_now = next.is_some_and(|next| !is_opaque(next, i));
        leaves |= leaves_now;
        if leaves_now || indices[i] != as_before {
            let (x, y) = (i % width, i / width);
            (left, right) = (left.min(x), right.max(x + 1));
            (top, bottom) = (top.min(y), bottom.max(y + 1));
        }
    }
    if right == 0 {
        // Nothing changed, but the time must pass.
        (left, right, top, bottom) = (0, 1, 0, 1);
    }
    let row = |y: usize| y * width + left..y * width + right;
    let cut: Vec<u8> = (top..bottom).flat_map(|y| &indices[row(y)]).copied().collect();
    if leaves {
        (top..bottom).for_each(|y| shown[row(y)].fill(as_before));
    }
    let transparent = cut.contains(&as_before).then_some(as_before);
    let dispose = if leaves { DisposalMethod::Background } else { DisposalMethod::Keep };
    frame(cut, (left, top, right - left, bottom - top), transparent, delay, dispose)
}

fn frame(
    indices: Vec<u8>,
    (left, top, width, height): (usize, usize, usize, usize),
    transparent: Option<u8>,
    delay: u16,
    dispose: DisposalMethod,
) -> Frame<'static> {
    Frame {
        delay,
        dispose,
        transparent,
        left: left as u16,
        top: top as u16,
        width: width as u16,
        height: height as u16,
        buffer: indices.into(),
        ..Frame::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedules_keep_the_time_and_the_limits() {
        assert_eq!(Schedule::new(4, 24.0, 100).delays, [4, 4, 5, 4]);
        for (frames, fps) in [(48, 24.0), (1000, 29.97), (300, 240.0), (1, 30.0), (7, 0.5)] {
            let schedule = Schedule::new(frames, fps, 120);
            assert!(schedule.frames.len() <= 120 && schedule.frames.len() == schedule.delays.len());
            let total: f64 = schedule.delays.iter().map(|d| f64::from(*d)).sum();
            assert!((total - 100.0 * frames as f64 / fps).abs() <= 2.0, "{frames} at {fps}: {total}");
            assert!(schedule.delays.iter().all(|d| *d >= 2));
        }
    }
}
