//! Colours of a creature from one frame of its clip.
//!
//! Method: Reinert 2016, section 3.8. Each limb's unrolled cylinder is projected into the first key frame. A texel is
//! reliable where it lies inside the mask, faces the viewer and is not hidden by another limb (z-buffer). The side
//! turned away takes the mirror image of the side that is seen; a hidden limb takes its twin's colours; what is left
//! is filled by push and pull on the torus.

use glam::{Vec2, Vec3};
use image::{Rgb, RgbImage};

use super::limb::LimbShape;
use super::tube::{covered, section};
use crate::clip::FrameImage;
use crate::geometry::TriMesh;
use crate::raster::{Grid, Mask, Rasterizer, Surface, Wrap, clip_view, push_pull};

/// Surfaces whose normal is less toward the viewer than this are seen at a grazing angle (0 is edge on).
const GRAZING: f32 = 0.25;
/// Texels kept free around a block, so that bilinear reads at its border see its own colours.
const GUTTER: u32 = 2;

/// A limb's unrolled surface: x around, y along.
#[derive(Clone)]
pub(super) struct Unrolled {
    pub color: Vec<[f32; 3]>,
    pub known: Grid<bool>,
}

/// What the camera sees in the frame that gives the colours.
pub(super) struct View<'a> {
    pub image: &'a FrameImage,
    pub mask: &'a Mask,
    /// Which part is in front at every pixel, and its depth.
    pub front: &'a Rasterizer,
}

/// Draws all parts' identities and depths as the clip's camera sees them.
pub(super) fn visibility<'a>(meshes: impl Iterator<Item = &'a TriMesh>, size: (u32, u32)) -> Rasterizer {
    let mut picture = Rasterizer::new(size.0, size.1);
    add_visible(&mut picture, meshes.map(Some));
    picture
}

/// Draws more meshes, one for each part that has one.
pub(super) fn add_visible<'a>(picture: &mut Rasterizer, meshes: impl Iterator<Item = Option<&'a TriMesh>>) {
    let view = clip_view(picture.depth.height() as u32);
    for (id, mesh) in meshes.enumerate() {
        if let Some(mesh) = mesh {
            picture.draw(mesh, &view, Surface::Bare, id as u16);
        }
    }
}

/// The size of a limb's unrolled texture: one texel a clip pixel, within `max`.
pub(super) fn unrolled_size(limb: &LimbShape, max: u32) -> (u32, u32) {
    let (first, last) = covered(limb);
    let widest = (first..=last).map(|i| limb.half_width(i)).fold(1.0, f32::max);
    let around = (std::f32::consts::TAU * widest).ceil() as u32;
    let along = ((last - first) as f32 * limb.axis.spacing()).ceil() as u32;
    (around.clamp(16, max.max(16)) / 2 * 2, along.clamp(16, max.max(16)))
}

/// The reliable colours of a limb in `frame`.
pub(super) fn project(
    limb: &LimbShape,
    part: u16,
    frame: usize,
    view: &View<'_>,
    (width, height): (u32, u32),
) -> Unrolled {
    let (w, h) = (width as usize, height as usize);
    let mut out = Unrolled { color: vec![[0.0; 3]; w * h], known: Grid::new(w, h, false) };
    let (first, last) = covered(limb);
    let normals = limb.normals(frame);
    for y in 0..h {
        let sample = first as f32 + (last - first) as f32 * (y as f32 + 0.5) / h as f32;
        let ring = section(limb, frame, &normals, sample, 1.0);
        // The front half of the ring; the back half mirrors it.
        for x in 0..w / 2 {
            let angle = std::f32::consts::TAU * (x as f32 + 0.5) / w as f32;
            let place = ring.at(angle);
            let normal = ring_normal(ring.across, ring.toward, angle);
            if normal.z < GRAZING || !seen(view, part, place, limb) {
                continue;
            }
            let color = bilinear(view.image, Vec2::new(place.x, limb.clip_height - place.y));
            for column in [x, w - 1 - x] {
                out.color[y * w + column] = color;
                out.known.set(column, y, true);
            }
        }
    }
    out
}

fn ring_normal(across: Vec3, toward: Vec3, angle: f32) -> Vec3 {
    let (a, b) = (across.length().max(1e-3), toward.length().max(1e-3));
    (across / (a * a) * angle.cos() + toward / (b * b) * angle.sin()).normalize_or(Vec3::Z)
}

/// Whether the pixel and those around it are in the mask: colours on the outline are mixed with the background's.
fn well_inside(mask: &Mask, x: isize, y: isize) -> bool {
    [(0, 0), (2, 0), (-2, 0), (0, 2), (0, -2)].iter().all(|(dx, dy)| mask.at(x + dx, y + dy))
}

/// Whether the camera sees this place of the part.
fn seen(view: &View<'_>, part: u16, place: Vec3, limb: &LimbShape) -> bool {
    let (x, y) = (place.x.floor() as isize, (limb.clip_height - place.y).floor() as isize);
    if !well_inside(view.mask, x, y) {
        return false;
    }
    let (x, y) = (x as usize, y as usize);
    let (id, depth) = (view.front.id.get(x, y), view.front.depth.get(x, y));
    id == part || id == Rasterizer::NOTHING || place.z >= depth
}

/// Fills what is unknown from the same limb's other of the pair, which may have another size.
pub(super) fn borrow(own: &mut Unrolled, twin: &Unrolled) {
    let (w, h) = (own.known.width(), own.known.height());
    let (tw, th) = (twin.known.width(), twin.known.height());
    for y in 0..h {
        for x in 0..w {
            let (tx, ty) = (x * tw / w, y * th / h);
            if !own.known.get(x, y) && twin.known.get(tx, ty) {
                own.color[y * w + x] = twin.color[ty * tw + tx];
                own.known.set(x, y, true);
            }
        }
    }
}

