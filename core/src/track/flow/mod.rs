//! Dense optical flow between two pictures of one size.
//!
//! Inverse search over patches from coarse to fine, then a few sweeps of variational refinement at every level
//! (Kroeger, Timofte, Dai, Van Gool 2016, "Fast Optical Flow using Dense Inverse Search"). The finest level is half
//! the picture's resolution; places between are interpolated. Fields are kept as 16-bit fixed point, 1 byte a pixel.
//!
//! Limits: brightness changes are followed only where they are locally even; a thing that moves farther than its own
//! width between frames has vanished at the level that could follow it, and takes the motion of what is behind it.

mod inverse_search;
mod pyramid;
mod variational;

pub use pyramid::Pyramid;

use glam::Vec2;

use crate::raster::Grid;

/// Fixed-point steps for one pixel of the picture.
const STEPS: f32 = 16.0;
/// Picture pixels for one cell of a field.
const CELL: f32 = 2.0;

/// Where every place of a first picture went in a second.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowField {
    cells: Grid<[i16; 2]>,
}

impl FlowField {
    /// The flow from `from` to `to`, pyramids of two pictures of one size.
    pub fn between(from: &Pyramid, to: &Pyramid) -> Self {
        let mut flow: Option<Grid<Vec2>> = None;
        for level in (0..from.levels.len().min(to.levels.len())).rev() {
            let (a, b) = (&from.levels[level], &to.levels[level]);
            let start = match &flow {
                Some(coarse) => enlarge(coarse, a.width, a.height),
                None => Grid::new(a.width, a.height, Vec2::ZERO),
            };
            let mut found = inverse_search::search(a, b, &start);
            variational::refine(a, b, &mut found);
            flow = Some(found);
        }
        Self::packed(&flow.unwrap_or_else(|| Grid::new(1, 1, Vec2::ZERO)))
    }

    /// From motions in cells, one a cell.
    fn packed(flow: &Grid<Vec2>) -> Self {
        // Rounded; the cast keeps within the range.
        let fixed = |v: f32| (v * (CELL * STEPS) + 0.5f32.copysign(v)) as i16;
        let cells = flow.data().iter().map(|v| [fixed(v.x), fixed(v.y)]).collect();
        Self { cells: Grid::from_vec(flow.width(), flow.height(), cells) }
    }

    /// The field that `motion` (picture pixels) gives over a picture of this size.
    #[cfg(test)]
    pub(crate) fn from_fn(width: usize, height: usize, motion: impl Fn(Vec2) -> Vec2) -> Self {
        let (w, h) = (width / CELL as usize, height / CELL as usize);
        let cells = (0..w * h).map(|i| {
            let centre = Vec2::new((i % w) as f32 + 0.5, (i / w) as f32 + 0.5) * CELL;
            motion(centre) / CELL
        });
        Self::packed(&Grid::from_vec(w, h, cells.collect()))
    }

    /// Width and height of the pictures, to a cell.
    pub(crate) fn size(&self) -> Vec2 {
        Vec2::new(self.cells.width() as f32, self.cells.height() as f32) * CELL
    }

    /// How far the place `p` (picture pixels) moves. Places outside take the border's motion.
    #[inline]
    pub fn at(&self, p: Vec2) -> Vec2 {
        let (w, h) = (self.cells.width(), self.cells.height());
        let x = (p.x / CELL - 0.5).clamp(0.0, (w - 1) as f32);
        let y = (p.y / CELL - 0.5).clamp(0.0, (h - 1) as f32);
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(w - 1), (y0 + 1).min(h - 1));
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let cell = |x, y| {
            let c: [i16; 2] = self.cells.get(x, y);
            Vec2::new(f32::from(c[0]), f32::from(c[1]))
        };
        let top = cell(x0, y0).lerp(cell(x1, y0), fx);
        let bottom = cell(x0, y1).lerp(cell(x1, y1), fx);
        top.lerp(bottom, fy) / STEPS
    }

    /// How far `p` misses itself after going along this field and back along `back`, in picture pixels.
    #[inline]
    pub fn disagreement(&self, back: &Self, p: Vec2) -> f32 {
        let there = self.at(p);
        (there + back.at(p + there)).length()
    }
}

