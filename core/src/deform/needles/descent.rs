//! The way down to the least energy of one joint area.
//!
//! Gauss-Newton steps. What the Gauss-Newton matrix leaves out, mostly where edges are pushed together, is learnt from
//! the last steps (L-BFGS, Nocedal 1980, with that matrix as its start). Steps go downhill, and never so far that a
//! triangle turns that is sound. A frame of a drag starts with the matrix of an earlier one, turned along with the vertices,
//! as making one costs more than several steps.
//!
//! Known limits: where much is pushed together there are several low shapes, and which is found depends on the start.

use std::collections::VecDeque;

use glam::DVec2;

use super::blend::Placed;
use super::energy::{Terms, Wished};
use super::joint_areas::SettledArea;
use crate::deform::sparse::{Fronts, Matrix};
use crate::error::Result;
use crate::job::Stage;

/// Steps at most.
const STEPS: usize = 15;
/// Done when a step lowers the energy by less than this share, or moves nothing by this share of the mean edge.
const SETTLED: f64 = 1e-3;
const STILL: f64 = 2e-2;
/// In squared mean edges.
const UNBENT: f64 = 1e-7;
/// How much of the way to where a triangle vanishes a step may go.
const ROOM: f64 = 0.8;
/// How often a step is halved that does not go down by this share of what its slope promises.
const HALVINGS: usize = 11;
const ENOUGH: f64 = 1e-4;
/// A step is made up to so many times as long where that is lower still, if it is by more than this.
const FARTHEST: f64 = 2.0;
const WORTH: f64 = 1.2;
/// Steps to learn from.
const MEMORY: usize = 5;
/// Only whole steps teach that left at least this share of the energy, ...
const KNOWN: f64 = 0.7;
/// ... and saw at least this share of the curvature of the matrix.
const SOFT: f64 = 0.2;
/// After so many steps with an old matrix a new one is made, and so are those of the next frames.
const TIRED: usize = 4;
const REST: usize = 8;

/// What is solved for.
pub(super) struct System<'a> {
    pub(super) terms: &'a Terms,
    pub(super) wished: &'a Wished,
    pub(super) fronts: &'a Fronts,
    pub(super) free: usize,
}

impl System<'_> {
    pub(super) fn energy(&self, places: &[DVec2]) -> f64 {
        self.terms.energy(self.wished, places)
    }

    /// Below this energy an area only moved: rounding.
    pub(super) fn unbent(&self) -> f64 {
        UNBENT * self.wished.mean * self.wished.mean
    }
}

/// A step that was taken, and by how much it changed the slopes.
#[derive(Debug, Default)]
struct Taken {
    way: Vec<DVec2>,
    change: Vec<DVec2>,
    inverse: f64,
    /// A step that changed the slopes by less is not believed.
    least: f64,
}

/// Room for the numbers, and the factor of the matrix with the turns of the vertices for which it was made.
#[derive(Debug)]
pub(super) struct Descent {
    matrix: Matrix,
    turns: Vec<f64>,
    /// Frames that start with a new matrix before an old one is tried again.
    tired: usize,
    memory: VecDeque<Taken>,
    slopes: Vec<DVec2>,
    slopes_before: Vec<DVec2>,
    step: Vec<DVec2>,
    trial: Vec<DVec2>,
    spins: Vec<DVec2>,
}

impl Descent {
    pub(super) fn new(fronts: &Fronts, vertices: usize, free: usize) -> Self {
        Self {
            matrix: fronts.matrix(),
            turns: Vec::new(),
            tired: 0,
            memory: VecDeque::new(),
            slopes: vec![DVec2::ZERO; vertices],
            slopes_before: vec![DVec2::ZERO; free],
            step: vec![DVec2::ZERO; free],
            trial: Vec::new(),
            spins: Vec::new(),
        }
    }

