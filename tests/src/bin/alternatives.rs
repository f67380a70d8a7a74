//! Built-in trackers and segmenters beside the plugins that ship, on every scene of a data folder: accuracy and time.
//!
//! ```text
//! cargo xtask alternatives DATA [NAME ...]
//! ```
//! Plugins are loaded as any host loads them. Segmenters are given the built-in tracker's limbs. Prints two Markdown
//! tables. Seconds are of processor time, all threads together, on Linux; elsewhere of the clock.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context as _, Result, anyhow, bail};
use marey::clip::Clip;
use marey::job::Progress;
use marey::motion::Motion;
use marey::raster::Mask;
use marey::rig::Rig;
use marey::segment::{CostVolumeSegmenter, Segmenter};
use marey::track::Tracker;
use marey::track::limb::LimbTracker;
use marey_plugin_loader::{Options, PluginKind, Policy, Registry};
use marey_tests::scene::Scene;
use marey_tests::score::{self, Truth};
use serde_json::Value;

/// Parts of a creature that others seldom hide, by how their labels begin.
const TRUNK: [&str; 5] = ["body", "neck", "head", "Head", "trunk"];

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let Some((data, names)) = args.split_first() else { bail!("usage: alternatives DATA [NAME ...]") };
    let scratch = tempfile::tempdir()?;
    let registry = Registry::new(Options::new(scratch.path().join("cache"))).map_err(|e| anyhow!("{e}"))?;
    for library in ["flow_tracker", "grab_cut"] {
        let name = format!("{}{library}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        let path = std::env::current_exe()?.with_file_name(name);
        registry.load(&path).map_err(|e| anyhow!("{}: {e}; build it first", path.display()))?;
    }
    let flow = slot(&registry, "marey.flow-tracker", PluginKind::Tracker)?;
    let grab_cut = slot(&registry, "marey.grab-cut", PluginKind::Segmenter)?;
    let trackers: [(&str, &dyn Tracker); 2] = [("built-in", &LimbTracker::default()), ("flow-tracker", &flow)];
    let segmenters: [(&str, &dyn Segmenter); 2] =
        [("built-in", &CostVolumeSegmenter::default()), ("grab-cut", &grab_cut)];
    let scenes = Scene::all_masked(Path::new(data))?;
    let wanted = |s: &&Scene| names.is_empty() || names.contains(&s.name);
    let mut jobs = Vec::new();
    for scene in scenes.iter().filter(wanted) {
        for (keys, strokes) in &scene.strokes {
            jobs.push(Job { scene, keys: *keys, strokes, rig: Rig::read(strokes)? });
        }
    }
    head(&["clip", "keys", "tracker", "PCK02", "PCK05", "PCK20", "mean px", "trunk PCK02", "trunk PCK05", "s"]);
    let motions = jobs.iter().map(|job| job.track(&trackers).with_context(|| job.name()));
    let motions = motions.collect::<Result<Vec<_>>>()?;
    head(&["clip", "keys", "segmenter", "J", "J worst", "s"]);
    for (job, motion) in jobs.iter().zip(&motions) {
        job.cut(&segmenters, motion, scratch.path()).with_context(|| job.name())?;
    }
    Ok(())
}

fn slot(registry: &Registry, id: &str, kind: PluginKind) -> Result<marey_plugin_loader::Slot> {
    registry.slot(id, kind, Policy::Keep).map_err(|e| anyhow!("{e}"))
}

fn head(cells: &[&str]) {
    row(cells);
    row(&vec!["---"; cells.len()]);
}

#[expect(clippy::print_stdout, reason = "the tables are this program's output")]
fn row(cells: &[&str]) {
    println!("| {} |", cells.join(" | "));
}

/// A clip with its strokes.
struct Job<'a> {
    scene: &'a Scene,
    keys: usize,
    strokes: &'a Path,
    rig: Rig,
}

