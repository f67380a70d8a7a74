//! What a solid stands on: its own feet, made flat, or a rounded plate that holds all of them.
//!
//! Feet are the low places of the surface that one can only leave upwards: minima of the height with a persistence
//! (Edelsbrunner et al. 2002, "Topological Persistence and Simplification") of a tenth of the whole height, in its lower
//! third.

use glam::{Vec2, Vec3, Vec3Swizzles};
use rayon::prelude::*;

use crate::geometry::{Field3, polygon};

/// How far, as a share of the height, the surface rises around a foot before it meets another part.
const PERSISTENCE: f32 = 0.1;
/// No foot is higher than this share of the height.
const LOW: f32 = 0.35;

/// The plate's measures, in mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measures {
    /// From its bottom to its top.
    pub(super) thickness: f32,
    /// How far it reaches beyond the feet.
    pub(super) rim: f32,
    /// The radius of posts under feet that are in the air.
    pub(super) post: f32,
}

impl Measures {
    /// For a creature of this length with parts of at least `thickness`.
    pub(super) fn new(longest: f32, min_thickness: f32, cell: f32) -> Self {
        // Thin enough not to look like a block, thick enough not to bend: as miniatures have it.
        Self {
            thickness: (0.02 * longest).max(2.0 * min_thickness).max(4.0 * cell),
            rim: (0.05 * longest).max(2.0 * min_thickness),
            post: (0.01 * longest).max(0.6 * min_thickness).max(2.0 * cell),
        }
    }

    /// How deep feet stand in it.
    fn embed(&self) -> f32 {
        0.25 * self.thickness
    }
}

/// A plate with posts.
pub(super) struct Base {
    measures: Measures,
    hull: Vec<Vec2>,
    /// Feet that the plate does not reach.
    posts: Vec<Vec3>,
    top: f32,
    /// How many feet it holds.
    pub(super) feet: usize,
}

impl Base {
    /// A base for the closed surface of a creature.
    pub(super) fn new(measures: Measures, positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let ground = positions.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
        let top = ground + measures.embed();
        let feet = feet(positions, triangles);
        // All that stands in the plate, and what the posts stand below.
        let mut around: Vec<Vec2> = positions.iter().filter(|p| p.z < top).map(|p| p.xy()).collect();
        around.extend(feet.iter().map(|f| f.xy()));
        let posts = feet.iter().copied().filter(|f| f.z > top - 0.5 * measures.embed()).collect();
        Self { measures, hull: convex_hull(&around), posts, top, feet: feet.len() }
    }

    fn bottom(&self) -> f32 {
        self.top - self.measures.thickness
    }

    /// The signed distance from `place`, rounded above and as if it went on below the bed.
    pub(super) fn distance(&self, place: Vec3) -> f32 {
        let Measures { thickness, rim, post } = self.measures;
        let round = 0.5 * thickness;
        let q = Vec2::new(hull_distance(&self.hull, place.xy()) - rim, place.z - self.top) + round;
        let plate = q.max_element().min(0.0) + q.max(Vec2::ZERO).length() - round;
        self.posts.iter().fold(plate, |away, foot| {
            // Its round end just reaches into the foot.
            let end = (foot.z - 0.5 * post).max(self.bottom());
            let on = foot.with_z(place.z.clamp(self.bottom(), end));
            away.min(place.distance(on) - post)
        })
    }

    /// Adds it to the solid with fillets of about `width`, and cuts off what lies below.
    pub(super) fn add_to(&self, field: &mut Field3, width: f32) {
        let [nx, ny, _] = field.dims;
        let (origin, cell) = (field.origin, field.cell);
        let reach = self.posts.iter().map(|p| p.z + 2.0 * self.measures.post).fold(self.top, f32::max) + width;
        field.values.par_chunks_mut((nx * ny).max(1)).enumerate().for_each(|(z, plane)| {
            let height = origin.z + cell * z as f32;
            if height > reach {
                return;
            }
            for y in 0..ny {
                for x in 0..nx {
                    let place = Vec3::new(origin.x + cell * x as f32, origin.y + cell * y as f32, height);
                    let value = &mut plane[y * nx + x];
                    *value = blended(*value, self.distance(place), width).max(self.bottom() - height);
                }
            }
        });
    }
}

/// The lowest places of a closed surface, lowest first.
fn feet(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let (low, high) = positions.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), p| (l.min(p.z), h.max(p.z)));
    let height = high - low;
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| positions[a as usize].z.total_cmp(&positions[b as usize].z).then(a.cmp(&b)));
    let mut rank = vec![0u32; positions.len()];
    for (i, v) in order.iter().enumerate() {
        rank[*v as usize] = i as u32;
    }
    // An edge counts when its higher end is reached.
    let mut edges: Vec<(u32, u32)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(a, b)| (rank[a as usize].max(rank[b as usize]), rank[a as usize].min(rank[b as usize])))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    // The root of a basin is its lowest vertex.
    let mut parent: Vec<u32> = (0..positions.len() as u32).collect();
    let root = |parent: &mut Vec<u32>, mut v: u32| {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    };
    let z = |rank: u32| positions[order[rank as usize] as usize].z;
    let mut found = vec![];
    if !order.is_empty() {
        found.push(0);
    }
    for (upper, lower) in edges {
        let (a, b) = (root(&mut parent, upper), root(&mut parent, lower));
        let (keep, end) = (a.min(b), a.max(b));
        if keep == end {
            continue;
        }
        parent[end as usize] = keep;
        if z(upper) - z(end) >= PERSISTENCE * height && z(end) - low <= LOW * height {
            found.push(end);
        }
    }
    found.sort_unstable();
    found.into_iter().map(|rank| positions[order[rank as usize] as usize]).collect()
}

