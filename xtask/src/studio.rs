//! `cargo xtask studio [GESTURES [SEED]]`: what takes long about the studio, in the release build: killed at fifty random
//! moments, used by random gestures, and what a person's clip and a sample take.

use anyhow::{Result, ensure};

use crate::shell::{self, cargo};

pub(crate) fn run(args: &[String]) -> Result<()> {
    let number = |i: usize, otherwise: &str| args.get(i).cloned().unwrap_or_else(|| otherwise.into());
    let (gestures, seed) = (number(0, "100000"), number(1, "1"));
    let numbers = [&gestures, &seed].iter().all(|n| n.parse::<u64>().is_ok());
    ensure!(args.len() < 3 && numbers, "usage: cargo xtask studio [GESTURES [SEED]]");
    let mut tests = cargo();
    tests.env("GESTURES", gestures).env("SEED", seed);
    tests.args(["test", "--release", "--locked", "--package", "marey-studio"]);
    for name in ["kills", "person", "window", "chance"] {
        tests.args(["--test", name]);
    }
    shell::run(tests.args(["--", "--include-ignored", "--nocapture", "--test-threads", "1"]))
}
