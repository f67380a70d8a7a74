//! Damage, crashes and full disks.

use super::*;

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
        let Document { inputs, tracked, .. } = session.document();
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
