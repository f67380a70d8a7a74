//! Key poses of a character, and poses.json.
//!
//! `{"format": "marey-poses", "version": 1, "fps": 24, "step": 1, "keys": [{"frame": 0, "joints": {"hip": [x, y], ...},
//! "easing": "linear" | "in" | "out" | "inout" | "hold", "moved": [[vertex, dx, dy], ...], "depth": [["hip-knee", 1], ...]}]}`.
//! Joints that a key does not name hang from their bone as they do at rest. Unknown keys are ignored, an unknown version
//! is an error.

use std::collections::BTreeMap;
use std::path::Path;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::{Character, Skeleton};
use crate::error::{Error, Result};
pub use crate::motion::Easing;

const FORMAT: &str = "marey-poses";
const VERSION: u32 = 1;

/// A key pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeyPose {
    /// Its frame.
    pub frame: usize,
    /// Where each joint is, in the skeleton's order.
    pub joints: Vec<Vec2>,
    /// How the way to the next key is spread.
    pub easing: Easing,
    /// Vertices dragged by hand: how far from where the deformation puts them.
    pub moved: Vec<(u32, Vec2)>,
    /// Bones whose regions lie at another depth than 0; larger is nearer to the viewer.
    pub depth: Vec<(u32, i32)>,
}

/// Key poses over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Poses {
    /// Frames a second.
    pub fps: f64,
    /// Every pose stays for so many frames: 2 for animation "on twos".
    pub step: usize,
    /// The keys, by rising frames.
    pub keys: Vec<KeyPose>,
}

#[derive(Serialize, Deserialize)]
struct PosesFile {
    format: String,
    version: u32,
    #[serde(default = "usual_rate")]
    fps: f64,
    #[serde(default = "one")]
    step: usize,
    keys: Vec<KeyEntry>,
}

#[derive(Serialize, Deserialize)]
struct KeyEntry {
    frame: usize,
    #[serde(default)]
    joints: BTreeMap<String, Vec2>,
    #[serde(default)]
    easing: Easing,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    moved: Vec<(u32, f32, f32)>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    depth: Vec<(String, i32)>,
}

/// Film.
fn usual_rate() -> f64 {
    24.0
}

fn one() -> usize {
    1
}

fn bone_name(skeleton: &Skeleton, bone: usize) -> String {
    let [a, b] = skeleton.bones[bone].map(|j| skeleton.joints[j].name.as_str());
    format!("{a}-{b}")
}

impl Poses {
    /// Checks them against a character.
    ///
    /// # Errors
    /// No keys, frames that do not rise, a step of 0, a rate that is not a number, places that are not numbers, and
    /// joints, vertices and bones that are not there.
    pub fn checked(self, character: &Character) -> Result<Self> {
        let bad = |what: String, problem: &str, remedy: &str| Err(Error::invalid(what, problem, remedy));
        if self.keys.is_empty() {
            return bad("poses".into(), "have no keys", "add a key pose");
        }
        if self.step == 0 || !(self.fps > 0.0 && self.fps.is_finite()) {
            return bad("poses".into(), "have a step or a rate of 0", "give at least 1");
        }
        for (i, key) in self.keys.iter().enumerate() {
            let what = || format!("key pose of frame {}", key.frame);
            if i > 0 && self.keys[i - 1].frame >= key.frame {
                return bad(what(), "does not come after the one before", "sort the keys by frame");
            }
            if key.joints.len() != character.skeleton.joints.len() {
                return bad(what(), "has another number of joints than the skeleton", "give each joint a place");
            }
            if key.joints.iter().chain(key.moved.iter().map(|m| &m.1)).any(|p| !p.is_finite()) {
                return bad(what(), "has a place that is not a number", "give finite places");
            }
            if key.moved.iter().any(|m| m.0 as usize >= character.mesh.points.len()) {
                return bad(what(), "moves a vertex that is not there", "check the vertices");
            }
            if key.depth.iter().any(|d| d.0 as usize >= character.skeleton.bones.len()) {
                return bad(what(), "orders a bone that is not there", "check the bones");
            }
        }
        Ok(self)
    }

