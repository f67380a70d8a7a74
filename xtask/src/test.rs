//! `cargo xtask test`: everything that must pass before a change lands, cheap checks first.

use anyhow::Result;

use crate::{c_host, header, shell, system, validator};

pub(crate) fn run() -> Result<()> {
    system::ensure()?;
    header::run(&["--check".into()])?;
    shell::run(shell::cargo().args(["test", "--workspace", "--locked"]))?;
    c_host::run(&["--dev".into()])?;
    validator::demo()
}
