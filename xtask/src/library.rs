//! `cargo xtask install --prefix DIR`: the C library as a system has it; `cargo xtask library` puts it into target/marey.
//!
//! ```text
//! include/marey/marey.h, marey.hpp, plugin.h
//! lib/libmarey.so -> libmarey.so.0.1 -> libmarey.so.0.1.0      SONAME libmarey.so.0.1, symbols at MRY_0.1
//! lib/libmarey.a
//! lib/pkgconfig/marey.pc
//! lib/cmake/marey/marey-config.cmake, marey-config-version.cmake
//! ```
//! Cargo cannot call the library `marey` itself: the engine's crate has that name. Nor can a cdylib carry symbol
//! versions, because rustc hands the linker a version script of its own; so the shared library is linked here, from
//! the static one. Everything in the prefix finds its neighbours from its own place, so that it can be moved.

use std::collections::BTreeSet;
use std::path::Path;
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
    let folder = target().join("marey");
    build(Profile::of(args)?, &folder)?;
    say(&format!("{}: lib, include, and pkg-config's marey.pc in lib/pkgconfig", folder.display()));
    Ok(())
}

/// `cargo xtask install --prefix DIR [--dev]`
pub(crate) fn install(args: &[String]) -> Result<()> {
    let [flag, prefix, rest @ ..] = args else { bail!("usage: cargo xtask install --prefix DIR [--dev]") };
    ensure!(flag == "--prefix", "usage: cargo xtask install --prefix DIR [--dev]");
    let prefix = std::path::absolute(prefix)?;
    build(Profile::of(rest)?, &prefix)?;
    say(&format!("installed into {}", prefix.display()));
    Ok(())
}

/// Builds the library and installs it into `prefix`.
pub(crate) fn build(profile: Profile, prefix: &Path) -> Result<()> {
    let (flags, built): (&[&str], _) = match profile {
        Profile::Release => (&["--release"], "release"),
        Profile::Dev => (&[], "debug"),
    };
    // The compiler says what a program that links the static library needs besides; cargo repeats it when nothing is
    // built anew.
    let mut command = cargo();
    command.args(["rustc", "--locked", "--package", "marey-ffi", "--lib", "--crate-type", "staticlib"]).args(flags);
    command.args(["--", "--print", "native-static-libs"]);
    say("+ cargo rustc --package marey-ffi");
    let output = command.stdout(Stdio::inherit()).output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{said}");
    let private = said.lines().find_map(|l| l.split_once("native-static-libs:")).map_or("", |(_, libs)| libs.trim());
    ensure!(!private.is_empty(), "the compiler did not say what the static library needs:\n{said}");

    let (lib, include) = (prefix.join("lib"), prefix.join("include/marey"));
    let (pkgconfig, cmake) = (lib.join("pkgconfig"), lib.join("cmake/marey"));
    for dir in [&pkgconfig, &cmake, &include] {
        std::fs::create_dir_all(dir).with_context(|| dir.display().to_string())?;
    }
    let [major, minor, patch] = header::version();
    let (soname, full) = (format!("libmarey.so.{major}.{minor}"), format!("libmarey.so.{major}.{minor}.{patch}"));
    copy(&target().join(built).join("libmarey_ffi.a"), &lib.join("libmarey.a"))?;
    link_shared(&lib.join("libmarey.a"), private, &soname, &lib.join(&full))?;
    for name in ["marey.h", "marey.hpp", "plugin.h"] {
        copy(&root().join("include/marey").join(name), &include.join(name))?;
    }
    link(&full, &lib.join(&soname))?;
    link(&soname, &lib.join("libmarey.so"))?;
    let dynamic = read(program("readelf").arg("-d").arg(lib.join(&full)))?;
    ensure!(dynamic.contains(&format!("[{soname}]")), "{full} does not carry SONAME {soname}:\n{dynamic}");
    check_symbols(&lib.join(&full))?;
    write(&pkgconfig.join("marey.pc"), &pkg_config(private))?;
    write(&cmake.join("marey-config.cmake"), &cmake_config(&soname, &full, private))?;
    write(&cmake.join("marey-config-version.cmake"), &cmake_version())
}

/// The version that the exported symbols carry; it follows the SONAME.
fn symbol_version() -> String {
    let [major, minor, _] = header::version();
    format!("MRY_{major}.{minor}")
}

