//! How a picture is looked at in its panel: zoom at the cursor, pan by Space or the middle button, fit; and what lies over
//! it in a corner.

use eframe::egui::{
    Color32, CursorIcon, Frame, Key, Margin, Painter, PointerButton, Pos2, Rect, Response, Ui, UiBuilder, Vec2, pos2,
    vec2,
};

use crate::shortcuts::Command;
use crate::theme::Palette;
use crate::view::{Placement, View};

/// All of a texture.
pub(crate) const WHOLE: Rect = Rect { min: pos2(0.0, 0.0), max: pos2(1.0, 1.0) };
/// By a key.
const ZOOM: f32 = 1.25;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Looking {
    view: View,
    /// Where the panel was, and how large what it shows.
    panel: Rect,
    size: Vec2,
    /// Space was held to pan with, so that letting it go does not play.
    panned: bool,
}

impl Default for Looking {
    fn default() -> Self {
        Self { view: View::default(), panel: Rect::NOTHING, size: Vec2::ZERO, panned: false }
    }
}

impl Looking {
    /// Zoom and pan; gives where a picture of this size lies.
    pub(crate) fn show(&mut self, ui: &Ui, response: &Response, size: Vec2) -> Placement {
        (self.panel, self.size) = (response.rect, size);
        if let Some(at) = response.hover_pos() {
            let (zoom, scroll, ctrl) =
                ui.input(|i| (i.zoom_delta(), i.smooth_scroll_delta(), i.modifiers.command || i.modifiers.ctrl));
            let by_wheel = if ctrl { 1.0 } else { (scroll.y / 240.0).exp2() };
            if zoom * by_wheel != 1.0 {
                self.view.zoom(self.panel, size, at, zoom * by_wheel);
            }
        }
        let space = ui.input(|i| i.key_down(Key::Space)) && !ui.ctx().text_edit_focused();
        if response.dragged_by(PointerButton::Middle) || (space && response.dragged_by(PointerButton::Primary)) {
            self.view.pan(self.panel, size, response.drag_delta());
            self.panned |= space;
            ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
        } else if space && response.hovered() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        self.placed()
    }

    /// Where the picture was shown last.
    pub(crate) fn placed(&self) -> Placement {
        self.view.place(self.panel, self.size)
    }

    /// Where a place of the picture is on the screen.
    pub(crate) fn on_screen(&self, at: (f32, f32)) -> Pos2 {
        self.placed().to_screen(at)
    }

    pub(crate) fn fit(&mut self) {
        self.view.fit();
    }

    /// Does what a key asked for; false for what is not about looking.
    pub(crate) fn command(&mut self, command: Command) -> bool {
        let by = match command {
            Command::Fit => {
                self.view.fit();
                return true;
            }
            Command::ZoomIn => ZOOM,
            Command::ZoomOut => 1.0 / ZOOM,
            _ => return false,
        };
        self.view.zoom(self.panel, self.size, self.panel.center(), by);
        true
    }

    /// Whether Space, let go now, was held to pan; asked once for each time it is let go.
    pub(crate) fn space_was_to_pan(&mut self) -> bool {
        std::mem::take(&mut self.panned)
    }
}

/// What is shown, by words in a corner; gives where they lie.
pub(crate) fn toolbar(ui: &mut Ui, panel: Rect, spacing: f32, show: impl FnOnce(&mut Ui)) -> Rect {
    let palette = Palette::of(ui);
    let at = Rect::from_min_size(panel.min + vec2(10.0, 10.0), vec2(panel.width() - 20.0, 36.0));
    let tools = ui.scope_builder(UiBuilder::new().max_rect(at), |ui| {
        let frame = Frame::new()
            .fill(palette.panel.gamma_multiply(0.92))
            .corner_radius(8)
            .inner_margin(Margin::symmetric(6, 3));
        frame.show(ui, |ui| {
            // A narrow panel has two lines of them.
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing.x = spacing;
                show(ui);
            });
        })
    });
    tools.inner.response.rect
}

/// What is see-through: squares of two shades.
pub(crate) fn checkers(painter: &Painter, at: Rect, dark: bool) {
    const SIDE: f32 = 10.0;
    // Neither what is black nor what is white is lost on them.
    let shades = if dark { [84, 98] } else { [214, 232] };
    let seen = at.intersect(painter.clip_rect());
    let painter = painter.with_clip_rect(seen);
    painter.rect_filled(at, 0.0, Color32::from_gray(shades[0]));
    // Only what is seen: a picture that is looked at closely has a million squares.
    let square = |from: f32, to: f32| (from / SIDE).floor() as i32..(to / SIDE).ceil() as i32;
    let columns = square(seen.left() - at.left(), seen.right() - at.left());
    for y in square(seen.top() - at.top(), seen.bottom() - at.top()) {
        for x in columns.clone().filter(|x| (x + y) % 2 != 0) {
            let corner = at.min + vec2(x as f32, y as f32) * SIDE;
            painter.rect_filled(Rect::from_min_size(corner, vec2(SIDE, SIDE)), 0.0, Color32::from_gray(shades[1]));
        }
    }
}
