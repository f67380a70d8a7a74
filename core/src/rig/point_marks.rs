//! Control points that the user marked on key frames, and points.json, their file.
//!
//! `{"format":"marey-points","version":1,"size":[W,H],"points":[{"name":"nose","keys":[{"frame":0,"at":[x,y]}]}]}`. A point
//! is marked on one frame at least; more keys of it are corrections, in any order. Unknown keys of the file are ignored, an
//! unknown version is an error.

use std::collections::HashSet;
use std::path::Path;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

const FORMAT: &str = "marey-points";
const VERSION: u32 = 1;
/// With the points' number, a bound that keeps a hostile file from eating the machine.
const MAX_KEYS: usize = 100_000;

/// A point's place on one frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointKey {
    /// The frame, counted from 0.
    pub frame: usize,
    /// The place, in clip pixels.
    pub at: Vec2,
}

/// A point and where the user marked it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PointMark {
    /// Its name, unique.
    pub name: String,
    /// One key a frame at most, in the order they were made.
    pub keys: Vec<PointKey>,
}

impl PointMark {
    /// Where the point is marked on a frame.
    pub fn key(&self, frame: usize) -> Option<Vec2> {
        self.keys.iter().find(|k| k.frame == frame).map(|k| k.at)
    }
}

/// The user's whole input for tracking points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointMarks {
    /// Width and height of the clip that was marked.
    pub size: (u32, u32),
    /// The points.
    pub points: Vec<PointMark>,
}

#[derive(Serialize, Deserialize)]
struct PointsFile {
    format: String,
    version: u32,
    size: (u32, u32),
    points: Vec<PointMark>,
}

impl PointMarks {
    /// How many points there can be.
    pub const MOST: usize = 256;

