//! A range of a motion closed into a loop whose seam does not show.
//!
//! What its two ends differ by is parted in three. The way of the whole is even over the loop, and kept or taken out. The
//! rest's value and speed at the seam, a line fitted through the frames that lie both before and after a period, is taken
//! up half by the first half of the loop and half by the second, with weights that begin and end without speed or
//! acceleration. What then remains, noise, is faded over as far as both ends' frames reach. So pose and speed agree at the
//! seam, and linear relations between points, such as a leg's place on a body, are kept. Where no range is given every frame
//! is tried that a cycle can begin at, and the one whose seam shows least is taken.
//!
//! Known limits: a limb whose two ends point far apart is shortened a little on the way between them; a camera that zooms
//! leaves a figure that grows and shrinks; light and texture are no part of a motion.

use glam::DVec2;

use super::sampling::Ends;
use super::{Motion, Track, TrackFrame};
use crate::error::{Error, Result};

/// How a loop is closed.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopParams {
    /// The frame it begins at, and how many frames until it begins again; `None` for the cycle that is found.
    pub range: Option<(f64, f64)>,
    /// Cycles in the loop, where the cycle is found: more keep more of what differs between strides.
    pub cycles: u32,
    /// Whether the whole stays in place; else it goes on by its way a loop.
    pub in_place: bool,
    /// Frames of the loop; `None` for as many as keep the pace best.
    pub frames: Option<usize>,
    /// Frames a second; `None` for the motion's own.
    pub fps: Option<f64>,
    /// The share of the loop over which the frames of both ends are faded, where there are any: 0..=1.
    pub fade: f64,
}

impl Default for LoopParams {
    /// A quarter of a stride is faded: longer fades mix strides that run apart, shorter ones show noise.
    fn default() -> Self {
        Self { range: None, cycles: 1, in_place: true, frames: None, fps: None, fade: 0.25 }
    }
}

/// What a seam adds to the motion, as shares of the figure's extent (see [`Motion::extent`]): what steps from frame to frame,
/// over the seam and wherever its two ends are faded, differ by from those that the source makes at the nearer end.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Seam {
    /// How far a step is from the source's, the mean over points, where it is most.
    pub pose: f64,
    /// The same of the point where it is most.
    pub pose_most: f64,
    /// How far the change of a step is from the source's, the mean over points, where it is most.
    pub speed: f64,
    /// The same of the point where it is most.
    pub speed_most: f64,
    /// How far a point goes from frame to frame of the loop, the mean over points and frames.
    pub usual_step: f64,
    /// How much a step differs from the one before, the mean over points and frames.
    pub usual_change: f64,
}

/// A motion that goes on from its last frame to its first.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedLoop {
    /// The loop; its first frame comes after its last.
    pub motion: Motion,
    /// The frame of the source that it begins at.
    pub start: f64,
    /// How many frames of the source it takes.
    pub period: f64,
    /// How far the whole went meanwhile, in pixels, in place or not.
    pub travel: DVec2,
    /// How the seam looks.
    pub seam: Seam,
}

/// Frames to begin at that are tried where none is given, and points that are placed for it: a second's work.
const MOST_STARTS: f64 = 256.0;
const MOST_WORK: f64 = (1 << 23) as f64;

/// Rises from 0 to 1 without speed or acceleration at either end.
pub(super) fn smoother_step(share: f64) -> f64 {
    let u = share.clamp(0.0, 1.0);
    u * u * u * (u * (6.0 * u - 15.0) + 10.0)
}

