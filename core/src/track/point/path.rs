//! The cheapest path of a point through the candidates of a stretch of frames (Buchanan and Fitzgibbon 2006; Live Sketch,
//! Su et al. 2018, equation 1), frames skipped where the point is hidden.
//!
//! First exactly over single candidates. Then, with inertia, over steps from candidate to candidate: exact over the steps
//! that the cheapest paths of the first pass go through.
//!
//! Known limit: inertia sees only those steps.

use glam::Vec2;
use rayon::prelude::*;

use super::candidates::Candidate;
use super::footage::Footage;
use super::guide::Guide;
use super::params::PointParams;
use crate::error::Result;
use crate::job::Stage;

/// Candidates of a frame that steps over skipped frames join.
const JOINED_FAR: usize = 12;
/// Other paths that are looked for, and how many times the cheapest's cost they may have (Live Sketch).
const ALTERNATIVES: usize = 4;
const MOST_DEAR: f32 = 4.0;
/// What going where a known path goes costs a frame, tried in turn.
const DEARER: [f32; 3] = [0.2, 0.6, 2.0];

/// A candidate with what steps from it need to know.
#[derive(Clone, Debug)]
struct Node {
    at: Vec2,
    ground: Vec2,
    angle: f32,
    own: f32,
    /// What leaving the guide costs.
    astray: f32,
    /// Where the flow takes it in the next and in the previous frame, and how far that is to be trusted.
    next: (Vec2, f32),
    last: (Vec2, f32),
}

/// A stretch of frames with candidates in each.
pub(super) struct Graph<'a> {
    params: &'a PointParams,
    unit: f32,
    nodes: Vec<Vec<Node>>,
    candidates: &'a [Vec<Candidate>],
    /// Whether the first and the last frame are marked, and so cannot be skipped.
    held: [bool; 2],
    /// For every frame the steps that end there.
    steps: Vec<Vec<Step>>,
}

/// A step between two candidates.
#[derive(Clone, Copy, Debug)]
struct Step {
    gap: u16,
    from: u16,
    to: u16,
    cost: f32,
}

/// A path: for every frame the candidate that it goes through, none where the point is hidden; and its cost.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Path {
    pub(super) nodes: Vec<Option<usize>>,
    pub(super) cost: f32,
}

/// Half where `x` is `reach`, near 1 far beyond.
#[inline]
fn bounded(square: f32, reach: f32) -> f32 {
    square / (square + reach * reach)
}

/// Half where the square of `reach` is `square`; flat near 0, because a guide is no exact place.
#[inline]
fn off_guide(square: f32, reach: f32) -> f32 {
    bounded(square * square, reach * reach)
}

impl<'a> Graph<'a> {
    /// Over the frames from `start` on.
    pub(super) fn new(
        footage: &Footage,
        start: usize,
        candidates: &'a [Vec<Candidate>],
        held: [bool; 2],
        guide: &[Guide],
        params: &'a PointParams,
    ) -> Self {
        let reach = params.guide_reach * footage.unit;
        let nodes = candidates
            .par_iter()
            .enumerate()
            .map(|(i, list)| {
                let f = start + i;
                let node = |c: &Candidate| {
                    let [next, last] = c.with_motions(footage, f).motions.unwrap_or([(c.at, 0.0); 2]);
                    Node {
                        at: c.at,
                        ground: footage.grounded(c.at, f),
                        angle: c.angle,
                        own: params.looks * bounded(c.unlike * c.unlike, params.looks_reach),
                        astray: guide
                            .get(i)
                            .map_or(0.0, |g| params.guide * g.trust * off_guide(g.at.distance_squared(c.at), reach)),
                        next,
                        last,
                    }
                };
                list.iter().map(node).collect()
            })
            .collect();
        let mut graph = Self { params, unit: footage.unit, nodes, candidates, held, steps: Vec::new() };
        graph.steps = (0..candidates.len()).into_par_iter().map(|t| graph.steps_to(t)).collect();
        graph
    }

