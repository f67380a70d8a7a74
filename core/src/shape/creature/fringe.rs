//! What tubes miss: ears, hooves, tusks, a rump. Parts of the rest frame's mask that no tube covers become inflated
//! patches on the limb they move with.
//!
//! Method: a pixel belongs to the limb that carries it into the masks of the most frames; what no limb carries is a
//! mistake of the rest frame's mask or stroke and is left out. Each limb's pixels are inflated to a closed sheet: the
//! squared height solves a Poisson equation that is 0 on the outline and meets the tube's own height inside the tube,
//! which gives round cross-sections (a strip becomes a half cylinder) that grow out of the tube without a step.
//!
//! Limit: shapes hidden in the rest frame are not found.

use glam::{Vec2, vec2, vec3};
use rayon::prelude::*;

use super::limb::LimbShape;
use super::tube::orient_outward;
use crate::error::Result;
use crate::geometry::TriMesh;
use crate::job::Stage;
use crate::raster::{Grid, Mask, Rasterizer};

/// At most so many frames, evenly over the clip, are asked whether a pixel moves with a limb.
const WITNESSES: usize = 32;
/// The least share of them that must say yes.
const SUPPORT: f32 = 0.4;
/// A patch is a shape when some lattice point is inside with all its cell and its neighbours with this share of theirs;
/// thinner ones are the tubes' own rounding.
const THIN: f32 = 0.4;
/// Curvature of the inflated sheets: 2 makes a strip a half cylinder, 4 makes a disc a half sphere.
const INFLATION: f32 = 3.0;
/// Sweeps of the Poisson solver, and its over-relaxation.
const SWEEPS: usize = 150;
const RELAXATION: f32 = 1.8;

/// A closed sheet on a limb, in the rest frame.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// The surface; texture coordinates are clip pixels of the rest frame.
    pub mesh: TriMesh,
    /// Where each vertex lies along the limb, as a sample.
    pub samples: Vec<f32>,
    /// The pixels it lies over: left, top, right, bottom.
    pub bounds: [f32; 4],
}

/// A pixel in a limb's own coordinates.
#[derive(Clone, Copy)]
pub(super) struct Hold {
    pub sample: usize,
    along: f32,
    across: f32,
}

/// The patches of every limb (an empty mesh where it has none). `front` is what the tubes cover in the rest frame.
/// `step` is the size of a lattice cell in clip pixels.
pub(super) fn patches(
    limbs: &[LimbShape],
    rest: usize,
    masks: &[Mask],
    front: &Rasterizer,
    step: f32,
    stage: Stage<'_>,
) -> Result<Vec<Option<Patch>>> {
    let lattices = lattices(limbs, rest, masks, front, step, stage)?;
    let meshes = lattices
        .par_iter()
        .zip(limbs)
        .map(|(lattice, limb)| lattice.as_ref().and_then(|lattice| mesh_of(limb, rest, &limb.normals(rest), lattice)));
    Ok(meshes.collect())
}

/// What is inflated on every limb, as heights.
pub(super) fn lattices(
    limbs: &[LimbShape],
    rest: usize,
    masks: &[Mask],
    front: &Rasterizer,
    step: f32,
    stage: Stage<'_>,
) -> Result<Vec<Option<Lattice>>> {
    let mask = &masks[rest];
    let (width, height) = (mask.width(), mask.height());
    let witnesses: Vec<usize> = (0..masks.len()).step_by(masks.len().div_ceil(WITNESSES).max(1)).collect();
    let normals: Vec<Vec<Vec<Vec2>>> =
        limbs.iter().map(|l| witnesses.iter().map(|&f| l.normals(f)).collect()).collect();
    let rest_normals: Vec<Vec<Vec2>> = limbs.iter().map(|l| l.normals(rest)).collect();
    let rows: Vec<Vec<u16>> = (0..height)
        .into_par_iter()
        .map(|y| {
            stage.at(0.0)?;
            let of_pixel = |x: usize| {
                if !mask.get(x, y) || front.id.get(x, y) != Rasterizer::NOTHING {
                    return 0;
                }
                let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
                owner(p, limbs, rest, &rest_normals, &normals, &witnesses, masks)
            };
            Ok((0..width).map(of_pixel).collect())
        })
        .collect::<Result<_>>()?;
    let owners = rows.concat();
    let owners = Grid::from_vec(width, height, owners);
    (0..limbs.len())
        .into_par_iter()
        .map(|l| {
            stage.at(0.5)?;
            Ok(sheet(&limbs[l], l, rest, &rest_normals[l], &owners, mask, front, step))
        })
        .collect()
}

