//! Blending two poses of one tree.
//!
//! Reinert 2016, section 3.5 ("Blending"): the direction of every segment relative to its parent segment is blended by
//! spherical interpolation, which in the plane is the shorter way round the circle, and roots linearly, so that limbs
//! keep their lengths where a blend of places would shorten them. Lengths, which the paper leaves open, are blended
//! linearly.

use glam::Vec2;

/// The pose between `from` and `to`. `parent[v]` is the parent of vertex `v`, `order` lists parents before children, and
/// `share[v]` in 0..=1 says how far the vertex is on the way to `to`. All slices have one entry a vertex.
///
/// A vertex whose share is 0 or 1, like all before it up to its root, comes out exactly as in that pose.
pub fn blend_tree(order: &[usize], parent: &[Option<usize>], from: &[Vec2], to: &[Vec2], share: &[f32]) -> Vec<Vec2> {
    let segment = |pose: &[Vec2], v: usize| parent[v].map_or(Vec2::ZERO, |p| pose[v] - pose[p]);
    // Directions as angles; a segment without length points where its parent segment does.
    let directions = |pose: &[Vec2]| {
        let mut angles = vec![0.0f32; pose.len()];
        for &v in order {
            let along = segment(pose, v);
            angles[v] =
                if along.length_squared() > 1e-12 { along.to_angle() } else { parent[v].map_or(0.0, |p| angles[p]) };
        }
        angles
    };
    let (a, b) = (directions(from), directions(to));
    let mut out = vec![Vec2::ZERO; from.len()];
    let mut angle = vec![0.0f32; from.len()];
    // Whether everything from the root to here is exactly one pose, and which.
    let mut pure: Vec<Option<bool>> = vec![None; from.len()];
    for &v in order {
        let t = share[v].clamp(0.0, 1.0);
        let own = if t <= 0.0 { Some(false) } else { (t >= 1.0).then_some(true) };
        let Some(p) = parent[v] else {
            out[v] = from[v].lerp(to[v], t);
            pure[v] = own;
            continue;
        };
        let bend_from = a[v] - a[p];
        let bend = bend_from + t * shorter_way(b[v] - b[p] - bend_from);
        angle[v] = angle[p] + bend;
        pure[v] = own.filter(|_| pure[p] == own);
        out[v] = match pure[v] {
            Some(false) => from[v],
            Some(true) => to[v],
            None => {
                let length = segment(from, v).length() * (1.0 - t) + segment(to, v).length() * t;
                out[p] + Vec2::from_angle(angle[v]) * length
            }
        };
    }
    out
}

/// The angle in -pi..=pi that turns as far.
fn shorter_way(angle: f32) -> f32 {
    use std::f32::consts::{PI, TAU};
    let turned = (angle + PI).rem_euclid(TAU) - PI;
    if turned.is_finite() { turned } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;
    use proptest::prelude::*;

    const ORDER: [usize; 4] = [0, 1, 2, 3];
    const PARENT: [Option<usize>; 4] = [None, Some(0), Some(1), Some(1)];

    #[test]
    fn half_way_round_a_quarter_turn_keeps_lengths() {
        let from = [vec2(0.0, 0.0), vec2(10.0, 0.0), vec2(20.0, 0.0), vec2(10.0, 5.0)];
        let to = [vec2(8.0, 4.0), vec2(8.0, 14.0), vec2(8.0, 24.0), vec2(3.0, 14.0)];
        let half = blend_tree(&ORDER, &PARENT, &from, &to, &[0.5; 4]);
        let diagonal = Vec2::from_angle(std::f32::consts::FRAC_PI_4);
        let expected = [vec2(4.0, 2.0), vec2(4.0, 2.0) + diagonal * 10.0, vec2(4.0, 2.0) + diagonal * 20.0];
        for (p, e) in half.iter().zip(expected) {
            assert!(p.distance(e) < 1e-4, "{p} {e}");
        }
        assert!((half[3] - half[1] - diagonal.perp() * 5.0).length() < 1e-4);
    }

    proptest! {
        #[test]
        fn ends_are_exact_and_lengths_lie_between(
            a in prop::collection::vec((-90f32..90.0, -90f32..90.0), 4),
            b in prop::collection::vec((-90f32..90.0, -90f32..90.0), 4),
            t in 0f32..1.0,
        ) {
            let pose = |p: Vec<(f32, f32)>| p.into_iter().map(Vec2::from).collect::<Vec<_>>();
            let (a, b) = (pose(a), pose(b));
            prop_assert_eq!(blend_tree(&ORDER, &PARENT, &a, &b, &[0.0; 4]), a.clone());
            prop_assert_eq!(blend_tree(&ORDER, &PARENT, &a, &b, &[1.0; 4]), b.clone());
            let mixed = blend_tree(&ORDER, &PARENT, &a, &b, &[t; 4]);
            for v in 1..4 {
                let length = |pose: &[Vec2]| pose[v].distance(pose[PARENT[v].expect("no root")]);
                let (low, high) = (length(&a).min(length(&b)), length(&a).max(length(&b)));
                prop_assert!(length(&mixed) > low - 1e-3 && length(&mixed) < high + 1e-3);
            }
        }
    }
}
