//! How a document is met, named, saved and left, the same behind every door.

use std::path::Path;

use eframe::egui::Context as Gui;

use crate::around::Around;
use crate::document::Document;
use crate::picker::Ask;
use crate::texts;

impl Document {
    /// Tells a person what they should know of it.
    pub(crate) fn greet(&self, around: &mut Around) {
        for warning in self.warnings().unwrap_or_default() {
            around.notices.failed(warning);
        }
        if self.state.recovered > 0 {
            around.notices.done(texts::recovered(self.state.recovered));
        }
    }

    /// Leaves it as it should be found again: saved where it has a name, kept where it was worked on, and gone where it was
    /// only opened.
    pub(crate) fn leave(mut self, around: &mut Around) {
        let path = self.path();
        if self.state.untitled && !self.is_worked_on() {
            path.iter().for_each(|path| around.preferences.forget(path));
            around.notices.check(self.discard());
            return;
        }
        if let Some(path) = path {
            around.preferences.remember(&path, &self.title);
        }
        if !self.state.untitled && self.state.modified {
            around.notices.check(self.save());
        }
    }

    /// Saves it under the name it has, or asks for one.
    pub(crate) fn save_or_ask(&mut self, gui: &Gui, around: &mut Around) {
        if self.named_path().is_some() {
            around.notices.check(self.save());
        } else {
            self.ask_name(gui, around);
        }
    }

    pub(crate) fn ask_name(&self, gui: &Gui, around: &mut Around) {
        let named = self.named_path();
        let folder = named.as_deref().and_then(Path::parent).unwrap_or(&around.places.home).to_owned();
        around.picker.ask(gui, Ask::SaveAs { folder, name: texts::session_file(&self.title) });
    }

    /// Saves it under a name that was chosen.
    pub(crate) fn save_under(&mut self, path: &Path, around: &mut Around) {
        let ending = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("marey"));
        let path = if ending { path.to_owned() } else { texts::with_session_ending(path) };
        let before = self.path();
        if around.notices.check(self.save_as(&path)).is_some() {
            if let Some(before) = before.filter(|b| *b != path) {
                around.preferences.recent.retain(|r| r.path != before || before.exists());
            }
            around.preferences.remember(&path, &self.title);
        }
    }
}
