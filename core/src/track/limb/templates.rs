//! What every skeleton vertex looks like on its key frames, and finding it on another frame.
//!
//! A template that follows the last match drifts; one that stays with the key frame does not (Matthews, Ishikawa & Baker
//! 2004, "The template update problem"), and it finds a limb again that was hidden. Each vertex keeps a Lab patch for every
//! key frame that draws it. To search a frame the patch is turned with the limb, from the direction drawn to the
//! direction now, and weighs most what is near the vertex and likely on the limb. The search runs over a whole window at
//! half size and again around the best places at full size.
//!
//! Limits: a limb seen from another side looks different from its key frames; foreshortening is not modelled.

use glam::{Vec2, vec2};
use image::RgbImage;

use super::candidates::{Candidate, CostMap};
use super::limb_width::half_widths;
use super::params::TemplateParams;
use super::patch::{Patch, Region};
use crate::raster::{Grid, Planes, sample};
use crate::rig::Skeleton;

/// How often a search at full size may move on when the half-size minimum was beside the true one.
const DESCENT: usize = 3;

/// A frame ready to be searched: Lab at full and half size.
#[derive(Clone, Debug)]
pub struct MatchImage {
    full: Planes,
    half: Planes,
}

impl MatchImage {
    /// Prepares a frame at the working resolution.
    pub fn new(image: &RgbImage) -> Self {
        let full = Planes::lab(image);
        let half = full.halved();
        Self { full, half }
    }

    /// The frame in Lab.
    pub fn full(&self) -> &Planes {
        &self.full
    }
}

/// What a search found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detection {
    /// Places that look like the vertex, the best first; costs in 0..=1, 0 alike and 1 nothing alike. Empty when the
    /// vertex is drawn nowhere or the window lies outside the image.
    pub candidates: Vec<Candidate>,
    /// How clearly the best place beats the next: 0 when another is as good, 1 when any other differs as much as
    /// look-alikes did on the key frame.
    pub margin: f32,
}

/// Templates of all vertices of a skeleton. Places are pixels of the images given.
#[derive(Clone, Debug)]
pub struct KeyTemplates {
    params: TemplateParams,
    axes: Vec<Axis>,
    /// For each vertex the key frames that draw it, by rising frame.
    vertices: Vec<Vec<KeyPatch>>,
}

/// The two vertices whose difference is a vertex's direction.
#[derive(Clone, Copy, Debug)]
struct Axis {
    from: usize,
    to: usize,
}

/// A vertex on one key frame: the image around it, in key-frame axes.
#[derive(Clone, Debug)]
struct KeyPatch {
    frame: usize,
    direction: Vec2,
    /// Full and half size.
    levels: [Surroundings; 2],
    distinctiveness: f32,
}

/// An image around a place, as much of it as a turned patch sees.
#[derive(Clone, Debug)]
pub(super) struct Surroundings {
    colours: Planes,
    weights: Grid<f32>,
    /// The vertex, in pixels of `colours`.
    centre: Vec2,
}

impl KeyTemplates {
    /// No key frames yet. Lengths in `params` are in pixels of the images that will be given.
    pub fn new(skeleton: &Skeleton, params: TemplateParams) -> Self {
        let vertices = vec![Vec::new(); skeleton.len()];
        Self { params, axes: axes(skeleton), vertices }
    }

    /// The largest squared Lab difference (of Lab / 100) that one pixel counts for; a cost of 1 is a mean of this.
    pub fn truncation(&self) -> f32 {
        self.params.truncation
    }

