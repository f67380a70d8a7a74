//! The first door: a creature from a clip. Draw, make, look, export, on one screen.

use std::path::Path;
use std::sync::Arc;

use eframe::egui::{Align, CentralPanel, Context as Gui, Frame, Layout, Margin, Panel, Pos2, Ui};
use marey_binding::{Creature, Facing, Masks};

use crate::around::Around;
use crate::canvas::{self, Canvas, Shown};
use crate::document::{Document, Door, Limb};
use crate::export::{self, ExportDialog, Exported, ShownCreature};
use crate::frames::Frames;
use crate::icons::Icon;
use crate::limbs_panel::{self, LimbsPanel};
use crate::overlaps::{Bones, Overlap, Said};
use crate::playback::Playback;
use crate::running::{Ended, Purpose, Running};
use crate::shortcuts::Command;
use crate::theme::{self, Palette};
use crate::timeline::{self, Timeline};
use crate::view3d::View3d;
use crate::{methods, overlaps, shortcuts, texts, widgets};

/// A creature that was made, and the masks it was made of.
struct Made {
    creature: Arc<Creature>,
    masks: Masks,
    bones: Bones,
}

pub(crate) struct CreatureDoor {
    pub(crate) document: Document,
    frames: Option<Frames>,
    canvas: Canvas,
    limbs: LimbsPanel,
    timeline: Timeline,
    pub(crate) playback: Playback,
    view3d: View3d,
    /// The limb that is drawn next; none for a new one.
    pub(crate) selected: Option<usize>,
    running: Option<Running>,
    made: Option<Made>,
    /// What was said of limbs' depth when the creature in the making was begun.
    making: Said,
    /// Where limbs lie over each other in the frame that is shown; none while it plays.
    pub(crate) overlaps: Vec<Overlap>,
    pub(crate) export: Option<ExportDialog>,
    /// Whether it is shown by what the creature is made.
    methods: bool,
    /// Whether the list of plugins was asked for.
    pub(crate) wants_plugins: bool,
}

impl CreatureDoor {
    pub(crate) fn new(gui: &Gui, document: Document, around: &mut Around) -> Self {
        document.greet(around);
        let fps = document.clip.as_ref().map_or(0.0, |(_, info)| info.fps);
        let mut door = Self {
            frames: None,
            canvas: Canvas::default(),
            limbs: LimbsPanel::default(),
            timeline: Timeline::default(),
            playback: Playback::new(document.frames(), fps, !around.preferences.once),
            view3d: View3d::new(gui),
            selected: None,
            running: None,
            made: None,
            making: Said::new(),
            overlaps: Vec::new(),
            export: None,
            methods: false,
            wants_plugins: false,
            document,
        };
        door.playback.seek(door.document.keys.first().copied().unwrap_or(0), 0.0);
        if let Some((clip, info)) = &door.document.clip {
            door.frames = Some(Frames::new(gui, clip.clone(), info));
        }
        // What is drawn already can be seen at once, made.
        if !door.document.limbs.is_empty() && door.document.clip.is_some() {
            door.make(around);
        }
        door
    }

    /// Whether a job runs.
    pub(crate) fn is_busy(&self) -> bool {
        self.running.is_some()
    }

    /// Whether there is a creature to look at.
    pub(crate) fn has_creature(&self) -> bool {
        self.made.is_some()
    }

    /// How many pictures the 3D view has shown.
    pub(crate) fn pictures(&self) -> u64 {
        self.view3d.pictures
    }

    /// Where a place of the clip is on the screen.
    pub(crate) fn on_screen(&self, at: (f32, f32)) -> Pos2 {
        self.canvas.looking.on_screen(at)
    }

    /// The document, to be left. A job has nothing to give to a session that is gone.
    pub(crate) fn leave(self, around: &mut Around) {
        drop(self.running);
        self.document.leave(around);
    }

