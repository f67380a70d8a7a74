//! The list of everything that has a key, in which other keys can be chosen.

use eframe::egui::{
    Align, Button, Context, Event, Grid, Id, Key, KeyboardShortcut, Layout, Modal, RichText, ScrollArea, Ui,
};

use crate::shortcuts::{self, Chosen, Command, TABLE};
use crate::theme::{self, Palette};
use crate::{texts, widgets};

#[derive(Debug, Default)]
pub(crate) struct Help {
    /// The command whose keys are chosen, and what it does.
    choosing: Option<(Command, &'static str)>,
    /// Keys that another command has.
    conflict: Option<KeyboardShortcut>,
    /// Why the last keys will not do.
    wrong: Option<&'static str>,
}

impl Help {
    /// False once it is to be closed.
    pub(crate) fn show(&mut self, ctx: &Context, chosen: &mut Chosen) -> bool {
        let before = chosen.clone();
        self.listen(ctx, chosen);
        let modal = Modal::new(Id::unique("help")).frame(theme::dialog(ctx)).show(ctx, |ui| {
            ui.set_width(720.0_f32.min(ctx.content_rect().width() - 60.0));
            ui.heading(texts::SHORTCUTS);
            ui.add_space(theme::GAP);
            ScrollArea::vertical().max_height(ctx.content_rect().height() - 240.0).show(ui, |ui| self.table(ui));
            self.below(ui, chosen)
        });
        if *chosen != before {
            shortcuts::choose(ctx, chosen);
        }
        !(modal.inner || modal.should_close())
    }

    fn table(&mut self, ui: &mut Ui) {
        ui.columns(2, |columns| {
            for (i, (name, group)) in TABLE.iter().enumerate() {
                // As many lines on the left as on the right.
                let ui = &mut columns[usize::from(i == 2 || i == 3)];
                widgets::section(ui, name);
                let grid = Grid::new(*name).num_columns(2).min_col_width(110.0).min_row_height(18.0);
                grid.spacing([8.0, 0.0]).show(ui, |ui| {
                    for shortcut in *group {
                        let keys = shortcuts::keys(ui.ctx(), shortcut.command);
                        let keys = keys.map_or(texts::NO_KEY.into(), |keys| shortcuts::shown(ui.ctx(), &keys));
                        let on = self.choosing.is_some_and(|(command, _)| command == shortcut.command);
                        let (palette, shown) = (Palette::of(ui), if on { texts::PRESS_KEYS } else { &keys });
                        let button = Button::new(RichText::new(shown).color(palette.accent)).frame_when_inactive(on);
                        let button = ui.add(button.small());
                        if button.accessible_name(texts::keys_of(shortcut.text, &keys)).clicked() {
                            self.choosing = Some((shortcut.command, shortcut.text));
                            (self.conflict, self.wrong) = (None, None);
                        }
                        ui.label(shortcut.text);
                        ui.end_row();
                    }
                });
                ui.add_space(theme::GAP);
            }
        });
    }

    /// What is being chosen, and the ways out; true to close.
    fn below(&mut self, ui: &mut Ui, chosen: &mut Chosen) -> bool {
        let palette = Palette::of(ui);
        match self.choosing {
            None => {
                widgets::remark(ui, texts::MOUSE_HELP);
                widgets::remark(ui, texts::KEYS_HINT);
            }
            Some((command, what)) => {
                let shown = |keys: &KeyboardShortcut| shortcuts::shown(ui.ctx(), keys);
                let taken = self.conflict.and_then(|keys| Some((keys, shortcuts::taken(ui.ctx(), keys, command)?)));
                let line = match (taken, self.wrong) {
                    (Some((keys, (_, by))), _) => texts::keys_taken(&shown(&keys), by),
                    (None, Some(wrong)) => wrong.into(),
                    (None, None) => texts::keys_wanted(what),
                };
                ui.label(RichText::new(line).color(palette.accent));
                ui.horizontal(|ui| {
                    if let Some((keys, (other, _))) = taken
                        && ui.button(texts::USE_KEY).clicked()
                    {
                        chosen.insert(shortcuts::name(other), String::new());
                        self.settle(command, Some(keys), chosen);
                    }
                    if ui.button(texts::TAKE_KEY_AWAY).clicked() {
                        self.settle(command, None, chosen);
                    }
                    if ui.button(texts::LEAVE_KEY).clicked() {
                        *self = Self::default();
                    }
                });
            }
        }
        ui.add_space(theme::GAP);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let close = widgets::primary_button(ui, texts::CLOSE).clicked();
            if !chosen.is_empty() && ui.button(texts::RESET_KEYS).clicked() {
                chosen.clear();
                *self = Self::default();
            }
            close
        })
        .inner
    }

    /// Takes the keys that are pressed while some are chosen; no widget gets them.
    fn listen(&mut self, ctx: &Context, chosen: &mut Chosen) {
        let Some((command, _)) = self.choosing else { return };
        let pressed = ctx.input_mut(|input| {
            let mut pressed = None;
            input.events.retain(|event| match event {
                Event::Key { key, pressed: down, modifiers, .. } => {
                    if *down {
                        pressed = Some((*modifiers, *key));
                    }
                    false
                }
                // Where there is one, copying and pasting have no key event of their own.
                Event::Text(_) => false,
                _ => true,
            });
            pressed
        });
        let Some((modifiers, key)) = pressed else { return };
        if key == Key::Escape && modifiers.is_none() {
            *self = Self::default();
            return;
        }
        (self.conflict, self.wrong) = (None, None);
        match shortcuts::offered(modifiers, key) {
            Err(wrong) => self.wrong = Some(wrong),
            Ok(keys) if shortcuts::taken(ctx, keys, command).is_some() => self.conflict = Some(keys),
            Ok(keys) => self.settle(command, Some(keys), chosen),
        }
    }

    fn settle(&mut self, command: Command, keys: Option<KeyboardShortcut>, chosen: &mut Chosen) {
        let usual = TABLE.iter().flat_map(|(_, group)| *group).find(|s| s.command == command).map(|s| s.keys);
        if keys == usual {
            chosen.remove(&shortcuts::name(command));
        } else {
            chosen.insert(shortcuts::name(command), keys.map(shortcuts::text).unwrap_or_default());
        }
        *self = Self::default();
    }
}
