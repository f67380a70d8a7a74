//! Random gestures: nothing panics, nothing grows, and what is undone is done again to the bit.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::print_stdout, reason = "it says how far it came")]

mod common;

use std::collections::{HashMap, VecDeque};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use common::gestures::{Chance, drew, drop_file, gesture};
use egui_kittest::kittest::Queryable as _;
use egui_kittest::{Harness, TestRenderer};
use marey_studio::Studio;
use marey_studio::egui::{Context, FullOutput, Key, TextureId, TexturesDelta};

/// Gestures from one look at the undo history to the next, and from one look at the memory to the next.
const LOOKS: (u64, u64) = (100, 1000);
/// Memory that may come and go, MB: what the allocator keeps, glyphs, a creature.
const SLACK: f64 = 64.0;

#[test]
fn hundreds_of_random_gestures_do_no_harm() {
    live(1, 300);
}

/// `GESTURES` and `SEED` say otherwise.
#[test]
#[ignore = "an hour; cargo xtask studio"]
fn a_hundred_thousand_random_gestures_do_no_harm() {
    let of = |name: &str| std::env::var(name).ok().and_then(|v| v.parse().ok());
    live(of("SEED").unwrap_or(1), of("GESTURES").unwrap_or(100_000));
}

/// Draws nothing, and knows the bytes of the textures that there are.
#[derive(Clone, Default)]
struct Textures(Arc<Mutex<HashMap<TextureId, usize>>>);

impl TestRenderer for Textures {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let mut held = self.0.lock().unwrap();
        for (id, images) in delta.set.drain() {
            // A part of a texture is no new one.
            for image in images.iter().filter(|image| image.pos.is_none()) {
                held.insert(id, 4 * image.image.width() * image.image.height());
            }
        }
        for id in std::mem::take(&mut delta.free) {
            held.remove(&id);
        }
    }

    fn render(&mut self, _: &Context, _: &FullOutput) -> Result<image::RgbaImage, String> {
        Err("it draws nothing".into())
    }
}

/// Says what led to a panic.
struct Trail(u64, VecDeque<(u64, &'static str)>);

impl Drop for Trail {
    fn drop(&mut self) {
        if std::thread::panicking() {
            println!("seed {}, the last gestures: {:?}", self.0, self.1);
        }
    }
}

fn live(seed: u64, count: u64) {
    let folder = tempfile::tempdir().unwrap();
    // What is typed as the name of an export may be no whole path.
    std::env::set_current_dir(folder.path()).unwrap();
    let clip = common::bar(folder.path());
    let textures = Textures::default();
    let mut harness = common::harness(folder.path(), textures.clone());
    let mut chance = Chance::new(seed);
    let mut trail = Trail(seed, VecDeque::new());
    let (mut undone, mut memory, began) = (0, Vec::new(), Instant::now());
    for number in 1..=count {
        let name = gesture(&mut harness, &mut chance, &clip);
        trail.1.push_back((number, name));
        if trail.1.len() > 20 {
            trail.1.pop_front();
        }
        if number % LOOKS.0 == 0 {
            undone += undo_and_redo(&mut harness, &mut chance, &clip);
        }
        if number % LOOKS.1 == 0 {
            let held = textures.0.lock().unwrap().values().sum::<usize>();
            leave(&mut harness, folder.path());
            memory.push(resident());
            let threads = std::fs::read_dir("/proc/self/task").map_or(0, Iterator::count);
            let (texture, resident) = (held as f64 / 1e6, memory.last().unwrap());
            println!(
                "{number} gestures, {:.0?}, {resident:.0} MB, textures {texture:.0} MB, {threads} threads",
                began.elapsed()
            );
            assert!(texture < 400.0, "textures are held");
        }
    }
    println!("{count} gestures of seed {seed}, {undone} steps undone and done again, {:.0?}", began.elapsed());
    assert!(undone > 0, "nothing was undone: the driver does nothing");
    if memory.len() >= 8 {
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let quarter = memory.len() / 4;
        let (early, late) = (mean(&memory[quarter..2 * quarter]), mean(&memory[memory.len() - quarter..]));
        println!("resident memory: {early:.0} MB in the second quarter, {late:.0} MB in the last");
        assert!(late < early + SLACK, "it grows");
    }
}

/// Clicks on a button of the bar: which keys are whose may have been changed.
fn click(harness: &mut Harness<'static, Studio>, label: &str) {
    let button = harness.query_all_by_label_contains(label).next();
    button.unwrap_or_else(|| panic!("no {label}")).click();
    harness.run_steps(3);
}

/// Lets go of dialogs, lists and texts, and waits for jobs.
fn settle(harness: &mut Harness<'static, Studio>) {
    for _ in 0..6 {
        harness.key_press(Key::Escape);
        harness.run_steps(3);
    }
    let began = Instant::now();
    while harness.state().open().is_some_and(|o| o.is_busy()) {
        harness.step();
        std::thread::sleep(Duration::from_millis(2));
        assert!(began.elapsed() < Duration::from_secs(120), "a job does not end: {:?}", harness.state().notices());
    }
}

/// Undoes some steps and does them again; gives how many.
fn undo_and_redo(harness: &mut Harness<'static, Studio>, chance: &mut Chance, clip: &Path) -> usize {
    settle(harness);
    let began = Instant::now();
    if harness.state().open().is_none() {
        drop_file(harness, clip.to_owned());
        while harness.state().open().is_none() && began.elapsed() < Duration::from_secs(60) {
            harness.step();
            std::thread::sleep(Duration::from_millis(2));
        }
    }
    drew(harness, chance);
    settle(harness);
    let print = |harness: &Harness<'static, Studio>| harness.state().open().unwrap().fingerprint().unwrap();
    let label = |harness: &Harness<'static, Studio>| format!("{:?}", harness.state().open().unwrap().steps());
    let (mut states, mut labels) = (vec![print(harness)], vec![label(harness)]);
    for _ in 0..=chance.below(8) {
        if harness.state().open().unwrap().steps().0.is_none() {
            break;
        }
        let before = harness.state().open().unwrap().gestures();
        click(harness, "Undo: ");
        assert!(harness.state().open().unwrap().gestures() > before, "undo does nothing");
        states.push(print(harness));
        labels.push(label(harness));
    }
    for state in states.iter().rev().skip(1) {
        assert!(harness.state().open().unwrap().steps().1.is_some(), "what was undone cannot be done again");
        click(harness, "Redo: ");
        let now = label(harness);
        assert_eq!(print(harness), *state, "undone and done again: {labels:?}, now {now}");
    }
    settle(harness);
    states.len() - 1
}

/// Goes back to the start, and clears away what was left unsaved: a list of thousands is no leak.
fn leave(harness: &mut Harness<'static, Studio>, folder: &Path) {
    settle(harness);
    if harness.state().open().is_some() {
        click(harness, "To the start");
    }
    assert!(harness.state().open().is_none());
    for left in std::fs::read_dir(folder.join("data/unsaved")).unwrap() {
        std::fs::remove_file(left.unwrap().path()).unwrap();
    }
}

/// Resident memory in MB; 0 where the system does not say.
fn resident() -> f64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = statm.split_whitespace().nth(1).and_then(|p| p.parse::<f64>().ok()).unwrap_or(0.0);
    pages * 4096.0 / 1e6
}