/// Closes a range of `motion` into a loop.
///
/// # Errors
/// No cycle, where no range is given; a range that the motion does not have; no cycles or frames; a rate or a fade out of
/// range.
pub fn close_loop(motion: &Motion, params: &LoopParams) -> Result<ClosedLoop> {
    motion.checked(3)?;
    let bad = |what: &str, problem: String, remedy: &str| Err(Error::invalid(what, problem, remedy));
    if !(0.0..=1.0).contains(&params.fade) {
        return bad("fade of the loop", format!("is {}", params.fade), "give a share of the loop, 0 to 1");
    }
    let fps = params.fps.unwrap_or(motion.fps);
    if !(fps > 0.0 && fps.is_finite()) {
        return bad("fps of the loop", format!("is {fps}"), "give frames a second, above 0");
    }
    let (starts, period) = match params.range {
        Some((start, period)) => (vec![start], period),
        None => {
            let period = super::find_cycle(motion)?.period * f64::from(params.cycles);
            let last = (motion.frames as f64 - 1.0 - period).max(0.0) as usize;
            let points: usize = motion.tracks.iter().map(|t| t.frames[0].points.len()).sum();
            let most = MOST_WORK / (points as f64 * params.frames.map_or(period, |f| f as f64)).max(1.0);
            ((0..=last).step_by(last / most.clamp(1.0, MOST_STARTS) as usize + 1).map(|f| f as f64).collect(), period)
        }
    };
    // A loop may end one frame after the last: the first frame then comes where the next would have been.
    if !starts.iter().all(|s| *s >= 0.0 && period >= 3.0 && s + period <= motion.frames as f64 + 1e-6) {
        let problem = format!("is of {period:.2} frames from frame {:.2}, of {} in all", starts[0], motion.frames);
        return bad("range of the loop", problem, "give one of 3 frames at least within the motion, or fewer cycles");
    }
    let count = params.frames.unwrap_or_else(|| (period * fps / motion.fps).round().max(3.0) as usize);
    if count < 3 {
        return bad("frames of the loop", format!("are {count}"), "give 3 at least");
    }
    super::edit::check_points(motion, count)?;
    let extent = motion.extent();
    let closed = |start: f64| {
        let closing = Closing::of(motion, start, period, params);
        let made = closing.closed(motion, count, fps);
        let seam = seam(motion, &closing, &made, extent);
        let bridged = closing.bridged() / extent;
        let cost = seam.pose + seam.speed + seam.pose_most + seam.speed_most + bridged;
        (cost, ClosedLoop { motion: made, start, period, travel: closing.travel, seam })
    };
    let best = starts.into_iter().map(closed).min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, made) = best.ok_or_else(|| Error::invalid("range of the loop", "is none", "give one"))?;
    made.motion.validate()?;
    Ok(made)
}

/// What the ends of a range differ by.
struct Closing {
    start: f64,
    period: f64,
    /// How far the fade reaches before and after the seam, in frames.
    fade: (f64, f64),
    /// The way of the whole in a period.
    travel: DVec2,
    /// The way of the whole a frame that is taken out.
    slope: DVec2,
    /// For each point of each track: what its ends differ by beyond the way, and how fast that changes.
    gaps: Vec<Vec<(DVec2, DVec2)>>,
}

impl Closing {
    fn of(motion: &Motion, start: f64, period: f64, params: &LoopParams) -> Self {
        let last = (motion.frames - 1) as f64;
        // How far before the start, and after the end, there are frames.
        let (before, after) = (start.min(period / 2.0), (last - start - period).clamp(0.0, period / 2.0));
        // A tenth of the loop on either side says what its ends differ by: there a line fits.
        let reach = (0.1 * period).max(2.0);
        let shared: Vec<f64> = (-(before.min(reach).floor() as i64)..=after.min(reach).floor() as i64)
            .map(|k| k as f64)
            .filter(|_| start + period <= last + 1e-6)
            .collect();
        let mut gaps: Vec<Vec<(DVec2, DVec2)>> =
            motion.tracks.iter().map(|track| gaps(track, start, period, &shared)).collect();
        let count: usize = gaps.iter().map(Vec::len).sum();
        let travel = gaps.iter().flatten().map(|g| g.0).sum::<DVec2>() / count as f64;
        gaps.iter_mut().flatten().for_each(|g| g.0 -= travel);
        let half = 0.5 * params.fade * period;
        let fade = if start + period <= last { (before.min(half), after.min(half)) } else { (0.0, 0.0) };
        let slope = if params.in_place { travel / period } else { DVec2::ZERO };
        Self { start, period, fade, travel, slope, gaps }
    }

    /// The loop.
    fn closed(&self, motion: &Motion, count: usize, fps: f64) -> Motion {
        let time = |k: usize| k as f64 * self.period / count as f64;
        let track = |(track, gaps): (&Track, &Vec<_>)| Track {
            name: track.name.clone(),
            kind: track.kind,
            frames: (0..count).map(|k| self.frame(track, gaps, time(k))).collect(),
        };
        let tracks = motion.tracks.iter().zip(&self.gaps).map(track).collect();
        Motion { size: motion.size, fps, frames: count, tracks, bones: motion.bones.clone() }
    }

