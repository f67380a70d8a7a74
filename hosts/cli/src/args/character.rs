//! What can be typed after `marey rig`, `character` and `retarget`.

use std::path::PathBuf;

use super::Plugins;

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