/// The limb (index + 1) that carries a pixel into the most masks; 0 when none carries it well enough.
fn owner(
    p: Vec2,
    limbs: &[LimbShape],
    rest: usize,
    rest_normals: &[Vec<Vec2>],
    normals: &[Vec<Vec<Vec2>>],
    witnesses: &[usize],
    masks: &[Mask],
) -> u16 {
    let mut best = (SUPPORT, 0u16);
    for (l, limb) in limbs.iter().enumerate() {
        let hold = hold(p, &limb.axis.frames[rest], &rest_normals[l]);
        let distance = vec2(hold.along, hold.across).length();
        let reach = 3.0 * limb.half_width(hold.sample).max(limb.mean_radius());
        if distance > reach {
            continue;
        }
        let (mut inside, mut asked) = (0u32, 0u32);
        for (w, &f) in witnesses.iter().enumerate() {
            let n = normals[l][w][hold.sample];
            let q = limb.axis.frames[f][hold.sample] + n * hold.across + vec2(-n.y, n.x) * hold.along;
            let mask = &masks[f];
            if q.x >= 0.0 && q.y >= 0.0 && q.x < mask.width() as f32 && q.y < mask.height() as f32 {
                asked += 1;
                inside += u32::from(mask.get(q.x as usize, q.y as usize));
            }
        }
        if asked == 0 {
            continue;
        }
        // Of limbs that explain a pixel alike, the one that it is closest to in widths.
        let score = inside as f32 / asked as f32 - 0.05 * distance / reach;
        if score > best.0 {
            best = (score, l as u16 + 1);
        }
    }
    best.1
}

/// Where a pixel lies from the nearest sample of an axis.
pub(super) fn hold(p: Vec2, points: &[Vec2], normals: &[Vec2]) -> Hold {
    let nearest = points
        .iter()
        .enumerate()
        .map(|(i, q)| (q.distance_squared(p), i))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(0, |(_, i)| i);
    let (n, d) = (normals[nearest], p - points[nearest]);
    Hold { sample: nearest, along: d.dot(vec2(-n.y, n.x)), across: d.dot(n) }
}

/// The lattice over one limb's pixels.
pub(super) struct Lattice {
    left: f32,
    top: f32,
    /// Clip pixels between points.
    pub step: f32,
    /// How far each point is inside the sheet: the outline is at one half.
    pub inside: Grid<f32>,
    /// Height over the axis, in clip pixels.
    pub height: Grid<f32>,
}

impl Lattice {
    /// The clip pixel of a place on the lattice.
    pub(super) fn place(&self, x: f32, y: f32) -> Vec2 {
        vec2(self.left + x * self.step, self.top + y * self.step)
    }

    /// The place on the lattice of a clip pixel.
    pub(super) fn local(&self, p: Vec2) -> Vec2 {
        (p - vec2(self.left, self.top)) / self.step
    }

    /// The clip pixels that it lies over: the top left and the bottom right.
    pub(super) fn bounds(&self) -> (Vec2, Vec2) {
        let last = vec2(self.inside.width() as f32 - 1.0, self.inside.height() as f32 - 1.0);
        (self.place(0.0, 0.0), self.place(last.x, last.y))
    }

    /// The area that it covers, in square clip pixels.
    pub(super) fn area(&self) -> f32 {
        self.inside.data().iter().filter(|share| **share > 0.5).count() as f32 * self.step * self.step
    }
}

