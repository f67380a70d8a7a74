//! A take: what a character does in every frame, as exporters and renderers use it.

use glam::Vec2;

use super::{Animation, Character, Poser};
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::motion::Motion;

/// The most places of vertices that a take may hold: 2 GiB.
const MOST_PLACES: u64 = 1 << 28;

/// A character in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TakeFrame {
    /// Where each vertex of the mesh is, in pixels of the picture.
    pub points: Vec<Vec2>,
    /// Where each joint is, in the skeleton's order.
    pub joints: Vec<Vec2>,
    /// How near each bone's region is to the viewer; larger is nearer. Of regions at one depth the later bone's is drawn
    /// over the earlier one's: bones go from the root outward.
    pub depths: Vec<i32>,
}

/// A character over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Take {
    /// Frames a second.
    pub fps: f64,
    /// The frames.
    pub frames: Vec<TakeFrame>,
}

impl Take {
    /// Every frame of key poses and what lies between them.
    ///
    /// # Errors
    /// Too many frames for so large a mesh, or a cancel.
    pub fn of_poses(animation: &Animation, stage: Stage<'_>) -> Result<Self> {
        stage.name("in-betweens")?;
        let count = animation.frames();
        let mut frames = Vec::with_capacity(room(count, animation.vertices())?);
        for frame in 0..count {
            stage.at(frame as f64 / count as f64)?;
            frames.push(TakeFrame {
                points: animation.frame(frame)?,
                joints: animation.joints(frame),
                depths: animation.depths(frame),
            });
        }
        Ok(Self { fps: animation.fps(), frames })
    }

    /// Every frame of a motion onto this character's skeleton, as [`crate::motion::retarget`] makes it. `depths` holds for
    /// all of them; empty for 0 everywhere.
    ///
    /// # Errors
    /// A joint without its track, places that are not numbers, another number of depths than bones, too many frames for
    /// so large a mesh, a cancel.
    pub fn of_motion(poser: &mut Poser, motion: &Motion, depths: &[i32], stage: Stage<'_>) -> Result<Self> {
        stage.name("posing")?;
        let bones = poser.skeleton().bones.len();
        if !depths.is_empty() && depths.len() != bones {
            let problem = format!("are {} and the skeleton has {bones} bones", depths.len());
            return Err(Error::invalid("depths", problem, "give each bone one, or none"));
        }
        let mut frames = Vec::with_capacity(room(motion.frames, poser.vertices())?);
        for frame in 0..motion.frames {
            let part = |f: usize| f as f64 / motion.frames as f64;
            let joints = poser.joints_of(motion, frame)?;
            let points = poser.pose(&joints, stage.part(part(frame), part(frame + 1)))?;
            let depths = if depths.is_empty() { vec![0; bones] } else { depths.to_vec() };
            frames.push(TakeFrame { points, joints, depths });
        }
        Ok(Self { fps: motion.fps, frames })
    }

    /// The smallest upright rectangle around the mesh in all frames, lower corner first; `None` without frames.
    pub fn bounds(&self) -> Option<(Vec2, Vec2)> {
        let points = || self.frames.iter().flat_map(|f| &f.points);
        let low = points().copied().reduce(Vec2::min)?;
        Some((low, points().copied().fold(low, Vec2::max)))
    }
}

pub(super) fn room(frames: usize, vertices: usize) -> Result<usize> {
    let value = frames as u64 * vertices as u64;
    if value <= MOST_PLACES {
        return Ok(frames);
    }
    let what = "the take's number of frames times vertices".into();
    Err(Error::Limit { what, value, max: MOST_PLACES, remedy: "take fewer frames or a coarser mesh".into() })
}

impl Character {
    /// The bone whose region each triangle is drawn with: that of most of its corners, the outer one where all differ.
    pub fn triangle_bones(&self) -> Vec<u32> {
        (0..self.mesh.triangles.len()).map(|t| self.triangle_bone(t)).collect()
    }

    pub(super) fn triangle_bone(&self, triangle: usize) -> u32 {
        let [a, b, c] = self.mesh.triangles[triangle].map(|v| self.regions.bone[v as usize]);
        match (a == b || a == c, b == c) {
            (true, _) => a,
            (_, true) => b,
            _ => a.max(b).max(c),
        }
    }

    /// The mesh's triangles from the farthest to the nearest, for bones of these depths. A region stays together; among
    /// regions of one depth those of outer bones are nearer, and within a region the mesh's order holds.
    pub fn draw_order(&self, depths: &[i32]) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.mesh.triangles.len() as u32).collect();
        order.sort_by_cached_key(|t| self.nearness(*t, depths));
        order
    }

    /// How near a triangle is: its region's depth, and its bone.
    pub(super) fn nearness(&self, triangle: u32, depths: &[i32]) -> (i32, u32) {
        let bone = self.triangle_bone(triangle as usize);
        (depths.get(bone as usize).copied().unwrap_or(0), bone)
    }
}
