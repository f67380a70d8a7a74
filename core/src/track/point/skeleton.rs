//! A skeleton through marked points, as limbs: within what looks like the thing that was marked, the cheapest ways from the
//! most central point to all others, drawn to the middle of what they run through. Ways that run into each other part
//! where limbs do, so that a leg that was marked at knee and foot only gets its hip.
//!
//! Dijkstra over a grid of a few pixels a cell; a cell costs more where it looks unlike every point (or is transparent) and
//! where that is near. Known limits: where legs hide each other on the marked frame they may be joined; a thing in the
//! colours of what is behind it has straight limbs.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec2;
use rayon::prelude::*;

use super::footage::Footage;
use crate::raster::Grid;
use crate::raster::distance::{NO_SITE, nearest_site};

/// Side of a cell in pixels of a 512 x 512 picture; three lie across a thin leg.
const CELL: f32 = 4.0;
/// How many times more a cell costs that looks unlike every point.
const UNLIKE: f32 = 8.0;
/// The difference of colour, summed over channels, from which on a cell is of no point.
const OFF: f32 = 60.0;
/// How many times more a cell costs at the border, falling with the distance from it in cells.
const BORDER: f32 = 2.0;
/// Ways that come within so many cells of a point on another way go through it; so many of another way, join it.
const THROUGH: f32 = 4.0;
const JOINED: f32 = 1.2;
/// How often ways are smoothed: steps along a grid are no directions.
const SMOOTHED: usize = 12;
/// Opacity in a description's bytes; more means that the clip has none.
const OPAQUE: u8 = 120;
/// A limb may be one of a pair if the other is at least so much as long, hangs so near, as a share of its length.
const AS_LONG: f32 = 0.6;
const AS_NEAR: f32 = 0.25;

/// A limb between two places where the skeleton ends or parts.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Branch {
    pub(super) line: Vec<Vec2>,
    /// The marked points on it: which, and at which place of the line.
    pub(super) points: Vec<(usize, usize)>,
    /// Whether other limbs hang from its first and its last place.
    joined: [bool; 2],
}

impl Branch {
    fn length(&self) -> f32 {
        crate::geometry::polyline::length(&self.line)
    }

    /// Where it hangs and where it ends, if it hangs by one end.
    fn hung(&self) -> Option<[Vec2; 2]> {
        let ends = [self.line[0], self.line[self.line.len() - 1]];
        match self.joined {
            [true, false] => Some(ends),
            [false, true] => Some([ends[1], ends[0]]),
            _ => None,
        }
    }
}

/// The limbs through points `at` places of `frame`.
pub(super) fn branches(footage: &Footage, frame: usize, at: &[Vec2]) -> Vec<Branch> {
    let land = Land::new(footage, frame, at);
    let ways: Vec<Ways> = at.par_iter().map(|p| land.ways(*p)).collect();
    let far = |i: usize| at.iter().map(|p| ways[i].cost[land.cell(*p)]).sum::<f32>();
    let all: Vec<f32> = (0..at.len()).map(far).collect();
    let Some(root) = (0..at.len()).min_by(|&a, &b| all[a].total_cmp(&all[b])) else { return Vec::new() };
    let ways = &ways[root];
    let mut order: Vec<usize> = (0..at.len()).filter(|&i| i != root).collect();
    let cost = |i: usize| ways.cost[land.cell(at[i])];
    order.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)).then(a.cmp(&b)));
    let mut net = Net { places: vec![at[root]], points: vec![Some(root)], joined: vec![Vec::new()] };
    for i in order {
        net.add(i, at[i], &land.trace(ways, at[i]), land.side);
    }
    net.branches()
}

