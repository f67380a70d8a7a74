//! Moves the limbs of single frames so that the skin meets the frames' silhouettes.
//!
//! Tracking follows marks on the skin of the creature and is off by some pixels; with the skin's shape known, outlines say
//! more. In every frame but the rest frame each bone may move in the image plane; the moves are those that meet the wishes
//! of the vertices on the outline best, by how they carry bones along and turn the bones beside, small and alike along a chain
//! (one dense least-squares problem a frame), evened out over neighbouring frames.

use glam::{DVec2, Vec2, vec2};
use rayon::prelude::*;

use super::super::bones::{Bones, bone_weights};
use super::super::chain::all_world;
use super::super::limb::LimbShape;
use super::silhouette::{Fit, Wish};
use super::weights::Binding;

/// What a bone's own staying and its staying with its parent count against one vertex' wish.
const STAY: f64 = 0.1;
const TOGETHER: f64 = 1.5;
/// What a move takes from each of the two frames beside.
const EVEN: f32 = 0.2;

/// Bones nearer to each other in the image, in clip pixels, turn nothing: a chain seen end on has no direction.
const SHORT: f32 = 4.0;

/// The move of each bone in each frame, clip pixels. Takes from the wishes what the moves make good.
pub(super) fn moves(wishes: &mut [Vec<Wish>], fit: &Fit<'_>, bones: &Bones) -> Vec<Vec<Vec2>> {
    let levers: Vec<Vec<Lever>> = (0..wishes.len()).into_par_iter().map(|f| levers(bones, fit, f)).collect();
    let own: Vec<Vec<Vec2>> = wishes
        .par_iter()
        .zip(&levers)
        .enumerate()
        .map(
            |(f, (wishes, levers))| {
                if f == fit.rest { vec![Vec2::ZERO; bones.bones.len()] } else { solve(wishes, levers, fit, bones) }
            },
        )
        .collect();
    let fixed = |f: usize| f == fit.rest || fit.keys.contains(&f);
    let moves: Vec<Vec<Vec2>> = (0..own.len())
        .map(|f| {
            if fixed(f) {
                return own[f].clone();
            }
            let (before, after) = (&own[f.saturating_sub(1)], &own[(f + 1).min(own.len() - 1)]);
            (0..own[f].len()).map(|b| EVEN * (before[b] + after[b]) + (1.0 - 2.0 * EVEN) * own[f][b]).collect()
        })
        .collect();
    wishes.par_iter_mut().zip(&levers).zip(&moves).for_each(|((wishes, levers), moves)| {
        for wish in wishes {
            wish.distance -= row(wish, levers, fit.binding).map(|(b, c)| c.dot(moves[b])).sum::<f32>();
        }
    });
    moves
}

/// How a bone turns when its neighbours in the chain move.
struct Lever {
    at: Vec2,
    /// The bones before and after.
    ends: [usize; 2],
    /// The turn for a unit of move of the one after, against that of the one before.
    turn: Vec2,
}

fn levers(bones: &Bones, fit: &Fit<'_>, frame: usize) -> Vec<Lever> {
    let height = fit.masks[frame].height() as f32;
    let placed = all_world(&bones.bones, &bones.animation[frame]);
    let at = |b: usize| vec2(placed[b].0.x, height - placed[b].0.y);
    let mut out: Vec<Lever> = (0..placed.len()).map(|b| Lever { at: at(b), ends: [b, b], turn: Vec2::ZERO }).collect();
    for chain in &bones.of_limb {
        for (k, &b) in chain.iter().enumerate() {
            let ends = [chain[k.saturating_sub(1)], chain[(k + 1).min(chain.len() - 1)]];
            let way = at(ends[1]) - at(ends[0]);
            if way.length() > SHORT {
                (out[b].ends, out[b].turn) = (ends, way.perp() / way.length_squared());
            }
        }
    }
    out
}

/// How the moves of bones bring about what a wish asks for, to first order: bones carry their vertices along and around.
fn row<'a>(wish: &'a Wish, levers: &'a [Lever], binding: &'a Binding) -> impl Iterator<Item = (usize, Vec2)> + 'a {
    let v = wish.vertex as usize;
    let held = binding.bones[v].iter().zip(binding.weights[v]).filter(|(_, w)| *w > 0.0);
    held.flat_map(move |(&bone, weight)| {
        let bone = usize::from(bone);
        let lever = &levers[bone];
        let turned = lever.turn * (weight * wish.normal.dot((wish.at - lever.at).perp()));
        [(bone, weight * wish.normal), (lever.ends[1], turned), (lever.ends[0], -turned)]
    })
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

fn solve(wishes: &[Wish], levers: &[Lever], fit: &Fit<'_>, bones: &Bones) -> Vec<Vec2> {
    let n = 2 * bones.bones.len();
    let mut a = vec![0.0f64; n * n];
    let mut right = vec![0.0f64; n];
    let mut entries: Vec<(usize, f64)> = Vec::new();
    for wish in wishes {
        let w = f64::from(fit.trust(wish));
        entries.clear();
        for (b, c) in row(wish, levers, fit.binding) {
            entries.extend([(2 * b, f64::from(c.x)), (2 * b + 1, f64::from(c.y))]);
        }
        for &(i, ci) in &entries {
            right[i] += w * ci * f64::from(wish.distance);
            for &(j, cj) in &entries {
                a[i * n + j] += w * ci * cj;
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
