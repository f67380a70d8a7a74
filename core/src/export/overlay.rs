//! What was understood, over the clip: strokes, visibility, trust, masks and key frames, as a GIF.
//!
//! Each limb has a colour, shared by the two of a pair; the far one is dashed and dimmer. A line fades where its
//! place is trusted less; a vertex is a disc where it is seen and a ring where it is hidden. The mask is
//! outlined and a little tinted, and outside it the picture is dimmed and grey. The bar at the bottom shows the time and the key frames.

use glam::Vec2;
use image::RgbImage;

use super::canvas::{Pen, blend, disc, line, mix, ring};
use super::gif::{Schedule, encode};
use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::motion::{Motion, TrackFrame};
use crate::raster::Mask;
use crate::raster::pyramid::{fitted, shrunk};
use crate::rig::{Rig, Side};

/// The picture's longest side: enough to judge by, small enough to mail.
const LONGEST: u32 = 480;
const MAX_FRAMES: usize = 120;
const OUTLINE: [u8; 3] = [255, 240, 120];
const INK: [u8; 3] = [16, 16, 20];
const PAPER: [u8; 3] = [250, 250, 250];
const BAR: u32 = 5;

/// The overlay as the bytes of a GIF. `masks` may be empty, when there are none yet.
///
/// # Errors
/// A motion or masks that do not fit the clip, a frame that cannot be read, or a cancel.
pub fn overlay(clip: &Clip, rig: &Rig, motion: &Motion, masks: &[Mask], stage: Stage<'_>) -> Result<Vec<u8>> {
    let info = clip.info();
    motion.validate()?;
    if motion.frames > info.frames || !(masks.is_empty() || masks.len() == motion.frames) {
        return Err(Error::invalid(
            "the overlay",
            format!("has {} frames of motion, {} masks and {} of the clip", motion.frames, masks.len(), info.frames),
            "give what was made from this clip",
        ));
    }
    let size = fitted(info.width, info.height, LONGEST);
    let scale = size.0 as f32 / info.width as f32;
    let looks: Vec<Look> = motion.tracks.iter().map(|t| Look::of(rig, &t.name)).collect();
    let mut order: Vec<usize> = (0..looks.len()).collect();
    order.sort_by_key(|&t| looks[t].layer);
    let keys: Vec<usize> = rig.keyframes.iter().filter(|k| !k.strokes.is_empty()).map(|k| k.frame).collect();

    let fixed: Vec<[u8; 3]> = [OUTLINE, INK, PAPER].into_iter().chain(looks.iter().map(|l| l.color)).collect();
    let draw = |frame: usize| {
        let picture = clip.frame(frame)?;
        let mut image = shrunk(&picture.rgb, size.0, size.1);
        if let Some(mask) = masks.get(frame) {
            show_mask(&mut image, mask);
        }
        for &track in &order {
            show_limb(&mut image, &motion.tracks[track].frames[frame], looks[track], scale);
        }
        show_time(&mut image, frame, motion.frames, &keys);
        Ok(image)
    };
    encode(&Schedule::new(motion.frames, motion.fps, MAX_FRAMES), &fixed, draw, stage)
}

/// How a limb is drawn.
#[derive(Clone, Copy, Debug)]
struct Look {
    color: [u8; 3],
    dashed: bool,
    /// Lower ones are drawn first.
    layer: u8,
}

impl Look {
    fn of(rig: &Rig, name: &str) -> Self {
        let limb = rig.limbs.iter().position(|l| l.label == name).unwrap_or(0);
        let far = rig.limbs.get(limb).is_some_and(|l| l.side == Some(Side::Far));
        let pair = rig.twin(limb).map_or(limb, |twin| limb.min(twin));
        let bright = hue(0.02 + 0.618_034 * pair as f32);
        let layer = match rig.limbs.get(limb).and_then(|l| l.side) {
            Some(Side::Far) => 0,
            Some(Side::Mid) | None => 1,
            Some(Side::Near) => 2,
        };
        Self { color: if far { mix(bright, [110; 3], 0.45) } else { bright }, dashed: far, layer }
    }
}

