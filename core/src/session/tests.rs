//! The session as its user knows it: nothing that was done is lost, and what is damaged says so.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{Vec2, vec2};

use super::journal::path_of;
use super::*;
use crate::clip::ClipInfo;
use crate::job::Progress;
use crate::motion::{Motion, Track, TrackFrame, TrackKind};
use crate::rig::{Facing, Paint, Rig, Side};

fn bar(y: f32) -> Vec<Vec2> {
    vec![vec2(10.0, y), vec2(40.5, y + 0.25), vec2(80.0, y)]
}

fn clip(path: &Path) -> ClipReference {
    std::fs::write(path, b"frames").expect("written");
    let info =
        ClipInfo { width: 100, height: 80, frames: 40, fps: 24000.0 / 1001.0, source: "memory", warnings: vec![] };
    ClipReference::new(path, &info, Progress::new().whole()).expect("read")
}

fn motion(rig: &Rig) -> Arc<Motion> {
    let track = |limb: &crate::rig::Limb| Track {
        name: limb.label.clone(),
        kind: TrackKind::Stroke,
        frames: (0..3).map(|f| TrackFrame::certain(vec![vec2(0.1 * f as f32, 1.0), vec2(9.0, 2.0)])).collect(),
    };
    let tracks = rig.limbs.iter().map(track).collect();
    Arc::new(Motion { size: rig.size, fps: 24.0, frames: 3, tracks, bones: vec![("body".into(), "tail".into())] })
}

/// Does something of every kind, a gesture each.
fn draw(session: &mut Session, folder: &Path) {
    session.set_clip(Some(clip(&folder.join("clip.mp4")))).expect("a clip");
    session.add_limb("body", None).expect("a limb");
    session.add_limb("leg", Some(Side::Near)).expect("a limb");
    session.set_stroke(0, 3, bar(20.0), None).expect("a stroke");
    session.set_stroke(1, 3, bar(40.0), Some(Facing::Toward)).expect("a stroke");
    session.set_stroke(0, 20, bar(30.0), None).expect("a stroke");
    let paint = |radius| Paint { foreground: radius > 2.0, radius, points: bar(50.0) };
    session.add_paint(3, paint(2.0)).expect("paint");
    session.add_paint(3, paint(4.5)).expect("paint");
    session.remove_paint(3, 0).expect("less paint");
    session.set_mask(7, Some(&folder.join("mask.png"))).expect("a mask");
    session.add_limb("tail", None).expect("a limb");
    session.set_stroke(2, 5, bar(60.0), None).expect("a stroke");
    session.set_parameter("creature.smoothing", Some(Value::Number(0.1))).expect("a value");
    let inputs = session.document().inputs.clone();
    session.set_motion(Some(Tracked { motion: motion(&inputs.rig), inputs })).expect("a motion");
    session.remove_limb(1).expect("no leg");
    session.set_limb(1, "long tail", Some(Side::Mid)).expect("a label");
    session.remove_stroke(0, 20).expect("no stroke");
}
const DRAWN: u64 = 17;

fn open(path: &Path) -> Session {
    Session::open(path, Access::Edit, Progress::new().whole()).expect("opened")
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = std::fs::canonicalize(folder.path()).expect("a path");
    std::fs::write(path.join("mask.png"), b"a picture").expect("written");
    (folder, path)
}

/// The document after each gesture of [`draw`], the empty one first.
fn states(folder: &Path) -> Vec<Document> {
    let mut session = Session::new();
    draw(&mut session, folder);
    let mut states = vec![session.document().clone()];
    while session.undo().expect("undone").is_some() {
        states.push(session.document().clone());
    }
    states.reverse();
    states
}

