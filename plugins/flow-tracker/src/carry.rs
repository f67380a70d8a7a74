//! One limb from one frame to the next.

use glam::Vec2;

use crate::Parameters;
use crate::chain::{Pull, settle};
use crate::flow::Flow;
use crate::patch::Patch;
use crate::pyramid::Level;

/// Offsets across the limb, in its half width, whose motion counts.
const ACROSS: [f32; 5] = [-0.7, -0.35, 0.0, 0.35, 0.7];
/// And along it, in steps to the neighbouring point.
const ALONG: [f32; 3] = [-0.5, 0.0, 0.5];
const SAMPLES: usize = ACROSS.len() * ALONG.len();
/// Rounds of re-weighting for the median of motions (Weiszfeld).
const MEDIAN_ROUNDS: usize = 6;
/// Levels of brightness variance from which a key frame's patch is worth looking for.
const TEXTURE: f32 = 60.0;
/// A patch found with less than this share of its own variance in error is the same place.
const SAME: f32 = 0.25;
/// How far in pixels of the searched level a patch is looked for.
const REACH: f32 = 3.5;
/// Pixels of a frame for one of those on which looks are compared: patches are 16 pixels wide.
const LOOKS_SCALE: f32 = 2.0;
const LOOKS_STEPS: usize = 8;
/// The last step of the flow, at the frame's own resolution.
const LAST_STEPS: usize = 5;
const LAST_REACH: f32 = 2.5;

/// What is followed and how it looked on its key frame.
pub(crate) struct Anchor<'a> {
    pub(crate) points: &'a [Vec2],
    /// At half the resolution.
    pub(crate) picture: &'a Level,
}

/// A limb after the step.
#[derive(Clone, Debug)]
pub(crate) struct Carried {
    pub(crate) points: Vec<Vec2>,
    /// How far the pictures say where each point is, 0 to 1.
    pub(crate) trust: Vec<f32>,
}

/// Flow to the next frame, and back from it.
pub(crate) struct Step<'a> {
    pub(crate) there: &'a Flow,
    pub(crate) back: &'a Flow,
    pub(crate) from: &'a Level,
    pub(crate) to: &'a Level,
    /// The frame it goes to at half the resolution.
    pub(crate) looks: &'a Level,
}

impl Step<'_> {
    /// The motion of `p`, and by how much it is missed on the way back.
    fn motion(&self, p: Vec2) -> (Vec2, f32) {
        let there = settle_at(self.from, self.to, p, self.there.at(p));
        let back = settle_at(self.to, self.from, p + there, self.back.at(p + there));
        (there, (there + back).length())
    }
}

/// The motion near `start` by which the patch around `p` fits best.
fn settle_at(from: &Level, to: &Level, p: Vec2, start: Vec2) -> Vec2 {
    let at = p - 0.5;
    let found = Patch::new(from, at, Vec2::X).descend(to, at + start, LAST_STEPS, LAST_REACH);
    found.at - at
}

/// Moves `pose`. `root` is a point that hangs on another limb, and where that is now.
pub(crate) fn carry(
    pose: &[Vec2],
    half_width: f32,
    step: &Step<'_>,
    anchor: &Anchor<'_>,
    root: Option<(usize, Vec2)>,
    parameters: &Parameters,
) -> Carried {
    let mut pulls: Vec<Pull> = (0..pose.len())
        .map(|i| {
            let (motion, weight) = motion(pose, half_width, i, step, parameters.disagreement);
            Pull { target: pose[i] + motion, weight }
        })
        .collect();
    if parameters.anchor > 0.0 {
        hold_to_looks(&mut pulls, anchor, step.looks, parameters.anchor);
    }
    if let Some((i, at)) = root
        && let Some(pull) = pulls.get_mut(i)
    {
        // Both know something of the joint.
        let weight = pull.weight + 0.5;
        pull.target = (pull.target * pull.weight + 0.5 * at) / weight;
        pull.weight = weight;
    }
    let lengths = lengths(pose, &pulls, anchor.points, parameters.length);
    let points = settle(pose, &lengths, &pulls);
    Carried { points, trust: pulls.iter().map(|p| p.weight.min(1.0)).collect() }
}

fn tangent(points: &[Vec2], i: usize) -> Vec2 {
    let (a, b) = (points[i.saturating_sub(1)], points[(i + 1).min(points.len() - 1)]);
    (b - a).try_normalize().unwrap_or(Vec2::X)
}

