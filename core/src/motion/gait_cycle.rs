//! The cycle of a motion: after how many frames everything moves the same way again, where it closes best, and which limb
//! is when.
//!
//! Poses are compared without the body's way: a few points of each track, moved onto each other, after an even growth or
//! shrinking of the figure is taken out. The period is where poses and their changes come back nearest to what they were,
//! by the mean square over all pairs of frames a lag apart without the worst quarter (hidden spans, slips); between frames
//! by the parabola through the three nearest lags. The loop begins where the frames on both sides of its seam agree best.
//! A limb's phase is that of the strongest harmonic of its swing.
//!
//! Known limits: a steady pace; a period that leaves no frames to compare is not found (give the range by hand); a figure
//! that turns in space while it walks has no cycle in the plane.

use std::f64::consts::TAU;

use glam::DVec2;

use super::sampling::Ends;
use super::{Motion, Track, TrackKind};
use crate::error::{Error, Result};

/// Points that stand for a track.
const SAMPLES: usize = 5;
/// The shortest period, in frames: fewer do not show a swing there and back. The longest: a minute at 60 a second.
const SHORTEST: usize = 5;
const LONGEST: usize = 3600;
/// Pairs of frames that are compared at a lag: more tell nothing new of a long motion.
const MOST_PAIRS: usize = 512;
/// Frames that must be left to compare: at least so many, and this share of the lag. 1.3 strides leave 0.3.
const COMPARED: (usize, f64) = (4, 0.12);
/// The worst share of the pairs of frames is left out.
const LEFT_OUT: f64 = 0.25;
/// In the period poses differ by less than this share of what they differ by at any lag.
const AGREEMENT: f64 = 0.5;
/// A divisor of the best lag is the period if it fits nearly as well: up to this factor, and this share of what poses
/// differ by at any lag, which a period half-way between frames is off by.
const AS_WELL: (f64, f64) = (1.3, 0.1);
/// What moves less than this share of the figure stands still: less than a pixel of a figure of two hundred.
const STILL: f64 = 0.005;

/// A limb's part in a cycle.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LimbPhase {
    /// The track.
    pub track: String,
    /// When its end is farthest along its swing, to the right or, where it swings up and down, below: as a share of the
    /// cycle from its start, 0..1. Limbs a half apart swing against each other.
    pub phase: f64,
    /// How far its end swings to either side of the middle, in pixels.
    pub swing: f64,
    /// How many times a cycle it swings: two strides that differ a little make one cycle.
    pub beats: u32,
}

/// The cycle of a motion.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct GaitCycle {
    /// After so many frames all is the same again; no whole number.
    pub period: f64,
    /// The frame at which a period begins whose surroundings are most like those where it ends.
    pub start: f64,
    /// How surely this is a cycle, 0..1: 1 less what poses a period apart differ by, as a share of what poses differ by
    /// at any lag.
    pub confidence: f64,
    /// Each track's part in it, in the motion's order.
    pub limbs: Vec<LimbPhase>,
}

