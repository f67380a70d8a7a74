//! Sessions as a host edits them through the binding, and as the command line shows them.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::Command;

use marey_binding::{Access, Context, Facing, ParameterKind, Session, Side};
use serde_json::Value;

fn camel(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/camel").join(name).to_str().unwrap().to_owned()
}

/// A session on the bundled clip and strokes, saved, and then edited.
fn edited(context: &Context, path: &str) -> Session {
    let session = context.new_session(path).unwrap();
    session.set_clip(Some(&context.open_clip(&camel("clip.mp4")).unwrap())).unwrap();
    session.set_rig(&context.read_rig(&camel("strokes.json")).unwrap()).unwrap();
    session.save().unwrap();
    session.begin_gesture("add an ear").unwrap();
    let ear = session.add_limb("ear", Side::Mid).unwrap();
    session.set_stroke(ear, 3, &[(50.0, 20.0), (60.0, 10.0)], Facing::Toward).unwrap();
    session.end_gesture().unwrap();
    session.add_paint(3, true, 4.0, &[(50.0, 20.0)]).unwrap();
    session
}

#[test]
fn info_says_what_a_session_holds_and_what_was_not_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.marey").to_str().unwrap().to_owned();
    let context = Context::new(1).unwrap();
    let session = edited(&context, &path);
    let info = |arguments: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_marey")).args(["session", "info"]).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    // While it is edited elsewhere, too.
    let (code, said, _) = info(&[&path, "--json"]);
    let report: Value = serde_json::from_str(&said).unwrap();
    assert_eq!((code, &report["unsaved_gestures"], &report["has_clip"]), (Some(0), &2.into(), &true.into()));
    let limbs = report["limbs"].as_array().unwrap();
    assert_eq!(limbs.last().unwrap()["label"], "ear");
    assert_eq!(limbs[0]["outdated"][0][0], 0, "nothing is tracked yet");
    assert!(info(&[&path]).1.contains("not tracked"));
    drop(session);
    std::fs::write(&path, "walk").unwrap();
    let (code, _, error) = info(&[&path]);
    assert!(code == Some(3) && error.lines().count() == 1 && error.contains("walk.marey"), "{error}");
}

#[test]
fn what_a_host_does_is_undone_and_lasts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.marey").to_str().unwrap().to_owned();
    let context = Context::new(1).unwrap();
    let session = edited(&context, &path);
    let drawn = session.rig().unwrap().to_json().unwrap();
    assert!(session.undo().unwrap());
    assert_eq!(session.undo_label().unwrap().as_deref(), Some("add an ear"));
    session.remove_paint(3, 0).unwrap_err();
    assert!(session.redo().unwrap() && !session.redo().unwrap() && session.redo_label().unwrap().is_none());
    assert!(session.rig().unwrap().to_json().unwrap() == drawn);
    session.set_limb(0, "trunk", Side::Unknown).unwrap();
    session.remove_stroke(0, 12).unwrap();
    session.set_mask(1, &camel("clip.mp4")).unwrap();
    session.remove_limb(0).unwrap();
    for _ in 0..4 {
        session.undo().unwrap();
    }
    assert!(session.rig().unwrap().to_json().unwrap() == drawn);

    for parameter in context.parameters().unwrap() {
        let value = match parameter.kind {
            ParameterKind::Number(low, _) | ParameterKind::Whole(low, _) => low,
            ParameterKind::Switch => 0.0,
            ParameterKind::Choice(names) => names.len() as f64 - 1.0,
            ParameterKind::Text => {
                session.set_text(&parameter.name, "org.example.none").unwrap();
                assert_eq!(session.text(&parameter.name).unwrap(), "org.example.none");
                session.set_text(&parameter.name, "").unwrap();
                continue;
            }
        };
        session.begin_gesture("cancelled").unwrap();
        session.set_parameter(&parameter.name, Some(value)).unwrap();
        assert_eq!(session.parameter(&parameter.name).unwrap(), value);
        session.cancel_gesture().unwrap();
        assert_eq!(session.parameter(&parameter.name).unwrap(), parameter.default);
    }
    session.set_parameter("creature.around", None).unwrap();
    assert!(session.motion().unwrap().is_none());
    let job = session.start_track().unwrap();
    job.cancel().unwrap();
    let _ = job.wait(None);
    assert!(session.take(&job).is_err(), "what was cancelled is not taken");

    let gestures = session.state().unwrap().gestures;
    assert_eq!(
        session.path().unwrap().as_deref().map(Path::new),
        Some(std::fs::canonicalize(&path).unwrap().as_path())
    );
    drop(session);
    let session = context.open_session(&path, Access::Edit).unwrap();
    let state = session.state().unwrap();
    assert_eq!((state.gestures, state.modified, session.warnings().unwrap().len()), (gestures, true, 0));
    assert!(session.rig().unwrap().to_json().unwrap() == drawn);
    assert_eq!(session.clip().unwrap().unwrap().info().unwrap().frames, session.outdated(0).unwrap()[0].end);
    session.discard().unwrap();
    let session = context.open_session(&path, Access::ReadOnly).unwrap();
    assert_ne!(session.rig().unwrap().to_json().unwrap(), drawn, "as it was saved");
    assert!(context.sessions_left_in(folder.path().to_str().unwrap()).unwrap().is_empty());
}

#[test]
fn a_session_is_made_to_carry_its_clip_and_a_recording_is_played() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let context = Context::new(1).unwrap();
    let session = edited(&context, &at("walk.marey"));
    session.start_recording(&at("walk.recording")).unwrap();
    session.set_parameter("creature.smoothing", Some(0.2)).unwrap();
    session.undo().unwrap();
    session.stop_recording().unwrap();
    let fingerprint = session.fingerprint().unwrap();
    session.save().unwrap();
    drop(session);
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_marey")).arg("session").args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, said, error) = run(&["replay", &at("walk.recording"), "-o", &at("played.marey"), "--json"]);
    assert_eq!(code, Some(0), "{error}");
    let report: Value = serde_json::from_str(&said).unwrap();
    assert_eq!((&report["played"], &report["fingerprint"]), (&2.into(), &format!("{fingerprint:016x}").into()));
    let played = context.open_session(&at("played.marey"), Access::ReadOnly).unwrap();
    assert_eq!(played.fingerprint().unwrap(), fingerprint);
    assert_eq!(run(&["replay", &at("walk.marey-journal")]).0, Some(3), "no recording");

    let small = std::fs::metadata(at("walk.marey")).unwrap().len();
    let (code, _, error) = run(&["embed", &at("walk.marey")]);
    assert_eq!(code, Some(0), "{error}");
    let clip = std::fs::metadata(camel("clip.mp4")).unwrap().len();
    assert!(std::fs::metadata(at("walk.marey")).unwrap().len() > small + clip);
    let session = context.open_session(&at("walk.marey"), Access::Edit).unwrap();
    assert!(session.state().unwrap().embedded && session.warnings().unwrap().is_empty());
    assert!(run(&["embed", &at("walk.marey")]).2.contains("another program"));
}
