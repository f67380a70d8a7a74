//! Fewer triangles for a closed surface, with as little change of its form as can be.
//!
//! Edges are collapsed in the order of the quadric error (Garland and Heckbert 1997, "Surface Simplification Using Quadric
//! Error Metrics"), plus a little of the edge's own length so that flat parts keep even triangles. An edge is only
//! collapsed when the mesh stays a manifold (the link condition: both ends have exactly two neighbours in common) and no
//! triangle around it turns over or becomes a needle.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DVec3, Vec3};

use crate::error::Result;
use crate::job::Stage;

/// The share of the squared edge length that counts as error.
const EVEN: f64 = 1e-3;
/// A triangle may turn by so much (the cosine): beyond it the surface folds.
const TURN: f64 = 0.2;
/// Twice the area over the longest side squared, below which a triangle is a needle; that of even sides has 0.87.
const NEEDLE: f64 = 0.05;

/// The sum of squared distances from planes, weighted by area: the upper half of a symmetric 4 x 4 matrix.
#[derive(Clone, Copy, Default)]
struct Quadric([f64; 10]);

impl Quadric {
    fn plane(normal: DVec3, on: DVec3, weight: f64) -> Self {
        let [a, b, c] = normal.to_array();
        let d = -normal.dot(on);
        Self([a * a, a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d, d * d].map(|v| v * weight))
    }

    fn plus(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }

    fn error(&self, p: DVec3) -> f64 {
        let [aa, ab, ac, ad, bb, bc, bd, cc, cd, dd] = self.0;
        let DVec3 { x, y, z } = p;
        (aa * x + 2.0 * (ab * y + ac * z + ad)) * x + (bb * y + 2.0 * (bc * z + bd)) * y + (cc * z + 2.0 * cd) * z + dd
    }

    /// The place of least error, if there is one clearly.
    fn best(&self) -> Option<DVec3> {
        let [aa, ab, ac, ad, bb, bc, bd, cc, cd, _] = self.0;
        let m = glam::DMat3::from_cols(DVec3::new(aa, ab, ac), DVec3::new(ab, bb, bc), DVec3::new(ac, bc, cc));
        let scale = (aa + bb + cc) / 3.0;
        (m.determinant().abs() > 1e-6 * scale.powi(3)).then(|| m.inverse() * -DVec3::new(ad, bd, cd))
    }
}

struct Mesh {
    places: Vec<DVec3>,
    quadrics: Vec<Quadric>,
    triangles: Vec<[u32; 3]>,
    /// The triangles around each vertex; those that are gone are [`GONE`].
    around: Vec<Vec<u32>>,
    /// How often a vertex changed: entries of the queue from before are out of date.
    version: Vec<u32>,
}

const GONE: [u32; 3] = [u32::MAX; 3];

/// A closed manifold of at most `most` triangles, or as few as can be without breaking it.
///
/// # Errors
/// A cancel.
pub fn decimate(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    most: usize,
    stage: Stage<'_>,
) -> Result<(Vec<Vec3>, Vec<[u32; 3]>)> {
    let mut mesh = Mesh::new(positions, triangles);
    let mut queue = BinaryHeap::new();
    for &[a, b, c] in triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            if a < b {
                mesh.offer(&mut queue, a, b);
            }
        }
    }
    let (mut left, whole) = (triangles.len(), triangles.len());
    while left > most {
        let Some(Reverse((_, a, b, versions))) = queue.pop() else { break };
        if [mesh.version[a as usize], mesh.version[b as usize]] != versions {
            continue;
        }
        stage.at((whole - left) as f64 / (whole - most) as f64)?;
        if mesh.collapse(a, b) {
            left -= 2;
            for other in mesh.ring(a) {
                mesh.offer(&mut queue, a.min(other), a.max(other));
            }
        }
    }
    Ok(mesh.finish())
}

type Entry = Reverse<(u64, u32, u32, [u32; 2])>;

