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
  marey track walk.gif --joints j.json -o m.json        a character's joints over time

CLIP is a video file (mp4, GIF, APNG, animated WebP; others through an ffmpeg on the PATH) or a folder of numbered
images. Frames count from 0. Strokes are drawn limbs on key frames, as a marey-strokes file; joints are rectangles on a
frame, as a marey-joints file.

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
    /// Follow drawn limbs, or marked joints, over all frames
    Track(Track),
    /// Cut the creature out of every frame
    Segment(Segment),
    /// Make the whole creature: limbs, masks, textured and animated model
    Creature(Creature),
    /// Give a drawing a mesh and a skeleton
    Rig(Rig),
    /// Move a drawing by key poses or by a motion
    Character(Box<Character>),
    /// Carry a motion over to the joints of a drawing
    Retarget(Retarget),
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
#[command(after_help = "\
Examples:
  marey track horse.mp4 --strokes strokes.json -o motion.json
  marey track walk.gif --joints joints.json -o motion.json

joints.json marks each joint as a small rectangle on one frame, and names the bones between them; more rectangles of a
joint on other frames are corrections.")]
pub(crate) struct Track {
    /// A video file or a folder of numbered images
    #[arg(value_name = "CLIP")]
    pub(crate) clip: PathBuf,
    /// The drawn limbs (strokes.json)
    #[arg(long, value_name = "S.json", required_unless_present = "joints")]
    pub(crate) strokes: Option<PathBuf>,
    /// The marked joints of a character (joints.json), in place of limbs
    #[arg(long, value_name = "J.json", conflicts_with_all = ["strokes", "tracker", "plugin", "set"])]
    pub(crate) joints: Option<PathBuf>,
    /// Who follows the limbs: space-time, paper, or a plugin's id [default: the best]
    #[arg(long, value_name = "ID", default_value = "", hide_default_value = true)]
    pub(crate) tracker: String,
    #[command(flatten)]
    pub(crate) plugins: Plugins,
    /// Where to write the motion
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
  marey rig cat.png -o rig.json --preview rig.png

The drawing is what is opaque; where everything is, what differs from the paper around it, or what a mask says. rig.json
holds the mesh, joints and bones; joints may be moved and renamed in it.")]
pub(crate) struct Rig {
    /// The drawing: PNG, JPEG, WebP or GIF
    #[arg(value_name = "IMAGE")]
    pub(crate) picture: PathBuf,
    /// Where to write the rig
    #[arg(short, long, value_name = "RIG.json")]
    pub(crate) output: PathBuf,
    /// A picture of the same size that cuts the drawing out: bright is the drawing
    #[arg(long, value_name = "MASK.png")]
    pub(crate) mask: Option<PathBuf>,
    /// About how many vertices the mesh has [default: 1200]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub(crate) vertices: u32,
    /// How much closer vertices are at joints, 1 to 8 [default: 2]
    #[arg(long, value_name = "F", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) finer_at_joints: f32,
    /// Also draw the rig over the drawing
    #[arg(long, value_name = "PREVIEW.png")]
    pub(crate) preview: Option<PathBuf>,
}

/// What of a bone's direction is carried over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Angles {
    Relative,
    Absolute,
}

/// What keeps the area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Area {
    Exact,
    Reciprocal,
    Off,
}

/// From where a BVH file is seen; the numbers are the library's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum View {
    Front = 0,
    Side = 1,
    FrontZUp = 2,
    SideZUp = 3,
}

