//! `cargo xtask check`: format, lints, documentation, dependency licences and sources.

use anyhow::Result;

use crate::shell::{self, cargo, has, program, say, target};

const DENY: &str = "0.20.2";

pub(crate) fn run() -> Result<()> {
    shell::run(cargo().args(["fmt", "--all", "--check"]))?;
    shell::run(cargo().args(["clippy", "--workspace", "--all-targets", "--locked", "--", "-D", "warnings"]))?;
    let mut doc = cargo();
    doc.env("RUSTDOCFLAGS", "-D warnings");
    shell::run(doc.args(["doc", "--workspace", "--no-deps", "--document-private-items", "--locked"]))?;
    deny()
}

/// Licences, sources and duplicate versions by deny.toml; advisories too, where their database can be fetched.
fn deny() -> Result<()> {
    let own = target().join("tools/bin/cargo-deny");
    let deny = if has("cargo-deny") {
        "cargo-deny".into()
    } else {
        if !own.exists() {
            let root = target().join("tools");
            let install = ["install", "cargo-deny", "--locked", "--debug", "--version", DENY, "--root"];
            shell::run(cargo().args(install).arg(root))?;
        }
        own.to_string_lossy().into_owned()
    };
    shell::run(program(&deny).args(["--locked", "check", "bans", "licenses", "sources"]))?;
    let advisories = program(&deny).args(["--locked", "check", "advisories"]).output()?;
    let said = String::from_utf8_lossy(&advisories.stderr);
    if advisories.status.success() {
        say("advisories: none that deny.toml does not explain");
        return Ok(());
    }
    // Only a database that could not be fetched is forgiven; a finding is not.
    anyhow::ensure!(said.contains("failed to fetch advisory database"), "advisories:\n{said}");
    say("advisories: not checked, their database cannot be fetched from here");
    Ok(())
}
