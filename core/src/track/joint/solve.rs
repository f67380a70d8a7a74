//! All joints over a range of frames, solved together over the skeleton and over time.
//!
//! Chain by chain from the part that says most outward: every frame gets a list of poses, and the cheapest path through
//! the lists trades looks against a steady motion. Then every chain is solved anew, knowing where the others are seen,
//! so that two legs that look alike do not both take the nearer one.

use std::ops::Range;

use glam::Vec2;
use rayon::prelude::*;

use super::limb::{Limb, SAME, distinct};
use super::params::JointParams;
use super::parts::{Claims, Look, Part};
use super::pose_path::{Candidate, Motion, best_path, turned_on};
use super::scene::Scene;
use super::tree::{Chain, Tree};
use crate::error::Result;
use crate::job::Stage;

/// Everything about the character that does not change.
pub(super) struct Character<'a> {
    pub(super) scene: &'a Scene,
    pub(super) tree: &'a Tree,
    pub(super) parts: &'a [Part],
    pub(super) chains: &'a [Chain],
    /// Where all joints are on the frame that parts are cut from, working pixels.
    pub(super) places: &'a [Vec2],
    /// Distance from a joint, working pixels, within which it is looked whether it is seen.
    pub(super) radii: &'a [f32],
    pub(super) params: &'a JointParams,
}

/// A joint in one frame, in working pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Place {
    pub(super) at: Vec2,
    pub(super) visible: bool,
    pub(super) confidence: f32,
}

/// Frames of a whole clip, by joint, where they are known: working pixels.
pub(super) type Pins = Vec<Vec<Option<Vec2>>>;

/// Poses of one chain: by frame of the range, then by pose.
type Poses = Vec<Vec<Vec<Vec2>>>;

