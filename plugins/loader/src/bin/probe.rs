//! `marey-plugin-probe plugin probe load FILE`: tries a plugin for a host that does not want to try it itself.
//!
//! The command line `marey` answers the same words, so that either can be named as a host's probe.

use std::path::Path;
use std::process::ExitCode;

use marey_plugin_loader::{ProbeMode, probe_main};

#[expect(clippy::print_stdout, reason = "the answer goes to whoever started this program")]
fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [plugin, probe, mode, file] = args.as_slice() else { return ExitCode::from(2) };
    let (true, Some(mode)) = (plugin == "plugin" && probe == "probe", ProbeMode::of(mode)) else {
        return ExitCode::from(2);
    };
    println!("{}", probe_main(mode, Path::new(file)));
    ExitCode::SUCCESS
}
