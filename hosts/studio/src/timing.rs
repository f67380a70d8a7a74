//! The time that what was made takes: how long each picture stands, how it starts and ends, which way and how fast it goes. It
//! belongs to the session, and is played and exported.

use eframe::egui::{Grid, Popup, PopupCloseBehavior, Ui, vec2};
use marey_binding::RetimeOptions;
use serde::{Deserialize, Serialize};

use crate::{texts, widgets};

/// How time passes from the first frame to the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Pace {
    #[default]
    Even,
    SlowStart,
    SlowEnd,
    SlowEnds,
}

/// Which way it goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Way {
    #[default]
    Forward,
    Backward,
    ThereAndBack,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Timing {
    /// Each picture stands for so many frames: 2 is "on twos".
    held: u32,
    pace: Pace,
    way: Way,
    /// Of its own speed.
    percent: u32,
}

impl Default for Timing {
    fn default() -> Self {
        Self { held: 1, pace: Pace::Even, way: Way::Forward, percent: 100 }
    }
}

impl Timing {
    /// As the library calls it; none where nothing changes. What was read from a file is brought within what can be chosen.
    pub(crate) fn options(&self) -> Option<RetimeOptions<'static>> {
        (*self != Self::default()).then(|| RetimeOptions {
            direction: self.way as i32,
            easing: self.pace as i32,
            hold: self.held.clamp(1, 4),
            speed: f64::from(self.percent.clamp(25, 400)) / 100.0,
            ..RetimeOptions::default()
        })
    }

    /// What it is in a few words.
    fn words(&self) -> String {
        let others = [
            (self.pace != Pace::Even).then(|| texts::pace(self.pace)),
            (self.way != Way::Forward).then(|| texts::way(self.way)),
            (self.percent != 100).then(|| texts::speed(self.percent)),
        ];
        let others = others.into_iter().flatten();
        std::iter::once(texts::held(self.held)).chain(others).collect::<Vec<_>>().join(", ")
    }
}

/// A button that says what it is and opens what can be chosen; gives what was chosen.
pub(crate) fn menu(ui: &mut Ui, now: &Timing) -> Option<Timing> {
    let mut timing = *now;
    let words = now.words();
    let name = texts::timing_name(&words);
    let button = ui.button(words).on_hover_text(texts::TIMING_HINT).accessible_name(name);
    Popup::menu(&button).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        ui.spacing_mut().button_padding = vec2(8.0, 4.0);
        Grid::new("timing").num_columns(2).spacing([14.0, 8.0]).show(ui, |ui| {
            row(ui, texts::TIMING_PICTURES, &mut timing.held, &[1, 2, 3, 4].map(|n| (n, texts::held(n))));
            let paces = [Pace::Even, Pace::SlowStart, Pace::SlowEnd, Pace::SlowEnds];
            row(ui, texts::TIMING_PACE, &mut timing.pace, &paces.map(|pace| (pace, texts::pace(pace))));
            let ways = [Way::Forward, Way::Backward, Way::ThereAndBack];
            row(ui, texts::TIMING_WAY, &mut timing.way, &ways.map(|way| (way, texts::way(way))));
            let speeds = [25, 50, 100, 150, 200];
            row(ui, texts::TIMING_SPEED, &mut timing.percent, &speeds.map(|percent| (percent, texts::speed(percent))));
        });
        widgets::remark(ui, texts::TIMING_ABOUT);
    });
    (timing != *now).then_some(timing)
}

fn row<T: Copy + PartialEq>(ui: &mut Ui, name: &str, value: &mut T, choices: &[(T, String)]) {
    ui.label(name);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for (choice, text) in choices {
            ui.selectable_value(value, *choice, text);
        }
    });
    ui.end_row();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_what_differs_and_keeps_within_bounds() {
        assert_eq!((Timing::default().words(), Timing::default().options()), ("on ones".into(), None));
        let timing = Timing { held: 2, pace: Pace::SlowEnds, ..Timing::default() };
        assert_eq!(timing.words(), "on twos, slow ends");
        let read: Timing = serde_json::from_str("{\"held\": 0, \"percent\": 4000000000}").unwrap_or_default();
        let options = read.options().unwrap_or_default();
        assert_eq!((options.hold, options.speed), (1, 4.0));
    }
}