    /// What has to be taken up, the mean over points in pixels.
    fn bridged(&self) -> f64 {
        let all = || self.gaps.iter().flatten();
        all().map(|g| g.0.length()).sum::<f64>() / all().count() as f64
    }

    /// The track `time` frames after the start, its share of the gaps taken up; `time` may lie a fade beyond the range.
    fn taken_up(&self, track: &Track, gaps: &[(DVec2, DVec2)], time: f64) -> Vec<DVec2> {
        let half = self.period / 2.0;
        let near = |from_seam: f64| 1.0 - smoother_step(from_seam / half);
        let (from, to) = (near(time), near(self.period - time));
        let later = time - self.period;
        let places = track.places_at(self.start + time, Ends::Open);
        let moved = places.into_iter().zip(gaps).map(|(p, (gap, change))| {
            p - self.slope * time + 0.5 * from * (*gap + *change * time) - 0.5 * to * (*gap + *change * later)
        });
        moved.collect()
    }

    fn frame(&self, track: &Track, gaps: &[(DVec2, DVec2)], time: f64) -> TrackFrame {
        let mut frame = track.at(self.start + time, Ends::Open);
        let (before, after) = self.fade;
        let mut places = self.taken_up(track, gaps, time);
        // Around the seam both ends are faded: here from the seam on, there before it.
        let onward = self.travel - self.slope * self.period;
        let mut fade = |other: f64, share: f64, shift: DVec2| {
            let there = track.at(self.start + other, Ends::Open);
            for ((place, q), (c, d)) in places
                .iter_mut()
                .zip(self.taken_up(track, gaps, other))
                .zip(frame.confidence.iter_mut().zip(&there.confidence))
            {
                *place = place.lerp(q + shift, share);
                *c = (*c as f64 + (f64::from(*d) - f64::from(*c)) * share) as f32;
            }
        };
        if time < after || (time == 0.0 && before > 0.0) {
            fade(time + self.period, 1.0 - smoother_step((time + before) / (before + after)), -onward);
        } else if time > self.period - before {
            let from_seam = time - self.period;
            fade(from_seam, smoother_step((from_seam + before) / (before + after)), onward);
        }
        // Only what is as it was drawn stays certain.
        for ((confidence, place), was) in frame.confidence.iter_mut().zip(&places).zip(&frame.points) {
            let moved = place.as_vec2().distance(*was);
            *confidence = if moved < 1e-3 { *confidence } else { confidence.min(0.99) };
        }
        frame.points = places.into_iter().map(|p| p.as_vec2()).collect();
        frame
    }
}

/// What the points of a track differ by a period apart, and how fast that changes, at the seam: by a line through the
/// frames that both ends have, or by the speeds at the two ends where they share too few.
fn gaps(track: &Track, start: f64, period: f64, shared: &[f64]) -> Vec<(DVec2, DVec2)> {
    let at = |t: f64| track.places_at(t, Ends::Open);
    let apart = |offset: f64| -> Vec<DVec2> {
        let (from, to) = (at(start + offset), at(start + period + offset));
        to.into_iter().zip(from).map(|(q, p)| q - p).collect()
    };
    if shared.len() < 4 {
        // Speeds by the parabola through five frames on the inner side of each end (Savitzky and Golay 1964).
        const FIRST: [f64; 5] = [-54.0 / 70.0, 13.0 / 70.0, 40.0 / 70.0, 27.0 / 70.0, -26.0 / 70.0];
        let speed = |from: f64, step: f64| -> Vec<DVec2> {
            let mut speed = vec![DVec2::ZERO; track.frames[0].points.len()];
            for (k, weight) in FIRST.iter().enumerate() {
                let places = at(from + step * k as f64);
                speed.iter_mut().zip(places).for_each(|(s, p)| *s += p * *weight * step);
            }
            speed
        };
        // The end may lie after the last frame, where places are led on to: its speed is the last frame's.
        let last = (start + period).min((track.frames.len() - 1) as f64);
        let (first, last) = (speed(start, 1.0), speed(last, -1.0));
        return apart(0.0).into_iter().zip(first.into_iter().zip(last)).map(|(gap, (a, b))| (gap, b - a)).collect();
    }
    let count = shared.len() as f64;
    let middle = shared.iter().sum::<f64>() / count;
    let spread: f64 = shared.iter().map(|t| (t - middle) * (t - middle)).sum();
    let mut fitted = vec![(DVec2::ZERO, DVec2::ZERO); track.frames[0].points.len()];
    for &offset in shared {
        for ((mean, change), gap) in fitted.iter_mut().zip(apart(offset)) {
            *mean += gap / count;
            *change += gap * ((offset - middle) / spread);
        }
    }
    fitted.iter_mut().for_each(|(gap, change)| *gap -= *change * middle);
    fitted
}

