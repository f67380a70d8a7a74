//! A sketch's take as a file: which formats there are, and what they share.

use std::path::{Path, PathBuf};

use image::{RgbaImage, imageops};

use super::animation::{self, Animation, AnimationFormat, RATES};
use super::vector::animated_svg::{self, SvgOptions};
use super::vector::{curve, lottie};
use super::{format_name, write_aside};
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::shape::sketch::{Drawing, SketchCanvas, SketchTake, draw_sketch};

/// How far a coordinate of an animated SVG may be off, in pixels of the picture, where nothing else is asked for.
pub const SVG_TOLERANCE: f64 = 0.1;
/// What a sketch's take can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SketchFormat {
    /// SVG that moves by itself, without scripts.
    Svg,
    /// Lottie, with the deformation in its paths.
    Lottie,
    /// An animated GIF, whose pixels are clear or opaque.
    Gif,
    /// An animated PNG.
    Apng,
    /// An animated WebP, lossless.
    WebP,
    /// H.264 in mp4, on a background.
    Mp4,
    /// H.264 in mp4, colours in the upper half and opacity in the lower: see [`Self::ALL`].
    Mp4Alpha,
    /// A folder of PNG pictures, 00000.png and so on.
    PngFolder,
    /// PNG pictures with all frames on them, and JSON files that say where each is.
    SpriteSheet,
}

impl SketchFormat {
    /// All of them with their names.
    ///
    /// H.264 has no opacity. What web players and game engines do instead ("stacked alpha") is `mp4-alpha`: a picture twice
    /// as high, the straight colours above, the opacity as grey below, put together by a shader of a few lines. Elsewhere
    /// APNG and WebP keep opacity.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::Svg, "svg"),
        (Self::Lottie, "lottie"),
        (Self::Gif, "gif"),
        (Self::Apng, "apng"),
        (Self::WebP, "webp"),
        (Self::Mp4, "mp4"),
        (Self::Mp4Alpha, "mp4-alpha"),
        (Self::PngFolder, "png-dir"),
        (Self::SpriteSheet, "sprite-sheet"),
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

/// What is written: a drawing and what it does.
#[derive(Clone, Copy, Debug)]
pub struct SketchSubject<'a> {
    /// A name for what is inside the file.
    pub name: &'a str,
    /// The drawing.
    pub drawing: &'a Drawing,
    /// What it does.
    pub take: &'a SketchTake,
}

/// How it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SketchOptions {
    /// All of every frame is shown, however far it leaves the page; else it is cut to that.
    pub grow: bool,
    /// Pixels of the picture a pixel of the page.
    pub scale: f64,
    /// What lies behind, straight alpha. Formats without alpha show it over white.
    pub background: [u8; 4],
    /// Whether an animated SVG begins again when it ends. Pictures that move always do; of Lottie and video the player says.
    pub repeat: bool,
    /// How far a coordinate of SVG and Lottie may be off in any frame, in pixels of the picture: files grow as it shrinks.
    /// `None` for [`SVG_TOLERANCE`]; in Lottie for a quarter of a pixel, up to a whole one where it would be large.
    pub tolerance: Option<f64>,
}

