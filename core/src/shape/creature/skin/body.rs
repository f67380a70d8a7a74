//! The solid that the skin bounds, as a signed distance on a grid: the limbs' generalized cylinders and what is inflated
//! beside them, joined smoothly to what they hang from.
//!
//! Method: a generalized cylinder is a dense row of ellipsoids with the limb's cross-sections; its distance is that to
//! the nearest one (a first-order estimate, exact on the surface). A limb is blended with what it hangs from by the
//! polynomial smooth minimum (Quilez), from the joint to a little beyond where it leaves it; limbs that are not joined
//! meet by the plain minimum.
//!
//! Limit: a limb thinner than the grid's cells becomes as thick as one.

use glam::{Vec2, Vec3, vec2};
use rayon::prelude::*;

use super::super::fringe::Lattice;
use super::super::limb::LimbShape;
use super::super::tube::{covered, rounding, section};
use crate::error::Result;
use crate::geometry::Field3;
use crate::job::Stage;

/// Half length of an ellipsoid along the limb, as a share of its smaller half axis: long ones would fill what is slim
/// between thicker places. They stand a third of it apart.
const ALONG: f32 = 0.35;
/// How far a joint's fillet reaches, as a share of the thinner limb's radius.
const FILLET: f32 = 0.4;
/// At most so many grid points: 4 bytes each, and a solid of a clip that it fills needs under two million.
const MOST_POINTS: f32 = 6.0e6;
/// Farther than this many cells nothing is measured.
const BAND: f32 = 3.0;

/// Beyond all distances that are measured.
pub(super) const FAR: f32 = 1.0e6;

/// One limb's own distance on its part of the grid.
pub(super) struct LimbField {
    /// First grid point and how many there are.
    low: [usize; 3],
    dims: [usize; 3],
    /// Signed distance in world units; [`FAR`] beyond the band.
    distance: Vec<f32>,
    /// The limb's sample that is nearest.
    sample: Vec<f32>,
    /// How far the fillet with the parent reaches.
    fillet: f32,
    /// The share of the limb at which it leaves its parent.
    leaves: f32,
}

/// The whole solid.
pub(super) struct Body {
    /// Signed distance of the union.
    pub field: Field3,
    /// For each limb its own.
    pub limbs: Vec<LimbField>,
}

struct Ball {
    center: Vec3,
    axes: [Vec3; 3],
    half: Vec3,
    sample: f32,
    /// Samples a unit of length along the limb.
    along: Vec3,
}

impl Ball {
    /// A first-order signed distance.
    fn distance(&self, p: Vec3) -> f32 {
        let d = p - self.center;
        let q = Vec3::new(d.dot(self.axes[0]), d.dot(self.axes[1]), d.dot(self.axes[2])) / self.half;
        let (k0, k1) = (q.length(), (q / self.half).length());
        if k1 < 1e-6 { -self.half.min_element() } else { k0 * (k0 - 1.0) / k1 }
    }
}

impl LimbField {
    fn index(&self, at: [usize; 3]) -> Option<usize> {
        let mut local = [0; 3];
        for k in 0..3 {
            local[k] = at[k].checked_sub(self.low[k]).filter(|v| *v < self.dims[k])?;
        }
        Some((local[2] * self.dims[1] + local[1]) * self.dims[0] + local[0])
    }

    fn at(&self, at: [usize; 3]) -> f32 {
        self.index(at).map_or(FAR, |i| self.distance[i])
    }

    /// Distance and nearest sample between grid points; [`FAR`] beyond the band.
    pub(super) fn read(&self, grid: &Field3, p: Vec3) -> (f32, f32) {
        let local = ((p - grid.origin) / grid.cell).max(Vec3::ZERO);
        let base = local.floor();
        let share = local - base;
        let (mut distance, mut sample, mut total) = (0.0, 0.0, 0.0);
        for c in 0..8usize {
            let step = [c & 1, c >> 1 & 1, c >> 2];
            let at = [base.x as usize + step[0], base.y as usize + step[1], base.z as usize + step[2]];
            let weight: f32 = (0..3).map(|k| if step[k] == 1 { share[k] } else { 1.0 - share[k] }).product();
            let Some(i) = self.index(at).filter(|&i| self.distance[i] < FAR) else { continue };
            distance += weight * self.distance[i];
            sample += weight * self.sample[i];
            total += weight;
        }
        if total < 0.25 { (FAR, 0.0) } else { (distance / total, sample / total) }
    }