#[test]
fn every_step_is_taken_back_and_done_again_exactly() {
    let (_keep, folder) = folder();
    let states = states(&folder);
    assert_eq!(states.len(), DRAWN as usize + 1);
    assert_eq!(states[0], Document::default());
    let mut session = Session::new();
    draw(&mut session, &folder);
    let track = |session: &Session| session.document().tracked.as_ref().expect("tracked").motion.tracks[2].name.clone();
    assert_eq!(track(&session), "long tail", "the track goes with its limb's label");
    for state in states.iter().rev().skip(1) {
        assert!(session.undo_label().is_some());
        session.undo().expect("undone").expect("a step");
        assert_eq!(session.document(), state);
    }
    assert!(session.undo().expect("nothing").is_none() && !session.is_modified());
    for state in &states[1..] {
        session.redo().expect("redone").expect("a step");
        assert_eq!(session.document(), state);
    }
    assert!(session.redo().expect("nothing").is_none());
    session.undo().expect("undone");
    session.set_stroke(0, 0, bar(9.0), None).expect("a stroke");
    assert_eq!(session.redo_label(), None, "another way was taken");
    assert_eq!(session.undo_label(), Some("draw `body` on frame 0"));
}

#[test]
fn a_gesture_is_one_step_and_keeps_one_change_however_long_it_drags() {
    let mut session = Session::new();
    session.begin_gesture("smooth").expect("begun");
    for i in 0..1000 {
        session.set_parameter("creature.smoothing", Some(Value::Number(f64::from(i) / 1000.0))).expect("a value");
    }
    assert!(session.begin_gesture("another").is_err() && session.undo().is_err() && session.save().is_err());
    session.end_gesture().expect("ended");
    assert_eq!((session.gestures(), session.history.back[0].edits.len()), (1, 1));
    session.undo().expect("undone").expect("a step");
    assert_eq!(session.document(), &Document::default());

    // Back where it began, cancelled, or refused half-way: nothing happened.
    session.begin_gesture("there and back").expect("begun");
    session.set_parameter("export.scale", Some(Value::Number(2.0))).expect("a value");
    session.set_parameter("export.scale", None).expect("a value");
    session.end_gesture().expect("ended");
    session.begin_gesture("oh no").expect("begun");
    session.add_limb("wing", None).expect("a limb");
    assert!(session.add_limb("wing", None).is_err() && session.set_stroke(0, 0, vec![Vec2::NAN; 2], None).is_err());
    session.cancel_gesture().expect("cancelled");
    assert!(session.end_gesture().is_err() && session.set_stroke(0, 0, bar(1.0), None).is_err());
    assert_eq!((session.document(), session.undo_label()), (&Document::default(), None));
}

#[test]
fn an_edit_says_which_frames_of_which_limb_it_puts_out_of_date() {
    let (_keep, folder) = folder();
    let mut session = Session::new();
    session.set_clip(Some(clip(&folder.join("clip.mp4")))).expect("a clip");
    for (label, side) in [("body", Side::Mid), ("leg_near", Side::Near), ("leg_far", Side::Far)] {
        session.add_limb(label, Some(side)).expect("a limb");
    }
    (0..3).for_each(|limb| drop(session.set_stroke(limb, 0, bar(20.0), None).expect("a stroke")));
    session.set_stroke(0, 20, bar(25.0), None).expect("a stroke");
    assert_eq!(session.outdated().limbs.len(), 3, "nothing is tracked yet");
    let inputs = session.document().inputs.clone();
    session.set_creature(motion(&inputs.rig), inputs).expect("a creature");
    assert!(session.outdated().is_empty());

    let ranges =
        |o: &Outdated| -> Vec<String> { o.limbs.iter().map(|l| format!("{} {:?}", l.label, l.frames)).collect() };
    let edit = session.set_stroke(0, 10, bar(22.0), None).expect("a stroke");
    assert_eq!(ranges(&edit), ["body [1..20]"]);
    let edit = session.set_stroke(0, 30, bar(22.0), None).expect("a stroke");
    assert_eq!(ranges(&edit), ["body [21..40]"]);
    assert_eq!(ranges(&session.outdated()), ["body [1..20, 21..40]"]);
    let edit = session.undo().expect("undone").expect("a step");
    assert_eq!(ranges(&edit), ["body [21..40]"]);
    session.undo().expect("undone").expect("a step");
    assert!(session.outdated().is_empty(), "what is undone puts nothing out of date");

    let edit = session.set_stroke(1, 0, bar(20.0), Some(Facing::Away)).expect("a facing");
    assert!(edit.limbs.is_empty() && edit.creature, "trackers do not look at it");
    let edit = session.add_paint(4, Paint { foreground: true, radius: 3.0, points: bar(9.0) }).expect("paint");
    assert!(edit.limbs.is_empty() && edit.creature);
    assert!(session.set_parameter("export.obj", Some(Value::Switch(true))).expect("a value").is_empty());
    assert_eq!(session.set_parameter("track.spacing", Some(Value::Number(8.0))).expect("a value").limbs.len(), 3);
    session.undo().expect("undone");
    let edit = session.set_limb(2, "leg_far", None).expect("a side");
    assert_eq!(ranges(&edit), ["leg_near [0..40]", "leg_far [0..40]"], "and its twin's");
}

