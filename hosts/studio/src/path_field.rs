//! A file asked for by its path, where the system has no dialog for it. Files can be dropped on the window all the same.

use std::path::{Path, PathBuf};

use eframe::egui::text::{CCursor, CCursorRange};
use eframe::egui::{Align, Button, Context, Id, Key, Layout, Modal, RichText, TextEdit, vec2};

use crate::picker::Ask;
use crate::theme::{self, Palette};
use crate::{texts, widgets};

#[derive(Debug, Default)]
pub(crate) struct PathField {
    /// None before it is shown the first time.
    typed: Option<String>,
    wrong: Option<String>,
}

pub(crate) enum Answer {
    Open,
    Closed,
    Chosen(PathBuf),
}

impl PathField {
    pub(crate) fn show(&mut self, ui: &Context, ask: &Ask, home: &Path) -> Answer {
        let first = self.typed.is_none();
        let typed = self.typed.get_or_insert_with(|| beginning(ask, home));
        let mut answer = Answer::Open;
        let modal = Modal::new(Id::unique("path")).frame(theme::dialog(ui)).show(ui, |ui| {
            ui.set_width(560.0_f32.min(ui.ctx().content_rect().width() - 60.0));
            ui.heading(ask.title());
            ui.add_space(theme::GAP);
            widgets::remark(ui, texts::NO_DIALOGS);
            ui.add_space(theme::GAP);
            let mut edit = TextEdit::singleline(typed).desired_width(f32::INFINITY).show(ui);
            let field = edit.response.response.accessible_name(texts::PATH);
            if first {
                field.request_focus();
                let end = CCursor::new(typed.chars().count());
                edit.state.cursor.set_char_range(Some(CCursorRange::one(end)));
                edit.state.store(ui.ctx(), field.id);
            }
            if field.changed() {
                self.wrong = None;
            }
            if let Some(wrong) = &self.wrong {
                ui.label(RichText::new(wrong).color(Palette::of(ui).bad));
            }
            ui.add_space(theme::GAP);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
                if widgets::primary_button(ui, texts::CHOOSE).clicked() || entered {
                    match resolve(typed, ask, home) {
                        Ok(path) => answer = Answer::Chosen(path),
                        Err(wrong) => {
                            self.wrong = Some(wrong);
                            field.request_focus();
                        }
                    }
                }
                if ui.add(Button::new(texts::CANCEL).min_size(vec2(0.0, 30.0))).clicked() {
                    answer = Answer::Closed;
                }
            });
        });
        if modal.should_close() && matches!(answer, Answer::Open) {
            answer = Answer::Closed;
        }
        answer
    }
}

/// What stands in the field first.
fn beginning(ask: &Ask, home: &Path) -> String {
    let path = match ask {
        Ask::Clip | Ask::DrawingClip | Ask::Picture | Ask::Drawing | Ask::Motion | Ask::MotionClip | Ask::Session => {
            home.join("")
        }
        Ask::SaveAs { folder, name } | Ask::ExportFile { folder, name } => folder.join(name),
        Ask::ExportFolder { folder } => folder.join(""),
    };
    path.to_string_lossy().into_owned()
}

/// The path, or what is wrong with it for a person.
fn resolve(typed: &str, ask: &Ask, home: &Path) -> Result<PathBuf, String> {
    let typed = typed.trim();
    let path = match typed.strip_prefix("~/").or(typed.strip_prefix("~").filter(|rest| rest.is_empty())) {
        Some(rest) => home.join(rest),
        None => home.join(typed),
    };
    let folder = match ask {
        Ask::Clip | Ask::DrawingClip | Ask::Picture | Ask::Drawing | Ask::Motion | Ask::MotionClip | Ask::Session => {
            return if path.exists() { Ok(path) } else { Err(texts::not_there(&path)) };
        }
        Ask::SaveAs { .. } | Ask::ExportFile { .. } if path.is_dir() || path.file_name().is_none() => {
            return Err(texts::name_a_file(&path));
        }
        Ask::SaveAs { .. } | Ask::ExportFile { .. } => path.parent().unwrap_or(&path),
        Ask::ExportFolder { .. } => &path,
    };
    if folder.is_dir() { Ok(path) } else { Err(texts::no_such_folder(folder)) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;

    #[test]
    fn paths_are_found_or_said_to_be_wrong() {
        let home = tempfile::tempdir().unwrap();
        let home = home.path();
        std::fs::write(home.join("fox.mp4"), "").unwrap();
        let clip = |typed: &str| resolve(typed, &Ask::Clip, home);
        for typed in [" ~/fox.mp4 ", "fox.mp4", &home.join("fox.mp4").to_string_lossy()] {
            assert_eq!(clip(typed).unwrap(), home.join("fox.mp4"));
        }
        assert!(clip("~/cow.mp4").unwrap_err().contains("cow.mp4"));
        assert_eq!(clip("~").unwrap(), home.join(""));

        let save = Ask::SaveAs { folder: home.to_owned(), name: "fox.marey".into() };
        assert_eq!(beginning(&save, home), home.join("fox.marey").to_string_lossy());
        assert_eq!(resolve("new.marey", &save, home).unwrap(), home.join("new.marey"));
        assert!(resolve("none/new.marey", &save, home).unwrap_err().contains("none"));
        assert!(resolve("~/", &save, home).is_err() && resolve("", &save, home).is_err(), "a folder is no name");
        let folder = Ask::ExportFolder { folder: home.to_owned() };
        assert_eq!(resolve("~/", &folder, home).unwrap(), home.join(""));
        assert!(resolve("fox.mp4", &folder, home).is_err());
    }
}
