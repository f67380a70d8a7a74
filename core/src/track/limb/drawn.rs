//! What the key frames say before anything is tracked: colours, half widths, and where a limb hangs.

use glam::Vec2;

use super::footage::Footage;
use super::foreground::Foreground;
use super::limb_keys::LimbKeys;
use super::limb_width::half_widths;
use super::solving_order::Turn;
use super::space_time::Solved;
use crate::clip::Clip;
use crate::error::Result;
use crate::raster::{Planes, pyramid};
use crate::rig::{Rig, Skeleton};

/// The colours of the creature and of what surrounds it, from all key frames.
pub(super) fn learn_foreground(rig: &Rig, footage: &Footage) -> Foreground {
    let longest = (0..rig.limbs.len()).map(|l| rig.length_hint(l)).fold(0.0, f32::max) * footage.scale;
    let keys: Vec<_> = rig
        .keyframes
        .iter()
        .filter(|k| !k.strokes.is_empty())
        .map(|k| {
            let strokes = k.strokes.iter().map(|s| {
                let points: Vec<Vec2> = s.points.iter().map(|p| *p * footage.scale).collect();
                let steps = (crate::geometry::polyline::length(&points) / 4.0) as usize + 2;
                crate::geometry::polyline::resample(&points, steps)
            });
            (&footage.lab[k.frame], strokes.collect())
        })
        .collect();
    Foreground::learn(&keys, (0.02 * longest).max(1.5), 0.4 * longest)
}

/// The key frames in Lab at the working size.
pub(super) fn key_planes(clip: &Clip, rig: &Rig, footage: &Footage) -> Result<Vec<(usize, Planes)>> {
    let size = footage.size;
    let frames = rig.keyframes.iter().filter(|k| !k.strokes.is_empty());
    frames.map(|k| Ok((k.frame, Planes::lab(&pyramid::shrunk(&clip.frame(k.frame)?.rgb, size.0, size.1))))).collect()
}

/// Half widths at the vertices: the mean over the key frames.
pub(super) fn radii(keys: &LimbKeys, planes: &[(usize, Planes)]) -> Vec<f32> {
    let mut sum = vec![0.0; keys.vertices()];
    for (frame, pose) in keys.frames.iter().zip(&keys.poses) {
        let length = crate::geometry::polyline::length(pose);
        if let Some((_, planes)) = planes.iter().find(|p| p.0 == *frame) {
            for (s, r) in sum.iter_mut().zip(half_widths(planes, pose, 0.2 * length)) {
                *s += r / keys.frames.len() as f32;
            }
        }
    }
    sum
}

/// Where the limb's first vertex lies in every frame: on the limb it hangs from, with the gap that was drawn.
pub(super) fn roots(
    rig: &Rig,
    skeleton: &Skeleton,
    turn: Turn,
    turns: &[Turn],
    keys: &LimbKeys,
    solved: &[Option<Solved>],
    footage: &Footage,
) -> Option<Vec<Vec2>> {
    let (parent, at_end) = turn.from?;
    let track = solved[parent].as_ref()?;
    let parent_turn = turns.iter().find(|t| t.limb == parent)?;
    let last = track.poses[0].len() - 1;
    let vertex = if at_end == parent_turn.reversed { 0 } else { last };
    let parent_keys = LimbKeys::new(rig, skeleton, *parent_turn, footage.scale);
    let gap = |key: usize| {
        let joint = match parent_keys.frames.iter().position(|&f| f == keys.frames[key]) {
            Some(drawn) => parent_keys.poses[drawn][vertex],
            None => track.poses[keys.frames[key]][vertex],
        };
        keys.poses[key][0] - joint
    };
    Some((0..footage.frames()).map(|f| track.poses[f][vertex] + keys.mixed(f, gap, |a, b, t| a.lerp(b, t))).collect())
}
