//! A motion without jitter that still goes exactly through its key frames.
//!
//! Each coordinate over time is the series that stays near what was tracked, near where it is trusted, and changes its
//! acceleration little: penalised least squares on third differences (Whittaker 1923), solved as a banded system. Frames
//! that are held are no unknowns, so they come out as they went in. The penalty is given as the period in frames of the
//! swing that it halves.
//!
//! Known limits: each point by itself, so that a limb that swings widely within the halved period is shortened; a loop's
//! seam is an end like any: smooth before closing.

use glam::DVec2;

use super::Motion;
use crate::error::{Error, Result};

/// Which frames a smoothed motion goes through exactly.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Held {
    /// Those where every point of a track is certain: key frames.
    #[default]
    Certain,
    /// These frames, in all tracks.
    Frames(Vec<usize>),
}

/// How a motion is smoothed.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothParams {
    /// The period in frames of the swing that is halved: shorter ones vanish, longer ones stay. 2 to 200.
    pub period: f64,
    /// Which frames are gone through exactly.
    pub held: Held,
}

impl Default for SmoothParams {
    /// Tracking's jitter is within two or three frames; half a stride of a gallop takes twelve, of which a tenth of a percent
    /// is lost at five.
    fn default() -> Self {
        Self { period: 5.0, held: Held::Certain }
    }
}

/// What is not trusted at all still counts so much, so that no span hangs free.
const LEAST_TRUST: f64 = 0.02;

/// Smooths every track of `motion`.
///
/// # Errors
/// A period out of range, a held frame that is not there, a motion that is none.
pub fn smooth(motion: &Motion, params: &SmoothParams) -> Result<Motion> {
    motion.checked(1)?;
    if !(2.0..=200.0).contains(&params.period) {
        let problem = format!("is {}", params.period);
        return Err(Error::invalid("period of the swing that is halved", problem, "give frames, 2 to 200"));
    }
    if let Held::Frames(frames) = &params.held
        && let Some(beyond) = frames.iter().find(|f| **f >= motion.frames)
    {
        let problem = format!("is not there: the motion has {}", motion.frames);
        return Err(Error::invalid(format!("frame {beyond} to hold"), problem, "frames count from 0"));
    }
    // A swing of this period is halved where the penalty on its third difference is one.
    let penalty = (2.0 * (std::f64::consts::PI / params.period).sin()).powi(-6);
    let mut out = motion.clone();
    for track in &mut out.tracks {
        let held: Vec<bool> = match &params.held {
            Held::Certain => track.frames.iter().map(|f| f.confidence.iter().all(|c| *c >= 1.0)).collect(),
            Held::Frames(frames) => {
                let mut held = vec![false; motion.frames];
                frames.iter().for_each(|f| held[*f] = true);
                held
            }
        };
        for point in 0..track.frames[0].points.len() {
            let places: Vec<DVec2> = track.frames.iter().map(|f| f.points[point].as_dvec2()).collect();
            let trust = |f: &super::TrackFrame| {
                let seen = if f.visible[point] { 1.0 } else { 0.5 };
                (seen * f64::from(f.confidence[point].clamp(0.0, 1.0)).powi(2)).max(LEAST_TRUST)
            };
            let trust: Vec<f64> = track.frames.iter().map(trust).collect();
            let smoothed = whittaker(&places, &trust, &held, penalty);
            for ((frame, place), held) in track.frames.iter_mut().zip(smoothed).zip(&held) {
                if !held {
                    frame.points[point] = place.as_vec2();
                }
            }
        }
    }
    out.validate()?;
    Ok(out)
}

/// The series nearest to `values` by `weights`, with the sum of squared third differences times `penalty`; those that are
/// `held` do not move. Of shorter series lower differences count.
pub(super) fn whittaker(values: &[DVec2], weights: &[f64], held: &[bool], penalty: f64) -> Vec<DVec2> {
    let order = 3.min(values.len().saturating_sub(1));
    let stencil: &[f64] = match order {
        0 => return values.to_vec(),
        1 => &[-1.0, 1.0],
        2 => &[1.0, -2.0, 1.0],
        _ => &[-1.0, 3.0, -3.0, 1.0],
    };
    // Rows of the symmetric matrix from the diagonal on.
    let mut band: Vec<[f64; 4]> = weights.iter().map(|w| [*w, 0.0, 0.0, 0.0]).collect();
    for first in 0..values.len() - order {
        for (i, a) in stencil.iter().enumerate() {
            for (j, b) in stencil.iter().enumerate().skip(i) {
                band[first + i][j - i] += penalty * a * b;
            }
        }
    }
    let mut right: Vec<DVec2> = values.iter().zip(weights).map(|(v, w)| *v * *w).collect();
    // What is held goes over to the right and leaves an equation of its own.
    for (h, _) in held.iter().enumerate().filter(|h| *h.1) {
        for other in h.saturating_sub(3)..(h + 4).min(values.len()) {
            let (row, off) = (other.min(h), other.abs_diff(h));
            let entry = band[row][off];
            if other != h {
                band[row][off] = 0.0;
                right[other] -= values[h] * entry;
            }
        }
        (band[h][0], right[h]) = (1.0, values[h]);
    }
    solve_banded(band, right)
}

/// Solves a symmetric positive definite system of half bandwidth 3 by Cholesky's decomposition without roots.
fn solve_banded(mut band: Vec<[f64; 4]>, mut right: Vec<DVec2>) -> Vec<DVec2> {
    let count = band.len();
    for i in 0..count {
        let row = band[i];
        for k in 1..4.min(count - i) {
            let share = row[k] / row[0];
            for j in k..4 {
                band[i + k][j - k] -= share * row[j];
            }
            let above = right[i];
            right[i + k] -= above * share;
        }
    }
    for i in (0..count).rev() {
        let mut value = right[i];
        for k in 1..4.min(count - i) {
            value -= right[i + k] * band[i][k];
        }
        right[i] = value / band[i][0];
    }
    right
}
