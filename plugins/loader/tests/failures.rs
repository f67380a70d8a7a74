//! Every way for a plugin to fail: the precise status, one plain line, and a host that lives on. Each is tried in a
//! process of its own.

mod common;

use std::path::Path;
use std::time::{Duration, Instant};

use marey::Error;
use marey::deform::{Deformer as _, Handle, RestMesh};
use marey::job::Progress;
use marey::segment::Segmenter as _;
use marey::track::Tracker as _;
use marey::vec2;
use marey_plugin_loader::{DoorKind, LogLevel, PluginKind, Policy, Registry, Status, Value};

/// How a file comes to be.
enum Made {
    C(&'static [&'static str]),
    Bytes(fn(&[u8]) -> Vec<u8>),
}

struct Case {
    name: &'static str,
    made: Made,
    /// Whether the file is tried in another process first.
    probe: bool,
    status: Status,
    /// What the line must hold.
    says: &'static str,
}

const fn c(name: &'static str, flags: &'static [&'static str], status: Status, says: &'static str) -> Case {
    Case { name, made: Made::C(flags), probe: false, status, says }
}

const fn bytes(name: &'static str, made: fn(&[u8]) -> Vec<u8>, status: Status, says: &'static str) -> Case {
    Case { name, made: Made::Bytes(made), probe: false, status, says }
}

const fn probed(name: &'static str, flags: &'static [&'static str], status: Status, says: &'static str) -> Case {
    Case { name, made: Made::C(flags), probe: true, status, says }
}

/// What fails while it is loaded.
const LOADING: &[Case] = &[
    c("missing symbol", &["MISSING_SYMBOL"], Status::NoEntry, "exports no plugin"),
    c("other ABI", &["OTHER_ABI"], Status::AbiVersion, "version 99.0"),
    c("small entry", &["SMALL_ENTRY"], Status::Layout, "16 bytes"),
    c("missing function", &["NULL_FUNCTION"], Status::Layout, "NULL"),
    c("undefined symbol", &["UNDEFINED_SYMBOL"], Status::Dlopen, "nobody_has_this_function"),
    c("init fails", &["INIT_FAILS"], Status::Init, "no licence"),
    c("init fails in silence", &["SILENT_FAILURE"], Status::Init, "without a reason"),
    c("constructor error", &["CREATE_FAILS"], Status::Init, "no model file"),
    c("constructor gives nothing", &["NO_INSTANCE"], Status::Init, "no instance"),
    c("constructor hangs", &["CREATE_HANGS"], Status::Timeout, "not loaded after"),
    c("nothing inside", &["NO_PLUGINS"], Status::Descriptor, "no plugin in the library"),
    c("descriptor missing", &["NULL_DESCRIPTOR"], Status::Descriptor, "NULL"),
    c("range is not finite", &["BAD_DESCRIPTOR"], Status::Descriptor, "lift"),
    c("bad id", &["ID=\"Spaces and CAPITALS\""], Status::Descriptor, "is no id"),
    bytes("half a file", |good| good[..good.len() / 2].to_vec(), Status::Truncated, "cut off"),
    bytes("a tenth of a file", |good| good[..good.len() / 10].to_vec(), Status::Truncated, "cut off"),
    bytes("all but a byte", |good| good[..good.len() - 1].to_vec(), Status::Truncated, "cut off"),
    bytes("an empty file", |_| Vec::new(), Status::Truncated, "empty"),
    bytes("a text file", |_| b"#!/bin/sh\necho hello\n".to_vec(), Status::Format, "no ELF"),
    bytes("zeros", |good| vec![0; good.len()], Status::Format, "no ELF"),
    bytes("another machine", |good| [&good[..18], &[40, 0], &good[20..]].concat(), Status::Format, "another machine"),
    bytes("a program", |good| [&good[..16], &[2, 0], &good[18..]].concat(), Status::Format, "no shared library"),
    probed("exit on load", &["EXIT_ON_LOAD"], Status::Crashed, "exit code 0"),
    probed("crash on load", &["CRASH_ON_LOAD"], Status::Crashed, "signal 11"),
    probed("hang on load", &["HANG_ON_LOAD"], Status::Timeout, "not loaded after"),
    probed("constructor error in a probe", &["CREATE_FAILS"], Status::Init, "no model file"),
];

/// What fails at work.
const WORKING: &[Case] = &[
    c("NaN output", &["NOT_A_NUMBER"], Status::Output, "limb 0 on frame 0: point"),
    c("NaN output, answers ignored", &["NOT_A_NUMBER", "IGNORES_ANSWERS"], Status::Output, "NaN"),
    c("far away", &["FAR_AWAY"], Status::Output, "point 0"),
    c("NaN confidence", &["BAD_CONFIDENCE"], Status::Output, "confidence"),
    c("wrong count", &["WRONG_COUNT"], Status::Output, "and the limb has"),
    c("wrong limb", &["WRONG_LIMB"], Status::Output, "limb 7"),
    c("missing frame", &["MISSING_FRAME"], Status::Output, "did not give limb `bar` on frame 3"),
    c("missing limb", &["MISSING_LIMB"], Status::Output, "did not give limb `bar` on frame 1"),
    c("fails", &["FAILS"], Status::Failed, "the model is not there"),
    c("no such status", &["WRONG_STATUS"], Status::Output, "returned 77"),
    c("cancels on its own", &["FALSE_CANCEL"], Status::Failed, "nobody asked"),
    c("no function", &["NO_TRACK"], Status::Failed, "no function `track`"),
    c("absurd frames", &["ABSURD_FRAME"], Status::Output, "struct_size is 3"),
    c("endless loop", &["ENDLESS"], Status::Timeout, "no sign of life for 0.4 s"),
    c("slow and silent", &["SLOW"], Status::Timeout, "no sign of life"),
];

fn make(made: &Made, folder: &Path) -> std::path::PathBuf {
    let file = folder.join("case.so");
    match made {
        Made::C(flags) => common::build_c("bad/bad.c", flags, &file),
        Made::Bytes(change) => {
            let good = folder.join("good.so");
            common::build_c("bad/bad.c", &[], &good);
            let changed = change(&std::fs::read(&good).expect("read"));
            std::fs::write(&file, changed).expect("written");
        }
    }
    file
}

fn find(argument: &str) -> &'static Case {
    LOADING.iter().chain(WORKING).find(|c| c.name == argument).expect("a case")
}

/// What a failure says, for the parent: the status and the line.
fn tell(status: i32, line: &str) {
    common::say("failed", &format!("{status} {line}"));
}

#[test]
#[ignore = "run by the others, in a process of its own"]
fn child() {
    let Ok(argument) = std::env::var("MAREY_CHILD") else { return };
    let case = find(&argument);
    let folder = tempfile::tempdir().expect("a folder");
    let file = make(&case.made, folder.path());
    let (mut options, _lines) = common::options(&folder.path().join("cache"));
    options.probe = case.probe.then(common::probe);
    let registry = Registry::new(options).expect("a registry");
    match registry.load(&file) {
        Err(refusal) => tell(refusal.status as i32, &refusal.to_string()),
        Ok(ids) => {
            let slot = registry.slot(&ids[0], PluginKind::Tracker, Policy::Keep).expect("a slot");
            let progress = Progress::new();
            match slot.track(&common::clip(6), &common::rig(), progress.whole()) {
                Err(Error::Helper { what, problem, remedy, code }) => {
                    tell(code, &format!("{what}: {problem}; {remedy}"));
                }
                Err(other) => tell(0, &other.to_string()),
                Ok(_) => tell(0, "worked"),
            }
        }
    }
    // The host works on, with a good plugin too.
    let good = folder.path().join("again.so");
    common::build_c("bad/bad.c", &["ID=\"org.marey.good\""], &good);
    registry.load(&good).expect("a good plugin");
    let slot = registry.slot("org.marey.good", PluginKind::Tracker, Policy::Keep).expect("a slot");
    let progress = Progress::new();
    let motion = slot.track(&common::clip(6), &common::rig(), progress.whole()).expect("tracked");
    common::say("alive", &motion.tracks.len().to_string());
    drop(folder);
    // A thread that hangs in a plugin must not keep the child.
    std::process::exit(0);
}

fn run(cases: &[Case]) {
    let failed: Vec<String> = cases
        .iter()
        .filter_map(|case| {
            let output = common::child("child", case.name);
            let said = common::answer(&output, "failed").unwrap_or_default();
            let (status, line) = said.split_once(' ').unwrap_or_default();
            let good = status.parse() == Ok(case.status as i32)
                && line.contains(case.says)
                && common::answer(&output, "alive").as_deref() == Some("2");
            let err = String::from_utf8_lossy(&output.stderr).into_owned();
            (!good).then(|| format!("{}: {:?} expected, got {said} ({}) {err}", case.name, case.status, output.status))
        })
        .collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn what_fails_while_it_is_loaded_is_refused_with_its_status() {
    run(LOADING);
}

#[test]
fn what_fails_at_work_fails_the_job_and_nothing_else() {
    run(WORKING);
}

#[test]
fn panics_in_rust_are_contained_and_told_through_either_door() {
    [DoorKind::C, DoorKind::Rust].into_iter().for_each(panics);
}

fn panics(door: DoorKind) {
    let folder = tempfile::tempdir().expect("a folder");
    let library = common::build_rust("marey-plugin-bad");
    let (mut options, lines) = common::options(folder.path());
    options.strikes = 100;
    options.door = Some(door);
    let registry = Registry::new(options).expect("a registry");
    registry.load(&library).expect("loaded");
    let (clip, rig, progress) = (common::clip(6), common::rig(), Progress::new());
    assert!(registry.plugins().iter().all(|p| p.door == door));
    let track = |id: &str| {
        let slot = registry.slot(id, PluginKind::Tracker, Policy::Keep).expect("a slot");
        match slot.track(&clip, &rig, progress.whole()) {
            Ok(motion) => Ok(motion),
            Err(Error::Helper { problem, code, .. }) => Err((code, problem)),
            Err(other) => panic!("{other}"),
        }
    };
    let (code, problem) = track("org.marey.bad.panics").expect_err("panics");
    assert_eq!(code, Status::Panicked as i32);
    assert!(problem.contains("2 limbs are too many") && problem.contains("lib.rs:"), "{problem}");
    assert!(common::logged(&lines, "2 limbs are too many"), "the host's log hears of it");
    assert_eq!(track("org.marey.bad.out-of-bounds").expect_err("panics").0, Status::Panicked as i32);
    assert_eq!(track("org.marey.bad.throws-a-bomb").expect_err("panics").0, Status::Panicked as i32);
    assert_eq!(track("org.marey.bad.not-a-number").expect_err("refused").0, Status::Output as i32);
    assert_eq!(track("org.marey.bad.too-few").expect_err("refused").0, Status::Failed as i32);
    track("org.marey.bad.panics-in-drop").expect("its work is good");
    let until = Instant::now() + Duration::from_secs(5);
    while !common::logged(&lines, "in drop") && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(common::logged(&lines, "in drop") && common::logged(&lines, "a thread of the plugin's own"));

    let segment = |slot: &marey_plugin_loader::Slot| {
        let still = marey::motion::TrackFrame::certain(vec![vec2(30.0, 32.0), vec2(40.0, 32.0)]);
        let tracks = rig.limbs.iter().map(|l| marey::motion::Track {
            name: l.label.clone(),
            kind: marey::motion::TrackKind::Stroke,
            frames: vec![still.clone(); 6],
        });
        let tracks = tracks.collect();
        let motion = marey::motion::Motion { size: (96, 64), fps: 24.0, frames: 6, tracks, bones: Vec::new() };
        slot.segment(&clip, &rig, &motion, progress.whole())
    };
    let slot = registry.slot("org.marey.bad.panics-in-create", PluginKind::Segmenter, Policy::Keep).expect("a slot");
    let masks = segment(&slot).expect("segmented");
    assert_eq!(masks.iter().map(marey::raster::Mask::count).collect::<Vec<_>>(), [2; 6]);
    registry.choose("org.marey.bad.panics-in-create", "panic", Value::Number(1.0)).expect("chosen");
    let error = segment(&slot).expect_err("panics");
    assert!(error.to_string().contains("in create"), "{error}");

    let deformer = registry.slot("org.marey.bad.shifts", PluginKind::Deformer, Policy::Keep).expect("a slot");
    let rest = [vec2(0.0, 0.0), vec2(10.0, 0.0), vec2(0.0, 10.0)];
    let mesh = RestMesh { points: &rest, triangles: &[[0, 1, 2]] };
    let at = |x: f32| [Handle::Point(vec2(x, 0.0))];
    let mut bound = deformer.bind(mesh, &at(0.0), progress.whole()).expect("bound");
    let mut points = rest;
    bound.solve(&at(5.0), &mut points, progress.whole()).expect("solved");
    assert_eq!(points, [vec2(5.0, 0.0), vec2(15.0, 0.0), vec2(5.0, 10.0)]);
    let before = points;
    assert!(
        bound.solve(&at(-2000.0), &mut points, progress.whole()).expect_err("infinite").to_string().contains("inf")
    );
    assert!(bound.solve(&at(f32::NAN), &mut points, progress.whole()).is_err(), "never reaches the plugin");
    assert!(bound.solve(&[], &mut points, progress.whole()).is_err(), "other handles");
    let mut other = deformer.bind(mesh, &at(0.0), progress.whole()).expect("bound");
    let error = bound.solve(&at(-500.0), &mut points, progress.whole()).expect_err("panics");
    assert!(error.to_string().contains("too far to the left"), "{error}");
    assert!(bound.solve(&at(1.0), &mut points, progress.whole()).is_err(), "poisoned");
    assert_eq!(points, before, "after an error the shape is as it was");
    other.solve(&at(1.0), &mut points, progress.whole()).expect("another one is as good as new");
    let bad = RestMesh { points: &rest, triangles: &[[0, 1, 3]] };
    assert!(deformer.bind(bad, &at(0.0), progress.whole()).is_err());
}

#[test]
fn three_strikes_put_a_file_into_quarantine_until_it_is_forgiven() {
    let folder = tempfile::tempdir().expect("a folder");
    let library = common::build_rust("marey-plugin-bad");
    let (options, _lines) = common::options(folder.path());
    let registry = Registry::new(options.clone()).expect("a registry");
    registry.load(&library).expect("loaded");
    let (clip, rig, progress) = (common::clip(2), common::rig(), Progress::new());
    let id = "org.marey.bad.panics";
    let slot = registry.slot(id, PluginKind::Tracker, Policy::Keep).expect("a slot");
    let code = || match slot.track(&clip, &rig, progress.whole()) {
        Err(Error::Helper { code, .. }) => code,
        _ => 0,
    };
    let panicked = Status::Panicked as i32;
    assert_eq!([code(), code(), code(), code()], [panicked, panicked, panicked, Status::Disabled as i32]);
    let another = Registry::new(options).expect("a registry");
    let refusal = another.load(&library).expect_err("in quarantine");
    assert_eq!(refusal.status, Status::Quarantined);
    assert!(refusal.to_string().contains("too many"), "{refusal}");
    another.retry(&library);
    another.load(&library).expect("forgiven");
}

#[test]
fn a_hung_plugin_is_switched_off_and_can_be_switched_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("slow.so");
    common::build_c("bad/bad.c", &["SLOW"], &file);
    let (options, lines) = common::options(&folder.path().join("cache"));
    let registry = Registry::new(options).expect("a registry");
    registry.load(&file).expect("loaded");
    let (clip, rig, progress) = (common::clip(3), common::rig(), Progress::new());
    let slot = registry.slot("org.marey.bad", PluginKind::Tracker, Policy::Keep).expect("a slot");
    assert!(slot.track(&clip, &rig, progress.whole()).is_err());
    let warned = |level| {
        let lines = lines.lock().expect("a lock");
        lines.iter().any(|(l, line)| *l == level && line.contains("no sign of life"))
    };
    assert!(warned(LogLevel::Warning), "slow, at first");
    assert!(warned(LogLevel::PluginMisbehaving), "then hung");
    drop(clip);
    assert_eq!(
        registry.slot("org.marey.bad", PluginKind::Tracker, Policy::Keep).expect_err("off").status,
        Status::Disabled
    );
    assert_eq!(registry.plugins()[0].instances, 1, "its thread is still there");
    registry.set_enabled("org.marey.bad", true).expect("on");
    registry.slot("org.marey.bad", PluginKind::Tracker, Policy::Keep).expect("a slot");
    // The plugin wakes up, asks for a frame of the clip that is gone, is told to stop, and ends.
    let until = Instant::now() + Duration::from_secs(10);
    while registry.plugins()[0].instances > 0 && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(registry.plugins()[0].instances, 0);
}

#[test]
fn a_cancel_takes_effect_within_a_tenth_of_a_second_even_if_the_plugin_is_deaf() {
    for (flags, left) in [(&["PATIENT"][..], 0), (&["DEAF"][..], 1)] {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("case.so");
        common::build_c("bad/bad.c", flags, &file);
        let (options, _lines) = common::options(&folder.path().join("cache"));
        let registry = Registry::new(options).expect("a registry");
        registry.load(&file).expect("loaded");
        let slot = registry.slot("org.marey.bad", PluginKind::Tracker, Policy::Keep).expect("a slot");
        let progress = Progress::new();
        let asked = std::sync::Mutex::new(None);
        let result = std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(80));
                *asked.lock().expect("a lock") = Some(Instant::now());
                progress.cancel();
            });
            slot.track(&common::clip(3), &common::rig(), progress.whole())
        });
        let took = asked.lock().expect("a lock").expect("asked").elapsed();
        assert!(matches!(result, Err(Error::Cancelled)), "{flags:?}: {result:?}");
        assert!(took < Duration::from_millis(100), "{flags:?}: {took:?}");
        std::thread::sleep(Duration::from_millis(20));
        // The slot keeps an instance that stopped; one that did not is left to itself.
        let there = if left == 1 { slot.generation().is_none() } else { slot.generation().is_some() };
        assert!(there, "{flags:?}");
    }
}

