//! A character's take as a file: which formats there are, and what they share.

use std::path::{Path, PathBuf};

use image::RgbaImage;

use crate::error::{Error, Result};
use crate::job::Stage;
use crate::shape::character::{Character, Take};

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
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let wanted = match (name, extension.as_deref()) {
            (Some(name), _) => name,
            (None, Some("json")) => "lottie",
            (None, Some("png")) => "apng",
            (None, Some(ending)) => ending,
            (None, None) => "png-dir",
        };
        Self::ALL.iter().find(|f| f.1 == wanted).map(|f| f.0).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|f| f.1).collect();
            Error::invalid("format", format!("`{wanted}` is not known"), format!("choose one of {}", names.join(", ")))
        })
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
    let _ = (subject, options, stage);
    Err(Error::invalid(format!("{}", path.display()), format!("{format:?} is not written"), "choose another format"))
}
