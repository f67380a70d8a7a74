//! Textured triangles in the plane, painted one over the other: the far ones first.
//!
//! Colours are premultiplied by their opacity while they are sampled and laid over each other (Porter and Duff 1984,
//! "over"), and straight when they are handed out. Edges are smooth where the texture's opacity is: coverage itself is all
//! or nothing, each pixel along a shared edge once. Where pieces of one surface overlap by no more than rounding, a half
//! clear pixel would show twice; what shows a pixel's texel again is left out.
//!
//! Where a piece is shrunk, a pixel is the mean of several samples.
//!
//! Limits: pieces that are shrunk to less than a quarter are sampled too sparsely; give a texture that is scaled down.

use glam::{DVec2, Vec2, Vec4};
use image::{ImageBuffer, Rgba, RgbaImage};

use super::Grid;
use super::cover::Cover;

/// Rows painted at once: what they need stays in the processor's cache.
const BAND: usize = 64;
/// The value of full colour or opacity.
const FULL: f32 = 65_535.0;

/// What is less clear than this is opaque: means of opaque samples are rounded.
const OPAQUE: f32 = FULL - 0.5;
/// Samples of a shrunk pixel along each axis, at most.
const MOST_SAMPLES: f32 = 4.0;

/// A picture to paint with, with a clear rim around it.
#[derive(Clone, Debug)]
pub struct Texture {
    /// With the rim.
    size: [usize; 2],
    texels: Vec<[u16; 4]>,
    /// What part of the surface each pixel belongs to; without the rim.
    zones: Grid<u32>,
}

impl Texture {
    /// Of a picture with straight alpha, at `scale` times its size where that is less than 1. `zones` has the picture's
    /// size.
    pub fn new(picture: &RgbaImage, zones: &Grid<u32>, scale: f32) -> Self {
        let premultiplied: ImageBuffer<Rgba<f32>, Vec<f32>> =
            ImageBuffer::from_fn(picture.width(), picture.height(), |x, y| {
                let p = picture.get_pixel(x, y).0.map(f32::from);
                let a = p[3] / 255.0;
                Rgba([p[0] * a, p[1] * a, p[2] * a, p[3]].map(|v| v * (FULL / 255.0)))
            });
        let scaled = |n: u32| ((n as f32 * scale).ceil() as u32).max(1);
        let (width, height) = picture.dimensions();
        let (scaled, zones) = if scale < 1.0 && width > 0 && height > 0 {
            let (w, h) = (scaled(width), scaled(height));
            let at = |i: usize| {
                let p = |v: usize| (v as f32 + 0.5) / scale;
                zones.clamped(p(i % w as usize) as isize, p(i / w as usize) as isize)
            };
            let zones = Grid::from_vec(w as usize, h as usize, (0..(w * h) as usize).map(at).collect());
            (shrunk(&premultiplied, scale, (w, h)), zones)
        } else {
            (premultiplied, zones.clone())
        };
        let (w, h) = (scaled.width() as usize, scaled.height() as usize);
        let mut texels = vec![[0u16; 4]; (w + 2) * (h + 2)];
        for (row, to) in scaled.as_raw().chunks_exact(4 * w.max(1)).zip(texels.chunks_exact_mut(w + 2).skip(1)) {
            for (p, to) in row.chunks_exact(4).zip(&mut to[1..]) {
                *to = [0, 1, 2, 3].map(|c| (p[c] + 0.5) as u16);
            }
        }
        Self { size: [w + 2, h + 2], texels, zones }
    }

    /// The colour at a place in pixels, premultiplied, in 0..=[`FULL`]; clear outside.
    #[inline(always)]
    fn at(&self, p: Vec2) -> Vec4 {
        let axis = |v: f32, size: usize| {
            let v = (v + 0.5).max(0.0).min((size - 2) as f32 + 0.999);
            let low = v as usize;
            (low, v - low as f32)
        };
        let ((x, fx), (y, fy)) = (axis(p.x, self.size[0]), axis(p.y, self.size[1]));
        let texel = |i: usize| {
            let [r, g, b, a] = self.texels[i];
            Vec4::new(f32::from(r), f32::from(g), f32::from(b), f32::from(a))
        };
        let (i, below) = (y * self.size[0] + x, (y + 1) * self.size[0] + x);
        let (top, bottom) = (texel(i).lerp(texel(i + 1), fx), texel(below).lerp(texel(below + 1), fx));
        top.lerp(bottom, fy)
    }
}

