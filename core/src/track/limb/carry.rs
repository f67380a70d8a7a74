//! Carrying a limb to a neighbouring frame by dense flow.
//!
//! All pixels across the limb's width carry its motion, not one on the axis: every vertex moves by a robust mean of
//! the flow around it, weighted by forward-backward agreement, and the limb as a whole stays as rigid as its vertices'
//! trust demands (as-rigid-as-possible chain: local rotations and a banded solve in turns; Sorkine, Alexa 2007).

use glam::Vec2;

use crate::geometry::polyline;
use crate::track::flow::FlowField;

/// Forward-backward disagreement in working pixels at which a flow vector loses half its weight.
const DISAGREEMENT: f32 = 1.5;
/// Weight of an edge's shape against a fully trusted vertex.
const RIGIDITY: f32 = 0.7;
/// Trust that remains where the flow says nothing.
const LEAST_TRUST: f32 = 0.02;

/// A limb after the carry.
#[derive(Clone, Debug)]
pub(super) struct Carried {
    pub(super) points: Vec<Vec2>,
    /// How far the flow agreed at each vertex, in 0..=1.
    pub(super) trust: Vec<f32>,
    /// By what factor the flow lengthened the limb, as far as it is trusted.
    pub(super) stretch: f32,
}

/// Moves `pose` along `flow` (`back` leads back). `radii` are the limb's half widths at the vertices, `lengths` the
/// edges' lengths in the frame it goes to. `root` is where the first vertex ends, where that is known.
pub(super) fn carry(
    pose: &[Vec2],
    radii: &[f32],
    lengths: &[f32],
    flow: &FlowField,
    back: &FlowField,
    root: Option<Vec2>,
) -> Carried {
    let tangents = polyline::tangents(pose);
    let mut targets = Vec::with_capacity(pose.len());
    let mut trust = Vec::with_capacity(pose.len());
    for i in 0..pose.len() {
        let (motion, weight) = motion_around(pose, &tangents, radii, i, flow, back);
        targets.push(pose[i] + motion);
        trust.push(weight);
    }
    let stretch = stretch(pose, &targets, &trust);
    let points = rigid_chain(pose, &targets, &trust, lengths, root);
    Carried { points, trust, stretch }
}

/// The change of distances between vertices a few apart, tempered by how far both ends are trusted.
fn stretch(pose: &[Vec2], targets: &[Vec2], trust: &[f32]) -> f32 {
    let span = (pose.len() / 3).max(1);
    let (mut before, mut after, mut weight, mut pairs) = (1e-6, 1e-6, 0.0, 0.0);
    for i in 0..pose.len() - span {
        let w = trust[i] * trust[i + span];
        before += w * pose[i].distance(pose[i + span]);
        after += w * targets[i].distance(targets[i + span]);
        weight += w;
        pairs += 1.0;
    }
    1.0 + (after / before - 1.0) * weight / pairs
}

/// The robust mean flow over the limb's width around vertex `i`, and how far its samples agree forward and back.
fn motion_around(
    pose: &[Vec2],
    tangents: &[Vec2],
    radii: &[f32],
    i: usize,
    flow: &FlowField,
    back: &FlowField,
) -> (Vec2, f32) {
    let last = pose.len() - 1;
    let normal = tangents[i].perp();
    let mut samples = [(Vec2::ZERO, 0.0f32); 15];
    let mut n = 0;
    for along in [-0.5f32, 0.0, 0.5] {
        let to = if along < 0.0 { i.saturating_sub(1) } else { (i + 1).min(last) };
        let centre = pose[i].lerp(pose[to], along.abs());
        for across in [-0.6f32, -0.3, 0.0, 0.3, 0.6] {
            let p = centre + normal * (across * radii[i]);
            let there = flow.at(p);
            let miss = (there + back.at(p + there)).length() / DISAGREEMENT;
            samples[n] = (there, 1.0 / (1.0 + miss * miss));
            n += 1;
        }
    }
    let trust = samples.iter().map(|s| s.1).sum::<f32>() / n as f32;
    // A weighted geometric median by re-weighting (Weiszfeld).
    let mut mean = Vec2::ZERO;
    for round in 0..6 {
        let (mut sum, mut weight) = (Vec2::ZERO, 1e-6);
        let mut weights = [0.0; 15];
        for (weight, (v, w)) in weights.iter_mut().zip(samples) {
            *weight = if round == 0 { w } else { w / (v.distance(mean) + 0.3) };
        }
        for ((v, _), w) in samples.iter().zip(weights) {
            sum += *v * w;
            weight += w;
        }
        mean = sum / weight;
    }
    (mean, trust)
}

/// The chain nearest to `targets` that keeps the shape of `pose` with edges of `lengths`.
pub(super) fn rigid_chain(
    pose: &[Vec2],
    targets: &[Vec2],
    trust: &[f32],
    lengths: &[f32],
    root: Option<Vec2>,
) -> Vec<Vec2> {
    let n = pose.len();
    let mut points = targets.to_vec();
    if let Some(root) = root {
        points[0] = root;
    }
    let rest: Vec<Vec2> = pose
        .windows(2)
        .zip(lengths)
        .map(|(p, &length)| (p[1] - p[0]).try_normalize().unwrap_or(Vec2::X) * length)
        .collect();
    let mut edges = rest.clone();
    for _ in 0..4 {
        for e in 0..n - 1 {
            // The rotation of the edge's neighbourhood, from its own motion and its neighbours'.
            let mut turn = Vec2::new(1e-6, 0.0);
            for near in e.saturating_sub(2)..(e + 3).min(n - 1) {
                let moved = points[near + 1] - points[near];
                let weight = (trust[near] + trust[near + 1] + LEAST_TRUST) / (1.0 + near.abs_diff(e) as f32);
                turn += weight * Vec2::new(rest[near].dot(moved), rest[near].perp_dot(moved));
            }
            edges[e] = turn.normalize_or(Vec2::X).rotate(rest[e]);
        }
        points = banded(targets, trust, &edges, root);
    }
    points
}

/// Minimises trust-weighted distance to `targets` plus edge differences to `edges`: a tridiagonal system.
fn banded(targets: &[Vec2], trust: &[f32], edges: &[Vec2], root: Option<Vec2>) -> Vec<Vec2> {
    let n = targets.len();
    let mut diagonal = vec![0.0f32; n];
    let mut right = vec![Vec2::ZERO; n];
    for i in 0..n {
        let (weight, target) = match root {
            Some(root) if i == 0 => (1e3, root),
            _ => (trust[i] + LEAST_TRUST, targets[i]),
        };
        diagonal[i] += weight;
        right[i] += weight * target;
        if i + 1 < n {
            diagonal[i] += RIGIDITY;
            diagonal[i + 1] += RIGIDITY;
            right[i] -= RIGIDITY * edges[i];
            right[i + 1] += RIGIDITY * edges[i];
        }
    }
    // Thomas' algorithm; the off-diagonals are all -RIGIDITY and the system is diagonally dominant.
    for i in 1..n {
        let factor = -RIGIDITY / diagonal[i - 1];
        diagonal[i] += factor * RIGIDITY;
        let above = right[i - 1];
        right[i] -= factor * above;
    }
    let mut points = vec![Vec2::ZERO; n];
    for i in (0..n).rev() {
        let below = if i + 1 < n { RIGIDITY * points[i + 1] } else { Vec2::ZERO };
        points[i] = (right[i] + below) / diagonal[i];
    }
    points
}
