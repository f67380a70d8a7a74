//! report.json: what a run did, how long each stage took, what a person should know, and what to correct next.
//!
//! Key frames are worth more than any algorithm, so the report says where one more stroke would help most: the limbs
//! and frames whose tracked places are trusted least. Unknown keys are ignored on reading.

use serde::{Deserialize, Serialize};

use crate::clip::ClipInfo;
use crate::motion::Motion;
use crate::raster::Mask;
use crate::rig::Rig;
use crate::shape::RiggedModel;

/// The `format` of every report.
pub const FORMAT: &str = "marey-report";
const VERSION: u32 = 1;
/// How many corrections a report suggests.
const SUGGESTIONS: usize = 5;
/// Suggestions for one limb keep this share of the clip between them: a stroke also helps its neighbours.
const SUGGESTION_GAP: f32 = 0.1;
/// A limb whose share of seen points is below this is worth a warning, and so is one trusted less than that on average.
const HARDLY: f32 = 0.05;
const DOUBTED: f32 = 0.3;

/// What a run did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Always `marey-report`.
    pub format: String,
    /// Version of the format.
    pub version: u32,
    /// The program's version.
    pub generator: String,
    /// The clip.
    pub clip: ClipSummary,
    /// What was made.
    pub counts: Counts,
    /// The stages in the order they ran, with their wall time.
    pub stages: Vec<StageSeconds>,
    /// The sum of the stages' seconds.
    pub total_seconds: f64,
    /// What a person should know, one sentence each.
    pub warnings: Vec<String>,
    /// How far each limb is to be trusted, in the rig's order.
    pub limbs: Vec<LimbConfidence>,
    /// The strokes that would help most, the most helpful first.
    pub correct_next: Vec<Correction>,
    /// The settings the caller ran with, as the caller put them.
    #[serde(default)]
    pub settings: serde_json::Value,
    /// Files and folders written, relative to the report.
    #[serde(default)]
    pub outputs: Vec<String>,
}

/// The clip of a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClipSummary {
    /// What read it.
    pub source: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Frames read.
    pub frames: usize,
    /// Mean frames a second.
    pub fps: f64,
}

/// How much was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Frames of the motion.
    pub frames: usize,
    /// Key frames that were drawn on.
    pub key_frames: usize,
    /// Limbs.
    pub limbs: usize,
    /// Bones of the model.
    pub bones: usize,
    /// Vertices of all parts.
    pub vertices: usize,
    /// Triangles of all parts.
    pub triangles: usize,
    /// Texels of all parts.
    pub texels: usize,
}

/// How long a stage took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageSeconds {
    /// The stage.
    pub name: String,
    /// Its wall time.
    pub seconds: f64,
}

/// How far one limb is to be trusted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimbConfidence {
    /// The limb's label.
    pub limb: String,
    /// Mean confidence over all frames and points, 0..=1.
    pub mean: f32,
    /// The lowest mean of any frame.
    pub lowest: f32,
    /// The frame where that is.
    pub lowest_frame: usize,
    /// The share of points seen, over all frames.
    pub visible: f32,
}

/// A stroke worth drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Correction {
    /// The frame to draw on.
    pub frame: usize,
    /// The limb to draw.
    pub limb: String,
    /// How far it is trusted there now, 0..=1.
    pub confidence: f32,
}

impl Report {
    /// A report of a clip and what was tracked in it; stages, model and outputs are added as they come.
    pub fn new(clip: &ClipInfo, rig: &Rig, motion: &Motion) -> Self {
        let means = frame_means(motion);
        let limbs = limb_confidences(motion, &means);
        let mut warnings = clip.warnings.clone();
        warnings.extend(limbs.iter().filter_map(LimbConfidence::warning));
        Self {
            format: FORMAT.into(),
            version: VERSION,
            generator: concat!("marey ", env!("CARGO_PKG_VERSION")).into(),
            clip: ClipSummary {
                source: clip.source.into(),
                width: clip.width,
                height: clip.height,
                frames: clip.frames,
                fps: clip.fps,
            },
            counts: Counts {
                frames: motion.frames,
                key_frames: rig.keyframes.iter().filter(|k| !k.strokes.is_empty()).count(),
                limbs: rig.limbs.len(),
                ..Counts::default()
            },
            stages: Vec::new(),
            total_seconds: 0.0,
            warnings,
            limbs,
            correct_next: corrections_by(motion, rig, &means),
            settings: serde_json::Value::Null,
            outputs: Vec::new(),
        }
    }

