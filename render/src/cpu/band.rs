//! Some rows of a picture being filled.

use std::ops::Range;

use glam::{Vec2, Vec4};
use marey::raster::Cover;

use super::corners::Corner;
use crate::Style;
use crate::shading::{CROWDED, FAINTEST, HALF_LINE, LINE};
use crate::texture::Texture;

/// What a triangle is filled with.
#[derive(Clone, Copy, Debug)]
pub(super) enum Material<'a> {
    /// The shadow's colour, before all else.
    Shadow,
    /// Its corners' colours.
    Painted,
    /// The same times those of a texture.
    Textured(&'a Texture),
    /// The same with dark edges.
    Edged,
    /// Its corners' colours, whatever is nearer, where it faces the viewer.
    InFront,
}

impl<'a> Material<'a> {
    pub(super) fn surface(style: Style, texture: &'a Texture) -> Self {
        match style {
            Style::Wireframe => Self::Edged,
            _ if style.is_textured() => Self::Textured(texture),
            _ => Self::Painted,
        }
    }
}

/// Some rows of samples.
#[derive(Debug, Default)]
pub(super) struct Band {
    columns: usize,
    rows: Range<usize>,
    /// Premultiplied.
    color: Vec<[u8; 4]>,
    depth: Vec<f32>,
}

impl Band {
    pub(super) fn begin(&mut self, columns: usize, rows: Range<usize>, clear: Vec4) {
        let samples = columns * rows.len();
        (self.columns, self.rows) = (columns, rows);
        self.color.clear();
        self.color.resize(samples, bytes(clear));
        self.depth.clear();
        self.depth.resize(samples, f32::INFINITY);
    }

    /// Fills a triangle, `fine` samples a pixel along each axis.
    pub(super) fn fill(&mut self, corner: [&Corner; 3], material: &Material<'_>, shadow: Vec4, fine: f32) {
        let at = corner.map(|c| c.at);
        let Some(cover) = Cover::new(at, self.columns, self.rows.clone()) else { return };
        // Counter-clockwise goes the other way with y down.
        if matches!(material, Material::InFront) && (at[1] - at[0]).perp_dot(at[2] - at[0]) >= 0.0 {
            return;
        }
        let shadow = bytes(shadow);
        let corner = cover.order.map(|i| corner[i]);
        let depth = corner.map(|c| c.depth);
        let inverse = corner.map(|c| c.inverse_w);
        let tint = corner.map(|c| c.tint * c.inverse_w);
        let uv = corner.map(|c| c.uv * c.inverse_w);
        let scale = 1.0 / cover.area as f32;
        let level = if let Material::Textured(texture) = material { level(corner, texture, fine) } else { 0.0 };
        let heights = heights(corner, fine);
        for y in cover.rows() {
            let span = cover.span(y);
            let mut next = cover.edges(span.start, y);
            let line = (y - self.rows.start) * self.columns;
            for sample in line + span.start..line + span.end {
                let share = next.map(|e| e as f32 * scale);
                for (edge, right) in next.iter_mut().zip(cover.right) {
                    *edge += right;
                }
                let mix = |of: [f32; 3]| of[0] * share[0] + of[1] * share[1] + of[2] * share[2];
                match material {
                    Material::Shadow => {
                        self.color[sample] = shadow;
                        continue;
                    }
                    Material::InFront => {}
                    _ => {
                        let depth = mix(depth);
                        if depth >= self.depth[sample] {
                            continue;
                        }
                        self.depth[sample] = depth;
                    }
                }
                let w = 1.0 / mix(inverse);
                let tint = (tint[0] * share[0] + tint[1] * share[1] + tint[2] * share[2]) * w;
                let color = match material {
                    Material::Textured(texture) => {
                        let uv = (uv[0] * share[0] + uv[1] * share[1] + uv[2] * share[2]) * w;
                        tint * texture.at(uv, level)
                    }
                    Material::Edged => tint.lerp(LINE, line_at(share, heights)),
                    _ => tint,
                };
                self.color[sample] = bytes(color.extend(1.0));
            }
        }
    }

    /// Writes rows of straight alpha, each pixel the mean of `fine` x `fine` samples.
    pub(super) fn resolve(&self, out: &mut [u8], fine: usize) {
        let columns = self.columns / fine;
        for (y, line) in out.chunks_exact_mut(4 * columns).enumerate() {
            for (x, pixel) in line.chunks_exact_mut(4).enumerate() {
                let mut sum = [0_u32; 4];
                for dy in 0..fine {
                    let at = (y * fine + dy) * self.columns + x * fine;
                    for sample in &self.color[at..at + fine] {
                        for c in 0..4 {
                            sum[c] += u32::from(sample[c]);
                        }
                    }
                }
                let count = (fine * fine) as u32;
                for c in 0..3 {
                    // Where nothing covers there is no colour.
                    let mean = (sum[c] * 255 + sum[3] / 2).checked_div(sum[3]).unwrap_or(0);
                    pixel[c] = mean.min(255) as u8;
                }
                pixel[3] = ((sum[3] + count / 2) / count) as u8;
            }
        }
    }
}

/// Which version of a texture shows a triangle: the one whose pixels are as large as the picture's.
fn level(corner: [&Corner; 3], texture: &Texture, fine: f32) -> f32 {
    let (w, h) = texture.levels[0].dimensions();
    let texels = Vec2::new(w as f32, h as f32);
    let [a, b, c] = corner.map(|c| c.at / fine);
    let [p, q, r] = corner.map(|c| c.uv * texels);
    let (ab, ac) = (b - a, c - a);
    let area = ab.perp_dot(ac);
    let right = ((q - p) * ac.y - (r - p) * ab.y) / area;
    let down = ((r - p) * ab.x - (q - p) * ac.x) / area;
    let step = right.length().max(down.length());
    if step > 1.0 { step.log2().min(16.0) } else { 0.0 }
}

/// How far each corner is from the edge across, in pixels.
fn heights(corner: [&Corner; 3], fine: f32) -> [f32; 3] {
    let [a, b, c] = corner.map(|c| c.at / fine);
    let area = (b - a).perp_dot(c - a).abs();
    [b.distance(c), c.distance(a), a.distance(b)].map(|edge| area / edge.max(1e-6))
}

/// How much of the line along the edges a sample has.
fn line_at(share: [f32; 3], heights: [f32; 3]) -> f32 {
    let nearest = (0..3).map(|i| share[i] * heights[i]).fold(f32::INFINITY, f32::min);
    let lowest = heights.into_iter().fold(f32::INFINITY, f32::min);
    let strength = (lowest / CROWDED).clamp(FAINTEST, 1.0);
    strength * (HALF_LINE + 0.5 - nearest).clamp(0.0, 1.0)
}

fn bytes(color: Vec4) -> [u8; 4] {
    // The cast cuts off at both ends.
    color.to_array().map(|c| (c * 255.0 + 0.5) as u8)
}
