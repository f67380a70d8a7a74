//! A triangle mesh with texture coordinates.

use glam::{Vec2, Vec3};

/// Vertices, one normal and one texture coordinate each (v down, as glTF has it), and triangles,
/// counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals, as many as positions.
    pub normals: Vec<Vec3>,
    /// Texture coordinates in 0..=1, as many as positions.
    pub uvs: Vec<Vec2>,
    /// Vertex indices, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// For each vertex the first one at the same place: what vertices that a texture's seam doubles are on the surface.
    /// The triangles over these are closed where the surface is.
    pub fn surface(&self) -> Vec<u32> {
        let key = |v: u32| self.positions[v as usize].to_array().map(f32::to_bits);
        let mut by_place: Vec<u32> = (0..self.positions.len() as u32).collect();
        by_place.sort_by_key(|&v| (key(v), v));
        let mut out = vec![0; self.positions.len()];
        let mut first = 0;
        for (i, &v) in by_place.iter().enumerate() {
            if i == 0 || key(by_place[i - 1]) != key(v) {
                first = v;
            }
            out[v as usize] = first;
        }
        out
    }

    /// Vertex normals: the mean of those of the triangles around each place, by area.
    pub fn smooth_normals(&self) -> Vec<Vec3> {
        let surface = self.surface();
        let mut sum = vec![Vec3::ZERO; self.positions.len()];
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            let area = (b - a).cross(c - a);
            for v in t {
                sum[surface[*v as usize] as usize] += area;
            }
        }
        surface.iter().map(|&s| sum[s as usize].normalize_or(Vec3::Z)).collect()
    }
}