    /// Learns the vertices that a key frame draws. `places` has one entry a vertex, `None` where not drawn.
    pub fn add_key(&mut self, frame: usize, image: &MatchImage, skeleton: &Skeleton, places: &[Option<Vec2>]) {
        let directions = self.directions(|v| places.get(v).copied().flatten());
        let strokes: Vec<Vec<Vec2>> = skeleton
            .limbs
            .iter()
            .map(|limb| limb.vertices.iter().map_while(|&v| places.get(v).copied().flatten()).collect())
            .collect();
        // Every vertex is a little on each limb that it belongs to.
        let mut parts: Vec<Vec<(usize, f32)>> = vec![Vec::new(); skeleton.len()];
        for (l, (limb, stroke)) in skeleton.limbs.iter().zip(&strokes).enumerate() {
            if stroke.len() < limb.vertices.len() {
                continue;
            }
            for (&v, width) in limb.vertices.iter().zip(half_widths(&image.full, stroke, self.params.side)) {
                parts[v].push((l, width));
            }
        }
        for (v, part) in parts.iter().enumerate() {
            let Some(at) = places.get(v).copied().flatten() else { continue };
            let on_limb = |p: Vec2| {
                let near = |&(l, width): &(usize, f32)| {
                    let beyond = (polyline_distance(&strokes[l], p) - width) / (0.3 * width + 1.0);
                    1.0 - beyond.clamp(0.0, 1.0)
                };
                let inside = part.iter().map(near).fold(0.0, f32::max);
                self.params.background + (1.0 - self.params.background) * inside
            };
            let levels = [
                Surroundings::new(&image.full, at, self.params.side, on_limb),
                Surroundings::new(&image.half, at * 0.5, self.params.side * 0.5, |p| on_limb(p * 2.0)),
            ];
            let mut patch = KeyPatch { frame, direction: directions[v], levels, distinctiveness: 0.0 };
            patch.distinctiveness = self.distinctiveness_of(&patch, image, at);
            let place = self.vertices[v].partition_point(|k| k.frame < frame);
            self.vertices[v].insert(place, patch);
        }
    }

    /// The unit direction of every vertex along its limb, from places of all vertices.
    pub fn directions(&self, place: impl Fn(usize) -> Option<Vec2>) -> Vec<Vec2> {
        let direction = |a: &Axis| (place(a.to)? - place(a.from)?).try_normalize();
        self.axes.iter().map(|a| direction(a).unwrap_or(Vec2::X)).collect()
    }

    /// How different a vertex is, on its key frames, from everything around it but itself: 0 when its surroundings hold
    /// its like (matches mean little), up to 1.
    pub fn distinctiveness(&self, vertex: usize) -> f32 {
        let keys = &self.vertices[vertex];
        keys.iter().map(|k| k.distinctiveness).sum::<f32>() / keys.len().max(1) as f32
    }

