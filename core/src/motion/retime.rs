//! A motion at another time: faster, longer, at another rate, backwards, there and back, eased, held on twos, or by keys that
//! say when which of its frames comes.
//!
//! Everything is one map from a frame of the result to a frame of the source; places between frames are read off a cubic.
//! Keys are joined by an easing each, or smoothly by a cubic that never runs backwards between keys that do not (Fritsch
//! and Carlson 1980).

use super::sampling::{Ends, split};
use super::{Easing, Motion};
use crate::error::{Error, Result};

/// The most frames of a result: some twelve hours.
const MOST_FRAMES: u64 = 1 << 20;

/// Which way it goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// As it was.
    #[default]
    Forward,
    /// From its end to its beginning.
    Backward,
    /// To its end and back; neither end comes twice in a row, so that it may be repeated.
    ThereAndBack,
}

/// At a frame of the result, a frame of the source comes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TimeKey {
    /// The frame of the result, from 0.
    pub at: f64,
    /// The frame of the source.
    pub frame: f64,
    /// How time passes from here to the next key.
    #[serde(default)]
    pub easing: Easing,
}

/// How a motion is given another time.
#[derive(Clone, Debug, PartialEq)]
pub struct Retime {
    /// How many times as fast.
    pub speed: f64,
    /// Seconds in all, in place of a speed.
    pub seconds: Option<f64>,
    /// Frames a second; the time it takes stays. `None` for the motion's own.
    pub fps: Option<f64>,
    /// How time passes over the whole.
    pub easing: Easing,
    /// Which way it goes.
    pub direction: Direction,
    /// Each picture stands for so many frames: 2 is on twos.
    pub hold: usize,
    /// When what comes; in place of speed, seconds and easing. The result ends with the last of them.
    pub keys: Vec<TimeKey>,
    /// Whether speed changes without jumps from key to key, in place of the keys' easings.
    pub smooth: bool,
    /// Whether the motion is a loop: its first frame comes after its last, and the result is a loop too.
    pub closed: bool,
}

impl Default for Retime {
    fn default() -> Self {
        Self {
            speed: 1.0,
            seconds: None,
            fps: None,
            easing: Easing::Linear,
            direction: Direction::Forward,
            hold: 1,
            keys: Vec::new(),
            smooth: false,
            closed: false,
        }
    }
}

/// Which frame of its source each frame of a result is.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// For each frame of the result the place in the source, in frames from 0; it may lie between two.
    pub places: Vec<f64>,
    /// Frames a second of the result.
    pub fps: f64,
    /// Whether the source's first frame comes after its last.
    pub closed: bool,
}

impl Course {
    /// For each frame of the result the source's frame before it, the one after it, and the share of the way between them.
    /// There are `frames` in the source, one at least.
    pub(crate) fn between(&self, frames: usize) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let count = frames as i64;
        let there = move |f: i64| if self.closed { f.rem_euclid(count) } else { f.clamp(0, count - 1) } as usize;
        self.places.iter().map(move |place| {
            let (frame, share) = split(*place);
            (there(frame), there(frame + 1), share)
        })
    }
}

impl Retime {
    /// Which frame of something that takes `frames` at `fps` comes when.
    ///
    /// # Errors
    /// No frames, a speed, a time or a rate that is not above 0, no frames to hold, keys that are no numbers or not in order,
    /// or lie outside the source; more than a million frames.
    pub fn course(&self, frames: usize, fps: f64) -> Result<Course> {
        if frames == 0 {
            return Err(Error::invalid("what is given another time", "has no frame", "give it one at least"));
        }
        let to_fps = self.fps.unwrap_or(fps);
        for (value, what) in
            [(self.speed, "speed"), (self.seconds.unwrap_or(1.0), "time"), (to_fps, "fps"), (fps, "the source's fps")]
        {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::invalid(format!("{what} of the motion"), format!("is {value}"), "give one above 0"));
            }
        }
        if self.hold == 0 {
            return Err(Error::invalid("frames that a picture stands", "are 0", "give 1, or 2 for on twos"));
        }
        let count = frames as f64;
        // Steps from the first frame to the last; a loop has one more, back to the first.
        let steps = if self.closed { count } else { count - 1.0 };
        let places = if self.keys.is_empty() {
            let seconds = self.seconds.unwrap_or(count / fps / self.speed);
            // So many frames fill the time; the last of an open motion is its last frame.
            let wished = seconds * to_fps;
            room(wished)?;
            let made = if self.closed || self.seconds.is_some() || self.fps.is_some() {
                (wished.round() as usize).max(1)
            } else {
                // By a plain factor, every so many frames: a whole one keeps frames as they are.
                (steps / self.speed + 1e-9).floor() as usize + 1
            };
            let whole = if self.closed { made as f64 } else { (made - 1) as f64 };
            let plain = !self.closed && self.seconds.is_none() && self.fps.is_none() && self.easing == Easing::Linear;
            let at = |k: usize| match whole {
                _ if plain => (k as f64 * self.speed).min(steps),
                0.0 => 0.0,
                whole => self.easing.share(k as f64 / whole) * steps,
            };
            (0..made).map(at).collect()
        } else {
            keyed(self, steps)?
        };
        let places: Vec<f64> = match self.direction {
            Direction::Forward => places,
            // A loop keeps its first frame, so that backwards twice is forwards.
            Direction::Backward if self.closed => places.iter().map(|t| (steps - t) % steps).collect(),
            Direction::Backward => places.into_iter().rev().collect(),
            Direction::ThereAndBack => {
                let back = if self.closed { 1..places.len() } else { 1..places.len().saturating_sub(1).max(1) };
                places.iter().copied().chain(places[back].iter().rev().copied()).collect()
            }
        };
        let places = (0..places.len()).map(|k| places[k - k % self.hold]).collect();
        Ok(Course { places, fps: to_fps, closed: self.closed })
    }
}

