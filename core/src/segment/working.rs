//! The clip and its strokes at the segmenter's working size.
//!
//! Frames are read once, in order, reduced by area averages and kept as bytes; the number of kept pixels is bounded,
//! so a long clip is worked on at a smaller size instead of filling the memory.

use glam::{Vec2, vec2};
use rayon::prelude::*;

use crate::clip::{Clip, Picture};
use crate::error::Result;
use crate::geometry::polyline;
use crate::job::Stage;
use crate::motion::Motion;
use crate::raster::{Grid, Mask, pyramid};
use crate::rig::{Rig, Skeleton};

/// Frames decoded before they are reduced side by side.
pub(super) const BATCH: usize = 8;
/// Pixels kept over all frames.
const MAX_PIXELS: f64 = 48e6;
/// A clip of which more is opaque than this is a scene, not a cut-out.
const CUT_OUT_SHARE: f64 = 0.6;
/// A working image is no smaller than this, however long the clip.
const MIN_SIDE: u32 = 160;
/// Share of a terminal limb, at its free end, that is drawn too long or hidden too often to be trusted (Reinert 2016).
const TRUSTED_SHARE: f32 = 0.8;

/// The clip at working size.
pub(super) struct Working {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Working pixels for one pixel of the clip.
    pub(super) scale: Vec2,
    pub(super) frames: Vec<Grid<[u8; 3]>>,
    /// Where each frame is opaque, in the clip's size, when the clip has opacity.
    pub(super) opaque: Vec<Option<Mask>>,
}

impl Working {
    /// Reads the clip; its working image has no side longer than `side`.
    pub(super) fn read(clip: &Clip, side: u32, stage: Stage<'_>) -> Result<Self> {
        let info = clip.info();
        let longest = info.width.max(info.height).max(1);
        let whole = f64::from(info.width) * f64::from(info.height) * info.frames as f64;
        let bound = f64::from(longest) * (MAX_PIXELS / whole.max(1.0)).sqrt();
        let side = side.min((bound as u32).max(MIN_SIDE)).max(1);
        let (width, height) = pyramid::fitted(info.width, info.height, side);
        let mut frames = Vec::with_capacity(info.frames);
        let read =
            |_, picture: &Picture| Ok((reduce(picture, width, height), picture.alpha.as_ref().map(Mask::from_image)));
        for_batches(clip, stage, read, &mut frames)?;
        let (frames, opaque) = frames.into_iter().unzip();
        let scale = vec2(width as f32 / info.width.max(1) as f32, height as f32 / info.height.max(1) as f32);
        Ok(Self { width: width as usize, height: height as usize, scale, frames, opaque })
    }
}

impl Working {
    /// The masks of a cut-out: a clip with opacity of which little is opaque shows nothing but the creature.
    pub(super) fn cut_out(&self) -> Option<Vec<Mask>> {
        let opaque: Vec<Mask> = self.opaque.iter().cloned().collect::<Option<_>>()?;
        let covered: usize = opaque.iter().map(Mask::count).sum();
        let all: usize = opaque.iter().map(|m| m.width() * m.height()).sum();
        (covered as f64 <= CUT_OUT_SHARE * all as f64).then_some(opaque)
    }
}

/// Calls `work` with every frame of the clip: decoded in order, worked on side by side, results in order.
pub(super) fn for_batches<T: Send>(
    clip: &Clip,
    stage: Stage<'_>,
    work: impl Fn(usize, &Picture) -> Result<T> + Sync,
    out: &mut Vec<T>,
) -> Result<()> {
    let frames = clip.info().frames;
    let mut first = 0;
    while first < frames {
        let end = (first + BATCH).min(frames);
        let mut pictures = Vec::with_capacity(BATCH);
        for frame in first..end {
            stage.at(frame as f64 / frames as f64)?;
            pictures.push(clip.frame(frame)?);
        }
        let done: Vec<Result<T>> = pictures
            .par_iter()
            .enumerate()
            .map(|(i, picture)| {
                stage.at(first as f64 / frames as f64)?;
                work(first + i, picture)
            })
            .collect();
        for result in done {
            out.push(result?);
        }
        first = end;
    }
    stage.at(1.0)
}

fn reduce(picture: &Picture, width: u32, height: u32) -> Grid<[u8; 3]> {
    let small = pyramid::shrunk(&picture.rgb, width, height);
    Grid::from_vec(width as usize, height as usize, small.pixels().map(|p| p.0).collect())
}

/// The tracked limbs as evenly spaced samples, the same ones in every frame, in working pixels.
pub(super) struct Limbs {
    /// The limb of every sample.
    pub(super) limb: Vec<u16>,
    /// Where each limb's samples begin, and their total at the end.
    pub(super) first: Vec<usize>,
    /// About how long each limb is, in working pixels.
    pub(super) length: Vec<f32>,
    /// Whether a sample may be taken for creature without doubt: not near the free end of a terminal limb.
    pub(super) trusted: Vec<bool>,
    /// The limb on the body's other side, where the rig has one.
    pub(super) twin: Vec<Option<usize>>,
    /// For every frame the samples' places.
    pub(super) places: Vec<Vec<Vec2>>,
    /// For every frame whether the tracker saw the sample.
    pub(super) visible: Vec<Vec<bool>>,
    /// For every frame whether the user drew the limb there.
    pub(super) drawn: Vec<Vec<bool>>,
}

