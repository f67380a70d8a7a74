//! A tree of boxes over triangles in space: the nearest point, the first hit of a ray, and how often the surface winds
//! around a point.
//!
//! The winding number is generalised (Jacobson et al. 2013, "Robust Inside-Outside Segmentation Using Generalized Winding
//! Numbers"): 1 inside one closed surface, 2 where two overlap, between 0 and 1 beside a hole. Far triangles count
//! together as one dipole (Barill et al. 2018, "Fast Winding Numbers for Soups and Clouds", the first term), which is off
//! by about 0.01.

use glam::Vec3;

/// Triangles in a leaf. Between 4 and 16 the speed hardly differs.
const LEAF: usize = 8;
/// A node counts as one dipole from this many of its radii away; 2 is the value of Barill et al.
const FAR: f32 = 2.0;

/// The tree. Triangles keep the numbers that they came with.
#[derive(Clone, Debug)]
pub struct TriangleTree {
    nodes: Vec<Node>,
    triangles: Vec<[Vec3; 3]>,
    numbers: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// Its triangles.
    first: u32,
    end: u32,
    /// The second child; the first one follows its parent. 0 in a leaf.
    second: u32,
    centre: Vec3,
    /// The sum of the areas times normals.
    dipole: Vec3,
    /// No triangle reaches further from the centre.
    radius: f32,
}

/// A place on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnTriangle {
    /// The triangle's number.
    pub triangle: u32,
    /// The place.
    pub point: Vec3,
    /// How far it is from where was asked.
    pub distance: f32,
}

impl TriangleTree {
    /// A tree over `triangles` between `positions`. Triangles without an area, or with a vertex that is no number, are left
    /// out.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let mut entries: Vec<(u32, [Vec3; 3])> = triangles
            .iter()
            .enumerate()
            .map(|(i, t)| (i as u32, t.map(|v| positions[v as usize])))
            .filter(|(_, [a, b, c])| (*b - *a).cross(*c - *a).length_squared() > 0.0)
            .collect();
        entries.retain(|(_, t)| t.iter().all(|p| p.is_finite()));
        let mut nodes = Vec::new();
        if !entries.is_empty() {
            let end = entries.len();
            build(&mut nodes, &mut entries, 0, end);
        }
        let (numbers, triangles) = entries.into_iter().unzip();
        Self { nodes, triangles, numbers }
    }

    /// The lowest and highest corner of all; `None` when there are no triangles.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        self.nodes.first().map(|n| (n.low, n.high))
    }

    /// The nearest place on the surface, when it is nearer than `limit`.
    pub fn nearest(&self, point: Vec3, limit: f32) -> Option<OnTriangle> {
        let mut best: Option<OnTriangle> = None;
        let mut bound = limit * limit;
        let mut open = Open::new();
        let gap = |n: usize| (point.clamp(self.nodes[n].low, self.nodes[n].high) - point).length_squared();
        if !self.nodes.is_empty() {
            open.push(0, gap(0));
        }
        while let Some((n, away)) = open.pop() {
            if away >= bound {
                continue;
            }
            let node = &self.nodes[n];
            if node.second == 0 {
                for i in node.first as usize..node.end as usize {
                    let on = nearest_on(point, &self.triangles[i]);
                    let squared = on.distance_squared(point);
                    if squared < bound {
                        bound = squared;
                        best = Some(OnTriangle { triangle: self.numbers[i], point: on, distance: 0.0 });
                    }
                }
                continue;
            }
            let (a, b) = (n + 1, node.second as usize);
            let (gap_a, gap_b) = (gap(a), gap(b));
            // The nearer one is looked at first.
            if gap_a <= gap_b {
                open.push(b, gap_b);
                open.push(a, gap_a);
            } else {
                open.push(a, gap_a);
                open.push(b, gap_b);
            }
        }
        best.map(|b| OnTriangle { distance: bound.sqrt(), ..b })
    }

    /// Where a ray from `from` along the unit vector `way` first meets the surface, between the distances `after` and
    /// `limit`.
    pub fn first_hit(&self, from: Vec3, way: Vec3, after: f32, limit: f32) -> Option<OnTriangle> {
        let mut best: Option<OnTriangle> = None;
        let mut bound = limit;
        let enters = |n: usize, bound: f32| {
            let node = &self.nodes[n];
            let (a, b) = ((node.low - from) / way, (node.high - from) / way);
            // A component of a ray that lies in a side of the box is no number, and `min` and `max` pass it over.
            let (near, far) = (a.min(b), a.max(b));
            let near = near.x.max(near.y).max(near.z).max(after);
            near <= far.x.min(far.y).min(far.z).min(bound)
        };
        let mut open = Open::new();
        if !self.nodes.is_empty() {
            open.push(0, 0.0);
        }
        while let Some((n, _)) = open.pop() {
            if !enters(n, bound) {
                continue;
            }
            let node = &self.nodes[n];
            if node.second != 0 {
                open.push(node.second as usize, 0.0);
                open.push(n + 1, 0.0);
                continue;
            }
            for i in node.first as usize..node.end as usize {
                if let Some(t) = hit(from, way, &self.triangles[i]).filter(|t| *t > after && *t < bound) {
                    bound = t;
                    best = Some(OnTriangle { triangle: self.numbers[i], point: from + way * t, distance: t });
                }
            }
        }
        best
    }

    /// How often the surface winds around `point`.
    pub fn winding(&self, point: Vec3) -> f32 {
        let mut sum = 0.0;
        let mut open = Open::new();
        if !self.nodes.is_empty() {
            open.push(0, 0.0);
        }
        while let Some((n, _)) = open.pop() {
            let node = &self.nodes[n];
            let to = node.centre - point;
            let away = to.length_squared();
            if away > (FAR * node.radius).powi(2) {
                sum += node.dipole.dot(to) / (away * away.sqrt());
            } else if node.second == 0 {
                let own = &self.triangles[node.first as usize..node.end as usize];
                sum += own.iter().map(|t| solid_angle(point, t)).sum::<f32>();
            } else {
                open.push(node.second as usize, 0.0);
                open.push(n + 1, 0.0);
            }
        }
        sum / (4.0 * std::f32::consts::PI)
    }
}

