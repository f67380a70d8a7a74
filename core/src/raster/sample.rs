//! Reading grids between pixels. The centre of the top-left pixel is (0.5, 0.5).

use glam::Vec2;

use super::Grid;

/// The four pixels around a place and their bilinear weights, shared by all grids of one size.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    index: [usize; 4],
    weight: [f32; 4],
}

impl Corner {
    /// Around `p` in a grid of `width` x `height` pixels, neither of them 0. A place outside gives the nearest
    /// inside, a place that is no number gives the top-left pixel.
    #[inline]
    pub fn new(p: Vec2, width: usize, height: usize) -> Self {
        let axis = |v: f32, n: usize| {
            let v = (v - 0.5).max(0.0).min((n - 1) as f32);
            let low = v as usize;
            (low, (low + 1).min(n - 1), v - low as f32)
        };
        let (x0, x1, fx) = axis(p.x, width);
        let (y0, y1, fy) = axis(p.y, height);
        Self {
            index: [y0 * width + x0, y0 * width + x1, y1 * width + x0, y1 * width + x1],
            weight: [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy],
        }
    }

    /// The value there.
    #[inline]
    pub fn read(&self, grid: &Grid<f32>) -> f32 {
        let d = grid.data();
        self.weight[0] * d[self.index[0]]
            + self.weight[1] * d[self.index[1]]
            + self.weight[2] * d[self.index[2]]
            + self.weight[3] * d[self.index[3]]
    }
}

/// The bilinear value of a grid that is not empty at a place in pixels; outside, the nearest inside.
#[inline]
pub fn bilinear(grid: &Grid<f32>, p: Vec2) -> f32 {
    Corner::new(p, grid.width(), grid.height()).read(grid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn a_plane_is_read_exactly_and_outside_is_the_border() {
        let data = (0..6 * 5).map(|i| (i % 6) as f32 * 2.0 + (i / 6) as f32 * 3.0).collect();
        let grid = Grid::from_vec(6, 5, data);
        for (x, y) in [(0.5, 0.5), (2.25, 3.0), (5.5, 4.5), (3.9, 1.1)] {
            assert!((bilinear(&grid, vec2(x, y)) - ((x - 0.5) * 2.0 + (y - 0.5) * 3.0)).abs() < 1e-5);
        }
        assert_eq!(bilinear(&grid, vec2(-90.0, 1e9)), grid.get(0, 4));
        assert_eq!(bilinear(&grid, vec2(f32::NAN, f32::INFINITY)), grid.get(0, 4));
    }
}
