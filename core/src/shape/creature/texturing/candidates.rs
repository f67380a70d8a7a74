//! What the frames offer for every texel, and which frame is taken.
//!
//! A texel keeps the key frame's sample and its few best others, so that memory does not grow with the clip. Colours are
//! brought to the key frame's exposure first. The choice is a labelling (Lempitsky and Ivanov 2007, "Seamless mosaicing
//! of image-based texture maps"): a frame's cost is low where it sees the texel well and agrees with what most frames
//! show (a mistracked frame does not), the key frame has a bonus, and neighbours with different frames pay. It is
//! lowered by iterated conditional modes on a checkerboard. One frame gives each texel, so nothing is blurred.

use glam::Vec3;
use rayon::prelude::*;

use super::texels::Texels;
use super::view::Sample;
use crate::error::Result;
use crate::job::Stage;

/// Samples kept a texel, the key frame's first. Seven others are enough for a median.
const KEPT: usize = 8;
/// Samples at least this good take part in matching exposures.
const GOOD: u8 = 64;
/// Texels that two frames must share before their exposures are compared, and the contrast that counts as one.
const SHARED: u64 = 200;
const GAIN: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// Levels off the median that cost as much as being seen e times worse.
const DEVIATION: f32 = 12.0;
/// What a neighbour of another frame costs.
const SEAM: f32 = 0.4;
const ROUNDS: usize = 8;

pub(super) struct Candidates {
    /// `KEPT` a texel.
    samples: Vec<Sample>,
    frames: Vec<u16>,
    key: u16,
}

/// The frame that was taken for every texel, and its colour.
pub(super) struct Choice {
    /// [`Choice::NONE`] where no frame shows the texel.
    pub frame: Vec<u16>,
    pub color: Vec<Vec3>,
    pub quality: Vec<u8>,
}

impl Choice {
    pub(super) const NONE: u16 = u16::MAX;
}

impl Candidates {
    /// With the key frame's samples.
    pub(super) fn new(key: usize, samples: &[Sample]) -> Self {
        let mut kept = vec![[0; 4]; KEPT * samples.len()];
        kept.chunks_exact_mut(KEPT).zip(samples).for_each(|(k, s)| k[0] = *s);
        Self { samples: kept, frames: vec![key as u16; KEPT * samples.len()], key: key as u16 }
    }

    /// Adds another frame's samples, brought to the key frame's exposure.
    pub(super) fn add(&mut self, frame: usize, samples: &[Sample]) {
        let (gain, offset) = self.exposure(samples);
        let matched = |c: u8, k: usize| (f64::from(c) * gain[k] + offset[k]).round().clamp(0.0, 255.0) as u8;
        let tables: Vec<[u8; 3]> = (0..=255).map(|c| [matched(c, 0), matched(c, 1), matched(c, 2)]).collect();
        let slots = self.samples.par_chunks_exact_mut(KEPT).zip(self.frames.par_chunks_exact_mut(KEPT));
        slots.zip(samples).with_min_len(4096).for_each(|((kept, frames), s)| {
            let worst = (1..KEPT).min_by_key(|&k| kept[k][3]).unwrap_or(1);
            if s[3] > kept[worst][3] {
                let [r, g, b] = [0, 1, 2].map(|k| tables[usize::from(s[k])][k]);
                kept[worst] = [r, g, b, s[3]];
                frames[worst] = frame as u16;
            }
        });
    }

    /// The gain and offset a channel that take the frame's colours to the key frame's, by mean and deviation over the
    /// texels that both show well.
    fn exposure(&self, samples: &[Sample]) -> ([f64; 3], [f64; 3]) {
        let (mut n, mut sum, mut square) = (0u64, [[0u64; 3]; 2], [[0u64; 3]; 2]);
        for (kept, s) in self.samples.chunks_exact(KEPT).zip(samples) {
            if kept[0][3] >= GOOD && s[3] >= GOOD {
                n += 1;
                for (which, of) in [kept[0], *s].iter().enumerate() {
                    for c in 0..3 {
                        sum[which][c] += u64::from(of[c]);
                        square[which][c] += u64::from(of[c]) * u64::from(of[c]);
                    }
                }
            }
        }
        if n < SHARED {
            return ([1.0; 3], [0.0; 3]);
        }
        let mean = |w: usize, c: usize| sum[w][c] as f64 / n as f64;
        let deviation = |w: usize, c: usize| (square[w][c] as f64 / n as f64 - mean(w, c).powi(2)).max(0.25).sqrt();
        let gain = [0, 1, 2].map(|c| (deviation(0, c) / deviation(1, c)).clamp(*GAIN.start(), *GAIN.end()));
        (gain, [0, 1, 2].map(|c| mean(0, c) - gain[c] * mean(1, c)))
    }

