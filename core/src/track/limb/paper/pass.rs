//! One direction of Reinert 2016, section 3.5: every frame from the one before it, as a chain of exact tree optima.
//!
//! A pass visits frames in its direction from a key frame on. Strokes that a visited frame draws are taken from the
//! drawing; all other vertices choose between seen and hidden candidates. A vertex takes part from its first key frame on.

use glam::{Vec2, vec2};
use image::RgbImage;
use rayon::prelude::*;

use super::super::candidates::Candidate;
use super::super::params::PaperParams;
use super::super::templates::{KeyTemplates, MatchImage};
use super::super::tree_dp::tree_optimum;
use super::appearance::{Matcher, View, Views};
use crate::error::Result;
use crate::job::Stage;
use crate::raster::Grid;
use crate::rig::Skeleton;
use crate::track::flow::{FlowField, Pyramid};

/// A place other than the chosen one is a rival, not a neighbour, from this far on (pixels of a 512 x 512 image).
const RIVAL: f32 = 8.0;
/// A gap to the best rival of this much cost makes a choice `1 - 1/e` sure.
const SURE: f32 = 10.0;

/// What stays the same over all frames. Lengths in working pixels.
#[derive(Debug)]
pub(super) struct Setting<'a> {
    pub(super) skeleton: &'a Skeleton,
    pub(super) params: &'a PaperParams,
    /// Working pixels for one pixel of the paper's 512 x 512 image.
    pub(super) scale: f32,
    pub(super) matcher: Matcher,
    pub(super) templates: Option<KeyTemplates>,
    /// The limbs of every vertex.
    pub(super) limbs: Vec<Vec<usize>>,
    /// The parent and the children of every vertex.
    pub(super) neighbours: Vec<Vec<usize>>,
    /// Whether a vertex belongs to far limbs only.
    pub(super) far: Vec<bool>,
}

/// A vertex on one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) at: Vec2,
    pub(super) visible: bool,
    /// How clearly its place beat all others, in 0..=1.
    pub(super) sure: f32,
}

/// A vertex while it is followed.
#[derive(Clone, Debug)]
struct Followed {
    placed: Placed,
    views: Views,
    /// Matching cost of the best seen candidate on the last frame that had any.
    best: Option<f32>,
}

/// A candidate of either kind.
#[derive(Clone, Copy, Debug)]
struct Choice {
    at: Vec2,
    cost: f32,
    visible: bool,
}

/// One direction in progress.
#[derive(Debug)]
pub(super) struct Pass<'a> {
    setting: &'a Setting<'a>,
    followed: Vec<Option<Followed>>,
    /// Distance of each vertex to its parent when last drawn.
    rest: Vec<Option<f32>>,
    brightness: Option<Pyramid>,
}

impl<'a> Pass<'a> {
    pub(super) fn new(setting: &'a Setting<'a>) -> Self {
        let n = setting.skeleton.len();
        Self { setting, followed: vec![None; n], rest: vec![None; n], brightness: None }
    }

    /// Places all vertices on the next frame. `drawn` has the places that are known there.
    pub(super) fn step(
        &mut self,
        frame: usize,
        image: &RgbImage,
        drawn: &[Option<Vec2>],
        stage: Stage<'_>,
    ) -> Result<Vec<Option<Placed>>> {
        let setting = self.setting;
        let view = View::new(image, setting.params);
        let anchors = setting.templates.as_ref().map(|_| MatchImage::new(image));
        stage.at(0.0)?;
        let centres = self.predicted(image);
        stage.at(0.0)?;
        let forced = self.forced_hidden();
        let members: Vec<usize> = (setting.skeleton.order.iter().copied())
            .filter(|&v| drawn[v].is_some() || self.followed[v].is_some())
            .collect();
        let directions = match &setting.templates {
            Some(t) => t.directions(|v| self.followed[v].as_ref().map(|f| f.placed.at)),
            None => Vec::new(),
        };
        let choices: Vec<Vec<Choice>> = members
            .par_iter()
            .map(|&v| {
                stage.at(0.0)?;
                Ok(match (drawn[v], &self.followed[v]) {
                    (Some(at), _) => vec![Choice { at, cost: 0.0, visible: true }],
                    (None, Some(followed)) => {
                        let anchor = anchors.as_ref().zip(setting.templates.as_ref());
                        let anchor =
                            anchor.map(|(image, t)| Anchor { frame, image, templates: t, direction: directions[v] });
                        setting.choices(v, followed, &view, anchor.as_ref(), centres[v], forced[v])
                    }
                    (None, None) => Vec::new(),
                })
            })
            .collect::<Result<_>>()?;
        stage.at(0.0)?;
        self.learn_lengths(drawn);
        let placed = self.optimum(&members, &choices, &centres);
        self.remember(&view, &members, &choices, &placed, drawn);
        Ok(placed)
    }