impl Character<'_> {
    /// All joints, also those nobody marked, in every frame of `range`. `pins` has every marked joint of every frame.
    pub(super) fn solve(&self, range: Range<usize>, pins: &Pins, stage: Stage<'_>) -> Result<Vec<Vec<Place>>> {
        let frames = range.len();
        let mut at: Vec<Vec<Option<Vec2>>> = vec![vec![None; self.places.len()]; frames];
        let blank = |f: usize| {
            let view = self.scene.fine[f].as_ref();
            view.map_or_else(|| Claims::new(1, 1), |v| Claims::new(v.width, v.height))
        };
        let mut claims: Vec<Claims> = range.clone().map(blank).collect();
        let mut poses: Vec<Poses> = vec![Vec::new(); self.chains.len()];
        let rounds = self.params.rounds.max(1);
        for round in 0..rounds {
            for c in 0..self.chains.len() {
                let share = |c: usize| (round * self.chains.len() + c) as f64 / (rounds * self.chains.len()) as f64;
                let stage = stage.part(share(c), share(c + 1));
                let limb = self.limb(c, &range, pins, &at);
                claims.iter_mut().for_each(|c| c.remove(limb.bit));
                if round == 0 {
                    poses[c] = self.first_poses(&limb, &range, &claims, stage.part(0.0, 0.6))?;
                }

                let known = (round > 0).then_some(&claims[..]);
                let path = follow(&limb, &range, &mut poses[c], known, stage.part(0.6, 1.0))?;
                for (i, pose) in path.iter().enumerate() {
                    for (joint, place) in self.chains[c].joints.iter().zip(pose) {
                        at[i][*joint] = Some(*place);
                    }
                }
                // Which of two limbs is where is not decided by who comes first.
                if round > 0 || self.leads_on(c) {
                    self.claim(c, &range, &at, &mut claims);
                }
            }
            if round == 0 {
                (0..self.chains.len())
                    .filter(|&c| !self.leads_on(c))
                    .for_each(|c| self.claim(c, &range, &at, &mut claims));
            }
        }
        let all = at.into_iter().map(|frame| frame.into_iter().map(Option::unwrap_or_default).collect::<Vec<Vec2>>());
        let judged = all.enumerate().map(|(i, at)| self.judged(range.start + i, &at, &claims[i]));
        Ok(judged.collect())
    }

    /// Whether other chains hang on this one, or it on none.
    fn leads_on(&self, chain: usize) -> bool {
        let end = self.chains[chain].joints.last();
        self.chains[chain].free || self.chains.iter().any(|c| !c.free && c.joints.first() == end)
    }

    /// Claims the places where a solved chain is seen.
    fn claim(&self, chain: usize, range: &Range<usize>, at: &[Vec<Option<Vec2>>], claims: &mut [Claims]) {
        claims.par_iter_mut().zip(at).enumerate().for_each(|(i, (claims, at))| {
            let Some(view) = &self.scene.fine[range.start + i] else { return };
            let look = Look { view, level: 0, claims: None, params: self.params };
            for &bone in &self.chains[chain].bones {
                if let [Some(from), Some(to)] = self.tree.bones[bone].joints.map(|j| at[j]) {
                    self.parts[bone].claim(&look, claims, Self::bit(chain), from, to);
                }
            }
        });
    }

    fn bit(chain: usize) -> u64 {
        1 << (chain % 64)
    }

    fn limb(&self, c: usize, range: &Range<usize>, pins: &Pins, at: &[Vec<Option<Vec2>>]) -> Limb<'_> {
        let chain = &self.chains[c];
        let all = self.scene.frames();
        let ends = chain.joints.windows(2).map(|j| (j[0], j[1]));
        let pinned = |joint: usize| (0..all).map(|f| pins[f].get(joint).copied().flatten()).collect();
        let of_range = |place: &dyn Fn(&[Option<Vec2>]) -> Option<Vec2>| -> Vec<Option<Vec2>> {
            let mut out = vec![None; all];
            for (f, at) in range.clone().zip(at) {
                out[f] = place(at);
            }
            out
        };
        let root = chain.joints[0];
        let attached = chain.beside.map(|beside| {
            let [from, to] = self.tree.bones[beside].joints;
            let rest = self.places[to] - self.places[from];
            let own = self.places[chain.joints[1]] - self.places[root];
            move |at: &[Option<Vec2>]| Some(turned_like(own, rest, at[to]? - at[from]?))
        });
        let attached = match &attached {
            Some(place) => of_range(place),
            None => vec![None; all],
        };
        Limb {
            chain,
            parts: self.parts,
            reversed: chain.bones.iter().zip(&chain.joints).map(|(&b, &j)| self.tree.bones[b].joints[0] != j).collect(),
            rest: ends.map(|(a, b)| self.places[b] - self.places[a]).collect(),
            weights: chain.bones.iter().map(|&b| self.parts[b].weight).collect(),
            params: self.params,
            scene: self.scene,
            bit: Self::bit(c),
            pins: chain.joints.iter().map(|&j| pinned(j)).collect(),
            roots: if chain.free { vec![None; all] } else { of_range(&|at| at[root]) },
            attached,
        }
    }

    /// What every frame starts with.
    fn first_poses<'a>(
        &self,
        limb: &Limb<'a>,
        range: &Range<usize>,
        claims: &'a [Claims],
        stage: Stage<'_>,
    ) -> Result<Poses> {
        let frames = range.len();
        if !limb.chain.free {
            return range
                .clone()
                .into_par_iter()
                .map(|f| {
                    stage.at((f - range.start) as f64 / frames as f64)?;
                    let found = limb.search(f, Some(&claims[f - range.start]));
                    let mut poses: Vec<Vec<Vec2>> = found.iter().map(|p| limb.settled(f, None, p)).collect();
                    distinct(&mut poses, 0.4 * SAME);
                    Ok(poses)
                })
                .collect();
        }
        let marked = |f: usize| -> Option<Vec<Vec2>> { limb.pins.iter().map(|p| p[f]).collect() };
        let rest: Vec<Vec2> = limb.chain.joints.iter().map(|&j| self.places[j]).collect();
        let start = |f: usize| marked(f).or_else(|| limb.pins[0][f].map(|_| limb.pinned(f, rest.clone())));
        let mut poses: Poses = vec![Vec::new(); frames];
        let mut sweep = |order: &mut dyn Iterator<Item = usize>| -> Result<()> {
            let mut from: Option<Vec<Vec2>> = None;
            for f in order {
                stage.at(0.5 * (f - range.start) as f64 / frames as f64)?;
                if let Some(held) = start(f) {
                    let held = limb.settled(f, None, &held);
                    poses[f - range.start].push(held.clone());
                    from = Some(held);
                } else if let Some(before) = &from {
                    let mut found: Vec<Vec<Vec2>> =
                        limb.search_free(f, before).iter().map(|p| limb.settled(f, None, p)).collect();
                    distinct(&mut found, 0.4 * SAME);
                    let near = |p: &Vec<Vec2>| {
                        let moved: f32 = p.iter().zip(before).map(|(a, b)| a.distance_squared(*b)).sum();
                        limb.judged(f, None, p.clone()).cost + 1e-4 * moved / p.len() as f32
                    };
                    let best = found.iter().min_by(|a, b| near(a).total_cmp(&near(b))).cloned();
                    poses[f - range.start].extend(found);
                    from = best.or(from);
                }
            }
            Ok(())
        };
        sweep(&mut range.clone())?;
        sweep(&mut range.clone().rev())?;
        for (i, list) in poses.iter_mut().enumerate() {
            if list.is_empty() {
                list.push(limb.pinned(range.start + i, rest.clone()));
            }
            distinct(list, 0.4 * SAME);
        }
        Ok(poses)
    }

    /// Where joints are, whether they are seen, and how surely.
    fn judged(&self, frame: usize, at: &[Vec2], claims: &Claims) -> Vec<Place> {
        let Some(view) = &self.scene.fine[frame] else {
            return at.iter().map(|&at| Place { at, visible: false, confidence: 0.0 }).collect();
        };
        let place = |joint: usize| {
            let (mut near, mut whole, mut own) = (0.0f32, 0.0f32, 0);
            for (c, chain) in self.chains.iter().enumerate() {
                let bones = chain.bones.iter().filter(|&&b| self.tree.bones[b].joins(joint));
                let look = Look { view, level: 0, claims: None, params: self.params };
                for &b in bones {
                    own |= Self::bit(c);
                    let ends = self.tree.bones[b].joints.map(|j| at[j]);
                    let around = self.parts[b].seen(&look, ends.into(), Some((at[joint], self.radii[joint])));
                    if around.1 >= LEAST_SEEN {
                        near = near.max(around.0);
                    }
                    whole = whole.max(self.parts[b].seen(&look, ends.into(), None).0);
                }
            }
            if near == 0.0 {
                near = whole;
            }
            let covered = claims.covered(at[joint], self.radii[joint], own);
            let inside = view.at(at[joint]).is_some_and(|p| p[3] >= 128);
            let visible = inside && near > if covered > 0.5 { COVERED } else { BARE };
            Place { at: at[joint], visible, confidence: 0.5 * (near + whole) }
        };
        (0..at.len()).map(place).collect()
    }
}

