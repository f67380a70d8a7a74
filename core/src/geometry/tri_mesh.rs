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
    /// Vertex normals: the mean of the triangles around each place, by area. Vertices at the same place (a seam) share it.
    pub fn smooth_normals(&self) -> Vec<Vec3> {
        let mut by_place: Vec<usize> = (0..self.positions.len()).collect();
        let key = |i: usize| self.positions[i].to_array().map(f32::to_bits);
        by_place.sort_by_key(|&i| key(i));
        let mut leader = vec![0usize; self.positions.len()];
        for pair in 0..by_place.len() {
            let i = by_place[pair];
            leader[i] = if pair > 0 && key(by_place[pair - 1]) == key(i) { leader[by_place[pair - 1]] } else { i };
        }
        let mut sum = vec![Vec3::ZERO; self.positions.len()];
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| self.positions[i as usize]);
            let area = (b - a).cross(c - a);
            for i in t {
                sum[leader[*i as usize]] += area;
            }
        }
        leader.iter().map(|&l| sum[l].normalize_or(Vec3::Z)).collect()
    }
}
