//! The signed distance from a soup of triangles: tubes that overlap, a skin that folds over itself, a mesh with holes.
//!
//! Inside is where the generalised winding number is at least a half, so that overlapping closed surfaces are their union,
//! and holes are closed by the surface that a soap film would take. The distance is exact up to a band's width, from those
//! triangles that have the inside on one side only: faces within the union are no surface.
//!
//! Limits: a triangle that is partly within counts as a whole, so that beside a crease distances can be too small by up to
//! the size of a triangle; and the film over a hole is found by sign only, a cell exact.

use glam::Vec3;
use rayon::prelude::*;

use super::Field3;
use super::triangle_tree::TriangleTree;
use crate::error::Result;
use crate::job::Stage;

/// Samples along a block's side that are asked together whether a triangle is near.
const BLOCK: usize = 8;

/// A soup of triangles, ready to be asked.
#[derive(Clone, Debug)]
pub struct Soup {
    /// All triangles, for telling inside from outside.
    pub all: TriangleTree,
    /// Those between inside and outside, for distances. Numbered as in the soup.
    pub surface: TriangleTree,
    /// For every triangle of the soup: its normal away from the inside, or zero when it is no surface.
    pub normals: Vec<Vec3>,
}

impl Soup {
    /// Finds which triangles are the surface.
    ///
    /// # Errors
    /// A cancel.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]], stage: Stage<'_>) -> Result<Self> {
        let all = TriangleTree::new(positions, triangles);
        let Some((low, high)) = all.bounds() else {
            return Ok(Self { surface: all.clone(), all, normals: vec![Vec3::ZERO; triangles.len()] });
        };
        // Far above rounding, far below what can be seen.
        let step = 1e-4 * low.distance(high);
        let normals = triangles
            .par_iter()
            .map(|t| {
                stage.at(0.0)?;
                let [a, b, c] = t.map(|v| positions[v as usize]);
                let normal = (b - a).cross(c - a).normalize_or_zero();
                if normal == Vec3::ZERO || !normal.is_finite() {
                    return Ok(Vec3::ZERO);
                }
                let middle = (a + b + c) / 3.0;
                let places = [middle, middle.lerp(a, 0.7), middle.lerp(b, 0.7), middle.lerp(c, 0.7)];
                let outward = places.iter().find_map(|p| {
                    let (above, below) = (all.winding(*p + normal * step), all.winding(*p - normal * step));
                    ((above < 0.5) != (below < 0.5)).then_some(if above < 0.5 { normal } else { -normal })
                });
                Ok(outward.unwrap_or(Vec3::ZERO))
            })
            .collect::<Result<Vec<Vec3>>>()?;
        // A triangle that is left out by its corners keeps its number.
        let kept: Vec<[u32; 3]> =
            triangles.iter().zip(&normals).map(|(t, n)| if *n == Vec3::ZERO { [0; 3] } else { *t }).collect();
        Ok(Self { surface: TriangleTree::new(positions, &kept), all, normals })
    }

    /// Fills `field` with the signed distance, negative inside, between `-band` and `band`.
    ///
    /// # Errors
    /// A cancel.
    pub fn signed_distance(&self, field: &mut Field3, band: f32, stage: Stage<'_>) -> Result<()> {
        let [nx, ny, nz] = field.dims;
        let (origin, cell) = (field.origin, field.cell);
        let place = |x: usize, y: usize, z: usize| origin + cell * Vec3::new(x as f32, y as f32, z as f32);
        let done = std::sync::atomic::AtomicUsize::new(0);
        let blocks = nz.div_ceil(BLOCK) * ny.div_ceil(BLOCK);
        field.values.par_chunks_mut((nx * ny * BLOCK).max(1)).enumerate().try_for_each(|(slab, values)| {
            let (z0, depth) = (slab * BLOCK, values.len() / (nx * ny));
            for y0 in (0..ny).step_by(BLOCK) {
                stage.at(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) as f64 / blocks as f64)?;
                for x0 in (0..nx).step_by(BLOCK) {
                    let (x1, y1) = ((x0 + BLOCK).min(nx), (y0 + BLOCK).min(ny));
                    let (low, high) = (place(x0, y0, z0), place(x1 - 1, y1 - 1, z0 + depth - 1));
                    let (centre, reach) = (0.5 * (low + high), 0.5 * low.distance(high) + band);
                    // Where the nearest triangle is far the winding number hardly changes, and tells for all.
                    let far = self.all.nearest(centre, reach).is_none().then(|| self.all.winding(centre));
                    let whole = far.filter(|w| certain(*w)).map(|w| if w < 0.5 { band } else { -band });
                    for z in 0..depth {
                        for y in y0..y1 {
                            let row = &mut values[(z * ny + y) * nx + x0..(z * ny + y) * nx + x1];
                            match whole {
                                Some(value) => row.fill(value),
                                None => self.fill_row(row, place(x0, y, z0 + z), cell, band),
                            }
                        }
                    }
                }
            }
            Ok(())
        })
    }

    fn fill_row(&self, row: &mut [f32], first: Vec3, cell: f32, band: f32) {
        // The winding number of the sample before, when nothing can lie between.
        let mut before = None;
        for (x, value) in row.iter_mut().enumerate() {
            let point = first + Vec3::X * (cell * x as f32);
            let winding = before.unwrap_or_else(|| self.all.winding(point));
            let away = self.surface.nearest(point, band).map_or(band, |n| n.distance);
            // Inside stays inside where a triangle that is partly a surface passes through.
            *value = if winding < 0.5 { away } else { -away.max(1e-3 * cell) };
            let clear = away > 1.01 * cell && certain(winding);
            before = clear.then_some(winding);
        }
    }
}

