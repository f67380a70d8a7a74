//! How long a person takes from a clip of their own to an exported creature, by the keystroke-level model of Card, Moran and
//! Newell (Communications of the ACM 23(7), 1980), with what the machine takes as it is measured.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::print_stdout, reason = "it says what it measured")]

mod common;

use std::path::{Path, PathBuf};
use std::time::Instant;

use common::Desk;
use marey_studio::egui::{Key, Modifiers};

// Seconds an operator.
/// A key or a button of the mouse, an average person.
const K: f64 = 0.28;
/// Pointing.
const P: f64 = 1.10;
/// A hand from the mouse to the keyboard or back.
const H: f64 = 0.40;
/// Making up one's mind; charged for every operation.
const M: f64 = 1.35;
/// Points of the screen in a centimetre, at 96 to the inch.
const CM: f64 = 96.0 / 2.54;

/// What is asked of the studio.
const MOST: (f64, u32) = (300.0, 25);

struct Person {
    desk: Desk,
    operations: u32,
    /// Seconds of the person's own, and of waiting.
    own: f64,
    waited: f64,
}

impl Person {
    fn operation(&mut self, seconds: f64) {
        self.operations += 1;
        self.own += M + seconds;
    }

    fn click(&mut self, label: &str) {
        self.operation(P + 2.0 * K / 2.0);
        self.desk.click(label);
    }

    fn key(&mut self, key: Key) {
        self.operation(2.0 * H + K);
        self.desk.harness.key_press_modifiers(Modifiers::NONE, key);
        self.desk.harness.run_steps(3);
    }

    /// Drawing takes 0.9 s for each straight part and 0.16 s for each centimetre.
    fn draw(&mut self, points: &[(f32, f32)]) {
        let at: Vec<_> = points.iter().map(|p| self.desk.harness.state().open().unwrap().on_screen(*p)).collect();
        let length: f32 = at.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        self.operation(P + K + 0.9 * (points.len() - 1) as f64 + 0.16 * f64::from(length) / CM);
        self.desk.draw(points);
    }

    fn wait(&mut self, what: &str, so: impl Fn(&marey_studio::Studio) -> bool) {
        let began = Instant::now();
        self.desk.wait(what, so);
        self.waited += began.elapsed().as_secs_f64();
    }
}

/// Limbs on the fox's first frame as a person draws them, a few straight parts each.
fn limbs(scale: f32) -> Vec<Vec<(f32, f32)>> {
    let text = std::fs::read_to_string(fox().join("strokes-k3.json")).unwrap();
    let strokes: serde_json::Value = serde_json::from_str(&text).unwrap();
    let of = |stroke: &serde_json::Value| {
        let points: Vec<(f32, f32)> = serde_json::from_value(stroke["points"].clone()).unwrap();
        // Every part of a third: a hand does not draw in steps of a pixel.
        let parts = 3.min(points.len() - 1);
        (0..=parts).map(|i| points[i * (points.len() - 1) / parts]).map(|(x, y)| (x * scale, y * scale)).collect()
    };
    strokes["keyframes"][0]["strokes"].as_array().unwrap().iter().map(of).collect()
}

fn fox() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/fox")
}

/// A third of the clip's size and half of its frames, for a test that must not take long.
fn smaller(folder: &Path) -> (PathBuf, f32) {
    let context = marey_binding::Context::new(0).unwrap();
    let clip = context.open_clip(fox().join("clip.mp4").to_str().unwrap()).unwrap();
    let info = clip.info().unwrap();
    let to = folder.join("fox");
    std::fs::create_dir(&to).unwrap();
    for frame in (0..info.frames).step_by(2) {
        let whole = image::RgbImage::from_raw(info.width, info.height, clip.frame(frame).unwrap().to_vec()).unwrap();
        let small = image::imageops::thumbnail(&whole, info.width / 3, info.height / 3);
        small.save(to.join(format!("{frame:05}.png"))).unwrap();
    }
    (to, 1.0 / 3.0)
}

