//! What can be typed.

use std::path::PathBuf;

use clap::{Parser, Subcommand};

use crate::motion_args::MotionCommand;
use crate::surface_args::{Edit, Texture};

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
  marey print horse --frame 12 --base -o horse.stl      one frame for a 3D printer
  marey track horse.mp4 --strokes s.json -o m.json      only the limbs over time
  marey track walk.gif --joints j.json -o m.json        a character's joints over time
  marey sketch bird.svg --motion m.json -o bird.svg     a vector drawing that takes a motion
  marey render horse -o horse.gif --turntable           a creature from all sides
  marey texture horse --pictures skin                   its textures, to paint on
  marey motion loop horse/motion.json -o loop.json      a stride that repeats without a seam

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
    /// Follow drawn limbs, marked joints or marked points over all frames
    Track(Track),
    /// Cut the creature out of every frame
    Segment(Segment),
    /// Make the whole creature: limbs, masks, textured and animated model
    Creature(Creature),
    /// Draw a creature from any side: a picture, its animation, a turntable
    Render(Box<Render>),
    /// Draw many creatures, put them back into their clip, or write them as one glTF file
    Crowd(Box<Crowd>),
    /// Give a creature other textures, or take them out to paint on
    Texture(Box<Texture>),
    /// Take a mesh that was changed in a modelling tool back into a creature
    Edit(Edit),
    /// Make a frame of a creature a solid for a 3D printer
    Print(Print),
    /// Give a drawing a mesh and a skeleton
    Rig(Rig),
    /// Move a drawing by key poses or by a motion
    Character(Box<Character>),
    /// Carry a motion over to the joints of a drawing
    Retarget(Retarget),
    /// Loop, smooth, steady or retime a motion, or put it on a creature
    #[command(subcommand)]
    Motion(MotionCommand),
    /// Pose a creature by strokes, or move it by any motion
    Pose(Box<Pose>),
    /// Lay what moves on a vector drawing
    Bind(Box<Bind>),
    /// Move a vector drawing by a motion
    Sketch(Box<Sketch>),
    /// Make a motion of drawn paths, without a clip
    Path(PathMotion),
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
  marey track bird.mp4 --points points.json -o motion.json

joints.json marks each joint as a small rectangle on one frame, and names the bones between them; more rectangles of a
joint on other frames are corrections. points.json marks control points, each on one frame or more.")]
pub(crate) struct Track {
    /// A video file or a folder of numbered images
    #[arg(value_name = "CLIP")]
    pub(crate) clip: PathBuf,
    /// The drawn limbs (strokes.json)
    #[arg(long, value_name = "S.json", required_unless_present_any = ["joints", "points"])]
    pub(crate) strokes: Option<PathBuf>,
    /// The marked joints of a character (joints.json), in place of limbs
    #[arg(long, value_name = "J.json", conflicts_with_all = ["strokes", "tracker", "plugin", "set"])]
    pub(crate) joints: Option<PathBuf>,
    /// The marked control points (points.json), in place of limbs
    #[arg(long, value_name = "P.json", conflicts_with_all = ["strokes", "joints", "tracker", "plugin", "set"])]
    pub(crate) points: Option<PathBuf>,
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
    /// How deep a limb is toward the viewer for its width; may be repeated
    #[arg(long, value_name = "LIMB=RATIO")]
    pub(crate) depth: Vec<String>,
    /// How far limbs of a pair stand apart, times what is usual [default: 1]
    #[arg(long, value_name = "F", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) spread: f32,
    /// What covers the limbs
    #[arg(long, value_enum, default_value = "skin")]
    pub(crate) surface: Surface,
}

/// What covers a creature's limbs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Surface {
    /// One connected skin over all limbs
    Skin,
    /// A closed tube around each limb, with a texture each
    Tubes,
}

