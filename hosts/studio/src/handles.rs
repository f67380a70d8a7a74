//! Numbered handles on a picture: points that are clicked, dragged and told apart by their numbers.

use eframe::egui::{Align2, Color32, CursorIcon, FontId, Painter, PointerButton, Pos2, Response, Stroke, Ui};

use crate::theme;
use crate::view::Placement;

/// A handle is taken hold of so near to it, in points of the screen.
const NEAR: f32 = 12.0;
const RADIUS: f32 = 9.0;

/// A place with the number that it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Handle {
    pub(crate) number: usize,
    /// In pixels of the picture.
    pub(crate) at: (f32, f32),
    /// How far it is trusted, 0..=1.
    pub(crate) sure: f32,
    /// Whether a person put it there.
    pub(crate) by_hand: bool,
}

/// What a person did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Done {
    /// Clicked beside all.
    Clicked((f32, f32)),
    Selected(usize),
    /// Let go of one that was moved.
    Moved(usize, (f32, f32)),
}

/// The handle that is held, and where it is now.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hand(Option<(usize, (f32, f32))>);

impl Hand {
    /// Drops what is held where it was.
    pub(crate) fn cancel(&mut self) -> bool {
        self.0.take().is_some()
    }

    /// Where a handle is while it is held.
    pub(crate) fn place(&self, handle: &Handle) -> (f32, f32) {
        self.0.filter(|held| held.0 == handle.number).map_or(handle.at, |held| held.1)
    }

    /// Of handles that lie on each other the `selected` one is taken hold of.
    pub(crate) fn act(
        &mut self,
        ui: &Ui,
        response: &Response,
        placed: Placement,
        (handles, selected): (&[Handle], Option<usize>),
    ) -> Option<Done> {
        let near = |at: Pos2| {
            let far = |h: &&Handle| placed.to_screen(h.at).distance(at);
            let in_reach = || handles.iter().filter(|h| far(h) <= NEAR);
            let chosen = in_reach().find(|h| Some(h.number) == selected);
            chosen.or(in_reach().min_by(|a, b| far(a).total_cmp(&far(b)))).map(|h| h.number)
        };
        if response.drag_started_by(PointerButton::Primary) && !ui.input(|i| i.key_down(eframe::egui::Key::Space)) {
            let from = ui.input(|i| i.pointer.press_origin());
            self.0 = from.and_then(|at| Some((near(at)?, placed.to_picture(at))));
        }
        if let (Some(held), Some(at)) = (&mut self.0, response.interact_pointer_pos()) {
            held.1 = placed.to_picture(at);
            ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
        } else if response.hover_pos().and_then(near).is_some() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        if response.drag_stopped_by(PointerButton::Primary) {
            return self.0.take().map(|(number, at)| Done::Moved(number, at));
        }
        if !response.dragged() {
            // The button was let go where the window did not see it.
            self.0 = None;
        }
        let at = response.interact_pointer_pos().filter(|_| response.clicked_by(PointerButton::Primary))?;
        Some(near(at).map_or_else(|| Done::Clicked(placed.to_picture(at)), Done::Selected))
    }

    pub(crate) fn paint(&self, painter: &Painter, placed: Placement, handles: &[Handle], selected: Option<usize>) {
        for handle in handles {
            let at = placed.to_screen(self.place(handle));
            let color = theme::limb(handle.number);
            let ring = if selected == Some(handle.number) {
                Stroke::new(3.0, Color32::WHITE)
            } else if handle.sure < 0.5 {
                Stroke::new(2.5, theme::trusted(color, handle.sure))
            } else {
                Stroke::new(1.5, Color32::from_black_alpha(200))
            };
            if handle.by_hand {
                painter.circle(at, RADIUS, color, ring);
            } else {
                painter.circle(at, RADIUS, color.gamma_multiply(0.72), ring);
            }
            let font = FontId::proportional(12.0);
            painter.text(at, Align2::CENTER_CENTER, handle.number + 1, font, Color32::from_rgb(16, 18, 22));
        }
    }
}
