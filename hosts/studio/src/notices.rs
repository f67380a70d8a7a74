//! What the program has to say: what went wrong, until it is closed; what was done, for a while.

use std::time::{Duration, Instant};

use eframe::egui::{Align2, Area, Context, Frame, Id, Label, Order, RichText, Stroke, Ui, vec2};

use crate::icons::Icon;
use crate::theme::{self, Palette};
use crate::{texts, widgets};

/// Long enough to read a line twice.
const SHOWN: Duration = Duration::from_secs(8);
/// More than these would cover the picture.
const MOST: usize = 3;

#[derive(Debug)]
struct Notice {
    text: String,
    /// What went wrong stays.
    until: Option<Instant>,
}

#[derive(Debug, Default)]
pub(crate) struct Notices(Vec<Notice>);

impl Notices {
    /// Something failed. The library's messages say what, where and what to do.
    pub(crate) fn failed(&mut self, message: impl std::fmt::Display) {
        self.add(message.to_string(), None);
    }

    /// Something was done.
    pub(crate) fn done(&mut self, message: String) {
        self.add(message, Some(Instant::now() + SHOWN));
    }

    /// Says what failed, and gives the rest on.
    pub(crate) fn check<T, E: std::fmt::Display>(&mut self, result: Result<T, E>) -> Option<T> {
        result.map_err(|e| self.failed(e)).ok()
    }

    fn add(&mut self, text: String, until: Option<Instant>) {
        self.0.retain(|n| n.text != text);
        self.0.push(Notice { text, until });
        if self.0.len() > MOST {
            self.0.remove(0);
        }
    }

    /// Every line that is shown.
    pub(crate) fn texts(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|n| n.text.as_str())
    }

    pub(crate) fn show(&mut self, ctx: &Context) {
        let now = Instant::now();
        self.0.retain(|n| n.until.is_none_or(|until| until > now));
        if let Some(next) = self.0.iter().filter_map(|n| n.until).min() {
            ctx.request_repaint_after(next - now);
        }
        if self.0.is_empty() {
            return;
        }
        let width = (ctx.content_rect().width() - 80.0).clamp(240.0, 620.0);
        Area::new(Id::unique("notices"))
            .order(Order::Foreground)
            .anchor(Align2::CENTER_BOTTOM, vec2(0.0, -160.0))
            .default_width(width)
            .show(ctx, |ui| {
                ui.set_width(width);
                let mut closed = None;
                for (i, notice) in self.0.iter().enumerate() {
                    if one(ui, notice) {
                        closed = Some(i);
                    }
                }
                if let Some(i) = closed {
                    self.0.remove(i);
                }
            });
    }
}

fn one(ui: &mut Ui, notice: &Notice) -> bool {
    let palette = Palette::of(ui);
    let (icon, color) = match notice.until {
        None => (Icon::Warning, palette.bad),
        Some(_) => (Icon::Check, palette.good),
    };
    let frame = Frame::new()
        .fill(palette.raised)
        .stroke(Stroke::new(1.0, color))
        .corner_radius(theme::RADIUS)
        .shadow(ui.visuals().popup_shadow)
        .inner_margin(theme::PAD);
    let close = frame.show(ui, |ui| {
        ui.horizontal(|ui| {
            icon.show(ui, 18.0, color);
            let room = ui.available_width() - 36.0;
            ui.allocate_ui(vec2(room, 0.0), |ui| {
                ui.set_width(room);
                ui.add(Label::new(RichText::new(&notice.text)).wrap());
            });
            widgets::icon_button(ui, Icon::Close, texts::CLOSE_NOTICE).clicked()
        })
        .inner
    });
    close.inner
}