/// Finds the cycle of a motion.
///
/// # Errors
/// A motion that is none, that stands still, or that shows no cycle.
pub fn find_cycle(motion: &Motion) -> Result<GaitCycle> {
    motion.checked(1)?;
    let none = |why: String| {
        let remedy =
            "give one that shows a stride and an eighth at least, or say yourself where the loop begins and ends";
        Error::invalid("cycle of the motion", why, remedy)
    };
    let left = |lag: usize| COMPARED.0.max((COMPARED.1 * lag as f64).ceil() as usize);
    let most = (0..motion.frames.min(LONGEST)).take_while(|&lag| lag + left(lag) <= motion.frames).last().unwrap_or(0);
    if most <= SHORTEST {
        return Err(none(format!("cannot be seen in {} frames", motion.frames)));
    }
    let poses = Poses::of(motion);
    let misses: Vec<f64> = (0..=most).map(|lag| poses.miss(lag)).collect();
    let mut sorted = misses[1..].to_vec();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    if usual < STILL * STILL {
        return Err(none("is none: nothing moves against the rest".into()));
    }
    let lows: Vec<usize> = (SHORTEST..most)
        .filter(|&lag| {
            misses[lag] <= misses[lag - 1] && misses[lag] <= misses[lag + 1] && misses[lag] < misses[lag / 2]
        })
        .collect();
    let vertex = |lag: usize| {
        let (a, b, c) = (misses[lag - 1], misses[lag], misses[lag + 1]);
        let bend = a - 2.0 * b + c;
        let aside = if bend > 0.0 { (0.5 * (a - c) / bend).clamp(-0.5, 0.5) } else { 0.0 };
        (lag as f64 + aside, (b - 0.25 * (a - c) * aside).max(0.0))
    };
    let least = lows.iter().map(|&lag| vertex(lag).1).fold(f64::INFINITY, f64::min);
    // Squares: factors are of differences.
    let found = lows.into_iter().map(vertex).find(|v| v.1 <= AS_WELL.0.powi(2) * least + AS_WELL.1.powi(2) * usual);
    let found = found.filter(|v| v.1 < AGREEMENT * AGREEMENT * usual);
    let Some((period, miss)) = found else {
        return Err(none("is none: no pose comes back".into()));
    };
    let start = poses.best_start(period);
    let limbs = motion.tracks.iter().map(|t| phase(motion, t, period, start)).collect();
    Ok(GaitCycle { period, start, confidence: 1.0 - (miss / usual).sqrt(), limbs })
}

/// Poses without the body's way, and how they change.
struct Poses {
    /// For each frame its points, in units of the figure's spread, and how fast they change.
    frames: Vec<Vec<(DVec2, DVec2)>>,
    /// How far each point of each frame is trusted.
    trust: Vec<Vec<f64>>,
    /// What a change counts against a pose: the root of the mean square of poses by that of changes.
    change: f64,
}

impl Poses {
    fn of(motion: &Motion) -> Self {
        let spot = |t: &Track, k: usize| k as f64 / (SAMPLES - 1) as f64 * (t.frames[0].points.len() - 1) as f64;
        let samples = |t: &Track| if t.frames[0].points.len() > 1 { SAMPLES } else { 1 };
        let all = |f: usize| {
            let sampled = motion.tracks.iter().flat_map(|t| (0..samples(t)).map(move |k| (t, spot(t, k))));
            sampled.map(move |(t, spot)| {
                let (low, frame) = (spot.floor() as usize, &t.frames[f]);
                let high = (low + 1).min(frame.points.len() - 1);
                let at = frame.points[low].as_dvec2().lerp(frame.points[high].as_dvec2(), spot.fract());
                let seen = if frame.visible[low] { 1.0 } else { 0.5 };
                // Squares, as of what is off by so much less.
                (at, (seen * f64::from(frame.confidence[low].clamp(0.0, 1.0))).powi(2))
            })
        };
        let (mut places, mut trust): (Vec<Vec<DVec2>>, Vec<Vec<f64>>) =
            (0..motion.frames).map(|f| all(f).unzip()).unzip();
        // What nobody trusts anywhere is better than nothing.
        if trust.iter().flatten().sum::<f64>() < 1e-6 {
            trust.iter_mut().flatten().for_each(|t| *t = 1.0);
        }
        let (count, points) = (motion.frames, places[0].len());
        let middle = |p: &[DVec2]| p.iter().sum::<DVec2>() / points as f64;
        let spread = |p: &[DVec2]| {
            let middle = middle(p);
            (p.iter().map(|q| q.distance_squared(middle)).sum::<f64>() / points as f64).sqrt().max(1e-6)
        };
        // Growth by the line through the logarithms of spreads.
        let logs: Vec<f64> = places.iter().map(|p| spread(p).ln()).collect();
        let late = |f: usize| f as f64 - (count - 1) as f64 / 2.0;
        let mean = logs.iter().sum::<f64>() / count as f64;
        let (rise, run) =
            logs.iter().enumerate().fold((0.0, 1e-9), |(a, b), (f, l)| (a + late(f) * l, b + late(f) * late(f)));
        for (f, place) in places.iter_mut().enumerate() {
            let scale = (mean + late(f) * rise / run).exp();
            place.iter_mut().for_each(|p| *p /= scale);
        }
        let changes: Vec<Vec<DVec2>> = (0..count)
            .map(|f| {
                let (a, b) = (f.saturating_sub(1), (f + 1).min(count - 1));
                let step = (b - a).max(1) as f64;
                places[a].iter().zip(&places[b]).map(|(p, q)| (*q - *p) / step).collect()
            })
            .collect();
        // By how much poses and changes vary, without the way of the whole.
        let varied = |of: &[Vec<DVec2>]| {
            let apart: Vec<Vec<DVec2>> = of.iter().map(|p| p.iter().map(|q| *q - middle(p)).collect()).collect();
            let mean = |i: usize| apart.iter().map(|p| p[i]).sum::<DVec2>() / count as f64;
            (0..points).map(|i| apart.iter().map(|p| p[i].distance_squared(mean(i))).sum::<f64>()).sum::<f64>()
        };
        let moved = varied(&changes);
        let change = if moved > 0.0 { (varied(&places) / moved).sqrt() } else { 0.0 };
        let frames = places.into_iter().zip(changes).map(|(p, c)| p.into_iter().zip(c).collect()).collect();
        Self { frames, trust, change }
    }

