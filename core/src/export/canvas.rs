//! Antialiased lines, discs and rings over a picture.
//!
//! Coverage is one pixel's ramp of the distance to the shape, which is exact enough for lines wider than a pixel. A
//! line is covered once where its segments overlap.

use glam::{IVec2, Vec2, vec2};
use image::{Rgb, RgbImage};

/// How a line looks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pen {
    pub(super) color: [u8; 3],
    /// Half the line's width in pixels.
    pub(super) radius: f32,
    /// Lengths of the dashes and of the gaps between them, in pixels.
    pub(super) dash: Option<f32>,
}

/// Draws a line through `points`, with an opacity at each of them.
pub(super) fn line(image: &mut RgbImage, points: &[Vec2], opacity: &[f32], pen: Pen) {
    let reach = pen.radius + 1.0;
    let Some((low, high)) = bounds(image, points.iter().copied(), reach) else { return };
    let width = (high.x - low.x) as usize;
    let mut coverage = vec![0.0f32; width * (high.y - low.y) as usize];
    let mut passed = 0.0;
    for (ends, opacity) in points.windows(2).zip(opacity.windows(2)) {
        let along = ends[1] - ends[0];
        let length = along.length();
        if let Some((from, to)) = bounds(image, ends.iter().copied(), reach) {
            for y in from.y..to.y {
                for x in from.x..to.x {
                    let at = vec2(x as f32 + 0.5, y as f32 + 0.5) - ends[0];
                    let share = (at.dot(along) / (length * length).max(1e-12)).clamp(0.0, 1.0);
                    let gap = pen.dash.is_some_and(|d| ((passed + share * length) / d) as i64 % 2 == 1);
                    if gap {
                        continue;
                    }
                    let ramp = (pen.radius + 0.5 - (at - along * share).length()).clamp(0.0, 1.0);
                    let value = ramp * (opacity[0] + (opacity[1] - opacity[0]) * share);
                    let cell = &mut coverage[(y - low.y) as usize * width + (x - low.x) as usize];
                    *cell = cell.max(value);
                }
            }
        }
        passed += length;
    }
    for (i, value) in coverage.into_iter().enumerate().filter(|(_, v)| *v > 0.0) {
        blend(image, low.x as u32 + (i % width) as u32, low.y as u32 + (i / width) as u32, pen.color, value);
    }
}

/// Draws a filled disc.
pub(super) fn disc(image: &mut RgbImage, center: Vec2, radius: f32, color: [u8; 3]) {
    around(image, center, radius, color, |d| radius + 0.5 - d);
}

/// Draws a circle of a pen `width` wide.
pub(super) fn ring(image: &mut RgbImage, center: Vec2, radius: f32, width: f32, color: [u8; 3]) {
    around(image, center, radius + width, color, |d| 0.5 * width + 0.5 - (d - radius).abs());
}

fn around(image: &mut RgbImage, center: Vec2, reach: f32, color: [u8; 3], ramp: impl Fn(f32) -> f32) {
    let Some((low, high)) = bounds(image, std::iter::once(center), reach + 1.0) else { return };
    for y in low.y..high.y {
        for x in low.x..high.x {
            let value = ramp(vec2(x as f32 + 0.5, y as f32 + 0.5).distance(center)).clamp(0.0, 1.0);
            blend(image, x as u32, y as u32, color, value);
        }
    }
}

/// Mixes `color` into a pixel.
#[inline]
pub(super) fn blend(image: &mut RgbImage, x: u32, y: u32, color: [u8; 3], share: f32) {
    let Rgb(pixel) = image.get_pixel_mut(x, y);
    *pixel = mix(*pixel, color, share);
}

/// `share` of `to`, the rest of `from`.
#[inline]
pub(super) fn mix(from: [u8; 3], to: [u8; 3], share: f32) -> [u8; 3] {
    std::array::from_fn(|c| {
        let (from, to) = (f32::from(from[c]), f32::from(to[c]));
        // The cast cuts off at both ends.
        (from + (to - from) * share + 0.5) as u8
    })
}

/// The pixels within `reach` of any of the points, cut to the picture; `None` where there are none.
fn bounds(image: &RgbImage, points: impl Iterator<Item = Vec2>, reach: f32) -> Option<(IVec2, IVec2)> {
    let size = vec2(image.width() as f32, image.height() as f32);
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for point in points.filter(|p| p.is_finite()) {
        low = low.min(point);
        high = high.max(point);
    }
    let (low, high) = ((low - reach).floor().max(Vec2::ZERO), (high + reach).ceil().min(size));
    low.cmplt(high).all().then(|| (low.as_ivec2(), high.as_ivec2()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Pen = Pen { color: [255; 3], radius: 1.5, dash: None };

    #[test]
    fn a_line_covers_its_area_once() {
        let mut image = RgbImage::new(60, 40);
        // Doubling back and bending must not add ink.
        let points = [vec2(10.0, 20.0), vec2(50.0, 20.0), vec2(10.0, 20.0), vec2(30.0, 20.0)];
        line(&mut image, &points, &[1.0; 4], WHITE);
        let ink: f64 = image.pixels().map(|p| f64::from(p.0[0]) / 255.0).sum();
        let expected = 40.0 * 3.0 + std::f64::consts::PI * 1.5 * 1.5;
        assert!((ink - expected).abs() < 0.03 * expected, "{ink} of {expected}");
    }

    #[test]
    fn what_lies_outside_or_nowhere_is_left_out() {
        let mut image = RgbImage::new(20, 20);
        let far = [vec2(-1e9, 5.0), vec2(-1e8, 5.0)];
        line(&mut image, &far, &[1.0; 2], WHITE);
        disc(&mut image, vec2(f32::NAN, 3.0), 4.0, [255; 3]);
        ring(&mut image, vec2(400.0, 3.0), 4.0, 1.0, [255; 3]);
        assert!(image.pixels().all(|p| p.0 == [0; 3]));
        line(&mut image, &[vec2(-30.0, 10.0), vec2(50.0, 10.0)], &[1.0; 2], WHITE);
        assert!((0..20).all(|x| image.get_pixel(x, 10).0 == [255; 3]));
    }

    #[test]
    fn dashes_leave_gaps() {
        let mut image = RgbImage::new(60, 10);
        line(&mut image, &[vec2(0.0, 5.0), vec2(60.0, 5.0)], &[1.0; 2], Pen { dash: Some(6.0), ..WHITE });
        let dark = (0..60).filter(|&x| image.get_pixel(x, 5).0[0] == 0).count();
        assert!((24..=36).contains(&dark), "{dark}");
    }
}
