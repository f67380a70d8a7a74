//! Where every pixel lies on the limbs of a frame: the nearest limb, how far along it, and how far to which side.
//!
//! Nearest points are passed from pixel to pixel in two sweeps over the picture (Danielsson 1980, "Euclidean distance
//! mapping"), which is right to less than a pixel for points as dense as these. A limb's known radius is taken off
//! its distance, so that a thin leg beside a wide body keeps what is its own.

use glam::{Vec2, vec2};

use crate::footage::Limb;

/// Parts along a limb, and one more beyond each of its ends.
pub(crate) const PARTS: usize = 16;
/// Places across a limb in pixels of the working size, on both sides together.
const ACROSS: usize = 128;
/// Pixels for one place across.
const BIN: f32 = 2.0;
/// Cells of one limb.
const CELLS: usize = (PARTS + 2) * ACROSS;

/// A limb's nearest point seen from a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Which limb.
    pub(crate) limb: u16,
    /// 0 at its start, 1 at its end.
    pub(crate) along: f32,
    /// Pixels from it; negative on its left.
    pub(crate) offset: f32,
    /// -1 before its start, 1 beyond its end, 0 beside it.
    pub(crate) beyond: i8,
}

impl Place {
    /// The cell of this place among [`cells`].
    pub(crate) fn cell(&self) -> usize {
        let part = match self.beyond {
            -1 => 0,
            1 => PARTS + 1,
            _ => 1 + ((self.along * PARTS as f32) as usize).min(PARTS - 1),
        };
        let across = (self.offset / BIN + ACROSS as f32 / 2.0).clamp(0.0, (ACROSS - 1) as f32) as usize;
        usize::from(self.limb) * CELLS + part * ACROSS + across
    }
}

/// How many cells `limbs` limbs have.
pub(crate) fn cells(limbs: usize) -> usize {
    limbs * CELLS
}

/// A point of a limb that pixels can be near to.
struct Seed {
    at: Vec2,
    limb: u16,
    along: f32,
    tangent: Vec2,
    end: i8,
    radius: f32,
}

/// The places of a window's pixels.
pub(crate) struct LimbField {
    pub(crate) width: usize,
    seeds: Vec<Seed>,
    nearest: Vec<u32>,
}

impl LimbField {
    /// Limbs in pixels of a window of this size; `radius` is a limb's known radius there, 0 where it is not.
    pub(crate) fn new(width: usize, height: usize, limbs: &[Limb], radius: &[f32]) -> Self {
        let mut seeds = Vec::new();
        for (i, limb) in limbs.iter().enumerate() {
            plant(&mut seeds, i as u16, &limb.points, radius.get(i).copied().unwrap_or(0.0));
        }
        let mut field = Self { width, seeds, nearest: vec![u32::MAX; width * height] };
        field.spread(width, height);
        field
    }

    fn spread(&mut self, width: usize, height: usize) {
        if width == 0 || height == 0 {
            return;
        }
        for (i, s) in self.seeds.iter().enumerate() {
            // Points outside count from the border's nearest pixel.
            let x = s.at.x.clamp(0.0, width as f32 - 1.0) as usize;
            let y = s.at.y.clamp(0.0, height as f32 - 1.0) as usize;
            take(&self.seeds, &mut self.nearest[y * width + x], i as u32, pixel(x, y));
        }
        let seeds = &self.seeds;
        let nearest = &mut self.nearest;
        for down in [true, false] {
            for row in 0..height {
                let y = if down { row } else { height - 1 - row };
                let before = if down { y.checked_sub(1) } else { (y + 1 < height).then_some(y + 1) };
                if let Some(before) = before {
                    for x in 0..width {
                        for nx in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                            let from = nearest[before * width + nx];
                            take(seeds, &mut nearest[y * width + x], from, pixel(x, y));
                        }
                    }
                }
                for x in 1..width {
                    let from = nearest[y * width + x - 1];
                    take(seeds, &mut nearest[y * width + x], from, pixel(x, y));
                }
                for x in (1..width).rev() {
                    let from = nearest[y * width + x];
                    take(seeds, &mut nearest[y * width + x - 1], from, pixel(x - 1, y));
                }
            }
        }
    }

    /// The place of a pixel; `None` without limbs.
    pub(crate) fn at(&self, x: usize, y: usize) -> Option<Place> {
        let seed = self.seeds.get(self.nearest[y * self.width + x] as usize)?;
        let off = pixel(x, y) - seed.at;
        let (across, ahead) = (seed.tangent.perp_dot(off), seed.tangent.dot(off));
        let beyond = if seed.end != 0 && ahead * f32::from(seed.end) > across.abs() { seed.end } else { 0 };
        Some(Place { limb: seed.limb, along: seed.along, offset: off.length().copysign(across), beyond })
    }
}