/// A flow at twice the resolution (or nearly: odd sizes), in the finer level's pixels.
fn enlarge(coarse: &Grid<Vec2>, width: usize, height: usize) -> Grid<Vec2> {
    let (cw, ch) = (coarse.width(), coarse.height());
    let (sx, sy) = (cw as f32 / width as f32, ch as f32 / height as f32);
    let grow = Vec2::new(1.0 / sx, 1.0 / sy);
    let mut fine = Grid::new(width, height, Vec2::ZERO);
    for y in 0..height {
        let v = ((y as f32 + 0.5) * sy - 0.5).clamp(0.0, (ch - 1) as f32);
        let (y0, fy) = (v as usize, v.fract());
        let (top, bottom) = (coarse.row(y0), coarse.row((y0 + 1).min(ch - 1)));
        for (x, out) in fine.row_mut(y).iter_mut().enumerate() {
            let u = ((x as f32 + 0.5) * sx - 0.5).clamp(0.0, (cw - 1) as f32);
            let (x0, fx) = (u as usize, u.fract());
            let x1 = (x0 + 1).min(cw - 1);
            *out = top[x0].lerp(top[x1], fx).lerp(bottom[x0].lerp(bottom[x1], fx), fy) * grow;
        }
    }
    fine
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A smooth pattern without repetition at the scale of the motion, sampled at `map(x, y)`.
    fn picture(width: usize, height: usize, map: impl Fn(Vec2) -> Vec2) -> Grid<f32> {
        let mut grid = Grid::new(width, height, 0.0);
        for y in 0..height {
            for x in 0..width {
                let p = map(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
                let wave = |a: f32, b: f32, c: f32| (p.x * a + p.y * b + c).sin();
                let v = wave(0.11, 0.07, 0.0) + wave(-0.05, 0.13, 1.0) + wave(0.31, -0.21, 2.0) + wave(0.03, 0.29, 0.5);
                grid.set(x, y, 128.0 + 28.0 * v);
            }
        }
        grid
    }

    #[test]
    fn follows_a_shift_and_a_turn_to_a_fraction_of_a_pixel() {
        let (w, h) = (200, 150);
        let centre = Vec2::new(100.0, 75.0);
        for (turn, shift) in [(0.0f32, Vec2::new(6.3, -3.6)), (0.06, Vec2::new(-2.0, 1.0))] {
            let rotation = Vec2::from_angle(turn);
            let moved = |p: Vec2| centre + rotation.rotate(p - centre) + shift;
            let unmoved = |q: Vec2| centre + Vec2::from_angle(-turn).rotate(q - centre - shift);
            let a = Pyramid::new(&picture(w, h, |p| p));
            let b = Pyramid::new(&picture(w, h, unmoved));
            let (there, back) = (FlowField::between(&a, &b), FlowField::between(&b, &a));
            let (mut worst, mut sum, mut n) = (0.0f32, 0.0, 0.0);
            for y in (20..130).step_by(5) {
                for x in (20..180).step_by(5) {
                    let p = Vec2::new(x as f32, y as f32);
                    let error = (p + there.at(p)).distance(moved(p));
                    worst = worst.max(error);
                    sum += error;
                    n += 1.0;
                }
            }
            assert!(sum / n < 0.15 && worst < 1.0, "turn {turn}: mean {}, worst {worst}", sum / n);
            assert!(there.disagreement(&back, centre) < 0.3);
        }
    }

    #[test]
    fn tiny_and_flat_pictures_stay_put() {
        for (w, h) in [(1, 1), (2, 9), (40, 3), (64, 64)] {
            let flat = Pyramid::new(&Grid::new(w, h, 77.0));
            let field = FlowField::between(&flat, &flat);
            assert!(field.at(Vec2::new(w as f32, h as f32) / 2.0).length() < 1e-3);
        }
    }
}
