//! A character's rig over its picture: the mesh with each bone's region in a colour, bones, and joints.

use glam::Vec2;
use image::{Rgb, RgbImage, RgbaImage};

use super::canvas::{Pen, disc, line, ring};
use super::png::encode_rgb;
use crate::error::{Error, Result};
use crate::shape::character::Character;

/// Pictures are shown this large at least, where they can be enlarged evenly, and at most.
const LEAST: u32 = 600;
const MOST: u32 = 2400;
/// Colours that are told apart on a light ground, by hue; neighbours in the skeleton get ones far apart.
const COLOURS: [[u8; 3]; 8] = [
    [214, 39, 40],
    [31, 119, 180],
    [44, 160, 44],
    [148, 103, 189],
    [255, 127, 14],
    [23, 160, 170],
    [188, 110, 34],
    [200, 60, 150],
];

/// The preview as the bytes of a PNG.
///
/// # Errors
/// A picture of another size than the character's.
pub fn rig_preview(character: &Character, picture: &RgbaImage) -> Result<Vec<u8>> {
    if picture.dimensions() != character.size {
        return Err(Error::invalid("picture", "is not of the character's size", "give the one that it was made of"));
    }
    let (width, height) = character.size;
    let largest = width.max(height).max(1);
    let scale = if largest < LEAST {
        f64::from(LEAST.div_ceil(largest))
    } else {
        f64::from(MOST.min(largest)) / f64::from(largest)
    };
    let size = |n: u32| ((f64::from(n) * scale).round() as u32).max(1);
    // Half as strong as it is, so that the rig is seen over it.
    let mut image = RgbImage::from_fn(size(width), size(height), |x, y| {
        let from = |n: u32, most: u32| ((f64::from(n) + 0.5) / scale) as u32 % most.max(1);
        let [r, g, b, a] = picture.get_pixel(from(x, width), from(y, height)).0;
        let faint = |c: u8| 255 - (255 - u32::from(c)) * u32::from(a) / 510;
        Rgb([r, g, b].map(|c| faint(c) as u8))
    });
    let scale = scale as f32;
    let at = |v: u32| character.mesh.points[v as usize] * scale;
    let colour = |bone: u32| COLOURS[bone as usize % COLOURS.len()];
    for triangle in &character.mesh.triangles {
        for (&a, &b) in triangle.iter().zip(triangle.iter().cycle().skip(1)) {
            // Every inner edge is drawn from one of its two sides.
            let bone = character.regions.bone.get(a as usize).copied().unwrap_or(0);
            if a < b {
                let pen = Pen { color: colour(bone), radius: 0.4, dash: None };
                line(&mut image, &[at(a), at(b)], &[0.7; 2], pen);
            }
        }
    }
    let thick = (size(largest) as f32 / 300.0).max(1.5);
    let joints: Vec<Vec2> = character.skeleton.joints.iter().map(|j| j.at * scale).collect();
    for (bone, &[from, to]) in character.skeleton.bones.iter().enumerate() {
        let ends = [joints[from], joints[to]];
        line(&mut image, &ends, &[1.0; 2], Pen { color: [20; 3], radius: 1.6 * thick, dash: None });
        line(&mut image, &ends, &[1.0; 2], Pen { color: colour(bone as u32), radius: thick, dash: None });
    }
    let roots = character.skeleton.roots();
    for (j, at) in joints.iter().enumerate() {
        disc(&mut image, *at, 2.6 * thick, [20; 3]);
        disc(&mut image, *at, 1.8 * thick, [255; 3]);
        if roots.contains(&j) {
            ring(&mut image, *at, 4.5 * thick, thick, [20; 3]);
        }
    }
    encode_rgb(&image)
}