/// Distance between samples along limbs, in working pixels.
pub(super) const SPACING: f32 = 3.0;
/// Most samples of one limb, and of all limbs together.
const MAX_SAMPLES: usize = 400;
const MAX_ALL_SAMPLES: usize = 1 << 15;

impl Limbs {
    /// The rig's limbs as `motion` tracked them, a sample about every `spacing` working pixels. Frames or limbs that
    /// the motion lacks have no sample that is visible.
    pub(super) fn new(rig: &Rig, motion: &Motion, scale: Vec2, frames: usize, spacing: f32) -> Self {
        let skeleton = Skeleton::new(rig, rig.size.0.max(rig.size.1).max(1) as f32 / 50.0);
        let (mut limb, mut first, mut lengths, mut trusted) = (Vec::new(), vec![0], Vec::new(), Vec::new());
        let most = (MAX_ALL_SAMPLES / rig.limbs.len().max(1)).clamp(3, MAX_SAMPLES);
        for l in 0..rig.limbs.len() {
            let length = rig.length_hint(l) * 0.5 * (scale.x + scale.y);
            let count = ((length / spacing).round() as usize + 1).clamp(3, most);
            let chain = &skeleton.limbs[l];
            for i in 0..count {
                let along = i as f32 / (count - 1) as f32;
                let outward = if chain.rooted_at_start { along } else { 1.0 - along };
                // A limb without a parent can be free at both ends; its root counts as body.
                trusted.push(!chain.terminal || outward <= TRUSTED_SHARE);
                limb.push(l as u16);
            }
            first.push(limb.len());
            lengths.push(length);
        }
        let mut places = Vec::with_capacity(frames);
        let mut visible = Vec::with_capacity(frames);
        for frame in 0..frames {
            let (mut here, mut seen) = (Vec::with_capacity(limb.len()), Vec::with_capacity(limb.len()));
            for (l, entry) in rig.limbs.iter().enumerate() {
                let count = first[l + 1] - first[l];
                let track = motion.track(&entry.label).and_then(|t| t.frames.get(frame));
                let points: Vec<Vec2> = track.map_or_else(Vec::new, |t| t.points.iter().map(|p| *p * scale).collect());
                if points.is_empty() || points.iter().any(|p| !p.is_finite()) {
                    here.extend(std::iter::repeat_n(Vec2::NAN, count));
                    seen.extend(std::iter::repeat_n(false, count));
                    continue;
                }
                here.extend(polyline::resample(&points, count));
                let flags = track.map_or(&[][..], |t| &t.visible[..]);
                seen.extend((0..count).map(|i| {
                    let at = (i as f32 / (count - 1) as f32 * (points.len() - 1) as f32).round() as usize;
                    flags.get(at).copied().unwrap_or(true)
                }));
            }
            places.push(here);
            visible.push(seen);
        }
        let twin = (0..rig.limbs.len()).map(|l| rig.twin(l)).collect();
        let drawn = (0..frames).map(|f| (0..rig.limbs.len()).map(|l| rig.stroke(l, f).is_some()).collect()).collect();
        Self { limb, first, length: lengths, trusted, twin, places, visible, drawn }
    }

    /// How many samples there are.
    pub(super) fn len(&self) -> usize {
        self.limb.len()
    }

    /// The samples of a limb.
    pub(super) fn of(&self, limb: usize) -> std::ops::Range<usize> {
        self.first[limb]..self.first[limb + 1]
    }

    /// The size of the creature in working pixels: the square root of the area of the box around its strokes, the
    /// median over frames.
    pub(super) fn extent(&self) -> f32 {
        let mut sizes: Vec<f32> = self.places.iter().filter_map(|p| bounds(p)).map(|(a, b)| extent_of(b - a)).collect();
        sizes.sort_by(f32::total_cmp);
        sizes.get(sizes.len() / 2).copied().unwrap_or(0.0)
    }
}

/// A box of any shape as one length; a lone straight limb still counts with a fifth of its length across.
fn extent_of(size: Vec2) -> f32 {
    let (long, short) = (size.max_element(), size.min_element());
    (long * short.max(0.2 * long)).sqrt()
}

/// The box around the finite ones of `points`.
pub(super) fn bounds(points: &[Vec2]) -> Option<(Vec2, Vec2)> {
    points
        .iter()
        .filter(|p| p.is_finite())
        .fold(None, |b, &p| Some(b.map_or((p, p), |(lo, hi): (Vec2, Vec2)| (lo.min(p), hi.max(p)))))
}
