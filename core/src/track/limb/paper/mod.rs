//! The limb tracker of Reinert 2016, section 3.5, with improvements that can be switched on one by one.
//!
//! From every key frame the clip is followed forward and backward, frame by frame ([`pass`]): candidates for each vertex
//! with their appearance costs ([`appearance`]), distance and direction costs along the strokes, the exact optimum over
//! the whole forest. Far limbs near other strokes are forced to be hidden, and follow their twins when never seen
//! ([`far_limbs`]). Between two key frames both directions are blended, segment angles by spherical interpolation.
//!
//! Readings of what the paper leaves open: costs of appearance are means times a factor, not sums; the three templates are
//! of the last frames where the vertex was seen; minima keep a distance from each other; the best cost that hiding is
//! compared with is that of the frame before, taken or not; the grid of hidden candidates holds the centre.
//! A stroke drawn on some key frames only starts anew on those and is followed through the others.

mod appearance;
mod far_limbs;
mod pass;
#[cfg(test)]
mod tests;

use glam::Vec2;
use image::RgbImage;
use std::sync::atomic::{AtomicUsize, Ordering};

use self::appearance::Matcher;
use self::far_limbs::{Visited, follow_twins};
use self::pass::{Pass, Placed, Setting};
use super::params::{LimbParams, TemplateParams};
use super::space_time::Trajectory;
use super::templates::{KeyTemplates, MatchImage};
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::blend_tree;
use crate::raster::pyramid;
use crate::rig::{Rig, Side, Skeleton};

/// Disagreement of the two directions (pixels of a 512 x 512 image) that takes confidence down to 1/e.
const DISAGREEMENT: f32 = 10.0;
/// Confidence of a hidden vertex against a seen one.
const HIDDEN: f32 = 0.5;

/// Tracks every limb; one trajectory a limb, in the rig's order, in clip pixels.
pub(super) fn solve(
    clip: &Clip,
    rig: &Rig,
    skeleton: &Skeleton,
    params: &LimbParams,
    stage: Stage<'_>,
) -> Result<Vec<Trajectory>> {
    let info = clip.info();
    let (width, height) = pyramid::fitted(info.width, info.height, params.working_side);
    let shrink = Vec2::new(width as f32 / info.width as f32, height as f32 / info.height as f32);
    let read = |frame: usize| -> Result<RgbImage> { Ok(pyramid::shrunk(&clip.frame(frame)?.rgb, width, height)) };
    let keys = drawn_places(rig, skeleton, shrink);
    let scale = LimbParams::scale(width as usize, height as usize);

    let templates = if params.paper.anchored > 0.0 {
        let mut templates = KeyTemplates::new(skeleton, TemplateParams::default().scaled(scale));
        for (i, (frame, places)) in keys.iter().enumerate() {
            stage.at(0.1 * i as f64 / keys.len() as f64)?;
            templates.add_key(*frame, &MatchImage::new(&read(*frame)?), skeleton, places);
        }
        Some(templates)
    } else {
        None
    };
    let mut limbs = vec![Vec::new(); skeleton.len()];
    for (l, chain) in skeleton.limbs.iter().enumerate() {
        chain.vertices.iter().for_each(|&v| limbs[v].push(l));
    }
    let neighbours = neighbours(skeleton);
    let far = limbs.iter().map(|of| of.iter().all(|&l| rig.limbs[l].side == Some(Side::Far))).collect();
    let matcher = Matcher::new(&params.paper, scale);
    let setting = Setting { skeleton, params: &params.paper, scale, matcher, templates, limbs, neighbours, far };

    let (first, last) = match (keys.first(), keys.last()) {
        (Some(first), Some(last)) => (first.0, last.0),
        _ => return Ok(Vec::new()),
    };
    let steps = (info.frames - first) + last + 1;
    let done = AtomicUsize::new(0);
    let run = |frames: &mut dyn Iterator<Item = usize>| -> Result<Vec<Option<Vec<Option<Placed>>>>> {
        let mut pass = Pass::new(&setting);
        let mut visited: Vec<Visited> = Vec::new();
        let nothing = vec![None; skeleton.len()];
        for frame in frames {
            let count = done.fetch_add(1, Ordering::Relaxed);
            let stage = stage.part(0.1 + 0.9 * count as f64 / steps as f64, 1.0);
            stage.at(0.0)?;
            let drawn = keys.iter().find(|k| k.0 == frame).map_or(&nothing, |k| &k.1);
            visited.push((frame, pass.step(frame, &read(frame)?, drawn, stage)?));
        }
        follow_twins(&setting, rig, &mut visited);
        let mut by_frame = vec![None; info.frames];
        for (frame, placed) in visited {
            by_frame[frame] = Some(placed);
        }
        Ok(by_frame)
    };
    let (ahead, behind) = rayon::join(|| run(&mut (first..info.frames)), || run(&mut (0..=last).rev()));
    Ok(blended(rig, skeleton, &keys, &ahead?, &behind?, shrink, scale))
}