fn sheet(
    limb: &LimbShape,
    l: usize,
    rest: usize,
    normals: &[Vec2],
    owners: &Grid<u16>,
    mask: &Mask,
    front: &Rasterizer,
    step: f32,
) -> Option<Lattice> {
    let id = l as u16 + 1;
    let (mut lo, mut hi) = (vec2(f32::INFINITY, f32::INFINITY), vec2(f32::NEG_INFINITY, f32::NEG_INFINITY));
    for y in 0..owners.height() {
        for x in 0..owners.width() {
            if owners.get(x, y) == id {
                let p = vec2(x as f32, y as f32);
                lo = lo.min(p);
                hi = hi.max(p + 1.0);
            }
        }
    }
    if !lo.is_finite() {
        return None;
    }
    let margin = (limb.mean_radius() + 4.0 * step).ceil();
    let (left, top) = (lo.x - margin, lo.y - margin);
    let columns = ((hi.x + margin - left) / step).ceil() as usize + 2;
    let rows = ((hi.y + margin - top) / step).ceil() as usize + 2;
    let share = |x: usize, y: usize, hit: &dyn Fn(isize, isize) -> bool| {
        // The share of a cell-sized window of pixels around the lattice point that is hit.
        let at = vec2(left + x as f32 * step, top + y as f32 * step);
        let half = (step / 2.0).max(0.5);
        let (x0, x1) = ((at.x - half).round() as isize, (at.x + half).round() as isize);
        let (y0, y1) = ((at.y - half).round() as isize, (at.y + half).round() as isize);
        let (mut hits, mut all) = (0u32, 0u32);
        for py in y0..y1.max(y0 + 1) {
            for px in x0..x1.max(x0 + 1) {
                all += 1;
                hits += u32::from(hit(px, py));
            }
        }
        hits as f32 / all as f32
    };
    let owned = |x: isize, y: isize| {
        x >= 0
            && y >= 0
            && (x as usize) < owners.width()
            && (y as usize) < owners.height()
            && owners.get(x as usize, y as usize) == id
    };
    let own =
        Grid::from_vec(columns, rows, (0..columns * rows).map(|i| share(i % columns, i / columns, &owned)).collect());
    let part = |x: isize, y: isize| mask.at(x, y) && front.id.get(x as usize, y as usize) == l as u16;
    let touching = Grid::from_vec(
        columns,
        rows,
        (0..columns * rows).map(|i| share(i % columns, i / columns, &part) > 0.0).collect(),
    );
    let core = shapes(&own, &touching);
    if !core.data().iter().any(|&c| c) {
        return None;
    }
    // The sheet reaches into the tube as far as it is thick outside, so that it grows out of it.
    let reach = reach_inside(&core, margin / step);
    let covered = |x: isize, y: isize| {
        mask.at(x, y) && (owned(x, y) || front.id.get(x as usize, y as usize) != Rasterizer::NOTHING)
    };
    let mut inside = Grid::new(columns, rows, 0.0f32);
    for y in 1..rows - 1 {
        for x in 1..columns - 1 {
            if reach.get(x, y) > 0.0 || core.get(x, y) {
                inside.set(x, y, share(x, y, &covered));
            }
        }
    }
    let ratio = limb.depth_ratio.iter().sum::<f32>() / limb.depth_ratio.len().max(1) as f32;
    let height = inflate(&inside, &core, INFLATION * (ratio * step).powi(2), |x, y| {
        let p = vec2(left + x as f32 * step, top + y as f32 * step);
        tube_height(limb, hold(p, &limb.axis.frames[rest], normals))
    });
    Some(Lattice { left, top, step, inside, height })
}

