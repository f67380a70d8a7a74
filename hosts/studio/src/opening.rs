//! Opening clips, samples and sessions beside the window: whole clips are read to know them again.

use std::path::{Path, PathBuf};

use eframe::egui;
use marey_binding::{Access, Context, Part};

use crate::background::Background;
use crate::document::{Document, Door, stem};
use crate::plugins::FirstLook;
use crate::{Places, sample, texts};

/// What is to be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// A video file, or a folder of pictures.
    Clip(PathBuf),
    /// The bundled fox.
    Fox,
    /// A session file.
    Session(PathBuf),
    /// A clip for a drawing that lives.
    DrawingClip(PathBuf),
    /// A picture for a character.
    Picture(PathBuf),
    /// The bundled child's drawing, which walks and waves.
    Child,
    /// The bundled drawing of a horse, which gallops.
    Horse,
}

impl Source {
    /// By a path's ending.
    pub(crate) fn of_path(path: &Path) -> Self {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match ending.as_str() {
            "marey" => Self::Session(path.to_owned()),
            // Other pictures may be clips too.
            "jpg" | "jpeg" => Self::Picture(path.to_owned()),
            _ => Self::Clip(path.to_owned()),
        }
    }

    pub(crate) fn name(&self) -> String {
        match self {
            Self::Clip(path) | Self::Session(path) | Self::DrawingClip(path) | Self::Picture(path) => {
                stem(&path.to_string_lossy())
            }
            Self::Fox => texts::FOX.into(),
            Self::Child => texts::CHILD.into(),
            Self::Horse => texts::HORSE.into(),
        }
    }
}

#[derive(Debug)]
pub(crate) struct Opening {
    pub(crate) source: Source,
    answer: Background<Result<Document, String>>,
}

impl Opening {
    /// `plugins` are waited for: what is opened may be made with them at once.
    pub(crate) fn start(
        ui: &egui::Context,
        context: &Context,
        places: &Places,
        plugins: FirstLook,
        source: Source,
    ) -> Self {
        let (context, places, opened) = (context.clone(), places.clone(), source.clone());
        let open = move || {
            plugins.wait();
            open(&context, &places, &opened)
        };
        Self { source, answer: Background::start(ui, open) }
    }

    pub(crate) fn answer(&self) -> Option<Result<Document, String>> {
        match self.answer.answer() {
            Ok(answer) => answer,
            Err(()) => Some(Err(texts::OPENING_BROKE.into())),
        }
    }
}

fn open(context: &Context, places: &Places, source: &Source) -> Result<Document, String> {
    let said = |e: marey_binding::Error| e.to_string();
    match source {
        Source::Clip(path) => Document::of_clip(context, &places.unsaved, &path.to_string_lossy(), None).map_err(said),
        Source::Fox => {
            let clip = sample::clip(&places.samples).map_err(|e| texts::no_folder(&places.samples, &e))?;
            let strokes = Some(sample::strokes());
            let mut document =
                Document::of_clip(context, &places.unsaved, &clip.to_string_lossy(), strokes).map_err(said)?;
            document.title = texts::FOX.into();
            Ok(document)
        }
        Source::DrawingClip(path) => {
            let clip = Some(path.to_string_lossy());
            Document::of_parts(context, &places.unsaved, Door::Drawing, &source.name(), clip.as_deref(), &[])
                .map_err(said)
        }
        Source::Picture(path) => {
            let picture = std::fs::read(path).map_err(|e| texts::unreadable(path, &e))?;
            let parts = [(Part::Picture, Some(picture.as_slice()))];
            Document::of_parts(context, &places.unsaved, Door::Character, &source.name(), None, &parts).map_err(said)
        }
        Source::Child => {
            Document::of_parts(context, &places.unsaved, Door::Character, texts::CHILD, None, &sample::child())
                .map_err(said)
        }
        Source::Horse => {
            let clip = sample::gallop(&places.samples).map_err(|e| texts::no_folder(&places.samples, &e))?;
            let clip = Some(clip.to_string_lossy());
            let parts = sample::horse();
            Document::of_parts(context, &places.unsaved, Door::Drawing, texts::HORSE, clip.as_deref(), &parts)
                .map_err(said)
        }
        Source::Session(path) => {
            let session = context.open_session(&path.to_string_lossy(), Access::Edit).map_err(said)?;
            Document::of(session, &source.name()).map_err(said)
        }
    }
}
