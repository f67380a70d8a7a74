//! The surface of a field on a grid as a triangle mesh that is a closed 2-manifold for every input.
//!
//! A dual method: in every cell the sides of the marching-cubes polygons (diagonal inside corners of a face are kept
//! apart) join to closed patches, each patch becomes a vertex, and the four patches around a grid edge that the surface
//! crosses become two triangles (Nielson 2004, "Dual Marching Cubes"). Where two patches share both sides of an ambiguous
//! face, their edge would have four triangles; there each side gets a vertex of its own in the face, which is what makes
//! the mesh a manifold without exception. Vertices are put on the trilinear surface and spread evenly along it, each
//! within its cell.
//!
//! Limits: features thinner than a cell are lost or broken, sharp edges are rounded at the size of a cell, and a mesh is
//! free of self-intersections only where a cell holds one patch (everywhere when the field is resolved).

use glam::Vec3;
use rayon::prelude::*;

use super::field3::{Field3, trilinear};

/// How near a vertex may come to the sides of its cell, as a share of the cell. Vertices of neighbouring cells stay apart,
/// and a surface that touches a corner of a cell is off by no more than can be seen.
const MARGIN: f32 = 0.01;
/// Rounds of spreading vertices along the surface. After four the shortest edges do not grow any more.
const ROUNDS: usize = 4;

/// For each of a cell's twelve edges the patch that crosses it, for each of the 256 sets of inside corners.
static PATCHES: [Patches; 256] = {
    let mut all = [Patches { of_edge: [0; 12], count: 0 }; 256];
    let mut mask = 0;
    while mask < 256 {
        all[mask] = patches(mask);
        mask += 1;
    }
    all
};

#[derive(Clone, Copy)]
struct Patches {
    /// [`NONE`] where the edge is not crossed.
    of_edge: [u8; 12],
    count: u8,
}

const NONE: u8 = u8::MAX;

/// The edge along `axis` that holds `corner`.
const fn edge_at(axis: usize, corner: usize) -> usize {
    axis * 4 + (corner >> ((axis + 1) % 3) & 1) + 2 * (corner >> ((axis + 2) % 3) & 1)
}

/// The corner of an edge at its lower end.
const fn edge_start(edge: usize) -> usize {
    let axis = edge / 4;
    (edge & 1) << ((axis + 1) % 3) | (edge >> 1 & 1) << ((axis + 2) % 3)
}

/// The corners of the face across `axis` on `side`, in turn.
const fn face_corners(axis: usize, side: usize) -> [usize; 4] {
    let (u, v, base) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3), side << axis);
    [base, base | u, base | u | v, base | v]
}

/// The two edges of the face across `axis` that meet in `corner`.
const fn edges_around(axis: usize, corner: usize) -> [usize; 2] {
    [edge_at((axis + 1) % 3, corner), edge_at((axis + 2) % 3, corner)]
}

const fn ambiguous(mask: usize, axis: usize, side: usize) -> bool {
    let [a, b, c, d] = face_corners(axis, side);
    let (a, b, c, d) = (mask >> a & 1, mask >> b & 1, mask >> c & 1, mask >> d & 1);
    a == c && b == d && a != b
}

