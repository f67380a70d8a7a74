//! Where the points together would have each of them: the branches of their tree (see `tree`), tracked as limbs.
//!
//! The limb tracker solves whole poses, hung from each other, with steady motion and a gait, and so keeps points that
//! alone would be lost; it knows their places less exactly. So its places are candidates, and leaving them costs.
//!
//! All of it comes from the points' first keys, so that a correction moves no guide. Known limits: only points first
//! marked on the frame on which most are; fewer than three say nothing of each other.

use glam::Vec2;

use super::footage::Footage;
use super::stretch::{Key, Place};
use super::tree::branches;
use crate::error::Result;
use crate::geometry::polyline;
use crate::job::Stage;
use crate::rig::{KeyFrame, Limb, Rig, Stroke};
use crate::track::Tracker;
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
    let line = |branch: &[usize]| -> Vec<Vec2> { branch.iter().map(|&i| at[i] * scale).collect() };
    let mut limbs = branches(footage, frame, &at, &ways);
    // Nobody can see how a limb of two points in one place lies.
    limbs.retain(|branch| polyline::length(&line(branch)) >= 1.0);
    if limbs.is_empty() {
        return Ok(Vec::new());
    }
    let strokes = limbs.iter().enumerate().map(|(limb, b)| Stroke { limb, points: line(b), facing: None }).collect();
    let rig = Rig {
        size: (info.width, info.height),
        limbs: (0..limbs.len()).map(|l| Limb { label: l.to_string(), side: None }).collect(),
        keyframes: vec![KeyFrame { frame, strokes, ..KeyFrame::default() }],
    };
    let motion = LimbTracker::default().track(&footage.small, &rig, stage)?;
    let guide = |i: usize| {
        let (limb, vertex) =
            limbs.iter().enumerate().find_map(|(l, branch)| Some((l, branch.iter().position(|&v| v == i)?)))?;
        let line = line(&limbs[limb]);
        let share = polyline::length(&line[..=vertex]) / polyline::length(&line);
        let places = motion.tracks[limb].frames.iter().enumerate().map(|(f, pose)| {
            // The key frame holds the stroke as it was drawn, whose vertices lie elsewhere; there the point is known.
            if f == frame {
                return Guide { at: at[i], trust: 0.0 };
            }
            let along = share * (pose.points.len() - 1) as f32;
            let before = (along as usize).min(pose.points.len().saturating_sub(2));
            let after = (before + 1).min(pose.points.len() - 1);
            let place = pose.points[before].lerp(pose.points[after], along - before as f32);
            Guide { at: place / scale, trust: pose.confidence[before] }
        });
        Some((keys[i], places.collect()))
    };
    Ok((0..at.len()).filter_map(guide).collect())
}
