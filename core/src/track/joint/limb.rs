//! One chain of bones in one frame: what a pose costs there, and where good ones are.

use glam::Vec2;

use super::params::JointParams;
use super::parts::{Claims, Look, Part};
use super::pose_path::Candidate;
use super::scene::Scene;
use super::tree::Chain;

/// Steps of a bone's direction in the search, and the lengths tried, as shares of its own.
const TURNS: usize = 60;
const LENGTHS: [f32; 3] = [0.86, 1.0, 1.16];
/// Steps of the descent: degrees, and the share of the length that goes with them.
const DESCENT: [(f32, f32); 3] = [(4.0, 0.05), (2.0, 0.025), (1.0, 0.012)];
/// Poses as near as this everywhere (working pixels) are one.
pub(super) const SAME: f32 = 2.0;
/// Search of a chain that nothing holds: how far, as a share of the picture's long side, and the turns tried.
const WINDOW: f32 = 0.1;
const FREE_TURNS: [f32; 7] = [-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0];

/// A chain with what it needs to be judged.
pub(super) struct Limb<'a> {
    pub(super) chain: &'a Chain,
    pub(super) parts: &'a [Part],
    /// For every bone: whether the part's first joint is the chain's later one.
    pub(super) reversed: Vec<bool>,
    /// For every bone where it was marked, from the chain's earlier joint to its later one.
    pub(super) rest: Vec<Vec2>,
    pub(super) weights: Vec<f32>,
    pub(super) params: &'a JointParams,
    pub(super) scene: &'a Scene,
    /// The limb's bit among the claims.
    pub(super) bit: u64,
    /// For every joint of the chain and every frame where the user marked it (working pixels).
    pub(super) pins: Vec<Vec<Option<Vec2>>>,
    /// For every frame: where its first joint is, and where its first bone would point if it turned with the others.
    pub(super) roots: Vec<Option<Vec2>>,
    pub(super) attached: Vec<Option<Vec2>>,
}

