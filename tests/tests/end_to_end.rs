//! The command line on bundled clips, from video to scored creature.
//!
//! Needs the `marey` binary beside the tests; `cargo test --workspace` builds it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use anyhow::{Context as _, Result, ensure};
use marey::motion::Motion;
use marey_tests::score;

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data")
}

fn marey() -> Result<Command> {
    // target/<profile>/deps/end_to_end-<hash> -> target/<profile>/marey
    let path = std::env::current_exe()?.ancestors().nth(2).context("no target folder")?.join("marey");
    ensure!(path.exists(), "{}: not built; run `cargo test --workspace`", path.display());
    Ok(Command::new(path))
}

fn succeed(command: &mut Command) -> Result<Output> {
    let output = command.output()?;
    ensure!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    Ok(output)
}

fn creature(clip: &str, strokes: &str, out: &Path, options: &[&str]) -> Result<Output> {
    let mut command = marey()?;
    command.arg("creature").arg(data().join(clip)).arg("--strokes").arg(data().join(strokes)).arg("-o").arg(out);
    succeed(command.args(["--json"]).args(options))
}

/// The fox is rendered, so everything about it is known. The bounds lie a little below what was measured.
#[test]
fn the_fox_is_tracked_cut_out_and_rebuilt() -> Result<()> {
    let scratch = tempfile::tempdir()?;
    let out = scratch.path().join("fox");
    let said = creature("fox/clip.mp4", "fox/strokes-k3.json", &out, &[])?;
    let report: serde_json::Value = serde_json::from_slice(&said.stdout)?;
    let written: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("report.json"))?)?;
    ensure!(report.is_object() && written.is_object(), "two reports");

    let truth = serde_json::from_slice(&std::fs::read(data().join("fox/truth.json"))?)?;
    let motion = Motion::read(out.join("motion.json"))?;
    let masks = data().join("fox/masks");
    let tracks = score::tracks(&motion, &truth, &data().join("fox/strokes-k3.json"), &masks)?;
    ensure!(tracks.pck05 > 80.0, "PCK05 {:.1}", tracks.pck05);
    ensure!(tracks.confidence_auc.is_none_or(|a| a > 0.6), "confidence says nothing: {:?}", tracks.confidence_auc);
    let cut = score::masks(&out.join("masks"), &masks)?;
    ensure!(cut.mean > 88.0, "J {:.1}", cut.mean);
    Ok(())
}

/// The same bits with one thread and with two, for everything but the clock in report.json.
#[test]
fn the_camel_comes_out_the_same_with_one_thread_and_two() -> Result<()> {
    let scratch = tempfile::tempdir()?;
    let run = |threads: &str| -> Result<PathBuf> {
        let out = scratch.path().join(threads);
        creature("camel/clip.mp4", "camel/strokes.json", &out, &["--obj", "--threads", threads])?;
        Ok(out)
    };
    let (one, two) = (run("1")?, run("2")?);
    let files = listing(&one)?;
    ensure!(files == listing(&two)?, "other files");
    for expected in ["creature.glb", "motion.json", "overlay.gif", "preview.gif", "report.json"] {
        ensure!(files.contains(&PathBuf::from(expected)), "{expected} is missing");
    }
    ensure!(files.contains(&PathBuf::from("masks/00035.png")) && files.contains(&PathBuf::from("meshes/00035.obj")));
    for file in files.iter().filter(|f| f.as_os_str() != "report.json") {
        ensure!(std::fs::read(one.join(file))? == std::fs::read(two.join(file))?, "{} differs", file.display());
    }
    Ok(())
}

fn listing(dir: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = vec![dir.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.push(path.strip_prefix(dir)?.to_owned());
            }
        }
    }
    files.sort();
    Ok(files)
}

/// What a person gets wrong: exit code 3, one line that names the thing, and nothing written.
#[test]
fn bad_strokes_are_refused_by_name() -> Result<()> {
    let scratch = tempfile::tempdir()?;
    let good = std::fs::read_to_string(data().join("camel/strokes.json"))?;
    let cases = [
        ("not json", "{".to_owned(), "not readable"),
        ("past the end", good.replace("\"frame\": 24", "\"frame\": 240"), "240"),
        ("another size", good.replace("[400, 224]", "[800, 448]"), "400x224"),
        ("twice", good.replace("neck", "body"), "twice"),
        ("far outside", good.replace("[121, 94]", "[1e7, 94]"), "far outside"),
        ("no number", good.replace("[121, 94]", "[NaN, 94]"), "not readable"),
    ];
    for (name, text, expected) in cases {
        ensure!(text != good, "{name}: the case changes nothing");
        let strokes = scratch.path().join("strokes.json");
        std::fs::write(&strokes, text)?;
        let out = scratch.path().join("out");
        let mut command = marey()?;
        command.arg("creature").arg(data().join("camel/clip.mp4")).arg("--strokes").arg(&strokes).arg("-o").arg(&out);
        let output = command.output()?;
        let said = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.code() == Some(3), "{name}: {:?} {said}", output.status);
        ensure!(said.trim().lines().count() == 1 && said.contains(expected), "{name}: {said}");
        ensure!(!out.exists(), "{name}: something was written");
    }
    Ok(())
}
