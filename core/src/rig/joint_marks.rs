//! Joints that the user marked as small rectangles, the bones between them, and joints.json, their file.
//!
//! `{"format":"marey-joints","version":1,"size":[W,H],"joints":[{"name","frame","rect":[x,y,w,h]}],
//! "bones":[["hip","knee"]]}`. On one frame every joint is marked; more marks of the same joints on other frames are
//! corrections. The order of the marks is kept: it is the order in which they were made. Unknown keys are ignored, an
//! unknown version is an error.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

const FORMAT: &str = "marey-joints";
const VERSION: u32 = 1;
/// Bounds that keep a hostile file from eating the machine.
const MAX_JOINTS: usize = 256;
const MAX_MARKS: usize = 100_000;

/// One joint marked on one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointMark {
    /// The joint's name.
    pub name: String,
    /// The frame, counted from 0.
    pub frame: usize,
    /// Left, top, width and height in clip pixels; the joint is at its centre.
    pub rect: [f32; 4],
}

impl JointMark {
    /// Where the joint is.
    pub fn centre(&self) -> Vec2 {
        let [x, y, w, h] = self.rect;
        Vec2::new(x + 0.5 * w, y + 0.5 * h)
    }
}

/// The user's whole input for capturing joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointMarks {
    /// Width and height of the clip that was marked.
    pub size: (u32, u32),
    /// The marks in the order they were made.
    pub marks: Vec<JointMark>,
    /// Pairs of joint names, from parent to child: a tree, or several.
    pub bones: Vec<(String, String)>,
}

#[derive(Serialize, Deserialize)]
struct JointsFile {
    format: String,
    version: u32,
    size: (u32, u32),
    joints: Vec<JointMark>,
    #[serde(default)]
    bones: Vec<(String, String)>,
}