    /// How much frames `f` and `g` differ when one is moved onto the other, squared, and how much that is to be trusted.
    fn gap(&self, f: usize, g: usize) -> (f64, f64) {
        let (mut weight, mut sum, mut squares) = (0.0, [DVec2::ZERO; 2], 0.0);
        for (i, (a, b)) in self.frames[f].iter().zip(&self.frames[g]).enumerate() {
            let w = self.trust[f][i] * self.trust[g][i];
            let (place, change) = (a.0 - b.0, (a.1 - b.1) * self.change);
            squares += w * (place.length_squared() + change.length_squared());
            sum = [sum[0] + place * w, sum[1] + change * w];
            weight += w;
        }
        if weight <= 0.0 {
            return (0.0, 0.0);
        }
        let way = (sum[0].length_squared() + sum[1].length_squared()) / weight;
        (0.5 * ((squares - way) / weight).max(0.0), weight)
    }

    /// How much frames a lag apart differ, squared, without the worst.
    fn miss(&self, lag: usize) -> f64 {
        let pairs = self.frames.len() - lag;
        let gaps = (0..pairs).step_by(pairs / MOST_PAIRS + 1).map(|f| self.gap(f, f + lag));
        let mut gaps: Vec<(f64, f64)> = gaps.filter(|g| g.1 > 0.0).collect();
        gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
        gaps.truncate(((1.0 - LEFT_OUT) * gaps.len() as f64).ceil() as usize);
        let weight: f64 = gaps.iter().map(|g| g.1).sum();
        if weight > 0.0 { gaps.iter().map(|g| g.0 * g.1).sum::<f64>() / weight } else { f64::INFINITY }
    }

