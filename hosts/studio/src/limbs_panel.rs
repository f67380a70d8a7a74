//! The limbs in a list: named, told apart, drawn, taken away.

use eframe::egui::{
    Align, Button, ComboBox, Frame, Key, Layout, Margin, ScrollArea, Sense, Stroke, TextEdit, Ui, vec2,
};
use marey_binding::{Facing, Side};

use crate::document::Document;
use crate::icons::Icon;
use crate::overlaps::{self, Overlap};
use crate::shortcuts::Command;
use crate::theme::{self, Palette};
use crate::{texts, widgets};

/// What a person asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Asked {
    /// To draw this one next; none for a new one.
    Select(Option<usize>),
    Name(usize, String),
    Side(usize, Side),
    Facing(usize, Facing),
    RemoveStroke(usize),
    /// In front of another, or behind it.
    Order {
        limb: usize,
        before: bool,
        other: usize,
    },
    RemoveLimb(usize),
}

/// A name that is being typed: whose, what, and what it was.
#[derive(Debug, Default)]
pub(crate) struct LimbsPanel {
    typed: Option<(usize, String)>,
}

const SIDES: [(Side, &str); 4] = [
    (Side::Unknown, texts::SIDE_UNKNOWN),
    (Side::Near, texts::SIDE_NEAR),
    (Side::Far, texts::SIDE_FAR),
    (Side::Mid, texts::SIDE_MID),
];

impl LimbsPanel {
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        document: &Document,
        (frame, overlaps): (u64, &[Overlap]),
        selected: Option<usize>,
    ) -> Vec<Asked> {
        let mut asked = Vec::new();
        ui.horizontal(|ui| {
            widgets::section(ui, &texts::limbs(document.limbs.len()));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if widgets::command_button(ui, Icon::Plus, texts::NEW_LIMB, Command::NewLimb) {
                    asked.push(Asked::Select(None));
                }
            });
        });
        if document.limbs.is_empty() {
            widgets::remark(ui, texts::NO_LIMBS);
        }
        // The longest of what is below, so that the list does not jump from frame to frame.
        let below = if selected.is_some() { 230.0 } else { 60.0 };
        ScrollArea::vertical().max_height((ui.available_height() - below).max(80.0)).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            for limb in 0..document.limbs.len() {
                ui.push_id(limb, |ui| self.row(ui, document, frame, limb, selected == Some(limb), &mut asked));
            }
        });
        ui.add_space(theme::GAP);
        match selected.filter(|limb| *limb < document.limbs.len()) {
            Some(limb) => {
                details(ui, document, frame, limb, &mut asked);
                order(ui, document, overlaps, limb, &mut asked);
            }
            None => {
                widgets::remark(ui, texts::DRAWS_NEW);
            }
        }
        asked
    }

    fn row(&mut self, ui: &mut Ui, document: &Document, frame: u64, index: usize, on: bool, asked: &mut Vec<Asked>) {
        let palette = Palette::of(ui);
        let limb = &document.limbs[index];
        let fill = if on { ui.visuals().selection.bg_fill } else { eframe::egui::Color32::TRANSPARENT };
        let outline = if on { Stroke::new(1.0, palette.accent) } else { Stroke::NONE };
        let row =
            Frame::new().fill(fill).stroke(outline).corner_radius(theme::RADIUS).inner_margin(Margin::symmetric(6, 3));
        row.show(ui, |ui| {
            ui.horizontal(|ui| {
                let (rect, swatch) = ui.allocate_exact_size(vec2(20.0, 20.0), Sense::click());
                let color = theme::limb(index);
                if document.stroke(index, frame).is_some() {
                    ui.painter().circle_filled(rect.center(), 7.0, color);
                } else {
                    ui.painter().circle_stroke(rect.center(), 6.0, Stroke::new(2.0, color));
                }
                let name = texts::select_limb(&limb.label);
                swatch.widget_info(|| {
                    eframe::egui::WidgetInfo::selected(eframe::egui::Role::RadioButton, true, on, &name)
                });
                if swatch.on_hover_text(&name).clicked() {
                    asked.push(Asked::Select(Some(index)));
                }
                let mut text = match &self.typed {
                    Some((at, text)) if *at == index => text.clone(),
                    _ => limb.label.clone(),
                };
                let room = ui.available_width() - 36.0;
                let edit = TextEdit::singleline(&mut text)
                    .desired_width(room)
                    .min_size(vec2(0.0, 26.0))
                    .align(eframe::egui::Align2::LEFT_CENTER)
                    .frame(Frame::new().inner_margin(Margin::symmetric(4, 3)))
                    .hint_text(texts::LIMB_NAME);
                let edit = ui.add(edit).accessible_name(texts::name_of_limb(&limb.label));
                if edit.gained_focus() && !on {
                    asked.push(Asked::Select(Some(index)));
                }
                if edit.changed() {
                    self.typed = Some((index, text));
                }
                if edit.lost_focus() {
                    let escaped = ui.input(|i| i.key_pressed(Key::Escape));
                    let typed = self.typed.take().map(|(_, text)| text.trim().to_owned());
                    if let Some(text) = typed.filter(|t| !escaped && !t.is_empty() && *t != limb.label) {
                        asked.push(Asked::Name(index, text));
                    }
                }
                if widgets::icon_button(ui, Icon::Trash, &texts::remove_limb(&limb.label)).clicked() {
                    asked.push(Asked::RemoveLimb(index));
                }
            });
        });
    }
}

