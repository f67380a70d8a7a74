//! The whole program but for its window: one screen at a time, what lies over all of them, and what is remembered.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Align, Frame, Label, Layout, Margin, Panel, RichText, Ui};
use marey_binding::{Access, Context};

use crate::around::Around;
use crate::character_door::CharacterDoor;
use crate::creature_door::CreatureDoor;
use crate::document::{Document, Door};
use crate::drawing_door::DrawingDoor;
use crate::export::{ExportDialog, path_for};
use crate::help::Help;
use crate::icons::Icon;
use crate::notices::Notices;
use crate::opening::{Opening, Source};
use crate::picker::{Ask, Picker};
use crate::plugins::Plugins;
use crate::preferences::{Appearance, Preferences};
use crate::shortcuts::{self, Command};
use crate::start::{self, Start};
use crate::theme::{self, Palette};
use crate::{Places, plugins_panel, texts, widgets};

enum Screen {
    /// What there is to open is found out when it is shown.
    Start(Option<Box<Start>>),
    Opening(Opening),
    Creature(Box<CreatureDoor>),
    Character(Box<CharacterDoor>),
    Drawing(Box<DrawingDoor>),
}

impl Screen {
    /// What is open.
    fn document(&self) -> Option<&Document> {
        match self {
            Self::Creature(door) => Some(&door.document),
            Self::Character(door) => Some(&door.shop.document),
            Self::Drawing(door) => Some(&door.shop.document),
            Self::Start(_) | Self::Opening(_) => None,
        }
    }

    /// What is open, and the dialog for its exports where that is open.
    fn at_work(&mut self) -> Option<(&mut Document, Option<&mut ExportDialog>)> {
        match self {
            Self::Creature(door) => Some((&mut door.document, door.export.as_mut())),
            Self::Character(door) => Some((&mut door.shop.document, door.shop.export.as_mut())),
            Self::Drawing(door) => Some((&mut door.shop.document, door.shop.export.as_mut())),
            Self::Start(_) | Self::Opening(_) => None,
        }
    }

    fn show_steps(&mut self, ui: &mut Ui, around: &mut Around) {
        match self {
            Self::Creature(door) => door.show_steps(ui, around),
            Self::Character(door) => door.show_steps(ui, around),
            Self::Drawing(door) => door.show_steps(ui, around),
            Self::Start(_) | Self::Opening(_) => {}
        }
    }
}

/// The program.
pub struct Studio {
    around: Around,
    /// The preferences as they were written last.
    written: Preferences,
    screen: Screen,
    /// To be opened as soon as there is a window.
    first: Option<Source>,
    help: Option<Help>,
    plugins: bool,
    set_up: bool,
}

impl Studio {
    /// # Errors
    /// The library does not start; for a person.
    pub fn new(places: Places) -> Result<Self, String> {
        let context = Context::new(0).map_err(|e| e.to_string())?;
        let preferences = Preferences::read(&places.preferences);
        let written = preferences.clone();
        let (notices, picker) = (Notices::default(), Picker::default());
        Ok(Self {
            around: Around { context, places, preferences, notices, picker, plugins: None },
            written,
            screen: Screen::Start(None),
            first: None,
            help: None,
            plugins: false,
            set_up: false,
        })
    }

    /// Opens a clip or a session when the window is drawn next.
    pub fn open_file(&mut self, path: &Path) {
        // A session refers to its clip by where it is, not by where the program was started.
        self.first = Some(Source::of_path(&std::path::absolute(path).unwrap_or_else(|_| path.to_owned())));
    }

    /// Opens a clip for a drawing that lives when the window is drawn next.
    pub fn open_for_drawing(&mut self, path: &Path) {
        self.first = Some(Source::DrawingClip(std::path::absolute(path).unwrap_or_else(|_| path.to_owned())));
    }

    /// Opens a picture for a character when the window is drawn next.
    pub fn open_picture(&mut self, path: &Path) {
        self.first = Some(Source::Picture(path.to_owned()));
    }

