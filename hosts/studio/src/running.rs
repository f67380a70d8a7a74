//! A job while it runs: how far it is, how long it will take, and how it ended.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use eframe::egui::{Align, Label, Layout, ProgressBar, RichText, Ui, vec2};
use marey_binding::{Error, Job, JobState, Status};

use crate::texts;
use crate::theme::Palette;

/// Before so much is done, nothing can be said of the rest.
const KNOWN: (Duration, f64) = (Duration::from_millis(700), 0.03);

/// What is over within so long is not worth a bar that comes and goes.
const SHORT: Duration = Duration::from_millis(400);

/// A step that the machine fills in, of a character or a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Finding points to mark, because a person asked for it.
    Propose,
    /// Following the marked points.
    Points,
    /// Laying what moves on the drawing.
    Bind,
    /// The same again, because a person asked for it.
    Rebind,
    /// The drawing as it is.
    Still,
    /// A character of a picture.
    Character,
    /// What was made, in motion.
    Move,
}

impl Step {
    /// Whether a person asked for it, and it goes on whatever can be filled in meanwhile.
    pub(crate) fn is_asked_for(self) -> bool {
        matches!(self, Self::Propose | Self::Rebind)
    }
}

/// What a job is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A creature of the session.
    Creature,
    /// The session's limbs, after a correction.
    Track,
    /// A step of another door.
    Step(Step),
    /// A file; of pictures, or of other things.
    Export { path: PathBuf, pictures: bool },
}

#[derive(Debug)]
pub(crate) struct Running {
    pub(crate) job: Job,
    pub(crate) purpose: Purpose,
    began: Instant,
    state: JobState,
    /// A person asked it to stop.
    pub(crate) cancelled: bool,
    /// Nothing wants it any more.
    pub(crate) given_up: bool,
}

/// How a job ended.
#[derive(Debug)]
pub(crate) enum Ended {
    Done,
    Cancelled,
    Failed(Error),
}

impl Running {
    pub(crate) fn new(job: Job, purpose: Purpose) -> Self {
        let state = JobState { ended: false, fraction: 0.0, stage: String::new(), stage_fraction: 0.0, revision: 0 };
        Self { job, purpose, began: Instant::now(), state, cancelled: false, given_up: false }
    }

    /// Looks how it is; gives its end.
    pub(crate) fn poll(&mut self) -> Option<Ended> {
        match self.job.poll() {
            Ok(state) => self.state = state,
            Err(e) => return Some(Ended::Failed(e)),
        }
        if !self.state.ended {
            return None;
        }
        Some(match self.job.wait(Some(Duration::ZERO)) {
            Ok(_) => Ended::Done,
            Err(e) if e.status() == Status::Cancelled => Ended::Cancelled,
            Err(e) => Ended::Failed(e),
        })
    }

    /// Asks it to stop.
    pub(crate) fn cancel(&mut self) {
        self.cancelled = true;
        // What has ended meanwhile needs no cancel.
        let _ = self.job.cancel();
    }

    /// Whether it takes so long that a person should be told.
    pub(crate) fn is_long(&self) -> bool {
        matches!(self.purpose, Purpose::Export { .. }) || self.began.elapsed() > SHORT
    }

    /// Stops it, of which a person need not hear.
    pub(crate) fn give_up(&mut self) {
        self.given_up = true;
        let _ = self.job.cancel();
    }

    /// How far it is, and a button that stops it.
    pub(crate) fn show(&mut self, ui: &mut Ui, frames: u64) {
        let palette = Palette::of(ui);
        ui.horizontal(|ui| {
            let what = match &self.purpose {
                Purpose::Creature => texts::MAKING,
                Purpose::Track => texts::TRACKING,
                Purpose::Export { .. } => texts::EXPORTING,
                Purpose::Step(step) => texts::step(*step),
            };
            ui.label(RichText::new(what).strong());
            let line = self.text(frames);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button(texts::CANCEL).clicked() {
                    self.cancel();
                }
                // As wide as its longest text, so that the bar does not jump.
                ui.allocate_ui_with_layout(vec2(330.0, 24.0), Layout::left_to_right(Align::Center), |ui| {
                    ui.set_min_width(330.0);
                    ui.add(Label::new(RichText::new(line).color(palette.weak)).truncate());
                });
                let (wide, fill) = (ui.available_width(), palette.accent);
                let bar =
                    ProgressBar::new(self.state.fraction as f32).desired_height(8.0).desired_width(wide).fill(fill);
                ui.add(bar).accessible_name(what);
            });
        });
    }

    /// Its line for a person.
    fn text(&self, frames: u64) -> String {
        if self.cancelled {
            return texts::STOPPING.into();
        }
        let fraction = self.state.fraction;
        let done = match &self.purpose {
            Purpose::Export { pictures: false, .. } => texts::percent(fraction),
            Purpose::Step(step) if *step != Step::Points => texts::percent(fraction),
            // Each stage goes over the clip's frames.
            _ => texts::frame_of((self.state.stage_fraction * frames as f64) as u64, frames),
        };
        texts::progress(texts::stage(&self.state.stage), &done, left(self.began.elapsed(), fraction))
    }
}

/// How long it will still take, when as much time goes into the rest as went into what is done.
fn left(spent: Duration, fraction: f64) -> Option<Duration> {
    let known = spent >= KNOWN.0 && fraction >= KNOWN.1 && fraction <= 1.0;
    known.then(|| spent.mul_f64((1.0 - fraction) / fraction))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_that_is_left_is_said_once_it_is_known() {
        assert_eq!(left(Duration::from_secs(3), 0.25), Some(Duration::from_secs(9)));
        assert_eq!(left(Duration::from_secs(3), 0.0), None);
        assert_eq!(left(Duration::from_millis(20), 0.5), None);
        assert_eq!(left(Duration::from_secs(3), 1.0), Some(Duration::ZERO));
    }
}