#[test]
fn what_is_saved_is_read_and_what_is_not_known_is_kept_or_refused() {
    let (_keep, folder) = folder();
    let path = folder.join("walk.marey");
    let mut session = Session::create(&path).expect("created");
    assert!(Session::create(&path).is_err(), "it exists");
    draw(&mut session, &folder);
    assert!(session.is_modified());
    session.save().expect("saved");
    assert!(!session.is_modified());
    let document = session.document().clone();
    session.undo().expect("undone");
    assert!(session.is_modified());
    session.redo().expect("redone");
    assert!(!session.is_modified(), "back in the state that the file has");
    drop(session);

    let strange = record::encode(&serde_json::json!({"section": "sounds", "data": [1, {"neigh": 2.5}]})).expect("text");
    let text = std::fs::read_to_string(&path).expect("read") + &strange;
    std::fs::write(&path, &text).expect("written");
    let mut session = open(&path);
    assert_eq!((session.document(), session.warnings()), (&document, &[][..]));
    session.save().expect("saved");
    assert!(std::fs::read_to_string(&path).expect("read").contains(&strange));
    drop(session);
    assert!(!path_of(&path).exists(), "an empty journal leaves with its session");

    let refusal = |from: &str, to: &str| {
        let changed: String = text
            .lines()
            .map(|line| {
                let json = line.splitn(3, ' ').nth(2).expect("three fields").replace(from, to);
                record::encode(&serde_json::from_str::<serde_json::Value>(&json).expect("JSON")).expect("text")
            })
            .collect();
        std::fs::write(&path, changed).expect("written");
        Session::open(&path, Access::Edit, Progress::new().whole()).expect_err(to).to_string()
    };
    let message = refusal("\"version\":1", "\"version\":2");
    assert!(message.contains("version 2") && message.contains("newer"), "{message}");
    assert!(refusal("\"facing\"", "\"colour\":1,\"facing\"").contains("colour"));
    assert!(refusal("\"size\":[100,80],\"limbs\"", "\"size\":[0,0],\"limbs\"").contains("size is empty"));
    assert!(refusal("marey-session", "marey-strokes").contains("marey-strokes"));

    // A journal of a newer version is refused too, and stays as it is.
    std::fs::write(&path, &text).expect("written");
    let newer =
        record::encode(&serde_json::json!({"format": "marey-journal", "version": 2, "session": ""})).expect("text");
    std::fs::write(path_of(&path), &newer).expect("written");
    let error = Session::open(&path, Access::Edit, Progress::new().whole()).expect_err("newer").to_string();
    assert!(error.contains("version 2") && error.contains("walk.marey-journal"), "{error}");
    assert_eq!(std::fs::read_to_string(path_of(&path)).expect("kept"), newer);
}