/// How a motion is carried over to a drawing.
#[derive(Debug, clap::Args)]
pub(crate) struct Carry {
    /// Which joint follows what; without it names decide, or where figures lie alike
    #[arg(long, value_name = "MAP.json")]
    pub(crate) map: Option<PathBuf>,
    /// Write the map that was used, to correct it and give it back
    #[arg(long, value_name = "MAP.json")]
    pub(crate) keep_map: Option<PathBuf>,
    /// Whether bones turn as the motion's do, or point where they do
    #[arg(long, value_enum, default_value_t = Angles::Relative)]
    pub(crate) angles: Angles,
    /// The frame of the motion that the drawing at rest corresponds to
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) reference: u64,
    /// Joints that stay where they come down, such as feet
    #[arg(long, value_name = "JOINT,...", value_delimiter = ',')]
    pub(crate) planted: Vec<String>,
    /// Bones change their length up to this factor; 1 for not at all [default: 3]
    #[arg(long, value_name = "F", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) stretch: f32,
    /// What the way of the whole figure is scaled by; 0 to stay in place [default: by the figures' sizes]
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    pub(crate) root_scale: Option<f32>,
    /// From where a BVH file is seen
    #[arg(long, value_enum, default_value_t = View::Front)]
    pub(crate) view: View,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey character cat.png --rig rig.json --poses poses.json -o cat.gif
  marey character cat.png --rig rig.json --motion horse/motion.json -o cat.mp4 --background white
  marey character girl.png --rig rig.json --motion walk.bvh --planted foot_l,foot_r -o walk

OUT's ending says the format: gif, apng, webp, mp4, glb, json (Lottie), no ending for a folder of PNG pictures. --format
names any of png-dir, sprite-sheet, gif, apng, webp, mp4, glb, lottie, spine, dragonbones.")]
pub(crate) struct Character {
    /// The drawing: PNG, JPEG, WebP or GIF
    #[arg(value_name = "IMAGE")]
    pub(crate) picture: PathBuf,
    /// Its rig, as `marey rig` writes it
    #[arg(long, value_name = "RIG.json")]
    pub(crate) rig: PathBuf,
    /// The mask that the rig was made with
    #[arg(long, value_name = "MASK.png")]
    pub(crate) mask: Option<PathBuf>,
    /// Key poses
    #[arg(long, value_name = "POSES.json", conflicts_with = "motion", required_unless_present = "motion")]
    pub(crate) poses: Option<PathBuf>,
    /// A motion of anything: motion.json, or a BVH file
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) carry: Carry,
    /// The file or folder to write
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// The format, where OUT's ending does not say it
    #[arg(long, value_name = "NAME")]
    pub(crate) format: Option<String>,
    /// Pixels a pixel of the drawing
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    pub(crate) scale: f32,
    /// What lies behind: #rrggbb, #rrggbbaa, none, white, black
    #[arg(long, value_name = "COLOR", default_value = "none")]
    pub(crate) background: String,
    /// Cut pictures to the drawing's, rather than show all of every frame
    #[arg(long)]
    pub(crate) no_grow: bool,
    /// What keeps the area where bones change their length, with needles
    #[arg(long, value_enum, default_value_t = Area::Exact)]
    pub(crate) area: Area,
    /// Who deforms: needles, arap, or a plugin's id
    #[arg(long, value_name = "ID", default_value = "needles")]
    pub(crate) deformer: String,
    /// Also write the motion as the drawing's joints have it, as motion.json or BVH
    #[arg(long, value_name = "OUT_MOTION", requires = "motion")]
    pub(crate) keep_motion: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) plugins: Plugins,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey retarget walk.bvh --rig rig.json -o walk.json --keep-map map.json")]
pub(crate) struct Retarget {
    /// A motion of anything: motion.json, or a BVH file
    #[arg(value_name = "MOTION")]
    pub(crate) motion: PathBuf,
    /// The drawing's rig
    #[arg(long, value_name = "RIG.json")]
    pub(crate) rig: PathBuf,
    #[command(flatten)]
    pub(crate) carry: Carry,
    /// The motion of the drawing's joints: .json, or .bvh
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
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
#[command(after_help = "Examples:\n  marey demo -o camel\n  marey demo --character -o child")]
pub(crate) struct Demo {
    /// The folder to write
    #[arg(short, long, value_name = "DIR", default_value = "marey-demo")]
    pub(crate) output: PathBuf,
    /// Move a bundled drawing instead
    #[arg(long)]
    pub(crate) character: bool,
}
