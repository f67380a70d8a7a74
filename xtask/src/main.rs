//! The project's chores. `cargo xtask` lists them.

mod c_host;
mod cancels;
mod check;
mod header;
mod library;
mod measure;
mod shell;
mod system;
mod test;
mod validator;

use anyhow::{Result, bail};

const HELP: &str = "\
cargo xtask COMMAND

  test               everything that must pass; installs or names missing system packages
  check              format, lints, documentation, dependency licences and sources
  header [--check]   include/marey/marey.h from ffi/src
  library [--dev]    target/marey: the C library as it is installed
  c-host [--dev]     the header's compile matrix, and the C program of hosts/c built and run
  cancels            how soon jobs end when cancelled, at a hundred moments (release build, quiet machine)
  measure DATA ...   the table of scores on a data folder (release build)
  validate GLB ...   the Khronos glTF validator on files
";

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let Some((command, rest)) = args.split_first() else {
        shell::say(HELP);
        return Ok(());
    };
    match command.as_str() {
        "test" => test::run(),
        "check" => check::run(),
        "measure" => measure::run(rest),
        "header" => header::run(rest),
        "library" => library::run(rest),
        "c-host" => c_host::run(rest),
        "cancels" => cancels::run(),
        "validate" => validator::run(rest),
        "help" | "--help" | "-h" => {
            shell::say(HELP);
            Ok(())
        }
        other => bail!("no command `{other}`\n\n{HELP}"),
    }
}
