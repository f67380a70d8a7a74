//! The frames between key poses.
//!
//! Pan and Zhang 2011, section 3.5: `f(t) = slerp(f_start (1 - t), f_skeleton t) + (f_end - f_skeleton) t`. The skeleton's
//! bones turn the shorter way round from their parents and change their lengths evenly, its needles follow, and what the
//! joint areas and the hand added at the keys fades from one to the other, turning with its bone. Both ends are the key
//! poses themselves, to the bit.

use glam::{DVec2, Vec2};

use super::poses::{KeyPose, Poses};
use super::{Character, Skeleton};
use crate::deform::needles::{NeedleDeformer, Needles, Settled};
use crate::deform::{Deformation, Handle, RestMesh};
use crate::error::Result;
use crate::job::Stage;
use crate::motion::Motion;

/// A character bound to its needles: what poses it.
#[derive(Debug)]
pub struct Poser {
    skeleton: Skeleton,
    rest: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    bone: Vec<u32>,
    needles: Needles,
}

impl Character {
    /// Binds the mesh to the skeleton.
    ///
    /// # Errors
    /// A weight out of range, or a cancel.
    pub fn poser(&self, deformer: &NeedleDeformer, stage: Stage<'_>) -> Result<Poser> {
        let mesh = RestMesh { points: &self.mesh.points, triangles: &self.mesh.triangles };
        let needles = Needles::new(deformer, mesh, &handles(&self.skeleton, &self.skeleton.rest()), stage)?;
        Ok(Poser {
            skeleton: self.skeleton.clone(),
            rest: self.mesh.points.clone(),
            triangles: self.mesh.triangles.clone(),
            bone: self.regions.bone.clone(),
            needles,
        })
    }
}

pub(super) fn handles(skeleton: &Skeleton, joints: &[Vec2]) -> Vec<Handle> {
    skeleton.segments(joints).into_iter().map(|(a, b)| Handle::Bone(a, b)).collect()
}

impl Poser {
    /// The mesh with the joints at `joints`, in the skeleton's order.
    ///
    /// # Errors
    /// Another number of joints, places that are not numbers, a cancel.
    pub fn pose(&mut self, joints: &[Vec2], stage: Stage<'_>) -> Result<Vec<Vec2>> {
        self.count(joints)?;
        let mut points = self.rest.clone();
        self.needles.solve(&handles(&self.skeleton, joints), &mut points, stage)?;
        Ok(points)
    }

    /// Moves `points`, the mesh that the last pose gave, on to another place of the joints: for drags, many times as fast
    /// as a new [`Poser::pose`] and within a pixel of it but for poses that press flesh together. Pose anew on release.
    ///
    /// # Errors
    /// Another number of joints or points, places that are not numbers, a cancel; `points` are then as they were.
    pub fn drag(&mut self, joints: &[Vec2], points: &mut [Vec2], stage: Stage<'_>) -> Result<()> {
        self.count(joints)?;
        self.needles.solve(&handles(&self.skeleton, joints), points, stage)
    }

    /// How the joint areas of the last pose were settled.
    pub fn settled(&self) -> &Settled {
        self.needles.settled()
    }

    /// The skeleton that is posed.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// How many vertices the mesh has.
    pub fn vertices(&self) -> usize {
        self.rest.len()
    }

    /// The joints in a frame of a motion onto this skeleton, as [`crate::motion::retarget`] makes it.
    ///
    /// # Errors
    /// A joint without its track.
    pub fn joints_of(&self, motion: &Motion, frame: usize) -> Result<Vec<Vec2>> {
        let place = |j: &super::Joint| {
            let track = motion.track(&j.name).and_then(|t| t.frames.get(frame)?.points.first().copied());
            track.ok_or_else(|| {
                let problem = format!("has no place for joint `{}` in frame {frame}", j.name);
                crate::error::Error::invalid("motion", problem, "retarget it onto this skeleton first")
            })
        };
        self.skeleton.joints.iter().map(place).collect()
    }

    pub(super) fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    pub(super) fn bone_of(&self, vertex: u32) -> u32 {
        self.bone[vertex as usize]
    }

    pub(super) fn count(&self, joints: &[Vec2]) -> Result<()> {
        if joints.len() == self.skeleton.joints.len() {
            return Ok(());
        }
        let problem = format!("are {} and the skeleton has {}", joints.len(), self.skeleton.joints.len());
        Err(crate::error::Error::invalid("joints", problem, "give each joint a place"))
    }

    fn stage_one(&self, joints: &[Vec2]) -> Result<Vec<Vec2>> {
        self.needles.stage_one(&handles(&self.skeleton, joints))
    }
}

/// A character's key poses, solved, and the frames between them.
#[derive(Debug)]
pub struct Animation {
    poser: Poser,
    poses: Poses,
    keys: Vec<Key>,
}

#[derive(Debug)]
struct Key {
    shape: Vec<Vec2>,
    /// What the shape has beyond stage one.
    beyond: Vec<Vec2>,
}