    /// Searches a frame for a vertex: all places within `window` pixels of `centre`, across and down, for the limb
    /// pointing along `direction` (a unit vector). The key frames at or around `frame` give the templates, and a place
    /// costs what the better one says.
    pub fn detect(
        &self,
        frame: usize,
        image: &MatchImage,
        vertex: usize,
        centre: Vec2,
        window: f32,
        direction: Vec2,
    ) -> Detection {
        let keys = self.around(vertex, frame);
        let Some(patches) = self.turned(&keys, direction, 0) else { return Detection::default() };
        let mut candidates = if window > 4.0
            && let Some(coarse) = self.turned(&keys, direction, 1)
        {
            let near = self.search(&image.half, &coarse, centre * 0.5, window * 0.5);
            let wanted = 2 * self.params.candidates;
            let hollows = near.minima(wanted, 0.5 * self.params.separation);
            hollows.iter().filter_map(|c| self.descend(&image.full, &patches, c.at * 2.0)).collect()
        } else {
            self.search(&image.full, &patches, centre, window).minima(self.params.candidates, self.params.separation)
        };
        candidates
            .sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.at.x.total_cmp(&b.at.x)).then(a.at.y.total_cmp(&b.at.y)));
        let mut kept: Vec<Candidate> = Vec::with_capacity(self.params.candidates);
        for candidate in candidates {
            let apart = |k: &Candidate| k.at.distance(candidate.at) >= self.params.separation;
            if kept.len() < self.params.candidates && kept.iter().all(apart) {
                kept.push(candidate);
            }
        }
        let distinct = self.distinctiveness(vertex).max(1e-3);
        let margin = match kept.as_slice() {
            [] => 0.0,
            [best] => ((1.0 - best.cost) / distinct).clamp(0.0, 1.0),
            [best, rival, ..] => ((rival.cost - best.cost) / distinct).clamp(0.0, 1.0),
        };
        Detection { candidates: kept, margin }
    }

    /// What it costs the vertex to be exactly at `at`, in 0..=1; `None` where it is drawn nowhere.
    pub fn cost(&self, frame: usize, image: &MatchImage, vertex: usize, at: Vec2, direction: Vec2) -> Option<f32> {
        let patches = self.turned(&self.around(vertex, frame), direction, 0)?;
        if !at.is_finite() {
            return Some(1.0);
        }
        // Shift the image, not the templates, so that all templates share the resampling.
        let side = patches[0].side();
        let seen = Patch::cut(&image.full, at, Vec2::X, side);
        let cost = |p: &Patch| p.difference(&seen, self.params.truncation) / self.params.truncation;
        Some(patches.iter().map(cost).fold(f32::INFINITY, f32::min).min(1.0))
    }

    /// The key frames of a vertex at or on either side of `frame`.
    fn around(&self, vertex: usize, frame: usize) -> Vec<&KeyPatch> {
        let Some(keys) = self.vertices.get(vertex) else { return Vec::new() };
        let after = keys.partition_point(|k| k.frame < frame);
        if let Some(exact) = keys.get(after).filter(|k| k.frame == frame) {
            return vec![exact];
        }
        after.checked_sub(1).and_then(|b| keys.get(b)).into_iter().chain(keys.get(after)).collect()
    }

    fn turned(&self, keys: &[&KeyPatch], direction: Vec2, level: usize) -> Option<Vec<Patch>> {
        let side = (self.params.side / (1 << level) as f32).round().max(3.0) as usize;
        let sigma = self.params.sigma * self.params.side / (1 << level) as f32;
        let patches = keys.iter().map(|k| {
            // The turn from the key frame's direction to this one, as a unit complex number.
            let turn = vec2(k.direction.dot(direction), k.direction.perp_dot(direction));
            let turn = turn.try_normalize().unwrap_or(Vec2::X);
            k.levels[level].patch(side, turn, sigma)
        });
        Some(patches.collect()).filter(|p: &Vec<Patch>| !p.is_empty())
    }

    /// The better template's costs over the part of a window that lies in the image, in 0..=1.
    fn search(&self, image: &Planes, patches: &[Patch], centre: Vec2, window: f32) -> CostMap {
        let empty = CostMap { origin: (0, 0), costs: Grid::new(0, 0, f32::INFINITY) };
        if !(centre.is_finite() && window.is_finite()) {
            return empty;
        }
        let span = |c: f32, n: usize| {
            let low = (c - 0.5 - window).round().clamp(0.0, n as f32) as usize;
            let high = ((c - 0.5 + window).round() + 1.0).clamp(0.0, n as f32) as usize;
            (low, high.saturating_sub(low))
        };
        let (x, width) = span(centre.x, image.width());
        let (y, height) = span(centre.y, image.height());
        let (Some(first), true) = (patches.first(), width > 0 && height > 0) else { return empty };
        let region = Region::around(image, (x as isize, y as isize), width, height, first.side());
        let mut map = region.costs(first, self.params.truncation);
        for patch in &patches[1..] {
            let other = region.costs(patch, self.params.truncation);
            for (a, b) in map.costs.data_mut().iter_mut().zip(other.costs.data()) {
                *a = a.min(*b);
            }
        }
        map.costs.data_mut().iter_mut().for_each(|c| *c /= self.params.truncation);
        map
    }

    /// The local minimum near a place: small windows follow the costs downhill until the lowest pixel is inside one.
    fn descend(&self, image: &Planes, patches: &[Patch], start: Vec2) -> Option<Candidate> {
        let mut best = self.search(image, patches, start, 2.0).minima(1, 0.0).first().copied()?;
        let mut middle = start;
        for _ in 0..DESCENT {
            let moved = (best.at - middle).abs();
            if moved.max_element() < 1.5 {
                break;
            }
            middle = best.at;
            let next = self.search(image, patches, middle, 2.0).minima(1, 0.0).first().copied()?;
            if next.cost >= best.cost {
                break;
            }
            best = next;
        }
        Some(best)
    }

    /// The least cost of a look-alike around a vertex on its own key frame.
    fn distinctiveness_of(&self, key: &KeyPatch, image: &MatchImage, at: Vec2) -> f32 {
        let Some(patches) = self.turned(&[key], key.direction, 1) else { return 0.0 };
        let map = self.search(&image.half, &patches, at * 0.5, self.params.side * 0.5);
        let own = self.params.side * 0.25;
        let mut least = f32::INFINITY;
        for y in 0..map.costs.height() {
            for x in 0..map.costs.width() {
                if map.place(x, y).distance(at * 0.5) * 2.0 >= own {
                    least = least.min(map.costs.get(x, y));
                }
            }
        }
        if least.is_finite() { least.min(1.0) } else { 0.0 }
    }
}

