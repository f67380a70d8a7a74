//! The third coordinate of a limb's axis: limbs that leave the image plane, and the distance between pairs
//! (Reinert 2016, section 3.7.2).

use super::axis::Axis;
use super::params::{CreatureParams, LegSpread};
use crate::geometry::polyline;
use crate::rig::{Facing, Rig, Side};

/// The share of the limb over which it swings out from the middle plane to its full distance: a hip's or shoulder's.
const HIP_SHARE: f32 = 0.3;

/// Depth toward the viewer of every sample of a limb in every frame, relative to where the limb starts.
///
/// A limb whose projection is shorter than a share of its longest one points out of the image: its depth is a parabola
/// that leaves the image plane smoothly and has the right length in space. The paper switches at that share; here the
/// length fades in from 1.3 times the share, so that nothing jumps.
pub(super) fn bend_out(axis: &Axis, facing: &[f32], foreshortened: f32) -> Vec<Vec<f32>> {
    let full = full_length(axis);
    lengths(axis)
        .iter()
        .zip(facing)
        .map(|(&length, sign)| {
            let share = if full > 0.0 { length / full } else { 1.0 };
            let fade = ((1.3 * foreshortened - share) / (0.3 * foreshortened).max(1e-6)).clamp(0.0, 1.0);
            let rise = sign * parabola_rise(length, length + (full - length) * fade * fade * (3.0 - 2.0 * fade));
            (0..axis.samples()).map(|i| rise * axis.share(i as f32).max(0.0).powi(2)).collect()
        })
        .collect()
}

/// How long the stroke is in every frame's image.
fn lengths(axis: &Axis) -> Vec<f32> {
    axis.frames.iter().map(|p| polyline::length(&p[axis.first..=axis.last])).collect()
}

/// How long the limb is when it lies in the image plane: nearly the longest that it was, since one mistracked frame
/// must not make a limb long for good.
pub(super) fn full_length(axis: &Axis) -> f32 {
    let mut sorted = lengths(axis);
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
    match side {
        Some(Side::Near) => distance,
        Some(Side::Far) => -distance,
        Some(Side::Mid) | None => 0.0,
    }
}

/// The share of its pair's distance that a limb has reached at `share` of its length.
pub(super) fn hip_ramp(share: f32) -> f32 {
    let t = (share / HIP_SHARE).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

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
