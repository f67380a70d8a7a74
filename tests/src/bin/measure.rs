//! The measured table: runs the release `marey creature` on every scene of a data folder and scores what it wrote.
//!
//! ```text
//! cargo xtask measure DATA [NAME ...] [-- extra options for marey creature]
//! ```
//! A scene is described in `marey_tests::scene`. Prints a Markdown table: a row for each clip and number of key frames.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail, ensure};
use marey_tests::scene::Scene;
use marey_tests::score;

struct Run {
    seconds: f64,
    megabytes: Option<f64>,
}

fn main() -> Result<()> {
    let mut args: Vec<String> = std::env::args().skip(1).collect();
    let extra = args.iter().position(|a| a == "--").map_or_else(Vec::new, |at| args.split_off(at)[1..].to_vec());
    let Some((data, names)) = args.split_first() else {
        bail!("usage: measure DATA [NAME ...] [-- options of marey creature]");
    };
    let marey = std::env::current_exe()?.with_file_name("marey");
    ensure!(marey.exists(), "{}: not built; run this through `cargo xtask measure`", marey.display());
    let scenes = Scene::all(Path::new(data))?;
    ensure!(!scenes.is_empty(), "{data}: holds no scene (a clip with truth.json and strokes-k*.json)");
    print_row(&[
        "clip",
        "keys",
        "PCK05",
        "PCK20",
        "mean px",
        "conf. AUC",
        "J",
        "J worst",
        "IoU 2D",
        "IoU 3D",
        "s",
        "MB",
    ]);
    print_row(&["---"; 12]);
    for scene in scenes.iter().filter(|s| names.is_empty() || names.contains(&s.name)) {
        for (keys, strokes) in &scene.strokes {
            measure(&marey, scene, *keys, strokes, &extra)
                .with_context(|| format!("{}, {keys} key frames", scene.name))?;
        }
    }
    Ok(())
}

#[expect(clippy::print_stdout, reason = "the table is this program's output")]
fn print_row(cells: &[&str]) {
    println!("| {} |", cells.join(" | "));
}

fn measure(marey: &Path, scene: &Scene, keys: usize, strokes: &Path, extra: &[String]) -> Result<()> {
    let scratch = tempfile::tempdir()?;
    let out = scratch.path().join("creature");
    let meshes = scene.dir.join("meshes.npz");
    let mut command = Command::new(marey);
    command.arg("creature").arg(&scene.clip).arg("--strokes").arg(strokes).arg("-o").arg(&out);
    command.args(["--json", "--threads", "2"]).args(extra);
    // The table's time is that of the plain command; meshes for scoring come from a second run.
    let run = watch(&mut command)?;
    let creature = if meshes.exists() {
        watch(command.arg("--obj"))?;
        Some(score::creature(&out.join("meshes"), &meshes, &scene.dir.join("masks"))?)
    } else {
        None
    };
    let motion = marey::motion::Motion::read(out.join("motion.json"))?;
    let truth = serde_json::from_str(&std::fs::read_to_string(scene.dir.join("truth.json"))?)?;
    let tracks = score::tracks(&motion, &truth, strokes, &scene.dir.join("masks"))?;
    let masks = score::masks(&out.join("masks"), &scene.dir.join("masks"))?;
    let or_blank = |v: Option<f64>, digits: usize| v.map_or(String::new(), |v| format!("{v:.digits$}"));
    print_row(&[
        &scene.name,
        &keys.to_string(),
        &format!("{:.1}", tracks.pck05),
        &or_blank(tracks.pck20, 1),
        &format!("{:.1}", tracks.mean_px),
        &or_blank(tracks.confidence_auc, 2),
        &format!("{:.1}", masks.mean),
        &format!("{:.1}", masks.worst),
        &or_blank(creature.as_ref().map(|c| c.silhouette), 1),
        &or_blank(creature.as_ref().map(|c| c.volume), 1),
        &format!("{:.1}", run.seconds),
        &or_blank(run.megabytes, 0),
    ]);
    Ok(())
}

/// Runs the command to its end, watching its clock and, where the system tells, its peak memory.
fn watch(command: &mut Command) -> Result<Run> {
    let begun = Instant::now();
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
    let status = PathBuf::from(format!("/proc/{}/status", child.id()));
    let mut megabytes = None;
    while child.try_wait()?.is_none() {
        megabytes = peak_megabytes(&status).or(megabytes);
        std::thread::sleep(Duration::from_millis(10));
    }
    let seconds = begun.elapsed().as_secs_f64();
    let output = child.wait_with_output()?;
    ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr).trim());
    Ok(Run { seconds, megabytes })
}

fn peak_megabytes(status: &Path) -> Option<f64> {
    let text = std::fs::read_to_string(status).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    Some(line.trim().trim_end_matches("kB").trim().parse::<f64>().ok()? / 1024.0)
}
