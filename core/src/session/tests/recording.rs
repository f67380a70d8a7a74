//! What was recorded leads to the same document again, wherever and however often it is played.

use super::*;

#[test]
fn a_recording_leads_to_the_same_document() {
    let (_keep, folder) = folder();
    let path = folder.join("what.recording");
    let mut session = Session::new();
    session.add_limb("early", None).expect("a limb");
    session.start_recording(&path).expect("recording");
    draw(&mut session, &folder);
    for _ in 0..5 {
        session.undo().expect("undone");
    }
    session.redo().expect("redone");
    session.begin_gesture("oops").expect("begun");
    session.remove_limb(0).expect("gone");
    session.cancel_gesture().expect("cancelled");
    assert!(session.is_recording() && session.stop_recording() && !session.stop_recording());
    let after = session.fingerprint();
    session.set_parameter("creature.smoothing", Some(Value::Number(0.3))).expect("after the end");
    assert_ne!(session.fingerprint(), after);

    let played = Session::replay_recording(&path, usize::MAX).expect("played");
    assert_eq!((played.fingerprint(), played.replayed() as u64), (after, DRAWN + 6));
    assert!(played.warnings().is_empty() && played.path().is_none());
    let (mut part, mut whole) = (Session::replay_recording(&path, 4).expect("played"), Session::new());
    assert_eq!(part.replayed(), 4);
    // What is left to do by hand leads there, too.
    whole.add_limb("early", None).expect("a limb");
    draw(&mut whole, &folder);
    while part.undo().expect("undone").is_some() {}
    draw(&mut part, &folder);
    assert_eq!(part.fingerprint(), whole.fingerprint());
}

#[test]
fn a_damaged_recording_is_played_to_the_damage() {
    let (_keep, folder) = folder();
    let path = folder.join("what.recording");
    let mut session = Session::new();
    session.start_recording(&path).expect("recording");
    draw(&mut session, &folder);
    let whole = std::fs::read(&path).expect("written");
    for cut in 0..whole.len() {
        std::fs::write(&path, &whole[..cut]).expect("written");
        if let Ok(played) = Session::replay_recording(&path, usize::MAX) {
            assert!(played.replayed() as u64 <= DRAWN, "cut at {cut}");
        }
    }
    for at in (0..whole.len()).step_by(7) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x11;
        std::fs::write(&path, &bytes).expect("written");
        let _ = Session::replay_recording(&path, usize::MAX);
    }
    assert!(Session::replay_recording(&folder.join("none"), 1).is_err());
    std::fs::write(&path, b"").expect("written");
    assert!(Session::replay_recording(&path, 1).is_err());
    assert!(session.start_recording(&path).is_err(), "a file that exists is left alone");
}

#[test]
fn a_fingerprint_does_not_depend_on_where_files_lie() {
    let ((_keep, here), (_too, there)) = (folder(), folder());
    let of = |folder: &Path| {
        let mut session = Session::new();
        draw(&mut session, folder);
        session.fingerprint()
    };
    assert_eq!(of(&here), of(&there));
}