impl Surroundings {
    /// What patches of `side` pixels around `at` see; pixels outside the image weigh nothing.
    pub(super) fn new(image: &Planes, at: Vec2, side: f32, weight: impl Fn(Vec2) -> f32) -> Self {
        let reach = (0.75 * side).ceil() as isize + 2;
        let origin = (at.x.floor() as isize - reach, at.y.floor() as isize - reach);
        let size = 2 * reach as usize + 1;
        let corner = vec2(origin.0 as f32, origin.1 as f32);
        let place = |i: usize| corner + vec2((i % size) as f32 + 0.5, (i / size) as f32 + 0.5);
        let inside = |p: Vec2| p.x > 0.0 && p.y > 0.0 && p.x < image.width() as f32 && p.y < image.height() as f32;
        let weights = (0..size * size).map(place).map(|p| if inside(p) { weight(p) } else { 0.0 }).collect();
        Self {
            colours: image.crop(origin, size, size),
            weights: Grid::from_vec(size, size, weights),
            centre: at - corner,
        }
    }

    /// The patch around the place with what points along x turned to `turn`; `sigma` in pixels, infinite for none.
    pub(super) fn patch(&self, side: usize, turn: Vec2, sigma: f32) -> Patch {
        let unturn = vec2(turn.x, -turn.y);
        Patch::from_fn(side, |offset| {
            let near = (-offset.length_squared() / (2.0 * sigma * sigma)).exp();
            let p = self.centre + unturn.rotate(offset);
            (self.colours.at(p), near * sample::bilinear(&self.weights, p))
        })
    }
}

/// For each vertex its neighbours on the limb that it hangs from; at a root, on the limb that starts there.
fn axes(skeleton: &Skeleton) -> Vec<Axis> {
    let mut axes: Vec<Axis> = (0..skeleton.len()).map(|v| Axis { from: v, to: v }).collect();
    let mut hung = vec![false; skeleton.len()];
    for limb in &skeleton.limbs {
        let chain = &limb.vertices;
        for (i, &v) in chain.iter().enumerate() {
            let (before, after) = (chain[i.saturating_sub(1)], chain[(i + 1).min(chain.len() - 1)]);
            let hangs = skeleton.parent[v].is_some_and(|p| p == before || p == after);
            if (hangs && !hung[v]) || axes[v].from == axes[v].to {
                axes[v] = Axis { from: before, to: after };
                hung[v] = hangs;
            }
        }
    }
    axes
}

