//! `cargo xtask cancels`: cancels jobs of every kind at a hundred random moments, in the release build.

use anyhow::Result;

use crate::shell::{self, cargo};

pub(crate) fn run() -> Result<()> {
    let what = ["test", "--release", "--locked", "--package", "marey-ffi", "--test", "cancel"];
    shell::run(cargo().args(what).args(["--", "--ignored", "--nocapture"]))
}
