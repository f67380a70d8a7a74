//! Motion without a clip: points that run along drawn paths, and paths.json, their file.
//!
//! `{"format":"marey-paths","version":1,"size":[W,H],"fps":24,"seconds":2,"points":[{"name":"tip","path":"M10 20 C..",
//! "turns":1,"phase":0,"rhythm":"swing"}]}`, with SVG path data. Around a closed path a point goes at constant speed; along
//! an open one it goes there and back, slowing down at the ends unless the rhythm is "even". The motion loops: its last
//! frame is followed by its first. Unknown keys are ignored, an unknown version is an error.

use glam::Vec2;
use kurbo::{BezPath, ParamCurve as _, ParamCurveArclen as _, PathEl, PathSeg, Point};
use serde::{Deserialize, Serialize};

use super::{Motion, Track, TrackFrame, TrackKind};
use crate::error::{Error, Result};

const FORMAT: &str = "marey-paths";
const VERSION: u32 = 1;
/// Bounds that keep a hostile file from eating the machine.
const MAX_POINTS: usize = 256;
const MAX_FRAMES: f64 = 100_000.0;
/// How exactly lengths along a path are measured, in pixels.
const ACCURACY: f64 = 1e-3;

/// Points that run along paths.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionPaths {
    /// Width and height of what the paths were drawn on.
    pub size: (u32, u32),
    /// Frames a second.
    pub fps: f64,
    /// How long it lasts, in seconds.
    pub seconds: f64,
    /// The points.
    pub points: Vec<PointPath>,
}

/// A point and the path that it runs along.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointPath {
    /// The point's name, unique.
    pub name: String,
    /// SVG path data, one subpath.
    pub path: String,
    /// How often it runs through its path: around, or there and back.
    #[serde(default = "once")]
    pub turns: u32,
    /// Where in a turn it begins, 0..=1.
    #[serde(default)]
    pub phase: f64,
    /// Of an open path: how it goes there and back.
    #[serde(default)]
    pub rhythm: Rhythm,
}

/// How a point goes there and back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Rhythm {
    /// Slowing down at the ends, as a pendulum does.
    #[default]
    Swing,
    /// At constant speed.
    Even,
}

fn once() -> u32 {
    1
}

#[derive(Deserialize)]
struct PathsFile {
    format: String,
    version: u32,
    size: (u32, u32),
    fps: f64,
    seconds: f64,
    points: Vec<PointPath>,
}

impl MotionPaths {
    /// Parses the text of a paths.json.
    ///
    /// # Errors
    /// It is no paths.json.
    pub fn from_json(text: &str) -> Result<Self> {
        let file: PathsFile = serde_json::from_str(text)
            .map_err(|e| Error::invalid("paths", format!("not readable: {e}"), "expected a marey-paths file"))?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(Error::invalid(
                "paths",
                format!("the file says {} version {}", file.format, file.version),
                format!("expected {FORMAT} version {VERSION}"),
            ));
        }
        let PathsFile { size, fps, seconds, points, .. } = file;
        Ok(Self { size, fps, seconds, points })
    }

    /// The motion: one track a point, of one point.
    ///
    /// # Errors
    /// No points or too many, a name that is there twice, a path that cannot be read or is empty, a length or rate that is
    /// none.
    pub fn motion(&self) -> Result<Motion> {
        let frames = (self.fps * self.seconds).round();
        if !(self.fps.is_finite() && self.fps > 0.0 && (1.0..=MAX_FRAMES).contains(&frames)) {
            let problem = format!("last {} seconds at {} frames a second", self.seconds, self.fps);
            return Err(Error::invalid("paths", problem, format!("give 1 to {MAX_FRAMES} frames")));
        }
        if self.points.is_empty() || self.points.len() > MAX_POINTS {
            let problem = format!("move {} points", self.points.len());
            return Err(Error::invalid("paths", problem, format!("give 1 to {MAX_POINTS}")));
        }
        let mut motion = Motion::new(self.size, self.fps, frames as usize)?;
        for point in &self.points {
            let run = Run::new(point)?;
            let at = |f: usize| run.at(f64::from(point.turns) * f as f64 / frames + point.phase);
            let frames = (0..frames as usize).map(|f| TrackFrame::certain(vec![at(f)])).collect();
            motion.tracks.push(Track { name: point.name.clone(), kind: TrackKind::Point, frames });
        }
        motion.validate()?;
        Ok(motion)
    }
}

/// A path with its length, to be run along.
struct Run {
    start: Point,
    segments: Vec<(PathSeg, f64)>,
    length: f64,
    closed: bool,
    rhythm: Rhythm,
}

