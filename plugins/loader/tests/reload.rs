//! New builds of a plugin while it is at work: every result from the right build, state carried over, nothing lost.

mod common;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use marey::job::Progress;
use marey::motion::Motion;
use marey::track::Tracker as _;
use marey_plugin_loader::{Carried, DoorKind, PluginKind, Policy, Registry, Rescan, Slot, Status, Value};

const ID: &str = "org.marey.bad";

/// Builds of one plugin that differ in a number, which shows in every result.
struct Builds {
    bytes: Vec<u8>,
    at: usize,
}

impl Builds {
    fn new(folder: &Path, flags: &[&str]) -> Self {
        let file = folder.join("build.so.tmp");
        common::build_c("bad/bad.c", flags, &file);
        let bytes = std::fs::read(&file).expect("read");
        std::fs::remove_file(&file).expect("removed");
        let mark = 0x5952_4d56_u32.to_le_bytes();
        let at = bytes.windows(4).position(|w| w == mark).expect("a mark") + 4;
        Self { bytes, at }
    }

    /// Puts build `version` at `file` as an installer does: written aside and renamed.
    fn install(&self, version: u32, file: &Path) {
        let mut bytes = self.bytes.clone();
        bytes[self.at..self.at + 4].copy_from_slice(&version.to_le_bytes());
        let aside = file.with_extension("tmp");
        std::fs::write(&aside, bytes).expect("written");
        std::fs::rename(&aside, file).expect("renamed");
    }
}

fn registry(folder: &Path) -> (Registry, common::Lines, PathBuf) {
    let plugins = folder.join("plugins");
    std::fs::create_dir_all(&plugins).expect("a folder");
    let (mut options, lines) = common::options(&folder.join("cache"));
    options.folders = vec![plugins.clone()];
    options.max_generations = 1000;
    (Registry::new(options).expect("a registry"), lines, plugins.join("bad.so"))
}

fn track(slot: &Slot) -> marey::Result<Motion> {
    let progress = Progress::new();
    slot.track(&common::clip(3), &common::rig(), progress.whole())
}

/// The build that a result came from, by how far it shifted the limb; and the call, from how far it lifted it.
fn seen(motion: &Motion) -> (u32, u32) {
    let (first, later) = (motion.tracks[0].frames[0].points[0], motion.tracks[0].frames[1].points[0]);
    ((later.x - first.x).round() as u32, ((later.y - first.y) / 1000.0).round() as u32)
}

/// Runs a test of this file in a process of its own, where nobody else's memory is counted.
fn alone(name: &str, argument: &str) {
    let output = common::child(name, argument);
    let all = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && all.contains("1 passed"), "{all}");
    all.lines().filter_map(|l| l.strip_prefix("measured: ")).for_each(|line| common::say("measured", line));
}

#[test]
fn two_hundred_reloads_while_a_slot_keeps_tracking() {
    alone("reloads", "");
}

#[test]
fn builds_of_a_rust_library_cost_less_than_a_megabyte_each() {
    alone("rust_builds", "C");
    alone("rust_builds", "Rust");
}

#[test]
#[ignore = "run by another, in a process of its own"]
fn reloads() {
    let folder = tempfile::tempdir().expect("a folder");
    let builds = Builds::new(folder.path(), &[]);
    let (registry, _lines, file) = registry(folder.path());
    builds.install(1, &file);
    assert_eq!(registry.rescan().len(), 1);
    let slot = registry.slot(ID, PluginKind::Tracker, Policy::Migrate).expect("a slot");
    let ended = AtomicBool::new(false);
    let (reloads, memory) = (200u32, resident());
    let tracked = std::thread::scope(|scope| {
        let work = scope.spawn(|| {
            let (mut calls, mut newest) = (0u32, 0);
            while !ended.load(Ordering::Acquire) {
                let motion = track(&slot).expect("tracked");
                let (version, call) = seen(&motion);
                assert!(version >= newest, "build {version} came after build {newest}");
                // Calls are counted in the state, which goes from build to build. The lift shows up to call 9.
                assert_eq!(call, calls, "the state is carried over");
                (calls, newest) = (calls + 1, version);
                if calls >= 9 {
                    // Places farther out are refused: start a count anew.
                    slot.load(1, &0u32.to_le_bytes()).expect("loaded");
                    calls = 0;
                }
            }
            newest
        });
        for version in 2..=reloads + 1 {
            builds.install(version, &file);
            match registry.rescan().as_slice() {
                [Rescan::Loaded { generation, .. }] => assert_eq!(*generation, u64::from(version)),
                other => panic!("{other:?}"),
            }
        }
        let fresh = registry.slot(ID, PluginKind::Tracker, Policy::Keep).expect("a slot");
        assert_eq!(seen(&track(&fresh).expect("tracked")), (reloads + 1, 0));
        ended.store(true, Ordering::Release);
        work.join().expect("tracked")
    });
    assert!(tracked >= 1);
    assert_eq!(seen(&track(&slot).expect("tracked")).0, reloads + 1, "the slot came along");
    assert_eq!(slot.carried(), Some(Carried::State));
    let grown = resident().saturating_sub(memory) as f64 / f64::from(reloads);
    common::say("measured", &format!("{grown:.0} bytes for each build that is kept"));
    assert!(grown < 1e6, "{grown} bytes for each build");
    let (retired, bytes) = registry.retired();
    assert!(retired >= 190 && bytes > 0, "{retired} builds of {bytes} bytes are retired");
}

