//! The clip as the point tracker sees it: pictures in bytes at falling resolutions, the flow between neighbours, and what
//! the camera did. Read once, it serves every solve, and the tracker of limbs.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use glam::{Affine2, Vec2};
use image::imageops::FilterType::Triangle;
use image::{RgbImage, imageops};
use rayon::prelude::*;

use super::looks::{Levels, Rings};
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::raster::{Planes, pyramid};
use crate::track::flow::{FlowField, Pyramid};
use crate::track::limb;
use crate::track::limb::footage::LabImage;

/// Pixels of all frames together that are kept; longer clips are tracked on smaller pictures. A pixel takes 8 to 16 bytes.
const PIXEL_BUDGET: usize = 100_000_000;
/// Working pictures never get smaller than this on their long side, whatever the budget says.
const LEAST_SIDE: u32 = 320;
/// Clips with a shorter long side are enlarged to it, as far as the budget allows, twice at most: for them the steps of
/// flow and of places, a pixel or half of one, are too coarse. Larger ones are no better on bars that swing.
const ENLARGED: u32 = 400;
const MOST_ENLARGED: u32 = 2;

/// Longest side of the pictures that flow is found and whole limbs are tracked in: smaller ones lose thin legs and the
/// outlines of drawings, larger ones cost seconds; what flow leaves open, the patches of [`Footage::follow`] find.
const SMALL_SIDE: u32 = 512;
/// Places of a frame that are remembered with where they go; beyond them it is found out again.
const REMEMBERED: usize = 4096;
/// Places along the side of the patch that is followed from frame to frame, and their distance.
const PATCH: usize = 6;
const PATCH_STEP: f32 = 1.8;
/// What leaving the flow costs, a squared pixel, against differences of colour summed over channels: along an outline
/// the patch fits everywhere.
const PULL: f32 = 0.15;
/// Where the patch misses by more than this, what is there moved faster than flow can follow, and is searched for: so many
/// steps of this length either way, the places with the likest looks tried; what is found must miss so much less.
const LOST: f32 = 28.0;
const SEARCHED: isize = 11;
const SEARCH_STEP: f32 = 3.5;
const FOUND: usize = 3;
/// What a pixel away from the flow's target costs there.
const FAR: f32 = 0.15;
const BETTER: f32 = 0.5;
/// How far around a place other motions are looked for.
const AROUND: f32 = 7.0;

/// Where a place goes in the next frame and comes from in the previous one, and how far each is to be trusted.
pub(super) type Motions = [(Vec2, f32); 2];

/// Working pictures, flows and camera of a clip.
#[derive(Debug)]
pub(super) struct Footage {
    /// Working pixels for one clip pixel.
    pub(super) scale: f32,
    /// The geometric mean of the working pictures' sides over 512.
    pub(super) unit: f32,
    /// Columns and rows of the working pictures.
    pub(super) size: Vec2,
    /// Every frame.
    pub(super) pictures: Vec<Levels>,
    /// The clip again, smaller, and as the limb tracker sees it, with the flows.
    pub(super) small: Clip,
    pub(super) limbs: limb::footage::Footage,
    /// Pixels of the small pictures for a working pixel.
    shrunk: Vec2,
    rings: Rings,
    /// Where places of every frame go, by their bits.
    followed: Vec<Mutex<HashMap<[u32; 2], Motions>>>,
    /// Maps a place of every frame to where that place of the ground is in the first one.
    still: Vec<Affine2>,
}

