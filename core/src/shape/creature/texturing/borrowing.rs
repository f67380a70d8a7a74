//! Colours for what no frame shows, from places that look alike: the other limb of a pair mirrored, the same limb's other
//! side; and for the rest, from what is around in space.
//!
//! A place is turned into the one that it should look like, and takes the colour of what is known nearest to that, if it
//! is near. What is left is filled by push and pull (Gortler et al. 1996) through the cells of space instead of the
//! pixels of a picture, so that it does not matter how the surface was cut into charts.

use std::collections::HashMap;

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::limbs::{Limbs, OnLimb};
use super::texels::Texels;

/// Size of the cells that texels are looked up in, in world units: a few texels each.
const CELL: f32 = 2.0;
/// Texels this much farther than the nearest still count, so that nearest texels do not show as mosaic.
const BLUR: f32 = 0.8;
/// Cells of the finest level of the filling.
const FINEST: f32 = 2.0;
const LEVELS: usize = 9;
/// A cell with this many texels is known well.
const FULL: f32 = 4.0;

/// Known texels, to be found by place.
pub(super) struct Known<'a> {
    pub places: &'a [Vec3],
    pub colors: &'a [Vec3],
    order: Vec<u32>,
    cells: HashMap<IVec3, (u32, u32)>,
}

impl<'a> Known<'a> {
    pub(super) fn new(places: &'a [Vec3], colors: &'a [Vec3], known: impl Fn(usize) -> bool) -> Self {
        let cell = |i: &u32| (places[*i as usize] / CELL).floor().as_ivec3();
        let mut order: Vec<u32> = (0..places.len() as u32).filter(|i| known(*i as usize)).collect();
        order.sort_by_cached_key(|i| (cell(i).to_array(), *i));
        let mut cells = HashMap::new();
        for (n, i) in order.iter().enumerate() {
            cells.entry(cell(i)).or_insert((n as u32, n as u32)).1 = n as u32 + 1;
        }
        Self { places, colors, order, cells }
    }

    /// How far what is known nearest to `p` is, if it is less than `far`.
    pub(super) fn distance(&self, p: Vec3, far: f32) -> Option<f32> {
        self.around(p, far, 0.0).map(|(nearest, _)| nearest)
    }

    /// The colour of what is known nearest to `p`, at most `far` away.
    pub(super) fn near(&self, p: Vec3, far: f32) -> Option<Vec3> {
        let (nearest, found) = self.around(p, far, BLUR)?;
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for (d, i) in found {
            let share = 1.0 - (d - nearest) / BLUR;
            if share > 0.0 {
                sum += self.colors[i as usize] * share;
                total += share;
            }
        }
        Some(sum / total)
    }

    /// The least distance to what is known, at most `far`, and all that is up to `more` farther, with some beyond.
    fn around(&self, p: Vec3, far: f32, more: f32) -> Option<(f32, Vec<(f32, u32)>)> {
        let middle = (p / CELL).floor().as_ivec3();
        let shells = (far / CELL).ceil() as i32;
        let mut nearest = f32::INFINITY;
        let mut found: Vec<(f32, u32)> = Vec::new();
        for shell in 0..=shells {
            // What lies in this shell is at least so far away.
            if (shell - 1) as f32 * CELL > nearest.min(far) + more {
                break;
            }
            for z in -shell..=shell {
                for y in -shell..=shell {
                    let face = z.abs() == shell || y.abs() == shell;
                    let mut x = -shell;
                    while x <= shell {
                        if let Some(&(from, to)) = self.cells.get(&(middle + IVec3::new(x, y, z))) {
                            for &i in &self.order[from as usize..to as usize] {
                                let d = self.places[i as usize].distance(p);
                                nearest = nearest.min(d);
                                found.push((d, i));
                            }
                        }
                        x += if face || shell == 0 { 1 } else { 2 * shell };
                    }
                }
            }
        }
        (nearest <= far).then_some((nearest, found))
    }
}

/// How a limb's places are turned into those that look alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Alike {
    /// The other limb of the pair, mirrored: outside to outside.
    Twin(usize),
    /// The same limb's other side.
    OtherSide,
    /// The other limb of the pair as it is seen.
    TwinAsSeen(usize),
}

