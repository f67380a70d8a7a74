//! rig.json: a character as a file, beside its picture.
//!
//! `{"format": "marey-rig", "version": 1, "size": [w, h], "mesh": {"points": [[x, y], ...], "triangles": [[a, b, c], ...]},
//! "joints": [{"name": "hip", "at": [x, y]}, ...], "bones": [["hip", "knee"], ...], "curve": [[[x, y], ...], ...]}`, in
//! pixels of the picture. Unknown keys are ignored, an unknown version is an error. Regions are grown anew.

use std::path::Path;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::{Character, Joint, Skeleton};
use crate::error::{Error, Result};
use crate::geometry::PlaneMesh;

const FORMAT: &str = "marey-rig";
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
struct RigFile {
    format: String,
    version: u32,
    size: (u32, u32),
    mesh: PlaneMesh,
    joints: Vec<Joint>,
    bones: Vec<(String, String)>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    curve: Vec<Vec<Vec2>>,
}

impl Character {
    /// Reads rig.json.
    ///
    /// # Errors
    /// A file that cannot be read or is not a rig, and what [`Character::new`] refuses.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_json(&text).map_err(|e| e.in_file(path))
    }

    /// Reads the text of a rig.json.
    ///
    /// # Errors
    /// As for [`Self::read`].
    pub fn from_json(text: &str) -> Result<Self> {
        #[derive(Deserialize)]
        struct Head {
            #[serde(default)]
            format: String,
            #[serde(default)]
            version: u32,
        }
        let bad = |problem: String| Error::invalid("rig", problem, "write it with `marey rig`");
        let head: Head = serde_json::from_str(text).map_err(|e| bad(format!("is not readable: {e}")))?;
        if head.format != FORMAT {
            return Err(bad(format!("says its format is `{}` and not `{FORMAT}`", head.format)));
        }
        if head.version != VERSION {
            return Err(bad(format!("is of version {}, and only {VERSION} is known", head.version)));
        }
        let file: RigFile = serde_json::from_str(text).map_err(|e| bad(format!("is not readable: {e}")))?;
        let mut skeleton = Skeleton { joints: file.joints, bones: Vec::new() };
        for (from, to) in &file.bones {
            let find = |name: &String| {
                skeleton.joint(name).ok_or_else(|| {
                    Error::invalid(
                        format!("bone `{from}`-`{to}`"),
                        format!("no joint is called `{name}`"),
                        "add the joint",
                    )
                })
            };
            let bone = [find(from)?, find(to)?];
            skeleton.bones.push(bone);
        }
        if file.curve.iter().flatten().any(|p| !p.is_finite()) {
            return Err(bad("its curve has a place that is not a number".into()));
        }
        let own = Self::new(file.size, file.mesh, skeleton)?;
        Ok(Self { curve: file.curve, ..own })
    }

    /// The text of rig.json.
    pub fn to_json(&self) -> String {
        let name = |j: usize| self.skeleton.joints[j].name.clone();
        let file = RigFile {
            format: FORMAT.into(),
            version: VERSION,
            size: self.size,
            mesh: self.mesh.clone(),
            joints: self.skeleton.joints.clone(),
            bones: self.skeleton.bones.iter().map(|&[a, b]| (name(a), name(b))).collect(),
            curve: self.curve.clone(),
        };
        serde_json::to_string(&file).unwrap_or_default()
    }
}
