//! The two radius functions of a limb: how far the creature reaches on either side of the axis.
//!
//! Method: Reinert 2016, section 3.7.1. Every frame votes by marching from the axis along both normals to the border of
//! the mask; a vote is rejected when the way leads over another limb, reaches the image's border, is too short, or
//! starts where the tracker saw nothing. A robust percentile over all frames, the neighbours and the twin limb gives
//! the radius; gaps are filled along the limb, the function is smoothed and held inside the key frames' masks.

use glam::Vec2;
use rayon::prelude::*;

use super::axis::{Axis, normals};
use super::params::CreatureParams;
use crate::error::Result;
use crate::job::Stage;
use crate::raster::{Grid, Mask};

/// Between these shares of its length a limb's radius is likely to be.
const LIKELY: (f32, f32) = (0.06, 0.15);
/// Length of a step of a march, in pixels.
const STEP: f32 = 0.5;

/// Radii along an axis, one a sample, in clip pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Radii {
    /// Along the normal (to the left of the axis' direction, as the image shows it).
    pub left: Vec<f32>,
    /// Against the normal.
    pub right: Vec<f32>,
}

/// One frame's votes for a limb; `None` where rejected.
#[derive(Clone, Debug, Default)]
pub(super) struct Votes {
    pub left: Vec<Option<f32>>,
    pub right: Vec<Option<f32>>,
}

/// The votes of all frames for all limbs: `[frame][limb]`. `labels` gives a frame's pixels to limbs (0 outside, limb
/// index + 1 inside).
pub(super) fn vote(axes: &[Axis], labels: &[Grid<u16>], min_vote: f32, stage: Stage<'_>) -> Result<Vec<Vec<Votes>>> {
    let done = std::sync::atomic::AtomicUsize::new(0);
    (0..labels.len())
        .into_par_iter()
        .map(|f| {
            let n = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            stage.at(n as f64 / labels.len() as f64)?;
            Ok(axes.iter().enumerate().map(|(l, axis)| frame_votes(axis, f, l, &labels[f], min_vote)).collect())
        })
        .collect()
}

fn frame_votes(axis: &Axis, frame: usize, limb: usize, labels: &Grid<u16>, min_vote: f32) -> Votes {
    let points = &axis.frames[frame];
    let normal = normals(points);
    let one = |i: usize, direction: Vec2| {
        if !axis.visible[frame][i] { None } else { march(points[i], direction, limb as u16 + 1, labels, min_vote) }
    };
    Votes {
        left: (0..points.len()).map(|i| one(i, normal[i])).collect(),
        right: (0..points.len()).map(|i| one(i, -normal[i])).collect(),
    }
}

/// How far the limb reaches from `start`; `None` where that cannot be seen.
fn march(start: Vec2, direction: Vec2, label: u16, labels: &Grid<u16>, min_vote: f32) -> Option<f32> {
    let (width, height) = (labels.width() as f32, labels.height() as f32);
    let mut travelled = 0.0;
    loop {
        let p = start + direction * travelled;
        if !(p.x >= 0.0 && p.y >= 0.0 && p.x < width && p.y < height) {
            return None;
        }
        match labels.get(p.x as usize, p.y as usize) {
            0 => break,
            l if l != label => return None,
            _ => travelled += STEP,
        }
    }
    (travelled >= min_vote).then_some(travelled)
}

/// Radii of all limbs from their votes. `twins` gives each limb's other of a pair, whose votes count too; a limb without
/// any vote is half as thick as its parent, as far as its length makes that likely.
pub(super) fn fit(
    axes: &[Axis],
    votes: &[Vec<Votes>],
    twins: &[Option<usize>],
    parents: &[Option<usize>],
    params: &CreatureParams,
) -> Vec<Radii> {
    let measured: Vec<[Option<Vec<f32>>; 2]> = (0..axes.len())
        .into_par_iter()
        .map(|l| [true, false].map(|left| fill_gaps(&percentiles(axes, votes, twins, l, left, params))))
        .collect();
    let mean = |l: usize| {
        let sides = measured[l].iter().flatten();
        let (sum, count) = sides.flatten().fold((0.0, 0usize), |(s, n), r| (s + r, n + 1));
        (count > 0).then(|| sum / count as f32)
    };
    let radii = (0..axes.len()).map(|l| {
        let length = axes[l].length;
        let parent = parents.get(l).copied().flatten().and_then(mean);
        let usual = parent.map_or(LIKELY.0, |r| r / 2.0 / length.max(1.0)).clamp(LIKELY.0, LIKELY.1) * length;
        // One side that was seen says more than another limb.
        let constant = || vec![mean(l).unwrap_or(usual); axes[l].samples()];
        let sigma = params.smoothing.max(0.0) * (axes[l].last - axes[l].first) as f32;
        let side = |k: usize| smoothed(&measured[l][k].clone().unwrap_or_else(constant), sigma);
        Radii { left: side(0), right: side(1) }
    });
    radii.collect()
}