#[test]
fn frames_that_are_kept_or_given_back_twice_do_no_harm() {
    for (flag, told) in [("KEEPS_FRAMES", true), ("RELEASES_TWICE", false)] {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("case.so");
        common::build_c("bad/bad.c", &[flag], &file);
        let (options, lines) = common::options(&folder.path().join("cache"));
        let registry = Registry::new(options).expect("a registry");
        registry.load(&file).expect("loaded");
        let slot = registry.slot("org.marey.bad", PluginKind::Tracker, Policy::Keep).expect("a slot");
        let progress = Progress::new();
        slot.track(&common::clip(3), &common::rig(), progress.whole()).expect("tracked");
        assert_eq!(common::logged(&lines, "did not give 6 frames back"), told, "{flag}");
    }
}

#[test]
fn a_file_that_does_not_match_its_manifest_is_not_mapped() {
    let folder = tempfile::tempdir().expect("a folder");
    let bundle = folder.path().join("plugins/good.marey");
    std::fs::create_dir_all(&bundle).expect("a folder");
    common::build_c("bad/bad.c", &[], &bundle.join("good.so"));
    let manifest = |sha: &str, id: &str| {
        let platform = format!("{}-{}", std::env::consts::OS, std::env::consts::ARCH);
        let text = format!(
            r#"{{"format":"marey-plugin","version":1,"id":"{id}","files":{{"{platform}":{{"path":"good.so"{sha}}}}}}}"#
        );
        std::fs::write(bundle.join("plugin.json"), text).expect("written");
    };
    let load = |cache: &str| {
        let (mut options, _) = common::options(&folder.path().join(cache));
        options.folders = vec![folder.path().join("plugins")];
        let registry = Registry::new(options).expect("a registry");
        let changes = registry.rescan();
        let failed = registry.failures().pop().map(|(_, refusal)| refusal.status);
        (changes.len(), registry.plugins().len(), failed)
    };
    manifest(&format!(r#","sha256":"{}""#, "0".repeat(64)), "org.marey.bad");
    assert_eq!(load("a"), (1, 0, Some(Status::Hash)));
    manifest("", "org.marey.other");
    assert_eq!(load("b"), (1, 0, Some(Status::Descriptor)));
    manifest("", "org.marey.bad");
    assert_eq!(load("c"), (1, 1, None));
}

#[test]
fn the_rust_door_is_checked_before_it_is_opened() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut options, lines) = common::options(&folder.path().join("cache"));
    options.door = Some(DoorKind::Rust);
    let registry = Registry::new(options).expect("a registry");
    let refusal = registry.load(&common::build_rust("marey-plugin-bad-layout")).expect_err("another layout");
    assert_eq!(refusal.status, Status::Layout);
    assert!(refusal.to_string().len() < 300, "one line for a person: {refusal}");
    assert!(common::logged(&lines, "Layout"), "the whole of it for the log");

    // The header of another abi_stable: its first bytes say which it is.
    let good = common::build_rust("marey-plugin-bad");
    let mut bytes = std::fs::read(&good).expect("read");
    let magic = b"abi stable library for Rust";
    let at: Vec<usize> = (0..bytes.len() - magic.len()).filter(|i| bytes[*i..].starts_with(magic)).collect();
    assert!(!at.is_empty());
    at.into_iter().for_each(|i| bytes[i] ^= 1);
    let other = folder.path().join("other.so");
    std::fs::write(&other, bytes).expect("written");
    assert_eq!(registry.load(&other).expect_err("another abi_stable").status, Status::AbiVersion);

    let c = folder.path().join("c.so");
    common::build_c("bad/bad.c", &[], &c);
    assert_eq!(registry.load(&c).expect_err("has only the other door").status, Status::NoEntry);
    // After all of these a good one comes in, as it would not through abi_stable's own loading.
    registry.load(&good).expect("a good one");
}
