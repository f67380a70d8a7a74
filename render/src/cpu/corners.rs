//! Triangles on the screen: moved by bones, coloured, and cut where they pass behind the eye.

use std::ops::Range;

use glam::{Mat4, Vec2, Vec3, Vec4, vec2};
use marey::shape::SkinnedPart;
use rayon::prelude::*;

use crate::Style;
use crate::bone_shapes::Corner as ShapeCorner;
use crate::model::blend;
use crate::picture::View;
use crate::shading::{CLAY, light};

/// A corner before projection.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    clip: Vec4,
    tint: Vec3,
    uv: Vec2,
}

/// A corner on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Where, in samples, y down.
    pub(super) at: Vec2,
    /// How far, 0 nearest to 1.
    pub(super) depth: f32,
    /// One over w.
    pub(super) inverse_w: f32,
    pub(super) tint: Vec3,
    pub(super) uv: Vec2,
}

/// All triangles of a picture in the order in which they are drawn.
#[derive(Debug)]
pub(super) struct Corners {
    corners: Vec<Corner>,
    triangles: Vec<[u32; 3]>,
    projection: Mat4,
    /// In samples.
    size: Vec2,
}

impl Corners {
    pub(super) fn new((width, height): (u32, u32), fine: u32, projection: &Mat4) -> Self {
        let size = vec2((width * fine) as f32, (height * fine) as f32);
        Self { corners: Vec::new(), triangles: Vec::new(), projection: *projection, size }
    }

    pub(super) fn triangle(&self, triangle: u32) -> [&Corner; 3] {
        self.triangles[triangle as usize].map(|corner| &self.corners[corner as usize])
    }

    /// Adds a surface where these matrices take it; says which triangles that makes.
    pub(super) fn add_surface(
        &mut self,
        part: &SkinnedPart,
        skin: &[Mat4],
        colors: Option<&[[u8; 4]]>,
        style: Style,
        view: &View,
    ) -> Range<usize> {
        let vertex = |v: usize| {
            let moved = blend(part, v, skin);
            let place = moved.transform_point3(part.mesh.positions[v]);
            let normal = || {
                let normal = moved.transform_vector3(part.mesh.normals[v]);
                view.turn.transform_vector3(normal).normalize_or(Vec3::Z)
            };
            let tint = match style {
                Style::Textured => Vec3::ONE,
                Style::Shaded => Vec3::splat(light(normal())),
                Style::Wireframe => CLAY * light(normal()),
                Style::Normals => normal() * 0.5 + 0.5,
                Style::Depth => {
                    let z = view.turn.transform_point3(place).z;
                    Vec3::splat(((z - view.tones.1) / (view.tones.0 - view.tones.1)).clamp(0.0, 1.0))
                }
                Style::Radius | Style::Bones => {
                    let [r, g, b, _] = colors.map_or([255; 4], |c| c[v]).map(|c| f32::from(c) / 255.0);
                    Vec3::new(r, g, b) * light(normal())
                }
            };
            Vertex { clip: self.projection * place.extend(1.0), tint, uv: part.mesh.uvs[v] }
        };
        let vertices: Vec<Vertex> = (0..part.mesh.positions.len()).into_par_iter().map(vertex).collect();
        self.add(&vertices, part.mesh.triangles.iter().copied())
    }

    /// Adds a surface without colours.
    pub(super) fn add_flat(&mut self, part: &SkinnedPart, skin: &[Mat4]) -> Range<usize> {
        let vertex = |v: usize| {
            let place = blend(part, v, skin).transform_point3(part.mesh.positions[v]);
            Vertex { clip: self.projection * place.extend(1.0), tint: Vec3::ZERO, uv: Vec2::ZERO }
        };
        let vertices: Vec<Vertex> = (0..part.mesh.positions.len()).into_par_iter().map(vertex).collect();
        self.add(&vertices, part.mesh.triangles.iter().copied())
    }

    /// Adds triangles of one corner after the other.
    pub(super) fn add_shapes(&mut self, shapes: &[ShapeCorner]) -> Range<usize> {
        let vertex =
            |c: &ShapeCorner| Vertex { clip: self.projection * c.at.extend(1.0), tint: c.color, uv: Vec2::ZERO };
        let vertices: Vec<Vertex> = shapes.iter().map(vertex).collect();
        self.add(&vertices, (0..vertices.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]))
    }

    fn add(&mut self, vertices: &[Vertex], triangles: impl Iterator<Item = [u32; 3]>) -> Range<usize> {
        let (first, base) = (self.triangles.len(), self.corners.len() as u32);
        self.corners.extend(vertices.iter().map(|v| project(v, self.size)));
        for triangle in triangles {
            let inside = triangle.map(|v| is_before(&vertices[v as usize]));
            if inside == [true; 3] {
                self.triangles.push(triangle.map(|v| base + v));
            } else if inside != [false; 3] {
                self.cut(triangle.map(|v| vertices[v as usize]));
            }
        }
        first..self.triangles.len()
    }

    /// Adds what of a triangle lies before the near plane (Sutherland and Hodgman, for one plane).
    fn cut(&mut self, triangle: [Vertex; 3]) {
        let mut polygon: Vec<Vertex> = Vec::with_capacity(4);
        for i in 0..3 {
            let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
            if is_before(&a) {
                polygon.push(a);
            }
            if is_before(&a) != is_before(&b) {
                let share = a.clip.z / (a.clip.z - b.clip.z);
                polygon.push(Vertex {
                    clip: a.clip.lerp(b.clip, share),
                    tint: a.tint.lerp(b.tint, share),
                    uv: a.uv.lerp(b.uv, share),
                });
            }
        }
        let base = self.corners.len() as u32;
        self.corners.extend(polygon.iter().map(|v| project(v, self.size)));
        self.triangles.extend((2..polygon.len() as u32).map(|i| [base, base + i - 1, base + i]));
    }

    /// For each band of so many rows of samples the triangles that reach it, in their order.
    pub(super) fn bins(&self, rows: u32) -> Vec<Vec<u32>> {
        let bands = (self.size.y as u32).div_ceil(rows) as usize;
        let mut bins = vec![Vec::new(); bands];
        for (t, triangle) in self.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| self.corners[v as usize].at);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            // Written so that what is no number is outside.
            if !(high.x >= 0.0 && low.x <= self.size.x && high.y >= 0.0 && low.y <= self.size.y) {
                continue;
            }
            // The casts cut off at both ends; corners are snapped, by less than a sample.
            let from = (low.y - 1.0) as u32 / rows;
            let to = ((high.y + 1.0) as u32 / rows).min(bands as u32 - 1);
            bins[from as usize..=to as usize].iter_mut().for_each(|bin| bin.push(t as u32));
        }
        bins
    }
}

fn is_before(vertex: &Vertex) -> bool {
    vertex.clip.z >= 0.0
}

fn project(vertex: &Vertex, size: Vec2) -> Corner {
    let inverse_w = 1.0 / vertex.clip.w;
    let at = vertex.clip.truncate() * inverse_w;
    Corner { at: vec2(at.x + 1.0, 1.0 - at.y) * size / 2.0, depth: at.z, inverse_w, tint: vertex.tint, uv: vertex.uv }
}
