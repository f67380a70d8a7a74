//! The curve skeleton of a silhouette, and the joints that it proposes.
//!
//! The middle line by thinning; branches that end within the disc around the place they leave from are spurs of the
//! outline and go, one after the other, the shortest first; what is left is smoothed. Joints are proposed at ends, where
//! branches meet, and where a branch bends. A circle is opened where the drawing is thinnest.

use glam::{Vec2, vec2};

use super::skeleton::{Joint, Skeleton};
use crate::error::Result;
use crate::geometry::{polygon, polyline};
use crate::job::Stage;
use crate::raster::distance::distance_to;
use crate::raster::morphology::{parts, without_holes};
use crate::raster::thinning::thin;
use crate::raster::{Grid, Mask};

/// The longer side that is thinned: finer pictures only add noise to the line.
const WORKING: usize = 400;
/// A branch whose end reaches less far beyond the disc it leaves from than this share of the disc's radius is a spur.
const SPUR: f32 = 0.6;
/// A branch bends where it leaves its chord by this share of its mean radius, but at least this share of its length.
const BEND: (f32, f32) = (0.42, 0.05);
/// Holes below this share of the drawing are closed before thinning: a line around every eye helps nobody.
const HOLE: f64 = 0.01;
/// Pieces below this share of the largest get no bones; they follow the nearest ones.
const BONELESS: f64 = 0.05;

/// A branch of the curve skeleton: its line, and how far the outline is all along it.
#[derive(Clone, Debug)]
pub(super) struct Branch {
    pub(super) nodes: [usize; 2],
    pub(super) points: Vec<Vec2>,
    radius: Vec<f32>,
}

/// The curve skeleton: branches between nodes.
#[derive(Clone, Debug, Default)]
pub(crate) struct CurveSkeleton {
    pub(super) branches: Vec<Branch>,
}

impl CurveSkeleton {
    /// The curve skeleton of `mask`, in its pixels.
    pub(crate) fn of(mask: &Mask, stage: Stage<'_>) -> Result<Self> {
        let shrink = mask.width().max(mask.height()).div_ceil(WORKING).max(1);
        let (width, height) = (mask.width().div_ceil(shrink) + 2, mask.height().div_ceil(shrink) + 2);
        // One working pixel wide around, and in where any pixel of its square is: a limb of one pixel stays whole.
        let small = Mask::from_fn(width, height, |x, y| {
            let from = |v: usize| (v as isize - 1) * shrink as isize;
            (0..shrink * shrink).any(|i| mask.at(from(x) + (i % shrink) as isize, from(y) + (i / shrink) as isize))
        });
        let small = without_holes(&small, (small.count() as f64 * HOLE) as usize);
        let small = boned(&small);
        let radius = distance_to(&small, false);
        let mut rounds = 0;
        let line = thin(&small, || {
            rounds += 1;
            stage.at(rounds as f64 / (rounds + 20) as f64)
        })?;
        let mut own = Self::trace(&line, &radius);
        own.prune();
        own.open_circles();
        own.replace_lone_points(&small);
        let place = |p: Vec2| (p - 1.0) * shrink as f32;
        for branch in &mut own.branches {
            branch.points = smooth(&branch.points).into_iter().map(place).collect();
            branch.radius.iter_mut().for_each(|r| *r *= shrink as f32);
        }
        Ok(own)
    }

