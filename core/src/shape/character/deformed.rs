//! A take by any deformer: bones are its handles, and every frame starts from the shape of the one before.
//!
//! Known limits: vertices that a key pose drags by hand fade evenly from key to key.

use glam::Vec2;

use super::in_between::handles;
use super::take::room;
use super::{Animation, Character, Take, TakeFrame};
use crate::deform::{Deformer, RestMesh};
use crate::error::{Error, Result};
use crate::job::Stage;

/// A frame before its mesh is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Posture {
    /// Where each joint is, in the skeleton's order.
    pub joints: Vec<Vec2>,
    /// How near each bone's region is, as in [`TakeFrame`].
    pub depths: Vec<i32>,
    /// Vertices that are elsewhere than the deformer puts them, and by how much.
    pub moved: Vec<(u32, Vec2)>,
}

impl Animation {
    /// A frame's posture.
    pub fn posture(&self, frame: usize) -> Posture {
        Posture { joints: self.joints(frame), depths: self.depths(frame), moved: self.moved(frame) }
    }
}

impl Take {
    /// The frames of `postures`, as `deformer` deforms them.
    ///
    /// # Errors
    /// What the deformer refuses, another number of joints than the skeleton has, vertices that are not there, too many
    /// frames for so large a mesh, a cancel.
    pub fn by_deformer(
        character: &Character,
        deformer: &dyn Deformer,
        fps: f64,
        postures: Vec<Posture>,
        stage: Stage<'_>,
    ) -> Result<Self> {
        stage.name("posing")?;
        let mesh = RestMesh { points: &character.mesh.points, triangles: &character.mesh.triangles };
        let skeleton = &character.skeleton;
        let mut deformation = deformer.bind(mesh, &handles(skeleton, &skeleton.rest()), stage.part(0.0, 0.1))?;
        let count = postures.len();
        let mut frames = Vec::with_capacity(room(count, mesh.points.len())?);
        let mut shape = mesh.points.to_vec();
        for (f, Posture { joints, depths, moved }) in postures.into_iter().enumerate() {
            let part = |f: usize| 0.1 + 0.9 * f as f64 / count as f64;
            if joints.len() != skeleton.joints.len() || depths.len() != skeleton.bones.len() {
                let problem = "has another number of joints or depths than the skeleton";
                return Err(Error::invalid(format!("frame {f}"), problem, "give each its own"));
            }
            deformation.solve(&handles(skeleton, &joints), &mut shape, stage.part(part(f), part(f + 1)))?;
            let mut points = shape.clone();
            for (vertex, way) in moved {
                let none = || Error::invalid(format!("frame {f}"), "moves a vertex that is not there", "check them");
                *points.get_mut(vertex as usize).ok_or_else(none)? += way;
            }
            frames.push(TakeFrame { points, joints, depths });
        }
        Ok(Self { fps, frames })
    }
}
