//! The frame that is shown, and its course while it plays.

use marey_binding::Context;

use crate::shortcuts::Command;
use crate::timing::Timing;

/// What is shown of what plays, as an export needs to know it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Played {
    /// The frame that is shown.
    pub(crate) frame: u64,
    /// How many frames play.
    pub(crate) frames: u64,
    pub(crate) fps: f64,
    pub(crate) timing: Timing,
}

/// Frames against the window's clock.
#[derive(Clone, Debug)]
pub(crate) struct Playback {
    frames: u64,
    fps: f64,
    frame: u64,
    /// The time and the place in the course it began to play at.
    since: Option<(f64, usize)>,
    pub(crate) looped: bool,
    timing: Timing,
    /// The frames in the order in which they play, never none.
    course: Vec<u64>,
}

impl Playback {
    /// `fps` beyond reason is taken for 24.
    pub(crate) fn new(frames: u64, fps: f64, looped: bool) -> Self {
        let fps = if fps.is_finite() && fps > 0.1 { fps } else { 24.0 };
        let course = (0..frames.max(1)).collect();
        Self { frames, fps, frame: 0, since: None, looped, timing: Timing::default(), course }
    }

    /// Plays by that timing from here on.
    pub(crate) fn take(&mut self, timing: Timing, context: &Context) {
        if timing == self.timing {
            return;
        }
        self.timing = timing;
        let places = timing.options().and_then(|how| context.retimed_places(self.frames, self.fps, &how).ok());
        self.course = match places {
            // The frame that is nearest.
            Some(places) if !places.is_empty() => places.iter().map(|p| (p.round() as u64).min(self.last())).collect(),
            _ => (0..self.frames.max(1)).collect(),
        };
        // It goes on from what is shown.
        self.since = self.since.map(|(began, _)| (began, self.place()));
    }

    pub(crate) fn played(&self) -> Played {
        Played { frame: self.frame, frames: self.course.len() as u64, fps: self.fps, timing: self.timing }
    }

    /// Where in its course the shown frame comes first, or one near to it.
    fn place(&self) -> usize {
        let far = |place: &usize| self.course[*place].abs_diff(self.frame);
        (0..self.course.len()).min_by_key(far).unwrap_or(0)
    }

    pub(crate) fn frame(&self) -> u64 {
        self.frame
    }

    pub(crate) fn last(&self) -> u64 {
        self.frames.saturating_sub(1)
    }

    pub(crate) fn fps(&self) -> f64 {
        self.fps
    }

    pub(crate) fn playing(&self) -> bool {
        self.since.is_some()
    }

    /// `now` in seconds.
    pub(crate) fn toggle(&mut self, now: f64) {
        self.since = match self.since {
            Some(_) => None,
            None if self.frames < 2 => None,
            None => {
                let place = self.place();
                // At the end there is nothing left to play.
                let ended = self.course[place] == self.course[self.course.len() - 1] && !self.looped;
                Some((now, if ended { 0 } else { place }))
            }
        };
    }

    pub(crate) fn stop(&mut self) {
        self.since = None;
    }

    /// Shows a frame, and goes on from it while it plays.
    pub(crate) fn seek(&mut self, frame: u64, now: f64) {
        self.frame = frame.min(self.last());
        if self.since.is_some() {
            self.since = Some((now, self.place()));
        }
    }

    /// Does a command that is about what is shown, over a document with these key frames; false for another.
    pub(crate) fn command(&mut self, command: Command, keys: &[u64], now: f64) -> bool {
        let (frame, last) = (self.frame, self.last());
        let to = match command {
            Command::Play => {
                self.toggle(now);
                None
            }
            Command::Loop => {
                self.looped ^= true;
                None
            }
            Command::NextFrame => Some(if frame == last { 0 } else { frame + 1 }),
            Command::PreviousFrame => Some(frame.checked_sub(1).unwrap_or(last)),
            Command::FirstFrame => Some(0),
            Command::LastFrame => Some(last),
            Command::NextKey => keys.iter().find(|k| **k > frame).or(keys.first()).copied(),
            Command::PreviousKey => keys.iter().rev().find(|k| **k < frame).or(keys.last()).copied(),
            _ => return false,
        };
        if let Some(to) = to {
            self.seek(to, now);
        }
        true
    }

    /// The frame for this moment.
    pub(crate) fn advance(&mut self, now: f64) {
        let Some((began, from)) = self.since else { return };
        let (at, count) = (from + ((now - began).max(0.0) * self.fps) as usize, self.course.len());
        if at < count || self.looped {
            self.frame = self.course[at % count];
        } else {
            self.frame = self.course[count - 1];
            self.since = None;
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;

    #[test]
    fn it_loops_or_ends() {
        let mut play = Playback::new(10, 5.0, true);
        play.seek(8, 0.0);
        play.toggle(100.0);
        let frames: Vec<u64> = (0..5)
            .map(|i| {
                play.advance(100.0 + 0.21 * f64::from(i));
                play.frame()
            })
            .collect();
        assert_eq!(frames, [8, 9, 0, 1, 2]);
        play.looped = false;
        play.seek(8, 200.0);
        play.advance(203.0);
        assert_eq!((play.frame(), play.playing()), (9, false));
        play.toggle(300.0);
        play.advance(300.3);
        assert_eq!((play.frame(), play.playing()), (1, true), "begins again from its end");
        play.seek(99, 301.0);
        assert_eq!(play.frame(), 9);
    }

    #[test]
    fn it_goes_its_course() {
        let context = Context::new(1).unwrap();
        let shown = |timing: &str, from: u64, count: usize| -> Vec<u64> {
            let mut play = Playback::new(10, 10.0, true);
            play.take(serde_json::from_str(timing).unwrap(), &context);
            play.seek(from, 0.0);
            play.toggle(0.0);
            let at = |i| {
                play.advance(0.05 + 0.1 * f64::from(i));
                play.frame()
            };
            (0..count as i32).map(at).collect()
        };
        assert_eq!(shown(r#"{"held": 2}"#, 0, 12), [0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 0, 0]);
        assert_eq!(shown(r#"{"way": "there-and-back"}"#, 7, 6), [7, 8, 9, 8, 7, 6]);
        assert_eq!(shown(r#"{"percent": 50}"#, 3, 4), [3, 3, 4, 4], "twice as long");
        let eased = shown(r#"{"pace": "slow-ends"}"#, 0, 10);
        assert_eq!((eased[0], eased[1], eased[9]), (0, 0, 9), "{eased:?}");
    }

    #[test]
    fn still_pictures_and_strange_clips_do_not_play() {
        for frames in [0, 1] {
            let mut play = Playback::new(frames, f64::NAN, true);
            play.toggle(0.0);
            play.advance(5.0);
            assert_eq!((play.frame(), play.playing()), (0, false));
        }
    }
}
