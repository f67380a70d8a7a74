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
/// A guide's error falls to 1 / e in so many frames: those found on rendered and drawn animals do so in 4 to 12.
const RECALL: f32 = 6.0;
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

/// A stretch with the places where its point may be and the cheapest path through them that no guide leads.
#[derive(Clone, Debug)]
pub(super) struct Alone {
    pub(super) stretch: Stretch,
    sought: Vec<Sought>,
    candidates: Vec<Vec<Candidate>>,
    path: Path,
    /// What the path costs in every frame.
    spent: Vec<f32>,
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

impl Alone {
    /// The way of the point by itself.
    pub(super) fn way(&self, footage: &Footage) -> Trajectory {
        self.stretch.trajectory(footage, &self.candidates, &self.path)
    }

    /// The way of the point with `guide`, which says for every frame of the clip, or for none, where other points would
    /// have it.
    pub(super) fn guided(
        &self,
        footage: &Footage,
        params: &PointParams,
        guide: &[Guide],
        stage: Stage<'_>,
    ) -> Result<Solved> {
        let stretch = self.stretch;
        let mut guide = guide.get(stretch.from..=stretch.to).unwrap_or_default().to_vec();
        stretch.bend(&mut guide, params.guide_reach * footage.unit);
        let (mut candidates, mut path) = (self.candidates.clone(), self.path.clone());
        if guide.iter().any(|g| g.trust > 0.0) {
            let rings = Rings::new(footage.unit, 0.0);
            candidates.par_iter_mut().zip(&guide).enumerate().for_each(|(i, (list, g))| {
                let f = stretch.from + i;
                if g.trust > 0.0 && stretch.key_on(f).is_none() {
                    let there = judged(footage, &rings, &self.sought, f, g.at);
                    let settled = settled(footage, &rings, &self.sought, f, there, 6.0 * footage.unit);
                    merge(list, [there, settled].map(|c| c.with_motions(footage, f)));
                }
            });
            let spent;
            (path, spent) = stretch.path(footage, params, &self.sought, &mut candidates, &guide, stage)?;
            let led = stretch.places(footage, &candidates, &path);
            let erring = self.erring(footage, params, &led, &spent);
            if erring.contains(&true) {
                guide.iter_mut().zip(erring).filter(|(_, erring)| *erring).for_each(|(g, _)| g.trust = 0.0);
                path = stretch.path(footage, params, &self.sought, &mut candidates, &guide, stage)?.0;
            }
        }
        let best = stretch.trajectory(footage, &candidates, &path);
        Ok(Solved { stretch, best, candidates, path, guide })
    }
}

impl Alone {
    /// For every frame whether the guide errs there: where the point has a smooth way without it, from which `led`, the
    /// cheapest way with it, departs at a high price.
    fn erring(&self, footage: &Footage, params: &PointParams, led: &[Place], spent: &[f32]) -> Vec<bool> {
        let own = self.stretch.places(footage, &self.candidates, &self.path);
        let apart = params.together * footage.unit;
        let parted: Vec<bool> = own.iter().zip(led).map(|(a, b)| a.at.distance(b.at) > apart).collect();
        let mut erring = vec![false; parted.len()];
        let mut from = 0;
        for run in parted.chunk_by(|a, b| a == b) {
            let to = from + run.len();
            // What a way costs where it comes back counts, too.
            let end = (to + 2).min(parted.len());
            let (own, led) = (&self.spent[from..end], &spent[from..end]);
            let (cost, dearest) = (own.iter().sum::<f32>(), own.iter().copied().fold(0.0, f32::max));
            let smooth = dearest < params.leap && cost < params.smooth * own.len() as f32;
            if run[0] && smooth && led.iter().sum::<f32>() - cost > params.dear {
                erring[from..to].fill(true);
            }
            from = to;
        }
        erring
    }
}

/// Adds candidates to those of a frame; of places that are one, the one that looks best is kept.
fn merge(list: &mut Vec<Candidate>, more: impl IntoIterator<Item = Candidate>) {
    list.extend(more);
    list.sort_by(|a, b| a.unlike.total_cmp(&b.unlike));
    list.dedup_by(|a, b| a.at.distance(b.at) < 0.5);
}

impl Stretch {
    /// Solves it from its keys alone.
    pub(super) fn alone(&self, footage: &Footage, params: &PointParams, stage: Stage<'_>) -> Result<Alone> {
        let rings = Rings::new(footage.unit, 0.0);
        let sought: Vec<Sought> = self.keys.iter().flatten().map(|k| Sought::new(footage, k.frame, k.at)).collect();
        let chains: Vec<Vec<Vec<Candidate>>> =
            sought.iter().map(|s| self.chains(footage, &rings, &sought, s, stage)).collect::<Result<_>>()?;
        let chains = chains.concat();
        let mut candidates: Vec<Vec<Candidate>> = (self.from..=self.to)
            .into_par_iter()
            .map(|f| {
                stage.at((f - self.from) as f64 / (self.to - self.from + 1) as f64)?;
                if let Some(s) = sought.iter().find(|s| s.frame == f) {
                    return Ok(vec![s.marked().with_motions(footage, f)]);
                }
                let mut found = over_the_frame(footage, &rings, &sought, f, params);
                merge(&mut found, chains.iter().map(|c| c[f - self.from]));
                Ok(found.into_iter().map(|c| c.with_motions(footage, f)).collect())
            })
            .collect::<Result<_>>()?;
        let (path, spent) = self.path(footage, params, &sought, &mut candidates, &[], stage)?;
        Ok(Alone { stretch: *self, sought, candidates, path, spent })
    }

