//! A character's take as a file: which formats there are, and what they share.

use std::path::{Path, PathBuf};

use image::RgbaImage;

use super::animation::{self, Animation, AnimationFormat};
use super::format_name;
use super::scene::{character_gltf, dragonbones, lottie, spine};
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::shape::character::{Canvas, Character, Drawing, Take, cut_out};

/// What a take can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TakeFormat {
    /// A folder of PNG pictures, 00000.png and so on.
    PngFolder,
    /// One PNG of all frames and a JSON file that says where each is.
    SpriteSheet,
    /// An animated GIF, whose pixels are clear or opaque.
    Gif,
    /// An animated PNG.
    Apng,
    /// An animated WebP, lossless.
    WebP,
    /// H.264 in mp4, on a background.
    Mp4,
    /// Binary glTF: a skinned or morphing mesh.
    Glb,
    /// Lottie.
    Lottie,
    /// The JSON of Spine, its atlas and its picture.
    Spine,
    /// The JSON of DragonBones, its atlas and its picture.
    DragonBones,
}

impl TakeFormat {
    /// All of them with their names.
    pub const ALL: [(Self, &'static str); 10] = [
        (Self::PngFolder, "png-dir"),
        (Self::SpriteSheet, "sprite-sheet"),
        (Self::Gif, "gif"),
        (Self::Apng, "apng"),
        (Self::WebP, "webp"),
        (Self::Mp4, "mp4"),
        (Self::Glb, "glb"),
        (Self::Lottie, "lottie"),
        (Self::Spine, "spine"),
        (Self::DragonBones, "dragonbones"),
    ];

    /// The format called `name`, or else the one that the path's ending stands for: `.json` is Lottie, `.png` an animated
    /// PNG, no ending a folder of pictures.
    ///
    /// # Errors
    /// A name or an ending that is not known.
    pub fn choose(name: Option<&str>, path: &Path) -> Result<Self> {
        format_name::choose(&Self::ALL, name, path)
    }
}

/// What is written: a character, its picture and what it does.
#[derive(Clone, Copy, Debug)]
pub struct TakeSubject<'a> {
    /// A name for what is inside the file.
    pub name: &'a str,
    /// The character.
    pub character: &'a Character,
    /// Its picture, of the character's size.
    pub picture: &'a RgbaImage,
    /// What it does.
    pub take: &'a Take,
}

/// How it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TakeOptions {
    /// Pictures show all of every frame, however far it leaves the character's picture; else they are cut to that.
    pub grow: bool,
    /// Pixels a pixel of the character's picture.
    pub scale: f32,
    /// What lies behind, straight alpha. Formats without alpha show it over white.
    pub background: [u8; 4],
}

impl Default for TakeOptions {
    fn default() -> Self {
        Self { grow: true, scale: 1.0, background: [0; 4] }
    }
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TakeFiles {
    /// The files; of a folder of pictures, the folder.
    pub files: Vec<PathBuf>,
    /// Left, top, width and height of what pictures show, in pixels of the character's picture.
    pub shown: [i32; 4],
    /// How many frames there are.
    pub frames: usize,
}

/// Writes a take.
///
/// # Errors
/// A take without frames or of another character, a picture of another size, what a format cannot hold, a file that
/// cannot be written, a cancel. What was there before then stays as it was.
pub fn write_take(
    path: &Path,
    format: TakeFormat,
    subject: TakeSubject<'_>,
    options: &TakeOptions,
    stage: Stage<'_>,
) -> Result<TakeFiles> {
    let TakeSubject { name, character, picture, take } = subject;
    check(subject, options)?;
    stage.name("cutting out")?;
    let cut = cut_out(picture)?;
    let subject = TakeSubject { picture: &cut, ..subject };
    let stage = stage.part(0.05, 1.0);
    let pictures = match format {
        TakeFormat::Glb => return character_gltf::write(path, subject, options, stage),
        TakeFormat::Spine => return spine::write(path, subject, options, stage),
        TakeFormat::DragonBones => return dragonbones::write(path, subject, options, stage),
        TakeFormat::Lottie => None,
        TakeFormat::PngFolder => Some(AnimationFormat::PngFolder),
        TakeFormat::SpriteSheet => Some(AnimationFormat::SpriteSheet),
        TakeFormat::Gif => Some(AnimationFormat::Gif),
        TakeFormat::Apng => Some(AnimationFormat::Apng),
        TakeFormat::WebP => Some(AnimationFormat::WebP),
        TakeFormat::Mp4 => Some(AnimationFormat::Mp4),
    };
    let canvas = Canvas::new(character, take, options.scale, options.grow)?;
    let drawing = Drawing::new(character, &cut, options.scale)?;
    let draw = |frame: usize| Ok(drawing.draw(&take.frames[frame], &canvas, options.background));
    let Some(format) = pictures else {
        return lottie::write(path, subject, options, canvas.shown(), &mut { draw }, stage);
    };
    let root = character.skeleton.roots().first().map_or(glam::Vec2::ZERO, |j| character.skeleton.joints[*j].at);
    let size = glam::vec2(canvas.size.0 as f32, canvas.size.1 as f32);
    let animation = Animation {
        name,
        frames: take.frames.len(),
        fps: take.fps,
        size: canvas.size,
        pivot: (canvas.place(root) / size).to_array(),
        draw: &draw,
    };
    let files = animation::write(path, format, &animation, stage)?;
    Ok(TakeFiles { files, shown: canvas.shown(), frames: take.frames.len() })
}

/// Whether a character, its picture and a take belong together and can be written.
pub(super) fn check(subject: TakeSubject<'_>, options: &TakeOptions) -> Result<()> {
    let TakeSubject { character, picture, take, .. } = subject;
    if picture.dimensions() != character.size {
        let ((w, h), (width, height)) = (picture.dimensions(), character.size);
        let problem = format!("is {w}x{h} pixels and the character's was {width}x{height}");
        return Err(Error::invalid("picture", problem, "give the picture that the character was made from"));
    }
    if take.frames.is_empty() {
        return Err(Error::invalid("take", "has no frames", "add a key pose, or take a longer motion"));
    }
    if !(take.fps.is_finite() && take.fps > 0.0) {
        return Err(Error::invalid("take", format!("has {} frames a second", take.fps), "give a rate above 0"));
    }
    if !(options.scale.is_finite() && options.scale > 0.0) {
        return Err(Error::invalid("scale", format!("is {}", options.scale), "give a number above 0"));
    }
    let (vertices, joints) = (character.mesh.points.len(), character.skeleton.joints.len());
    for (f, frame) in take.frames.iter().enumerate() {
        let what = || format!("frame {f} of the take");
        let counts = [
            ("vertices", frame.points.len(), vertices),
            ("joints", frame.joints.len(), joints),
            ("depths", frame.depths.len(), character.skeleton.bones.len()),
        ];
        if let Some((of, own, wanted)) = counts.into_iter().find(|(_, own, wanted)| own != wanted) {
            let problem = format!("has {own} {of} and the character needs {wanted}");
            return Err(Error::invalid(what(), problem, "give a take of this character"));
        }
        if frame.points.iter().chain(&frame.joints).any(|p| !p.is_finite()) {
            return Err(Error::invalid(what(), "has a place that is not a number", "check the motion"));
        }
    }
    Ok(())
}
