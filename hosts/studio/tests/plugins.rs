//! Plugins: found, refused with a reason and tried again, chosen where they are used, rebuilt while a session is open.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::{Desk, bar};
use egui_kittest::kittest::Queryable as _;
use marey_studio::egui::accesskit::Role;
use marey_studio::egui::{Key, Modifiers};

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);
const NAME: &str = "Nearest (C example)";

/// The tracker in C that ships, called `version`, built beside and put in place in one go.
fn build(desk: &Desk, version: &str) {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let source = std::fs::read_to_string(root.join("plugins/example-c/nearest.c")).unwrap();
    let (own, built) = (desk.folder.path().join("nearest.c"), desk.folder.path().join("nearest.so"));
    std::fs::write(&own, source.replace("\"1.0.0\"", &format!("\"{version}\""))).unwrap();
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-O2", "-std=gnu11", "-fvisibility=hidden", "-I"]).arg(root.join("include"));
    assert!(cc.arg(&own).arg("-o").arg(&built).status().unwrap().success());
    std::fs::rename(built, plugins(desk).join("nearest.so")).unwrap();
}

fn plugins(desk: &Desk) -> PathBuf {
    desk.folder.path().join("data/plugins")
}

/// It looks by itself every other second.
fn look_again(desk: &mut Desk) {
    if desk.harness.query_by_label("Look again").is_some() {
        desk.click("Look again");
    }
    desk.rest(100);
}

/// Lets time pass until a widget with this name is there.
fn see(desk: &mut Desk, label: &str) {
    let began = std::time::Instant::now();
    while desk.harness.query_all_by_label_contains(label).next().is_none() {
        look_again(desk);
        assert!(began.elapsed().as_secs() < 60, "waited for `{label}`; said: {:?}", desk.harness.state().notices());
    }
    desk.harness.run_steps(3);
}

fn gone(desk: &mut Desk, label: &str) {
    let began = std::time::Instant::now();
    while desk.harness.query_by_label(label).is_some() {
        look_again(desk);
        let said: Vec<_> = desk.harness.query_all_by_label_contains(".so").map(|n| format!("{n:?}")).collect();
        assert!(began.elapsed().as_secs() < 30, "`{label}` is still there: {said:?}");
    }
}

#[test]
fn plugins_are_found_chosen_used_and_rebuilt_while_a_session_is_open() {
    let mut desk = Desk::with_probe(Path::new(env!("CARGO_BIN_EXE_marey-studio")));
    let clip = bar(desk.folder.path());
    std::fs::write(plugins(&desk).join("broken.so"), "no library").unwrap();
    desk.drop_file(&clip);
    desk.wait_open();
    desk.draw(&[(33.0, 32.0), (57.0, 32.0)]);

    // A refused file, with its reason; it is built right and tried again.
    desk.keys(CTRL_SHIFT, Key::P);
    see(&mut desk, "broken.so: ");
    desk.harness.get_by_label("Not loaded");
    build(&desk, "1.0.0");
    see(&mut desk, NAME);
    std::fs::copy(plugins(&desk).join("nearest.so"), desk.folder.path().join("good.so")).unwrap();
    std::fs::remove_file(plugins(&desk).join("nearest.so")).unwrap();
    gone(&mut desk, NAME);
    std::fs::rename(desk.folder.path().join("good.so"), plugins(&desk).join("broken.so")).unwrap();
    desk.click("Try again: broken.so");
    see(&mut desk, NAME);
    see(&mut desk, "1.0.0, by Marey");
    gone(&mut desk, "Not loaded");
    // The same plugin under another name waits until the first is gone, and needs no click then.
    std::fs::copy(plugins(&desk).join("broken.so"), plugins(&desk).join("renamed.so")).unwrap();
    see(&mut desk, "Not loaded");
    std::fs::remove_file(plugins(&desk).join("broken.so")).unwrap();
    gone(&mut desk, "Not loaded");
    see(&mut desk, NAME);
    std::fs::remove_file(plugins(&desk).join("renamed.so")).unwrap();
    gone(&mut desk, NAME);
    build(&desk, "1.0.0");
    desk.harness.check_accessibility();
    desk.click("Close");

    // Chosen where it is used, with what can be chosen about it; one step of undo.
    desk.click("How the creature is made");
    see(&mut desk, "Limbs are followed by");
    desk.click("Limbs are followed by");
    desk.wait("the plugin", move |s| s.notices().iter().all(|n| !n.contains("built anew")));
    see(&mut desk, NAME);
    desk.click(NAME);
    see(&mut desk, "Reach");
    desk.harness.check_accessibility();
    desk.harness.get_by_role_and_label(Role::Slider, "Reach").focus();
    desk.harness.run_steps(2);
    for _ in 0..3 {
        desk.keys(Modifiers::NONE, Key::ArrowRight);
    }
    desk.click("Close");
    assert_eq!(desk.harness.state().open().unwrap().steps().0, Some("how it is made"));
    desk.click("Make the creature");
    desk.wait("the creature", |s| s.open().is_some_and(|o| o.has_creature() && !o.is_busy()));
    assert!(desk.harness.state().notices().iter().all(|n| !n.contains("rror")), "{:?}", desk.harness.state().notices());

    // A new build is taken while the session is open, and used by the next job.
    build(&desk, "2.0.0");
    desk.wait("the new build", |s| s.notices().iter().any(|n| n.contains("built anew")));
    desk.keys(CTRL, Key::Enter);
    desk.wait("the creature again", |s| s.open().is_some_and(|o| !o.is_busy()));
    desk.keys(CTRL_SHIFT, Key::P);
    see(&mut desk, "2.0.0, by Marey");
    desk.click("Close");

    // What was chosen about it is remembered, and the session knows what it is made by.
    let mut desk = desk.again();
    desk.harness.run();
    desk.click("Open bar");
    desk.wait_open();
    desk.wait("the creature", |s| s.open().is_some_and(|o| o.has_creature() && !o.is_busy()));
    desk.click("How the creature is made");
    see(&mut desk, "Reach");
    let remembered = std::fs::read_to_string(desk.folder.path().join("data/preferences.json")).unwrap();
    assert!(remembered.contains("\"reach\": 11.0"), "{remembered}");
}
