//! A textured mesh on animated bones: what a creature hands to exporters and renderers.
//!
//! Linear blend skinning as glTF 2.0 defines it (section 3.7.3): a vertex is the weighted sum of its bind position
//! moved by `bone(frame) * bone(rest)^-1`. What is written, drawn and measured is this one model.

use glam::{Mat4, Quat, Vec3};
use image::RgbImage;

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
        let skin: Vec<Mat4> = self
            .world(&self.animation[frame])
            .into_iter()
            .zip(self.world(&self.rest))
            .map(|(now, rest)| now * rest.inverse())
            .collect();
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
