//! The third coordinate of a limb's axis: limbs that leave the image plane, and the distance between pairs
//! (Reinert 2016, section 3.7.2).

use super::axis::Axis;
use super::params::{CreatureParams, LegSpread};
use crate::geometry::polyline;
use crate::rig::{Facing, Rig, Side};

/// The share of the limb over which it swings out from the middle plane to its full distance: a hip's or shoulder's.
const HIP_SHARE: f32 = 0.3;

/// How far toward the viewer the limb's end stands from its start in every frame.
///
/// A limb whose projection is shorter than a share of its longest one points out of the image, as far as its length in
/// space says.
pub(super) fn rises(axis: &Axis, facing: &[f32], foreshortened: f32) -> Vec<f32> {
    let full = full_length(axis);
    lengths(axis).iter().zip(facing).map(|(&length, sign)| sign * rise(length, full, foreshortened)).collect()
}

/// How far a limb of the length `full` leaves the image plane where it is `length` long in the image. The paper
/// switches at the share `foreshortened`; here the length fades in from 1.3 times the share, so that nothing jumps.
pub(super) fn rise(length: f32, full: f32, foreshortened: f32) -> f32 {
    let share = if full > 0.0 { length / full } else { 1.0 };
    let fade = (1.3 * foreshortened - share) / (0.3 * foreshortened).max(1e-6);
    parabola_rise(length, length + (full - length) * smooth(fade))
}

/// How far toward the viewer a limb's end stands that is bent just as far as its length in space says.
pub(super) fn exact_rise(length: f32, full: f32) -> f32 {
    parabola_rise(length, full)
}

/// The depth at a share of a limb that leaves the image plane smoothly, along a parabola.
pub(super) fn bent(share: f32, rise: f32) -> f32 {
    rise * share.max(0.0).powi(2)
}

/// A value over all frames from what is said at some of them, rising; where a key says nothing, it is what it is by
/// itself. From key to key it changes smoothly.
pub(super) fn eased(own: Vec<f32>, keys: &[(usize, Option<f32>)]) -> Vec<f32> {
    if keys.iter().all(|(_, said)| said.is_none()) {
        return own;
    }
    let at = |f: usize, own: f32| {
        let after = keys.partition_point(|(k, _)| *k <= f);
        let said = |k: usize| keys[k].1.unwrap_or(own);
        if after == 0 || after == keys.len() {
            return said(after.saturating_sub(1));
        }
        let (from, to) = (keys[after - 1].0, keys[after].0);
        let t = (f - from) as f32 / (to - from) as f32;
        said(after - 1) + (said(after) - said(after - 1)) * smooth(t)
    };
    own.into_iter().enumerate().map(|(f, own)| at(f, own)).collect()
}

/// How long the stroke is in every frame's image.
fn lengths(axis: &Axis) -> Vec<f32> {
    axis.frames.iter().map(|p| polyline::length(&p[axis.first..=axis.last])).collect()
}

/// How long the limb is when it lies in the image plane: nearly the longest that it was, since one mistracked frame
/// must not make a limb long for good.
pub(super) fn full_length(axis: &Axis) -> f32 {
    full_length_of(lengths(axis))
}

/// Nearly the longest of a limb's lengths over time.
pub(super) fn full_length_of(mut sorted: Vec<f32>) -> f32 {
    sorted.sort_by(f32::total_cmp);
    sorted.get((sorted.len() * 19 / 20).min(sorted.len().saturating_sub(1))).copied().unwrap_or(0.0)
}

/// The height at 1 of the parabola c t^2 over a base of `flat` whose arc has the length `arc`.
fn parabola_rise(flat: f32, arc: f32) -> f32 {
    if arc <= flat * 1.001 || !arc.is_finite() {
        return 0.0;
    }
    let arc_of = |c: f32| {
        (0..32).map(|i| (flat * flat + (2.0 * c * (i as f32 + 0.5) / 32.0).powi(2)).sqrt()).sum::<f32>() / 32.0
    };
    let (mut low, mut high) = (0.0, arc);
    for _ in 0..30 {
        let middle = (low + high) / 2.0;
        if arc_of(middle) < arc { low = middle } else { high = middle }
    }
    low
}

/// For every frame whether a limb that leaves the image plane does so toward the viewer (1) or away (-1): as the
/// nearest key frame with a flag says (the earlier of two as near). A limb without any flag points at the viewer.
pub(super) fn facing_over_time(rig: &Rig, limb: usize, reversed: bool, frames: usize) -> Vec<f32> {
    let flags: Vec<(usize, f32)> = rig
        .keys_of(limb)
        .filter_map(|(f, s)| Some((f, if s.facing? == Facing::Toward { 1.0 } else { -1.0 })))
        .map(|(f, sign)| (f, if reversed { -sign } else { sign }))
        .collect();
    (0..frames).map(|f| flags.iter().min_by_key(|(k, _)| (k.abs_diff(f), *k)).map_or(1.0, |(_, sign)| *sign)).collect()
}

/// How far a limb of a pair stands from the middle plane, in world units, toward the viewer for a near one. `radius`
/// is its mean radius in the lower half, `body_depth` the half depth of what it hangs from.
pub(super) fn pair_offset(side: Option<Side>, radius: f32, body_depth: f32, params: &CreatureParams) -> f32 {
    let distance = match params.leg_spread {
        LegSpread::BodyWidth { body, leg } => (body * body_depth).max(leg * radius),
        LegSpread::Radii(times) => times * radius,
    };
    let distance = distance * params.spread;
    match side {
        Some(Side::Near) => distance,
        Some(Side::Far) => -distance,
        Some(Side::Mid) | None => 0.0,
    }
}

/// The share of its pair's distance that a limb has reached at `share` of its length.
pub(super) fn hip_ramp(share: f32) -> f32 {
    smooth(share / HIP_SHARE)
}

/// From 0 at 0 to 1 at 1, level at both.
pub(super) fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The share of a limb's distance from the middle plane, of a pair's or one that was asked for, that it has reached at
/// `share` of its length. A limb that nothing holds moves as a whole.
pub(super) fn free_part(share: f32, held: bool) -> f32 {
    if held { hip_ramp(share) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_key_says_holds_there_and_fades_to_its_neighbours() {
        let own = vec![1.0; 31];
        assert_eq!(eased(own.clone(), &[(0, None), (20, None)]), own);
        let eased = eased(own, &[(0, None), (10, Some(9.0)), (20, None)]);
        assert_eq!((eased[0], eased[10], eased[20], eased[30]), (1.0, 9.0, 1.0, 1.0));
        assert!((eased[5] - 5.0).abs() < 1e-6);
        assert!(eased[..=10].is_sorted() && eased[10..].is_sorted_by(|a, b| a >= b));
    }

    #[test]
    fn the_parabola_has_the_length_asked_for() {
        let c = parabola_rise(30.0, 90.0);
        let mut length = 0.0;
        for i in 0..1000 {
            let (a, b) = (i as f32 / 1000.0, (i + 1) as f32 / 1000.0);
            length += ((30.0 * (b - a)).powi(2) + (c * (b * b - a * a)).powi(2)).sqrt();
        }
        assert!((length - 90.0).abs() < 0.2, "{length}");
        assert_eq!(parabola_rise(30.0, 20.0), 0.0);
    }
}
