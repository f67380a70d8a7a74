//! Which limb of a pair is which after they pass each other.
//!
//! Where the limbs of a pair meet they look alike, and the cheapest path may let them bounce off each other instead of
//! passing through. Legs swing: a few frames on, each is where its own motion took it. So at every meeting the motion
//! before it is continued past it, and the motion after it back before it, by straight lines; the labelling that both
//! foretell better wins. Exact over all meetings by dynamic programming; frames with key frames keep their labels.
//!
//! Known limits: limbs that turn round within the few frames of a meeting (a fast gallop) cannot be foretold so; then
//! both labellings miss by much, the evidence counts for little, and the labels stay. Limbs that meet gently and turn
//! back are taken to have passed; a key frame after the meeting says otherwise.

use glam::Vec2;

use super::median::median;
use crate::geometry::polyline;

/// Places compared on each limb; those of the outer half, where the limbs part.
const PLACES: usize = 21;
const OUTER: usize = 10;
/// Limbs whose outer halves are nearer than this share of their length meet.
const MEETING: f32 = 0.2;
/// Meetings are at least so many frames apart.
const APART: usize = 3;
/// Frames before and after a meeting whose motion is continued.
const REACH: usize = 4;
/// A forecast that misses by this share of the length says nothing.
const BLIND: f32 = 0.4;
/// Cost of changing labels at a meeting, so that a draw changes nothing.
const CHANGE: f32 = 0.02;

/// For every frame whether the poses of the two limbs are to be exchanged. `drawn[f]` says that one of them is drawn on
/// frame `f`. Poses run from the joint outward.
pub(super) fn exchanged(poses: [&[Vec<Vec2>]; 2], drawn: &[bool]) -> Vec<bool> {
    let frames = drawn.len();
    let length = median(poses[0].iter().map(|p| polyline::length(p)).collect()).max(1.0);
    let limbs = outer_halves(poses);
    let meetings = meetings(&limbs, length);
    // Stretches between meetings; a meeting begins the stretch after it.
    let mut bounds = vec![0];
    bounds.extend(&meetings);
    bounds.push(frames);
    let fixed: Vec<bool> = bounds.windows(2).map(|b| drawn[b[0]..b[1]].contains(&true)).collect();
    let forbid = |stretch: usize, state: usize| if state == 1 && fixed[stretch] { f32::INFINITY } else { 0.0 };
    let mut cost = [0.0, forbid(0, 1) + CHANGE];
    let mut links: Vec<[usize; 2]> = Vec::with_capacity(meetings.len());
    for (i, &meeting) in meetings.iter().enumerate() {
        let from = (meeting.saturating_sub(REACH)).max(bounds[i] + usize::from(i > 0));
        let to = (meeting + REACH + 1).min(bounds[i + 2]);
        let evidence = for_change(&limbs, from..meeting, meeting + 1..to, length);
        let (same, other) = (evidence.max(0.0), (-evidence).max(0.0) + CHANGE);
        let mut link = [0; 2];
        let mut next = [0.0; 2];
        for state in 0..2 {
            let (stay, change) = (cost[state] + same, cost[1 - state] + other);
            link[state] = if change < stay { 1 - state } else { state };
            next[state] = stay.min(change) + forbid(i + 1, state);
        }
        links.push(link);
        cost = next;
    }
    let mut state = usize::from(cost[1] < cost[0]);
    let mut out = vec![false; frames];
    for i in (0..=meetings.len()).rev() {
        out[bounds[i]..bounds[i + 1]].fill(state == 1);
        if i > 0 {
            state = links[i - 1][state];
        }
    }
    out
}

/// The pose of one limb as that of the other, which hangs at `root` and has `count` vertices.
pub(super) fn as_other(pose: &[Vec2], root: Vec2, count: usize) -> Vec<Vec2> {
    let mut out = polyline::resample(pose, count);
    let shift = out.first().map_or(Vec2::ZERO, |first| root - *first);
    for (i, p) in out.iter_mut().enumerate() {
        *p += shift * (1.0 - i as f32 / (count - 1).max(1) as f32);
    }
    out
}

/// The outer halves relative to the joints, one list of places a frame.
fn outer_halves(poses: [&[Vec<Vec2>]; 2]) -> [Vec<Vec<Vec2>>; 2] {
    poses.map(|limb| {
        limb.iter()
            .enumerate()
            .map(|(f, pose)| {
                let joint = 0.5 * (poses[0][f][0] + poses[1][f][0]);
                polyline::resample(pose, PLACES)[OUTER..].iter().map(|p| *p - joint).collect()
            })
            .collect()
    })
}

fn distance(a: &[Vec2], b: &[Vec2]) -> f32 {
    a.iter().zip(b).map(|(p, q)| p.distance(*q)).sum::<f32>() / a.len() as f32
}

