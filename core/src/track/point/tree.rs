//! The tree of marked points that move together, and its branches as limbs.
//!
//! The cheapest spanning tree (Prim), where an edge costs its length, more where what lies between looks unlike either
//! end (background) and more where the ends changed their distance as each was tracked alone. Known limit: points of two
//! legs that touch and have not parted yet may be joined.

use glam::Vec2;

use super::footage::Footage;
use super::stretch::Place;

/// How many times its length an edge costs more where all of it looks unlike its ends.
const UNLIKE: f32 = 8.0;
/// And where the ends' distance changed by all of itself.
const CHANGED: f32 = 20.0;
/// The difference of colour, summed over channels, from which on what lies between is not of either end.
const OFF: f32 = 60.0;
/// Places looked at between two ends.
const BETWEEN: usize = 15;
/// Distances are compared as if longer by so many pixels of a 512 x 512 picture, as near points are marked inexactly.
const INEXACT: f32 = 4.0;

/// The edges of the tree over points `at` places of `frame`; `ways` are what was found for each alone.
fn edges(footage: &Footage, frame: usize, at: &[Vec2], ways: &[Vec<Place>]) -> Vec<(usize, usize)> {
    let mut near = vec![(f32::INFINITY, 0); at.len()];
    let mut outside: Vec<usize> = (1..at.len()).collect();
    let mut edges = Vec::with_capacity(outside.len());
    let mut last = 0;
    while !outside.is_empty() {
        for &i in &outside {
            let cost = cost(footage, frame, [at[last], at[i]], [&ways[last], &ways[i]]);
            if cost < near[i].0 {
                near[i] = (cost, last);
            }
        }
        let next = (0..outside.len()).min_by(|&a, &b| near[outside[a]].0.total_cmp(&near[outside[b]].0));
        last = outside.remove(next.unwrap_or(0));
        edges.push((near[last].1, last));
    }
    edges
}

fn cost(footage: &Footage, frame: usize, [a, b]: [Vec2; 2], ways: [&[Place]; 2]) -> f32 {
    let picture = &footage.pictures[frame];
    let colour = |p: Vec2| picture.at(1, p);
    let ends = [colour(a), colour(b)];
    let unlike = (1..=BETWEEN).map(|k| {
        let here = colour(a.lerp(b, k as f32 / (BETWEEN + 1) as f32));
        let gap = |end: &[u8; 4]| (0..4).map(|c| f32::from(end[c].abs_diff(here[c]))).sum::<f32>();
        (ends.iter().map(gap).fold(f32::INFINITY, f32::min) / OFF).min(1.0)
    });
    let unlike = unlike.sum::<f32>() / BETWEEN as f32;
    let length = a.distance(b);
    // What is never seen surely says nothing.
    let (mut changed, mut sure) = (0.0, 0.01);
    for (p, q) in ways[0].iter().zip(ways[1]) {
        let weight = (p.confidence * q.confidence).powi(2);
        let change = (p.at.distance(q.at) - length).abs() / (length + INEXACT * footage.unit);
        changed += weight * change.min(1.0);
        sure += weight;
    }
    length * (1.0 + UNLIKE * unlike + CHANGED * changed / sure)
}

/// The paths of the tree between its leaves and the points where it branches.
pub(super) fn branches(footage: &Footage, frame: usize, at: &[Vec2], ways: &[Vec<Place>]) -> Vec<Vec<usize>> {
    let mut joined = vec![Vec::new(); at.len()];
    for (a, b) in edges(footage, frame, at, ways) {
        joined[a].push(b);
        joined[b].push(a);
    }
    let mut branches = Vec::new();
    for start in (0..at.len()).filter(|&i| joined[i].len() != 2) {
        for &next in &joined[start] {
            let (mut path, mut here) = (vec![start], next);
            while let [a, b] = joined[here][..] {
                let before = path[path.len() - 1];
                path.push(here);
                here = if a == before { b } else { a };
            }
            path.push(here);
            if start < here {
                branches.push(path);
            }
        }
    }
    branches
}