const fn patches(mask: usize) -> Patches {
    // Edges that share a side of a polygon are one patch: join them to the lowest of their numbers.
    let mut of_edge = [NONE; 12];
    let mut edge = 0;
    while edge < 12 {
        let start = edge_start(edge);
        if mask >> start & 1 != mask >> (start | 1 << (edge / 4)) & 1 {
            of_edge[edge] = edge as u8;
        }
        edge += 1;
    }
    let mut face = 0;
    while face < 6 {
        let (axis, side) = (face / 2, face % 2);
        let corners = face_corners(axis, side);
        if ambiguous(mask, axis, side) {
            let mut i = 0;
            while i < 4 {
                if mask >> corners[i] & 1 == 1 {
                    let [a, b] = edges_around(axis, corners[i]);
                    of_edge = joined(of_edge, a, b);
                }
                i += 1;
            }
        } else {
            let mut first = 12;
            let mut i = 0;
            while i < 4 {
                let next = corners[(i + 1) % 4];
                let edge = edge_at((corners[i] ^ next).trailing_zeros() as usize, corners[i]);
                if of_edge[edge] != NONE {
                    if first < 12 {
                        of_edge = joined(of_edge, first, edge);
                    }
                    first = edge;
                }
                i += 1;
            }
        }
        face += 1;
    }
    // Number them from 0.
    let (mut count, mut edge, mut number) = (0, 0, [NONE; 12]);
    while edge < 12 {
        if of_edge[edge] != NONE {
            let root = of_edge[edge] as usize;
            if number[root] == NONE {
                number[root] = count;
                count += 1;
            }
            of_edge[edge] = number[root];
        }
        edge += 1;
    }
    Patches { of_edge, count }
}

const fn joined(mut of_edge: [u8; 12], a: usize, b: usize) -> [u8; 12] {
    let (from, to) = if of_edge[a] < of_edge[b] { (of_edge[b], of_edge[a]) } else { (of_edge[a], of_edge[b]) };
    let mut i = 0;
    while i < 12 {
        if of_edge[i] == from {
            of_edge[i] = to;
        }
        i += 1;
    }
    of_edge
}

/// The closed surface around all that is below `level` in `field`: positions, and triangles counter-clockwise seen from
/// outside. Whatever lies on the grid's rim counts as outside, as does a value that is no number.
///
/// Every edge has two triangles that run along it in opposite directions, and the triangles around every vertex form one
/// ring. Takes memory for the surface only. The same bits on any number of threads.
pub fn iso_surface(field: &Field3, level: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let [nx, ny, nz] = field.dims;
    if nx < 3 || ny < 3 || nz < 3 {
        return (Vec::new(), Vec::new());
    }
    let scene = Scene { field, level };
    let layers: Vec<Layer> = (0..nz - 1).into_par_iter().map(|z| scene.layer(z)).collect();
    let mut bases = Vec::with_capacity(layers.len());
    let mut vertices = 0u32;
    for layer in &layers {
        bases.push(vertices);
        vertices += layer.vertices.len() as u32;
    }
    let faces: Vec<Faces> = (0..nz - 1).into_par_iter().map(|z| scene.faces(z, &layers, &bases)).collect();
    let mut vertices: Vec<Vertex> = layers.into_iter().flat_map(|layer| layer.vertices).collect();
    scene.spread(&mut vertices, &faces);

    let positions: Vec<Vec3> = vertices.iter().map(|v| field.origin + field.cell * v.place()).collect();
    let triangles = faces
        .par_iter()
        .flat_map_iter(|f| f.quads.iter().flat_map(|quad| split(quad, &positions)).chain(f.triangles.iter().copied()))
        .collect();
    (positions, triangles)
}

/// Two triangles over the diagonal that bends the surface least where one of them would fold it, else over the shorter.
fn split(&[a, b, c, d]: &[u32; 4], positions: &[Vec3]) -> [[u32; 3]; 2] {
    let at = |v: u32| positions[v as usize];
    let bend = |halves: &[[u32; 3]; 2]| {
        let [m, n] = halves.map(|[i, j, k]| (at(j) - at(i)).cross(at(k) - at(i)).normalize_or_zero());
        m.dot(n)
    };
    let (over_ac, over_bd) = ([[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]);
    let (bend_ac, bend_bd) = (bend(&over_ac), bend(&over_bd));
    let shorter_ac = at(a).distance_squared(at(c)) <= at(b).distance_squared(at(d));
    // A fold beyond a right angle; flatter quads look best with even triangles.
    let folds = bend_ac.min(bend_bd) < 0.0;
    if (folds && bend_ac >= bend_bd) || (!folds && shorter_ac) { over_ac } else { over_bd }
}

struct Scene<'a> {
    field: &'a Field3,
    level: f32,
}

