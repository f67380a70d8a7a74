//! The whole job with a tracker and a segmenter that know the truth, and with ones that do not keep their word.

use marey::clip::Clip;
use marey::export::FolderOptions;
use marey::export::gltf::{GltfOptions, glb};
use marey::export::report::Report;
use marey::job::{Progress, Stage};
use marey::motion::Motion;
use marey::pipeline::{Outcome, PipelineOptions, creature, creature_to_folder};
use marey::raster::Mask;
use marey::rig::Rig;
use marey::segment::Segmenter;
use marey::track::Tracker;
use marey::{Error, Result};

use crate::scene::{Scene, listing};

/// Answers with what it holds, and cancels the job first when it is told to.
struct Known<T> {
    answer: T,
    cancels: Option<Progress>,
}

impl<T> Known<T> {
    fn new(answer: T) -> Self {
        Self { answer, cancels: None }
    }

    fn before(&self, stage: Stage<'_>) -> Result<()> {
        if let Some(progress) = &self.cancels {
            progress.cancel();
        }
        stage.at(0.5)
    }
}

impl Tracker for Known<Motion> {
    fn track(&self, _: &Clip, _: &Rig, stage: Stage<'_>) -> Result<Motion> {
        self.before(stage)?;
        Ok(self.answer.clone())
    }
}

impl Segmenter for Known<Vec<Mask>> {
    fn segment(&self, _: &Clip, _: &Rig, _: &Motion, stage: Stage<'_>) -> Result<Vec<Mask>> {
        self.before(stage)?;
        Ok(self.answer.clone())
    }
}

fn run(scene: &Scene, motion: Motion, masks: Vec<Mask>) -> Result<Outcome> {
    let (tracker, segmenter) = (Known::new(motion), Known::new(masks));
    let mut options = PipelineOptions::new(&tracker, &segmenter);
    options.settings = serde_json::json!({"tracker": "known"});
    creature(&scene.clip(), &scene.rig, &options, Progress::new().whole())
}

#[test]
fn truth_in_makes_a_creature_that_fits_the_clip() {
    let scene = Scene::new(8);
    let outcome = run(&scene, scene.motion.clone(), scene.masks.clone()).expect("a creature");
    assert_eq!(outcome.motion, scene.motion);
    let report = &outcome.report;
    let names: Vec<&str> = report.stages.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["track", "segment", "reconstruct"]);
    assert_eq!(report.settings["tracker"], "known");
    assert!(report.counts.vertices > 100 && report.counts.bones > 2 && report.counts.texels > 100);
    let view = marey::raster::clip_view(scene.rig.size.1);
    for f in [0, 4, 7] {
        let mut raster = marey::raster::Rasterizer::new(scene.rig.size.0, scene.rig.size.1);
        for mesh in outcome.creature.model.pose(f) {
            raster.draw(&mesh, &view, marey::raster::Surface::Bare, 0);
        }
        let drawn = Mask::from_fn(raster.id.width(), raster.id.height(), |x, y| raster.id.get(x, y) == 0);
        let fit = drawn.iou(&scene.masks[f]);
        assert!(fit > 0.8, "frame {f}: {fit}");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let scene = Scene::new(5);
    let bytes = || {
        let outcome = run(&scene, scene.motion.clone(), scene.masks.clone()).expect("a creature");
        glb(&outcome.creature, &GltfOptions::default(), Progress::new().whole()).expect("a file")
    };
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("a pool");
    assert_eq!(pool(1).install(bytes), pool(3).install(bytes));
}

#[test]
fn the_folder_comes_with_the_progress_of_the_whole() {
    let scene = Scene::new(4);
    let (tracker, segmenter) = (Known::new(scene.motion.clone()), Known::new(scene.masks.clone()));
    let options = PipelineOptions::new(&tracker, &segmenter);
    let (target, progress) = (scene.scratch("creature"), Progress::new());
    let files = FolderOptions::default();
    let outcome = creature_to_folder(&scene.clip(), &scene.rig, &options, &target, &files, progress.whole());
    let outcome = outcome.expect("a creature");
    assert_eq!(progress.fraction(), 1.0);
    let text = std::fs::read_to_string(target.join("report.json")).expect("a report");
    assert_eq!(serde_json::from_str::<Report>(&text).expect("a report"), outcome.report);
    assert!(outcome.report.outputs.contains(&"creature.glb".to_owned()));
}

#[test]
fn a_cancel_in_any_stage_leaves_nothing() {
    let scene = Scene::new(4);
    for stage in 0..2 {
        let progress = Progress::new();
        let (mut tracker, mut segmenter) = (Known::new(scene.motion.clone()), Known::new(scene.masks.clone()));
        if stage == 0 {
            tracker.cancels = Some(progress.clone());
        } else {
            segmenter.cancels = Some(progress.clone());
        }
        let options = PipelineOptions::new(&tracker, &segmenter);
        let target = scene.scratch("creature");
        let files = FolderOptions::default();
        let result = creature_to_folder(&scene.clip(), &scene.rig, &options, &target, &files, progress.whole());
        assert!(matches!(result, Err(Error::Cancelled)));
        assert!(listing(target.parent().expect("a parent")).is_empty());
    }
}

#[test]
fn trackers_and_segmenters_are_held_to_their_word() {
    let scene = Scene::new(4);
    let refused = |motion: Motion, masks: Vec<Mask>, word: &str| {
        let error = run(&scene, motion, masks).expect_err(word);
        assert!(error.to_string().contains(word), "{error}");
    };
    let good = || scene.motion.clone();
    let masks = || scene.masks.clone();
    refused(Motion { tracks: good().tracks[..1].to_vec(), ..good() }, masks(), "tracker");
    refused(Motion { tracks: good().tracks.into_iter().rev().collect(), ..good() }, masks(), "leg_far");
    refused(Motion { size: (1, 2), ..good() }, masks(), "1x2");
    let mut broken = good();
    broken.tracks[1].frames[2].points[0].x = f32::NAN;
    refused(broken, masks(), "frame 2");
    refused(good(), masks()[..3].to_vec(), "segmenter");
    refused(good(), vec![Mask::new(3, 3); 4], "3x3");
}
