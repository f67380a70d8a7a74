//! Saving, opening, moving, and who may.

use super::*;

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
        record::encode(&serde_json::json!({"format": "marey-journal", "version": 3, "session": ""})).expect("text");
    std::fs::write(path_of(&path), &newer).expect("written");
    let error = Session::open(&path, Access::Edit, Progress::new().whole()).expect_err("newer").to_string();
    assert!(error.contains("version 3") && error.contains("walk.marey-journal"), "{error}");
    assert_eq!(std::fs::read_to_string(path_of(&path)).expect("kept"), newer);
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
