//! The character cut into parts, one a bone, and how well a part fits a place of a picture.
//!
//! On the frame where all joints are marked, regions grow from all bones at once (geodesic distance that outlines
//! lengthen), so that every pixel of the character belongs to one bone, or to what is beyond a bone's free end (a foot,
//! a hand, the top of a head), which is a part of its own and gets a joint at its far end that nobody marked. A part is
//! laid along its bone anywhere: turned with it, stretched along it. That is what a joint's colour template becomes when
//! it turns with the limb, and grows to the whole limb.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec2;

use super::params::JointParams;
use super::scene::{Scene, View};
use super::tree::{Bone, Tree};

/// Samples of one part, at most, in the fine picture and in the coarse one.
const SAMPLES: [usize; 2] = [100, 48];
/// Working pixels of a sample's neighbourhood in either.
pub(super) const CELL: f32 = 2.0;
/// How much farther a step of 10 Lab units (byte units) makes a cell.
const OUTLINE: f32 = 1.0;
/// Places just outside a part: up to so many cells away.
const RING: isize = 3;
/// Bones shorter than this (working pixels) have no direction of their own.
const SHORT: f32 = 4.0;
/// Area (working pixels) of a part that counts half.
const SMALL: f32 = 150.0;
/// What is beyond a free end is a part from this area and this reach on.
const TIP: (usize, f32) = (12, 4.0);
/// How far behind the others a limb starts to grow where it hangs on a branching joint, as a share of its length.
const INSIDE: f32 = 0.5;
/// Cost of a place beyond the picture's border: nearly that of a place where the character is not.
const BEYOND: f32 = 0.8;
/// Where it is not known what is the character, a part reaches so far: as a share of its bone, and in cells.
const REACH: (f32, f32, f32) = (0.15, 3.0, 14.0);

/// A place of a part: along and across its bone, from the bone's start, in working pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    at: Vec2,
    colour: [u8; 3],
    /// Nothing of the part, nor of what is around it, is there.
    outside: bool,
}

/// What a bone carries.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// From its first joint to its second where it was marked.
    pub(super) rest: Vec2,
    /// For the fine picture and for the coarse one.
    samples: [Vec<Sample>; 2],
    inside: [f32; 2],
    /// Half the distance between samples, in working pixels.
    pub(super) spacing: f32,
    /// Working pixels.
    pub(super) area: f32,
    /// How much it says, over 0..=1.
    pub(super) weight: f32,
}

/// A picture as parts are judged on it.
#[derive(Clone, Copy)]
pub(super) struct Look<'a> {
    pub(super) view: &'a View,
    /// 0 for the fine picture, 1 for the coarse one.
    pub(super) level: usize,
    /// For every cell the limbs that are seen there, as bits; and those that do not matter.
    pub(super) claims: Option<(&'a Claims, u64)>,
    pub(super) params: &'a JointParams,
}

/// Which limbs are seen where on one frame.
#[derive(Clone, Debug)]
pub(super) struct Claims {
    width: usize,
    cells: Vec<u64>,
}

impl Claims {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let (w, h) = (width.div_ceil(CELL as usize), height.div_ceil(CELL as usize));
        Self { width: w, cells: vec![0; w * h] }
    }

    #[inline]
    fn at(&self, p: Vec2) -> u64 {
        let (x, y) = ((p.x / CELL) as usize, (p.y / CELL) as usize);
        if x < self.width { self.cells.get(y * self.width + x).copied().unwrap_or(0) } else { 0 }
    }

    /// The share of the places around `at` where others than `own` are seen, and they are not.
    pub(super) fn covered(&self, at: Vec2, radius: f32, own: u64) -> f32 {
        let steps = (radius / CELL).ceil().max(1.0) as i32;
        let square = (-steps..=steps).flat_map(|y| (-steps..=steps).map(move |x| Vec2::new(x as f32, y as f32) * CELL));
        let (mut others, mut count) = (0, 0);
        for by in square.filter(|by| by.length() <= radius) {
            let seen = self.at((at + by).max(Vec2::ZERO));
            others += usize::from(seen & !own != 0 && seen & own == 0);
            count += 1;
        }
        others as f32 / count.max(1) as f32
    }

    /// Takes a limb away.
    pub(super) fn remove(&mut self, bit: u64) {
        self.cells.iter_mut().for_each(|c| *c &= !bit);
    }

    fn put(&mut self, p: Vec2, reach: f32, bit: u64) {
        let at = |v: f32| (v / CELL).max(0.0) as usize;
        for y in at(p.y - reach)..=at(p.y + reach) {
            for x in at(p.x - reach)..=at(p.x + reach).min(self.width - 1) {
                if let Some(cell) = self.cells.get_mut(y * self.width + x) {
                    *cell |= bit;
                }
            }
        }
    }
}