/// How well a joint's surroundings have to look like its part, over 0..=1, for it to be seen: where others are seen, and
/// where none is (skin that stretches over a bent joint looks like neither part). And of how many places at least.
const COVERED: f32 = 0.8;
const BARE: f32 = 0.3;
const LEAST_SEEN: usize = 4;

/// `own`, turned and grown as `rest` has become `now`.
fn turned_like(own: Vec2, rest: Vec2, now: Vec2) -> Vec2 {
    let square = rest.length() * now.length();
    if square < 1.0 {
        return own;
    }
    Vec2::new(rest.dot(now), rest.perp_dot(now)).rotate(own) / square
}

/// How often poses near the path are added.
const NEAR: usize = 2;

/// The cheapest path through the lists, after poses near it were added to them. `claims` is by frame of the range.
fn follow<'a>(
    limb: &Limb<'a>,
    range: &Range<usize>,
    poses: &mut Poses,
    claims: Option<&'a [Claims]>,
    stage: Stage<'_>,
) -> Result<Vec<Vec<Vec2>>> {
    let lengths: Vec<f32> = limb.rest.iter().map(|r| r.length()).collect();
    let unit = 0.1 * limb.scene.fine.iter().flatten().next().map_or(400, |v| v.width.max(v.height)) as f32;
    let motion = Motion {
        lengths: &lengths,
        weights: &limb.weights,
        free: limb.chain.free.then_some(unit),
        params: limb.params,
    };
    let judge = |i: usize, poses: Vec<Vec<Vec2>>| -> Vec<Candidate> {
        let f = range.start + i;
        let place = |pose: Vec<Vec2>| limb.judged(f, claims.map(|c| &c[i]), limb.pinned(f, pose));
        poses.into_iter().map(place).collect()
    };
    let mut lists: Vec<Vec<Candidate>> =
        poses.par_iter_mut().enumerate().map(|(i, list)| judge(i, std::mem::take(list))).collect();
    stage.at(0.1)?;
    let (mut path, _) = best_path(&lists, &motion);
    for round in 0..NEAR {
        let taken: Vec<Vec<Vec2>> = path.iter().zip(&lists).map(|(&p, list)| list[p].pose.clone()).collect();
        let more: Vec<Vec<Candidate>> = (0..lists.len())
            .into_par_iter()
            .map(|i| {
                stage.at(0.1 + 0.9 * (round as f64 + i as f64 / lists.len() as f64) / NEAR as f64)?;
                let f = range.start + i;
                let mut near: Vec<Vec<Vec2>> = near_path(&taken, i);
                let mut starts = near.clone();
                distinct(&mut starts, SAME);
                let settled: Vec<Vec<Vec2>> =
                    starts.iter().map(|p| limb.settled(f, claims.map(|c| &c[i]), p)).collect();
                near.extend(settled);
                let mut near: Vec<Vec<Vec2>> = near.into_iter().map(|p| limb.pinned(f, p)).collect();
                distinct(&mut near, 0.2 * SAME);
                Ok(judge(i, near))
            })
            .collect::<Result<_>>()?;
        lists.iter_mut().zip(more).for_each(|(list, more)| list.extend(more));
        path = best_path(&lists, &motion).0;
    }
    let taken = path.iter().zip(&lists).map(|(&p, list)| list[p].pose.clone()).collect();
    let kept = |(list, path): (Vec<Candidate>, usize)| {
        let mut order: Vec<usize> = (0..list.len()).filter(|&i| i != path).collect();
        order.sort_by(|&a, &b| list[a].cost.total_cmp(&list[b].cost));
        let mut poses: Vec<Vec<Vec2>> = vec![list[path].pose.clone()];
        poses.extend(order.into_iter().map(|i| list[i].pose.clone()));
        distinct(&mut poses, 0.4 * SAME);
        poses.truncate(limb.params.found);
        poses
    };
    *poses = lists.into_iter().zip(path).map(kept).collect();
    Ok(taken)
}

