//! Ways of working: keys of one's own, the timeline by keyboard, paint, the third dimension by clicks, paths typed.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{BAR_FRAMES, Desk, LEGS, bar, legs};
use egui_kittest::kittest::Queryable as _;
use marey_studio::egui::{Event, Key, Modifiers, PointerButton, Pos2, TouchDeviceId, TouchId, TouchPhase};

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

fn press(desk: &mut Desk, pos: Pos2, button: PointerButton) {
    desk.harness.hover_at(pos);
    for pressed in [true, false] {
        desk.harness.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
    }
    desk.harness.run_steps(3);
}

/// The bar, with a stroke along it.
fn drawn() -> Desk {
    let mut desk = Desk::new();
    let clip = bar(desk.folder.path());
    desk.drop_file(&clip);
    desk.wait_open();
    desk.draw(&[(33.0, 32.0), (57.0, 32.0)]);
    desk
}

fn make(desk: &mut Desk) {
    desk.keys(CTRL, Key::Enter);
    desk.wait("the creature", |s| s.open().is_some_and(|o| o.has_creature() && !o.is_busy()));
}

fn steps(desk: &Desk) -> (Option<String>, Option<String>) {
    let open = desk.harness.state().open().unwrap();
    let (undo, redo) = open.steps();
    (undo.map(str::to_owned), redo.map(str::to_owned))
}

#[test]
fn keys_are_chosen_conflicts_are_told_and_it_is_remembered() {
    let mut desk = drawn();
    desk.keys(Modifiers::NONE, Key::F1);
    desk.click("Keys of First frame: Home");
    desk.harness.get_by_label("First frame: press the keys for it.");
    // Tab stays what it is; Ctrl+K is free.
    desk.keys(Modifiers::NONE, Key::Tab);
    desk.harness.get_by_label_contains("moves through every window");
    desk.keys(CTRL, Key::K);
    desk.harness.get_by_label("Keys of First frame: Ctrl+K");
    // The keys of something else are told, and taken away only where that is wanted.
    desk.click("Keys of Last frame: End");
    desk.keys(CTRL, Key::Z);
    desk.harness.get_by_label_contains("are the keys of: Undo");
    desk.click("Leave it");
    desk.click("Keys of Last frame: End");
    desk.keys(Modifiers::NONE, Key::R);
    desk.harness.get_by_label_contains("are the keys of: Loop, or play once");
    desk.click("Use them here");
    desk.harness.get_by_label("Keys of Loop, or play once: none");
    desk.harness.check_accessibility();
    desk.click("Close");
    let frame = |desk: &Desk| desk.harness.state().open().unwrap().frame();
    desk.keys(Modifiers::NONE, Key::R);
    assert_eq!(frame(&desk), u64::from(BAR_FRAMES) - 1);
    desk.keys(Modifiers::NONE, Key::Home);
    assert_eq!(frame(&desk), u64::from(BAR_FRAMES) - 1, "the old key does nothing");
    desk.keys(CTRL, Key::K);
    assert_eq!(frame(&desk), 0);

    let mut desk = desk.again();
    desk.harness.run();
    desk.keys(Modifiers::NONE, Key::F1);
    desk.harness.get_by_label("Keys of First frame: Ctrl+K");
    desk.click("All keys as they were");
    desk.harness.get_by_label("Keys of Loop, or play once: R");
    desk.keys(Modifiers::NONE, Key::Escape);
    assert!(desk.harness.query_by_label("All keys as they were").is_none());
}

#[test]
fn the_timeline_is_used_by_keyboard_and_shows_poses_around() {
    let mut desk = drawn();
    desk.harness.get_by_label_contains("Timeline").focus();
    desk.harness.run_steps(2);
    let state = |desk: &Desk| {
        let open = desk.harness.state().open().unwrap();
        (open.frame(), open.key_frames().to_vec())
    };
    desk.keys(Modifiers::NONE, Key::ArrowRight);
    desk.keys(Modifiers::NONE, Key::ArrowRight);
    assert_eq!(state(&desk), (2, vec![0]));
    desk.keys(Modifiers::NONE, Key::ArrowLeft);
    desk.keys(Modifiers::NONE, Key::ArrowLeft);
    // With Shift the key frame goes along, a step of undo each.
    desk.keys(Modifiers::SHIFT, Key::ArrowRight);
    assert_eq!(state(&desk), (1, vec![1]));
    desk.keys(Modifiers::NONE, Key::Space);
    assert!(desk.harness.state().open().unwrap().playing());
    desk.keys(Modifiers::NONE, Key::Space);
    assert!(!desk.harness.state().open().unwrap().playing());
    desk.keys(CTRL, Key::Z);
    assert_eq!(state(&desk).1, [0]);

    desk.keys(Modifiers::NONE, Key::Escape);
    desk.keys(Modifiers::NONE, Key::O);
    desk.click("Onion skin: how much");
    desk.harness.get_by_label("Poses before");
    desk.harness.check_accessibility();
    desk.keys(Modifiers::NONE, Key::Escape);
    let remembered = std::fs::read_to_string(desk.folder.path().join("data/preferences.json")).unwrap();
    assert!(remembered.contains("\"on\": true"), "{remembered}");
    desk.click("Timing: on ones");
    desk.click("slow ends");
    assert_eq!(steps(&desk).0.as_deref(), Some("Timing"), "a step of undo");
    desk.keys(Modifiers::NONE, Key::Escape);
    desk.keys(CTRL, Key::Z);
    assert_ne!(steps(&desk).0.as_deref(), Some("Timing"));
}