/// How a part lies: its axes.
struct Axes {
    start: Vec2,
    along: Vec2,
    across: Vec2,
    length: f32,
    stretch: f32,
}

impl Axes {
    #[inline]
    fn new(rest: Vec2, a: Vec2, b: Vec2) -> Self {
        let length = rest.length();
        let now = (b - a).length();
        if length < SHORT || now < 1e-3 {
            return Self { start: a, along: Vec2::X, across: Vec2::Y, length: 0.0, stretch: 1.0 };
        }
        let along = (b - a) / now;
        Self { start: a, along, across: along.perp(), length, stretch: (now / length).clamp(0.5, 2.0) }
    }

    /// Where a place of the part is. Only between the joints is it stretched.
    #[inline]
    fn place(&self, at: Vec2) -> Vec2 {
        let grown = at.x.clamp(0.0, self.length) * (self.stretch - 1.0);
        self.start + self.along * (at.x + grown) + self.across * at.y
    }
}

impl Part {
    /// What a bone from `a` to `b` on `look` costs, from 0 to about 1.
    #[inline]
    pub(super) fn cost(&self, look: &Look<'_>, a: Vec2, b: Vec2) -> f32 {
        let axes = Axes::new(self.rest, a, b);
        let shrink = if look.level == 0 { 1.0 } else { 0.5 };
        let sum: f32 = self.samples[look.level].iter().map(|s| sample_cost(s, look, axes.place(s.at), shrink)).sum();
        sum / self.inside[look.level]
    }

    /// What is seen of it, near one of its joints (within `reach`) or in all: how well it matches there, over 0..=1,
    /// and how many places there are.
    pub(super) fn seen(&self, look: &Look<'_>, ends: (Vec2, Vec2), near: Option<(Vec2, f32)>) -> (f32, usize) {
        let axes = Axes::new(self.rest, ends.0, ends.1);
        let inside = self.samples[0].iter().filter(|s| !s.outside).map(|s| (s, axes.place(s.at)));
        let close = inside.filter(|(_, p)| near.is_none_or(|(q, reach)| q.distance_squared(*p) < reach * reach));
        let (mut sum, mut count) = (0.0, 0);
        for (s, p) in close {
            sum += match look.view.at(p) {
                Some(pixel) if pixel[3] >= 128 => 1.0 - mismatch(s.colour, pixel, look.params),
                _ => 0.0,
            };
            count += 1;
        }
        (sum / count.max(1) as f32, count)
    }

    /// Claims the places where the part is seen.
    pub(super) fn claim(&self, look: &Look<'_>, claims: &mut Claims, bit: u64, a: Vec2, b: Vec2) {
        let axes = Axes::new(self.rest, a, b);
        for s in self.samples[0].iter().filter(|s| !s.outside) {
            let p = axes.place(s.at);
            if let Some(pixel) = look.view.at(p)
                && pixel[3] >= 128
                && mismatch(s.colour, pixel, look.params) < 0.4
            {
                claims.put(p, self.spacing, bit);
            }
        }
    }
}

#[inline]
fn mismatch(colour: [u8; 3], pixel: [u8; 4], params: &JointParams) -> f32 {
    let [dl, da, db] = [0, 1, 2].map(|c| f32::from(colour[c]) - f32::from(pixel[c]));
    let d = 0.7 * dl * dl + da * da + db * db;
    d / (d + params.colour * params.colour)
}

#[inline]
fn sample_cost(s: &Sample, look: &Look<'_>, p: Vec2, shrink: f32) -> f32 {
    let Some(pixel) = look.view.at(p * shrink) else { return if s.outside { 0.0 } else { BEYOND } };
    let shown = f32::from(pixel[3]) * (1.0 / 255.0);
    let claimed = look.claims.is_some_and(|(claims, own)| claims.at(p) & !own != 0);
    if s.outside {
        return if claimed { 0.0 } else { look.params.outside * shown };
    }
    let wrong = mismatch(s.colour, pixel, look.params);
    if claimed && look.level == 1 {
        // A search is for where a part can be seen.
        return 1.0 - shown + shown * (look.params.claimed + 0.9 * wrong);
    }
    if claimed && pixel[3] >= 128 {
        return look.params.claimed + wrong * (look.params.hidden - look.params.claimed);
    }
    1.0 - shown + shown * 0.9 * wrong
}

