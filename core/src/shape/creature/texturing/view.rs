//! What one frame of the clip shows of the model's texels, and how well.
//!
//! The posed model is drawn into a depth buffer, which knows what hides what. A texel that is seen has a colour and a
//! quality: how far its surface faces the viewer, how far it is from the mask's border (there colours are mixed with the
//! background's) and from the outline of what is in front of it, how sharp the frame is, and how far the tracker trusts
//! the limbs that carry it.

use std::ops::Deref;

use glam::{Vec2, Vec3};
use image::{ImageBuffer, Rgb};
use rayon::prelude::*;

use super::texels::Texels;
use super::{Footage, frame_trust};
use crate::clip::Picture;
use crate::error::Result;
use crate::geometry::TriMesh;
use crate::raster::distance::{NO_SITE, nearest_site};
use crate::raster::{Grid, Mask, Rasterizer, Surface, clip_view};
use crate::shape::RiggedModel;

/// Below this share toward the viewer a surface is seen edge on and its place is not certain to a pixel.
const EDGE_ON: f32 = 0.12;
/// Pixels from the mask's border at which colours are not mixed (the border of a video is soft for a pixel or two),
/// and at which also a border that is a few pixels off does no harm.
const MIXED: f32 = 1.5;
const CERTAIN: f32 = 5.0;
/// World units by which a surface may be behind the depth buffer and still be the one seen, facing the viewer.
const BIAS: f32 = 0.75;
/// Something in front stands at least this many world units nearer, and harms within so many pixels.
const STEP: f32 = 3.0;
const STEP_REACH: isize = 3;
/// What is left of the quality beside such a step.
const BESIDE_STEP: f32 = 0.15;

/// A frame that gives colours.
pub(super) struct View {
    pub frame: usize,
    picture: std::sync::Arc<Picture>,
    meshes: Vec<TriMesh>,
    depth: Grid<f32>,
    /// Pixels to the mask's border.
    inside: Grid<f32>,
    /// How far each vertex of each part is trusted.
    trust: Vec<Vec<f32>>,
}

/// A colour and its quality in 0..=255; 0 is not seen.
pub(super) type Sample = [u8; 4];

impl View {
    pub(super) fn new(model: &RiggedModel, footage: &Footage<'_>, frame: usize) -> Result<Self> {
        let picture = footage.clip.frame(frame)?;
        let meshes = model.pose(frame);
        let (w, h) = picture.rgb.dimensions();
        let mut raster = Rasterizer::new(w, h);
        for (i, mesh) in meshes.iter().enumerate() {
            raster.draw(mesh, &clip_view(h), Surface::Bare, i as u16);
        }
        let bones = frame_trust(model, footage.motion, frame);
        let trust = model
            .parts
            .iter()
            .map(|part| {
                let of = |(b, w): (&[u16; 4], &[f32; 4])| (0..4).map(|k| bones[usize::from(b[k])] * w[k]).sum();
                part.bones.iter().zip(&part.weights).map(of).collect()
            })
            .collect();
        let inside = to_border(&footage.masks[frame]);
        Ok(Self { frame, picture, meshes, depth: raster.depth, inside, trust })
    }

    /// How sharp the picture is inside the mask: the mean of |Laplacian| of its green channel.
    pub(super) fn sharpness(&self) -> f32 {
        let rgb = &self.picture.rgb;
        let (w, h) = (rgb.width() as usize, rgb.height() as usize);
        let (raw, row) = (rgb.as_raw(), 3 * w);
        let (mut sum, mut count) = (0u64, 0u64);
        for y in 1..h.saturating_sub(1) {
            for x in 1..w.saturating_sub(1) {
                if self.inside.get(x, y) >= CERTAIN {
                    let at = y * row + 3 * x + 1;
                    let green = |at: usize| i32::from(raw[at]);
                    let bend = 4 * green(at) - green(at - 3) - green(at + 3) - green(at - row) - green(at + row);
                    sum += u64::from(bend.unsigned_abs());
                    count += 1;
                }
            }
        }
        if count == 0 { 0.0 } else { sum as f32 / count as f32 }
    }

    /// What the frame shows of every texel. `weight` is the quality of the whole frame.
    pub(super) fn samples(&self, texels: &Texels, weight: f32) -> Vec<Sample> {
        texels.list.par_iter().with_min_len(4096).map(|texel| self.sample(texel, weight)).collect()
    }

