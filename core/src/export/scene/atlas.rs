//! The picture of a scene as a texture, and the files that say what is where on it: one region, the whole picture.

use image::RgbaImage;

use super::super::png;
use crate::error::Result;
use crate::export::take::TakeSubject;

/// Alphas between these are neither clear nor opaque, and this share of such pixels away from rims makes a drawing of glass.
const GLASS: std::ops::RangeInclusive<u8> = 26..=230;
const MOST_GLASS: usize = 100;

/// The picture as a PNG.
pub(super) fn texture(subject: TakeSubject<'_>) -> Result<Vec<u8>> {
    png::encode_rgba(subject.picture)
}

/// Spine's atlas text: the page, its size and how it is sampled, and the region.
pub(super) fn spine_atlas(page: &str, region: &str, (width, height): (u32, u32)) -> String {
    format!("{page}\nsize:{width},{height}\nfilter:Linear,Linear\n{region}\nbounds:0,0,{width},{height}\n")
}

/// DragonBones' atlas JSON.
pub(super) fn dragonbones_atlas(
    name: &str,
    page: &str,
    region: &str,
    (width, height): (u32, u32),
) -> serde_json::Value {
    serde_json::json!({
        "name": name, "imagePath": page, "width": width, "height": height,
        "SubTexture": [{ "name": region, "x": 0, "y": 0, "width": width, "height": height }],
    })
}

/// Whether more than a rim of the picture is half clear.
pub(super) fn is_glass(picture: &RgbaImage) -> bool {
    let (width, height) = picture.dimensions();
    let half = |x: u32, y: u32| GLASS.contains(&picture.get_pixel(x, y).0[3]);
    let (mut glass, mut shown) = (0, 0);
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            shown += usize::from(picture.get_pixel(x, y).0[3] > 0);
            glass += usize::from(half(x, y) && (y - 1..=y + 1).all(|y| (x - 1..=x + 1).all(|x| half(x, y))));
        }
    }
    glass * MOST_GLASS > shown
}
