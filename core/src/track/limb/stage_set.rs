//! Made-up frames for tests: textured bars that move exactly over a textured ground.

use glam::{Vec2, vec2};
use image::{Rgb, RgbImage};

/// A straight limb.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bar {
    pub(crate) from: Vec2,
    /// Radians from x toward y.
    pub(crate) angle: f32,
    pub(crate) length: f32,
    pub(crate) half_width: f32,
}

impl Bar {
    /// The place at a share of its length.
    pub(crate) fn at(&self, share: f32) -> Vec2 {
        self.from + Vec2::from_angle(self.angle) * self.length * share
    }

    fn colour(&self, p: Vec2) -> Option<[f32; 3]> {
        let own = Vec2::from_angle(-self.angle).rotate(p - self.from);
        let inside = own.x > -self.half_width && own.x < self.length + self.half_width && own.y.abs() < self.half_width;
        inside.then(|| {
            let t = smooth_noise(own * 0.16 + vec2(900.0, 40.0));
            let u = smooth_noise(own * 0.09 + vec2(10.0, 700.0));
            [150.0 + 90.0 * t, 80.0 + 80.0 * u, 40.0 + 50.0 * t * u]
        })
    }
}

/// The bars, later ones in front, over a ground shifted by `ground`; four samples a pixel.
pub(crate) fn scene(size: (u32, u32), bars: &[Bar], ground: Vec2) -> RgbImage {
    RgbImage::from_fn(size.0, size.1, |x, y| {
        let mut sum = [0.0; 3];
        for s in 0..4 {
            let p = vec2(x as f32 + 0.25 + 0.5 * (s % 2) as f32, y as f32 + 0.25 + 0.5 * (s / 2) as f32);
            let colour = bars.iter().rev().find_map(|b| b.colour(p)).unwrap_or_else(|| {
                let t = smooth_noise((p + ground) * 0.11);
                [60.0 + 50.0 * t, 110.0 + 60.0 * t, 70.0 + 40.0 * smooth_noise((p + ground) * 0.07 + vec2(50.0, 3.0))]
            });
            for c in 0..3 {
                sum[c] += colour[c] * 0.25;
            }
        }
        Rgb(sum.map(|v| v as u8))
    })
}

/// Value noise in 0..=1 with a smooth blend between whole places.
fn smooth_noise(p: Vec2) -> f32 {
    let (cell, t) = (p.floor(), p.fract_gl());
    let hash = |dx: i64, dy: i64| {
        let mut h =
            (cell.x as i64 + dx).wrapping_mul(0x9E37_79B9).wrapping_add((cell.y as i64 + dy).wrapping_mul(0x85EB_CA6B));
        h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
        h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
        ((h ^ (h >> 15)) & 0xFFFF) as f32 / 65535.0
    };
    let s = t * t * (Vec2::splat(3.0) - 2.0 * t);
    let low = hash(0, 0) + (hash(1, 0) - hash(0, 0)) * s.x;
    let high = hash(0, 1) + (hash(1, 1) - hash(0, 1)) * s.x;
    low + (high - low) * s.y
}
