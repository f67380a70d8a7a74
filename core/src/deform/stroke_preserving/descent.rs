//! The way down to the least energy: Newton's method, whose steps turn.
//!
//! A step of Newton's method moves what should turn along a tangent, which stretches it; the stiffer a line, the shorter
//! such steps must be. So a step is taken for what it says of turns and stretches alone, and the shape is put together
//! anew from those (after Huang et al. 2011, "rotation-strain coordinates"), with a factor that serves every shape. Of the
//! negative curvature as much is kept as leaves the matrix definite, and steps go on where the energy still falls.
//!
//! Known limits: the energy has several low shapes when handles push hard, and which is found depends on the start. A start
//! that is exactly between two of them leaves it slowly.

use glam::DVec2;

use super::terms::{Curves, Pins, Terms};
use crate::deform::sparse::{Fronts, Matrix};
use crate::error::Result;
use crate::job::Stage;

/// How far a solve goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Newton's steps at most.
    pub steps: usize,
    /// Done when a step lowers the energy by less than this share of it, or to within it of what was promised.
    pub tolerance: f64,
}

impl Default for Effort {
    /// What a step promises and misses bounds what is left; below this nothing visible is.
    fn default() -> Self {
        Self { steps: 10, tolerance: 1e-3 }
    }
}

/// How a solve went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settled {
    /// The energy at the start of Newton's steps, and after each.
    pub energies: Vec<f64>,
    /// How often a matrix was factored.
    pub factors: usize,
}

impl Settled {
    /// Newton's steps that were taken.
    pub fn iterations(&self) -> usize {
        self.energies.len().saturating_sub(1)
    }
}

/// What is solved for.
pub(super) struct System<'a> {
    pub(super) terms: &'a Terms,
    pub(super) fronts: &'a Fronts,
    pub(super) rigidity: &'a [f64],
    pub(super) pins: &'a Pins,
    pub(super) targets: &'a [DVec2],
}

impl System<'_> {
    fn energy(&self, u: &[DVec2]) -> f64 {
        self.terms.energy(u, self.rigidity, self.pins, self.targets)
    }

    fn slopes(&self, u: &[DVec2], turns: f64, slopes: &mut [DVec2]) -> f64 {
        self.terms.slopes(u, self.rigidity, self.pins, self.targets, turns, slopes)
    }

    /// How far a handle is from its target at most.
    fn gap(&self, u: &[DVec2]) -> f64 {
        self.targets.iter().enumerate().map(|(k, t)| self.pins.at(k, u).distance(*t)).fold(0.0, f64::max)
    }
}

/// Each vertex is held so stiffly where it is: what has no other hold does not turn.
const KEEP: f64 = 1e-6;
/// Handles that are farther than so many edges from their targets ask for a start from afar, ...
const FAR: f64 = 2.0;
/// ... in which triangles may take any size; a little they mind.
const SIMILAR: f64 = 1e-3;
/// Handles less than this from their targets are there, and below this energy nothing is bent: rounding of shapes, in
/// edges.
const THERE: f64 = 1e-9;
const UNBENT: f64 = 1e-7;
/// How often a step is halved that does not go down by this share of what its slope promises.
const HALVINGS: usize = 20;
const ENOUGH: f64 = 1e-4;
/// A step is made up to so many times as long where that is lower still, if it is by more than this.
const FARTHEST: f64 = 3.0;
const WORTH: f64 = 1.2;
/// The most of the negative curvature that is tried, below 1 so that a soft direction does not make a step endless; and
/// the least before it is left out.
const NEGATIVE: f64 = 0.9;
const LITTLE: f64 = 0.1;
/// What a step misses says what is left only where it lowers the energy by less than this share.
const SMALL: f64 = 0.1;
/// A factor for turned shapes serves while no rigidity is more than so many times another.
const SERVES: f64 = 4.0;
/// Rigidities that change by more than so many times between two solves ask for a start from afar.
const JUMP: f64 = 2.0;

