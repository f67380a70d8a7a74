//! Numbered handles on a picture: points that are clicked, dragged and told apart by their numbers.

use eframe::egui::{
    Align2, Color32, CursorIcon, FontId, Key, Painter, PointerButton, Pos2, Response, Stroke, Ui, Vec2,
};

use crate::theme;
use crate::view::Placement;

/// A handle is taken hold of so near to it, in points of the screen.
const NEAR: f32 = 12.0;
/// What moves a handle less than this is a click: less than elsewhere, so that small corrections can be made.
const STIRRED: f32 = 2.5;
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

/// The handle that is held.
#[derive(Clone, Copy, Debug)]
struct Held {
    number: usize,
    /// Where it is now.
    at: (f32, f32),
    /// From the mouse to its middle, on the screen.
    grip: Vec2,
    /// Whether the mouse has moved so far that it is not a click.
    stirred: bool,
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hand(Option<Held>);

impl Hand {
    /// Drops what is held where it was.
    pub(crate) fn cancel(&mut self) -> bool {
        self.0.take().is_some_and(|held| held.stirred)
    }

    /// Where a handle is while it is held.
    pub(crate) fn place(&self, handle: &Handle) -> (f32, f32) {
        self.0.filter(|held| held.stirred && held.number == handle.number).map_or(handle.at, |held| held.at)
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
            chosen.or(in_reach().min_by(|a, b| far(a).total_cmp(&far(b))))
        };
        let (pressed, down, from, space) = ui.input(|i| {
            let button = PointerButton::Primary;
            let pointer = &i.pointer;
            (
                pointer.button_pressed(button),
                pointer.button_down(button),
                pointer.press_origin(),
                i.key_down(Key::Space),
            )
        });
        if pressed && response.is_pointer_button_down_on() && !space {
            let hold = |from: Pos2| {
                let handle = near(from)?;
                let grip = placed.to_screen(handle.at) - from;
                Some(Held { number: handle.number, at: handle.at, grip, stirred: false })
            };
            self.0 = from.and_then(hold);
        }
        if let (Some(held), Some(at), Some(from)) = (&mut self.0, response.interact_pointer_pos(), from) {
            held.stirred |= at.distance(from) > STIRRED;
            held.at = placed.to_picture(at + held.grip);
            ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
        } else if response.hover_pos().and_then(near).is_some() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        if !down && let Some(held) = self.0.take() {
            // Where the window did not see it let go of, nothing was done.
            let seen = ui.input(|i| i.pointer.button_released(PointerButton::Primary));
            return seen.then_some(if held.stirred {
                Done::Moved(held.number, held.at)
            } else {
                Done::Selected(held.number)
            });
        }
        let at = response.interact_pointer_pos().filter(|_| response.clicked_by(PointerButton::Primary))?;
        Some(near(at).map_or_else(|| Done::Clicked(placed.to_picture(at)), |handle| Done::Selected(handle.number)))
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