/// Nodes to look at. Halving makes the tree at most 32 deep for as many triangles as have numbers.
struct Open {
    nodes: [(u32, f32); 64],
    count: usize,
}

impl Open {
    fn new() -> Self {
        Self { nodes: [(0, 0.0); 64], count: 0 }
    }

    fn push(&mut self, node: usize, away: f32) {
        self.nodes[self.count] = (node as u32, away);
        self.count += 1;
    }

    fn pop(&mut self) -> Option<(usize, f32)> {
        self.count = self.count.checked_sub(1)?;
        let (node, away) = self.nodes[self.count];
        Some((node as usize, away))
    }
}

fn build(nodes: &mut Vec<Node>, entries: &mut [(u32, [Vec3; 3])], first: usize, end: usize) {
    let own = &mut entries[first..end];
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (mut dipole, mut centre, mut weight) = (Vec3::ZERO, Vec3::ZERO, 0.0);
    for (_, [a, b, c]) in own.iter() {
        low = low.min(*a).min(*b).min(*c);
        high = high.max(*a).max(*b).max(*c);
        let area = 0.5 * (*b - *a).cross(*c - *a);
        dipole += area;
        centre += (*a + *b + *c) / 3.0 * area.length();
        weight += area.length();
    }
    let centre = if weight > 0.0 { centre / weight } else { 0.5 * (low + high) };
    let reach = own.iter().flat_map(|(_, t)| t).map(|p| p.distance_squared(centre)).fold(0.0, f32::max);
    let node = nodes.len();
    let (first32, end32) = (first as u32, end as u32);
    nodes.push(Node { low, high, first: first32, end: end32, second: 0, centre, dipole, radius: reach.sqrt() });
    if own.len() <= LEAF {
        return;
    }
    let axis = (high - low).max_position();
    let half = own.len() / 2;
    let key = |(i, [a, b, c]): &(u32, [Vec3; 3])| (a[axis] + b[axis] + c[axis], *i);
    own.select_nth_unstable_by(half, |a, b| {
        let ((p, i), (q, j)) = (key(a), key(b));
        p.total_cmp(&q).then(i.cmp(&j))
    });
    build(nodes, entries, first, first + half);
    nodes[node].second = nodes.len() as u32;
    build(nodes, entries, first + half, end);
}