/// How the seam of a `made` loop looks.
fn seam(motion: &Motion, closing: &Closing, made: &Motion, extent: f64) -> Seam {
    let count = made.frames as i64;
    let onward = closing.travel - closing.slope * closing.period;
    let step = closing.period / count as f64;
    // Places of the loop, and of the source around either end, from two frames before the seam to one after.
    let of_loop = |f: i64| -> Vec<DVec2> {
        let shift = onward * f.div_euclid(count) as f64;
        let at = |t: &Track| {
            t.frames[f.rem_euclid(count) as usize].points.iter().map(move |p| p.as_dvec2() + shift).collect::<Vec<_>>()
        };
        made.tracks.iter().flat_map(at).collect()
    };
    let of_source = |end: f64, f: i64| -> Vec<DVec2> {
        let shift = closing.slope * step * f as f64;
        let at = |t: &Track| t.places_at(end + step * f as f64, Ends::Open);
        motion.tracks.iter().flat_map(at).map(|p| p - shift).collect()
    };
    // Steps into each frame of the fade and its neighbours.
    let [from, to] = [closing.fade.0, closing.fade.1].map(|reach| (reach / step).ceil() as i64 + 1);
    let steps = |at: &dyn Fn(i64) -> Vec<DVec2>| -> Vec<Vec<DVec2>> {
        let places: Vec<Vec<DVec2>> = (-from - 1..=to).map(at).collect();
        places.windows(2).map(|p| p[1].iter().zip(&p[0]).map(|(b, a)| *b - *a).collect()).collect()
    };
    let changes = |steps: &Vec<Vec<DVec2>>| -> Vec<Vec<DVec2>> {
        steps.windows(2).map(|s| s[1].iter().zip(&s[0]).map(|(b, a)| *b - *a).collect()).collect()
    };
    let own = steps(&of_loop);
    let last = (motion.frames - 1) as f64;
    let ends = [closing.start, closing.start + closing.period];
    let whole = |end: &f64| end - (from + 1) as f64 * step >= -1e-6 && end + to as f64 * step <= last + 1e-6;
    let looked_at = ends.into_iter().filter(whole);
    // Of a range without frames beyond either end, the end itself: the motion is led on there.
    let looked_at: Vec<f64> = looked_at.collect();
    let looked_at = if looked_at.is_empty() { vec![ends[1]] } else { looked_at };
    let theirs: Vec<Vec<Vec<DVec2>>> = looked_at.into_iter().map(|end| steps(&|f| of_source(end, f))).collect();
    // The mean and the most of what each point is off from the nearer of the source's, in the frame where that is most.
    let off = |own: &[Vec<DVec2>], theirs: &[Vec<Vec<DVec2>>]| -> (f64, f64) {
        let gap = |f: usize, i: usize| theirs.iter().map(|t| t[f][i].distance(own[f][i])).fold(f64::INFINITY, f64::min);
        let gaps = |f: usize| (0..own[f].len()).map(move |i| gap(f, i) / extent);
        (0..own.len()).fold((0.0, 0.0), |(mean, most): (f64, f64), f| {
            (mean.max(gaps(f).sum::<f64>() / own[f].len() as f64), most.max(gaps(f).fold(0.0, f64::max)))
        })
    };
    let (pose, pose_most) = off(&own, &theirs);
    let (speed, speed_most) = off(&changes(&own), &theirs.iter().map(changes).collect::<Vec<_>>());
    let mut out = Seam { pose, pose_most, speed, speed_most, usual_step: 0.0, usual_change: 0.0 };
    let points = own[0].len() as f64;
    let mut at = [of_loop(-2), of_loop(-1)];
    for f in 0..count {
        let now = of_loop(f);
        for ((a, b), c) in at[0].iter().zip(&at[1]).zip(&now) {
            out.usual_step += c.distance(*b) / (extent * points * count as f64);
            out.usual_change += (*c - 2.0 * *b + *a).length() / (extent * points * count as f64);
        }
        at = [std::mem::take(&mut at[1]), now];
    }
    out
}