#[test]
fn the_largest_numbers_are_numbers_like_others() {
    let (_keep, folder) = folder();
    let path = folder.join("walk.marey");
    let mut session = Session::create(&path).expect("created");
    session.set_clip(Some(clip(&folder.join("clip.mp4")))).expect("a clip");
    session.add_limb("body", None).expect("a limb");
    session.set_stroke(0, usize::MAX, bar(20.0), None).expect("a stroke");
    let edit = session.set_stroke(0, usize::MAX - 1, bar(20.0), None).expect("a stroke");
    assert_eq!(edit.limbs[0].frames[0].end, 40, "no further than the clip");
    session.set_clip(None).expect("no clip");
    session.undo().expect("undone");
    session.save().expect("saved");
    drop(session);
    let text = std::fs::read_to_string(&path).expect("read");
    let json = text.lines().next().and_then(|l| l.splitn(3, ' ').nth(2)).expect("a header");
    let mut header: serde_json::Value = serde_json::from_str(json).expect("JSON");
    header["saved"] = u64::MAX.into();
    let rest = text.split_inclusive('\n').skip(1).collect::<String>();
    std::fs::write(&path, record::encode(&header).expect("text") + &rest).expect("written");
    let mut session = open(&path);
    session.set_stroke(0, 5, bar(20.0), None).expect("a stroke");
    drop(session);
    assert!(Session::open(&path, Access::ReadOnly, Progress::new().whole()).is_ok());
}

/// Files of a session with something saved and something not, and all its states.
fn half_saved(folder: &Path) -> (PathBuf, Vec<u8>, Vec<u8>, Document, Document) {
    let path = folder.join("walk.marey");
    let mut session = Session::create(&path).expect("created");
    draw(&mut session, folder);
    session.save().expect("saved");
    let saved = session.document().clone();
    session.undo().expect("undone");
    session.set_stroke(0, 9, bar(33.0), None).expect("a stroke");
    let document = session.document().clone();
    drop(session);
    let files = [&path, &path_of(&path)].map(|p| std::fs::read(p).expect("read"));
    let [file, journal] = files;
    (path, file, journal, saved, document)
}

#[test]
fn a_damaged_file_gives_all_that_is_whole_and_says_what_is_not() {
    let (_keep, folder) = folder();
    let (path, file, _, saved, _) = half_saved(&folder);
    std::fs::remove_file(path_of(&path)).expect("removed");
    let check = |bytes: &[u8], what: &str| {
        std::fs::write(&path, bytes).expect("written");
        let opened = Session::open(&path, Access::ReadOnly, Progress::new().whole());
        let Ok(session) = opened else { return 0 };
        let Document { inputs, tracked } = session.document();
        let whole = [
            inputs.clip == saved.inputs.clip,
            inputs.rig == saved.inputs.rig,
            inputs.settings == saved.inputs.settings,
            *tracked == saved.tracked,
        ];
        let empty = Document::default();
        assert!(whole[0] || inputs.clip.is_none(), "{what}: the clip is neither whole nor gone");
        assert!(whole[1] || inputs.rig == empty.inputs.rig, "{what}: the rig is neither whole nor gone");
        assert!(whole[2] || inputs.settings == empty.inputs.settings, "{what}");
        assert!(whole[3] || tracked.is_none(), "{what}: the motion is neither whole nor gone");
        let kept = whole.into_iter().filter(|w| *w).count();
        assert!(kept == 4 || !session.warnings().is_empty(), "{what}: nothing was said");
        kept
    };
    for length in 0..file.len() {
        let kept = check(&file[..length], &format!("cut at {length}"));
        assert!(kept < 4, "cut at {length}");
    }
    let mut least = 4;
    for at in (0..file.len()).step_by(5) {
        let mut bytes = file.clone();
        bytes[at] ^= 1 << (at % 8);
        // One byte may join two records, or be the header's.
        least = least.min(check(&bytes, &format!("flipped {at}")));
    }
    assert_eq!(least, 2);

    // Without its header it is still edited safely: it is written anew at once, and the damaged one kept.
    std::fs::write(&path, &file[20..]).expect("written");
    let mut session = open(&path);
    assert!(session.is_modified() && !session.warnings().is_empty());
    session.set_stroke(0, 9, bar(33.0), None).expect("a stroke");
    let document = session.document().clone();
    drop(session);
    assert_eq!(open(&path).document(), &document);
    assert_eq!(std::fs::read(folder.join("walk.marey-damaged")).expect("kept"), file[20..]);
}