fn polyline_distance(points: &[Vec2], p: Vec2) -> f32 {
    let to_segment = |pair: &[Vec2]| {
        let along = pair[1] - pair[0];
        let share = ((p - pair[0]).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        p.distance_squared(pair[0] + along * share)
    };
    points.windows(2).map(to_segment).fold(f32::INFINITY, f32::min).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::stage_set::{Bar, scene};
    use super::*;
    use crate::rig::{KeyFrame, Limb, Rig, Stroke};

    const DRAWN: Bar = Bar { from: vec2(60.0, 50.0), angle: 0.3, length: 90.0, half_width: 9.0 };

    fn learned(params: TemplateParams) -> (Skeleton, KeyTemplates) {
        let stroke = Stroke { limb: 0, points: vec![DRAWN.at(0.0), DRAWN.at(1.0)], facing: None };
        let rig = Rig {
            size: (220, 160),
            limbs: vec![Limb { label: "leg".into(), side: None }],
            keyframes: vec![KeyFrame { frame: 0, strokes: vec![stroke], ..KeyFrame::default() }],
        };
        let skeleton = Skeleton::new(&rig, 15.0);
        let places: Vec<Option<Vec2>> = skeleton.drawn(&rig, 0, 0).expect("drawn").into_iter().map(Some).collect();
        let mut templates = KeyTemplates::new(&skeleton, params);
        templates.add_key(0, &MatchImage::new(&scene((220, 160), &[DRAWN], vec2(0.0, 0.0))), &skeleton, &places);
        (skeleton, templates)
    }

    #[test]
    fn a_limb_that_moved_and_turned_over_another_ground_is_found_between_pixels() {
        let (skeleton, templates) = learned(TemplateParams::default());
        let moved = Bar { from: vec2(71.3, 62.6), angle: 0.75, ..DRAWN };
        let image = MatchImage::new(&scene((220, 160), &[moved], vec2(37.0, 11.0)));
        let n = skeleton.len();
        for v in 1..n - 1 {
            let truth = moved.at(v as f32 / (n - 1) as f32);
            let found = templates.detect(9, &image, v, truth + vec2(7.0, -6.0), 14.0, Vec2::from_angle(0.75));
            let best = found.candidates[0];
            assert!(best.at.distance(truth) < 0.7, "vertex {v}: {} from {truth}", best.at);
            assert!(found.margin > 0.1, "vertex {v}: {}", found.margin);
            let there = templates.cost(9, &image, v, truth, Vec2::from_angle(0.75)).expect("drawn");
            let aside = templates.cost(9, &image, v, truth + vec2(5.0, 5.0), Vec2::from_angle(0.75)).expect("drawn");
            assert!(there < 0.1 && aside > 3.0 * there, "{there} {aside}");
            assert!(templates.distinctiveness(v) > 0.05);
        }
    }

    #[test]
    fn half_size_first_finds_what_full_size_finds() {
        let (skeleton, templates) = learned(TemplateParams::default());
        let image = MatchImage::new(&scene((220, 160), &[Bar { from: vec2(64.0, 57.0), ..DRAWN }], vec2(5.0, 0.0)));
        for v in 1..skeleton.len() - 1 {
            let centre = DRAWN.at(v as f32 / (skeleton.len() - 1) as f32);
            let quick = templates.detect(3, &image, v, centre, 16.0, Vec2::from_angle(0.3)).candidates[0];
            let keys = templates.around(v, 3);
            let patches = templates.turned(&keys, Vec2::from_angle(0.3), 0).expect("drawn");
            let exact = templates.search(&image.full, &patches, centre, 16.0).minima(1, 4.0)[0];
            assert!(quick.at.distance(exact.at) < 1e-3, "vertex {v}: {quick:?} {exact:?}");
        }
    }

    #[test]
    fn windows_outside_the_image_and_undrawn_vertices_find_nothing() {
        let (skeleton, templates) = learned(TemplateParams::default());
        let image = MatchImage::new(&scene((220, 160), &[DRAWN], Vec2::ZERO));
        assert!(templates.detect(0, &image, 1, vec2(-500.0, 30.0), 10.0, Vec2::X).candidates.is_empty());
        assert!(templates.detect(0, &image, 1, Vec2::NAN, 10.0, Vec2::X).candidates.is_empty());
        let blank = KeyTemplates::new(&skeleton, TemplateParams::default());
        assert!(blank.detect(0, &image, 1, vec2(50.0, 50.0), 10.0, Vec2::X).candidates.is_empty());
        assert!(blank.cost(0, &image, 1, vec2(50.0, 50.0), Vec2::X).is_none());
    }
}
