//! The clip as joints are looked for in it: reduced pictures in Lab, each pixel with how surely it shows the character.
//!
//! The character is what is opaque, where the clip has opacity (its art is laid on mid grey, so that dark and light
//! outlines both count); else what differs from the one colour of the picture's border; else what differs from the
//! median of each pixel over time, where the camera is still. Where none of these holds, all may be the character.
//!
//! Known limits: a character that never moves before a still camera is its own backdrop, and then none is subtracted.

use glam::Vec2;
use image::RgbImage;
use rayon::prelude::*;

use crate::clip::{Clip, Picture};
use crate::error::Result;
use crate::job::Stage;
use crate::raster::{Grid, Planes, gaussian::gaussian, pyramid};

/// What transparent art is laid on: as far from black outlines as from white ones.
const GREY: u8 = 128;
/// Pixels of all frames together that are kept; longer clips are tracked on smaller pictures. A pixel takes 5 bytes,
/// and some 16 while the clip is read.
const PIXEL_BUDGET: f64 = 60e6;
/// Working pictures never get smaller than this on their long side, whatever the budget says.
const LEAST_SIDE: u32 = 200;
/// Blur of the working picture in its pixels: what a part's place may be wrong by before its looks are.
const BLUR: f32 = 0.8;
/// Frames that the backdrop is learned from, spread evenly over longer clips.
const BACKDROP_FRAMES: usize = 32;
/// Lab distance (byte units) from the backdrop that is as likely character as not, and over which that is certain.
const UNLIKE: (f32, f32) = (10.0, 30.0);
/// The share of the border, and of the marked joints' surroundings, that decides about a backdrop.
const PLAIN: f32 = 0.9;
const STILL: f32 = 0.7;
const COVERED: f32 = 0.5;

/// One working picture: lightness over 0..=255, chroma doubled around 128, and how surely it is the character's.
#[derive(Clone, Debug)]
pub(super) struct View {
    pub(super) width: usize,
    pub(super) height: usize,
    pixels: Vec<[u8; 4]>,
}

impl View {
    /// The pixel at `p`, or nothing outside the picture.
    #[inline]
    pub(super) fn at(&self, p: Vec2) -> Option<[u8; 4]> {
        if p.x >= 0.0 && p.y >= 0.0 && p.x < self.width as f32 && p.y < self.height as f32 {
            Some(self.pixels[p.y as usize * self.width + p.x as usize])
        } else {
            None
        }
    }

    fn new(planes: &[Grid<f32>; 4]) -> Self {
        let byte = |v: f32| v.round().clamp(0.0, 255.0) as u8;
        let pixels = (0..planes[0].data().len()).map(|i| std::array::from_fn(|c| byte(planes[c].data()[i])));
        Self { width: planes[0].width(), height: planes[0].height(), pixels: pixels.collect() }
    }
}

/// All pictures of a clip that are looked at.
#[derive(Debug)]
pub(super) struct Scene {
    /// Working pixels for one clip pixel.
    pub(super) scale: f32,
    /// Every frame, nothing where it is not looked at; and the same at half the size.
    pub(super) fine: Vec<Option<View>>,
    pub(super) coarse: Vec<Option<View>>,
    /// Whether it is known what is the character.
    pub(super) cut_out: bool,
}

/// A frame before it is known what the character is.
struct Raw {
    lab: [Grid<f32>; 3],
    alpha: Option<Grid<f32>>,
}

