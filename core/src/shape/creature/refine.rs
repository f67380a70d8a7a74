//! Settles tracked axes into the masks: a tube should fill its limb's pixels on both sides in every frame.
//!
//! Tracking follows marks on the skin and is off by some pixels; the masks know where the limb ends. Where the borders
//! of the limb's pixels across the axis disagree with its radii in opposite ways, the axis lies beside the middle. The
//! wanted shifts are noisy and have gaps, so the shift that is applied is the smooth one that explains them best: a
//! least-squares problem along the limb (one tridiagonal system, robust weights), then blended over neighbouring
//! frames. Free ends are treated alike along the limb: the whole limb stretches until its tip meets the mask's.
//!
//! Source: our own, by the marching of Reinert 2016, section 3.7.1. Limit: limbs that are covered over a long time
//! stay where the tracker put them.

use glam::Vec2;
use rayon::prelude::*;

use super::axis::{Axis, normals};
use super::radius::Radii;
use crate::raster::Grid;

/// How much a sample wants to stay where it was tracked, against one vote.
const STAY: f32 = 0.05;
/// What a vote counts when the other side was not seen.
const ONE_SIDED: f32 = 0.25;
/// What a vote counts where the tracker saw nothing.
const UNSEEN: f32 = 0.4;
/// Length of a step of a march, in pixels.
const STEP: f32 = 0.5;
/// Shifts beyond this share of the limb's radius are doubted.
const DOUBT: f32 = 0.8;
/// A tip moves at most by this share of the limb's length.
const MAX_STRETCH: f32 = 0.1;
/// Weight of a neighbouring frame's shift, when both are equally sure.
const TEMPORAL: f32 = 0.4;

/// A shift along the normal at one sample and how many votes stand behind it.
#[derive(Clone, Copy, Default)]
struct Wish {
    shift: f32,
    weight: f32,
}

/// Moves all frames of an axis to where the limb's radii fit its pixels. `labels` tells who owns the pixels
/// (limb index + 1), `free_end` whether nothing hangs from the limb's end; `stiffness` is that of
/// [`super::CreatureParams::settling_stiffness`].
pub(super) fn settle(
    axis: &mut Axis,
    limb: usize,
    radii: &Radii,
    free_end: bool,
    labels: &[Grid<u16>],
    stiffness: f32,
) {
    let frames = axis.frames.len().min(labels.len());
    let label = limb as u16 + 1;
    let solved: Vec<Vec<Wish>> = (0..frames)
        .into_par_iter()
        .map(|f| solve(&wishes(axis, f, radii, label, &labels[f]), axis, stiffness))
        .collect();
    let stretches: Vec<Option<f32>> = if free_end {
        let past = tip_lengths(axis, label, labels);
        let mut known: Vec<f32> = past.iter().flatten().copied().collect();
        known.sort_by(f32::total_cmp);
        let usual = known.get(known.len() / 2).copied();
        let bound = MAX_STRETCH * axis.length;
        past.iter().map(|p| Some((p.as_ref()? - usual?).clamp(-bound, bound))).collect()
    } else {
        vec![None; frames]
    };
    let moved: Vec<Vec<Vec2>> = (0..frames)
        .into_par_iter()
        .map(|f| {
            let n = normals(&axis.frames[f]);
            let around = [(f, 1.0), (f.wrapping_sub(1), TEMPORAL), (f + 1, TEMPORAL)];
            let nearby = || around.iter().filter(|(g, _)| *g < frames);
            let stretch = {
                let known = nearby().filter_map(|(g, w)| Some((stretches[*g]?, *w)));
                let (sum, total) = known.fold((0.0, 0.0), |(s, t), (v, w)| (s + v * w, t + w));
                // What the frame itself does not know fades out.
                if total > 0.0 { sum / total.max(1.0) } else { 0.0 }
            };
            (0..axis.frames[f].len())
                .map(|i| {
                    let (sum, total) = nearby().fold((0.0, 1e-6), |(s, t), (g, w)| {
                        let wish = solved[*g][i];
                        (s + wish.shift * w * wish.weight, t + w * wish.weight)
                    });
                    let along = Vec2::new(-n[i].y, n[i].x);
                    let share = axis.share(i as f32).clamp(0.0, 1.2);
                    axis.frames[f][i] + n[i] * (sum / total) + along * (stretch * share * share)
                })
                .collect()
        })
        .collect();
    for (frame, points) in axis.frames.iter_mut().zip(moved) {
        *frame = points;
    }
}

