//! The Khronos glTF validator, fetched once as an npm package at a pinned version into target/.

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};

use crate::shell::{self, program, say, target};

const PACKAGE: &str = "gltf-validator@2.0.0-dev.3.10";

/// Reads one file, prints `errors warnings` and, on more lines, the messages of those severities.
const SCRIPT: &str = r#"
const validator = require("gltf-validator"), fs = require("fs");
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])), { maxIssues: 50 }).then((report) => {
  console.log(report.issues.numErrors, report.issues.numWarnings);
  for (const m of report.issues.messages) if (m.severity < 2) console.log(m.code, m.pointer, m.message);
});
"#;

/// `cargo xtask validate GLB ...`
pub(crate) fn run(files: &[String]) -> Result<()> {
    ensure!(!files.is_empty(), "usage: cargo xtask validate GLB ...");
    files.iter().try_for_each(|file| validate(Path::new(file)))
}

/// Makes the demo and validates its creature: no errors, no warnings.
pub(crate) fn demo() -> Result<()> {
    let out = target().join("marey/validated-demo");
    if out.exists() {
        std::fs::remove_dir_all(&out)?;
    }
    // The whole workspace, so that what the tests built is what runs: the command line by itself is built with fewer
    // features of everything below it, the engine once more among them.
    shell::run(shell::cargo().args(["build", "--workspace", "--locked", "--bin", "marey"]))?;
    let marey = target().join("debug/marey").with_extension(std::env::consts::EXE_EXTENSION);
    shell::run(program(&marey.to_string_lossy()).args(["demo", "-o"]).arg(&out))?;
    validate(&out.join("creature.glb"))
}

fn install() -> Result<PathBuf> {
    let tools = target().join("tools/gltf-validator");
    let script = tools.join("validate.js");
    if !tools.join("node_modules/gltf-validator").exists() {
        std::fs::create_dir_all(&tools)?;
        let mut npm = program("npm");
        npm.args(["install", "--silent", "--no-audit", "--no-fund", "--prefix"]).arg(&tools).arg(PACKAGE);
        shell::run(&mut npm)?;
    }
    std::fs::write(&script, SCRIPT)?;
    Ok(script)
}

pub(crate) fn validate(file: &Path) -> Result<()> {
    let said = shell::read(program("node").arg(install()?).arg(std::path::absolute(file)?))?;
    ensure!(said.starts_with("0 0\n"), "{}: the glTF validator says (errors, warnings):\n{said}", file.display());
    say(&format!("{}: 0 errors, 0 warnings in the glTF validator", file.display()));
    Ok(())
}