    /// Reads points.json and validates it.
    ///
    /// # Errors
    /// The file cannot be read, is no points.json, or says something that no tracker can use.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_json(&text).map_err(|e| e.in_file(path))
    }

    /// Parses and validates the text of a points.json.
    ///
    /// # Errors
    /// It is no points.json, or says something that no tracker can use.
    pub fn from_json(text: &str) -> Result<Self> {
        let file: PointsFile = serde_json::from_str(text)
            .map_err(|e| Error::invalid("points", format!("not readable: {e}"), "expected a marey-points file"))?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(Error::invalid(
                "points",
                format!("the file says {} version {}", file.format, file.version),
                format!("expected {FORMAT} version {VERSION}"),
            ));
        }
        let marks = Self { size: file.size, points: file.points };
        marks.validate(None)?;
        Ok(marks)
    }

    /// The marks as the text of a points.json.
    pub fn to_json(&self) -> String {
        let file = PointsFile { format: FORMAT.into(), version: VERSION, size: self.size, points: self.points.clone() };
        serde_json::to_string(&file).unwrap_or_default()
    }

    /// The point called `name`.
    pub fn point(&self, name: &str) -> Option<&PointMark> {
        self.points.iter().find(|p| p.name == name)
    }

    /// Marks a point on a frame, in place of an earlier key there; a name that is new makes a new point.
    pub fn put(&mut self, name: &str, key: PointKey) {
        let point = match self.points.iter_mut().position(|p| p.name == name) {
            Some(i) => &mut self.points[i],
            None => {
                self.points.push(PointMark { name: name.to_owned(), keys: Vec::new() });
                let last = self.points.len() - 1;
                &mut self.points[last]
            }
        };
        match point.keys.iter_mut().find(|k| k.frame == key.frame) {
            Some(old) => *old = key,
            None => point.keys.push(key),
        }
    }

    /// Takes a key back; says whether there was one. A point without keys goes with its last.
    pub fn remove(&mut self, name: &str, frame: usize) -> bool {
        let Some(i) = self.points.iter().position(|p| p.name == name) else { return false };
        let before = self.points[i].keys.len();
        self.points[i].keys.retain(|k| k.frame != frame);
        let found = self.points[i].keys.len() < before;
        if self.points[i].keys.is_empty() {
            self.points.remove(i);
        }
        found
    }

    /// Checks everything that trackers rely on. `clip` is the clip's size and how many frames it has, when known.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self, clip: Option<((u32, u32), usize)>) -> Result<()> {
        if let Some((size, _)) = clip
            && size != self.size
        {
            return Err(Error::invalid(
                "points",
                format!("marked on {}x{}, but the clip is {}x{}", self.size.0, self.size.1, size.0, size.1),
                "scale the marks or use the clip they were made on",
            ));
        }
        self.validate_draft(clip.map(|(_, frames)| frames))?;
        if self.points.is_empty() {
            return Err(Error::invalid("points", "none is marked", "mark each point on one frame"));
        }
        Ok(())
    }

    /// Checks what holds of marks from the first one on, finished or not.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate_draft(&self, frames: Option<usize>) -> Result<()> {
        let keys = self.points.iter().map(|p| p.keys.len()).sum();
        let counts = [("points", self.points.len(), Self::MOST), ("keys", keys, MAX_KEYS)];
        if let Some((what, value, max)) = counts.into_iter().find(|(_, value, max)| value > max) {
            return Err(Error::Limit {
                what: format!("the number of {what}"),
                value: value as u64,
                max: max as u64,
                remedy: "one or two dozen points move most things".into(),
            });
        }
        if (self.size.0 == 0 || self.size.1 == 0) && !self.points.is_empty() {
            return Err(Error::invalid("points", "the size is empty", "give the clip's width and height"));
        }
        let mut names = HashSet::with_capacity(self.points.len());
        for (i, point) in self.points.iter().enumerate() {
            if point.name.trim().is_empty() {
                return Err(Error::invalid(format!("point {i}"), "has no name", "name each point"));
            }
            if !names.insert(point.name.as_str()) {
                let what = format!("point `{}`", point.name);
                return Err(Error::invalid(what, "is there twice", "give each point a name of its own"));
            }
            self.validate_keys(point, frames)?;
        }
        Ok(())
    }

    fn validate_keys(&self, point: &PointMark, frames: Option<usize>) -> Result<()> {
        if point.keys.is_empty() {
            let what = format!("point `{}`", point.name);
            return Err(Error::invalid(what, "is marked nowhere", "mark it on one frame, or remove it"));
        }
        let mut marked = HashSet::with_capacity(point.keys.len());
        for key in &point.keys {
            let what = || format!("point `{}`, frame {}", point.name, key.frame);
            if !marked.insert(key.frame) {
                return Err(Error::invalid(what(), "is marked twice", "keep one place for each point and frame"));
            }
            if !key.at.is_finite() {
                return Err(Error::invalid(what(), "its place holds something that is no number", "mark it again"));
            }
            let (width, height) = (self.size.0 as f32, self.size.1 as f32);
            if key.at.x < 0.0 || key.at.y < 0.0 || key.at.x > width || key.at.y > height {
                let problem = format!("{}, {} is outside the clip's {width} x {height} pixels", key.at.x, key.at.y);
                return Err(Error::invalid(what(), problem, "mark it where it is seen"));
            }
            if let Some(frames) = frames.filter(|&f| key.frame >= f) {
                let problem = format!("is past the clip's last frame {}", frames.saturating_sub(1));
                return Err(Error::invalid(what(), problem, "frames count from 0"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(points: &str) -> String {
        format!(r#"{{"format":"marey-points","version":1,"size":[100,80],"extra":1,"points":[{points}]}}"#)
    }

    const NOSE: &str = r#"{"name":"nose","keys":[{"frame":0,"at":[40,30]},{"frame":7,"at":[41.5,30]}]}"#;

    #[test]
    fn round_trip_keeps_everything() {
        let mut marks = PointMarks::from_json(&file(NOSE)).expect("valid");
        assert_eq!(marks.point("nose").and_then(|p| p.key(7)), Some(Vec2::new(41.5, 30.0)));
        assert_eq!(PointMarks::from_json(&marks.to_json()).expect("valid"), marks);
        marks.put("nose", PointKey { frame: 7, at: Vec2::ONE });
        marks.put("tail", PointKey { frame: 2, at: Vec2::ONE });
        assert_eq!((marks.points.len(), marks.points[0].keys.len()), (2, 2));
        assert!(marks.remove("tail", 2) && !marks.remove("tail", 2) && marks.points.len() == 1);
    }

    #[test]
    fn every_mistake_is_named() {
        let at = |at: &str| file(&format!(r#"{{"name":"nose","keys":[{{"frame":0,"at":{at}}}]}}"#));
        let many: Vec<String> =
            (0..300).map(|i| format!(r#"{{"name":"p{i}","keys":[{{"frame":0,"at":[1,1]}}]}}"#)).collect();
        let cases = [
            (file(""), "none is marked"),
            (at("[200,10]"), "outside"),
            (at("[-1,10]"), "outside"),
            (at("[1e39,30]"), "out of range"),
            (at("[40]"), "not readable"),
            (file(&format!("{NOSE},{NOSE}")), "there twice"),
            (file(r#"{"name":"nose","keys":[]}"#), "marked nowhere"),
            (file(r#"{"name":"n","keys":[{"frame":1,"at":[1,1]},{"frame":1,"at":[2,1]}]}"#), "marked twice"),
            (file(r#"{"name":" ","keys":[{"frame":0,"at":[1,1]}]}"#), "no name"),
            (file(&many.join(",")), "at most 256"),
            (file(NOSE).replace("\"version\":1", "\"version\":2"), "version 2"),
        ];
        for (text, expected) in cases {
            let message = PointMarks::from_json(&text).expect_err(expected).to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        }
        let marks = PointMarks::from_json(&file(NOSE)).expect("valid");
        let message = marks.validate(Some(((100, 80), 7))).expect_err("too late").to_string();
        assert!(message.contains("last frame 6"), "{message}");
    }
}
