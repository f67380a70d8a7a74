//! What the doors of characters and drawings have in common: the document, what runs, what plays, and the way out.

use std::path::Path;
use std::sync::Arc;

use eframe::egui::{Context as Gui, Frame, Margin, Panel, RichText, Slider, Ui};

use crate::around::Around;
use crate::document::Document;
use crate::export::{self, ExportDialog, Exported};
use crate::frames::Frames;
use crate::icons::Icon;
use crate::moving::{Moving, MovingPictures};
use crate::playback::Playback;
use crate::running::{Ended, Purpose, Running, Step};
use crate::shortcuts::Command;
use crate::theme::{self, Palette};
use crate::timeline::Timeline;
use crate::{canvas, texts, timing, widgets};

/// How high the line is that says how far what runs is.
const PROGRESS: f32 = 44.0;

/// How a step ended.
#[derive(Debug)]
pub(crate) enum Watched {
    Done(Step, Running),
    /// It failed, or was cancelled; a person was told.
    Failed,
    /// It was stopped for what is no more.
    Outdated,
}

pub(crate) struct Workshop {
    pub(crate) document: Document,
    pub(crate) frames: Option<Frames>,
    pub(crate) timeline: Timeline,
    pub(crate) playback: Playback,
    pub(crate) running: Option<Running>,
    pub(crate) export: Option<ExportDialog>,
    /// What was made to move.
    pub(crate) moving: Option<Moving>,
    pub(crate) pictures: MovingPictures,
}

impl Workshop {
    pub(crate) fn new(gui: &Gui, document: Document, around: &mut Around) -> Self {
        document.greet(around);
        let (frames, fps) = document.clip.as_ref().map_or((0, 0.0), |(_, info)| (info.frames, info.fps));
        let playback = Playback::new(frames, fps, !around.preferences.once);
        Self {
            frames: document.clip.as_ref().map(|(clip, info)| Frames::new(gui, clip.clone(), info)),
            timeline: Timeline::default(),
            playback,
            running: None,
            export: None,
            moving: None,
            pictures: MovingPictures::new(gui),
            document,
        }
    }

    /// Another clip is shown from now on, where the document has another.
    pub(crate) fn follow_clip(&mut self, gui: &Gui) {
        let clip = self.document.clip.as_ref();
        if self.frames.as_ref().map(Frames::clip).map(Arc::as_ptr) == clip.map(|(clip, _)| Arc::as_ptr(clip)) {
            return;
        }
        self.frames = clip.map(|(clip, info)| Frames::new(gui, clip.clone(), info));
        if let Some((_, info)) = clip.filter(|_| self.moving.is_none()) {
            self.playback = Playback::new(info.frames, info.fps, self.playback.looped);
        }
    }

    /// Time goes on.
    pub(crate) fn advance(&mut self, ui: &Ui, around: &mut Around) {
        self.playback.take(self.document.timing(), &around.context);
        self.playback.advance(ui.input(|i| i.time));
        if self.playback.playing() {
            widgets::keep_moving(ui.ctx());
        }
        let frame = self.playback.frame();
        if let Some(message) = self.frames.as_mut().and_then(|frames| frames.update(ui.ctx(), frame)) {
            around.notices.failed(message);
        }
    }

    /// What moves was made anew; it plays.
    pub(crate) fn show_moving(&mut self, moving: Moving, now: f64) {
        if let Ok((frames, fps)) = moving.frames() {
            let (frame, first) = (self.playback.frame(), self.moving.is_none());
            let playing = self.playback.playing() || first;
            self.playback = Playback::new(frames, fps, self.playback.looped);
            self.playback.seek(frame, now);
            if playing {
                self.playback.toggle(now);
            }
        }
        self.moving = Some(moving);
    }

    /// Takes in how what runs ended.
    pub(crate) fn watch(&mut self, ui: &Ui, around: &mut Around) -> Option<Watched> {
        let ended = self.running.as_mut().and_then(Running::poll)?;
        let running = self.running.take()?;
        ui.ctx().request_repaint();
        match (ended, running.purpose.clone()) {
            (Ended::Done, Purpose::Step(step)) => return Some(Watched::Done(step, running)),
            (Ended::Done, Purpose::Export { path, .. }) => around.notices.done(texts::exported(&path)),
            (Ended::Done, _) => {}
            (Ended::Failed(error), Purpose::Step(_)) => {
                around.notices.failed(error);
                return Some(Watched::Failed);
            }
            (Ended::Failed(error), _) => around.notices.failed(error),
            (Ended::Cancelled, Purpose::Step(_)) => {
                if running.cancelled {
                    around.notices.done(texts::CANCELLED.into());
                    return Some(Watched::Failed);
                }
                return Some(Watched::Outdated);
            }
            (Ended::Cancelled, _) => around.notices.done(texts::CANCELLED.into()),
        }
        None
    }

