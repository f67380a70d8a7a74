//! The only places that print. A reader that has gone away (`marey info clip | head -0`) is no error.

use std::io::Write as _;

/// Text for stdout, as it is.
pub(crate) fn text(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// A line for stdout.
pub(crate) fn line(line: &str) {
    text(&format!("{line}\n"));
}

/// The line that says what went wrong.
pub(crate) fn error(message: &str) {
    let message = message.replace(['\n', '\r'], " ");
    let _ = writeln!(std::io::stderr(), "marey: {message}");
}

/// What can be typed, for someone who typed nothing.
pub(crate) fn help(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

/// A line that a person should see though all goes well.
pub(crate) fn warning(message: &str) {
    let _ = writeln!(std::io::stderr(), "marey: warning: {}", message.replace(['\n', '\r'], " "));
}