/// Every key frame with the places of the vertices it draws, in working pixels. Ends that are joined but drawn apart
/// meet half-way.
fn drawn_places(rig: &Rig, skeleton: &Skeleton, shrink: Vec2) -> Vec<(usize, Vec<Option<Vec2>>)> {
    let places = |frame: usize| {
        let mut sums = vec![(Vec2::ZERO, 0.0f32); skeleton.len()];
        for (l, chain) in skeleton.limbs.iter().enumerate() {
            for (p, &v) in skeleton.drawn(rig, l, frame).unwrap_or_default().iter().zip(&chain.vertices) {
                sums[v].0 += *p * shrink;
                sums[v].1 += 1.0;
            }
        }
        sums.into_iter().map(|(sum, n)| (n > 0.0).then(|| sum / n)).collect()
    };
    let drawing = rig.keyframes.iter().filter(|k| !k.strokes.is_empty());
    drawing.map(|k| (k.frame, places(k.frame))).collect()
}

/// Both directions as one track: each vertex by its distance in time to the key frames that draw it.
fn blended(
    rig: &Rig,
    skeleton: &Skeleton,
    keys: &[(usize, Vec<Option<Vec2>>)],
    ahead: &[Option<Vec<Option<Placed>>>],
    behind: &[Option<Vec<Option<Placed>>>],
    shrink: Vec2,
    scale: f32,
) -> Vec<Trajectory> {
    let blank = || Trajectory { poses: Vec::new(), visible: Vec::new(), confidence: Vec::new() };
    let mut out: Vec<Trajectory> = (0..rig.limbs.len()).map(|_| blank()).collect();
    let keys_of: Vec<Vec<usize>> =
        (0..skeleton.len()).map(|v| keys.iter().filter(|k| k.1[v].is_some()).map(|k| k.0).collect()).collect();
    let (order, parent) = rooted_at_joints(skeleton);
    for frame in 0..ahead.len() {
        let nowhere = Placed { at: Vec2::ZERO, visible: false, sure: 0.0 };
        let both: Vec<(Placed, Placed, f32)> = (0..skeleton.len())
            .map(|v| {
                let one = |pass: &[Option<Vec<Option<Placed>>>]| pass[frame].as_ref().and_then(|p| p[v]);
                match (one(ahead), one(behind)) {
                    (Some(a), Some(b)) => (a, b, share_behind(&keys_of[v], frame)),
                    (Some(a), None) => (a, a, 0.0),
                    (None, Some(b)) => (b, b, 1.0),
                    (None, None) => (nowhere, nowhere, 0.0),
                }
            })
            .collect();
        let from: Vec<Vec2> = both.iter().map(|b| b.0.at).collect();
        let to: Vec<Vec2> = both.iter().map(|b| b.1.at).collect();
        let share: Vec<f32> = both.iter().map(|b| b.2).collect();
        let places = blend_tree(&order, &parent, &from, &to, &share);
        for (track, chain) in out.iter_mut().zip(&skeleton.limbs) {
            let of = |v: &usize| &both[*v];
            track.poses.push(chain.vertices.iter().map(|&v| places[v] / shrink).collect());
            let nearer = |b: &(Placed, Placed, f32)| if b.2 < 0.5 { b.0 } else { b.1 };
            track.visible.push(chain.vertices.iter().map(|v| nearer(of(v)).visible).collect());
            let confidence = |b: &(Placed, Placed, f32)| {
                let trust = |p: Placed| p.sure * if p.visible { 1.0 } else { HIDDEN };
                let agreement = (-b.0.at.distance(b.1.at) / (DISAGREEMENT * scale)).exp();
                (trust(b.0) * (1.0 - b.2) + trust(b.1) * b.2) * agreement
            };
            track.confidence.push(chain.vertices.iter().map(|v| confidence(of(v))).collect());
        }
    }
    out
}

/// The parent and the children of every vertex.
fn neighbours(skeleton: &Skeleton) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); skeleton.len()];
    for (v, p) in skeleton.parent.iter().enumerate().filter_map(|(v, p)| Some((v, (*p)?))) {
        neighbours[v].push(p);
        neighbours[p].push(v);
    }
    neighbours
}

/// Every tree hung from the vertex where most limbs meet: order and parents. Blended angles add up from the root on, so
/// it should lie on the body and not at the end of a leg.
fn rooted_at_joints(skeleton: &Skeleton) -> (Vec<usize>, Vec<Option<usize>>) {
    let neighbours = neighbours(skeleton);
    let mut roots: Vec<usize> = (0..skeleton.len()).collect();
    roots.sort_by_key(|&v| (std::cmp::Reverse(neighbours[v].len()), v));
    let mut parent = vec![None; skeleton.len()];
    let mut order: Vec<usize> = Vec::with_capacity(skeleton.len());
    let mut reached = vec![false; skeleton.len()];
    for root in roots {
        if reached[root] {
            continue;
        }
        reached[root] = true;
        let mut next = order.len();
        order.push(root);
        while let Some(&v) = order.get(next) {
            next += 1;
            for &n in &neighbours[v] {
                if !reached[n] {
                    reached[n] = true;
                    parent[n] = Some(v);
                    order.push(n);
                }
            }
        }
    }
    (order, parent)
}

/// How far `frame` is on the way from the key frame before to the one after: the backward direction's share.
fn share_behind(keys: &[usize], frame: usize) -> f32 {
    let before = keys.iter().rev().find(|&&k| k <= frame);
    let after = keys.iter().find(|&&k| k >= frame);
    match (before, after) {
        (Some(a), Some(b)) if b > a => (frame - a) as f32 / (b - a) as f32,
        (None, Some(_)) => 1.0,
        _ => 0.0,
    }
}