    /// How far what runs is; short steps go without a word. Over a clip there is always room for it: each mark is followed
    /// anew, and what is clicked on must not move.
    pub(crate) fn show_progress(&mut self, ui: &mut Ui) {
        let (palette, frames) = (Palette::of(ui), self.document.frames());
        if self.running.is_some() {
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
        }
        let mut running = self.running.as_mut().filter(|running| running.is_long());
        if running.is_none() && self.document.clip.is_none() {
            return;
        }
        let followed = self.document.tracked.as_ref().map_or(0, |tracked| tracked.limbs.len());
        let plain = Frame::new().fill(palette.panel).inner_margin(Margin::symmetric(theme::PAD, 8));
        Panel::top("progress").frame(plain).exact_size(PROGRESS).show(ui, |ui| match &mut running {
            Some(running) => running.show(ui, frames),
            None if followed == 0 || followed < self.document.marks.points.len() => {}
            None => {
                ui.horizontal_centered(|ui| widgets::remark(ui, texts::ALL_FOLLOWED));
            }
        });
    }

    /// Playing without a clip.
    pub(crate) fn show_transport(&mut self, ui: &mut Ui, around: &mut Around) -> Vec<Command> {
        let mut asked = Vec::new();
        ui.add_enabled_ui(self.moving.is_some(), |ui| {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                let playing = self.playback.playing();
                let (icon, text) = if playing { (Icon::Pause, texts::PAUSE) } else { (Icon::Play, texts::PLAY) };
                let play = widgets::icon_toggle(ui, icon, text, false).on_hover_text(canvas::play_hint(ui, playing));
                if play.clicked() {
                    asked.push(Command::Play);
                }
                if widgets::icon_toggle(ui, Icon::Loop, texts::LOOP, self.playback.looped).clicked() {
                    asked.push(Command::Loop);
                }
                ui.add_space(6.0);
                if let Some(timing) = timing::menu(ui, &self.document.timing()) {
                    around.notices.check(self.document.set_timing(timing));
                }
                ui.add_space(10.0);
                let (mut frame, last) = (self.playback.frame(), self.playback.last());
                let place = texts::place_in_time(frame, last + 1, frame as f64 / self.playback.fps());
                ui.label(RichText::new(place).monospace());
                ui.add_space(10.0);
                ui.spacing_mut().slider_width = (ui.available_width() - 20.0).max(60.0);
                let slider = ui.add(Slider::new(&mut frame, 0..=last.max(1)).show_value(false));
                if slider.accessible_name(texts::TIMELINE).changed() {
                    self.playback.stop();
                    self.playback.seek(frame, 0.0);
                }
            });
        });
        asked
    }

    /// Does what a key or a button asked for; false for what is the door's.
    pub(crate) fn command(&mut self, command: Command, gui: &Gui, around: &mut Around) -> bool {
        if self.playback.command(command, &self.document.keys, gui.input(|i| i.time)) {
            around.preferences.once = !self.playback.looped;
            return true;
        }
        match command {
            Command::Undo => {
                let done = self.document.undo_one();
                around.notices.check(done);
            }
            Command::Redo => {
                let done = self.document.redo_one();
                around.notices.check(done);
            }
            Command::Export => {
                if self.moving.is_none() {
                    around.notices.failed(texts::MOVE_FIRST);
                } else if self.export.is_none() {
                    let (settings, home) = (&around.preferences.export, &around.places.home);
                    let door = self.document.door();
                    self.export = Some(ExportDialog::new(settings, door, home, &self.document.title));
                }
            }
            Command::ExportAgain => {
                let (settings, home) = (&around.preferences.export, &around.places.home);
                let path = export::path_for(settings, self.document.door(), home, &self.document.title);
                self.start_export(&path, around);
            }
            Command::Save => self.document.save_or_ask(gui, around),
            Command::SaveAs => self.document.ask_name(gui, around),
            _ => return false,
        }
        true
    }

    pub(crate) fn show_export(&mut self, ui: &Ui, around: &mut Around) {
        let (Some(mut dialog), Some(moving)) = (self.export.take(), &self.moving) else { return };
        let exported = Exported::Moving(moving, self.playback.played());
        let (settings, home) = (&mut around.preferences.export, &around.places.home);
        let asked = dialog.show(ui.ctx(), settings, &exported, home, &self.document.title);
        match asked {
            Some(export::Asked::Close) => {}
            Some(export::Asked::Export(path)) => self.start_export(&path, around),
            Some(export::Asked::Browse) => {
                let folders = around.preferences.export.format(self.document.door()).is_folder();
                around.picker.ask(ui.ctx(), dialog.browse(folders, &around.places.home));
                self.export = Some(dialog);
            }
            None => self.export = Some(dialog),
        }
    }

    fn start_export(&mut self, path: &Path, around: &mut Around) {
        if self.running.is_some() {
            around.notices.failed(texts::BUSY);
            return;
        }
        let Some(moving) = &self.moving else {
            around.notices.failed(texts::MOVE_FIRST);
            return;
        };
        let exported = Exported::Moving(moving, self.playback.played());
        self.running = export::start(&exported, path, around);
    }
}
