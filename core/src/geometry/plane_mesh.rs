//! Triangle meshes in the plane, and their making from outlines.
//!
//! Constrained Delaunay: corners are set along the outlines and on a hexagonal grid inside, at a spacing that may differ
//! from place to place by halves, the outlines' edges are kept, and triangles outside are dropped.

use glam::{Vec2, vec2};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::polygon;

/// Inner corners keep this share of the spacing from the outline: nearer ones make slivers.
const CLEARANCE: f32 = 0.6;
/// Triangles flatter than this, height over longest edge, lie between corners of a straight rim and are left out.
const SLIVER: f32 = 1e-3;
/// Outlines whose edges cross are sampled more finely, so many times at most, by halves.
const REFINEMENTS: usize = 5;

/// Vertices and triangles that all turn from x to y.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PlaneMesh {
    /// Vertices.
    pub points: Vec<Vec2>,
    /// Vertex indices, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl PlaneMesh {
    /// Meshes what lies within an odd number of `outlines`, with corners `spacing(place)` apart. The spacing inside goes
    /// by halves of the largest. Empty when nothing is left.
    pub fn within(outlines: &[Vec<Vec2>], spacing: impl Fn(Vec2) -> f32) -> Self {
        (0..REFINEMENTS)
            .find_map(|finer| Self::attempt(outlines, &spacing, 0.5f32.powi(finer as i32)))
            .unwrap_or_default()
    }

    /// `None` when edges of the outlines cross.
    fn attempt(outlines: &[Vec<Vec2>], spacing: &impl Fn(Vec2) -> f32, finer: f32) -> Option<Self> {
        let rims: Vec<Vec<Vec2>> = outlines.iter().map(|o| polygon::resample(o, |p| spacing(p) * finer)).collect();
        let mut triangulation = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
        for rim in &rims {
            let corners: Option<Vec<_>> =
                rim.iter().map(|p| triangulation.insert(Point2::new(f64::from(p.x), f64::from(p.y))).ok()).collect();
            let corners = corners?;
            for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                if a != b && !triangulation.exists_constraint(a, b) && triangulation.try_add_constraint(a, b).is_empty()
                {
                    return None;
                }
            }
        }
        for p in inner_points(&rims, spacing) {
            triangulation.insert(Point2::new(f64::from(p.x), f64::from(p.y))).ok()?;
        }
        let points: Vec<Vec2> =
            triangulation.vertices().map(|v| vec2(v.position().x as f32, v.position().y as f32)).collect();
        let rows = Rows::new(&rims);
        let triangles = triangulation.inner_faces().filter_map(|face| {
            let t = face.vertices().map(|v| v.fix().index() as u32);
            let [a, b, c] = t.map(|v| points[v as usize]);
            let turned = (b - a).perp_dot(c - a);
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            let sound = turned.abs() > SLIVER * longest && rows.contain((a + b + c) / 3.0);
            sound.then(|| if turned > 0.0 { t } else { [t[0], t[2], t[1]] })
        });
        Some(Self { triangles: triangles.collect(), points }.without_loose())
    }

    /// The mesh without vertices that belong to no triangle.
    fn without_loose(self) -> Self {
        let mut kept = vec![u32::MAX; self.points.len()];
        self.triangles.iter().flatten().for_each(|&v| kept[v as usize] = 0);
        let mut points = Vec::new();
        for (slot, p) in kept.iter_mut().zip(&self.points) {
            if *slot == 0 {
                *slot = points.len() as u32;
                points.push(*p);
            }
        }
        Self { points, triangles: self.triangles.iter().map(|t| t.map(|v| kept[v as usize])).collect() }
    }

    /// The area of triangle `t`, positive when it turns from x to y.
    pub fn area(&self, t: usize) -> f64 {
        let [a, b, c] = self.triangles[t].map(|v| self.points[v as usize].as_dvec2());
        0.5 * (b - a).perp_dot(c - a)
    }

    /// Every edge once, lower vertex first, rising, with the number of triangles on it.
    pub fn edges(&self) -> Vec<([u32; 2], u32)> {
        let mut all: Vec<[u32; 2]> = Vec::with_capacity(3 * self.triangles.len());
        for t in &self.triangles {
            all.extend([[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| [a.min(b), a.max(b)]));
        }
        all.sort_unstable();
        let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(all.len() / 2);
        for edge in all {
            match edges.last_mut() {
                Some((last, count)) if *last == edge => *count += 1,
                _ => edges.push((edge, 1)),
            }
        }
        edges
    }

    /// The rim as loops of vertices with the mesh on the right of the way (y down), each starting at its lowest index.
    pub fn rims(&self) -> Vec<Vec<u32>> {
        let mut next: std::collections::BTreeMap<u32, Vec<u32>> = std::collections::BTreeMap::new();
        let single: std::collections::HashSet<[u32; 2]> =
            self.edges().into_iter().filter(|e| e.1 == 1).map(|e| e.0).collect();
        for t in &self.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                if single.contains(&[a.min(b), a.max(b)]) {
                    next.entry(a).or_default().push(b);
                }
            }
        }
        let mut rims = Vec::new();
        while let Some((&first, _)) = next.iter().find(|(_, to)| !to.is_empty()) {
            let mut rim = vec![first];
            let mut at = first;
            while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
                if to == first {
                    break;
                }
                rim.push(to);
                at = to;
            }
            next.retain(|_, to| !to.is_empty());
            rims.push(rim);
        }
        rims
    }
}

