//! The library's state for one user.

use std::sync::Arc;

use crate::sys::{self, Handle};
use crate::{Clip, Creature, CreatureOptions, Job, Motion, Result, Rig, SegmentOptions, TrackOptions};

/// Owns the worker threads. Clones are the same context; it ends with its last object.
#[derive(Clone, Debug)]
pub struct Context(pub(crate) Arc<Handle>);

impl Context {
    /// A context with `threads` worker threads; 0 for one a core.
    pub fn new(threads: u32) -> Result<Self> {
        Ok(Self(Arc::new(sys::context_create(threads)?)))
    }

    /// How many worker threads it has.
    pub fn threads(&self) -> Result<u32> {
        sys::context_threads(&self.0)
    }

    /// Opens a video file or a folder of numbered images.
    pub fn open_clip(&self, path: &str) -> Result<Clip> {
        Ok(Clip { id: sys::clip_open(&self.0, path)?, context: self.clone() })
    }

    /// Opens a creature.glb, one that a modelling program wrote of it, or a creature's folder.
    pub fn open_creature(&self, path: &str) -> Result<Creature> {
        Ok(Creature { id: sys::creature_open(&self.0, path)?, context: self.clone() })
    }

    /// An empty rig for a clip of this size.
    pub fn new_rig(&self, width: u32, height: u32) -> Result<Rig> {
        Ok(Rig { id: sys::rig_create(&self.0, width, height)?, context: self.clone() })
    }

    /// Reads a strokes.json file.
    pub fn read_rig(&self, path: &str) -> Result<Rig> {
        Ok(Rig { id: sys::rig_read(&self.0, path)?, context: self.clone() })
    }

    /// Reads the text of a strokes.json.
    pub fn rig_from_json(&self, json: &str) -> Result<Rig> {
        Ok(Rig { id: sys::rig_from_json(&self.0, json)?, context: self.clone() })
    }

    /// Reads a motion.json file.
    pub fn read_motion(&self, path: &str) -> Result<Motion> {
        Ok(Motion { id: sys::motion_read(&self.0, path)?, context: self.clone() })
    }

    /// Reads the text of a motion.json.
    pub fn motion_from_json(&self, json: &str) -> Result<Motion> {
        Ok(Motion { id: sys::motion_from_json(&self.0, json)?, context: self.clone() })
    }

    /// Starts tracking.
    pub fn start_track(&self, clip: &Clip, rig: &Rig, options: &TrackOptions<'_>) -> Result<Job> {
        Ok(Job { id: sys::start_track(&self.0, clip.id, rig.id, options.tracker)?, context: self.clone() })
    }

    /// Starts segmenting, after tracking where no motion is given.
    pub fn start_segment(&self, clip: &Clip, rig: &Rig, options: &SegmentOptions<'_>) -> Result<Job> {
        let motion = options.motion.map(|m| m.id).unwrap_or_default();
        let SegmentOptions { tracker, segmenter, folder, .. } = options;
        let id = sys::start_segment(&self.0, (clip.id, rig.id, motion), tracker, segmenter, folder)?;
        Ok(Job { id, context: self.clone() })
    }

    /// Starts the whole job.
    pub fn start_creature(&self, clip: &Clip, rig: &Rig, options: &CreatureOptions<'_>) -> Result<Job> {
        Ok(Job { id: sys::start_creature(&self.0, (clip.id, rig.id), options)?, context: self.clone() })
    }
}
