//! The built-in point tracker: points marked on a frame or a few, followed through the clip.
//!
//! Live Sketch (Su et al. 2018, "Motion Extraction" and "Ambiguity Handling"), after Buchanan and Fitzgibbon 2006: candidates
//! over the frame, the cheapest path through them, look-alike points told apart together. Beside the paper's terms a path
//! is held to the motion of small patches between neighbouring frames, which is where most of its exactness comes from.
//!
//! Each stretch between two keys of a point is solved by itself, from its keys and a guide: where all points together,
//! tracked as limbs from their first keys, would have it (see `guide`). So a correction changes nothing beyond the keys
//! beside it, but for points that look like the corrected one; another first key changes everything.
//!
//! Known limits: limbs that swing fast behind others are lost until a correction; skipping is dear by default
//! ([`PointParams::hide`]): lower it where things hide a lot.

mod candidates;
mod footage;
mod guide;
mod joint_choice;
mod look_alikes;
mod looks;
mod params;
mod path;
mod report;
mod skeleton;
mod stretch;

pub use params::PointParams;
pub use report::{PointConfidence, PointCorrection, PointReport};

use rayon::prelude::*;

use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::motion::{Motion, Track, TrackFrame, TrackKind};
use crate::rig::{PointMark, PointMarks};
use footage::Footage;
use guide::{Guide, guides};
use look_alikes::{LookAlikes, alike};
use stretch::{Alone, Key, Place, Solved, Stretch};

#[cfg(test)]
mod tests;

/// Tracks points.
#[derive(Clone, Debug, Default)]
pub struct PointTracker {
    /// How.
    pub params: PointParams,
}

/// What was tracked before.
#[derive(Clone, Copy, Debug)]
pub struct EarlierPoints<'a> {
    /// The motion.
    pub motion: &'a Motion,
    /// The marks that led to it.
    pub marks: &'a PointMarks,
}

/// Share of the work that is reading.
const READING: f64 = 0.4;
/// Share of the tracking that is finding guides.
const GUIDING: f64 = 0.7;

impl super::TrackPoints for PointTracker {
    fn track_points(&self, clip: &Clip, marks: &PointMarks, stage: Stage<'_>) -> Result<Motion> {
        let mut solver = self.read(clip, marks, stage.part(0.0, READING))?;
        solver.track(marks, stage.part(READING, 1.0))
    }

    fn retrack_points(
        &self,
        clip: &Clip,
        marks: &PointMarks,
        earlier: EarlierPoints<'_>,
        stage: Stage<'_>,
    ) -> Result<Motion> {
        let mut solver = self.read(clip, marks, stage.part(0.0, READING))?;
        let (touched, kept) = solver.touched(marks, &earlier);
        let mut motion = if touched.points.is_empty() {
            Motion { tracks: Vec::new(), ..earlier.motion.clone() }
        } else {
            solver.guide(marks, stage.part(READING, READING + (1.0 - READING) * GUIDING))?;
            solver.follow(&touched, stage.part(READING + (1.0 - READING) * GUIDING, 1.0))?
        };
        motion.tracks.extend(kept.into_iter().cloned());
        let place = |name: &str| marks.points.iter().position(|p| p.name == name);
        motion.tracks.sort_by_key(|t| place(&t.name));
        Ok(motion)
    }
}

impl PointTracker {
    /// Reads a clip for marks that are of it.
    fn read(&self, clip: &Clip, marks: &PointMarks, stage: Stage<'_>) -> Result<PointFootage> {
        let info = clip.info();
        marks.validate(Some(((info.width, info.height), info.frames)))?;
        PointFootage::read(clip, &self.params, stage)
    }
}

/// A clip that was read for tracking points in it; what was solved is kept.
#[derive(Debug)]
pub struct PointFootage {
    footage: Footage,
    params: PointParams,
    size: (u32, u32),
    fps: f64,
    alone: Vec<Alone>,
    solved: Vec<Solved>,
    look_alikes: LookAlikes,
    /// The points' first keys, and the guides that follow from them.
    firsts: Vec<Key>,
    guides: Vec<(Key, Vec<Guide>)>,
}

impl PointFootage {
    /// Reads a clip.
    ///
    /// # Errors
    /// A frame cannot be read, or the caller cancelled.
    pub fn read(clip: &Clip, params: &PointParams, stage: Stage<'_>) -> Result<Self> {
        stage.name("reading")?;
        let info = clip.info();
        let footage = Footage::read(clip, params.working_side, stage)?;
        Ok(Self {
            footage,
            params: params.clone(),
            size: (info.width, info.height),
            fps: info.fps,
            alone: Vec::new(),
            solved: Vec::new(),
            look_alikes: LookAlikes::default(),
            firsts: Vec::new(),
            guides: Vec::new(),
        })
    }

