//! A folder of a thousand damaged copies of a good plugin, looked through by hosts of their own: none of them goes down.

mod common;

use std::path::Path;

use marey::job::Progress;
use marey::track::Tracker as _;
use marey_plugin_loader::{PluginKind, Policy, Registry};

/// Files for each child: a host that looks through all of them.
const BATCH: u64 = 125;

/// A small generator of numbers, the same on every machine (xorshift64*).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// Damage of the kinds that files meet: bytes changed, cut off, zeroed, moved, doubled; half of it in the tables that
/// the system's loader reads, where it hurts most.
fn damage(good: &[u8], seed: u64) -> Vec<u8> {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut bytes = good.to_vec();
    let reach = if random.below(2) == 0 { good.len().min(0x800) } else { good.len() };
    match random.below(6) {
        0 => bytes.truncate(random.below(good.len())),
        1 => {
            let (at, len) = (random.below(reach), 1 + random.below(256));
            bytes.iter_mut().skip(at).take(len).for_each(|b| *b = 0);
        }
        2 => {
            let (from, to, len) = (random.below(good.len()), random.below(reach), 1 + random.below(64));
            for i in 0..len {
                if let (Some(&b), true) = (good.get(from + i), to + i < bytes.len()) {
                    bytes[to + i] = b;
                }
            }
        }
        3 => {
            let at = random.below(reach) & !7;
            let value = [0, 1, u64::MAX, 1 << 63, 0x7fff_ffff][random.below(5)];
            bytes.splice(at..(at + 8).min(good.len()), value.to_le_bytes());
        }
        _ => {
            for _ in 0..1 + random.below(8) {
                let at = random.below(reach);
                bytes[at] ^= 1 << random.below(8);
            }
        }
    }
    bytes
}

#[test]
#[ignore = "run by the others, in a process of its own"]
fn child() {
    let Ok(argument) = std::env::var("MAREY_CHILD") else { return };
    let mut words = argument.split(' ');
    let (first, probe) = (words.next().and_then(|w| w.parse::<u64>().ok()).expect("a number"), words.next());
    let folder = tempfile::tempdir().expect("a folder");
    let plugins = folder.path().join("plugins");
    std::fs::create_dir(&plugins).expect("a folder");
    let good_file = folder.path().join("good.so");
    common::build_c("bad/bad.c", &[], &good_file);
    let good = std::fs::read(&good_file).expect("read");
    for seed in first..first + BATCH {
        std::fs::write(plugins.join(format!("{seed}.so")), damage(&good, seed)).expect("written");
    }
    let (mut options, _lines) = common::options(&folder.path().join("cache"));
    options.folders = vec![plugins];
    options.max_generations = 1000;
    options.load_deadline = std::time::Duration::from_secs(2);
    options.probe = probe.map(|_| common::probe());
    let registry = Registry::new(options).expect("a registry");
    registry.rescan();
    let failures = registry.failures();
    let crashed = failures.iter().filter(|(_, r)| r.status == marey_plugin_loader::Status::Crashed).count();
    let before = [marey_plugin_loader::Status::Truncated, marey_plugin_loader::Status::Format];
    let seen = failures.iter().filter(|(_, r)| before.contains(&r.status)).count();
    // A good plugin under another name works on.
    let again = folder.path().join("again.so");
    common::build_c("bad/bad.c", &["ID=\"org.marey.good\""], &again);
    registry.load(Path::new(&again)).expect("a good plugin");
    let slot = registry.slot("org.marey.good", PluginKind::Tracker, Policy::Keep).expect("a slot");
    let progress = Progress::new();
    slot.track(&common::clip(3), &common::rig(), progress.whole()).expect("tracked");
    common::say("alive", &format!("{} refused {seen} seen {crashed} crashed", failures.len()));
    drop(folder);
    std::process::exit(0);
}

#[test]
fn a_thousand_damaged_files_take_no_host_down() {
    let mut sums = [0usize; 3];
    for batch in 0..8 {
        let output = common::child("child", &format!("{} probe", batch * BATCH + 1));
        let said = common::answer(&output, "alive");
        let said = said.unwrap_or_else(|| panic!("{}: {}", output.status, String::from_utf8_lossy(&output.stderr)));
        let numbers = said.split(' ').filter_map(|w| w.parse::<usize>().ok());
        sums.iter_mut().zip(numbers).for_each(|(sum, n)| *sum += n);
    }
    let [refused, seen, crashed] = sums;
    let line = format!("of 1000: {refused} refused, {seen} by the look at the file, {crashed} ended the probe");
    common::say("measured", &line);
    assert!(seen > 300, "{line}");
}