/// The median motion of the band around point `i`, and how far it agrees there and back.
fn motion(pose: &[Vec2], half_width: f32, i: usize, step: &Step<'_>, disagreement: f32) -> (Vec2, f32) {
    let normal = tangent(pose, i).perp();
    let mut samples = [(Vec2::ZERO, 0.0f32); SAMPLES];
    let mut n = 0;
    for along in ALONG {
        let to = if along < 0.0 { i.saturating_sub(1) } else { (i + 1).min(pose.len() - 1) };
        let on = pose[i].lerp(pose[to], along.abs());
        for across in ACROSS {
            let p = on + normal * (across * half_width);
            let (there, miss) = step.motion(p);
            let miss = miss / disagreement;
            // The axis is surely on the limb, the band's border only maybe.
            samples[n] = (there, (1.0 - 0.4 * across.abs()) / (1.0 + miss * miss));
            n += 1;
        }
    }
    let mut median = Vec2::ZERO;
    for round in 0..MEDIAN_ROUNDS {
        let (mut sum, mut weight) = (Vec2::ZERO, 1e-6);
        for (motion, w) in samples {
            let w = if round == 0 { w } else { w / (motion.distance(median) + 0.2) };
            sum += w * motion;
            weight += w;
        }
        median = sum / weight;
    }
    (median, samples.iter().map(|s| s.1).sum::<f32>() / (0.86 * SAMPLES as f32))
}

/// Moves targets toward what looks as the points did on the key frame, where that is found near them.
fn hold_to_looks(pulls: &mut [Pull], anchor: &Anchor<'_>, now: &Level, strength: f32) {
    let (key, scale) = (anchor.picture, LOOKS_SCALE);
    let targets: Vec<Vec2> = pulls.iter().map(|p| p.target).collect();
    let inside = |p: Vec2, width: usize, height: usize| {
        p.x > 2.0 && p.y > 2.0 && p.x < width as f32 - 3.0 && p.y < height as f32 - 3.0
    };
    let corrections: Vec<Option<(Vec2, f32)>> = (0..pulls.len())
        .map(|i| {
            let from = anchor.points[i] / scale - 0.5;
            let to = targets[i] / scale - 0.5;
            if !inside(from, key.width, key.height) || !inside(to, now.width, now.height) {
                return None;
            }
            let (before, after) = (tangent(anchor.points, i), tangent(&targets, i));
            let turn = Vec2::new(before.dot(after), before.perp_dot(after));
            let patch = Patch::new(key, from, turn);
            if patch.contrast < TEXTURE {
                return None;
            }
            let found = patch.descend(now, to, LOOKS_STEPS, REACH);
            let error = found.cost / (SAME * patch.contrast);
            (error < 1.0).then(|| (scale * (found.at - to), 1.0 - error))
        })
        .collect();
    for (i, pull) in pulls.iter_mut().enumerate() {
        let Some((correction, fit)) = corrections[i] else { continue };
        // A neighbour that was found and says otherwise takes the trust away.
        let near = [i.checked_sub(1), Some(i + 1)].into_iter().flatten();
        let beside = near.filter_map(|j| corrections.get(j).copied().flatten());
        let mut agreement = 1.0f32;
        for (other, _) in beside {
            let apart = other.distance(correction) / 3.0;
            agreement = agreement.min(1.0 / (1.0 + apart * apart));
        }
        let gain = strength * fit * agreement;
        pull.target += gain * correction;
        pull.weight = pull.weight.max(gain);
    }
}

/// Edge lengths: as before, times what trusted targets say of the limb's stretch, drawn to the key frame's.
fn lengths(pose: &[Vec2], pulls: &[Pull], drawn: &[Vec2], keep: f32) -> Vec<f32> {
    let span = (pose.len() / 3).max(1);
    let (mut before, mut after, mut sure, mut pairs) = (1e-6f32, 1e-6f32, 0.0f32, 1e-6f32);
    for i in 0..pose.len().saturating_sub(span) {
        let w = (pulls[i].weight * pulls[i + span].weight).min(1.0);
        before += w * pose[i].distance(pose[i + span]);
        after += w * pulls[i].target.distance(pulls[i + span].target);
        sure += w;
        pairs += 1.0;
    }
    let stretch = 1.0 + (after / before - 1.0).clamp(-0.2, 0.2) * (sure / pairs);
    pose.windows(2)
        .zip(drawn.windows(2))
        .map(|(p, d)| {
            let (now, key) = (p[0].distance(p[1]) * stretch, d[0].distance(d[1]));
            now + keep * (key - now)
        })
        .collect()
}