#[test]
fn what_follows_by_itself_is_undone_with_what_it_follows_from() {
    let mut desk = drawn();
    make(&mut desk);
    desk.keys(Modifiers::NONE, Key::Space);
    desk.keys(Modifiers::NONE, Key::Home);
    desk.click("Draw limb 1");
    let before = desk.harness.state().open().unwrap().fingerprint().unwrap();
    desk.draw(&[(34.0, 33.0), (58.0, 33.0)]);
    desk.wait("the correction", |s| s.open().is_some_and(|o| !o.is_busy()));
    let after = desk.harness.state().open().unwrap().fingerprint().unwrap();
    assert_eq!(steps(&desk).0.as_deref(), Some("stroke"));
    desk.keys(CTRL, Key::Z);
    desk.rest(300);
    assert_eq!(desk.harness.state().open().unwrap().fingerprint().unwrap(), before);
    assert_eq!(steps(&desk), (Some("making the creature".into()), Some("stroke".into())));
    desk.keys(CTRL_SHIFT, Key::Z);
    desk.rest(300);
    assert_eq!(desk.harness.state().open().unwrap().fingerprint().unwrap(), after);
    assert_eq!(steps(&desk), (Some("stroke".into()), None));
}

#[test]
fn ends_are_turned_by_clicks_and_what_was_cut_out_wrong_is_painted() {
    let mut desk = drawn();
    let end = desk.harness.state().open().unwrap().on_screen((57.0, 32.0));
    for step in ["facing", "facing"] {
        press(&mut desk, end, PointerButton::Secondary);
        assert_eq!(steps(&desk).0.as_deref(), Some(step));
    }
    assert_eq!(desk.harness.state().open().unwrap().selected(), Some(0));

    make(&mut desk);
    desk.keys(Modifiers::NONE, Key::Space);
    desk.keys(Modifiers::NONE, Key::Home);
    desk.click("Paint what is not the creature");
    // A pen that says how hard it is pressed.
    let at = desk.harness.state().open().unwrap().on_screen((60.0, 50.0));
    desk.harness.hover_at(at);
    desk.harness.drag_at(at);
    for step in 1..=5 {
        let pos = at + Pos2::new(6.0 * step as f32, 0.0).to_vec2();
        desk.harness.event(Event::Touch {
            device_id: TouchDeviceId(1),
            id: TouchId(1),
            phase: TouchPhase::Move,
            pos,
            force: Some(1.0),
        });
        desk.harness.hover_at(pos);
    }
    desk.harness.drop_at(at + Pos2::new(30.0, 0.0).to_vec2());
    desk.harness.run_steps(3);
    assert_eq!(steps(&desk).0.as_deref(), Some("painting"));
    assert_eq!(desk.limbs().len(), 1, "it is no limb");
    desk.harness.get_by_label("Update the creature");
    make(&mut desk);
    desk.keys(Modifiers::NONE, Key::Space);
    desk.keys(Modifiers::NONE, Key::Home);
    desk.click("Clear this frame");
    assert_eq!(steps(&desk).0.as_deref(), Some("removing paint"));
    assert!(desk.harness.query_by_label("Clear this frame").is_none());
    desk.keys(Modifiers::NONE, Key::D);
    desk.keys(Modifiers::NONE, Key::N);
    desk.draw(&[(33.0, 40.0), (57.0, 50.0)]);
    assert_eq!(desk.limbs().len(), 2);
}

