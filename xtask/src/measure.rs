//! `cargo xtask measure DATA`: builds the release command line and the scorer, and prints the table.

use anyhow::Result;

use crate::shell::{self, cargo, program, target};

pub(crate) fn run(args: &[String]) -> Result<()> {
    let packages = ["--package", "marey-cli", "--package", "marey-tests"];
    shell::run(cargo().args(["build", "--release", "--locked", "--bins"]).args(packages))?;
    let measure = target().join("release/measure");
    shell::run(program(&measure.to_string_lossy()).current_dir(std::env::current_dir()?).args(args))
}
