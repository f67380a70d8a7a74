//! The third door: a drawing that lives. Mark points on a clip; they are followed, laid on a vector drawing and move it.
//!
//! The machine fills every step in as soon as it can: marks are followed, what moves is laid on the drawing, and the drawing
//! moves. What it proposes is not part of the document until a person corrects it, so that undo takes back what a person
//! did and nothing else.

use std::path::Path;
use std::sync::Arc;

use eframe::egui::{
    Align, CentralPanel, Color32, ComboBox, Context as Gui, Frame, Layout, Margin, Panel, PointerButton, Pos2, Rect,
    Response, Role, ScrollArea, Sense, Slider, Stroke, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use marey_binding::{BindOptions, Binding, BoundPoint, Drawing, Job, Motion, MotionUse, Part, Result};

use crate::around::Around;
use crate::document::Document;
use crate::frames::Frames;
use crate::handles::{Done, Hand, Handle};
use crate::icons::Icon;
use crate::moving::{Moving, MovingPictures};
use crate::picker::Ask;
use crate::running::{Purpose, Running, Step};
use crate::shortcuts::{self, Command};
use crate::theme::{self, Palette};
use crate::view::View;
use crate::workshop::{Watched, Workshop};
use crate::{overlay, sample, texts, timeline, widgets};

/// Fewer points do not say how a drawing lies.
const LEAST: usize = 3;

/// How much stiffer or softer lines can be made.
const STIFFNESS: std::ops::RangeInclusive<f32> = 0.02..=50.0;

/// The drawing of the document, read.
struct Sheet {
    /// What it was read from.
    of: Arc<Vec<u8>>,
    drawing: Drawing,
    strokes: Vec<String>,
    size: Vec2,
}

/// How the drawing is held, as it is now: what a person said, and what the machine proposes for the rest.
struct Held {
    json: String,
    points: Vec<BoundPoint>,
    how: MotionUse,
    stiffness: f32,
}

/// What something was made of: the marks, the drawing, and how it was held.
#[derive(Clone, Debug, Default, PartialEq)]
struct Of {
    points: Option<Arc<Vec<u8>>>,
    drawing: Option<Arc<Vec<u8>>>,
    held: String,
}

pub(crate) struct DrawingDoor {
    pub(crate) shop: Workshop,
    view: View,
    sheet_view: View,
    hand: Hand,
    sheet_hand: Hand,
    pub(crate) selected: Option<usize>,
    paths: bool,
    /// Numbers on the drawing, which then stands still unless it plays.
    numbers: bool,
    sheet: Option<Sheet>,
    still: Option<Moving>,
    still_pictures: MovingPictures,
    /// Where the points go, and the marks that it was made of.
    motion: Option<(Arc<Vec<u8>>, Motion)>,
    /// What the machine proposes, for which marks and which drawing.
    proposed: Option<(Of, String)>,
    held: Option<Held>,
    /// What the moving drawing was made of.
    moves: Option<Of>,
    /// What runs was begun for these; what failed for them is not tried again.
    begun: Option<(Step, Of)>,
    failed: Option<(Step, Of)>,
    /// The slider while it is held.
    stiffness: Option<f32>,
    panel: Rect,
    sheet_panel: Rect,
}

impl DrawingDoor {
    pub(crate) fn new(gui: &Gui, document: Document, around: &mut Around) -> Self {
        let mut door = Self {
            shop: Workshop::new(gui, document, around),
            view: View::default(),
            sheet_view: View::default(),
            hand: Hand::default(),
            sheet_hand: Hand::default(),
            selected: None,
            paths: true,
            numbers: true,
            sheet: None,
            still: None,
            still_pictures: MovingPictures::new(gui),
            motion: None,
            proposed: None,
            held: None,
            moves: None,
            begun: None,
            failed: None,
            stiffness: None,
            panel: Rect::NOTHING,
            sheet_panel: Rect::NOTHING,
        };
        let first = door.shop.document.keys.first().copied().unwrap_or(0);
        door.shop.playback.seek(first, 0.0);
        door.take_known_motion(around);
        door.go_on(around);
        door
    }

    /// A motion that comes with the marks it was made of, as samples do, needs no tracking.
    fn take_known_motion(&mut self, around: &mut Around) {
        let document = &self.shop.document;
        let (Some(points), Some(json)) = (document.part(Part::Points).cloned(), document.text(Part::Motion)) else {
            return;
        };
        let Ok(motion) = around.context.motion_from_json(json) else { return };
        if passes_marks(&motion, document).unwrap_or(false) {
            self.take_motion(points, motion, around);
        }
    }

    fn take_motion(&mut self, points: Arc<Vec<u8>>, motion: Motion, around: &mut Around) {
        let next = std::str::from_utf8(&points)
            .ok()
            .and_then(|json| around.context.control_points_from_json(json).ok())
            .and_then(|points| motion.point_report(&points).ok())
            .map(|report| next_corrections(&report))
            .unwrap_or_default();
        let taken = self.shop.document.take_points(Some(&motion), &next);
        around.notices.check(taken);
        self.motion = Some((points, motion));
    }

    /// Starts what can be filled in next, after every change.
    fn go_on(&mut self, around: &mut Around) {
        let document = &mut self.shop.document;
        let points = document.part(Part::Points).cloned();
        match (&points, &self.motion) {
            (None, Some(_)) => {
                self.motion = None;
                around.notices.check(document.take_points(None, &[]));
            }
            // Names and places may have changed since.
            (Some(points), Some((of, motion))) if points != of => {
                let next: Vec<_> = Vec::new();
                around.notices.check(document.take_points(Some(motion), &next));
            }
            _ => {}
        }
        self.read_sheet(around);
        self.hold(around);
        let wanted = self.next_step(points.as_ref());
        if let Some(running) = &mut self.shop.running {
            // What runs for what is no more is stopped; what was asked for by hand goes on.
            let outdated = matches!(running.purpose, Purpose::Step(step) if step != Step::Rebind)
                && self.begun.as_ref() != wanted.as_ref();
            if outdated && wanted.is_some() {
                running.give_up();
            }
            return;
        }
        let Some(wanted) = wanted.filter(|w| self.failed.as_ref() != Some(w)) else { return };
        let started = self.start(wanted.0, around);
        match started {
            Ok(Some(job)) => {
                self.shop.running = Some(Running::new(job, Purpose::Step(wanted.0)));
                self.begun = Some(wanted);
            }
            Ok(None) => {}
            Err(error) => {
                around.notices.failed(error);
                self.failed = Some(wanted);
            }
        }
    }

    /// The step that is to be done, and what it is to be done for.
    fn next_step(&self, points: Option<&Arc<Vec<u8>>>) -> Option<(Step, Of)> {
        let sheet = self.sheet.as_ref();
        let drawing = sheet.map(|sheet| sheet.of.clone());
        if sheet.is_some() && self.still.is_none() {
            return Some((Step::Still, Of { drawing, ..Of::default() }));
        }
        let points = points.filter(|_| self.shop.document.clip.is_some())?;
        if self.motion.as_ref().is_none_or(|(of, _)| of != points) {
            return Some((Step::Points, Of { points: Some(points.clone()), ..Of::default() }));
        }
        sheet?;
        if self.shop.document.marks.points.len() < LEAST {
            return None;
        }
        let of = Of { points: Some(points.clone()), drawing, held: String::new() };
        let Some(held) = &self.held else { return Some((Step::Bind, of)) };
        let of = Of { held: held.json.clone(), ..of };
        (self.moves.as_ref() != Some(&of)).then_some((Step::Move, of))
    }

    fn start(&self, step: Step, around: &Around) -> Result<Option<Job>> {
        let (context, document) = (&around.context, &self.shop.document);
        match step {
            Step::Points => {
                let (Some((clip, _)), Some(json)) = (&document.clip, document.text(Part::Points)) else {
                    return Ok(None);
                };
                let points = context.control_points_from_json(json)?;
                context.start_point_track(clip, &points, true).map(Some)
            }
            Step::Bind => self.start_bind(None, None, around),
            Step::Still => {
                let Some(sheet) = &self.sheet else { return Ok(None) };
                let (w, h) = (sheet.size.x, sheet.size.y);
                let motion = context.motion_from_json(&one_frame(&[("still", (w / 2.0, h / 2.0))], (w, h)))?;
                let binding = context.new_binding(&sheet.drawing)?;
                binding.set_motion(&MotionUse {
                    name: "still".into(),
                    scale: 1.0,
                    rotation: 0.0,
                    mirror: false,
                    frame: 0,
                    travel: 1.0,
                    repeat: false,
                })?;
                binding.set_point("", "still", 0, (w / 2.0, h / 2.0), "")?;
                context.start_sketch_take(&sheet.drawing, &binding, &[&motion]).map(Some)
            }
            Step::Move => {
                let (Some(sheet), Some(held), Some((_, motion))) = (&self.sheet, &self.held, &self.motion) else {
                    return Ok(None);
                };
                let binding = context.binding_from_json(&held.json)?;
                context.start_sketch_take(&sheet.drawing, &binding, &[motion]).map(Some)
            }
            Step::Rebind | Step::Character => Ok(None),
        }
    }

    fn start_bind(&self, frame: Option<u64>, mirror: Option<bool>, around: &Around) -> Result<Option<Job>> {
        let (Some(sheet), Some((_, motion))) = (&self.sheet, &self.motion) else { return Ok(None) };
        let clip = self.shop.document.clip.as_ref().map(|(clip, _)| &**clip);
        let options = BindOptions { clip, frame, mirror, ..BindOptions::default() };
        around.context.start_bind(&sheet.drawing, motion, &options).map(Some)
    }

    /// Lays what moves on the drawing anew, in place of what was corrected.
    fn rebind(&mut self, frame: Option<u64>, mirror: Option<bool>, around: &mut Around) {
        if self.shop.running.is_some() {
            around.notices.failed(texts::BUSY);
            return;
        }
        let started = self.start_bind(frame, mirror, around);
        if let Some(Some(job)) = around.notices.check(started) {
            self.shop.running = Some(Running::new(job, Purpose::Step(Step::Rebind)));
            self.begun = None;
        }
    }

    fn watch(&mut self, ui: &Ui, around: &mut Around) {
        let Some(watched) = self.shop.watch(ui, around) else { return };
        let now = ui.input(|i| i.time);
        match watched {
            // What is no more is begun anew; what failed for these is not.
            Watched::Failed => self.failed = self.begun.take(),
            Watched::Outdated => self.begun = None,
            Watched::Done(step, running) => {
                let of = self.begun.take().map(|b| b.1).unwrap_or_default();
                let taken = self.take(step, &running.job, of, now, around);
                around.notices.check(taken);
            }
        }
        self.go_on(around);
    }

    fn take(&mut self, step: Step, job: &Job, of: Of, now: f64, around: &mut Around) -> Result<()> {
        match step {
            Step::Points => {
                let motion = job.take_motion()?;
                if let Some(points) = of.points {
                    self.take_motion(points, motion, around);
                }
            }
            Step::Bind => self.proposed = Some((of, job.take_binding()?.to_json()?)),
            Step::Rebind => {
                let json = job.take_binding()?.to_json()?;
                self.shop.document.set_parts(texts::EDIT_REBIND, &[(Part::Binding, Some(json.as_bytes()))])?;
            }
            Step::Still => self.still = Some(Moving::Drawing(Arc::new(job.take_sketch_take()?))),
            Step::Move => {
                let take = Moving::Drawing(Arc::new(job.take_sketch_take()?));
                self.moves = Some(of);
                self.shop.show_moving(take, now);
            }
            Step::Character => {}
        }
        Ok(())
    }

    /// Reads the drawing where it is another.
    fn read_sheet(&mut self, around: &mut Around) {
        let Some(of) = self.shop.document.part(Part::Drawing) else {
            self.sheet = None;
            self.still = None;
            self.shop.moving = None;
            self.moves = None;
            return;
        };
        if self.sheet.as_ref().is_some_and(|sheet| sheet.of == *of) {
            return;
        }
        let read = || {
            let drawing = around.context.drawing_from_svg(&String::from_utf8_lossy(of))?;
            let info = drawing.info()?;
            let strokes = (0..info.strokes).map(|i| drawing.stroke(i).map(|s| s.name)).collect::<Result<_>>()?;
            let size = vec2(info.size.0 as f32, info.size.1 as f32);
            Ok::<_, marey_binding::Error>(Sheet { of: of.clone(), drawing, strokes, size })
        };
        let read = read();
        self.sheet = around.notices.check(read);
        self.still = None;
        self.still_pictures.clear();
        self.shop.moving = None;
        self.shop.pictures.clear();
        self.moves = None;
        self.sheet_view.fit();
    }

    /// Puts together how the drawing is held.
    fn hold(&mut self, around: &mut Around) {
        self.held = None;
        let (Some(sheet), Some((points, motion))) = (&self.sheet, &self.motion) else { return };
        if self.shop.document.part(Part::Points) != Some(points) {
            return;
        }
        let is_of_these = |of: &Of| of.points.as_ref() == Some(points) && of.drawing.as_ref() == Some(&sheet.of);
        let proposed = self.proposed.as_ref().filter(|p| is_of_these(&p.0)).map(|p| &p.1);
        let said = self.shop.document.text(Part::Binding);
        let held = held(&around.context, sheet, motion, said, proposed.map(String::as_str));
        // Without an answer there is something to be proposed yet.
        self.held = around.notices.check(held).flatten();
    }

    /// Changes how the drawing is held, one step of undo.
    fn change_held(&mut self, label: &str, around: &mut Around, change: impl FnOnce(&Binding, &Sheet) -> Result<()>) {
        let (Some(held), Some(sheet)) = (&self.held, &self.sheet) else { return };
        let changed = || {
            let binding = around.context.binding_from_json(&held.json)?;
            change(&binding, sheet)?;
            binding.to_json()
        };
        if let Some(json) = around.notices.check(changed()) {
            let set = self.shop.document.set_parts(label, &[(Part::Binding, Some(json.as_bytes()))]);
            around.notices.check(set);
        }
        self.go_on(around);
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
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.steps(ui, frame, around));
        });
        let half = (ui.available_width() * 0.5).max(200.0);
        Panel::right("sheet").frame(Frame::new()).default_size(half).min_size(200.0).show(ui, |ui| {
            self.show_sheet(ui, frame, around);
        });
        CentralPanel::default().frame(Frame::new()).show(ui, |ui| self.show_clip(ui, frame, around));
        if let Some(command) = shortcuts::space_released(ui.ctx()).filter(|_| ui.memory(|m| m.focused().is_none())) {
            self.command(command, ui.ctx(), around);
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

    fn mark(&mut self, label: &str, around: &mut Around, change: impl FnOnce(&mut crate::marks::Marks)) {
        let marked = self.shop.document.set_marks(label, change);
        around.notices.check(marked);
        self.selected = self.selected.filter(|point| *point < self.shop.document.marks.points.len());
        self.go_on(around);
    }

    /// The steps, each with what can be corrected of it.
    fn steps(&mut self, ui: &mut Ui, frame: u64, around: &mut Around) {
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
        ui.add_space(theme::GAP);
        ui.separator();
        self.choose_drawing(ui, around);
        if self.held.is_some() {
            ui.add_space(theme::GAP);
            ui.separator();
            self.correct(ui, frame, around);
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

    fn clip_size(&self) -> Vec2 {
        self.shop.document.clip.as_ref().map_or(Vec2::ZERO, |(_, i)| vec2(i.width as f32, i.height as f32))
    }

    /// The points in a frame of the clip: as they were marked, else as they were followed, else as marked elsewhere.
    fn clip_handles(&self, frame: u64) -> Vec<Handle> {
        let document = &self.shop.document;
        let of = |(number, mark): (usize, &crate::marks::Mark)| {
            if let Some(key) = mark.keys.iter().find(|k| k.frame == frame) {
                return Some(Handle { number, at: key.at, sure: 1.0, by_hand: true });
            }
            let tracked = document.tracked.as_ref().and_then(|t| t.limbs.get(number)?.get(frame as usize));
            match tracked {
                Some(at) => {
                    let (at, sure) = (*at.points.first()?, *at.confidence.first()?);
                    Some(Handle { number, at, sure, by_hand: false })
                }
                None => Some(Handle { number, at: mark.keys.first()?.at, sure: 0.0, by_hand: false }),
            }
        };
        document.marks.points.iter().enumerate().filter_map(of).collect()
    }

    /// The same points on the drawing, as it was drawn.
    fn sheet_handles(&self) -> Vec<Handle> {
        let Some(held) = &self.held else { return Vec::new() };
        let said = self.shop.document.part(Part::Binding).is_some();
        let number = |track: &str| self.shop.document.marks.points.iter().position(|p| p.name == track);
        let of = |p: &BoundPoint| Some(Handle { number: number(&p.track)?, at: p.at, sure: 1.0, by_hand: said });
        held.points.iter().filter_map(of).collect()
    }

    fn show_clip(&mut self, ui: &mut Ui, frame: u64, around: &mut Around) {
        let palette = Palette::of(ui);
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        self.panel = panel;
        painter.rect_filled(panel, 0.0, palette.canvas);
        let Some((_, info)) = &self.shop.document.clip else {
            let font = eframe::egui::FontId::proportional(15.0);
            painter.text(panel.center(), eframe::egui::Align2::CENTER_CENTER, texts::NO_CLIP, font, palette.weak);
            response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, texts::NO_CLIP));
            return;
        };
        let name = texts::canvas_name(frame, info.frames);
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, &name));
        let size = self.clip_size();
        look_around(ui, &response, &mut self.view, size);
        let placed = self.view.place(panel, size);
        let picture = placed.picture(size);
        match self.shop.frames.as_ref().and_then(Frames::picture) {
            Some(texture) => drop(painter.image(texture.id(), picture, WHOLE, Color32::WHITE)),
            None => drop(painter.rect_filled(picture, 0.0, palette.raised)),
        }
        if self.paths {
            overlay::paths(&painter, placed, &self.shop.document, frame, self.selected);
        }
        let handles = self.clip_handles(frame);
        let done = self.hand.act(ui, &response, placed, &handles);
        self.hand.paint(&painter, placed, &handles, self.selected);
        toolbar(ui, panel, |ui| {
            if widgets::word_toggle(ui, texts::PATHS, self.paths, Command::Paths) {
                self.paths ^= true;
            }
            if widgets::command_button(ui, Icon::Fit, texts::FIT, Command::Fit) {
                self.view.fit();
            }
        });
        if handles.len() < LEAST {
            crate::canvas::hint(&painter, panel, texts::MARK_HINT);
        }
        match done {
            Some(Done::Clicked(at)) if picture.contains(placed.to_screen(at)) => {
                self.shop.playback.stop();
                let point = self.shop.document.marks.points.len();
                self.mark(texts::EDIT_MARK, around, |marks| marks.put(point, frame, at));
                self.selected = None;
            }
            Some(Done::Clicked(_)) => self.selected = None,
            Some(Done::Selected(point)) => self.selected = Some(point),
            Some(Done::Moved(point, at)) => {
                self.shop.playback.stop();
                self.selected = Some(point);
                self.mark(texts::EDIT_MOVE_POINT, around, |marks| marks.put(point, frame, at));
            }
            None => {}
        }
    }

    fn show_sheet(&mut self, ui: &mut Ui, frame: u64, around: &mut Around) {
        let palette = Palette::of(ui);
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        self.sheet_panel = panel;
        painter.rect_filled(panel, 0.0, palette.canvas);
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, texts::SHEET_NAME));
        let Some(size) = self.sheet.as_ref().map(|sheet| sheet.size) else {
            painter.vline(panel.left(), panel.y_range(), Stroke::new(1.0, palette.outline));
            let middle = Rect::from_center_size(panel.center(), vec2(panel.width() - 60.0, 120.0));
            ui.scope_builder(eframe::egui::UiBuilder::new().max_rect(middle), |ui| {
                ui.vertical_centered(|ui| {
                    widgets::remark(ui, texts::NO_DRAWING);
                    ui.add_space(theme::GAP);
                    if widgets::primary_button(ui, texts::CHOOSE_A_DRAWING).clicked() {
                        around.picker.ask(ui.ctx(), Ask::Drawing);
                    }
                });
            });
            return;
        };
        look_around(ui, &response, &mut self.sheet_view, size);
        let placed = self.sheet_view.place(panel, size);
        let paper = placed.picture(size);
        painter.rect_filled(paper, 2.0, Color32::WHITE);
        let editing = self.numbers && !self.shop.playback.playing();
        let scale = placed.scale * ui.pixels_per_point();
        let shown = match (&self.shop.moving, &self.still) {
            (Some(moving), _) if !editing => {
                self.shop.pictures.update(ui.ctx(), moving, frame, scale);
                Some(&self.shop.pictures)
            }
            (_, Some(still)) => {
                self.still_pictures.update(ui.ctx(), still, 0, scale);
                Some(&self.still_pictures)
            }
            _ => None,
        };
        if let Some(pictures) = shown {
            if let Some(texture) = pictures.picture() {
                let (low, high) = (pictures.area.min, pictures.area.max);
                let at = Rect::from_min_max(placed.to_screen((low.x, low.y)), placed.to_screen((high.x, high.y)));
                // What leaves the paper is drawn on what lies behind, which is as light.
                painter.rect_filled(at.intersect(panel), 2.0, Color32::WHITE);
                painter.image(texture.id(), at, WHOLE, Color32::WHITE);
            }
            if let Some(failed) = &pictures.failed {
                let font = eframe::egui::FontId::proportional(14.0);
                let galley = painter.layout(failed.clone(), font, palette.bad, panel.width() - 40.0);
                painter.galley(panel.min + vec2(20.0, 60.0), galley, palette.bad);
            }
        }
        let handles = if editing { self.sheet_handles() } else { Vec::new() };
        let done = self.sheet_hand.act(ui, &response, placed, &handles);
        self.sheet_hand.paint(&painter, placed, &handles, self.selected);
        painter.vline(panel.left(), panel.y_range(), Stroke::new(1.0, palette.outline));
        toolbar(ui, panel, |ui| {
            if widgets::word_toggle(ui, texts::NUMBERS, self.numbers, Command::Tracks) {
                self.numbers ^= true;
            }
            if widgets::command_button(ui, Icon::Fit, texts::FIT_DRAWING, Command::Fit) {
                self.sheet_view.fit();
            }
        });
        if self.held.is_none() && self.shop.document.marks.points.len() < LEAST {
            crate::canvas::hint(&painter, panel, texts::MARK_FIRST);
        }
        match done {
            Some(Done::Moved(point, at)) => {
                self.selected = Some(point);
                let track = self.shop.document.marks.points[point].name.clone();
                self.change_held(texts::EDIT_HANDLE, around, |binding, _| binding.set_point("", &track, 0, at, ""));
            }
            Some(Done::Selected(point)) => self.selected = Some(point),
            Some(Done::Clicked(_)) => self.selected = None,
            None => {}
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
        if self.failed.take().is_some() {
            // What was cancelled or went wrong is tried again.
            self.go_on(around);
        } else if self.shop.document.marks.points.len() < LEAST {
            around.notices.failed(texts::MARK_HINT);
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
                let held = self.hand.cancel() | self.sheet_hand.cancel();
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
                let worst = self.shop.document.tracked.as_ref().and_then(|t| t.corrections.first()).copied();
                if let Some(worst) = worst {
                    self.shop.playback.stop();
                    self.shop.playback.seek(worst.frame, 0.0);
                    self.selected = Some(worst.track as usize);
                }
            }
            Command::Paths => self.paths ^= true,
            Command::Tracks => self.numbers ^= true,
            Command::Fit => {
                self.view.fit();
                self.sheet_view.fit();
            }
            Command::ZoomIn | Command::ZoomOut => {
                let by = if command == Command::ZoomIn { 1.25 } else { 0.8 };
                let size = self.clip_size();
                self.view.zoom(self.panel, size, self.panel.center(), by);
            }
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

    /// Where a place of the clip is on the screen.
    pub(crate) fn on_screen(&self, at: (f32, f32)) -> Pos2 {
        self.view.place(self.panel, self.clip_size()).to_screen(at)
    }

    /// Where a place of the drawing is on the screen.
    pub(crate) fn on_sheet(&self, at: (f32, f32)) -> Pos2 {
        let size = self.sheet.as_ref().map_or(Vec2::ZERO, |sheet| sheet.size);
        self.sheet_view.place(self.sheet_panel, size).to_screen(at)
    }

    /// Where the points are in the frame that is shown.
    pub(crate) fn points(&self) -> Vec<(f32, f32)> {
        self.clip_handles(self.shop.playback.frame()).iter().map(|h| h.at).collect()
    }

    /// Where the points hold the drawing, by number.
    pub(crate) fn handles(&self) -> Vec<(usize, (f32, f32))> {
        self.sheet_handles().iter().map(|h| (h.number, h.at)).collect()
    }
}

