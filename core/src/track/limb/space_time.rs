//! All frames of all limbs, solved together between key frames.
//!
//! Limb by limb from the body outward: every frame gets a list of possible poses, from carrying the limb by flow from
//! either key frame, and from searching the frame for the limb's looks; the cheapest path through the lists (exact, by
//! dynamic programming) trades looks against flow and inertia. Poses near the path are then added and the path found
//! again, until it settles.

use glam::Vec2;
use rayon::prelude::*;

use super::carry::carry;
use super::claims::Claims;
use super::footage::Footage;
use super::foreground::Foreground;
use super::limb_keys::LimbKeys;
use super::limb_width::half_widths;
use super::params::LimbParams;
use super::pose_path::{Candidate, PathWeights, best_path};
use super::pose_search;
use super::solving_order::{Turn, solving_order};
use super::strip::{Strip, View};
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::raster::{Planes, pyramid};
use crate::rig::{Rig, Side, Skeleton};

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

/// Everything that is known of one limb before it is solved.
struct Task<'a> {
    footage: &'a Footage,
    foreground: &'a Foreground,
    keys: LimbKeys,
    strip: Strip,
    roots: Option<Vec<Vec2>>,
    claims: Option<&'a Claims>,
    /// Whether others hang from it.
    carries: bool,
}