    /// Where the window of every vertex lies: where it was, or where dense flow takes it.
    fn predicted(&mut self, image: &RgbImage) -> Vec<Vec2> {
        let skeleton = self.setting.skeleton;
        let was = |v: usize| self.followed[v].as_ref().map_or(Vec2::ZERO, |f| f.placed.at);
        let mut centres: Vec<Vec2> = (0..self.followed.len()).map(was).collect();
        if self.setting.params.flow_window.is_none() {
            return centres;
        }
        let now = Pyramid::new(&brightness(image));
        if let Some(before) = &self.brightness {
            let flow = FlowField::between(before, &now);
            let size = vec2(image.width() as f32, image.height() as f32);
            // What hides a vertex moves by itself: a hidden one goes with the nearest vertex that is seen.
            let seen = |v: usize| {
                let at = self.followed[v].as_ref().filter(|f| f.placed.visible)?.placed.at;
                (at.cmpge(Vec2::ZERO).all() && at.cmple(size).all()).then(|| flow.at(at))
            };
            let mut motion: Vec<Option<Vec2>> = (0..centres.len()).map(seen).collect();
            let mut front: Vec<usize> = skeleton.order.iter().copied().filter(|&v| motion[v].is_some()).collect();
            while !front.is_empty() {
                let mut next = Vec::new();
                for v in front {
                    for &n in &self.setting.neighbours[v] {
                        if motion[n].is_none() {
                            motion[n] = motion[v];
                            next.push(n);
                        }
                    }
                }
                front = next;
            }
            for (centre, motion) in centres.iter_mut().zip(motion) {
                *centre += motion.unwrap_or(Vec2::ZERO);
            }
        }
        self.brightness = Some(now);
        centres
    }

    /// Far limbs' vertices that another stroke comes too near to: they are presumably behind it.
    fn forced_hidden(&self) -> Vec<bool> {
        let setting = self.setting;
        let near = (setting.params.crowding * setting.scale).powi(2);
        let crowded = |v: usize, at: Vec2| {
            (0..self.followed.len()).any(|other| {
                let apart = setting.limbs[other].iter().all(|l| !setting.limbs[v].contains(l));
                apart && self.followed[other].as_ref().is_some_and(|f| f.placed.at.distance_squared(at) < near)
            })
        };
        (0..self.followed.len())
            .map(|v| setting.far[v] && self.followed[v].as_ref().is_some_and(|f| crowded(v, f.placed.at)))
            .collect()
    }

    fn learn_lengths(&mut self, drawn: &[Option<Vec2>]) {
        for (v, parent) in self.setting.skeleton.parent.iter().enumerate() {
            let Some(p) = *parent else { continue };
            if let (Some(a), Some(b)) = (drawn[v], drawn[p]) {
                self.rest[v] = Some(a.distance(b));
            }
        }
    }

    /// The cheapest choice for all vertices that take part.
    fn optimum(&self, members: &[usize], choices: &[Vec<Choice>], centres: &[Vec2]) -> Vec<Option<Placed>> {
        let setting = self.setting;
        let params = setting.params;
        let mut index = vec![usize::MAX; setting.skeleton.len()];
        for (i, &v) in members.iter().enumerate() {
            index[v] = i;
        }
        let parent: Vec<Option<usize>> = members
            .iter()
            .map(|&v| setting.skeleton.parent[v].map(|p| index[p]).filter(|&i| i != usize::MAX))
            .collect();
        let order: Vec<usize> = (0..members.len()).collect();
        let own: Vec<Vec<f32>> = choices.iter().map(|c| c.iter().map(|c| c.cost).collect()).collect();
        let bound = params.edge_truncation;
        let pair = |i: usize, p: usize, c: usize| {
            let Some(above) = parent[i] else { return 0.0 };
            let along = (choices[i][c].at - choices[above][p].at) / setting.scale;
            let distance = self.rest[members[i]].map_or(0.0, |rest| (along.length() - rest / setting.scale).abs());
            let both = self.followed[members[i]].is_some() && self.followed[members[above]].is_some();
            let expected = (centres[members[i]] - centres[members[above]]) / setting.scale;
            let direction = if both { along.distance(expected) } else { 0.0 };
            params.smoothness * (distance.min(bound) + direction.min(bound))
        };
        let mut placed = vec![None; setting.skeleton.len()];
        let Some(solved) = tree_optimum(&order, &parent, &own, pair) else { return placed };
        for (i, &v) in members.iter().enumerate() {
            let taken = choices[i][solved.chosen[i]];
            let rival = RIVAL * setting.scale;
            let gap = solved.gap(i, |c| choices[i][c].at.distance(taken.at) > rival);
            placed[v] = Some(Placed { at: taken.at, visible: taken.visible, sure: 1.0 - (-gap / SURE).exp() });
        }
        placed
    }