/// The nearest point of a triangle, by the regions of its corners, edges and inside (Ericson 2005, "Real-Time Collision
/// Detection", 5.1.5).
fn nearest_on(p: Vec3, &[a, b, c]: &[Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let whole = va + vb + vc;
    a + ab * (vb / whole) + ac * (vc / whole)
}

/// The share of each corner in a point of a triangle.
pub(crate) fn barycentric(p: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let normal = (b - a).cross(c - a);
    let whole = normal.length_squared();
    let share = |from: Vec3, to: Vec3| ((to - from).cross(p - from).dot(normal) / whole).clamp(0.0, 1.0);
    let shares = Vec3::new(share(b, c), share(c, a), share(a, b));
    let sum = shares.element_sum();
    if sum > 0.0 { shares / sum } else { Vec3::splat(1.0 / 3.0) }
}

/// Möller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".
fn hit(from: Vec3, way: Vec3, &[a, b, c]: &[Vec3; 3]) -> Option<f32> {
    let (ab, ac) = (b - a, c - a);
    let across = way.cross(ac);
    let det = ab.dot(across);
    let to = from - a;
    let u = to.dot(across) / det;
    let turned = to.cross(ab);
    let v = way.dot(turned) / det;
    // Also false for a ray along the triangle, where all are no numbers.
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| ac.dot(turned) / det)
}

/// Van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle"; positive when seen from its back.
fn solid_angle(p: Vec3, t: &[Vec3; 3]) -> f32 {
    let [a, b, c] = t.map(|v| v - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(below)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A box with outward triangles.
    pub(crate) fn cuboid(low: Vec3, high: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let pick = |c: u32, axis: usize| if c >> axis & 1 == 1 { high[axis] } else { low[axis] };
        let positions = (0..8).map(|c| Vec3::new(pick(c, 0), pick(c, 1), pick(c, 2))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        (positions, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
    }

    #[test]
    fn winding_counts_overlaps_and_holes() {
        let (mut positions, mut triangles) = cuboid(Vec3::ZERO, Vec3::splat(2.0));
        let (more, others) = cuboid(Vec3::ONE, Vec3::splat(3.0));
        triangles.extend(others.iter().map(|t| t.map(|v| v + 8)));
        positions.extend(more);
        let tree = TriangleTree::new(&positions, &triangles);
        for (at, expected) in [(0.5, 1.0), (1.5, 2.0), (2.5, 1.0), (3.5, 0.0), (-40.0, 0.0)] {
            assert!((tree.winding(Vec3::splat(at)) - expected).abs() < 0.02, "{at}");
        }
        let open = TriangleTree::new(&positions[..8], &triangles[..10]);
        assert!(open.winding(Vec3::new(0.5, 1.0, 1.0)) > 0.7);
        assert!(open.winding(Vec3::new(3.0, 1.0, 1.0)) < 0.3);
        let none = TriangleTree::new(&[], &[]);
        assert!(none.winding(Vec3::ZERO) == 0.0 && none.bounds().is_none());
        assert!(none.nearest(Vec3::ZERO, 9.0).is_none() && none.first_hit(Vec3::ZERO, Vec3::X, 0.0, 9.0).is_none());
    }

    proptest! {
        #[test]
        fn nearest_and_hit_are_those_of_all_triangles(
            numbers in proptest::collection::vec(-1.0f32..1.0, 90..270),
            at in proptest::array::uniform3(-2.0f32..2.0),
            way in proptest::array::uniform3(-1.0f32..1.0),
        ) {
            let positions: Vec<Vec3> = numbers.chunks_exact(3).map(Vec3::from_slice).collect();
            let triangles: Vec<[u32; 3]> = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let tree = TriangleTree::new(&positions, &triangles);
            let (at, way) = (Vec3::from_array(at), Vec3::from_array(way).normalize_or(Vec3::X));
            let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
            let least = triangles.iter().map(|t| nearest_on(at, &corners(t)).distance(at)).fold(f32::INFINITY, f32::min);
            let found = tree.nearest(at, 10.0).expect("there are triangles");
            prop_assert!((found.distance - least).abs() < 1e-5);
            let shares = barycentric(found.point, corners(&triangles[found.triangle as usize]));
            let [a, b, c] = corners(&triangles[found.triangle as usize]);
            prop_assert!((a * shares.x + b * shares.y + c * shares.z).distance(found.point) < 1e-2);
            let first = triangles.iter().filter_map(|t| hit(at, way, &corners(t))).filter(|t| *t > 0.0 && *t < 9.0);
            let first = first.fold(9.0, f32::min);
            prop_assert_eq!(tree.first_hit(at, way, 0.0, 9.0).map_or(9.0, |h| h.distance), first);
        }
    }
}
