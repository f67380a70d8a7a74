//! The whole job: a clip and a rig become a motion, masks, a creature, and on request a folder of files.
//!
//! [`creature`] computes, [`creature_to_folder`] also writes. The tracker and the segmenter may be anybody's, so what
//! they return is checked before the next stage relies on it.

use std::path::Path;
use std::time::Instant;

use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::export::report::Report;
use crate::export::{CreatureFiles, FolderOptions, check_creature_folder, write_creature};
use crate::job::Stage;
use crate::motion::Motion;
use crate::raster::Mask;
use crate::rig::Rig;
use crate::segment::Segmenter;
use crate::shape::creature::{Creature, CreatureParams, reconstruct};
use crate::track::Tracker;

/// The share of the time of [`creature_to_folder`] that computing takes; the rest is writing.
const COMPUTED: f64 = 0.85;
/// Where the stages of [`creature`] end, as shares of its time on clips like the ones it was measured with.
const TRACKED: f64 = 0.5;
const SEGMENTED: f64 = 0.75;

/// Who does each step, and how.
#[non_exhaustive]
pub struct PipelineOptions<'a> {
    /// Follows the limbs.
    pub tracker: &'a dyn Tracker,
    /// Cuts the creature out of every frame.
    pub segmenter: &'a dyn Segmenter,
    /// How the creature is built.
    pub creature: CreatureParams,
    /// Copied into the report, so that a run can be repeated.
    pub settings: serde_json::Value,
}

impl std::fmt::Debug for PipelineOptions<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PipelineOptions")
            .field("creature", &self.creature)
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

impl<'a> PipelineOptions<'a> {
    /// The defaults, with these two.
    pub fn new(tracker: &'a dyn Tracker, segmenter: &'a dyn Segmenter) -> Self {
        Self { tracker, segmenter, creature: CreatureParams::default(), settings: serde_json::Value::Null }
    }
}

/// What the whole job gives.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The limbs over time, one track a limb in the rig's order.
    pub motion: Motion,
    /// The creature's mask in every frame.
    pub masks: Vec<Mask>,
    /// The textured creature on its animated bones.
    pub creature: Creature,
    /// What was done, how long it took, and what to correct next.
    pub report: Report,
}

/// Tracks, segments and reconstructs.
///
/// # Errors
/// A rig that does not fit the clip, a frame that cannot be read, a cancel, or whatever a stage says.
pub fn creature(clip: &Clip, rig: &Rig, options: &PipelineOptions<'_>, stage: Stage<'_>) -> Result<Outcome> {
    let info = clip.info();
    rig.validate(Some(((info.width, info.height), info.frames)))?;

    let began = Instant::now();
    let track = stage.part(0.0, TRACKED);
    track.name("tracking")?;
    let motion = options.tracker.track(clip, rig, track)?;
    check_motion(clip, rig, &motion)?;
    let mut report = Report::new(info, rig, &motion);
    report.settings = options.settings.clone();
    report.stage("track", began.elapsed().as_secs_f64());

    let began = Instant::now();
    let segment = stage.part(TRACKED, SEGMENTED);
    segment.name("segmenting")?;
    let masks = options.segmenter.segment(clip, rig, &motion, segment)?;
    check_masks(clip, &masks)?;
    report.check_masks(&masks);
    report.stage("segment", began.elapsed().as_secs_f64());

    let began = Instant::now();
    let shape = stage.part(SEGMENTED, 1.0);
    shape.name("reconstructing")?;
    let creature = reconstruct(clip, rig, &motion, &masks, &options.creature, shape)?;
    creature.validate()?;
    report.count_model(&creature.model);
    report.stage("reconstruct", began.elapsed().as_secs_f64());
    stage.at(1.0)?;
    Ok(Outcome { motion, masks, creature, report })
}

/// [`creature`], and everything it made written into `target`, whole or not at all.
pub fn creature_to_folder(
    clip: &Clip,
    rig: &Rig,
    options: &PipelineOptions<'_>,
    target: &Path,
    files: &FolderOptions,
    stage: Stage<'_>,
) -> Result<Outcome> {
    check_creature_folder(target)?;
    let mut outcome = creature(clip, rig, options, stage.part(0.0, COMPUTED))?;
    outcome.report = outcome.write(clip, rig, target, files, stage.part(COMPUTED, 1.0))?;
    Ok(outcome)
}

impl Outcome {
    /// Writes everything into the folder `target`, whole or not at all, and gives the report as written there: with
    /// the outputs and how long they took. `clip` and `rig` are the ones it was made from.
    ///
    /// # Errors
    /// As [`write_creature`].
    pub fn write(
        &self,
        clip: &Clip,
        rig: &Rig,
        target: &Path,
        options: &FolderOptions,
        stage: Stage<'_>,
    ) -> Result<Report> {
        let Self { motion, masks, creature, report } = self;
        let mut report = report.clone();
        write_creature(target, &CreatureFiles { clip, rig, motion, masks, creature }, options, &mut report, stage)?;
        Ok(report)
    }
}

/// A tracker must give every limb a place in every frame.
fn check_motion(clip: &Clip, rig: &Rig, motion: &Motion) -> Result<()> {
    motion.validate()?;
    let info = clip.info();
    let expected =
        format!("expected {} tracks of {} frames at {}x{}", rig.limbs.len(), info.frames, info.width, info.height);
    if motion.tracks.len() != rig.limbs.len()
        || motion.frames != info.frames
        || motion.size != (info.width, info.height)
    {
        let got = format!(
            "it gave {} tracks of {} frames at {}x{}",
            motion.tracks.len(),
            motion.frames,
            motion.size.0,
            motion.size.1
        );
        return Err(Error::invalid("tracker", got, expected));
    }
    for (track, limb) in motion.tracks.iter().zip(&rig.limbs) {
        if track.name != limb.label {
            let got = format!("it gave track `{}` where limb `{}` belongs", track.name, limb.label);
            return Err(Error::invalid("tracker", got, "tracks come in the rig's order"));
        }
    }
    Ok(())
}

/// A segmenter must give every frame a mask of the clip's size.
fn check_masks(clip: &Clip, masks: &[Mask]) -> Result<()> {
    let info = clip.info();
    if masks.len() != info.frames {
        let got = format!("it gave {} masks for {} frames", masks.len(), info.frames);
        return Err(Error::invalid("segmenter", got, "expected one a frame"));
    }
    for (frame, mask) in masks.iter().enumerate() {
        if (mask.width(), mask.height()) != (info.width as usize, info.height as usize) {
            let got = format!("mask {frame} is {}x{}", mask.width(), mask.height());
            return Err(Error::invalid("segmenter", got, format!("the clip is {}x{}", info.width, info.height)));
        }
    }
    Ok(())
}
