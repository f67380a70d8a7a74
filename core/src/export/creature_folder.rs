//! The folder of a creature: creature.glb, motion.json, masks, the two GIFs, report.json, and meshes on request.

use std::path::Path;
use std::time::Instant;

use super::folder::{REPORT, StagedFolder};
use super::gltf::{GltfOptions, glb};
use super::masks::write_masks;
use super::obj::write_obj;
use super::overlay::overlay;
use super::preview::preview;
use super::report::Report;
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::Motion;
use crate::raster::Mask;
use crate::rig::Rig;
use crate::shape::creature::Creature;

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
    pub creature: &'a Creature,
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

/// Whether a creature may be written into `target`: better asked before the work than after it.
///
/// # Errors
/// What [`write_creature`] would say of the target.
pub fn check_creature_folder(target: &Path) -> Result<()> {
    StagedFolder::begin(target, is_ours).map(drop)
}

fn is_ours(name: &str) -> bool {
    OURS.contains(&name)
}

/// Writes the folder, whole or not at all, and adds to `report` what was written and how long it took.
///
/// # Errors
/// A folder that cannot be written or is somebody else's ([`StagedFolder::begin`]), parts that do not fit each other,
/// or a cancel.
pub fn write_creature(
    target: &Path,
    files: &CreatureFiles<'_>,
    options: &FolderOptions,
    report: &mut Report,
    stage: Stage<'_>,
) -> Result<()> {
    let &CreatureFiles { clip, rig, motion, masks, creature } = files;
    let folder = StagedFolder::begin(target, is_ours)?;

    stage.name("writing creature.glb")?;
    let began = Instant::now();
    let gltf = GltfOptions { scale: options.scale, ..GltfOptions::default() };
    folder.write("creature.glb", &glb(creature, &gltf, stage.part(0.0, 0.1))?)?;
    report.wrote("creature.glb", began);

    stage.part(0.1, 0.25).name("writing masks")?;
    let began = Instant::now();
    folder.write("motion.json", motion.to_json().as_bytes())?;
    folder.create_dir("masks")?;
    write_masks(&folder.path().join("masks"), masks, stage.part(0.1, 0.25))?;
    report.outputs.push("motion.json".into());
    report.wrote("masks", began);

    if options.gifs {
        stage.part(0.25, 0.5).name("writing overlay.gif")?;
        let began = Instant::now();
        folder.write("overlay.gif", &overlay(clip, rig, motion, masks, stage.part(0.25, 0.5))?)?;
        report.wrote("overlay.gif", began);

        stage.part(0.5, 0.8).name("writing preview.gif")?;
        let began = Instant::now();
        folder.write("preview.gif", &preview(&creature.model, stage.part(0.5, 0.8))?)?;
        report.wrote("preview.gif", began);
    }
    if options.obj {
        stage.part(0.8, 1.0).name("writing meshes")?;
        let began = Instant::now();
        folder.create_dir("meshes")?;
        write_obj(&folder.path().join("meshes"), &creature.model, stage.part(0.8, 1.0))?;
        report.wrote("meshes", began);
    }
    report.outputs.push(REPORT.into());
    folder.write(REPORT, report.to_json().as_bytes())?;
    stage.at(1.0)?;
    folder.commit()
}
