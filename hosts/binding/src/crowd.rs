//! Creatures many times over.

use marey_ffi::{MRY_PLAY_HOLD, MRY_PLAY_LOOP, MRY_PLAY_ONCE, mry_crowd, mry_instance};

use crate::{Context, Creature, Result, sys};

/// A crowd.
#[derive(Debug)]
pub struct Crowd {
    pub(crate) id: mry_crowd,
    context: Context,
}

/// How an instance's motion goes on when it has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Play {
    /// It starts anew.
    #[default]
    Loop,
    /// It stays as it ends.
    Once,
    /// There is none: the pose of the start is held.
    Hold,
}

/// A creature in a crowd.
#[derive(Clone, Copy, Debug)]
pub struct Instance<'a> {
    /// The creature.
    pub creature: &'a Creature,
    /// Moved by x, y, z, in world units.
    pub at: [f32; 3],
    /// Turned about the vertical, in degrees.
    pub yaw: f32,
    /// Times its size.
    pub scale: f32,
    /// How its motion goes on.
    pub play: Play,
    /// The frame of its motion in the crowd's first frame.
    pub start: f64,
    /// Times as fast.
    pub speed: f64,
}

/// How much a crowd is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrowdInfo {
    /// Different creatures.
    pub creatures: u32,
    /// Instances.
    pub instances: u64,
    /// Frames.
    pub frames: u64,
    /// Frames a second.
    pub fps: f64,
}

impl Context {
    /// A crowd of these instances; 0 frames for those of the longest creature, 0 `fps` for the first creature's.
    pub fn crowd(&self, instances: &[Instance<'_>], frames: u64, fps: f64) -> Result<Crowd> {
        let instance = |i: &Instance<'_>| mry_instance {
            creature: i.creature.id,
            at: i.at,
            yaw: i.yaw,
            scale: i.scale,
            play: match i.play {
                Play::Loop => MRY_PLAY_LOOP,
                Play::Once => MRY_PLAY_ONCE,
                Play::Hold => MRY_PLAY_HOLD,
            },
            start: i.start,
            speed: i.speed,
        };
        let instances: Vec<mry_instance> = instances.iter().map(instance).collect();
        Ok(Crowd { id: sys::crowd_create(&self.0, &instances, frames, fps)?, context: self.clone() })
    }

    /// A creature `count` times in rows, out of step; 0 frames for the creature's.
    pub fn herd(&self, creature: &Creature, count: u32, frames: u64) -> Result<Crowd> {
        Ok(Crowd { id: sys::crowd_herd(&self.0, creature.id, count, frames)?, context: self.clone() })
    }

    /// Reads a crowd and opens its creatures.
    pub fn read_crowd(&self, path: &str) -> Result<Crowd> {
        Ok(Crowd { id: sys::crowd_read(&self.0, path)?, context: self.clone() })
    }
}

impl Crowd {
    /// How much it is made of.
    pub fn info(&self) -> Result<CrowdInfo> {
        let info = sys::crowd_info(&self.context.0, self.id)?;
        Ok(CrowdInfo {
            creatures: info.creature_count,
            instances: info.instance_count,
            frames: info.frame_count,
            fps: info.fps,
        })
    }

    /// Writes one glTF binary, whole or not at all. `scale` is metres a world unit, 0 for 1.
    pub fn write_glb(&self, path: &str, scale: f32) -> Result<()> {
        sys::crowd_write_glb(&self.context.0, self.id, path, scale)
    }
}

impl Drop for Crowd {
    fn drop(&mut self) {
        sys::crowd_destroy(&self.context.0, self.id);
    }
}