impl JointMarks {
    /// Reads joints.json and validates it.
    ///
    /// # Errors
    /// The file cannot be read, is no joints.json, or says something that no tracker can use.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_json(&text).map_err(|e| e.in_file(path))
    }

    /// Parses and validates the text of a joints.json.
    ///
    /// # Errors
    /// It is no joints.json, or says something that no tracker can use.
    pub fn from_json(text: &str) -> Result<Self> {
        let file: JointsFile = serde_json::from_str(text)
            .map_err(|e| Error::invalid("joints", format!("not readable: {e}"), "expected a marey-joints file"))?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(Error::invalid(
                "joints",
                format!("the file says {} version {}", file.format, file.version),
                format!("expected {FORMAT} version {VERSION}"),
            ));
        }
        let marks = Self { size: file.size, marks: file.joints, bones: file.bones };
        marks.validate(None)?;
        Ok(marks)
    }

    /// The marks as the text of a joints.json.
    pub fn to_json(&self) -> String {
        let file = JointsFile {
            format: FORMAT.into(),
            version: VERSION,
            size: self.size,
            joints: self.marks.clone(),
            bones: self.bones.clone(),
        };
        serde_json::to_string(&file).unwrap_or_default()
    }

    /// The joints' names, in the order they were first marked.
    pub fn names(&self) -> Vec<&str> {
        let mut seen = HashSet::new();
        self.marks.iter().map(|m| m.name.as_str()).filter(|name| seen.insert(*name)).collect()
    }

    /// The frames that have marks, in the order they were first marked.
    pub fn frames(&self) -> Vec<usize> {
        let mut seen = HashSet::new();
        self.marks.iter().map(|m| m.frame).filter(|frame| seen.insert(*frame)).collect()
    }

    /// The mark of a joint on a frame.
    pub fn mark(&self, name: &str, frame: usize) -> Option<&JointMark> {
        self.marks.iter().find(|m| m.frame == frame && m.name == name)
    }

    /// Marks a joint on a frame, in place of an earlier mark there.
    pub fn put(&mut self, mark: JointMark) {
        match self.marks.iter_mut().find(|m| m.frame == mark.frame && m.name == mark.name) {
            Some(old) => *old = mark,
            None => self.marks.push(mark),
        }
    }

    /// Takes a mark back; says whether there was one.
    pub fn remove(&mut self, name: &str, frame: usize) -> bool {
        let before = self.marks.len();
        self.marks.retain(|m| m.frame != frame || m.name != name);
        self.marks.len() < before
    }

    /// The first marked frame on which every joint is marked: what the joints look like is learned there.
    pub fn whole_frame(&self) -> Option<usize> {
        let joints = self.names().len();
        let mut counts: HashMap<usize, usize> = HashMap::new();
        self.marks.iter().for_each(|m| *counts.entry(m.frame).or_default() += 1);
        self.frames().into_iter().find(|f| counts[f] == joints)
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
                "joints",
                format!("marked on {}x{}, but the clip is {}x{}", self.size.0, self.size.1, size.0, size.1),
                "scale the marks or use the clip they were made on",
            ));
        }
        self.validate_draft(clip.map(|(_, frames)| frames))?;
        if self.marks.is_empty() {
            return Err(Error::invalid("joints", "none is marked", "mark each joint on one frame"));
        }
        if self.whole_frame().is_none() {
            return Err(self.unmarked());
        }
        Ok(())
    }

    /// Checks what holds of marks from the first one on, finished or not.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate_draft(&self, frames: Option<usize>) -> Result<()> {
        let names: HashSet<&str> = self.marks.iter().map(|m| m.name.as_str()).collect();
        let counts = [
            ("joints", names.len(), MAX_JOINTS),
            ("marks", self.marks.len(), MAX_MARKS),
            ("bones", self.bones.len(), MAX_JOINTS),
        ];
        if let Some((what, value, max)) = counts.into_iter().find(|(_, value, max)| value > max) {
            return Err(Error::Limit {
                what: format!("the number of {what}"),
                value: value as u64,
                max: max as u64,
                remedy: "mark what bends, on the frames that need it".into(),
            });
        }
        if (self.size.0 == 0 || self.size.1 == 0) && !self.marks.is_empty() {
            return Err(Error::invalid("joints", "the size is empty", "give the clip's width and height"));
        }
        let mut marked = HashSet::with_capacity(self.marks.len());
        for mark in &self.marks {
            self.validate_mark(mark, frames)?;
            if !marked.insert((mark.frame, mark.name.as_str())) {
                let what = format!("joint `{}`, frame {}", mark.name, mark.frame);
                return Err(Error::invalid(what, "is marked twice", "keep one rectangle for each joint and frame"));
            }
        }
        self.validate_bones(&names)
    }

    fn validate_mark(&self, mark: &JointMark, frames: Option<usize>) -> Result<()> {
        if mark.name.trim().is_empty() {
            return Err(Error::invalid(format!("a joint on frame {}", mark.frame), "has no name", "name each joint"));
        }
        let what = || format!("joint `{}`, frame {}", mark.name, mark.frame);
        let [x, y, w, h] = mark.rect;
        if !mark.rect.iter().all(|v| v.is_finite()) {
            return Err(Error::invalid(what(), "its rectangle holds something that is no number", "mark it again"));
        }
        if w <= 0.0 || h <= 0.0 {
            return Err(Error::invalid(what(), format!("its rectangle is {w} x {h}"), "draw it around the joint"));
        }
        let (width, height) = (self.size.0 as f32, self.size.1 as f32);
        let centre = mark.centre();
        if x > width || y > height || x + w < 0.0 || y + h < 0.0 || !(centre.x.is_finite() && centre.y.is_finite()) {
            let problem = format!("its rectangle is outside the clip's {width} x {height} pixels");
            return Err(Error::invalid(what(), problem, "mark it where it is seen"));
        }
        if w > width || h > height {
            let problem = format!("its rectangle of {w} x {h} is larger than the clip");
            return Err(Error::invalid(what(), problem, "draw it small, around the joint"));
        }
        match frames {
            Some(frames) if mark.frame >= frames => {
                let problem = format!("is past the clip's last frame {}", frames.saturating_sub(1));
                Err(Error::invalid(what(), problem, "frames count from 0"))
            }
            _ => Ok(()),
        }
    }

    fn validate_bones(&self, names: &HashSet<&str>) -> Result<()> {
        // Joints that hang together, each by another of them; a bone within one such set closes a circle.
        let mut hangs: HashMap<&str, &str> = HashMap::new();
        for (parent, child) in &self.bones {
            let what = || format!("bone from `{parent}` to `{child}`");
            if let Some(missing) = [parent, child].into_iter().find(|n| !names.contains(n.as_str())) {
                let problem = format!("no joint is called `{missing}`");
                return Err(Error::invalid(what(), problem, "mark that joint, or remove the bone"));
            }
            if top(&hangs, parent) == top(&hangs, child) {
                return Err(Error::invalid(what(), "closes a circle", "bones make a tree: remove one of the circle"));
            }
            if hangs.insert(child, parent).is_some() {
                let problem = format!("`{child}` hangs on another joint already");
                return Err(Error::invalid(what(), problem, "give each joint one parent"));
            }
        }
        Ok(())
    }

    /// The error of marks that are on no frame all of them.
    fn unmarked(&self) -> Error {
        let names = self.names();
        let on = |frame: usize| names.iter().filter(|n| self.mark(n, frame).is_some()).count();
        let fullest = self.frames().into_iter().rev().max_by_key(|&f| on(f)).unwrap_or(0);
        let missing = names.iter().find(|n| self.mark(n, fullest).is_none()).copied().unwrap_or_default();
        let remedy = format!("mark all joints on one frame: `{missing}` is missing on frame {fullest}");
        Error::invalid(format!("joint `{missing}`"), format!("is not marked on frame {fullest}"), remedy)
    }
}