impl Scene {
    /// Reads the frames that `looked_at` names, and those that a backdrop is learned from, at a long side of `side`
    /// pixels, less where the clip is long. `joints` are places (clip pixels) on frame `whole` that are of the character.
    pub(super) fn read(
        clip: &Clip,
        side: u32,
        looked_at: &mut [bool],
        (whole, joints): (usize, &[Vec2]),
        stage: Stage<'_>,
    ) -> Result<Self> {
        let info = clip.info();
        let long = f64::from(info.width.max(info.height));
        let area = f64::from(info.width) * f64::from(info.height);
        let affordable = (PIXEL_BUDGET / info.frames.max(1) as f64 / area).sqrt() * long;
        let (width, height) = pyramid::fitted(info.width, info.height, side.min((affordable as u32).max(LEAST_SIDE)));
        // The same frames whatever is looked at, so that the same is taken for the character.
        let step = info.frames.div_ceil(BACKDROP_FRAMES).max(1);
        let chosen: Vec<usize> = (0..info.frames).step_by(step).collect();
        chosen.iter().for_each(|&f| looked_at[f] = true);
        let looked_at = &*looked_at;
        let scale = width as f32 / info.width as f32;
        let raw: Vec<Option<Raw>> = (0..info.frames)
            .into_par_iter()
            .map(|f| {
                stage.at(0.8 * f as f64 / info.frames as f64)?;
                Ok(if looked_at[f] { Some(Raw::new(&*clip.frame(f)?, width, height)) } else { None })
            })
            .collect::<Result<_>>()?;
        stage.at(0.8)?;
        let shows = chosen.iter().chain([&whole]).any(|&f| raw[f].as_ref().is_some_and(|r| r.alpha.is_some()));
        let backdrop = if shows { None } else { Backdrop::learn(&raw, &chosen, whole, joints, scale) };
        let cut_out = shows || backdrop.is_some();
        let views: Vec<Option<(View, View)>> = raw
            .into_par_iter()
            .map(|raw| {
                stage.at(0.9)?;
                let Some(Raw { lab: [l, a, b], alpha }) = raw else { return Ok(None) };
                let all = || Grid::new(l.width(), l.height(), 255.0);
                let shown = match &backdrop {
                    Some(backdrop) => backdrop.character([&l, &a, &b]),
                    None => alpha.unwrap_or_else(all),
                };
                let fine = [&l, &a, &b, &shown].map(|g| gaussian(g, BLUR));
                let coarse = [&fine[0], &fine[1], &fine[2], &fine[3]].map(pyramid::halved);
                Ok(Some((View::new(&fine), View::new(&coarse))))
            })
            .collect::<Result<_>>()?;
        let (fine, coarse) = views.into_iter().map(Option::unzip).unzip();
        Ok(Self { scale, fine, coarse, cut_out })
    }

    /// How many frames there are.
    pub(super) fn frames(&self) -> usize {
        self.fine.len()
    }
}

impl Raw {
    fn new(picture: &Picture, width: u32, height: u32) -> Self {
        let laid;
        let (small, alpha) = match &picture.alpha {
            None => (pyramid::shrunk(&picture.rgb, width, height), None),
            Some(alpha) => {
                let mix =
                    |c: u8, a: u8| ((u16::from(c) * u16::from(a) + u16::from(GREY) * u16::from(255 - a)) / 255) as u8;
                let pixels = picture.rgb.as_raw().chunks_exact(3).zip(alpha.as_raw());
                let pixels = pixels.flat_map(|(p, &a)| [mix(p[0], a), mix(p[1], a), mix(p[2], a)]).collect();
                laid = RgbImage::from_raw(alpha.width(), alpha.height(), pixels).unwrap_or_default();
                // Opacity is reduced as colours are.
                let tripled = alpha.as_raw().iter().flat_map(|&a| [a; 3]).collect();
                let tripled = RgbImage::from_raw(alpha.width(), alpha.height(), tripled).unwrap_or_default();
                let opacity = pyramid::shrunk(&tripled, width, height);
                let opacity = opacity.as_raw().chunks_exact(3).map(|p| f32::from(p[0])).collect();
                let opacity = Grid::from_vec(width as usize, height as usize, opacity);
                (pyramid::shrunk(&laid, width, height), Some(opacity))
            }
        };
        let planes = Planes::lab(&small);
        let channel = |c: usize, by: f32, from: f32| {
            let data = planes.channel(c).data().iter().map(|v| v * by + from).collect();
            Grid::from_vec(planes.width(), planes.height(), data)
        };
        Self { lab: [channel(0, 255.0, 0.0), channel(1, 200.0, 128.0), channel(2, 200.0, 128.0)], alpha }
    }
}

/// What is behind the character, as Lab planes.
struct Backdrop([Grid<f32>; 3]);