/// Links the shared library: every exported function with its version, nothing else to be seen, nothing undefined,
/// never unmapped (its threads and the host keep pointers into it).
fn link_shared(archive: &Path, private: &str, soname: &str, to: &Path) -> Result<()> {
    let script = target().join("marey.map");
    write(&script, &format!("{} {{ global: mry_*; local: *; }};\n", symbol_version()))?;
    remove(to)?;
    let mut cc = program("cc");
    cc.args(["-shared", "-Wl,--whole-archive"]).arg(archive).arg("-Wl,--no-whole-archive");
    cc.arg(format!("-Wl,--version-script={}", script.display())).arg(format!("-Wl,-soname,{soname}"));
    cc.args(["-Wl,-z,nodelete", "-Wl,-z,defs", "-Wl,-z,relro", "-Wl,-z,now", "-Wl,--gc-sections", "-Wl,--as-needed"]);
    read(cc.args(private.split_whitespace()).arg("-o").arg(to)).map(drop)
}

/// The library exports what ffi/abi/symbols.txt lists, no more and no less.
fn check_symbols(library: &Path) -> Result<()> {
    let listed = std::fs::read_to_string(root().join("ffi/abi/symbols.txt"))?;
    let listed: BTreeSet<&str> = listed.lines().collect();
    let said = read(program("nm").args(["--dynamic", "--defined-only", "--format=posix"]).arg(library))?;
    let names = said.lines().filter_map(|l| l.split_whitespace().next());
    let (versioned, others): (Vec<_>, Vec<_>) = names.partition(|name| name.contains("@@"));
    // Beside the functions there is the name of the version itself.
    ensure!(others.iter().all(|n| *n == symbol_version()), "exported without a version: {others:?}");
    let exported: BTreeSet<&str> = versioned.iter().filter_map(|n| n.split("@@").next()).collect();
    let extra: Vec<_> = exported.difference(&listed).collect();
    let missing: Vec<_> = listed.difference(&exported).collect();
    ensure!(
        extra.is_empty() && missing.is_empty(),
        "{}: exports that ffi/abi/symbols.txt does not list: {extra:?}; listed and not exported: {missing:?}",
        library.display()
    );
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).with_context(|| path.display().to_string())
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

/// `find_package(marey)` gives `marey::marey`: the shared library, or the static one where MAREY_STATIC is set.
fn cmake_config(soname: &str, full: &str, private: &str) -> String {
    let needed: Vec<&str> = private.split_whitespace().collect();
    format!(
        "# marey::marey is the library: shared, or static when MAREY_STATIC is true before find_package(marey).
get_filename_component(_marey_prefix \"${{CMAKE_CURRENT_LIST_DIR}}/../../..\" ABSOLUTE)

if(NOT TARGET marey::marey)
  if(MAREY_STATIC)
    add_library(marey::marey STATIC IMPORTED)
    set_target_properties(marey::marey PROPERTIES
      IMPORTED_LOCATION \"${{_marey_prefix}}/lib/libmarey.a\"
      INTERFACE_LINK_LIBRARIES \"{}\")
  else()
    add_library(marey::marey SHARED IMPORTED)
    set_target_properties(marey::marey PROPERTIES
      IMPORTED_LOCATION \"${{_marey_prefix}}/lib/{full}\"
      IMPORTED_SONAME \"{soname}\")
  endif()
  set_target_properties(marey::marey PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES \"${{_marey_prefix}}/include\")
endif()
unset(_marey_prefix)
",
        needed.join(";")
    )
}

/// Before 1.0 a version fits another with its major and minor number, and no older patch.
fn cmake_version() -> String {
    let [major, minor, patch] = header::version();
    format!(
        "set(PACKAGE_VERSION {major}.{minor}.{patch})
if(PACKAGE_FIND_VERSION_MAJOR EQUAL {major}
   AND (PACKAGE_FIND_VERSION_COUNT LESS 2 OR PACKAGE_FIND_VERSION_MINOR EQUAL {minor})
   AND NOT PACKAGE_FIND_VERSION VERSION_GREATER PACKAGE_VERSION)
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
  if(PACKAGE_FIND_VERSION VERSION_EQUAL PACKAGE_VERSION)
    set(PACKAGE_VERSION_EXACT TRUE)
  endif()
endif()
"
    )
}