#[test]
#[ignore = "run by another, in a process of its own"]
fn rust_builds() {
    let folder = tempfile::tempdir().expect("a folder");
    let bytes = std::fs::read(common::build_rust("marey-plugin-bad")).expect("read");
    let asked = std::env::var("MAREY_CHILD").unwrap_or_default();
    let wanted = |door: &DoorKind| format!("{door:?}") == asked;
    for door in [DoorKind::C, DoorKind::Rust].into_iter().filter(wanted) {
        let (mut options, _lines) = common::options(&folder.path().join("cache"));
        options.max_generations = 1000;
        options.door = Some(door);
        let registry = Registry::new(options).expect("a registry");
        let file = folder.path().join("rust.so");
        let load = |build: u32| {
            // Bytes behind the last table make it another build, and change nothing else.
            let build = [&bytes[..], &build.to_le_bytes()].concat();
            std::fs::write(file.with_extension("tmp"), build).expect("written");
            std::fs::rename(file.with_extension("tmp"), &file).expect("renamed");
            registry.load(&file).expect("loaded");
        };
        // The first few find the size that buffers grow to.
        (0..10).for_each(load);
        let (memory, began) = (resident(), std::time::Instant::now());
        (10..50).for_each(load);
        let (each, took) = ((resident().saturating_sub(memory)) as f64 / 40.0, began.elapsed().as_secs_f64() / 40.0);
        let (kilobytes, ms) = (each / 1e3, took * 1e3);
        let line = format!("{door:?} door: {kilobytes:.0} KB and {ms:.1} ms for each build of a Rust library");
        common::say("measured", &line);
        assert!(each < 1e6, "{line}");
    }
}

/// Bytes of memory that this process has.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    text.split(' ').nth(1).and_then(|p| p.parse::<u64>().ok()).unwrap_or(0) * 4096
}