    /// Asks for files in the window, whether the system has dialogs for it or not.
    pub fn ask_for_paths(&mut self) {
        self.around.picker.here = true;
    }

    /// Draws everything, and does what was asked for. Call it for every picture of the window.
    pub fn ui(&mut self, ui: &mut Ui) {
        if !self.set_up {
            theme::apply(ui.ctx());
            theme::set_light(ui.ctx(), self.around.preferences.light);
            shortcuts::choose(ui.ctx(), &self.around.preferences.keys);
            self.set_up = true;
            let Around { context, places, preferences, .. } = &self.around;
            self.around.plugins = Some(Plugins::start(ui.ctx(), context, places, &preferences.plugins));
            // The style of this picture was taken before.
            ui.set_style(ui.ctx().global_style());
        }
        self.receive(ui);
        for command in shortcuts::pressed(ui.ctx()) {
            self.command(command, ui.ctx());
        }
        self.bar(ui);
        match &mut self.screen {
            Screen::Start(start) => {
                let recent = &self.around.preferences.recent;
                let start = start.get_or_insert_with(|| {
                    Box::new(Start::new(ui.ctx(), &self.around.context, &self.around.places, recent))
                });
                if let Some(asked) = start.show(ui) {
                    self.begin(asked, ui.ctx());
                }
            }
            Screen::Opening(opening) => waiting(ui, &opening.source),
            Screen::Creature(door) => {
                door.show(ui, &mut self.around);
                self.plugins |= std::mem::take(&mut door.wants_plugins);
            }
            Screen::Character(door) => door.show(ui, &mut self.around),
            Screen::Drawing(door) => door.show(ui, &mut self.around),
        }
        if let Some(help) = &mut self.help
            && !help.show(ui.ctx(), &mut self.around.preferences.keys)
        {
            self.help = None;
        }
        self.show_plugins(ui.ctx());
        drop_target(ui);
        self.around.notices.show(ui.ctx());
        if self.around.preferences != self.written {
            self.written = self.around.preferences.clone();
            self.around.notices.check(
                self.around.preferences.write(&self.around.places.preferences).map_err(|e| texts::no_memory(&e)),
            );
        }
    }

    /// Leaves everything as it should be found again. What is open is kept.
    pub fn close(&mut self) {
        self.leave();
        // There is nobody left to tell.
        let _ = self.around.preferences.write(&self.around.places.preferences);
    }

    /// Every line that the program has to say now.
    pub fn notices(&self) -> Vec<String> {
        self.around.notices.texts().map(str::to_owned).collect()
    }