/// What of a creature is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Style {
    /// The texture's colours as they are
    Textured,
    /// The texture under a lamp
    Shaded,
    /// The edges of the triangles
    Wireframe,
    /// How far the surface is from its bones
    Radius,
    /// Which bones move the surface, and the bones
    Bones,
    /// How near it is
    Depth,
    /// Where the surface faces
    Normals,
}

/// Who draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Adapter {
    /// A GPU where there is one, else the CPU
    Auto,
    /// A GPU, or one that a driver simulates
    Gpu,
    /// The CPU
    Cpu,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey render fox -o fox.mp4 --background white
  marey render fox -o fox.png --frame 12 --view 30,15 --style shaded --shadow 0.4
  marey render fox/creature.glb -o turn.gif --turntable --size 480x360
  marey render fox -o frames --view clip

OUT's ending says the format: png (one picture with --frame, else animated), gif, apng, webp, mp4, no ending for a folder of
PNG pictures. --format names any of png, png-dir, sprite-sheet, gif, apng, webp, mp4. --frame shows that frame alone; with
--turntable the camera goes once around it. The view \"clip\" is the clip's own camera: at the clip's size every picture lies
on its frame pixel by pixel.")]
pub(crate) struct Render {
    /// A creature's folder, or its creature.glb
    #[arg(value_name = "CREATURE")]
    pub(crate) creature: PathBuf,
    #[command(flatten)]
    pub(crate) look: Look,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey crowd fox --count 9 -o herd.mp4 --view 20,20 --background white --shadow 0.4
  marey crowd fox --count 5 --into fox.mp4 -o many.mp4
  marey crowd foxes.json -o foxes.glb

CROWD is a creature (its folder or creature.glb), which stands in rows, out of step, or a file that says who stands where:
  {\"format\": \"marey-crowd\", \"version\": 1, \"creatures\": [\"fox\"], \"frames\": 60, \"instances\": [
    {\"creature\": 0, \"at\": [0, 0, 0]},
    {\"creature\": 0, \"at\": [150, 0, -120], \"yaw\": 180, \"scale\": 0.8, \"start\": 12, \"speed\": 1.2, \"loop\": true}]}
Places are in pixels of the clip, moved from where the creature was filmed: x right, y up, z toward the viewer. OUT's ending
says the format: glb for one file with all of it, else as for marey render. --into puts the crowd back into the clip: who has
a z below 0 is hidden by the creature that was filmed, by the masks in its folder or in --masks.")]
pub(crate) struct Crowd {
    /// A creature, or a file that says who stands where
    #[arg(value_name = "CROWD")]
    pub(crate) crowd: PathBuf,
    /// How many of the creature
    #[arg(long, value_name = "N")]
    pub(crate) count: Option<u32>,
    /// Put it back into this clip
    #[arg(long, value_name = "CLIP")]
    pub(crate) into: Option<PathBuf>,
    /// Pictures of who was filmed, bright where it is, a folder [default: masks in the creature's folder]
    #[arg(long, value_name = "DIR", requires = "into")]
    pub(crate) masks: Option<PathBuf>,
    /// With --into: draw the crowd alone, on nothing, with what hides it cut out
    #[arg(long, requires = "into")]
    pub(crate) alone: bool,
    /// With .glb: metres a pixel of the clip
    #[arg(long, value_name = "M", default_value_t = 1.0)]
    pub(crate) scale: f32,
    #[command(flatten)]
    pub(crate) look: Look,
}

/// How creatures are looked at, and into which file.
#[derive(Debug, clap::Args)]
pub(crate) struct Look {
    /// The file or folder to write
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// The format, where OUT's ending does not say it
    #[arg(long, value_name = "NAME")]
    pub(crate) format: Option<String>,
    /// From where: degrees to the right and from above, or "clip" [default: clip, or 0,15 with --turntable]
    #[arg(long, value_name = "YAW,PITCH", allow_hyphen_values = true)]
    pub(crate) view: Option<String>,
    /// Degrees between the bottom and the top of the picture; 0 to look in parallel
    #[arg(long, value_name = "DEGREES", default_value_t = 30.0)]
    pub(crate) fov: f32,
    /// Look at this place of the creature's world, rather than at its middle
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "distance")]
    pub(crate) target: Option<String>,
    /// World units (pixels of the clip) from the eye to the target, or with --fov 0 as high as the picture
    #[arg(long, value_name = "UNITS", requires = "target")]
    pub(crate) distance: Option<f32>,
    /// The camera goes once around
    #[arg(long)]
    pub(crate) turntable: bool,
    /// How often it goes around, to the left below 0
    #[arg(long, value_name = "N", allow_negative_numbers = true, conflicts_with = "turntable")]
    pub(crate) turns: Option<f32>,
    /// Pixels across and down [default: the clip's]
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<String>,
    /// Show this frame alone
    #[arg(long, value_name = "N")]
    pub(crate) frame: Option<u64>,
    /// How many pictures [default: as the animation has; a turntable of one frame takes 72]
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u64>,
    /// Pictures a second [default: the creature's]
    #[arg(long, value_name = "F")]
    pub(crate) fps: Option<f64>,
    /// What is shown
    #[arg(long, value_enum, default_value_t = Style::Textured)]
    pub(crate) style: Style,
    /// What lies behind: #rrggbb, #rrggbbaa, none, white, black
    #[arg(long, value_name = "COLOR", default_value = "none")]
    pub(crate) background: String,
    /// How dark the shadow on the floor is, 0 for none to 1
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    pub(crate) shadow: f32,
    /// Do not smooth edges
    #[arg(long)]
    pub(crate) hard_edges: bool,
    /// Who draws
    #[arg(long, value_enum, default_value_t = Adapter::Auto)]
    pub(crate) adapter: Adapter,
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

/// Whether a creature's bones keep their lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Lengths {
    /// Strokes only show directions.
    Kept,
    /// Limbs are as long as their strokes, within the stretch.
    Drawn,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey pose out/creature.glb --poses poses.json -o reared.glb
  marey pose horse/creature.glb --motion fox/motion.json -o horse-as-fox.glb
  marey pose horse/creature.glb --motion walk.bvh --map map.json -o walk.glb

POSES.json is a strokes.json whose key frames are the poses, with \"easing\" (linear, in, out, inout, hold) on a key frame.
MAP.json says which limb follows what: {\"limbs\": {\"hind_near\": {\"tracks\": [\"hip\", \"knee\", \"foot\"]}}}.")]
pub(crate) struct Pose {
    /// A creature.glb, or a creature's folder
    #[arg(value_name = "CREATURE")]
    pub(crate) creature: PathBuf,
    /// Key poses
    #[arg(long, value_name = "POSES.json", conflicts_with = "motion", required_unless_present = "motion")]
    pub(crate) poses: Option<PathBuf>,
    /// A motion of anything: motion.json, or a BVH file
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<PathBuf>,
    /// Which limb follows what; without it names decide
    #[arg(long, value_name = "MAP.json", requires = "motion")]
    pub(crate) map: Option<PathBuf>,
    /// Write the map that was used, to correct it and give it back
    #[arg(long, value_name = "MAP.json", requires = "motion")]
    pub(crate) keep_map: Option<PathBuf>,
    /// The file to write
    #[arg(short, long, value_name = "OUT.glb")]
    pub(crate) output: PathBuf,
    /// Frames a second [default: as the poses say, or the creature's]
    #[arg(long, value_name = "F", requires = "poses")]
    pub(crate) fps: Option<f64>,
    /// How many frames to make [default: up to the last key]
    #[arg(long, value_name = "N", requires = "poses", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) frames: Option<u64>,
    /// Whether bones keep their lengths [default: drawn for poses, kept for motions]
    #[arg(long, value_enum)]
    pub(crate) lengths: Option<Lengths>,
    /// A limb gets at most this many times its length [default: 1.25]
    #[arg(long, value_name = "F", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) stretch: f32,
    /// What the way of the whole creature is scaled by; 0 to stay in place [default: by the limbs' lengths]
    #[arg(long, value_name = "F", allow_negative_numbers = true, requires = "motion")]
    pub(crate) root_scale: Option<f32>,
    /// Turn a motion that runs the other way
    #[arg(long, requires = "motion")]
    pub(crate) mirror: bool,
    /// Whether limbs turn as the motion's do from their own mean pose, or point where they do [default: absolute for a
    /// motion of the same body]
    #[arg(long, value_enum, requires = "motion")]
    pub(crate) angles: Option<Angles>,
    /// From where a BVH file is seen
    #[arg(long, value_enum, default_value_t = View::Front)]
    pub(crate) view: View,
}

/// What says where a motion holds a drawing.
#[derive(Debug, clap::Args)]
pub(crate) struct Laying {
    /// The clip that the motion was tracked in, for the outline of what moves
    #[arg(long, value_name = "CLIP")]
    pub(crate) clip: Option<PathBuf>,
    /// The motion was drawn on the drawing: its points hold it where they are in the first frame
    #[arg(long, conflicts_with_all = ["clip", "frame", "mirror"])]
    pub(crate) as_drawn: bool,
    /// The frame of the motion that the drawing is like [default: chosen]
    #[arg(long, value_name = "N")]
    pub(crate) frame: Option<u64>,
    /// Whether the drawing faces the other way than what moves: true or false [default: what fits better]
    #[arg(long, value_name = "BOOL")]
    pub(crate) mirror: Option<bool>,
    /// How much the motion moves the drawing, against the figures' sizes
    #[arg(long, value_name = "F", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) motion_scale: f32,
    /// How far the motion is turned, in degrees, clockwise
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pub(crate) motion_rotation: Option<f32>,
    /// How much of the motion's way over the picture is kept: 1 all, 0 to move on the spot
    #[arg(long, value_name = "F")]
    pub(crate) travel: Option<f32>,
    /// Keep a stroke's shape so much more than by default, 1 to 1000
    #[arg(long, value_name = "STROKE=R")]
    pub(crate) rigidity: Vec<String>,
    /// Strokes that stand still, whatever moves
    #[arg(long, value_name = "STROKE,...", value_delimiter = ',')]
    pub(crate) decoration: Vec<String>,
    /// Places of the drawing that stay where they are
    #[arg(long, value_name = "X,Y")]
    pub(crate) pin: Vec<String>,
    /// Strokes that make a layer of their own, in front of those before
    #[arg(long, value_name = "NAME=STROKE,...")]
    pub(crate) layer: Vec<String>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  marey bind cat.svg --motion walk.json --clip dog.mp4 -o bind.json --preview bind.png

What moves in the clip and the drawing are laid on each other by their outlines; bind.json says where each tracked point
holds the drawing, and is yours to correct. Without a clip the motion's points alone say how large it is.")]
pub(crate) struct Bind {
    /// The drawing
    #[arg(value_name = "DRAWING.svg")]
    pub(crate) drawing: PathBuf,
    /// The motion
    #[arg(long, value_name = "MOTION.json")]
    pub(crate) motion: PathBuf,
    #[command(flatten)]
    pub(crate) laying: Laying,
    /// Where to write the binding
    #[arg(short, long, value_name = "BIND.json")]
    pub(crate) output: PathBuf,
    /// Also draw the drawing with the places that are held
    #[arg(long, value_name = "PREVIEW.png")]
    pub(crate) preview: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey sketch cat.svg --motion walk.json --clip dog.mp4 -o cat.json
  marey sketch cat.svg --motion walk.json --bind bind.json -o cat.gif --background white
  marey sketch bird.svg fish.svg --motion kite.json -o moving/ --format lottie

OUT's ending says the format: svg, json (Lottie), gif, apng, webp, mp4, no ending for a folder of PNG pictures. --format
names any of svg, lottie, png-dir, sprite-sheet, gif, apng, webp, mp4, mp4-alpha. Several drawings are written into the
folder OUT, each under its own name. Several motions on one drawing need a binding that says which point is whose.")]
pub(crate) struct Sketch {
    /// The drawing, or several
    #[arg(value_name = "DRAWING.svg", required = true)]
    pub(crate) drawings: Vec<PathBuf>,
    /// The motion; several in the binding's order
    #[arg(long, value_name = "MOTION.json", required = true)]
    pub(crate) motion: Vec<PathBuf>,
    /// Where the motion holds the drawing, as `marey bind` writes it [default: by likeness]
    #[arg(long, value_name = "BIND.json", conflicts_with_all = ["clip", "frame", "mirror", "as_drawn"])]
    pub(crate) bind: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) laying: Laying,
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
    /// Show the drawing's page, rather than all of every frame
    #[arg(long)]
    pub(crate) no_grow: bool,
    /// Also write the binding that was used, to correct it
    #[arg(long, value_name = "BIND.json")]
    pub(crate) keep_bind: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey print horse --frame 12 --base -o horse.stl
  marey print horse/creature.glb --frame 12 --height 60 --min-thickness 1.2 -o horse.3mf

The result is one closed surface in millimetres, whatever the creature, and stands upright on the bed: no repair is
needed. STL is the form alone; 3MF has units and colours.")]
pub(crate) struct Print {
    /// A creature.glb, or the folder of a creature
    #[arg(value_name = "CREATURE")]
    pub(crate) creature: PathBuf,
    /// Which frame
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) frame: u64,
    /// The file to write, .stl or .3mf
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// The longest side, in mm, before thin parts and a base make it larger
    #[arg(long, value_name = "MM", default_value_t = 100.0)]
    pub(crate) size: f32,
    /// The height instead, in mm
    #[arg(long, value_name = "MM", conflicts_with = "size")]
    pub(crate) height: Option<f32>,
    /// Millimetres a world unit instead: frames of one creature keep their relative size
    #[arg(long, value_name = "MM", conflicts_with_all = ["size", "height"])]
    pub(crate) mm_per_unit: Option<f32>,
    /// Make thinner parts so thick, in mm; 0 leaves them as they are
    #[arg(long, value_name = "MM", default_value_t = 1.0)]
    pub(crate) min_thickness: f32,
    /// The smallest detail, in mm [default: by size and thickness]
    #[arg(long, value_name = "MM")]
    pub(crate) detail: Option<f32>,
    /// Put a plate under the feet and join all of them to it
    #[arg(long)]
    pub(crate) base: bool,
    /// At most so many triangles [default: as many as the detail takes]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..))]
    pub(crate) max_triangles: Option<u32>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  marey path paths.json -o motion.json

PATHS.json: {\"format\": \"marey-paths\", \"version\": 1, \"size\": [W, H], \"fps\": 24, \"seconds\": 2, \"points\": [{\"name\": \"tip\",
\"path\": \"M10 20 C ...\", \"turns\": 1, \"phase\": 0, \"rhythm\": \"swing\"}]}, with SVG path data. Around a closed path a point goes
evenly, along an open one there and back.")]
pub(crate) struct PathMotion {
    /// The paths
    #[arg(value_name = "PATHS.json")]
    pub(crate) paths: PathBuf,
    /// Where to write the motion
    #[arg(short, long, value_name = "motion.json")]
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
#[command(
    after_help = "Examples:\n  marey demo -o camel\n  marey demo --character -o child\n  marey demo --sketch -o horse"
)]
pub(crate) struct Demo {
    /// The folder to write
    #[arg(short, long, value_name = "DIR", default_value = "marey-demo")]
    pub(crate) output: PathBuf,
    /// Move a bundled drawing by key poses instead
    #[arg(long, conflicts_with = "sketch")]
    pub(crate) character: bool,
    /// Let a bundled vector drawing gallop instead
    #[arg(long)]
    pub(crate) sketch: bool,
}
