//! The appearance cost of Reinert 2016, section 3.5: how unlike the last three views of a vertex a place is.
//!
//! A place costs the least mean squared colour difference of its patch to 21 variants: the patches around the vertex in the
//! last three frames where it was seen, each in seven rotations within 10 degrees. The paper sums the squares and leaves
//! their unit open; a mean does not change with the patch's size, and `colour_unit` sets its weight against pixels of
//! stretch.
//!
//! The paper tries every pixel of the window. [`Views::search`] does that, or finds the same minima in three steps: all
//! pixels at a quarter of the size with a third of the rotations, then around the best at half and full size with the
//! variants next to the best one.

use std::collections::VecDeque;

use glam::Vec2;
use image::RgbImage;

use super::super::candidates::{Candidate, CostMap};
use super::super::params::PaperParams;
use super::super::patch::{Patch, Region};
use super::super::templates::Surroundings;
use crate::raster::{Grid, Planes};

/// Resolutions: full, half, quarter.
const LEVELS: usize = 3;
/// Hollows followed from each resolution to the next, for each candidate wanted.
const FOLLOWED: usize = 2;
/// Standard deviation of Gaussian patch weights as a share of the side, where they are asked for.
const SIGMA: f32 = 0.3;
/// Windows of fewer pixels are searched at half size at once.
const SMALL_WINDOW: f32 = 48.0;

/// A frame in the colours that are compared, at all resolutions.
#[derive(Clone, Debug)]
pub(super) struct View {
    levels: [Planes; LEVELS],
}

impl View {
    pub(super) fn new(image: &RgbImage, params: &PaperParams) -> Self {
        let full = if params.lab { Planes::lab(image) } else { Planes::rgb(image) };
        let half = full.halved();
        let quarter = half.halved();
        Self { levels: [full, half, quarter] }
    }
}

/// The last frames in which a vertex was seen, the latest first.
#[derive(Clone, Debug, Default)]
pub(super) struct Views {
    shots: VecDeque<[Surroundings; LEVELS]>,
}

/// One of the variants a place is compared with: which shot, and which rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Variant {
    shot: usize,
    rotation: usize,
}

/// Where and with which variant a level's minimum lies.
#[derive(Clone, Copy, Debug)]
struct Hollow {
    at: Vec2,
    cost: f32,
    variant: Variant,
}

/// What all searches of one tracking share. Lengths in working pixels.
#[derive(Clone, Debug)]
pub(super) struct Matcher {
    side: f32,
    count: usize,
    separation: f32,
    coarse_to_fine: bool,
    subpixel: bool,
    sigma: f32,
    truncation: f32,
    /// Cost of one unit of summed squared difference over the three channels.
    unit: f32,
    turns: Vec<Vec2>,
    shots: usize,
}

impl Matcher {
    pub(super) fn new(params: &PaperParams, scale: f32) -> Self {
        let n = params.rotations.max(1);
        let turn = |i: usize| {
            let share = if n > 1 { 2.0 * i as f32 / (n - 1) as f32 - 1.0 } else { 0.0 };
            Vec2::from_angle(share * params.max_rotation.to_radians())
        };
        let side = params.patch * scale;
        Self {
            side,
            count: params.candidates.max(1),
            separation: params.separation * scale,
            coarse_to_fine: params.coarse_to_fine,
            subpixel: params.lab,
            sigma: if params.lab { SIGMA * side } else { f32::INFINITY },
            truncation: params.colour_truncation,
            unit: params.colour_unit / 3.0,
            turns: (0..n).map(turn).collect(),
            shots: params.templates.max(1),
        }
    }

    fn patch(&self, views: &Views, variant: Variant, level: usize) -> Patch {
        let shrink = (1 << level) as f32;
        let side = (self.side / shrink).round().max(3.0) as usize;
        views.shots[variant.shot][level].patch(side, self.turns[variant.rotation], self.sigma / shrink)
    }

    /// The variants next to one: its own neighbours in rotation, and the other shots in its rotation.
    fn nearby(&self, views: &Views, v: Variant) -> Vec<Variant> {
        let last = self.turns.len() - 1;
        let rotations = v.rotation.saturating_sub(1)..=(v.rotation + 1).min(last);
        let turned = rotations.map(|rotation| Variant { rotation, ..v });
        let others = (0..views.shots.len()).filter(|&shot| shot != v.shot).map(|shot| Variant { shot, ..v });
        turned.chain(others).collect()
    }

