//! How the command line is called, a test's own folder, and a creature of a few frames.
#![allow(dead_code, reason = "each file of tests uses what it needs of it")]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const STROKES: &str = r#"{"format":"marey-strokes","version":1,"size":[96,64],"limbs":[{"label":"body"}],
    "keyframes":[{"frame":0,"strokes":[{"limb":"body","points":[[33,32],[57,32]]}]}]}"#;

/// A file of the bundled data.
pub(crate) fn sample(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name).to_str().unwrap().to_owned()
}

/// A folder of a test's own, and names in it.
pub(crate) struct Desk(pub(crate) tempfile::TempDir);

impl Desk {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    pub(crate) fn write(&self, name: &str, text: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path(name), text).unwrap();
        self.path(name)
    }
}

pub(crate) fn marey_in(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_marey")).current_dir(folder).args(args).output().unwrap()
}

/// The one line of a failure, which leaves stdout to reports.
pub(crate) fn fails_in(folder: &Path, args: &[&str], exit_code: i32) -> String {
    let output = marey_in(folder, args);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(exit_code), "{args:?}: {said}");
    assert!(output.stdout.is_empty(), "{args:?}: {}", String::from_utf8_lossy(&output.stdout));
    assert_eq!(said.lines().count(), 1, "{args:?}: {said}");
    said
}

/// The report of a command that succeeds.
pub(crate) fn report_in(folder: &Path, args: &[&str]) -> Value {
    let output = marey_in(folder, &[args, &["--json"]].concat());
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

pub(crate) fn marey(args: &[&str]) -> Output {
    marey_in(Path::new("."), args)
}

pub(crate) fn fails(args: &[&str], exit_code: i32) -> String {
    fails_in(Path::new("."), args, exit_code)
}

pub(crate) fn report(args: &[&str]) -> Value {
    report_in(Path::new("."), args)
}

/// A creature of a dark bar that wanders over light ground for six frames.
pub(crate) fn bar(folder: &Path) {
    std::fs::create_dir(folder.join("clip")).unwrap();
    for frame in 0..6 {
        let at = 30 + 2 * frame;
        let image = image::RgbImage::from_fn(96, 64, |x, y| {
            let bar = x >= at && x < at + 30 && (26..38).contains(&y);
            let grain = ((x * 37 + y * 91) % 17) as u8;
            if bar { image::Rgb([60 + grain, 40, 30]) } else { image::Rgb([190, 200 - grain, 180 + grain]) }
        });
        image.save(folder.join(format!("clip/{frame:05}.png"))).unwrap();
    }
    std::fs::write(folder.join("strokes.json"), STROKES).unwrap();
    let made = marey_in(folder, &["creature", "clip", "--strokes", "strokes.json", "-o", "bar"]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
}