    /// How far the fillet reaches at a share of the limb: none where it has left its parent.
    fn fillet_at(&self, share: f32) -> f32 {
        let t = ((share - self.leaves) / 0.25).clamp(0.0, 1.0);
        self.fillet * (1.0 - t * t * (3.0 - 2.0 * t))
    }
}

/// The solid of limbs that stand apart in their only frame. `sheets` are what is inflated on each, `cell` the wanted
/// size of the grid's cells.
pub(super) fn body(limbs: &[LimbShape], sheets: &[Option<Lattice>], cell: f32, stage: Stage<'_>) -> Result<Body> {
    let balls: Vec<Vec<Ball>> = limbs.iter().map(|l| balls(l, 0.75 * cell)).collect();
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for ball in balls.iter().flatten() {
        low = low.min(ball.center - ball.half.max_element());
        high = high.max(ball.center + ball.half.max_element());
    }
    for (sheet, limb) in sheets.iter().zip(limbs) {
        if let Some(sheet) = sheet {
            let (a, b) = sheet.bounds();
            let deep = sheet.height.data().iter().copied().fold(0.0, f32::max);
            let z = limb.z[0].iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), z| (l.min(*z), h.max(*z)));
            low = low.min(Vec3::new(a.x, limb.clip_height - b.y, z.0 - deep));
            high = high.max(Vec3::new(b.x, limb.clip_height - a.y, z.1 + deep));
        }
    }
    if !(low.is_finite() && high.is_finite()) {
        (low, high) = (Vec3::ZERO, Vec3::ONE);
    }
    let extent = high - low;
    let cell = cell.max((extent.x * extent.y * extent.z / MOST_POINTS).cbrt()).max(extent.max_element() / 2000.0);
    let origin = low - 2.0 * cell;
    let dims = (extent / cell).to_array().map(|n| n.ceil() as usize + 5);
    let mut field = Field3::new(dims, origin, cell, FAR);
    let own: Vec<LimbField> = (0..limbs.len())
        .into_par_iter()
        .map(|l| {
            stage.at(0.0)?;
            Ok(limb_field(&limbs[l], &balls[l], sheets[l].as_ref(), limbs, &field))
        })
        .collect::<Result<_>>()?;
    let plane = dims[0] * dims[1];
    field.values.par_chunks_mut(plane).enumerate().for_each(|(z, values)| {
        for (l, limb) in own.iter().enumerate() {
            if z < limb.low[2] || z >= limb.low[2] + limb.dims[2] {
                continue;
            }
            let parent = limbs[l].trunk.map(|(p, _)| &own[p]);
            for y in limb.low[1]..limb.low[1] + limb.dims[1] {
                for x in limb.low[0]..limb.low[0] + limb.dims[0] {
                    let Some(i) = limb.index([x, y, z]) else { continue };
                    let mut d = limb.distance[i];
                    if d < FAR {
                        if let Some(parent) = parent {
                            let k = limb.fillet_at(limbs[l].axis.share(limb.sample[i]));
                            d = smooth_min(d, parent.at([x, y, z]), k);
                        }
                        let value = &mut values[y * dims[0] + x];
                        *value = value.min(d);
                    }
                }
            }
        }
    });
    stage.at(1.0)?;
    Ok(Body { field, limbs: own })
}

fn smooth_min(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0);
    if k > 1e-6 { a.min(b) - h * h / (4.0 * k) } else { a.min(b) }
}

fn balls(limb: &LimbShape, thinnest: f32) -> Vec<Ball> {
    let normals = limb.normals(0);
    let (first, last) = covered(limb);
    let mut out = Vec::new();
    let mut sample = first as f32;
    let spacing = limb.axis.spacing().max(1e-3);
    while sample <= last as f32 {
        let scale = rounding(limb, sample, (first, last)).max(0.02);
        let ring = section(limb, 0, &normals, sample, scale);
        let (a, b) = (ring.across.length().max(thinnest), ring.toward.length().max(thinnest));
        let to_end = (sample - first as f32).min(last as f32 - sample) * spacing;
        let along = (ALONG * a.min(b)).min(to_end).max(thinnest);
        let across = ring.across.normalize_or(Vec3::Y);
        let toward = ring.toward.normalize_or(Vec3::Z);
        let ahead = limb.place(0, sample + 1.0) - limb.place(0, sample - 1.0);
        out.push(Ball {
            center: ring.center,
            axes: [across, toward, across.cross(toward)],
            half: Vec3::new(a, b, along),
            sample,
            along: ahead.normalize_or_zero() / spacing,
        });
        if sample >= last as f32 {
            break;
        }
        sample = (sample + (0.3 * along / spacing).max(1.0)).min(last as f32);
    }
    out
}

