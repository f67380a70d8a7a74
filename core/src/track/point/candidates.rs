//! Where a point may be in a frame: the places of the whole frame that look most like it where it was marked, at any of
//! a few turns, and where the flow takes it.
//!
//! Places are chosen in three steps: by the blurred colours alone, which do not change when a thing turns; by their
//! description; and then moved to where they fit best.

use glam::Vec2;

use super::footage::{Footage, Motions};
use super::looks::{LEVELS, Looks, Pixel, Rings};
use super::params::PointParams;

/// Turns that are looked for, in degrees.
const TURNS: [f32; 11] = [0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0, 80.0, -80.0];
/// Side of the squares of the quarter-size picture of which the best place each is looked at.
const SQUARE: usize = 2;

/// A place where a point may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) at: Vec2,
    /// How it is turned against where it was marked.
    pub(super) angle: f32,
    /// How unlike the marked place it looks.
    pub(super) unlike: f32,
    pub(super) looks: Looks,
    /// Where it goes in the next and comes from in the previous frame, and how far that is to be trusted.
    pub(super) motions: Option<Motions>,
}

impl Candidate {
    /// Finds out where it goes and comes from, once.
    pub(super) fn with_motions(mut self, footage: &Footage, f: usize) -> Self {
        self.motions.get_or_insert_with(|| footage.motions(self.at, f));
        self
    }
}

/// A marked place and what it looks like.
#[derive(Clone, Debug)]
pub(super) struct Sought {
    pub(super) frame: usize,
    pub(super) at: Vec2,
    turned: Vec<Looks>,
    colours: [Pixel; LEVELS],
}

impl Sought {
    pub(super) fn new(footage: &Footage, frame: usize, at: Vec2) -> Self {
        let picture = &footage.pictures[frame];
        let turned = TURNS.iter().map(|a| picture.looks(at, &Rings::new(footage.unit, a.to_radians()))).collect();
        Self { frame, at, turned, colours: std::array::from_fn(|l| picture.at(l, at)) }
    }

    /// How unlike another marked place it looks, at the turn that fits best.
    pub(super) fn unlike(&self, other: &Self) -> f32 {
        self.turned.iter().map(|t| t.unlike(&other.turned[0])).fold(f32::INFINITY, f32::min)
    }

    /// The place itself as a candidate.
    pub(super) fn marked(&self) -> Candidate {
        Candidate { at: self.at, angle: 0.0, unlike: 0.0, looks: self.turned[0], motions: None }
    }
}

fn colour_gap(a: Pixel, b: Pixel) -> u32 {
    (0..4).map(|c| u32::from(a[c].abs_diff(b[c]).min(60))).sum()
}

/// What is at `p`, against the nearest of the sought.
pub(super) fn judged(footage: &Footage, rings: &Rings, sought: &[Sought], f: usize, p: Vec2) -> Candidate {
    let looks = footage.pictures[f].looks(p, rings);
    let mut best = (f32::INFINITY, 0.0);
    for s in sought {
        for (turned, angle) in s.turned.iter().zip(TURNS) {
            let unlike = turned.unlike(&looks);
            if unlike < best.0 {
                best = (unlike, angle.to_radians());
            }
        }
    }
    Candidate { at: p, angle: best.1, unlike: best.0, looks, motions: None }
}

/// Moves a candidate downhill to where it looks most like what is sought, `reach` pixels at most.
pub(super) fn settled(
    footage: &Footage,
    rings: &Rings,
    sought: &[Sought],
    f: usize,
    start: Candidate,
    reach: f32,
) -> Candidate {
    let mut best = start;
    for step in [2.0f32, 1.0] {
        for _ in 0..6 {
            let centre = best.at;
            for (dx, dy) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
                let p = centre + step * Vec2::new(dx, dy);
                if p.distance(start.at) > reach {
                    continue;
                }
                let there = judged(footage, rings, sought, f, p);
                if there.unlike < best.unlike {
                    best = there;
                }
            }
            if best.at == centre {
                break;
            }
        }
    }
    best
}

/// The candidates of frame `f`, best first.
pub(super) fn over_the_frame(
    footage: &Footage,
    rings: &Rings,
    sought: &[Sought],
    f: usize,
    params: &PointParams,
) -> Vec<Candidate> {
    let picture = &footage.pictures[f];
    let (width, height, pixels) = picture.level(2);
    let mut squares: Vec<(u32, u16, u16)> = Vec::new();
    for y0 in (0..height).step_by(SQUARE) {
        for x0 in (0..width).step_by(SQUARE) {
            let coarse = picture.at(3, Vec2::new(4.0 * x0 as f32 + 2.0, 4.0 * y0 as f32 + 2.0));
            let mut best = (u32::MAX, 0, 0);
            for s in sought {
                let base = colour_gap(coarse, s.colours[3]);
                for y in y0..(y0 + SQUARE).min(height) {
                    for x in x0..(x0 + SQUARE).min(width) {
                        best = best.min((base + colour_gap(pixels[y * width + x], s.colours[2]), x as u16, y as u16));
                    }
                }
            }
            squares.push(best);
        }
    }
    let count = params.looked_at.min(squares.len());
    if count < squares.len() && count > 0 {
        squares.select_nth_unstable(count - 1);
        squares.truncate(count);
    }
    let mut found: Vec<Candidate> = squares
        .iter()
        .map(|&(_, x, y)| {
            let p = Vec2::new(4.0 * f32::from(x) + 2.0, 4.0 * f32::from(y) + 2.0);
            judged(footage, rings, sought, f, p)
        })
        .collect();
    found.sort_by(|a, b| a.unlike.total_cmp(&b.unlike).then(a.at.x.total_cmp(&b.at.x)).then(a.at.y.total_cmp(&b.at.y)));
    found.truncate(params.candidates + params.candidates / 2);
    let settled: Vec<Candidate> =
        found.into_iter().map(|c| settled(footage, rings, sought, f, c, 8.0 * footage.unit)).collect();
    thinned(settled, params.apart * footage.unit, params.candidates)
}

/// The best candidates, no two of them near each other.
pub(super) fn thinned(mut found: Vec<Candidate>, apart: f32, count: usize) -> Vec<Candidate> {
    found.sort_by(|a, b| a.unlike.total_cmp(&b.unlike).then(a.at.x.total_cmp(&b.at.x)).then(a.at.y.total_cmp(&b.at.y)));
    let mut kept: Vec<Candidate> = Vec::with_capacity(count);
    for c in found {
        if kept.len() == count {
            break;
        }
        if kept.iter().all(|k| k.at.distance(c.at) >= apart) {
            kept.push(c);
        }
    }
    kept
}
