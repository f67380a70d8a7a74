//! motion.json: a motion as a file. Unknown keys are ignored, an unknown version is an error.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Motion, Track};
use crate::error::{Error, Result};

const FORMAT: &str = "marey-motion";
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
struct MotionFile {
    format: String,
    version: u32,
    size: (u32, u32),
    fps: f64,
    frames: usize,
    tracks: Vec<Track>,
    #[serde(default)]
    bones: Vec<(String, String)>,
}

impl Motion {
    /// Reads motion.json and checks it.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_json(&text).map_err(|e| e.in_file(path))
    }

    /// Parses and checks the text of a motion.json.
    pub fn from_json(text: &str) -> Result<Self> {
        let file: MotionFile = serde_json::from_str(text)
            .map_err(|e| Error::invalid("motion", format!("not readable: {e}"), "expected a marey-motion file"))?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(Error::invalid(
                "motion",
                format!("the file says {} version {}", file.format, file.version),
                format!("expected {FORMAT} version {VERSION}"),
            ));
        }
        let MotionFile { size, fps, frames, tracks, bones, .. } = file;
        let motion = Self { size, fps, frames, tracks, bones };
        motion.validate()?;
        Ok(motion)
    }

    /// The motion as the text of a motion.json.
    pub fn to_json(&self) -> String {
        let file = MotionFile {
            format: FORMAT.into(),
            version: VERSION,
            size: self.size,
            fps: self.fps,
            frames: self.frames,
            tracks: self.tracks.clone(),
            bones: self.bones.clone(),
        };
        serde_json::to_string(&file).unwrap_or_default()
    }

    /// Checks that every track has an entry for every frame, of one length, of real numbers.
    pub fn validate(&self) -> Result<()> {
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return Err(Error::invalid("motion", "fps is no positive number", "give frames a second"));
        }
        for (i, track) in self.tracks.iter().enumerate() {
            let what = |f: usize| format!("track `{}`, frame {f}", track.name);
            if self.tracks[..i].iter().any(|t| t.name == track.name) {
                return Err(Error::invalid(format!("track `{}`", track.name), "is listed twice", "rename one"));
            }
            if track.frames.len() != self.frames {
                return Err(Error::invalid(
                    format!("track `{}`", track.name),
                    format!("has {} frames", track.frames.len()),
                    format!("the motion has {}", self.frames),
                ));
            }
            for (f, frame) in track.frames.iter().enumerate() {
                let n = frame.points.len();
                if n == 0 || n != track.frames[0].points.len() {
                    return Err(Error::invalid(what(f), format!("has {n} points"), "keep one count, above 0"));
                }
                if frame.visible.len() != n || frame.confidence.len() != n {
                    return Err(Error::invalid(what(f), "its lists differ in length", "give one entry a point"));
                }
                if !frame.points.iter().all(|p| p.is_finite()) || !frame.confidence.iter().all(|c| c.is_finite()) {
                    return Err(Error::invalid(what(f), "holds something that is no number", "remove it"));
                }
            }
        }
        Ok(())
    }
}
