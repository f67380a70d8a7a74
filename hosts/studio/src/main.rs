//! `marey-studio [FILE]`: a clip or a session to begin with. `marey-studio plugin probe MODE FILE` tries a plugin, in the
//! process of its own that a studio starts for it.

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<_> = std::env::args_os().skip(1).collect();
    let done = match &words[..] {
        [plugin, probe, mode, file] if plugin == "plugin" && probe == "probe" => {
            marey_studio::probe(&mode.to_string_lossy(), &file.to_string_lossy()).map(|line| {
                use std::io::Write as _;
                let _ = writeln!(std::io::stdout(), "{line}");
            })
        }
        _ => marey_studio::run(words.first().map(PathBuf::from)),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            use std::io::Write as _;
            let _ = writeln!(std::io::stderr(), "marey-studio: {message}");
            ExitCode::FAILURE
        }
    }
}
