//! Asks for a file: by a dialog of the system, which waits for a person on a thread of its own, or where there is none by
//! its path.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use eframe::egui::Context;

use crate::background::Background;
use crate::path_field::{Answer, PathField};
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
    /// A clip that a character's motion is taken from.
    MotionClip,
    /// A name for the session.
    SaveAs { folder: PathBuf, name: String },
    /// A file for the export.
    ExportFile { folder: PathBuf, name: String },
    /// A folder that the export's folder goes into.
    ExportFolder { folder: PathBuf },
}

/// What ends with these is offered as a clip; a folder of pictures is dropped on the window.
const CLIPS: [&str; 9] = ["mp4", "m4v", "mov", "avi", "mkv", "webm", "gif", "png", "webp"];
/// Nobody closes a dialog so soon: without a portal and zenity it was never there, and that is all there is to know it by.
const SOONEST: Duration = Duration::from_millis(400);

#[derive(Debug)]
enum Question {
    /// What was chosen, and how long it took.
    System(Ask, Background<(Option<PathBuf>, Duration)>),
    Here(Ask, PathField),
}

/// What can be a character's picture, or its motion.
const PICTURES: [&str; 5] = ["png", "jpg", "jpeg", "webp", "gif"];
const MOTIONS: [&str; 3] = ["json", "bvh", "marey"];

#[derive(Debug, Default)]
pub(crate) struct Picker {
    question: Option<Question>,
    /// The system has no dialogs.
    pub(crate) here: bool,
}

impl Picker {
    /// Asks, unless a question is open.
    pub(crate) fn ask(&mut self, ui: &Context, ask: Ask) {
        if self.question.is_some() {
            return;
        }
        self.question = Some(if self.here {
            Question::Here(ask, PathField::default())
        } else {
            let question = ask.clone();
            let asked = move || {
                let began = Instant::now();
                (dialog(&question), began.elapsed())
            };
            Question::System(ask, Background::start(ui, asked))
        });
    }

    /// Shows what is asked here, and gives what was asked and chosen. A path of a person's may begin with ~ for `home`.
    pub(crate) fn show(&mut self, ui: &Context, home: &Path) -> Option<(Ask, PathBuf)> {
        match self.question.take()? {
            Question::System(ask, background) => match background.answer() {
                Ok(None) => {
                    self.question = Some(Question::System(ask, background));
                    None
                }
                Ok(Some((Some(path), _))) => Some((ask, path)),
                Ok(Some((None, took))) if cfg!(target_os = "linux") && took < SOONEST => {
                    self.here = true;
                    self.ask(ui, ask);
                    ui.request_repaint();
                    None
                }
                Ok(Some((None, _))) | Err(()) => None,
            },
            Question::Here(ask, mut field) => match field.show(ui, &ask, home) {
                Answer::Chosen(path) => Some((ask, path)),
                Answer::Closed => None,
                Answer::Open => {
                    self.question = Some(Question::Here(ask, field));
                    None
                }
            },
        }
    }
}

impl Ask {
    pub(crate) fn title(&self) -> &'static str {
        match self {
            Self::Clip | Self::DrawingClip => texts::PICK_CLIP,
            Self::Picture => texts::PICK_PICTURE,
            Self::Drawing => texts::PICK_DRAWING,
            Self::Motion => texts::PICK_MOTION,
            Self::MotionClip => texts::PICK_MOTION_CLIP,
            Self::Session => texts::PICK_SESSION,
            Self::SaveAs { .. } => texts::SAVE_AS,
            Self::ExportFile { .. } | Self::ExportFolder { .. } => texts::EXPORT_TO,
        }
    }
}

fn dialog(ask: &Ask) -> Option<PathBuf> {
    let dialog = rfd::FileDialog::new().set_title(ask.title());
    let start = |folder: &Path| dialog.clone().set_directory(folder);
    match ask {
        Ask::Clip | Ask::DrawingClip | Ask::MotionClip => dialog.add_filter(texts::CLIPS, &CLIPS).pick_file(),
        Ask::Picture => dialog.add_filter(texts::PICTURES_OF, &PICTURES).pick_file(),
        Ask::Drawing => dialog.add_filter(texts::DRAWINGS, &["svg"]).pick_file(),
        Ask::Motion => dialog.add_filter(texts::MOTIONS, &MOTIONS).pick_file(),
        Ask::Session => dialog.add_filter(texts::SESSIONS, &["marey"]).pick_file(),
        Ask::SaveAs { folder, name } => {
            start(folder).add_filter(texts::SESSIONS, &["marey"]).set_file_name(name).save_file()
        }
        Ask::ExportFile { folder, name } => start(folder).set_file_name(name).save_file(),
        Ask::ExportFolder { folder } => start(folder).pick_folder(),
    }
}