/// Poses that a path suggests for its frame `i`: those of its neighbours, what their motion leads to, and between them.
fn near_path(path: &[Vec<Vec2>], i: usize) -> Vec<Vec<Vec2>> {
    let at = |i: usize, by: isize| i.checked_add_signed(by).and_then(|i| path.get(i));
    // A pose from this one's first joint on, by bones.
    let built = |start: Vec2, bone: &dyn Fn(usize) -> Vec2| -> Vec<Vec2> {
        let mut pose = vec![start];
        (0..path[i].len() - 1).for_each(|k| pose.push(pose[k] + bone(k)));
        pose
    };
    let bone = |pose: &[Vec2], k: usize| pose[k + 1] - pose[k];
    let mut near = vec![path[i].clone()];
    for side in [-1, 1] {
        let Some(one) = at(i, side) else { continue };
        near.push(built(path[i][0], &|k| bone(one, k)));
        if let Some(two) = at(i, 2 * side) {
            near.push(built(2.0 * one[0] - two[0], &|k| turned_on(bone(two, k), bone(one, k))));
        }
    }
    for reach in [1, 2, 4, 8] {
        if let (Some(a), Some(b)) = (at(i, -reach), at(i, reach)) {
            near.push(built(0.5 * (a[0] + b[0]), &|k| halfway(bone(a, k), bone(b, k))));
        }
    }
    near
}

/// The bone half-way between two: half the turn, the mean length.
fn halfway(a: Vec2, b: Vec2) -> Vec2 {
    let sum = a.normalize_or_zero() + b.normalize_or_zero();
    let length = 0.5 * (a.length() + b.length());
    sum.try_normalize().map_or(a, |d| d * length)
}
