//! What can be typed after `marey motion`.

use std::path::PathBuf;

use crate::args::{Angles, View};

#[derive(Debug, clap::Subcommand)]
pub(crate) enum MotionCommand {
    /// Say after how many frames a motion does the same again, and which limb is when
    Cycle(Cycle),
    /// Close a stride into a loop without a visible seam
    Loop(Loop),
    /// Take the jitter out, and keep the key frames
    Smooth(Smooth),
    /// Keep feet where they come down
    Plant(Plant),
    /// Make it faster, longer, backwards, on twos, or time it by keys
    Retime(Retime),
    /// Put it on the limbs of a creature
    Map(Map),
}

/// A motion in, and one out.
#[derive(Debug, clap::Args)]
pub(crate) struct Through {
    /// The motion: motion.json, or a BVH file
    #[arg(value_name = "MOTION")]
    pub(crate) motion: PathBuf,
    /// Where to write it: .json, or .bvh for joints
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// From where a BVH file is seen
    #[arg(long, value_enum, default_value_t = View::Side)]
    pub(crate) view: View,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey motion cycle horse/motion.json")]
pub(crate) struct Cycle {
    /// The motion: motion.json, or a BVH file
    #[arg(value_name = "MOTION")]
    pub(crate) motion: PathBuf,
    /// From where a BVH file is seen
    #[arg(long, value_enum, default_value_t = View::Side)]
    pub(crate) view: View,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey motion loop horse/motion.json -o loop.json
  marey motion loop horse/motion.json -o loop.json --keep-travel --fps 30
  marey motion loop cow/motion.json -o loop.json --start 30 --period 66

The loop's first frame comes after its last. What its ends differ by is taken up over the whole of it.")]
pub(crate) struct Loop {
    #[command(flatten)]
    pub(crate) through: Through,
    /// The frame it begins at, with --period [default: found]
    #[arg(long, value_name = "FRAME", requires = "period")]
    pub(crate) start: Option<f64>,
    /// Frames until it begins again [default: found]
    #[arg(long, value_name = "FRAMES")]
    pub(crate) period: Option<f64>,
    /// Cycles in the loop
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "period", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) cycles: u32,
    /// Keep the way of the whole, rather than stay in place
    #[arg(long)]
    pub(crate) keep_travel: bool,
    /// Frames of the loop [default: what keeps the pace]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub(crate) frames: u64,
    /// Frames a second [default: the motion's]
    #[arg(long, value_name = "FPS", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) fps: f64,
    /// The share of the loop over which its ends are faded [default: 0.25]
    #[arg(long, value_name = "SHARE")]
    pub(crate) fade: Option<f64>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey motion smooth horse/motion.json -o smooth.json --period 6")]
pub(crate) struct Smooth {
    #[command(flatten)]
    pub(crate) through: Through,
    /// Swings of so many frames are halved, shorter ones vanish: 2 to 200
    #[arg(long, value_name = "FRAMES", default_value_t = 5.0)]
    pub(crate) period: f64,
    /// Frames that stay as they are [default: key frames]
    #[arg(long, value_name = "FRAME,...", value_delimiter = ',', conflicts_with = "hold_none")]
    pub(crate) hold: Option<Vec<u64>>,
    /// No frame stays as it is
    #[arg(long)]
    pub(crate) hold_none: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey motion plant loop.json -o planted.json --closed
  marey motion plant walk.bvh -o planted.bvh --feet LeftFoot,RightFoot --still

A foot is down while it is low and goes with the ground, which is measured: it goes where the camera follows.")]
pub(crate) struct Plant {
    #[command(flatten)]
    pub(crate) through: Through,
    /// Limbs, or joints, that end in feet [default: found]
    #[arg(long, value_name = "TRACK,...", value_delimiter = ',')]
    pub(crate) feet: Vec<String>,
    /// Where the ground is, in pixels from the top [default: where feet come down]
    #[arg(long, value_name = "Y", allow_negative_numbers = true)]
    pub(crate) ground: Option<f64>,
    /// The ground stands still in the picture
    #[arg(long)]
    pub(crate) still: bool,
    /// Frames over which a foot is let go [default: 4]
    #[arg(long, value_name = "FRAMES", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) ease: f64,
    /// The motion is a loop in place
    #[arg(long)]
    pub(crate) closed: bool,
}

/// How time passes; the numbers are the library's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Easing {
    Linear = 0,
    In = 1,
    Out = 2,
    InOut = 3,
    Hold = 4,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey motion retime loop.json -o slow.json --speed 0.5 --closed
  marey motion retime walk.json -o walk2.json --seconds 3 --easing in-out
  marey motion retime walk.json -o twos.json --hold 2
  marey motion retime walk.json -o cut.json --key 0=0 --key 24=30:in-out --key 48=47")]
pub(crate) struct Retime {
    #[command(flatten)]
    pub(crate) through: Through,
    /// How many times as fast
    #[arg(long, value_name = "F", default_value_t = 1.0, conflicts_with = "seconds")]
    pub(crate) speed: f64,
    /// Seconds in all
    #[arg(long, value_name = "S", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) seconds: f64,
    /// Frames a second, in the same time [default: the motion's]
    #[arg(long, value_name = "FPS", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) fps: f64,
    /// How time passes over the whole
    #[arg(long, value_enum, default_value_t = Easing::Linear)]
    pub(crate) easing: Easing,
    /// From its end to its beginning
    #[arg(long)]
    pub(crate) backward: bool,
    /// To its end and back
    #[arg(long, conflicts_with = "backward")]
    pub(crate) there_and_back: bool,
    /// Frames that each picture stands: 2 for on twos
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) hold: u32,
    /// At frame AT of the result comes FRAME, with an easing from there; may be repeated
    #[arg(long, value_name = "AT=FRAME[:EASING]", conflicts_with_all = ["speed", "seconds"])]
    pub(crate) key: Vec<String>,
    /// Speed changes without jumps from key to key
    #[arg(long, requires = "key")]
    pub(crate) smooth: bool,
    /// The motion is a loop, and stays one
    #[arg(long)]
    pub(crate) closed: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  marey motion map fox/motion.json --onto horse/motion.json -o horse-walks.json
  marey motion map walk.bvh --onto horse/motion.json -o horse-walks.json --keep-map map.json
  marey motion map walk.bvh --onto horse/motion.json -o horse-walks.json --map map.json

MAP.json: {\"limbs\": {\"fore_near\": {\"tracks\": [\"LeftArm\", \"LeftForeArm\", \"LeftHand\"]}, ...}}: each limb follows a stroke, or
joints in a row. The creature keeps its lengths and its bearing.")]
pub(crate) struct Map {
    #[command(flatten)]
    pub(crate) through: Through,
    /// The creature's own motion, whose strokes are its limbs
    #[arg(long, value_name = "MOTION.json")]
    pub(crate) onto: PathBuf,
    /// Which limb follows what [default: by names and likeness]
    #[arg(long, value_name = "MAP.json")]
    pub(crate) map: Option<PathBuf>,
    /// Write the map that was used, to correct it and give it back
    #[arg(long, value_name = "MAP.json")]
    pub(crate) keep_map: Option<PathBuf>,
    /// Whether limbs turn as the motion's do, or point where they do
    #[arg(long, value_enum, default_value_t = Angles::Relative)]
    pub(crate) angles: Angles,
    /// Whether the creature faces the other way: true or false [default: what fits]
    #[arg(long, value_name = "BOOL")]
    pub(crate) mirror: Option<bool>,
    /// The frame of the motion that the creature at rest corresponds to [default: its mean pose]
    #[arg(long, value_name = "N")]
    pub(crate) reference: Option<u64>,
    /// The frame of the creature's motion in which it is at rest [default: its mean pose]
    #[arg(long, value_name = "N")]
    pub(crate) rest: Option<u64>,
    /// Limbs change their length up to this factor
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub(crate) stretch: f64,
    /// What the way of the whole is scaled by; 0 to stay in place [default: by the figures' sizes]
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    pub(crate) travel: Option<f64>,
}
