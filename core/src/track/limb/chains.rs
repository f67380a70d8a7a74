//! Limbs carried by flow from key frame to key frame, forward and backward.

use glam::Vec2;

use super::carry::carry;
use super::limb_keys::LimbKeys;
use super::space_time::Task;
use crate::geometry::polyline;

/// A pose and how far each vertex is trusted, where a chain has reached a frame.
pub(super) type Reached = Option<(Vec<Vec2>, Vec<f32>)>;

/// Carries the limb by flow from key to key in one direction of time.
pub(super) fn chain(task: &Task<'_>, forward: bool) -> (Vec<Reached>, Vec<f32>) {
    let (footage, keys) = (task.footage, &task.keys);
    let frames = footage.frames();
    let mut out: Vec<Reached> = vec![None; frames];
    let order: Vec<usize> = if forward { (0..frames).collect() } else { (0..frames).rev().collect() };
    let mut previous: Option<usize> = None;
    let mut stretch = vec![1.0f32; frames];
    for f in order {
        if let Some(key) = keys.frames.iter().position(|&k| k == f) {
            out[f] = Some((keys.poses[key].clone(), vec![1.0; keys.vertices()]));
        } else if let Some(kept) = task.kept.at(f) {
            let drawn: f32 = keys.lengths(f).iter().sum();
            if task.carries {
                stretch[f] = (polyline::length(&kept.points) / drawn.max(1e-6)).clamp(BODY_STRETCH.0, BODY_STRETCH.1);
            }
            out[f] = Some((kept.points.clone(), vec![1.0; keys.vertices()]));
        } else if let Some(p) = previous
            && let Some((pose, trust)) = &out[p]
            && let Some((flow, back)) = footage.flows(p, f)
        {
            let root = task.roots.as_ref().map(|r| r[f]);
            let lengths: Vec<f32> = keys.lengths(f).into_iter().map(|l| l * stretch[p]).collect();
            let carried = carry(pose, &task.strip.radii, &lengths, flow, back, root);
            let relaxed = 1.0 + (stretch[p] * carried.stretch - 1.0) * STRETCH_MEMORY;
            stretch[f] = if task.carries { relaxed.clamp(BODY_STRETCH.0, BODY_STRETCH.1) } else { 1.0 };
            let trust = trust.iter().zip(&carried.trust).map(|(a, b)| a * (0.3 + 0.7 * b)).collect();
            out[f] = Some((carried.points, trust));
        }
        previous = Some(f);
    }
    (out, stretch)
}

/// The poses that chains from both sides reach in frame `f`, mixed by distance in time, and their trust.
pub(super) fn mixed_chains(keys: &LimbKeys, f: usize, ahead: &Reached, behind: &Reached) -> (Vec<Vec2>, Vec<f32>) {
    match (ahead, behind) {
        (Some(a), Some(b)) => {
            let share = keys.mixed(f, |k| if keys.frames[k] >= f { 1.0 } else { 0.0 }, |a, b, t| a + (b - a) * t);
            let pose = a.0.iter().zip(&b.0).map(|(p, q)| p.lerp(*q, share)).collect();
            (pose, a.1.iter().zip(&b.1).map(|(p, q)| p.max(*q)).collect())
        }
        (Some(one), None) | (None, Some(one)) => one.clone(),
        (None, None) => (keys.poses[0].clone(), vec![0.0; keys.vertices()]),
    }
}

/// How far lengths may leave the drawn ones, of limbs that carry others: their texture shows when the animal turns. The
/// flow on a thin limb's end is no measure of its length.
const BODY_STRETCH: (f32, f32) = (0.4, 1.6);
/// Share of a stretch that is left in the next frame.
const STRETCH_MEMORY: f32 = 0.99;
