//! What was understood, over the clip: strokes, visibility, trust, masks and key frames, as a GIF.
//!
//! Each limb has a colour, shared by the two of a pair; the far one is dashed and dimmer. A line fades where its
//! place is trusted less; a vertex is a disc where it is seen and a ring where it is hidden. Outside the mask the
//! picture is dimmed and grey, and the mask is outlined. The bar at the bottom shows the time and the key frames.

use glam::Vec2;
use image::RgbImage;
use image::imageops::thumbnail;

use super::canvas::{Pen, blend, disc, line, mix, ring};
use super::gif::{Schedule, encode};
use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::motion::{Motion, TrackFrame};
use crate::raster::Mask;
use crate::rig::{Rig, Side};

/// Size of the picture: enough to judge by, small enough to mail.
const MAX_WIDTH: u32 = 480;
const MAX_HEIGHT: u32 = 480;
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
    let scale = (MAX_WIDTH as f32 / info.width as f32).min(MAX_HEIGHT as f32 / info.height as f32).min(1.0);
    let side = |pixels: u32| ((pixels as f32 * scale).round() as u32).max(1);
    let size = (side(info.width), side(info.height));
    let looks: Vec<Look> = motion.tracks.iter().map(|t| Look::of(rig, &t.name)).collect();
    let mut order: Vec<usize> = (0..looks.len()).collect();
    order.sort_by_key(|&t| looks[t].layer);
    let keys: Vec<usize> = rig.keyframes.iter().filter(|k| !k.strokes.is_empty()).map(|k| k.frame).collect();

    let fixed: Vec<[u8; 3]> = [OUTLINE, INK, PAPER].into_iter().chain(looks.iter().map(|l| l.color)).collect();
    let draw = |frame: usize| {
        let picture = clip.frame(frame)?;
        let mut image = thumbnail(&picture.rgb, size.0, size.1);
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
    let (width, height) = image.dimensions();
    let step = [mask.width() as f32 / width as f32, mask.height() as f32 / height as f32];
    // Quarters of every pixel that lie inside.
    let quarters: Vec<u8> = (0..width * height)
        .map(|i| {
            let place = |share: f32, at: u32, axis: usize| ((at as f32 + share) * step[axis]) as isize;
            let (x, y) = (i % width, i / width);
            let inside = |sx: f32, sy: f32| u8::from(mask.at(place(sx, x, 0), place(sy, y, 1)));
            inside(0.25, 0.25) + inside(0.75, 0.25) + inside(0.25, 0.75) + inside(0.75, 0.75)
        })
        .collect();
    let at = |x: u32, y: u32| quarters[(y * width + x) as usize];
    for y in 0..height {
        for x in 0..width {
            let [r, g, b] = image.get_pixel(x, y).0;
            let grey = ((u32::from(r) * 2 + u32::from(g) * 5 + u32::from(b)) / 8) as u8;
            let outside = mix([r, g, b], mix([grey; 3], INK, 0.4), 0.75);
            blend(image, x, y, outside, 1.0 - f32::from(at(x, y)) / 4.0);
            let near = [
                (x.saturating_sub(1), y),
                ((x + 1).min(width - 1), y),
                (x, y.saturating_sub(1)),
                (x, (y + 1).min(height - 1)),
            ];
            if at(x, y) >= 2 && near.iter().any(|&(x, y)| at(x, y) < 2) {
                blend(image, x, y, OUTLINE, 0.8);
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
