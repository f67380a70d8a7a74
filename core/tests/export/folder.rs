//! The creature's folder: complete, replaced as a whole, and untouched by failures.

use std::path::Path;

use marey::export::report::Report;
use marey::export::{CreatureFiles, FolderOptions, write_creature, write_mask_folder};
use marey::job::Progress;
use marey::motion::Motion;
use marey::raster::Mask;
use marey::shape::creature::Creature;
use marey::{Error, Result};

use crate::model::animal;
use crate::scene::{Scene, listing};

const FRAMES: usize = 5;

fn write(scene: &Scene, masks: &[Mask], creature: &Creature, target: &Path, obj: bool) -> Result<Report> {
    let clip = scene.clip();
    let files = CreatureFiles { clip: &clip, rig: &scene.rig, motion: &scene.motion, masks, creature };
    let mut options = FolderOptions::default();
    options.obj = obj;
    let mut report = Report::new(clip.info(), &scene.rig, &scene.motion);
    write_creature(target, &files, &options, &mut report, Progress::new().whole())?;
    Ok(report)
}

#[test]
fn holds_everything_it_says() {
    let scene = Scene::new(FRAMES);
    let target = scene.scratch("deep/creature");
    let report = write(&scene, &scene.masks, &animal(FRAMES).into(), &target, true).expect("written");
    for name in &report.outputs {
        assert!(target.join(name).exists(), "{name}");
    }
    assert_eq!(Motion::read(target.join("motion.json")).expect("a motion"), scene.motion);
    for (f, mask) in scene.masks.iter().enumerate() {
        let image = image::open(target.join(format!("masks/{f:05}.png"))).expect("a mask");
        assert_eq!(image.color(), image::ColorType::L8);
        let image = image.to_luma8();
        assert!(image.pixels().all(|p| p.0[0] == 0 || p.0[0] == 255));
        assert_eq!(&Mask::from_image(&image), mask);
    }
    let text = std::fs::read_to_string(target.join("report.json")).expect("a report");
    let read: Report = serde_json::from_str(&text).expect("a report");
    assert_eq!((read.counts.limbs, read.counts.frames, read.counts.key_frames), (2, FRAMES, 1));
    // The leg is trusted less and less, and the body always.
    assert_eq!(read.correct_next[0].frame, FRAMES - 1);
    assert!(read.correct_next.iter().all(|c| c.limb == "leg_far" && c.frame > 0));
    assert!(read.stages.iter().all(|s| s.seconds >= 0.0) && read.stages.len() == 5);
    let beside = listing(target.parent().expect("a parent"));
    assert!(beside.iter().all(|n| n.starts_with("creature")), "nothing is left beside it: {beside:?}");
}

#[test]
fn replaces_what_is_ours_and_nothing_else() {
    let scene = Scene::new(FRAMES);
    let target = scene.scratch("creature");
    std::fs::create_dir_all(&target).expect("a folder");
    std::fs::write(target.join("notes.txt"), "mine").expect("written");
    write(&scene, &scene.masks, &animal(FRAMES).into(), &target, true).expect("written into a folder with a note");
    let first = std::fs::read(target.join("creature.glb")).expect("a creature");
    assert!(target.join("meshes/00000.obj").exists());

    let mut other = Creature::from(animal(FRAMES));
    other.model.parts.pop();
    write(&scene, &scene.masks, &other, &target, false).expect("written again");
    assert_ne!(std::fs::read(target.join("creature.glb")).expect("a creature"), first);
    assert!(!target.join("meshes").exists(), "what is no longer made does not stay");
    assert_eq!(std::fs::read_to_string(target.join("notes.txt")).expect("the note"), "mine");
}

#[test]
fn a_failure_leaves_what_was_there() {
    let scene = Scene::new(FRAMES);
    let (fresh, used) = (scene.scratch("fresh"), scene.scratch("used"));
    write(&scene, &scene.masks, &animal(FRAMES).into(), &used, true).expect("written");
    let before = listing(&used);
    let old = std::fs::read(used.join("creature.glb")).expect("a creature");

    // Creature and masks are written by then; the overlay finds that they do not fit.
    let mut other = Creature::from(animal(FRAMES));
    other.model.parts.pop();
    for target in [&fresh, &used] {
        assert!(write(&scene, &scene.masks[..2], &other, target, true).is_err());
    }
    let clip = scene.clip();
    let files =
        CreatureFiles { clip: &clip, rig: &scene.rig, motion: &scene.motion, masks: &scene.masks, creature: &other };
    for target in [&fresh, &used] {
        let progress = Progress::new();
        progress.cancel();
        let mut report = Report::new(clip.info(), &scene.rig, &scene.motion);
        let result = write_creature(target, &files, &FolderOptions::default(), &mut report, progress.whole());
        assert!(matches!(result, Err(Error::Cancelled)));
    }
    assert_eq!(listing(&used), before);
    assert_eq!(std::fs::read(used.join("creature.glb")).expect("a creature"), old);
    let beside = std::fs::read_dir(used.parent().expect("a parent")).expect("listed").count();
    assert_eq!(beside, 1, "no trace of the failed runs");
}

#[test]
fn refuses_places_that_are_somebody_elses() {
    let scene = Scene::new(FRAMES);
    let target = scene.scratch("mine");
    std::fs::create_dir_all(target.join("masks")).expect("a folder");
    std::fs::write(target.join("masks/00000.png"), "painted by hand").expect("written");
    let error = write(&scene, &scene.masks, &animal(FRAMES).into(), &target, false).expect_err("my masks");
    assert!(error.to_string().contains("`masks`") && error.to_string().contains("mine"), "{error}");
    assert_eq!(listing(&target), ["masks", "masks/00000.png"]);

    let file = target.join("masks/00000.png");
    for target in [file.clone(), file.join("below")] {
        let error = write(&scene, &scene.masks, &animal(FRAMES).into(), &target, false).expect_err("a file");
        assert!(error.to_string().contains("00000.png"), "{error}");
    }
    assert_eq!(std::fs::read_to_string(&file).expect("the mask"), "painted by hand");
}

#[test]
fn masks_alone_have_a_folder_that_can_be_written_again() {
    let scene = Scene::new(FRAMES);
    let target = scene.scratch("masks");
    let report = Report::new(scene.clip().info(), &scene.rig, &scene.motion);
    let write = |masks: &[Mask], target: &Path| write_mask_folder(target, masks, &report, Progress::new().whole());
    write(&scene.masks, &target).expect("written");
    write(&scene.masks[..3], &target).expect("written again");
    assert_eq!(listing(&target), ["00000.png", "00001.png", "00002.png", "report.json"]);
    // A folder of frames is no place for masks, whatever the names.
    let error = write(&scene.masks, scene.path()).expect_err("the clip itself");
    assert!(error.to_string().contains("00000.png"), "{error}");
}