    /// What is open, for tests and measurements.
    pub fn open(&self) -> Option<Open<'_>> {
        self.screen.document().map(|document| Open(&self.screen, document))
    }

    /// What is new about plugins, and the list of them while it is open.
    fn show_plugins(&mut self, gui: &egui::Context) {
        let Some(plugins) = &mut self.around.plugins else { return };
        for line in plugins.update() {
            match line {
                Ok(done) => self.around.notices.done(done),
                Err(failed) => self.around.notices.failed(failed),
            }
        }
        if self.plugins {
            let folder = self.around.places.plugins.to_string_lossy();
            let (asked, open) = plugins_panel::show(gui, plugins, &folder);
            self.plugins = open;
            if let Some(ask) = asked {
                plugins.ask(ask, &mut self.around.preferences.plugins);
            }
        }
    }

    /// What came from other threads and from outside.
    fn receive(&mut self, ui: &Ui) {
        if let Some(source) = self.first.take() {
            self.open_source(source, ui.ctx());
        }
        let dropped: Vec<PathBuf> =
            ui.input(|i| i.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        for path in dropped {
            self.take_file(&path, None, ui.ctx());
        }
        if let Some((ask, path)) = self.around.picker.show(ui.ctx(), &self.around.places.home) {
            match (&ask, &mut self.screen) {
                (Ask::DrawingClip, _) => self.open_source(Source::DrawingClip(path), ui.ctx()),
                (Ask::Picture, Screen::Start(_)) => self.open_source(Source::Picture(path), ui.ctx()),
                (Ask::Clip | Ask::Session, _) => self.take_file(&path, None, ui.ctx()),
                (Ask::Picture | Ask::Drawing | Ask::Motion | Ask::MotionClip, _) => {
                    self.take_file(&path, Some(&ask), ui.ctx());
                }
                (Ask::SaveAs { .. }, screen) => {
                    if let Some((document, _)) = screen.at_work() {
                        document.save_under(&path, &mut self.around);
                    }
                }
                (Ask::ExportFile { .. }, screen) => {
                    if let Some((_, Some(dialog))) = screen.at_work() {
                        dialog.set_path(&path);
                    }
                }
                (Ask::ExportFolder { .. }, screen) => {
                    if let Some((document, dialog)) = screen.at_work() {
                        let settings = &mut self.around.preferences.export;
                        settings.folder = Some(path.clone());
                        if let Some(dialog) = dialog {
                            dialog.set_path(&path_for(settings, document.door(), &path, &document.title));
                        }
                    }
                }
            }
        }
        if let Screen::Opening(opening) = &self.screen
            && let Some(answer) = opening.answer()
        {
            self.screen = Screen::Start(None);
            if let Some(mut document) = self.around.notices.check(answer) {
                if let Some(path) = document.path() {
                    // A session without a name keeps what it was called for its clip, through a crash too.
                    if document.state.untitled
                        && let Some(title) = self.around.preferences.title(&path)
                    {
                        document.title = title.to_owned();
                    }
                    self.around.preferences.remember(&path, &document.title);
                }
                let (gui, around) = (ui.ctx(), &mut self.around);
                self.screen = match document.door() {
                    Door::Creature => Screen::Creature(Box::new(CreatureDoor::new(gui, document, around))),
                    Door::Character => Screen::Character(Box::new(CharacterDoor::new(gui, document, around))),
                    Door::Drawing => Screen::Drawing(Box::new(DrawingDoor::new(gui, document, around))),
                };
            }
        }
    }

    fn take_file(&mut self, path: &Path, asked: Option<&Ask>, gui: &egui::Context) {
        let around = &mut self.around;
        let taken = match &mut self.screen {
            Screen::Creature(door) => door.take_file(path, around),
            Screen::Character(door) => door.take_file(gui, path, asked, around),
            Screen::Drawing(door) => door.take_file(path, around),
            Screen::Start(_) | Screen::Opening(_) => false,
        };
        if !taken {
            self.open_source(Source::of_path(path), gui);
        }
    }

    fn open_source(&mut self, source: Source, gui: &egui::Context) {
        self.leave();
        let plugins = self.around.plugins.as_ref().map(Plugins::first_look).unwrap_or_default();
        self.screen = Screen::Opening(Opening::start(gui, &self.around.context, &self.around.places, plugins, source));
    }

    fn leave(&mut self) {
        match std::mem::replace(&mut self.screen, Screen::Start(None)) {
            Screen::Creature(door) => door.leave(&mut self.around),
            Screen::Character(door) => door.shop.document.leave(&mut self.around),
            Screen::Drawing(door) => door.shop.document.leave(&mut self.around),
            Screen::Start(_) | Screen::Opening(_) => {}
        }
    }

    fn begin(&mut self, asked: start::Asked, gui: &egui::Context) {
        match asked {
            start::Asked::PickClip => self.around.picker.ask(gui, Ask::Clip),
            start::Asked::PickPicture => self.around.picker.ask(gui, Ask::Picture),
            start::Asked::PickDrawingClip => self.around.picker.ask(gui, Ask::DrawingClip),
            start::Asked::PickSession => self.around.picker.ask(gui, Ask::Session),
            start::Asked::Open(source) => self.open_source(source, gui),
            start::Asked::Discard(path) => {
                let session = self.around.context.open_session(&path.to_string_lossy(), Access::Edit);
                self.around.notices.check(session.and_then(marey_binding::Session::discard));
                self.around.preferences.forget(&path);
                self.screen = Screen::Start(None);
            }
            start::Asked::Forget(path) => {
                self.around.preferences.forget(&path);
                self.screen = Screen::Start(None);
            }
        }
    }

    fn command(&mut self, command: Command, gui: &egui::Context) {
        match command {
            Command::OpenClip => self.around.picker.ask(gui, Ask::Clip),
            Command::Open => self.around.picker.ask(gui, Ask::Session),
            Command::Help => self.help = Some(Help::default()),
            Command::Plugins => self.plugins = true,
            Command::Light => {
                let light = if gui.theme() == egui::Theme::Dark { Appearance::Light } else { Appearance::Dark };
                self.around.preferences.light = light;
                theme::set_light(gui, light);
            }
            Command::Start => self.leave(),
            _ => match &mut self.screen {
                Screen::Creature(door) => door.command(command, gui, &mut self.around),
                Screen::Character(door) => door.command(command, gui, &mut self.around),
                Screen::Drawing(door) => door.command(command, gui, &mut self.around),
                Screen::Start(_) | Screen::Opening(_) => {}
            },
        }
    }

    /// Where one is, what can be undone, and what comes next.
    fn bar(&mut self, ui: &mut Ui) {
        let palette = Palette::of(ui);
        let frame = Frame::new().fill(palette.panel).inner_margin(Margin::symmetric(theme::PAD, 8));
        let mut commands = Vec::new();
        Panel::top("bar").frame(frame).exact_size(48.0).show(ui, |ui| {
            ui.horizontal_centered(|ui| {
                let mut button = |ui: &mut Ui, on: bool, icon: Icon, text: &str, command: Command| {
                    ui.add_enabled_ui(on, |ui| {
                        if widgets::command_button(ui, icon, text, command) {
                            commands.push(command);
                        }
                    });
                };
                if let Some(document) = self.screen.document() {
                    button(ui, true, Icon::Home, texts::TO_START, Command::Start);
                    ui.label(RichText::new(&document.title).size(16.0).strong());
                    saved(ui, document);
                    ui.add_space(12.0);
                    let undo = texts::with_what(texts::UNDO, document.undo());
                    button(ui, document.undo().is_some(), Icon::Undo, &undo, Command::Undo);
                    let redo = texts::with_what(texts::REDO, document.redo.as_deref());
                    button(ui, document.redo.is_some(), Icon::Redo, &redo, Command::Redo);
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let mut button = |ui: &mut Ui, icon: Icon, text: &str, command: Command| {
                        if widgets::command_button(ui, icon, text, command) {
                            commands.push(command);
                        }
                    };
                    button(ui, Icon::Help, texts::SHORTCUTS, Command::Help);
                    button(ui, Icon::Sun, texts::LIGHT, Command::Light);
                    button(ui, Icon::Plug, texts::PLUGINS, Command::Plugins);
                    ui.add_space(8.0);
                    self.screen.show_steps(ui, &mut self.around);
                });
            });
        });
        for command in commands {
            self.command(command, ui.ctx());
        }
    }
}