#[test]
fn two_builds_live_at_once_and_policies_decide() {
    let folder = tempfile::tempdir().expect("a folder");
    let builds = Builds::new(folder.path(), &[]);
    let (registry, _lines, file) = registry(folder.path());
    builds.install(1, &file);
    registry.rescan();
    let slot = |policy| registry.slot(ID, PluginKind::Tracker, policy).expect("a slot");
    let [keep, migrate, dropped] = [Policy::Keep, Policy::Migrate, Policy::Drop].map(slot);
    for each in [&keep, &migrate, &dropped] {
        assert_eq!(seen(&track(each).expect("tracked")), (1, 0));
    }
    builds.install(5, &file);
    assert!(matches!(registry.rescan().as_slice(), [Rescan::Loaded { .. }]));
    assert!(registry.rescan().is_empty(), "nothing is new");
    assert_eq!(seen(&track(&keep).expect("tracked")), (1, 1), "the old build goes on, with its state");
    assert_eq!(seen(&track(&migrate).expect("tracked")), (5, 1), "the new one has the old one's state");
    assert_eq!(seen(&track(&dropped).expect("tracked")), (5, 0), "the new one starts afresh");
    // The one that was exchanged and the one that was dropped end on threads of their own.
    let until = std::time::Instant::now() + std::time::Duration::from_secs(5);
    while registry.plugins()[0].instances > 3 && std::time::Instant::now() < until {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    assert_eq!(registry.plugins()[0].instances, 3);
    registry.choose(ID, "lift", Value::Number(7.0)).expect("chosen");
    assert!(registry.choose(ID, "lift", Value::Number(51.0)).is_err());
    assert!(registry.choose(ID, "lift", Value::Text("high".into())).is_err());
    assert!(registry.choose(ID, "other", Value::Number(1.0)).is_err());
    let lifted = track(&migrate).expect("tracked");
    assert_eq!(lifted.tracks[0].frames[1].points[0].y - lifted.tracks[0].frames[0].points[0].y, 7.0);
    std::fs::remove_file(&file).expect("removed");
    assert!(matches!(registry.rescan().as_slice(), [Rescan::Gone { .. }]));
    assert_eq!(registry.slot(ID, PluginKind::Tracker, Policy::Keep).expect_err("gone").status, Status::NotFound);
}

#[test]
fn a_failed_migration_keeps_the_old_build_and_a_refused_state_keeps_the_values() {
    let folder = tempfile::tempdir().expect("a folder");
    let (registry, lines, file) = registry(folder.path());
    Builds::new(folder.path(), &[]).install(1, &file);
    registry.rescan();
    registry.choose(ID, "lift", Value::Number(30.0)).expect("chosen");
    let slot = registry.slot(ID, PluginKind::Tracker, Policy::Migrate).expect("a slot");
    track(&slot).expect("tracked");
    // A build that does not even load leaves everything as it is.
    std::fs::write(file.with_extension("tmp"), "no library").expect("written");
    std::fs::rename(file.with_extension("tmp"), &file).expect("renamed");
    assert!(
        matches!(registry.rescan().as_slice(), [Rescan::Refused { refusal, .. }] if refusal.status == Status::Format)
    );
    assert!(registry.rescan().is_empty(), "said once");
    assert_eq!(seen(&track(&slot).expect("tracked")), (1, 1));
    // A build that cannot read the state takes over with the values.
    Builds::new(folder.path(), &["REFUSES_STATE"]).install(2, &file);
    registry.rescan();
    let motion = track(&slot).expect("tracked");
    assert_eq!((seen(&motion), slot.carried()), ((2, 0), Some(Carried::Parameters)));
    let frames = &motion.tracks[0].frames;
    assert_eq!(frames[1].points[0].y - frames[0].points[0].y, 30.0);
    assert!(common::logged(&lines, "of another age"));
    // One whose range became narrower falls back to the default where the chosen value does not fit.
    Builds::new(folder.path(), &["NARROW_RANGE"]).install(3, &file);
    registry.rescan();
    let frames = track(&slot).expect("tracked").tracks.remove(0).frames;
    assert_eq!(frames[1].points[0].y - frames[0].points[0].y, 1000.0, "the second call, and no lift");
    // State of a newer kind is not read by an older build.
    Builds::new(folder.path(), &["STATE_VERSION=9u"]).install(4, &file);
    registry.rescan();
    track(&slot).expect("tracked");
    Builds::new(folder.path(), &[]).install(6, &file);
    registry.rescan();
    assert_eq!((seen(&track(&slot).expect("tracked")), slot.carried()), ((6, 0), Some(Carried::Parameters)));
}

#[test]
fn state_is_a_fixpoint_of_saving_and_loading() {
    let folder = tempfile::tempdir().expect("a folder");
    let (registry, _lines, file) = registry(folder.path());
    Builds::new(folder.path(), &[]).install(1, &file);
    registry.rescan();
    let [one, other] = [(); 2].map(|()| registry.slot(ID, PluginKind::Tracker, Policy::Keep).expect("a slot"));
    for _ in 0..3 {
        let (version, bytes) = one.save().expect("saved").expect("a state");
        other.load(version, &bytes).expect("loaded");
        assert_eq!(other.save().expect("saved"), Some((version, bytes)));
        track(&one).expect("tracked");
    }
    assert!(one.load(1, b"no state").is_err());
}

#[test]
fn writers_that_write_in_place_never_end_the_host() {
    let folder = tempfile::tempdir().expect("a folder");
    let (registry, _lines, file) = registry(folder.path());
    let builds = Builds::new(folder.path(), &[]);
    builds.install(1, &file);
    registry.rescan();
    let slot = registry.slot(ID, PluginKind::Tracker, Policy::Migrate).expect("a slot");
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for round in 0..60u32 {
                use std::io::Write as _;
                let mut bytes = builds.bytes.clone();
                bytes[builds.at..builds.at + 4].copy_from_slice(&(round + 2).to_le_bytes());
                let mut out = std::fs::File::create(&file).expect("created");
                for part in bytes.chunks(1 << 12) {
                    out.write_all(part).expect("written");
                    std::thread::sleep(std::time::Duration::from_micros(300));
                }
                drop(out);
                std::thread::sleep(std::time::Duration::from_millis(3));
            }
            ended.store(true, Ordering::Release);
        });
        while !ended.load(Ordering::Acquire) {
            for change in registry.rescan() {
                if let Rescan::Refused { refusal, .. } = change {
                    let torn = [Status::UnstableFile, Status::Truncated, Status::Format, Status::NotFound];
                    assert!(torn.contains(&refusal.status), "{refusal}");
                }
            }
            track(&slot).ok();
            slot.load(1, &0u32.to_le_bytes()).ok();
        }
    });
    std::thread::sleep(std::time::Duration::from_millis(20));
    registry.rescan();
    assert_eq!(seen(&track(&slot).expect("tracked")).0, 61, "the last build is whole");
}