/// The percentile of the accepted votes at every sample; `None` where too many were rejected.
fn percentiles(
    axes: &[Axis],
    votes: &[Vec<Votes>],
    twins: &[Option<usize>],
    limb: usize,
    left: bool,
    params: &CreatureParams,
) -> Vec<Option<f32>> {
    let samples = axes[limb].samples();
    let pick = |f: &[Votes], l: usize, i: usize| {
        let side = if left { &f[l].left } else { &f[l].right };
        side.get(i).copied().flatten()
    };
    // The twin may have another number of samples: the same share of the limb counts.
    let same_place = |i: usize, l: usize| {
        let share = axes[limb].share(i as f32);
        let at = axes[l].first as f32 + share * (axes[l].last - axes[l].first) as f32;
        (at.round().max(0.0) as usize).min(axes[l].samples() - 1)
    };
    let mut accepted = Vec::new();
    (0..samples)
        .map(|i| {
            accepted.clear();
            let mut asked = 0usize;
            for j in i.saturating_sub(params.neighbours)..=(i + params.neighbours).min(samples - 1) {
                for f in votes {
                    asked += 1;
                    accepted.extend(pick(f, limb, j));
                }
                if let Some(twin) = twins[limb] {
                    for f in votes {
                        asked += 1;
                        accepted.extend(pick(f, twin, same_place(j, twin)));
                    }
                }
            }
            let too_few = (accepted.len() as f32) < (1.0 - params.max_rejected) * asked as f32;
            if accepted.is_empty() || too_few {
                return None;
            }
            let rank = (params.percentile.clamp(0.0, 1.0) * (accepted.len() - 1) as f32).round() as usize;
            Some(*accepted.select_nth_unstable_by(rank, f32::total_cmp).1)
        })
        .collect()
}

/// Linear between measured samples, constant beyond them; `None` where nothing was measured.
fn fill_gaps(measured: &[Option<f32>]) -> Option<Vec<f32>> {
    let known: Vec<(usize, f32)> = measured.iter().enumerate().filter_map(|(i, r)| r.map(|r| (i, r))).collect();
    let (&first, &last) = known.first().zip(known.last())?;
    let mut next = 0;
    let fill = (0..measured.len()).map(|i| {
        if i <= first.0 {
            return first.1;
        }
        if i >= last.0 {
            return last.1;
        }
        while known[next + 1].0 < i {
            next += 1;
        }
        let (a, b) = (known[next], known[next + 1]);
        a.1 + (b.1 - a.1) * (i - a.0) as f32 / (b.0 - a.0) as f32
    });
    Some(fill.collect())
}

/// Gaussian smoothing, `sigma` in samples; the ends count their inside neighbours only.
pub(super) fn smoothed(values: &[f32], sigma: f32) -> Vec<f32> {
    if sigma < 0.25 {
        return values.to_vec();
    }
    let reach = (3.0 * sigma).ceil() as usize;
    let kernel: Vec<f32> = (0..=reach).map(|i| (-0.5 * (i as f32 / sigma).powi(2)).exp()).collect();
    (0..values.len())
        .map(|i| {
            let (mut sum, mut total) = (0.0, 0.0);
            for j in i.saturating_sub(reach)..=(i + reach).min(values.len() - 1) {
                let w = kernel[i.abs_diff(j)];
                sum += w * values[j];
                total += w;
            }
            sum / total
        })
        .collect()
}

/// Holds the radii inside the key frames' masks: no limb may be wider than the mask shows it on the key frames, where
/// the axis is certain. A key frame on which the mask ends within `least` pixels of the axis says nothing about the
/// stroke (the mask is torn), but ends the part that lengthens it.
pub(super) fn hold_inside(radii: &mut Radii, axis: &Axis, keys: &[usize], masks: &[Mask], least: f32) {
    let views: Vec<(&Mask, &[Vec2], Vec<Vec2>)> = keys
        .iter()
        .filter_map(|&k| axis.frames.get(k).zip(masks.get(k)))
        .map(|(points, mask)| (mask, points.as_slice(), normals(points)))
        .collect();
    for (sign, side) in [(1.0, &mut radii.left), (-1.0, &mut radii.right)] {
        for (i, radius) in side.iter_mut().enumerate() {
            let mut limits: Vec<f32> =
                views.iter().filter_map(|(mask, points, n)| reach(mask, points[i], n[i] * sign)).collect();
            limits.sort_by(f32::total_cmp);
            // The middle key frame decides: one torn mask must not cut a limb off.
            if let Some(&limit) = limits.get(limits.len() / 2) {
                let beyond = i < axis.first || i > axis.last;
                if limit >= least || beyond {
                    *radius = radius.min(limit);
                }
            }
        }
    }
}

/// How far the mask reaches from `start`; `None` where it reaches the image's border.
fn reach(mask: &Mask, start: Vec2, direction: Vec2) -> Option<f32> {
    let mut travelled = 0.0;
    loop {
        let p = start + direction * travelled;
        if !(p.x >= 0.0 && p.y >= 0.0 && p.x < mask.width() as f32 && p.y < mask.height() as f32) {
            return None;
        }
        if !mask.get(p.x as usize, p.y as usize) {
            return Some(travelled);
        }
        travelled += STEP;
    }
}