/// What is open in a [`Studio`].
pub struct Open<'a>(&'a Screen, &'a Document);

impl Open<'_> {
    fn creature(&self) -> Option<&CreatureDoor> {
        if let Screen::Creature(door) = self.0 { Some(door) } else { None }
    }

    /// The limbs' labels.
    pub fn limbs(&self) -> Vec<String> {
        self.1.limbs.iter().map(|l| l.label.clone()).collect()
    }

    /// The frames that are drawn or marked on.
    pub fn key_frames(&self) -> &[u64] {
        &self.1.keys
    }

    /// A limb's stroke on a frame, in clip pixels.
    pub fn stroke(&self, limb: usize, frame: u64) -> Option<&[(f32, f32)]> {
        self.1.stroke(limb, frame).map(|s| &s.points[..])
    }

    /// The marked points, each with the frames and places of its marks.
    pub fn marks(&self) -> Vec<Vec<(u64, (f32, f32))>> {
        self.1.marks.points.iter().map(|p| p.keys.iter().map(|k| (k.frame, k.at)).collect()).collect()
    }

    /// Where marked points hold the drawing: their numbers from 0, and places in its pixels.
    pub fn handles(&self) -> Vec<(usize, (f32, f32))> {
        if let Screen::Drawing(door) = self.0 { door.handles() } else { Vec::new() }
    }

    /// Where the marked points are in the frame that is shown: marked there, or followed to it.
    pub fn points(&self) -> Vec<(f32, f32)> {
        match self.0 {
            Screen::Drawing(door) => door.points(),
            Screen::Character(door) => door.points().into_iter().map(|(_, at)| at).collect(),
            _ => Vec::new(),
        }
    }

    /// The character's joints.
    pub fn joints(&self) -> Vec<(String, (f32, f32))> {
        if let Screen::Character(door) = self.0 { door.joints() } else { Vec::new() }
    }

    /// Where a limb was tracked on a frame, in clip pixels.
    pub fn tracked(&self, limb: usize, frame: u64) -> Option<&[(f32, f32)]> {
        let frames = self.1.tracked.as_ref()?.limbs.get(limb)?;
        frames.get(frame as usize).map(|f| &f.points[..])
    }

    /// The frame that is shown.
    pub fn frame(&self) -> u64 {
        match self.0 {
            Screen::Creature(door) => door.playback.frame(),
            Screen::Character(door) => door.shop.playback.frame(),
            Screen::Drawing(door) => door.shop.playback.frame(),
            Screen::Start(_) | Screen::Opening(_) => 0,
        }
    }

    /// Whether it plays.
    pub fn playing(&self) -> bool {
        match self.0 {
            Screen::Creature(door) => door.playback.playing(),
            Screen::Character(door) => door.shop.playback.playing(),
            Screen::Drawing(door) => door.shop.playback.playing(),
            Screen::Start(_) | Screen::Opening(_) => false,
        }
    }

    /// The limb that is drawn next, or the point or joint that is selected; none for a new one.
    pub fn selected(&self) -> Option<usize> {
        match self.0 {
            Screen::Creature(door) => door.selected,
            Screen::Character(door) => door.selected,
            Screen::Drawing(door) => door.selected,
            Screen::Start(_) | Screen::Opening(_) => None,
        }
    }

    /// Whether a job runs.
    pub fn is_busy(&self) -> bool {
        match self.0 {
            Screen::Creature(door) => door.is_busy(),
            Screen::Character(door) => door.is_busy(),
            Screen::Drawing(door) => door.shop.running.is_some(),
            Screen::Start(_) | Screen::Opening(_) => false,
        }
    }

    /// Whether there is a creature.
    pub fn has_creature(&self) -> bool {
        self.creature().is_some_and(CreatureDoor::has_creature)
    }

    /// Where limbs lie over each other in the frame that is shown: the one in front, the one behind, and the place.
    pub fn overlaps(&self) -> Vec<(usize, usize, (f32, f32))> {
        let overlaps = self.creature().map_or(&[][..], |door| &door.overlaps);
        overlaps.iter().map(|o| (o.front, o.behind, o.at)).collect()
    }

    /// How many times marked points were followed since it was opened.
    pub fn followed(&self) -> u64 {
        match self.0 {
            Screen::Character(door) => door.steps.followed,
            Screen::Drawing(door) => door.steps.followed,
            _ => 0,
        }
    }

    /// Whether a character or a drawing moves.
    pub fn moves(&self) -> bool {
        match self.0 {
            Screen::Character(door) => door.shop.moving.is_some(),
            Screen::Drawing(door) => door.shop.moving.is_some(),
            _ => false,
        }
    }

    /// Whether limbs are to be tracked, for the first time or again.
    pub fn is_motion_outdated(&self) -> bool {
        self.1.state.motion_outdated
    }

    /// How many gestures were finished in the session, undo and redo included.
    pub fn gestures(&self) -> u64 {
        self.1.state.gestures
    }

    /// A number that is the same for sessions that are alike to the last bit.
    ///
    /// # Errors
    /// The library fails.
    pub fn fingerprint(&self) -> Result<u64, String> {
        self.1.fingerprint().map_err(|e| e.to_string())
    }

    /// What undo would take back, and what redo would do again.
    pub fn steps(&self) -> (Option<&str>, Option<&str>) {
        (self.1.undo(), self.1.redo.as_deref())
    }

    /// Where a place of the clip, or of a character's picture, is on the screen.
    pub fn on_screen(&self, at: (f32, f32)) -> egui::Pos2 {
        match self.0 {
            Screen::Creature(door) => door.on_screen(at),
            Screen::Character(door) => door.on_screen(at),
            Screen::Drawing(door) => door.on_screen(at),
            Screen::Start(_) | Screen::Opening(_) => egui::Pos2::ZERO,
        }
    }

    /// Where a place of the clip that a character's motion is taken from is on the screen.
    pub fn on_clip(&self, at: (f32, f32)) -> egui::Pos2 {
        if let Screen::Character(door) = self.0 { door.on_clip(at) } else { egui::Pos2::ZERO }
    }

    /// Where a place of the drawing is on the screen.
    pub fn on_sheet(&self, at: (f32, f32)) -> egui::Pos2 {
        if let Screen::Drawing(door) = self.0 { door.on_sheet(at) } else { egui::Pos2::ZERO }
    }

    /// How many pictures of what was made were shown.
    pub fn pictures(&self) -> u64 {
        match self.0 {
            Screen::Creature(door) => door.pictures(),
            Screen::Character(door) => door.shop.pictures.count,
            Screen::Drawing(door) => door.shop.pictures.count,
            Screen::Start(_) | Screen::Opening(_) => 0,
        }
    }
}

