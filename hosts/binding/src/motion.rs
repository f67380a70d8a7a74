//! Motions: limbs over time.

use marey_ffi::{mry_motion, mry_rig};

use crate::{Clip, Context, Result, Rig, sys};

/// Named tracks over time.
#[derive(Debug)]
pub struct Motion {
    pub(crate) id: mry_motion,
    pub(crate) context: Context,
}

/// What a motion is.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionInfo {
    /// How many frames every track has.
    pub frames: u64,
    /// Frames a second.
    pub fps: f64,
    /// The tracks' names, in the rig's order.
    pub tracks: Vec<String>,
}

/// A track in one frame; three lists of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackFrame {
    /// Places in clip pixels.
    pub points: Vec<(f32, f32)>,
    /// Whether each is seen.
    pub visible: Vec<bool>,
    /// How far each is to be trusted, 0..=1.
    pub confidence: Vec<f32>,
}

/// A stroke that is worth drawing next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// The track to draw.
    pub track: u32,
    /// The frame to draw it on.
    pub frame: u64,
    /// How far it is trusted there now.
    pub confidence: f32,
}

impl Motion {
    /// What it is.
    pub fn info(&self) -> Result<MotionInfo> {
        let info = sys::motion_info(&self.context.0, self.id)?;
        let name = |track| sys::motion_track_name(&self.context.0, self.id, track);
        let tracks = (0..info.track_count).map(name).collect::<Result<_>>()?;
        Ok(MotionInfo { frames: info.frame_count, fps: info.fps, tracks })
    }

    /// Where a track is in a frame.
    pub fn frame(&self, track: u32, frame: u64) -> Result<TrackFrame> {
        let (points, visible, confidence) = sys::motion_frame(&self.context.0, self.id, track, frame)?;
        Ok(TrackFrame {
            points: points.iter().map(|p| (p.x, p.y)).collect(),
            visible: visible.iter().map(|v| *v != 0).collect(),
            confidence,
        })
    }

    /// The strokes that would help most, the most helpful first, without what is drawn in `rig`.
    pub fn corrections(&self, rig: Option<&Rig>) -> Result<Vec<Correction>> {
        let rig = rig.map_or(mry_rig::default(), |r| r.id);
        let mut corrections = Vec::new();
        for index in 0.. {
            let Some(c) = sys::motion_correction(&self.context.0, self.id, rig, index)? else { break };
            corrections.push(Correction { track: c.track, frame: c.frame, confidence: c.confidence });
        }
        Ok(corrections)
    }

    /// The text of a report.json about the tracking.
    pub fn report(&self, clip: &Clip, rig: &Rig) -> Result<String> {
        sys::motion_report(&self.context.0, self.id, clip.id, rig.id)
    }

    /// The text of a motion.json.
    pub fn to_json(&self) -> Result<String> {
        sys::motion_to_json(&self.context.0, self.id)
    }

    /// Writes motion.json, whole or not at all.
    pub fn write(&self, path: &str) -> Result<()> {
        sys::motion_write(&self.context.0, self.id, path)
    }
}

impl Drop for Motion {
    fn drop(&mut self) {
        sys::motion_destroy(&self.context.0, self.id);
    }
}
