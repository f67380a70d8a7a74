//! Where a character's regions lie over each other, and which is in front.
//!
//! Pan and Zhang 2011, section 3.4: after each deformation the mesh is looked through for parts that lie over each other,
//! and a click brings a region forward, for that frame. Triangles are compared through a grid of cells; the area that two
//! share is their intersection's (Sutherland and Hodgman 1974).
//!
//! Known limits: a region that folds over itself has one depth, so nothing can be ordered within it.

use std::collections::BTreeMap;

use glam::Vec2;

use super::Character;
use crate::geometry::polygon;

/// Shared areas below this share of a mean triangle are rims that touch.
const TOUCH: f64 = 0.02;

/// Two bones whose regions lie over each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// The bone in front, and the one behind it.
    pub bones: [u32; 2],
    /// The area that they share, in square pixels.
    pub area: f64,
    /// The middle of what they share.
    pub at: Vec2,
    /// Whether depths put one before the other; else it is in front because its bone is the outer one.
    pub ordered: bool,
}

impl Character {
    /// The regions that lie over each other where the vertices are at `points` and bones at `depths`, the largest areas
    /// first. Empty where there are not as many points as vertices. A depth that is not given is 0.
    pub fn overlaps(&self, points: &[Vec2], depths: &[i32]) -> Vec<Overlap> {
        if points.len() != self.mesh.points.len() || points.iter().any(|p| !p.is_finite()) {
            return Vec::new();
        }
        let corners = |t: usize| self.mesh.triangles[t].map(|v| points[v as usize]);
        let areas = (0..self.mesh.triangles.len()).map(|t| polygon::signed_area(&corners(t)).abs());
        let least = TOUCH * areas.sum::<f64>() / self.mesh.triangles.len() as f64;
        let mut shared: BTreeMap<[u32; 2], (f64, glam::DVec2)> = BTreeMap::new();
        for (t, u) in self.near(points) {
            let (one, other) = (self.triangle_bone(t), self.triangle_bone(u));
            let touching = self.mesh.triangles[t].iter().any(|v| self.mesh.triangles[u].contains(v));
            if one == other || touching {
                continue;
            }
            let (area, at) = intersection(corners(t), corners(u));
            let sum = shared.entry([one.min(other), one.max(other)]).or_default();
            (sum.0, sum.1) = (sum.0 + area, sum.1 + at * area);
        }
        let depth = |bone: u32| depths.get(bone as usize).copied().unwrap_or(0);
        let mut found: Vec<Overlap> = shared
            .into_iter()
            .filter(|(_, (area, _))| *area > least)
            .map(|([a, b], (area, at))| Overlap {
                bones: if depth(a) > depth(b) { [a, b] } else { [b, a] },
                area,
                at: (at / area).as_vec2(),
                ordered: depth(a) != depth(b),
            })
            .collect();
        found.sort_by(|a, b| b.area.total_cmp(&a.area));
        found
    }

    /// Brings the hindmost region at the place `at` in front of all others there, and says which bone's it is: a second
    /// click at a place of two regions undoes the first. `None` where there are no two.
    pub fn bring_forward(&self, points: &[Vec2], depths: &mut [i32], at: Vec2) -> Option<u32> {
        if points.len() != self.mesh.points.len() || depths.len() != self.skeleton.bones.len() {
            return None;
        }
        // From the farthest to the nearest, each bone once.
        let mut there: Vec<u32> = Vec::new();
        for t in self.draw_order(depths) {
            let t = t as usize;
            let bone = self.triangle_bone(t);
            if !there.contains(&bone) && covers(self.mesh.triangles[t].map(|v| points[v as usize]), at) {
                there.push(bone);
            }
        }
        let (&hindmost, others) = there.split_first()?;
        let nearest = others.iter().map(|b| depths[*b as usize]).max()?;
        depths[hindmost as usize] = nearest.saturating_add(1);
        Some(hindmost)
    }

    /// Pairs of triangles whose upright boxes share a cell of a grid and meet, the lower first, each once.
    fn near(&self, points: &[Vec2]) -> Vec<(usize, usize)> {
        let boxes: Vec<(Vec2, Vec2)> = self
            .mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| points[v as usize]);
                (a.min(b).min(c), a.max(b).max(c))
            })
            .collect();
        let extent: f32 = boxes.iter().map(|(low, high)| (*high - *low).max_element()).sum();
        let cell = (2.0 * extent / boxes.len() as f32).max(1e-3);
        let place = |p: Vec2| (p / cell).floor().as_i64vec2();
        let mut cells: BTreeMap<(i64, i64), Vec<u32>> = BTreeMap::new();
        let mut pairs = Vec::new();
        for (t, (low, high)) in boxes.iter().enumerate() {
            // A triangle that is stretched over thousands of cells is one that something went wrong with.
            let (from, to) = (place(*low), place(*high).min(place(*low) + 64));
            for y in from.y..=to.y {
                for x in from.x..=to.x {
                    let here = cells.entry((y, x)).or_default();
                    for &u in here.iter() {
                        let other = &boxes[u as usize];
                        // The pair is noted in the first cell that both have.
                        let first = place(low.max(other.0));
                        let meet = low.cmple(other.1).all() && other.0.cmple(*high).all();
                        if meet && (first.x, first.y) == (x, y) {
                            pairs.push((u as usize, t));
                        }
                    }
                    here.push(t as u32);
                }
            }
        }
        pairs
    }
}

