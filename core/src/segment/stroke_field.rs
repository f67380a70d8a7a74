//! Limb coordinates of pixels: the nearest stroke sample, on which side of the stroke, how far.
//!
//! What is learned about a limb (how thick it is, where creature was seen beside it) is kept in these coordinates, and
//! so moves with the limb from frame to frame.

use glam::{Vec2, vec2};

use super::working::Limbs;
use crate::raster::{Grid, distance};

/// Fixed-point steps of a distance for one working pixel.
const STEPS: f32 = 16.0;
/// Border around the image, as a share of its longer side, in which strokes outside still count.
const BORDER: f32 = 0.12;
/// No sample: there is no stroke in or near the image.
pub(super) const NOWHERE: u16 = u16::MAX;

/// One pixel in limb coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// Index into the samples of [`Limbs`], or [`NOWHERE`].
    pub(super) sample: u16,
    /// Distance to the stroke in sixteenths of a pixel, negative on the right of the stroke's direction.
    signed: i16,
}

impl Place {
    /// Distance to the stroke in working pixels.
    #[inline]
    pub(super) fn distance(self) -> f32 {
        f32::from(self.signed.unsigned_abs()) / STEPS
    }

    /// 0 or 1: the side of the stroke.
    #[inline]
    pub(super) fn side(self) -> usize {
        usize::from(self.signed < 0)
    }
}

/// Bounds what is kept for a frame, for rigs of very many limbs.
const MAX_CELLS: usize = 1 << 19;

/// Cells of limb coordinates: sample, side, distance in whole working pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    samples: usize,
    /// Distances kept.
    pub(super) reach: usize,
}

impl Cells {
    pub(super) fn new(samples: usize, reach: f32) -> Self {
        let bound = MAX_CELLS / (2 * samples.max(1));
        Self { samples, reach: (reach.ceil() as usize).min(bound).clamp(4, 400) }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.samples * 2 * self.reach
    }

    /// The cell of a pixel, `None` beyond the reach.
    #[inline]
    pub(super) fn of(&self, place: Place) -> Option<usize> {
        let distance = place.distance() as usize;
        let inside = place.sample != NOWHERE && distance < self.reach;
        inside.then(|| (usize::from(place.sample) * 2 + place.side()) * self.reach + distance)
    }
}

/// The limb coordinates of every pixel of a frame.
pub(super) fn stroke_field(limbs: &Limbs, frame: usize, width: usize, height: usize) -> Grid<Place> {
    let border = (width.max(height) as f32 * BORDER).ceil() as usize;
    let places = &limbs.places[frame];
    let (wide, high) = (width + 2 * border, height + 2 * border);
    let mut sites = Grid::new(wide, high, distance::NO_SITE);
    let shift = vec2(border as f32, border as f32);
    for limb in 0..limbs.first.len() - 1 {
        for sample in limbs.of(limb) {
            let here = places[sample];
            let next = if sample + 1 < limbs.of(limb).end { places[sample + 1] } else { here };
            if !here.is_finite() || !next.is_finite() {
                continue;
            }
            // Far outside nothing can matter, and steps must stay few.
            let steps = (here.distance(next).ceil() as usize).clamp(1, 256);
            for i in 0..=steps {
                let t = i as f32 / steps as f32;
                let p = here.lerp(next, t) + shift;
                if p.x >= 0.0 && p.y >= 0.0 && (p.x as usize) < wide && (p.y as usize) < high {
                    let nearest = if t < 0.5 || sample + 1 >= limbs.of(limb).end { sample } else { sample + 1 };
                    sites.set(p.x as usize, p.y as usize, nearest as u32);
                }
            }
        }
    }
    let nearest = distance::nearest_site(&sites);
    let mut field = Grid::new(width, height, Place { sample: NOWHERE, signed: i16::MAX });
    for y in 0..height {
        for x in 0..width {
            let sample = nearest.get(x + border, y + border);
            if sample == distance::NO_SITE {
                continue;
            }
            let sample = sample as usize;
            let range = limbs.of(usize::from(limbs.limb[sample]));
            let centre = vec2(x as f32 + 0.5, y as f32 + 0.5);
            let before = places[sample.saturating_sub(1).max(range.start)];
            let after = places[(sample + 1).min(range.end - 1)];
            let here = places[sample];
            let distance = to_segment(centre, before, here).min(to_segment(centre, here, after));
            let left = (after - before).perp_dot(centre - here) >= 0.0;
            let fixed = (distance * STEPS).round().clamp(1.0, f32::from(i16::MAX)) as i16;
            field.set(x, y, Place { sample: sample as u16, signed: if left { fixed } else { -fixed } });
        }
    }
    field
}

/// Distance from `p` to the segment from `a` to `b`.
fn to_segment(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let along = b - a;
    let t =
        if along.length_squared() > 0.0 { ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + along * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_and_distances_follow_the_stroke() {
        let limbs = Limbs {
            limb: vec![0, 0, 0],
            first: vec![0, 3],
            length: vec![20.0],
            trusted: vec![true; 3],
            twin: vec![None],
            places: vec![vec![vec2(10.5, 20.5), vec2(20.5, 20.5), vec2(30.5, 20.5)], vec![Vec2::NAN; 3]],
            visible: vec![vec![true; 3], vec![false; 3]],
            drawn: vec![vec![true], vec![false]],
        };
        let field = stroke_field(&limbs, 0, 40, 40);
        let (above, below) = (field.get(20, 12), field.get(20, 29));
        assert_ne!(above.side(), below.side());
        assert!((above.distance() - 8.0).abs() < 0.1 && (below.distance() - 9.0).abs() < 0.1);
        assert_eq!((field.get(11, 5).sample, field.get(29, 5).sample), (0, 2));
        let nothing = stroke_field(&limbs, 1, 40, 40);
        assert!(nothing.data().iter().all(|p| p.sample == NOWHERE));
    }
}
