//! The frame that is shown, and its course while it plays.

use crate::shortcuts::Command;

/// Frames against the window's clock.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Playback {
    frames: u64,
    fps: f64,
    frame: u64,
    /// The time and the frame it began to play at.
    since: Option<(f64, u64)>,
    pub(crate) looped: bool,
    /// While it plays, each picture is held for so many frames: 2 is "on twos".
    pub(crate) held: u64,
}

impl Playback {
    /// `fps` beyond reason is taken for 24.
    pub(crate) fn new(frames: u64, fps: f64, looped: bool) -> Self {
        let fps = if fps.is_finite() && fps > 0.1 { fps } else { 24.0 };
        Self { frames, fps, frame: 0, since: None, looped, held: 1 }
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
            // At the end there is nothing left to play.
            None if self.frame == self.last() && !self.looped => Some((now, 0)),
            None => Some((now, self.frame)),
        };
    }

    pub(crate) fn stop(&mut self) {
        self.since = None;
    }

    /// Shows a frame, and goes on from it while it plays.
    pub(crate) fn seek(&mut self, frame: u64, now: f64) {
        self.frame = frame.min(self.last());
        if self.since.is_some() {
            self.since = Some((now, self.frame));
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
        let passed = ((now - began).max(0.0) * self.fps) as u64;
        let at = from + passed - passed % self.held.max(1);
        if at <= self.last() {
            self.frame = at;
        } else if self.looped {
            self.frame = at % self.frames;
        } else {
            self.frame = self.last();
            self.since = None;
        }
    }
}

#[cfg(test)]
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
    fn pictures_are_held_on_twos() {
        let mut play = Playback::new(10, 10.0, true);
        play.held = 2;
        play.toggle(0.0);
        let shown: Vec<u64> = (0..12)
            .map(|i| {
                play.advance(0.05 + 0.1 * f64::from(i));
                play.frame()
            })
            .collect();
        assert_eq!(shown, [0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 0, 0]);
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
