//! `cargo xtask measure DATA`: builds the release command line and the scorer, and prints the table. `cargo xtask
//! alternatives DATA` does so for the plugins that ship.

use anyhow::Result;

use crate::shell::{self, cargo, program, target};

pub(crate) fn run(args: &[String]) -> Result<()> {
    let packages = ["--package", "marey-cli", "--package", "marey-tests"];
    shell::run(cargo().args(["build", "--release", "--locked", "--bins"]).args(packages))?;
    let measure = target().join("release/measure");
    shell::run(program(&measure.to_string_lossy()).current_dir(std::env::current_dir()?).args(args))
}

pub(crate) fn alternatives(args: &[String]) -> Result<()> {
    let plugins = ["flow-tracker", "grab-cut", "moving-least-squares"];
    let packages = plugins.iter().flat_map(|p| ["--package".to_owned(), format!("marey-{p}")]);
    shell::run(cargo().args(["build", "--release", "--locked", "--lib"]).args(packages))?;
    shell::run(cargo().args(["build", "--release", "--locked", "--package", "marey-tests", "--bin", "alternatives"]))?;
    let alternatives = target().join("release/alternatives");
    shell::run(program(&alternatives.to_string_lossy()).current_dir(std::env::current_dir()?).args(args))
}