/// Room for the numbers, and factors that serve any shape.
#[derive(Debug)]
pub(super) struct Descent {
    pub(super) effort: Effort,
    pub(super) settled: Settled,
    /// What is the same for any shape.
    base: Option<Matrix<f64>>,
    /// The factor of a step in which triangles may take any size.
    similar: Option<Matrix<f64>>,
    /// The factor of a step in which everything is turned already, and the rigidities that it was made for.
    turned: Option<(Matrix<f64>, Vec<f64>)>,
    /// The rigidities of the last solve.
    last: Vec<f64>,
    matrix: Matrix<f64>,
    slopes: Vec<DVec2>,
    step: Vec<DVec2>,
    trial: Vec<DVec2>,
    pulls: Vec<DVec2>,
}

impl Descent {
    pub(super) fn new(fronts: &Fronts, n: usize) -> Self {
        let room = || vec![DVec2::ZERO; n];
        Self {
            effort: Effort::default(),
            settled: Settled::default(),
            base: None,
            similar: None,
            turned: None,
            last: Vec::new(),
            matrix: fronts.matrix(),
            slopes: room(),
            step: room(),
            trial: room(),
            pulls: room(),
        }
    }

    /// Rigidities have changed.
    pub(super) fn forget(&mut self) {
        (self.base, self.similar) = (None, None);
    }

    /// Factors the matrix at the shape `u`; whether it is definite.
    fn factor(&mut self, system: &System<'_>, u: &[DVec2], how: Curves) -> bool {
        let base = self.base.get_or_insert_with(|| {
            let mut base = system.fronts.matrix();
            system.terms.base(system.rigidity, system.pins, KEEP, &mut base);
            base
        });
        self.settled.factors += 1;
        self.matrix.copy_from(base);
        system.terms.curves(u, system.rigidity, how, &mut self.matrix);
        system.fronts.factor(&mut self.matrix)
    }

    /// Makes the factor for turned shapes where there is none that serves.
    fn turn(&mut self, system: &System<'_>, u: &[DVec2]) {
        if !self.turned.as_ref().is_some_and(|(_, kept)| alike(kept, system.rigidity, SERVES)) {
            self.factor(system, u, Curves::Turned(1.0));
            self.turned = Some((self.matrix.clone(), system.rigidity.to_vec()));
        }
    }

    /// A start from the shape `u`: where handles went far, or rigidities jumped, the lowest of several. Whether it is near.
    fn start(&mut self, system: &System<'_>, u: &mut [DVec2], stage: Stage<'_>) -> Result<bool> {
        let gap = system.gap(u);
        let jumped = !self.last.is_empty() && !alike(&self.last, system.rigidity, JUMP);
        self.last.clear();
        self.last.extend_from_slice(system.rigidity);
        self.turn(system, u);
        if gap <= THERE && (!jumped || system.energy(u) < UNBENT) {
            return Ok(true);
        }
        stage.at(0.1)?;
        // Handles must come to their targets at once, which an old factor does not do.
        if self.turned.as_ref().is_some_and(|(_, kept)| kept != system.rigidity) {
            self.turned = None;
            self.turn(system, u);
        }
        let mut low = if gap <= THERE { system.energy(u) } else { f64::INFINITY };
        let mut starts = vec![u.to_vec()];
        if gap > FAR || jumped {
            if self.similar.is_none() {
                self.factor(system, u, Curves::Turned(SIMILAR));
                self.similar = Some(self.matrix.clone());
            }
            let mut any = u.to_vec();
            if let Some(factor) = &mut self.similar {
                system.slopes(&any, SIMILAR, &mut self.slopes);
                go(system.fronts, factor, &mut self.slopes, &mut any);
            }
            starts.push(any);
        }
        for mut start in starts {
            if let Some((factor, _)) = &mut self.turned {
                system.slopes(&start, 1.0, &mut self.slopes);
                go(system.fronts, factor, &mut self.slopes, &mut start);
            }
            let energy = system.energy(&start);
            if energy < low {
                low = energy;
                u.copy_from_slice(&start);
            }
        }
        Ok(gap <= FAR && !jumped)
    }

