//! Where a limb's axis lies beside its stroke. Strokes are drawn where it is easy and tracked along marks on the skin; axes lie
//! where the creature's outlines ask for them.
//!
//! How the two differ depends on the pose: a hock is drawn behind a bent leg and within a straight one. So it is kept for
//! poses that were seen and read by likeness for others (pose space deformation, Lewis, Cordner and Fong 2000, with
//! normalized Gaussian weights), and a pose unlike all of them gets what is usual.
//!
//! Known limit: likeness is that of shapes in the image, so that a creature turned as a whole gets what is usual.

use glam::{Vec2, vec2};
use serde::{Deserialize, Serialize};

use super::{CreatureLimb, path};
use crate::geometry::polyline;

/// A limb's pose that was seen, and how its axis lay there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SettledPose {
    /// The stroke at each bone, in clip pixels from its start, from the end nearer to the root.
    pub stroke: Vec<Vec2>,
    /// How far each bone stands from there, as in [`CreatureLimb::settled`].
    pub moved: Vec<Vec2>,
}

/// Poses that differ by this share of the limb's length, as the root of the mean square over its bones, tell little of each
/// other; legs in a walk differ by four times that from one frame to the next. On the tracked strokes of their own clips,
/// silhouettes of horse, fox and camel lose 0.3 to 0.8 of a hundred at 0.007, 0.5 to 1.0 at 0.01, 2.1 to 2.5 at 0.03, and
/// 4.8 to 5.3 with nothing but what is usual.
const ALIKE: f32 = 0.007;
/// What the usual weighs, against 1 for a pose that is the same.
const USUAL: f32 = 0.02;
/// The most poses that are kept of a limb: a stride or two of what it does.
const MOST: usize = 64;
/// Rounds in which a stroke is found that settles to an axis, after a guess by poses with like axes.
const ROUNDS: usize = 3;