/// A vertex of the mesh and the cell that it stays in.
struct Vertex {
    cell: [u32; 3],
    /// Its place in the cell, in shares of it.
    share: Vec3,
    /// May move: the only one of its cell.
    free: bool,
}

impl Vertex {
    /// In cells from the field's origin.
    fn place(&self) -> Vec3 {
        Vec3::from_array(self.cell.map(|c| c as f32)) + self.share
    }
}

/// The cells that the surface passes through between two planes of samples.
struct Layer {
    /// Where each row of cells begins in `cells`, and the end.
    rows: Vec<u32>,
    cells: Vec<Cell>,
    /// Faces of both sides' cells that get vertices of their own: cell, axis, the first of the two vertices. Sorted.
    splits: Vec<([u32; 2], u8, u32)>,
    vertices: Vec<Vertex>,
}

struct Cell {
    x: u32,
    mask: u8,
    /// The vertex of its first patch, in the layer.
    first: u32,
}

impl Layer {
    /// The vertex, in the layer, of the patch of cell (x, y) that crosses `edge`.
    fn vertex(&self, x: usize, y: usize, edge: usize) -> u32 {
        let row = &self.cells[self.rows[y] as usize..self.rows[y + 1] as usize];
        let cell = &row[row.partition_point(|c| (c.x as usize) < x)];
        cell.first + u32::from(PATCHES[usize::from(cell.mask)].of_edge[edge])
    }
}

/// What surrounds the crossed edges from one plane of samples up to the next.
#[derive(Default)]
struct Faces {
    quads: Vec<[u32; 4]>,
    /// Of the few that have more corners.
    triangles: Vec<[u32; 3]>,
}

