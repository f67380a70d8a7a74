//! A rigged model made ready for drawing: checked, and with all that does not change from picture to picture.

use std::sync::{Arc, OnceLock};

use glam::{Mat4, Vec3};
use marey::job::Stage;
use marey::shape::{RiggedModel, SkinnedPart, Transform};
use marey::{Error, Result};
use rayon::prelude::*;

use crate::bone_shapes::Link;
use crate::shading::{limb_color, ramp};
use crate::texture::Texture;
use crate::{Extent, Style};

/// A rigged model ready for drawing. Clones are the same model; what a device holds of it goes with the last one.
#[derive(Clone, Debug)]
pub struct Model(pub(crate) Arc<Prepared>);

/// What clones of a model share.
#[derive(Debug)]
pub(crate) struct Prepared {
    pub(crate) rig: Arc<RiggedModel>,
    inverse_rest: Vec<Mat4>,
    /// One a part.
    pub(crate) textures: Vec<Texture>,
    /// The bones that are drawn.
    pub(crate) links: Vec<Link>,
    /// Which limb each bone belongs to.
    limbs: Vec<usize>,
    extent: OnceLock<Extent>,
    radius: OnceLock<Vec<Vec<[u8; 4]>>>,
    bones: OnceLock<Vec<Vec<[u8; 4]>>>,
}

impl Model {
    /// # Errors
    /// A model that is not valid, or has no frames.
    pub fn new(rig: impl Into<Arc<RiggedModel>>) -> Result<Self> {
        let rig = rig.into();
        rig.validate()?;
        if rig.animation.is_empty() {
            return Err(Error::invalid("the model", "has no frames", "give it at least one"));
        }
        let inverse_rest = rig.world(&rig.rest).iter().map(Mat4::inverse).collect();
        let textures = rig.parts.par_iter().map(|p| Texture::new(&p.texture)).collect();
        // Bones of a limb are named after it and numbered: "hind_near.3".
        let stem = |bone: usize| rig.bones[bone].name.rsplit_once('.').map_or("", |n| n.0);
        let mut names: Vec<&str> = Vec::new();
        let limbs: Vec<usize> = (0..rig.bones.len())
            .map(|bone| {
                names.iter().position(|n| *n == stem(bone)).unwrap_or_else(|| {
                    names.push(stem(bone));
                    names.len() - 1
                })
            })
            .collect();
        let link = |child: usize| {
            let parent = rig.bones[child].parent?;
            Some(Link { parent, child, limb: (limbs[parent] == limbs[child]).then_some(limbs[child]) })
        };
        let links = (0..rig.bones.len()).filter_map(link).collect();
        Ok(Self(Arc::new(Prepared {
            rig,
            inverse_rest,
            textures,
            links,
            limbs,
            extent: OnceLock::new(),
            radius: OnceLock::new(),
            bones: OnceLock::new(),
        })))
    }

    /// The model that it was made of.
    pub fn rig(&self) -> &Arc<RiggedModel> {
        &self.0.rig
    }

    /// How many frames there are.
    pub fn frames(&self) -> usize {
        self.0.rig.animation.len()
    }

    /// How far it reaches over all its frames. Measured once.
    ///
    /// # Errors
    /// A cancel.
    pub fn extent(&self, stage: Stage<'_>) -> Result<&Extent> {
        if let Some(extent) = self.0.extent.get() {
            return Ok(extent);
        }
        let frames: Vec<Extent> = (0..self.frames())
            .into_par_iter()
            .map(|frame| {
                stage.at(0.0)?;
                let skin = self.0.skin(&self.0.rig.animation[frame], &Mat4::IDENTITY);
                let part = |p: &SkinnedPart| {
                    Extent::of(
                        (0..p.mesh.positions.len()).map(|v| blend(p, v, &skin).transform_point3(p.mesh.positions[v])),
                    )
                };
                let parts: Vec<Extent> = self.0.rig.parts.iter().map(part).collect();
                Ok(Extent::join(&parts))
            })
            .collect::<Result<_>>()?;
        Ok(self.0.extent.get_or_init(|| Extent::join(&frames)))
    }
}