/// What is kept of a limb: what is usual (the median over all frames), and the poses that differ most from each other.
pub(super) fn settled(strokes: &[Vec<Vec2>], axes: &[Vec<Vec2>], bones: usize) -> (Vec<Vec2>, Vec<SettledPose>) {
    let pose = |(stroke, axis): (&Vec<Vec2>, &Vec<Vec2>)| {
        let (from, to) = (at_bones(stroke, bones), at_bones(axis, bones));
        let moved = ways(&from).into_iter().zip(from.iter().zip(&to)).map(|(way, (from, to))| {
            let by = *to - *from;
            hundredths(vec2(by.dot(way), by.dot(way.perp())))
        });
        SettledPose { moved: moved.collect(), stroke: from.iter().map(|p| hundredths(*p - from[0])).collect() }
    };
    let poses: Vec<SettledPose> = strokes.iter().zip(axes).map(pose).collect();
    let median = |k: usize, part: fn(Vec2) -> f32| {
        let mut values: Vec<f32> = poses.iter().map(|p| part(p.moved[k])).collect();
        values.sort_by(f32::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let usual = (0..bones).map(|k| vec2(median(k, |v| v.x), median(k, |v| v.y))).collect();
    (usual, unlike(poses))
}

/// Files say it shorter, and nobody sees a smaller part of a pixel.
fn hundredths(v: Vec2) -> Vec2 {
    (v * 100.0).round() / 100.0
}

/// Of many poses those that differ most, each from all before.
fn unlike(poses: Vec<SettledPose>) -> Vec<SettledPose> {
    if poses.len() <= MOST {
        return poses;
    }
    let mut nearest = vec![f32::INFINITY; poses.len()];
    let mut kept = Vec::with_capacity(MOST);
    let mut next = 0;
    while kept.len() < MOST {
        kept.push(poses[next].clone());
        for (near, pose) in nearest.iter_mut().zip(&poses) {
            *near = near.min(apart(&pose.stroke, &poses[next].stroke));
        }
        next = (0..poses.len()).fold(0, |best, i| if nearest[i] > nearest[best] { i } else { best });
    }
    kept
}

impl SettledPose {
    /// The axis at each bone, from the stroke's start.
    fn axis(&self) -> Vec<Vec2> {
        let moved = ways(&self.stroke).into_iter().zip(&self.moved);
        self.stroke.iter().zip(moved).map(|(p, (way, by))| *p + turned(way, *by)).collect()
    }
}

impl CreatureLimb {
    /// Its strokes' length when they lie in the image plane.
    pub(super) fn stroke_length(&self) -> f32 {
        if self.settled_poses.is_empty() {
            return self.length;
        }
        path::full_length_of(self.settled_poses.iter().map(|p| polyline::length(&p.stroke)).collect())
    }

    /// Moves places along the limb, at even steps from the end nearer to the root, from its stroke to its axis, or `back`.
    pub(super) fn settle(&self, points: &mut [Vec2], back: bool) {
        if self.settled.len() < 2 || points.len() < 2 {
            return;
        }
        let given = points.to_vec();
        let strokes: Vec<&[Vec2]> = self.settled_poses.iter().map(|p| &p.stroke[..]).collect();
        if !back {
            shift(points, &given, &self.moved(&given, &strokes), 1.0);
            return;
        }
        let axes: Vec<Vec<Vec2>> = self.settled_poses.iter().map(SettledPose::axis).collect();
        shift(points, &given, &self.moved(&given, &axes), -1.0);
        for _ in 0..ROUNDS {
            let moved = self.moved(points, &strokes);
            shift(points, &given, &moved, -1.0);
        }
    }

    /// How far each bone stands from its place on a line that is like the `seen` ones, one for each settled pose.
    fn moved<Line: AsRef<[Vec2]>>(&self, line: &[Vec2], seen: &[Line]) -> Vec<Vec2> {
        let at = at_bones(line, self.settled.len());
        let scale = (ALIKE * self.length).powi(2).max(f32::MIN_POSITIVE);
        let mut sum: Vec<Vec2> = self.settled.iter().map(|usual| USUAL * *usual).collect();
        let mut weights = USUAL;
        for (pose, seen) in self.settled_poses.iter().zip(seen) {
            let weight = (-apart(&at, seen.as_ref()) / scale).exp();
            weights += weight;
            sum.iter_mut().zip(&pose.moved).for_each(|(sum, moved)| *sum += weight * *moved);
        }
        ways(&at).into_iter().zip(sum).map(|(way, sum)| turned(way, sum / weights)).collect()
    }
}

/// Sets `points` to `given` with what each bone is moved by.
fn shift(points: &mut [Vec2], given: &[Vec2], moved: &[Vec2], sign: f32) {
    let span = (points.len() - 1) as f32;
    for (i, (p, from)) in points.iter_mut().zip(given).enumerate() {
        *p = *from + sign * along(moved, i as f32 / span);
    }
}

/// The mean square distance of two lines, laid on each other with their starts.
fn apart(a: &[Vec2], b: &[Vec2]) -> f32 {
    a.iter().zip(b).map(|(p, q)| (*p - a[0]).distance_squared(*q - b[0])).sum::<f32>() / a.len().max(1) as f32
}

/// The places of so many bones at even steps on a line.
fn at_bones(line: &[Vec2], bones: usize) -> Vec<Vec2> {
    (0..bones).map(|k| along(line, k as f32 / (bones - 1) as f32)).collect()
}

/// The value at a share of the way along values at even steps.
fn along(values: &[Vec2], share: f32) -> Vec2 {
    let at = share * (values.len() - 1) as f32;
    let k = (at as usize).min(values.len() - 1);
    values[k].lerp(values[(k + 1).min(values.len() - 1)], at - k as f32)
}

/// Where a line points at each of its points: from the one before to the one after.
fn ways(line: &[Vec2]) -> Vec<Vec2> {
    let last = line.len().saturating_sub(1);
    (0..line.len()).map(|k| (line[(k + 1).min(last)] - line[k.saturating_sub(1)]).normalize_or_zero()).collect()
}

/// What lies so far along a way and to its right, as the image shows it.
fn turned(way: Vec2, by: Vec2) -> Vec2 {
    way * by.x + way.perp() * by.y
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight limb of 100 px that points this far from straight down.
    fn stroke(degrees: f32) -> Vec<Vec2> {
        let way = Vec2::from_angle(degrees.to_radians()).perp();
        (0..=50).map(|i| vec2(200.0, 100.0) + way * 2.0 * i as f32).collect()
    }

    fn side(line: &[Vec2]) -> Vec2 {
        (line[50] - line[0]).normalize().perp()
    }

    /// Its axis lies to one side of it when it is swung to one side, and to the other when to the other.
    fn limb() -> CreatureLimb {
        let swings: Vec<f32> = (-20..=20).map(|k| 1.5 * k as f32).collect();
        let strokes: Vec<Vec<Vec2>> = swings.iter().map(|s| stroke(*s)).collect();
        let aside = |(s, line): (&f32, &Vec<Vec2>)| line.iter().map(|p| *p + side(line) * s / 5.0).collect();
        let axes: Vec<Vec<Vec2>> = swings.iter().zip(&strokes).map(aside).collect();
        let (usual, seen) = settled(&strokes, &axes, 5);
        CreatureLimb {
            label: "leg".into(),
            side: None,
            twin: None,
            parent: None,
            reversed: false,
            first_bone: 0,
            bones: 5,
            length: 100.0,
            radius: 10.0,
            offset: 0.0,
            settled: usual,
            settled_poses: seen,
        }
    }

    #[test]
    fn what_was_seen_comes_back_what_is_between_lies_between_and_what_is_strange_is_usual() {
        let limb = limb();
        for (degrees, aside) in [(-30.0, -6.0), (-12.0, -2.4), (0.0, 0.0), (9.75, 1.95), (27.0, 5.4), (150.0, 0.0)] {
            let line = stroke(degrees);
            let mut points = line.clone();
            limb.settle(&mut points, false);
            for (p, from) in points.iter().zip(&line) {
                let by = (*p - *from).dot(side(&line));
                assert!((by - aside).abs() < 0.3, "{degrees} degrees: {by} for {aside}");
            }
        }
    }

    #[test]
    fn a_stroke_is_found_again_from_where_it_settles() {
        let limb = limb();
        for degrees in [-30.0, -4.0, 7.0, 20.0, 100.0] {
            let mut points = stroke(degrees);
            limb.settle(&mut points, false);
            limb.settle(&mut points, true);
            for (p, from) in points.iter().zip(&stroke(degrees)) {
                assert!(p.distance(*from) < 0.1, "{degrees} degrees: {p} for {from}");
            }
        }
    }

    #[test]
    fn of_a_long_clip_the_poses_that_differ_are_kept() {
        let strokes: Vec<Vec<Vec2>> = (0..1000).map(|f| stroke(if f == 700 { 90.0 } else { (f % 5) as f32 })).collect();
        let (_, poses) = settled(&strokes, &strokes, 4);
        assert_eq!(poses.len(), MOST);
        let far = stroke(90.0);
        let far = at_bones(&far, 4).iter().map(|p| hundredths(*p - far[0])).collect::<Vec<_>>();
        assert!(poses.iter().any(|p| p.stroke == far));
    }
}
