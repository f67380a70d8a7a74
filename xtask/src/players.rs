//! `cargo xtask players [DATA]`: takes of characters and sketches played by programs that are not ours, and compared.
//!
//! Three.js and lottie-web in a headless Chromium, the DragonBones runtime in node, and a reader of Spine's JSON of our own,
//! as Spine's runtimes need a licence of their editor. The first run fetches them as npm packages at pinned versions, and
//! Chromium from the system's packages.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};

use crate::shell::{self, cargo, program, say, target};
use crate::{system, validator};

const PACKAGES: [&str; 5] =
    ["pixi5-dragonbones@5.7.0-2b", "lottie-web@5.13.0", "three@0.187.0", "puppeteer-core@24.43.1", "pngjs@7.0.0"];

const SCRIPTS: [(&str, &str); 5] = [
    ("common.js", include_str!("players/common.js")),
    ("dragonbones.js", include_str!("players/dragonbones.js")),
    ("spine.js", include_str!("players/spine.js")),
    ("browser.js", include_str!("players/browser.js")),
    ("sketches.js", include_str!("players/sketches.js")),
];

/// Runs everything; fails when a player shows something else than we do.
pub(crate) fn run(args: &[String]) -> Result<()> {
    ensure!(args.len() <= 1, "usage: cargo xtask players [DATA]");
    system::ensure_browser()?;
    let tools = target().join("tools/players");
    std::fs::create_dir_all(&tools)?;
    for (name, text) in SCRIPTS {
        std::fs::write(tools.join(name), text)?;
    }
    let wanted = PACKAGES.join("\n");
    let stamp = tools.join("installed.txt");
    if std::fs::read_to_string(&stamp).ok().as_ref() != Some(&wanted) {
        let mut npm = program("npm");
        npm.args([
            "install",
            "--silent",
            "--no-audit",
            "--no-fund",
            "--ignore-scripts",
            "--legacy-peer-deps",
            "--prefix",
        ]);
        shell::run(npm.arg(&tools).args(PACKAGES)).context("the players are npm packages: is there a network?")?;
        std::fs::write(&stamp, wanted)?;
    }
    shell::run(cargo().args(["build", "--locked", "--package", "marey-tests", "--bin", "players"]))?;
    let out = target().join("marey/players");
    if out.exists() {
        std::fs::remove_dir_all(&out)?;
    }
    let own = target().join("debug/players");
    shell::run(program(&own.to_string_lossy()).current_dir(std::env::current_dir()?).arg(&out).args(args))?;
    for entry in std::fs::read_dir(&out)? {
        let file = entry?.path().join("take.glb");
        if file.exists() {
            validator::validate(&file)?;
        }
    }
    let scripts: [(&str, &[&str]); 3] =
        [("dragonbones.js", &[]), ("spine.js", &[]), ("browser.js", &[system::BROWSER])];
    let mut all_well = true;
    for (script, args) in scripts {
        all_well &= play(&tools.join(script), &out, args)?;
    }
    ensure!(all_well, "a player shows something else; the lines that begin with FAIL say which");
    Ok(())
}

fn play(script: &Path, out: &Path, args: &[&str]) -> Result<bool> {
    let mut node = program("node");
    node.arg(script).arg(out).args(args);
    let status = node.status().with_context(|| format!("node {}", script.display()))?;
    if !status.success() {
        say(&format!("{}: {status}", script.display()));
    }
    Ok(status.success())
}