/// Which limbs the selected one lies before, and behind which.
fn order(ui: &mut Ui, document: &Document, overlaps: &[Overlap], limb: usize, asked: &mut Vec<Asked>) {
    let mut crossed = overlaps::of(overlaps, limb).peekable();
    if crossed.peek().is_none() {
        return;
    }
    ui.add_space(theme::GAP);
    widgets::remark(ui, texts::CROSSES);
    for (before, other) in crossed {
        let label = document.limbs.get(other).map_or("", |l| &l.label);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for (side, text) in [(true, texts::in_front_of(label)), (false, texts::behind(label))] {
                let hint = crate::shortcuts::hint(ui.ctx(), texts::ORDER_HINT, Command::Order);
                let button = ui.add(Button::selectable(before == side, text)).on_hover_text(hint);
                if button.clicked() && before != side {
                    asked.push(Asked::Order { limb, before: side, other });
                }
            }
        });
    }
}

/// What can be said of the selected limb.
fn details(ui: &mut Ui, document: &Document, frame: u64, index: usize, asked: &mut Vec<Asked>) {
    let limb = &document.limbs[index];
    ui.separator();
    ui.horizontal(|ui| {
        let label = ui.label(texts::SIDE);
        let text = |side: Side| SIDES.iter().find(|(s, _)| *s == side).map_or("", |(_, text)| *text);
        let list = ComboBox::from_id_salt("side").width(120.0).selected_text(text(limb.side));
        let list = list.show_ui(ui, |ui| {
            for (side, text) in SIDES {
                if ui.selectable_label(limb.side == side, text).clicked() && limb.side != side {
                    asked.push(Asked::Side(index, side));
                }
            }
        });
        list.response.labelled_by(label.id).on_hover_text(texts::SIDE_HINT);
    });
    let Some(stroke) = document.stroke(index, frame) else {
        widgets::remark(ui, &*texts::draws_again(&limb.label));
        return;
    };
    ui.horizontal(|ui| {
        ui.label(texts::END);
        ui.spacing_mut().item_spacing.x = 2.0;
        for (facing, text, hint) in [
            (Facing::Unknown, texts::FACING_FLAT, texts::FACING_FLAT_HINT),
            (Facing::Toward, texts::FACING_TOWARD, texts::FACING_TOWARD_HINT),
            (Facing::Away, texts::FACING_AWAY, texts::FACING_AWAY_HINT),
        ] {
            let button = ui.add(Button::selectable(stroke.facing == facing, text)).on_hover_text(hint);
            if button.clicked() && stroke.facing != facing {
                asked.push(Asked::Facing(index, facing));
            }
        }
    });
    let hint = crate::shortcuts::hint(ui.ctx(), texts::REMOVE_STROKE, Command::RemoveStroke);
    if ui.button(texts::REMOVE_STROKE).on_hover_text(hint).clicked() {
        asked.push(Asked::RemoveStroke(index));
    }
}