#[test]
fn a_damaged_journal_gives_the_gestures_before_the_damage() {
    let (_keep, folder) = folder();
    let (path, file, journal, saved, document) = half_saved(&folder);
    let before_last = {
        let mut session = open(&path);
        assert_eq!((session.document(), session.replayed()), (&document, 2));
        assert!(session.is_modified() && session.undo_label() == Some("draw `body` on frame 9"));
        session.undo().expect("undone");
        session.document().clone()
    };
    let check = |bytes: &[u8], what: &str| {
        std::fs::write(&path, &file).expect("written");
        std::fs::write(path_of(&path), bytes).expect("written");
        let session = Session::open(&path, Access::ReadOnly, Progress::new().whole()).expect("opened");
        let expected = [&saved, &before_last, &document][session.replayed()];
        assert_eq!(session.document(), expected, "{what}");
        let bare = bytes.is_empty() || record::lines(bytes).all(|l| l.text.is_some());
        assert!(bare || !session.warnings().is_empty(), "{what}: nothing was said");
        session.replayed()
    };
    let ends: Vec<usize> = record::lines(&journal).map(|l| l.end).collect();
    for length in 0..=journal.len() {
        let whole = ends.iter().filter(|&&end| end <= length).count();
        assert_eq!(check(&journal[..length], &format!("cut at {length}")), whole.saturating_sub(1));
    }
    for at in 0..journal.len() {
        let mut bytes = journal.clone();
        bytes[at] ^= 1 << (at % 8);
        check(&bytes, &format!("flipped {at}"));
    }
    // A gesture done after a torn one takes its place.
    check(&journal[..journal.len() - 3], "torn");
    let mut session = open(&path);
    session.set_stroke(0, 11, bar(34.0), None).expect("a stroke");
    let document = session.document().clone();
    drop(session);
    let session = open(&path);
    assert_eq!((session.document(), session.warnings()), (&document, &[][..]));
}

#[test]
fn a_crash_between_the_file_and_its_journal_does_nothing_twice() {
    let (_keep, folder) = folder();
    let (path, _, journal, _, document) = half_saved(&folder);
    open(&path).save().expect("saved");
    std::fs::write(path_of(&path), &journal).expect("written");
    let mut session = open(&path);
    assert_eq!((session.document(), session.replayed(), session.is_modified()), (&document, 0, false));
    session.set_stroke(0, 11, bar(34.0), None).expect("a stroke");
    let document = session.document().clone();
    drop(session);
    let mut session = open(&path);
    assert_eq!((session.document(), session.replayed()), (&document, 1));
    // An older file under a newer journal is told, and the journal kept aside.
    session.save().expect("saved");
    let old = std::fs::read(&path).expect("read");
    for y in [1.0, 2.0] {
        session.set_stroke(0, 12, bar(y), None).expect("a stroke");
        session.save().expect("saved");
    }
    session.set_stroke(0, 12, bar(3.0), None).expect("a stroke");
    drop(session);
    std::fs::write(&path, old).expect("written");
    let session = open(&path);
    assert_eq!((session.document(), session.replayed(), session.warnings().len()), (&document, 0, 1));
    assert!(folder.join("walk.marey-journal-damaged").exists());
}

#[test]
fn two_programs_do_not_edit_one_session() {
    let (_keep, folder) = folder();
    let path = folder.join("walk.marey");
    let mut session = Session::create(&path).expect("created");
    session.add_limb("body", None).expect("a limb");
    let error = Session::open(&path, Access::Edit, Progress::new().whole()).expect_err("it is edited").to_string();
    assert!(error.contains("another program") && error.contains("read-only"), "{error}");
    let mut reader = Session::open(&path, Access::ReadOnly, Progress::new().whole()).expect("read");
    assert_eq!(reader.document(), session.document());
    assert!(reader.is_read_only() && reader.add_limb("wing", None).is_err() && reader.save().is_err());
    let error = reader.save_as(&path).expect_err("it is edited").to_string();
    assert!(error.contains("another program"), "{error}");
    reader.save_as(&folder.join("copy.marey")).expect("saved");
    reader.add_limb("wing", None).expect("its own now");
    drop(session);
    assert_eq!(open(&path).document().inputs.rig.limbs.len(), 1);
}

