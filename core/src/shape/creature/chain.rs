//! A chain of bones along a curve in space: what reconstructing and posing share.
//!
//! Every bone stands on the curve and points along it with its second axis in the image plane, so that limbs never
//! roll. Known limit: a limb that swings past the viewing direction turns its second axis round.

use glam::{Mat3, Quat, Vec3};

use crate::shape::{Bone, Transform};

/// How far before and after a bone its direction is measured, as a share of the way to the next: what a curve does between
/// bones must not turn them.
const REACH: f32 = 0.8;

/// A bone's place and turn in world coordinates.
pub(super) type Placed = (Vec3, Quat);

/// `bones` bones at even steps over the points of `curve`, of which there are at least two.
pub(super) fn along(curve: &[Vec3], bones: usize) -> Vec<Placed> {
    let span = (curve.len() - 1) as f32;
    let place = |at: f32| point(curve, at.clamp(0.0, span));
    let reach = REACH * span / (bones - 1).max(1) as f32;
    (0..bones)
        .map(|k| {
            let at = span * k as f32 / (bones - 1).max(1) as f32;
            (place(at), frame_along(place(at + reach) - place(at - reach)))
        })
        .collect()
}

/// The place at a fractional point of a curve.
fn point(curve: &[Vec3], at: f32) -> Vec3 {
    let i = (at as usize).min(curve.len().saturating_sub(2));
    curve[i].lerp(curve[(i + 1).min(curve.len() - 1)], at - i as f32)
}

/// The rotation of a bone that points along `along`.
fn frame_along(along: Vec3) -> Quat {
    let Some(x) = along.try_normalize() else { return Quat::IDENTITY };
    let flat = Vec3::new(-x.y, x.x, 0.0);
    let Some(y) = flat.try_normalize() else {
        return Quat::from_rotation_y(-x.z.signum() * std::f32::consts::FRAC_PI_2);
    };
    Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y))).normalize()
}

/// A bone's transform relative to its parent.
pub(super) fn local((place, turn): Placed, parent: Option<Placed>) -> Transform {
    match parent {
        None => Transform { translation: place, rotation: turn },
        Some((from, base)) => {
            let back = base.inverse();
            Transform { translation: back * (place - from), rotation: (back * turn).normalize() }
        }
    }
}

/// Where a bone with this local transform is: [`local`] taken back.
pub(super) fn world(local: &Transform, parent: Option<Placed>) -> Placed {
    match parent {
        None => (local.translation, local.rotation),
        Some((from, base)) => (from + base * local.translation, (base * local.rotation).normalize()),
    }
}

/// Where all bones with these local transforms are.
pub(super) fn all_world(bones: &[Bone], local: &[Transform]) -> Vec<Placed> {
    let mut placed: Vec<Placed> = Vec::with_capacity(bones.len());
    for (bone, local) in bones.iter().zip(local) {
        placed.push(world(local, bone.parent.map(|p| placed[p])));
    }
    placed
}

/// q and -q are one rotation, but an importer that blends between frames takes the way that the signs say: the short
/// one.
pub(super) fn keep_signs(animation: &mut [Vec<Transform>]) {
    for f in 1..animation.len() {
        let (before, now) = animation.split_at_mut(f);
        for (bone, last) in now[0].iter_mut().zip(&before[f - 1]) {
            if bone.rotation.dot(last.rotation) < 0.0 {
                bone.rotation = -bone.rotation;
            }
        }
    }
}

/// The curve's length.
pub(super) fn length(curve: &[Vec3]) -> f32 {
    curve.windows(2).map(|p| p[0].distance(p[1])).sum()
}

/// Points at these distances along a curve from its start, rising; beyond its end, its end.
pub(super) fn at_distances(curve: &[Vec3], distances: &[f32]) -> Vec<Vec3> {
    let (mut i, mut passed) = (0, 0.0);
    distances
        .iter()
        .map(|&wanted| {
            let step = |i: usize| curve[i].distance(curve[i + 1]);
            while i + 2 < curve.len() && passed + step(i) < wanted {
                passed += step(i);
                i += 1;
            }
            let share = if step(i) > 0.0 { ((wanted - passed) / step(i)).clamp(0.0, 1.0) } else { 0.0 };
            curve[i].lerp(curve[i + 1], share)
        })
        .collect()
}

/// Turns the segments of a polyline that turn by more than `most` radians against the one before down to that, from the
/// start on; lengths stay. Whether anything was turned.
pub(super) fn limit_turns(points: &mut [Vec3], most: f32) -> bool {
    let mut limited = false;
    for i in 1..points.len().saturating_sub(1) {
        let (before, way) = (points[i] - points[i - 1], points[i + 1] - points[i]);
        let (Some(b), Some(w)) = (before.try_normalize(), way.try_normalize()) else { continue };
        if b.angle_between(w) <= most {
            continue;
        }
        let axis = b.cross(w).try_normalize().unwrap_or(Vec3::Z);
        let turned = Quat::from_axis_angle(axis, most) * b * way.length();
        // What follows keeps its direction in space and is moved along.
        let moved = points[i] + turned - points[i + 1];
        points[i + 1..].iter_mut().for_each(|p| *p += moved);
        limited = true;
    }
    limited
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    #[test]
    fn a_bone_points_along_its_curve_and_comes_back_from_its_parent() {
        let curve = [vec3(0.0, 0.0, 0.0), vec3(10.0, 0.0, 0.0), vec3(10.0, 10.0, 5.0)];
        let bones = along(&curve, 3);
        assert_eq!(bones.iter().map(|b| b.0).collect::<Vec<_>>(), curve);
        assert!((bones[0].1 * Vec3::X).distance(Vec3::X) < 1e-6);
        assert!((bones[2].1 * Vec3::X).distance(vec3(0.0, 10.0, 5.0).normalize()) < 1e-6);
        let back = world(&local(bones[2], Some(bones[1])), Some(bones[1]));
        assert!(back.0.distance(bones[2].0) < 1e-5 && back.1.dot(bones[2].1).abs() > 1.0 - 1e-6);
    }

    #[test]
    fn sharp_turns_are_opened_and_lengths_stay() {
        let mut points = [vec3(0.0, 0.0, 0.0), vec3(10.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(0.0, 9.0, 0.0)];
        let lengths = |p: &[Vec3]| p.windows(2).map(|s| s[0].distance(s[1])).collect::<Vec<_>>();
        let before = lengths(&points);
        assert!(limit_turns(&mut points, 1.0));
        for (a, b) in lengths(&points).into_iter().zip(before) {
            assert!((a - b).abs() < 1e-4);
        }
        for p in points.windows(3) {
            assert!((p[1] - p[0]).angle_between(p[2] - p[1]) < 1.0 + 1e-3);
        }
        assert!(!limit_turns(&mut points, 1.01));
    }

    #[test]
    fn no_curve_makes_a_number_that_is_none() {
        let still = [Vec3::ONE; 2];
        for (place, turn) in along(&still, 4).into_iter().chain(along(&[Vec3::ZERO, Vec3::NEG_Z], 4)) {
            assert!(place.is_finite() && (turn.length() - 1.0).abs() < 1e-6);
        }
        assert_eq!(at_distances(&still, &[0.0, 1.0]), still);
    }
}