/// How many samples an ellipsoid stands for, at most, to either side.
fn apart_of(ball: &Ball) -> f32 {
    (ball.half.z * ball.along.length()).max(1.0)
}

fn limb_field(
    limb: &LimbShape,
    balls: &[Ball],
    sheet: Option<&Lattice>,
    limbs: &[LimbShape],
    grid: &Field3,
) -> LimbField {
    let cell = grid.cell;
    let radius = limb.mean_radius();
    let thinner = limb.trunk.map_or(radius, |(p, _)| radius.min(limbs[p].mean_radius()));
    let fillet = (FILLET * thinner).max(cell);
    let band = BAND * cell + fillet;
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for ball in balls {
        low = low.min(ball.center - ball.half.max_element() - band);
        high = high.max(ball.center + ball.half.max_element() + band);
    }
    let raised = sheet.map(|s| Raised::new(s, limb));
    if let Some(r) = &raised {
        low = low.min(r.low - band);
        high = high.max(r.high + band);
    }
    let to_grid = |p: Vec3| ((p - grid.origin) / cell).to_array();
    let (low, high) = (to_grid(low), to_grid(high));
    let low: [usize; 3] = std::array::from_fn(|k| (low[k].floor().max(0.0) as usize).min(grid.dims[k] - 1));
    let high: [usize; 3] = std::array::from_fn(|k| (high[k].ceil().max(0.0) as usize).clamp(low[k], grid.dims[k] - 1));
    let dims: [usize; 3] = std::array::from_fn(|k| high[k] - low[k] + 1);
    let count = dims.iter().product();
    let mut out = LimbField {
        low,
        dims,
        distance: vec![FAR; count],
        sample: vec![0.0; count],
        fillet,
        leaves: leaves_at(limb, limbs),
    };
    for ball in balls {
        let reach = ball.half.max_element() + band;
        let (a, b) = (to_grid(ball.center - reach), to_grid(ball.center + reach));
        let range = |k: usize| {
            let from = (a[k].ceil().max(0.0) as usize).max(low[k]);
            let to = (b[k].floor().max(0.0) as usize).min(high[k]);
            from..(to + 1).max(from)
        };
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let Some(i) = out.index([x, y, z]) else { continue };
                    let d = ball.distance(grid.position(x, y, z));
                    if d < out.distance[i] && d < band {
                        let beside = (grid.position(x, y, z) - ball.center).dot(ball.along);
                        let most = apart_of(ball);
                        (out.distance[i], out.sample[i]) = (d, ball.sample + beside.clamp(-most, most));
                    }
                }
            }
        }
    }
    if let Some(raised) = raised {
        raised.add(&mut out, grid, band);
    }
    out
}

/// The share of a limb at which it leaves what it hangs from; 0 where it never was inside.
fn leaves_at(limb: &LimbShape, limbs: &[LimbShape]) -> f32 {
    let Some((parent, _)) = limb.trunk else { return 0.0 };
    let parent = &limbs[parent];
    let (first, last) = (limb.axis.first, limb.axis.last);
    let inside = |i: usize| {
        let p = limb.place(0, i as f32);
        (parent.axis.first..=parent.axis.last).any(|j| {
            let q = parent.place(0, j as f32) - p;
            let (a, b) = (parent.half_width(j).max(1e-3), (parent.half_width(j) * parent.depth_ratio[j]).max(1e-3));
            vec2(q.truncate().length() / a, q.z / b).length() < 1.0
        })
    };
    let at = (first..=last).find(|&i| !inside(i)).unwrap_or(last);
    limb.axis.share(at as f32)
}

/// An inflated sheet as an implicit function: dz^2 - u(x, y), where u is the squared height inside the sheet and falls
/// below 0 outside.
struct Raised<'a> {
    sheet: &'a Lattice,
    u: Vec<f32>,
    base: Vec<f32>,
    nearest: Vec<f32>,
    clip_height: f32,
    low: Vec3,
    high: Vec3,
}

