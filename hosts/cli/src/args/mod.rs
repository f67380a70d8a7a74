//! What can be typed.

mod character;
mod clip;
pub(crate) mod motion;
mod plugin;
mod pose;
mod render;
mod session;
mod sketch;
mod solid;
pub(crate) mod surface;

use std::path::PathBuf;

use clap::{Parser, Subcommand};

pub(crate) use character::{Angles, Area, Carry, Character, Retarget, Rig, View};
pub(crate) use clip::{Creature, Points, Segment, Surface, Track};
pub(crate) use plugin::{PluginCheck, PluginCommand, PluginList, PluginNew, PluginProbe, Plugins};
pub(crate) use pose::{Lengths, Pose};
pub(crate) use render::{Adapter, Crowd, Look, Render, Style};
pub(crate) use session::{SessionCommand, SessionEmbed, SessionInfo, SessionReplay};
pub(crate) use sketch::{Bind, Laying, PathMotion, Sketch};
pub(crate) use solid::{Deform, Print};

use motion::MotionCommand;
use surface::{Edit, Texture};

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
    /// Propose points to follow on a frame of a clip
    Points(Points),
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

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey info horse.mp4 --json")]
pub(crate) struct Info {
    /// A video file or a folder of numbered images
    #[arg(value_name = "CLIP")]
    pub(crate) clip: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  marey demo -o camel\n  marey demo --character -o child\n  marey demo --sketch -o horse"
)]
pub(crate) struct Demo {
    /// The folder to write [default: marey-demo, marey-demo-character or marey-demo-sketch]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Move a bundled drawing by key poses instead
    #[arg(long, conflicts_with = "sketch")]
    pub(crate) character: bool,
    /// Let a bundled vector drawing gallop instead
    #[arg(long)]
    pub(crate) sketch: bool,
}
