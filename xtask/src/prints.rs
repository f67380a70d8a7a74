//! Prints of every frame of creatures, looked at by programs of others: trimesh and manifold3d (Python), admesh, and
//! PrusaSlicer, which slices every eighth. None may find anything to repair.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};

use crate::shell::{self, cargo, has, program, read, say, target};

const CHECK: &str = include_str!("prints.py");
/// Of so many frames one is sliced: a slice takes longer than a print.
const SLICED: usize = 8;
/// What admesh counts that must be nought.
const REPAIRS: [&str; 7] = [
    "Total disconnected facets",
    "Degenerate facets",
    "Edges fixed",
    "Facets removed",
    "Facets added",
    "Facets reversed",
    "Backwards edges",
];

/// `cargo xtask prints CREATURE ... [-- OPTION ...]`: creature.glb files or creatures' folders, and options of `marey print`.
pub(crate) fn run(args: &[String]) -> Result<()> {
    let (creatures, options) = match args.iter().position(|a| a == "--") {
        Some(at) => (&args[..at], &args[at + 1..]),
        None => (args, &[][..]),
    };
    ensure!(!creatures.is_empty(), "usage: cargo xtask prints CREATURE ... [-- OPTION ...]");
    for name in ["admesh", "prusa-slicer"] {
        ensure!(has(name) || name == "prusa-slicer", "install {name} first");
    }
    shell::run(cargo().args(["build", "--quiet", "--release", "--bin", "marey"]))?;
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    for creature in creatures {
        let creature = Path::new(creature);
        let name = creature.file_stem().filter(|n| *n != "creature").or(creature.parent().and_then(|p| p.file_name()));
        let folder = target().join("marey/prints").join(name.unwrap_or_default());
        let files = print(creature, &folder, options).with_context(|| creature.display().to_string())?;
        let script = folder.join("check.py");
        std::fs::write(&script, CHECK)?;
        say(read(program(&python).arg(&script).args(&files))?.trim());
        for file in &files {
            repairs(file)?;
        }
        for file in files.iter().step_by(SLICED) {
            slice(file)?;
        }
        say(&format!(
            "{}: {} frames are closed, {} sliced",
            creature.display(),
            files.len(),
            files.len().div_ceil(SLICED)
        ));
    }
    Ok(())
}

/// Every frame as an STL file.
fn print(creature: &Path, folder: &Path, options: &[String]) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(folder)?;
    let mut files = Vec::new();
    loop {
        let file = folder.join(format!("{:05}.stl", files.len()));
        let mut marey = program(&target().join("release/marey").to_string_lossy());
        marey.arg("print").arg(std::path::absolute(creature)?).args(["--frame", &files.len().to_string()]);
        let output = marey.args(options).arg("-o").arg(&file).output()?;
        if output.status.success() {
            files.push(file);
            continue;
        }
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        // The frame after the last is refused.
        ensure!(!files.is_empty() && said.contains(&format!("frame is {}", files.len())), "{said}");
        return Ok(files);
    }
}

fn repairs(file: &Path) -> Result<()> {
    let said = read(program("admesh").arg(file))?;
    for line in said.lines() {
        for what in REPAIRS.iter().filter(|what| line.trim_start().starts_with(**what)) {
            // Two columns, before and after, or one count.
            let counts = line.split(':').skip(1).flat_map(|part| part.split_whitespace());
            if counts.filter_map(|n| n.parse::<u64>().ok()).any(|n| n > 0) {
                bail!("{}: admesh says {what}: {}", file.display(), line.trim());
            }
        }
    }
    Ok(())
}

fn slice(file: &Path) -> Result<()> {
    let code = file.with_extension("gcode");
    let mut slicer = program("prusa-slicer");
    slicer.args(["--export-gcode", "--support-material", "-o"]).arg(&code).arg(file);
    let output = slicer.output()?;
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    ensure!(output.status.success() && code.is_file(), "{}: PrusaSlicer fails:\n{said}", file.display());
    ensure!(!said.to_lowercase().contains("repair"), "{}: PrusaSlicer repairs:\n{said}", file.display());
    Ok(())
}
