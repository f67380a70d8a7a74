//! The densely sampled axis of a limb over time, from the end nearer to the root to the other, lengthened at both ends
//! (Reinert 2016, section 3.7.1).

use glam::Vec2;

use crate::geometry::polyline;
use crate::motion::Track;

/// Clip pixels between samples, and a bound on how many there are.
const SPACING: f32 = 2.0;
const MAX_SAMPLES: usize = 400;

/// Where along a limb's axis each sample lies in every frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// For each frame all samples, clip pixels, y down.
    pub frames: Vec<Vec<Vec2>>,
    /// For each frame and sample, whether the tracker saw it.
    pub visible: Vec<Vec<bool>>,
    /// The first sample of the stroke itself; those before lengthen it.
    pub first: usize,
    /// The last sample of the stroke itself; those after lengthen it.
    pub last: usize,
    /// The stroke's longest length over time, in pixels.
    pub length: f32,
}

impl Axis {
    /// The axis along a track, `reversed` where the track starts at the end away from the root.
    pub(super) fn new(track: &Track, reversed: bool, extension: f32) -> Self {
        let length = track.frames.iter().map(|f| polyline::length(&f.points)).fold(0.0, f32::max);
        let core = samples_over(length);
        let extra = ((core - 1) as f32 * extension.clamp(0.0, 1.0)).ceil() as usize;
        let mut axis = Self {
            frames: Vec::with_capacity(track.frames.len()),
            visible: Vec::with_capacity(track.frames.len()),
            first: extra,
            last: extra + core - 1,
            length,
        };
        for frame in &track.frames {
            let mut points = frame.points.clone();
            let mut visible = frame.visible.clone();
            if reversed {
                points.reverse();
                visible.reverse();
            }
            let dense = polyline::resample(&points, core);
            axis.frames.push(lengthened(&dense, extra));
            let seen = |i: usize| {
                let share = i.saturating_sub(extra).min(core - 1) as f32 / (core - 1) as f32;
                let at = (share * (visible.len().max(1) - 1) as f32).round() as usize;
                visible.get(at).copied().unwrap_or(false)
            };
            axis.visible.push((0..core + 2 * extra).map(seen).collect());
        }
        axis
    }

    /// How many samples there are.
    pub(super) fn samples(&self) -> usize {
        self.last + self.first + 1
    }

    /// How far a sample is along the stroke: 0 at its start, 1 at its end, beyond that outside.
    pub(super) fn share(&self, sample: f32) -> f32 {
        (sample - self.first as f32) / (self.last - self.first) as f32
    }

    /// The length between two samples when the stroke is at its longest.
    pub(super) fn spacing(&self) -> f32 {
        self.length / (self.last - self.first) as f32
    }
}

/// How many samples a stroke of a length gets.
pub(super) fn samples_over(length: f32) -> usize {
    ((length / SPACING).ceil() as usize + 1).clamp(8, MAX_SAMPLES)
}

/// The polyline with `extra` more points at each end, straight on at its mean spacing.
fn lengthened(dense: &[Vec2], extra: usize) -> Vec<Vec2> {
    let n = dense.len();
    let step = polyline::length(dense) / (n - 1).max(1) as f32;
    // The direction of an end is that of its last tenth: a hand's last few pixels often hook.
    let reach = (n / 10).max(1).min(n - 1);
    let back = (dense[0] - dense[reach]).normalize_or_zero();
    let ahead = (dense[n - 1] - dense[n - 1 - reach]).normalize_or_zero();
    let before = (1..=extra).rev().map(|i| dense[0] + back * (step * i as f32));
    let after = (1..=extra).map(|i| dense[n - 1] + ahead * (step * i as f32));
    before.chain(dense.iter().copied()).chain(after).collect()
}

/// Unit normals of an axis in one frame, smoothed over a few samples: perpendicular to the direction, to its left as
/// the image shows it.
pub(super) fn normals(points: &[Vec2]) -> Vec<Vec2> {
    let reach = (points.len() / 40).max(2);
    (0..points.len())
        .map(|i| {
            let ahead = points[(i + reach).min(points.len() - 1)];
            let along = (ahead - points[i.saturating_sub(reach)]).try_normalize().unwrap_or(Vec2::X);
            Vec2::new(along.y, -along.x)
        })
        .collect()
}
