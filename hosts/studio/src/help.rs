//! The list of everything that has a key.

use eframe::egui::{Context, Grid, Id, Modal, RichText, ScrollArea};

use crate::shortcuts::TABLE;
use crate::theme::{self, Palette};
use crate::{texts, widgets};

/// False once it is to be closed.
pub(crate) fn show(ctx: &Context) -> bool {
    let modal = Modal::new(Id::unique("help")).frame(theme::dialog(ctx)).show(ctx, |ui| {
        ui.set_width(700.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading(texts::SHORTCUTS);
        ui.add_space(theme::GAP);
        ScrollArea::vertical().max_height(ctx.content_rect().height() - 180.0).show(ui, |ui| {
            ui.columns(2, |columns| {
                for (i, (name, group)) in TABLE.iter().enumerate() {
                    // As many lines on the left as on the right.
                    let ui = &mut columns[usize::from(i == 2 || i == 3)];
                    widgets::section(ui, name);
                    Grid::new(*name).num_columns(2).min_col_width(110.0).min_row_height(20.0).spacing([8.0, 2.0]).show(
                        ui,
                        |ui| {
                            for shortcut in *group {
                                let color = Palette::of(ui).accent;
                                ui.label(RichText::new(ctx.format_shortcut(&shortcut.keys)).color(color));
                                ui.label(shortcut.text);
                                ui.end_row();
                            }
                        },
                    );
                    ui.add_space(theme::GAP);
                }
            });
        });
        widgets::remark(ui, texts::MOUSE_HELP);
        ui.add_space(theme::GAP);
        widgets::primary_button(ui, texts::CLOSE).clicked()
    });
    !(modal.inner || modal.should_close())
}