    fn frames(&self) -> usize {
        self.nodes.len()
    }

    fn skipped(&self, frames: usize) -> f32 {
        if frames == 0 { 0.0 } else { self.params.hide + self.params.hidden * frames as f32 }
    }

    fn step_cost(&self, t: usize, gap: usize, from: usize, to: usize) -> f32 {
        let p = self.params;
        let (a, b) = (&self.nodes[t - gap][from], &self.nodes[t][to]);
        let unit = self.unit;
        let speed = a.ground.distance_squared(b.ground) / (gap * gap) as f32;
        let mut cost = p.velocity * bounded(speed, p.velocity_reach * unit) * gap as f32
            + p.turn * (a.angle - b.angle).abs() / gap as f32;
        if p.update > 0.0 {
            cost += p.update * self.candidates[t - gap][from].looks.unlike(&self.candidates[t][to].looks);
        }
        if gap == 1 {
            let reach = p.flow_reach * unit;
            cost += 0.5
                * p.flow
                * (a.next.1 * bounded(a.next.0.distance_squared(b.at), reach)
                    + b.last.1 * bounded(b.last.0.distance_squared(a.at), reach)
                    + p.lost * (2.0 - a.next.1 - b.last.1));
        } else {
            cost += self.skipped(gap - 1);
        }
        cost
    }

    /// All steps that end in frame `t`.
    fn steps_to(&self, t: usize) -> Vec<Step> {
        let mut steps = Vec::new();
        for gap in 1..=(self.params.skip + 1).min(t) {
            let most = if gap == 1 { usize::MAX } else { JOINED_FAR };
            for from in 0..self.nodes[t - gap].len().min(most) {
                for to in 0..self.nodes[t].len().min(most) {
                    let cost = self.step_cost(t, gap, from, to);
                    steps.push(Step { gap: gap as u16, from: from as u16, to: to as u16, cost });
                }
            }
        }
        steps
    }

    /// What it costs to begin in frame `t`, or to end there.
    fn beyond(&self, t: usize, end: usize) -> Option<f32> {
        let skipped = if end == 0 { t } else { self.frames() - 1 - t };
        if skipped == 0 {
            return Some(0.0);
        }
        (!self.held[end] && skipped <= self.params.skip).then(|| self.skipped(skipped))
    }

    /// What a path costs in every frame, its guide aside.
    pub(super) fn spent(&self, path: &Path) -> Vec<f32> {
        let reach = self.params.inertia_reach * self.unit;
        let mut out = vec![0.0; self.frames()];
        let mut last: Option<(usize, usize, Option<Vec2>)> = None;
        for (t, i) in path.nodes.iter().enumerate().filter_map(|(t, n)| Some((t, (*n)?))) {
            out[t] = self.nodes[t][i].own;
            let mut motion = None;
            match last {
                None => out[t] += self.beyond(t, 0).unwrap_or(0.0),
                Some((s, j, before)) => {
                    let gap = t - s;
                    let v = (self.nodes[t][i].ground - self.nodes[s][j].ground) / gap as f32;
                    let change = before.map_or(0.0, |u: Vec2| bounded(u.distance_squared(v), reach));
                    out[t] += self.step_cost(t, gap, j, i) + self.params.inertia * change;
                    motion = Some(v);
                }
            }
            last = Some((t, i, motion));
        }
        if let Some((t, _, _)) = last {
            out[t] += self.beyond(t, 1).unwrap_or(0.0);
        }
        out
    }

