//! Joints: what a person marks to capture the motion of a character.

use marey_ffi::{mry_clip, mry_joints};

use crate::{Clip, Context, Job, Motion, Result, sys};

/// Marked joints and the bones between them.
#[derive(Debug)]
pub struct Joints {
    pub(crate) id: mry_joints,
    pub(crate) context: Context,
}

impl Context {
    /// Joints of which none is marked, for a clip of this size.
    pub fn new_joints(&self, width: u32, height: u32) -> Result<Joints> {
        Ok(Joints { id: sys::joints_create(&self.0, width, height)?, context: self.clone() })
    }

    /// Reads a joints.json file.
    pub fn read_joints(&self, path: &str) -> Result<Joints> {
        Ok(Joints { id: sys::joints_read(&self.0, path)?, context: self.clone() })
    }

    /// Reads the text of a joints.json.
    pub fn joints_from_json(&self, json: &str) -> Result<Joints> {
        Ok(Joints { id: sys::joints_from_json(&self.0, json)?, context: self.clone() })
    }

    /// Starts capture. With `earlier`, what was captured before and from which joints, only what differs is captured
    /// again.
    pub fn start_capture(&self, clip: &Clip, joints: &Joints, earlier: Option<(&Motion, &Joints)>) -> Result<Job> {
        let earlier = earlier.map(|(motion, joints)| (motion.id, joints.id));
        Ok(Job { id: sys::start_capture(&self.0, (clip.id, joints.id), earlier)?, context: self.clone() })
    }
}

impl Joints {
    /// The text of a joints.json.
    pub fn to_json(&self) -> Result<String> {
        sys::joints_to_json(&self.context.0, self.id)
    }

    /// Writes joints.json, whole or not at all.
    pub fn write(&self, path: &str) -> Result<()> {
        sys::joints_write(&self.context.0, self.id, path)
    }

    /// Whether jobs can work with them, on `clip` where one is given.
    pub fn validate(&self, clip: Option<&Clip>) -> Result<()> {
        sys::joints_validate(&self.context.0, self.id, clip.map_or(mry_clip::default(), |c| c.id))
    }

    /// Marks a joint on a frame, in place of an earlier mark there: left, top, width and height in clip pixels.
    pub fn mark(&self, name: &str, frame: u64, rect: [f32; 4]) -> Result<()> {
        sys::joints_mark(&self.context.0, self.id, name, frame, rect)
    }

    /// Takes a joint's mark on a frame back.
    pub fn unmark(&self, name: &str, frame: u64) -> Result<()> {
        sys::joints_unmark(&self.context.0, self.id, name, frame)
    }

    /// Adds a bone between two marked joints.
    pub fn add_bone(&self, parent: &str, child: &str) -> Result<()> {
        sys::joints_add_bone(&self.context.0, self.id, parent, child)
    }
}

impl Motion {
    /// What there is to say about captured joints, as JSON.
    pub fn capture_report(&self, clip: &Clip, joints: &Joints) -> Result<String> {
        sys::capture_report(&self.context.0, self.id, clip.id, joints.id)
    }
}

impl Drop for Joints {
    fn drop(&mut self) {
        sys::joints_destroy(&self.context.0, self.id);
    }
}