    fn sample(&self, texel: &super::texels::Texel, weight: f32) -> Sample {
        let mesh = &self.meshes[usize::from(texel.part)];
        let place = texel.mix(mesh, &mesh.positions);
        let at = Vec2::new(place.x, self.depth.height() as f32 - place.y);
        let (w, h) = (self.depth.width() as f32, self.depth.height() as f32);
        if !(at.x >= 0.0 && at.y >= 0.0 && at.x < w && at.y < h) {
            return [0; 4];
        }
        let (x, y) = (at.x as usize, at.y as usize);
        let inside = self.inside.get(x, y);
        if inside < MIXED {
            return [0; 4];
        }
        let facing = texel.mix(mesh, &mesh.normals).normalize_or_zero().z;
        if facing < EDGE_ON {
            return [0; 4];
        }
        // Within a pixel a slanted surface's depth changes by its slope.
        let slope = (1.0 - facing * facing).max(0.0).sqrt() / facing;
        if place.z < self.depth.get(x, y) - BIAS - slope {
            return [0; 4];
        }
        let mut quality = weight * facing * (inside / CERTAIN).min(1.0);
        let (ix, iy) = (x as isize, y as isize);
        let stepped = [(STEP_REACH, 0), (-STEP_REACH, 0), (0, STEP_REACH), (0, -STEP_REACH)]
            .iter()
            .any(|(dx, dy)| self.depth.clamped(ix + dx, iy + dy) > place.z + STEP + slope * (1 + STEP_REACH) as f32);
        if stepped {
            quality *= BESIDE_STEP;
        }
        let trust = &self.trust[usize::from(texel.part)];
        let [a, b, c] = mesh.triangles[texel.triangle as usize].map(|i| trust[i as usize]);
        quality *= a + (b - a) * texel.share[0] + (c - a) * texel.share[1];
        let [r, g, b] = bilinear(&self.picture.rgb, at);
        [r, g, b, (quality * 255.0).round().clamp(1.0, 255.0) as u8]
    }
}

/// How far each pixel is from the nearest one outside the mask; beyond the picture's border nothing is known, so it
/// counts as outside.
fn to_border(mask: &Mask) -> Grid<f32> {
    let (w, h) = (mask.width(), mask.height());
    // Only where the creature is: a frame of nothing is not worth a transform of it all.
    let (mut low, mut high) = ((w, h), (0, 0));
    for y in 0..h {
        for x in 0..w {
            if mask.get(x, y) {
                low = (low.0.min(x), low.1.min(y));
                high = (high.0.max(x + 1), high.1.max(y + 1));
            }
        }
    }
    let mut out = Grid::new(w, h, 0.0);
    if low.0 >= high.0 {
        return out;
    }
    let (bw, bh) = (high.0 - low.0 + 2, high.1 - low.1 + 2);
    let outside = |x: usize, y: usize| !mask.at((low.0 + x) as isize - 1, (low.1 + y) as isize - 1);
    let sites = (0..bw * bh).map(|i| if outside(i % bw, i / bw) { i as u32 } else { NO_SITE }).collect();
    let nearest = nearest_site(&Grid::from_vec(bw, bh, sites));
    for y in 1..bh - 1 {
        for x in 1..bw - 1 {
            let site = nearest.get(x, y) as usize;
            let (dx, dy) = ((site % bw).abs_diff(x) as f32, (site / bw).abs_diff(y) as f32);
            out.set(low.0 + x - 1, low.1 + y - 1, dx.hypot(dy));
        }
    }
    out
}

/// The colour of an image at a place in pixels.
pub(super) fn bilinear<C: Deref<Target = [u8]>>(image: &ImageBuffer<Rgb<u8>, C>, at: Vec2) -> [u8; 3] {
    let (w, h) = image.dimensions();
    let x = (at.x - 0.5).clamp(0.0, w as f32 - 1.0);
    let y = (at.y - 0.5).clamp(0.0, h as f32 - 1.0);
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(w as usize - 1), (y0 + 1).min(h as usize - 1));
    let raw = image.as_raw();
    let texel = |x: usize, y: usize| {
        let at = 3 * (y * w as usize + x);
        Vec3::new(f32::from(raw[at]), f32::from(raw[at + 1]), f32::from(raw[at + 2]))
    };
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    let c = texel(x0, y0).lerp(texel(x1, y0), fx).lerp(texel(x0, y1).lerp(texel(x1, y1), fx), fy) + 0.5;
    [c.x as u8, c.y as u8, c.z as u8]
}
