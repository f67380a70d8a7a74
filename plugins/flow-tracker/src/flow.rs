//! Where every place of a picture went in another: one motion a patch, asked for between patches.
//!
//! Patches on a grid are searched from coarse to fine (Kroeger, Timofte, Dai and Van Gool 2016, "Fast optical flow
//! using dense inverse search"), down to half the picture's resolution; the last step is taken where it is asked for
//! (see `carry`), which costs a tenth of taking it everywhere. What a patch found is then put to the vote of
//! its neighbours, weighed by how alike they look and how well they fit (the weighted median of Sun, Roth and Black
//! 2010, "Secrets of optical flow estimation", found among the neighbours' own answers), which keeps the edges between
//! a limb and what is behind it. There is no dense field: a place is answered by the patches around it.
//!
//! Limits: what moves farther between two frames than its own width is lost at the level that could follow it.

use glam::{Vec2, vec2};

use crate::patch::{Patch, SIDE};
use crate::pyramid::{Level, Pyramid};

/// Pixels between patches.
const STRIDE: usize = 4;
/// Steps of descent.
const STEPS: usize = 10;
/// Fixed point of stored motions.
const FIXED: f32 = 32.0;
/// Difference of mean brightness at which two patches stop looking alike.
const ALIKE: f32 = 12.0;

/// The flow between two pictures.
#[derive(Clone, Debug)]
pub(crate) struct Flow {
    columns: usize,
    rows: usize,
    /// Pixels of the picture for one of the level that was searched last.
    scale: f32,
    motions: Vec<[i16; 2]>,
    /// Root mean squared difference of each patch, 0 to 255.
    misfit: Vec<u8>,
}

struct Grid {
    columns: usize,
    rows: usize,
    motions: Vec<Vec2>,
    costs: Vec<f32>,
}

fn places(size: usize) -> usize {
    size.div_ceil(STRIDE).max(1)
}

/// The centre of a patch, from the first pixel's centre.
fn centre(column: usize, row: usize) -> Vec2 {
    vec2(column as f32, row as f32) * STRIDE as f32 + 0.5 * (STRIDE as f32 - 1.0)
}

impl Flow {
    /// From `from` to `to`, of one size; `None` when `go_on`, asked between rows of patches, said no.
    pub(crate) fn between(from: &Pyramid, to: &Pyramid, go_on: &dyn Fn() -> bool) -> Option<Self> {
        let mut coarse: Option<Grid> = None;
        let levels = from.levels.len().min(to.levels.len());
        let finest = usize::from(levels > 1);
        for i in (finest..levels).rev() {
            let grid = search(&from.levels[i], &to.levels[i], coarse.as_ref(), go_on)?;
            coarse = Some(vote(&from.levels[i], &grid));
        }
        let grid = coarse?;
        let fixed = |v: f32| (v * FIXED).round().clamp(f32::from(i16::MIN), f32::from(i16::MAX)) as i16;
        Some(Self {
            columns: grid.columns,
            rows: grid.rows,
            scale: (1 << finest) as f32,
            motions: grid.motions.iter().map(|m| [fixed(m.x), fixed(m.y)]).collect(),
            misfit: grid.costs.iter().map(|c| c.sqrt().min(255.0) as u8).collect(),
        })
    }

    /// The motion of the place `p` (the first pixel's centre is (0.5, 0.5)), by the four patches around it, those that
    /// fit counting most.
    pub(crate) fn at(&self, p: Vec2) -> Vec2 {
        let g = (p / self.scale - 0.5 - 0.5 * (STRIDE as f32 - 1.0)) / STRIDE as f32;
        let g = g.clamp(Vec2::ZERO, vec2((self.columns - 1) as f32, (self.rows - 1) as f32));
        let (x0, y0) = (g.x as usize, g.y as usize);
        let (x1, y1) = ((x0 + 1).min(self.columns - 1), (y0 + 1).min(self.rows - 1));
        let (fx, fy) = (g.x - x0 as f32, g.y - y0 as f32);
        let (mut sum, mut weight) = (Vec2::ZERO, 0.0);
        for (x, y, w) in
            [(x0, y0, (1.0 - fx) * (1.0 - fy)), (x1, y0, fx * (1.0 - fy)), (x0, y1, (1.0 - fx) * fy), (x1, y1, fx * fy)]
        {
            let i = y * self.columns + x;
            let w = (w + 1e-4) / (2.0 + f32::from(self.misfit[i]));
            sum += w * vec2(f32::from(self.motions[i][0]), f32::from(self.motions[i][1]));
            weight += w;
        }
        sum * (self.scale / (weight * FIXED))
    }
}

