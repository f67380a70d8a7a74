//! All frames of all limbs, solved together between key frames.
//!
//! Limb by limb from the body outward: every frame gets a list of possible poses, from carrying the limb by flow from
//! either key frame, and from searching the frame for the limb's looks; the cheapest path through the lists (see
//! `inertia`) trades looks against flow, rest and a steady motion. Poses near the path, where the other of its pair is
//! and what both did a stride away (see `gait`) are then added and the path is found again.

use glam::Vec2;
use rayon::prelude::*;

use super::carry::carry;
use super::chains::{Reached, chain, mixed_chains};
use super::claims::{Claims, cover};
use super::confidence::{Evidence, spread};
use super::crossings;
use super::drawn::{key_planes, learn_foreground, radii, roots};
use super::footage::{Footage, LookedAt};
use super::gait::Gait;
use super::inertia::best_path;
use super::kept::{Kept, KeptLimb};
use super::limb_keys::LimbKeys;
use super::params::{LimbParams, SpaceTimeParams};
use super::pose_path::{Candidate, Chain, Group, costs_through};
use super::pose_search;
use super::solving_order::{groups, solving_order};
use super::strip::{CLAIM_CELL, Hideable, Strip, View};
use super::unexplained::Unexplained;
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::raster::{Grid, Mask};
use crate::rig::{Rig, Side, Skeleton};

/// One limb in all frames, in clip pixels, from the stroke's start to its end.
#[derive(Clone, Debug)]
pub(in crate::track) struct Trajectory {
    pub(in crate::track) poses: Vec<Vec<Vec2>>,
    pub(super) visible: Vec<Vec<bool>>,
    pub(in crate::track) confidence: Vec<Vec<f32>>,
}

/// One limb in all frames in working pixels, from the end it hangs by.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) poses: Vec<Vec<Vec2>>,
    pub(super) visible: Vec<Vec<bool>>,
    pub(super) confidence: Vec<Vec<f32>>,
}

/// Everything that is known of one limb before it is solved.
pub(super) struct Task<'a> {
    pub(super) params: &'a SpaceTimeParams,
    pub(super) footage: &'a Footage,
    /// For every frame, how likely its pixels are the animal's.
    animal: &'a [Grid<u8>],
    pub(super) keys: LimbKeys,
    pub(super) strip: Strip,
    pub(super) roots: Option<Vec<Vec2>>,
    /// Where it would go without moving of its own: with the joint it hangs by, or with the ground.
    rest: Vec<Vec2>,
    claims: Option<&'a Claims>,
    /// Whether others hang from it.
    pub(super) carries: bool,
    /// What stands of an earlier run.
    pub(super) kept: KeptLimb,
    /// Its length in every frame, as a multiple of what its keys say.
    stretch: Vec<f32>,
}

impl Task<'_> {
    pub(super) fn view(&self, frame: usize) -> View<'_> {
        View {
            image: &self.footage.lab[frame],
            animal: &self.animal[frame],
            claimed: self.claims.map(|c| c.frame(frame)),
        }
    }

    pub(super) fn lengths(&self, frame: usize) -> Vec<f32> {
        let mut lengths = self.keys.lengths(frame);
        lengths.iter_mut().for_each(|l| *l *= self.stretch[frame]);
        lengths
    }
}

/// Tracks every limb, but for the frames that are kept; one trajectory a limb, in the rig's order.
pub(super) fn solve(
    clip: &Clip,
    rig: &Rig,
    skeleton: &Skeleton,
    kept: Option<&Kept>,
    params: &LimbParams,
    stage: Stage<'_>,
) -> Result<Vec<Trajectory>> {
    let mut looked_at = LookedAt::all(clip.info().frames);
    if let Some(kept) = kept {
        looked_at.motion = kept.looked_at(clip.info().frames);
        looked_at.pictures.clone_from(&looked_at.motion);
        rig.keyframes.iter().filter(|k| !k.strokes.is_empty()).for_each(|k| looked_at.pictures[k.frame] = true);
    }
    let footage = Footage::read(clip, params.working_side, &looked_at, stage.part(0.0, 0.6))?;
    solve_in(&footage, clip, rig, skeleton, kept, &params.space_time, stage.part(0.6, 1.0))
}

