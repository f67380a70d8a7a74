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
/// Bytes of a description, a multiple of those compared at once; the last four stay 0.
const BYTES: usize = 96;
const PART: usize = 16;
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
        let (ours, theirs) = (self.0.as_chunks().0, other.0.as_chunks().0);
        SHARE * ours.iter().zip(theirs).enumerate().map(|(i, (a, b))| gap(i, a, b)).sum::<u32>() as f32
    }
}

/// The share of the greatest difference that a unit of difference is.
const SHARE: f32 = 1.0 / (15.0 * 3.0) / CUT as f32;

/// The difference of part `at` of two descriptions.
#[inline]
fn gap(at: usize, a: &[u8; PART], b: &[u8; PART]) -> u32 {
    let cut = if at < 4 { CUT } else { OUTER };
    let mut sum = 0u16;
    for i in 0..PART {
        sum += u16::from(a[i].abs_diff(b[i]).min(cut));
    }
    sum.into()
}

/// A picture at falling resolutions, as bytes.
#[derive(Clone, Debug)]
pub(super) struct Levels {
    levels: Vec<(usize, usize, Vec<Pixel>)>,
}

impl Levels {
    /// Of a working picture and its opacity, if it has any.
    pub(super) fn new(rgb: &RgbImage, alpha: Option<&image::GrayImage>) -> Self {
        let mut channels = Planes::lab(rgb).into_channels().to_vec();
        let (width, height) = (channels[0].width(), channels[0].height());
        if let Some(alpha) = alpha {
            let data = alpha.as_raw().iter().map(|a| f32::from(*a) / 255.0).collect();
            channels.push(crate::raster::Grid::from_vec(width, height, data));
        }
        let mut levels = Vec::with_capacity(LEVELS);
        for level in 0..LEVELS {
            if level > 0 {
                channels = channels.iter().map(pyramid::halved).collect();
            }
            let (width, height) = (channels[0].width(), channels[0].height());
            let mut pixels = vec![[0, 0, 0, 255u8]; width * height];
            for (c, channel) in channels.iter().enumerate() {
                let (scale, zero) = [(255.0, 0.0), (200.0, 128.0), (200.0, 128.0), (120.0, 0.0)][c];
                for (pixel, v) in pixels.iter_mut().zip(channel.data()) {
                    // Rounded; the cast keeps within the range.
                    pixel[c] = (v * scale + (zero + 0.5)) as u8;
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

    /// The colours of the whole picture `steps` away from `p`, across and down, bilinear; outside, the nearest ones
    /// inside.
    #[inline]
    pub(super) fn lattice<const N: usize>(&self, p: Vec2, steps: &[f32; N]) -> Lattice<'_, N> {
        let (width, height, pixels) = &self.levels[0];
        let between = |centre: f32, size: usize| {
            let mut out = [(0, 0, 0.0); N];
            for (out, step) in out.iter_mut().zip(steps) {
                let x = (centre + step - 0.5).clamp(0.0, (size - 1) as f32);
                let x0 = x as usize;
                *out = (x0, (x0 + 1).min(size - 1), x - x0 as f32);
            }
            out
        };
        Lattice { width: *width, pixels, columns: between(p.x, *width), rows: between(p.y, *height) }
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

    /// How unlike `looks` the colours around `p` are, with the rings turned, if less than `most`.
    #[inline]
    pub(super) fn unlike(&self, p: Vec2, rings: &Rings, looks: &Looks, most: f32) -> Option<f32> {
        let mut sum = 0;
        for (i, (places, looks)) in rings.0.chunks(PART / 4).zip(looks.0.as_chunks().0).enumerate() {
            let mut here = [0u8; PART];
            for ((offset, level), here) in places.iter().zip(here.chunks_exact_mut(4)) {
                here.copy_from_slice(&self.at(*level, p + *offset));
            }
            sum += gap(i, &here, looks);
            if SHARE * sum as f32 >= most {
                return None;
            }
        }
        Some(SHARE * sum as f32)
    }
}

/// Places of a picture in rows and columns: for each of those the pixels before and after, and the share of the latter.
pub(super) struct Lattice<'a, const N: usize> {
    width: usize,
    pixels: &'a [Pixel],
    columns: [(usize, usize, f32); N],
    rows: [(usize, usize, f32); N],
}

impl<const N: usize> Lattice<'_, N> {
    /// The colours of a row.
    #[inline]
    pub(super) fn row(&self, row: usize) -> [[f32; 4]; N] {
        let (above, below, fy) = self.rows[row];
        let [above, below] = [above, below].map(|y| &self.pixels[y * self.width..(y + 1) * self.width]);
        let mut out = [[0.0; 4]; N];
        for (out, (left, right, fx)) in out.iter_mut().zip(self.columns) {
            let (a, b, c, d) = (above[left], above[right], below[left], below[right]);
            for i in 0..4 {
                let top = f32::from(a[i]) * (1.0 - fx) + f32::from(b[i]) * fx;
                let bottom = f32::from(c[i]) * (1.0 - fx) + f32::from(d[i]) * fx;
                out[i] = top * (1.0 - fy) + bottom * fy;
            }
        }
        out
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
