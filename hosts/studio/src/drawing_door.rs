//! The third door: a drawing that lives. Mark points on a clip; they are followed, laid on a vector drawing and move it.
//!
//! The machine fills every step in as soon as it can (`drawing_steps`); here is what a person sees and does.

use std::path::Path;

use eframe::egui::{
    Align, CentralPanel, Checkbox, ComboBox, Context as Gui, Frame, Layout, Margin, Panel, Pos2, ScrollArea, Sense,
    Slider, Ui, vec2,
};
use marey_binding::{MotionUse, Part};

use crate::around::Around;
use crate::clip_points::{self, Asked, ClipPoints};
use crate::document::Document;
use crate::drawing_steps::Of;
use crate::filling::{Filling as _, Steps};
use crate::handles::Hand;
use crate::held::{Held, Sheet};
use crate::icons::Icon;
use crate::looking::Looking;
use crate::marks::Marks;
use crate::moving::{Moving, MovingPictures};
use crate::picker::Ask;
use crate::shortcuts::{self, Command};
use crate::solved::Solved;
use crate::theme::{self, Palette};
use crate::workshop::Workshop;
use crate::{sample, texts, timeline, widgets};

/// Fewer points do not say how a drawing lies.
pub(crate) const LEAST: usize = 3;

/// How much stiffer or softer lines can be made.
const STIFFNESS: std::ops::RangeInclusive<f32> = 0.02..=50.0;

pub(crate) struct DrawingDoor {
    pub(crate) shop: Workshop,
    pub(crate) steps: Steps<Of>,
    clip: ClipPoints,
    pub(crate) sheet_looking: Looking,
    pub(crate) sheet_hand: Hand,
    pub(crate) selected: Option<usize>,
    /// Numbers on the drawing, which then stands still unless it plays.
    pub(crate) numbers: bool,
    pub(crate) sheet: Option<Sheet>,
    pub(crate) still: Option<Moving>,
    pub(crate) still_pictures: MovingPictures,
    /// Where the points go.
    pub(crate) solved: Option<Solved>,
    /// What the machine proposes, for which marks and which drawing.
    pub(crate) proposed: Option<(Of, String)>,
    pub(crate) held: Option<Held>,
    /// What the moving drawing was made of.
    pub(crate) moves: Option<Of>,
    /// The slider while it is held.
    stiffness: Option<f32>,
}

impl DrawingDoor {
    pub(crate) fn new(gui: &Gui, document: Document, around: &mut Around) -> Self {
        let mut door = Self {
            shop: Workshop::new(gui, document, around),
            steps: Steps::default(),
            clip: ClipPoints::default(),
            sheet_looking: Looking::default(),
            sheet_hand: Hand::default(),
            selected: None,
            numbers: true,
            sheet: None,
            still: None,
            still_pictures: MovingPictures::new(gui),
            solved: None,
            proposed: None,
            held: None,
            moves: None,
            stiffness: None,
        };
        let first = door.shop.document.keys.first().copied().unwrap_or(0);
        door.shop.playback.seek(first, 0.0);
        door.go_on(around);
        door
    }