fn search(a: &Level, b: &Level, coarse: Option<&Grid>, go_on: &dyn Fn() -> bool) -> Option<Grid> {
    let (columns, rows) = (places(a.width), places(a.height));
    let n = columns * rows;
    let mut grid = Grid { columns, rows, motions: vec![Vec2::ZERO; n], costs: vec![0.0; n] };
    let mut patches = Vec::with_capacity(n);
    for row in 0..rows {
        if !go_on() {
            return None;
        }
        for column in 0..columns {
            let i = row * columns + column;
            let patch = Patch::new(a, centre(column, row), Vec2::X);
            if let Some(coarse) = coarse {
                let (x, y) = ((column / 2).min(coarse.columns - 1), (row / 2).min(coarse.rows - 1));
                let mut best = f32::INFINITY;
                // The coarse patches on both sides: at an edge one of them moved as this does.
                for (dx, dy) in
                    [(0, 0), (if column % 2 == 0 { -1 } else { 1 }, 0), (0, if row % 2 == 0 { -1 } else { 1 })]
                {
                    let cx = (x as isize + dx).clamp(0, coarse.columns as isize - 1) as usize;
                    let cy = (y as isize + dy).clamp(0, coarse.rows as isize - 1) as usize;
                    let start = 2.0 * coarse.motions[cy * coarse.columns + cx];
                    let cost = patch.cost(b, centre(column, row) + start);
                    if cost < best {
                        (best, grid.motions[i]) = (cost, start);
                    }
                }
                grid.costs[i] = best;
            } else {
                grid.costs[i] = patch.cost(b, centre(column, row));
            }
            patches.push(patch);
        }
    }
    for back in [false, true] {
        for k in 0..n {
            if k % columns == 0 && !go_on() {
                return None;
            }
            let i = if back { n - 1 - k } else { k };
            let (column, row) = (i % columns, i / columns);
            let here = centre(column, row);
            let neighbours = if back {
                [(column + 1 < columns).then_some(i + 1), (row + 1 < rows).then_some(i + columns)]
            } else {
                [(column > 0).then(|| i - 1), (row > 0).then(|| i - columns)]
            };
            let mut changed = !back;
            for j in neighbours.into_iter().flatten() {
                if grid.motions[j].distance_squared(grid.motions[i]) < 0.01 {
                    continue;
                }
                let cost = patches[i].cost(b, here + grid.motions[j]);
                if cost < grid.costs[i] {
                    (grid.motions[i], grid.costs[i]) = (grid.motions[j], cost);
                    changed = true;
                }
            }
            if changed {
                let found = patches[i].descend(b, here + grid.motions[i], STEPS, SIDE as f32);
                if found.cost <= grid.costs[i] {
                    (grid.motions[i], grid.costs[i]) = (found.at - here, found.cost);
                }
            }
        }
    }
    Some(grid)
}

/// Every patch's motion by the weighted median of its neighbourhood.
fn vote(level: &Level, grid: &Grid) -> Grid {
    let (columns, rows) = (grid.columns, grid.rows);
    let looks: Vec<f32> = (0..columns * rows)
        .map(|i| {
            let c = centre(i % columns, i / columns);
            0.25 * (level.sample(c.x - 1.0, c.y - 1.0)
                + level.sample(c.x + 1.0, c.y - 1.0)
                + level.sample(c.x - 1.0, c.y + 1.0)
                + level.sample(c.x + 1.0, c.y + 1.0))
        })
        .collect();
    let mut motions = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let i = row * columns + column;
            let mut voters = [(Vec2::ZERO, 0.0f32); 9];
            let mut n = 0;
            for y in row.saturating_sub(1)..(row + 2).min(rows) {
                for x in column.saturating_sub(1)..(column + 2).min(columns) {
                    let j = y * columns + x;
                    let unlike = (looks[j] - looks[i]) / ALIKE;
                    voters[n] = (grid.motions[j], (-unlike * unlike).exp() / (4.0 + grid.costs[j].sqrt()));
                    n += 1;
                }
            }
            let voters = &voters[..n];
            let loss = |m: Vec2| voters.iter().map(|(v, w)| w * v.distance(m)).sum::<f32>();
            let mut best = (f32::INFINITY, grid.motions[i]);
            for (candidate, weight) in voters {
                let l = loss(*candidate);
                if *weight > 0.0 && l < best.0 {
                    best = (l, *candidate);
                }
            }
            motions.push(best.1);
        }
    }
    Grid { columns, rows, motions, costs: grid.costs.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pattern that does not repeat at the scale of the motion, sampled at `map`.
    fn picture(width: usize, height: usize, map: impl Fn(Vec2) -> Vec2) -> Pyramid {
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let p = map(vec2(x as f32 + 0.5, y as f32 + 0.5));
                let wave = |a: f32, b: f32, c: f32| (p.x * a + p.y * b + c).sin();
                let v = wave(0.11, 0.07, 0.0) + wave(-0.05, 0.13, 1.0) + wave(0.31, -0.21, 2.0) + wave(0.03, 0.29, 0.5);
                pixels.push(128.0 + 28.0 * v);
            }
        }
        Pyramid::new(Level { width, height, pixels })
    }

    #[test]
    fn follows_shifts_and_turns_to_a_fraction_of_a_pixel() {
        let centre = vec2(100.0, 75.0);
        for (turn, shift) in [(0.0f32, vec2(6.3, -3.6)), (0.06, vec2(-2.0, 1.0)), (0.0, vec2(14.2, 0.0))] {
            let moved = |p: Vec2| centre + Vec2::from_angle(turn).rotate(p - centre) + shift;
            let unmoved = |q: Vec2| centre + Vec2::from_angle(-turn).rotate(q - centre - shift);
            let flow = Flow::between(&picture(200, 150, |p| p), &picture(200, 150, unmoved), &|| true);
            let flow = flow.expect("nobody stops it");
            let (mut sum, mut worst, mut n) = (0.0, 0.0f32, 0.0);
            for y in (25..125).step_by(5) {
                for x in (25..175).step_by(5) {
                    let p = vec2(x as f32, y as f32);
                    let error = (p + flow.at(p)).distance(moved(p));
                    (sum, worst, n) = (sum + error, worst.max(error), n + 1.0);
                }
            }
            assert!(sum / n < 0.2 && worst < 1.5, "{turn} {shift}: mean {}, worst {worst}", sum / n);
        }
    }

    #[test]
    fn tiny_and_flat_pictures_stay() {
        for (w, h) in [(1, 1), (3, 50), (64, 64)] {
            let flat = Pyramid::new(Level { width: w, height: h, pixels: vec![70.0; w * h] });
            let flow = Flow::between(&flat, &flat, &|| true).expect("nobody stops it");
            assert!(flow.at(vec2(1.0, 1.0)).length() < 1e-3);
        }
    }
}