impl Backdrop {
    fn learn(raw: &[Option<Raw>], chosen: &[usize], whole: usize, joints: &[Vec2], scale: f32) -> Option<Self> {
        let marked = raw.get(whole)?.as_ref()?;
        let chosen: Vec<&Raw> = chosen.iter().filter_map(|&f| raw[f].as_ref()).collect();
        let stands = |backdrop: Self| {
            // The marked joints have to be something else than backdrop.
            let character = backdrop.character(marked.lab.each_ref());
            let (w, h) = (character.width() as isize, character.height() as isize);
            let near = |p: &Vec2| {
                let (x, y) = ((p.x * scale) as isize, (p.y * scale) as isize);
                (0..25).filter(|i| character.clamped(x + i % 5 - 2, y + i / 5 - 2) > 128.0).count()
            };
            let inside =
                joints.iter().filter(|p| p.x >= 0.0 && p.y >= 0.0 && p.x * scale < w as f32 && p.y * scale < h as f32);
            let (covered, all) = inside.fold((0, 0), |(c, n), p| (c + near(p), n + 25));
            (covered as f32 >= COVERED * all.max(1) as f32).then_some(backdrop)
        };
        Self::plain(&chosen).and_then(stands).or_else(|| Self::still(&chosen).and_then(stands))
    }

    /// The one colour of the border of all pictures.
    fn plain(chosen: &[&Raw]) -> Option<Self> {
        let (w, h) = chosen.first().map(|r| (r.lab[0].width(), r.lab[0].height()))?;
        let border: Vec<(usize, usize)> =
            (0..w).flat_map(|x| [(x, 0), (x, h - 1)]).chain((0..h).flat_map(|y| [(0, y), (w - 1, y)])).collect();
        let colours: Vec<[f32; 3]> = chosen
            .iter()
            .flat_map(|r| border.iter().map(|&(x, y)| std::array::from_fn(|c| r.lab[c].get(x, y))))
            .collect();
        let colour: [f32; 3] = std::array::from_fn(|c| median(colours.iter().map(|p| p[c]).collect()));
        let like = colours.iter().filter(|p| distance(p, &colour) < UNLIKE.0).count();
        let plain = like as f32 >= PLAIN * colours.len() as f32;
        plain.then(|| Self(colour.map(|v| Grid::new(w, h, v))))
    }

    /// The median of every pixel over time, where most pixels keep to theirs.
    fn still(chosen: &[&Raw]) -> Option<Self> {
        let (w, h) = chosen.first().map(|r| (r.lab[0].width(), r.lab[0].height()))?;
        if chosen.len() < 4 {
            return None;
        }
        let pixels: Vec<([f32; 3], usize)> = (0..w * h)
            .into_par_iter()
            .map(|i| {
                let usual: [f32; 3] =
                    std::array::from_fn(|c| median(chosen.iter().map(|r| r.lab[c].data()[i]).collect()));
                let here = |r: &&&Raw| distance(&std::array::from_fn(|c| r.lab[c].data()[i]), &usual) < UNLIKE.0;
                (usual, chosen.iter().filter(here).count())
            })
            .collect();
        let steady: usize = pixels.iter().map(|p| p.1).sum();
        let still = steady as f32 >= STILL * (chosen.len() * w * h) as f32;
        still.then(|| Self(std::array::from_fn(|c| Grid::from_vec(w, h, pixels.iter().map(|p| p.0[c]).collect()))))
    }

    /// How surely every pixel is the character's, over 0..=255.
    fn character(&self, lab: [&Grid<f32>; 3]) -> Grid<f32> {
        let pixel = |i: usize| {
            let here: [f32; 3] = std::array::from_fn(|c| lab[c].data()[i]);
            let unlike = distance(&here, &std::array::from_fn(|c| self.0[c].data()[i]));
            255.0 * ((unlike - UNLIKE.0) / (UNLIKE.1 - UNLIKE.0) + 0.5).clamp(0.0, 1.0)
        };
        let sure = Grid::from_vec(lab[0].width(), lab[0].height(), (0..lab[0].data().len()).map(pixel).collect());
        gaussian(&sure, 1.0)
    }
}

fn distance(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
}

fn median(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f32::total_cmp).1 }
}