/// The same in `footage` of the clip that was read before.
pub(super) fn solve_in(
    footage: &Footage,
    clip: &Clip,
    rig: &Rig,
    skeleton: &Skeleton,
    kept: Option<&Kept>,
    params: &SpaceTimeParams,
    stage: Stage<'_>,
) -> Result<Vec<Trajectory>> {
    let turns = solving_order(rig, skeleton);
    let foreground = learn_foreground(rig, footage);
    let animal: Vec<Grid<u8>> = footage.lab.par_iter().map(|image| foreground.seen(image)).collect();
    let key_planes = key_planes(clip, rig, footage)?;
    let mut claims = Claims::new(footage);
    let mut solved: Vec<Option<Solved>> = vec![None; rig.limbs.len()];
    let groups = groups(rig, &turns);
    for (i, group) in groups.iter().enumerate() {
        let part = |i: usize| i as f64 / groups.len() as f64;
        let mut tasks = Vec::with_capacity(2);
        for (place, &turn) in group.iter().enumerate() {
            let keys = LimbKeys::new(rig, skeleton, turn, footage.scale);
            let roots = roots(rig, skeleton, turn, &turns, &keys, &solved, footage);
            let carries = turns.iter().any(|t| t.from.is_some_and(|(p, _)| p == turn.limb));
            let kept = kept.map(|k| KeptLimb::new(k.limb(turn.limb), turn.reversed, footage.scale));
            let far = rig.limbs[turn.limb].side == Some(Side::Far);
            let radii = radii(&keys, &key_planes);
            // What is in front of it where it was drawn: solved limbs and, as drawn, the near one of its pair.
            let in_front: Vec<Option<Mask>> = keys
                .frames
                .iter()
                .map(|&f| {
                    far.then(|| {
                        let mut mask = claims.frame(f).clone();
                        let near: Option<&Task<'_>> = if place > 0 { tasks.first() } else { None };
                        if let Some(near) = near
                            && let Some(key) = near.keys.frames.iter().position(|&k| k == f)
                        {
                            cover(&mut mask, &near.keys.poses[key], &near.strip.radii);
                        }
                        mask
                    })
                })
                .collect();
            let views: Vec<(usize, View<'_>, &[Vec2])> = keys
                .frames
                .iter()
                .zip(&keys.poses)
                .zip(&in_front)
                .map(|((&f, pose), mask)| {
                    let view = View { image: &footage.lab[f], animal: &animal[f], claimed: mask.as_ref() };
                    (f, view, pose.as_slice())
                })
                .collect();
            let strip = Strip::new(radii, &views, !carries);
            let stretch = vec![1.0; footage.frames()];
            let claims = far.then_some(&claims);
            let rest = roots.clone().unwrap_or_else(|| {
                let middle = keys.poses[0][keys.vertices() / 2];
                footage.on_the_ground(middle, keys.frames[0])
            });
            tasks.push(Task {
                params,
                footage,
                animal: &animal,
                keys,
                strip,
                roots,
                rest,
                claims,
                carries,
                kept: kept.unwrap_or_default(),
                stretch,
            });
        }
        let ordered = group.iter().any(|t| rig.limbs[t.limb].side == Some(Side::Far));
        let results = solve_group(&mut tasks, &claims, ordered, stage.part(part(i), part(i + 1)))?;
        let radii: Vec<Vec<f32>> = tasks.into_iter().map(|t| t.strip.radii).collect();
        for ((turn, result), radii) in group.iter().zip(results).zip(radii) {
            if rig.limbs[turn.limb].side != Some(Side::Far) {
                claims.cover(&result.poses, &radii);
            }
            solved[turn.limb] = Some(result);
        }
    }
    let out = solved.into_iter().zip(0..).filter_map(|(s, l)| Some((s?, l)));
    Ok(out.map(|(s, l)| finish(s, turns.iter().any(|t| t.limb == l && t.reversed), footage.scale)).collect())
}

fn finish(solved: Solved, reversed: bool, scale: f32) -> Trajectory {
    let Solved { mut poses, mut visible, mut confidence } = solved;
    poses.iter_mut().flatten().for_each(|p| *p /= scale);
    if reversed {
        poses.iter_mut().for_each(|p| p.reverse());
        visible.iter_mut().for_each(|v| v.reverse());
        confidence.iter_mut().for_each(|c| c.reverse());
    }
    Trajectory { poses, visible, confidence }
}

/// Share of the time that goes into the poses every frame starts with.
const FIRST: f64 = 0.4;

/// Solves one limb, or a pair together. `ordered` says that the first of a pair is in front of the second.
fn solve_group(tasks: &mut [Task<'_>], claims: &Claims, ordered: bool, stage: Stage<'_>) -> Result<Vec<Solved>> {
    if tasks.iter().all(|task| task.kept.is_whole()) {
        return Ok(tasks.iter().map(standing).collect());
    }
    let frames = tasks[0].footage.frames();
    let mut lists: Vec<Vec<Vec<Candidate>>> = Vec::with_capacity(tasks.len());
    let mut trusts: Vec<Vec<Vec<f32>>> = Vec::with_capacity(tasks.len());
    let count = tasks.len();
    for (i, task) in tasks.iter_mut().enumerate() {
        let ((ahead, grown), (behind, grown_back)) = (chain(task, true), chain(task, false));
        for f in 0..frames {
            task.stretch[f] = match (&ahead[f], &behind[f]) {
                (Some(_), Some(_)) => {
                    let late = |k: usize| if task.keys.frames[k] >= f { 1.0 } else { 0.0 };
                    let share = task.keys.mixed(f, late, |a, b, t| a + (b - a) * t);
                    grown[f] + (grown_back[f] - grown[f]) * share
                }
                (None, Some(_)) => grown_back[f],
                _ => grown[f],
            };
        }
        let task = &*task;
        trusts.push((0..frames).map(|f| mixed_chains(&task.keys, f, &ahead[f], &behind[f]).1).collect());
        let list = (0..frames)
            .into_par_iter()
            .map(|f| {
                stage.at(FIRST * (i as f64 + f as f64 / frames as f64) / count as f64)?;
                let poses = first_poses(task, f, &ahead[f], &behind[f]);
                Ok(poses.into_iter().map(|p| judged(task, f, p)).collect())
            })
            .collect::<Result<_>>()?;
        lists.push(list);
    }
    let tasks = &*tasks;
    let rounds = tasks[0].params.rounds;
    // Of each round, the first one included, a part is for adding poses and the rest for finding the path.
    let share = |round: usize| FIRST + (1.0 - FIRST) * round as f64 / (rounds + 1) as f64;
    let mut paths = best(tasks, &lists, claims, ordered, stage.part(share(0), share(1)))?;
    for round in 0..rounds {
        let this = stage.part(share(round + 1), share(round + 2));
        let (adding, finding) = (this.part(0.0, 0.7), this.part(0.7, 1.0));
        let mut chosen = chosen_poses(&paths, &lists);
        if swings(tasks, &chosen) {
            untangle(tasks, &mut chosen);
        }
        for (i, (task, list)) in tasks.iter().zip(&mut lists).enumerate() {
            let poses = &chosen[i];
            let twin = if i == 0 { chosen.get(1) } else { chosen.first() }.map(Vec::as_slice);
            let gait = if task.roots.is_some() { Gait::of(poses, twin) } else { None };
            let added: Vec<Vec<Candidate>> = (0..frames)
                .into_par_iter()
                .map(|f| {
                    adding.at((i as f64 + f as f64 / frames as f64) / count as f64)?;
                    let mut hints: Vec<Vec<Vec2>> = gait.iter().flat_map(|g| g.foretold(poses, twin, f)).collect();
                    hints.extend(twin.map(|t| crossings::as_other(&t[f], poses[f][0], poses[f].len())));
                    Ok(near_poses(task, f, poses, hints).into_iter().map(|p| judged(task, f, p)).collect())
                })
                .collect::<Result<_>>()?;
            for (list, new) in list.iter_mut().zip(added) {
                list.extend(new);
            }
        }
        paths = best(tasks, &lists, claims, ordered, finding)?;
    }
    let mut chosen = chosen_poses(&paths, &lists);
    untangle(tasks, &mut chosen);
    let mut solved: Vec<Solved> = Vec::with_capacity(count);
    let finishing = stage.part(1.0, 1.0);
    for ((i, task), poses) in tasks.iter().enumerate().zip(chosen) {
        // Of a pair in known order, the second may be behind the first.
        let front = if ordered && i > 0 { tasks.first().zip(solved.first()) } else { None };
        let alone = Group { first: Chain { lists: &lists[i], rest: &task.rest }, second: None, together: &[] };
        let costs = costs_through(&alone, tasks[0].params, finishing)?.through;
        let trust = trust(task, &poses, &lists[i], &costs, &trusts[i], front, finishing)?;
        let (visible, confidence) = trust.into_iter().unzip();
        solved.push(Solved { poses, visible, confidence });
    }
    Ok(solved)
}

/// A limb that is kept in every frame.
fn standing(task: &Task<'_>) -> Solved {
    let kept = (0..task.footage.frames()).filter_map(|f| task.kept.at(f).cloned());
    let (poses, (visible, confidence)) = kept.map(|k| (k.points, (k.visible, k.confidence))).unzip();
    Solved { poses, visible, confidence }
}

/// The poses on the paths, of every limb in every frame.
fn chosen_poses(paths: &[Vec<usize>], lists: &[Vec<Vec<Candidate>>]) -> Vec<Vec<Vec<Vec2>>> {
    let of = |(path, lists): (&Vec<usize>, &Vec<Vec<Candidate>>)| {
        path.iter().zip(lists).map(|(&c, list)| list[c].pose.clone()).collect()
    };
    paths.iter().zip(lists).map(of).collect()
}

/// Whether the limbs of a pair go through a cycle, so that where they meet they pass.
fn swings(tasks: &[Task<'_>], chosen: &[Vec<Vec<Vec2>>]) -> bool {
    tasks.iter().zip(chosen).any(|(task, poses)| task.roots.is_some() && Gait::of(poses, None).is_some())
}

/// Gives the limbs of a pair back their own poses where they bounced off each other.
fn untangle(tasks: &[Task<'_>], chosen: &mut [Vec<Vec<Vec2>>]) {
    let ([a, b], [first, second]) = (tasks, &mut *chosen) else { return };
    let mut drawn = vec![false; first.len()];
    a.keys.frames.iter().chain(&b.keys.frames).for_each(|&f| drawn[f] = true);
    drawn.iter_mut().enumerate().for_each(|(f, drawn)| *drawn |= a.kept.at(f).or(b.kept.at(f)).is_some());
    let exchange = crossings::exchanged([first.as_slice(), second.as_slice()], &drawn);
    let own = |task: &Task<'_>, f: usize, old: &[Vec2], other: &[Vec2]| {
        let pose = crossings::as_other(other, old[0], old.len());
        pose_search::settle(&task.strip, &task.view(f), f, &pose, false)
    };
    for f in (0..first.len()).filter(|&f| exchange[f]) {
        (first[f], second[f]) = (own(a, f, &first[f], &second[f]), own(b, f, &second[f], &first[f]));
    }
}

/// For every frame whether each vertex is seen, and how far it is to be trusted.
fn trust(
    task: &Task<'_>,
    poses: &[Vec<Vec2>],
    lists: &[Vec<Candidate>],
    costs: &[Vec<f32>],
    trusts: &[Vec<f32>],
    front: Option<(&Task<'_>, &Solved)>,
    stage: Stage<'_>,
) -> Result<Vec<(Vec<bool>, Vec<f32>)>> {
    (0..poses.len())
        .into_par_iter()
        .map(|f| {
            stage.at(f as f64 / poses.len() as f64)?;
            if let Some(kept) = task.kept.at(f) {
                return Ok((kept.visible.clone(), kept.confidence.clone()));
            }
            let pose = &poses[f];
            let view = task.view(f);
            let mut mask = Claims::blank(task.footage);
            if let Some((near, solved)) = front {
                cover(&mut mask, &solved.poses[f], &near.strip.radii);
            }
            let length: f32 = task.lengths(f).iter().sum::<f32>().max(1.0);
            let spread = spread(pose, &lists[f], &costs[f]);
            let keys = task.strip.keys_around(f);
            let misfit = |e: usize| task.strip.edge_cost(&view, keys, e, pose[e], pose[e + 1]);
            let vertices = (0..pose.len()).map(|v| {
                let cell = pose[v] / CLAIM_CELL;
                let outside = task.footage.lab[f].at(pose[v]).is_none();
                let hidden = outside || view.is_claimed(pose[v]) || mask.at(cell.x as isize, cell.y as isize);
                let evidence = Evidence {
                    spread: spread[v] / length,
                    misfit: 0.5 * (misfit(v.saturating_sub(1)) + misfit(v.min(pose.len() - 2))),
                    trust: trusts[f][v],
                    along: v as f32 / (pose.len() - 1) as f32,
                };
                (!hidden, evidence.confidence())
            });
            Ok(vertices.unzip())
        })
        .collect()
}

/// The best path of one limb, or of two that hide each other.
fn best(
    tasks: &[Task<'_>],
    lists: &[Vec<Vec<Candidate>>],
    claims: &Claims,
    ordered: bool,
    stage: Stage<'_>,
) -> Result<Vec<Vec<usize>>> {
    let together: Vec<Vec<f32>> = match (tasks, lists) {
        ([a, b], [first, second]) => (0..first.len())
            .into_par_iter()
            .map(|f| {
                stage.at(0.5 * f as f64 / first.len() as f64)?;
                if tasks.iter().all(|task| task.kept.at(f).is_some()) {
                    return Ok(vec![0.0]);
                }
                Ok(together([a, b], claims, f, [&first[f], &second[f]], ordered))
            })
            .collect::<Result<_>>()?,
        _ => Vec::new(),
    };
    let chain = |i: usize| Some(Chain { lists: lists.get(i)?, rest: &tasks.get(i)?.rest });
    let Some(first) = chain(0) else { return Ok(Vec::new()) };
    best_path(&Group { first, second: chain(1), together: &together }, tasks[0].params, stage.part(0.5, 1.0))
}

/// For every pose of the first limb, and within it for every one of the second, what the two cost beyond their own
/// costs: what one hides of the other, and what animal neither covers.
fn together(tasks: [&Task<'_>; 2], claims: &Claims, f: usize, lists: [&[Candidate]; 2], ordered: bool) -> Vec<f32> {
    let covers: [Vec<Mask>; 2] = std::array::from_fn(|side| {
        let mask = |c: &Candidate| {
            let mut mask = Claims::blank(tasks[side].footage);
            cover(&mut mask, &c.pose, &tasks[side].strip.radii);
            mask
        };
        lists[side].iter().map(mask).collect()
    });
    let hideable: [Vec<Hideable>; 2] = std::array::from_fn(|side| {
        let view = tasks[side].view(f);
        lists[side].iter().map(|c| tasks[side].strip.hideable(&view, f, &c.pose)).collect()
    });
    let unexplained = Unexplained::new(tasks, claims, f);
    let bits: [Vec<Vec<u64>>; 2] =
        std::array::from_fn(|side| covers[side].iter().map(|m| unexplained.covered(m)).collect());
    let mut out = Vec::with_capacity(lists[0].len() * lists[1].len());
    for i in 0..lists[0].len() {
        for j in 0..lists[1].len() {
            let mut hidden = hideable[1][j].change(&covers[0][i]);
            if !ordered {
                // Nobody said which is in front: whichever order costs less.
                hidden = hidden.min(hideable[0][i].change(&covers[1][j]));
            }
            out.push(hidden + unexplained.cost(&bits[0][i], &bits[1][j]));
        }
    }
    out
}

/// What a frame starts with: the drawn or kept pose alone where there is one; else the carried ones and what a search
/// finds.
fn first_poses(task: &Task<'_>, f: usize, ahead: &Reached, behind: &Reached) -> Vec<Vec<Vec2>> {
    let keys = &task.keys;
    if let Some(key) = keys.frames.iter().position(|&k| k == f) {
        return vec![keys.poses[key].clone()];
    }
    if let Some(kept) = task.kept.at(f) {
        return vec![kept.points.clone()];
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
            let lengths = task.lengths(f);
            poses.extend(pose_search::search(
                &task.strip,
                &task.view(f),
                f,
                &keys.poses[key],
                &lengths,
                roots[f],
                task.params,
            ));
        }
    }
    poses
}

/// Poses worth trying around a path: its neighbours in time carried here, between them, `hints` from elsewhere, and a
/// better fit near each.
fn near_poses(task: &Task<'_>, f: usize, path: &[Vec<Vec2>], hints: Vec<Vec<Vec2>>) -> Vec<Vec<Vec2>> {
    if task.keys.frames.contains(&f) || task.kept.at(f).is_some() {
        return Vec::new();
    }
    let mut poses = Vec::new();
    let root = task.roots.as_ref().map(|r| r[f]);
    let lengths = task.lengths(f);
    for from in [f.checked_sub(1), (f + 1 < path.len()).then_some(f + 1)].into_iter().flatten() {
        if let Some((flow, back)) = task.footage.flows(from, f) {
            poses.push(carry(&path[from], &task.strip.radii, &lengths, flow, back, root).points);
        }
    }
    if f > 0 && f + 1 < path.len() {
        poses.push(path[f - 1].iter().zip(&path[f + 1]).map(|(a, b)| a.lerp(*b, 0.5)).collect());
    }
    poses.extend(hints);
    let view = task.view(f);
    let starts: Vec<Vec<Vec2>> = poses.iter().cloned().chain([path[f].clone()]).collect();
    poses.extend(starts.into_iter().map(|p| pose_search::settle(&task.strip, &view, f, &p, task.roots.is_none())));
    poses
}

fn judged(task: &Task<'_>, f: usize, pose: Vec<Vec2>) -> Candidate {
    if task.kept.surrounds(f) {
        return Candidate { pose, cost: 0.0, next: None, last: None };
    }
    let cost = task.strip.cost(&task.view(f), f, &pose);
    let moved = |to: usize| {
        let (flow, back) = task.footage.flows(f, to)?;
        let root = task.roots.as_ref().map(|r| r[to]);
        Some(carry(&pose, &task.strip.radii, &task.lengths(to), flow, back, root))
    };
    let (next, last) = (moved(f + 1), f.checked_sub(1).and_then(moved));
    Candidate { pose, cost, next, last }
}
