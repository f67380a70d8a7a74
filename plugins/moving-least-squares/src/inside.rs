//! How far vertices are from a handle inside the mesh: shortest paths along edges and across the triangles on both
//! sides of them (Dijkstra 1959).
//!
//! A path along a mesh is longer than the straight one even where nothing is in its way, by a tenth or so; whoever
//! compares the two must allow for that.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;

/// Which vertices can be reached from which in one step.
pub(crate) struct Paths {
    /// Where each vertex' neighbours begin in `ends`.
    starts: Vec<usize>,
    /// Neighbours and how far they are.
    ends: Vec<(u32, f64)>,
}

impl Paths {
    /// Of a mesh whose indices all have their vertices.
    pub(crate) fn new(points: &[DVec2], triangles: &[[u32; 3]]) -> Self {
        let mut edges: Vec<(u32, u32)> = Vec::with_capacity(8 * triangles.len());
        let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
        for &[a, b, c] in triangles {
            for (from, to, opposite) in [(a, b, c), (b, c, a), (c, a, b)] {
                edges.push((from, to));
                edges.push((to, from));
                sides.push((from.min(to), from.max(to), opposite));
            }
        }
        // Over a shared side from tip to tip: twice as many directions, half the detour.
        sides.sort_unstable();
        for pair in sides.windows(2) {
            if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) && crosses(points, pair[0], pair[1].2) {
                edges.push((pair[0].2, pair[1].2));
                edges.push((pair[1].2, pair[0].2));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let mut starts = vec![0; points.len() + 1];
        for &(from, _) in &edges {
            starts[from as usize + 1] += 1;
        }
        for i in 0..points.len() {
            starts[i + 1] += starts[i];
        }
        let length = |a: u32, b: u32| points[a as usize].distance(points[b as usize]);
        Self { starts, ends: edges.iter().map(|&(a, b)| (b, length(a, b))).collect() }
    }

    /// How far every vertex is from the nearest of `sources`, each with a distance of its own; infinite where there
    /// is no way. `None` when `go_on`, asked every few thousand vertices, said no.
    pub(crate) fn distances(&self, sources: &[(usize, f64)], go_on: &dyn Fn() -> bool) -> Option<Vec<f64>> {
        let mut best = vec![f64::INFINITY; self.starts.len() - 1];
        // Distances are not negative, and such numbers order like their bits.
        let mut queue = BinaryHeap::new();
        for &(vertex, distance) in sources {
            if distance < best[vertex] {
                best[vertex] = distance;
                queue.push(Reverse((distance.to_bits(), vertex as u32)));
            }
        }
        let mut taken = 0u32;
        while let Some(Reverse((bits, vertex))) = queue.pop() {
            taken += 1;
            if taken.is_multiple_of(1 << 13) && !go_on() {
                return None;
            }
            let (here, v) = (f64::from_bits(bits), vertex as usize);
            if here > best[v] {
                continue;
            }
            for &(to, length) in &self.ends[self.starts[v]..self.starts[v + 1]] {
                let there = here + length;
                if there < best[to as usize] {
                    best[to as usize] = there;
                    queue.push(Reverse((there.to_bits(), to)));
                }
            }
        }
        Some(best)
    }
}

/// Whether the straight line between the tips of two triangles goes through their shared side.
fn crosses(points: &[DVec2], (a, b, tip): (u32, u32, u32), other: u32) -> bool {
    let [a, b, tip, other] = [a, b, tip, other].map(|i| points[i as usize]);
    let line = other - tip;
    line.perp_dot(a - tip) * line.perp_dot(b - tip) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;

    #[test]
    fn the_way_round_a_gap_is_longer() {
        // A horseshoe of squares: up, across, down.
        let cells = [(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0)];
        let mut points = Vec::new();
        let mut triangles = Vec::new();
        let mut at = std::collections::BTreeMap::new();
        let mut vertex = |x: i32, y: i32, points: &mut Vec<DVec2>| {
            *at.entry((x, y)).or_insert_with(|| {
                points.push(dvec2(f64::from(x), f64::from(y)));
                points.len() as u32 - 1
            })
        };
        for (x, y) in cells {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| vertex(x + i, y + j, &mut points));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let from = points.iter().position(|p| *p == dvec2(1.0, 0.0)).expect("vertex");
        let to = points.iter().position(|p| *p == dvec2(2.0, 0.0)).expect("vertex");
        let paths = Paths::new(&points, &triangles);
        let distance = paths.distances(&[(from, 0.0)], &|| true).expect("nobody stops it")[to];
        assert!((distance - 5.0).abs() < 1e-9, "{distance}");
    }
}
