//! Where the points together would have each of them: the limbs of their skeleton (see `skeleton`), tracked as such.
//!
//! The limb tracker solves whole poses, hung from each other, pairs together, with steady motion and a gait, and so keeps
//! points that alone would be lost; it knows their places less exactly. So its places are candidates, and leaving them by
//! far costs, by little next to nothing.
//!
//! All of it comes from the points' first keys. A correction bends its point's guide towards it, as far as the keys beside
//! it, and no other: on rendered animals the errors of two points of a limb have little to do with each other. Where a
//! point's own way is smooth and the guide would tear it away dearly, the guide is left out. Known limits: only points first
//! marked on the frame on which most are; fewer than three say nothing of each other.

use glam::Vec2;

use super::footage::Footage;
use super::skeleton::{Branch, branches, pairs};
use super::stretch::{Key, Place};
use crate::error::Result;
use crate::geometry::polyline;
use crate::job::Stage;
use crate::rig::{KeyFrame, Limb, Rig, Side, Stroke};
use crate::track::limb::LimbTracker;

/// Fewer points have no guide.
const FEWEST: usize = 3;

/// Where a point should be in a frame, and how far that is to be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Guide {
    pub(super) at: Vec2,
    pub(super) trust: f32,
}

/// For every point of the frame on which most of `firsts` are, its guide in every frame. `ways` are what was found for each
/// alone.
pub(super) fn guides(
    footage: &Footage,
    firsts: &[Key],
    ways: &[Vec<Place>],
    stage: Stage<'_>,
) -> Result<Vec<(Key, Vec<Guide>)>> {
    let on = |frame: usize| firsts.iter().filter(|k| k.frame == frame).count();
    let Some(frame) = firsts.iter().map(|k| k.frame).max_by_key(|&f| (on(f), std::cmp::Reverse(f))) else {
        return Ok(Vec::new());
    };
    let (keys, ways): (Vec<Key>, Vec<Vec<Place>>) =
        firsts.iter().zip(ways).filter(|(k, _)| k.frame == frame).map(|(k, w)| (*k, w.clone())).unzip();
    if keys.len() < FEWEST {
        return Ok(Vec::new());
    }
    let at: Vec<Vec2> = keys.iter().map(|k| k.at).collect();
    let info = footage.small.info();
    let scale = info.width as f32 / footage.size.x;
    let mut limbs = branches(footage, frame, &at);
    // Nobody can see how a limb of two points in one place lies.
    limbs.retain(|limb| scale * polyline::length(&limb.line) >= 1.0);
    if limbs.is_empty() {
        return Ok(Vec::new());
    }
    let sure = |l: usize| {
        let all = limbs[l].points.iter().flat_map(|&(i, _)| &ways[i]).map(|p| p.confidence);
        all.clone().sum::<f32>() / all.count().max(1) as f32
    };
    // What is in front is followed more surely.
    let pairs: Vec<[usize; 2]> =
        pairs(&limbs).into_iter().map(|[a, b]| if sure(a) < sure(b) { [b, a] } else { [a, b] }).collect();
    let line = |l: &Branch| l.line.iter().map(|p| *p * scale).collect();
    let strokes = limbs.iter().enumerate().map(|(limb, l)| Stroke { limb, points: line(l), facing: None }).collect();
    let limb = |l: usize| match pairs.iter().position(|p| p.contains(&l)) {
        None => Limb { label: l.to_string(), side: None },
        Some(pair) if pairs[pair][0] == l => Limb { label: format!("pair {pair} near"), side: Some(Side::Near) },
        Some(pair) => Limb { label: format!("pair {pair} far"), side: Some(Side::Far) },
    };
    let rig = Rig {
        size: (info.width, info.height),
        limbs: (0..limbs.len()).map(limb).collect(),
        keyframes: vec![KeyFrame { frame, strokes, ..KeyFrame::default() }],
    };
    let tracks = LimbTracker::default().trajectories(&footage.limbs, &footage.small, &rig, stage)?;
    let guide = |i: usize| {
        let on = |(l, b): (usize, &Branch)| Some((l, b.points.iter().find(|p| p.0 == i)?.1));
        let (limb, vertex) = limbs.iter().enumerate().find_map(on)?;
        let line = &limbs[limb].line;
        let share = polyline::length(&line[..=vertex]) / polyline::length(line);
        let poses = tracks[limb].poses.iter().zip(&tracks[limb].confidence);
        let places = poses.enumerate().map(|(f, (pose, confidence))| {
            // The key frame holds the stroke as it was drawn, whose vertices lie elsewhere; there the point is known.
            if f == frame {
                return Guide { at: at[i], trust: 0.0 };
            }
            let along = share * (pose.len() - 1) as f32;
            let before = (along as usize).min(pose.len().saturating_sub(2));
            let after = (before + 1).min(pose.len() - 1);
            let place = pose[before].lerp(pose[after], along - before as f32);
            Guide { at: place / scale, trust: confidence[before].sqrt() }
        });
        Some((keys[i], places.collect()))
    };
    Ok((0..at.len()).filter_map(guide).collect())
}