impl Run {
    fn new(point: &PointPath) -> Result<Self> {
        let what = || format!("the path of point `{}`", point.name);
        if point.name.trim().is_empty() {
            return Err(Error::invalid("a point", "has no name", "name each point"));
        }
        if !point.phase.is_finite() {
            return Err(Error::invalid(what(), "its phase is no number", "give 0 to 1"));
        }
        let path = BezPath::from_svg(&point.path)
            .map_err(|e| Error::invalid(what(), format!("is not readable: {e}"), "give SVG path data"))?;
        let moves = path.elements().iter().filter(|e| matches!(e, PathEl::MoveTo(_))).count();
        let start = match path.elements().first() {
            Some(PathEl::MoveTo(start)) if moves == 1 && path.is_finite() => *start,
            _ => return Err(Error::invalid(what(), "is not one line", "give one subpath, of real numbers")),
        };
        let segments: Vec<(PathSeg, f64)> = path.segments().map(|s| (s, s.arclen(ACCURACY))).collect();
        let length = segments.iter().map(|s| s.1).sum();
        let closed = matches!(path.elements().last(), Some(PathEl::ClosePath));
        Ok(Self { start, segments, length, closed, rhythm: point.rhythm })
    }

    /// The place after so many turns.
    fn at(&self, turns: f64) -> Vec2 {
        let turn = turns.rem_euclid(1.0);
        let share = match (self.closed, self.rhythm) {
            (true, _) => turn,
            (false, Rhythm::Swing) => 0.5 - 0.5 * (std::f64::consts::TAU * turn).cos(),
            (false, Rhythm::Even) => 1.0 - (1.0 - 2.0 * turn).abs(),
        };
        let mut left = share * self.length;
        let mut at = self.start;
        for (segment, length) in &self.segments {
            if left <= *length {
                at = segment.eval(segment.inv_arclen(left, ACCURACY));
                break;
            }
            left -= length;
            at = segment.end();
        }
        Vec2::new(at.x as f32, at.y as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(points: &str) -> String {
        format!(r#"{{"format":"marey-paths","version":1,"size":[100,80],"fps":10,"seconds":2,"points":[{points}]}}"#)
    }

    fn motion(points: &str) -> Result<Motion> {
        MotionPaths::from_json(&file(points))?.motion()
    }

    #[test]
    fn around_at_constant_speed_and_there_and_back() {
        let motion = motion(
            r#"{"name":"round","path":"M0 0 H40 V40 H0 Z"},
            {"name":"swing","path":"M10 10 L30 10","turns":2},{"name":"even","path":"M10 10 L30 10","phase":0.5,"rhythm":"even"},
            {"name":"still","path":"M7 8"}"#,
        );
        let motion = motion.expect("valid");
        let at = |track: usize, frame: usize| motion.tracks[track].frames[frame].points[0];
        assert_eq!(motion.frames, 20);
        // 160 pixels in 20 frames.
        for f in 0..20 {
            let step = at(0, f).distance(at(0, (f + 1) % 20));
            assert!((step - 8.0).abs() < 1e-2, "frame {f}: {step}");
        }
        assert!(at(1, 5).distance(Vec2::new(30.0, 10.0)) < 1e-2 && at(1, 10).distance(at(1, 0)) < 1e-2);
        assert!(at(1, 0).distance(at(1, 1)) < 0.5 * at(1, 2).distance(at(1, 3)));
        assert!(at(2, 0).distance(Vec2::new(30.0, 10.0)) < 1e-2 && (at(2, 5).x - 20.0).abs() < 1e-2);
        assert!((0..20).all(|f| at(3, f) == Vec2::new(7.0, 8.0)));
    }

    #[test]
    fn every_mistake_is_named() {
        let point = |path: &str| format!(r#"{{"name":"a","path":"{path}"}}"#);
        let cases = [
            (String::new(), "0 points"),
            (point(""), "not one line"),
            (point("hello"), "not readable"),
            (point("M0 0 L5 5 M9 9 L3 3"), "not one line"),
            (point("M0 0 L1e999 5"), "not one line"),
            (format!("{0},{0}", point("M0 0 L5 5")), "listed twice"),
            (point("M0 0 L5 5").replace(r#""a""#, r#"" ""#), "no name"),
        ];
        for (points, expected) in cases {
            let message = motion(&points).expect_err(expected).to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        }
        let text = file(&point("M0 0 L5 5"));
        for (from, to, expected) in [
            ("\"version\":1", "\"version\":9", "version 9"),
            ("\"fps\":10", "\"fps\":0", "0 frames a second"),
            ("\"seconds\":2", "\"seconds\":-2", "-2 seconds"),
            ("\"seconds\":2", "\"seconds\":1e9", "100000 frames"),
        ] {
            let made = MotionPaths::from_json(&text.replace(from, to)).and_then(|p| p.motion());
            let message = made.expect_err(expected).to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        }
    }
}
