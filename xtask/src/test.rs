//! `cargo xtask test`: everything that must pass before a change lands, cheap checks first.

use anyhow::Result;

use crate::{shell, system, validator};

pub(crate) fn run() -> Result<()> {
    system::ensure()?;
    shell::run(shell::cargo().args(["test", "--workspace", "--locked"]))?;
    validator::demo()
}