#[cfg(target_os = "linux")]
#[test]
fn a_gesture_that_cannot_be_written_is_taken_back() {
    let (_keep, folder) = folder();
    let path = folder.join("walk.marey");
    let mut session = Session::create(&path).expect("created");
    session.set_clip(Some(clip(&folder.join("clip.mp4")))).expect("a clip");
    let document = session.document().clone();
    session.store.fill_disk();
    let error = session.add_limb("body", None).expect_err("the disk is full").to_string();
    assert!(error.contains("walk.marey-journal"), "{error}");
    assert!(session.undo().is_err());
    assert_eq!((session.document(), session.gestures(), session.undo_label()), (&document, 1, Some("choose the clip")));
    drop(session);
    assert_eq!(open(&path).document(), &document);
}

#[test]
fn a_clip_may_move_with_its_session_and_is_told_when_it_is_another() {
    let (_keep, folder) = folder();
    std::fs::create_dir(folder.join("a")).expect("a folder");
    let path = folder.join("a/walk.marey");
    let mut session = Session::create(&path).expect("created");
    draw(&mut session, &folder.join("a"));
    std::fs::write(folder.join("a/mask.png"), b"a picture").expect("written");
    session.save().expect("saved");
    drop(session);
    std::fs::rename(folder.join("a"), folder.join("b")).expect("moved");
    let path = folder.join("b/walk.marey");
    let mut session = open(&path);
    assert_eq!(session.warnings(), &[] as &[String]);
    let found = session.document().inputs.clip.clone().expect("a clip");
    assert_eq!(found.path, folder.join("b/clip.mp4"));

    std::fs::rename(&found.path, folder.join("elsewhere.mp4")).expect("moved");
    let moved = ClipReference { path: folder.join("elsewhere.mp4"), ..(*found).clone() };
    assert!(session.set_clip(Some(moved)).expect("chosen").is_empty(), "the same clip elsewhere");
    session.save().expect("saved");
    drop(session);
    assert!(open(&path).warnings().is_empty());
    std::fs::write(folder.join("elsewhere.mp4"), b"others").expect("written");
    assert!(open(&path).warnings()[0].contains("not the one"), "as long, and another");
    std::fs::remove_file(folder.join("elsewhere.mp4")).expect("removed");
    assert!(open(&path).warnings()[0].contains("is not there"));
}

#[test]
fn a_session_without_a_name_outlives_a_crash_until_it_gets_one() {
    let (_keep, folder) = folder();
    let mut session = Session::create_untitled(&folder).expect("created");
    session.add_limb("body", None).expect("a limb");
    assert!(session.is_untitled() && Session::left_in(&folder).expect("listed").is_empty(), "it is in use");
    drop(session);
    let left = Session::left_in(&folder).expect("listed");
    let mut session = open(&left[0]);
    assert!(left.len() == 1 && session.is_untitled() && session.replayed() == 1);
    session.save_as(&folder.join("walk.marey")).expect("saved");
    assert!(!session.is_untitled() && !session.is_modified() && Session::left_in(&folder).expect("listed").is_empty());
    session.add_limb("wing", None).expect("a limb");
    session.discard().expect("discarded");
    assert_eq!(open(&folder.join("walk.marey")).document().inputs.rig.limbs.len(), 1, "as it was saved");
    Session::create_untitled(&folder).expect("created").discard().expect("discarded");
    let names = std::fs::read_dir(&folder).expect("listed").map(|e| e.expect("an entry").file_name());
    let mut names: Vec<_> = names.collect();
    names.sort();
    assert_eq!(names, ["mask.png", "walk.marey"]);
}
