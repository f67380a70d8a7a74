//! How long is it from a corrected stroke to its new motion, and is that as good as tracking the whole clip again?
//!
//! ```text
//! cargo xtask retrack DATA [NAME ...]
//! ```
//! On every scene with three key frames or more, one limb of a key frame in the middle is drawn off by a tenth of the
//! picture, and tracked; then the stroke is put right, and tracked again in part and as a whole. Prints a Markdown table.

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail, ensure};
use marey::clip::Clip;
use marey::job::Progress;
use marey::motion::Motion;
use marey::rig::Rig;
use marey::track::limb::LimbTracker;
use marey::track::{Earlier, Tracker, outdated_frames};
use marey_tests::scene::Scene;
use marey_tests::score;

#[expect(clippy::print_stdout, reason = "the table is this program's output")]
fn print_row(cells: &[&str]) {
    println!("| {} |", cells.join(" | "));
}

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let Some((data, names)) = args.split_first() else { bail!("usage: retrack DATA [NAME ...]") };
    let scenes = Scene::all(Path::new(data))?;
    print_row(&["clip", "keys", "limb-frames tracked again", "s whole", "s again", "PCK05 whole", "PCK05 again"]);
    print_row(&["---"; 7]);
    for scene in scenes.iter().filter(|s| names.is_empty() || names.contains(&s.name)) {
        for (keys, strokes) in scene.strokes.iter().filter(|(keys, _)| *keys >= 3) {
            measure(scene, *keys, strokes)?;
        }
    }
    Ok(())
}

fn measure(scene: &Scene, keys: usize, strokes: &Path) -> Result<()> {
    let (clip, right) = (Clip::open(&scene.clip)?, Rig::read(strokes)?);
    ensure!(right.keyframes.len() >= 3, "{}: fewer key frames than its name says", strokes.display());
    let mut wrong = right.clone();
    let middle = wrong.keyframes.len() / 2;
    if let Some(stroke) = wrong.keyframes[middle].strokes.last_mut() {
        stroke.points.iter_mut().for_each(|p| p.x += 0.1 * right.size.0 as f32);
    }
    let tracker = LimbTracker::default();
    let before = tracker.track(&clip, &wrong, Progress::new().whole())?;
    let timed = |work: &dyn Fn() -> marey::Result<Motion>| -> Result<(Motion, f64)> {
        let begun = Instant::now();
        Ok((work()?, begun.elapsed().as_secs_f64()))
    };
    let (whole, whole_s) = timed(&|| tracker.track(&clip, &right, Progress::new().whole()))?;
    let outdated = outdated_frames(&wrong, &right, clip.info().frames);
    let earlier = Earlier { motion: &before, outdated: &outdated };
    let (again, again_s) = timed(&|| tracker.retrack(&clip, &right, earlier, Progress::new().whole()))?;

    let truth = serde_json::from_str(&std::fs::read_to_string(scene.dir.join("truth.json"))?)?;
    let pck = |motion: &Motion| -> Result<String> {
        let score = score::tracks(motion, &truth, strokes, &scene.dir.join("masks"))?;
        Ok(format!("{:.1}", score.pck05))
    };
    let changed: usize = outdated.iter().flatten().map(ExactSizeIterator::len).sum();
    print_row(&[
        &scene.name,
        &keys.to_string(),
        &format!("{changed} of {}", right.limbs.len() * clip.info().frames),
        &format!("{whole_s:.2}"),
        &format!("{again_s:.2}"),
        &pck(&whole)?,
        &pck(&again)?,
    ]);
    Ok(())
}