/// A picture at `scale` times its size, below 1, each pixel the mean of what lies under it.
fn shrunk(
    picture: &ImageBuffer<Rgba<f32>, Vec<f32>>,
    scale: f32,
    (width, height): (u32, u32),
) -> ImageBuffer<Rgba<f32>, Vec<f32>> {
    // The last column and row may reach past the picture: there it is clear, which adds nothing.
    let row = weights(width, scale, picture.width());
    let column = weights(height, scale, picture.height());
    let mut narrow = ImageBuffer::from_pixel(width, picture.height(), Rgba([0.0f32; 4]));
    for (to, from) in narrow.rows_mut().zip(picture.rows()) {
        let from: Vec<Vec4> = from.map(|p| Vec4::from_array(p.0)).collect();
        for (p, (first, parts)) in to.zip(&row) {
            p.0 = parts.iter().zip(&from[*first..]).map(|(w, v)| *w * *v).sum::<Vec4>().to_array();
        }
    }
    ImageBuffer::from_fn(width, height, |x, y| {
        let (first, parts) = &column[y as usize];
        let at = |i: usize| Vec4::from_array(narrow.get_pixel(x, (first + i) as u32).0);
        Rgba(parts.iter().enumerate().map(|(i, w)| *w * at(i)).sum::<Vec4>().to_array())
    })
}

/// For each of `count` scaled pixels the first of `size` pixels under it and the share of each.
fn weights(count: u32, scale: f32, size: u32) -> Vec<(usize, Vec<f32>)> {
    (0..count)
        .map(|i| {
            let (from, to) = (f64::from(i) / f64::from(scale), f64::from(i + 1) / f64::from(scale));
            let (first, last) = (from as u32, (to.ceil() as u32).min(size));
            let share = |j: u32| ((f64::from(j + 1).min(to) - f64::from(j).max(from)).max(0.0) / (to - from)) as f32;
            (first as usize, (first..last).map(share).collect())
        })
        .collect()
}

/// A triangle of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Where its corners are in the picture, in pixels.
    pub at: [Vec2; 3],
    /// And in the texture, in its pixels.
    pub uv: [Vec2; 3],
    /// How opaque it is at its corners; what is less than 1 fades out what is opaque.
    pub opacity: [f32; 3],
    /// The zones of the texture that it shows; [`Piece::ALL`] for all.
    pub zones: [u32; 3],
}

impl Piece {
    /// No choice of zones.
    pub const ALL: [u32; 3] = [u32::MAX; 3];
}

/// Paints the pieces in their order over a background with straight alpha, and gives straight alpha.
pub fn paint(pieces: &[Piece], texture: &Texture, (width, height): (u32, u32), background: [u8; 4]) -> RgbaImage {
    let (columns, rows) = (width as usize, height as usize);
    let mut out = RgbaImage::from_pixel(width, height, Rgba(background));
    let ground = Vec4::from_array(background.map(f32::from)) * (FULL / 255.0);
    let ground = (ground.truncate() * (ground.w / FULL)).extend(ground.w);
    let mut band = Band { columns, first: 0, color: Vec::new(), shown: Vec::new() };
    for first in (0..rows).step_by(BAND) {
        let last = (first + BAND).min(rows);
        band.begin(first, last);
        for piece in pieces {
            if let Some(cover) = Cover::new(piece.at, columns, first..last) {
                band.paint(piece, &cover, texture);
            }
        }
        let lines = &mut out.as_mut()[first * columns * 4..last * columns * 4];
        for (to, color) in lines.chunks_exact_mut(4).zip(&band.color) {
            if color.w > 0.0 {
                to.copy_from_slice(&straight(*color + ground * (1.0 - color.w / FULL)));
            }
        }
    }
    out
}

#[inline]
fn straight(color: Vec4) -> [u8; 4] {
    let alpha = color.w * (255.0 / FULL) + 0.5;
    if alpha < 1.0 {
        return [0; 4];
    }
    let rgb = color * (255.0 / color.w) + 0.5;
    [rgb.x as u8, rgb.y as u8, rgb.z as u8, alpha as u8]
}

/// Some rows being painted.
struct Band {
    columns: usize,
    first: usize,
    color: Vec<Vec4>,
    /// The texel that a pixel last showed half clear, column and row in 16 bits each.
    shown: Vec<u32>,
}

/// Changes evenly over a triangle.
struct Slope {
    value: DVec2,
    right: DVec2,
    down: DVec2,
}

