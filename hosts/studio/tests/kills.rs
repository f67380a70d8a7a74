//! kill -9 at random moments: the next start offers everything up to the last gesture.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::print_stdout, reason = "a life says what it did")]

mod common;

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::gestures::{Chance, drew, drop_file};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use marey_studio::Studio;
use marey_studio::egui::{Key, Modifiers};

/// The longest life.
const LIFE_MS: usize = 1500;
/// Says to a process of this test that it is a life: its folder and its seed.
const LIFE: (&str, &str) = ("MAREY_STUDIO_LIFE", "MAREY_STUDIO_SEED");

#[test]
fn nothing_is_lost_when_it_is_killed() {
    kill(3, 7);
}

#[test]
#[ignore = "minutes; cargo xtask studio"]
fn nothing_is_lost_at_fifty_moments() {
    kill(50, 1);
}

fn kill(times: usize, seed: u64) {
    let mut chance = Chance::new(seed);
    let folder = tempfile::tempdir().unwrap();
    let clip = common::bar(folder.path());
    let (mut words, mut offered, mut known) = (0, 0, None);
    for time in 0..times {
        // Some die while they start and open what there is.
        let from = if time % 5 == 4 { "running" } else { "at " };
        let life = Duration::from_millis(chance.below(LIFE_MS) as u64);
        let said = live_and_die(folder.path(), seed + time as u64, from, life);
        words += said.len();
        let Some((gestures, fingerprint)) = said.last().copied().or(known) else { continue };
        let mut harness = common::harness(folder.path(), common::Nothing);
        harness.run();
        assert!(harness.query_by_label("Open bar").is_some(), "kill {time}: it is not offered");
        open(&mut harness, &clip);
        let open = harness.state().open().unwrap();
        let now = (open.gestures(), open.fingerprint().unwrap());
        // The last one may have been on the disk before it could be said.
        if now.0 == gestures {
            assert_eq!(now.1, fingerprint, "kill {time}, after {gestures} gestures");
        } else {
            assert!((gestures..=gestures + 2).contains(&now.0), "{gestures} finished: {}", now.0);
        }
        offered += 1;
        // The next life goes on with it: this one is let go of without a word, too.
        known = Some(now);
    }
    println!("{times} kills, {offered} sessions offered and alike, {words} gestures said");
    assert!(offered > times / 2 && words > 2 * times, "the lives are too short to tell");
}

/// Lets the studio live for so long from a word of its own on, and kills it; gives the states that it said were reached.
fn live_and_die(folder: &Path, seed: u64, from: &'static str, life: Duration) -> Vec<(u64, u64)> {
    let mut studio = Command::new(std::env::current_exe().unwrap());
    studio.args(["--exact", "a_life", "--ignored", "--nocapture"]).stdout(Stdio::piped());
    let mut studio = studio.env(LIFE.0, folder).env(LIFE.1, seed.to_string()).spawn().unwrap();
    let (heard, first) = std::sync::mpsc::channel();
    let lines = BufReader::new(studio.stdout.take().unwrap()).lines();
    let reader = std::thread::spawn(move || {
        let parse = |line: String| {
            if line.starts_with(from) {
                let _ = heard.send(());
            }
            let (gestures, fingerprint) = line.strip_prefix("at ")?.split_once(' ')?;
            Some((gestures.parse().ok()?, fingerprint.parse().ok()?))
        };
        lines.map_while(Result::ok).filter_map(parse).collect()
    });
    first.recv_timeout(Duration::from_secs(60)).unwrap();
    std::thread::sleep(life);
    studio.kill().unwrap();
    assert_eq!(studio.wait().unwrap().code(), None, "it ended by itself");
    reader.join().unwrap()
}

/// Opens what was left, or the clip.
fn open(harness: &mut Harness<'static, Studio>, clip: &Path) {
    match harness.query_by_label("Open bar") {
        Some(left) => left.click(),
        None => drop_file(harness, clip.to_owned()),
    }
    let began = Instant::now();
    while harness.state().open().is_none() {
        harness.step();
        std::thread::sleep(Duration::from_millis(2));
        assert!(began.elapsed() < Duration::from_secs(60), "{:?}", harness.state().notices());
    }
}

/// Not a test by itself: what is killed.
#[test]
#[ignore = "run by the others"]
fn a_life() {
    let (Some(folder), Ok(seed)) = (std::env::var_os(LIFE.0), std::env::var(LIFE.1)) else { return };
    let folder = Path::new(&folder);
    let mut harness = common::harness(folder, common::Nothing);
    harness.run();
    open(&mut harness, &folder.join("bar"));
    let mut chance = Chance::new(seed.parse().unwrap());
    const SHORTCUTS: [(Modifiers, Key); 9] = [
        (Modifiers::COMMAND, Key::Z),
        (Modifiers::COMMAND, Key::Z),
        (Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z),
        (Modifiers::COMMAND, Key::Enter),
        (Modifiers::NONE, Key::N),
        (Modifiers::NONE, Key::L),
        (Modifiers::NONE, Key::Delete),
        (Modifiers::NONE, Key::Period),
        (Modifiers::NONE, Key::Home),
    ];
    let mut told = 0;
    loop {
        if chance.below(3) == 0 {
            let (modifiers, key) = SHORTCUTS[chance.below(SHORTCUTS.len())];
            harness.key_press_modifiers(modifiers, key);
        } else {
            drew(&mut harness, &mut chance);
        }
        harness.step();
        harness.step();
        let open = harness.state().open().unwrap();
        if open.gestures() != told {
            told = open.gestures();
            let mut out = std::io::stdout().lock();
            writeln!(out, "at {told} {}", open.fingerprint().unwrap()).unwrap();
            out.flush().unwrap();
        }
    }
}
