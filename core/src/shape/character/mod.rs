//! Characters: cut-out drawings that move by their skeleton.
//!
//! Pan and Zhang 2011, "Sketch-Based Skeleton-Driven 2D Animation and Motion Capture". A picture becomes a
//! [`Character`]: a silhouette between the pixels, a mesh that is finer at joints, a skeleton proposed on the curve
//! skeleton, and a region of the mesh for each bone.

pub(crate) mod curve_skeleton;
mod cutout;
mod deformed;
mod draw;
mod drawing;
mod in_between;
mod overlap;
mod poses;
mod redrawing;
mod rig_file;
mod skeleton;
mod skeleton_edit;
mod sketching;
mod take;
#[cfg(test)]
mod tests;

use glam::Vec2;
use image::RgbaImage;

pub use crate::deform::{Regions, VertexClass};
pub use cutout::cut_out;
pub use deformed::Posture;
pub use draw::{Canvas, Drawing};
pub use drawing::{apply_mask, read_cut, read_drawing};
pub use in_between::{Animation, Poser};
pub use overlap::Overlap;
pub use poses::{Easing, KeyPose, Poses};
pub use skeleton::{Joint, Skeleton};
pub use sketching::Sketched;
pub use take::{Take, TakeFrame};

use crate::error::{Error, Result};
use crate::geometry::{PlaneMesh, polygon};
use crate::job::Stage;
use crate::raster::Grid;
use crate::raster::marching_squares::outlines;
use curve_skeleton::CurveSkeleton;

/// How a picture becomes a character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigParams {
    /// About how many vertices the mesh has away from joints.
    pub vertices: usize,
    /// How much closer vertices are at joints; 1 for a mesh that is even.
    pub finer_at_joints: f32,
}

impl Default for RigParams {
    /// 1200 vertices, twice as close at joints: a limb of a figure of a thousand pixels is some six wide.
    fn default() -> Self {
        Self { vertices: 1200, finer_at_joints: 2.0 }
    }
}

/// The most vertices that may be asked for.
const MOST_VERTICES: usize = 200_000;
/// The largest picture, in pixels: 16k by 16k.
const MOST_PIXELS: u64 = 1 << 28;

/// A drawing ready to be moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Character {
    /// Width and height of the picture.
    pub size: (u32, u32),
    /// The mesh at rest, in pixels of the picture, which are its texture coordinates as well.
    pub mesh: PlaneMesh,
    /// The skeleton at rest.
    pub skeleton: Skeleton,
    /// Which bone each vertex follows.
    pub regions: Regions,
    /// The curve skeleton that joints were proposed on: lines in pixels. Empty where there was no picture.
    pub curve: Vec<Vec<Vec2>>,
}

impl Character {
    /// Makes a character of a picture: of what is opaque, or, where everything is, of what differs from the paper. Every
    /// piece of the drawing is meshed, holes are kept; pieces of less than a twentieth of the largest get no bones of
    /// their own and follow the nearest.
    ///
    /// # Errors
    /// A picture without pixels, with nothing on it, or filled from border to border; too large a picture; a cancel.
    pub fn from_picture(picture: &RgbaImage, params: &RigParams, stage: Stage<'_>) -> Result<Self> {
        stage.name("silhouette")?;
        let pixels = u64::from(picture.width()) * u64::from(picture.height());
        if pixels > MOST_PIXELS {
            let remedy = "scale the picture down".into();
            return Err(Error::Limit {
                what: "the picture's pixel count".into(),
                value: pixels,
                max: MOST_PIXELS,
                remedy,
            });
        }
        if params.vertices > MOST_VERTICES {
            let (value, max) = (params.vertices as u64, MOST_VERTICES as u64);
            return Err(Error::Limit { what: "the vertex count".into(), value, max, remedy: "ask for fewer".into() });
        }
        if !(params.finer_at_joints >= 1.0 && params.finer_at_joints <= 8.0) {
            return Err(Error::invalid("finer_at_joints", "is not in 1..=8", "give 1 for an even mesh"));
        }
        let opacity = cutout::opacity(picture)?;
        stage.at(0.2)?;
        let mask = cutout::pieces(&opacity);
        let kept = Grid::from_vec(
            mask.width(),
            mask.height(),
            opacity
                .data()
                .iter()
                .enumerate()
                .map(|(i, a)| {
                    // Half clear rims of a kept piece place its outline; those of dust go with it.
                    let (x, y) = ((i % mask.width()) as isize, (i / mask.width()) as isize);
                    let near = (-1..=1).any(|dy| (-1..=1).any(|dx| mask.at(x + dx, y + dy)));
                    if near { a.min(if mask.at(x, y) { 1.0 } else { 0.5 }) } else { 0.0 }
                })
                .collect(),
        );
        let silhouette = outlines(&kept, 0.5);
        stage.at(0.3)?;
        let curve = CurveSkeleton::of(&mask, stage.part(0.3, 0.6))?;
        let skeleton = curve.joints()?;
        stage.name("mesh")?;
        let mesh = mesh(&silhouette, &skeleton, params);
        stage.at(0.9)?;
        let mut own = Self::new((picture.width(), picture.height()), mesh, skeleton)?;
        own.curve = curve.branches.into_iter().map(|b| b.points).collect();
        Ok(own)
    }