/// The joint that hangs on none, on which `joint` hangs by way of others.
fn top<'a>(hangs: &HashMap<&'a str, &'a str>, mut joint: &'a str) -> &'a str {
    while let Some(by) = hangs.get(joint) {
        joint = by;
    }
    joint
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(joints: &str, bones: &str) -> String {
        format!(
            r#"{{"format":"marey-joints","version":1,"size":[100,80],"extra":1,"joints":[{joints}],"bones":[{bones}]}}"#
        )
    }

    const HIP: &str = r#"{"name":"hip","frame":0,"rect":[40,30,8,8]}"#;
    const KNEE: &str = r#"{"name":"knee","frame":0,"rect":[40,50,8,8]}"#;

    #[test]
    fn round_trip_keeps_everything_and_its_order() {
        let text = file(&format!(r#"{HIP},{KNEE},{{"name":"hip","frame":7,"rect":[1.5,2,3,4]}}"#), r#"["hip","knee"]"#);
        let marks = JointMarks::from_json(&text).expect("valid");
        assert_eq!((marks.names(), marks.frames(), marks.whole_frame()), (vec!["hip", "knee"], vec![0, 7], Some(0)));
        assert_eq!(marks.marks[2].centre(), Vec2::new(3.0, 4.0));
        assert_eq!(JointMarks::from_json(&marks.to_json()).expect("valid"), marks);
    }

    #[test]
    fn every_mistake_is_named() {
        let rect = |rect: &str| file(&format!(r#"{{"name":"hip","frame":0,"rect":{rect}}}"#), "");
        let both = format!("{HIP},{KNEE}");
        let many: Vec<String> = (0..300).map(|i| format!(r#"{{"name":"j{i}","frame":0,"rect":[1,1,2,2]}}"#)).collect();
        let cases = [
            (file("", ""), "none is marked"),
            (rect("[200,10,8,8]"), "outside"),
            (rect("[40,30,0,8]"), "0 x 8"),
            (rect("[40,30,-4,8]"), "-4 x 8"),
            (rect("[40,30,500,8]"), "larger than the clip"),
            (rect("[NaN,30,8,8]"), "not readable"),
            (rect("[1e39,30,8,8]"), "out of range"),
            (rect("[40,30,8]"), "not readable"),
            (file(&format!("{HIP},{HIP}"), ""), "marked twice"),
            (file(&format!(r#"{HIP},{{"name":"knee","frame":3,"rect":[1,1,2,2]}}"#), ""), "not marked on frame"),
            (file(HIP, r#"["hip","knee"]"#), "`knee`"),
            (file(HIP, r#"["hip","hip"]"#), "circle"),
            (file(&both, r#"["hip","knee"],["knee","hip"]"#), "circle"),
            (
                file(
                    &format!(r#"{both},{{"name":"toe","frame":0,"rect":[1,1,2,2]}}"#),
                    r#"["hip","toe"],["knee","toe"]"#,
                ),
                "one parent",
            ),
            (file(r#"{"name":" ","frame":0,"rect":[1,1,2,2]}"#, ""), "no name"),
            (file(&many.join(","), ""), "at most 256"),
            (file(HIP, "").replace("\"version\":1", "\"version\":2"), "version 2"),
        ];
        for (text, expected) in cases {
            let message = JointMarks::from_json(&text).expect_err(expected).to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        }
    }
}
