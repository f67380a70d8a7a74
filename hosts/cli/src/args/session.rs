//! What can be typed after `marey session`.

use std::path::PathBuf;

use clap::Subcommand;

#[derive(Debug, Subcommand)]
pub(crate) enum SessionCommand {
    /// Say what a session holds, what of it was not saved, and what is damaged or missing
    Info(SessionInfo),
    /// Put the clip and the painted masks into the session's file, so that the one file can be carried about
    Embed(SessionEmbed),
    /// Do again what a recording of a session says was done
    Replay(SessionReplay),
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey session info walk.marey --json")]
pub(crate) struct SessionInfo {
    /// A session file; it is only read, and may be open elsewhere
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey session embed walk.marey")]
pub(crate) struct SessionEmbed {
    /// A session file that is not open elsewhere
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey session replay walk.recording -o walk.marey")]
pub(crate) struct SessionReplay {
    /// A recording
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Gestures to play, at most
    #[arg(long, value_name = "N", default_value_t = u64::MAX, hide_default_value = true)]
    pub(crate) most: u64,
    /// Where to save the session that it leads to
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}