    /// Reads poses.json for a character.
    ///
    /// # Errors
    /// A file that cannot be read or holds no poses, and what [`Self::checked`] refuses.
    pub fn read(path: impl AsRef<Path>, character: &Character) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_json(&text, character).map_err(|e| e.in_file(path))
    }

    /// Reads the text of a poses.json for a character.
    ///
    /// # Errors
    /// As for [`Self::read`].
    pub fn from_json(text: &str, character: &Character) -> Result<Self> {
        let bad = |problem: String| Error::invalid("poses", problem, "expected a marey-poses file");
        let file: PosesFile = serde_json::from_str(text).map_err(|e| bad(format!("are not readable: {e}")))?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(bad(format!(
                "say {} version {}, and {FORMAT} version {VERSION} is known",
                file.format, file.version
            )));
        }
        let skeleton = &character.skeleton;
        let key = |entry: KeyEntry| -> Result<KeyPose> {
            let mut named = vec![None; skeleton.joints.len()];
            for (name, at) in entry.joints {
                let Some(joint) = skeleton.joint(&name) else {
                    let what = format!("key pose of frame {}", entry.frame);
                    return Err(Error::invalid(
                        what,
                        format!("names joint `{name}`, which is not there"),
                        "check the rig",
                    ));
                };
                named[joint] = Some(at);
            }
            let depth = entry.depth.into_iter().map(|(name, depth)| {
                let bone = (0..skeleton.bones.len()).find(|&b| bone_name(skeleton, b) == name);
                bone.map(|b| (b as u32, depth)).ok_or_else(|| {
                    let what = format!("key pose of frame {}", entry.frame);
                    Error::invalid(what, format!("orders bone `{name}`, which is not there"), "check the rig")
                })
            });
            Ok(KeyPose {
                frame: entry.frame,
                joints: skeleton.hung(&named),
                easing: entry.easing,
                moved: entry.moved.into_iter().map(|(v, x, y)| (v, Vec2::new(x, y))).collect(),
                depth: depth.collect::<Result<_>>()?,
            })
        };
        let keys = file.keys.into_iter().map(key).collect::<Result<_>>()?;
        Self { fps: file.fps, step: file.step, keys }.checked(character)
    }

    /// The text of poses.json.
    pub fn to_json(&self, character: &Character) -> String {
        let skeleton = &character.skeleton;
        let entry = |key: &KeyPose| KeyEntry {
            frame: key.frame,
            joints: skeleton.joints.iter().zip(&key.joints).map(|(j, at)| (j.name.clone(), *at)).collect(),
            easing: key.easing,
            moved: key.moved.iter().map(|&(v, way)| (v, way.x, way.y)).collect(),
            depth: key.depth.iter().map(|&(b, depth)| (bone_name(skeleton, b as usize), depth)).collect(),
        };
        let keys = self.keys.iter().map(entry).collect();
        let file = PosesFile { format: FORMAT.into(), version: VERSION, fps: self.fps, step: self.step, keys };
        serde_json::to_string(&file).unwrap_or_default()
    }

    /// The keys around `frame` and the share of the way between them: the first of `(i, i + 1, share)`, held "on twos"
    /// and eased. Before the first key and after the last it is theirs.
    pub(super) fn between(&self, frame: usize) -> (usize, usize, f64) {
        let after = self.keys.partition_point(|k| k.frame <= frame);
        let Some(i) = after.checked_sub(1) else { return (0, 0, 0.0) };
        if after == self.keys.len() {
            return (i, i, 0.0);
        }
        let (from, to) = (self.keys[i].frame, self.keys[after].frame);
        let passed = (frame - from) / self.step * self.step;
        (i, after, self.keys[i].easing.share(passed as f64 / (to - from) as f64))
    }
}

impl Skeleton {
    /// Places of all joints: those given, and the others as they hang at rest from the joint before them.
    pub fn hung(&self, given: &[Option<Vec2>]) -> Vec<Vec2> {
        let given = |j: usize| given.get(j).copied().flatten();
        let mut at: Vec<Vec2> = (0..self.joints.len()).map(|j| given(j).unwrap_or(self.joints[j].at)).collect();
        for &[from, to] in &self.bones {
            if given(to).is_none() {
                at[to] = at[from] + (self.joints[to].at - self.joints[from].at);
            }
        }
        at
    }
}
