//! Anderson acceleration of a fixed-point iteration that lowers an energy.
//!
//! Peng et al. 2018, "Anderson Acceleration for Geometry Optimization and Physics Simulation": the next shape is the
//! combination of the last ones whose residuals cancel best. The caller compares energies and forgets the history
//! when a combination was worse than the plain step.

use glam::Vec2;

/// How many steps are combined. 5 measured best of 2 to 8 for ten steps.
const WINDOW: usize = 5;

/// The last steps.
#[derive(Clone, Debug)]
pub(super) struct Anderson {
    /// Differences of successive residuals, and of successive plain steps.
    residuals: Vec<Vec<Vec2>>,
    steps: Vec<Vec<Vec2>>,
    /// Inner products of the residuals' differences.
    products: [[f64; WINDOW]; WINDOW],
    last_residual: Vec<Vec2>,
    last_step: Vec<Vec2>,
    /// How many differences there are, and where the next goes; `None` before the first step.
    held: Option<usize>,
    next: usize,
}

impl Anderson {
    /// Room for shapes of `n` vertices.
    pub(super) fn new(n: usize) -> Self {
        Self {
            residuals: vec![vec![Vec2::ZERO; n]; WINDOW],
            steps: vec![vec![Vec2::ZERO; n]; WINDOW],
            products: [[0.0; WINDOW]; WINDOW],
            last_residual: vec![Vec2::ZERO; n],
            last_step: vec![Vec2::ZERO; n],
            held: None,
            next: 0,
        }
    }

    /// Begins anew.
    pub(super) fn forget(&mut self) {
        self.held = None;
        self.next = 0;
    }

    /// The last plain step.
    pub(super) fn plain(&self) -> &[Vec2] {
        &self.last_step
    }

    /// From the shape `u` and its `residual`, the plain step minus the shape, makes `u` the next shape to try.
    pub(super) fn advance(&mut self, u: &mut [Vec2], residual: &[Vec2]) {
        let Some(held) = self.held else {
            self.held = Some(0);
            self.last_residual.copy_from_slice(residual);
            add(u, residual);
            self.last_step.copy_from_slice(u);
            return;
        };
        let held = (held + 1).min(WINDOW);
        self.held = Some(held);
        let slot = self.next;
        self.next = (slot + 1) % WINDOW;
        difference(&mut self.residuals[slot], residual, &mut self.last_residual);
        add(u, residual);
        difference(&mut self.steps[slot], u, &mut self.last_step);
        let mut right = [0.0; WINDOW];
        for k in 0..held {
            let product = dot(&self.residuals[slot], &self.residuals[k]);
            (self.products[slot][k], self.products[k][slot]) = (product, product);
            right[k] = dot(&self.residuals[k], residual);
        }
        let weights = least_squares(&self.products, &right, held);
        for k in 0..held {
            let w = weights[k] as f32;
            u.iter_mut().zip(&self.steps[k]).for_each(|(u, s)| *u -= w * *s);
        }
    }
}

fn add(u: &mut [Vec2], v: &[Vec2]) {
    u.iter_mut().zip(v).for_each(|(u, v)| *u += *v);
}

/// `out = new - last`, and `last = new`.
fn difference(out: &mut [Vec2], new: &[Vec2], last: &mut [Vec2]) {
    for ((out, new), last) in out.iter_mut().zip(new).zip(last) {
        *out = *new - *last;
        *last = *new;
    }
}

/// A sum in chains that do not depend on the machine; 32 bits hold a short chain well enough.
fn dot(a: &[Vec2], b: &[Vec2]) -> f64 {
    const LANES: usize = 4;
    let mut total = 0.0;
    for (a, b) in a.chunks(512).zip(b.chunks(512)) {
        let mut sums = [Vec2::ZERO; LANES];
        let ((left, left_rest), (right, right_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
        for (a, b) in left.iter().zip(right) {
            for l in 0..LANES {
                sums[l] += a[l] * b[l];
            }
        }
        let rest: Vec2 = left_rest.iter().zip(right_rest).map(|(a, b)| *a * *b).sum();
        let sum = sums.iter().sum::<Vec2>() + rest;
        total += f64::from(sum.x + sum.y);
    }
    total
}

/// Weights of the normal equations; nearly dependent steps get little.
fn least_squares(products: &[[f64; WINDOW]; WINDOW], right: &[f64; WINDOW], n: usize) -> [f64; WINDOW] {
    let mut a = *products;
    let mut x = *right;
    let trace: f64 = (0..n).map(|i| a[i][i]).sum();
    for (i, row) in a.iter_mut().enumerate().take(n) {
        row[i] += 1e-8 * trace + f64::MIN_POSITIVE;
    }
    for i in 0..n {
        for j in i + 1..n {
            let f = a[j][i] / a[i][i];
            for k in i..n {
                a[j][k] -= f * a[i][k];
            }
            x[j] -= f * x[i];
        }
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            x[i] -= a[i][k] * x[k];
        }
        x[i] /= a[i][i];
    }
    x
}
