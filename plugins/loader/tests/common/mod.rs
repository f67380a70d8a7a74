//! What the tests of this folder share: broken plugins built on demand, a small scene, and children to be lost.
#![allow(dead_code, reason = "each test file uses its part")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use image::RgbImage;
use marey::clip::Clip;
use marey::rig::{KeyFrame, Limb, Rig, Stroke};
use marey::vec2;
use marey_plugin_loader::{LogLevel, Options};

/// The repository's root.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The probe program.
pub(crate) fn probe() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_marey-plugin-probe"))
}

/// Builds a C plugin with `-D` flags.
pub(crate) fn build_c(source: &str, flags: &[&str], to: &Path) {
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-O1", "-std=gnu11", "-fvisibility=hidden", "-Wall", "-Wextra", "-Werror"]);
    cc.args(["-Wno-missing-field-initializers", "-Wno-unused-function", "-Wno-unused-parameter"]);
    cc.args(["-Wno-unused-variable", "-Wno-infinite-recursion"]);
    cc.args(flags.iter().map(|f| format!("-D{f}"))).arg("-I").arg(root().join("include"));
    let said = cc.arg(root().join("plugins").join(source)).arg("-o").arg(to).output().expect("a C compiler");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
}

/// Builds a package of type cdylib and gives its library.
pub(crate) fn build_rust(package: &str) -> PathBuf {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--locked", "--message-format=json", "--package", package]).current_dir(root());
    let said = cargo.output().expect("cargo");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let lines = String::from_utf8_lossy(&said.stdout).into_owned();
    let artifacts = lines.lines().filter_map(|l| serde_json::from_str::<serde_json::Value>(l).ok());
    let files = artifacts.filter_map(|a| a.get("filenames").cloned()).filter_map(|f| f.as_array().cloned()).flatten();
    let mut libraries = files.filter_map(|f| f.as_str().map(PathBuf::from));
    let name = format!("lib{}", package.replace('-', "_"));
    let own = |f: &PathBuf| f.extension().is_some_and(|e| e == "so") && f.to_string_lossy().contains(&name);
    libraries.rfind(own).expect("a library")
}

/// A bright bar on a dark ground that moves right by two pixels a frame.
pub(crate) fn clip(frames: usize) -> Clip {
    let frame = |f: u32| {
        RgbImage::from_fn(96, 64, |x, y| {
            let inside = (20 + 2 * f..50 + 2 * f).contains(&x) && (28..36).contains(&y);
            image::Rgb(if inside { [230, 200 - x as u8, 40 + y as u8] } else { [20, 30, 40] })
        })
    };
    Clip::from_frames((0..frames as u32).map(frame).collect(), 24.0).expect("a clip")
}

/// The bar as a limb on the first frame, and another limb.
pub(crate) fn rig() -> Rig {
    let limb = |label: &str| Limb { label: label.to_owned(), side: None };
    let stroke = |limb, y| Stroke { limb, points: vec![vec2(22.0, y), vec2(48.0, y)], facing: None };
    let key = KeyFrame { frame: 0, strokes: vec![stroke(0, 32.0), stroke(1, 50.0)], ..KeyFrame::default() };
    Rig { size: (96, 64), limbs: vec![limb("bar"), limb("ground")], keyframes: vec![key] }
}

/// Lines of a log.
pub(crate) type Lines = Arc<Mutex<Vec<(LogLevel, String)>>>;

/// Options for tests: nothing waits long.
pub(crate) fn options(cache: &Path) -> (Options, Lines) {
    let lines = Lines::default();
    let own = lines.clone();
    let mut options = Options::new(cache);
    options.settle = Duration::ZERO;
    options.silence = Duration::from_millis(400);
    options.load_deadline = Duration::from_secs(3);
    options.log = Arc::new(move |level, line| own.lock().expect("a lock").push((level, line.to_owned())));
    (options, lines)
}

/// Whether a line with `text` was logged.
pub(crate) fn logged(lines: &Lines, text: &str) -> bool {
    lines.lock().expect("a lock").iter().any(|(_, line)| line.contains(text))
}

/// Runs the ignored test `name` of the calling test program in a process of its own, with `argument` in MAREY_CHILD.
pub(crate) fn child(name: &str, argument: &str) -> Output {
    let mut command = Command::new(std::env::current_exe().expect("this program"));
    command.args(["--exact", name, "--ignored", "--nocapture", "--test-threads=1"]).env("MAREY_CHILD", argument);
    command.output().expect("a child")
}

/// What a child said behind `key: `.
pub(crate) fn answer(output: &Output, key: &str) -> Option<String> {
    let text = String::from_utf8_lossy(&output.stdout);
    let mark = format!("{key}: ");
    text.lines().find_map(|l| Some(l.split_once(&mark)?.1.to_owned()))
}

/// Tells the parent something, behind `key: `.
#[expect(clippy::print_stdout, reason = "the parent reads it")]
pub(crate) fn say(key: &str, text: &str) {
    println!("\n{key}: {text}");
}