    /// Every `step`th variant of every shot, the middle rotation always among them.
    fn variants(&self, views: &Views, step: usize) -> Vec<Variant> {
        let middle = self.turns.len() / 2;
        let rotations: Vec<usize> = (0..self.turns.len()).filter(|r| r.abs_diff(middle) % step == 0).collect();
        (0..views.shots.len())
            .flat_map(|shot| rotations.iter().map(move |&rotation| Variant { shot, rotation }))
            .collect()
    }
}

impl Views {
    /// Remembers the vertex at `at` in `view`, and forgets views beyond the number kept.
    pub(super) fn remember(&mut self, view: &View, at: Vec2, matcher: &Matcher) {
        let shot = |level: usize| {
            let shrink = (1 << level) as f32;
            Surroundings::new(&view.levels[level], at / shrink, matcher.side / shrink, |_| 1.0)
        };
        self.shots.push_front([shot(0), shot(1), shot(2)]);
        self.shots.truncate(matcher.shots);
    }

    /// The dominant minima of the costs over a window of `side` pixels around `centre`, inside the image, best first.
    pub(super) fn search(&self, view: &View, matcher: &Matcher, centre: Vec2, side: f32) -> Vec<Candidate> {
        if self.shots.is_empty() || !centre.is_finite() {
            return Vec::new();
        }
        let found = if matcher.coarse_to_fine {
            self.search_coarse_to_fine(view, matcher, centre, side)
        } else {
            let (map, _) = self.costs(view, matcher, 0, &matcher.variants(self, 1), centre, side);
            self.pick(&map, matcher, matcher.count, matcher.separation)
        };
        found.into_iter().map(|c| Candidate { cost: c.cost * matcher.unit, ..c }).collect()
    }

    /// What it costs to be exactly at `at`: the least over all variants, without a search.
    pub(super) fn cost(&self, view: &View, matcher: &Matcher, at: Vec2) -> f32 {
        let Some(first) = matcher.variants(self, 1).first().map(|&v| matcher.patch(self, v, 1)) else {
            return f32::INFINITY;
        };
        let seen = Patch::cut(&view.levels[1], at * 0.5, Vec2::X, first.side());
        let variants = matcher.variants(self, 2);
        let cost = |&v: &Variant| matcher.patch(self, v, 1).difference(&seen, matcher.truncation);
        variants.iter().map(cost).fold(f32::INFINITY, f32::min) * matcher.unit
    }

    fn pick(&self, map: &CostMap, matcher: &Matcher, count: usize, separation: f32) -> Vec<Candidate> {
        if matcher.subpixel { map.minima(count, separation) } else { map.pixel_minima(count, separation) }
    }

    fn search_coarse_to_fine(&self, view: &View, matcher: &Matcher, centre: Vec2, side: f32) -> Vec<Candidate> {
        let top = if side < SMALL_WINDOW { 1 } else { LEVELS - 1 };
        let shrink = (1 << top) as f32;
        let (map, best) = self.costs(view, matcher, top, &matcher.variants(self, 3), centre / shrink, side / shrink);
        let wanted = FOLLOWED * matcher.count;
        let hollow = |c: Candidate| {
            let (x, y) = (c.at.x.floor() as isize - map.origin.0, c.at.y.floor() as isize - map.origin.1);
            Hollow { at: c.at, cost: c.cost, variant: best.clamped(x, y) }
        };
        let mut hollows: Vec<Hollow> =
            map.pixel_minima(wanted, matcher.separation / shrink).into_iter().map(hollow).collect();
        let mut found: Vec<Candidate> = Vec::new();
        for level in (0..top).rev() {
            let mut finer: Vec<Hollow> = Vec::with_capacity(hollows.len());
            found.clear();
            for h in &hollows {
                let (map, _) = self.costs(view, matcher, level, &[h.variant], h.at * 2.0, 5.0);
                let Some(lowest) = self.pick(&map, matcher, 1, 0.0).first().copied() else { continue };
                let (variant, least) = self.best_variant(view, matcher, level, h.variant, lowest.at);
                let cost = lowest.cost.min(least);
                finer.push(Hollow { at: lowest.at, cost, variant });
            }
            finer.sort_by(|a, b| {
                a.cost.total_cmp(&b.cost).then(a.at.y.total_cmp(&b.at.y)).then(a.at.x.total_cmp(&b.at.x))
            });
            let separation = matcher.separation / (1 << level) as f32;
            let mut kept: Vec<Hollow> = Vec::with_capacity(matcher.count);
            for h in finer {
                if kept.len() < matcher.count && kept.iter().all(|k| k.at.distance(h.at) >= separation) {
                    kept.push(h);
                }
            }
            hollows = kept;
            found.extend(hollows.iter().map(|h| Candidate { at: h.at, cost: h.cost }));
        }
        found
    }

