//! A point between two of its neighbouring keys, or from a key to the clip's end: solved on its own, from nothing but those
//! keys, so that a correction changes nothing beyond the keys beside it.

use glam::Vec2;
use rayon::prelude::*;

use super::candidates::{Candidate, Sought, judged, over_the_frame, settled};
use super::footage::Footage;
use super::guide::Guide;
use super::looks::Rings;
use super::params::PointParams;
use super::path::{Graph, Path};
use crate::error::Result;
use crate::job::Stage;

/// A place that looks so unlike its mark says nothing for itself.
const UNLIKE: f32 = 0.5;
/// Share of the confidence that a step loses that is not to be trusted at all.
const DOUBT: f32 = 0.15;

/// A key in working pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Key {
    pub(super) frame: usize,
    pub(super) at: Vec2,
}

/// What is solved: from frame `from` to frame `to`, both included; keys stand at the ends that have one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) keys: [Option<Key>; 2],
}

/// Where the point is in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) at: Vec2,
    pub(super) seen: bool,
    pub(super) confidence: f32,
}

/// A way a point may have gone.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Trajectory {
    pub(super) places: Vec<Place>,
    pub(super) cost: f32,
}

impl Trajectory {
    /// Where it is seen.
    pub(super) fn seen(&self) -> impl Iterator<Item = Option<Vec2>> {
        self.places.iter().map(|p| p.seen.then_some(p.at))
    }
}

/// A stretch that was solved, and what it takes to solve it otherwise.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) stretch: Stretch,
    pub(super) best: Trajectory,
    candidates: Vec<Vec<Candidate>>,
    path: Path,
    guide: Vec<Guide>,
}

impl Solved {
    fn graph<'a>(&'a self, footage: &Footage, params: &'a PointParams) -> Graph<'a> {
        Graph::new(footage, self.stretch.from, &self.candidates, self.stretch.held(), &self.guide, params)
    }

    /// Other ways, of which no two, nor one and the best, are near each other for long.
    pub(super) fn alternatives(
        &self,
        footage: &Footage,
        params: &PointParams,
        stage: Stage<'_>,
    ) -> Result<Vec<Trajectory>> {
        let paths = self.graph(footage, params).alternatives(&self.path, stage)?;
        Ok(paths.iter().map(|p| self.stretch.trajectory(footage, &self.candidates, p)).collect())
    }

    /// The best way that keeps away from what is at `others`, one entry a frame of the stretch.
    pub(super) fn around(
        &self,
        footage: &Footage,
        params: &PointParams,
        others: &[Option<Vec2>],
        stage: Stage<'_>,
    ) -> Result<Trajectory> {
        let path = self.graph(footage, params).around(others, stage)?;
        Ok(self.stretch.trajectory(footage, &self.candidates, &path))
    }
}

impl Stretch {
    /// Solves it; `guide` says for every frame of the clip, or for none, where other points would have it.
    pub(super) fn solve(
        &self,
        footage: &Footage,
        params: &PointParams,
        guide: &[Guide],
        stage: Stage<'_>,
    ) -> Result<Solved> {
        let mut guide = guide.get(self.from..=self.to).unwrap_or_default().to_vec();
        // A key where the guide is not says that it is wrong around there.
        let reach = params.guide_reach * footage.unit;
        for key in self.keys.iter().flatten() {
            let miss = guide.get(key.frame - self.from).map_or(0.0, |g| g.at.distance(key.at));
            guide.iter_mut().for_each(|g| g.trust *= reach * reach / (reach * reach + 4.0 * miss * miss));
        }
        let rings = Rings::new(footage.unit, 0.0);
        let sought: Vec<Sought> = self.keys.iter().flatten().map(|k| Sought::new(footage, k.frame, k.at)).collect();
        let held = |f: usize| sought.iter().find(|s| s.frame == f);
        let chains: Vec<Vec<Vec<Candidate>>> =
            sought.iter().map(|s| self.chains(footage, &rings, &sought, s, stage)).collect::<Result<_>>()?;
        let chains = chains.concat();
        let mut candidates: Vec<Vec<Candidate>> = (self.from..=self.to)
            .into_par_iter()
            .map(|f| {
                stage.at((f - self.from) as f64 / (self.to - self.from + 1) as f64)?;
                if let Some(s) = held(f) {
                    return Ok(vec![s.marked().with_motions(footage, f)]);
                }
                let mut found = over_the_frame(footage, &rings, &sought, f, params);
                found.extend(chains.iter().map(|c| c[f - self.from]));
                if let Some(g) = guide.get(f - self.from).filter(|g| g.trust > 0.0) {
                    let there = judged(footage, &rings, &sought, f, g.at);
                    found.extend([there, settled(footage, &rings, &sought, f, there, 6.0 * footage.unit)]);
                }
                found.sort_by(|a, b| a.unlike.total_cmp(&b.unlike));
                found.dedup_by(|a, b| a.at.distance(b.at) < 0.5);
                Ok(found.into_iter().map(|c| c.with_motions(footage, f)).collect())
            })
            .collect::<Result<_>>()?;
        let mut path = Graph::new(footage, self.from, &candidates, self.held(), &guide, params)
            .best(&|_, _| 0.0, stage.part(1.0, 1.0))?;
        for _ in 1..params.rounds {
            let places = self.places(footage, &candidates, &path);
            let more: Vec<Vec<Candidate>> = (self.from..=self.to)
                .into_par_iter()
                .map(|f| {
                    let mut list = candidates[f - self.from].clone();
                    if held(f).is_none() {
                        for p in self.near_the_path(footage, &candidates, &path, &places, f) {
                            if list.iter().all(|k| k.at.distance(p) > 0.7) {
                                list.push(judged(footage, &rings, &sought, f, p).with_motions(footage, f));
                            }
                        }
                        list.sort_by(|a, b| a.unlike.total_cmp(&b.unlike));
                    }
                    list
                })
                .collect();
            candidates = more;
            path = Graph::new(footage, self.from, &candidates, self.held(), &guide, params)
                .best(&|_, _| 0.0, stage.part(1.0, 1.0))?;
        }
        let best = self.trajectory(footage, &candidates, &path);
        Ok(Solved { stretch: *self, best, candidates, path, guide })
    }