    /// From now on tracks as `params` say (the size of the working pictures stays); forgets what was solved.
    pub fn set_params(&mut self, params: &PointParams) {
        self.params = params.clone();
        self.forget();
        (self.firsts, self.guides) = (Vec::new(), Vec::new());
    }

    fn forget(&mut self) {
        (self.alone, self.solved, self.look_alikes) = (Vec::new(), Vec::new(), LookAlikes::default());
    }

    /// Finds where all points together would have each, unless their first keys are the same as before.
    fn guide(&mut self, marks: &PointMarks, stage: Stage<'_>) -> Result<()> {
        let firsts = first_keys(marks, self.footage.scale);
        if firsts == self.firsts || self.params.guide <= 0.0 {
            return Ok(());
        }
        self.forget();
        (self.firsts, self.guides) = (Vec::new(), Vec::new());
        let frames = self.footage.frames();
        let all: Vec<Vec<Stretch>> = firsts.iter().map(|key| stretches(&[*key], frames)).collect();
        self.solve_alone(&all.concat(), stage.part(0.0, 0.3))?;
        let ways: Vec<Vec<Place>> = all
            .iter()
            .map(|parts| {
                let mut way = Vec::with_capacity(frames);
                for alone in parts.iter().filter_map(|s| self.alone.iter().find(|a| a.stretch == *s)) {
                    way.extend_from_slice(&alone.way(&self.footage).places[usize::from(!way.is_empty())..]);
                }
                way
            })
            .collect();
        self.guides = guides(&self.footage, &firsts, &ways, stage.part(0.3, 1.0))?;
        self.firsts = firsts;
        Ok(())
    }

    /// Solves each of some stretches alone that were not solved before.
    fn solve_alone(&mut self, stretches: &[Stretch], stage: Stage<'_>) -> Result<()> {
        let mut fresh: Vec<Stretch> = Vec::new();
        for s in stretches {
            if !fresh.contains(s) && !self.alone.iter().any(|a| a.stretch == *s) {
                fresh.push(*s);
            }
        }
        let found: Vec<Alone> =
            fresh.par_iter().map(|s| s.alone(&self.footage, &self.params, stage)).collect::<Result<_>>()?;
        self.alone.extend(found);
        Ok(())
    }

    /// Tracks every point of `marks`; what was solved for the same keys before is not solved again.
    ///
    /// # Errors
    /// The marks are not of this clip or not valid, or the caller cancelled.
    pub fn track(&mut self, marks: &PointMarks, stage: Stage<'_>) -> Result<Motion> {
        marks.validate(Some((self.size, self.footage.frames())))?;
        stage.name("tracking")?;
        self.guide(marks, stage.part(0.0, GUIDING))?;
        self.follow(marks, stage.part(GUIDING, 1.0))
    }

    /// Tracks points with the guides that are there.
    fn follow(&mut self, marks: &PointMarks, stage: Stage<'_>) -> Result<Motion> {
        let frames = self.footage.frames();
        let scale = self.footage.scale;
        let stretches: Vec<Vec<Stretch>> =
            marks.points.iter().map(|p| stretches(&sorted_keys(p, scale), frames)).collect();
        let flat: Vec<Stretch> = stretches.iter().flatten().copied().collect();
        let fresh: Vec<(Key, Stretch)> = first_keys(marks, scale)
            .into_iter()
            .zip(&stretches)
            .flat_map(|(first, list)| list.iter().map(move |s| (first, *s)))
            .filter(|(_, s)| !self.solved.iter().any(|known| known.stretch == *s))
            .collect();
        let all: Vec<Stretch> = fresh.iter().map(|f| f.1).collect();
        self.solve_alone(&all, stage.part(0.0, 0.4))?;
        let solving = stage.part(0.4, 0.8);
        let fresh: Vec<Option<Solved>> = fresh
            .par_iter()
            .map(|(first, s)| {
                let guide = self.guides.iter().find(|g| g.0 == *first).map_or(&[][..], |g| &g.1);
                let alone = self.alone.iter().find(|a| a.stretch == *s);
                alone.map(|a| a.guided(&self.footage, &self.params, guide, solving)).transpose()
            })
            .collect::<Result<_>>()?;
        let fresh: Vec<Solved> = fresh.into_iter().flatten().collect();
        self.alone.retain(|known| flat.contains(&known.stretch));
        self.solved.retain(|known| flat.contains(&known.stretch));
        self.solved.extend(fresh);
        let of = |s: &Stretch| self.solved.iter().find(|known| known.stretch == *s);
        let parts: Vec<Vec<&Solved>> = stretches.iter().map(|list| list.iter().filter_map(of).collect()).collect();
        let ways = self.look_alikes.told_apart(&self.footage, &self.params, &parts, stage.part(0.8, 1.0))?;
        let tracks = marks
            .points
            .iter()
            .zip(parts.iter().zip(&ways))
            .map(|(point, (parts, ways))| {
                let mut track = vec![TrackFrame::default(); frames];
                for (part, way) in parts.iter().zip(ways) {
                    for (f, place) in (part.stretch.from..).zip(&way.places) {
                        track[f] = TrackFrame {
                            points: vec![place.at / self.footage.scale],
                            visible: vec![place.seen],
                            confidence: vec![place.confidence],
                        };
                    }
                }
                for key in &point.keys {
                    track[key.frame] = TrackFrame::certain(vec![key.at]);
                }
                Track { name: point.name.clone(), kind: TrackKind::Point, frames: track }
            })
            .collect();
        stage.at(1.0)?;
        Ok(Motion { size: marks.size, fps: self.fps, frames, tracks, bones: Vec::new() })
    }
}

