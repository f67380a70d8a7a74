//! Which pixels a triangle covers, decided in whole numbers.
//!
//! Corners are snapped to 1/256 pixel and pixels on a left or top edge belong to the triangle, so that triangles which
//! share an edge cover every pixel along it exactly once and results are the same on every machine. Method: edge
//! functions, Pineda, "A Parallel Algorithm for Polygon Rasterization", 1988, solved for each row's first and last pixel.

use std::ops::Range;

use glam::Vec2;

/// Sub-pixel steps of snapped corners.
const STEP: i64 = 256;
/// Places farther from the picture than this many pixels are not drawn: products of snapped places stay exact.
const FAR_OUTSIDE: f32 = 1e6;

/// The pixels of one triangle in a picture.
#[derive(Clone, Debug)]
pub struct Cover {
    /// The corners as they go around from x to y: indices into those that were given.
    pub order: [usize; 3],
    /// Twice the area; what the three edge values of a pixel add up to.
    pub area: i64,
    /// What each edge value changes by a pixel to the right.
    pub right: [i64; 3],
    down: [i64; 3],
    /// The edge values at the centre of pixel (0, 0).
    origin: [i64; 3],
    bias: [i64; 3],
    columns: Range<i64>,
    rows: Range<i64>,
}

impl Cover {
    /// Of the triangle with corners `at` in a picture of `width` columns with these `rows`; `None` where it has no area
    /// or lies far outside.
    pub fn new(at: [Vec2; 3], width: usize, rows: Range<usize>) -> Option<Self> {
        // Written so that what is no number is far outside.
        if !at.iter().all(|p| p.x.abs() <= FAR_OUTSIDE && p.y.abs() <= FAR_OUTSIDE) {
            return None;
        }
        let snap = |v: f32| (v * STEP as f32).round() as i64;
        let mut p = at.map(|p| [snap(p.x), snap(p.y)]);
        let mut order = [0, 1, 2];
        let edge =
            |a: [i64; 2], b: [i64; 2], c: [i64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let mut area = edge(p[0], p[1], p[2]);
        if area == 0 {
            return None;
        }
        if area < 0 {
            p.swap(1, 2);
            order.swap(1, 2);
            area = -area;
        }
        let bound = |axis: usize, range: Range<usize>| {
            let least = p.iter().map(|q| q[axis]).min().unwrap_or(0);
            let most = p.iter().map(|q| q[axis]).max().unwrap_or(0);
            least.div_euclid(STEP).max(range.start as i64)..(most.div_euclid(STEP) + 1).min(range.end as i64)
        };
        let (columns, rows) = (bound(0, 0..width), bound(1, rows));
        if columns.is_empty() || rows.is_empty() {
            return None;
        }
        let pairs = [(1, 2), (2, 0), (0, 1)].map(|(a, b): (usize, usize)| (p[a], p[b]));
        Some(Self {
            order,
            area,
            right: pairs.map(|(a, b)| (a[1] - b[1]) * STEP),
            down: pairs.map(|(a, b)| (b[0] - a[0]) * STEP),
            origin: pairs.map(|(a, b)| edge(a, b, [STEP / 2; 2])),
            bias: pairs.map(|(a, b)| if b[1] < a[1] || (b[1] == a[1] && b[0] > a[0]) { 0 } else { -1 }),
            columns,
            rows,
        })
    }

    /// The rows that it may cover pixels of.
    pub fn rows(&self) -> Range<usize> {
        self.rows.start as usize..self.rows.end as usize
    }

    /// The pixels that it covers in a row.
    pub fn span(&self, y: usize) -> Range<usize> {
        let (mut first, mut last) = (self.columns.start, self.columns.end);
        for i in 0..3 {
            // Inside where value + x * right >= 0.
            let (value, right) = (self.origin[i] + y as i64 * self.down[i] + self.bias[i], self.right[i]);
            match right {
                0 if value < 0 => return 0..0,
                0 => {}
                1.. => first = first.max(-value.div_euclid(right)),
                _ => last = last.min(value.div_euclid(-right) + 1),
            }
        }
        if first < last { first as usize..last as usize } else { 0..0 }
    }

    /// The edge values at the centre of a pixel, in the order of [`Self::order`]: over the area, how much of each corner
    /// it has.
    #[inline]
    pub fn edges(&self, x: usize, y: usize) -> [i64; 3] {
        [0, 1, 2].map(|i| self.origin[i] + x as i64 * self.right[i] + y as i64 * self.down[i])
    }
}
