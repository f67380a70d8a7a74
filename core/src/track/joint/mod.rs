//! The built-in joint tracker: joints marked on one frame, followed through the clip.
//!
//! Base: Pan and Zhang 2011, section 4.1 (joint templates, prediction from the joints' velocities). Templates become
//! whole parts that turn with their bones (see `parts`), and prediction a motion that is steady over the whole clip (see
//! `pose_path`), so that what is hidden is bridged from both sides.
//!
//! Marks are a history: first the frame on which all joints are marked leads to the whole clip; then every frame with
//! corrections, in the order they were made, re-solves what lies between the marked frames beside it. So a correction
//! changes nothing beyond those, to the bit, whether it is made now or was there from the start.
//!
//! Known limits: parts are learned where all joints are marked and do not change their looks; what is hidden there is
//! known only by what is seen of it.

mod limb;
mod params;
mod parts;
mod pose_path;
mod report;
mod scene;
mod solve;
#[cfg(test)]
mod tests;
mod tree;

pub use params::JointParams;
pub use report::{BoneLength, CaptureReport, JointConfidence, JointCorrection};

use std::ops::Range;

use glam::Vec2;

use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::{Motion, Track, TrackFrame, TrackKind};
use crate::rig::JointMarks;
use parts::Part;
use scene::Scene;
use solve::{Character, Pins, Place};
use tree::{Chain, Tree};

/// Tracks joints.
#[derive(Clone, Debug, Default)]
pub struct JointTracker {
    /// How.
    pub params: JointParams,
}

/// What was captured before.
#[derive(Clone, Copy, Debug)]
pub struct EarlierCapture<'a> {
    /// The motion.
    pub motion: &'a Motion,
    /// The marks that led to it.
    pub marks: &'a JointMarks,
}

/// Frames beside a range that is solved anew, so that it joins what stands without a jump in its motion.
const MARGIN: usize = 2;
/// Distance in working pixels, from places that nobody marked, within which it is looked whether they are seen.
const TIP_RADIUS: f32 = 6.0;
/// Share of the work that is reading.
const READING: f64 = 0.15;

impl super::TrackJoints for JointTracker {
    fn track_joints(&self, clip: &Clip, marks: &JointMarks, stage: Stage<'_>) -> Result<Motion> {
        self.capture(clip, marks, None, stage)
    }

    fn retrack_joints(
        &self,
        clip: &Clip,
        marks: &JointMarks,
        earlier: EarlierCapture<'_>,
        stage: Stage<'_>,
    ) -> Result<Motion> {
        self.capture(clip, marks, Some(earlier), stage)
    }
}

impl JointTracker {
    fn capture(
        &self,
        clip: &Clip,
        marks: &JointMarks,
        earlier: Option<EarlierCapture<'_>>,
        stage: Stage<'_>,
    ) -> Result<Motion> {
        let info = clip.info();
        marks.validate(Some(((info.width, info.height), info.frames)))?;
        let whole = marks.whole_frame().unwrap_or(0);
        let (mut tracks, steps) = match earlier.filter(|e| holds(e, marks, info.frames)) {
            Some(earlier) => (earlier.motion.tracks.clone(), changed(earlier.marks, marks, info.frames)),
            None => (blank(marks, info.frames), history(marks, whole, info.frames)),
        };
        let mut looked_at = vec![false; info.frames];
        looked_at[whole] = true;
        for step in &steps {
            looked_at[widened(&step.range, info.frames)].fill(true);
        }
        stage.name("reading")?;
        let names = marks.names();
        let on_whole = names.iter().filter_map(|n| marks.mark(n, whole));
        let centres: Vec<Vec2> = on_whole.clone().map(|m| m.centre()).collect();
        let side = self.params.working_side;
        let scene = Scene::read(clip, side, &mut looked_at, (whole, &centres), stage.part(0.0, READING))?;
        stage.name("tracking")?;
        let mut tree = Tree::new(marks);
        let mut places: Vec<Vec2> = centres.iter().map(|p| *p * scene.scale).collect();
        let mut radii: Vec<f32> = on_whole.map(|m| 0.5 * scene.scale * m.rect[2].max(m.rect[3])).collect();
        let parts: Vec<Part> = parts::cut(&scene, whole, &radii, &mut tree, &mut places);
        radii.resize(places.len(), TIP_RADIUS);
        let chains: Vec<Chain> = tree.chains(&parts);
        let character = Character {
            scene: &scene,
            tree: &tree,
            parts: &parts,
            chains: &chains,
            places: &places,
            radii: &radii,
            params: &self.params,
        };
        let share = |i: usize| READING + (1.0 - READING) * i as f64 / steps.len().max(1) as f64;
        for (i, step) in steps.iter().enumerate() {
            let wide = widened(&step.range, info.frames);
            let mut pins: Pins = vec![vec![None; places.len()]; info.frames];
            for f in wide.clone() {
                for (j, track) in tracks.iter().enumerate() {
                    let held = if step.range.contains(&f) {
                        marks.mark(&track.name, f).filter(|_| step.marked.contains(&f)).map(|m| m.centre())
                    } else {
                        track.frames[f].points.first().copied()
                    };
                    pins[f][j] = held.map(|p| p * scene.scale);
                }
            }
            if wide.contains(&whole) {
                pins[whole] = places.iter().map(|p| Some(*p)).collect();
            }
            let solved = character.solve(wide.clone(), &pins, stage.part(share(i), share(i + 1)))?;
            for f in step.range.clone() {
                for (j, track) in tracks.iter_mut().enumerate() {
                    let mark = marks.mark(&track.name, f).filter(|_| step.marked.contains(&f));
                    let place = solved[f - wide.start][j];
                    track.frames[f] =
                        mark.map_or_else(|| frame_of(place, scene.scale), |m| TrackFrame::certain(vec![m.centre()]));
                }
            }
        }
        Ok(Motion { size: marks.size, fps: info.fps, frames: info.frames, tracks, bones: marks.bones.clone() })
    }
}