impl Slope {
    /// Of what has these values at the corners; `None` without area.
    fn new(at: [Vec2; 3], values: [Vec2; 3]) -> Option<Self> {
        let [a, b, c] = at.map(|p| p.as_dvec2());
        let [u, v, w] = values.map(|p| p.as_dvec2());
        let (ab, ac, uv, uw) = (b - a, c - a, v - u, w - u);
        let area = ab.perp_dot(ac);
        let right = (uv * ac.y - uw * ab.y) / area;
        let down = (uw * ab.x - uv * ac.x) / area;
        (right.is_finite() && down.is_finite()).then(|| Self { value: u - right * a.x - down * a.y, right, down })
    }

    fn at(&self, x: usize, y: usize) -> Vec2 {
        (self.value + self.right * (x as f64 + 0.5) + self.down * (y as f64 + 0.5)).as_vec2()
    }
}

impl Band {
    fn begin(&mut self, first: usize, last: usize) {
        let pixels = (last - first) * self.columns;
        self.first = first;
        self.color.clear();
        self.color.resize(pixels, Vec4::ZERO);
        self.shown.clear();
        self.shown.resize(pixels, u32::MAX);
    }

    fn paint(&mut self, piece: &Piece, cover: &Cover, texture: &Texture) {
        let Some(place) = Slope::new(piece.at, piece.uv) else { return };
        let (step, down) = (place.right.as_vec2(), place.down.as_vec2());
        // Up to a quarter more than a texel a pixel, one sample sees all.
        let samples = |way: Vec2| (way.length() - 0.25).ceil().clamp(1.0, MOST_SAMPLES) as usize;
        let (across, along) = (samples(step), samples(down));
        let share = 1.0 / (across * along) as f32;
        // Snapped corners lie a little outside the triangle, which a sliver would magnify.
        let [a, b, c] = piece.uv;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let whole = piece.opacity == [1.0; 3];
        let fade = Slope::new(piece.at, piece.opacity.map(|o| Vec2::new(o, 0.0)));
        let anywhere = piece.zones == Piece::ALL;
        for y in cover.rows() {
            let span = cover.span(y);
            let from = place.at(span.start, y);
            let line = (y - self.first) * self.columns;
            let pixels = self.color[line + span.start..line + span.end].iter_mut();
            let shown = self.shown[line + span.start..line + span.end].iter_mut();
            for (k, (pixel, shown)) in pixels.zip(shown).enumerate() {
                let uv = (from + step * k as f32).clamp(low, high);
                let mut color = if across * along == 1 {
                    texture.at(uv)
                } else {
                    let inside = |i: usize, of: usize| (i as f32 + 0.5) / of as f32 - 0.5;
                    let sample = |i: usize| {
                        let way = step * inside(i % across, across) + down * inside(i / across, along);
                        texture.at((uv + way).clamp(low, high))
                    };
                    (0..across * along).map(sample).sum::<Vec4>() * share
                };
                if !anywhere {
                    let zone = texture.zones.clamped(uv.x as isize, uv.y as isize);
                    if !piece.zones.contains(&zone) {
                        continue;
                    }
                }
                if !whole {
                    let fade = fade.as_ref().map_or(0.0, |f| f.at(span.start + k, y).x.clamp(0.0, 1.0));
                    // What is half clear itself is there already, from the piece beside this one.
                    color *= if color.w < OPAQUE { 0.0 } else { fade };
                }
                if color.w >= OPAQUE {
                    *pixel = color;
                } else if color.w > 0.0 {
                    if whole {
                        let texel = (uv.x as u32 & 0xffff) | (uv.y as u32) << 16;
                        if is_near(*shown, texel) {
                            continue;
                        }
                        *shown = texel;
                    }
                    *pixel = color + *pixel * (1.0 - color.w / FULL);
                }
            }
        }
    }
}