/// A hexagonal grid at the largest spacing and, where less is asked for, at its halves.
fn inner_points(rims: &[Vec<Vec2>], spacing: &impl Fn(Vec2) -> f32) -> Vec<Vec2> {
    let all = || rims.iter().flatten();
    let (low, high) = all().fold((Vec2::MAX, Vec2::MIN), |(low, high), p| (low.min(*p), high.max(*p)));
    if low.cmpgt(high).any() {
        return Vec::new();
    }
    let widest = all().map(|p| spacing(*p)).fold(0.0, f32::max);
    let finest = {
        // Where a place asks for less: looked for at the widest spacing.
        let mut finest = widest;
        let steps = ((high - low) / widest).ceil();
        for j in 0..=steps.y as usize {
            for i in 0..=steps.x as usize {
                finest = finest.min(spacing(low + widest * vec2(i as f32, j as f32)));
            }
        }
        all().map(|p| spacing(*p)).fold(finest, f32::min).max(widest / 8.0)
    };
    let halvings = (widest / finest).log2().round().clamp(0.0, 3.0) as u32;
    let step = widest / f32::from(1u16 << halvings);
    let height = step * 0.75f32.sqrt();
    let cells = Cells::new(rims, low, widest);
    let rows = Rows::new(rims);
    let mut out = Vec::new();
    for j in 0..=((high.y - low.y) / height) as usize {
        for i in 0..=((high.x - low.x) / step) as usize + 1 {
            // In coordinates along two sides of the triangles, coarser grids are those of even numbers.
            let p = low + vec2((i as f32 - (j % 2) as f32 * 0.5) * step, j as f32 * height);
            let along = i as isize - (j as isize + 1).div_euclid(2);
            let own = spacing(p);
            let level = (own / step).log2().round().clamp(0.0, halvings as f32) as u32;
            let every = 1isize << level;
            if j as isize % every != 0 || along.rem_euclid(every) != 0 {
                continue;
            }
            if rows.contain(p) && cells.nearest(p) > CLEARANCE * own {
                out.push(p);
            }
        }
    }
    out
}

/// Edges of polygons by the rows they cross, for quick tests of what lies inside.
struct Rows {
    top: f32,
    rows: Vec<Vec<[Vec2; 2]>>,
}

impl Rows {
    fn new(polygons: &[Vec<Vec2>]) -> Self {
        let ys = || polygons.iter().flatten().map(|p| p.y);
        let (top, bottom) = (ys().fold(f32::MAX, f32::min), ys().fold(f32::MIN, f32::max));
        let mut rows = vec![Vec::new(); if bottom >= top { (bottom - top) as usize + 1 } else { 0 }];
        for polygon in polygons {
            for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
                let (from, to) = (a.y.min(b.y) - top, a.y.max(b.y) - top);
                let last = rows.len() - 1;
                for row in &mut rows[from as usize..=(to as usize).min(last)] {
                    row.push([*a, *b]);
                }
            }
        }
        Self { top, rows }
    }

    fn contain(&self, p: Vec2) -> bool {
        if p.y < self.top {
            return false;
        }
        let Some(row) = self.rows.get((p.y - self.top) as usize) else { return false };
        let crosses =
            |[a, b]: &&[Vec2; 2]| (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) * (b.x - a.x) / (b.y - a.y);
        row.iter().filter(crosses).count() % 2 == 1
    }
}

