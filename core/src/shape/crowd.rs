//! A crowd: many instances of creatures, each with its own place, turn, size and time (cloning: Reinert 2016, section 4).
//!
//! An instance stands where its creature was filmed until it is moved: it turns and grows about the point on the ground
//! below the middle of its creature, so a mirrored twin is a turn by 180 degrees. Limits: creatures do not see each
//! other; where they walk through each other is the caller's to avoid.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DQuat, Mat4, Quat, Vec3};
use serde::{Deserialize, Serialize};

use super::creature::Creature;
use super::{RiggedModel, Transform};
use crate::error::{Error, Result};

/// Bounds that keep a hostile file from eating the machine.
const MAX_INSTANCES: usize = 10_000;
const MAX_FRAMES: usize = 100_000;
/// Where an instance may be, in world units, and how large.
const MAX_PLACE: f32 = 1e6;
const SCALES: std::ops::RangeInclusive<f32> = 1e-3..=1e3;

/// One creature in a crowd.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Instance {
    /// Which of the crowd's creatures.
    pub creature: usize,
    /// Moved by, in world units: x right, y up, z toward the viewer.
    pub at: [f32; 3],
    /// Turned about the vertical, in degrees: 90 turns a creature that looks right away from the viewer.
    pub yaw: f32,
    /// Times its size.
    pub scale: f32,
    /// The frame of its creature that it shows in the crowd's first frame.
    pub start: f64,
    /// Frames of its creature for each frame of the crowd, by their rates; 0 holds a pose, below 0 plays backwards.
    pub speed: f64,
    /// Whether its last frame is followed by its first; else it holds the last.
    #[serde(rename = "loop")]
    pub looped: bool,
}

impl Default for Instance {
    fn default() -> Self {
        Self { creature: 0, at: [0.0; 3], yaw: 0.0, scale: 1.0, start: 0.0, speed: 1.0, looped: true }
    }
}

/// Creatures and where they stand.
#[derive(Clone, Debug)]
pub struct Crowd {
    /// Width and height of the picture they were filmed in, or of a scene of their own.
    pub size: (u32, u32),
    /// Frames a second.
    pub fps: f64,
    /// How many frames.
    pub frames: usize,
    /// The creatures.
    pub creatures: Vec<Arc<Creature>>,
    /// Who stands where.
    pub instances: Vec<Instance>,
}

impl Crowd {
    /// Checks what [`Self::pose`], exporters and renderers rely on.
    pub fn validate(&self) -> Result<()> {
        for creature in &self.creatures {
            creature.validate()?;
        }
        if self.instances.is_empty() {
            return Err(Error::invalid("the crowd", "has no instance", "place at least one creature"));
        }
        let counts = [("instances", self.instances.len(), MAX_INSTANCES), ("frames", self.frames, MAX_FRAMES)];
        if let Some((what, value, max)) = counts.into_iter().find(|(_, value, max)| value > max) {
            let what = format!("the crowd's number of {what}");
            return Err(Error::Limit {
                what,
                value: value as u64,
                max: max as u64,
                remedy: "make several crowds".into(),
            });
        }
        if self.frames == 0 || !(self.fps.is_finite() && (0.1..=1000.0).contains(&self.fps)) {
            let problem = format!("has {} frames at {} a second", self.frames, self.fps);
            return Err(Error::invalid("the crowd", problem, "give at least one frame and a rate of 0.1 to 1000"));
        }
        self.instances.iter().enumerate().try_for_each(|(i, instance)| self.validate_instance(i, instance))
    }

    fn validate_instance(&self, index: usize, instance: &Instance) -> Result<()> {
        let bad = |problem: String, remedy: &str| Err(Error::invalid(format!("instance {index}"), problem, remedy));
        let Some(creature) = self.creatures.get(instance.creature) else {
            let problem = format!("is of creature {}, and there are {}", instance.creature, self.creatures.len());
            return bad(problem, "creatures count from 0");
        };
        if creature.model.animation.is_empty() {
            return bad("is of a creature that has no frame".into(), "give an animated creature");
        }
        if !instance.at.iter().all(|v| v.abs() <= MAX_PLACE) {
            return bad(format!("stands at {:?}", instance.at), "give its place in pixels of the clip");
        }
        if !SCALES.contains(&instance.scale) {
            return bad(format!("is {} times as large", instance.scale), "give a scale of 0.001 to 1000");
        }
        let times = [f64::from(instance.yaw), instance.start, instance.speed];
        if !times.iter().all(|v| v.abs() <= 1e6) {
            return bad(
                format!("turns by {}, starts at {} or plays at {}", times[0], times[1], times[2]),
                "give numbers",
            );
        }
        Ok(())
    }

    /// Where an instance's creature is placed in the world.
    ///
    /// # Panics
    /// When the crowd is not valid or has no such instance.
    pub fn placement(&self, instance: usize) -> Mat4 {
        let instance = &self.instances[instance];
        let (turn, moved) = placed(instance, pivot(&self.creatures[instance.creature].model));
        Mat4::from_scale_rotation_translation(Vec3::splat(instance.scale), turn, moved)
    }

    /// An instance's bones in a frame of the crowd, each relative to its parent.
    ///
    /// # Panics
    /// As for [`Self::placement`].
    pub fn pose(&self, instance: usize, frame: usize) -> Vec<Transform> {
        let instance = &self.instances[instance];
        let model = &self.creatures[instance.creature].model;
        let at = instance.start + frame as f64 * instance.speed * model.fps / self.fps;
        between(&model.animation, at, instance.looped)
    }