/// What each sample wants: the limb's own pixels along the normal are a run, whose borders should lie at the radii.
fn wishes(axis: &Axis, frame: usize, radii: &Radii, label: u16, labels: &Grid<u16>) -> Vec<Wish> {
    let points = &axis.frames[frame];
    let normals = normals(points);
    (0..points.len())
        .map(|i| {
            let (left, right) = (radii.left[i], radii.right[i]);
            let run = own_run(points[i], normals[i], label, labels, left + right);
            let (shift, weight) = match run {
                (Some(high), Some(low)) => ((high - left + low + right) / 2.0, 1.0),
                (Some(high), None) => (high - left, ONE_SIDED),
                (None, Some(low)) => (low + right, ONE_SIDED),
                (None, None) => (0.0, 0.0),
            };
            let doubt = (DOUBT * (left + right) / 2.0).max(1.0);
            let seen = if axis.visible[frame][i] { 1.0 } else { UNSEEN };
            Wish { shift, weight: seen * weight / (1.0 + (shift / doubt).powi(2)).powi(2) }
        })
        .collect()
}

/// The borders of the limb's own run of pixels along `normal`, as distances along it (the far border, the near one):
/// the run around `start`, or the nearest one within `reach` where `start` lies in the background. A border toward
/// another limb or the image's end is unknown.
fn own_run(start: Vec2, normal: Vec2, label: u16, labels: &Grid<u16>, reach: f32) -> (Option<f32>, Option<f32>) {
    let owner = |t: f32| {
        let p = start + normal * t;
        let within = p.x >= 0.0 && p.y >= 0.0 && p.x < labels.width() as f32 && p.y < labels.height() as f32;
        within.then(|| labels.get(p.x as usize, p.y as usize))
    };
    let border = |from: f32, step: f32| {
        let mut t = from;
        loop {
            match owner(t) {
                Some(l) if l == label => t += step,
                Some(0) => return Some(t),
                _ => return None,
            }
        }
    };
    let inside = match owner(0.0) {
        Some(l) if l == label => Some(0.0),
        Some(0) => {
            let steps = (reach / STEP).clamp(0.0, 4096.0) as usize;
            let places = (1..=steps).flat_map(|k| [k as f32 * STEP, -(k as f32) * STEP]);
            places.into_iter().find(|t| owner(*t) == Some(label))
        }
        _ => None,
    };
    inside.map_or((None, None), |t| (border(t, STEP), border(t, -STEP)))
}

/// The smooth shift x that minimises sum w (x - wish)^2 + STAY x^2 + stiffness (x' )^2, with the weight of the votes
/// near each sample.
fn solve(wishes: &[Wish], axis: &Axis, stiffness: f32) -> Vec<Wish> {
    let n = wishes.len();
    let stiffness = stiffness.max(0.0) * ((axis.last - axis.first) as f32 / 100.0).powi(2);
    // Thomas' algorithm on the diagonal d and the side diagonal -stiffness.
    let mut diagonal: Vec<f32> = Vec::with_capacity(n);
    let mut right: Vec<f32> = Vec::with_capacity(n);
    for (i, wish) in wishes.iter().enumerate() {
        let links = f32::from(u8::from(i > 0)) + f32::from(u8::from(i + 1 < n));
        let mut d = wish.weight + STAY + stiffness * links;
        let mut r = wish.weight * wish.shift;
        if i > 0 {
            let factor = stiffness / diagonal[i - 1];
            d -= factor * stiffness;
            r += factor * right[i - 1];
        }
        diagonal.push(d);
        right.push(r);
    }
    let mut out = vec![Wish::default(); n];
    let mut next = 0.0;
    for i in (0..n).rev() {
        next = (right[i] + if i + 1 < n { stiffness * next } else { 0.0 }) / diagonal[i];
        out[i].shift = next;
    }
    let weights: Vec<f32> = wishes.iter().map(|w| w.weight).collect();
    let spread = super::radius::smoothed(&weights, (axis.last - axis.first) as f32 * 0.05);
    out.iter_mut().zip(spread).for_each(|(o, w)| o.weight = w + STAY);
    out
}

/// How far each frame's limb reaches past the end of its stroke; `None` where another limb or the image's border is in
/// the way, or the end is outside the limb.
fn tip_lengths(axis: &Axis, label: u16, labels: &[Grid<u16>]) -> Vec<Option<f32>> {
    let back = (axis.last - axis.first) as f32 * 0.08;
    (0..axis.frames.len())
        .map(|f| {
            let points = &axis.frames[f];
            let before = points[axis.last.saturating_sub(back as usize + 1)];
            let along = (points[axis.last] - before).try_normalize()?;
            axis.visible[f][axis.last].then_some(())?;
            // From a little inside the limb, so that a stroke that is too long is found as well.
            let start = -(2.0 * back * axis.spacing());
            let mut travelled = start;
            while travelled < 0.4 * axis.length {
                let p = points[axis.last] + along * travelled;
                let grid = labels.get(f)?;
                if !(p.x >= 0.0 && p.y >= 0.0 && p.x < grid.width() as f32 && p.y < grid.height() as f32) {
                    return None;
                }
                match grid.get(p.x as usize, p.y as usize) {
                    0 => return (travelled > start).then_some(travelled),
                    l if l != label => return None,
                    _ => travelled += 0.5,
                }
            }
            None
        })
        .collect()
}
