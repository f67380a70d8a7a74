//! `cargo xtask blender GLB ...`: creatures taken through Blender. It imports, plays and exports each file again, and every
//! vertex must be where it was in every frame. The first run fetches Blender as a Python module at a pinned version.

use anyhow::{Context as _, Result, ensure};

use crate::shell::{self, program, target};

/// Blender 5.0 as a module needs Python 3.11.
const PACKAGES: [&str; 3] = ["bpy==5.0.1", "numpy<3", "scipy<2"];
const SCRIPT: &str = include_str!("blender/round_trip.py");

pub(crate) fn run(files: &[String]) -> Result<()> {
    ensure!(!files.is_empty(), "usage: cargo xtask blender GLB ...");
    let tools = target().join("tools/blender");
    let python = tools.join("bin/python");
    let stamp = tools.join("installed.txt");
    let wanted = PACKAGES.join("\n");
    if std::fs::read_to_string(&stamp).ok().as_ref() != Some(&wanted) {
        shell::run(program("python3").args(["-m", "venv"]).arg(&tools)).context("Python 3.11 with venv is needed")?;
        let mut pip = program(&python.to_string_lossy());
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(PACKAGES);
        shell::run(&mut pip).context("Blender is a Python package: is there a network?")?;
        std::fs::write(&stamp, wanted)?;
    }
    let script = tools.join("round_trip.py");
    std::fs::write(&script, SCRIPT)?;
    let out = target().join("marey/blender");
    std::fs::create_dir_all(&out)?;
    shell::run(program(&python.to_string_lossy()).arg(&script).arg(&out).args(files))
}