    /// A character of a mesh and a skeleton.
    ///
    /// # Errors
    /// A mesh without triangles or with what is not a number, or that names vertices that are not there; a skeleton that
    /// [`Skeleton::checked`] refuses.
    pub fn new(size: (u32, u32), mesh: PlaneMesh, skeleton: Skeleton) -> Result<Self> {
        if mesh.triangles.is_empty() {
            return Err(Error::invalid("mesh", "has no triangles", "give a drawing larger than a few pixels"));
        }
        if mesh.points.iter().any(|p| !p.is_finite()) {
            return Err(Error::invalid("mesh", "has a vertex that is not at a number", "give finite places"));
        }
        if mesh.triangles.iter().flatten().any(|&v| v as usize >= mesh.points.len()) {
            return Err(Error::invalid("mesh", "names a vertex that is not there", "check its triangles"));
        }
        let skeleton = skeleton.checked()?;
        let regions = Regions::grow(&mesh, &skeleton.segments(&skeleton.rest()));
        Ok(Self { size, mesh, skeleton, regions, curve: Vec::new() })
    }

    /// The character with another skeleton: joints moved, added or taken away. Bones may reach out of the drawing; one
    /// that lies wholly outside moves nothing.
    ///
    /// # Errors
    /// What [`Skeleton::checked`] refuses.
    pub fn with_skeleton(&self, skeleton: Skeleton) -> Result<Self> {
        let own = Self::new(self.size, self.mesh.clone(), skeleton)?;
        Ok(Self { curve: self.curve.clone(), ..own })
    }

    /// The place on the curve skeleton nearest to `p`: where a joint snaps to.
    pub fn on_curve(&self, p: Vec2) -> Option<Vec2> {
        let places =
            self.curve.iter().flat_map(|line| line.windows(2)).map(|s| polygon::nearest_on_segment(s[0], s[1], p).1);
        places.min_by(|a, b| a.distance(p).total_cmp(&b.distance(p)))
    }
}

/// The mesh of a silhouette, finer around joints within the width that the drawing has there.
fn mesh(silhouette: &[Vec<Vec2>], skeleton: &Skeleton, params: &RigParams) -> PlaneMesh {
    let area: f64 = silhouette.iter().map(|o| polygon::signed_area(o)).sum();
    // Hexagonal grids have 1.155 points for a square of their spacing.
    let spacing = ((1.155 * area.max(1.0) / params.vertices.max(16) as f64).sqrt() as f32).max(1.0);
    let joints: Vec<(Vec2, f32)> = skeleton
        .joints
        .iter()
        .map(|j| {
            let gap = |p: &Vec2| p.distance(j.at);
            (j.at, 0.8 * silhouette.iter().flatten().map(gap).fold(f32::INFINITY, f32::min).max(2.0 * spacing))
        })
        .collect();
    PlaneMesh::within(silhouette, |p| {
        let near = joints.iter().any(|(at, reach)| at.distance_squared(p) < reach * reach);
        if near { (spacing / params.finer_at_joints).max(1.0) } else { spacing }
    })
}