impl Footage {
    pub(super) fn read(clip: &Clip, working_side: u32, stage: Stage<'_>) -> Result<Self> {
        let info = clip.info();
        let long = f64::from(info.width.max(info.height));
        let area = f64::from(info.width) * f64::from(info.height);
        let affordable = (PIXEL_BUDGET as f64 / info.frames.max(1) as f64 / area).sqrt() * long;
        let side = working_side.min((affordable as u32).max(LEAST_SIDE));
        let enlarged = f64::from(ENLARGED.min(working_side)).min(affordable) / long;
        let (width, height) = if enlarged > 1.0 {
            let times = enlarged.min(f64::from(MOST_ENLARGED));
            [info.width, info.height].map(|side| (times * f64::from(side)).round() as u32).into()
        } else {
            pyramid::fitted(info.width, info.height, side)
        };
        let (reading, flowing) = (stage.part(0.0, 0.4), stage.part(0.4, 1.0));
        let (columns, rows) = pyramid::fitted(width, height, SMALL_SIDE);
        let frames: Vec<((Levels, RgbImage), (LabImage, Pyramid))> = (0..info.frames)
            .into_par_iter()
            .map(|f| {
                reading.at(f as f64 / info.frames as f64)?;
                let picture = clip.frame(f)?;
                let (rgb, alpha) = if enlarged > 1.0 {
                    let alpha = picture.alpha.as_ref().map(|a| imageops::resize(a, width, height, Triangle));
                    (imageops::resize(&picture.rgb, width, height, Triangle), alpha)
                } else {
                    let alpha = picture.alpha.as_ref().map(|a| shrunk_alpha(a, width, height));
                    (pyramid::shrunk(&picture.rgb, width, height), alpha)
                };
                let small = pyramid::shrunk(&rgb, columns, rows);
                let lab = Planes::lab(&small);
                let seen = (LabImage::new(&lab), Pyramid::of(&lab));
                Ok(((Levels::new(&rgb, alpha.as_ref()), small), seen))
            })
            .collect::<Result<_>>()?;
        let (pictures, seen): (Vec<_>, Vec<_>) = frames.into_iter().unzip();
        let (pictures, small): (Vec<Levels>, Vec<RgbImage>) = pictures.into_iter().unzip();
        let (lab, pyramids): (Vec<LabImage>, Vec<Pyramid>) = seen.into_iter().unzip();
        let pairs = pyramids.len().saturating_sub(1);
        let flows: Vec<(FlowField, FlowField)> = (0..pairs)
            .into_par_iter()
            .map(|t| {
                flowing.at(t as f64 / pairs as f64)?;
                let (a, b) = (&pyramids[t], &pyramids[t + 1]);
                Ok((FlowField::between(a, b), FlowField::between(b, a)))
            })
            .collect::<Result<_>>()?;
        let limbs = limb::footage::Footage::new((columns, rows), lab, flows);
        let size = Vec2::new(width as f32, height as f32);
        let shrunk = Vec2::new(columns as f32, rows as f32) / size;
        let mut still = vec![Affine2::IDENTITY; info.frames];
        for f in 1..info.frames {
            let back = limbs.camera[f - 1].inverse();
            still[f] = still[f - 1] * Affine2::from_scale(1.0 / shrunk) * back * Affine2::from_scale(shrunk);
        }
        Ok(Self {
            scale: width as f32 / info.width as f32,
            unit: (size.x * size.y).sqrt() / 512.0,
            size,
            shrunk,
            followed: pictures.iter().map(|_| Mutex::default()).collect(),
            pictures,
            limbs,
            rings: Rings::new((size.x * size.y).sqrt() / 512.0, 0.0),
            small: Clip::from_frames(small, info.fps)?,
            still,
        })
    }

    /// How many frames there are.
    pub(super) fn frames(&self) -> usize {
        self.pictures.len()
    }

    /// Where `p` of frame `f` goes in the next frame and comes from in the previous one, and how far that is to be trusted.
    pub(super) fn motions(&self, p: Vec2, f: usize) -> Motions {
        let (known, key) = (&self.followed[f], p.to_array().map(f32::to_bits));
        // What is remembered is whole, whoever failed meanwhile.
        if let Some(motions) = known.lock().unwrap_or_else(PoisonError::into_inner).get(&key) {
            return *motions;
        }
        let follow = |to: Option<usize>| to.map_or((p, 0.0), |to| self.follow(p, f, to));
        let motions = [follow((f + 1 < self.frames()).then_some(f + 1)), follow(f.checked_sub(1))];
        let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() < REMEMBERED {
            known.insert(key, motions);
        }
        motions
    }

