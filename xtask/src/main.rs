//! The project's chores. `cargo xtask` lists them.

mod abi;
mod blender;
mod c_host;
mod cancels;
mod check;
mod compile_matrix;
mod first_host;
mod gallery;
mod header;
mod library;
mod measure;
mod players;
mod prints;
mod reference;
mod sample;
mod shell;
mod studio;
mod system;
mod test;
mod validator;
mod watched;

use anyhow::{Result, bail};

const HELP: &str = "\
cargo xtask COMMAND

  test               everything that must pass; installs or names missing system packages
  check              format, lints, documentation, dependency licences and sources
  header [--check]   include/marey/marey.h from ffi/src
  library [--dev]    target/marey: the C library as it is installed
  install --prefix DIR [--dev]
                     the C library into DIR: lib, headers, pkg-config, CMake
  c-host [--dev]     what C and C++ hosts rely on: compile matrix, ABI, installed consumers, sanitizers, valgrind, docs
  docs               the C reference and articles in target/docs/html
  soak [CALLS [SEED]]
                     random calls on the C library under sanitizers, a million by default (release build)
  cancels            how soon jobs end when cancelled, at a hundred moments, and what a call costs (release build,
                     quiet machine)
  studio [GESTURES [SEED]]
                     the studio killed at fifty moments, used by random gestures, a hundred thousand by default, and what a
                     clip and a sample take a person
                     (release build)
  measure DATA ...   the table of scores on a data folder (release build)
  retrack DATA ...   what a corrected stroke costs, on the same folder (release build)
  alternatives DATA ...
                     built-in trackers and segmenters beside the plugins that ship (release build)
  players [DATA]     takes of characters in three.js, lottie-web, the DragonBones runtime and a reader of Spine's JSON
                     (fetches them and a browser)
  prints CREATURE ... [-- OPTION ...]
                     a print of every frame, looked at by trimesh and manifold3d (a python3, or $PYTHON, that has them),
                     admesh and PrusaSlicer; OPTIONs are those of marey print (release build)
  gallery [ARTICLE ...]
                     the pictures of docs/sketches.md and creatures.md, made anew by the commands they give (release build)
  validate GLB ...   the Khronos glTF validator on files
  blender GLB ...    files imported, played and exported again by Blender, and compared (fetches it)
";

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let Some((command, rest)) = args.split_first() else {
        shell::say(HELP);
        return Ok(());
    };
    if ["test", "docs", "soak", "c-host", "studio"].contains(&command.as_str()) {
        system::ensure()?;
    }
    match command.as_str() {
        "test" => test::run(),
        "check" => check::run(),
        "measure" | "retrack" => measure::run(command, rest),
        "alternatives" => measure::alternatives(rest),
        "header" => header::run(rest),
        "library" => library::run(rest),
        "install" => library::install(rest),
        "docs" => reference::run(),
        "soak" => watched::long(rest),
        "c-host" => c_host::run(rest),
        "cancels" => cancels::run(),
        "players" => players::run(rest),
        "studio" => studio::run(rest),
        "prints" => prints::run(rest),
        "gallery" => gallery::gallery(rest),
        "validate" => validator::run(rest),
        "blender" => blender::run(rest),
        "help" | "--help" | "-h" => {
            shell::say(HELP);
            Ok(())
        }
        other => bail!("no command `{other}`\n\n{HELP}"),
    }
}
