//! Pictures as PNG bytes: fast rather than smallest, but for those with alpha, which are textures and frames that travel.

use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, RgbImage, RgbaImage};

use super::write_aside::write_aside;
use crate::error::{Error, Result};
use crate::raster::Mask;

/// An sRGB picture.
pub(super) fn encode_rgb(image: &RgbImage) -> Result<Vec<u8>> {
    encode(image.as_raw(), image.dimensions(), ExtendedColorType::Rgb8, FilterType::Adaptive, CompressionType::Fast)
}

/// An sRGB picture with straight alpha.
pub(super) fn encode_rgba(image: &RgbaImage) -> Result<Vec<u8>> {
    encode(image.as_raw(), image.dimensions(), ExtendedColorType::Rgba8, FilterType::Adaptive, CompressionType::Default)
}

/// Writes a picture with straight alpha as PNG, whole or not at all.
///
/// # Errors
/// A file that cannot be written, a picture without pixels.
pub fn write_picture(path: &Path, picture: &RgbaImage) -> Result<()> {
    write_aside(path, &encode_rgba(picture)?)
}

/// A mask as 8-bit grey, 0 or 255.
pub fn encode_mask(mask: &Mask) -> Result<Vec<u8>> {
    let image = mask.to_image();
    encode(image.as_raw(), image.dimensions(), ExtendedColorType::L8, FilterType::NoFilter, CompressionType::Fast)
}

fn encode(
    pixels: &[u8],
    (width, height): (u32, u32),
    color: ExtendedColorType,
    filter: FilterType,
    compression: CompressionType,
) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, compression, filter).write_image(pixels, width, height, color).map_err(
        |e| Error::invalid(format!("a picture of {width}x{height}"), e.to_string(), "expected pixels to write"),
    )?;
    Ok(bytes)
}
