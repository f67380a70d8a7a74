//! A coarse answer to "which way does each part turn": one rotation for each cluster of triangles, everything else exact.
//!
//! Jacobson et al. 2012, "Fast Automatic Skinning Transformations", section 4: with one rotation for a whole cluster,
//! the best positions are linear in the rotations, so that the energy is a small quadratic of them. Left free to
//! scale as well, the rotations follow from one small linear system (the as-similar-as-possible start); held to unit
//! length, they are found by Newton steps on their angles. What a local and global solver needs hundreds of steps for,
//! turning whole limbs, is done here in a few small ones.

use glam::Vec2;

use super::elements::Elements;
use crate::deform::sparse::{Factor, Rows, Symbolic};

/// Newton steps at most; poses of the measured meshes take 3 to 9.
const STEPS: usize = 16;
/// Angles that change less are done, in radians.
const SETTLED: f64 = 1e-4;
/// How much a cluster that nothing holds prefers its rotation at rest, as a share of its area.
const PREFERENCE: f64 = 1e-5;

type Complex = [f64; 2];

/// The clusters of a bound mesh.
#[derive(Clone, Debug)]
pub(super) struct Clusters {
    /// Which cluster each triangle belongs to.
    of: Vec<u32>,
    count: usize,
    /// `B* L^-1 B`, row by row: what the clusters' rotations do to one another.
    gram: Vec<Complex>,
    /// Twice the area of each cluster.
    area: Vec<f64>,
    /// Lower Cholesky factor of area minus gram.
    similar: Vec<Complex>,
}

fn mul(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// `conj(a) b`.
fn conj_mul(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] + a[1] * b[1], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: Complex) -> Complex {
    let length = a[0].hypot(a[1]);
    if length > 0.0 { [a[0] / length, a[1] / length] } else { [1.0, 0.0] }
}

impl Clusters {
    /// Clusters of about `size` vertices. `triangles` are in the order of elimination, `held` says which vertices
    /// cannot move.
    pub(super) fn new(
        elements: &Elements,
        triangles: &[[u32; 3]],
        held: &[bool],
        symbolic: &Symbolic,
        factor: &Factor,
        size: usize,
    ) -> Option<Self> {
        let parts = symbolic.parts(size);
        let count = parts.len();
        // A triangle between parts goes with the part before it in the order.
        let of: Vec<u32> = triangles
            .iter()
            .map(|t| {
                let low = t.iter().copied().min().unwrap_or(0) as usize;
                parts.partition_point(|p| p.start <= low).saturating_sub(1) as u32
            })
            .collect();
        let mut area = vec![0.0; count];
        let mut rows = Rows::new(held.len(), triangles);
        for (t, (&cluster, triangle)) in of.iter().zip(triangles).enumerate() {
            let (double_area, q) = elements.rest_of(t);
            area[cluster as usize] += f64::from(double_area);
            for (&v, q) in triangle.iter().zip(q) {
                rows.add(v, cluster, if held[v as usize] { Vec2::ZERO } else { q });
            }
        }
        let gram = factor.gram(symbolic, count, &rows);
        let mut similar = gram.clone();
        for (i, value) in similar.iter_mut().enumerate() {
            let own = if i / count == i % count { area[i / count] * (1.0 + PREFERENCE) } else { 0.0 };
            *value = [own - value[0], -value[1]];
        }
        factor_hermitian(&mut similar, count)?;
        Some(Self { of, count, gram, area, similar })
    }

    /// How many clusters there are.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// Which cluster each triangle belongs to.
    pub(super) fn of(&self) -> &[u32] {
        &self.of
    }

    /// The best rotations, given the `turns` of all triangles in the shape that the handles make when nothing rotates.
    pub(super) fn rotations(&self, turns: &[Vec2]) -> Vec<Complex> {
        let n = self.count;
        let mut pull = vec![[0.0; 2]; n];
        for (t, &cluster) in self.of.iter().enumerate() {
            let c = &mut pull[cluster as usize];
            c[0] += f64::from(turns[t].x);
            c[1] += f64::from(turns[t].y);
        }
        let mut r = pull.clone();
        r.iter_mut().zip(&self.area).for_each(|(r, a)| r[0] += PREFERENCE * a);
        solve_hermitian(&self.similar, n, &mut r);
        r.iter_mut().for_each(|r| *r = unit(*r));
        let mut current = self.forces(&pull, &r);
        for _ in 0..STEPS {
            let Some(step) = self.newton(&r, &current.0) else { break };
            let longest = step.iter().fold(0f64, |m, s| m.max(s.abs()));
            // A quarter turn is as far as a quadratic model of angles can be trusted.
            let mut scale = (std::f64::consts::FRAC_PI_4 / longest.max(1e-300)).min(1.0);
            let mut better = None;
            for _ in 0..4 {
                let next: Vec<Complex> =
                    r.iter().zip(&step).map(|(r, s)| mul(*r, [(scale * s).cos(), (scale * s).sin()])).collect();
                let forces = self.forces(&pull, &next);
                if forces.1 < current.1 {
                    better = Some((next, forces));
                    break;
                }
                scale *= 0.25;
            }
            let Some((next, forces)) = better else { break };
            (r, current) = (next, forces);
            if longest * scale < SETTLED {
                break;
            }
        }
        r
    }

