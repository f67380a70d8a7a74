//! Where places lie in a mesh: their triangle and barycentric weights. Places outside belong to the nearest triangle and
//! have weights below 0.

use glam::DVec2;

/// Triangles by the square cells of a grid that they touch.
#[derive(Debug)]
pub(crate) struct Finder {
    low: DVec2,
    cell: f64,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

/// Cells along one side of the grid at most.
const CELLS: f64 = 256.0;

impl Finder {
    /// `cell` is about the size of a triangle.
    pub(crate) fn new(points: &[DVec2], triangles: &[[u32; 3]], cell: f64) -> Self {
        let corners = || triangles.iter().flatten().map(|&v| points[v as usize]);
        let low = corners().fold(DVec2::MAX, DVec2::min);
        let size = corners().fold(DVec2::MIN, DVec2::max) - low;
        let cell = cell.max(size.max_element() / CELLS);
        let count = |side: f64| (side / cell) as usize + 1;
        let (columns, rows) = (count(size.x), count(size.y));
        let mut own = Self { low, cell, columns, rows, starts: vec![0; columns * rows + 1], triangles: Vec::new() };
        let covered: Vec<_> = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| points[v as usize]);
                (own.cell_of(a.min(b).min(c)), own.cell_of(a.max(b).max(c)))
            })
            .collect();
        let cells = |&((x0, y0), (x1, y1)): &((usize, usize), (usize, usize))| {
            (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| y * columns + x))
        };
        covered.iter().flat_map(cells).for_each(|c| own.starts[c + 1] += 1);
        for c in 0..columns * rows {
            own.starts[c + 1] += own.starts[c];
        }
        let mut filled = own.starts.clone();
        own.triangles = vec![0; own.starts[columns * rows] as usize];
        for (t, covered) in covered.iter().enumerate() {
            for c in cells(covered) {
                own.triangles[filled[c] as usize] = t as u32;
                filled[c] += 1;
            }
        }
        own
    }

    fn cell_of(&self, p: DVec2) -> (usize, usize) {
        let at = (p - self.low) / self.cell;
        ((at.x.max(0.0) as usize).min(self.columns - 1), (at.y.max(0.0) as usize).min(self.rows - 1))
    }

    /// The triangle at `p`, or nearest to it, and the place in it that is nearest.
    pub(crate) fn find(&self, points: &[DVec2], triangles: &[[u32; 3]], p: DVec2) -> (usize, DVec2) {
        let (x, y) = self.cell_of(p);
        let (mut best, mut found) = (f64::INFINITY, (0, p));
        for ring in 0..self.columns.max(self.rows) {
            // Whatever lies in this ring of cells is at least so far from the cell of `p`, ...
            if best.sqrt() <= (ring as f64 - 1.0) * self.cell {
                break;
            }
            let (left, right) = (x.checked_sub(ring), Some(x + ring).filter(|c| *c < self.columns));
            for row in y.saturating_sub(ring)..=(y + ring).min(self.rows - 1) {
                let whole = row.abs_diff(y) == ring;
                let inner = if whole { x.saturating_sub(ring)..(x + ring + 1).min(self.columns) } else { 0..0 };
                for column in inner.chain([left, right].into_iter().flatten().filter(|_| !whole)) {
                    let c = row * self.columns + column;
                    for &t in &self.triangles[self.starts[c] as usize..self.starts[c + 1] as usize] {
                        let near = nearest_in(triangles[t as usize].map(|v| points[v as usize]), p);
                        let gap = near.distance_squared(p);
                        // ... and the order of cells decides nothing.
                        if gap < best || (gap == best && (t as usize) < found.0) {
                            (best, found) = (gap, (t as usize, near));
                        }
                    }
                }
            }
        }
        found
    }
}

/// The barycentric weights of `p` in a triangle.
pub(crate) fn weights(corners: [DVec2; 3], p: DVec2) -> [f64; 3] {
    let [a, b, c] = corners;
    let area = (b - a).perp_dot(c - a);
    let (at_b, at_c) = ((p - a).perp_dot(c - a) / area, (b - a).perp_dot(p - a) / area);
    [1.0 - at_b - at_c, at_b, at_c]
}

fn nearest_in(corners: [DVec2; 3], p: DVec2) -> DVec2 {
    if weights(corners, p).iter().all(|w| *w >= 0.0) {
        return p;
    }
    let [a, b, c] = corners;
    let on = |from: DVec2, to: DVec2| {
        let along = to - from;
        from + along * ((p - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
    };
    [on(a, b), on(b, c), on(c, a)].into_iter().min_by(|x, y| x.distance(p).total_cmp(&y.distance(p))).unwrap_or(a)
}
