//! What a place looks like: colours and opacity on three rings around it, each from a picture as blurred as the ring is
//! wide (the layout of DAISY, Tola et al. 2008, over colours instead of gradients), so that a few bytes say what is there
//! and a little misalignment changes little. A turned thing is looked for with turned rings.
//!
//! Differences are cut off, so that what passes behind a thing, and so changes some of the ring, does not outweigh the rest.
//! Known limits: no change of size; brightness counts as it is.

use glam::Vec2;
use image::RgbImage;

use crate::raster::{Planes, pyramid};

/// Lightness, two colours, opacity.
pub(super) type Pixel = [u8; 4];
/// Places on a ring, the ring's radius in pixels of a 512 x 512 picture, and the halved picture it is read from.
const RINGS: [(usize, f32, usize); 4] = [(1, 0.0, 0), (6, 3.5, 0), (8, 8.5, 1), (8, 18.0, 2)];
const PLACES: usize = 23;
/// Bytes of a description, a multiple of 16 for wide instructions; the last four stay 0.
const BYTES: usize = 96;
/// A difference as large as this is as bad as any.
const CUT: u8 = 60;
/// The outermost ring counts less: what is there often moves apart from the thing.
const OUTER: u8 = 20;
/// Halved pictures that are kept, the whole one among them.
pub(super) const LEVELS: usize = 4;

/// A description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Looks([u8; BYTES]);

impl Looks {
    /// How unlike two places look, in 0..=1.
    #[inline]
    pub(super) fn unlike(&self, other: &Self) -> f32 {
        let mut sum = 0u32;
        for (at, (a, b)) in self.0.chunks_exact(16).zip(other.0.chunks_exact(16)).enumerate() {
            let cut = if at < 4 { CUT } else { OUTER };
            let mut part = 0u16;
            for i in 0..16 {
                part += u16::from(a[i].abs_diff(b[i]).min(cut));
            }
            sum += u32::from(part);
        }
        sum as f32 * (1.0 / (15.0 * 3.0) / f32::from(CUT))
    }
}

/// A picture at falling resolutions, as bytes.
#[derive(Clone, Debug)]
pub(super) struct Levels {
    levels: Vec<(usize, usize, Vec<Pixel>)>,
}

impl Levels {
    /// Of a working picture and its opacity, if it has any.
    pub(super) fn new(rgb: &RgbImage, alpha: Option<&image::GrayImage>) -> Self {
        let lab = Planes::lab(rgb);
        let mut channels: Vec<_> = (0..3).map(|c| lab.channel(c).clone()).collect();
        if let Some(alpha) = alpha {
            let data = alpha.as_raw().iter().map(|a| f32::from(*a) / 255.0).collect();
            channels.push(crate::raster::Grid::from_vec(lab.width(), lab.height(), data));
        }
        let mut levels = Vec::with_capacity(LEVELS);
        for level in 0..LEVELS {
            if level > 0 {
                channels = channels.iter().map(pyramid::halved).collect();
            }
            let (width, height) = (channels[0].width(), channels[0].height());
            let byte = |v: f32| v.round().clamp(0.0, 255.0) as u8;
            let mut pixels = vec![[0, 0, 0, 255u8]; width * height];
            for (c, channel) in channels.iter().enumerate() {
                let (scale, zero) = [(255.0, 0.0), (200.0, 128.0), (200.0, 128.0), (120.0, 0.0)][c];
                for (pixel, v) in pixels.iter_mut().zip(channel.data()) {
                    pixel[c] = byte(v * scale + zero);
                }
            }
            levels.push((width, height, pixels));
        }
        Self { levels }
    }

    /// A level's columns, rows and pixels.
    pub(super) fn level(&self, level: usize) -> (usize, usize, &[Pixel]) {
        let (width, height, pixels) = &self.levels[level];
        (*width, *height, pixels)
    }

    /// The pixel of a level at `p`, in pixels of the whole picture; outside, the nearest one inside.
    #[inline]
    pub(super) fn at(&self, level: usize, p: Vec2) -> Pixel {
        let (width, height, pixels) = &self.levels[level];
        let scale = 1.0 / (1 << level) as f32;
        let x = ((p.x * scale) as isize).clamp(0, *width as isize - 1) as usize;
        let y = ((p.y * scale) as isize).clamp(0, *height as isize - 1) as usize;
        pixels[y * width + x]
    }

    /// The colour at `p` of the whole picture, bilinear; outside, the nearest one inside.
    #[inline]
    pub(super) fn between(&self, p: Vec2) -> [f32; 4] {
        let (width, height, pixels) = &self.levels[0];
        let x = (p.x - 0.5).clamp(0.0, (*width - 1) as f32);
        let y = (p.y - 0.5).clamp(0.0, (*height - 1) as f32);
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let (a, b) = (pixels[y0 * width + x0], pixels[y0 * width + x1]);
        let (c, d) = (pixels[y1 * width + x0], pixels[y1 * width + x1]);
        std::array::from_fn(|i| {
            let top = f32::from(a[i]) * (1.0 - fx) + f32::from(b[i]) * fx;
            let bottom = f32::from(c[i]) * (1.0 - fx) + f32::from(d[i]) * fx;
            top * (1.0 - fy) + bottom * fy
        })
    }

    /// The colours around `p`, with the rings turned.
    #[inline]
    pub(super) fn looks(&self, p: Vec2, rings: &Rings) -> Looks {
        let mut out = [0u8; BYTES];
        for ((offset, level), out) in rings.0.iter().zip(out.chunks_exact_mut(4)) {
            out.copy_from_slice(&self.at(*level, p + *offset));
        }
        Looks(out)
    }
}

/// Where the places of a description lie, for one turn.
#[derive(Clone, Debug)]
pub(super) struct Rings([(Vec2, usize); PLACES]);

impl Rings {
    /// Rings for a picture whose sides' geometric mean is `unit` times 512, turned back by `angle`: the description
    /// that a thing has now is what the same thing, turned by `angle`, has with straight rings.
    pub(super) fn new(unit: f32, angle: f32) -> Self {
        let mut places = [(Vec2::ZERO, 0); PLACES];
        let mut at = 0;
        for (count, radius, level) in RINGS {
            for i in 0..count {
                let turn = std::f32::consts::TAU * i as f32 / count as f32 - angle;
                places[at] = (Vec2::from_angle(turn) * radius * unit, level);
                at += 1;
            }
        }
        Self(places)
    }
}
