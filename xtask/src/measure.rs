//! `cargo xtask measure DATA`, `retrack DATA` and `alternatives DATA`: build the release programs and print their tables.

use anyhow::Result;

use crate::shell::{self, cargo, program, target};

/// Runs the program `name` of the tests, which measures.
pub(crate) fn run(name: &str, args: &[String]) -> Result<()> {
    let packages = ["--package", "marey-cli", "--package", "marey-tests"];
    shell::run(cargo().args(["build", "--release", "--locked", "--bins"]).args(packages))?;
    let measure = target().join("release").join(name);
    shell::run(program(&measure.to_string_lossy()).current_dir(std::env::current_dir()?).args(args))
}

/// The built-in trackers and segmenters beside the plugins that ship.
pub(crate) fn alternatives(args: &[String]) -> Result<()> {
    let plugins = ["flow-tracker", "grab-cut", "moving-least-squares"];
    let packages = plugins.iter().flat_map(|p| ["--package".to_owned(), format!("marey-{p}")]);
    shell::run(cargo().args(["build", "--release", "--locked", "--lib"]).args(packages))?;
    run("alternatives", args)
}