    /// Branches from node to node of a line one pixel wide.
    fn trace(line: &Mask, radius: &Grid<f32>) -> Self {
        const AROUND: [(isize, isize); 8] = [(0, -1), (1, 0), (0, 1), (-1, 0), (1, -1), (1, 1), (-1, 1), (-1, -1)];
        let (width, height) = (line.width(), line.height());
        let neighbours = |x: usize, y: usize| {
            let near = |dx: isize, dy: isize| line.at(x as isize + dx, y as isize + dy);
            AROUND
                .into_iter()
                .filter(|&(dx, dy)| near(dx, dy))
                // A corner that is also reached along a side is no neighbour of its own.
                .filter(|&(dx, dy)| dx == 0 || dy == 0 || !(near(dx, 0) || near(0, dy)))
                .map(|(dx, dy)| (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy)))
                .collect::<Vec<_>>()
        };
        let inside: Vec<(usize, usize)> =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|&(x, y)| line.get(x, y)).collect();
        let mut node = Grid::new(width, height, usize::MAX);
        let mut nodes = 0;
        // Junction pixels that touch are one node.
        for &(x, y) in &inside {
            if neighbours(x, y).len() == 2 || node.get(x, y) != usize::MAX {
                continue;
            }
            let mut waiting = vec![(x, y)];
            node.set(x, y, nodes);
            while let Some((x, y)) = waiting.pop() {
                for (nx, ny) in neighbours(x, y) {
                    if node.get(nx, ny) == usize::MAX && neighbours(nx, ny).len() > 2 && neighbours(x, y).len() > 2 {
                        node.set(nx, ny, nodes);
                        waiting.push((nx, ny));
                    }
                }
            }
            nodes += 1;
        }
        // A circle without any node gets one below.
        let mut used = Mask::new(width, height);
        let mut branches = Vec::new();
        for round in 0..2 {
            for &start in &inside {
                if round == 1 && !used.get(start.0, start.1) && node.get(start.0, start.1) == usize::MAX {
                    node.set(start.0, start.1, nodes);
                    nodes += 1;
                }
                let from = node.get(start.0, start.1);
                if from == usize::MAX {
                    continue;
                }
                for second in neighbours(start.0, start.1) {
                    let to = node.get(second.0, second.1);
                    let fresh = if to == usize::MAX { !used.get(second.0, second.1) } else { to > from && round == 0 };
                    if !fresh {
                        continue;
                    }
                    let mut pixels = vec![start, second];
                    while node.get(pixels[pixels.len() - 1].0, pixels[pixels.len() - 1].1) == usize::MAX {
                        let (at, last) = (pixels[pixels.len() - 1], pixels[pixels.len() - 2]);
                        used.set(at.0, at.1, true);
                        let Some(next) = neighbours(at.0, at.1).into_iter().find(|p| *p != last) else { break };
                        pixels.push(next);
                    }
                    let end = pixels[pixels.len() - 1];
                    branches.push(Branch {
                        nodes: [from, node.get(end.0, end.1)],
                        points: pixels.iter().map(|p| vec2(p.0 as f32 + 0.5, p.1 as f32 + 0.5)).collect(),
                        radius: pixels.iter().map(|p| radius.get(p.0, p.1)).collect(),
                    });
                }
            }
        }
        let mut own = Self { branches };
        own.centre_nodes();
        own
    }

    /// Branches that meet in one node end at one place: the middle of its pixels.
    fn centre_nodes(&mut self) {
        let mut sums: std::collections::BTreeMap<usize, (Vec2, f32)> = std::collections::BTreeMap::new();
        for branch in &self.branches {
            for (node, p) in branch.nodes.iter().zip([branch.points[0], branch.points[branch.points.len() - 1]]) {
                let sum = sums.entry(*node).or_default();
                *sum = (sum.0 + p, sum.1 + 1.0);
            }
        }
        for branch in &mut self.branches {
            let last = branch.points.len() - 1;
            for (node, at) in branch.nodes.iter().zip([0, last]) {
                let (sum, count) = sums[node];
                branch.points[at] = sum / count;
            }
        }
    }

    fn degree(&self, node: usize) -> usize {
        self.branches.iter().flat_map(|b| b.nodes).filter(|n| *n == node).count()
    }

    /// Takes away spurs, and joins what then runs on.
    fn prune(&mut self) {
        loop {
            let spur = (0..self.branches.len())
                .filter_map(|i| {
                    let branch = &self.branches[i];
                    let at_end = branch.nodes.map(|n| self.degree(n) == 1);
                    let hub = match at_end {
                        [true, false] => branch.radius[branch.radius.len() - 1],
                        [false, true] => branch.radius[0],
                        _ => return None,
                    };
                    let reach =
                        polyline::length(&branch.points) + branch.radius.iter().copied().fold(f32::MAX, f32::min);
                    (reach < (1.0 + SPUR) * hub).then_some((reach / hub, i))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let Some((_, spur)) = spur else { break };
            let nodes = self.branches.remove(spur).nodes;
            nodes.into_iter().for_each(|n| self.join(n));
        }
    }

    /// Makes one branch of the two that meet at `node`, where no other does.
    fn join(&mut self, node: usize) {
        let meeting: Vec<usize> =
            (0..self.branches.len()).filter(|&i| self.branches[i].nodes.contains(&node)).collect();
        let &[a, b] = &meeting[..] else { return };
        let mut second = self.branches.remove(b);
        let first = &mut self.branches[a];
        if first.nodes[0] == first.nodes[1] || second.nodes[0] == second.nodes[1] {
            self.branches.insert(b, second);
            return;
        }
        if first.nodes[0] == node {
            first.reverse();
        }
        if second.nodes[1] == node {
            second.reverse();
        }
        first.points.extend(&second.points[1..]);
        first.radius.extend(&second.radius[1..]);
        first.nodes[1] = second.nodes[1];
    }

    /// Opens every circle at one end of its thinnest branch.
    fn open_circles(&mut self) {
        let mean = |b: &Branch| b.radius.iter().sum::<f32>() / b.radius.len() as f32;
        let mut order: Vec<usize> = (0..self.branches.len()).collect();
        order.sort_by(|&a, &b| mean(&self.branches[b]).total_cmp(&mean(&self.branches[a])).then(a.cmp(&b)));
        let mut fresh = 1 + self.branches.iter().flat_map(|b| b.nodes).max().unwrap_or(0);
        let mut tree: Vec<usize> = (0..fresh + self.branches.len()).collect();
        for i in order {
            let [a, b] = self.branches[i].nodes.map(|n| tree[n]);
            if a == b {
                // Short of the node it came back to, so that two joints are not on one spot.
                let branch = &mut self.branches[i];
                branch.nodes[1] = fresh;
                let keep = (branch.points.len() * 4 / 5).max(2);
                branch.points.truncate(keep);
                branch.radius.truncate(keep);
                fresh += 1;
            } else {
                tree.iter_mut().filter(|t| **t == b).for_each(|t| *t = a);
            }
        }
    }

    /// A piece as round as its middle line is a point gets a branch along its longer axis.
    fn replace_lone_points(&mut self, mask: &Mask) {
        let parts = parts(mask);
        let mut lined = vec![false; parts.areas.len() + 1];
        for branch in &self.branches {
            if polyline::length(&branch.points) >= 2.0 {
                let p = branch.points[0];
                lined[parts.labels.clamped(p.x as isize, p.y as isize) as usize] = true;
            }
        }
        self.branches.retain(|b| polyline::length(&b.points) >= 2.0);
        let mut fresh = 1 + self.branches.iter().flat_map(|b| b.nodes).max().unwrap_or(0);
        for part in (1..=parts.areas.len()).filter(|&p| !lined[p]) {
            let (mut sum, mut square) = (glam::DVec2::ZERO, glam::DMat2::ZERO);
            let count = parts.areas[part - 1] as f64;
            let pixels = || (0..mask.height()).flat_map(|y| (0..mask.width()).map(move |x| (x, y)));
            for (x, y) in pixels().filter(|&(x, y)| parts.labels.get(x, y) as usize == part) {
                let p = glam::dvec2(x as f64 + 0.5, y as f64 + 0.5);
                sum += p;
                square += glam::DMat2::from_cols(p * p.x, p * p.y);
            }
            let middle = sum / count;
            let spread = square * (1.0 / count) - glam::DMat2::from_cols(middle * middle.x, middle * middle.y);
            let angle = 0.5 * (2.0 * spread.x_axis.y).atan2(spread.x_axis.x - spread.y_axis.y);
            let axis = glam::DVec2::from_angle(angle);
            // Of an ellipse, its half axis is twice the deviation.
            let reach = 1.4 * axis.dot(spread * axis).max(0.25).sqrt();
            let points = [-1.0, 0.0, 1.0].map(|t| (middle + axis * (t * reach)).as_vec2()).to_vec();
            self.branches.push(Branch { nodes: [fresh, fresh + 1], radius: vec![reach as f32; 3], points });
            fresh += 2;
        }
    }

    /// Joints at ends, where branches meet and where they bend; the widest place of each tree is its root.
    pub(crate) fn joints(&self) -> Result<Skeleton> {
        let mut skeleton = Skeleton::default();
        let mut joint_of = std::collections::BTreeMap::new();
        let mut radius_of: Vec<f32> = Vec::new();
        let name = |i: usize| format!("joint{i}");
        for branch in &self.branches {
            let mean = branch.radius.iter().sum::<f32>() / branch.radius.len() as f32;
            let tolerance = (BEND.0 * mean).max(BEND.1 * polyline::length(&branch.points));
            let bends = bends(&branch.points, tolerance);
            let mut last = None;
            for (k, &at) in bends.iter().enumerate() {
                let node =
                    if k == 0 { Some(branch.nodes[0]) } else { (k + 1 == bends.len()).then_some(branch.nodes[1]) };
                let known = node.and_then(|n| joint_of.get(&n).copied());
                let joint = known.unwrap_or_else(|| {
                    let i = skeleton.joints.len();
                    skeleton.joints.push(Joint { name: name(i), at: branch.points[at] });
                    radius_of.push(branch.radius[at.min(branch.radius.len() - 1)]);
                    if let Some(n) = node {
                        joint_of.insert(n, i);
                    }
                    i
                });
                if let Some(last) = last {
                    skeleton.bones.push([last, joint]);
                }
                last = Some(joint);
            }
        }
        contract(&mut skeleton, &mut radius_of);
        root_at_widest(&mut skeleton, &radius_of);
        for (i, joint) in skeleton.joints.iter_mut().enumerate() {
            joint.name = name(i);
        }
        skeleton.checked()
    }
}

impl Branch {
    fn reverse(&mut self) {
        self.nodes.reverse();
        self.points.reverse();
        self.radius.reverse();
    }
}

/// Where two meeting places lie within the disc of one, they are one joint.
fn contract(skeleton: &mut Skeleton, radius: &mut Vec<f32>) {
    let degree = |s: &Skeleton, j: usize| s.bones.iter().flatten().filter(|k| **k == j).count();
    loop {
        let near = skeleton.bones.iter().position(|&[a, b]| {
            let gap = skeleton.joints[a].at.distance(skeleton.joints[b].at);
            let hubs = degree(skeleton, a) > 2 && degree(skeleton, b) > 2;
            let bend = degree(skeleton, a) > 1 && degree(skeleton, b) > 1;
            (hubs && gap < 0.7 * radius[a].max(radius[b])) || (bend && gap < 0.4 * radius[a].max(radius[b]))
        });
        let Some(bone) = near else { break };
        let [a, b] = skeleton.bones.remove(bone);
        let (kept, gone) = if degree(skeleton, a) >= degree(skeleton, b) { (a, b) } else { (b, a) };
        if degree(skeleton, a) > 1 && degree(skeleton, b) > 1 && degree(skeleton, kept) == degree(skeleton, gone) {
            skeleton.joints[kept].at = skeleton.joints[a].at.midpoint(skeleton.joints[b].at);
        }
        skeleton.bones.iter_mut().flatten().filter(|j| **j == gone).for_each(|j| *j = kept);
        skeleton.joints.remove(gone);
        radius.remove(gone);
        skeleton.bones.iter_mut().flatten().filter(|j| **j > gone).for_each(|j| *j -= 1);
    }
}

/// Orders the bones so that each tree begins at its widest joint where branches meet, or else at its widest.
fn root_at_widest(skeleton: &mut Skeleton, radius: &[f32]) {
    let degree: Vec<usize> =
        (0..radius.len()).map(|j| skeleton.bones.iter().flatten().filter(|k| **k == j).count()).collect();
    let mut order: Vec<usize> = (0..radius.len()).collect();
    order.sort_by(|&a, &b| (degree[b] > 2).cmp(&(degree[a] > 2)).then(radius[b].total_cmp(&radius[a])).then(a.cmp(&b)));
    let mut reached = vec![false; radius.len()];
    let mut bones = Vec::with_capacity(skeleton.bones.len());
    for root in order {
        if std::mem::replace(&mut reached[root], true) {
            continue;
        }
        let mut waiting = std::collections::VecDeque::from([root]);
        while let Some(joint) = waiting.pop_front() {
            for &[a, b] in &skeleton.bones {
                let other = if a == joint { b } else { a };
                if (a == joint || b == joint) && !reached[other] {
                    reached[other] = true;
                    bones.push([joint, other]);
                    waiting.push_back(other);
                }
            }
        }
    }
    skeleton.bones = bones;
}

/// Indices of the points that a polyline bends at by more than `tolerance` (Douglas and Peucker 1973), with both ends.
fn bends(points: &[Vec2], tolerance: f32) -> Vec<usize> {
    let mut kept = vec![0, points.len() - 1];
    let mut waiting = vec![(0, points.len() - 1)];
    while let Some((from, to)) = waiting.pop() {
        let off = |i: &usize| polygon::nearest_on_segment(points[from], points[to], points[*i]).1.distance(points[*i]);
        let far = (from + 1..to).map(|i| (off(&i), i)).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        if let Some((gap, at)) = far
            && gap > tolerance
        {
            kept.push(at);
            waiting.extend([(from, at), (at, to)]);
        }
    }
    kept.sort_unstable();
    kept
}

/// The line without its pixels' steps; its ends stay.
fn smooth(points: &[Vec2]) -> Vec<Vec2> {
    let mut out = points.to_vec();
    for _ in 0..6 {
        let before = out.clone();
        for i in 1..out.len().saturating_sub(1) {
            out[i] = 0.25 * (before[i - 1] + before[i + 1]) + 0.5 * before[i];
        }
    }
    out
}

/// The pieces that get bones.
fn boned(mask: &Mask) -> Mask {
    let parts = parts(mask);
    let least = parts.areas.iter().copied().max().unwrap_or(0) as f64 * BONELESS;
    Mask::from_fn(mask.width(), mask.height(), |x, y| {
        let part = parts.labels.get(x, y) as usize;
        part > 0 && parts.areas[part - 1] as f64 >= least
    })
}