/// Corners of polygons in square cells, for the distance to the nearest.
struct Cells {
    low: Vec2,
    size: f32,
    columns: usize,
    cells: Vec<Vec<[Vec2; 2]>>,
}

impl Cells {
    fn new(polygons: &[Vec<Vec2>], low: Vec2, size: f32) -> Self {
        let high = polygons.iter().flatten().fold(low, |high, p| high.max(*p));
        let count = ((high - low) / size).floor();
        let (columns, rows) = (count.x as usize + 1, count.y as usize + 1);
        let mut own = Self { low, size, columns, cells: vec![Vec::new(); columns * rows] };
        for polygon in polygons {
            for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
                let mut last = None;
                for end in [*a, *b, a.midpoint(*b)] {
                    let cell = own.cell(end);
                    if last != Some(cell) {
                        own.cells[cell.1 * columns + cell.0].push([*a, *b]);
                    }
                    last = Some(cell);
                }
            }
        }
        own
    }

    fn cell(&self, p: Vec2) -> (usize, usize) {
        let place = ((p - self.low) / self.size).floor().max(Vec2::ZERO);
        ((place.x as usize).min(self.columns - 1), (place.y as usize).min(self.cells.len() / self.columns - 1))
    }

    /// How far the nearest edge is, when one is within a cell's size.
    fn nearest(&self, p: Vec2) -> f32 {
        let (x, y) = self.cell(p);
        let mut best = f32::INFINITY;
        for row in y.saturating_sub(1)..=(y + 1).min(self.cells.len() / self.columns - 1) {
            for column in x.saturating_sub(1)..=(x + 1).min(self.columns - 1) {
                for [a, b] in &self.cells[row * self.columns + column] {
                    best = best.min(polygon::nearest_on_segment(*a, *b, p).1.distance(p));
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(at: Vec2, radius: f32, turn: f32) -> Vec<Vec2> {
        (0..200).map(|i| at + radius * Vec2::from_angle(turn * i as f32 / 200.0 * std::f32::consts::TAU)).collect()
    }

    #[test]
    fn a_ring_is_meshed_with_its_hole_and_finer_where_asked() {
        let ring = [circle(vec2(100.0, 100.0), 80.0, 1.0), circle(vec2(100.0, 100.0), 30.0, -1.0)];
        let mesh = PlaneMesh::within(&ring, |p| if p.x < 80.0 { 4.0 } else { 8.0 });
        let area: f64 = (0..mesh.triangles.len()).map(|t| mesh.area(t)).sum();
        let wished = ring.iter().map(|r| polygon::signed_area(r)).sum::<f64>();
        assert!((area / wished - 1.0).abs() < 0.01, "{area} {wished}");
        assert!((0..mesh.triangles.len()).all(|t| mesh.area(t) > 0.0));
        assert_eq!(mesh.rims().len(), 2);
        let (left, right): (Vec<Vec2>, Vec<Vec2>) = mesh.points.iter().partition(|p| p.x < 80.0);
        assert!(left.len() as f32 / 8000.0 > 2.0 * right.len() as f32 / 9300.0);
        // No needle: the smallest angle of nearly all triangles is well above that of a sliver.
        let smallest = |t: &[u32; 3]| {
            let p = t.map(|v| mesh.points[v as usize]);
            (0..3).map(|i| (p[(i + 1) % 3] - p[i]).angle_to(p[(i + 2) % 3] - p[i]).abs()).fold(f32::MAX, f32::min)
        };
        let thin = mesh.triangles.iter().filter(|t| smallest(t) < 0.25).count();
        assert!(thin * 50 < mesh.triangles.len(), "{thin} of {}", mesh.triangles.len());
    }

    #[test]
    fn a_limb_of_one_pixel_and_nothing_at_all() {
        let thin = vec![vec2(10.0, 10.0), vec2(60.0, 10.0), vec2(60.0, 11.0), vec2(10.0, 11.0)];
        let mesh = PlaneMesh::within(&[thin], |_| 8.0);
        let area: f64 = (0..mesh.triangles.len()).map(|t| mesh.area(t)).sum();
        assert!((area - 50.0).abs() < 8.0, "{area}");
        assert_eq!(PlaneMesh::within(&[], |_| 8.0), PlaneMesh::default());
    }
}
