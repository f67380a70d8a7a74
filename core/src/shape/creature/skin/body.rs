//! The solid that the skin bounds, as a signed distance on a grid: the limbs' generalized cylinders and what is inflated
//! beside them, joined smoothly to what they hang from.
//!
//! Method: a generalized cylinder is a dense row of ellipsoids with the limb's cross-sections; its distance is that to
//! the nearest one (a first-order estimate, exact on the surface). A limb is blended with what it hangs from by the
//! polynomial smooth minimum (Quilez), from the joint to a little beyond where it leaves it; between limbs of which neither
//! hangs from the other a gap stays where both have left what they hang from. All that is still joined where it should not
//! be is cut by [`keep_ball`]: the solid is one ball, whatever the limbs do.
//!
//! Limit: a limb thinner than the grid's cells becomes as thick as one.

use glam::{Vec2, Vec3, vec2};
use rayon::prelude::*;

use super::super::fringe::Lattice;
use super::super::limb::LimbShape;
use super::super::tube::{covered, rounding, section};
use crate::error::Result;
use crate::geometry::{Field3, keep_ball};
use crate::job::Stage;

/// Half length of an ellipsoid along the limb, as a share of its smaller half axis: long ones would fill what is slim
/// between thicker places. They stand a third of it apart.
const ALONG: f32 = 0.35;
/// Half the least thickness in cells: a row of samples so close to a line hangs together by their sides.
const THINNEST: f32 = 0.87;
/// The gap between limbs that are not joined, in cells.
const GAP: f32 = 1.5;
/// The share of a limb beyond which it has left its trunk, over which the gap opens.
const PARTING: f32 = 0.1;
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
    /// The share of the limb where that is.
    share: Vec<f32>,
    /// How deep inside, as a share of the cross-section there: -1 on the axis, 0 on the surface.
    depth: Vec<f32>,
    /// How far the fillet with the parent reaches.
    fillet: f32,
    /// The share of the limb at which it leaves its parent.
    leaves: f32,
    /// The limb's mean radius.
    radius: f32,
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

    /// How far the limb has left its parent at a grid point: 0 not at all, 1 it is on its own.
    fn parted(&self, i: usize) -> f32 {
        let t = ((self.share[i] - self.leaves) / PARTING).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }
}

/// The solid of limbs that stand apart in their only frame. `sheets` are what is inflated on each, `cell` the wanted
/// size of the grid's cells.
pub(super) fn body(limbs: &[LimbShape], sheets: &[Option<Lattice>], cell: f32, stage: Stage<'_>) -> Result<Body> {
    let raised: Vec<Option<Raised<'_>>> =
        limbs.iter().zip(sheets).map(|(l, s)| s.as_ref().map(|s| Raised::new(s, l))).collect();
    let balls: Vec<Vec<Ball>> = (0..limbs.len()).map(|l| balls(limbs, l, THINNEST * cell)).collect();
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for ball in balls.iter().flatten() {
        low = low.min(ball.center - ball.half.max_element());
        high = high.max(ball.center + ball.half.max_element());
    }
    for sheet in raised.iter().flatten() {
        (low, high) = (low.min(sheet.low), high.max(sheet.high));
    }
    if !(low.is_finite() && high.is_finite()) {
        (low, high) = (Vec3::ZERO, Vec3::ONE);
    }
    let extent = high - low;
    let cell = cell.max((extent.x * extent.y * extent.z / MOST_POINTS).cbrt()).max(extent.max_element() / 2000.0);
    let origin = low - 2.0 * cell;
    let dims = (extent / cell).to_array().map(|n| n.ceil() as usize + 5);
    let mut field = Field3::new(dims, origin, cell, FAR);
    let mut own = Vec::with_capacity(limbs.len());
    for l in 0..limbs.len() {
        own.push(limb_field(l, limbs, &balls[l], raised[l].as_ref(), &field, stage)?);
    }
    let rivals = Rivals::new(limbs);
    let mut rank = vec![FAR; field.values.len()];
    let plane = dims[0] * dims[1];
    let planes = field.values.par_chunks_mut(plane).zip(rank.par_chunks_mut(plane)).enumerate();
    planes.try_for_each(|(z, (values, rank))| {
        stage.at(0.9)?;
        for (l, limb) in own.iter().enumerate() {
            if z < limb.low[2] || z >= limb.low[2] + limb.dims[2] {
                continue;
            }
            let parent = limbs[l].trunk.map(|(p, _)| &own[p]);
            for y in limb.low[1]..limb.low[1] + limb.dims[1] {
                for x in limb.low[0]..limb.low[0] + limb.dims[0] {
                    let Some(i) = limb.index([x, y, z]).filter(|i| limb.distance[*i] < FAR) else { continue };
                    let mut d = limb.distance[i].max(rivals.gap(l, limb, i, &own, [x, y, z], cell));
                    if let Some(parent) = parent {
                        let k = limb.fillet_at(limb.share[i]);
                        d = smooth_min(d, parent.at([x, y, z]), k);
                    }
                    let at = y * dims[0] + x;
                    if d < values[at] {
                        (values[at], rank[at]) = (d, rank[at].min(limb.depth[i]));
                    }
                }
            }
        }
        Ok(())
    })?;
    keep_ball(&mut field, 0.0, &rank);
    stage.at(1.0)?;
    Ok(Body { field, limbs: own })
}

/// Limbs that must not be joined where they meet: neither hangs from the other.
struct Rivals(Vec<Vec<usize>>);

