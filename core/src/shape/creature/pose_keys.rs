//! Key poses of a creature: limbs drawn on the frames that matter.
//!
//! The file is a strokes.json ([`crate::rig`]): each of its key frames is a key pose. Beyond what a rig has it may say
//! `"fps"` and `"step"`, and a key frame `"easing": "linear" | "in" | "out" | "inout" | "hold"` for the way to the next
//! one. Unknown keys are ignored, an unknown version is an error.

use std::path::Path;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::LimbPose;
use crate::error::{Error, Result};
use crate::rig::{Facing, Rig};
use crate::shape::character::Easing;

const FORMAT: &str = "marey-strokes";
const VERSION: u32 = 1;

/// Key poses over time.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseKeys {
    /// Width and height of the picture that was drawn on.
    pub size: (u32, u32),
    /// Frames a second; the creature's own where it is not said.
    pub fps: Option<f64>,
    /// Every pose stays for so many frames: 2 for animation "on twos".
    pub step: usize,
    /// The keys by rising frames, at least one.
    pub keys: Vec<PoseKey>,
}

/// A key pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseKey {
    /// Its frame, counted from 0.
    pub frame: usize,
    /// How the way from here to a limb's next key is spread.
    pub easing: Easing,
    /// The limbs that are drawn, at most once each.
    pub limbs: Vec<LimbPose>,
}

#[derive(Serialize, Deserialize)]
struct File {
    format: String,
    version: u32,
    size: (u32, u32),
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fps: Option<f64>,
    #[serde(default = "one", skip_serializing_if = "is_one")]
    step: usize,
    #[serde(default)]
    limbs: Vec<Label>,
    keyframes: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
struct Label {
    label: String,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    frame: usize,
    #[serde(default, skip_serializing_if = "is_linear")]
    easing: Easing,
    #[serde(default)]
    strokes: Vec<Drawn>,
}

#[derive(Serialize, Deserialize)]
struct Drawn {
    limb: String,
    #[serde(default)]
    points: Vec<Vec2>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    facing: Option<Facing>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    depth: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bend: Option<f32>,
}

fn one() -> usize {
    1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_one(step: &usize) -> bool {
    *step == 1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_linear(easing: &Easing) -> bool {
    *easing == Easing::Linear
}

impl From<&Rig> for PoseKeys {
    /// Every key frame with a stroke as a key pose.
    fn from(rig: &Rig) -> Self {
        let pose = |key: &crate::rig::KeyFrame, stroke: &crate::rig::Stroke| {
            let mark = key.depths.iter().find(|d| d.limb == stroke.limb);
            LimbPose {
                limb: rig.limbs.get(stroke.limb).map_or_else(String::new, |l| l.label.clone()),
                points: stroke.points.clone(),
                facing: stroke.facing,
                bend: mark.and_then(|d| d.bend),
                depth: mark.and_then(|d| d.depth).unwrap_or(0.0),
            }
        };
        let drawn = rig.keyframes.iter().filter(|k| !k.strokes.is_empty());
        let key = |k: &crate::rig::KeyFrame| PoseKey {
            frame: k.frame,
            easing: Easing::Linear,
            limbs: k.strokes.iter().map(|s| pose(k, s)).collect(),
        };
        Self { size: rig.size, fps: None, step: 1, keys: drawn.map(key).collect() }
    }
}

impl PoseKeys {
    /// Reads a file of key poses.
    ///
    /// # Errors
    /// A file that cannot be read, and what [`Self::from_json`] refuses.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_json(&text).map_err(|e| e.in_file(path))
    }

    /// Parses and checks the text of a file of key poses. Strokes without points pose nothing.
    ///
    /// # Errors
    /// Text that is no strokes.json, and what [`Self::validate`] refuses.
    pub fn from_json(text: &str) -> Result<Self> {
        let bad = |problem: String| Error::invalid("key poses", problem, "expected a marey-strokes file");
        let file: File = serde_json::from_str(text).map_err(|e| bad(format!("are not readable: {e}")))?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(bad(format!(
                "say {} version {}, and {FORMAT} version {VERSION} is known",
                file.format, file.version
            )));
        }
        let pose = |s: Drawn| LimbPose {
            limb: s.limb,
            points: s.points,
            facing: s.facing,
            bend: s.bend,
            depth: s.depth.unwrap_or(0.0),
        };
        let key = |k: Entry| PoseKey {
            frame: k.frame,
            easing: k.easing,
            limbs: k.strokes.into_iter().filter(|s| !s.points.is_empty()).map(pose).collect(),
        };
        let mut keys: Vec<PoseKey> = file.keyframes.into_iter().map(key).filter(|k| !k.limbs.is_empty()).collect();
        keys.sort_by_key(|k| k.frame);
        let keys = Self { size: file.size, fps: file.fps, step: file.step, keys };
        keys.validate()?;
        Ok(keys)
    }

    /// The text of the file, which is a strokes.json too.
    pub fn to_json(&self) -> String {
        let mut limbs: Vec<Label> = Vec::new();
        for pose in self.keys.iter().flat_map(|k| &k.limbs) {
            if !limbs.iter().any(|l| l.label == pose.limb) {
                limbs.push(Label { label: pose.limb.clone() });
            }
        }
        let drawn = |p: &LimbPose| Drawn {
            limb: p.limb.clone(),
            points: p.points.clone(),
            facing: p.facing,
            depth: (p.depth != 0.0).then_some(p.depth),
            bend: p.bend,
        };
        let entry =
            |k: &PoseKey| Entry { frame: k.frame, easing: k.easing, strokes: k.limbs.iter().map(drawn).collect() };
        let file = File {
            format: FORMAT.into(),
            version: VERSION,
            size: self.size,
            fps: self.fps,
            step: self.step,
            limbs,
            keyframes: self.keys.iter().map(entry).collect(),
        };
        serde_json::to_string(&file).unwrap_or_default()
    }

    /// Checks what no creature is needed for: that there are keys, one a frame in order, and a sound rate.
    pub fn validate(&self) -> Result<()> {
        let bad = |what: String, problem: &str, remedy: &str| Err(Error::invalid(what, problem, remedy));
        let all = || "key poses".to_owned();
        if self.keys.is_empty() {
            return bad(all(), "draw no limb", "draw at least one limb on a key frame");
        }
        if self.fps.is_some_and(|fps| !(fps > 0.0 && fps <= 1000.0)) {
            return bad(all(), "have a frame rate that is none", "give frames a second, up to 1000");
        }
        if self.step == 0 {
            return bad(all(), "hold every pose for no frame", "give a step of at least 1");
        }
        if let Some(pair) = self.keys.windows(2).find(|k| k[0].frame >= k[1].frame) {
            let what = format!("the key pose of frame {}", pair[1].frame);
            return bad(what, "is listed twice or out of order", "list each frame once");
        }
        Ok(())
    }
}
