//! Moves the limbs of single frames so that the skin meets the frames' silhouettes.
//!
//! Tracking follows marks on the skin of the creature and is off by some pixels; with the skin's shape known, outlines say
//! more. In every frame but the rest frame each bone may move in the image plane; the moves are those that meet the wishes
//! of the vertices on the outline best, small and alike along a chain (one dense least-squares problem a frame), evened
//! out over neighbouring frames.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::super::bones::{Bones, bone_weights};
use super::super::limb::LimbShape;
use super::silhouette::{Fit, Wish};
use super::weights::Binding;

/// What a bone's own staying and its staying with its parent count against one vertex' wish.
const STAY: f64 = 0.1;
const TOGETHER: f64 = 1.5;
/// What a move takes from each of the two frames beside.
const EVEN: f32 = 0.2;

/// The move of each bone in each frame, clip pixels.
pub(super) fn moves(wishes: &[Vec<Wish>], fit: &Fit<'_>, bones: &Bones) -> Vec<Vec<Vec2>> {
    let own: Vec<Vec<Vec2>> = wishes
        .par_iter()
        .enumerate()
        .map(|(f, wishes)| if f == fit.rest { vec![Vec2::ZERO; bones.bones.len()] } else { solve(wishes, fit, bones) })
        .collect();
    let fixed = |f: usize| f == fit.rest || fit.keys.contains(&f);
    (0..own.len())
        .map(|f| {
            if fixed(f) {
                return own[f].clone();
            }
            let (before, after) = (&own[f.saturating_sub(1)], &own[(f + 1).min(own.len() - 1)]);
            (0..own[f].len()).map(|b| EVEN * (before[b] + after[b]) + (1.0 - 2.0 * EVEN) * own[f][b]).collect()
        })
        .collect()
}

/// How far a vertex moves with the bones, to first order.
pub(super) fn of_vertex(moves: &[Vec2], binding: &Binding, vertex: u32) -> Vec2 {
    let v = vertex as usize;
    binding.bones[v].iter().zip(binding.weights[v]).map(|(b, w)| moves[usize::from(*b)] * w).sum()
}

/// Moves the limbs' axes with their bones.
pub(super) fn apply(moves: &[Vec<Vec2>], limbs: &mut [LimbShape], bones: &Bones) {
    for (l, limb) in limbs.iter_mut().enumerate() {
        let chain = &bones.of_limb[l];
        let held: Vec<(usize, usize, f32)> =
            (0..limb.axis.samples()).map(|i| bone_weights(limb, i as f32, chain.len())).collect();
        for (points, moves) in limb.axis.frames.iter_mut().zip(moves) {
            for (p, (a, b, t)) in points.iter_mut().zip(&held) {
                *p += moves[chain[*a]].lerp(moves[chain[*b]], *t);
            }
        }
    }
}

fn solve(wishes: &[Wish], fit: &Fit<'_>, bones: &Bones) -> Vec<Vec2> {
    let n = 2 * bones.bones.len();
    let mut a = vec![0.0f64; n * n];
    let mut right = vec![0.0f64; n];
    for wish in wishes {
        let w = f64::from(fit.trust(wish));
        let v = wish.vertex as usize;
        let normal = [f64::from(wish.normal.x), f64::from(wish.normal.y)];
        let held = || fit.binding.bones[v].iter().zip(fit.binding.weights[v]).filter(|(_, w)| *w > 0.0);
        for (i, wi) in held() {
            for k in 0..2 {
                let row = 2 * usize::from(*i) + k;
                let ci = f64::from(wi) * normal[k];
                right[row] += w * ci * f64::from(wish.distance);
                for (j, wj) in held() {
                    for m in 0..2 {
                        a[row * n + 2 * usize::from(*j) + m] += w * ci * f64::from(wj) * normal[m];
                    }
                }
            }
        }
    }
    for (b, bone) in bones.bones.iter().enumerate() {
        for k in 0..2 {
            let i = 2 * b + k;
            a[i * n + i] += STAY;
            if let Some(p) = bone.parent {
                let j = 2 * p + k;
                a[i * n + i] += TOGETHER;
                a[j * n + j] += TOGETHER;
                a[i * n + j] -= TOGETHER;
                a[j * n + i] -= TOGETHER;
            }
        }
    }
    cholesky_solve(&mut a, &mut right, n);
    right.chunks_exact(2).map(|t| DVec2::new(t[0], t[1]).as_vec2()).collect()
}

/// Solves a x = b in place for a positive definite a.
fn cholesky_solve(a: &mut [f64], b: &mut [f64], n: usize) {
    for i in 0..n {
        for j in 0..=i {
            let mut sum = a[i * n + j];
            for k in 0..j {
                sum -= a[i * n + k] * a[j * n + k];
            }
            a[i * n + j] = if i == j { sum.max(1e-9).sqrt() } else { sum / a[j * n + j] };
        }
    }
    for i in 0..n {
        let sum: f64 = (0..i).map(|k| a[i * n + k] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i * n + i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| a[k * n + i] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i * n + i];
    }
}