/// Cuts the character into parts on the frame where all is marked; `places` are its joints there in working pixels.
/// Adds to the tree, and to the places, what is beyond free ends.
pub(super) fn cut(scene: &Scene, frame: usize, radii: &[f32], tree: &mut Tree, places: &mut Vec<Vec2>) -> Vec<Part> {
    let (Some(fine), Some(coarse)) = (&scene.fine[frame], &scene.coarse[frame]) else { return Vec::new() };
    let mut regions = grow(scene.cut_out, coarse, tree, places, radii);
    for joint in 0..places.len() {
        let bones: Vec<usize> = (0..tree.bones.len()).filter(|&b| tree.bones[b].joins(joint)).collect();
        let tip = match bones[..] {
            [] => {
                // A joint without bones is a disc.
                let reach = radii[joint].max(3.0);
                Some((disc(coarse, places[joint], reach), Vec2::new(0.0, reach)))
            }
            [bone] => {
                let (from, to) = (places[tree.bones[bone].other(joint)], places[joint]);
                let direction = (to - from).normalize_or_zero();
                let beyond = |&(x, y): &(usize, usize)| (centre(x, y) - to).dot(direction) > 0.0;
                let (tip, own): (Vec<_>, Vec<_>) = regions[bone].iter().copied().partition(beyond);
                let middle = tip.iter().map(|&(x, y)| centre(x, y)).sum::<Vec2>() / tip.len().max(1) as f32;
                let reach = 2.0 * (middle - to);
                let is_part = tip.len() >= TIP.0 && reach.length() >= TIP.1 && scene.cut_out;
                is_part.then(|| {
                    regions[bone] = own;
                    (tip, reach)
                })
            }
            _ => None,
        };
        if let Some((region, reach)) = tip {
            tree.bones.push(Bone { joints: [joint, places.len()], tip: true });
            places.push(places[joint] + reach);
            regions.push(region);
        }
    }
    let bones = tree.bones.iter().zip(&regions);
    bones
        .map(|(bone, region)| Part::new(scene, fine, coarse, bone.joints.map(|j| places[j]), region, bone.tip))
        .collect()
}

fn centre(x: usize, y: usize) -> Vec2 {
    Vec2::new(x as f32 + 0.5, y as f32 + 0.5) * CELL
}

fn shown(view: &View, x: isize, y: isize) -> f32 {
    view.at(Vec2::new(x as f32 + 0.5, y as f32 + 0.5)).map_or(0.0, |p| f32::from(p[3]))
}

fn disc(coarse: &View, at: Vec2, reach: f32) -> Vec<(usize, usize)> {
    let all = (0..coarse.height).flat_map(|y| (0..coarse.width).map(move |x| (x, y)));
    all.filter(|&(x, y)| centre(x, y).distance(at) <= reach).collect()
}