/// Gives `motion` another time.
///
/// # Errors
/// What [`Retime::course`] refuses; a result of more than a motion can hold.
pub fn retime(motion: &Motion, how: &Retime) -> Result<Motion> {
    motion.checked(1)?;
    let course = how.course(motion.frames, motion.fps)?;
    super::edit::check_points(motion, course.places.len())?;
    Ok(motion.at_times(&course.places, if how.closed { Ends::Closed } else { Ends::Open }, course.fps))
}

/// Checks that a result may have so many frames.
fn room(frames: f64) -> Result<()> {
    if frames <= MOST_FRAMES as f64 {
        return Ok(());
    }
    let (what, remedy) = ("the number of frames".to_owned(), "ask for fewer".to_owned());
    Err(Error::Limit { what, value: frames as u64, max: MOST_FRAMES, remedy })
}

/// The source's frame for each frame of the result, by keys.
fn keyed(how: &Retime, steps: f64) -> Result<Vec<f64>> {
    let keys = &how.keys;
    let wrong = |i: usize, problem: String, remedy: &str| Err(Error::invalid(format!("time key {i}"), problem, remedy));
    for (i, key) in keys.iter().enumerate() {
        if !(key.at >= 0.0 && key.at.is_finite() && (0.0..=steps).contains(&key.frame)) {
            let problem = format!("puts frame {} at frame {}", key.frame, key.at);
            return wrong(
                i,
                problem,
                &format!("frames of the motion are 0 to {steps}, those of the result count from 0"),
            );
        }
        if i > 0 && key.at <= keys[i - 1].at {
            return wrong(i, format!("is at {} and the one before at {}", key.at, keys[i - 1].at), "put keys in order");
        }
    }
    let end = keys[keys.len() - 1].at;
    room(end)?;
    let slopes = monotone_slopes(keys);
    let at = |k: usize| {
        let t = k as f64;
        let next = keys.partition_point(|key| key.at <= t);
        let (Some(from), Some(to)) = (next.checked_sub(1).map(|i| keys[i]), keys.get(next)) else {
            return keys[next.saturating_sub(1)].frame;
        };
        let span = to.at - from.at;
        let u = (t - from.at) / span;
        if !how.smooth {
            return from.frame + (to.frame - from.frame) * from.easing.share(u);
        }
        let (a, b) = (slopes[next - 1] * span, slopes[next] * span);
        let way = to.frame - from.frame;
        from.frame + u * (a + u * (3.0 * way - 2.0 * a - b + u * (a + b - 2.0 * way)))
    };
    // A loop's last key is its first again.
    let frames = if how.closed { end.round().max(1.0) as usize } else { end.floor() as usize + 1 };
    Ok((0..frames).map(at).collect())
}

/// Slopes at keys for cubics between them that rise and fall where the keys do.
fn monotone_slopes(keys: &[TimeKey]) -> Vec<f64> {
    let secants: Vec<f64> = keys.windows(2).map(|k| (k[1].frame - k[0].frame) / (k[1].at - k[0].at)).collect();
    (0..keys.len())
        .map(|i| match (i.checked_sub(1).map(|j| secants[j]), secants.get(i)) {
            (Some(before), Some(&after)) if before * after <= 0.0 => 0.0,
            // The harmonic mean keeps within three times either secant.
            (Some(before), Some(&after)) => 2.0 * before * after / (before + after),
            (Some(only), None) => only,
            (None, Some(&only)) => only,
            (None, None) => 0.0,
        })
        .collect()
}
