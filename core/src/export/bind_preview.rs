//! A picture that shows what holds a drawing: its tracked points by number, beside the clip's frame with the same numbers.

use glam::{Vec2, vec2};
use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};

use super::canvas::{Pen, disc, line};
use super::png::encode_rgb;
use crate::clip::Clip;
use crate::error::Result;
use crate::motion::Motion;
use crate::shape::sketch::{Binding, Drawing, SketchCanvas, SketchTake, draw_sketch};

/// The height of the picture, in pixels: numbers can be read, and it fits beside an editor.
const HEIGHT: f64 = 640.0;
/// Radius of a mark and height of a digit, in pixels.
const RADIUS: f32 = 5.0;
const DIGIT: f32 = 11.0;
/// Segments of a digit from the top clockwise, the middle one last, as two corners each on a grid 1 wide and 2 high.
const SEGMENTS: [[f32; 4]; 7] = [
    [0.0, 0.0, 1.0, 0.0],
    [1.0, 0.0, 1.0, 1.0],
    [1.0, 1.0, 1.0, 2.0],
    [1.0, 2.0, 0.0, 2.0],
    [0.0, 2.0, 0.0, 1.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 1.0, 1.0, 1.0],
];
/// Which segments each digit has, the top one in the lowest bit.
const DIGITS: [u8; 10] = [0x3f, 0x06, 0x5b, 0x4f, 0x66, 0x6d, 0x7d, 0x07, 0x7f, 0x6f];

/// The picture as PNG: the drawing, and left of it, where a clip is given, the frame in which the binding's first motion is at
/// rest. Pins have no number.
///
/// # Errors
/// A frame that cannot be read, a page that cannot be drawn.
pub fn bind_preview(drawing: &Drawing, binding: &Binding, motion: &Motion, clip: Option<&Clip>) -> Result<Vec<u8>> {
    let scale = HEIGHT / drawing.size.1;
    let canvas = SketchCanvas::page(drawing, scale)?;
    let drawn = draw_sketch(drawing, &SketchTake::still(drawing), 0, &canvas);
    let mut right = RgbImage::from_fn(drawn.width(), drawn.height(), |x, y| {
        let [r, g, b, a] = drawn.get_pixel(x, y).0;
        on_white([r, g, b], a.into())
    });
    for (i, point) in binding.points.iter().enumerate() {
        mark(&mut right, point.at * scale as f32, Some(i));
    }
    for pin in &binding.pins {
        mark(&mut right, pin.at * scale as f32, None);
    }
    let Some(clip) = clip else { return encode_rgb(&right) };
    let frame = binding.motions.first().map_or(0, |m| m.frame).min(clip.info().frames.saturating_sub(1));
    let picture = clip.frame(frame)?;
    let (width, height) = picture.rgb.dimensions();
    // What is clear is white, as the page beside it.
    let shown = RgbImage::from_fn(width, height, |x, y| {
        let a = picture.alpha.as_ref().map_or(255, |alpha| u32::from(alpha.get_pixel(x, y).0[0]));
        on_white(picture.rgb.get_pixel(x, y).0, a)
    });
    let shrink = f64::from(right.height()) / f64::from(height.max(1));
    let width = ((f64::from(width) * shrink).round() as u32).max(1);
    let mut both = RgbImage::new(width + right.width(), right.height());
    imageops::replace(&mut both, &imageops::resize(&shown, width, right.height(), FilterType::Triangle), 0, 0);
    for (i, point) in binding.points.iter().enumerate() {
        let tracked = motion.track(&point.track).and_then(|t| t.frames.get(frame)?.points.get(point.index).copied());
        if let Some(at) = tracked {
            mark(&mut both, at * shrink as f32, Some(i));
        }
    }
    imageops::replace(&mut both, &right, i64::from(width), 0);
    encode_rgb(&both)
}

fn on_white(color: [u8; 3], opacity: u32) -> Rgb<u8> {
    Rgb(color.map(|c| ((u32::from(c) * opacity + 255 * (255 - opacity)) / 255) as u8))
}

/// A colour of its own for every number, far from its neighbours'.
fn colour(number: usize) -> [u8; 3] {
    // Steps of the golden ratio around the colour circle.
    let hue = (number as f32 * 0.618_034).fract() * 6.0;
    let part = |shift: f32, most: f32| (((hue + shift).rem_euclid(6.0) - 3.0).abs().clamp(1.0, 2.0) - 1.0) * most;
    [part(0.0, 215.0), part(4.0, 190.0), part(2.0, 240.0)].map(|c| c as u8)
}

/// A dot with a number beside it, on a white rim.
fn mark(picture: &mut RgbImage, at: Vec2, number: Option<usize>) {
    let label = number.map(|n| (n + 1).to_string()).unwrap_or_default();
    for (color, rim) in [([255; 3], 1.6), (number.map_or([20; 3], colour), 0.0)] {
        disc(picture, at, RADIUS + rim, color);
        let pen = Pen { color, radius: 1.0 + rim, dash: None };
        for (i, digit) in label.bytes().enumerate() {
            let corner = at + vec2(1.6 * RADIUS + 0.85 * DIGIT * i as f32, -1.6 * RADIUS - DIGIT);
            for (s, [x0, y0, x1, y1]) in SEGMENTS.into_iter().enumerate() {
                if DIGITS[usize::from(digit - b'0')] & 1 << s != 0 {
                    let ends = [vec2(x0, y0), vec2(x1, y1)].map(|p| corner + 0.5 * DIGIT * p);
                    line(picture, &ends, &[1.0; 2], pen);
                }
            }
        }
    }
}