    /// The cheapest path. `dear` says what going through a candidate costs beside its looks.
    pub(super) fn best(&self, dear: &(impl Fn(usize, usize) -> f32 + Sync), stage: Stage<'_>) -> Result<Path> {
        let n = self.frames();
        let all = &self.steps;
        let own = |t: usize, i: usize| self.nodes[t][i].own + self.nodes[t][i].astray + dear(t, i);
        let mut reach: Vec<Vec<f32>> = self.nodes.iter().map(|l| vec![f32::INFINITY; l.len()]).collect();
        for t in 0..n {
            stage.at(0.0)?;
            if let Some(cost) = self.beyond(t, 0) {
                reach[t].fill(cost);
            }
            let (before, here) = reach.split_at_mut(t);
            for s in &all[t] {
                let cost = before[t - s.gap as usize][s.from as usize] + s.cost;
                let place = &mut here[0][s.to as usize];
                *place = place.min(cost);
            }
            for (i, r) in reach[t].iter_mut().enumerate() {
                *r += own(t, i);
            }
        }
        let mut rest: Vec<Vec<f32>> = self.nodes.iter().map(|l| vec![f32::INFINITY; l.len()]).collect();
        for t in (0..n).rev() {
            stage.at(0.2)?;
            if let Some(cost) = self.beyond(t, 1) {
                rest[t].iter_mut().for_each(|r| *r = r.min(cost));
            }
            let (before, here) = rest.split_at_mut(t);
            for s in &all[t] {
                let to = s.to as usize;
                let cost = here[0][to] + own(t, to) + s.cost;
                let place = &mut before[t - s.gap as usize][s.from as usize];
                *place = place.min(cost);
            }
        }
        let kept: Vec<Vec<Step>> = all
            .par_iter()
            .enumerate()
            .map(|(t, steps)| {
                stage.at(0.4)?;
                let through = |s: &Step| {
                    reach[t - s.gap as usize][s.from as usize] + s.cost + own(t, s.to as usize) + rest[t][s.to as usize]
                };
                let count = self.params.steps;
                let mut keyed: Vec<(f32, Step)> = steps.iter().map(|s| (through(s), *s)).collect();
                if keyed.len() > count {
                    keyed.select_nth_unstable_by(count, |a, b| {
                        a.0.total_cmp(&b.0).then((a.1.gap, a.1.from, a.1.to).cmp(&(b.1.gap, b.1.from, b.1.to)))
                    });
                    keyed.truncate(count);
                }
                let mut kept: Vec<Step> = keyed.into_iter().map(|k| k.1).collect();
                kept.sort_unstable_by_key(|s| (s.to, s.gap, s.from));
                Ok(kept)
            })
            .collect::<Result<_>>()?;
        self.with_inertia(&kept, &own, stage)
    }

    /// Other paths than `best` that share less than a quarter of their frames with each other and with it (Live Sketch
    /// after Chondrogiannis et al. 2015), cheapest first; none that costs [`MOST_DEAR`] times as much. Candidates near a
    /// path that is known are made dearer until the next path keeps away from them.
    pub(super) fn alternatives(&self, best: &Path, stage: Stage<'_>) -> Result<Vec<Path>> {
        let mut known = vec![best.clone()];
        while known.len() <= ALTERNATIVES {
            let near = |t: usize, i: usize| {
                let here = self.nodes[t][i].at;
                let on = |p: &&Path| p.nodes[t].is_some_and(|k| self.nodes[t][k].at.distance(here) < self.together());
                known.iter().filter(on).count() as f32
            };
            let mut parted = None;
            for dear in DEARER {
                let mut path = self.best(&|t, i| dear * near(t, i), stage)?;
                let through: Vec<f32> =
                    path.nodes.iter().enumerate().filter_map(|(t, n)| n.map(|n| near(t, n))).collect();
                path.cost -= dear * through.iter().sum::<f32>();
                let shared = through.iter().filter(|count| **count > 0.0).count();
                if 4 * shared <= self.frames() && path.cost <= MOST_DEAR * best.cost {
                    parted = Some(path);
                    break;
                }
            }
            let Some(path) = parted else { break };
            known.push(path);
        }
        Ok(known.split_off(1))
    }