/// Whether all of it is in a file of the user's, in a word.
fn saved(ui: &mut Ui, document: &Document) {
    let palette = Palette::of(ui);
    let state = &document.state;
    let (text, color) = match (state.untitled, state.modified) {
        (true, _) => (texts::NOT_SAVED, palette.weak),
        (false, true) => (texts::MODIFIED, palette.weak),
        (false, false) => (texts::SAVED, palette.good),
    };
    ui.label(RichText::new(text).size(12.0).color(color)).on_hover_text(texts::SAVED_HINT);
}

fn waiting(ui: &mut Ui, source: &Source) {
    egui::CentralPanel::default().show(ui, |ui| {
        ui.vertical_centered(|ui| {
            ui.add_space(ui.available_height() * 0.4);
            ui.spinner();
            ui.add_space(theme::GAP);
            ui.add(Label::new(texts::opening(&source.name())));
        });
    });
}

/// Says that what is held over the window can be let go.
fn drop_target(ui: &Ui) {
    if ui.input(|i| i.raw.hovered_files.is_empty()) {
        return;
    }
    let palette = Palette::of(ui);
    let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop"));
    let painter = ui.ctx().layer_painter(layer);
    let rect = ui.ctx().content_rect().shrink(12.0);
    painter.rect_filled(rect, 12.0, palette.panel.gamma_multiply(0.9));
    painter.rect_stroke(rect, 12.0, egui::Stroke::new(2.0, palette.accent), egui::StrokeKind::Inside);
    let font = egui::FontId::proportional(24.0);
    painter.text(rect.center(), egui::Align2::CENTER_CENTER, texts::DROP, font, palette.text);
}
