//! The creature in motion as a GIF: as the clip's camera sees it, and from another side.

use glam::{Mat4, Vec3, vec3};
use image::{Rgb, RgbImage};
use rayon::prelude::*;

use super::gif::{Schedule, encode};
use crate::error::Result;
use crate::geometry::TriMesh;
use crate::job::Stage;
use crate::raster::{Rasterizer, Surface, clip_view, orbit_view};
use crate::shape::RiggedModel;

/// Size of each of the two views.
const MAX_WIDTH: u32 = 360;
const MAX_HEIGHT: u32 = 320;
const MAX_FRAMES: usize = 120;
/// Samples a pixel along each axis.
const FINE: u32 = 2;
/// The second view: to the right and from above, in degrees.
const YAW: f32 = 40.0;
const PITCH: f32 = 12.0;
/// The second view shows the creature at most this many times larger than the first.
const MAX_ZOOM: f32 = 2.0;
const BACKGROUND: [u8; 3] = [58, 62, 70];
const DIVIDER: [u8; 3] = [36, 38, 43];

/// The preview as the bytes of a GIF.
///
/// # Errors
/// A model that is not valid, or a cancel.
pub fn preview(model: &RiggedModel, stage: Stage<'_>) -> Result<Vec<u8>> {
    model.validate()?;
    let (width, height) = model.size;
    let scale = (MAX_WIDTH as f32 / width.max(1) as f32).min(MAX_HEIGHT as f32 / height.max(1) as f32).min(1.0);
    let side = |pixels: u32| ((pixels as f32 * scale).round() as u32).max(1);
    let view = (side(width), side(height));
    let schedule = Schedule::new(model.animation.len(), model.fps, MAX_FRAMES);

    let clip = Mat4::from_scale(vec3(scale, scale, scale)) * clip_view(height);
    let other = other_view(model, &schedule.frames, scale, view, stage.part(0.0, 0.1))?;
    let draw = |frame: usize| {
        let meshes = model.pose(frame);
        Ok(side_by_side(&show(model, &meshes, clip, view, false), &show(model, &meshes, other, view, true)))
    };
    encode(&schedule, &[BACKGROUND, DIVIDER], draw, stage.part(0.1, 1.0))
}

/// The second view, centred and sized so that the creature stays in the picture in all frames.
fn other_view(model: &RiggedModel, frames: &[usize], scale: f32, view: (u32, u32), stage: Stage<'_>) -> Result<Mat4> {
    let turned = orbit_view(Vec3::ZERO, YAW, PITCH, 1.0, None, (0, 0));
    let boxes: Vec<[Vec3; 4]> = frames
        .par_iter()
        .map(|&frame| {
            stage.at(0.0)?;
            let start = [Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::INFINITY, Vec3::NEG_INFINITY];
            let meshes = model.pose(frame);
            Ok(meshes.iter().flat_map(|m| &m.positions).fold(start, |b, p| {
                let seen = turned.transform_point3(*p);
                [b[0].min(*p), b[1].max(*p), b[2].min(seen), b[3].max(seen)]
            }))
        })
        .collect::<Result<_>>()?;
    let all = boxes
        .into_iter()
        .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])])
        .filter(|b| b.iter().all(|v| v.is_finite()))
        .unwrap_or([Vec3::ZERO; 4]);
    let spread = (all[3] - all[2]).max(Vec3::ONE);
    let fit = (0.92 * view.0 as f32 / spread.x).min(0.92 * view.1 as f32 / spread.y).min(MAX_ZOOM * scale);
    // The middle of what is seen, rather than of the box in the world, is what should be in the middle.
    let center = turned.inverse().transform_point3((all[2] + all[3]) / 2.0);
    Ok(orbit_view(center, YAW, PITCH, fit, None, view))
}

fn show(model: &RiggedModel, meshes: &[TriMesh], view: Mat4, (width, height): (u32, u32), lit: bool) -> RgbImage {
    let mut raster = Rasterizer::new(width * FINE, height * FINE);
    raster.clear([BACKGROUND[0], BACKGROUND[1], BACKGROUND[2], 255]);
    let fine = Mat4::from_scale(vec3(FINE as f32, FINE as f32, 1.0)) * view;
    for (part, mesh) in model.parts.iter().zip(meshes) {
        let surface = if lit { Surface::Lit(&part.texture) } else { Surface::Flat(&part.texture) };
        raster.draw(mesh, &fine, surface, 0);
    }
    let raw = raster.color.as_raw();
    let row = (width * FINE * 4) as usize;
    RgbImage::from_fn(width, height, |x, y| {
        let at = (y * FINE) as usize * row + (x * FINE * 4) as usize;
        Rgb(std::array::from_fn(|c| {
            let sum: u32 = [0, 4, row, row + 4].iter().map(|o| u32::from(raw[at + o + c])).sum();
            ((sum + 2) / 4) as u8
        }))
    })
}

fn side_by_side(left: &RgbImage, right: &RgbImage) -> RgbImage {
    let gap = 2;
    let mut out = RgbImage::from_pixel(left.width() + gap + right.width(), left.height(), Rgb(DIVIDER));
    image::imageops::replace(&mut out, left, 0, 0);
    image::imageops::replace(&mut out, right, i64::from(left.width() + gap), 0);
    out
}
