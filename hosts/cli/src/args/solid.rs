//! What can be typed after `marey print` and `marey deform`.

use std::path::PathBuf;

use super::Plugins;

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
