//! What can be typed.

use std::path::PathBuf;

use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
#[command(
    name = "marey",
    version,
    about = "Turns a video of an animal, and a few strokes drawn on it, into an animated, textured 3D creature",
    after_help = "\
Examples:
  marey demo                                            the whole job on a bundled clip, into ./marey-demo
  marey info horse.mp4                                  what a clip is
  marey creature horse.mp4 --strokes s.json -o horse    a creature, animated and textured, and all that led to it
  marey track horse.mp4 --strokes s.json -o m.json      only the limbs over time

CLIP is a video file (mp4, GIF, APNG, animated WebP; others through an ffmpeg on the PATH) or a folder of numbered
images. Frames count from 0. Strokes are drawn limbs on key frames, as a marey-strokes file.

Exit codes: 0 done, 2 bad use, 3 bad input, 4 failed, 130 cancelled.",
    disable_help_subcommand = true
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print one machine-readable report on stdout
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Worker threads; 0 for one a core. Results do not depend on it
    #[arg(long, global = true, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=1024))]
    pub(crate) threads: u32,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Say what a clip is: size, frames, rate
    Info(Info),
    /// Follow the drawn limbs over all frames
    Track(Track),
    /// Cut the creature out of every frame
    Segment(Segment),
    /// Make the whole creature: limbs, masks, textured and animated model
    Creature(Creature),
    /// Make a creature of a bundled clip
    Demo(Demo),
    /// List plugins, check one, or begin a new one
    #[command(subcommand)]
    Plugin(PluginCommand),
    /// Deform a mesh by handles, and time it
    Deform(Deform),
    /// Look into the sessions of an editor
    #[command(subcommand)]
    Session(SessionCommand),
}

/// Which plugins to use beside those that are installed.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Plugins {
    /// Load this plugin too (a library or a bundle); may be repeated
    #[arg(long, value_name = "FILE")]
    pub(crate) plugin: Vec<PathBuf>,
    /// Choose the value of a plugin's parameter; may be repeated
    #[arg(long, value_name = "ID:PARAMETER=VALUE")]
    pub(crate) set: Vec<String>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum PluginCommand {
    /// List the plugins that are installed, and those that could not be loaded
    List(PluginList),
    /// Run the conformance suite on a plugin and say what is wrong
    Check(PluginCheck),
    /// Begin a new plugin: a project that builds, passes its own tests and loads
    New(PluginNew),
    /// Try a plugin for another process
    #[command(hide = true)]
    Probe(PluginProbe),
}

#[derive(Debug, clap::Args)]
pub(crate) struct PluginList {
    /// Load this plugin too (a library or a bundle); may be repeated
    #[arg(long, value_name = "FILE")]
    pub(crate) plugin: Vec<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey plugin check target/release/libmine.so")]
pub(crate) struct PluginCheck {
    /// The library (*.so) or bundle (*.marey)
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey plugin new my-tracker && cd my-tracker && cargo test")]
pub(crate) struct PluginNew {
    /// The plugin's name: a-z, 0-9 and '-'
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
    /// The folder to write [default: NAME]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Use the sdk in this folder instead of bringing it along
    #[arg(long, value_name = "DIR")]
    pub(crate) sdk: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct PluginProbe {
    /// How
    pub(crate) mode: String,
    /// The library
    pub(crate) file: PathBuf,
}

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

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey info horse.mp4 --json")]
pub(crate) struct Info {
    /// A video file or a folder of numbered images
    #[arg(value_name = "CLIP")]
    pub(crate) clip: PathBuf,
}

/// A clip, what was drawn on it, and who follows it.
#[derive(Debug, clap::Args)]
pub(crate) struct Drawn {
    /// A video file or a folder of numbered images
    #[arg(value_name = "CLIP")]
    pub(crate) clip: PathBuf,
    /// The drawn limbs (strokes.json)
    #[arg(long, value_name = "S.json")]
    pub(crate) strokes: PathBuf,
    /// Who follows the limbs: space-time, paper, or a plugin's id [default: the best]
    #[arg(long, value_name = "ID", default_value = "", hide_default_value = true)]
    pub(crate) tracker: String,
    #[command(flatten)]
    pub(crate) plugins: Plugins,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey track horse.mp4 --strokes strokes.json -o motion.json")]
pub(crate) struct Track {
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    /// Where to write the limbs over time
    #[arg(short, long, value_name = "motion.json")]
    pub(crate) output: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  marey segment horse.mp4 --strokes strokes.json -o masks

Writes DIR/00000.png, ... (8 bits, 0 or 255, at the clip's size) and DIR/report.json.")]
pub(crate) struct Segment {
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    /// Who cuts the creature out: layered, paper, or a plugin's id [default: the best]
    #[arg(long, value_name = "ID", default_value = "", hide_default_value = true)]
    pub(crate) segmenter: String,
    /// The folder to write
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey creature horse.mp4 --strokes strokes.json -o horse
  marey creature horse.mp4 --strokes strokes.json -o horse --obj --json --threads 4

Writes DIR/creature.glb (animated, textured; opens in Blender), motion.json, masks/, overlay.gif, preview.gif and
report.json, whole or not at all. The report says which stroke would help most if you draw one more.")]
pub(crate) struct Creature {
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    /// Who cuts the creature out: layered, paper, or a plugin's id [default: the best]
    #[arg(long, value_name = "ID", default_value = "", hide_default_value = true)]
    pub(crate) segmenter: String,
    /// The folder to write
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Also write meshes/00000.obj, ... in world coordinates
    #[arg(long)]
    pub(crate) obj: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  marey deform figure.obj handles.json deformed.json --deformer arap

HANDLES.json: {\"handles\": [{\"vertex\": 12}, ...], \"poses\": [{\"name\": \"bend\", \"targets\": [[x, y], ...]}, ...],
\"drag\": [[[x, y], ...], ...]}. Writes for each pose its vertices after ten steps from rest, and milliseconds of one thread,
the best of repeats; for the drag, four steps a frame from the frame before.")]
pub(crate) struct Deform {
    /// The mesh: v and f lines; z is left out
    #[arg(value_name = "MESH.obj")]
    pub(crate) mesh: PathBuf,
    /// Vertices that are held, and where they go
    #[arg(value_name = "HANDLES.json")]
    pub(crate) handles: PathBuf,
    /// Where to write shapes and times
    #[arg(value_name = "OUT.json")]
    pub(crate) output: PathBuf,
    /// Who deforms: arap, or a plugin's id
    #[arg(long, value_name = "ID", default_value = "", hide_default_value = true)]
    pub(crate) deformer: String,
    #[command(flatten)]
    pub(crate) plugins: Plugins,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey demo -o camel")]
pub(crate) struct Demo {
    /// The folder to write
    #[arg(short, long, value_name = "DIR", default_value = "marey-demo")]
    pub(crate) output: PathBuf,
}
