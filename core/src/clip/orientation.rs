//! The eight ways in which a camera can have been held.
//!
//! A recording made with the phone upright is stored lying, with a matrix in the track header (ISO/IEC 14496-12,
//! 8.3.2) that turns it on display.

use image::{ImageBuffer, Pixel, imageops};

/// What has to be done to the stored picture: a mirroring left to right first, then quarter turns clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Orientation {
    pub(super) mirrored: bool,
    pub(super) quarter_turns: u8,
}

impl Orientation {
    /// From the linear part of a display matrix that takes a stored (x, y), y down, to (a x + c y, b x + d y).
    /// [`None`] for a matrix that does more than turning and mirroring.
    pub(super) fn from_matrix([a, b, c, d]: [i32; 4]) -> Option<Self> {
        let signs = [a.signum(), b.signum(), c.signum(), d.signum()];
        let turned = |quarter_turns| Some(Self { mirrored: false, quarter_turns });
        let mirrored = |quarter_turns| Some(Self { mirrored: true, quarter_turns });
        match signs {
            [1, 0, 0, 1] => turned(0),
            [0, 1, -1, 0] => turned(1),
            [-1, 0, 0, -1] => turned(2),
            [0, -1, 1, 0] => turned(3),
            [-1, 0, 0, 1] => mirrored(0),
            [0, -1, -1, 0] => mirrored(1),
            [1, 0, 0, -1] => mirrored(2),
            [0, 1, 1, 0] => mirrored(3),
            _ => None,
        }
    }

    /// The size on display of a picture stored as `size`.
    pub(super) fn size(self, (width, height): (u32, u32)) -> (u32, u32) {
        if self.quarter_turns % 2 == 1 { (height, width) } else { (width, height) }
    }

    pub(super) fn apply<P: Pixel + 'static>(
        self,
        image: ImageBuffer<P, Vec<P::Subpixel>>,
    ) -> ImageBuffer<P, Vec<P::Subpixel>> {
        let mut image = image;
        if self.mirrored {
            imageops::flip_horizontal_in_place(&mut image);
        }
        match self.quarter_turns % 4 {
            1 => imageops::rotate90(&image),
            2 => {
                imageops::rotate180_in_place(&mut image);
                image
            }
            3 => imageops::rotate270(&image),
            _ => image,
        }
    }
}

#[cfg(test)]
mod tests {
    use image::{GrayImage, Luma};

    use super::*;

    #[test]
    fn every_matrix_moves_pixels_as_it_says() {
        let (w, h) = (3i32, 2i32);
        let stored = GrayImage::from_fn(w as u32, h as u32, |x, y| Luma([(y * 3 + x) as u8]));
        for [a, b, c, d] in [
            [1, 0, 0, 1],
            [0, 1, -1, 0],
            [-1, 0, 0, -1],
            [0, -1, 1, 0],
            [-1, 0, 0, 1],
            [1, 0, 0, -1],
            [0, -1, -1, 0],
            [0, 1, 1, 0],
        ] {
            let way = Orientation::from_matrix([a, b, c, d].map(|v| v * 65536)).expect("one of the eight");
            let shown = way.apply(stored.clone());
            assert_eq!(shown.dimensions(), way.size((w as u32, h as u32)));
            for y in 0..h {
                for x in 0..w {
                    // The matrix turns about the corner; pixels that leave come back in by a shift.
                    let (mut sx, mut sy) = (a * x + c * y, b * x + d * y);
                    if a + c < 0 {
                        sx += shown.width() as i32 - 1;
                    }
                    if b + d < 0 {
                        sy += shown.height() as i32 - 1;
                    }
                    assert_eq!(
                        shown.get_pixel(sx as u32, sy as u32),
                        stored.get_pixel(x as u32, y as u32),
                        "matrix {:?} at {x}, {y}",
                        [a, b, c, d]
                    );
                }
            }
        }
        assert_eq!(Orientation::from_matrix([65536, 20000, -20000, 65536]), None);
    }
}