    /// The cheapest path and what it costs in every frame; candidates near it are added before it is looked for again.
    fn path(
        &self,
        footage: &Footage,
        params: &PointParams,
        sought: &[Sought],
        candidates: &mut Vec<Vec<Candidate>>,
        guide: &[Guide],
        stage: Stage<'_>,
    ) -> Result<(Path, Vec<f32>)> {
        let rings = Rings::new(footage.unit, 0.0);
        let cheapest = |candidates: &[Vec<Candidate>]| {
            let graph = Graph::new(footage, self.from, candidates, self.held(), guide, params);
            let path = graph.best(&|_, _| 0.0, stage.part(1.0, 1.0))?;
            let spent = graph.spent(&path);
            Ok((path, spent))
        };
        let (mut path, mut spent) = cheapest(candidates)?;
        for _ in 1..params.rounds {
            let places = self.places(footage, candidates, &path);
            let more: Vec<Vec<Candidate>> = (self.from..=self.to)
                .into_par_iter()
                .map(|f| {
                    let mut list = candidates[f - self.from].clone();
                    if self.key_on(f).is_none() {
                        for p in self.near_the_path(footage, candidates, &path, &places, f) {
                            if list.iter().all(|k| k.at.distance(p) > 0.7) {
                                list.push(judged(footage, &rings, sought, f, p).with_motions(footage, f));
                            }
                        }
                        list.sort_by(|a, b| a.unlike.total_cmp(&b.unlike));
                    }
                    list
                })
                .collect();
            *candidates = more;
            (path, spent) = cheapest(candidates)?;
        }
        Ok((path, spent))
    }

    /// Moves a guide so that it goes through the keys: how far it errs changes from frame to frame as a bridge between
    /// them that forgets (the mean of an Ornstein-Uhlenbeck process, given its ends). The less is known of its error, the
    /// less it is trusted; `reach` halves that.
    fn bend(&self, guide: &mut [Guide], reach: f32) {
        let last = guide.len().saturating_sub(1);
        let ends = [0, last].map(|i| guide.get(i).map_or(Vec2::ZERO, |g| g.at));
        let misses = [0, 1].map(|end| self.keys[end].map(|k| k.at - ends[end]));
        let kept = |frames: usize| (-(frames as f32) / RECALL).exp();
        for (i, g) in guide.iter_mut().enumerate() {
            let mut unknown = 0.0;
            for (end, miss) in misses.into_iter().enumerate() {
                let Some(miss) = miss else { continue };
                let (near, far) = if end == 0 { (i, last - i) } else { (last - i, i) };
                let share = match misses[1 - end] {
                    None => kept(near),
                    Some(_) if last == 0 => 0.5,
                    Some(_) => kept(near) * (1.0 - kept(2 * far)) / (1.0 - kept(2 * last)),
                };
                g.at += share * miss;
                unknown += miss.length_squared() * (1.0 - share * share);
            }
            g.trust *= reach * reach / (reach * reach + unknown);
        }
    }

    /// The key on frame `f`.
    fn key_on(&self, f: usize) -> Option<Key> {
        self.keys.into_iter().flatten().find(|k| k.frame == f)
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn a_guide_is_bent_through_the_keys_and_trusted_less_between_them() {
        let flat = |n: usize| vec![Guide { at: vec2(50.0, 20.0), trust: 0.8 }; n];
        let key = |frame: usize, x: f32| Some(Key { frame, at: vec2(x, 20.0) });
        let between = Stretch { from: 10, to: 30, keys: [key(10, 50.0), key(30, 90.0)] };
        let mut guide = flat(21);
        between.bend(&mut guide, 30.0);
        assert!(guide[0].at.x == 50.0 && (guide[20].at.x - 90.0).abs() < 1e-3);
        assert!(guide.windows(2).all(|g| g[0].at.x <= g[1].at.x && g[0].at.y == 20.0));
        // What is far from the key is left as it was, and known badly.
        assert!(guide[5].at.x < 55.0 && guide[5].trust < 0.4 && guide[20].trust > 0.79);
        let open = Stretch { from: 30, to: 130, keys: [key(30, 90.0), None] };
        let mut guide = flat(101);
        open.bend(&mut guide, 30.0);
        assert!(guide[0].at.x == 90.0 && guide[100].at.distance(vec2(50.0, 20.0)) < 1e-3);
        // One that is right is left alone; so is a single frame, and none.
        let mut guide = flat(21);
        Stretch { from: 10, to: 30, keys: [key(10, 50.0), key(30, 50.0)] }.bend(&mut guide, 30.0);
        assert_eq!(guide, flat(21));
        let mut guide = flat(1);
        Stretch { from: 10, to: 10, keys: [key(10, 50.0), key(10, 50.0)] }.bend(&mut guide, 30.0);
        assert_eq!(guide, flat(1));
        between.bend(&mut [], 30.0);
    }
}
