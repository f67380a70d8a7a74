//! `marey-studio [FILE]`: a clip or a session to begin with. `marey-studio plugin probe MODE FILE` tries a plugin, in the
//! process of its own that a studio starts for it.

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<_> = std::env::args_os().skip(1).collect();
    let done = match &words[..] {
        [plugin, probe, mode, file] if plugin == "plugin" && probe == "probe" => {
            marey_studio::probe(&mode.to_string_lossy(), &file.to_string_lossy()).and_then(|line| say(&line))
        }
        [asked, ..] if asked == "--help" || asked == "-h" => say(
            "marey-studio [FILE]\n\nFILE is a clip, a picture or a session to begin with. Keys: F1. The page about it: docs/studio.md",
        ),
        [asked, ..] if asked == "--version" || asked == "-V" => {
            say(concat!("marey-studio ", env!("CARGO_PKG_VERSION")))
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

fn say(line: &str) -> Result<(), String> {
    use std::io::Write as _;
    writeln!(std::io::stdout(), "{line}").map_err(|e| e.to_string())
}