/// Pairs of limbs of one kind: about as long, hung near each other; those with the nearest ends first.
pub(super) fn pairs(branches: &[Branch]) -> Vec<[usize; 2]> {
    let mut found: Vec<(f32, [usize; 2])> = Vec::new();
    for (i, a) in branches.iter().enumerate() {
        for (j, b) in branches.iter().enumerate().skip(i + 1) {
            let Some((a_ends, b_ends)) = a.hung().zip(b.hung()) else { continue };
            let (short, long) = (a.length().min(b.length()), a.length().max(b.length()));
            if short > AS_LONG * long && a_ends[0].distance(b_ends[0]) < AS_NEAR * long {
                found.push((a_ends[1].distance(b_ends[1]) / long, [i, j]));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for (_, pair) in found {
        if !pairs.iter().flatten().any(|l| pair.contains(l)) {
            pairs.push(pair);
        }
    }
    pairs
}

/// What it costs to go through each cell.
struct Land {
    /// Side of a cell in working pixels.
    side: f32,
    cost: Grid<f32>,
}

/// The cheapest ways from one place: what it costs to get to each cell, and the cell before it.
struct Ways {
    cost: Vec<f32>,
    before: Vec<usize>,
}

impl Land {
    fn new(footage: &Footage, frame: usize, at: &[Vec2]) -> Self {
        let picture = &footage.pictures[frame];
        let side = (CELL * footage.unit).max(1.0);
        let [width, height] = [footage.size.x, footage.size.y].map(|s| ((s / side).ceil() as usize).max(1));
        let level = (side.log2().round() as usize).min(super::looks::LEVELS - 1);
        let colours: Vec<[u8; 4]> = at.iter().map(|p| picture.at(1, *p)).collect();
        let cells: Vec<[u8; 4]> = (0..width * height)
            .map(|i| picture.at(level, Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5) * side))
            .collect();
        let cut_out = cells.iter().any(|c| c[3] < OPAQUE / 2);
        let unlike = |c: &[u8; 4]| {
            if cut_out {
                return 1.0 - f32::from(c[3].min(OPAQUE)) / f32::from(OPAQUE);
            }
            let gap = |p: &[u8; 4]| (0..3).map(|k| f32::from(p[k].abs_diff(c[k]))).sum::<f32>();
            (colours.iter().map(gap).fold(f32::INFINITY, f32::min) / OFF).min(1.0)
        };
        let unlike: Vec<f32> = cells.par_iter().map(unlike).collect();
        // Beyond the picture is no part of the thing either.
        let mut sites = Grid::new(width + 2, height + 2, NO_SITE);
        for y in 0..height + 2 {
            for x in 0..width + 2 {
                let within = (1..=width).contains(&x) && (1..=height).contains(&y);
                if !within || unlike[(y - 1) * width + x - 1] >= 0.5 {
                    sites.set(x, y, (y * (width + 2) + x) as u32);
                }
            }
        }
        let nearest = nearest_site(&sites);
        let cost = (0..width * height).map(|i| {
            let (x, y) = (i % width + 1, i / width + 1);
            let site = nearest.get(x, y) as usize;
            let (dx, dy) = ((site % (width + 2)).abs_diff(x) as f32, (site / (width + 2)).abs_diff(y) as f32);
            (1.0 + UNLIKE * unlike[i]) * (1.0 + BORDER / (1.0 + dx.hypot(dy)))
        });
        Self { side, cost: Grid::from_vec(width, height, cost.collect()) }
    }

    fn cell(&self, p: Vec2) -> usize {
        let place = |v: f32, count: usize| ((v / self.side).max(0.0) as usize).min(count - 1);
        place(p.y, self.cost.height()) * self.cost.width() + place(p.x, self.cost.width())
    }

    fn ways(&self, from: Vec2) -> Ways {
        let (width, height) = (self.cost.width(), self.cost.height());
        let through = self.cost.data();
        let start = self.cell(from);
        let mut ways = Ways { cost: vec![f32::INFINITY; width * height], before: vec![start; width * height] };
        ways.cost[start] = 0.0;
        // Costs are not negative, so their bits rise with them.
        let mut open = BinaryHeap::from([Reverse((0u32, start))]);
        while let Some(Reverse((bits, here))) = open.pop() {
            let cost = f32::from_bits(bits);
            if cost > ways.cost[here] {
                continue;
            }
            let (x, y) = ((here % width) as isize, (here / width) as isize);
            for (dx, dy) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
                let (nx, ny) = (x + dx, y + dy);
                if nx < 0 || ny < 0 || nx >= width as isize || ny >= height as isize {
                    continue;
                }
                let next = ny as usize * width + nx as usize;
                let step = if dx != 0 && dy != 0 { std::f32::consts::SQRT_2 } else { 1.0 };
                let there = cost + step * 0.5 * (through[here] + through[next]);
                if there < ways.cost[next] {
                    (ways.cost[next], ways.before[next]) = (there, here);
                    open.push(Reverse((there.to_bits(), next)));
                }
            }
        }
        ways
    }

    /// From `p` back to where the ways start, in places.
    fn trace(&self, ways: &Ways, p: Vec2) -> Vec<Vec2> {
        let width = self.cost.width();
        let mut here = self.cell(p);
        let mut out = vec![p];
        while ways.before[here] != here {
            here = ways.before[here];
            out.push(self.side * (Vec2::new((here % width) as f32, (here / width) as f32) + 0.5));
        }
        out
    }
}

/// Ways that were laid, as places and what joins them.
struct Net {
    places: Vec<Vec2>,
    points: Vec<Option<usize>>,
    joined: Vec<Vec<usize>>,
}

impl Net {
    /// Lays the way from point `point` to where it meets what was laid before.
    fn add(&mut self, point: usize, at: Vec2, way: &[Vec2], side: f32) {
        let mut fresh: Vec<Vec2> = Vec::new();
        let mut met = 0;
        for p in way {
            let near = |reach: f32, marked: bool| {
                let all = self.places.iter().enumerate().filter(|(k, _)| !marked || self.points[*k].is_some());
                let all = all.map(|(k, q)| (q.distance(*p), k)).filter(|(d, _)| *d < reach * side);
                all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k)| k)
            };
            if let Some(k) = near(THROUGH, true).or_else(|| near(JOINED, false)) {
                met = k;
                break;
            }
            fresh.push(*p);
        }
        if fresh.is_empty() {
            fresh.push(at);
        }
        for p in fresh.iter().rev() {
            let new = self.places.len();
            self.places.push(*p);
            self.points.push(None);
            self.joined.push(vec![met]);
            self.joined[met].push(new);
            met = new;
        }
        self.points[met] = Some(point);
    }

    fn branches(&self) -> Vec<Branch> {
        let mut branches = Vec::new();
        for start in (0..self.places.len()).filter(|&i| self.joined[i].len() != 2) {
            for &next in &self.joined[start] {
                let (mut path, mut here) = (vec![start], next);
                while let [a, b] = self.joined[here][..] {
                    let before = path[path.len() - 1];
                    path.push(here);
                    here = if a == before { b } else { a };
                }
                path.push(here);
                if start < here {
                    branches.push(self.branch(&path));
                }
            }
        }
        branches
    }

    fn branch(&self, path: &[usize]) -> Branch {
        let mut line: Vec<Vec2> = path.iter().map(|&i| self.places[i]).collect();
        for _ in 0..SMOOTHED {
            let before = line.clone();
            for i in 1..line.len() - 1 {
                if self.points[path[i]].is_none() {
                    line[i] = 0.25 * (before[i - 1] + before[i + 1]) + 0.5 * before[i];
                }
            }
        }
        let points = path.iter().enumerate().filter_map(|(k, &i)| Some((self.points[i]?, k))).collect();
        let ends = [path[0], path[path.len() - 1]];
        Branch { line, points, joined: ends.map(|e| self.joined[e].len() > 1) }
    }
}
