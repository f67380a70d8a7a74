//! A motion between its frames: places by Catmull and Rom's cubic through the four nearest frames, which goes through
//! every frame exactly and keeps speeds continuous.
//!
//! Beyond its ends a motion goes on at the speed it has there. What lies between frames is never certain: confidence 1 is
//! left to frames that were drawn.

use glam::{DVec2, Vec2};

use super::{Motion, Track, TrackFrame};

/// The most that a place between frames is trusted.
const BETWEEN: f32 = 0.99;
/// Times this near to a frame are that frame: rounding, at a million frames.
const SAME: f64 = 1e-9;

/// How a motion goes on beyond its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    /// At the speed it has there.
    Open,
    /// With its first frame after its last.
    Closed,
}

/// The frame at or before time `t`, and how far it is to the next.
pub(super) fn split(t: f64) -> (i64, f64) {
    let near = t.round();
    if (t - near).abs() < SAME * (1.0 + near.abs()) {
        return (near as i64, 0.0);
    }
    (t.floor() as i64, t - t.floor())
}

/// The cubic through `p[1]` and `p[2]`, a share of the way from one to the other.
fn cubic(p: [DVec2; 4], share: f64) -> DVec2 {
    let (before, after) = ((p[2] - p[0]) / 2.0, (p[3] - p[1]) / 2.0);
    let way = p[2] - p[1];
    p[1] + share * (before + share * ((3.0 * way - 2.0 * before - after) + share * (before + after - 2.0 * way)))
}

impl Track {
    /// A point in any frame, by what lies beyond the ends.
    fn place(&self, frame: i64, point: usize, ends: Ends) -> DVec2 {
        let count = self.frames.len() as i64;
        let at = |f: i64| self.frames[f as usize].points[point].as_dvec2();
        match ends {
            Ends::Closed => at(frame.rem_euclid(count)),
            Ends::Open if frame < 0 => at(0) + (at(1.min(count - 1)) - at(0)) * frame as f64,
            Ends::Open if frame >= count => {
                at(count - 1) + (at(count - 1) - at((count - 2).max(0))) * (frame - count + 1) as f64
            }
            Ends::Open => at(frame),
        }
    }

    /// All points at time `t`, in frames.
    pub(super) fn places_at(&self, t: f64, ends: Ends) -> Vec<DVec2> {
        let (frame, share) = split(t);
        let points = 0..self.frames[0].points.len();
        if share == 0.0 {
            return points.map(|i| self.place(frame, i, ends)).collect();
        }
        points.map(|i| cubic([-1, 0, 1, 2].map(|k| self.place(frame + k, i, ends)), share)).collect()
    }

    /// The track at time `t`, in frames.
    pub(super) fn at(&self, t: f64, ends: Ends) -> TrackFrame {
        let count = self.frames.len() as i64;
        let (frame, share) = split(t);
        let there = |f: i64| match ends {
            Ends::Open => &self.frames[f.clamp(0, count - 1) as usize],
            Ends::Closed => &self.frames[f.rem_euclid(count) as usize],
        };
        if share == 0.0 && (ends == Ends::Closed || (0..count).contains(&frame)) {
            return there(frame).clone();
        }
        let (a, b) = (there(frame), there(frame + 1));
        let between = |(p, q): (&f32, &f32)| (p + (q - p) * share as f32).min(BETWEEN);
        TrackFrame {
            points: self.places_at(t, ends).into_iter().map(|p| p.as_vec2()).collect(),
            visible: if share < 0.5 { a.visible.clone() } else { b.visible.clone() },
            confidence: a.confidence.iter().zip(&b.confidence).map(between).collect(),
        }
    }
}

impl Motion {
    /// The motion at other times, in frames of this one.
    pub(super) fn at_times(&self, times: &[f64], ends: Ends, fps: f64) -> Self {
        let track = |t: &Track| Track {
            name: t.name.clone(),
            kind: t.kind,
            frames: times.iter().map(|&time| t.at(time, ends)).collect(),
        };
        Self {
            size: self.size,
            fps,
            frames: times.len(),
            tracks: self.tracks.iter().map(track).collect(),
            bones: self.bones.clone(),
        }
    }

    /// The longer side of what the figure covers, the median over frames, in pixels; 1 where it covers less.
    pub fn extent(&self) -> f64 {
        let cover = |f: usize| {
            let points = || self.tracks.iter().flat_map(|t| &t.frames[f].points);
            let low = points().copied().fold(Vec2::MAX, Vec2::min);
            let high = points().copied().fold(Vec2::MIN, Vec2::max);
            f64::from((high - low).max_element())
        };
        let mut sides: Vec<f64> = (0..self.frames).map(cover).collect();
        sides.sort_by(f64::total_cmp);
        sides.get(sides.len() / 2).copied().unwrap_or(1.0).max(1.0)
    }

    /// Checks the motion, and that it has frames and tracks.
    pub(super) fn checked(&self, least: usize) -> crate::error::Result<()> {
        self.validate()?;
        if self.frames < least || self.tracks.is_empty() {
            let problem = format!("has {} tracks in {} frames", self.tracks.len(), self.frames);
            let remedy = format!("give one of at least a track and {least} frames");
            return Err(crate::error::Error::invalid("motion", problem, remedy));
        }
        Ok(())
    }
}
