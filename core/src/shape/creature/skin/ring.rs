//! The neighbours of a mesh's vertices, and smoothing along them.

use glam::Vec3;
use rayon::prelude::*;

/// Which vertices share an edge, as one list with where each vertex's part begins.
pub(super) struct Neighbours {
    start: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    pub(super) fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut edges: Vec<(u32, u32)> = Vec::with_capacity(6 * triangles.len());
        for t in triangles {
            for k in 0..3 {
                edges.push((t[k], t[(k + 1) % 3]));
                edges.push((t[(k + 1) % 3], t[k]));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let mut start = vec![0u32; vertices + 1];
        for e in &edges {
            start[e.0 as usize + 1] += 1;
        }
        for v in 0..vertices {
            start[v + 1] += start[v];
        }
        Self { start, list: edges.into_iter().map(|e| e.1).collect() }
    }

    pub(super) fn of(&self, v: usize) -> &[u32] {
        &self.list[self.start[v] as usize..self.start[v + 1] as usize]
    }

    pub(super) fn len(&self) -> usize {
        self.start.len() - 1
    }
}

/// One round of smoothing of `n` values a vertex: half its own, half its neighbours' mean, of those that may `mix`.
pub(super) fn smoothed(values: &[f32], n: usize, ring: &Neighbours, mix: impl Fn(f32, f32) -> bool + Sync) -> Vec<f32> {
    let mut out = values.to_vec();
    out.par_chunks_mut(n).enumerate().for_each(|(v, own)| {
        for (l, own) in own.iter_mut().enumerate() {
            let (mut sum, mut count) = (0.0, 0.0);
            for &o in ring.of(v) {
                let other = values[o as usize * n + l];
                if mix(*own, other) {
                    sum += other;
                    count += 1.0;
                }
            }
            if count > 0.0 {
                *own = 0.5 * *own + 0.5 * sum / count;
            }
        }
    });
    out
}

/// Normals by area.
pub(in super::super) fn normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sum = vec![Vec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        let area = (b - a).cross(c - a);
        for i in t {
            sum[*i as usize] += area;
        }
    }
    sum.into_iter().map(|n| n.normalize_or(Vec3::Z)).collect()
}