    /// Warns of frames whose mask is empty.
    pub fn check_masks(&mut self, masks: &[Mask]) {
        let empty: Vec<usize> = masks.iter().enumerate().filter(|(_, m)| m.count() == 0).map(|(f, _)| f).collect();
        if let Some(first) = empty.first() {
            let count = empty.len();
            self.warnings.push(format!("the creature was found in none of {count} frames, the first of them {first}"));
        }
    }

    /// Counts what the model is made of.
    pub fn count_model(&mut self, model: &RiggedModel) {
        self.counts.bones = model.bones.len();
        self.counts.vertices = model.parts.iter().map(|p| p.mesh.positions.len()).sum();
        self.counts.triangles = model.parts.iter().map(|p| p.mesh.triangles.len()).sum();
        self.counts.texels = model.parts.iter().map(|p| p.texture.width() as usize * p.texture.height() as usize).sum();
    }

    /// Adds a stage that took `seconds`.
    pub fn stage(&mut self, name: &str, seconds: f64) {
        self.stages.push(StageSeconds { name: name.into(), seconds: (seconds * 1e4).round() / 1e4 });
        self.total_seconds = (self.stages.iter().map(|s| s.seconds).sum::<f64>() * 1e4).round() / 1e4;
    }

    /// Adds an output that was written since `began`.
    pub(super) fn wrote(&mut self, name: &str, began: std::time::Instant) {
        self.outputs.push(name.into());
        self.stage(&format!("write {name}"), began.elapsed().as_secs_f64());
    }

    /// The text of report.json.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

impl LimbConfidence {
    fn warning(&self) -> Option<String> {
        let Self { limb, mean, lowest_frame, visible, .. } = self;
        if *visible < HARDLY {
            return Some(format!("limb `{limb}` is seen in hardly any frame: its motion is a guess"));
        }
        (*mean < DOUBTED).then(|| {
            format!("limb `{limb}` is trusted little ({mean:.2} of 1): draw it on frame {lowest_frame} as well")
        })
    }
}

/// For each track and frame the mean confidence of its points.
fn frame_means(motion: &Motion) -> Vec<Vec<f32>> {
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len().max(1) as f32;
    motion.tracks.iter().map(|t| t.frames.iter().map(|f| mean(&f.confidence)).collect()).collect()
}

fn limb_confidences(motion: &Motion, means: &[Vec<f32>]) -> Vec<LimbConfidence> {
    let summary = |(track, means): (&crate::motion::Track, &Vec<f32>)| {
        let (lowest_frame, lowest) =
            means.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 1.0));
        let points: usize = track.frames.iter().map(|f| f.visible.len()).sum();
        let seen: usize = track.frames.iter().map(|f| f.visible.iter().filter(|v| **v).count()).sum();
        LimbConfidence {
            limb: track.name.clone(),
            mean: means.iter().sum::<f32>() / means.len().max(1) as f32,
            lowest,
            lowest_frame,
            visible: seen as f32 / points.max(1) as f32,
        }
    };
    motion.tracks.iter().zip(means).map(summary).collect()
}

/// The strokes that would help most: the least trusted limb and frame, then the next that is not just its neighbour.
/// What is drawn in `rig` is never among them.
pub fn corrections(motion: &Motion, rig: &Rig) -> Vec<Correction> {
    corrections_by(motion, rig, &frame_means(motion))
}

