//! Needles: every vertex keeps its angle and its place along its bone; where bones meet, the shape is solved for.
//!
//! Pan and Zhang 2011, section 3.3, in two stages: `blend`, and `joint_areas`.
//!
//! A solve from the rest shape, or from any that is not the last result, depends on the targets alone, to the bit. One that is
//! given the last result goes on from it: areas whose bones keep their places to one another move along, and those whose
//! bones moved by a frame of a drag start from their last shape and, while it serves, with their last factor. Such a
//! drag ends within a pixel of what a solve from rest finds, except where flesh is pressed together (from about half a
//! right angle on at thick joints): there several shapes hold themselves, and a drag keeps to its own. Whoever wants the
//! same shape after a drag as after loading solves from rest on release.
//!
//! Known limits: bones only, no points; vertices that belong to bones without a common joint and lie side by side in one
//! mesh part only as far as stage two can bridge.

mod blend;
mod descent;
mod energy;
mod fill;
mod joint_areas;
#[cfg(test)]
mod tests;

use glam::{DVec2, Vec2};

use super::{Deformation, Deformer, Handle, RestMesh};
use crate::error::{Error, Result};
use crate::geometry::PlaneMesh;
use crate::job::Stage;
use blend::Blend;
use joint_areas::JointAreas;
pub use joint_areas::{Settled, SettledArea};

/// What keeps the area when a bone changes its length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AreaRule {
    /// Nothing: needles keep their length.
    Off,
    /// The paper's: needles change by the reciprocal of the bone. What lies beyond a bone's end shrinks both ways.
    Reciprocal,
    /// The same across, and what lies beyond a bone's end stretches along with it: every triangle keeps its area.
    #[default]
    Exact,
}

/// The built-in needle deformer. Its handles are bones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeedleDeformer {
    /// What keeps the area.
    pub area: AreaRule,
    /// How much joint areas mind the shape of their outline, `w1`; their edges' lengths weigh `1 - w1`.
    pub outline_weight: f64,
    /// Whether joint areas are solved for. Without, the blend of the bones' maps stays.
    pub joint_areas: bool,
}

impl Default for NeedleDeformer {
    /// The paper's equal weights.
    fn default() -> Self {
        Self { area: AreaRule::Exact, outline_weight: 0.5, joint_areas: true }
    }
}

impl Deformer for NeedleDeformer {
    fn bind(&self, mesh: RestMesh<'_>, handles: &[Handle], stage: Stage<'_>) -> Result<Box<dyn Deformation>> {
        Ok(Box::new(Needles::new(self, mesh, handles, stage)?))
    }
}

/// A mesh whose vertices hang on bones.
#[derive(Debug)]
pub struct Needles {
    deformer: NeedleDeformer,
    blend: Blend,
    areas: JointAreas,
    /// Vertices that no area may move.
    held: Vec<u32>,
    settled: Settled,
    /// The last result.
    last: Vec<Vec2>,
}

impl Needles {
    /// Binds `mesh` to `handles`.
    ///
    /// # Errors
    /// A handle that is not a bone or not a number, no handle; a mesh without triangles, with an index without its
    /// vertex, or with what is not a number.
    pub fn new(deformer: &NeedleDeformer, mesh: RestMesh<'_>, handles: &[Handle], stage: Stage<'_>) -> Result<Self> {
        stage.at(0.0)?;
        if !(0.0..=1.0).contains(&deformer.outline_weight) {
            return Err(Error::invalid("outline_weight", "is not in 0..=1", "give the share of the outline"));
        }
        if mesh.triangles.is_empty() || mesh.points.iter().any(|p| !p.is_finite()) {
            return Err(Error::invalid(
                "mesh",
                "has no triangles or a vertex that is not at a number",
                "check the mesh",
            ));
        }
        if mesh.triangles.iter().flatten().any(|&v| v as usize >= mesh.points.len()) {
            return Err(Error::invalid("mesh", "names a vertex that is not there", "check its triangles"));
        }
        let segments = blend::segments(handles)?;
        let plane = PlaneMesh { points: mesh.points.to_vec(), triangles: mesh.triangles.to_vec() };
        let (blend, free) = Blend::new(deformer.area, &plane, &segments);
        stage.at(0.4)?;
        let areas = JointAreas::new(&plane, &free, &blend);
        stage.at(1.0)?;
        let held = (0..free.len() as u32).filter(|&v| !free[v as usize]).collect();
        Ok(Self { deformer: *deformer, blend, areas, held, settled: Settled::default(), last: Vec::new() })
    }

    /// How the joint areas of the last solve were settled.
    pub fn settled(&self) -> &Settled {
        &self.settled
    }

    /// The mesh after stage one, with the bones at `targets`: the blend of their maps.
    ///
    /// # Errors
    /// Others than were bound, or what is not a number.
    pub fn stage_one(&self, targets: &[Handle]) -> Result<Vec<Vec2>> {
        let posed = self.blend.pose(targets)?;
        Ok((0..self.blend.len()).map(|v| self.blend.place(v, &posed).at.as_vec2()).collect())
    }
}

impl Deformation for Needles {
    /// Goes on from the last result where `points` hold it, else starts anew.
    fn solve(&mut self, targets: &[Handle], points: &mut [Vec2], stage: Stage<'_>) -> Result<()> {
        let posed = self.blend.pose(targets)?;
        if points.len() != self.blend.len() {
            let problem = format!("{} were given and {} bound", points.len(), self.blend.len());
            return Err(Error::invalid("points of the mesh", problem, "pass the shape of the mesh that was bound"));
        }
        stage.at(0.0)?;
        if !self.deformer.joint_areas {
            points.iter_mut().enumerate().for_each(|(v, p)| *p = self.blend.place(v, &posed).at.as_vec2());
            return Ok(());
        }
        let warm = self.last == points;
        // After a cancel half-way there is nothing to go on from.
        self.last.clear();
        self.settled = self.areas.settle(&self.blend, &posed, self.deformer.outline_weight, warm, stage)?;
        self.areas.each(|v, p: DVec2| points[v as usize] = p.as_vec2());
        for &v in &self.held {
            points[v as usize] = self.blend.place(v as usize, &posed).at.as_vec2();
        }
        self.last.extend_from_slice(points);
        Ok(())
    }
}
