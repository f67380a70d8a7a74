//! All frames of all limbs, solved together between key frames.

use glam::Vec2;

use super::carry::carry;
use super::footage::Footage;
use super::limb_keys::LimbKeys;
use super::params::LimbParams;
use super::solving_order::{Turn, solving_order};
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::rig::{Rig, Skeleton};

/// One limb in all frames, in clip pixels, from the stroke's start to its end.
#[derive(Clone, Debug)]
pub(super) struct Trajectory {
    pub(super) poses: Vec<Vec<Vec2>>,
    pub(super) visible: Vec<Vec<bool>>,
    pub(super) confidence: Vec<Vec<f32>>,
}

/// One limb in all frames in working pixels, from the end it hangs by.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) poses: Vec<Vec<Vec2>>,
    pub(super) trust: Vec<Vec<f32>>,
}

/// Tracks every limb; one trajectory a limb, in the rig's order.
pub(super) fn solve(
    clip: &Clip,
    rig: &Rig,
    skeleton: &Skeleton,
    params: &LimbParams,
    stage: Stage<'_>,
) -> Result<Vec<Trajectory>> {
    let footage = Footage::read(clip, params.working_side, stage.part(0.0, 0.6))?;
    let mut solved: Vec<Option<Solved>> = vec![None; rig.limbs.len()];
    let turns = solving_order(rig, skeleton);
    for (i, &turn) in turns.iter().enumerate() {
        let part = |i: usize| 0.6 + 0.4 * i as f64 / turns.len() as f64;
        let keys = LimbKeys::new(rig, skeleton, turn, footage.scale);
        let roots = roots(rig, skeleton, turn, &turns, &keys, &solved, &footage);
        let radii = radii_guess(&keys);
        solved[turn.limb] = Some(chain(&footage, &keys, &radii, roots.as_deref(), stage.part(part(i), part(i + 1)))?);
    }
    let out = solved.into_iter().zip(0..).filter_map(|(s, l)| Some((s?, l)));
    Ok(out.map(|(s, l)| finish(s, turns.iter().any(|t| t.limb == l && t.reversed), footage.scale)).collect())
}

fn finish(solved: Solved, reversed: bool, scale: f32) -> Trajectory {
    let turned = |points: Vec<Vec2>| -> Vec<Vec2> {
        let clip = points.into_iter().map(|p| p / scale);
        if reversed { clip.rev().collect() } else { clip.collect() }
    };
    let poses: Vec<Vec<Vec2>> = solved.poses.into_iter().map(turned).collect();
    let visible = poses.iter().map(|p| vec![true; p.len()]).collect();
    let confidence = solved
        .trust
        .into_iter()
        .map(|mut t| {
            if reversed {
                t.reverse();
            }
            t
        })
        .collect();
    Trajectory { poses, visible, confidence }
}

/// Where the limb's first vertex lies in every frame: on the limb it hangs from, with the gap that was drawn.
fn roots(
    rig: &Rig,
    skeleton: &Skeleton,
    turn: Turn,
    turns: &[Turn],
    keys: &LimbKeys,
    solved: &[Option<Solved>],
    footage: &Footage,
) -> Option<Vec<Vec2>> {
    let (parent, at_end) = turn.from?;
    let track = solved[parent].as_ref()?;
    let parent_turn = turns.iter().find(|t| t.limb == parent)?;
    let last = track.poses[0].len() - 1;
    let vertex = if at_end == parent_turn.reversed { 0 } else { last };
    let parent_keys = LimbKeys::new(rig, skeleton, *parent_turn, footage.scale);
    let gap = |key: usize| {
        let joint = match parent_keys.frames.iter().position(|&f| f == keys.frames[key]) {
            Some(drawn) => parent_keys.poses[drawn][vertex],
            None => track.poses[keys.frames[key]][vertex],
        };
        keys.poses[key][0] - joint
    };
    Some((0..footage.frames()).map(|f| track.poses[f][vertex] + keys.mixed(f, gap, |a, b, t| a.lerp(b, t))).collect())
}

/// Half widths before anything is known of the picture: a share of the limb's length.
fn radii_guess(keys: &LimbKeys) -> Vec<f32> {
    let length: f32 = keys.lengths(keys.frames[0]).iter().sum();
    vec![0.04 * length; keys.vertices()]
}

/// Carries the limb from key frames both ways and mixes what meets.
fn chain(
    footage: &Footage,
    keys: &LimbKeys,
    radii: &[f32],
    roots: Option<&[Vec2]>,
    stage: Stage<'_>,
) -> Result<Solved> {
    let frames = footage.frames();
    let run = |forward: bool| -> Result<Vec<Option<(Vec<Vec2>, Vec<f32>)>>> {
        let mut out: Vec<Option<(Vec<Vec2>, Vec<f32>)>> = vec![None; frames];
        let order: Vec<usize> = if forward { (0..frames).collect() } else { (0..frames).rev().collect() };
        let mut previous: Option<usize> = None;
        for f in order {
            stage.at(0.5 * f as f64 / frames as f64)?;
            if let Some(key) = keys.frames.iter().position(|&k| k == f) {
                out[f] = Some((keys.poses[key].clone(), vec![1.0; keys.vertices()]));
            } else if let Some(p) = previous
                && let Some((pose, trust)) = &out[p]
                && let Some((flow, back)) = footage.flows(p, f)
            {
                let carried = carry(pose, radii, &keys.lengths(f), flow, back, roots.map(|r| r[f]));
                let trust = trust.iter().zip(&carried.trust).map(|(a, b)| a * (0.3 + 0.7 * b)).collect();
                out[f] = Some((carried.points, trust));
            }
            previous = Some(f);
        }
        Ok(out)
    };
    let (ahead, behind) = (run(true)?, run(false)?);
    let (mut poses, mut trusts) = (Vec::with_capacity(frames), Vec::with_capacity(frames));
    for (f, both) in ahead.into_iter().zip(behind).enumerate() {
        let (pose, trust) = match both {
            (Some(a), Some(b)) => {
                let share = keys.mixed(f, |k| if keys.frames[k] >= f { 1.0 } else { 0.0 }, |a, b, t| a + (b - a) * t);
                let pose = a.0.iter().zip(&b.0).map(|(p, q)| p.lerp(*q, share)).collect();
                (pose, a.1.iter().zip(&b.1).map(|(p, q)| p.max(*q)).collect())
            }
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => (keys.poses[0].clone(), vec![0.0; keys.vertices()]),
        };
        poses.push(pose);
        trusts.push(trust);
    }
    Ok(Solved { poses, trust: trusts })
}