impl Task<'_> {
    fn view(&self, frame: usize) -> View<'_> {
        View {
            image: &self.footage.lab[frame],
            foreground: self.foreground,
            claimed: self.claims.map(|c| c.frame(frame)),
        }
    }
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
    let turns = solving_order(rig, skeleton);
    let foreground = learn_foreground(rig, &footage);
    let key_planes = key_planes(clip, rig, &footage)?;
    let mut claims = Claims::new(&footage);
    let mut solved: Vec<Option<Solved>> = vec![None; rig.limbs.len()];
    for (i, &turn) in turns.iter().enumerate() {
        let part = |i: usize| 0.6 + 0.4 * i as f64 / turns.len() as f64;
        let keys = LimbKeys::new(rig, skeleton, turn, footage.scale);
        let roots = roots(rig, skeleton, turn, &turns, &keys, &solved, &footage);
        let far = rig.limbs[turn.limb].side == Some(Side::Far);
        let carries = turns.iter().any(|t| t.from.is_some_and(|(p, _)| p == turn.limb));
        let radii = radii(&keys, &key_planes);
        let behind = far.then_some(&claims);
        let views: Vec<(usize, View<'_>, &[Vec2])> = keys
            .frames
            .iter()
            .zip(&keys.poses)
            .map(|(&f, pose)| {
                let claimed = behind.map(|c| c.frame(f));
                (f, View { image: &footage.lab[f], foreground: &foreground, claimed }, pose.as_slice())
            })
            .collect();
        let strip = Strip::new(radii, &views, !carries);
        let task = Task { footage: &footage, foreground: &foreground, keys, strip, roots, claims: behind, carries };
        let result = solve_limb(&task, stage.part(part(i), part(i + 1)))?;
        if !far {
            let radii = task.strip.radii;
            claims.cover(&result.poses, &radii);
        }
        solved[turn.limb] = Some(result);
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

fn learn_foreground(rig: &Rig, footage: &Footage) -> Foreground {
    let longest = (0..rig.limbs.len()).map(|l| rig.length_hint(l)).fold(0.0, f32::max) * footage.scale;
    let keys: Vec<_> = rig
        .keyframes
        .iter()
        .filter(|k| !k.strokes.is_empty())
        .map(|k| {
            let strokes = k.strokes.iter().map(|s| {
                let points: Vec<Vec2> = s.points.iter().map(|p| *p * footage.scale).collect();
                let steps = (crate::geometry::polyline::length(&points) / 4.0) as usize + 2;
                crate::geometry::polyline::resample(&points, steps)
            });
            (&footage.lab[k.frame], strokes.collect())
        })
        .collect();
    Foreground::learn(&keys, (0.02 * longest).max(1.5), 0.4 * longest)
}

fn key_planes(clip: &Clip, rig: &Rig, footage: &Footage) -> Result<Vec<(usize, Planes)>> {
    let size = (footage.lab[0].width() as u32, footage.lab[0].height() as u32);
    let frames = rig.keyframes.iter().filter(|k| !k.strokes.is_empty());
    frames.map(|k| Ok((k.frame, Planes::lab(&pyramid::shrunk(&clip.frame(k.frame)?.rgb, size.0, size.1))))).collect()
}

/// Half widths at the vertices: the mean over the key frames.
fn radii(keys: &LimbKeys, planes: &[(usize, Planes)]) -> Vec<f32> {
    let mut sum = vec![0.0; keys.vertices()];
    for (frame, pose) in keys.frames.iter().zip(&keys.poses) {
        let length = crate::geometry::polyline::length(pose);
        if let Some((_, planes)) = planes.iter().find(|p| p.0 == *frame) {
            for (s, r) in sum.iter_mut().zip(half_widths(planes, pose, 0.2 * length)) {
                *s += r / keys.frames.len() as f32;
            }
        }
    }
    sum
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

/// A pose and how far each vertex is trusted, where a chain has reached a frame.
type Reached = Option<(Vec<Vec2>, Vec<f32>)>;

/// Carries the limb by flow from key to key in one direction of time.
fn chain(task: &Task<'_>, forward: bool) -> Vec<Reached> {
    let (footage, keys) = (task.footage, &task.keys);
    let frames = footage.frames();
    let mut out: Vec<Reached> = vec![None; frames];
    let order: Vec<usize> = if forward { (0..frames).collect() } else { (0..frames).rev().collect() };
    let mut previous: Option<usize> = None;
    for f in order {
        if let Some(key) = keys.frames.iter().position(|&k| k == f) {
            out[f] = Some((keys.poses[key].clone(), vec![1.0; keys.vertices()]));
        } else if let Some(p) = previous
            && let Some((pose, trust)) = &out[p]
            && let Some((flow, back)) = footage.flows(p, f)
        {
            let root = task.roots.as_ref().map(|r| r[f]);
            let carried = carry(pose, &task.strip.radii, &keys.lengths(f), flow, back, root);
            let trust = trust.iter().zip(&carried.trust).map(|(a, b)| a * (0.3 + 0.7 * b)).collect();
            out[f] = Some((carried.points, trust));
        }
        previous = Some(f);
    }
    out
}

fn mixed_chains(keys: &LimbKeys, f: usize, ahead: &Reached, behind: &Reached) -> (Vec<Vec2>, Vec<f32>) {
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

fn solve_limb(task: &Task<'_>, stage: Stage<'_>) -> Result<Solved> {
    let frames = task.footage.frames();
    let (ahead, behind) = (chain(task, true), chain(task, false));
    let trusts: Vec<Vec<f32>> = (0..frames).map(|f| mixed_chains(&task.keys, f, &ahead[f], &behind[f]).1).collect();
    let mut lists: Vec<Vec<Candidate>> = (0..frames)
        .into_par_iter()
        .map(|f| {
            stage.at(0.5 * f as f64 / frames as f64)?;
            Ok(first_poses(task, f, &ahead[f], &behind[f]).into_iter().map(|p| judged(task, f, p)).collect())
        })
        .collect::<Result<_>>()?;
    let weights = PathWeights::default();
    let mut path = best_path(&lists, &weights, task.roots.as_deref());
    for round in 0..ROUNDS {
        let poses: Vec<Vec<Vec2>> = path.iter().zip(&lists).map(|(&i, l)| l[i].pose.clone()).collect();
        let added: Vec<Vec<Candidate>> = (0..frames)
            .into_par_iter()
            .map(|f| {
                stage.at(0.5 + 0.5 * (round as f64 + f as f64 / frames as f64) / ROUNDS as f64)?;
                Ok(near_poses(task, f, &poses).into_iter().map(|p| judged(task, f, p)).collect())
            })
            .collect::<Result<_>>()?;
        for (list, new) in lists.iter_mut().zip(added) {
            list.extend(new);
        }
        path = best_path(&lists, &weights, task.roots.as_deref());
    }
    let poses = path.iter().zip(&lists).map(|(&i, l)| l[i].pose.clone()).collect();
    Ok(Solved { poses, trust: trusts })
}

/// Rounds of adding poses near the path.
const ROUNDS: usize = 3;

/// What a frame starts with: drawn poses alone on key frames; else the carried ones and what a search finds.
fn first_poses(task: &Task<'_>, f: usize, ahead: &Reached, behind: &Reached) -> Vec<Vec<Vec2>> {
    let keys = &task.keys;
    if let Some(key) = keys.frames.iter().position(|&k| k == f) {
        return vec![keys.poses[key].clone()];
    }
    let mut poses = vec![mixed_chains(keys, f, ahead, behind).0];
    poses.extend([ahead, behind].into_iter().flatten().map(|r| r.0.clone()));
    if !task.carries
        && let Some(roots) = &task.roots
    {
        let (before, after) = keys.around(f);
        let mut shapes = [before, after].into_iter().flatten().collect::<Vec<usize>>();
        shapes.dedup();
        for key in shapes {
            let lengths = keys.lengths(f);
            poses.extend(pose_search::search(&task.strip, &task.view(f), f, &keys.poses[key], &lengths, roots[f]));
        }
    }
    poses
}

/// Poses worth trying around a path: its neighbours in time carried here, between them, and a better fit nearby.
fn near_poses(task: &Task<'_>, f: usize, path: &[Vec<Vec2>]) -> Vec<Vec<Vec2>> {
    if task.keys.frames.contains(&f) {
        return Vec::new();
    }
    let mut poses = Vec::new();
    let root = task.roots.as_ref().map(|r| r[f]);
    let lengths = task.keys.lengths(f);
    for from in [f.checked_sub(1), (f + 1 < path.len()).then_some(f + 1)].into_iter().flatten() {
        if let Some((flow, back)) = task.footage.flows(from, f) {
            poses.push(carry(&path[from], &task.strip.radii, &lengths, flow, back, root).points);
        }
    }
    if f > 0 && f + 1 < path.len() {
        poses.push(path[f - 1].iter().zip(&path[f + 1]).map(|(a, b)| a.lerp(*b, 0.5)).collect());
    }
    let view = task.view(f);
    let starts: Vec<Vec<Vec2>> = poses.iter().cloned().chain([path[f].clone()]).collect();
    poses.extend(starts.into_iter().map(|p| pose_search::settle(&task.strip, &view, f, p, task.roots.is_none())));
    poses
}

fn judged(task: &Task<'_>, f: usize, pose: Vec<Vec2>) -> Candidate {
    let cost = task.strip.cost(&task.view(f), f, &pose);
    let moved = |to: usize| {
        let (flow, back) = task.footage.flows(f, to)?;
        let root = task.roots.as_ref().map(|r| r[to]);
        Some(carry(&pose, &task.strip.radii, &task.keys.lengths(to), flow, back, root))
    };
    let (next, last) = (moved(f + 1), f.checked_sub(1).and_then(moved));
    Candidate { pose, cost, next, last }
}
