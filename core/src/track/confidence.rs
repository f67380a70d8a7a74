//! How far tracks of one point are to be trusted, and where a correction would help most: what reports on tracked joints and
//! points share.

use crate::motion::{Motion, Track};

/// How many corrections are suggested, and the share of the clip between two of one track: each helps its neighbours.
const SUGGESTIONS: usize = 5;
const GAP: f32 = 0.1;

/// How far one track is to be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Confidence {
    /// Mean over all frames, 0..=1.
    pub(super) mean: f32,
    /// The lowest of any frame, and that frame.
    pub(super) lowest: (f32, usize),
    /// How many frames there are, and in how many of them it is seen.
    pub(super) frames: usize,
    pub(super) seen: usize,
}

impl Confidence {
    pub(super) fn of(track: &Track) -> Self {
        let frames = || track.frames.iter().enumerate();
        let points = frames().filter_map(|(f, frame)| Some((f, *frame.confidence.first()?, *frame.visible.first()?)));
        let (mut sum, mut all) = (0.0f64, Self { lowest: (f32::INFINITY, 0), ..Self::default() });
        for (f, confidence, is_seen) in points {
            sum += f64::from(confidence);
            all.frames += 1;
            all.seen += usize::from(is_seen);
            if confidence < all.lowest.0 {
                all.lowest = (confidence, f);
            }
        }
        if all.frames == 0 {
            return Self::default();
        }
        all.mean = (sum / all.frames as f64) as f32;
        all
    }

    /// Share of frames in which it is seen.
    pub(super) fn visible(&self) -> f32 {
        self.seen as f32 / self.frames.max(1) as f32
    }
}

/// A place that is trusted little.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Doubt<'a> {
    pub(super) track: &'a str,
    pub(super) frame: usize,
    pub(super) confidence: f32,
}

/// The tracks and frames that are trusted least, apart from each other.
pub(super) fn doubts(motion: &Motion) -> Vec<Doubt<'_>> {
    let all = motion.tracks.iter().flat_map(|t| {
        let frames = t.frames.iter().enumerate();
        frames.filter_map(|(frame, f)| Some(Doubt { track: &t.name, frame, confidence: *f.confidence.first()? }))
    });
    let mut all: Vec<Doubt<'_>> = all.filter(|d| d.confidence < 1.0).collect();
    all.sort_by(|a, b| a.confidence.total_cmp(&b.confidence).then(a.frame.cmp(&b.frame)));
    let gap = (GAP * motion.frames as f32) as usize;
    let mut chosen: Vec<Doubt<'_>> = Vec::new();
    for doubt in all {
        if chosen.iter().all(|c| c.track != doubt.track || c.frame.abs_diff(doubt.frame) > gap) {
            chosen.push(doubt);
            if chosen.len() == SUGGESTIONS {
                break;
            }
        }
    }
    chosen
}