/// A strong colour of a hue counted in turns.
fn hue(turns: f32) -> [u8; 3] {
    [0.0, 2.0 / 3.0, 1.0 / 3.0].map(|shift| {
        let wave = ((turns + shift).rem_euclid(1.0) * 6.0 - 3.0).abs() - 1.0;
        (60.0 + 195.0 * wave.clamp(0.0, 1.0)) as u8
    })
}

fn show_mask(image: &mut RgbImage, mask: &Mask) {
    let (width, height) = (image.width() as usize, image.height() as usize);
    // How many of four samples of every pixel lie inside.
    let samples = |size: usize, cells: usize| -> Vec<usize> {
        (0..2 * cells).map(|i| ((2 * i + 1) * size / (4 * cells)).min(size.saturating_sub(1))).collect()
    };
    let (columns, rows) = (samples(mask.width(), width), samples(mask.height(), height));
    let mut inside = vec![0u8; width * height];
    for (y, &row) in rows.iter().enumerate() {
        let cells = &mut inside[y / 2 * width..(y / 2 + 1) * width];
        for (cell, columns) in cells.iter_mut().zip(columns.chunks_exact(2)) {
            *cell += u8::from(mask.get(columns[0], row)) + u8::from(mask.get(columns[1], row));
        }
    }
    for (pixel, &inside) in image.as_flat_samples_mut().samples.chunks_exact_mut(3).zip(&inside) {
        if inside > 0 {
            for (value, tint) in pixel.iter_mut().zip(OUTLINE.map(u32::from)) {
                *value = ((27 * u32::from(*value) + 5 * tint) / 32) as u8;
            }
        }
        if inside < 4 {
            let [r, g, b] = [pixel[0], pixel[1], pixel[2]].map(u32::from);
            let grey = (2 * r + 5 * g + b) / 8;
            let outside = 4 - u32::from(inside);
            for (value, ink) in pixel.iter_mut().zip(INK.map(u32::from)) {
                let dim = (5 * u32::from(*value) + 7 * grey + 4 * ink) / 16;
                *value = ((u32::from(inside) * u32::from(*value) + outside * dim) / 4) as u8;
            }
        }
    }
    let half = |x: usize, y: usize| inside[y * width + x] >= 2;
    for y in 0..height {
        for x in 0..width {
            let border = || {
                !half(x.saturating_sub(1), y)
                    || !half((x + 1).min(width - 1), y)
                    || !half(x, y.saturating_sub(1))
                    || !half(x, (y + 1).min(height - 1))
            };
            if half(x, y) && border() {
                blend(image, x as u32, y as u32, OUTLINE, 0.8);
            }
        }
    }
}

fn show_limb(image: &mut RgbImage, limb: &TrackFrame, look: Look, scale: f32) {
    let points: Vec<Vec2> = limb.points.iter().map(|p| *p * scale).collect();
    let trust: Vec<f32> = limb.confidence.iter().map(|c| 0.35 + 0.65 * c.clamp(0.0, 1.0)).collect();
    let dash = look.dashed.then_some(5.0);
    let halo: Vec<f32> = trust.iter().map(|t| 0.6 * t).collect();
    line(image, &points, &halo, Pen { color: INK, radius: 2.2, dash });
    line(image, &points, &trust, Pen { color: look.color, radius: 1.1, dash });
    for (&point, &visible) in points.iter().zip(&limb.visible) {
        if visible {
            disc(image, point, 1.6, look.color);
        } else {
            disc(image, point, 2.0, INK);
            ring(image, point, 2.0, 0.9, look.color);
        }
    }
}

fn show_time(image: &mut RgbImage, frame: usize, frames: usize, keys: &[usize]) {
    let (width, height) = image.dimensions();
    let at = |f: usize| ((f as f32 + 0.5) / frames.max(1) as f32 * width as f32) as u32;
    let now = at(frame);
    for y in height.saturating_sub(BAR)..height {
        for x in 0..width {
            blend(image, x, y, if x <= now { PAPER } else { INK }, 0.7);
        }
    }
    for &key in keys {
        for y in height.saturating_sub(BAR + 2)..height {
            for x in at(key).saturating_sub(1)..(at(key) + 1).min(width) {
                blend(image, x, y, OUTLINE, 1.0);
            }
        }
    }
}
