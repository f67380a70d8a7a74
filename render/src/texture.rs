//! A texture and ever smaller versions of it, so that what is far away does not flicker.

use glam::{Vec2, Vec3};
use image::RgbImage;

/// Smaller versions at most: with each, what lies beside a texture's island of colour comes a pixel nearer.
const SMALLER: usize = 4;

/// A texture, and versions of a half, a quarter, ... of its size: each pixel the mean of four.
#[derive(Clone, Debug)]
pub(crate) struct Texture {
    pub(crate) levels: Vec<RgbImage>,
}

impl Texture {
    pub(crate) fn new(picture: &RgbImage) -> Self {
        let mut levels = vec![picture.clone()];
        while levels.len() <= SMALLER {
            let last = &levels[levels.len() - 1];
            if last.width().min(last.height()) < 8 {
                break;
            }
            levels.push(halved(last));
        }
        Self { levels }
    }

    /// The colour at `uv` (0..=1, v down, borders repeated) between the two versions around `level`, 0..=1.
    pub(crate) fn at(&self, uv: Vec2, level: f32) -> Vec3 {
        let level = level.clamp(0.0, (self.levels.len() - 1) as f32);
        let (fine, share) = (level as usize, level.fract());
        let color = bilinear(&self.levels[fine], uv);
        if share < 1e-3 { color } else { color.lerp(bilinear(&self.levels[fine + 1], uv), share) }
    }
}

fn halved(picture: &RgbImage) -> RgbImage {
    let (w, h) = picture.dimensions();
    RgbImage::from_fn((w / 2).max(1), (h / 2).max(1), |x, y| {
        let at = |dx: u32, dy: u32| picture.get_pixel((2 * x + dx).min(w - 1), (2 * y + dy).min(h - 1)).0;
        let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        image::Rgb([0, 1, 2].map(|c| ((four.iter().map(|p| u32::from(p[c])).sum::<u32>() + 2) / 4) as u8))
    })
}

fn bilinear(picture: &RgbImage, uv: Vec2) -> Vec3 {
    let (width, height) = picture.dimensions();
    let x = (uv.x * width as f32 - 0.5).clamp(0.0, width as f32 - 1.0);
    let y = (uv.y * height as f32 - 0.5).clamp(0.0, height as f32 - 1.0);
    let (x0, y0) = (x as usize, y as usize);
    let right = if x0 + 1 < width as usize { 3 } else { 0 };
    let down = if y0 + 1 < height as usize { 3 * width as usize } else { 0 };
    let (bytes, at) = (picture.as_raw(), 3 * (y0 * width as usize + x0));
    let texel = |at: usize| {
        let &[r, g, b] = bytes[at..].first_chunk().unwrap_or(&[0; 3]);
        Vec3::new(f32::from(r), f32::from(g), f32::from(b))
    };
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    let above = texel(at).lerp(texel(at + right), fx);
    let below = texel(at + down).lerp(texel(at + down + right), fx);
    above.lerp(below, fy) / 255.0
}