impl<'a> Raised<'a> {
    fn new(sheet: &'a Lattice, limb: &LimbShape) -> Self {
        let (w, h) = (sheet.inside.width(), sheet.inside.height());
        let inside = |i: usize| sheet.inside.data()[i] > 0.5;
        let mut outside = crate::raster::Grid::new(w, h, 0.0f32);
        for i in 0..w * h {
            outside.data_mut()[i] = if inside(i) { 0.0 } else { (w + h) as f32 };
        }
        super::super::fringe::chamfer(&mut outside, |near, cost| near + cost, f32::min);
        let (sum, n) =
            (0..w * h).filter(|&i| inside(i)).fold((0.0, 0.0), |(s, n), i| (s + sheet.height.data()[i], n + 1.0));
        // Twice the height in the middle is the slope of the squared height at the border.
        let slope = 2.5 * (sum / f32::max(n, 1.0)).max(0.5 * sheet.step);
        let u = (0..w * h)
            .map(|i| {
                let (share, height) = (sheet.inside.data()[i], sheet.height.data()[i]);
                if inside(i) {
                    (height * height).max(slope * (share - 0.5) * sheet.step)
                } else {
                    -slope * sheet.step * (outside.data()[i] - 0.5 - share).max(0.05)
                }
            })
            .collect();
        let normals = limb.normals(0);
        let held: Vec<usize> = (0..w * h)
            .map(|i| {
                let p = sheet.place((i % w) as f32, (i / w) as f32);
                super::super::fringe::hold(p, &limb.axis.frames[0], &normals).sample
            })
            .collect();
        let base: Vec<f32> = held.iter().map(|&s| limb.z[0][s]).collect();
        let (a, b) = sheet.bounds();
        let deep = sheet.height.data().iter().copied().fold(0.0, f32::max);
        let z = base.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), z| (l.min(*z), h.max(*z)));
        Self {
            sheet,
            u,
            nearest: held.iter().map(|&s| s as f32).collect(),
            base,
            clip_height: limb.clip_height,
            low: Vec3::new(a.x, limb.clip_height - b.y, z.0 - deep),
            high: Vec3::new(b.x, limb.clip_height - a.y, z.1 + deep),
        }
    }

    fn add(&self, out: &mut LimbField, grid: &Field3, band: f32) {
        let (w, h) = (self.sheet.inside.width(), self.sheet.inside.height());
        for y in 0..out.dims[1] {
            for x in 0..out.dims[0] {
                let world = grid.position(x + out.low[0], y + out.low[1], 0);
                let at = self.sheet.local(Vec2::new(world.x, self.clip_height - world.y));
                if !(at.x >= 0.0 && at.y >= 0.0 && at.x < (w - 1) as f32 && at.y < (h - 1) as f32) {
                    continue;
                }
                let (i, f) = ((at.y as usize) * w + at.x as usize, at.fract());
                let mix = |v: &[f32]| {
                    let top = v[i] + (v[i + 1] - v[i]) * f.x;
                    let bottom = v[i + w] + (v[i + w + 1] - v[i + w]) * f.x;
                    (top, bottom, top + (bottom - top) * f.y)
                };
                let (top, bottom, u) = mix(&self.u);
                let left = self.u[i] + (self.u[i + w] - self.u[i]) * f.y;
                let right = self.u[i + 1] + (self.u[i + w + 1] - self.u[i + 1]) * f.y;
                let slope = vec2(right - left, bottom - top) / self.sheet.step;
                let base = mix(&self.base).2;
                for z in 0..out.dims[2] {
                    let dz = grid.origin.z + grid.cell * (z + out.low[2]) as f32 - base;
                    let steep = (4.0 * dz * dz + slope.length_squared() + 0.1 * grid.cell * grid.cell).sqrt();
                    let d = (dz * dz - u) / steep;
                    if d >= band {
                        continue;
                    }
                    let at = (z * out.dims[1] + y) * out.dims[0] + x;
                    let own = out.distance[at];
                    if own >= FAR {
                        out.sample[at] = self.nearest[i];
                    }
                    out.distance[at] = smooth_min(own, d, 0.4 * grid.cell);
                }
            }
        }
    }
}