    /// The frame whose surroundings are most like those a period on. Frames without neighbours on one side count as
    /// worse, as a loop has less to close with there.
    fn best_start(&self, period: f64) -> f64 {
        let count = self.frames.len();
        let lag = period.round() as usize;
        let last = ((count - 1) as f64 - period).floor().max(0.0) as usize;
        let reach = (lag / 6).max(1) as i64;
        let gaps: Vec<f64> = (0..count.saturating_sub(lag)).map(|f| self.gap(f, f + lag).0).collect();
        let usual = gaps.iter().sum::<f64>() / gaps.len().max(1) as f64;
        let cost = |start: usize| {
            let near = (-reach..=reach).map(|d| {
                let there = usize::try_from(start as i64 + d).ok().and_then(|f| gaps.get(f));
                // Nearer frames count more.
                (there.copied().unwrap_or(2.0 * usual), (reach + 1 - d.abs()) as f64)
            });
            let (sum, weight) = near.fold((0.0, 0.0), |(s, w), (gap, weight)| (s + gap * weight, w + weight));
            sum / weight
        };
        (0..=last).min_by(|&a, &b| cost(a).total_cmp(&cost(b))).unwrap_or(0) as f64
    }
}

/// When a track's end is farthest along its swing.
fn phase(motion: &Motion, track: &Track, period: f64, start: f64) -> LimbPhase {
    let above = motion.bones.iter().find(|b| b.1 == track.name).and_then(|b| motion.track(&b.0));
    let swings: Vec<DVec2> = (0..motion.frames)
        .map(|f| {
            let points = &track.frames[f].points;
            let end = points[points.len() - 1].as_dvec2();
            match (track.kind, above) {
                (TrackKind::Stroke, _) => end - points[0].as_dvec2(),
                (_, Some(above)) => end - above.places_at(f as f64, Ends::Open)[0],
                _ => {
                    let all = motion.tracks.iter().map(|t| t.frames[f].points[0].as_dvec2());
                    end - all.sum::<DVec2>() / motion.tracks.len() as f64
                }
            }
        })
        .collect();
    let harmonics = [1, 2, 3, 4].map(|beats| (beats, harmonic(&swings, period / f64::from(beats), start)));
    let strength = |h: &[DVec2; 2]| h[0].length_squared() + h[1].length_squared();
    let (beats, [cosine, sine]) = harmonics.into_iter().fold(harmonics[0], |best, next| {
        // A higher one must be clearly stronger: a stance and a swing of unlike lengths have both.
        if strength(&next.1) > 2.0 * strength(&best.1) { next } else { best }
    });
    // The principal axis of the ellipse that the harmonic runs along.
    let (xx, xy, yy) =
        [cosine, sine].iter().fold((0.0, 0.0, 0.0), |(a, b, c), v| (a + v.x * v.x, b + v.x * v.y, c + v.y * v.y));
    let axis = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
    let axis = if axis.x < -1e-6 || (axis.x.abs() <= 1e-6 && axis.y < 0.0) { -axis } else { axis };
    let (c, s) = (cosine.dot(axis), sine.dot(axis));
    let phase = (s.atan2(c) / TAU).rem_euclid(1.0) / f64::from(beats);
    LimbPhase { track: track.name.clone(), phase, swing: c.hypot(s), beats }
}

/// The harmonic of `values` of this period, beside a constant and a slope, by least squares: what goes with the cosine and with the
/// sine of the cycle from `start`.
fn harmonic(values: &[DVec2], period: f64, start: f64) -> [DVec2; 2] {
    let row = |f: usize| {
        let angle = TAU * (f as f64 - start) / period;
        glam::DVec4::new(angle.cos(), angle.sin(), 1.0, f as f64 / values.len() as f64 - 0.5)
    };
    let mut normal = glam::DMat4::ZERO;
    let (mut x, mut y) = (glam::DVec4::ZERO, glam::DVec4::ZERO);
    for (f, value) in values.iter().enumerate() {
        let row = row(f);
        normal += glam::DMat4::from_cols(row * row.x, row * row.y, row * row.z, row * row.w);
        x += row * value.x;
        y += row * value.y;
    }
    if normal.determinant().abs() < 1e-12 {
        return [DVec2::ZERO; 2];
    }
    let inverse = normal.inverse();
    let (x, y) = (inverse * x, inverse * y);
    [DVec2::new(x.x, y.x), DVec2::new(x.y, y.y)]
}
