//! A textured mesh on animated bones: what a creature hands to exporters and renderers.
//!
//! Linear blend skinning as glTF 2.0 defines it (section 3.7.3): a vertex is the weighted sum of its bind position
//! moved by `bone(frame) * bone(rest)^-1`. What is written, drawn and measured is this one model.

use glam::{Mat4, Quat, Vec3};
use image::RgbImage;

use crate::error::{Error, Result};
use crate::geometry::TriMesh;

/// A bone of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Bone {
    /// A name unique in the model: "hind_near.3".
    pub name: String,
    /// The parent's index, below this bone's own; `None` for a root.
    pub parent: Option<usize>,
}

/// A bone's place relative to its parent. There is no scale: limbs stretch by moving their bones apart, which keeps
/// shear out of every importer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Moved by, in world units.
    pub translation: Vec3,
    /// Turned by.
    pub rotation: Quat,
}

impl Transform {
    /// The transform as a matrix.
    pub fn matrix(&self) -> Mat4 {
        Mat4::from_rotation_translation(self.rotation, self.translation)
    }
}

/// A mesh bound to the bones, with its own texture.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinnedPart {
    /// The limb's label.
    pub name: String,
    /// The surface in the rest pose, in world coordinates.
    pub mesh: TriMesh,
    /// Up to four bones for each vertex; a bone with no weight is bone 0.
    pub bones: Vec<[u16; 4]>,
    /// Their weights, which sum to 1.
    pub weights: Vec<[f32; 4]>,
    /// The surface's colours, sRGB.
    pub texture: RgbImage,
}

impl SkinnedPart {
    fn validate(&self, bones: usize) -> Result<()> {
        let bad = |problem: &str| Err(Error::invalid(format!("part `{}`", self.name), problem, "build the model anew"));
        let n = self.mesh.positions.len();
        if [self.mesh.normals.len(), self.mesh.uvs.len(), self.bones.len(), self.weights.len()] != [n; 4] {
            return bad("its vertex lists differ in length");
        }
        if self.mesh.triangles.iter().flatten().any(|&v| v as usize >= n) {
            return bad("a triangle has a vertex that is not there");
        }
        let real = self.mesh.positions.iter().chain(&self.mesh.normals).all(|v| v.is_finite());
        if !real || !self.mesh.uvs.iter().all(|v| v.is_finite()) {
            return bad("a vertex holds something that is no number");
        }
        if self.bones.iter().flatten().any(|&b| usize::from(b) >= bones) {
            return bad("a vertex hangs on a bone that is not there");
        }
        if !self.weights.iter().all(|w| w.iter().all(|w| *w >= 0.0) && (w.iter().sum::<f32>() - 1.0).abs() < 1e-3) {
            return bad("a vertex has weights that do not add up to 1");
        }
        if self.texture.width() == 0 || self.texture.height() == 0 {
            return bad("its texture is empty");
        }
        Ok(())
    }
}

/// A whole animated model.
#[derive(Clone, Debug, PartialEq)]
pub struct RiggedModel {
    /// The clip's size in pixels, for putting the model back over it.
    pub size: (u32, u32),
    /// Frames a second.
    pub fps: f64,
    /// The hierarchy, parents before children.
    pub bones: Vec<Bone>,
    /// The rest pose: one local transform a bone.
    pub rest: Vec<Transform>,
    /// The animation: for each frame one local transform a bone.
    pub animation: Vec<Vec<Transform>>,
    /// The meshes.
    pub parts: Vec<SkinnedPart>,
}

impl RiggedModel {
    /// Checks what [`Self::pose`], exporters and renderers rely on: lists of one length, parents before children,
    /// indices that exist, real numbers, and something to see.
    pub fn validate(&self) -> Result<()> {
        let bad = |what: String, problem: &str| Err(Error::invalid(what, problem, "build the model anew"));
        let bones = self.bones.len();
        if bones == 0 || bones > usize::from(u16::MAX) {
            return bad("the model".into(), &format!("has {bones} bones"));
        }
        if self.bones.iter().enumerate().any(|(i, b)| b.parent.is_some_and(|p| p >= i)) {
            return bad("the model".into(), "lists a bone before its parent");
        }
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return bad("the model".into(), "has no frames a second");
        }
        for (frame, pose) in std::iter::once(&self.rest).chain(&self.animation).enumerate() {
            let what = || if frame == 0 { "the rest pose".to_owned() } else { format!("frame {}", frame - 1) };
            if pose.len() != bones {
                return bad(what(), &format!("moves {} of {bones} bones", pose.len()));
            }
            let real = |t: &Transform| t.translation.is_finite() && (t.rotation.length() - 1.0).abs() < 1e-3;
            if let Some(bone) = pose.iter().position(|t| !real(t)) {
                return bad(format!("bone `{}` in {}", self.bones[bone].name, what()), "is nowhere");
            }
        }
        for part in &self.parts {
            part.validate(bones)?;
        }
        if self.parts.iter().all(|p| p.mesh.triangles.is_empty()) {
            return bad("the model".into(), "has no surface");
        }
        Ok(())
    }

    /// World matrices of all bones for local transforms.
    pub fn world(&self, local: &[Transform]) -> Vec<Mat4> {
        let mut world: Vec<Mat4> = Vec::with_capacity(self.bones.len());
        for (bone, transform) in self.bones.iter().zip(local) {
            let matrix = transform.matrix();
            world.push(bone.parent.map_or(matrix, |p| world[p] * matrix));
        }
        world
    }

    /// The meshes of all parts in `frame`, in world coordinates.
    ///
    /// # Panics
    /// When the model has no such frame.
    pub fn pose(&self, frame: usize) -> Vec<TriMesh> {
        self.pose_at(&self.animation[frame])
    }

    /// The meshes of all parts with bones at `local`, one transform a bone, in world coordinates.
    pub fn pose_at(&self, local: &[Transform]) -> Vec<TriMesh> {
        let skin: Vec<Mat4> =
            self.world(local).into_iter().zip(self.world(&self.rest)).map(|(now, rest)| now * rest.inverse()).collect();
        self.parts
            .iter()
            .map(|part| {
                let mut mesh = part.mesh.clone();
                for v in 0..mesh.positions.len() {
                    let mut blend = Mat4::ZERO;
                    for (bone, weight) in part.bones[v].iter().zip(part.weights[v]) {
                        blend += skin[usize::from(*bone)] * weight;
                    }
                    mesh.positions[v] = blend.transform_point3(mesh.positions[v]);
                    mesh.normals[v] = blend.transform_vector3(mesh.normals[v]).normalize_or(Vec3::Z);
                }
                mesh
            })
            .collect()
    }
}