    /// The color that `frame` shows at a texel, if it is kept and at least so good.
    pub(super) fn shown(&self, texel: usize, frame: u16, least: u8) -> Option<Vec3> {
        let slots = texel * KEPT..(texel + 1) * KEPT;
        let of = |k: usize| self.samples[k][3] >= least && self.frames[k] == frame;
        slots.into_iter().find(|&k| of(k)).map(|k| color(self.samples[k]))
    }

    /// Which frame is taken for every texel. `bonus` is what being the key frame is worth, in natural logarithms of
    /// quality.
    pub(super) fn choose(&self, texels: &Texels, bonus: f32, stage: Stage<'_>) -> Result<Choice> {
        let costs: Vec<[f32; KEPT]> = self
            .samples
            .par_chunks_exact(KEPT)
            .zip(self.frames.par_chunks_exact(KEPT))
            .with_min_len(4096)
            .map(|(s, f)| self.costs(s, f, bonus))
            .collect();
        let best = |costs: &[f32; KEPT]| (0..KEPT).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0) as u8;
        let mut slot: Vec<u8> = costs.par_iter().with_min_len(4096).map(best).collect();
        for round in 0..2 * ROUNDS {
            stage.at(round as f64 / (2 * ROUNDS) as f64)?;
            let frame_of = |i: usize| match self.samples[i * KEPT + usize::from(slot[i])][3] {
                0 => Choice::NONE,
                _ => self.frames[i * KEPT + usize::from(slot[i])],
            };
            let taken: Vec<u16> = (0..slot.len()).into_par_iter().with_min_len(4096).map(frame_of).collect();
            slot.par_iter_mut().enumerate().with_min_len(4096).for_each(|(i, slot)| {
                let texel = &texels.list[i];
                let w = texels.sizes[usize::from(texel.part)].0;
                if (texel.at % w + texel.at / w) as usize % 2 != round % 2 || taken[i] == Choice::NONE {
                    return;
                }
                let beside = texels.beside(i);
                if beside.iter().all(|&j| taken[j as usize] == taken[i]) {
                    return;
                }
                let mut costs = costs[i];
                for (k, cost) in costs.iter_mut().enumerate() {
                    let frame = self.frames[i * KEPT + k];
                    let other = |j: &&u32| !matches!(taken[**j as usize], f if f == frame || f == Choice::NONE);
                    *cost += SEAM * beside.iter().filter(other).count() as f32;
                }
                *slot = best(&costs);
            });
        }
        let taken = |i: usize| self.samples[i * KEPT + usize::from(slot[i])];
        let n = slot.len();
        Ok(Choice {
            frame: (0..n)
                .map(|i| if taken(i)[3] == 0 { Choice::NONE } else { self.frames[i * KEPT + usize::from(slot[i])] })
                .collect(),
            color: (0..n).map(|i| color(taken(i))).collect(),
            quality: (0..n).map(|i| taken(i)[3]).collect(),
        })
    }

    fn costs(&self, samples: &[Sample], frames: &[u16], bonus: f32) -> [f32; KEPT] {
        let median = [0, 1, 2].map(|c| weighted_median(samples, c));
        let mut out = [f32::INFINITY; KEPT];
        for k in (0..KEPT).filter(|&k| samples[k][3] > 0) {
            let s = samples[k];
            let off = (0..3).map(|c| f32::from(s[c].abs_diff(median[c]))).sum::<f32>() / 3.0;
            // The user drew on the key frame, so it is right where it differs from all others.
            let doubt = if frames[k] == self.key { -bonus } else { off / DEVIATION };
            out[k] = doubt - (f32::from(s[3]) / 255.0).ln();
        }
        out
    }
}

fn color(s: Sample) -> Vec3 {
    Vec3::new(f32::from(s[0]), f32::from(s[1]), f32::from(s[2]))
}

/// The value at which half of the quality is reached.
fn weighted_median(samples: &[Sample], channel: usize) -> u8 {
    let mut sorted: [(u8, u8); KEPT] = [(0, 0); KEPT];
    sorted.iter_mut().zip(samples).for_each(|(o, s)| *o = (s[channel], s[3]));
    sorted.sort_unstable();
    let total: u32 = sorted.iter().map(|s| u32::from(s.1)).sum();
    let mut sum = 0;
    for (value, weight) in sorted {
        sum += u32::from(weight);
        if 2 * sum >= total && weight > 0 {
            return value;
        }
    }
    0
}