fn corrections_by(motion: &Motion, rig: &Rig, means: &[Vec<f32>]) -> Vec<Correction> {
    let drawn = |name: &str, frame: usize| {
        rig.limbs.iter().position(|l| l.label == name).is_some_and(|limb| rig.stroke(limb, frame).is_some())
    };
    let mut places: Vec<(f32, usize, usize)> = Vec::new();
    for (track, means) in means.iter().enumerate() {
        for (frame, &mean) in means.iter().enumerate() {
            if mean < 1.0 && !drawn(&motion.tracks[track].name, frame) {
                places.push((mean, frame, track));
            }
        }
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let gap = (motion.frames as f32 * SUGGESTION_GAP).ceil() as usize;
    let mut chosen: Vec<(f32, usize, usize)> = Vec::new();
    for place in places {
        if chosen.iter().all(|c| c.2 != place.2 || c.1.abs_diff(place.1) > gap) {
            chosen.push(place);
            if chosen.len() == SUGGESTIONS {
                break;
            }
        }
    }
    let name = |track: usize| motion.tracks[track].name.clone();
    chosen.into_iter().map(|(confidence, frame, t)| Correction { frame, limb: name(t), confidence }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Track, TrackFrame, TrackKind};
    use crate::rig::{KeyFrame, Limb, Stroke};
    use glam::Vec2;

    /// A limb that is trusted `1 - doubt(frame)` and seen where `seen(frame)`.
    fn track(name: &str, doubt: impl Fn(usize) -> f32, seen: impl Fn(usize) -> bool) -> Track {
        let points = vec![Vec2::ZERO, Vec2::ONE];
        let at =
            |f| TrackFrame { visible: vec![seen(f); 2], confidence: vec![1.0 - doubt(f); 2], points: points.clone() };
        Track { name: name.into(), kind: TrackKind::Stroke, frames: (0..40).map(at).collect() }
    }

    #[test]
    fn says_what_to_draw_next() {
        let limb = |label: &str| Limb { label: label.into(), side: None };
        let stroke = |limb| Stroke { limb, points: vec![Vec2::ZERO, Vec2::X * 9.0], facing: None };
        let rig = Rig {
            size: (10, 10),
            limbs: vec![limb("sure"), limb("lost"), limb("hidden")],
            keyframes: vec![KeyFrame { frame: 20, strokes: (0..3).map(stroke).collect(), ..KeyFrame::default() }],
        };
        let lost = |f: usize| if f == 20 { 0.95 } else { 0.9 - 0.01 * f.abs_diff(20) as f32 };
        let tracks = vec![
            track("sure", |_| 0.0, |_| true),
            track("lost", lost, |_| true),
            track("hidden", |_| 0.1, |f| f == 20),
        ];
        let motion = Motion { size: (10, 10), fps: 24.0, frames: 40, tracks, bones: Vec::new() };
        let clip = ClipInfo {
            width: 10,
            height: 10,
            frames: 40,
            fps: 24.0,
            source: "memory",
            warnings: vec!["truncated after frame 39".into()],
        };
        let mut report = Report::new(&clip, &rig, &motion);
        let named: Vec<(&str, usize)> = report.correct_next.iter().map(|c| (c.limb.as_str(), c.frame)).collect();
        // The drawn frame itself is no suggestion, however little it is trusted, and neighbours are not repeated.
        assert_eq!(named[..3], [("lost", 19), ("lost", 24), ("lost", 14)]);
        assert_eq!(report.warnings.len(), 3, "{:?}", report.warnings);
        assert!(report.warnings[0].contains("truncated") && report.warnings[1].contains("lost"));
        assert!(report.warnings[2].contains("hidden"));
        report.check_masks(&[Mask::from_fn(4, 4, |_, _| true), Mask::new(4, 4), Mask::new(4, 4)]);
        assert!(report.warnings[3].contains("2 frames") && report.warnings[3].ends_with('1'));
        let read: Report = serde_json::from_str(&report.to_json()).expect("readable");
        assert_eq!(read, report);
    }
}