/// Whether two packed texels are the same or neighbours.
#[inline]
fn is_near(a: u32, b: u32) -> bool {
    (a & 0xffff).abs_diff(b & 0xffff) <= 1 && (a >> 16).abs_diff(b >> 16) <= 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;
    use proptest::prelude::*;

    fn no_zones(width: usize, height: usize) -> Grid<u32> {
        Grid::new(width, height, 0)
    }

    fn whole(at: [Vec2; 3], uv: [Vec2; 3]) -> Piece {
        Piece { at, uv, opacity: [1.0; 3], zones: Piece::ALL }
    }

    fn noisy() -> RgbaImage {
        RgbaImage::from_fn(24, 24, |x, y| {
            let n = x.wrapping_mul(747_796_405).wrapping_add(y.wrapping_mul(2_891_336_453)) >> 7;
            let ring = x.min(y).min(23 - x).min(23 - y);
            Rgba([n as u8, (n >> 5) as u8, (n >> 9) as u8, (85 * ring.min(3)) as u8])
        })
    }

    proptest! {
        /// However a surface is cut into triangles, nothing shows of it, be it opaque or half clear.
        #[test]
        fn cuts_do_not_show(x in 2.0f32..22.0, y in 2.0f32..22.0, shift in 0.0f32..1.0) {
            let picture = noisy();
            let texture = Texture::new(&picture, &no_zones(24, 24), 1.0);
            let c = [vec2(0.0, 0.0), vec2(24.0, 0.0), vec2(24.0, 24.0), vec2(0.0, 24.0)];
            let fan = |middle: Vec2| (0..4).map(move |i| [c[i], c[(i + 1) % 4], middle]);
            let drawn = |middle: Vec2, shift: Vec2| {
                let pieces: Vec<Piece> = fan(middle).map(|t| whole(t.map(|p| p + shift), t)).collect();
                paint(&pieces, &texture, (25, 25), [0; 4])
            };
            let (one, other) = (drawn(vec2(x, y), vec2(shift, shift)), drawn(vec2(12.0, 12.0), vec2(shift, shift)));
            for (a, b) in one.pixels().zip(other.pixels()) {
                prop_assert!(a.0[3].abs_diff(b.0[3]) <= 1, "{:?} {:?}", a, b);
            }
            let still = drawn(vec2(x, y), Vec2::ZERO);
            for (x, y, p) in picture.enumerate_pixels() {
                let got = still.get_pixel(x, y).0;
                prop_assert!(p.0[3] == 0 || (0..4).all(|i| got[i].abs_diff(p.0[i]) <= 1), "{:?} {:?}", got, p);
            }
        }
    }

    #[test]
    fn what_is_nearer_hides_and_half_clear_edges_mix() {
        let red = RgbaImage::from_pixel(8, 8, Rgba([255, 0, 0, 255]));
        let texture = Texture::new(&red, &no_zones(8, 8), 1.0);
        let square = |x: f32| {
            let at = [vec2(x, 0.0), vec2(x + 8.0, 0.0), vec2(x, 8.0)];
            whole(at, [vec2(0.0, 0.0), vec2(8.0, 0.0), vec2(0.0, 8.0)])
        };
        let shown = paint(&[square(0.5)], &texture, (12, 8), [0, 0, 255, 255]);
        assert_eq!(shown.get_pixel(2, 2).0, [255, 0, 0, 255]);
        assert_eq!(shown.get_pixel(11, 2).0, [0, 0, 255, 255]);
        // Half a pixel of red over blue.
        assert_eq!(shown.get_pixel(0, 2).0, [128, 0, 128, 255]);
        // Over nothing its colour stays and its opacity is a half.
        assert_eq!(paint(&[square(0.5)], &texture, (12, 8), [0; 4]).get_pixel(0, 2).0, [255, 0, 0, 128]);
        let far = whole([vec2(f32::NAN, 0.0), vec2(1e9, 0.0), vec2(0.0, 1e9)], [Vec2::ZERO; 3]);
        assert!(paint(&[far], &texture, (12, 8), [0; 4]).pixels().all(|p| p.0 == [0; 4]));
    }

    #[test]
    fn a_smaller_texture_is_the_mean_of_what_lies_under_it() {
        let fine =
            RgbaImage::from_fn(
                9,
                6,
                |x, y| {
                    if (x + y) % 2 == 0 { Rgba([200, 100, 0, 255]) } else { Rgba([7, 7, 7, 0]) }
                },
            );
        let texture = Texture::new(&fine, &no_zones(9, 6), 0.5);
        let at = [vec2(0.0, 0.0), vec2(10.0, 0.0), vec2(0.0, 10.0)];
        let shown = paint(&[whole(at, at)], &texture, (5, 3), [0; 4]);
        assert_eq!(shown.get_pixel(1, 1).0, [200, 100, 0, 128]);
        // Only half of the last column lies over the picture.
        assert_eq!(shown.get_pixel(4, 1).0, [200, 100, 0, 64]);
        // A scale at which nothing is left.
        assert_eq!(Texture::new(&fine, &no_zones(9, 6), 1e-40).size, [3, 3]);
    }
}
