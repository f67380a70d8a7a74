//! What can be typed of a clip and what is drawn on it: `marey track`, `segment`, `creature`.

use std::path::PathBuf;

use super::Plugins;

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
joint on other frames are corrections. points.json marks control points, each on one frame or more; `marey points` proposes
them.")]
#[command(group = clap::ArgGroup::new("marks").required(true).args(["strokes", "joints", "points"]))]
pub(crate) struct Track {
    /// A video file or a folder of numbered images
    #[arg(value_name = "CLIP")]
    pub(crate) clip: PathBuf,
    /// The drawn limbs (strokes.json)
    #[arg(long, value_name = "S.json")]
    pub(crate) strokes: Option<PathBuf>,
    /// The marked joints of a character (joints.json), in place of limbs
    #[arg(long, value_name = "J.json", conflicts_with_all = ["tracker", "plugin", "set"])]
    pub(crate) joints: Option<PathBuf>,
    /// The marked control points (points.json), in place of limbs
    #[arg(long, value_name = "P.json", conflicts_with_all = ["tracker", "plugin", "set"])]
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
  marey points bird.mp4 -o points.json
  marey track bird.mp4 --points points.json -o motion.json

The points lie on the ends of what moves, or is opaque, or stands before an even background, and where its limbs meet and
bend. Correct them as you like: move, remove and rename them, and mark them on more frames.")]
pub(crate) struct Points {
    /// A video file or a folder of numbered images
    #[arg(value_name = "CLIP")]
    pub(crate) clip: PathBuf,
    /// The frame to mark, from 0 [default: the one of a few that shows most ends]
    #[arg(long, value_name = "N")]
    pub(crate) frame: Option<u64>,
    /// How many points at most
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) most: u32,
    /// Where to write the points
    #[arg(short, long, value_name = "points.json")]
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