/// The cells of every bone.
fn grow(cut_out: bool, view: &View, tree: &Tree, places: &[Vec2], radii: &[f32]) -> Vec<Vec<(usize, usize)>> {
    let (w, h) = (view.width, view.height);
    let mut owner = vec![usize::MAX; w * h];
    let mut best = vec![f32::INFINITY; w * h];
    let mut queue = BinaryHeap::new();
    // Non-negative floats order as their bits do.
    let push = |queue: &mut BinaryHeap<_>, i: usize, d: f32, bone: usize| queue.push(Reverse((d.to_bits(), i, bone)));
    let mut reaches = Vec::with_capacity(tree.bones.len());
    let degree = |joint: usize| tree.bones.iter().filter(|b| b.joins(joint)).count();
    for (b, bone) in tree.bones.iter().enumerate() {
        let [from, to] = bone.joints.map(|j| places[j]);
        let steps = (from.distance(to) / CELL).ceil().max(1.0);
        let limb = bone.joints.map(|j| degree(j) > 2 && degree(bone.other(j)) <= 2);
        for s in 0..=steps as usize {
            let p = from.lerp(to, s as f32 / steps) / CELL;
            if p.x >= 0.0 && p.y >= 0.0 && p.x < w as f32 && p.y < h as f32 {
                // A limb that hangs on a joint where others do begins inside of what they carry.
                let along = s as f32 / steps;
                let inside = if limb[0] {
                    1.0 - along
                } else if limb[1] {
                    along
                } else {
                    0.0
                };
                push(&mut queue, p.y as usize * w + p.x as usize, INSIDE * inside * steps, b);
            }
        }
        let rect = bone.joints.map(|j| radii[j]);
        let least = REACH.1.max(0.5 * (rect[0] + rect[1]) / CELL);
        let reach = (REACH.0 * from.distance(to)).clamp(least, REACH.2.max(least));
        reaches.push(if cut_out { f32::INFINITY } else { reach });
    }
    while let Some(Reverse((bits, i, bone))) = queue.pop() {
        let d = f32::from_bits(bits);
        if owner[i] != usize::MAX {
            continue;
        }
        owner[i] = bone;
        best[i] = d;
        let (x, y) = (i % w, i / w);
        let Some(here) = view.at(Vec2::new(x as f32 + 0.5, y as f32 + 0.5)) else { continue };
        for (dx, dy) in [(1isize, 0isize), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)] {
            let (nx, ny) = (x as isize + dx, y as isize + dy);
            if nx < 0 || ny < 0 || nx >= w as isize || ny >= h as isize || shown(view, nx, ny) < 128.0 {
                continue;
            }
            let n = ny as usize * w + nx as usize;
            let there = view.at(Vec2::new(nx as f32 + 0.5, ny as f32 + 0.5)).unwrap_or(here);
            let step: f32 = (0..3).map(|c| (f32::from(here[c]) - f32::from(there[c])).powi(2)).sum::<f32>().sqrt();
            let far = d + ((dx * dx + dy * dy) as f32).sqrt() + OUTLINE * step * 0.1;
            if owner[n] == usize::MAX && far < best[n] && far <= reaches[bone] {
                best[n] = far;
                push(&mut queue, n, far, bone);
            }
        }
    }
    let mut regions = vec![Vec::new(); tree.bones.len()];
    for (i, &bone) in owner.iter().enumerate() {
        if bone != usize::MAX && shown(view, (i % w) as isize, (i / w) as isize) >= 128.0 {
            regions[bone].push((i % w, i / w));
        }
    }
    regions
}

impl Part {
    fn new(scene: &Scene, fine: &View, coarse: &View, ends: [Vec2; 2], region: &[(usize, usize)], tip: bool) -> Self {
        let rest = ends[1] - ends[0];
        let axes = Axes::new(rest, ends[0], ends[1]);
        let local = |p: Vec2| Vec2::new((p - ends[0]).dot(axes.along), (p - ends[0]).dot(axes.across));
        let mut ring: Vec<(usize, usize)> = Vec::new();
        if scene.cut_out {
            for &(x, y) in region {
                for (dx, dy) in [(RING, 0), (-RING, 0), (0, RING), (0, -RING)] {
                    let (nx, ny) = (x as isize + dx, y as isize + dy);
                    if nx >= 0
                        && ny >= 0
                        && nx < coarse.width as isize
                        && ny < coarse.height as isize
                        && shown(coarse, nx, ny) < 64.0
                    {
                        ring.push((nx as usize, ny as usize));
                    }
                }
            }
            ring.sort_unstable();
            ring.dedup();
        }
        let area = region.len() as f32 * CELL * CELL;
        let mut spacing = CELL;
        let samples = [0, 1].map(|level| {
            let (view, shrink) = if level == 0 { (fine, 1.0) } else { (coarse, 0.5) };
            let step = ((region.len() as f32 / SAMPLES[level] as f32).sqrt().ceil() as usize).max(1);
            if level == 0 {
                spacing = 0.5 * step as f32 * CELL;
            }
            let inside = region.iter().filter(|(x, y)| x % step == 0 && y % step == 0);
            let every = (2 * ring.len() / SAMPLES[level]).max(1);
            let outside = ring.iter().step_by(every);
            let all = inside.map(|c| (c, false)).chain(outside.map(|c| (c, true)));
            all.filter_map(|(&(x, y), outside)| {
                let p = centre(x, y);
                let pixel = view.at(p * shrink)?;
                Some(Sample { at: local(p), colour: [pixel[0], pixel[1], pixel[2]], outside })
            })
            .collect::<Vec<_>>()
        });
        let inside = samples.each_ref().map(|s| s.iter().filter(|s| !s.outside).count().max(6) as f32);
        let weight = (area / (area + SMALL)).sqrt() * if tip { 0.7 } else { 1.0 };
        Self { rest, samples, inside, spacing, area, weight }
    }
}