    /// The best of the variants near one on the pixel around `at`.
    fn best_variant(&self, view: &View, matcher: &Matcher, level: usize, v: Variant, at: Vec2) -> (Variant, f32) {
        let mut best = (v, f32::INFINITY);
        for variant in matcher.nearby(self, v) {
            let (map, _) = self.costs(view, matcher, level, &[variant], at, 1.0);
            let cost = map.costs.data().first().copied().unwrap_or(f32::INFINITY);
            if cost < best.1 {
                best = (variant, cost);
            }
        }
        best
    }

    /// The least cost over some variants for every pixel of a window inside the image, and which variant has it.
    fn costs(
        &self,
        view: &View,
        matcher: &Matcher,
        level: usize,
        variants: &[Variant],
        centre: Vec2,
        side: f32,
    ) -> (CostMap, Grid<Variant>) {
        let image = &view.levels[level];
        let span = |c: f32, n: usize| {
            let first = (c - 0.5 * side).round().clamp(0.0, n as f32) as usize;
            let end = (c + 0.5 * side).round().clamp(0.0, n as f32) as usize;
            (first, end.saturating_sub(first))
        };
        let (x, width) = span(centre.x, image.width());
        let (y, height) = span(centre.y, image.height());
        let origin = (x as isize, y as isize);
        let none = Variant { shot: 0, rotation: 0 };
        let mut least = CostMap { origin, costs: Grid::new(width, height, f32::INFINITY) };
        let mut which = Grid::new(width, height, none);
        if width == 0 || height == 0 {
            return (least, which);
        }
        let mut region: Option<Region> = None;
        for &variant in variants {
            let patch = matcher.patch(self, variant, level);
            let region = region.get_or_insert_with(|| Region::around(image, origin, width, height, patch.side()));
            let costs = region.costs(&patch, matcher.truncation).costs;
            for ((best, index), &cost) in least.costs.data_mut().iter_mut().zip(which.data_mut()).zip(costs.data()) {
                if cost < *best {
                    *best = cost;
                    *index = variant;
                }
            }
        }
        (least, which)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::stage_set::{Bar, scene};
    use super::*;
    use glam::vec2;

    #[test]
    fn coarse_to_fine_finds_what_trying_every_pixel_finds() {
        let bar = |f: f32| Bar {
            from: vec2(40.0 + 5.0 * f, 50.0 - 3.0 * f),
            angle: 0.5 + 0.1 * f,
            length: 90.0,
            half_width: 10.0,
        };
        let picture = |f: f32| scene((220, 160), &[bar(f)], Vec2::ZERO);
        // Patches as large as the paper's, so that a quarter of the size still shows something.
        let quick = PaperParams { window: 48.0, patch: 24.0, ..PaperParams::default() };
        let brute = PaperParams { coarse_to_fine: false, ..quick.clone() };
        let (quick, brute) = (Matcher::new(&quick, 1.0), Matcher::new(&brute, 1.0));
        let (before, after) =
            (View::new(&picture(0.0), &PaperParams::default()), View::new(&picture(1.0), &PaperParams::default()));
        let mut agree = 0;
        for i in 1..9 {
            let at = bar(0.0).at(i as f32 / 9.0);
            let mut views = Views::default();
            views.remember(&before, at, &brute);
            let exact = views.search(&after, &brute, at, 48.0);
            let found = views.search(&after, &quick, at, 48.0);
            assert!(exact[0].at.distance(bar(1.0).at(i as f32 / 9.0)) < 2.0, "{:?}", exact[0]);
            assert!(exact.windows(2).all(|p| p[0].cost <= p[1].cost) && exact.len() <= 5);
            agree += usize::from(found[0].at.distance(exact[0].at) < 1.5);
        }
        assert!(agree >= 7, "{agree} of 8");
    }
}