/// The frames in which the limbs are nearest to each other.
fn meetings(limbs: &[Vec<Vec<Vec2>>; 2], length: f32) -> Vec<usize> {
    let gaps: Vec<f32> = limbs[0].iter().zip(&limbs[1]).map(|(a, b)| distance(a, b)).collect();
    let mut out: Vec<usize> = Vec::new();
    for f in 1..gaps.len().saturating_sub(1) {
        if gaps[f] > gaps[f - 1] || gaps[f] >= gaps[f + 1] || gaps[f] >= MEETING * length {
            continue;
        }
        match out.last_mut() {
            Some(last) if f - *last < APART => {
                if gaps[f] < gaps[*last] {
                    *last = f;
                }
            }
            _ => out.push(f),
        }
    }
    out
}

/// In -1..=1: how much better the motion on either side foretells the other side with the labels exchanged between them.
fn for_change(
    limbs: &[Vec<Vec<Vec2>>; 2],
    before: std::ops::Range<usize>,
    after: std::ops::Range<usize>,
    length: f32,
) -> f32 {
    if before.len() < 2 || after.len() < 2 {
        return 0.0;
    }
    let (mut same, mut other) = (0.0, 0.0);
    for (known, asked) in [(&before, &after), (&after, &before)] {
        for t in asked.clone() {
            for limb in 0..2 {
                let foretold = continued(&limbs[limb][known.clone()], t as f32 - known.start as f32);
                let share = 0.25 / (asked.len() as f32 * length);
                same += share * distance(&foretold, &limbs[limb][t]);
                other += share * distance(&foretold, &limbs[1 - limb][t]);
            }
        }
    }
    let sight = (1.0 - same.min(other) / BLIND).max(0.0);
    sight * (same - other) / (same + other).max(f32::MIN_POSITIVE)
}

/// Straight lines through the places of successive frames (least squares), at time `t` counted from the first of them.
fn continued(poses: &[Vec<Vec2>], t: f32) -> Vec<Vec2> {
    let n = poses.len() as f32;
    let middle = (n - 1.0) / 2.0;
    let spread: f32 = (0..poses.len()).map(|i| (i as f32 - middle).powi(2)).sum();
    (0..poses[0].len())
        .map(|v| {
            let mean = poses.iter().map(|p| p[v]).sum::<Vec2>() / n;
            let slope = poses.iter().enumerate().map(|(i, p)| p[v] * (i as f32 - middle)).sum::<Vec2>() / spread;
            mean + slope * (t - middle)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    fn leg(swing: f32) -> Vec<Vec2> {
        (0..6).map(|i| vec2(100.0, 50.0) + Vec2::from_angle(1.57 + swing) * (16.0 * i as f32)).collect()
    }

    /// Two legs in opposite phase, twelve frames to a meeting.
    fn walk(frames: usize) -> [Vec<Vec<Vec2>>; 2] {
        [1.0, -1.0].map(|side: f32| (0..frames).map(|f| leg(side * 0.5 * (f as f32 * 0.26).cos())).collect())
    }

    #[test]
    fn legs_that_bounced_pass_through_again() {
        let truth = walk(48);
        let meetings = meetings(&outer_halves([&truth[0], &truth[1]]), 80.0);
        assert_eq!(meetings.len(), 4);
        let bounced = |limb: usize, f: usize| {
            let swaps = meetings.iter().filter(|m| **m <= f).count();
            truth[(limb + swaps) % 2][f].clone()
        };
        let path: [Vec<Vec<Vec2>>; 2] = [0, 1].map(|limb| (0..48).map(|f| bounced(limb, f)).collect());
        let mut drawn = vec![false; 48];
        drawn[0] = true;
        let exchange = exchanged([&path[0], &path[1]], &drawn);
        for f in 0..48 {
            let found = &path[usize::from(exchange[f])][f];
            assert!(distance(found, &truth[0][f]) < 1.0, "frame {f}");
        }
    }

    #[test]
    fn legs_that_pass_or_never_meet_are_left_alone() {
        let pass = walk(48);
        assert!(!exchanged([&pass[0], &pass[1]], &[false; 48]).contains(&true));
        let apart: [Vec<Vec<Vec2>>; 2] =
            [1.0, -1.0].map(|side: f32| (0..48).map(|f| leg(side * (0.5 - 0.2 * (f as f32 * 0.26).cos()))).collect());
        assert!(!exchanged([&apart[0], &apart[1]], &[false; 48]).contains(&true));
    }

    #[test]
    fn what_cannot_be_foretold_is_left_alone() {
        // A gallop: the legs turn round within two frames of every meeting.
        let wild: [Vec<Vec<Vec2>>; 2] =
            [1.0, -1.0].map(|side: f32| (0..48).map(|f| leg(side * 0.9 * (f as f32 * 1.3).cos())).collect());
        assert!(!exchanged([&wild[0], &wild[1]], &[false; 48]).contains(&true));
    }

    #[test]
    fn the_other_limbs_pose_hangs_from_the_joint() {
        let pose = as_other(&leg(0.3), vec2(104.0, 50.0), 9);
        assert_eq!((pose.len(), pose[0]), (9, vec2(104.0, 50.0)));
        assert!(pose[8].distance(leg(0.3)[5]) < 1e-3);
    }
}
