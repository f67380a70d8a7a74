//! What there is to say about captured joints: how far each is to be trusted, what to correct next, and how bones
//! squash and stretch.

use serde::{Deserialize, Serialize};

use crate::clip::ClipInfo;
use crate::motion::Motion;
use crate::rig::JointMarks;
use crate::track::confidence::{Confidence, doubts};

/// A joint that is seen less often than this is worth a warning.
const HARDLY: f32 = 0.05;

/// A capture in words and numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaptureReport {
    /// Always `marey-capture-report`.
    pub format: String,
    /// Version of the format.
    pub version: u32,
    /// Frames captured.
    pub frames: usize,
    /// The frames that have marks, in the order they were made.
    pub marked_frames: Vec<usize>,
    /// Share of joints and frames that are seen.
    pub visible: f32,
    /// Mean confidence of all joints and frames.
    pub confidence: f32,
    /// The joints in the order they were first marked.
    pub joints: Vec<JointConfidence>,
    /// The bones as the marks list them.
    pub bones: Vec<BoneLength>,
    /// The marks that would help most, the most helpful first.
    pub correct_next: Vec<JointCorrection>,
    /// What a person should know, one sentence each.
    pub warnings: Vec<String>,
}

/// How far one joint is to be trusted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointConfidence {
    /// The joint's name.
    pub joint: String,
    /// Mean confidence over all frames, 0..=1.
    pub mean: f32,
    /// The lowest of any frame.
    pub lowest: f32,
    /// The frame where that is.
    pub lowest_frame: usize,
    /// Share of frames in which it is seen.
    pub visible: f32,
}

/// How a bone squashes and stretches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoneLength {
    /// Its joints, parent first.
    pub bone: (String, String),
    /// Its length where all joints are marked, in clip pixels.
    pub marked: f32,
    /// Its shortest and longest of all frames.
    pub shortest: f32,
    /// See [`Self::shortest`].
    pub longest: f32,
}

/// A mark worth making.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointCorrection {
    /// The frame to mark on.
    pub frame: usize,
    /// The joint to mark.
    pub joint: String,
    /// How far it is trusted there now, 0..=1.
    pub confidence: f32,
}

impl CaptureReport {
    /// The report of a motion that `marks` led to.
    pub fn new(clip: &ClipInfo, marks: &JointMarks, motion: &Motion) -> Self {
        let mut warnings = clip.warnings.clone();
        let mut joints = Vec::new();
        let all: Vec<Confidence> = motion.tracks.iter().map(Confidence::of).collect();
        for (track, c) in motion.tracks.iter().zip(&all) {
            if c.visible() < HARDLY {
                warnings.push(format!("joint `{}` is hardly ever seen", track.name));
            }
            let (joint, (lowest, lowest_frame)) = (track.name.clone(), c.lowest);
            joints.push(JointConfidence { joint, mean: c.mean, lowest, lowest_frame, visible: c.visible() });
        }
        let count = all.iter().map(|c| c.frames).sum::<usize>().max(1);
        let whole = marks.whole_frame();
        let bones = marks.bones.iter().filter_map(|bone| bone_length(motion, bone, whole)).collect();
        Self {
            format: "marey-capture-report".into(),
            version: 1,
            frames: motion.frames,
            marked_frames: marks.frames(),
            visible: all.iter().map(|c| c.seen).sum::<usize>() as f32 / count as f32,
            confidence: all.iter().map(|c| c.mean * c.frames as f32).sum::<f32>() / count as f32,
            joints,
            bones,
            correct_next: doubts(motion)
                .into_iter()
                .map(|d| JointCorrection { frame: d.frame, joint: d.track.to_owned(), confidence: d.confidence })
                .collect(),
            warnings,
        }
    }

    /// The report as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

fn bone_length(motion: &Motion, bone: &(String, String), whole: Option<usize>) -> Option<BoneLength> {
    let (from, to) = (motion.track(&bone.0)?, motion.track(&bone.1)?);
    let frames = from.frames.iter().zip(&to.frames);
    let lengths: Vec<f32> = frames.filter_map(|(a, b)| Some(a.points.first()?.distance(*b.points.first()?))).collect();
    let shortest = lengths.iter().copied().reduce(f32::min)?;
    let longest = lengths.iter().copied().reduce(f32::max)?;
    Some(BoneLength { bone: bone.clone(), marked: lengths.get(whole?).copied()?, shortest, longest })
}