/// Draws everything below `top` straight down to `ground` and cuts it off there, so that the feet are flat.
pub(super) fn flatten(field: &mut Field3, ground: f32, top: f32) {
    let [nx, ny, nz] = field.dims;
    let level = (((top - field.origin.z) / field.cell).round().max(0.0) as usize).min(nz - 1);
    let print: Vec<f32> = field.values[level * nx * ny..(level + 1) * nx * ny].to_vec();
    for z in 0..level {
        let below = ground - (field.origin.z + field.cell * z as f32);
        for (value, print) in field.values[z * nx * ny..(z + 1) * nx * ny].iter_mut().zip(&print) {
            *value = value.min(*print).max(below);
        }
    }
}

/// The union of two solids with a fillet about as wide as `width` (the polynomial smooth minimum of Quilez 2013). Only adds.
fn blended(a: f32, b: f32, width: f32) -> f32 {
    let h = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - 0.25 * h * h * width
}

/// A capsule of `radius` between two places, added to the solid.
pub(super) fn add_bar(field: &mut Field3, from: Vec3, to: Vec3, radius: f32) {
    let [nx, ny, _] = field.dims;
    let (origin, cell) = (field.origin, field.cell);
    let way = to - from;
    field.values.par_chunks_mut((nx * ny).max(1)).enumerate().for_each(|(z, plane)| {
        for y in 0..ny {
            for x in 0..nx {
                let place = origin + cell * Vec3::new(x as f32, y as f32, z as f32);
                let share = ((place - from).dot(way) / way.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
                let value = &mut plane[y * nx + x];
                *value = value.min(place.distance(from + way * share) - radius);
            }
        }
    });
}

/// The corners of the convex hull, counter-clockwise (Andrew 1979).
fn convex_hull(points: &[Vec2]) -> Vec<Vec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull: Vec<Vec2> = Vec::new();
    let backwards: Vec<Vec2> = sorted.iter().rev().copied().collect();
    for run in [&sorted, &backwards] {
        let start = hull.len() + 1;
        for &p in run {
            while hull.len() > start
                && (hull[hull.len() - 1] - hull[hull.len() - 2]).perp_dot(p - hull[hull.len() - 2]) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    }
    hull
}

/// The signed distance to a convex polygon; of fewer than three corners the distance to the point or line.
fn hull_distance(hull: &[Vec2], p: Vec2) -> f32 {
    let n = hull.len();
    let sides = || (0..n).map(|i| (hull[i], hull[(i + 1) % n]));
    let away = sides().map(|(a, b)| polygon::nearest_on_segment(a, b, p).1.distance(p)).fold(f32::INFINITY, f32::min);
    let inside = n >= 3 && sides().all(|(a, b)| (b - a).perp_dot(p - a) >= 0.0);
    if inside { -away } else { away }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::iso_surface;

    #[test]
    fn a_table_has_four_feet_and_a_ball_has_one() {
        let mut field = Field3::new([40, 40, 40], Vec3::ZERO, 0.25, 9.0);
        let legs =
            [Vec3::new(2.0, 2.0, 1.0), Vec3::new(8.0, 2.0, 1.5), Vec3::new(2.0, 8.0, 1.0), Vec3::new(8.0, 8.0, 2.0)];
        for leg in legs {
            add_bar(&mut field, leg, leg.with_z(8.0), 0.6);
            add_bar(&mut field, leg.with_z(8.0), Vec3::new(5.0, 5.0, 8.0), 0.8);
        }
        let (positions, triangles) = iso_surface(&field, 0.0);
        let found = feet(&positions, &triangles);
        assert_eq!(found.len(), 4);
        for leg in legs {
            assert!(found.iter().any(|f| f.truncate().distance(leg.truncate()) < 0.4), "{leg}");
        }
        let mut ball = Field3::new([40, 40, 40], Vec3::ZERO, 0.25, 9.0);
        add_bar(&mut ball, Vec3::splat(5.0), Vec3::splat(5.0), 3.0);
        let (positions, triangles) = iso_surface(&ball, 0.0);
        assert_eq!(feet(&positions, &triangles).len(), 1);
        assert!(feet(&[], &[]).is_empty());
    }

    #[test]
    fn the_hull_and_its_distance() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0], [1.0, 0.0]].map(Vec2::from_array);
        let hull = convex_hull(&square);
        assert_eq!(hull.len(), 4);
        assert_eq!(hull_distance(&hull, Vec2::new(1.0, 0.5)), -0.5);
        assert_eq!(hull_distance(&hull, Vec2::new(1.0, -0.5)), 0.5);
        assert_eq!(hull_distance(&convex_hull(&square[..1]), Vec2::new(3.0, 4.0)), 5.0);
    }
}