/// The owned lattice points of components that are thick enough somewhere to be a shape and touch the limb's own tube:
/// what floats belongs to something that no stroke marks.
fn shapes(own: &Grid<f32>, tube: &Grid<bool>) -> Grid<bool> {
    let (w, h) = (own.width(), own.height());
    let mut keep = Grid::new(w, h, false);
    let mut seen = Grid::new(w, h, false);
    for start in 0..w * h {
        if seen.data()[start] || own.data()[start] <= 0.5 {
            continue;
        }
        let (mut waiting, mut members) = (vec![start], Vec::new());
        seen.data_mut()[start] = true;
        let (mut thick, mut touches) = (false, false);
        while let Some(i) = waiting.pop() {
            members.push(i);
            let (x, y) = ((i % w) as isize, (i / w) as isize);
            let whole = [(1, 0), (-1, 0), (0, 1), (0, -1)]
                .iter()
                .map(|(dx, dy)| own.clamped(x + dx, y + dy))
                .fold(1.0, f32::min);
            touches |= [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].iter().any(|(dx, dy)| tube.clamped(x + dx, y + dy));
            thick |= own.data()[i] > 0.99 && whole > THIN;
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let (nx, ny) = (x + dx, y + dy);
                if nx >= 0 && ny >= 0 && (nx as usize) < w && (ny as usize) < h {
                    let n = ny as usize * w + nx as usize;
                    if !seen.data()[n] && own.data()[n] > 0.5 {
                        seen.data_mut()[n] = true;
                        waiting.push(n);
                    }
                }
            }
        }
        if thick && touches {
            members.iter().for_each(|&i| keep.data_mut()[i] = true);
        }
    }
    keep
}

/// How far beyond the core the sheet may go at every point, in lattice steps (positive inside that reach): as far as
/// the core is thick at its nearest place.
fn reach_inside(core: &Grid<bool>, most: f32) -> Grid<f32> {
    let (w, h) = (core.width(), core.height());
    // Chamfer distance to the outside of the core gives its thickness; flooding it outward gives the reach.
    let mut depth = Grid::new(w, h, 0.0f32);
    let far = (w + h) as f32;
    for (d, &c) in depth.data_mut().iter_mut().zip(core.data()) {
        *d = if c { far } else { 0.0 };
    }
    chamfer(&mut depth, |near, cost| near + cost, f32::min);
    // Thickness spreads along the core, so that all of a blob knows its thickest place nearby.
    let mut reach = Grid::new(w, h, f32::NEG_INFINITY);
    for i in 0..w * h {
        if core.data()[i] {
            reach.data_mut()[i] = (2.0 * depth.data()[i]).clamp(2.5, most.max(2.5));
        }
    }
    chamfer(&mut reach, |near, cost| near - cost, f32::max);
    reach
}

/// Two sweeps over a grid that carry values to neighbours: straight steps cost 1, diagonal ones 1.414.
pub(super) fn chamfer(grid: &mut Grid<f32>, step: impl Fn(f32, f32) -> f32, better: impl Fn(f32, f32) -> f32) {
    let (w, h) = (grid.width() as isize, grid.height() as isize);
    let diagonal = std::f32::consts::SQRT_2;
    let sides = [(-1, 0, 1.0), (0, -1, 1.0), (-1, -1, diagonal), (1, -1, diagonal)];
    for backward in [false, true] {
        for i in 0..w * h {
            let i = if backward { w * h - 1 - i } else { i };
            let (x, y) = (i % w, i / w);
            let mut value = grid.data()[i as usize];
            for (dx, dy, cost) in sides {
                let (nx, ny) = if backward { (x - dx, y - dy) } else { (x + dx, y + dy) };
                if nx >= 0 && ny >= 0 && nx < w && ny < h {
                    value = better(value, step(grid.get(nx as usize, ny as usize), cost));
                }
            }
            grid.data_mut()[i as usize] = value;
        }
    }
}

/// The height of the limb's tube over its axis at a held pixel, in clip pixels; 0 outside the tube.
fn tube_height(limb: &LimbShape, hold: Hold) -> f32 {
    let half = limb.half_width(hold.sample).max(1e-3);
    let x = (hold.across - limb.shift(hold.sample)) / half;
    limb.depth_ratio[hold.sample] * half * (1.0 - x * x).max(0.0).sqrt()
}

