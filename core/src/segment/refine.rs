//! From a small mask to crisp edges at the clip's size.

use image::RgbImage;

use crate::raster::Mask;

/// The mask at the picture's size.
pub(super) fn refine(picture: &RgbImage, small: &Mask) -> Mask {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    Mask::from_fn(width, height, |x, y| small.get(x * small.width() / width, y * small.height() / height))
}
