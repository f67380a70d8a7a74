//! Far limbs that are never seen: they move as their near twins do (Reinert 2016, section 3.5).
//!
//! The paper adds the near limb's offsets to a far limb's places when the far limb is hidden in all frames. Here "all
//! frames" are those from one key frame to the next, since what is drawn there starts anew.

use glam::Vec2;

use super::pass::{Placed, Setting};
use crate::rig::Rig;

/// Frame numbers in visiting order with what a pass placed there.
pub(super) type Visited = (usize, Vec<Option<Placed>>);

/// Moves every far limb that a pass never saw between two of its key frames like its twin. Vertices that the far limb
/// shares with other limbs stay.
pub(super) fn follow_twins(setting: &Setting<'_>, rig: &Rig, pass: &mut [Visited]) {
    for limb in 0..rig.limbs.len() {
        if rig.limbs[limb].side != Some(crate::rig::Side::Far) {
            continue;
        }
        let Some(twin) = rig.twin(limb) else { continue };
        let chain = &setting.skeleton.limbs[limb].vertices;
        let own: Vec<(usize, usize)> =
            chain.iter().copied().enumerate().filter(|&(_, v)| setting.limbs[v].len() == 1).collect();
        let starts: Vec<usize> = (0..pass.len()).filter(|&i| rig.stroke(limb, pass[i].0).is_some()).collect();
        for (n, &start) in starts.iter().enumerate() {
            let end = starts.get(n + 1).copied().unwrap_or(pass.len());
            let seen = |frame: &Visited| own.iter().any(|&(_, v)| frame.1[v].is_some_and(|p| p.visible));
            if pass[start + 1..end].iter().any(seen) {
                continue;
            }
            for &(i, v) in &own {
                let guide = counterpart(setting, chain.len(), i, limb, twin);
                let at = |frame: &Visited, v: usize| frame.1[v].map(|p| p.at);
                let (Some(drawn), Some(from)) = (at(&pass[start], v), at(&pass[start], guide)) else { continue };
                for frame in &mut pass[start + 1..end] {
                    let Some(offset) = at(frame, guide).map(|p: Vec2| p - from) else { continue };
                    if let Some(placed) = &mut frame.1[v] {
                        placed.at = drawn + offset;
                    }
                }
            }
        }
    }
}

/// The twin's vertex at the same share of its length, counted from the end that it hangs by.
fn counterpart(setting: &Setting<'_>, count: usize, index: usize, limb: usize, twin: usize) -> usize {
    let (ours, theirs) = (&setting.skeleton.limbs[limb], &setting.skeleton.limbs[twin]);
    let last = theirs.vertices.len() - 1;
    let share = index as f32 / (count - 1).max(1) as f32;
    let place = (share * last as f32).round() as usize;
    let aligned = ours.rooted_at_start == theirs.rooted_at_start;
    theirs.vertices[if aligned { place } else { last - place }]
}
