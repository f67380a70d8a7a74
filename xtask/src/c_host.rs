//! `cargo xtask c-host`: what authors of C and C++ hosts do, from the headers to running programs.
//!
//! The library is installed into an empty prefix, which is then all that the programs know: hosts/c and hosts/cpp
//! against the shared and the static library, and the article's first host by make and by CMake.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};

use crate::compile_matrix::{self, WARNINGS};
use crate::library::{self, Profile};
use crate::sample::{self, Sample};
use crate::shell::{program, read, root, say, target};
use crate::{abi, first_host, reference, watched};

pub(crate) fn run(args: &[String]) -> Result<()> {
    let profile = Profile::of(args)?;
    compile_matrix::run()?;
    abi::check()?;
    let prefix = fresh("prefix")?;
    library::build(profile, &prefix)?;
    let sample = sample::write(&fresh("sample")?)?;
    programs(&prefix, &sample)?;
    first_host::run(&prefix, &sample)?;
    abi::old_host(&prefix, &sample)?;
    watched::run(&prefix, &sample)?;
    reference::run()
}

/// An empty folder below target/c.
pub(crate) fn fresh(name: &str) -> Result<PathBuf> {
    let folder = target().join("c").join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// Compiles and links a program in C or C++ against an installed library.
pub(crate) struct Build<'a> {
    pub(crate) source: &'a Path,
    pub(crate) include: &'a Path,
    pub(crate) prefix: &'a Path,
    pub(crate) fixed: bool,
    pub(crate) flags: &'a [&'a str],
}

impl Build<'_> {
    /// Builds it as `to`.
    pub(crate) fn run(&self, to: &Path) -> Result<()> {
        let c = self.source.extension().is_some_and(|e| e == "c");
        let mut compiler = program(if c { "cc" } else { "c++" });
        compiler.args([if c { "-std=c11" } else { "-std=c++17" }, "-O1", "-g"]).args(WARNINGS).args(self.flags);
        compiler.arg(self.source).arg("-I").arg(self.include).arg("-o").arg(to);
        let lib = self.prefix.join("lib");
        if self.fixed {
            let pc = std::fs::read_to_string(lib.join("pkgconfig/marey.pc"))?;
            let private =
                pc.lines().find_map(|l| l.strip_prefix("Libs.private:")).context("marey.pc: no Libs.private")?;
            compiler.arg(lib.join("libmarey.a")).args(private.split_whitespace());
        } else {
            compiler.arg("-L").arg(&lib).arg("-lmarey").arg(format!("-Wl,-rpath,{}", lib.display())).arg("-lm");
        }
        read(&mut compiler).map(drop)
    }
}

/// Builds hosts/c/creature.c and hosts/cpp/gait.cpp against the shared and the static library, and runs them.
fn programs(prefix: &Path, sample: &Sample) -> Result<()> {
    let folder = fresh("hosts")?;
    let include = prefix.join("include");
    let (c, cpp) = (root().join("hosts/c/creature.c"), root().join("hosts/cpp/gait.cpp"));
    let mut written = Vec::new();
    for (kind, fixed) in [("shared", false), ("static", true)] {
        let build = |source: &Path, name: String| {
            let to = folder.join(name);
            Build { source, include: &include, prefix, fixed, flags: &[] }.run(&to).map(|()| to)
        };
        let (creature, gait) = (build(&c, format!("creature-{kind}"))?, build(&cpp, format!("gait-{kind}"))?);
        let glb = folder.join(format!("{kind}.glb"));
        let said = read(host(&creature).arg(&sample.clip).arg(&glb).arg(&sample.strokes))?;
        ensure!(said.contains("cancelled"), "{}: did not show a cancel:\n{said}", creature.display());
        let table = folder.join(format!("{kind}.csv"));
        let said = read(host(&gait).args([&sample.clip, &sample.strokes, &table]))?;
        ensure!(said.contains("3 limbs in 8 frames"), "{}:\n{said}", gait.display());
        written.push((is_glb(&glb)?, std::fs::read(&table)?));
    }
    ensure!(written[0] == written[1], "the shared and the static library give different results");
    // A real clip, drawn call by call.
    let glb = folder.join("camel.glb");
    read(host(&folder.join("creature-shared")).arg(root().join("data/camel/clip.mp4")).arg(&glb))?;
    say(&format!("hosts/c and hosts/cpp run, shared and static; the camel is {} bytes of glTF", is_glb(&glb)?.len()));
    Ok(())
}

/// A built program, to be run.
pub(crate) fn host(path: &Path) -> std::process::Command {
    program(&path.to_string_lossy())
}

/// The bytes of a file that must be a glTF binary.
pub(crate) fn is_glb(path: &Path) -> Result<Vec<u8>> {
    let glb = std::fs::read(path).with_context(|| path.display().to_string())?;
    ensure!(glb.starts_with(b"glTF"), "{}: not a glTF binary", path.display());
    Ok(glb)
}