impl Scene<'_> {
    fn inside(&self, at: [usize; 3]) -> bool {
        let rim = (0..3).any(|i| at[i] == 0 || at[i] + 1 == self.field.dims[i]);
        !rim && self.field.get(at[0], at[1], at[2]) < self.level
    }

    /// Which corners of a cell are inside, a bit each.
    fn mask(&self, cell: [usize; 3]) -> usize {
        (0..8).filter(|&c| self.inside(corner(cell, c))).map(|c| 1 << c).sum()
    }

    /// Where the surface crosses an edge of `cell`, in shares of the cell.
    fn crossing(&self, cell: [usize; 3], edge: usize) -> Vec3 {
        let (start, axis) = (edge_start(edge), edge / 4);
        let value = |c: usize| {
            let [x, y, z] = corner(cell, c);
            self.field.get(x, y, z) - self.level
        };
        let (a, b) = (value(start), value(start | 1 << axis));
        let share = a / (a - b);
        // At the rim and beside what is no number there is no crossing of the values.
        let share = if (a < 0.0) != (b < 0.0) && share.is_finite() { share } else { 0.5 };
        let mut place = corner_share(start);
        place[axis] = share.clamp(MARGIN, 1.0 - MARGIN);
        place
    }

    fn layer(&self, z: usize) -> Layer {
        let [nx, ny, _] = self.field.dims;
        let mut layer =
            Layer { rows: Vec::with_capacity(ny), cells: Vec::new(), splits: Vec::new(), vertices: Vec::new() };
        for y in 0..ny - 1 {
            layer.rows.push(layer.cells.len() as u32);
            // The four samples at x as bits 0, 2, 4 and 6; those at x + 1 are one further.
            let column = |x: usize| -> usize {
                (0..4).filter(|&c| self.inside([x, y + (c & 1), z + (c >> 1)])).map(|c| 1 << (2 * c)).sum()
            };
            let mut left = column(0);
            for x in 0..nx - 1 {
                let right = column(x + 1);
                let mask = left | right << 1;
                left = right;
                if mask != 0 && mask != 255 {
                    self.add_cell(&mut layer, [x, y, z], mask);
                }
            }
        }
        layer.rows.push(layer.cells.len() as u32);
        layer
    }

    fn add_cell(&self, layer: &mut Layer, cell: [usize; 3], mask: usize) {
        let Patches { of_edge, count } = PATCHES[mask];
        let at = cell.map(|c| c as u32);
        layer.cells.push(Cell { x: at[0], mask: mask as u8, first: layer.vertices.len() as u32 });
        for patch in 0..count {
            let crossed = (0..12).filter(|&e| of_edge[e] == patch);
            let (sum, n) = crossed.fold((Vec3::ZERO, 0.0), |(s, n), e| (s + self.crossing(cell, e), n + 1.0));
            let mut vertex = Vertex { cell: at, share: clamped(sum / n), free: count == 1 };
            if vertex.free {
                self.onto_surface(&mut vertex);
                self.onto_surface(&mut vertex);
            }
            layer.vertices.push(vertex);
        }
        for axis in 0..3 {
            if cell[axis] == 0 || !ambiguous(mask, axis, 0) {
                continue;
            }
            let mut other = cell;
            other[axis] -= 1;
            let theirs = PATCHES[self.mask(other)].of_edge;
            let inside = face_corners(axis, 0).into_iter().filter(|c| mask >> c & 1 == 1);
            let sides: Vec<[usize; 2]> = inside.map(|c| edges_around(axis, c)).collect();
            let (first, second) = (sides[0][0], sides[1][0]);
            let across = |edge: usize| edge_at(edge / 4, edge_start(edge) | 1 << axis);
            if of_edge[first] == of_edge[second] && theirs[across(first)] == theirs[across(second)] {
                layer.splits.push(([at[0], at[1]], axis as u8, layer.vertices.len() as u32));
                for [a, b] in sides {
                    let share = 0.5 * (self.crossing(cell, a) + self.crossing(cell, b));
                    layer.vertices.push(Vertex { cell: at, share, free: false });
                }
            }
        }
    }

    /// What surrounds the crossed edges that start in the samples of plane `z`, which is not the last.
    fn faces(&self, z: usize, layers: &[Layer], bases: &[u32]) -> Faces {
        let mut faces = Faces::default();
        let [nx, ny, _] = self.field.dims;
        for y in 0..ny - 1 {
            for x in 0..nx - 1 {
                let here = self.inside([x, y, z]);
                for axis in 0..3 {
                    let mut next = [x, y, z];
                    next[axis] += 1;
                    if here != self.inside(next) {
                        self.add_face(&mut faces, [x, y, z], axis, here, layers, bases);
                    }
                }
            }
        }
        faces
    }

    /// Adds the polygon around the crossed edge from sample `at` along `axis`. As one of its ends is inside, no cell
    /// around it is beyond the rim.
    fn add_face(&self, out: &mut Faces, at: [usize; 3], axis: usize, here: bool, layers: &[Layer], bases: &[u32]) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        // The cells around the edge, counter-clockwise seen from its upper end, and the corner of each that `at` is.
        let around = [3, 2, 0, 1].map(|back| {
            let mut cell = at;
            cell[u] -= back & 1;
            cell[v] -= back >> 1;
            (cell, (back & 1) << u | (back >> 1) << v)
        });
        let vertices = around.map(|([x, y, z], start)| bases[z] + layers[z].vertex(x, y, edge_at(axis, start)));
        // The face between a cell and the next belongs to the upper of the two.
        let owners = [(1, u), (2, v), (2, u), (3, v)];
        let splits = owners.map(|(i, across)| {
            let ([x, y, z], start) = around[i];
            let layer = &layers[z];
            let key = ([x as u32, y as u32], across as u8);
            let found = layer.splits.iter().find(|s| (s.0, s.1) == key)?;
            let inside = if here { start } else { start | 1 << axis };
            let turn = face_corners(across, 0).iter().position(|&c| c == inside)?;
            Some(bases[z] + found.2 + (turn / 2) as u32)
        });
        let mut polygon = Vec::with_capacity(8);
        for (vertex, split) in vertices.into_iter().zip(splits) {
            polygon.push(vertex);
            polygon.extend(split);
        }
        if !here {
            polygon.reverse();
        }
        if let Ok(quad) = <[u32; 4]>::try_from(polygon.as_slice()) {
            out.quads.push(quad);
            return;
        }
        // From a vertex of a split side no edge to another corner can be there already.
        let apex = splits.into_iter().flatten().next().and_then(|s| polygon.iter().position(|&p| p == s));
        polygon.rotate_left(apex.unwrap_or(0));
        out.triangles.extend(polygon[1..].windows(2).map(|w| [polygon[0], w[0], w[1]]));
    }

    /// Moves vertices toward the middle of their neighbours along the surface, for even triangles.
    fn spread(&self, vertices: &mut [Vertex], faces: &[Faces]) {
        let mut around = vec![(Vec3::ZERO, 0.0f32); vertices.len()];
        for _ in 0..ROUNDS {
            around.fill((Vec3::ZERO, 0.0));
            for quad in faces.iter().flat_map(|f| &f.quads) {
                for i in 0..4 {
                    let (a, b) = (quad[i] as usize, quad[(i + 1) % 4] as usize);
                    around[a].0 += vertices[b].place();
                    around[a].1 += 1.0;
                    around[b].0 += vertices[a].place();
                    around[b].1 += 1.0;
                }
            }
            vertices.par_iter_mut().zip(&around).for_each(|(vertex, &(sum, n))| {
                if vertex.free && n > 0.0 {
                    let normal = self.surface_at(vertex).1.normalize_or_zero();
                    let step = sum / n - vertex.place();
                    vertex.share = clamped(vertex.share + 0.5 * (step - normal * normal.dot(step)));
                    self.onto_surface(vertex);
                }
            });
        }
    }

    /// One step down the slope of the cell's trilinear surface.
    fn onto_surface(&self, vertex: &mut Vertex) {
        let (value, slope) = self.surface_at(vertex);
        let step = slope * ((value - self.level) / slope.length_squared());
        if step.is_finite() {
            vertex.share = clamped(vertex.share - step);
        }
    }

    fn surface_at(&self, vertex: &Vertex) -> (f32, Vec3) {
        trilinear(&self.field.corners(vertex.cell.map(|c| c as usize)), vertex.share)
    }
}