/// So far from a half that neighbours are on the same side.
fn certain(winding: f32) -> bool {
    (winding - 0.5).abs() > 0.3
}

#[cfg(test)]
mod tests {
    use super::super::manifold::{manifold_defect, pieces, volume};
    use super::super::triangle_tree::tests::cuboid;
    use super::*;
    use crate::geometry::iso_surface;
    use crate::job::Progress;

    fn field_of(positions: &[Vec3], triangles: &[[u32; 3]], n: usize) -> Field3 {
        let progress = Progress::new();
        let soup = Soup::new(positions, triangles, progress.whole()).expect("not cancelled");
        let mut field = Field3::new([n; 3], Vec3::splat(-1.013), 5.0 / (n - 1) as f32, 0.0);
        soup.signed_distance(&mut field, 0.5, progress.whole()).expect("not cancelled");
        field
    }

    #[test]
    fn overlapping_boxes_become_one_solid_without_inner_faces() {
        let (mut positions, mut triangles) = cuboid(Vec3::ZERO, Vec3::splat(2.0));
        let (more, others) = cuboid(Vec3::ONE, Vec3::splat(3.0));
        triangles.extend(others.iter().map(|t| t.map(|v| v + 8)));
        positions.extend(more);
        let field = field_of(&positions, &triangles, 41);
        let (positions, triangles) = iso_surface(&field, 0.0);
        assert_eq!(manifold_defect(positions.len(), &triangles), None);
        assert_eq!(pieces(positions.len(), &triangles).iter().max(), Some(&0));
        assert!((volume(&positions, &triangles) - 15.0).abs() < 0.2, "{}", volume(&positions, &triangles));
        assert!((field.sample(Vec3::new(1.0, 1.0, -0.3)) - 0.3).abs() < 1e-3);
        assert!((field.sample(Vec3::new(0.5, 0.5, 0.25)) + 0.25).abs() < 1e-3);
    }

    #[test]
    fn a_hole_is_closed_and_a_soup_inside_out_is_empty() {
        let (positions, triangles) = cuboid(Vec3::ZERO, Vec3::splat(3.0));
        let (closed, faces) = iso_surface(&field_of(&positions, &triangles[..11], 31), 0.0);
        assert_eq!(manifold_defect(closed.len(), &faces), None);
        let held = volume(&closed, &faces);
        assert!(held > 22.0 && held < 27.5, "{held}");
        let turned: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert!(iso_surface(&field_of(&positions, &turned, 31), 0.0).1.is_empty());
    }
}