    /// Where `p` goes from frame `from` to its neighbour `to`, and how far that is to be trusted. At the border of a moving
    /// thing dense flow is a mix of what moves there; so of the motions around, that is taken which keeps the looks of the
    /// place best, and made exact.
    pub(super) fn follow(&self, p: Vec2, from: usize, to: usize) -> (Vec2, f32) {
        let Some((along, against)) = self.limbs.flows(from, to) else { return (p, 0.0) };
        let (before, after) = (&self.pictures[from], &self.pictures[to]);
        let (mut steps, mut patch) = ([0.0; PATCH], [[[0.0f32; 4]; PATCH]; PATCH]);
        for (i, step) in steps.iter_mut().enumerate() {
            *step = (i as f32 - 0.5 * (PATCH - 1) as f32) * (PATCH_STEP * self.unit);
        }
        let at = before.lattice(p, &steps);
        patch.iter_mut().enumerate().for_each(|(row, pixels)| *pixels = at.row(row));
        // Infinite where it is no less than `most`: few motions need to be looked at in full.
        let miss = |motion: Vec2, most: f32| -> f32 {
            let at = after.lattice(p + motion, &steps);
            let mut sums = [0.0f32; 4];
            let mean = |[a, b, c, d]: [f32; 4]| ((a + b) + (c + d)) / (PATCH * PATCH) as f32;
            for (row, pixels) in patch.iter().enumerate() {
                for (pixel, there) in pixels.iter().zip(&at.row(row)) {
                    for c in 0..4 {
                        sums[c] += (pixel[c] - there[c]).abs().min(40.0);
                    }
                }
                if mean(sums) >= most {
                    return f32::INFINITY;
                }
            }
            mean(sums)
        };
        let flow = |field: &FlowField, p: Vec2| field.at(p * self.shrunk) / self.shrunk;
        let own = flow(along, p);
        let mut best = (own, miss(own, f32::INFINITY));
        for i in 0..8 {
            let around = p + Vec2::from_angle(std::f32::consts::FRAC_PI_4 * i as f32) * (AROUND * self.unit);
            let motion = flow(along, around);
            if motion.distance_squared(own) > 0.25 {
                let cost = miss(motion, best.1) + 0.3;
                if cost < best.1 {
                    best = (motion, cost);
                }
            }
        }
        let exact = |mut best: (Vec2, f32)| {
            let start = best.0;
            for step in [1.0f32, 0.5, 0.25] {
                for _ in 0..4 {
                    let centre = best.0;
                    for (x, y) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
                        let motion = centre + step * Vec2::new(x, y);
                        let pull = PULL * motion.distance_squared(start);
                        let cost = miss(motion, best.1 - pull) + pull;
                        if cost < best.1 {
                            best = (motion, cost);
                        }
                    }
                    if best.0 == centre {
                        break;
                    }
                }
            }
            best
        };
        best = exact(best);
        let mut searched = false;
        if best.1 > LOST {
            let looks = before.looks(p, &self.rings);
            let mut found = [(f32::INFINITY, Vec2::ZERO); FOUND];
            for y in -SEARCHED..=SEARCHED {
                for x in -SEARCHED..=SEARCHED {
                    let motion = Vec2::new(x as f32, y as f32) * (SEARCH_STEP * self.unit);
                    if let Some(unlike) = after.unlike(p + motion, &self.rings, &looks, found[FOUND - 1].0) {
                        let at = found.partition_point(|f| f.0 <= unlike);
                        found[at..].rotate_right(1);
                        found[at] = (unlike, motion);
                    }
                }
            }
            for (_, motion) in found {
                let there = exact((motion, miss(motion, f32::INFINITY) + FAR * motion.distance(own)));
                if there.1 < BETTER * best.1 {
                    (best, searched) = (there, true);
                }
            }
        }
        let target = p + best.0;
        // Where the flow knew nothing, it does not know the way back.
        let back = if searched { 0.5 } else { (target + flow(against, target)).distance(p) / (2.0 * self.unit) };
        let unlike = best.1 / 12.0;
        (target, 1.0 / (1.0 + back * back) / (1.0 + unlike * unlike))
    }

    /// `p` of frame `f` on the still ground.
    #[inline]
    pub(super) fn grounded(&self, p: Vec2, f: usize) -> Vec2 {
        self.still[f].transform_point2(p)
    }

    /// The place of frame `f` that is `p` on the still ground.
    pub(super) fn seen(&self, p: Vec2, f: usize) -> Vec2 {
        self.still[f].inverse().transform_point2(p)
    }
}

fn shrunk_alpha(alpha: &image::GrayImage, width: u32, height: u32) -> image::GrayImage {
    let rgb = RgbImage::from_fn(alpha.width(), alpha.height(), |x, y| image::Rgb([alpha.get_pixel(x, y).0[0]; 3]));
    let small = pyramid::shrunk(&rgb, width, height);
    image::GrayImage::from_fn(width, height, |x, y| image::Luma([small.get_pixel(x, y).0[0]]))
}