/// Frames that are solved anew, and those of them whose marks hold.
#[derive(Clone, Debug, PartialEq)]
struct Step {
    range: Range<usize>,
    marked: Vec<usize>,
}

/// From the frame on which all is marked to the whole clip, then correction by correction.
fn history(marks: &JointMarks, whole: usize, frames: usize) -> Vec<Step> {
    let mut steps = vec![Step { range: 0..frames, marked: vec![whole] }];
    let mut known = vec![whole];
    for frame in marks.frames().into_iter().filter(|&f| f != whole) {
        steps.push(Step { range: between(&known, frame, frames), marked: vec![frame] });
        known.push(frame);
    }
    steps
}

/// The frames around `frame` that are between those of `known`.
fn between(known: &[usize], frame: usize, frames: usize) -> Range<usize> {
    let before = known.iter().filter(|&&k| k < frame).max().map_or(0, |k| k + 1);
    let after = known.iter().filter(|&&k| k > frame).min().copied().unwrap_or(frames);
    before..after.min(frames)
}

/// Whether an earlier motion is of the same joints, learned on the same frame from the same marks.
fn holds(earlier: &EarlierCapture<'_>, marks: &JointMarks, frames: usize) -> bool {
    let (old, motion) = (earlier.marks, earlier.motion);
    let names = marks.names();
    let whole = marks.whole_frame();
    let same_tracks = motion.tracks.len() == names.len()
        && motion
            .tracks
            .iter()
            .zip(&names)
            .all(|(t, n)| t.name == *n && t.frames.len() == frames && t.frames.iter().all(|f| f.points.len() == 1));
    let same_marks = |whole: usize| names.iter().all(|n| old.mark(n, whole) == marks.mark(n, whole));
    same_tracks
        && motion.size == marks.size
        && motion.frames == frames
        && old.names() == names
        && old.bones == marks.bones
        && old.whole_frame() == whole
        && whole.is_some_and(same_marks)
}

/// What has to be solved anew where the marks of `old` became those of `new`.
fn changed(old: &JointMarks, new: &JointMarks, frames: usize) -> Vec<Step> {
    let names = new.names();
    let mut marked: Vec<usize> = old.frames().into_iter().chain(new.frames()).filter(|&f| f < frames).collect();
    marked.sort_unstable();
    marked.dedup();
    let at = |marks: &JointMarks, f: usize| -> Vec<Option<Vec2>> {
        names.iter().map(|n| marks.mark(n, f).map(|m| m.centre())).collect()
    };
    let (same, different): (Vec<usize>, Vec<usize>) = marked.into_iter().partition(|&f| at(old, f) == at(new, f));
    let mut steps: Vec<Step> = Vec::new();
    for frame in different {
        let range = between(&same, frame, frames);
        let still = new.frames().contains(&frame);
        match steps.last_mut().filter(|s| s.range == range) {
            Some(step) => step.marked.extend(still.then_some(frame)),
            None => steps.push(Step { range, marked: still.then_some(frame).into_iter().collect() }),
        }
    }
    steps
}

fn widened(range: &Range<usize>, frames: usize) -> Range<usize> {
    range.start.saturating_sub(MARGIN)..(range.end + MARGIN).min(frames)
}

/// Tracks that know nothing yet.
fn blank(marks: &JointMarks, frames: usize) -> Vec<Track> {
    let track = |name: &str| Track {
        name: name.to_owned(),
        kind: TrackKind::Joint,
        frames: vec![TrackFrame::certain(vec![Vec2::ZERO]); frames],
    };
    marks.names().into_iter().map(track).collect()
}

fn frame_of(place: Place, scale: f32) -> TrackFrame {
    TrackFrame {
        points: vec![place.at / scale],
        visible: vec![place.visible],
        confidence: vec![place.confidence.clamp(0.0, 1.0)],
    }
}