const WHOLE: Rect = Rect { min: pos2(0.0, 0.0), max: pos2(1.0, 1.0) };

/// Zoom at the cursor; pan by the middle button, or by Space.
pub(crate) fn look_around(ui: &Ui, response: &Response, view: &mut View, size: Vec2) {
    if let Some(at) = response.hover_pos() {
        let (zoom, scroll, ctrl) =
            ui.input(|i| (i.zoom_delta(), i.smooth_scroll_delta(), i.modifiers.command || i.modifiers.ctrl));
        let by_wheel = if ctrl { 1.0 } else { (scroll.y / 240.0).exp2() };
        if zoom * by_wheel != 1.0 {
            view.zoom(response.rect, size, at, zoom * by_wheel);
        }
    }
    if response.dragged_by(PointerButton::Middle) {
        view.pan(response.rect, size, response.drag_delta());
    }
}

/// What is shown, by words in a corner.
pub(crate) fn toolbar(ui: &mut Ui, panel: Rect, show: impl FnOnce(&mut Ui)) {
    let palette = Palette::of(ui);
    let at = Rect::from_min_size(panel.min + vec2(10.0, 10.0), vec2(panel.width() - 20.0, 36.0));
    ui.scope_builder(eframe::egui::UiBuilder::new().max_rect(at), |ui| {
        let frame = Frame::new()
            .fill(palette.panel.gamma_multiply(0.92))
            .corner_radius(8)
            .inner_margin(Margin::symmetric(6, 3));
        frame.show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                show(ui);
            });
        });
    });
}

