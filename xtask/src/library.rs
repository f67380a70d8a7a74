//! `cargo xtask library`: target/marey, laid out as the C library is installed.
//!
//! ```text
//! include/marey/marey.h
//! lib/libmarey.so -> libmarey.so.0.1 -> libmarey.so.0.1.0      SONAME libmarey.so.0.1
//! lib/libmarey.a
//! lib/pkgconfig/marey.pc
//! ```
//! Cargo cannot call the library `marey` itself: the engine's crate has that name.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::{Context as _, Result, bail, ensure};

use crate::header;
use crate::shell::{cargo, program, read, root, say, target};

/// Which build of the library.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Profile {
    Release,
    Dev,
}

impl Profile {
    /// `--dev` asks for the development profile, which the tests share with everything else they build.
    pub(crate) fn of(args: &[String]) -> Result<Self> {
        match args {
            [] => Ok(Self::Release),
            [only] if only == "--dev" => Ok(Self::Dev),
            _ => bail!("the only option is --dev"),
        }
    }
}

pub(crate) fn run(args: &[String]) -> Result<()> {
    let folder = build(Profile::of(args)?)?;
    say(&format!("{}: lib, include, and pkg-config's marey.pc in lib/pkgconfig", folder.display()));
    Ok(())
}

/// Builds the library and lays it out; gives the folder.
pub(crate) fn build(profile: Profile) -> Result<PathBuf> {
    let (flags, built): (&[&str], _) = match profile {
        Profile::Release => (&["--release"], "release"),
        Profile::Dev => (&[], "debug"),
    };
    // The compiler says what a program that links the static library needs besides; cargo repeats it when nothing is
    // built anew.
    let mut command = cargo();
    command.args(["rustc", "--locked", "--package", "marey-ffi", "--lib"]).args(flags);
    command.args(["--", "--print", "native-static-libs"]);
    say("+ cargo rustc --package marey-ffi");
    let output = command.stdout(Stdio::inherit()).output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{said}");
    let private = said.lines().find_map(|l| l.split_once("native-static-libs:")).map_or("", |(_, libs)| libs.trim());
    ensure!(!private.is_empty(), "the compiler did not say what the static library needs:\n{said}");

    let built = target().join(built);
    let folder = target().join("marey");
    let lib = folder.join("lib");
    let include = folder.join("include/marey");
    for dir in [&lib.join("pkgconfig"), &include] {
        std::fs::create_dir_all(dir).with_context(|| dir.display().to_string())?;
    }
    let [major, minor, patch] = header::version();
    let (soname, full) = (format!("libmarey.so.{major}.{minor}"), format!("libmarey.so.{major}.{minor}.{patch}"));
    copy(&built.join("libmarey_ffi.so"), &lib.join(&full))?;
    copy(&built.join("libmarey_ffi.a"), &lib.join("libmarey.a"))?;
    copy(&header::path(), &include.join("marey.h"))?;
    link(&full, &lib.join(&soname))?;
    link(&soname, &lib.join("libmarey.so"))?;
    let dynamic = read(program("readelf").arg("-d").arg(lib.join(&full)))?;
    ensure!(dynamic.contains(&format!("[{soname}]")), "{full} does not carry SONAME {soname}:\n{dynamic}");
    check_symbols(&lib.join(&full))?;
    std::fs::write(lib.join("pkgconfig/marey.pc"), pkg_config(private))?;
    Ok(folder)
}

/// The library exports what ffi/abi/symbols.txt lists, no more and no less.
fn check_symbols(library: &Path) -> Result<()> {
    let listed = std::fs::read_to_string(root().join("ffi/abi/symbols.txt"))?;
    let listed: BTreeSet<&str> = listed.lines().collect();
    let said = read(program("nm").args(["--dynamic", "--defined-only", "--format=posix"]).arg(library))?;
    let exported: BTreeSet<&str> = said.lines().filter_map(|l| l.split_whitespace().next()).collect();
    let extra: Vec<_> = exported.difference(&listed).collect();
    let missing: Vec<_> = listed.difference(&exported).collect();
    ensure!(
        extra.is_empty() && missing.is_empty(),
        "{}: exports that ffi/abi/symbols.txt does not list: {extra:?}; listed and not exported: {missing:?}",
        library.display()
    );
    Ok(())
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    // A new file, not the old one's bytes changed: a program that runs on the old library keeps it.
    remove(to)?;
    std::fs::copy(from, to).with_context(|| format!("{} to {}", from.display(), to.display()))?;
    Ok(())
}

fn link(to: &str, at: &Path) -> Result<()> {
    remove(at)?;
    std::os::unix::fs::symlink(to, at).with_context(|| at.display().to_string())
}

fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(e).with_context(|| path.display().to_string()),
        _ => Ok(()),
    }
}

/// marey.pc, which finds its folder from its own place.
fn pkg_config(private: &str) -> String {
    let [major, minor, patch] = header::version();
    format!(
        "prefix=${{pcfiledir}}/../..
libdir=${{prefix}}/lib
includedir=${{prefix}}/include

Name: marey
Description: Video of something alive in, animation out
Version: {major}.{minor}.{patch}
Cflags: -I${{includedir}}
Libs: -L${{libdir}} -lmarey
Libs.private: {private}
"
    )
}