    fn held(&self) -> [bool; 2] {
        self.keys.map(|k| k.is_some())
    }

    fn trajectory(&self, footage: &Footage, candidates: &[Vec<Candidate>], path: &Path) -> Trajectory {
        Trajectory { places: self.places(footage, candidates, path), cost: path.cost }
    }

    /// From a key over the stretch by the flow alone, and with every place moved to where it looks most like the key.
    fn chains(
        &self,
        footage: &Footage,
        rings: &Rings,
        sought: &[Sought],
        key: &Sought,
        stage: Stage<'_>,
    ) -> Result<Vec<Vec<Candidate>>> {
        [false, true]
            .into_iter()
            .map(|settling| {
                let mut chain = vec![key.marked(); self.to - self.from + 1];
                let mut go = |frames: &mut dyn Iterator<Item = usize>| -> Result<()> {
                    let mut here = key.marked();
                    let mut at = key.frame;
                    for f in frames {
                        stage.at(0.0)?;
                        let (target, _) = footage.follow(here.at, at, f);
                        let target = target.clamp(Vec2::ZERO, footage.size);
                        here = judged(footage, rings, sought, f, target);
                        if settling {
                            here = settled(footage, rings, sought, f, here, 3.0 * footage.unit);
                        }
                        chain[f - self.from] = here;
                        at = f;
                    }
                    Ok(())
                };
                go(&mut (key.frame + 1..=self.to))?;
                go(&mut (self.from..key.frame).rev())?;
                Ok(chain)
            })
            .collect()
    }

    /// Where the point would be in frame `f` by its neighbours on the path: by the flow from either, and midway.
    fn near_the_path(
        &self,
        footage: &Footage,
        candidates: &[Vec<Candidate>],
        path: &Path,
        places: &[Place],
        f: usize,
    ) -> Vec<Vec2> {
        let i = f - self.from;
        let motion = |g: Option<usize>, way: usize| {
            let g = g?;
            let node = path.nodes.get(g).copied().flatten()?;
            Some(candidates[g][node].motions?[way].0)
        };
        let mut out: Vec<Vec2> = [motion(i.checked_sub(1), 0), motion(Some(i + 1), 1)].into_iter().flatten().collect();
        if let (Some(a), Some(b)) = (i.checked_sub(1), places.get(i + 1)) {
            let [a, b] = [(places[a].at, f - 1), (b.at, f + 1)].map(|(p, g)| footage.grounded(p, g));
            out.push(footage.seen(0.5 * (a + b), f));
        }
        out.retain(|p| p.is_finite());
        out.iter().map(|p| p.clamp(Vec2::ZERO, footage.size)).collect()
    }

    /// The places of a path, hidden ones bridged.
    fn places(&self, footage: &Footage, candidates: &[Vec<Candidate>], path: &Path) -> Vec<Place> {
        let seen: Vec<(usize, Vec2)> = path
            .nodes
            .iter()
            .enumerate()
            .filter_map(|(i, n)| n.map(|n| (i, footage.grounded(candidates[i][n].at, self.from + i))))
            .collect();
        let bridged = |i: usize| {
            let after = seen.partition_point(|s| s.0 < i);
            let p = match (after.checked_sub(1).map(|b| seen[b]), seen.get(after)) {
                (Some(a), Some(b)) => a.1.lerp(b.1, (i - a.0) as f32 / (b.0 - a.0) as f32),
                (Some(a), None) => a.1,
                (None, Some(b)) => b.1,
                (None, None) => Vec2::ZERO,
            };
            footage.seen(p, self.from + i)
        };
        let kept = self.kept(candidates, path);
        (0..path.nodes.len())
            .map(|i| match path.nodes[i] {
                Some(n) => {
                    let c = &candidates[i][n];
                    let like = (1.0 - c.unlike / UNLIKE).clamp(0.0, 1.0);
                    Place { at: c.at, seen: true, confidence: (0.5 * (kept[i] + like)).clamp(0.05, 1.0) }
                }
                None => Place { at: bridged(i), seen: false, confidence: 0.2 * kept[i].clamp(0.25, 1.0) },
            })
            .collect()
    }

    /// For every frame how far the way from the nearer key is to be trusted: each step's trust, multiplied up.
    fn kept(&self, candidates: &[Vec<Candidate>], path: &Path) -> Vec<f32> {
        let n = path.nodes.len();
        let trust = |i: usize| {
            let node = |i: usize| path.nodes[i].and_then(|c| candidates[i][c].motions);
            let step = node(i).zip(node(i + 1)).map_or(0.0, |(a, b)| 0.5 * (a[0].1 + b[1].1));
            1.0 - DOUBT * (1.0 - step)
        };
        let (mut forth, mut back) = (vec![0.0f32; n], vec![0.0f32; n]);
        if self.keys[0].is_some() {
            forth[0] = 1.0;
        }
        if self.keys[1].is_some() {
            back[n - 1] = 1.0;
        }
        for i in 1..n {
            forth[i] = forth[i - 1] * trust(i - 1);
            let j = n - 1 - i;
            back[j] = back[j + 1] * trust(j);
        }
        forth.iter().zip(&back).map(|(a, b)| a.max(*b)).collect()
    }
}