impl Mesh {
    fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let places: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3()).collect();
        let mut quadrics = vec![Quadric::default(); places.len()];
        let mut around = vec![Vec::new(); places.len()];
        for (i, t) in triangles.iter().enumerate() {
            let [a, b, c] = t.map(|v| places[v as usize]);
            let cross = (b - a).cross(c - a);
            let quadric = Quadric::plane(cross.normalize_or_zero(), a, 0.5 * cross.length());
            for v in t.map(|v| v as usize) {
                quadrics[v] = quadrics[v].plus(quadric);
                around[v].push(i as u32);
            }
        }
        let version = vec![0; places.len()];
        Self { places, quadrics, triangles: triangles.to_vec(), around, version }
    }

    /// Where the ends of an edge would meet, and what it costs.
    fn target(&self, a: u32, b: u32) -> (DVec3, f64) {
        let (p, q) = (self.places[a as usize], self.places[b as usize]);
        let quadric = self.quadrics[a as usize].plus(self.quadrics[b as usize]);
        let middle = 0.5 * (p + q);
        let length = p.distance_squared(q);
        // A best place far away is that of planes which hardly meet.
        let best = quadric.best().filter(|x| x.distance_squared(middle) <= length).unwrap_or(middle);
        (best, quadric.error(best).max(0.0) + EVEN * length * length)
    }

    fn offer(&self, queue: &mut BinaryHeap<Entry>, a: u32, b: u32) {
        // Bits of a float that is not negative order like it.
        let cost = self.target(a, b).1.to_bits();
        queue.push(Reverse((cost, a, b, [self.version[a as usize], self.version[b as usize]])));
    }

    fn ring(&self, v: u32) -> Vec<u32> {
        let mut ring: Vec<u32> =
            self.around[v as usize].iter().flat_map(|&t| self.triangles[t as usize]).filter(|&o| o != v).collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    /// Makes one vertex, `a`, of two, unless that would harm the surface.
    fn collapse(&mut self, a: u32, b: u32) -> bool {
        let (ring_a, ring_b) = (self.ring(a), self.ring(b));
        let common = ring_a.iter().filter(|v| ring_b.binary_search(v).is_ok()).count();
        // A vertex of valence 3 opposite the edge would be left with two triangles.
        let apart = ring_a.len() + ring_b.len() - common - 2;
        if common != 2 || apart < 3 || ring_a.binary_search(&b).is_err() {
            return false;
        }
        let opposite = ring_a.iter().filter(|v| ring_b.binary_search(v).is_ok());
        if opposite.into_iter().any(|&v| self.around[v as usize].len() <= 3) {
            return false;
        }
        let place = self.target(a, b).0;
        let spoils = |t: u32, moved: u32, other: u32| {
            let triangle = self.triangles[t as usize];
            if triangle.contains(&other) {
                return false;
            }
            let before = triangle.map(|v| self.places[v as usize]);
            let after = triangle.map(|v| if v == moved { place } else { self.places[v as usize] });
            let [was, is] = [before, after].map(|[a, b, c]| (b - a).cross(c - a));
            let [p, q, r] = after;
            let longest = p.distance_squared(q).max(q.distance_squared(r)).max(r.distance_squared(p));
            let needle = |cross: DVec3, longest: f64| cross.length() < NEEDLE * longest;
            needle(is, longest) || is.normalize_or_zero().dot(was.normalize_or_zero()) < TURN
        };
        let spoilt = self.around[a as usize].iter().any(|&t| spoils(t, a, b))
            || self.around[b as usize].iter().any(|&t| spoils(t, b, a));
        if spoilt {
            return false;
        }
        let moved = std::mem::take(&mut self.around[b as usize]);
        for t in moved {
            let triangle = &mut self.triangles[t as usize];
            if triangle.contains(&a) {
                let corners = std::mem::replace(triangle, GONE);
                for v in corners {
                    self.around[v as usize].retain(|&other| other != t);
                }
            } else {
                for v in triangle.iter_mut().filter(|v| **v == b) {
                    *v = a;
                }
                self.around[a as usize].push(t);
            }
        }
        self.quadrics[a as usize] = self.quadrics[a as usize].plus(self.quadrics[b as usize]);
        self.places[a as usize] = place;
        self.version[a as usize] += 1;
        self.version[b as usize] += 1;
        true
    }

    fn finish(self) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut number = vec![u32::MAX; self.places.len()];
        let mut positions = Vec::new();
        let triangles = self.triangles.iter().filter(|t| **t != GONE).map(|t| {
            t.map(|v| {
                let number = &mut number[v as usize];
                if *number == u32::MAX {
                    *number = positions.len() as u32;
                    positions.push(self.places[v as usize].as_vec3());
                }
                *number
            })
        });
        let triangles = triangles.collect();
        (positions, triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::manifold::{manifold_defect, volume};
    use crate::geometry::{Field3, iso_surface};
    use crate::job::Progress;

    #[test]
    fn a_ball_of_few_triangles_is_closed_and_round() {
        let mut field = Field3::new([40; 3], Vec3::splat(-1.95), 0.1, 0.0);
        for z in 0..40 {
            for y in 0..40 {
                for x in 0..40 {
                    let i = field.index(x, y, z);
                    field.values[i] = field.position(x, y, z).length() - 1.5;
                }
            }
        }
        let (positions, triangles) = iso_surface(&field, 0.0);
        let progress = Progress::new();
        let (few, faces) = decimate(&positions, &triangles, 500, progress.whole()).expect("not cancelled");
        assert!(faces.len() <= 500 && faces.len() > 400 && triangles.len() > 5000);
        assert_eq!(manifold_defect(few.len(), &faces), None);
        let (before, after) = (volume(&positions, &triangles), volume(&few, &faces));
        assert!((after / before - 1.0).abs() < 0.02, "{before} became {after}");
        let (least, rest) = decimate(&positions, &triangles, 0, progress.whole()).expect("not cancelled");
        assert!(rest.len() >= 4);
        assert_eq!(manifold_defect(least.len(), &rest), None);
        progress.cancel();
        assert!(decimate(&positions, &triangles, 500, progress.whole()).is_err());
    }
}