impl PointFootage {
    /// The points that are to be tracked again, with all that they are told apart from, and the tracks that hold.
    fn touched<'a>(&self, marks: &PointMarks, earlier: &EarlierPoints<'a>) -> (PointMarks, Vec<&'a Track>) {
        let frames = self.footage.frames();
        let same = earlier.motion.size == self.size && earlier.motion.frames == frames;
        let same = same && earlier.marks.validate(Some((self.size, frames))).is_ok();
        let firsts = |marks: &PointMarks| first_keys(marks, self.footage.scale);
        let same = same && (self.params.guide <= 0.0 || firsts(earlier.marks) == firsts(marks));
        let track = |name: &str| earlier.motion.track(name).filter(|t| same && t.frames.len() == frames);
        let sorted = |point: &PointMark| sorted_keys(point, self.footage.scale);
        let unedited = |point: &PointMark| {
            let before = earlier.marks.point(&point.name).filter(|_| track(&point.name).is_some());
            before.is_some_and(|before| sorted(before) == sorted(point))
        };
        // Points of both times: whom an edited one was told apart from, it may now leave alone.
        let was = earlier.marks.points.iter().filter(|p| same && !marks.point(&p.name).is_some_and(unedited));
        let all: Vec<&PointMark> = marks.points.iter().chain(was).collect();
        let keys: Vec<Option<Key>> = all.iter().map(|p| sorted(p).first().copied()).collect();
        let kin = alike(&self.footage, &self.params, &keys);
        let mut again: Vec<bool> =
            all.iter().enumerate().map(|(i, p)| i >= marks.points.len() || !unedited(p)).collect();
        let mut open: Vec<usize> = (0..all.len()).filter(|&i| again[i]).collect();
        while let Some(i) = open.pop() {
            for j in 0..all.len() {
                if kin[i * all.len() + j] && !again[j] {
                    again[j] = true;
                    open.push(j);
                }
            }
        }
        let (mut touched, mut kept) = (PointMarks { size: marks.size, points: Vec::new() }, Vec::new());
        for (point, again) in marks.points.iter().zip(again) {
            match track(&point.name).filter(|_| !again) {
                Some(track) => kept.push(track),
                None => touched.points.push(point.clone()),
            }
        }
        (touched, kept)
    }
}

fn sorted_keys(point: &PointMark, scale: f32) -> Vec<Key> {
    let mut keys: Vec<Key> = point.keys.iter().map(|k| Key { frame: k.frame, at: k.at * scale }).collect();
    keys.sort_by_key(|k| k.frame);
    keys
}

/// The key that each point was given first.
fn first_keys(marks: &PointMarks, scale: f32) -> Vec<Key> {
    let keys = marks.points.iter().filter_map(|p| p.keys.first());
    keys.map(|k| Key { frame: k.frame, at: k.at * scale }).collect()
}

/// The stretches between a point's keys, which rise.
fn stretches(keys: &[Key], frames: usize) -> Vec<Stretch> {
    let mut out = Vec::with_capacity(keys.len() + 1);
    if let Some(first) = keys.first().filter(|k| k.frame > 0) {
        out.push(Stretch { from: 0, to: first.frame, keys: [None, Some(*first)] });
    }
    out.extend(keys.windows(2).map(|k| Stretch { from: k[0].frame, to: k[1].frame, keys: [Some(k[0]), Some(k[1])] }));
    if let Some(last) = keys.last().filter(|k| k.frame + 1 < frames) {
        out.push(Stretch { from: last.frame, to: frames - 1, keys: [Some(*last), None] });
    }
    out
}
