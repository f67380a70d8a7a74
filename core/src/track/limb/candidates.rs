//! Maps of matching costs and the places worth considering in them.
//!
//! The dominant minima of a window's costs (Reinert 2016, section 3.5) would all lie in one hollow were they simply the
//! lowest values; here they are local minima that keep a distance from each other, each placed between pixels by the
//! parabola through its neighbours.

use glam::{Vec2, vec2};

use crate::raster::Grid;

/// A place where a vertex may be, in pixels of the searched image, and what it costs to be there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The place.
    pub at: Vec2,
    /// Its matching cost; lower is more alike.
    pub cost: f32,
}

/// One cost for every pixel of a rectangle. Costs that are not finite are no candidates.
#[derive(Clone, Debug, PartialEq)]
pub struct CostMap {
    /// Column and row of the rectangle's first pixel in the searched image.
    pub origin: (isize, isize),
    /// The costs.
    pub costs: Grid<f32>,
}

impl CostMap {
    /// At most `count` local minima, the best first, any two at least `separation` pixels apart. A pixel on the
    /// rectangle's border counts when no neighbour inside is lower. Ties go to the upper, then the left pixel.
    pub fn minima(&self, count: usize, separation: f32) -> Vec<Candidate> {
        self.lowest(count, separation, |x, y| self.refined(x, y))
    }

    /// [`Self::minima`] on whole pixels.
    pub fn pixel_minima(&self, count: usize, separation: f32) -> Vec<Candidate> {
        self.lowest(count, separation, |x, y| Candidate { at: self.place(x, y), cost: self.costs.get(x, y) })
    }

    fn lowest(&self, count: usize, separation: f32, at: impl Fn(usize, usize) -> Candidate) -> Vec<Candidate> {
        let (width, height) = (self.costs.width(), self.costs.height());
        let mut found: Vec<(f32, usize, usize)> = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let cost = self.costs.get(x, y);
                if cost.is_finite() && self.is_lowest_around(x, y) {
                    found.push((cost, y, x));
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut kept: Vec<Candidate> = Vec::with_capacity(count);
        for (_, y, x) in found {
            if kept.len() == count {
                break;
            }
            let candidate = at(x, y);
            if kept.iter().all(|k| k.at.distance_squared(candidate.at) >= separation * separation) {
                kept.push(candidate);
            }
        }
        kept
    }

    /// The centre of a pixel of the map, in the searched image.
    pub fn place(&self, x: usize, y: usize) -> Vec2 {
        vec2((self.origin.0 + x as isize) as f32 + 0.5, (self.origin.1 + y as isize) as f32 + 0.5)
    }

    fn is_lowest_around(&self, x: usize, y: usize) -> bool {
        let cost = self.costs.get(x, y);
        for ny in y.saturating_sub(1)..=(y + 1).min(self.costs.height() - 1) {
            for nx in x.saturating_sub(1)..=(x + 1).min(self.costs.width() - 1) {
                let other = self.costs.get(nx, ny);
                if other < cost || (other == cost && (ny, nx) < (y, x)) {
                    return false;
                }
            }
        }
        true
    }

    /// The lowest point of the parabolas through the minimum and its neighbours, across and down.
    fn refined(&self, x: usize, y: usize) -> Candidate {
        let cost = self.costs.get(x, y);
        let along = |before: Option<f32>, after: Option<f32>| match (before, after) {
            (Some(before), Some(after)) if before.is_finite() && after.is_finite() => {
                let bend = before - 2.0 * cost + after;
                let slope = 0.5 * (after - before);
                // Neighbours are no lower, so the lowest point lies within half a pixel.
                if bend > 0.0 { ((-slope / bend).clamp(-0.5, 0.5), 0.5 * slope * slope / bend) } else { (0.0, 0.0) }
            }
            _ => (0.0, 0.0),
        };
        let value = |nx: Option<usize>, ny: Option<usize>| match (nx, ny) {
            (Some(nx), Some(ny)) if nx < self.costs.width() && ny < self.costs.height() => Some(self.costs.get(nx, ny)),
            _ => None,
        };
        let (dx, gain_x) = along(value(x.checked_sub(1), Some(y)), value(Some(x + 1), Some(y)));
        let (dy, gain_y) = along(value(Some(x), y.checked_sub(1)), value(Some(x), Some(y + 1)));
        Candidate { at: self.place(x, y) + vec2(dx, dy), cost: (cost - gain_x - gain_y).max(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: usize, height: usize, cost: impl Fn(Vec2) -> f32) -> CostMap {
        let blank = CostMap { origin: (-3, 10), costs: Grid::new(width, height, 0.0) };
        let mut out = blank.clone();
        for y in 0..height {
            for x in 0..width {
                out.costs.set(x, y, cost(blank.place(x, y)));
            }
        }
        out
    }

    #[test]
    fn hollows_are_found_between_pixels_and_once_each() {
        let hollows = [(vec2(4.3, 16.8), 1.0), (vec2(20.1, 22.6), 0.5)];
        let found = map(40, 30, |p| {
            hollows.iter().map(|(at, low)| low + 0.01 * p.distance_squared(*at)).fold(f32::INFINITY, f32::min)
        })
        .minima(5, 3.0);
        assert_eq!(found.len(), 2);
        for (candidate, (at, low)) in found.iter().zip([hollows[1], hollows[0]]) {
            assert!(candidate.at.distance(at) < 1e-2 && (candidate.cost - low).abs() < 1e-3, "{candidate:?}");
        }
    }

    #[test]
    fn plateaus_borders_and_holes_are_no_trouble() {
        assert_eq!(map(9, 9, |_| 2.0).minima(5, 3.0).len(), 1);
        let slope = map(9, 9, |p| p.x).minima(5, 3.0);
        assert_eq!(slope[0].at.x, -2.5);
        assert!(map(9, 9, |_| f32::INFINITY).minima(5, 3.0).is_empty());
        assert!(map(0, 0, |_| 0.0).minima(5, 3.0).is_empty());
    }
}