    /// As many instances of the first creature as asked for, in rows behind one another, each at another moment of its
    /// motion: what a herd looks like before anybody places it.
    pub fn herd(creature: Arc<Creature>, count: usize, frames: usize) -> Self {
        let model = &creature.model;
        let (low, high) = bounds(model);
        // A third of a length of free ground around each.
        let (along, deep) = ((high.x - low.x) * 1.3, (high.x - low.x) * 0.6);
        let across = (count as f64).sqrt().ceil().max(1.0) as usize;
        let length = model.animation.len() as f64;
        // Neighbours in the golden ratio of the motion apart are never in step.
        let phase = |i: usize| length * (i as f64 * 0.618_033_988_749_895).fract();
        let instance = |i: usize| {
            let (row, column) = (i / across, i % across);
            // Every other row stands between those before it.
            let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
            let side = (column as f32 + shift - (across - 1) as f32 / 2.0) * along;
            Instance { at: [side, 0.0, -(row as f32) * deep], start: phase(i).floor(), ..Instance::default() }
        };
        let (size, fps) = (model.size, model.fps);
        Self { size, fps, frames, instances: (0..count).map(instance).collect(), creatures: vec![creature] }
    }
}

/// The turn and the move that place an instance, beside its scale.
pub(crate) fn placed(instance: &Instance, pivot: Vec3) -> (Quat, Vec3) {
    let turn = DQuat::from_rotation_y(f64::from(instance.yaw).to_radians()).as_quat();
    (turn, pivot + Vec3::from_array(instance.at) - turn * (pivot * instance.scale))
}

/// The point on the ground below the middle of a creature at rest.
pub(crate) fn pivot(model: &RiggedModel) -> Vec3 {
    let (low, high) = bounds(model);
    Vec3::new((low.x + high.x) / 2.0, low.y, (low.z + high.z) / 2.0)
}

fn bounds(model: &RiggedModel) -> (Vec3, Vec3) {
    let places = model.parts.iter().flat_map(|p| &p.mesh.positions);
    let (low, high) = places.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    if low.is_finite() { (low, high) } else { (Vec3::ZERO, Vec3::ZERO) }
}

/// The pose of an animation, of at least a frame, at a fractional one: as it is on whole frames, blended between them.
/// `looped`, its last frame is followed by its first; else it stays where it begins and ends.
pub fn between(animation: &[Vec<Transform>], at: f64, looped: bool) -> Vec<Transform> {
    let count = animation.len();
    let (a, b, share) = if looped {
        let at = at.rem_euclid(count as f64);
        let a = (at as usize).min(count - 1);
        (a, (a + 1) % count, at - a as f64)
    } else {
        let at = at.clamp(0.0, (count - 1) as f64);
        let a = at as usize;
        (a, (a + 1).min(count - 1), at - a as f64)
    };
    if share < 1e-6 {
        return animation[a].clone();
    }
    let blend = |(from, to): (&Transform, &Transform)| Transform {
        translation: from.translation.lerp(to.translation, share as f32),
        rotation: from.rotation.slerp(to.rotation, share as f32).normalize(),
    };
    animation[a].iter().zip(&animation[b]).map(blend).collect()
}

/// A crowd as a file says it: creatures by their files.
///
/// ```json
/// {"format": "marey-crowd", "version": 1, "creatures": ["fox/creature.glb"], "frames": 60,
///  "instances": [{"creature": 0, "at": [120, 0, -80], "yaw": 180, "scale": 0.8, "start": 12, "loop": true}]}
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrowdFile {
    format: String,
    version: u32,
    /// Width and height; the first creature's where left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<(u32, u32)>,
    /// Frames a second; the first creature's where left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fps: Option<f64>,
    /// How many frames; those of the longest creature where left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<usize>,
    /// creature.glb files or creatures' folders, relative to the file.
    pub creatures: Vec<PathBuf>,
    /// Who stands where.
    pub instances: Vec<Instance>,
}

const FORMAT: &str = "marey-crowd";
const VERSION: u32 = 1;

impl CrowdFile {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read or is of another format or a later version.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        let remedy =
            "expected {\"format\": \"marey-crowd\", \"version\": 1, \"creatures\": [...], \"instances\": [...]}";
        let mut file: Self = serde_json::from_str(&text).map_err(|e| Error::file(path, e.to_string(), remedy))?;
        if file.format != FORMAT {
            return Err(Error::file(path, format!("is of format `{}`", file.format), remedy));
        }
        if file.version != VERSION {
            let problem = format!("is of version {}, and this program knows {VERSION}", file.version);
            return Err(Error::file(path, problem, "use a newer program"));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        file.creatures.iter_mut().for_each(|c| *c = folder.join(&*c));
        Ok(file)
    }

    /// The crowd, with its creatures in the file's order.
    ///
    /// # Errors
    /// A crowd that is not valid.
    pub fn crowd(&self, creatures: Vec<Arc<Creature>>) -> Result<Crowd> {
        let first = creatures.first().ok_or_else(|| Error::invalid("the crowd", "has no creature", "name one"))?;
        let longest = creatures.iter().map(|c| c.model.animation.len()).max().unwrap_or(0);
        let crowd = Crowd {
            size: self.size.unwrap_or(first.model.size),
            fps: self.fps.unwrap_or(first.model.fps),
            frames: self.frames.unwrap_or(longest),
            instances: self.instances.clone(),
            creatures,
        };
        crowd.validate()?;
        Ok(crowd)
    }
}
