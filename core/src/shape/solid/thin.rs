//! Where a solid is thinner than it may be, and what makes it thick enough.
//!
//! From places all over the surface a ray goes straight in to the other side (the shape diameter of Shapira et al. 2008 in
//! one ray, which sees every sheet and tube). Where the middle of its way is a middle of the solid, a ball of the least
//! thickness is put there: the union with all balls has no thin part, and parts that are thick enough stay as they are.
//! Sharp edges and short tips of thick parts are left as they are.
//!
//! Limits: a wedge or cone of more than 45 degrees counts as an edge however far it reaches; a long thin tip grows by up to
//! half the least thickness.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::Field3;
use crate::geometry::signed_distance::Soup;
use crate::job::Stage;

/// Balls so close to one another, as a share of their radius, change the surface by less than a hundredth of it.
const APART: f32 = 0.25;
/// The middle of the way through is no middle of the solid when something is nearer than this share of half the way: 45
/// degrees between the two sides.
const MIDDLE: f32 = 0.7;
/// A ball fits with so much of its radius: the rest is for what lies between samples.
const FITS: f32 = 0.95;
/// A thin part that stays within so many radii of the middle of a thick one is its tip or edge, and left as it is: no
/// further beyond it than the least thickness.
const TIP: f32 = 2.0;

/// What is too thin.
#[derive(Debug, Default)]
pub(super) struct Thin {
    /// Centres of balls.
    pub(super) balls: Vec<Vec3>,
    /// How much of the surface belongs to thin parts, in 0..=1.
    pub(super) share: f32,
}

/// What a place on the surface says of the part below it.
enum Below {
    /// The middle between it and the other side, nearer than allowed.
    Thin(Vec3),
    /// The centre of a ball of the least thickness that touches it and fits in.
    Thick(Vec3),
    Neither,
}

/// Finds where the solid inside `soup` is thinner than two `radius`. `field` is its signed distance, exact beyond `radius`.
pub(super) fn find(
    soup: &Soup,
    field: &Field3,
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    radius: f32,
    stage: Stage<'_>,
) -> Result<Thin> {
    let done = AtomicUsize::new(0);
    let found = triangles
        .par_iter()
        .zip(&soup.normals)
        .map(|(triangle, &normal)| {
            stage.at(done.fetch_add(1, Ordering::Relaxed) as f64 / triangles.len() as f64)?;
            if normal == Vec3::ZERO {
                return Ok((Vec::new(), Vec::new(), 0.0));
            }
            let [a, b, c] = triangle.map(|v| positions[v as usize]);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let steps = (2.0 * longest / radius).ceil().clamp(1.0, 1000.0) as usize;
            let area = 0.5 * (b - a).cross(c - a).length();
            let share = area / (steps * (steps + 1) / 2) as f32;
            let (mut thin, mut thick) = (Vec::new(), Vec::new());
            for i in 0..steps {
                stage.at(0.0)?;
                for j in 0..steps - i {
                    let (u, v) = ((i as f32 + 1.0 / 3.0) / steps as f32, (j as f32 + 1.0 / 3.0) / steps as f32);
                    match below(soup, field, a + (b - a) * u + (c - a) * v, normal, radius) {
                        Below::Thin(middle) => thin.push((middle, share)),
                        Below::Thick(centre) => thick.push(centre),
                        Below::Neither => {}
                    }
                }
            }
            Ok((thin, thick, area))
        })
        .collect::<Result<Vec<_>>>()?;
    let mut whole = 0.0f64;
    let (mut balls, mut core) = (Places::new(APART * radius), Places::new(0.5 * radius));
    for (thin, thick, area) in found {
        whole += f64::from(area);
        thin.into_iter().for_each(|(middle, share)| balls.add(middle, share));
        thick.into_iter().for_each(|centre| core.add(centre, 0.0));
    }
    let kept = reaching_out(&balls, &core, radius);
    let area: f64 = kept.iter().map(|&i| f64::from(balls.places[i].1)).sum();
    Ok(Thin {
        balls: kept.iter().map(|&i| balls.places[i].0).collect(),
        share: if whole > 0.0 { (area / whole) as f32 } else { 0.0 },
    })
}

