//! Why a command fails: one line, and an exit code.

use std::path::Path;

use marey_binding::{Error, Status};

pub(crate) const BAD_USE: i32 = 2;
pub(crate) const BAD_INPUT: i32 = 3;
pub(crate) const FAILED: i32 = 4;
pub(crate) const CANCELLED: i32 = 130;

/// A failed command.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) exit_code: i32,
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn new(exit_code: i32, message: impl Into<String>) -> Self {
        Self { exit_code, message: message.into() }
    }

    /// The failure as one of a file's.
    pub(crate) fn about(self, file: &Path) -> Self {
        Self::new(self.exit_code, format!("{}: {}", file.display(), self.message))
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let exit_code = match error.status() {
            Status::Cancelled => CANCELLED,
            Status::BadUse => BAD_USE,
            Status::BadInput => BAD_INPUT,
            _ => FAILED,
        };
        // A description's fields are the command's options here.
        Self::new(exit_code, error.to_string().replace("desc.", "--"))
    }
}

/// What clap says of a mistake, on one line.
pub(crate) fn one_line(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let said = text.split("\n\nUsage:").next().unwrap_or(&text).split("\n\nFor more").next().unwrap_or_default();
    let words: Vec<&str> = said.split_whitespace().collect();
    let said = words.join(" ");
    let command = std::env::args().nth(1).filter(|word| !word.starts_with('-') && !said.contains(&**word));
    let command = command.map_or(String::new(), |word| format!(" {word}"));
    format!("{}; `marey{command} --help` shows how", said.strip_prefix("error: ").unwrap_or(&said))
}
