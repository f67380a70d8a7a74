//! Finding a limb in one frame without knowing where it was: a beam search over bends.
//!
//! The limb grows from the joint it hangs by. A few turns along it, mixed linearly between, bend the drawn shape; at
//! each step the best partial poses that differ are kept, and those that reach the end are settled. Thin fast legs move farther between frames than any flow can
//! follow, so their poses must come from looking, and time chooses among them (see `space_time`).

use glam::Vec2;

use super::params::SpaceTimeParams;
use super::strip::{Strip, View};

/// Turns along a limb.
const CONTROLS: usize = 4;
/// First turns tried, in steps of this many radians, so many either way.
const FIRST_STEP: f32 = 0.14;
const FIRST_TURNS: i32 = 9;
/// Further turns relative to the one before.
const BEND_STEP: f32 = 0.16;
const BENDS: i32 = 6;
/// Cost of bending by one radian, of all a limb may cost.
const BEND_COST: f32 = 0.02;
/// Poses closer than this share of the limb's length (mean over the vertices that matter) are the same.
const SAME: f32 = 0.03;

#[derive(Clone, Debug)]
struct Partial {
    points: Vec<Vec2>,
    turns: Vec<f32>,
    cost: f32,
}

/// Poses of a limb whose first vertex is at `root`, the cheapest first. `shape` is a drawn pose whose edges have
/// `lengths` now.
pub(super) fn search(
    strip: &Strip,
    view: &View<'_>,
    frame: usize,
    shape: &[Vec2],
    lengths: &[f32],
    root: Vec2,
    params: &SpaceTimeParams,
) -> Vec<Vec<Vec2>> {
    let edges = shape.len() - 1;
    let controls = CONTROLS.min(edges.max(2));
    let directions: Vec<Vec2> = shape.windows(2).map(|p| (p[1] - p[0]).try_normalize().unwrap_or(Vec2::X)).collect();
    let total: f32 = lengths.iter().sum();
    let keys = strip.keys_around(frame);
    let mut beam: Vec<Partial> = (-FIRST_TURNS..=FIRST_TURNS)
        .map(|k| Partial { points: vec![root], turns: vec![k as f32 * FIRST_STEP], cost: 0.0 })
        .collect();
    for step in 1..controls {
        let (from, to) = ((step - 1) * edges / (controls - 1), step * edges / (controls - 1));
        let mut grown = Vec::with_capacity(beam.len() * (2 * BENDS as usize + 1));
        for partial in &beam {
            let before = partial.turns[step - 1];
            for bend in -BENDS..=BENDS {
                let after = before + bend as f32 * BEND_STEP;
                let mut next = partial.clone();
                let mut tail = partial.points[partial.points.len() - 1];
                for e in from..to {
                    let share = (e - from) as f32 + 0.5;
                    let turn = before + (after - before) * share / (to - from) as f32;
                    let head = tail + Vec2::from_angle(turn).rotate(directions[e]) * lengths[e];
                    next.cost += strip.edge_cost(view, keys, e, tail, head) / shape.len() as f32;
                    next.points.push(head);
                    tail = head;
                }
                next.cost += BEND_COST * (after - before).abs();
                next.turns.push(after);
                if step + 1 == controls {
                    next.cost += strip.tip_cost(view, keys, &next.points) / shape.len() as f32;
                }
                grown.push(next);
            }
        }
        let keep = if step + 1 == controls { params.found } else { params.beam };
        beam = distinct(grown, keep, from, SAME * total);
    }
    beam.into_iter().map(|p| settle(strip, view, frame, &p.points, false)).collect()
}

/// The cheapest `keep` whose vertices from `from` on differ by more than `least` pixels in the mean.
fn distinct(mut all: Vec<Partial>, keep: usize, from: usize, least: f32) -> Vec<Partial> {
    all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut kept: Vec<Partial> = Vec::with_capacity(keep);
    for candidate in all {
        if kept.len() == keep {
            break;
        }
        let gap = |other: &Partial| {
            let n = (candidate.points.len() - from) as f32;
            candidate.points[from..].iter().zip(&other.points[from..]).map(|(p, q)| p.distance(*q)).sum::<f32>() / n
        };
        if kept.iter().all(|other| gap(other) > least) {
            kept.push(candidate);
        }
    }
    kept
}

/// Rounds of [`settle`], each with smaller tries.
const SETTLING: [f32; 3] = [0.10, 0.05, 0.025];

/// The best fit near `pose`: turns at places along the limb and, tried in turn with them, shifts where it is `free`;
/// where it is not, lengths, which change as a limb folds or leaves the image plane.
pub(super) fn settle(strip: &Strip, view: &View<'_>, frame: usize, pose: &[Vec2], free: bool) -> Vec<Vec2> {
    let n = pose.len();
    let length: f32 = pose.windows(2).map(|p| p[0].distance(p[1])).sum();
    let keys = strip.keys_around(frame);
    let (mut best, mut sums) = (pose.to_vec(), vec![0.0; n]);
    let mut best_cost = strip.cost_from(view, keys, pose, &mut sums, 0, f32::INFINITY);
    let mut tried = sums.clone();
    // Of a pose that differs from the best from vertex `from` on.
    let mut attempt = |best: &mut Vec<Vec2>, from: usize, change: &dyn Fn(&[Vec2]) -> Vec<Vec2>| {
        let moved = change(best);
        let departure = DEPARTURE * apart(&moved, pose) / length;
        tried[..=from].copy_from_slice(&sums[..=from]);
        let cost = strip.cost_from(view, keys, &moved, &mut tried, from, best_cost - departure + SLACK) + departure;
        if cost < best_cost {
            (*best, best_cost) = (moved, cost);
            std::mem::swap(&mut sums, &mut tried);
        }
    };
    for step in SETTLING {
        for step in [-step, step] {
            for joint in [0, n / 4, n / 2, 3 * n / 4] {
                attempt(&mut best, joint, &|p| bent(p, joint, step));
            }
            if free {
                for axis in [Vec2::X, Vec2::Y] {
                    attempt(&mut best, 0, &|p| p.iter().map(|q| *q + axis * (step * 0.3 * length)).collect());
                }
            } else {
                attempt(&mut best, 0, &|p| p.iter().map(|q| p[0] + (*q - p[0]) * (1.0 + step)).collect());
            }
        }
    }
    best
}

/// What rounding may add to a sum of costs.
const SLACK: f32 = 1e-4;
/// Cost of a mean departure by the limb's length.
const DEPARTURE: f32 = 0.3;

fn apart(a: &[Vec2], b: &[Vec2]) -> f32 {
    a.iter().zip(b).map(|(p, q)| p.distance(*q)).sum::<f32>() / a.len() as f32
}

/// The pose turned by `angle` beyond vertex `joint`.
fn bent(pose: &[Vec2], joint: usize, angle: f32) -> Vec<Vec2> {
    let (turn, pivot) = (Vec2::from_angle(angle), pose[joint]);
    pose.iter().enumerate().map(|(i, &p)| if i > joint { pivot + turn.rotate(p - pivot) } else { p }).collect()
}
