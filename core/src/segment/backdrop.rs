//! The scene behind the creature, as far as it stands still: the usual colour of every pixel over the frames in which
//! it shows background, and how much it varies.
//!
//! Under a still camera, what differs from the backdrop has moved; under a moving one the variation is large where
//! the scenery has texture, and the backdrop says little there. Creature that is taken for background and does not move
//! becomes backdrop, so that "as always" counts for less than "unlike ever", and for nothing where there is no texture.

use rayon::prelude::*;

use super::working::Working;
use crate::raster::Grid;

/// Frames looked at, spread evenly over longer clips.
const FRAMES: usize = 48;
/// A pixel that shows background in fewer of them has no backdrop.
const LEAST_FRAMES: usize = 4;
/// Standard deviation of a colour that stands still, in 8-bit levels: noise of camera and codec.
const NOISE: f32 = 6.0;
/// The standard deviation of normally distributed values with a median absolute deviation of 1.
const SPREAD: f32 = 1.48;
/// Deviations up to which a colour is more likely backdrop than not.
const LIKE: f32 = 2.0;
/// Evidence for each deviation more or less, and its bounds.
const SLOPE: f32 = 0.5;
const AS_ALWAYS: f32 = -0.7;
const UNLIKE: f32 = 1.5;

/// Neighbouring pixels that differ by this in a channel are texture.
const TEXTURE: u8 = 16;
/// The share of texture that has the same colours in the next frame looked at, under a still camera at least.
const STILL: f32 = 0.5;

/// What a pixel usually shows.
#[derive(Clone, Copy, Default)]
struct Usual {
    colour: [u8; 3],
    /// 0 where there is no backdrop.
    deviation: f32,
}

/// The backdrop of a clip.
pub(super) struct Backdrop(Grid<Usual>);

impl Backdrop {
    /// `background(frame, x, y)` says whether a pixel shows background. `None` when the camera moves.
    pub(super) fn learn(working: &Working, background: impl Fn(usize, usize, usize) -> bool + Sync) -> Option<Self> {
        let all = working.frames.len();
        let count = all.min(FRAMES);
        let frames: Vec<usize> = (0..count).map(|i| i * all / count).collect();
        if !stands_still(working, &frames, &background) {
            return None;
        }
        let line = |y: usize| -> Vec<Usual> {
            let mut values: [Vec<u8>; 3] = Default::default();
            let pixel = |x: usize| {
                values.iter_mut().for_each(Vec::clear);
                for &frame in frames.iter().filter(|&&f| background(f, x, y)) {
                    let colour = working.frames[frame].get(x, y);
                    values.iter_mut().zip(colour).for_each(|(v, c)| v.push(c));
                }
                if values[0].len() < LEAST_FRAMES {
                    return Usual::default();
                }
                let middle: [u8; 3] = std::array::from_fn(|c| median(&mut values[c]));
                let variance: f32 = (0..3)
                    .map(|c| {
                        values[c].iter_mut().for_each(|v| *v = v.abs_diff(middle[c]));
                        (SPREAD * f32::from(median(&mut values[c]))).powi(2)
                    })
                    .sum();
                Usual { colour: middle, deviation: (variance / 3.0 + NOISE * NOISE).sqrt() }
            };
            (0..working.width).map(pixel).collect()
        };
        let lines: Vec<_> = (0..working.height).into_par_iter().map(line).collect();
        Some(Self(Grid::from_vec(working.width, working.height, lines.concat())))
    }

    /// The evidence for creature in that a pixel has this colour, as a natural logarithm.
    #[inline]
    pub(super) fn evidence(&self, x: usize, y: usize, colour: [u8; 3]) -> f32 {
        let usual = self.0.get(x, y);
        if usual.deviation == 0.0 {
            return 0.0;
        }
        let square: f32 = colour.iter().zip(usual.colour).map(|(&a, b)| f32::from(a.abs_diff(b)).powi(2)).sum();
        let evidence = SLOPE * ((square / 3.0).sqrt() / usual.deviation - LIKE);
        // Where all is of one colour, a creature of that colour looks as always.
        let textured = || {
            [(x.saturating_sub(1), y), (x, y.saturating_sub(1))]
                .iter()
                .any(|&(x, y)| differ(self.0.get(x, y).colour, usual.colour))
        };
        if evidence < 0.0 && !textured() { 0.0 } else { evidence.clamp(AS_ALWAYS, UNLIKE) }
    }
}

/// Whether background with texture keeps its colours from frame to frame, as it does under a still camera only.
fn stands_still(
    working: &Working,
    frames: &[usize],
    background: &(impl Fn(usize, usize, usize) -> bool + Sync),
) -> bool {
    let (textured, steady) = frames
        .par_windows(2)
        .map(|pair| {
            let (before, after) = (&working.frames[pair[0]], &working.frames[pair[1]]);
            let (mut textured, mut steady) = (0usize, 0usize);
            for y in (1..working.height).step_by(2) {
                for x in (1..working.width).step_by(2) {
                    let here = before.get(x, y);
                    let texture = differ(here, before.get(x - 1, y)) || differ(here, before.get(x, y - 1));
                    if texture && background(pair[0], x, y) && background(pair[1], x, y) {
                        textured += 1;
                        steady += usize::from(!differ(here, after.get(x, y)));
                    }
                }
            }
            (textured, steady)
        })
        .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    steady as f32 >= STILL * textured.max(1) as f32
}

fn differ(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).any(|(&a, b)| a.abs_diff(b) >= TEXTURE)
}

fn median(values: &mut [u8]) -> u8 {
    let middle = values.len() / 2;
    *values.select_nth_unstable(middle).1
}