impl Default for SketchOptions {
    fn default() -> Self {
        Self { grow: true, scale: 1.0, background: [0; 4], repeat: true, tolerance: None }
    }
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SketchFiles {
    /// The files; of a folder of pictures, the folder.
    pub files: Vec<PathBuf>,
    /// Left, top, width and height of what is shown, in the page's pixels.
    pub shown: [f64; 4],
    /// Width and height of the pictures.
    pub size: (u32, u32),
    /// How many frames there are.
    pub frames: usize,
}

/// Writes a sketch's take.
///
/// # Errors
/// A take without frames or of another drawing, what a format cannot hold, a file that cannot be written, a cancel. What
/// was there before then stays as it was.
pub fn write_sketch(
    path: &Path,
    format: SketchFormat,
    subject: SketchSubject<'_>,
    options: &SketchOptions,
    stage: Stage<'_>,
) -> Result<SketchFiles> {
    let SketchSubject { name, drawing, take } = subject;
    stage.name("measuring frames")?;
    check_sketch(drawing, take)?;
    if let Some(tolerance) = options.tolerance.filter(|t| !(t.is_finite() && *t >= 0.0)) {
        return Err(Error::invalid("tolerance", format!("is {tolerance}"), "give a number of pixels, 0 or more"));
    }
    let mut canvas = if options.grow {
        SketchCanvas::around(drawing, take, options.scale)?
    } else {
        SketchCanvas::page(drawing, options.scale)?
    };
    canvas.background = options.background;
    let (size, stage) = (canvas.size(), stage.part(0.05, 1.0));
    let animate = |format, double: bool| {
        let draw = |frame: usize| {
            let picture = draw_sketch(drawing, take, frame, &canvas);
            Ok(if double { stacked(&picture) } else { picture })
        };
        let size = if double { (size.0.next_multiple_of(2), 2 * size.1.next_multiple_of(2)) } else { size };
        let animation =
            Animation { name, frames: take.frames.len(), fps: take.fps, size, pivot: [0.5, 0.5], draw: &draw };
        animation::write(path, format, &animation, stage)
    };
    let write = |text: String| {
        write_aside(path, text.as_bytes())?;
        Ok(vec![path.to_owned()])
    };
    let files = match format {
        SketchFormat::Svg => {
            let tolerance = options.tolerance.unwrap_or(SVG_TOLERANCE);
            let how = SvgOptions { tolerance, repeat: options.repeat };
            write(animated_svg::write(name, drawing, take, &canvas, how, stage)?)
        }
        SketchFormat::Lottie => write(lottie::write(name, drawing, take, &canvas, options.tolerance, stage)?),
        SketchFormat::Gif => animate(AnimationFormat::Gif, false),
        SketchFormat::Apng => animate(AnimationFormat::Apng, false),
        SketchFormat::WebP => animate(AnimationFormat::WebP, false),
        SketchFormat::Mp4 => animate(AnimationFormat::Mp4, false),
        SketchFormat::Mp4Alpha => animate(AnimationFormat::Mp4, true),
        SketchFormat::PngFolder => animate(AnimationFormat::PngFolder, false),
        SketchFormat::SpriteSheet => animate(AnimationFormat::SpriteSheet, false),
    }?;
    let shown = canvas.shown();
    let shown = [shown.x0, shown.y0, shown.width(), shown.height()];
    Ok(SketchFiles { files, shown, size, frames: take.frames.len() })
}

/// Whether a drawing and a take belong together and can be written.
///
/// # Errors
/// What is wrong, and in which frame.
pub fn check_sketch(drawing: &Drawing, take: &SketchTake) -> Result<()> {
    let remedy = "give a take of this drawing";
    let Some(first) = take.frames.first() else {
        return Err(Error::invalid("take", "has no frames", "give a motion of at least one"));
    };
    if !RATES.contains(&take.fps) {
        let wanted = format!("give {} to {} frames a second", RATES.start(), RATES.end());
        return Err(Error::invalid("the take's rate", format!("is {}", take.fps), wanted));
    }
    let (strokes, groups) = (drawing.strokes.len(), drawing.groups.len());
    let mut seen = vec![false; strokes];
    let mut new = |stroke: usize| seen.get_mut(stroke).is_some_and(|seen| !std::mem::replace(seen, true));
    if take.order.len() != strokes || !take.order.iter().all(|stroke| new(*stroke)) {
        return Err(Error::invalid("the take's order", format!("is not of {strokes} strokes, each once"), remedy));
    }
    if take.widths.len() != strokes {
        let problem = format!("are of {} strokes and the drawing has {strokes}", take.widths.len());
        return Err(Error::invalid("the take's widths", problem, remedy));
    }
    if take.widths.iter().flatten().any(|w| !w.is_finite()) {
        return Err(Error::invalid("the take's widths", "hold what is not a number", "check the drawing's pens"));
    }
    for (f, frame) in take.frames.iter().enumerate() {
        let what = || format!("frame {f} of the take");
        let counts = [
            ("paths", frame.paths.len(), strokes),
            ("affine maps", frame.affines.len(), strokes),
            ("clips", frame.clips.len(), groups),
        ];
        if let Some((of, own, wanted)) = counts.into_iter().find(|(_, own, wanted)| own != wanted) {
            let problem = format!("has {own} {of} and the drawing needs {wanted}");
            return Err(Error::invalid(what(), problem, remedy));
        }
        let all = || frame.paths.iter().zip(&first.paths).chain(frame.clips.iter().zip(&first.clips));
        if let Some(i) = all().position(|(own, first)| !curve::alike(own, first)) {
            let name = drawing.strokes.get(i).map_or("a clip", |s| &s.name);
            let problem = format!("has a path of other elements than the first frame, `{name}`");
            return Err(Error::invalid(what(), problem, "give paths whose points alone differ"));
        }
        if all().any(|(own, _)| !own.is_finite()) || frame.affines.iter().any(|a| !a.is_finite()) {
            return Err(Error::invalid(what(), "has a place that is not a number", "check the motion"));
        }
    }
    Ok(())
}

/// The straight colours of a picture above its opacity. What is clear takes the colour nearest in its row or column, so
/// that video, which blurs colours, blurs none into the edges.
fn stacked(picture: &RgbaImage) -> RgbaImage {
    let (width, height) = (picture.width().next_multiple_of(2), picture.height().next_multiple_of(2));
    let mut out = RgbaImage::from_pixel(width, 2 * height, image::Rgba([0, 0, 0, 255]));
    let mut colors = picture.clone();
    let (w, h) = (picture.width(), picture.height());
    let mut spread = |cells: &mut dyn Iterator<Item = (u32, u32)>| {
        let mut last = None;
        for (x, y) in cells {
            let pixel = colors.get_pixel_mut(x, y);
            if pixel.0[3] > 0 {
                last = Some(*pixel);
            } else if let Some(color) = last {
                // As good as clear, yet coloured for those that come after.
                *pixel = color;
            }
        }
    };
    for y in 0..h {
        spread(&mut (0..w).map(|x| (x, y)));
        spread(&mut (0..w).rev().map(|x| (x, y)));
    }
    for x in 0..w {
        spread(&mut (0..h).map(|y| (x, y)));
        spread(&mut (0..h).rev().map(|y| (x, y)));
    }
    colors.pixels_mut().for_each(|p| p.0[3] = 255);
    imageops::replace(&mut out, &colors, 0, 0);
    for (x, y, pixel) in picture.enumerate_pixels() {
        let [.., alpha] = pixel.0;
        out.put_pixel(x, height + y, image::Rgba([alpha, alpha, alpha, 255]));
    }
    out
}

#[cfg(test)]
mod tests;