fn corner(cell: [usize; 3], c: usize) -> [usize; 3] {
    std::array::from_fn(|axis| cell[axis] + (c >> axis & 1))
}

fn corner_share(c: usize) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|axis| (c >> axis & 1) as f32))
}

fn clamped(share: Vec3) -> Vec3 {
    share.clamp(Vec3::splat(MARGIN), Vec3::splat(1.0 - MARGIN))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::manifold::{manifold_defect, pieces, volume};
    use glam::vec3;
    use proptest::prelude::*;

    fn sampled(n: usize, cell: f32, value: impl Fn(Vec3) -> f32) -> Field3 {
        let half = 0.5 * cell * (n - 1) as f32;
        let mut field = Field3::new([n; 3], Vec3::splat(-half), cell, 0.0);
        for z in 0..n {
            for y in 0..n {
                for x in 0..n {
                    let i = field.index(x, y, z);
                    field.values[i] = value(field.position(x, y, z));
                }
            }
        }
        field
    }

    #[test]
    fn a_ball_is_round_closed_and_even() {
        let field = sampled(40, 0.1, |p| p.length() - 1.5);
        let (positions, triangles) = iso_surface(&field, 0.0);
        assert_eq!(manifold_defect(positions.len(), &triangles), None);
        assert_eq!(pieces(positions.len(), &triangles).last(), Some(&0));
        // Euler: a sphere.
        assert_eq!(positions.len() as i64 - triangles.len() as i64 / 2, 2);
        let off = positions.iter().map(|p| (p.length() - 1.5).abs()).fold(0.0, f32::max);
        assert!(off < 0.003, "{off}");
        let whole = 4.0 / 3.0 * std::f64::consts::PI * 1.5f64.powi(3);
        assert!((volume(&positions, &triangles) / whole - 1.0).abs() < 0.005);
        let mut smallest: Vec<f32> = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                (b - a).angle_between(c - a).min((c - b).angle_between(a - b)).min((a - c).angle_between(b - c))
            })
            .collect();
        smallest.sort_by(f32::total_cmp);
        let (low, middle) = (smallest[smallest.len() / 100].to_degrees(), smallest[smallest.len() / 2].to_degrees());
        assert!(low > 15.0 && middle > 38.0, "smallest angles: 1 % below {low}, half below {middle} degrees");
    }

    #[test]
    fn a_level_moves_the_surface_and_the_rim_closes_it() {
        let field = sampled(40, 0.1, |p| p.x);
        let (positions, triangles) = iso_surface(&field, 0.5);
        assert_eq!(manifold_defect(positions.len(), &triangles), None);
        let far = positions.iter().filter(|p| p.y.abs() < 1.5 && p.z.abs() < 1.5).map(|p| p.x).fold(-9.0, f32::max);
        assert!((far - 0.5).abs() < 1e-4, "{far}");
        assert!(iso_surface(&sampled(10, 0.1, |_| 1.0), 0.0).1.is_empty());
        assert!(iso_surface(&Field3::new([2, 2, 2], Vec3::ZERO, 1.0, -1.0), 0.0).1.is_empty());
    }

    #[test]
    fn a_double_side_is_split() {
        // Two cells whose shared face has its diagonal inside, joined by a bridge on either side.
        let inside = [[1, 1, 2], [2, 2, 2], [1, 1, 1], [2, 1, 1], [2, 2, 1], [1, 1, 3], [2, 1, 3], [2, 2, 3]];
        let mut field = Field3::new([4, 4, 5], Vec3::ZERO, 1.0, 1.0);
        for [x, y, z] in inside {
            let i = field.index(x, y, z);
            field.values[i] = -1.0;
        }
        let (positions, triangles) = iso_surface(&field, 0.0);
        let surface = Scene { field: &field, level: 0.0 };
        assert!((0..4).any(|z| !surface.layer(z).splits.is_empty()), "the case that this test is for");
        assert_eq!(manifold_defect(positions.len(), &triangles), None);
        assert!(volume(&positions, &triangles) > 0.0);
    }

    proptest! {
        #[test]
        fn random_fields_give_closed_manifolds(
            dims in [3usize..8, 3usize..8, 3usize..8],
            share in 0.1f32..0.9,
            seed in proptest::collection::vec(0.0f32..1.0, 512),
            odd in proptest::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.5, 0.0]),
        ) {
            let mut field = Field3::new(dims, vec3(3.0, -2.0, 100.0), 0.25, 0.0);
            let n = field.values.len();
            field.values.copy_from_slice(&seed[..n]);
            field.values[n / 2] = odd;
            let (positions, triangles) = iso_surface(&field, share);
            prop_assert_eq!(manifold_defect(positions.len(), &triangles), None);
            prop_assert!(positions.iter().all(|p| p.is_finite()));
            prop_assert!(triangles.is_empty() || volume(&positions, &triangles) > 0.0);
            let degenerate = triangles.iter().find(|t| {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                a == b || b == c || c == a
            });
            prop_assert_eq!(degenerate, None);
            let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
            prop_assert!(alone.install(|| iso_surface(&field, share)) == (positions, triangles));
        }
    }
}