impl Animation {
    /// Solves every key pose.
    ///
    /// # Errors
    /// What [`Poses::checked`] refuses, or a cancel.
    pub fn new(character: &Character, deformer: &NeedleDeformer, poses: Poses, stage: Stage<'_>) -> Result<Self> {
        let poses = poses.checked(character)?;
        let mut poser = character.poser(deformer, stage.part(0.0, 0.2))?;
        let count = poses.keys.len() as f64;
        let mut keys = Vec::with_capacity(poses.keys.len());
        for (i, key) in poses.keys.iter().enumerate() {
            let part = |i: usize| 0.2 + 0.8 * i as f64 / count;
            let mut shape = poser.pose(&key.joints, stage.part(part(i), part(i + 1)))?;
            key.moved.iter().for_each(|&(v, way)| shape[v as usize] += way);
            let beyond = poser.stage_one(&key.joints)?.iter().zip(&shape).map(|(a, b)| *b - *a).collect();
            keys.push(Key { shape, beyond });
        }
        Ok(Self { poser, poses, keys })
    }

    /// How many frames there are: up to the last key.
    pub fn frames(&self) -> usize {
        self.poses.keys.last().map_or(0, |k| k.frame + 1)
    }

    /// Frames a second.
    pub fn fps(&self) -> f64 {
        self.poses.fps
    }

    /// How many vertices the mesh has.
    pub fn vertices(&self) -> usize {
        self.poser.vertices()
    }

    /// The joints in a frame.
    pub fn joints(&self, frame: usize) -> Vec<Vec2> {
        let (from, to, share) = self.poses.between(frame);
        blend(&self.poser.skeleton, &self.poses.keys[from], &self.poses.keys[to], share).0
    }

    /// The mesh in a frame.
    ///
    /// # Errors
    /// None that keys which were solved lead to.
    pub fn frame(&self, frame: usize) -> Result<Vec<Vec2>> {
        let (from, to, share) = self.poses.between(frame);
        if share <= 0.0 {
            return Ok(self.keys[from].shape.clone());
        }
        if share >= 1.0 {
            return Ok(self.keys[to].shape.clone());
        }
        let (joints, turns) = blend(&self.poser.skeleton, &self.poses.keys[from], &self.poses.keys[to], share);
        let mut shape = self.poser.stage_one(&joints)?;
        let t = share as f32;
        for (v, p) in shape.iter_mut().enumerate() {
            let [since, until] = turns[self.poser.bone[v] as usize].map(|a| Vec2::from_angle(a as f32));
            let (start, end) = (self.keys[from].beyond[v], self.keys[to].beyond[v]);
            *p += since.rotate(start) * (1.0 - t) + until.rotate(end) * t;
        }
        Ok(shape)
    }

    /// How far vertices are from where a deformer puts them, for one that knows nothing of the keys.
    pub(super) fn moved(&self, frame: usize) -> Vec<(u32, Vec2)> {
        let (from, to, share) = self.poses.between(frame);
        let faded =
            |key: usize, share: f64| self.poses.keys[key].moved.iter().map(move |&(v, way)| (v, way * share as f32));
        faded(from, 1.0 - share).chain(faded(to, share)).collect()
    }

    /// The depth of every bone's region in a frame: that of the last key.
    pub fn depths(&self, frame: usize) -> Vec<i32> {
        let mut depths = vec![0; self.poser.skeleton.bones.len()];
        let key = &self.poses.keys[self.poses.between(frame).0];
        key.depth.iter().for_each(|&(bone, depth)| depths[bone as usize] = depth);
        depths
    }
}

/// The joints between two keys, and for each bone how far it has turned since the first and until the second.
fn blend(skeleton: &Skeleton, a: &KeyPose, b: &KeyPose, share: f64) -> (Vec<Vec2>, Vec<[f64; 2]>) {
    if share <= 0.0 {
        return (a.joints.clone(), vec![[0.0; 2]; skeleton.bones.len()]);
    }
    let place = |p: &KeyPose, j: usize| p.joints[j].as_dvec2();
    let mut joints: Vec<DVec2> = (0..skeleton.joints.len()).map(|j| place(a, j).lerp(place(b, j), share)).collect();
    let parents = skeleton.parents();
    let mut turns: Vec<f64> = Vec::with_capacity(skeleton.bones.len());
    for (bone, &[from, to]) in skeleton.bones.iter().enumerate() {
        let (first, last) = (place(a, to) - place(a, from), place(b, to) - place(b, from));
        let parent = parents[bone].map_or(0.0, |p| turns[p]);
        let angle = first.perp_dot(last).atan2(first.dot(last)) - parent;
        let whole = std::f64::consts::TAU;
        // Half a turn goes the way that rounding would not decide.
        let turn = parent + angle - ((angle - 1e-9) / whole).round() * whole;
        turns.push(turn);
        let length = first.length() + (last.length() - first.length()) * share;
        let direction =
            first.try_normalize().unwrap_or_else(|| DVec2::from_angle(-turn).rotate(last.normalize_or_zero()));
        joints[to] = joints[from] + DVec2::from_angle(turn * share).rotate(direction) * length;
    }
    let rest = turns.iter().map(|t| [t * share, -t * (1.0 - share)]).collect();
    (joints.iter().map(|p| p.as_vec2()).collect(), rest)
}
