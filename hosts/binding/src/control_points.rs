//! Control points: what a person marks to take a motion from a clip.

use marey_ffi::{mry_clip, mry_control_points};

use crate::{Clip, Context, Job, Motion, Result, sys};

/// Marked control points.
#[derive(Debug)]
pub struct ControlPoints {
    pub(crate) id: mry_control_points,
    pub(crate) context: Context,
}

impl Context {
    /// Control points of which none is marked, for a clip of this size.
    pub fn new_control_points(&self, width: u32, height: u32) -> Result<ControlPoints> {
        Ok(ControlPoints { id: sys::control_points_create(&self.0, width, height)?, context: self.clone() })
    }

    /// Reads a points.json file.
    pub fn read_control_points(&self, path: &str) -> Result<ControlPoints> {
        Ok(ControlPoints { id: sys::control_points_read(&self.0, path)?, context: self.clone() })
    }

    /// Reads the text of a points.json.
    pub fn control_points_from_json(&self, json: &str) -> Result<ControlPoints> {
        Ok(ControlPoints { id: sys::control_points_from_json(&self.0, json)?, context: self.clone() })
    }

    /// Starts looking for points to follow on a frame, or on the one of a few that shows most ends; `most` at most, 0 for the
    /// default.
    pub fn start_propose_points(&self, clip: &Clip, frame: Option<u64>, most: u32) -> Result<Job> {
        let frame_from_one = frame.map_or(0, |frame| frame.saturating_add(1));
        Ok(Job { id: sys::start_propose_points(&self.0, clip.id, frame_from_one, most)?, context: self.clone() })
    }

    /// Starts tracking points. With `keep`, what was read and solved stays in memory until the clip is closed, and the
    /// next time only what differs is solved.
    pub fn start_point_track(&self, clip: &Clip, points: &ControlPoints, keep: bool) -> Result<Job> {
        Ok(Job { id: sys::start_point_track(&self.0, (clip.id, points.id), keep)?, context: self.clone() })
    }
}

impl ControlPoints {
    /// The text of a points.json.
    pub fn to_json(&self) -> Result<String> {
        sys::control_points_to_json(&self.context.0, self.id)
    }

    /// Writes points.json, whole or not at all.
    pub fn write(&self, path: &str) -> Result<()> {
        sys::control_points_write(&self.context.0, self.id, path)
    }

    /// Whether jobs can work with them, on `clip` where one is given.
    pub fn validate(&self, clip: Option<&Clip>) -> Result<()> {
        sys::control_points_validate(&self.context.0, self.id, clip.map_or(mry_clip::default(), |c| c.id))
    }

    /// Marks a point on a frame, in place of an earlier key there, in clip pixels.
    pub fn mark(&self, name: &str, frame: u64, at: (f32, f32)) -> Result<()> {
        sys::control_points_mark(&self.context.0, self.id, name, frame, at)
    }

    /// Takes a point's key on a frame back.
    pub fn unmark(&self, name: &str, frame: u64) -> Result<()> {
        sys::control_points_unmark(&self.context.0, self.id, name, frame)
    }
}

impl Job {
    /// The control points that it proposed; once.
    pub fn take_control_points(&self) -> Result<ControlPoints> {
        Ok(ControlPoints { id: sys::take_control_points(&self.context.0, self.id)?, context: self.context.clone() })
    }
}

impl Motion {
    /// What there is to say about tracked points, as JSON.
    pub fn point_report(&self, points: &ControlPoints) -> Result<String> {
        sys::point_report(&self.context.0, self.id, points.id)
    }
}

impl Drop for ControlPoints {
    fn drop(&mut self) {
        sys::control_points_destroy(&self.context.0, self.id);
    }
}