impl Prepared {
    /// For each bone what moves the surface from the rest pose to this one and then to `place`.
    pub(crate) fn skin(&self, pose: &[Transform], place: &Mat4) -> Vec<Mat4> {
        self.joints(pose, place).iter().zip(&self.inverse_rest).map(|(now, rest)| *now * *rest).collect()
    }

    /// Where the bones are.
    pub(crate) fn joints(&self, pose: &[Transform], place: &Mat4) -> Vec<Mat4> {
        self.rig.world(pose).iter().map(|now| *place * *now).collect()
    }

    /// The colours that a style gives the vertices of each part; nothing where it gives none.
    pub(crate) fn colors(&self, style: Style) -> Option<&[Vec<[u8; 4]>]> {
        match style {
            Style::Radius => Some(self.radius.get_or_init(|| self.radius_colors())),
            Style::Bones => Some(self.bones.get_or_init(|| self.bone_colors())),
            _ => None,
        }
    }

    /// By how far the rest pose's vertices are from the bones that move them, against the farthest.
    fn radius_colors(&self) -> Vec<Vec<[u8; 4]>> {
        let joints: Vec<Vec3> = self.rig.world(&self.rig.rest).iter().map(|m| m.transform_point3(Vec3::ZERO)).collect();
        let mut near: Vec<Vec<(Vec3, Vec3)>> = joints.iter().map(|at| vec![(*at, *at)]).collect();
        for link in self.links.iter().filter(|l| l.limb.is_some()) {
            let segment = (joints[link.parent], joints[link.child]);
            near[link.parent].push(segment);
            near[link.child].push(segment);
        }
        let radius = |part: &SkinnedPart, v: usize| {
            let moving = part.bones[v].iter().zip(part.weights[v]).filter(|(_, weight)| *weight > 0.0);
            let segments = moving.flat_map(|(bone, _)| &near[usize::from(*bone)]);
            segments.map(|s| distance(part.mesh.positions[v], *s)).fold(f32::INFINITY, f32::min)
        };
        let all: Vec<Vec<f32>> = self
            .rig
            .parts
            .par_iter()
            .map(|part| (0..part.mesh.positions.len()).map(|v| radius(part, v)).collect())
            .collect();
        let most = all.iter().flatten().copied().filter(|r| r.is_finite()).fold(1e-6, f32::max);
        all.iter().map(|part| part.iter().map(|r| bytes(ramp(r / most))).collect()).collect()
    }

    /// By limbs, mixed by the weights; along a limb every other bone is darker, so that bones can be told apart.
    fn bone_colors(&self) -> Vec<Vec<[u8; 4]>> {
        let mut depth = vec![0_usize; self.limbs.len()];
        for link in &self.links {
            depth[link.child] = if link.limb.is_some() { depth[link.parent] + 1 } else { 0 };
        }
        let of: Vec<Vec3> = self
            .limbs
            .iter()
            .zip(&depth)
            .map(|(limb, depth)| limb_color(*limb) * if depth % 2 == 0 { 1.0 } else { 0.72 })
            .collect();
        let vertex = |part: &SkinnedPart, v: usize| {
            let mixed = part.bones[v].iter().zip(part.weights[v]).map(|(bone, weight)| of[usize::from(*bone)] * weight);
            bytes(mixed.sum())
        };
        let part = |p: &SkinnedPart| (0..p.mesh.positions.len()).map(|v| vertex(p, v)).collect();
        self.rig.parts.par_iter().map(part).collect()
    }
}

/// What moves a vertex.
#[inline]
pub(crate) fn blend(part: &SkinnedPart, v: usize, skin: &[Mat4]) -> Mat4 {
    let mut sum = Mat4::ZERO;
    for (bone, weight) in part.bones[v].iter().zip(part.weights[v]) {
        if weight > 0.0 {
            sum += skin[usize::from(*bone)] * weight;
        }
    }
    sum
}

fn distance(p: Vec3, (a, b): (Vec3, Vec3)) -> f32 {
    let along = b - a;
    let share = (p - a).dot(along) / along.length_squared();
    p.distance(a + along * if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 })
}

fn bytes(color: Vec3) -> [u8; 4] {
    let [r, g, b] = color.to_array().map(|c| (c * 255.0 + 0.5) as u8);
    [r, g, b, 255]
}
