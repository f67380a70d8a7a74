//! `cargo xtask cancels`: cancels jobs of every kind at a hundred random moments, and measures what a call costs, in the
//! release build.

use anyhow::Result;

use crate::shell::{self, cargo};

pub(crate) fn run() -> Result<()> {
    let what = ["test", "--release", "--locked", "--package", "marey-ffi", "--test", "cancel", "--test", "overhead"];
    shell::run(cargo().args(what).args(["--", "--include-ignored", "--nocapture"]))
}