    /// `M r + c`, and the energy but for what does not depend on `r`.
    fn forces(&self, pull: &[Complex], r: &[Complex]) -> (Vec<Complex>, f64) {
        let n = self.count;
        let mut energy = 0.0;
        let forces = (0..n).map(|j| {
            let mut sum = [0.0; 2];
            for (m, r) in self.gram[j * n..(j + 1) * n].iter().zip(r) {
                sum[0] += m[0] * r[0] - m[1] * r[1];
                sum[1] += m[0] * r[1] + m[1] * r[0];
            }
            let own = [sum[0] + pull[j][0], sum[1] + pull[j][1]];
            energy -= conj_mul(r[j], [own[0] + pull[j][0], own[1] + pull[j][1]])[0];
            own
        });
        (forces.collect(), energy)
    }

    /// The step of the angles, with as much damping as makes it go down.
    fn newton(&self, r: &[Complex], forces: &[Complex]) -> Option<Vec<f64>> {
        let n = self.count;
        let along: Vec<Complex> = r.iter().zip(forces).map(|(r, s)| conj_mul(*r, *s)).collect();
        let mut damping = 0.0;
        for _ in 0..8 {
            let mut hessian = vec![0.0; n * n];
            for j in 0..n {
                for k in 0..=j {
                    hessian[j * n + k] = -conj_mul(r[j], mul(self.gram[j * n + k], r[k]))[0];
                }
                hessian[j * n + j] += along[j][0] + damping * self.area[j] + 1e-9 * self.area[j];
            }
            let mut step: Vec<f64> = along.iter().map(|a| a[1]).collect();
            if solve_dense(&mut hessian, n, &mut step).is_some() {
                return Some(step);
            }
            damping = if damping == 0.0 { 0.1 } else { 4.0 * damping };
        }
        None
    }
}

/// Cholesky of a full Hermitian matrix, in its lower half, row by row.
fn factor_hermitian(a: &mut [Complex], n: usize) -> Option<()> {
    for i in 0..n {
        for j in 0..=i {
            let mut sum = a[i * n + j];
            for k in 0..j {
                let p = conj_mul(a[j * n + k], a[i * n + k]);
                sum = [sum[0] - p[0], sum[1] - p[1]];
            }
            if i == j {
                if !(sum[0] > 0.0 && sum[0].is_finite()) {
                    return None;
                }
                a[i * n + i] = [sum[0].sqrt(), 0.0];
            } else {
                let d = a[j * n + j][0];
                a[i * n + j] = [sum[0] / d, sum[1] / d];
            }
        }
    }
    Some(())
}

fn solve_hermitian(l: &[Complex], n: usize, x: &mut [Complex]) {
    for i in 0..n {
        let mut sum = x[i];
        for k in 0..i {
            let p = mul(l[i * n + k], x[k]);
            sum = [sum[0] - p[0], sum[1] - p[1]];
        }
        x[i] = [sum[0] / l[i * n + i][0], sum[1] / l[i * n + i][0]];
    }
    for i in (0..n).rev() {
        let mut sum = x[i];
        for k in i + 1..n {
            let p = conj_mul(l[k * n + i], x[k]);
            sum = [sum[0] - p[0], sum[1] - p[1]];
        }
        x[i] = [sum[0] / l[i * n + i][0], sum[1] / l[i * n + i][0]];
    }
}

/// Solves a symmetric positive definite system given by its lower half, row by row.
fn solve_dense(a: &mut [f64], n: usize, x: &mut [f64]) -> Option<()> {
    for i in 0..n {
        for j in 0..=i {
            let (before, own) = a.split_at_mut(i * n);
            let sum = if j < i {
                own[j] - dot(&own[..j], &before[j * n..j * n + j])
            } else {
                own[j] - dot(&own[..j], &own[..j])
            };
            if i == j {
                if !(sum > 0.0 && sum.is_finite()) {
                    return None;
                }
                own[i] = sum.sqrt();
            } else {
                own[j] = sum / before[j * n + j];
            }
        }
        x[i] = (x[i] - dot(&a[i * n..i * n + i], &x[..i])) / a[i * n + i];
    }
    for i in (0..n).rev() {
        x[i] /= a[i * n + i];
        let value = x[i];
        x[..i].iter_mut().zip(&a[i * n..]).for_each(|(x, l)| *x -= l * value);
    }
    Some(())
}

/// A sum whose order does not depend on the machine, in four chains that it can keep apart.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (mut left, mut right) = (a.chunks_exact(4), b.chunks_exact(4));
    for (a, b) in left.by_ref().zip(right.by_ref()) {
        for l in 0..4 {
            sums[l] += a[l] * b[l];
        }
    }
    let rest: f64 = left.remainder().iter().zip(right.remainder()).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
