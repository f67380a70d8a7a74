//! What the doors of characters and drawings have in common: the document, what runs, what plays, and the way out.

use std::path::Path;

use eframe::egui::{
    Align, Context as Gui, Frame, Label, Layout, Margin, Panel, ProgressBar, RichText, Slider, Ui, vec2,
};

use crate::around::Around;
use crate::document::Document;
use crate::export::{self, ExportDialog, Exported};
use crate::frames::Frames;
use crate::icons::Icon;
use crate::moving::{Moving, MovingPictures};
use crate::picker::Ask;
use crate::playback::Playback;
use crate::running::{Ended, Purpose, Running, Step};
use crate::shortcuts::Command;
use crate::theme::{self, Palette};
use crate::timeline::Timeline;
use crate::{canvas, texts, widgets};

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
    export: Option<ExportDialog>,
    /// What was made to move.
    pub(crate) moving: Option<Moving>,
    pub(crate) pictures: MovingPictures,
}

impl Workshop {
    pub(crate) fn new(gui: &Gui, document: Document, around: &mut Around) -> Self {
        for warning in document.warnings().unwrap_or_default() {
            around.notices.failed(warning);
        }
        if document.state.recovered > 0 {
            around.notices.done(texts::recovered(document.state.recovered));
        }
        let (frames, fps) = document.clip.as_ref().map_or((0, 0.0), |(_, info)| (info.frames, info.fps));
        let mut playback = Playback::new(frames, fps, !around.preferences.once);
        playback.held = around.preferences.held.max(1);
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

    /// Leaves the document as it should be found again: saved where it has a name, kept where it was worked on, and
    /// gone where it was only opened.
    pub(crate) fn leave(self, around: &mut Around) {
        let document = self.document;
        let path = document.path();
        if document.state.untitled && !document.is_worked_on() {
            path.iter().for_each(|path| around.preferences.forget(path));
            around.notices.check(document.discard());
            return;
        }
        if let Some(path) = path {
            around.preferences.remember(&path, &document.title);
        }
        if !document.state.untitled && document.state.modified {
            let mut document = document;
            around.notices.check(document.save());
        }
    }

    /// Time goes on.
    pub(crate) fn advance(&mut self, ui: &Ui, around: &mut Around) {
        self.playback.advance(ui.input(|i| i.time));
        if self.playback.playing() {
            widgets::keep_moving(ui.ctx());
        }
        let frame = self.playback.frame();
        if let Some(message) = self.frames.as_mut().and_then(|frames| frames.update(ui.ctx(), frame)) {
            around.notices.failed(message);
        }
    }

    /// Each picture is held for so many frames while it plays.
    pub(crate) fn hold(&mut self, frames: u64, around: &mut Around) {
        self.playback.held = frames;
        around.preferences.held = frames;
    }

    /// What moves was made anew; it plays.
    pub(crate) fn show_moving(&mut self, moving: Moving, now: f64) {
        if let Ok((frames, fps)) = moving.frames() {
            let (frame, first) = (self.playback.frame(), self.moving.is_none());
            let playing = self.playback.playing() || first;
            let held = self.playback.held;
            self.playback = Playback::new(frames, fps, self.playback.looped);
            self.playback.held = held;
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

    /// How far what runs is; short steps go without a word.
    pub(crate) fn show_progress(&mut self, ui: &mut Ui) {
        let palette = Palette::of(ui);
        let frames = self.document.frames();
        let Some(running) = &mut self.running else { return };
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
        if !running.is_long() {
            return;
        }
        let plain = Frame::new().fill(palette.panel).inner_margin(Margin::symmetric(theme::PAD, 8));
        Panel::top("progress").frame(plain).show(ui, |ui| {
            ui.horizontal(|ui| {
                let what = match &running.purpose {
                    Purpose::Step(step) => texts::step(*step),
                    _ => texts::EXPORTING,
                };
                ui.label(RichText::new(what).strong());
                let line = running.text(frames);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    if ui.button(texts::CANCEL).clicked() {
                        running.cancel();
                    }
                    // As wide as its longest text, so that the bar does not jump.
                    ui.allocate_ui_with_layout(vec2(330.0, 24.0), Layout::left_to_right(Align::Center), |ui| {
                        ui.set_min_width(330.0);
                        ui.add(Label::new(RichText::new(line).color(palette.weak)).truncate());
                    });
                    let (wide, fill) = (ui.available_width(), palette.accent);
                    let bar = ProgressBar::new(running.fraction()).desired_height(8.0).desired_width(wide).fill(fill);
                    ui.add(bar).accessible_name(what);
                });
            });
        });
    }

    /// Playing without a clip.
    pub(crate) fn show_transport(&mut self, ui: &mut Ui) -> Vec<Command> {
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
        let (now, frame, last) = (gui.input(|i| i.time), self.playback.frame(), self.playback.last());
        match command {
            Command::Undo => {
                let done = self.document.undo_one();
                around.notices.check(done);
            }
            Command::Redo => {
                let done = self.document.redo_one();
                around.notices.check(done);
            }
            Command::Play => self.playback.toggle(now),
            Command::NextFrame => self.playback.seek(if frame == last { 0 } else { frame + 1 }, now),
            Command::PreviousFrame => self.playback.seek(frame.checked_sub(1).unwrap_or(last), now),
            Command::FirstFrame => self.playback.seek(0, now),
            Command::LastFrame => self.playback.seek(last, now),
            Command::NextKey | Command::PreviousKey => {
                let keys = &self.document.keys;
                let to = if command == Command::NextKey {
                    keys.iter().find(|k| **k > frame).or(keys.first())
                } else {
                    keys.iter().rev().find(|k| **k < frame).or(keys.last())
                };
                if let Some(to) = to {
                    self.playback.seek(*to, now);
                }
            }
            Command::Loop => {
                self.playback.looped ^= true;
                around.preferences.once = !self.playback.looped;
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
            Command::Save => match self.document.named_path() {
                Some(_) => {
                    let saved = self.document.save();
                    around.notices.check(saved);
                }
                None => self.ask_name(gui, around),
            },
            Command::SaveAs => self.ask_name(gui, around),
            _ => return false,
        }
        true
    }

    fn ask_name(&mut self, gui: &Gui, around: &mut Around) {
        let named = self.document.named_path();
        let folder = named.as_deref().and_then(Path::parent).unwrap_or(&around.places.home).to_owned();
        around.picker.ask(gui, Ask::SaveAs { folder, name: texts::session_file(&self.document.title) });
    }

    /// Saves under a name that was chosen.
    pub(crate) fn save_as(&mut self, path: &Path, around: &mut Around) {
        let ending = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("marey"));
        let path = if ending { path.to_owned() } else { texts::with_session_ending(path) };
        let before = self.document.path();
        if around.notices.check(self.document.save_as(&path)).is_some() {
            if let Some(before) = before.filter(|b| *b != path) {
                around.preferences.recent.retain(|r| r.path != before || before.exists());
            }
            around.preferences.remember(&path, &self.document.title);
        }
    }

    /// Where the export goes was chosen.
    pub(crate) fn set_export_path(&mut self, path: &Path) {
        if let Some(dialog) = &mut self.export {
            dialog.set_path(path);
        }
    }

    /// The folder that the export goes into was chosen.
    pub(crate) fn set_export_folder(&mut self, folder: &Path, around: &mut Around) {
        around.preferences.export.folder = Some(folder.to_owned());
        let (settings, door) = (&around.preferences.export, self.document.door());
        let path = export::path_for(settings, door, folder, &self.document.title);
        self.set_export_path(&path);
    }

    pub(crate) fn show_export(&mut self, ui: &Ui, around: &mut Around) {
        let (Some(mut dialog), Some(moving)) = (self.export.take(), &self.moving) else { return };
        let exported = Exported::Moving(moving, self.playback.frame());
        let (settings, home) = (&mut around.preferences.export, &around.places.home);
        let asked = dialog.show(ui.ctx(), settings, &exported, home, &self.document.title);
        match asked {
            Some(export::Asked::Close) => {}
            Some(export::Asked::Export(path)) => self.start_export(&path, around),
            Some(export::Asked::Browse) => {
                let path = dialog.path();
                let folder = path.parent().filter(|p| p.is_dir()).unwrap_or(&around.places.home).to_owned();
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let folders = around.preferences.export.format(self.document.door()).is_folder();
                let ask = if folders { Ask::ExportFolder { folder } } else { Ask::ExportFile { folder, name } };
                around.picker.ask(ui.ctx(), ask);
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
        let exported = Exported::Moving(moving, self.playback.frame());
        let started = around.preferences.export.start(&around.context, &exported, path);
        if let Some((job, purpose)) = around.notices.check(started) {
            around.preferences.export.folder = path.parent().map(Path::to_owned);
            self.running = Some(Running::new(job, purpose));
        }
    }
}
