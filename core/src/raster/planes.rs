//! A colour image as three float planes, the layout that patch comparison and filters run through fastest.

use image::RgbImage;

use super::{Grid, lab, pyramid};

/// Three grids of one size, one for each colour channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Planes {
    channels: [Grid<f32>; 3],
}

impl Planes {
    /// CIE L*a*b* (D65) divided by 100: lightness in 0..=1, colour in about -1..=1.
    pub fn lab(image: &RgbImage) -> Self {
        Self { channels: lab::planes(image) }
    }

    /// sRGB as it is stored, in 0..=1.
    pub fn rgb(image: &RgbImage) -> Self {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let channel = |c: usize| {
            let values = image.as_raw().chunks_exact(3).map(|p| f32::from(p[c]) / 255.0).collect();
            Grid::from_vec(width, height, values)
        };
        Self { channels: [channel(0), channel(1), channel(2)] }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.channels[0].width()
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.channels[0].height()
    }

    /// One of the three channels.
    pub fn channel(&self, c: usize) -> &Grid<f32> {
        &self.channels[c]
    }

    /// The three channels.
    pub(crate) fn into_channels(self) -> [Grid<f32>; 3] {
        self.channels
    }

    /// Half the size: a place `p` of this image lies at `p / 2`.
    pub fn halved(&self) -> Self {
        Self { channels: std::array::from_fn(|c| pyramid::halved(&self.channels[c])) }
    }

    /// The rectangle of `width` x `height` pixels from column and row `origin`; where it leaves the image, the image's
    /// border repeated.
    pub fn crop(&self, origin: (isize, isize), width: usize, height: usize) -> Self {
        let cut = |grid: &Grid<f32>| {
            let at = |i: usize| grid.clamped(origin.0 + (i % width) as isize, origin.1 + (i / width) as isize);
            Grid::from_vec(width, height, (0..width * height).map(at).collect())
        };
        Self { channels: std::array::from_fn(|c| cut(&self.channels[c])) }
    }

    /// The colour at a place in pixels, bilinear, the nearest one inside for places outside.
    #[inline]
    pub fn at(&self, p: glam::Vec2) -> [f32; 3] {
        let corner = super::sample::Corner::new(p, self.width(), self.height());
        std::array::from_fn(|c| corner.read(&self.channels[c]))
    }
}