    /// Goes down from `places`: with a new matrix in every step when `anew`, else with that of an earlier frame while it
    /// serves.
    pub(super) fn run(
        &mut self,
        system: &System<'_>,
        placed: &[Placed],
        anew: bool,
        places: &mut Vec<DVec2>,
        stage: Stage<'_>,
    ) -> Result<SettledArea> {
        let mean = system.wished.mean;
        let mut energy = system.energy(places);
        let mut settled = SettledArea { energies: vec![energy], ..SettledArea::default() };
        if energy < system.unbent() {
            return Ok(settled);
        }
        settled.flipped = system.terms.turned(places);
        let mut damping = 0.0f32;
        let mut factored = false;
        let mut fresh = anew || self.tired > 0 || self.turns.is_empty();
        let old = !fresh;
        self.memory.clear();
        self.trial.clone_from(places);
        if !fresh {
            self.spin(placed);
        }
        while settled.iterations < STEPS {
            stage.at(settled.iterations as f64 / STEPS as f64)?;
            settled.iterations += 1;
            fresh |= settled.iterations > TIRED;
            if anew || (fresh && !factored) {
                system.terms.curves(system.wished, places, &mut self.slopes, &mut self.matrix);
                system.terms.damp(&mut self.matrix, damping + 1e-6);
                self.turns.clear();
                if !system.fronts.factor(&mut self.matrix) {
                    damping = (10.0 * damping).max(1e-3);
                    continue;
                }
                damping = 0.0;
                factored = true;
                self.turns.extend(placed[..system.free].iter().map(|p| p.turn));
                self.spins.clear();
                self.spins.resize(system.free, DVec2::X);
            } else {
                system.terms.slopes(system.wished, places, &mut self.slopes);
            }
            self.learn();
            let downhill = self.direction(system);
            let (length, lower) = self.search(system, places, energy, downhill);
            if lower.is_nan() || lower >= energy {
                if fresh {
                    break;
                }
                fresh = true;
                continue;
            }
            if length >= 1.0 && lower > KNOWN * energy {
                let way = self.step.iter().map(|s| *s * length).collect();
                let least = -0.5 * SOFT * downhill * length * length;
                self.memory.push_back(Taken { way, least, ..Taken::default() });
            } else {
                self.memory.clear();
            }
            std::mem::swap(places, &mut self.trial);
            let drop = energy - lower;
            energy = lower;
            settled.energies.push(energy);
            settled.flipped = system.terms.turned(places);
            let longest = length * self.step.iter().map(|d| d.length_squared()).fold(0.0, f64::max).sqrt();
            if settled.flipped == 0 && (drop < SETTLED * energy || longest < STILL * mean) {
                break;
            }
        }
        self.tired = if old && fresh { REST } else { self.tired.saturating_sub(1) };
        Ok(settled)
    }

    /// How much of the step to go, and the energy there; `trial` is there.
    fn search(&mut self, system: &System<'_>, places: &[DVec2], energy: f64, downhill: f64) -> (f64, f64) {
        let Self { step, trial, .. } = self;
        let mut at = |length: f64| {
            trial.iter_mut().zip(places.iter().zip(&*step)).for_each(|(t, (p, s))| *t = *p + *s * length);
            system.energy(trial)
        };
        let room = ROOM * system.terms.room(places, step);
        let mut length = room.min(1.0);
        let mut lower = at(length);
        for _ in 0..HALVINGS {
            if lower <= energy + ENOUGH * length * downhill {
                break;
            }
            length *= 0.5;
            lower = at(length);
        }
        // Where the matrix overrates the curvature, the parabola through what was found goes on.
        let farther = (downhill / (2.0 * (energy + downhill - lower))).min(FARTHEST).min(room);
        if length == 1.0 && farther > WORTH {
            let there = at(farther);
            if there < lower {
                return (farther, there);
            }
            at(length);
        }
        (length, lower)
    }

    /// How the vertices have turned since the matrix was made.
    fn spin(&mut self, placed: &[Placed]) {
        self.spins.clear();
        self.spins.extend(self.turns.iter().zip(placed).map(|(old, now)| DVec2::from_angle(now.turn - old)));
    }

    /// Completes what the last step taught.
    fn learn(&mut self) {
        if let Some(last) = self.memory.back_mut().filter(|t| t.change.is_empty()) {
            last.change.extend(self.slopes.iter().zip(&self.slopes_before).map(|(now, old)| *now - *old));
            let along = dot(&last.way, &last.change);
            last.inverse = 1.0 / along;
            if !(along > last.least && last.inverse.is_finite()) {
                self.memory.pop_back();
            }
            if self.memory.len() > MEMORY {
                self.memory.pop_front();
            }
        }
        self.slopes_before.iter_mut().zip(&self.slopes).for_each(|(old, now)| *old = *now);
    }

    /// Sets the step; the energy's slope along it.
    fn direction(&mut self, system: &System<'_>) -> f64 {
        let Self { step, slopes, memory, spins, matrix, .. } = self;
        step.iter_mut().zip(&*slopes).for_each(|(d, g)| *d = -*g);
        let mut shares = [0.0; MEMORY];
        for (taken, share) in memory.iter().zip(&mut shares).rev() {
            *share = taken.inverse * dot(&taken.way, step);
            step.iter_mut().zip(&taken.change).for_each(|(d, y)| *d -= *y * *share);
        }
        step.iter_mut().zip(&*spins).for_each(|(d, s)| *d = DVec2::new(s.x, -s.y).rotate(*d));
        system.fronts.solve(matrix, step);
        step.iter_mut().zip(&*spins).for_each(|(d, s)| *d = s.rotate(*d));
        for (taken, share) in memory.iter().zip(&shares) {
            let back = share - taken.inverse * dot(&taken.change, step);
            step.iter_mut().zip(&taken.way).for_each(|(d, s)| *d += *s * back);
        }
        2.0 * dot(step, slopes)
    }
}

fn dot(a: &[DVec2], b: &[DVec2]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}