#[test]
fn paths_are_typed_where_there_is_no_dialog() {
    let mut desk = Desk::new();
    let clip = bar(desk.folder.path());
    desk.harness.run();
    desk.click("Choose a clip…");
    desk.type_path("~/nothing.mp4");
    desk.harness.get_by_label_contains("there is nothing under this name");
    desk.harness.check_accessibility();
    desk.type_path(clip.to_str().unwrap());
    desk.wait_open();
    desk.draw(&[(33.0, 32.0), (57.0, 32.0)]);
    desk.keys(CTRL, Key::S);
    desk.click("Cancel");
    desk.keys(CTRL, Key::S);
    desk.type_path("~/walk.marey");
    desk.harness.get_by_label("Saved");
    assert!(desk.home().join("walk.marey").exists());

    make(&mut desk);
    desk.click("Export…");
    desk.click("GIF");
    desk.click("Browse…");
    desk.type_path("walking.gif");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    assert!(desk.home().join("walking.gif").exists(), "{:?}", desk.harness.state().notices());
}

#[test]
fn of_limbs_that_cross_a_click_says_which_is_in_front() {
    let mut desk = Desk::new();
    let clip = legs(desk.folder.path());
    desk.drop_file(&clip);
    desk.wait_open();
    LEGS.iter().for_each(|limb| desk.draw(limb));
    desk.keys(Modifiers::NONE, Key::I);
    assert!(desk.harness.state().notices()[0].contains("Make the creature first"));
    make(&mut desk);
    if desk.open().playing() {
        desk.keys(Modifiers::NONE, Key::Space);
    }
    desk.keys(Modifiers::NONE, Key::Home);
    let before = desk.open().overlaps();
    assert_eq!(before.len(), 1, "{before:?}");
    let (front, behind, at) = before[0];
    assert!((at.0 - 48.0).abs() < 3.0 && (at.1 - 38.0).abs() < 3.0, "{at:?}");
    let order = |desk: &Desk| {
        let now = desk.open().overlaps();
        (now[0].0, now[0].1)
    };

    // A click on the mark: one step, which leaves what was drawn alone, and is undone.
    let made = desk.open().fingerprint().unwrap();
    let mark = desk.open().on_screen(at);
    press(&mut desk, mark, PointerButton::Primary);
    assert_eq!((order(&desk), desk.limbs().len()), ((behind, front), 3));
    assert_eq!(steps(&desk).0.as_deref(), Some("which limb is in front"));
    assert!(!desk.open().is_motion_outdated(), "nothing is to be followed again");
    desk.harness.get_by_label("Update the creature");
    desk.keys(CTRL, Key::Z);
    assert_eq!((order(&desk), desk.open().fingerprint().unwrap()), ((front, behind), made));
    desk.keys(CTRL_SHIFT, Key::Z);
    assert_eq!(order(&desk), (behind, front));

    // Clicked twice, nothing is said any more.
    press(&mut desk, mark, PointerButton::Primary);
    assert_eq!((order(&desk), desk.open().fingerprint().unwrap()), ((front, behind), made));

    // By the menu of a limb, away from where they cross.
    let ([from, to], share) = (LEGS[behind], 0.78);
    let beside = desk.open().on_screen((from.0 + (to.0 - from.0) * share, from.1 + (to.1 - from.1) * share));
    press(&mut desk, beside, PointerButton::Secondary);
    let label = |limb: usize| format!("limb {}", limb + 1);
    desk.click(&format!("In front of {}", label(front)));
    assert_eq!(order(&desk), (behind, front));
    press(&mut desk, beside, PointerButton::Secondary);
    desk.click("As the machine has it");
    assert_eq!(order(&desk), (front, behind));

    // By keyboard, and by the panel, which has the selected limb's.
    desk.click(&format!("Draw {}", label(behind)));
    desk.keys(Modifiers::NONE, Key::I);
    assert_eq!(order(&desk), (behind, front));
    desk.click(&format!("Behind {}", label(front)));
    assert_eq!(order(&desk), (front, behind));
    desk.keys(Modifiers::NONE, Key::I);

    // The creature that is made of it has it so by itself, and it is there after a crash.
    make(&mut desk);
    desk.keys(Modifiers::NONE, Key::Space);
    desk.keys(Modifiers::NONE, Key::Home);
    assert_eq!(order(&desk), (behind, front));
    assert!(!desk.open().is_motion_outdated());
    let mut desk = desk.again();
    desk.harness.run();
    desk.click("Open legs");
    desk.wait_open();
    desk.wait("the creature", |s| s.open().is_some_and(|o| o.has_creature() && !o.is_busy()));
    if desk.open().playing() {
        desk.keys(Modifiers::NONE, Key::Space);
    }
    desk.keys(Modifiers::NONE, Key::Home);
    assert_eq!(order(&desk), (behind, front));
}
