//! Dialogs of the system that ask for a file. They wait for a person on a thread of their own.

use std::path::{Path, PathBuf};

use eframe::egui::Context;

use crate::background::Background;
use crate::texts;

/// What is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Ask {
    /// A clip.
    Clip,
    /// A session.
    Session,
    /// A clip for a drawing that lives.
    DrawingClip,
    /// A picture for a character.
    Picture,
    /// A vector drawing.
    Drawing,
    /// A motion for a character.
    Motion,
    /// A name for the session.
    SaveAs { folder: PathBuf, name: String },
    /// A file for the export.
    ExportFile { folder: PathBuf, name: String },
    /// A folder that the export's folder goes into.
    ExportFolder { folder: PathBuf },
}

/// What ends with these is offered as a clip; a folder of pictures is dropped on the window.
const CLIPS: [&str; 9] = ["mp4", "m4v", "mov", "avi", "mkv", "webm", "gif", "png", "webp"];

/// What can be a character's picture, or its motion.
const PICTURES: [&str; 5] = ["png", "jpg", "jpeg", "webp", "gif"];
const MOTIONS: [&str; 3] = ["json", "bvh", "marey"];

#[derive(Debug, Default)]
pub(crate) struct Picker(Option<(Ask, Background<Option<PathBuf>>)>);

impl Picker {
    /// Asks, unless a question is open.
    pub(crate) fn ask(&mut self, ui: &Context, ask: Ask) {
        if self.0.is_none() {
            let question = ask.clone();
            self.0 = Some((ask, Background::start(ui, move || dialog(&question))));
        }
    }

    /// What was asked and chosen.
    pub(crate) fn answer(&mut self) -> Option<(Ask, PathBuf)> {
        let (_, background) = self.0.as_ref()?;
        let answer = match background.answer() {
            Ok(None) => return None,
            Ok(Some(path)) => path,
            Err(()) => None,
        };
        let (ask, _) = self.0.take()?;
        Some((ask, answer?))
    }
}

fn dialog(ask: &Ask) -> Option<PathBuf> {
    let dialog = rfd::FileDialog::new();
    let start = |folder: &Path| dialog.clone().set_directory(folder);
    match ask {
        Ask::Clip | Ask::DrawingClip => dialog.set_title(texts::PICK_CLIP).add_filter(texts::CLIPS, &CLIPS).pick_file(),
        Ask::Picture => dialog.set_title(texts::PICK_PICTURE).add_filter(texts::PICTURES_OF, &PICTURES).pick_file(),
        Ask::Drawing => dialog.set_title(texts::PICK_DRAWING).add_filter(texts::DRAWINGS, &["svg"]).pick_file(),
        Ask::Motion => dialog.set_title(texts::PICK_MOTION).add_filter(texts::MOTIONS, &MOTIONS).pick_file(),
        Ask::Session => dialog.set_title(texts::PICK_SESSION).add_filter(texts::SESSIONS, &["marey"]).pick_file(),
        Ask::SaveAs { folder, name } => start(folder)
            .set_title(texts::SAVE_AS)
            .add_filter(texts::SESSIONS, &["marey"])
            .set_file_name(name)
            .save_file(),
        Ask::ExportFile { folder, name } => start(folder).set_title(texts::EXPORT_TO).set_file_name(name).save_file(),
        Ask::ExportFolder { folder } => start(folder).set_title(texts::EXPORT_TO).pick_folder(),
    }
}
