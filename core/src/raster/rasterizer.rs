//! A z-buffer rasterizer: textured, shaded triangle meshes to colour, depth and identity.
//!
//! Every pixel along a shared edge is covered exactly once ([`Cover`]); attributes are divided by w, so that a perspective
//! view is textured rightly.
//!
//! Limits: nothing is clipped against a near plane (a triangle with a corner behind the eye is left out); textures are
//! sampled without minification filter.

use glam::{Mat4, Vec2, Vec3, Vec4, vec3};
use image::{RgbImage, RgbaImage};

use super::Grid;
use super::cover::Cover;
use crate::geometry::TriMesh;

/// Share of light that falls on a face turned away from the lamp.
const AMBIENT: f32 = 0.55;
/// Where the lamp is, as the viewer sees it: over the left shoulder.
const LAMP: Vec3 = vec3(-0.35, 0.5, 0.79);

/// What a mesh looks like.
#[derive(Clone, Copy, Debug)]
pub enum Surface<'a> {
    /// Colours of the texture as they are.
    Flat(&'a RgbImage),
    /// Colours of the texture under a lamp.
    Lit(&'a RgbImage),
    /// One colour under a lamp.
    Clay([u8; 3]),
    /// Depth and identity only.
    Bare,
}

/// A picture being drawn.
#[derive(Clone, Debug)]
pub struct Rasterizer {
    /// Colours; transparent where nothing was drawn, unless cleared to something else.
    pub color: RgbaImage,
    /// Screen depth, larger is nearer; minus infinity where nothing was drawn.
    pub depth: Grid<f32>,
    /// The `id` of the mesh that was drawn there; [`Rasterizer::NOTHING`] elsewhere.
    pub id: Grid<u16>,
}

impl Rasterizer {
    /// Identity of pixels that no mesh covers.
    pub const NOTHING: u16 = u16::MAX;

    /// An empty, transparent picture.
    pub fn new(width: u32, height: u32) -> Self {
        let (w, h) = (width as usize, height as usize);
        Self {
            color: RgbaImage::new(width, height),
            depth: Grid::new(w, h, f32::NEG_INFINITY),
            id: Grid::new(w, h, Self::NOTHING),
        }
    }

    /// Empties the picture and fills it with one colour.
    pub fn clear(&mut self, background: [u8; 4]) {
        self.color.pixels_mut().for_each(|p| p.0 = background);
        self.depth.data_mut().fill(f32::NEG_INFINITY);
        self.id.data_mut().fill(Self::NOTHING);
    }

    /// Draws `mesh`. `view` takes world coordinates to the screen: after division by w, x right and y down in pixels,
    /// z growing toward the viewer (see [`clip_view`] and [`orbit_view`]). Faces turned away are drawn too: what hides
    /// them is nearer.
    pub fn draw(&mut self, mesh: &TriMesh, view: &Mat4, surface: Surface<'_>, id: u16) {
        let screen: Vec<Vec4> = mesh.positions.iter().map(|p| *view * p.extend(1.0)).collect();
        let light: Vec<f32> = match surface {
            Surface::Lit(_) | Surface::Clay(_) => mesh.normals.iter().map(|n| shade(view, *n)).collect(),
            Surface::Flat(_) | Surface::Bare => Vec::new(),
        };
        for triangle in &mesh.triangles {
            let corner = triangle.map(|i| i as usize);
            if corner.iter().any(|&i| i >= screen.len()) {
                continue;
            }
            let attribute = |i: usize| {
                let uv = mesh.uvs.get(i).copied().unwrap_or(Vec2::ZERO);
                vec3(uv.x, uv.y, light.get(i).copied().unwrap_or(1.0))
            };
            self.triangle(corner.map(|i| screen[i]), corner.map(attribute), surface, id);
        }
    }

    fn triangle(&mut self, corner: [Vec4; 3], attribute: [Vec3; 3], surface: Surface<'_>, id: u16) {
        if corner.iter().any(|c| !c.is_finite() || c.w <= 1e-6) {
            return;
        }
        let w = corner.map(|c| 1.0 / c.w);
        let at = [0, 1, 2].map(|i| corner[i].truncate() * w[i]);
        let (width, height) = (self.depth.width(), self.depth.height());
        let Some(cover) = Cover::new(at.map(Vec3::truncate), width, 0..height) else { return };
        let order = cover.order;
        let z = order.map(|i| at[i].z);
        let weighted = order.map(|i| attribute[i] * w[i]);
        let inverse = order.map(|i| w[i]);
        let scale = 1.0 / cover.area as f32;
        for line in cover.rows() {
            let span = cover.span(line);
            let mut next = cover.edges(span.start, line);
            for column in span {
                let e = next;
                for i in 0..3 {
                    next[i] += cover.right[i];
                }
                let share = [e[0] as f32 * scale, e[1] as f32 * scale, e[2] as f32 * scale];
                let depth = z[0] + (z[1] - z[0]) * share[1] + (z[2] - z[0]) * share[2];
                if depth <= self.depth.get(column, line) {
                    continue;
                }
                self.depth.set(column, line, depth);
                self.id.set(column, line, id);
                if matches!(surface, Surface::Bare) {
                    continue;
                }
                let one = inverse[0] * share[0] + inverse[1] * share[1] + inverse[2] * share[2];
                let a = (weighted[0] * share[0] + weighted[1] * share[1] + weighted[2] * share[2]) / one;
                let rgb = match surface {
                    Surface::Flat(texture) => sample(texture, Vec2::new(a.x, a.y)),
                    Surface::Lit(texture) => sample(texture, Vec2::new(a.x, a.y)) * a.z,
                    Surface::Clay(rgb) => Vec3::from(rgb.map(f32::from)) * a.z,
                    Surface::Bare => Vec3::ZERO,
                };
                // The cast cuts off at both ends.
                let rgb = rgb + 0.5;
                self.color.put_pixel(
                    column as u32,
                    line as u32,
                    image::Rgba([rgb.x as u8, rgb.y as u8, rgb.z as u8, 255]),
                );
            }
        }
    }
}

/// The view of the clip's own camera: world pixels, y up, to image pixels, y down.
pub fn clip_view(clip_height: u32) -> Mat4 {
    Mat4::from_translation(vec3(0.0, clip_height as f32, 0.0)) * Mat4::from_scale(vec3(1.0, -1.0, 1.0))
}

/// A view from another side: turned by `yaw` (to the right) and `pitch` (from above) degrees around `center`, with
/// `scale` screen pixels a world unit, `center` in the middle of a `width` x `height` picture. With a `distance` in
/// world units from the eye to the centre it is a perspective view, else a parallel one.
pub fn orbit_view(
    center: Vec3,
    yaw: f32,
    pitch: f32,
    scale: f32,
    distance: Option<f32>,
    (width, height): (u32, u32),
) -> Mat4 {
    let turn = Mat4::from_rotation_x(pitch.to_radians()) * Mat4::from_rotation_y(-yaw.to_radians());
    let lens = match distance {
        Some(d) if d > 0.0 => Mat4::from_cols_array(&[
            1.0,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0,
            -1.0 / d,
            0.0,
            0.0,
            0.0,
            1.0,
        ]),
        _ => Mat4::IDENTITY,
    };
    Mat4::from_translation(vec3(width as f32 / 2.0, height as f32 / 2.0, 0.0))
        * Mat4::from_scale(vec3(scale, -scale, scale))
        * lens
        * turn
        * Mat4::from_translation(-center)
}

/// How bright a face with this normal is under the lamp, on either of its sides.
fn shade(view: &Mat4, normal: Vec3) -> f32 {
    let mut n = view.transform_vector3(normal).normalize_or(Vec3::Z);
    n.y = -n.y;
    let n = if n.z < 0.0 { -n } else { n };
    AMBIENT + (1.0 - AMBIENT) * n.dot(LAMP.normalize_or(Vec3::Z)).max(0.0)
}

/// Bilinear colour at `uv` (0..=1, v down); the border is repeated.
fn sample(texture: &RgbImage, uv: Vec2) -> Vec3 {
    let (width, height) = texture.dimensions();
    if width == 0 || height == 0 {
        return Vec3::ZERO;
    }
    let x = (uv.x * width as f32 - 0.5).clamp(0.0, width as f32 - 1.0);
    let y = (uv.y * height as f32 - 0.5).clamp(0.0, height as f32 - 1.0);
    let (x0, y0) = (x as u32, y as u32);
    let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    let texel = |x, y| Vec3::from(texture.get_pixel(x, y).0.map(f32::from));
    texel(x0, y0).lerp(texel(x1, y0), fx).lerp(texel(x0, y1).lerp(texel(x1, y1), fx), fy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn quad(z: f32) -> TriMesh {
        TriMesh {
            positions: vec![vec3(2.0, 2.0, z), vec3(8.0, 2.0, z), vec3(8.0, 8.0, z), vec3(2.0, 8.0, z)],
            normals: vec![Vec3::Z; 4],
            uvs: vec![Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.0)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        }
    }

    #[test]
    fn nearer_hides_farther_and_pixels_are_exact() {
        let texture = RgbImage::from_pixel(1, 1, image::Rgb([10, 200, 30]));
        let mut picture = Rasterizer::new(10, 10);
        picture.draw(&quad(5.0), &clip_view(10), Surface::Flat(&texture), 1);
        picture.draw(&quad(-5.0), &clip_view(10), Surface::Clay([255, 0, 0]), 2);
        let covered = picture.id.data().iter().filter(|&&i| i == 1).count();
        assert_eq!(covered, 36);
        assert_eq!(picture.id.data().iter().filter(|&&i| i == 2).count(), 0);
        assert_eq!(picture.color.get_pixel(5, 5).0, [10, 200, 30, 255]);
        assert_eq!(picture.color.get_pixel(1, 5).0[3], 0);
        assert_eq!(picture.depth.get(2, 2), 5.0);
    }

    #[test]
    fn texture_is_upright_in_the_clip_view() {
        let texture = RgbImage::from_fn(6, 6, |x, y| image::Rgb([x as u8 * 40, y as u8 * 40, 0]));
        let mut picture = Rasterizer::new(10, 10);
        picture.draw(&quad(0.0), &clip_view(10), Surface::Flat(&texture), 0);
        for (x, y) in [(2, 2), (7, 2), (4, 6), (7, 7)] {
            assert_eq!(picture.color.get_pixel(x, y).0[..3], [(x as u8 - 2) * 40, (y as u8 - 2) * 40, 0]);
        }
    }

    #[test]
    fn a_perspective_view_enlarges_what_is_near() {
        let view = orbit_view(vec3(5.0, 5.0, 0.0), 0.0, 0.0, 1.0, Some(20.0), (40, 40));
        let count = |z| {
            let mut picture = Rasterizer::new(40, 40);
            picture.draw(&quad(z), &view, Surface::Bare, 0);
            picture.id.data().iter().filter(|&&i| i == 0).count()
        };
        assert_eq!(count(0.0), 36);
        assert!(count(8.0) > 80 && count(-20.0) < 16);
    }

    proptest! {
        /// Fans of triangles around a point inside cover each pixel of their square exactly as often as one square.
        #[test]
        fn shared_edges_leave_no_gap(x in 3.0f32..17.0, y in 3.0f32..17.0, yaw in 0f32..90.0) {
            let c = |x, y| vec3(x, y, 0.0);
            let fan = TriMesh {
                positions: vec![c(2.0, 2.0), c(18.0, 2.0), c(18.0, 18.0), c(2.0, 18.0), c(x, y)],
                triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
                ..TriMesh::default()
            };
            let view = Mat4::from_translation(c(10.0, 10.0)) * Mat4::from_rotation_z(yaw.to_radians())
                * Mat4::from_translation(c(-10.0, -10.0));
            let mut whole = Rasterizer::new(24, 24);
            whole.draw(&TriMesh { triangles: vec![[0, 1, 2], [0, 2, 3]], ..fan.clone() }, &view, Surface::Bare, 0);
            let mut each = vec![0u32; 24 * 24];
            for t in &fan.triangles {
                let mut one = Rasterizer::new(24, 24);
                one.draw(&TriMesh { triangles: vec![*t], ..fan.clone() }, &view, Surface::Bare, 0);
                for (n, id) in each.iter_mut().zip(one.id.data()) {
                    *n += u32::from(*id == 0);
                }
            }
            for (n, id) in each.iter().zip(whole.id.data()) {
                prop_assert_eq!(*n, u32::from(*id == 0));
            }
        }
    }
}