/// The place that should look like texel `i`, and how far from it colours may be taken.
fn alike(limbs: &Limbs, texels: &Texels, i: usize, how: Alike) -> (Vec3, f32) {
    let limb = &limbs.list[usize::from(limbs.of_texel[i])];
    let at = limb.on(texels.rest[i]);
    let (other, mirrored) = match how {
        Alike::Twin(t) => (&limbs.list[t], true),
        Alike::OtherSide => (limb, true),
        Alike::TwinAsSeen(t) => (&limbs.list[t], false),
    };
    let radius = other.radius(at.share);
    let scale = radius / limb.radius(at.share);
    let off = at.off * scale;
    let off = if mirrored { off.with_z(-off.z) } else { off };
    // A fifth of the thickness is about what the two sides of an animal differ by.
    (other.place(OnLimb { share: at.share, off }), 2.0 + 0.4 * radius)
}

/// Gives the texels in `unknown` the colours of what looks alike, and takes them off the list.
pub(super) fn borrow(
    texels: &Texels,
    limbs: &Limbs,
    twins: &[Option<usize>],
    source: &Known<'_>,
    unknown: &mut Vec<u32>,
    step: usize,
) -> Vec<(u32, Vec3)> {
    let how = |l: usize| match (step, twins[l]) {
        (0, Some(t)) => Some(Alike::Twin(t)),
        (1, _) => Some(Alike::OtherSide),
        (2, Some(t)) => Some(Alike::TwinAsSeen(t)),
        _ => None,
    };
    let given: Vec<Option<Vec3>> = unknown
        .par_iter()
        .with_min_len(256)
        .map(|&i| {
            let how = how(usize::from(limbs.of_texel[i as usize]))?;
            let (place, far) = alike(limbs, texels, i as usize, how);
            source.near(place, far)
        })
        .collect();
    let out = unknown.iter().zip(&given).filter_map(|(i, c)| c.map(|c| (*i, c))).collect();
    let mut given = given.iter();
    unknown.retain(|_| given.next().is_some_and(Option::is_none));
    out
}

/// Smooth colours for places from known ones around them, near or far. Nothing known: `None`.
pub(super) fn fill(places: &[Vec3], known: &Known<'_>) -> Option<Vec<Vec3>> {
    if known.order.is_empty() {
        return None;
    }
    let mut levels: Vec<HashMap<IVec3, (Vec3, f32)>> = Vec::with_capacity(LEVELS);
    let mut finest: HashMap<IVec3, (Vec3, f32)> = HashMap::new();
    let mut whole = (Vec3::ZERO, 0.0);
    for &i in &known.order {
        let (p, c) = (known.places[i as usize], known.colors[i as usize]);
        let cell = finest.entry((p / FINEST).floor().as_ivec3()).or_default();
        *cell = (cell.0 + c, cell.1 + 1.0);
        whole = (whole.0 + c, whole.1 + 1.0);
    }
    levels.push(finest);
    for _ in 1..LEVELS {
        // In an order that no hash decides.
        let mut below: Vec<_> = levels[levels.len() - 1].iter().map(|(k, v)| (k.to_array(), *v)).collect();
        below.sort_unstable_by_key(|b| b.0);
        let mut level: HashMap<IVec3, (Vec3, f32)> = HashMap::new();
        for (k, (sum, n)) in below {
            // A full cell counts once, however many texels it has.
            let share = (n / FULL).min(1.0) / n;
            let cell = level.entry(IVec3::from(k).div_euclid(IVec3::splat(2))).or_default();
            *cell = (cell.0 + sum * share, cell.1 + n * share);
        }
        levels.push(level);
    }
    let mean = whole.0 / whole.1;
    let at = |p: &Vec3| {
        let mut color = mean;
        for (l, level) in levels.iter().enumerate().rev() {
            let q = *p / (FINEST * (1 << l) as f32) - 0.5;
            let low = q.floor();
            let t = q - low;
            let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
            for corner in 0..8 {
                let bit = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
                let side = |t: f32, b: i32| if b == 1 { t } else { 1.0 - t };
                let share = side(t.x, bit.x) * side(t.y, bit.y) * side(t.z, bit.z);
                if let Some((s, n)) = level.get(&(low.as_ivec3() + bit)) {
                    let full = if l == 0 { (n / FULL).min(1.0) } else { n.min(1.0) };
                    sum += *s / *n * (share * full);
                    weight += share * full;
                }
            }
            color = color * (1.0 - weight) + sum;
        }
        color
    };
    Some(places.par_iter().with_min_len(256).map(at).collect())
}
