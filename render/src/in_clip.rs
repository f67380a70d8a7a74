//! A crowd put back into the clip that its creature was filmed in (Reinert 2016, section 4, "cloning").
//!
//! Who stands behind the middle of the filmed creature (z below 0) is hidden by it, pixel by pixel of its mask; who stands
//! before covers it; among themselves they are hidden by depth. Limits: what else stands in the clip hides nobody, and
//! an instance is wholly behind or before the filmed creature.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{Pixel, Rgba, RgbaImage};
use marey::clip::Clip;
use marey::export::animation::{self, Animation, AnimationFormat};
use marey::job::Stage;
use marey::raster::Mask;
use marey::shape::crowd::Crowd;
use marey::{Error, Result};

use crate::{Camera, Picture, Renderer, Scene};

/// A crowd in a clip.
#[derive(Debug)]
pub struct InClip {
    behind: Option<Scene>,
    before: Option<Scene>,
    clip: Arc<Clip>,
    masks: Vec<Mask>,
    frames: usize,
    fps: f64,
    /// How the crowd is looked at: by default as the clip was filmed, with its colours as they are and no shadow.
    pub picture: Picture,
    /// Whether only the crowd is drawn, on nothing, for putting it over the clip elsewhere.
    pub alone: bool,
    /// Whether one frame alone is written, and which.
    pub still: Option<usize>,
}

impl InClip {
    /// A crowd and the clip that it is to be in, with a mask a frame of who was filmed; no masks when nobody hides
    /// anybody.
    ///
    /// # Errors
    /// A crowd that is not valid, that is longer than the clip, or masks that do not fit the clip.
    pub fn new(crowd: &Crowd, clip: Arc<Clip>, masks: Vec<Mask>) -> Result<Self> {
        crowd.validate()?;
        let info = clip.info();
        let size = (info.width, info.height);
        if crowd.frames > info.frames {
            let problem = format!("has {} frames, and the clip {}", crowd.frames, info.frames);
            return Err(Error::invalid("the crowd", problem, "ask for no more frames than the clip has"));
        }
        if !masks.is_empty() && masks.len() < crowd.frames {
            let problem = format!("there are {} for {} frames", masks.len(), crowd.frames);
            return Err(Error::invalid("masks", problem, "give one a frame, or none"));
        }
        let fits = |m: &Mask| (m.width() as u32, m.height() as u32) == size;
        if let Some(frame) = masks.iter().position(|m| !fits(m)) {
            return Err(Error::invalid(
                format!("mask {frame}"),
                "is not of the clip's size",
                "give the clip's own masks",
            ));
        }
        let group = |behind: bool| {
            let mut part = crowd.clone();
            part.instances.retain(|i| (i.at[2] < 0.0) == behind);
            if part.instances.is_empty() { Ok(None) } else { Scene::of_crowd(&part).map(Some) }
        };
        Ok(Self {
            behind: group(true)?,
            before: group(false)?,
            frames: crowd.frames,
            fps: crowd.fps,
            picture: Picture::new(size, Camera::of_clip(size, size)),
            alone: false,
            still: None,
            clip,
            masks,
        })
    }

    /// How many pictures [`Self::write`] draws.
    pub fn frames(&self) -> usize {
        self.still.map_or(self.frames, |_| 1)
    }

    /// Draws a frame: the clip with the crowd in it, or the crowd alone.
    ///
    /// # Errors
    /// What [`Renderer::draw`] says, a frame of the clip that cannot be read, or a cancel.
    pub fn draw(&self, renderer: &Renderer, frame: usize, stage: Stage<'_>) -> Result<RgbaImage> {
        let mut out = if self.alone {
            RgbaImage::new(self.picture.size.0, self.picture.size.1)
        } else {
            let filmed = self.clip.frame(frame)?;
            RgbaImage::from_fn(self.picture.size.0, self.picture.size.1, |x, y| filmed.rgb.get_pixel(x, y).to_rgba())
        };
        if let Some(scene) = &self.behind {
            let drawn = renderer.draw(scene, frame, &self.picture, stage)?;
            let mask = self.masks.get(frame);
            over(&mut out, &drawn, |x, y| 1.0 - mask.map_or(0.0, |m| softly(m, x, y)));
        }
        if let Some(scene) = &self.before {
            over(&mut out, &renderer.draw(scene, frame, &self.picture, stage)?, |_, _| 1.0);
        }
        Ok(out)
    }

    /// Draws all frames, or the still one, and writes them. Says which files that made.
    ///
    /// # Errors
    /// What [`Self::draw`] and [`animation::write`] say. What was there before then stays as it was.
    pub fn write(
        &self,
        renderer: &Renderer,
        path: &Path,
        format: AnimationFormat,
        stage: Stage<'_>,
    ) -> Result<Vec<PathBuf>> {
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let draw = |frame: usize| self.draw(renderer, self.still.unwrap_or(frame), stage);
        let (size, pivot) = (self.picture.size, [0.5, 0.5]);
        let film = Animation { name: &name, frames: self.frames(), fps: self.fps, size, pivot, draw: &draw };
        animation::write(path, format, &film, stage)
    }
}

/// How much of a pixel a mask covers, its border smoothed over a pixel.
fn softly(mask: &Mask, x: u32, y: u32) -> f32 {
    let (w, h) = (mask.width() as i64, mask.height() as i64);
    let around = (-1..=1i64).flat_map(|dy| (-1..=1i64).map(move |dx| (dx, dy)));
    let within = around.filter(|(dx, dy)| {
        let (x, y) = ((i64::from(x) + dx).clamp(0, w - 1), (i64::from(y) + dy).clamp(0, h - 1));
        mask.get(x as usize, y as usize)
    });
    within.count() as f32 / 9.0
}

/// Lays a picture over another, straight alpha both, where `share` lets it show.
fn over(under: &mut RgbaImage, picture: &RgbaImage, share: impl Fn(u32, u32) -> f32) {
    for ((x, y, to), from) in under.enumerate_pixels_mut().zip(picture.pixels()) {
        if from.0[3] == 0 {
            continue;
        }
        let (a, b) = (f32::from(from.0[3]) / 255.0 * share(x, y), f32::from(to.0[3]) / 255.0);
        let both = a + b * (1.0 - a);
        if both > 0.0 {
            let mix = |k: usize| (f32::from(from.0[k]) * a + f32::from(to.0[k]) * b * (1.0 - a)) / both;
            *to = Rgba([mix(0), mix(1), mix(2), both * 255.0].map(|v| v.round() as u8));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_behind_shows_beside_the_mask_only() {
        let mut under = RgbaImage::from_pixel(8, 1, Rgba([10, 20, 30, 255]));
        let picture = RgbaImage::from_pixel(8, 1, Rgba([200, 100, 0, 255]));
        let mask = Mask::from_fn(8, 1, |x, _| x >= 4);
        over(&mut under, &picture, |x, y| 1.0 - softly(&mask, x, y));
        assert_eq!(under.get_pixel(0, 0).0, [200, 100, 0, 255]);
        assert_eq!(under.get_pixel(7, 0).0, [10, 20, 30, 255]);
        let edge = under.get_pixel(4, 0).0[0];
        assert!((30..150).contains(&edge), "{edge}: the border is soft");
    }

    #[test]
    fn on_nothing_colours_stay_and_opacity_is_shared() {
        let mut under = RgbaImage::new(1, 1);
        over(&mut under, &RgbaImage::from_pixel(1, 1, Rgba([200, 100, 0, 128])), |_, _| 0.5);
        assert_eq!(under.get_pixel(0, 0).0, [200, 100, 0, 64]);
    }
}
