//! Edits and saves the session at the path given until it is killed, and prints the number of each gesture once it is
//! finished. See tests/session_kill.rs.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use marey::job::Progress;
use marey::session::{Access, Session};
use marey_tests::editing;

fn main() -> Result<()> {
    let path: PathBuf = std::env::args_os().nth(1).context("usage: session_editor FILE")?.into();
    let mut session = if path.exists() {
        Session::open(&path, Access::Edit, Progress::new().whole())?
    } else {
        Session::create(&path)?
    };
    let mut out = std::io::stdout().lock();
    loop {
        editing::gesture(&mut session)?;
        writeln!(out, "{}", session.gestures())?;
        out.flush()?;
        editing::save(&mut session)?;
    }
}