fn covers([a, b, c]: [Vec2; 3], p: Vec2) -> bool {
    let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| (b - a).perp_dot(p - a));
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

/// The area that two triangles share, and its middle.
fn intersection(mut one: [Vec2; 3], mut other: [Vec2; 3]) -> (f64, glam::DVec2) {
    for triangle in [&mut one, &mut other] {
        if polygon::signed_area(&triangle[..]) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    let mut left: Vec<Vec2> = one.to_vec();
    for i in 0..3 {
        let (a, b) = (other[i], other[(i + 1) % 3]);
        let side = |p: Vec2| (b - a).perp_dot(p - a);
        let mut kept = Vec::with_capacity(left.len() + 1);
        for (p, q) in left.iter().zip(left.iter().cycle().skip(1)) {
            let (from, to) = (side(*p), side(*q));
            if from >= 0.0 {
                kept.push(*p);
            }
            if (from >= 0.0) != (to >= 0.0) {
                kept.push(p.lerp(*q, from / (from - to)));
            }
        }
        left = kept;
    }
    let Some(&first) = left.first() else { return (0.0, glam::DVec2::ZERO) };
    let (mut double, mut middle) = (0.0, glam::DVec2::ZERO);
    for pair in left.windows(2).skip(1) {
        let [a, b, c] = [first, pair[0], pair[1]].map(|p| p.as_dvec2());
        let part = (b - a).perp_dot(c - a);
        double += part;
        middle += part * (a + b + c) / 3.0;
    }
    if double > 0.0 { (0.5 * double, middle / double) } else { (0.0, glam::DVec2::ZERO) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::PlaneMesh;
    use crate::shape::character::{Joint, Skeleton};
    use glam::vec2;

    /// A bar of two bones, 200 long and 20 wide.
    fn bar() -> Character {
        let outline = vec![vec2(0.0, 0.0), vec2(200.0, 0.0), vec2(200.0, 20.0), vec2(0.0, 20.0)];
        let joints = [10.0, 100.0, 190.0].map(|x| Joint { name: format!("{x}"), at: vec2(x, 10.0) }).to_vec();
        let skeleton = Skeleton { joints, bones: vec![[0, 1], [1, 2]] };
        Character::new((200, 20), PlaneMesh::within(&[outline], |_| 5.0), skeleton).expect("a character")
    }

    /// The right part folded over the left one by hand.
    fn folded(own: &Character) -> Vec<Vec2> {
        own.mesh.points.iter().map(|p| if p.x > 110.0 { vec2(220.0 - p.x, p.y + 5.0) } else { *p }).collect()
    }

    #[test]
    fn what_lies_over_something_is_found_with_its_area_and_ordered_by_a_click() {
        let own = bar();
        assert!(own.overlaps(&own.mesh.points, &[0, 0]).is_empty());
        let points = folded(&own);
        let found = own.overlaps(&points, &[0, 0]);
        assert_eq!(found.len(), 1, "{found:?}");
        // Ninety by fifteen pixels lie over each other, less what is beside the fold.
        assert!((found[0].area - 90.0 * 15.0).abs() < 0.12 * 1350.0 && !found[0].ordered, "{found:?}");
        assert!(found[0].at.distance(vec2(65.0, 12.5)) < 12.0, "{found:?}");
        let (mut depths, at) = (vec![0, 0], vec2(60.0, 12.0));
        let first = own.bring_forward(&points, &mut depths, at).expect("two regions");
        let found = own.overlaps(&points, &depths);
        assert!(found[0].ordered && found[0].bones[0] == first, "{found:?} {depths:?}");
        let second = own.bring_forward(&points, &mut depths, at).expect("two regions");
        assert_ne!(first, second);
        assert_eq!(own.overlaps(&points, &depths)[0].bones[0], second);
        assert_eq!(own.bring_forward(&points, &mut depths, vec2(60.0, 2.0)), None);
        assert_eq!(own.bring_forward(&points, &mut depths, vec2(-60.0, f32::NAN)), None);
    }

    #[test]
    fn the_shared_area_of_triangles_is_exact_and_odd_places_are_nothing() {
        let corner = [vec2(0.0, 0.0), vec2(4.0, 0.0), vec2(0.0, 4.0)];
        let (area, at) = intersection(corner, corner.map(|p| vec2(4.0, 4.0) - p));
        assert!(area.abs() < 1e-6, "{area} {at}");
        let (area, at) = intersection(corner, corner.map(|p| vec2(2.0, 2.0) - p));
        assert!((area - 4.0).abs() < 1e-6 && at.distance(glam::dvec2(1.0, 1.0)) < 1e-6, "{area} {at}");
        let own = bar();
        assert!(own.overlaps(&own.mesh.points[1..], &[]).is_empty());
        assert!(own.overlaps(&vec![vec2(f32::NAN, 0.0); own.mesh.points.len()], &[]).is_empty());
        // A vertex flung away must not take the time of a grid that reaches it.
        let mut flung = own.mesh.points.clone();
        flung[3] = vec2(1e9, -1e9);
        assert!(own.overlaps(&flung, &[]).len() <= 1);
    }
}