    /// The cheapest path that keeps away from what is at `others` where it is known.
    pub(super) fn around(&self, others: &[Option<Vec2>], stage: Stage<'_>) -> Result<Path> {
        let dear = |t: usize, i: usize| {
            let near = others[t].is_some_and(|p| p.distance(self.nodes[t][i].at) < self.together());
            if near { DEARER[1] } else { 0.0 }
        };
        let mut path = self.best(&dear, stage)?;
        let through = path.nodes.iter().enumerate().filter_map(|(t, n)| n.map(|n| dear(t, n)));
        path.cost -= through.sum::<f32>();
        Ok(path)
    }

    /// Places nearer than this are one.
    fn together(&self) -> f32 {
        self.params.together * self.unit
    }

    /// The cheapest path over `steps`, changes of motion charged.
    fn with_inertia(&self, steps: &[Vec<Step>], own: &impl Fn(usize, usize) -> f32, stage: Stage<'_>) -> Result<Path> {
        let n = self.frames();
        let p = self.params;
        let motion = |t: usize, s: &Step| {
            let from = self.nodes[t - s.gap as usize][s.from as usize].ground;
            (self.nodes[t][s.to as usize].ground - from) / s.gap as f32
        };
        let motions: Vec<Vec<Vec2>> = (0..n).map(|t| steps[t].iter().map(|s| motion(t, s)).collect()).collect();
        // Where the steps to every candidate begin and end in the list of its frame, which is sorted by candidate.
        let spans: Vec<Vec<(u32, u32)>> = (0..n)
            .map(|t| {
                let mut spans = vec![(0, 0); self.nodes[t].len()];
                for (i, s) in steps[t].iter().enumerate() {
                    let span = &mut spans[s.to as usize];
                    if span.1 == 0 {
                        span.0 = i as u32;
                    }
                    span.1 = i as u32 + 1;
                }
                spans
            })
            .collect();
        let reach = p.inertia_reach * self.unit;
        const NONE: u32 = u32::MAX;
        let mut value: Vec<Vec<(f32, u32)>> = Vec::with_capacity(n);
        for t in 0..n {
            stage.at(0.5 + 0.5 * t as f64 / n as f64)?;
            let here: Vec<(f32, u32)> = steps[t]
                .iter()
                .zip(&motions[t])
                .map(|(s, v)| {
                    let (before, from) = (t - s.gap as usize, s.from as usize);
                    let mut best = (self.beyond(before, 0).map_or(f32::INFINITY, |c| c + own(before, from)), NONE);
                    let span = spans[before][from];
                    for e in span.0..span.1 {
                        let change = motions[before][e as usize].distance_squared(*v);
                        let cost = value[before][e as usize].0 + p.inertia * bounded(change, reach);
                        if cost < best.0 {
                            best = (cost, e);
                        }
                    }
                    (best.0 + s.cost + own(t, s.to as usize), best.1)
                })
                .collect();
            value.push(here);
        }
        let mut nodes = vec![None; n];
        let mut best = (f32::INFINITY, 0, NONE);
        for t in 0..n {
            let Some(end) = self.beyond(t, 1) else { continue };
            for (e, v) in value[t].iter().enumerate() {
                if v.0 + end < best.0 {
                    best = (v.0 + end, t, e as u32);
                }
            }
            // A path of one candidate.
            if let Some(start) = self.beyond(t, 0) {
                for i in 0..self.nodes[t].len() {
                    let cost = start + own(t, i) + end;
                    if cost < best.0 {
                        best = (cost, t, NONE);
                        nodes.fill(None);
                        nodes[t] = Some(i);
                    }
                }
            }
        }
        let (cost, mut t, mut e) = best;
        if e != NONE {
            nodes.fill(None);
        }
        while e != NONE {
            let s = steps[t][e as usize];
            nodes[t] = Some(s.to as usize);
            let link = value[t][e as usize].1;
            t -= s.gap as usize;
            nodes[t] = Some(s.from as usize);
            e = link;
        }
        Ok(Path { nodes, cost })
    }
}
