//! A disk that fills up half-way: one line says so, what was there before is there still, and nothing is half-written.
//!
//! The shell bounds the size of files that its child may write, and has the signal for it ignored, so that writing on
//! fails as it does on a full disk.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::{Command, Output};

use marey_binding::{Access, Context};

fn camel(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/camel").join(name).to_str().unwrap().to_owned()
}

/// `marey` where no file can grow past so many blocks of 1024 bytes.
fn bounded(blocks: u32, arguments: &[&str]) -> Output {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    Command::new("bash").args(["-c", &script, env!("CARGO_BIN_EXE_marey")]).args(arguments).output().unwrap()
}

/// All files below a folder with their bytes.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
        if entry.is_dir() {
            files.extend(contents(&entry));
        } else {
            files.push((entry.display().to_string(), std::fs::read(&entry).unwrap()));
        }
    }
    files.sort();
    files
}

fn fails(output: &Output) -> String {
    let said = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!((output.status.code(), said.lines().count()), (Some(4), 1), "{said}");
    said
}

#[test]
fn an_output_that_does_not_fit_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (clip, strokes) = (camel("clip.mp4"), camel("strokes.json"));
    let track = ["track", &clip, "--strokes", &strokes, "-o", &at("motion.json")];
    let creature = ["creature", &clip, "--strokes", &strokes, "-o", &at("camel")];
    // Where nothing was, nothing is.
    assert!(fails(&bounded(8, &track)).contains("motion.json"));
    assert!(fails(&bounded(64, &creature)).contains("camel"));
    assert_eq!(contents(folder.path()), []);
    // Where something was, it is.
    assert!(bounded(1 << 20, &track).status.success() && bounded(1 << 20, &creature).status.success());
    let before = contents(folder.path());
    fails(&bounded(8, &track));
    fails(&bounded(64, &creature));
    assert!(contents(folder.path()) == before);
}

#[test]
fn a_session_that_does_not_fit_is_as_it_was_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.marey").to_str().unwrap().to_owned();
    let context = Context::new(1).unwrap();
    let session = context.new_session(&path).unwrap();
    session.set_clip(Some(&context.open_clip(&camel("clip.mp4")).unwrap())).unwrap();
    session.set_rig(&context.read_rig(&camel("strokes.json")).unwrap()).unwrap();
    session.save().unwrap();
    let fingerprint = session.fingerprint().unwrap();
    drop(session);
    let before = contents(folder.path());
    assert!(fails(&bounded(64, &["session", "embed", &path])).contains("walk.marey"));
    assert!(contents(folder.path()) == before);
    assert_eq!(context.open_session(&path, Access::ReadOnly).unwrap().fingerprint().unwrap(), fingerprint);
}
