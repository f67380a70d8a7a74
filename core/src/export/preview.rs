//! The creature in motion as a GIF: as the clip's camera sees it, and lit, from another side. Both views are cut to
//! where the creature is over all frames.

use glam::{Mat4, Vec2, Vec3, vec3};
use image::{Rgb, RgbImage};
use rayon::prelude::*;

use super::gif::{Schedule, encode};
use crate::error::Result;
use crate::geometry::TriMesh;
use crate::job::Stage;
use crate::raster::{Rasterizer, Surface, clip_view, orbit_view};
use crate::shape::RiggedModel;

/// Size of each of the two views.
const MAX_WIDTH: f32 = 360.0;
const MAX_HEIGHT: f32 = 300.0;
/// Share of a view that the creature takes.
const FILL: f32 = 0.92;
/// Screen pixels a pixel of the clip, at most: more would show nothing more.
const MAX_SCALE: f32 = 1.25;
const MAX_FRAMES: usize = 120;
/// Samples a pixel along each axis.
const FINE: u32 = 2;
/// The second view: to the right and from above, in degrees.
const YAW: f32 = 40.0;
const PITCH: f32 = 12.0;
const BACKGROUND: [u8; 3] = [58, 62, 70];
const DIVIDER: [u8; 3] = [36, 38, 43];

/// The preview as the bytes of a GIF.
///
/// # Errors
/// A model that is not valid, or a cancel.
pub fn preview(model: &RiggedModel, stage: Stage<'_>) -> Result<Vec<u8>> {
    model.validate()?;
    let schedule = Schedule::new(model.animation.len(), model.fps, MAX_FRAMES);
    let turned = orbit_view(Vec3::ZERO, YAW, PITCH, 1.0, None, (0, 0));
    let seen = [
        Bounds::seen(model, &schedule.frames, &clip_view(0), stage)?,
        Bounds::seen(model, &schedule.frames, &turned, stage)?,
    ];
    // One size and one scale for both, so that they can be compared.
    let extent = seen[0].extent().max(seen[1].extent());
    let scale = (FILL * MAX_WIDTH / extent.x).min(FILL * MAX_HEIGHT / extent.y).min(MAX_SCALE);
    let size = (extent * scale / FILL).ceil().max(Vec2::ONE);
    let views = [(clip_view(0), seen[0]), (turned, seen[1])].map(|(view, seen)| {
        Mat4::from_translation((size / 2.0).extend(0.0))
            * Mat4::from_scale(Vec3::splat(scale))
            * Mat4::from_translation(-seen.middle().extend(0.0))
            * view
    });
    let size = (size.x as u32, size.y as u32);
    let draw = |frame: usize| {
        let meshes = model.pose(frame);
        Ok(side_by_side(&show(model, &meshes, views[0], size, false), &show(model, &meshes, views[1], size, true)))
    };
    encode(&schedule, &[BACKGROUND, DIVIDER], draw, stage.part(0.1, 1.0))
}

/// What a view sees of the creature over all frames, on the screen.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: Vec2,
    high: Vec2,
}

impl Bounds {
    fn seen(model: &RiggedModel, frames: &[usize], view: &Mat4, stage: Stage<'_>) -> Result<Self> {
        let nothing = Self { low: Vec2::INFINITY, high: Vec2::NEG_INFINITY };
        let join = |a: Self, b: Self| Self { low: a.low.min(b.low), high: a.high.max(b.high) };
        let each: Vec<Self> = frames
            .par_iter()
            .map(|&frame| {
                stage.at(0.0)?;
                let meshes = model.pose(frame);
                let places = meshes.iter().flat_map(|m| &m.positions).map(|p| view.transform_point3(*p).truncate());
                Ok(places.fold(nothing, |b, p| join(b, Self { low: p, high: p })))
            })
            .collect::<Result<_>>()?;
        Ok(each.into_iter().fold(nothing, join))
    }

    fn extent(&self) -> Vec2 {
        (self.high - self.low).max(Vec2::ONE)
    }

    fn middle(&self) -> Vec2 {
        (self.low + self.high) / 2.0
    }
}

fn show(model: &RiggedModel, meshes: &[TriMesh], view: Mat4, (width, height): (u32, u32), lit: bool) -> RgbImage {
    let mut raster = Rasterizer::new(width * FINE, height * FINE);
    let fine = Mat4::from_scale(vec3(FINE as f32, FINE as f32, 1.0)) * view;
    for (part, mesh) in model.parts.iter().zip(meshes) {
        let surface = if lit { Surface::Lit(&part.texture) } else { Surface::Flat(&part.texture) };
        raster.draw(mesh, &fine, surface, 0);
    }
    let row = (width * FINE * 4) as usize;
    let mut out = RgbImage::from_pixel(width, height, Rgb(BACKGROUND));
    let lines = out.as_flat_samples_mut().samples.chunks_exact_mut(3 * width as usize);
    for (line, two) in lines.zip(raster.color.as_raw().chunks_exact(2 * row)) {
        for (x, pixel) in line.chunks_exact_mut(3).enumerate() {
            let samples = [8 * x, 8 * x + 4, row + 8 * x, row + 8 * x + 4].map(|at| &two[at..at + 4]);
            // Opacity is all or nothing; what nothing covers shows the background.
            let bare = samples.iter().filter(|s| s[3] == 0).count() as u32;
            if bare < 4 {
                for (c, value) in pixel.iter_mut().enumerate() {
                    let sum: u32 = samples.iter().filter(|s| s[3] > 0).map(|s| u32::from(s[c])).sum();
                    *value = ((sum + bare * u32::from(BACKGROUND[c]) + 2) / 4) as u8;
                }
            }
        }
    }
    out
}

fn side_by_side(left: &RgbImage, right: &RgbImage) -> RgbImage {
    let gap = 2;
    let mut out = RgbImage::from_pixel(left.width() + gap + right.width(), left.height(), Rgb(DIVIDER));
    image::imageops::replace(&mut out, left, 0, 0);
    image::imageops::replace(&mut out, right, i64::from(left.width() + gap), 0);
    out
}
