//! Brightness pyramids with gradients, from half resolution down, padded so that patches may cross the border.

use crate::raster::{Grid, Planes};

/// Pixels of repeated border around every level.
pub(super) const PAD: usize = 16;
/// The coarsest level keeps at least this many pixels on its short side.
const SMALLEST: usize = 16;

/// One picture at falling resolutions, ready for [`super::FlowField::between`].
#[derive(Clone, Debug)]
pub struct Pyramid {
    /// From half resolution to the coarsest.
    pub(super) levels: Vec<Level>,
}

/// One resolution: brightness and its central differences, each `(width + 2 PAD) x (height + 2 PAD)`.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) image: Grid<f32>,
    pub(super) dx: Grid<f32>,
    pub(super) dy: Grid<f32>,
}

impl Pyramid {
    /// The pyramid of `brightness` (0..=255).
    pub fn new(brightness: &Grid<f32>) -> Self {
        let mut current = halve(brightness);
        let mut levels = Vec::new();
        loop {
            levels.push(Level::new(&current));
            if current.width().min(current.height()) < 2 * SMALLEST {
                break;
            }
            current = halve(&current);
        }
        Self { levels }
    }

    /// The pyramid of a picture's lightness, of its planes of CIE Lab.
    pub(crate) fn of(lab: &Planes) -> Self {
        let lightness = lab.channel(0);
        let bright = lightness.data().iter().map(|l| l * 255.0).collect();
        Self::new(&Grid::from_vec(lightness.width(), lightness.height(), bright))
    }
}

impl Level {
    fn new(inner: &Grid<f32>) -> Self {
        let (width, height) = (inner.width(), inner.height());
        let (w, h) = (width + 2 * PAD, height + 2 * PAD);
        let mut image = Grid::new(w, h, 0.0);
        for y in 0..h {
            let source = inner.row(y.saturating_sub(PAD).min(height - 1));
            let row = image.row_mut(y);
            row[..PAD].fill(source[0]);
            row[PAD..PAD + width].copy_from_slice(source);
            row[PAD + width..].fill(source[width - 1]);
        }
        let (mut dx, mut dy) = (Grid::new(w, h, 0.0), Grid::new(w, h, 0.0));
        for y in 0..h {
            let (here, out) = (image.row(y), dx.row_mut(y));
            for x in 1..w - 1 {
                out[x] = 0.5 * (here[x + 1] - here[x - 1]);
            }
            let (above, below) = (image.row(y.saturating_sub(1)), image.row((y + 1).min(h - 1)));
            for ((o, a), b) in dy.row_mut(y).iter_mut().zip(above).zip(below) {
                *o = 0.5 * (b - a);
            }
        }
        Self { width, height, image, dx, dy }
    }
}

/// The mean of every two by two pixels; odd last rows and columns count twice.
fn halve(fine: &Grid<f32>) -> Grid<f32> {
    let (w, h) = (fine.width().div_ceil(2), fine.height().div_ceil(2));
    let mut coarse = Grid::new(w, h, 0.0);
    for y in 0..h {
        let (top, bottom) = (fine.row(2 * y), fine.row((2 * y + 1).min(fine.height() - 1)));
        for (x, out) in coarse.row_mut(y).iter_mut().enumerate() {
            let (l, r) = (2 * x, (2 * x + 1).min(fine.width() - 1));
            *out = 0.25 * (top[l] + top[r] + bottom[l] + bottom[r]);
        }
    }
    coarse
}
