//! `marey-studio [FILE]`: a clip or a session to begin with.

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    match marey_studio::run(std::env::args_os().nth(1).map(PathBuf::from)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            use std::io::Write as _;
            let _ = writeln!(std::io::stderr(), "marey-studio: {message}");
            ExitCode::FAILURE
        }
    }
}
