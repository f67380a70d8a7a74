//! How the skin hangs on the bones.
//!
//! A vertex follows the limb whose cylinder it is on; near a joint it follows both, by how much farther the one is than
//! the other, smoothed along the surface. Limbs that are not joined share vertices only where both begin, and take from
//! each other there, so that between twins the limb that both hang from holds the skin.

use glam::Vec3;
use rayon::prelude::*;

use super::super::bones::{Bones, bone_weights};
use super::super::limb::LimbShape;
use super::body::{Body, FAR};

/// A limb farther than the nearest by this share of the thinner one's radius has no say.
const REACH: f32 = 1.2;
/// Between these shares of its length a limb leaves its joint.
const JOINT: (f32, f32) = (0.25, 0.6);
/// Rounds of smoothing along the surface: half an edge each, so that weights fade over about three edges more.
const ROUNDS: usize = 12;

/// What each vertex follows.
pub(super) struct Binding {
    /// Up to four bones a vertex; a bone without weight is 0.
    pub bones: Vec<[u16; 4]>,
    /// Their weights, which sum to 1.
    pub weights: Vec<[f32; 4]>,
    /// The limb that a vertex is on.
    pub limb: Vec<u16>,
    /// `[vertex * limbs + limb]`: the share of each limb.
    pub share: Vec<f32>,
    /// The same for the nearest sample of each limb.
    pub sample: Vec<f32>,
}

/// Binds the vertices `places` (in the pose of `limbs`' only frame) with these `neighbours`.
pub(super) fn bind(
    places: &[Vec3],
    neighbours: &super::ring::Neighbours,
    body: &Body,
    limbs: &[LimbShape],
    bones: &Bones,
) -> Binding {
    let n = limbs.len();
    let parents: Vec<Option<usize>> = limbs.iter().map(|l| l.trunk.map(|(p, _)| p)).collect();
    let lines: Vec<Vec<usize>> = (0..n).map(|l| super::apart::ancestors(limbs, l)).collect();
    let line = |a: usize, b: usize| a == b || lines[a].contains(&b) || lines[b].contains(&a);
    // How near its own joint a place of a limb is: there limbs that are not joined to each other meet on what they hang from.
    let near_joint = |l: usize, sample: f32| {
        let t = ((limbs[l].axis.share(sample) - JOINT.0) / (JOINT.1 - JOINT.0)).clamp(0.0, 1.0);
        1.0 - t * t * (3.0 - 2.0 * t)
    };
    let radius: Vec<f32> = limbs.iter().map(LimbShape::mean_radius).collect();
    let read: Vec<(u16, Vec<(f32, f32)>)> = places
        .par_iter()
        .map(|p| {
            let each: Vec<(f32, f32)> = body.limbs.iter().map(|l| l.read(&body.field, *p)).collect();
            let main = (0..n).min_by(|&a, &b| each[a].0.total_cmp(&each[b].0)).unwrap_or(0);
            (main as u16, each)
        })
        .collect();
    let limb: Vec<u16> = read.iter().map(|r| r.0).collect();
    let mut share = vec![0.0f32; places.len() * n];
    let mut sample = vec![f32::NAN; places.len() * n];
    share.par_chunks_mut(n).zip(sample.par_chunks_mut(n)).zip(&read).for_each(|((share, sample), (main, each))| {
        let main = usize::from(*main);
        for l in 0..n {
            if each[l].0 < FAR {
                sample[l] = each[l].1;
            }
            if each[l].0 < FAR {
                let width = (REACH * radius[l].min(radius[main])).max(1e-3);
                let t = (1.0 - (each[l].0 - each[main].0) / width).clamp(0.0, 1.0);
                let joined = l == main || parents[l] == Some(main) || parents[main] == Some(l);
                let meet = |o: usize, other: usize| {
                    if lines[other].contains(&o) { 1.0 } else { near_joint(o, each[o].1) }
                };
                let met = if joined { 1.0 } else { meet(l, main) * meet(main, l) };
                share[l] = met * t * t * (3.0 - 2.0 * t);
            }
        }
        if share.iter().all(|s| *s <= 0.0) {
            share[main] = 1.0;
        }
    });
    settle(&mut share, &limb, &parents, &line);
    for _ in 0..ROUNDS {
        share = super::ring::smoothed(&share, n, neighbours, |_, _| true);
        settle(&mut share, &limb, &parents, &line);
    }
    for _ in 0..ROUNDS / 2 {
        // A sample is known where its limb is near.
        sample = super::ring::smoothed(&sample, n, neighbours, |own, other| own.is_finite() && other.is_finite());
    }
    let (joints, weights) = (0..places.len())
        .into_par_iter()
        .map(|v| {
            let mut all: Vec<(u16, f32)> = Vec::with_capacity(8);
            for (l, limb) in limbs.iter().enumerate() {
                let (w, s) = (share[v * n + l], sample[v * n + l]);
                if w > 0.0 {
                    let s = if s.is_finite() { s } else { limb.axis.first as f32 };
                    let chain = &bones.of_limb[l];
                    let (a, b, t) = bone_weights(limb, s, chain.len());
                    all.push((chain[a] as u16, w * (1.0 - t)));
                    all.push((chain[b] as u16, w * t));
                }
            }
            four(all)
        })
        .unzip();
    Binding { bones: joints, weights, limb, share, sample }
}

/// The four heaviest, summing to 1.
pub(in super::super) fn four(mut all: Vec<(u16, f32)>) -> ([u16; 4], [f32; 4]) {
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    all.truncate(4);
    let total: f32 = all.iter().map(|w| w.1).sum();
    let (mut bones, mut weights) = ([0; 4], [0.0; 4]);
    if total > 0.0 {
        for (k, (bone, weight)) in all.into_iter().filter(|w| w.1 > 0.0).enumerate() {
            (bones[k], weights[k]) = (bone, weight / total);
        }
    } else {
        weights[0] = 1.0;
    }
    (bones, weights)
}

/// Makes shares sum to 1 again. Limbs of which neither hangs from the other take from each other; what is taken goes to
/// what the vertex' own limb hangs from.
fn settle(share: &mut [f32], limb: &[u16], parents: &[Option<usize>], line: &(impl Fn(usize, usize) -> bool + Sync)) {
    let n = parents.len();
    share.par_chunks_mut(n).zip(limb).for_each(|(share, main)| {
        let main = usize::from(*main);
        let total: f32 = share.iter().sum::<f32>().max(1e-6);
        let old: Vec<f32> = share.iter().map(|s| s / total).collect();
        for l in 0..n {
            let rival = (0..n).filter(|&o| !line(o, l)).map(|o| old[o]).fold(0.0, f32::max);
            share[l] = (old[l] - rival).max(0.0);
        }
        let left = (1.0 - share.iter().sum::<f32>()).max(0.0);
        share[parents[main].unwrap_or(main)] += left;
    });
}