    /// Takes over the new places, and new views where vertices are seen.
    fn remember(
        &mut self,
        view: &View,
        members: &[usize],
        choices: &[Vec<Choice>],
        placed: &[Option<Placed>],
        drawn: &[Option<Vec2>],
    ) {
        let matcher = &self.setting.matcher;
        for (&v, choices) in members.iter().zip(choices) {
            let Some(now) = placed[v] else { continue };
            let fresh = || Followed { placed: now, views: Views::default(), best: None };
            let followed = self.followed[v].get_or_insert_with(fresh);
            followed.placed = now;
            if drawn[v].is_some() {
                *followed = fresh();
            }
            if now.visible {
                followed.views.remember(view, now.at, matcher);
            }
            let seen = choices.iter().filter(|c| c.visible && drawn[v].is_none());
            followed.best = seen.map(|c| c.cost).min_by(f32::total_cmp).or(followed.best);
        }
    }
}

/// Key-frame templates as a second opinion on one vertex.
#[derive(Debug)]
struct Anchor<'a> {
    frame: usize,
    image: &'a MatchImage,
    templates: &'a KeyTemplates,
    direction: Vec2,
}

impl Setting<'_> {
    /// Seen and hidden candidates of a vertex.
    fn choices(
        &self,
        v: usize,
        followed: &Followed,
        view: &View,
        anchor: Option<&Anchor<'_>>,
        centre: Vec2,
        forced: bool,
    ) -> Vec<Choice> {
        let window = self.params.flow_window.unwrap_or(self.params.window) * self.scale;
        let mut seen = Vec::new();
        if !forced {
            seen = followed.views.search(view, &self.matcher, centre, window);
            if let Some(anchor) = anchor {
                self.anchor(v, &mut seen, followed, view, anchor, centre, window);
            }
        }
        let least = seen.iter().map(|c| c.cost).min_by(f32::total_cmp);
        // On the first frame after a key frame nothing precedes; with nothing to be seen, hiding is free.
        let hidden = self.params.occlusion_cost * followed.best.or(least).unwrap_or(0.0);
        let mut choices: Vec<Choice> = seen.iter().map(|c| Choice { at: c.at, cost: c.cost, visible: true }).collect();
        let cells = self.params.occluded_candidates.max(1);
        let across = (cells as f32).sqrt().round() as usize;
        // Like the pixels of an even window the grid starts at its corner and holds its centre, which comes first: a limb
        // that is hidden altogether moves at no cost, and of equals the first is taken.
        let cell =
            |i: usize| vec2((i % across) as f32 - (across / 2) as f32, (i / across) as f32 - (across / 2) as f32);
        let mut grid: Vec<Vec2> = (0..across * across).map(cell).collect();
        grid.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let step = window / across as f32;
        choices.extend(grid.iter().map(|c| Choice { at: centre + *c * step, cost: hidden, visible: false }));
        choices
    }

    /// Adds what the key frames' templates find, and gives every place the blend of both opinions.
    fn anchor(
        &self,
        v: usize,
        seen: &mut Vec<Candidate>,
        followed: &Followed,
        view: &View,
        anchor: &Anchor<'_>,
        centre: Vec2,
        window: f32,
    ) {
        let found = anchor.templates.detect(anchor.frame, anchor.image, v, centre, 0.5 * window, anchor.direction);
        let share = self.params.anchored;
        // Template costs are shares of the largest difference that a pixel may have.
        let unit = self.params.colour_unit / 3.0 * anchor.templates.truncation();
        for c in seen.iter_mut() {
            let theirs = anchor.templates.cost(anchor.frame, anchor.image, v, c.at, anchor.direction);
            c.cost += share * (theirs.unwrap_or(1.0) * unit - c.cost);
        }
        let separation = self.params.separation * self.scale;
        for c in found.candidates {
            if seen.iter().all(|s| s.at.distance(c.at) >= separation) {
                let ours = followed.views.cost(view, &self.matcher, c.at);
                seen.push(Candidate { at: c.at, cost: ours + share * (c.cost * unit - ours) });
            }
        }
    }
}

/// Brightness in 0..=255 (ITU-R BT.601 weights).
fn brightness(image: &RgbImage) -> Grid<f32> {
    let value = |p: &[u8]| 0.299 * f32::from(p[0]) + 0.587 * f32::from(p[1]) + 0.114 * f32::from(p[2]);
    let data = image.as_raw().chunks_exact(3).map(value).collect();
    Grid::from_vec(image.width() as usize, image.height() as usize, data)
}
