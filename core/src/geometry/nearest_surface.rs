//! The place on a triangle mesh that is nearest to a point.
//!
//! Triangles lie in the cells of a regular grid that their boxes touch; a search goes outward shell by shell until no
//! cell can hold anything nearer. The place on a triangle is that of Ericson, "Real-Time Collision Detection", 5.1.5.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

/// A triangle, shares of its corners, and how far it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// Its index.
    pub triangle: usize,
    /// How much of each corner the place is; they sum to 1.
    pub shares: [f32; 3],
    /// The distance to it.
    pub distance: f32,
}

/// A mesh that is searched many times.
pub(crate) struct NearestSurface<'a> {
    positions: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    cells: HashMap<IVec3, Vec<u32>>,
    cell: f32,
    low: IVec3,
    high: IVec3,
}

impl<'a> NearestSurface<'a> {
    /// Triangles whose corners are finite; others are never found.
    pub(crate) fn new(positions: &'a [Vec3], triangles: &'a [[u32; 3]]) -> Self {
        let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
        let sound = |t: &&[u32; 3]| corners(t).iter().all(|p| p.is_finite());
        let (mut sum, mut count) = (0.0f64, 0u32);
        for t in triangles.iter().filter(sound) {
            let [a, b, c] = corners(t);
            sum += f64::from((a.max(b).max(c) - a.min(b).min(c)).max_element());
            count += 1;
        }
        // Twice the mean size: few triangles lie in many cells, and few cells are empty near the surface.
        let cell = ((2.0 * sum / f64::from(count.max(1))) as f32).max(1e-3);
        let mut out = Self { positions, triangles, cells: HashMap::new(), cell, low: IVec3::MAX, high: IVec3::MIN };
        for (i, t) in triangles.iter().enumerate().filter(|(_, t)| sound(t)) {
            let [a, b, c] = corners(t);
            let (low, high) = (out.cell_of(a.min(b).min(c)), out.cell_of(a.max(b).max(c)));
            out.low = out.low.min(low);
            out.high = out.high.max(high);
            for z in low.z..=high.z {
                for y in low.y..=high.y {
                    for x in low.x..=high.x {
                        out.cells.entry(IVec3::new(x, y, z)).or_default().push(i as u32);
                    }
                }
            }
        }
        out
    }

    fn cell_of(&self, p: Vec3) -> IVec3 {
        (p / self.cell).floor().as_ivec3()
    }

    /// The nearest place; `None` when there is no triangle or the point is no number. Of equally near ones the first.
    pub(crate) fn find(&self, p: Vec3) -> Option<Nearest> {
        if self.cells.is_empty() || !p.is_finite() {
            return None;
        }
        let at = self.cell_of(p);
        // Shells that do not reach the grid are skipped.
        let start = (self.low - at).max(at - self.high).max(IVec3::ZERO).max_element();
        let last = (at - self.low).abs().max((self.high - at).abs()).max_element();
        let mut best: Option<Nearest> = None;
        for shell in start..=last {
            if best.is_some_and(|b| b.distance <= (shell - 1).max(0) as f32 * self.cell) {
                break;
            }
            let (low, high) = ((at - shell).max(self.low), (at + shell).min(self.high));
            for z in low.z..=high.z {
                for y in low.y..=high.y {
                    let inner = (z - at.z).abs() < shell && (y - at.y).abs() < shell;
                    let columns = if inner { vec![at.x - shell, at.x + shell] } else { (low.x..=high.x).collect() };
                    for x in columns {
                        for &t in self.cells.get(&IVec3::new(x, y, z)).into_iter().flatten() {
                            let found = self.on_triangle(t as usize, p);
                            let better = best.is_none_or(|b| {
                                found.distance < b.distance
                                    || (found.distance == b.distance && found.triangle < b.triangle)
                            });
                            if better {
                                best = Some(found);
                            }
                        }
                    }
                }
            }
        }
        best
    }

    fn on_triangle(&self, triangle: usize, p: Vec3) -> Nearest {
        let [a, b, c] = self.triangles[triangle].map(|v| self.positions[v as usize]);
        let shares = shares(p, a, b, c);
        let place = a * shares[0] + b * shares[1] + c * shares[2];
        Nearest { triangle, shares, distance: p.distance(place) }
    }
}

/// How much of each corner the nearest place of a triangle is.
fn shares(p: Vec3, a: Vec3, b: Vec3, c: Vec3) -> [f32; 3] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return if t.is_finite() { [1.0 - t, t, 0.0] } else { [1.0, 0.0, 0.0] };
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return if t.is_finite() { [1.0 - t, 0.0, t] } else { [1.0, 0.0, 0.0] };
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return if t.is_finite() { [0.0, 1.0 - t, t] } else { [0.0, 1.0, 0.0] };
    }
    let total = va + vb + vc;
    [va / total, vb / total, vc / total]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;
    use proptest::prelude::*;

    proptest! {
        /// What the grid finds is as near as what looking at all triangles finds.
        #[test]
        fn nothing_nearer_is_missed(
            corners in prop::collection::vec((-9f32..9.0, -9f32..9.0, -9f32..9.0), 3..40),
            p in (-30f32..30.0, -30f32..30.0, -30f32..30.0),
        ) {
            let positions: Vec<Vec3> = corners.into_iter().map(Vec3::from).collect();
            let triangles: Vec<[u32; 3]> = (2..positions.len() as u32).map(|i| [i - 2, i - 1, i]).collect();
            let surface = NearestSurface::new(&positions, &triangles);
            let p = Vec3::from(p);
            let best = (0..triangles.len()).map(|t| surface.on_triangle(t, p).distance).fold(f32::INFINITY, f32::min);
            let found = surface.find(p).expect("a triangle");
            prop_assert!((found.distance - best).abs() < 1e-4);
            prop_assert!((found.shares.iter().sum::<f32>() - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn no_triangle_and_no_number_find_nothing() {
        assert!(NearestSurface::new(&[], &[]).find(Vec3::ZERO).is_none());
        let places = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let one = NearestSurface::new(&places, &[[0, 1, 2]]);
        assert!(one.find(vec3(f32::NAN, 0.0, 0.0)).is_none());
        let far = one.find(vec3(0.2, 0.2, 500.0)).expect("the triangle");
        assert!((far.distance - 500.0).abs() < 1e-3);
    }
}
