//! A drawing as a file: its picture with straight alpha, and a mask that cuts it out.

use std::io::BufReader;
use std::path::Path;

use image::{GrayImage, ImageDecoder, ImageReader, RgbaImage};

use super::MOST_PIXELS;
use crate::error::{Error, Result};

/// Reads a picture (PNG, JPEG, WebP or GIF), turned as the camera says.
///
/// # Errors
/// A file that cannot be read, is no picture, or is larger than a character may be.
pub fn read_drawing(path: impl AsRef<Path>) -> Result<RgbaImage> {
    let path = path.as_ref();
    let bad = |problem: String| Error::file(path, problem, "expected a picture such as a PNG");
    let file = std::fs::File::open(path).map_err(|e| Error::io(path, "read", e))?;
    let reader =
        ImageReader::new(BufReader::new(file)).with_guessed_format().map_err(|e| Error::io(path, "read", e))?;
    let mut decoder = reader.into_decoder().map_err(|e| bad(format!("is no picture: {e}")))?;
    let (width, height) = decoder.dimensions();
    let value = u64::from(width) * u64::from(height);
    if value > MOST_PIXELS {
        let what = format!("{}: the picture's pixel count", path.display());
        return Err(Error::Limit { what, value, max: MOST_PIXELS, remedy: "scale it down".into() });
    }
    let orientation = decoder.orientation().map_err(|e| bad(format!("is damaged: {e}")))?;
    let mut limits = image::Limits::default();
    // Sixteen bytes a pixel: four channels of 32 bits.
    limits.max_alloc = Some(16 * MOST_PIXELS);
    decoder.set_limits(limits).map_err(|e| bad(e.to_string()))?;
    let mut image = image::DynamicImage::from_decoder(decoder).map_err(|e| bad(format!("is damaged: {e}")))?;
    image.apply_orientation(orientation);
    Ok(image.into_rgba8())
}

/// Reads a mask of a drawing: bright is the drawing; of a picture with clear pixels, what is opaque and bright.
///
/// # Errors
/// As for [`read_drawing`].
pub fn read_cut(path: impl AsRef<Path>) -> Result<GrayImage> {
    let picture = read_drawing(path)?;
    let grey = |x, y| {
        let [r, g, b, a] = picture.get_pixel(x, y).0.map(u32::from);
        image::Luma([(r.max(g).max(b) * a / 255) as u8])
    };
    Ok(GrayImage::from_fn(picture.width(), picture.height(), grey))
}

/// Makes clear what the mask leaves out.
///
/// # Errors
/// A mask of another size than the picture.
pub fn apply_mask(picture: &mut RgbaImage, mask: &GrayImage) -> Result<()> {
    if picture.dimensions() != mask.dimensions() {
        let ((w, h), (mw, mh)) = (picture.dimensions(), mask.dimensions());
        let problem = format!("is of {mw}x{mh} pixels, and the picture of {w}x{h}");
        return Err(Error::invalid("mask", problem, "give a mask of the picture's size"));
    }
    for (pixel, mask) in picture.pixels_mut().zip(mask.pixels()) {
        pixel.0[3] = (u32::from(pixel.0[3]) * u32::from(mask.0[0]) / 255) as u8;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_cuts_and_what_is_no_picture_is_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        RgbaImage::from_pixel(4, 3, image::Rgba([9, 8, 7, 255])).save(path("a.png")).expect("written");
        GrayImage::from_fn(4, 3, |x, _| image::Luma([if x < 2 { 255 } else { 0 }]))
            .save(path("m.png"))
            .expect("written");
        let mut picture = read_drawing(path("a.png")).expect("a picture");
        apply_mask(&mut picture, &read_cut(path("m.png")).expect("a mask")).expect("of one size");
        assert_eq!((picture.get_pixel(1, 0).0, picture.get_pixel(2, 0).0), ([9, 8, 7, 255], [9, 8, 7, 0]));
        let error = apply_mask(&mut picture, &GrayImage::new(4, 4)).expect_err("another size").to_string();
        assert!(error.contains("4x4") && error.contains("4x3"), "{error}");
        let bytes = std::fs::read(path("a.png")).expect("read");
        std::fs::write(path("cut.png"), &bytes[..bytes.len() / 2]).expect("written");
        std::fs::write(path("text.png"), "hello").expect("written");
        for name in ["cut.png", "text.png", "none.png"] {
            let error = read_drawing(path(name)).expect_err(name).to_string();
            assert!(error.contains(name), "{error}");
        }
    }
}