impl<'a> Limb<'a> {
    fn look(&self, frame: usize, level: usize, claims: Option<&'a Claims>) -> Option<Look<'a>> {
        let views = if level == 0 { &self.scene.fine } else { &self.scene.coarse };
        let claims = claims.map(|c| (c, self.bit));
        Some(Look { view: views[frame].as_ref()?, level, claims, params: self.params })
    }

    fn part(&self, k: usize) -> &Part {
        &self.parts[self.chain.bones[k]]
    }

    /// What one bone costs.
    fn bone_cost(&self, look: &Look<'_>, frame: usize, k: usize, a: Vec2, b: Vec2) -> f32 {
        let p = self.params;
        let (from, to) = if self.reversed[k] { (b, a) } else { (a, b) };
        let mut cost = self.part(k).cost(look, from, to);
        let length = self.rest[k].length();
        if length > 3.0 {
            let grown = ((b - a).length().max(0.5) / length).ln();
            cost += p.length * grown * grown / (grown * grown + p.length_reach * p.length_reach);
        }
        if k == 0
            && let Some(expected) = self.attached[frame]
        {
            let reach = p.attached_reach * length + 2.0;
            let miss = (b - a - expected).length_squared();
            cost += p.attached * miss / (miss + reach * reach);
        }
        cost * self.weights[k]
    }

    /// What a whole pose costs.
    pub(super) fn cost(&self, look: &Look<'_>, frame: usize, pose: &[Vec2]) -> f32 {
        (0..self.rest.len()).map(|k| self.bone_cost(look, frame, k, pose[k], pose[k + 1])).sum()
    }

    /// The pose with what it costs; one that has to be there costs nothing.
    pub(super) fn judged(&self, frame: usize, claims: Option<&'a Claims>, pose: Vec<Vec2>) -> Candidate {
        let cost = self.look(frame, 0, claims).map_or(0.0, |look| self.cost(&look, frame, &pose));
        Candidate { pose, cost }
    }

    /// Moves the pose to where its first joint is, and every marked joint to its mark; what follows goes along.
    pub(super) fn pinned(&self, frame: usize, mut pose: Vec<Vec2>) -> Vec<Vec2> {
        for k in 0..pose.len() {
            let held = if k == 0 { self.roots[frame].or(self.pins[0][frame]) } else { self.pins[k][frame] };
            if let Some(place) = held {
                let by = place - pose[k];
                pose[k..].iter_mut().for_each(|p| *p += by);
            }
        }
        pose
    }

    /// Poses of a limb that hangs on a solved joint: the best of all directions.
    pub(super) fn search(&self, frame: usize, claims: Option<&'a Claims>) -> Vec<Vec<Vec2>> {
        let (Some(look), Some(root)) = (self.look(frame, 1, claims), self.roots[frame]) else { return Vec::new() };
        let mut beam = vec![Candidate { pose: vec![root], cost: 0.0 }];
        for k in 0..self.rest.len() {
            let mut grown = Vec::new();
            for partial in &beam {
                let from = partial.pose[k];
                let mut push = |to: Vec2| {
                    let cost = partial.cost + self.bone_cost(&look, frame, k, from, to);
                    grown.push((cost, from, to, partial));
                };
                if let Some(pin) = self.pins[k + 1][frame] {
                    push(pin);
                    continue;
                }
                for turn in 0..TURNS {
                    let turned =
                        Vec2::from_angle(turn as f32 * std::f32::consts::TAU / TURNS as f32).rotate(self.rest[k]);
                    LENGTHS.iter().for_each(|l| push(from + turned * *l));
                }
                if k == 0
                    && let Some(expected) = self.attached[frame]
                {
                    for degrees in [-9.0f32, -3.0, 0.0, 3.0, 9.0] {
                        push(from + Vec2::from_angle(degrees.to_radians()).rotate(expected));
                    }
                }
            }
            grown.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut kept: Vec<Candidate> = Vec::with_capacity(self.params.beam);
            let count = if k + 1 == self.rest.len() { self.params.found } else { self.params.beam };
            for (cost, _, to, partial) in grown {
                let pose: Vec<Vec2> = partial.pose.iter().copied().chain([to]).collect();
                if !kept.iter().any(|c| same(&c.pose, &pose, 2.0 * SAME)) {
                    kept.push(Candidate { pose, cost });
                    if kept.len() == count {
                        break;
                    }
                }
            }
            beam = kept;
        }
        beam.into_iter().map(|c| c.pose).collect()
    }

    /// Poses of a chain that nothing holds, near `from`: its best places and turns.
    pub(super) fn search_free(&self, frame: usize, from: &[Vec2]) -> Vec<Vec<Vec2>> {
        let Some(look) = self.look(frame, 1, None) else { return Vec::new() };
        let reach = (WINDOW * look.view.width.max(look.view.height) as f32) as isize;
        let mut found = Vec::new();
        for y in -reach..=reach {
            for x in -reach..=reach {
                let by = Vec2::new(x as f32, y as f32) * 2.0;
                for degrees in FREE_TURNS {
                    let turn = Vec2::from_angle(degrees.to_radians());
                    let pose: Vec<Vec2> = from.iter().map(|p| from[0] + by + turn.rotate(*p - from[0])).collect();
                    let far = 1e-6 * by.length_squared();
                    found.push((self.cost(&look, frame, &pose) + far, pose));
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut kept: Vec<Vec<Vec2>> = Vec::new();
        for (_, pose) in found {
            if !kept.iter().any(|p| same(p, &pose, 4.0 * SAME)) {
                kept.push(self.pinned(frame, pose));
                if kept.len() == 8 {
                    break;
                }
            }
        }
        kept
    }

    /// The pose nearby that costs least: coordinate descent over directions, lengths and, where nothing holds it, place.
    pub(super) fn settled(&self, frame: usize, claims: Option<&'a Claims>, pose: &[Vec2]) -> Vec<Vec2> {
        let Some(look) = self.look(frame, 0, claims) else { return pose.to_vec() };
        let mut descent = Descent::new(self, look, frame, self.pinned(frame, pose.to_vec()));
        for (degrees, share) in DESCENT {
            let turn = Vec2::from_angle(degrees.to_radians());
            let back = Vec2::new(turn.x, -turn.y);
            for k in 0..self.rest.len() {
                for factor in [turn, back, Vec2::X * (1.0 + share), Vec2::X * (1.0 - share)] {
                    for _ in 0..4 {
                        let bone = descent.pose[k + 1] - descent.pose[k];
                        if !descent.shifted(k + 1, factor.rotate(bone) - bone) {
                            break;
                        }
                    }
                }
            }
            if self.chain.free {
                for by in [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y] {
                    for _ in 0..4 {
                        if !descent.shifted(0, by * (0.5 * degrees)) {
                            break;
                        }
                    }
                }
            }
        }
        descent.pose
    }
}

/// A pose on its way down, with what each of its bones costs.
struct Descent<'a, 'l> {
    limb: &'l Limb<'a>,
    look: Look<'l>,
    frame: usize,
    pose: Vec<Vec2>,
    costs: Vec<f32>,
    tried: Vec<Vec2>,
    tried_costs: Vec<f32>,
}

impl<'a, 'l> Descent<'a, 'l> {
    fn new(limb: &'l Limb<'a>, look: Look<'l>, frame: usize, pose: Vec<Vec2>) -> Self {
        let costs: Vec<f32> =
            (0..limb.rest.len()).map(|k| limb.bone_cost(&look, frame, k, pose[k], pose[k + 1])).collect();
        Self { tried: pose.clone(), tried_costs: costs.clone(), limb, look, frame, pose, costs }
    }

    /// Tries the pose with its joints from `first` on moved, but for marked ones; says whether it is better, and then
    /// keeps it.
    fn shifted(&mut self, first: usize, by: Vec2) -> bool {
        let Self { limb, look, frame, pose, costs, tried, tried_costs } = self;
        let mut by = by;
        let changed = first.saturating_sub(1)..costs.len();
        for k in first..pose.len() {
            if limb.pins[k][*frame].is_some() {
                by = Vec2::ZERO;
            }
            tried[k] = pose[k] + by;
        }
        let was: f32 = costs[changed.clone()].iter().sum();
        let mut now = 0.0;
        for k in changed.clone() {
            tried_costs[k] = limb.bone_cost(look, *frame, k, tried[k], tried[k + 1]);
            now += tried_costs[k];
            if now >= was {
                break;
            }
        }
        let better = now < was - 1e-5;
        if better {
            pose[first..].copy_from_slice(&tried[first..]);
            costs[changed.clone()].copy_from_slice(&tried_costs[changed]);
        } else {
            tried[first..].copy_from_slice(&pose[first..]);
        }
        better
    }
}

/// Whether two poses are one.
pub(super) fn same(a: &[Vec2], b: &[Vec2], near: f32) -> bool {
    a.iter().zip(b).all(|(a, b)| a.distance_squared(*b) <= near * near)
}

/// Drops poses that others are the same as.
pub(super) fn distinct(poses: &mut Vec<Vec<Vec2>>, near: f32) {
    let mut kept: Vec<Vec<Vec2>> = Vec::with_capacity(poses.len());
    for pose in poses.drain(..) {
        if !kept.iter().any(|p| same(p, &pose, near)) {
            kept.push(pose);
        }
    }
    *poses = kept;
}