fn pixel(x: usize, y: usize) -> Vec2 {
    vec2(x as f32 + 0.5, y as f32 + 0.5)
}

#[inline]
fn take(seeds: &[Seed], current: &mut u32, other: u32, at: Vec2) {
    let far = |i: u32| seeds.get(i as usize).map_or(f32::INFINITY, |s| s.at.distance(at) - s.radius);
    if other != *current && far(other) < far(*current) {
        *current = other;
    }
}

fn plant(seeds: &mut Vec<Seed>, limb: u16, points: &[Vec2], radius: f32) {
    let total: f32 = points.windows(2).map(|p| p[0].distance(p[1])).sum();
    let mut walked = 0.0;
    let first = seeds.len();
    for pair in points.windows(2) {
        let length = pair[0].distance(pair[1]);
        let tangent = (pair[1] - pair[0]).normalize_or_zero();
        let steps = (length / 0.75).ceil().clamp(1.0, 4096.0) as usize;
        for i in 0..steps {
            let t = i as f32 / steps as f32;
            let along = if total > 0.0 { (walked + t * length) / total } else { 0.0 };
            seeds.push(Seed { at: pair[0].lerp(pair[1], t), limb, along, tangent, end: 0, radius });
        }
        walked += length;
    }
    if let (Some(&at), Some(last)) = (points.last(), seeds[first..].last()) {
        let tangent = last.tangent;
        seeds.push(Seed { at, limb, along: 1.0, tangent, end: 1, radius });
        seeds[first].end = -1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_finds_its_nearest_limb() {
        let limbs = [
            Limb { points: vec![vec2(10.0, 10.0), vec2(60.0, 12.0)], trust: vec![1.0; 2] },
            Limb { points: vec![vec2(30.0, 12.0), vec2(34.0, 50.0), vec2(20.0, 58.0)], trust: vec![1.0; 3] },
        ];
        let field = LimbField::new(80, 64, &limbs, &[]);
        let distance = |p: Vec2, limb: &Limb| {
            let pairs = limb.points.windows(2).map(|s| {
                let d = s[1] - s[0];
                let t = ((p - s[0]).dot(d) / d.length_squared()).clamp(0.0, 1.0);
                p.distance(s[0] + d * t)
            });
            pairs.fold(f32::INFINITY, f32::min)
        };
        for y in 0..64 {
            for x in 0..80 {
                let truth = limbs.iter().map(|l| distance(pixel(x, y), l)).fold(f32::INFINITY, f32::min);
                let found = field.at(x, y).expect("limbs").offset.abs();
                // Of two points in one pixel only one is passed on.
                assert!((found - truth).abs() < 0.8, "({x}, {y}): {found} for {truth}");
            }
        }
        let beyond = field.at(70, 12).expect("limbs");
        assert_eq!((beyond.limb, beyond.beyond), (0, 1));
        let side = |y| field.at(50, y).expect("limbs").offset.signum();
        assert_ne!(side(2), side(22));
    }

    #[test]
    fn without_limbs_nothing_has_a_place() {
        assert_eq!(LimbField::new(5, 5, &[], &[]).at(2, 2), None);
    }
}