/// A motion of one frame, as the text of a motion.json: what stands still.
pub(crate) fn one_frame(points: &[(&str, (f32, f32))], size: (f32, f32)) -> String {
    let track = |(name, at): &(&str, (f32, f32))| {
        let frame = serde_json::json!({ "points": [at], "visible": [true], "confidence": [1.0] });
        serde_json::json!({ "name": name, "kind": "point", "frames": [frame] })
    };
    let side = |v: f32| v.ceil().max(1.0) as u32;
    let motion = serde_json::json!({
        "format": "marey-motion",
        "version": 1,
        "size": [side(size.0), side(size.1)],
        "fps": 24.0,
        "frames": 1,
        "tracks": points.iter().map(track).collect::<Vec<_>>(),
    });
    motion.to_string()
}

/// Whether a motion is that of the marks: its tracks are theirs, and go through all of them.
fn passes_marks(motion: &Motion, document: &Document) -> Result<bool> {
    let info = motion.info()?;
    if !info.tracks.iter().eq(document.marks.points.iter().map(|p| &p.name)) {
        return Ok(false);
    }
    for (track, mark) in (0..).zip(&document.marks.points) {
        for key in &mark.keys {
            if key.frame >= info.frames {
                return Ok(false);
            }
            let at = motion.frame(track, key.frame)?.points;
            if at.first().is_none_or(|at| (at.0 - key.at.0).abs() + (at.1 - key.at.1).abs() > 0.01) {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// What a report of tracked points says to correct next: the point, the frame, and how far it is trusted there.
fn next_corrections(report: &str) -> Vec<(String, u64, f32)> {
    let report: serde_json::Value = serde_json::from_str(report).unwrap_or_default();
    let one = |c: &serde_json::Value| {
        Some((c["point"].as_str()?.to_owned(), c["frame"].as_u64()?, c["confidence"].as_f64()? as f32))
    };
    report["correct_next"].as_array().into_iter().flatten().filter_map(one).collect()
}

/// What a person said of how a drawing is held, with the machine's proposal for points that were marked since; none where
/// there is no proposal for them yet.
fn held(
    context: &marey_binding::Context,
    sheet: &Sheet,
    motion: &Motion,
    said: Option<&str>,
    proposed: Option<&str>,
) -> Result<Option<Held>> {
    let tracks = motion.info()?.tracks;
    let read = |json: Option<&str>| json.map(|json| context.binding_from_json(json)).transpose();
    let (said, proposed) = (read(said)?, read(proposed)?);
    let Some(binding) = said.as_ref().or(proposed.as_ref()) else { return Ok(None) };
    let there = binding.points()?;
    let is_there = |track: &String| there.iter().any(|p| p.track == *track);
    if !tracks.iter().all(is_there) && said.is_some() {
        let Some(proposed) = &proposed else { return Ok(None) };
        for point in proposed.points()?.iter().filter(|p| !is_there(&p.track)) {
            binding.set_point("", &point.track, point.index, point.at, "")?;
        }
    }
    for gone in there.iter().filter(|p| !tracks.contains(&p.track)) {
        binding.remove_point("", &gone.track, gone.index)?;
    }
    binding.validate(&sheet.drawing)?;
    let stiffness = sheet.strokes.first().map_or(Ok(1.0), |stroke| binding.stroke(stroke).map(|s| s.0))?;
    Ok(Some(Held { json: binding.to_json()?, points: binding.points()?, how: binding.motion(0)?, stiffness }))
}