/// Heights over the axis: the square root of the solution of the Poisson equation over the sheet. Where the sheet ends
/// inside the tube it has the tube's own height, `tube(x, y)`; `source` is the curvature of the squared height a step.
fn inflate(inside: &Grid<f32>, core: &Grid<bool>, source: f32, tube: impl Fn(usize, usize) -> f32) -> Grid<f32> {
    let (w, h) = (inside.width(), inside.height());
    let within = |i: usize| inside.data()[i] > 0.5;
    let mut free = Vec::new();
    let mut u = Grid::new(w, h, 0.0f32);
    for y in 1..h - 1 {
        for x in 1..w - 1 {
            let i = y * w + x;
            if !within(i) {
                continue;
            }
            let in_core = core.data()[i];
            if !in_core {
                u.data_mut()[i] = tube(x, y).powi(2);
            }
            if in_core || [i - 1, i + 1, i - w, i + w].into_iter().all(within) {
                free.push(i);
            }
        }
    }
    let u = u.data_mut();
    for _ in 0..SWEEPS {
        for &i in &free {
            let mean = (u[i - 1] + u[i + 1] + u[i - w] + u[i + w] + source) / 4.0;
            u[i] = (u[i] + RELAXATION * (mean - u[i])).max(0.0);
        }
    }
    Grid::from_vec(w, h, u.iter().map(|v| v.max(0.0).sqrt()).collect())
}

/// The closed surface of a lattice: marching squares along the outline, a front and a back sheet that share it.
fn mesh_of(limb: &LimbShape, rest: usize, normals: &[Vec2], lattice: &Lattice) -> Option<Patch> {
    let inside = &lattice.inside;
    let (w, h) = (inside.width(), inside.height());
    let within = |x: usize, y: usize| inside.get(x, y) > 0.5;
    let mut out = Patch { mesh: TriMesh::default(), samples: Vec::new(), bounds: [0.0; 4] };
    let (mut lo, mut hi) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    let mut push = |at: Vec2, rise: f32| {
        let p = lattice.place(at.x, at.y);
        let sample = hold(p, &limb.axis.frames[rest], normals).sample;
        let base = limb.z[rest][sample];
        (lo, hi) = (lo.min(p), hi.max(p));
        out.mesh.positions.push(vec3(p.x, limb.clip_height - p.y, base + rise));
        out.mesh.uvs.push(p);
        out.samples.push(sample as f32);
        (out.mesh.positions.len() - 1) as u32
    };
    // Lattice points inside have a vertex in front and one behind; crossings of the outline have one.
    let mut front = Grid::new(w, h, [0u32; 2]);
    let mut crossing = Grid::new(w, h, [0u32; 2]);
    for y in 0..h {
        for x in 0..w {
            let at = vec2(x as f32, y as f32);
            if within(x, y) {
                let rise = lattice.height.get(x, y).max(0.05 * lattice.step);
                front.set(x, y, [push(at, rise), push(at, -rise)]);
            }
            let mut cross = [0u32; 2];
            for (k, (nx, ny)) in [(x + 1, y), (x, y + 1)].into_iter().enumerate() {
                if nx < w && ny < h && within(x, y) != within(nx, ny) {
                    let (a, b) = (inside.get(x, y) - 0.5, inside.get(nx, ny) - 0.5);
                    let share = (a / (a - b)).clamp(0.02, 0.98);
                    cross[k] = push(at.lerp(vec2(nx as f32, ny as f32), share), 0.0);
                }
            }
            crossing.set(x, y, cross);
        }
    }
    let mut polygon: Vec<[u32; 2]> = Vec::with_capacity(6);
    for y in 0..h - 1 {
        for x in 0..w - 1 {
            polygon.clear();
            let corners = [(x, y), (x, y + 1), (x + 1, y + 1), (x + 1, y)];
            for i in 0..4 {
                let (a, b) = (corners[i], corners[(i + 1) % 4]);
                if within(a.0, a.1) {
                    polygon.push(front.get(a.0, a.1));
                }
                if within(a.0, a.1) != within(b.0, b.1) {
                    let (low, axis) = (a.min(b), usize::from(a.0 == b.0));
                    polygon.push([crossing.get(low.0, low.1)[axis]; 2]);
                }
            }
            for i in 1..polygon.len().saturating_sub(1) {
                let (a, b, c) = (polygon[0], polygon[i], polygon[i + 1]);
                out.mesh.triangles.push([a[0], b[0], c[0]]);
                out.mesh.triangles.push([a[1], c[1], b[1]]);
            }
        }
    }
    if out.mesh.triangles.is_empty() {
        return None;
    }
    orient_outward(&mut out.mesh);
    out.mesh.normals = out.mesh.smooth_normals();
    out.bounds = [lo.x, lo.y, hi.x, hi.y];
    Some(out)
}
