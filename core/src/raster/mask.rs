//! A binary image, one bit a pixel: a thousand masks of a full-HD clip fit in 260 MB.

use std::ops::Range;

use image::GrayImage;

/// Pixels that are in or out. Rows are padded to whole words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    width: usize,
    height: usize,
    stride: usize,
    words: Vec<u64>,
}

impl Mask {
    /// A mask with no pixel set.
    pub fn new(width: usize, height: usize) -> Self {
        let stride = width.div_ceil(64);
        Self { width, height, stride, words: vec![0; stride * height] }
    }

    /// The mask of the pixels for which `inside(x, y)` holds.
    pub fn from_fn(width: usize, height: usize, inside: impl Fn(usize, usize) -> bool) -> Self {
        let mut mask = Self::new(width, height);
        for y in 0..height {
            for x in 0..width {
                if inside(x, y) {
                    mask.set(x, y, true);
                }
            }
        }
        mask
    }

    /// The mask of the pixels above half brightness.
    pub fn from_image(image: &GrayImage) -> Self {
        Self::from_fn(image.width() as usize, image.height() as usize, |x, y| {
            image.get_pixel(x as u32, y as u32).0[0] > 127
        })
    }

    /// The mask as an image of 0 and 255.
    pub fn to_image(&self) -> GrayImage {
        GrayImage::from_fn(self.width as u32, self.height as u32, |x, y| {
            image::Luma([if self.get(x as usize, y as usize) { 255 } else { 0 }])
        })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Whether the pixel is in.
    #[inline]
    pub fn get(&self, x: usize, y: usize) -> bool {
        debug_assert!(x < self.width && y < self.height);
        self.words[y * self.stride + x / 64] >> (x % 64) & 1 == 1
    }

    /// Whether the pixel is in; a place outside the image is out.
    #[inline]
    pub fn at(&self, x: isize, y: isize) -> bool {
        x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height && self.get(x as usize, y as usize)
    }

    /// Puts the pixel in or out.
    #[inline]
    pub fn set(&mut self, x: usize, y: usize, inside: bool) {
        debug_assert!(x < self.width && y < self.height);
        let word = &mut self.words[y * self.stride + x / 64];
        let bit = 1 << (x % 64);
        if inside { *word |= bit } else { *word &= !bit }
    }

    /// Puts the pixels of `columns`, which lie within the width, in row `y` in.
    #[inline]
    pub(crate) fn fill(&mut self, y: usize, columns: Range<usize>) {
        debug_assert!(y < self.height && columns.end <= self.width);
        let row = &mut self.words[y * self.stride..(y + 1) * self.stride];
        let mut x = columns.start;
        while x < columns.end {
            let end = columns.end.min((x / 64 + 1) * 64);
            row[x / 64] |= (u64::MAX >> (64 - (end - x))) << (x % 64);
            x = end;
        }
    }

    /// How many pixels are in.
    pub fn count(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// Takes out every pixel that is not in `other`, a mask of the same size.
    pub fn intersect(&mut self, other: &Self) {
        self.words.iter_mut().zip(&other.words).for_each(|(a, b)| *a &= b);
    }

    /// Intersection over union with a mask of the same size; 1 when both are empty.
    pub fn iou(&self, other: &Self) -> f64 {
        let (mut both, mut any) = (0u64, 0u64);
        for (a, b) in self.words.iter().zip(&other.words) {
            both += u64::from((a & b).count_ones());
            any += u64::from((a | b).count_ones());
        }
        if any == 0 { 1.0 } else { both as f64 / any as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filled_run_is_what_setting_each_pixel_makes() {
        for (from, to) in [(0, 0), (0, 1), (3, 60), (0, 64), (63, 65), (60, 200), (64, 128), (199, 200)] {
            let mut filled = Mask::new(200, 3);
            filled.fill(1, from..to);
            assert_eq!(filled, Mask::from_fn(200, 3, |x, y| y == 1 && (from..to).contains(&x)), "{from}..{to}");
        }
    }

    #[test]
    fn image_round_trip_keeps_every_pixel() {
        let mask = Mask::from_fn(131, 7, |x, y| (x * 7 + y * 3) % 5 < 2);
        assert_eq!(Mask::from_image(&mask.to_image()), mask);
        assert_eq!(mask.iou(&mask), 1.0);
        assert!(!mask.at(-1, 0) && !mask.at(131, 0));
    }
}