    /// Goes down from `u`.
    pub(super) fn run(&mut self, system: &System<'_>, u: &mut [DVec2], stage: Stage<'_>) -> Result<()> {
        self.settled = Settled::default();
        let near = self.start(system, u, stage)?;
        let mut energy = system.slopes(u, 1.0, &mut self.slopes);
        self.settled.energies.push(energy);
        let mut share = if near { NEGATIVE } else { 0.0 };
        for k in 0..self.effort.steps {
            if energy < UNBENT {
                break;
            }
            stage.at(0.2 + 0.8 * k as f64 / self.effort.steps as f64)?;
            self.turn(system, u);
            while !self.factor(system, u, Curves::Newton(share)) {
                if share == 0.0 {
                    // What is left has no digits.
                    return Ok(());
                }
                share = if share > LITTLE { 0.5 * share } else { 0.0 };
                stage.at(0.0)?;
            }
            // Newton's own matrix, nearly, knows what is left.
            let own = share == NEGATIVE;
            share = if k == 0 { NEGATIVE } else { (2.0 * share).clamp(LITTLE, NEGATIVE) };
            self.step.iter_mut().zip(&self.slopes).for_each(|(s, g)| *s = -*g);
            system.fronts.solve(&mut self.matrix, &mut self.step);
            let downhill = 2.0 * self.step.iter().zip(&self.slopes).map(|(s, g)| s.dot(*g)).sum::<f64>();
            let (length, lower) = self.search(system, u, energy, downhill);
            if lower.is_nan() || lower >= energy {
                break;
            }
            u.copy_from_slice(&self.trial);
            let drop = energy - lower;
            energy = system.slopes(u, 1.0, &mut self.slopes);
            self.settled.energies.push(energy);
            let missed = (drop + 0.5 * downhill).abs();
            let foreseen = own && length == 1.0 && drop < SMALL * energy;
            let left = if foreseen { drop.min(missed) } else { drop };
            if left < self.effort.tolerance * energy {
                break;
            }
        }
        Ok(())
    }

    /// How much of the step to go, and the energy there; `trial` is there.
    fn search(&mut self, system: &System<'_>, u: &[DVec2], energy: f64, downhill: f64) -> (f64, f64) {
        let mut length = 1.0;
        let mut lower = self.swing(system, u, length);
        for _ in 0..HALVINGS {
            if lower <= energy + ENOUGH * length * downhill {
                break;
            }
            length *= 0.5;
            lower = self.swing(system, u, length);
        }
        // Where the matrix overrates the curvature, the parabola through what was found goes on.
        let rise = lower - energy - downhill;
        let farther = if rise > 0.0 { (-0.5 * downhill / rise).min(FARTHEST) } else { FARTHEST };
        if length == 1.0 && farther > WORTH {
            let there = self.swing(system, u, farther);
            if there < lower {
                return (farther, there);
            }
            self.swing(system, u, length);
        }
        (length, lower)
    }

    /// Sets `trial` to the shape that is turned and stretched as the step times `length` says, and gives its energy.
    fn swing(&mut self, system: &System<'_>, u: &[DVec2], length: f64) -> f64 {
        self.trial.iter_mut().zip(&self.step).for_each(|(t, s)| *t = *s * length);
        system.terms.swings(u, &self.trial, system.rigidity, &mut self.pulls);
        if let Some((factor, _)) = &mut self.turned {
            system.fronts.solve(factor, &mut self.pulls);
        }
        self.trial.iter_mut().zip(u.iter().zip(&self.pulls)).for_each(|(t, (u, p))| *t += *u + *p);
        system.energy(&self.trial)
    }
}

/// Whether no number is more than so many times the other.
fn alike(a: &[f64], b: &[f64], times: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| *a <= times * b && *b <= times * a)
}

/// Takes one step with a factor.
fn go(fronts: &Fronts, factor: &mut Matrix<f64>, slopes: &mut [DVec2], u: &mut [DVec2]) {
    fronts.solve(factor, slopes);
    u.iter_mut().zip(slopes).for_each(|(u, s)| *u -= *s);
}
