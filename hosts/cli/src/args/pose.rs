//! What can be typed after `marey pose`.

use std::path::PathBuf;

use super::{Angles, View};

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