fn clip_to_creature(clip: impl FnOnce(&Path) -> (PathBuf, f32)) {
    let desk = Desk::new();
    let (clip, scale) = clip(desk.folder.path());
    let mut person = Person { desk, operations: 0, own: 0.0, waited: 0.0 };
    // Dragged from a folder onto the window.
    person.operation(2.0 * P + 2.0 * K);
    person.desk.drop_file(&clip);
    person.wait("the clip", |s| s.open().is_some());
    person.desk.harness.run_steps(3);
    for limb in limbs(scale) {
        person.draw(&limb);
    }
    assert_eq!(person.desk.limbs().len(), 7);
    person.click("Make the creature");
    let made = |s: &marey_studio::Studio| s.open().is_some_and(|o| o.has_creature() && !o.is_busy());
    person.wait("the creature", made);
    // Three corrections where they help most; what is drawn is followed while the person goes on.
    for _ in 0..3 {
        person.key(Key::C);
        let open = person.desk.harness.state().open().unwrap();
        let (limb, frame) = (open.selected().unwrap(), open.frame());
        let points = open.tracked(limb, frame).unwrap();
        let parts = 3.min(points.len() - 1);
        let drawn: Vec<_> = (0..=parts).map(|i| points[i * (points.len() - 1) / parts]).collect();
        person.draw(&drawn);
    }
    person.wait("the corrections", |s| s.open().is_some_and(|o| !o.is_busy()));
    person.click("Update the creature");
    person.wait("the creature", made);
    person.click("Export…");
    person.click("Export");
    person.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    let name = clip.file_stem().unwrap().to_str().unwrap();
    assert_eq!(&std::fs::read(person.desk.home().join(format!("{name}.glb"))).unwrap()[..4], b"glTF");

    let Person { operations, own, waited, .. } = person;
    println!("{operations} operations, {own:.0} s of a person's, {waited:.0} s of waiting: {:.0} s", own + waited);
    assert!(operations <= MOST.1 && own + waited < MOST.0);
}

#[test]
fn a_small_clip_becomes_a_creature_in_a_few_operations() {
    clip_to_creature(smaller);
}

#[test]
#[ignore = "the whole clip; cargo xtask studio"]
fn a_clip_becomes_a_creature_in_minutes_and_few_operations() {
    clip_to_creature(|_| (fox().join("clip.mp4"), 1.0));
}

/// The keystroke aim of the second drawing on a motion that was captured.
const SECOND: f64 = 20.0;

#[test]
fn a_second_drawing_takes_a_captured_motion_in_seconds() {
    let mut desk = Desk::new();
    let clip = common::legs(desk.folder.path());
    let child = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/characters/child/drawing.png");
    // Another drawing, with another skeleton.
    let second = desk.folder.path().join("second.png");
    let picture = image::open(&child).unwrap().to_rgba8();
    image::imageops::flip_horizontal(&picture).save(&second).unwrap();
    desk.harness.state_mut().open_picture(&child);
    desk.wait_open();
    let busy = |s: &marey_studio::Studio| s.open().is_none_or(|o| o.joints().is_empty() || o.is_busy());
    desk.wait("the skeleton", move |s| !busy(s));
    desk.click("From a clip…");
    desk.type_path(clip.to_str().unwrap());
    desk.wait("the clip", move |s| {
        !busy(s) && s.open().is_some_and(|o| o.on_clip((0.0, 0.0)) != o.on_clip((1.0, 0.0)))
    });
    desk.harness.run_steps(3);
    for at in [(48.0, 18.0), (20.0, 18.0), (72.0, 18.0), (62.0, 54.0), (34.0, 54.0), (40.0, 30.0)] {
        let at = desk.open().on_clip(at);
        desk.click_at(at);
    }
    let moves = move |s: &marey_studio::Studio| !busy(s) && s.open().is_some_and(|o| o.moves());
    desk.wait("the first drawing", moves);

    let mut person = Person { desk, operations: 0, own: 0.0, waited: 0.0 };
    // Dragged from a folder onto the window.
    person.operation(2.0 * P + 2.0 * K);
    let first = person.desk.open().joints();
    person.desk.drop_file(&second);
    let other = move |s: &marey_studio::Studio| moves(s) && s.open().is_some_and(|o| o.joints() != first);
    person.wait("the second drawing", other);
    person.click("Export…");
    person.click("Export");
    person.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    assert!(std::fs::read_dir(person.desk.home()).unwrap().next().is_some());
    let Person { operations, own, waited, .. } = person;
    println!("{operations} operations, {own:.1} s of a person's, {waited:.1} s of waiting");
    assert!(operations <= 3 && own + waited < SECOND, "{own} {waited}");
}