    /// Draws everything, and does what was asked for.
    pub(crate) fn show(&mut self, ui: &mut Ui, around: &mut Around) {
        self.watch(ui, around);
        let now = ui.input(|i| i.time);
        self.playback.take(self.document.timing(), &around.context);
        self.playback.advance(now);
        if self.playback.playing() {
            widgets::keep_moving(ui.ctx());
        }
        let frame = self.playback.frame();
        if let Some(message) = self.frames.as_mut().and_then(|frames| frames.update(ui.ctx(), frame)) {
            around.notices.failed(message);
        }
        self.find_overlaps(around);
        let palette = Palette::of(ui);
        let plain = Frame::new().fill(palette.panel).inner_margin(Margin::symmetric(theme::PAD, 8));

        if let Some(running) = &mut self.running {
            Panel::top("progress").frame(plain).show(ui, |ui| running.show(ui, self.document.frames()));
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
        }
        let timeline = Panel::bottom("timeline").frame(plain).resizable(false).show(ui, |ui| {
            ui.set_min_height(timeline::HEIGHT - 36.0);
            let onion = &mut around.preferences.onion;
            self.timeline.show(ui, &self.document, self.frames.as_ref(), &self.playback, Some(onion))
        });
        let limbs = Panel::left("limbs")
            .frame(plain)
            .default_size(250.0)
            .size_range(210.0..=360.0)
            .show(ui, |ui| self.limbs.show(ui, &self.document, (frame, &self.overlaps), self.selected));
        if let Some(made) = &self.made {
            let half = (ui.available_width() * 0.5).max(200.0);
            let bounds = self.document.tracked.as_ref().map(|t| t.bounds);
            let height = self.document.clip.as_ref().map_or(1.0, |(_, info)| info.height as f32);
            let beside = Frame::new().fill(palette.panel).inner_margin(Margin::same(6));
            Panel::right("creature").frame(beside).default_size(half).min_size(200.0).show(ui, |ui| {
                let bounds = bounds.unwrap_or([0.0, 0.0, height, height]);
                self.view3d.show(ui, &made.creature, frame, bounds, height);
            });
        }
        let done = CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
            let shown = Shown {
                document: &self.document,
                frames: self.frames.as_ref(),
                masks: self.made.as_ref().map(|m| &m.masks),
                frame,
                selected: self.selected,
                overlaps: &self.overlaps,
                onion: around.preferences.onion,
                looped: self.playback.looped,
            };
            self.canvas.show(ui, &shown)
        });
        if let Some(command) = shortcuts::space_released(ui.ctx())
            && !self.canvas.looking.space_was_to_pan()
            && ui.memory(|m| m.focused().is_none())
        {
            self.command(command, ui.ctx(), around);
        }
        for asked in timeline.inner {
            match asked {
                timeline::Asked::Time(timing) => {
                    around.notices.check(self.document.set_timing(timing));
                }
                timeline::Asked::Seek(frame) => self.playback.seek(frame, now),
                timeline::Asked::Do(command) => self.command(command, ui.ctx(), around),
                timeline::Asked::MoveKey(from, to) => {
                    let moved = self.document.move_key(from, to);
                    around.notices.check(moved);
                    self.playback.seek(to, now);
                    self.follow();
                }
            }
        }
        for asked in limbs.inner {
            self.edit_limb(asked, frame, around);
        }
        for done in done.inner {
            match done {
                canvas::Done::Selected(limb) => self.selected = limb,
                canvas::Done::Turned(limb) => self.turn(limb, frame, around),
                canvas::Done::Ordered { limb, before, other } => self.order(limb, before, &[other], around),
                canvas::Done::Unordered(limb) => self.say_depths(&[(limb, None)], around),
                canvas::Done::Painted(hint) => {
                    self.playback.stop();
                    around.notices.check(self.document.paint(frame, &hint));
                }
                canvas::Done::RemovePaint => {
                    around.notices.check(self.document.remove_paint(frame));
                }
                canvas::Done::Drew(points) => self.draw(&points, frame, around),
            }
        }
        self.show_export(ui, around);
        self.show_methods(ui, around);
    }

    /// By what the creature is made.
    fn show_methods(&mut self, ui: &Ui, around: &mut Around) {
        let Some(plugins) = around.plugins.as_mut().filter(|_| self.methods) else { return };
        let (asked, open) = methods::show(ui.ctx(), &self.document, plugins);
        self.methods = open;
        match asked {
            Some(methods::Asked::Use(step, id)) => {
                let chosen = self.document.set_method(step, &id);
                around.notices.check(chosen);
                self.follow();
            }
            Some(methods::Asked::Plugin(ask)) => plugins.ask(ask, &mut around.preferences.plugins),
            Some(methods::Asked::Plugins) => {
                self.methods = false;
                self.wants_plugins = true;
            }
            None => {}
        }
    }

    /// The steps and what comes next, in the bar at the top.
    pub(crate) fn show_steps(&mut self, ui: &mut Ui, around: &mut Around) {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let stale = self.document.state.creature_outdated;
            let (made, busy) = (self.made.is_some(), self.is_making());
            let export = shortcuts::hint(ui.ctx(), texts::EXPORT_HINT, Command::Export);
            let make = shortcuts::hint(ui.ctx(), texts::MAKE_HINT, Command::Make);
            if made && !stale {
                if widgets::primary_button(ui, texts::EXPORT).on_hover_text(export).clicked() {
                    self.command(Command::Export, ui.ctx(), around);
                }
            } else {
                // While it is made, the line below says how far it is.
                let text = if made { texts::UPDATE } else { texts::MAKE };
                if !busy && widgets::primary_button(ui, text).on_hover_text(make).clicked() {
                    self.command(Command::Make, ui.ctx(), around);
                }
                if made && ui.button(texts::EXPORT).on_hover_text(export).clicked() {
                    self.command(Command::Export, ui.ctx(), around);
                }
            }
            if widgets::command_button(ui, Icon::Sliders, texts::METHODS, Command::Methods) {
                self.command(Command::Methods, ui.ctx(), around);
            }
        });
    }

    fn is_making(&self) -> bool {
        self.running.as_ref().is_some_and(|r| r.purpose == Purpose::Creature)
    }

    /// Takes in what a job made.
    fn watch(&mut self, ui: &Ui, around: &mut Around) {
        let Some(ended) = self.running.as_mut().and_then(Running::poll) else { return };
        let Some(running) = self.running.take() else { return };
        ui.ctx().request_repaint();
        match ended {
            _ if running.given_up => {}
            Ended::Failed(error) => around.notices.failed(error),
            Ended::Cancelled => around.notices.done(texts::CANCELLED.into()),
            Ended::Done => match running.purpose {
                Purpose::Creature => {
                    let made = self.document.take(&running.job, true).and_then(|()| {
                        let (creature, masks) = (running.job.take_creature()?, running.job.take_masks()?);
                        let height = self.document.clip.as_ref().map_or(0.0, |(_, info)| info.height as f32);
                        let bones = Bones::new(&creature, std::mem::take(&mut self.making), height)?;
                        Ok(Made { creature: Arc::new(creature), masks, bones })
                    });
                    if let Some(made) = around.notices.check(made) {
                        self.made = Some(made);
                        self.view3d.renew();
                        self.canvas.forget_mask();
                        if !self.playback.playing() {
                            self.playback.toggle(ui.input(|i| i.time));
                        }
                    }
                }
                Purpose::Track => {
                    around.notices.check(self.document.take(&running.job, false));
                }
                Purpose::Export { path, .. } => around.notices.done(texts::exported(&path)),
                Purpose::Step(_) => {}
            },
        }
        self.follow();
    }

    /// Tracks anew what was corrected, beside the person who goes on. The first time is left to [`Command::Make`].
    fn follow(&mut self) {
        let stale = self.document.tracked.is_some() && self.document.state.motion_outdated;
        // Following is a step too, after which nothing could be done again.
        if !stale
            || self.document.redo.is_some()
            || self.running.is_some()
            || self.document.clip.is_none()
            || self.document.limbs.is_empty()
        {
            return;
        }
        // What is half drawn cannot be followed yet; making the creature says what is missing.
        if let Ok(job) = self.document.start_track() {
            self.running = Some(Running::new(job, Purpose::Track));
        }
    }

    fn make(&mut self, around: &mut Around) {
        if self.document.limbs.is_empty() {
            around.notices.failed(texts::DRAW_FIRST);
            return;
        }
        if let Some(job) = around.notices.check(self.document.start_creature()) {
            self.running = Some(Running::new(job, Purpose::Creature));
            self.making = self.document.depths_said();
        }
    }

    /// Finds where limbs lie over each other in the frame that is shown.
    fn find_overlaps(&mut self, around: &mut Around) {
        self.overlaps.clear();
        let Some(made) = self.made.as_mut().filter(|_| !self.playback.playing()) else { return };
        let found = made.bones.overlaps(&made.creature, &self.document, self.playback.frame());
        self.overlaps = around.notices.check(found).unwrap_or_default();
    }

    /// Says that a limb is in front of others on this frame, or behind them.
    fn order(&mut self, limb: usize, before: bool, others: &[usize], around: &mut Around) {
        let Some(made) = &mut self.made else { return };
        let frame = self.playback.frame();
        let said = made.bones.order(&made.creature, &self.document, frame, (limb, before, others));
        if let Some(said) = around.notices.check(said) {
            self.say_depths(&said, around);
        }
    }

    /// By the key: before all that it crosses where it is behind any, else behind all.
    fn order_by_key(&mut self, around: &mut Around) {
        if self.made.is_none() {
            around.notices.failed(texts::MAKE_TO_ORDER);
            return;
        }
        let Some(limb) = self.selected else {
            around.notices.failed(texts::SELECT_TO_ORDER);
            return;
        };
        self.playback.stop();
        self.find_overlaps(around);
        let crossed: Vec<(bool, usize)> = overlaps::of(&self.overlaps, limb).collect();
        if crossed.is_empty() {
            around.notices.failed(texts::crosses_nothing(&self.document.limbs[limb].label));
            return;
        }
        let before = crossed.iter().any(|(before, _)| !before);
        let others: Vec<usize> = crossed.into_iter().map(|(_, other)| other).collect();
        self.order(limb, before, &others, around);
    }

    fn say_depths(&mut self, said: &[(usize, Option<f32>)], around: &mut Around) {
        if said.is_empty() {
            return;
        }
        let done = self.document.set_depths(self.playback.frame(), said);
        around.notices.check(done);
        self.follow();
    }

    fn draw(&mut self, points: &[(f32, f32)], frame: u64, around: &mut Around) {
        self.playback.stop();
        let drawn = match self.selected {
            Some(limb) => self.document.draw(limb, frame, points),
            None => self.document.add_limb(frame, points).map(drop),
        };
        around.notices.check(drawn);
        self.follow();
    }

    /// What the end of a stroke says of the third dimension, one after the other.
    fn turn(&mut self, limb: usize, frame: u64, around: &mut Around) {
        let Some(stroke) = self.document.stroke(limb, frame) else { return };
        let facing = match stroke.facing {
            Facing::Unknown => Facing::Toward,
            Facing::Toward => Facing::Away,
            Facing::Away => Facing::Unknown,
        };
        let turned = self.document.set_facing(limb, frame, facing);
        around.notices.check(turned);
        self.selected = Some(limb);
        self.follow();
    }

    fn edit_limb(&mut self, asked: limbs_panel::Asked, frame: u64, around: &mut Around) {
        let document = &mut self.document;
        // It may be gone: a name that was being typed comes when its field has been left, by an undo too.
        let of = |document: &Document, limb: usize| document.limbs.get(limb).cloned();
        let edited = match asked {
            limbs_panel::Asked::Select(limb) => {
                self.selected = limb;
                return;
            }
            limbs_panel::Asked::Name(limb, name) => {
                let Some(Limb { side, .. }) = of(document, limb) else { return };
                document.set_limb(limb, &name, side)
            }
            limbs_panel::Asked::Side(limb, side) => {
                let Some(Limb { label, .. }) = of(document, limb) else { return };
                document.set_limb(limb, &label, side)
            }
            limbs_panel::Asked::Facing(limb, facing) => document.set_facing(limb, frame, facing),
            limbs_panel::Asked::Order { limb, before, other } => {
                self.order(limb, before, &[other], around);
                return;
            }
            limbs_panel::Asked::RemoveStroke(limb) => document.remove_stroke(limb, frame),
            limbs_panel::Asked::RemoveLimb(limb) => {
                self.selected = None;
                document.remove_limb(limb)
            }
        };
        around.notices.check(edited);
        self.follow();
    }

    /// Does what a key or a button asked for.
    pub(crate) fn command(&mut self, command: Command, gui: &Gui, around: &mut Around) {
        let (now, frame) = (gui.input(|i| i.time), self.playback.frame());
        if self.canvas.command(command) || self.view3d.command(command) {
            return;
        }
        if self.playback.command(command, &self.document.keys, now) {
            around.preferences.once = !self.playback.looped;
            return;
        }
        match command {
            Command::Undo | Command::Redo => {
                let done = if command == Command::Undo { self.document.undo_one() } else { self.document.redo_one() };
                around.notices.check(done);
                // It follows what may just have been taken back.
                if let Some(running) = self.running.as_mut().filter(|r| r.purpose == Purpose::Track) {
                    running.give_up();
                }
                self.selected = self.selected.filter(|limb| *limb < self.document.limbs.len());
                self.follow();
            }
            Command::Cancel => {
                if self.canvas.drawing() {
                    self.canvas.cancel();
                } else {
                    self.selected = None;
                }
            }
            Command::NextCorrection => {
                let shown = (self.selected, frame);
                let worst = self.document.tracked.as_ref().and_then(|t| t.next_correction(shown));
                if let Some(worst) = worst {
                    self.playback.stop();
                    self.playback.seek(worst.frame, now);
                    self.selected = Some(worst.track as usize).filter(|limb| *limb < self.document.limbs.len());
                }
            }
            Command::Onion => around.preferences.onion.on ^= true,
            Command::Facing => {
                if let Some(limb) = self.selected {
                    self.turn(limb, frame, around);
                }
            }
            Command::Order => self.order_by_key(around),
            Command::NewLimb => self.selected = None,
            Command::NextLimb => {
                let count = self.document.limbs.len();
                self.selected = (count > 0).then(|| self.selected.map_or(0, |limb| (limb + 1) % count));
            }
            Command::RemoveStroke => {
                if let Some(limb) = self.selected.filter(|limb| self.document.stroke(*limb, frame).is_some()) {
                    let removed = self.document.remove_stroke(limb, frame);
                    around.notices.check(removed);
                    self.follow();
                }
            }
            Command::Make if !self.is_making() => self.make(around),
            Command::Methods => self.methods = true,
            Command::Export => {
                if self.made.is_none() {
                    around.notices.failed(texts::MAKE_FIRST);
                } else if self.export.is_none() {
                    let (settings, home) = (&around.preferences.export, &around.places.home);
                    self.export = Some(ExportDialog::new(settings, Door::Creature, home, &self.document.title));
                }
            }
            Command::ExportAgain => {
                let (settings, home) = (&around.preferences.export, &around.places.home);
                let path = export::path_for(settings, Door::Creature, home, &self.document.title);
                self.start_export(&path, around);
            }
            Command::Save => self.document.save_or_ask(gui, around),
            Command::SaveAs => self.document.ask_name(gui, around),
            _ => {}
        }
    }

    /// What a dropped or chosen file is for here; false for what opens another document.
    pub(crate) fn take_file(&mut self, path: &Path, around: &mut Around) -> bool {
        if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
            return false;
        }
        let taken = self.document.take_strokes(&around.context, &path.to_string_lossy());
        around.notices.check(taken);
        self.selected = None;
        self.follow();
        true
    }

    fn exported(&self) -> Option<Exported<'_>> {
        let (made, (_, clip)) = (self.made.as_ref()?, self.document.clip.as_ref()?);
        let bounds = self.document.tracked.as_ref()?.bounds;
        Some(Exported::Creature(ShownCreature {
            creature: &made.creature,
            clip,
            played: self.playback.played(),
            style: self.view3d.style,
            camera: self.view3d.camera(bounds, clip.height as f32),
        }))
    }

    fn show_export(&mut self, ui: &Ui, around: &mut Around) {
        let Some(mut dialog) = self.export.take() else { return };
        let Some(exported) = self.exported() else { return };
        let (settings, home) = (&mut around.preferences.export, &around.places.home);
        let asked = dialog.show(ui.ctx(), settings, &exported, home, &self.document.title);
        match asked {
            Some(export::Asked::Close) => {}
            Some(export::Asked::Export(path)) => self.start_export(&path, around),
            Some(export::Asked::Browse) => {
                let folders = around.preferences.export.format(Door::Creature).is_folder();
                around.picker.ask(ui.ctx(), dialog.browse(folders, &around.places.home));
                self.export = Some(dialog);
            }
            None => self.export = Some(dialog),
        }
    }

    fn start_export(&mut self, path: &Path, around: &mut Around) {
        if self.running.as_ref().is_some_and(|r| r.purpose != Purpose::Track) {
            around.notices.failed(texts::BUSY);
            return;
        }
        let Some(exported) = self.exported() else {
            around.notices.failed(texts::MAKE_FIRST);
            return;
        };
        self.running = export::start(&exported, path, around);
    }
}
