//! What can be typed after `marey render` and `marey crowd`.

use std::path::PathBuf;

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
