//! Numbers on a regular grid in space, and what lies between them by trilinear interpolation.

use glam::{Vec3, vec3};

/// Samples at the points `origin + cell * (x, y, z)`. A signed distance is negative inside, in the units of `cell`.
#[derive(Clone, Debug, PartialEq)]
pub struct Field3 {
    /// How many samples along x, y and z.
    pub dims: [usize; 3],
    /// Where the first sample lies.
    pub origin: Vec3,
    /// The distance between neighbouring samples.
    pub cell: f32,
    /// The samples: x runs fastest, then y, then z.
    pub values: Vec<f32>,
}

impl Field3 {
    /// A field that is `value` everywhere.
    pub fn new(dims: [usize; 3], origin: Vec3, cell: f32, value: f32) -> Self {
        Self { dims, origin, cell, values: vec![value; dims.iter().product()] }
    }

    /// Where sample (x, y, z) is in `values`.
    pub fn index(&self, x: usize, y: usize, z: usize) -> usize {
        (z * self.dims[1] + y) * self.dims[0] + x
    }

    /// Sample (x, y, z).
    pub fn get(&self, x: usize, y: usize, z: usize) -> f32 {
        self.values[self.index(x, y, z)]
    }

    /// Where sample (x, y, z) lies.
    pub fn position(&self, x: usize, y: usize, z: usize) -> Vec3 {
        self.origin + self.cell * vec3(x as f32, y as f32, z as f32)
    }

    /// The value at `point`, or that of the nearest point of the grid when it lies outside.
    ///
    /// # Panics
    /// When the grid has fewer than two samples along an axis.
    pub fn sample(&self, point: Vec3) -> f32 {
        let local = ((point - self.origin) / self.cell).to_array();
        let (mut first, mut share) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            let at = local[axis].clamp(0.0, (self.dims[axis] - 1) as f32);
            first[axis] = (at as usize).min(self.dims[axis] - 2);
            share[axis] = at - first[axis] as f32;
        }
        trilinear(&self.corners(first), Vec3::from_array(share)).0
    }

    /// The eight samples around the cell whose lowest is `at`; bits 0, 1 and 2 of a corner's number are its steps along
    /// x, y and z.
    pub(super) fn corners(&self, at: [usize; 3]) -> [f32; 8] {
        let first = self.index(at[0], at[1], at[2]);
        let (row, plane) = (self.dims[0], self.dims[0] * self.dims[1]);
        std::array::from_fn(|c| self.values[first + (c & 1) + (c >> 1 & 1) * row + (c >> 2) * plane])
    }
}

/// The value and its slope a cell at `share` of the way through a cell.
pub(super) fn trilinear(corners: &[f32; 8], share: Vec3) -> (f32, Vec3) {
    let c = corners;
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let Vec3 { x, y, z } = share;
    let along_x: [f32; 4] = std::array::from_fn(|i| mix(c[2 * i], c[2 * i + 1], x));
    let steps: [f32; 4] = std::array::from_fn(|i| c[2 * i + 1] - c[2 * i]);
    let (low, high) = (mix(along_x[0], along_x[1], y), mix(along_x[2], along_x[3], y));
    let slope = vec3(
        mix(mix(steps[0], steps[1], y), mix(steps[2], steps[3], y), z),
        mix(along_x[1] - along_x[0], along_x[3] - along_x[2], z),
        high - low,
    );
    (mix(low, high, z), slope)
}
