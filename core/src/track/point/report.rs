//! What there is to say about tracked points: how far each is to be trusted, and what to correct next.

use serde::{Deserialize, Serialize};

use crate::motion::Motion;
use crate::rig::PointMarks;
use crate::track::confidence::{Confidence, doubts};

/// Tracked points in words and numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointReport {
    /// Always `marey-point-report`.
    pub format: String,
    /// Version of the format.
    pub version: u32,
    /// Frames tracked.
    pub frames: usize,
    /// How many keys the user made.
    pub keys: usize,
    /// Share of points and frames that are seen.
    pub visible: f32,
    /// Mean confidence of all points and frames.
    pub confidence: f32,
    /// The points in the marks' order.
    pub points: Vec<PointConfidence>,
    /// The keys that would help most, the most helpful first.
    pub correct_next: Vec<PointCorrection>,
}

/// How far one point is to be trusted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointConfidence {
    /// The point's name.
    pub point: String,
    /// Mean confidence over all frames, 0..=1.
    pub mean: f32,
    /// The lowest of any frame.
    pub lowest: f32,
    /// The frame where that is.
    pub lowest_frame: usize,
    /// Share of frames in which it is seen.
    pub visible: f32,
}

/// A key worth making.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointCorrection {
    /// The frame to mark on.
    pub frame: usize,
    /// The point to mark.
    pub point: String,
    /// How far it is trusted there now, 0..=1.
    pub confidence: f32,
}

impl PointReport {
    /// The report of a motion that `marks` led to.
    pub fn new(marks: &PointMarks, motion: &Motion) -> Self {
        let all: Vec<Confidence> = motion.tracks.iter().map(Confidence::of).collect();
        let frames = all.iter().map(|c| c.frames).sum::<usize>().max(1);
        let points = motion.tracks.iter().zip(&all).map(|(track, c)| PointConfidence {
            point: track.name.clone(),
            mean: c.mean,
            lowest: c.lowest.0,
            lowest_frame: c.lowest.1,
            visible: c.visible(),
        });
        let corrections = doubts(motion).into_iter();
        Self {
            format: "marey-point-report".into(),
            version: 1,
            frames: motion.frames,
            keys: marks.points.iter().map(|p| p.keys.len()).sum(),
            visible: all.iter().map(|c| c.seen).sum::<usize>() as f32 / frames as f32,
            confidence: all.iter().map(|c| c.mean * c.frames as f32).sum::<f32>() / frames as f32,
            points: points.collect(),
            correct_next: corrections
                .map(|d| PointCorrection { frame: d.frame, point: d.track.to_owned(), confidence: d.confidence })
                .collect(),
        }
    }

    /// The report as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}
