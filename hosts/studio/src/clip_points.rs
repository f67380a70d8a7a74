//! Points on a clip: as they were marked, else as they were followed, to be added, dragged and told apart by numbers.

use eframe::egui::{Align2, Color32, FontId, Role, Sense, Ui, WidgetInfo, vec2};

use crate::document::Document;
use crate::frames::Frames;
use crate::handles::{Done, Hand, Handle};
use crate::icons::Icon;
use crate::looking::{self, Looking, WHOLE};
use crate::marks::Mark;
use crate::shortcuts::Command;
use crate::theme::Palette;
use crate::workshop::Workshop;
use crate::{canvas, overlay, texts, widgets};

/// What a person asked for; points by their numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Asked {
    /// A click beside all points.
    Mark((f32, f32)),
    Move(usize, (f32, f32)),
    Select(Option<usize>),
}

pub(crate) struct ClipPoints {
    pub(crate) looking: Looking,
    hand: Hand,
    pub(crate) paths: bool,
}

impl Default for ClipPoints {
    fn default() -> Self {
        Self { looking: Looking::default(), hand: Hand::default(), paths: true }
    }
}

impl ClipPoints {
    /// Drops what is held; whether there was something.
    pub(crate) fn cancel(&mut self) -> bool {
        self.hand.cancel()
    }

    /// Shows the clip with its points, which have these numbers, and a line that says what to do. `tools` is drawn among
    /// those of the canvas.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        shop: &Workshop,
        (numbers, selected): (&[usize], Option<usize>),
        hint: Option<&str>,
        tools: impl FnOnce(&mut Ui),
    ) -> Option<Asked> {
        let palette = Palette::of(ui);
        let frame = shop.playback.frame();
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        painter.rect_filled(panel, 0.0, palette.canvas);
        let Some((_, info)) = &shop.document.clip else {
            painter.text(
                panel.center(),
                Align2::CENTER_CENTER,
                texts::NO_CLIP,
                FontId::proportional(15.0),
                palette.weak,
            );
            response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, texts::NO_CLIP));
            return None;
        };
        let name = texts::canvas_name(frame, info.frames);
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, &name));
        let size = vec2(info.width as f32, info.height as f32);
        let placed = self.looking.show(ui, &response, size);
        let picture = placed.picture(size);
        match shop.frames.as_ref().and_then(Frames::picture) {
            Some(texture) => {
                if shop.frames.as_ref().is_some_and(|frames| frames.see_through) {
                    looking::checkers(&painter, picture, ui.visuals().dark_mode);
                }
                painter.image(texture.id(), picture, WHOLE, Color32::WHITE);
            }
            None => drop(painter.rect_filled(picture, 0.0, palette.raised)),
        }
        if self.paths {
            overlay::paths(&painter, placed, &shop.document, frame, selected, numbers);
        }
        let handles = handles(&shop.document, frame, numbers);
        let done = self.hand.act(ui, &response, placed, (&handles, selected));
        self.hand.paint(&painter, placed, &handles, selected);
        looking::toolbar(ui, panel, 4.0, |ui| {
            if widgets::word_toggle(ui, texts::PATHS, self.paths, Command::Paths) {
                self.paths ^= true;
            }
            tools(ui);
            if widgets::command_button(ui, Icon::Fit, texts::FIT, Command::Fit) {
                self.looking.fit();
            }
        });
        if let Some(hint) = hint {
            canvas::hint(&painter, panel, hint);
        }
        done.map(|done| match done {
            Done::Clicked(at) if picture.contains(placed.to_screen(at)) => Asked::Mark(at),
            Done::Clicked(_) => Asked::Select(None),
            Done::Selected(point) => Asked::Select(Some(point)),
            Done::Moved(point, at) => Asked::Move(point, at),
        })
    }
}

/// The points in a frame of the clip: as they were marked, else as they were followed, else as marked elsewhere.
pub(crate) fn handles(document: &Document, frame: u64, numbers: &[usize]) -> Vec<Handle> {
    let of = |(point, mark): (usize, &Mark)| {
        let number = *numbers.get(point)?;
        if let Some(key) = mark.keys.iter().find(|k| k.frame == frame) {
            return Some(Handle { number, at: key.at, sure: 1.0, by_hand: true });
        }
        let tracked = document.tracked.as_ref().and_then(|t| t.limbs.get(point)?.get(frame as usize));
        match tracked {
            Some(at) => {
                let (at, sure) = (*at.points.first()?, *at.confidence.first()?);
                Some(Handle { number, at, sure, by_hand: false })
            }
            None => Some(Handle { number, at: mark.keys.first()?.at, sure: 0.0, by_hand: false }),
        }
    };
    document.marks.points.iter().enumerate().filter_map(of).collect()
}