impl Rivals {
    fn new(limbs: &[LimbShape]) -> Self {
        let lines: Vec<Vec<usize>> = (0..limbs.len()).map(|l| super::apart::ancestors(limbs, l)).collect();
        let rival = |a: usize, b: usize| a != b && !lines[a].contains(&b) && !lines[b].contains(&a);
        Self((0..limbs.len()).map(|a| (0..limbs.len()).filter(|b| rival(a, *b)).collect()).collect())
    }

    /// What a limb's distance at a grid point is at least, so that a gap stays halfway to its rivals.
    fn gap(&self, l: usize, limb: &LimbField, i: usize, all: &[LimbField], at: [usize; 3], cell: f32) -> f32 {
        let own = limb.parted(i);
        let mut most = f32::NEG_INFINITY;
        for &r in &self.0[l] {
            let other = &all[r];
            let Some(j) = other.index(at).filter(|j| other.distance[*j] < FAR) else { continue };
            // Closed, the gap lies so deep in the other limb that it takes nothing.
            let wide = GAP * cell;
            let open = own.min(other.parted(j));
            let closed = limb.radius.max(other.radius) + wide;
            let gap = wide * open - closed * (1.0 - open);
            most = most.max(0.5 * (gap - (other.distance[j] - limb.distance[i])));
        }
        most
    }
}

fn smooth_min(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0);
    if k > 1e-6 { a.min(b) - h * h / (4.0 * k) } else { a.min(b) }
}

/// A limb's ellipsoids, and a row of balls from its start to what it hangs from, so that nothing floats.
fn balls(limbs: &[LimbShape], l: usize, thinnest: f32) -> Vec<Ball> {
    let limb = &limbs[l];
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
    link(limbs, l, thinnest, &mut out);
    out
}

/// Adds balls from a limb's start to the nearest place on the axis of what it hangs from. A limb that hangs from nothing is
/// linked to the first of all.
fn link(limbs: &[LimbShape], l: usize, thinnest: f32, out: &mut Vec<Ball>) {
    let to = limbs[l].trunk.map_or(0, |(p, _)| p);
    if to == l {
        return;
    }
    let other = &limbs[to];
    let (first, last) = covered(other);
    let from = limbs[l].axis.first as f32;
    let start = limbs[l].place(0, from);
    let places = (first..=last).map(|j| other.place(0, j as f32));
    let Some(end) = places.min_by(|a, b| a.distance(start).total_cmp(&b.distance(start))) else { return };
    let radius = (0.5 * limbs[l].mean_radius().min(other.mean_radius())).max(thinnest);
    let steps = (start.distance(end) / (0.5 * radius)).ceil().min(1000.0);
    out.extend((0..=steps as usize).map(|i| Ball {
        center: start.lerp(end, i as f32 / steps.max(1.0)),
        axes: [Vec3::X, Vec3::Y, Vec3::Z],
        half: Vec3::splat(radius),
        sample: from,
        along: Vec3::ZERO,
    }));
}

/// How many samples an ellipsoid stands for, at most, to either side.
fn apart_of(ball: &Ball) -> f32 {
    (ball.half.z * ball.along.length()).max(1.0)
}

fn limb_field(
    l: usize,
    limbs: &[LimbShape],
    balls: &[Ball],
    raised: Option<&Raised<'_>>,
    grid: &Field3,
    stage: Stage<'_>,
) -> Result<LimbField> {
    let limb = &limbs[l];
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
    if let Some(r) = raised {
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
        share: vec![0.0; count],
        depth: vec![FAR; count],
        fillet,
        leaves: leaves_at(limb, limbs),
        radius,
    };
    // What each ball reaches, as first and last grid points.
    let reached: Vec<[[usize; 2]; 3]> = balls
        .iter()
        .map(|ball| {
            let reach = ball.half.max_element() + band;
            let (a, b) = (to_grid(ball.center - reach), to_grid(ball.center + reach));
            std::array::from_fn(|k| {
                let from = (a[k].ceil().max(0.0) as usize).max(low[k]);
                [from, ((b[k].floor() + 1.0).max(0.0) as usize).min(high[k] + 1)]
            })
        })
        .collect();
    let plane = dims[0] * dims[1];
    let planes = out.distance.par_chunks_mut(plane).zip(out.sample.par_chunks_mut(plane));
    planes.zip(out.depth.par_chunks_mut(plane)).enumerate().try_for_each(|(z, ((distance, sample), depth))| {
        stage.at(0.8 * l as f64 / limbs.len() as f64)?;
        let z = z + low[2];
        for (ball, [xs, ys, zs]) in balls.iter().zip(&reached) {
            if z < zs[0] || z >= zs[1] {
                continue;
            }
            for y in ys[0]..ys[1] {
                for x in xs[0]..xs[1] {
                    let i = (y - low[1]) * dims[0] + x - low[0];
                    let place = grid.position(x, y, z);
                    let d = ball.distance(place);
                    if d < distance[i] && d < band {
                        let beside = (place - ball.center).dot(ball.along);
                        let most = apart_of(ball);
                        (distance[i], sample[i]) = (d, ball.sample + beside.clamp(-most, most));
                        depth[i] = d / ball.half.x.min(ball.half.y);
                    }
                }
            }
        }
        Ok(())
    })?;
    if let Some(raised) = raised {
        raised.add(&mut out, grid, band);
    }
    out.share.iter_mut().zip(&out.sample).for_each(|(share, sample)| *share = limb.axis.share(*sample));
    Ok(out)
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
                let deep = u.max(0.0).sqrt().max(grid.cell);
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
                    // Of less worth than an axis.
                    out.depth[at] = out.depth[at].min((0.5 * d / deep).max(-0.5));
                }
            }
        }
    }
}
