//! The folder of a creature: creature.glb, motion.json, masks, the two GIFs, report.json, and meshes on request.

use std::path::Path;
use std::time::Instant;

use super::folder::{REPORT, StagedFolder};
use super::masks::write_masks;
use super::report::Report;
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::Motion;
use crate::raster::Mask;
use crate::rig::Rig;
use crate::shape::RiggedModel;

const OURS: [&str; 7] = ["creature.glb", "motion.json", "masks", "overlay.gif", "preview.gif", REPORT, "meshes"];

/// What goes into the folder.
#[derive(Clone, Copy, Debug)]
pub struct CreatureFiles<'a> {
    /// The clip it came from.
    pub clip: &'a Clip,
    /// What was drawn on it.
    pub rig: &'a Rig,
    /// The limbs over time.
    pub motion: &'a Motion,
    /// The masks, one a frame.
    pub masks: &'a [Mask],
    /// The creature.
    pub model: &'a RiggedModel,
}

/// Which files to write, and how.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FolderOptions {
    /// Also `meshes/00000.obj` and so on, in world coordinates.
    pub obj: bool,
    /// overlay.gif and preview.gif.
    pub gifs: bool,
    /// Metres a world unit in creature.glb; 1 leaves a unit a pixel of the clip.
    pub scale: f32,
}

impl Default for FolderOptions {
    fn default() -> Self {
        Self { obj: false, gifs: true, scale: 1.0 }
    }
}

/// Writes the folder, whole or not at all, and adds to `report` what was written and how long it took.
pub fn write_creature(
    target: &Path,
    files: &CreatureFiles<'_>,
    options: &FolderOptions,
    report: &mut Report,
    stage: Stage<'_>,
) -> Result<()> {
    stage.name("writing")?;
    let _ = options;
    let folder = StagedFolder::begin(target, |name| OURS.contains(&name))?;

    let began = Instant::now();
    folder.write("motion.json", files.motion.to_json().as_bytes())?;
    folder.create_dir("masks")?;
    write_masks(&folder.path().join("masks"), files.masks, stage.part(0.1, 0.3))?;
    report.outputs.extend(["motion.json".into(), "masks".into()]);
    report.stage("write motion and masks", began.elapsed().as_secs_f64());

    report.outputs.push(REPORT.into());
    folder.write(REPORT, report.to_json().as_bytes())?;
    stage.at(1.0)?;
    folder.commit()
}
