//! `cargo xtask test`: everything that must pass before a change lands, cheap checks first.

use anyhow::Result;

use crate::{c_host, header, shell, validator};

pub(crate) fn run() -> Result<()> {
    header::run(&["--check".into()])?;
    shell::run(shell::cargo().args(["test", "--workspace", "--locked"]))?;
    c_host::run(&["--dev".into()])?;
    validator::demo()
}
