//! Edits, gestures, and what they put out of date.

use super::*;

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