fn below(soup: &Soup, field: &Field3, place: Vec3, normal: Vec3, radius: f32) -> Below {
    let centre = place - normal * radius;
    if field.sample(centre) <= -FITS * radius {
        return Below::Thick(centre);
    }
    // Below this a ray is still in the triangle that it starts from.
    let off = 1e-3 * radius;
    let mut after = off;
    let out = |p: Vec3| soup.all.winding(p) < 0.5;
    while let Some(hit) = soup.surface.first_hit(place, -normal, after, 2.0 * radius) {
        if !out(hit.point - normal * off) {
            // A triangle that is partly within, and there it is.
            after = hit.distance + off;
            continue;
        }
        let middle = place - normal * (0.5 * hit.distance);
        let opposite = soup.normals[hit.triangle as usize].dot(normal) < 0.0;
        let nearer = soup.surface.nearest(middle, MIDDLE * 0.5 * hit.distance).is_some();
        let thin = opposite && !nearer && !out(middle) && out(place + normal * off);
        return if thin { Below::Thin(middle) } else { Below::Neither };
    }
    Below::Neither
}

/// Places, few of them close to one another, found by where they are.
struct Places {
    apart: f32,
    places: Vec<(Vec3, f32)>,
    at: HashMap<IVec3, usize>,
}

impl Places {
    fn new(apart: f32) -> Self {
        Self { apart, places: Vec::new(), at: HashMap::new() }
    }

    /// Adds a place, or its weight to that of the one that is there.
    fn add(&mut self, place: Vec3, weight: f32) {
        let key = (place / self.apart).floor().as_ivec3();
        let next = self.places.len();
        match *self.at.entry(key).or_insert(next) {
            i if i < next => self.places[i].1 += weight,
            _ => self.places.push((place, weight)),
        }
    }

    /// The numbers of all within `reach` of `place`.
    fn near(&self, place: Vec3, reach: f32) -> impl Iterator<Item = usize> {
        let low = ((place - reach) / self.apart).floor().as_ivec3();
        let high = ((place + reach) / self.apart).floor().as_ivec3();
        (low.z..=high.z)
            .flat_map(move |z| (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| IVec3::new(x, y, z))))
            .filter_map(|key| self.at.get(&key).copied())
            .filter(move |&i| self.places[i].0.distance_squared(place) < reach * reach)
    }
}

/// Those of the balls that are in a thin part which reaches out further than a tip or an edge does.
fn reaching_out(balls: &Places, core: &Places, radius: f32) -> Vec<usize> {
    let n = balls.places.len();
    let mut seen = vec![false; n];
    let mut kept = vec![];
    for start in 0..n {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let (mut part, mut next, mut reaches) = (vec![start], 0, false);
        while let Some(&i) = part.get(next) {
            next += 1;
            let place = balls.places[i].0;
            reaches = reaches || core.near(place, TIP * radius).next().is_none();
            for j in balls.near(place, 0.75 * radius) {
                if !std::mem::replace(&mut seen[j], true) {
                    part.push(j);
                }
            }
        }
        if reaches {
            kept.extend(part);
        }
    }
    kept.sort_unstable();
    kept
}

/// Adds balls of `radius` around `centres` to the solid in `field`, exact within `band` of their surface.
pub(super) fn add_balls(field: &mut Field3, centres: &[Vec3], radius: f32, band: f32, stage: Stage<'_>) -> Result<()> {
    let [nx, ny, _] = field.dims;
    let (origin, cell) = (field.origin, field.cell);
    let reach = radius + band;
    field.values.par_chunks_mut((nx * ny).max(1)).enumerate().try_for_each(|(z, plane)| {
        stage.at(0.0)?;
        let height = origin.z + cell * z as f32;
        for centre in centres.iter().filter(|c| (c.z - height).abs() < reach) {
            let local = (*centre - origin) / cell;
            let span = |at: f32, n: usize| {
                let low = (at - reach / cell).ceil().max(0.0) as usize;
                low..((at + reach / cell).floor().max(-1.0) + 1.0).min(n as f32) as usize
            };
            for y in span(local.y, ny) {
                for x in span(local.x, nx) {
                    let place = Vec3::new(origin.x + cell * x as f32, origin.y + cell * y as f32, height);
                    let value = &mut plane[y * nx + x];
                    *value = value.min(place.distance(*centre) - radius);
                }
            }
        }
        Ok(())
    })
}
