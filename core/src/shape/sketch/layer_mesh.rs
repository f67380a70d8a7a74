//! The mesh of a layer's region, and where places hang on it.

use glam::{DVec2, Vec2};

use super::region::RegionGrid;
use crate::deform::stroke_preserving::embedding::{self, Finder};
use crate::error::{Error, Result};
use crate::geometry::PlaneMesh;
use crate::raster::Mask;

/// An edge is at most so many times as long as the region goes beyond the ink: strips along single lines are twice that
/// wide, and longer edges leave holes in them.
const LONGEST: f32 = 2.0;
/// Finer meshes than this share of that cost time and show nothing.
const SHORTEST: f32 = 0.8;

/// The length of the edges, in cells, of a mesh of the region with about `vertices` vertices.
pub(super) fn spacing(grid: &RegionGrid, region: &Mask, vertices: usize) -> f32 {
    let area = region.count() as f32;
    let along = |o: &Vec<Vec2>| o.iter().zip(o.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum::<f32>();
    let rim: f32 = grid.outlines(region).iter().map(along).sum();
    // Inside, a vertex has the area of two equilateral triangles; on the rim, half of that.
    let n = vertices.max(1) as f32;
    let spacing = (0.5 * rim + (0.25 * rim * rim + 4.0 * n * area / 0.866).sqrt()) / (2.0 * n);
    spacing.clamp(SHORTEST * grid.expanded(), LONGEST * grid.expanded())
}

/// A mesh on which places hang.
#[derive(Debug)]
pub(super) struct LayerMesh {
    pub(super) mesh: PlaneMesh,
    rest: Vec<DVec2>,
    finder: Finder,
    edge: f64,
}

/// Where a place hangs: what it has of the corners of a triangle, and what is left of its way to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) corners: [u32; 3],
    weights: [f32; 3],
    beyond: Vec2,
}

impl Place {
    /// Where it is when the mesh's vertices are at `points`.
    #[inline]
    pub(super) fn at(&self, points: &[Vec2]) -> Vec2 {
        let [a, b, c] = self.corners.map(|v| points[v as usize]);
        let [u, v, w] = self.weights;
        a * u + b * v + c * w + self.beyond
    }
}

impl LayerMesh {
    /// The mesh of a region with edges of `spacing` cells.
    pub(super) fn new(grid: &RegionGrid, region: &Mask, spacing: f32) -> Result<Self> {
        let outlines = grid.outlines(region);
        // A rim that touches itself at one spacing does not at a finer one.
        let found = [1.0, 0.7, 0.5].into_iter().map(|finer| PlaneMesh::within(&outlines, |_| finer * spacing));
        let Some(mut mesh) = found.into_iter().find(|m| !m.triangles.is_empty()) else {
            let problem = "their outline cannot be meshed";
            return Err(Error::invalid("strokes of a layer", problem, "draw them apart, or in another layer"));
        };
        mesh.points.iter_mut().for_each(|p| *p = grid.place(*p));
        let rest: Vec<DVec2> = mesh.points.iter().map(|p| p.as_dvec2()).collect();
        let edge = f64::from(spacing * grid.cell);
        let finder = Finder::new(&rest, &mesh.triangles, edge);
        Ok(Self { mesh, rest, finder, edge })
    }

    /// Where `p` hangs.
    pub(super) fn place(&self, p: Vec2) -> Place {
        let (t, near) = self.finder.find(&self.rest, &self.mesh.triangles, p.as_dvec2());
        let corners = self.mesh.triangles[t];
        // Beyond an edge's length the turn of one triangle says little.
        let reached = near + (p.as_dvec2() - near).clamp_length_max(self.edge);
        let weights = embedding::weights(corners.map(|v| self.rest[v as usize]), reached).map(|w| w as f32);
        Place { corners, weights, beyond: p - reached.as_vec2() }
    }

    /// The nearest place of the mesh.
    pub(super) fn nearest(&self, p: Vec2) -> Vec2 {
        self.finder.find(&self.rest, &self.mesh.triangles, p.as_dvec2()).1.as_vec2()
    }
}