impl Job<'_> {
    fn name(&self) -> String {
        format!("{}, {} key frames", self.scene.name, self.keys)
    }

    /// The clip, decoded before anything is timed.
    fn clip(&self) -> Result<Clip> {
        let clip = Clip::open(&self.scene.clip)?;
        (0..clip.info().frames).try_for_each(|frame| clip.frame(frame).map(|_| ()))?;
        Ok(clip)
    }

    /// Prints a row a tracker; the first one's limbs.
    fn track(&self, trackers: &[(&str, &dyn Tracker)]) -> Result<Motion> {
        let clip = self.clip()?;
        let mut first = None;
        for (name, tracker) in trackers {
            if first.is_some() && self.truth()?.is_none() {
                continue;
            }
            let (motion, seconds) = timed(|| tracker.track(&clip, &self.rig, Progress::new().whole()))?;
            if let Some(truth) = self.truth()? {
                let score = self.score(&motion, truth.clone())?;
                let trunk = trunk(truth, self.strokes)?.map(|truth| self.score(&motion, truth)).transpose()?;
                let blank = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.1}"));
                row(&[
                    &self.scene.name,
                    &self.keys.to_string(),
                    name,
                    &format!("{:.1}", score.pck02),
                    &format!("{:.1}", score.pck05),
                    &blank(score.pck20),
                    &format!("{:.1}", score.mean_px),
                    &blank(trunk.as_ref().map(|t| t.pck02)),
                    &blank(trunk.as_ref().map(|t| t.pck05)),
                    &format!("{seconds:.1}"),
                ]);
            }
            first.get_or_insert(motion);
        }
        first.context("no tracker")
    }

    fn truth(&self) -> Result<Option<Value>> {
        let path = self.scene.dir.join("truth.json");
        if !path.exists() {
            return Ok(None);
        }
        Ok(Some(serde_json::from_str(&std::fs::read_to_string(path)?)?))
    }

    fn score(&self, motion: &Motion, truth: Value) -> Result<score::TrackScore> {
        let truth: Truth = serde_json::from_value(truth)?;
        score::tracks(motion, &truth, self.strokes, &self.scene.dir.join("masks"))
    }

    /// Prints a row a segmenter.
    fn cut(&self, segmenters: &[(&str, &dyn Segmenter)], motion: &Motion, scratch: &Path) -> Result<()> {
        let clip = self.clip()?;
        let truth = self.scene.dir.join("masks");
        for (name, segmenter) in segmenters {
            let (masks, seconds) = timed(|| segmenter.segment(&clip, &self.rig, motion, Progress::new().whole()))?;
            let dir = scratch.join(format!("{}-{}-{name}", self.scene.name, self.keys));
            write_masks(&masks, &dir, &truth)?;
            let score = score::masks(&dir, &truth)?;
            let (mean, worst) = (format!("{:.1}", score.mean), format!("{:.1}", score.worst));
            row(&[&self.scene.name, &self.keys.to_string(), name, &mean, &worst, &format!("{seconds:.1}")]);
        }
        Ok(())
    }
}

/// Masks under the names that the true ones have.
fn write_masks(masks: &[Mask], dir: &Path, truth: &Path) -> Result<()> {
    std::fs::create_dir_all(dir)?;
    for entry in std::fs::read_dir(truth)? {
        let name = entry?.file_name();
        let number = Path::new(&name).file_stem().and_then(|s| s.to_str()?.parse::<usize>().ok());
        if let Some(mask) = number.and_then(|n| masks.get(n)) {
            mask.to_image().save(dir.join(&name))?;
        }
    }
    Ok(())
}

/// What is known of the trunk alone; `None` where nothing is.
fn trunk(mut truth: Value, strokes: &Path) -> Result<Option<Value>> {
    let is_trunk = |label: &str| TRUNK.iter().any(|t| label.starts_with(t));
    if let Some(limbs) = truth["limbs"].as_object_mut() {
        limbs.retain(|label, _| is_trunk(label));
        return Ok((!limbs.is_empty()).then_some(truth));
    }
    let strokes: Value = serde_json::from_str(&std::fs::read_to_string(strokes)?)?;
    let mut joints: Vec<String> = Vec::new();
    for stroke in strokes["keyframes"].as_array().into_iter().flatten().flat_map(|k| k["strokes"].as_array()).flatten()
    {
        if stroke["limb"].as_str().is_some_and(is_trunk) {
            joints
                .extend(stroke["joints"].as_array().into_iter().flatten().filter_map(|j| Some(j.as_str()?.to_owned())));
        }
    }
    for frame in truth["frames"].as_object_mut().into_iter().flat_map(|f| f.values_mut()) {
        if let Some(frame) = frame.as_object_mut() {
            frame.retain(|joint, _| joints.contains(joint));
        }
    }
    Ok((!joints.is_empty()).then_some(truth))
}

fn timed<T, E: std::error::Error + Send + Sync + 'static>(work: impl FnOnce() -> Result<T, E>) -> Result<(T, f64)> {
    let (clock, processor) = (Instant::now(), processor_seconds());
    let result = work()?;
    let seconds = match (processor, processor_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => clock.elapsed().as_secs_f64(),
    };
    Ok((result, seconds))
}

/// User and system time of this process: fields 14 and 15 of proc(5)'s stat, in hundredths.
fn processor_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let (user, system): (f64, f64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some((user + system) / 100.0)
}