/// Fills the rest by push and pull around the torus.
pub(super) fn fill(unrolled: &mut Unrolled, default: [f32; 3]) {
    push_pull(&mut unrolled.color, &unrolled.known, Wrap { x: true, y: true }, default);
}

/// The mean colour of the image inside the mask; middle grey when the mask is empty.
pub(super) fn mean_color(image: &FrameImage, mask: &Mask) -> [f32; 3] {
    let (mut sum, mut count) = ([0u64; 3], 0u64);
    for (x, y, p) in image.enumerate_pixels() {
        if mask.at(x as isize, y as isize) {
            count += 1;
            for c in 0..3 {
                sum[c] += u64::from(p.0[c]);
            }
        }
    }
    if count == 0 { [128.0; 3] } else { sum.map(|s| (s as f64 / count as f64) as f32) }
}

fn bilinear(image: &FrameImage, at: Vec2) -> [f32; 3] {
    let (width, height) = image.dimensions();
    let x = (at.x - 0.5).clamp(0.0, width as f32 - 1.0);
    let y = (at.y - 0.5).clamp(0.0, height as f32 - 1.0);
    let (x0, y0) = (x as u32, y as u32);
    let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
    let texel = |x, y| Vec3::from(image.get_pixel(x, y).0.map(f32::from));
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    texel(x0, y0).lerp(texel(x1, y0), fx).lerp(texel(x0, y1).lerp(texel(x1, y1), fx), fy).to_array()
}

/// A piece of the clip's frame for a patch.
#[derive(Clone)]
pub(super) struct Crop {
    left: f32,
    top: f32,
    color: Vec<[f32; 3]>,
    width: usize,
    height: usize,
}

impl Crop {
    /// A clip pixel as a share of the crop.
    pub(super) fn share(&self, p: Vec2) -> Vec2 {
        (p - Vec2::new(self.left, self.top)) / Vec2::new(self.width as f32, self.height as f32)
    }
}

/// The frame's pixels around a patch of `part`; those of other parts and of the background are filled over.
pub(super) fn crop([left, top, right, bottom]: [f32; 4], part: u16, view: &View<'_>, default: [f32; 3]) -> Crop {
    let (left, top) = (left.floor(), top.floor());
    let (width, height) = ((right - left).ceil().max(1.0) as usize, (bottom - top).ceil().max(1.0) as usize);
    let mut known = Grid::new(width, height, false);
    let mut color = vec![[0.0; 3]; width * height];
    for y in 0..height {
        for x in 0..width {
            let (ix, iy) = (left as isize + x as isize, top as isize + y as isize);
            if well_inside(view.mask, ix, iy) && view.front.id.get(ix as usize, iy as usize) == part {
                color[y * width + x] = view.image.get_pixel(ix as u32, iy as u32).0.map(f32::from);
                known.set(x, y, true);
            }
        }
    }
    push_pull(&mut color, &known, Wrap::default(), default);
    Crop { left, top, color, width, height }
}

/// Where a block lies in an atlas, as shares of the atlas.
#[derive(Clone, Copy)]
pub(super) struct Block {
    corner: Vec2,
    size: Vec2,
}

impl Block {
    /// A share of the block as a share of the atlas.
    pub(super) fn place(&self, uv: Vec2) -> Vec2 {
        self.corner + uv * self.size
    }
}

/// One texture with the unrolled cylinder above and the patch's crop below, and where they lie in it.
pub(super) fn atlas(unrolled: &Unrolled, crop: Option<&Crop>) -> (RgbImage, Block, Option<Block>) {
    let gutter = GUTTER as usize;
    let (w, h) = (unrolled.known.width(), unrolled.known.height());
    let (cw, ch) = crop.map_or((0, 0), |c| (c.width + 2 * gutter, c.height + 2 * gutter));
    let mut image = RgbImage::new((w + 2 * gutter).max(cw) as u32, (h + 2 * gutter + ch) as u32);
    paste(&mut image, &unrolled.color, (w, h), (gutter, gutter), true);
    let size = Vec2::new(image.width() as f32, image.height() as f32);
    let block = |x: usize, y: usize, w: usize, h: usize| Block {
        corner: Vec2::new(x as f32, y as f32) / size,
        size: Vec2::new(w as f32, h as f32) / size,
    };
    let below = crop.map(|c| {
        let top = h + 3 * gutter;
        paste(&mut image, &c.color, (c.width, c.height), (gutter, top), false);
        block(gutter, top, c.width, c.height)
    });
    (image, block(gutter, gutter, w, h), below)
}

/// Copies a block and, around it, a gutter: its border repeated, or its other side where it wraps.
fn paste(image: &mut RgbImage, color: &[[f32; 3]], (w, h): (usize, usize), (left, top): (usize, usize), wrap: bool) {
    let gutter = GUTTER as isize;
    for y in -gutter..h as isize + gutter {
        for x in -gutter..w as isize + gutter {
            let sx = if wrap { x.rem_euclid(w as isize) } else { x.clamp(0, w as isize - 1) } as usize;
            let sy = y.clamp(0, h as isize - 1) as usize;
            let rgb = color[sy * w + sx].map(|v| v.round().clamp(0.0, 255.0) as u8);
            image.put_pixel((left as isize + x) as u32, (top as isize + y) as u32, Rgb(rgb));
        }
    }
}
