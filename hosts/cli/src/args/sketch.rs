//! What can be typed after `marey bind`, `sketch` and `path`.

use std::path::PathBuf;

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
