//! The drawing that lives, as it was drawn with its numbers, or in motion.

use eframe::egui::{Color32, FontId, Rect, Role, Sense, Stroke, Ui, UiBuilder, WidgetInfo, vec2};
use marey_binding::{BoundPoint, Part};

use crate::around::Around;
use crate::drawing_door::{DrawingDoor, LEAST};
use crate::handles::{Done, Handle};
use crate::icons::Icon;
use crate::looking::{self, WHOLE};
use crate::picker::Ask;
use crate::shortcuts::Command;
use crate::theme::{self, Palette};
use crate::{canvas, texts, widgets};

impl DrawingDoor {
    /// The same points on the drawing, as it was drawn.
    pub(crate) fn sheet_handles(&self) -> Vec<Handle> {
        let Some(held) = &self.held else { return Vec::new() };
        let said = self.shop.document.part(Part::Binding).is_some();
        let number = |track: &str| self.shop.document.marks.points.iter().position(|p| p.name == track);
        let of = |p: &BoundPoint| Some(Handle { number: number(&p.track)?, at: p.at, sure: 1.0, by_hand: said });
        held.points.iter().filter_map(of).collect()
    }

    pub(crate) fn show_sheet(&mut self, ui: &mut Ui, frame: u64, around: &mut Around) {
        let palette = Palette::of(ui);
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        painter.rect_filled(panel, 0.0, palette.canvas);
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, texts::SHEET_NAME));
        let Some(size) = self.sheet.as_ref().map(|sheet| sheet.size) else {
            painter.vline(panel.left(), panel.y_range(), Stroke::new(1.0, palette.outline));
            let middle = Rect::from_center_size(panel.center(), vec2(panel.width() - 60.0, 120.0));
            ui.scope_builder(UiBuilder::new().max_rect(middle), |ui| {
                ui.vertical_centered(|ui| {
                    widgets::remark(ui, texts::NO_DRAWING);
                    ui.add_space(theme::GAP);
                    if widgets::primary_button(ui, texts::CHOOSE_A_DRAWING).clicked() {
                        around.picker.ask(ui.ctx(), Ask::Drawing);
                    }
                });
            });
            return;
        };
        let placed = self.sheet_looking.show(ui, &response, size);
        let paper = placed.picture(size);
        painter.rect_filled(paper, 2.0, Color32::WHITE);
        let editing = self.numbers && !self.shop.playback.playing();
        let scale = placed.scale * ui.pixels_per_point();
        let shown = match (&self.shop.moving, &self.still) {
            (Some(moving), _) if !editing => {
                self.shop.pictures.update(ui.ctx(), moving, frame, scale);
                Some(&self.shop.pictures)
            }
            (_, Some(still)) => {
                self.still_pictures.update(ui.ctx(), still, 0, scale);
                Some(&self.still_pictures)
            }
            _ => None,
        };
        if let Some(pictures) = shown {
            if let Some(texture) = pictures.picture() {
                let (low, high) = (pictures.area.min, pictures.area.max);
                let at = Rect::from_min_max(placed.to_screen((low.x, low.y)), placed.to_screen((high.x, high.y)));
                // What leaves the paper is drawn on what lies behind, which is as light.
                painter.rect_filled(at.intersect(panel), 2.0, Color32::WHITE);
                painter.image(texture.id(), at, WHOLE, Color32::WHITE);
            }
            if let Some(failed) = &pictures.failed {
                let font = FontId::proportional(14.0);
                let galley = painter.layout(failed.clone(), font, palette.bad, panel.width() - 40.0);
                painter.galley(panel.min + vec2(20.0, 60.0), galley, palette.bad);
            }
        }
        let handles = if editing { self.sheet_handles() } else { Vec::new() };
        let done = self.sheet_hand.act(ui, &response, placed, (&handles, self.selected));
        self.sheet_hand.paint(&painter, placed, &handles, self.selected);
        painter.vline(panel.left(), panel.y_range(), Stroke::new(1.0, palette.outline));
        looking::toolbar(ui, panel, 4.0, |ui| {
            if widgets::word_toggle(ui, texts::NUMBERS, self.numbers, Command::Tracks) {
                self.numbers ^= true;
            }
            if widgets::command_button(ui, Icon::Fit, texts::FIT_DRAWING, Command::Fit) {
                self.sheet_looking.fit();
            }
        });
        if self.held.is_none() && self.shop.document.marks.points.len() < LEAST {
            canvas::hint(&painter, panel, texts::MARK_FIRST);
        }
        match done {
            Some(Done::Moved(point, at)) => {
                self.selected = Some(point);
                let track = self.shop.document.marks.points[point].name.clone();
                self.change_held(texts::EDIT_HANDLE, around, |binding, _| binding.set_point("", &track, 0, at, ""));
            }
            Some(Done::Selected(point)) => self.selected = Some(point),
            Some(Done::Clicked(_)) => self.selected = None,
            None => {}
        }
    }
}
