//! What can be typed after `marey texture` and `marey edit`.

use std::ops::Range;
use std::path::PathBuf;

use clap::ArgGroup;

#[derive(Debug, clap::Args)]
#[command(
    group(ArgGroup::new("from").args(["clip", "like", "side", "material", "painted", "pictures"]).required(true)),
    after_help = "\
Examples:
  marey texture fox --pictures fox-skin                        the textures as PNG pictures, to paint on
  marey texture fox --painted fox-skin -o painted.glb          and back
  marey texture fox --clip fox.mp4 --frames 0,20 -o fox2.glb   colours of the first twenty frames only
  marey texture horse --like zebra/creature.glb -o zorse.glb   the look of another creature, limb by limb
  marey texture fox --side drawing.png -o fox3.glb             a picture of its side, as the clip shows it at rest
  marey texture fox --material felt.jpg --width 60 --limbs tail -o fox4.glb

A picture in the folder of --painted may be larger or smaller than the old texture; where it is clear, the old one stays."
)]
pub(crate) struct Texture {
    /// A creature.glb, or a creature's folder
    #[arg(value_name = "CREATURE")]
    pub(crate) creature: PathBuf,
    /// Take colours from the clip that the creature was made of
    #[arg(long, value_name = "CLIP")]
    pub(crate) clip: Option<PathBuf>,
    /// Pictures of the creature in that clip, bright where it is, a folder [default: masks in the creature's folder]
    #[arg(long, value_name = "DIR", requires = "clip")]
    pub(crate) masks: Option<PathBuf>,
    /// From the first to before the last of these frames of the clip [default: all]
    #[arg(long, value_name = "FIRST,END", requires = "clip", value_parser = frames)]
    pub(crate) frames: Option<Range<u64>>,
    /// Take colours from another creature, limb by limb of the same name
    #[arg(long, value_name = "CREATURE")]
    pub(crate) like: Option<PathBuf>,
    /// Stretch this picture of its side over it
    #[arg(long, value_name = "IMAGE")]
    pub(crate) side: Option<PathBuf>,
    /// Repeat this picture of a material over it
    #[arg(long, value_name = "IMAGE")]
    pub(crate) material: Option<PathBuf>,
    /// How wide one piece of the material is, in pixels of the clip [default: as many as the picture has]
    #[arg(long, value_name = "PIXELS", requires = "material", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) width: f32,
    /// Take the painted pictures in this folder, named as --pictures names them
    #[arg(long, value_name = "DIR", conflicts_with_all = ["limbs", "region", "soft"])]
    pub(crate) painted: Option<PathBuf>,
    /// Only these limbs
    #[arg(long, value_name = "LIMB,...", value_delimiter = ',')]
    pub(crate) limbs: Vec<String>,
    /// Only where this picture of the clip's size is bright, as the creature is seen at rest
    #[arg(long, value_name = "IMAGE")]
    pub(crate) region: Option<PathBuf>,
    /// Let the old and the new run into each other over so many pixels of the clip
    #[arg(long, value_name = "PIXELS", default_value_t = 0.0, hide_default_value = true)]
    pub(crate) soft: f32,
    /// Write the textures as PNG pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) pictures: Option<PathBuf>,
    /// The file to write
    #[arg(short, long, value_name = "OUT.glb", required_unless_present = "pictures")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  marey creature fox.mp4 --strokes s.json -o fox --obj
  (change fox/meshes/00012.obj in a modelling tool, and export it with the axes and the scale that it came with: Y up)
  marey edit fox --mesh changed.obj --frame 12 -o fox2.glb

With as many vertices as before each one carries its change along in every frame. A mesh of other vertices is bound anew
to what it lies on, and gets its colours from there.")]
pub(crate) struct Edit {
    /// A creature.glb, or a creature's folder
    #[arg(value_name = "CREATURE")]
    pub(crate) creature: PathBuf,
    /// The changed mesh
    #[arg(long, value_name = "MESH.obj")]
    pub(crate) mesh: PathBuf,
    /// The frame whose mesh it is
    #[arg(long, value_name = "N")]
    pub(crate) frame: u64,
    /// The file to write
    #[arg(short, long, value_name = "OUT.glb")]
    pub(crate) output: PathBuf,
}

fn frames(text: &str) -> Result<Range<u64>, String> {
    let range =
        text.split_once(',').and_then(|(first, end)| Some(first.trim().parse().ok()?..end.trim().parse().ok()?));
    range.filter(|r| !r.is_empty()).ok_or_else(|| "expected FIRST,END with an end beyond the first".into())
}