    /// Draws everything, and does what was asked for.
    pub(crate) fn show(&mut self, ui: &mut Ui, around: &mut Around) {
        self.watch(ui, around);
        self.shop.advance(ui, around);
        let (now, frame) = (ui.input(|i| i.time), self.shop.playback.frame());
        let palette = Palette::of(ui);
        let plain = Frame::new().fill(palette.panel).inner_margin(Margin::symmetric(theme::PAD, 8));
        self.shop.show_progress(ui);
        let timeline = Panel::bottom("timeline").frame(plain).resizable(false).show(ui, |ui| {
            ui.set_min_height(timeline::HEIGHT - 36.0);
            let Workshop { document, frames, timeline, playback, .. } = &mut self.shop;
            timeline.show(ui, document, frames.as_ref(), playback, None)
        });
        Panel::left("steps").frame(plain).default_size(250.0).size_range(210.0..=360.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.panel(ui, frame, around));
        });
        let half = (ui.available_width() * 0.5).max(200.0);
        Panel::right("sheet").frame(Frame::new()).default_size(half).min_size(200.0).show(ui, |ui| {
            self.show_sheet(ui, frame, around);
        });
        CentralPanel::default().frame(Frame::new()).show(ui, |ui| self.show_clip(ui, frame, around));
        if let Some(command) = shortcuts::space_released(ui.ctx()) {
            let panned = self.clip.looking.space_was_to_pan() | self.sheet_looking.space_was_to_pan();
            if !panned && ui.memory(|m| m.focused().is_none()) {
                self.command(command, ui.ctx(), around);
            }
        }
        for asked in timeline.inner {
            match asked {
                timeline::Asked::Time(timing) => {
                    around.notices.check(self.shop.document.set_timing(timing));
                }
                timeline::Asked::Seek(frame) => self.shop.playback.seek(frame, now),
                timeline::Asked::Do(command) => self.command(command, ui.ctx(), around),
                timeline::Asked::MoveKey(from, to) => {
                    self.mark(texts::EDIT_MOVE_KEY, around, |marks| marks.move_frame(from, to));
                    self.shop.playback.seek(to, now);
                }
            }
        }
        self.shop.show_export(ui, around);
    }

    pub(crate) fn mark(&mut self, label: &str, around: &mut Around, change: impl FnOnce(&mut Marks)) {
        let marked = self.shop.document.set_marks(label, change);
        around.notices.check(marked);
        self.selected = self.selected.filter(|point| *point < self.shop.document.marks.points.len());
        self.go_on(around);
    }

    /// The steps, each with what can be corrected of it.
    fn panel(&mut self, ui: &mut Ui, frame: u64, around: &mut Around) {
        let count = self.shop.document.marks.points.len();
        widgets::section(ui, &texts::points(count));
        if count == 0 {
            widgets::remark(ui, texts::NO_POINTS);
        }
        let mut removed = None;
        ui.spacing_mut().item_spacing.y = 2.0;
        for point in 0..count {
            let mark = &self.shop.document.marks.points[point];
            let (name, keys) = (texts::point_name(point, &mark.name), mark.keys.len());
            ui.push_id(point, |ui| {
                ui.horizontal(|ui| {
                    let (rect, _) = ui.allocate_exact_size(vec2(20.0, 22.0), Sense::hover());
                    ui.painter().circle_filled(rect.center(), 6.0, theme::limb(point));
                    let on = self.selected == Some(point);
                    let button = eframe::egui::Button::selectable(on, &name).truncate();
                    let wide = (ui.available_width() - 36.0).max(60.0);
                    let row = ui.add_sized(vec2(wide, 24.0), button.right_text(texts::times_marked(keys)));
                    if row.accessible_name(texts::select_point(point)).clicked() {
                        self.selected = (!on).then_some(point);
                    }
                    if widgets::icon_button(ui, Icon::Close, &texts::remove_point(point)).clicked() {
                        removed = Some(point);
                    }
                });
            });
        }
        ui.spacing_mut().item_spacing.y = theme::GAP;
        if let Some(point) = removed {
            self.mark(texts::EDIT_REMOVE_POINT, around, |marks| drop(marks.points.remove(point)));
        }
        if count > 0 {
            widgets::remark(ui, if self.selected.is_some() { texts::POINT_SELECTED } else { texts::MORE_POINTS });
        }
        if let Some(point) = self.selected
            && self.held.is_some()
        {
            self.leave_off(ui, point, around);
        }
        ui.add_space(theme::GAP);
        ui.separator();
        self.choose_drawing(ui, around);
        if self.held.is_some() {
            ui.add_space(theme::GAP);
            ui.separator();
            self.correct(ui, frame, around);
        }
    }

    /// Whether the point holds the drawing; at least as many as are needed do.
    fn leave_off(&mut self, ui: &mut Ui, point: usize, around: &mut Around) {
        let document = &mut self.shop.document;
        let Some(name) = document.marks.points.get(point).map(|p| p.name.clone()) else { return };
        let mut on = document.is_on_drawing(&name);
        let others = document.marks.points.iter().filter(|p| p.name != name && document.is_on_drawing(&p.name)).count();
        let check = ui.add_enabled(!on || others >= LEAST, Checkbox::new(&mut on, texts::ON_DRAWING));
        if check.on_hover_text(texts::ON_DRAWING_HINT).changed() {
            let set = document.set_on_drawing(&name, on);
            around.notices.check(set);
            self.go_on(around);
        }
    }

    fn choose_drawing(&mut self, ui: &mut Ui, around: &mut Around) {
        widgets::section(ui, texts::DRAWING);
        if ui.button(texts::CHOOSE_DRAWING).clicked() {
            around.picker.ask(ui.ctx(), Ask::Drawing);
        }
        let mut chosen = None;
        let list = ComboBox::from_id_salt("drawings").width(ui.available_width() - 12.0).selected_text(texts::OURS);
        let list = list.show_ui(ui, |ui| {
            for (name, svg) in sample::DRAWINGS {
                if ui.selectable_label(false, name).clicked() {
                    chosen = Some(svg);
                }
            }
        });
        list.response.accessible_name(texts::OURS);
        if let Some(svg) = chosen {
            self.set_drawing(svg.as_bytes(), around);
        }
    }

    fn set_drawing(&mut self, svg: &[u8], around: &mut Around) {
        // How another drawing was held says nothing of this one.
        let parts = [(Part::Drawing, Some(svg)), (Part::Binding, None)];
        let set = self.shop.document.set_parts(texts::EDIT_DRAWING, &parts);
        around.notices.check(set);
        self.go_on(around);
    }

    /// What can be corrected of how the drawing is held.
    fn correct(&mut self, ui: &mut Ui, frame: u64, around: &mut Around) {
        let Some(held) = &self.held else { return };
        let how = held.how.clone();
        widgets::section(ui, texts::LAID);
        widgets::remark(ui, texts::LAID_HINT);
        let mut mirror = how.mirror;
        if ui.checkbox(&mut mirror, texts::MIRRORED).on_hover_text(texts::MIRRORED_HINT).changed() {
            self.rebind(Some(how.frame), Some(mirror), around);
        }
        let mut on_spot = how.travel == 0.0;
        if ui.checkbox(&mut on_spot, texts::ON_SPOT).on_hover_text(texts::ON_SPOT_HINT).changed() {
            let travel = if on_spot { 0.0 } else { 1.0 };
            self.change_held(texts::EDIT_HOW, around, |binding, _| {
                binding.set_motion(&MotionUse { travel, ..binding.motion(0)? })
            });
        }
        widgets::remark(ui, texts::like_frame(how.frame));
        if ui.button(texts::LIKE_THIS).on_hover_text(texts::LIKE_THIS_HINT).clicked() {
            self.rebind(Some(frame), None, around);
        }
        ui.add_space(theme::GAP);
        ui.separator();
        widgets::section(ui, texts::STIFFNESS);
        let now = self.held.as_ref().map_or(1.0, |held| held.stiffness);
        let mut stiffness = self.stiffness.unwrap_or(now);
        ui.spacing_mut().slider_width = ui.available_width() - 12.0;
        let slider = Slider::new(&mut stiffness, STIFFNESS).logarithmic(true).show_value(false);
        let slider = ui.add(slider).accessible_name(texts::STIFFNESS_NAME).on_hover_text(texts::STIFFNESS_HINT);
        ui.horizontal(|ui| {
            widgets::remark(ui, texts::SOFT);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| widgets::remark(ui, texts::STIFF));
        });
        if slider.changed() {
            self.stiffness = Some(stiffness);
        }
        let held_still = slider.is_pointer_button_down_on() || slider.dragged();
        if let Some(stiffness) = self.stiffness.filter(|_| !held_still) {
            self.stiffness = None;
            self.change_held(texts::EDIT_STIFFNESS, around, |binding, sheet| {
                sheet.strokes.iter().try_for_each(|stroke| {
                    let decoration = binding.stroke(stroke)?.1;
                    binding.set_stroke(stroke, stiffness, decoration)
                })
            });
        }
    }

    /// What comes next, in the bar. It always leads on.
    pub(crate) fn show_steps(&mut self, ui: &mut Ui, around: &mut Around) {
        let document = &self.shop.document;
        let text = if document.marks.points.len() < LEAST {
            texts::NEXT_MARK
        } else if self.sheet.is_none() {
            texts::CHOOSE_A_DRAWING
        } else {
            texts::EXPORT
        };
        if widgets::primary_button(ui, text).clicked() {
            self.next(ui.ctx(), around);
        }
    }

    fn next(&mut self, gui: &Gui, around: &mut Around) {
        if self.steps.try_again() {
            // What was cancelled or went wrong is tried again.
            self.go_on(around);
        } else if self.shop.document.marks.points.len() < LEAST {
            self.find_points(around);
        } else if self.sheet.is_none() {
            around.picker.ask(gui, Ask::Drawing);
        } else {
            self.command(Command::Export, gui, around);
        }
    }

    pub(crate) fn command(&mut self, command: Command, gui: &Gui, around: &mut Around) {
        let frame = self.shop.playback.frame();
        match command {
            Command::Make => self.next(gui, around),
            Command::Cancel => {
                let held = self.clip.cancel() | self.sheet_hand.cancel();
                if !held {
                    self.selected = None;
                }
            }
            Command::NextLimb => {
                let count = self.shop.document.marks.points.len();
                self.selected = (count > 0).then(|| self.selected.map_or(0, |point| (point + 1) % count));
            }
            Command::RemoveStroke => {
                if let Some(point) = self.selected {
                    self.mark(texts::EDIT_UNMARK, around, |marks| marks.take(point, frame));
                }
            }
            Command::NextCorrection => {
                let shown = (self.selected, frame);
                let worst = self.shop.document.tracked.as_ref().and_then(|t| t.next_correction(shown));
                if let Some(worst) = worst {
                    self.shop.playback.stop();
                    self.shop.playback.seek(worst.frame, 0.0);
                    self.selected = Some(worst.track as usize);
                }
            }
            Command::Paths => self.clip.paths ^= true,
            Command::Tracks => self.numbers ^= true,
            Command::Fit => {
                self.clip.looking.fit();
                self.sheet_looking.fit();
            }
            Command::ZoomIn | Command::ZoomOut => drop(self.clip.looking.command(command)),
            _ => {
                if self.shop.command(command, gui, around) && matches!(command, Command::Undo | Command::Redo) {
                    self.selected = self.selected.filter(|point| *point < self.shop.document.marks.points.len());
                    self.go_on(around);
                }
            }
        }
    }

    /// What a dropped or chosen file is for here; false for what opens another document.
    pub(crate) fn take_file(&mut self, path: &Path, around: &mut Around) -> bool {
        let is = |ending: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
        if is("svg") {
            let read = std::fs::read(path).map_err(|e| texts::unreadable(path, &e));
            if let Some(svg) = around.notices.check(read) {
                self.set_drawing(&svg, around);
            }
            return true;
        }
        if is("json") {
            let read = around.context.read_control_points(&path.to_string_lossy()).and_then(|points| points.to_json());
            if let Some(json) = around.notices.check(read) {
                let parts = [(Part::Points, Some(json.as_bytes()))];
                let set = self.shop.document.set_parts(texts::EDIT_TAKE_POINTS, &parts);
                around.notices.check(set);
                self.selected = None;
                self.go_on(around);
            }
            return true;
        }
        false
    }

    fn show_clip(&mut self, ui: &mut Ui, frame: u64, around: &mut Around) {
        let numbers: Vec<usize> = (0..self.shop.document.marks.points.len()).collect();
        let hint = (numbers.len() < LEAST).then_some(texts::MARK_HINT);
        let asked = self.clip.show(ui, &self.shop, (&numbers, self.selected), hint, |_| {});
        match asked {
            Some(Asked::Mark(at)) => {
                self.shop.playback.stop();
                self.mark(texts::EDIT_MARK, around, |marks| marks.put(numbers.len(), frame, at));
                self.selected = None;
            }
            Some(Asked::Move(point, at)) => {
                self.shop.playback.stop();
                self.selected = Some(point);
                self.mark(texts::EDIT_MOVE_POINT, around, |marks| marks.put(point, frame, at));
            }
            Some(Asked::Select(point)) => self.selected = point,
            None => {}
        }
    }

    /// Where a place of the clip is on the screen.
    pub(crate) fn on_screen(&self, at: (f32, f32)) -> Pos2 {
        self.clip.looking.on_screen(at)
    }

    /// Where a place of the drawing is on the screen.
    pub(crate) fn on_sheet(&self, at: (f32, f32)) -> Pos2 {
        self.sheet_looking.on_screen(at)
    }

    /// Where the points are in the frame that is shown.
    pub(crate) fn points(&self) -> Vec<(f32, f32)> {
        let numbers: Vec<usize> = (0..self.shop.document.marks.points.len()).collect();
        let handles = clip_points::handles(&self.shop.document, self.shop.playback.frame(), &numbers);
        handles.iter().map(|h| h.at).collect()
    }

    /// Where the points hold the drawing, by number.
    pub(crate) fn handles(&self) -> Vec<(usize, (f32, f32))> {
        self.sheet_handles().iter().map(|h| (h.number, h.at)).collect()
    }
}
