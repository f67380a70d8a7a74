//! The second door: a character that moves. A picture of a drawing gets a mesh and a skeleton, takes a motion, and plays.
//!
//! The skeleton is proposed, and becomes part of the document when a person moves a joint. The picture lies in a file of
//! its own while it is open, for the library reads files.

use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;

use eframe::egui::{
    Align2, CentralPanel, Color32, ComboBox, Context as Gui, FontId, Frame, Margin, Panel, Pos2, Rect, Role,
    ScrollArea, Sense, Slider, Stroke, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use marey_binding::{Access, Character, CharacterOptions, Context, Motion, Part, Result, RetargetOptions, TakeOptions};

use crate::around::Around;
use crate::background::Background;
use crate::document::{CharacterNotes, Document};
use crate::drawing_door::{look_around, one_frame, toolbar};
use crate::handles::{Done, Hand, Handle};
use crate::icons::Icon;
use crate::moving::{Moving, MovingPictures};
use crate::picker::Ask;
use crate::running::{Purpose, Running, Step};
use crate::shortcuts::{self, Command};
use crate::theme::{self, Palette};
use crate::view::View;
use crate::workshop::{Watched, Workshop};
use crate::{overlay, sample, texts, widgets};

const WHOLE: Rect = Rect { min: pos2(0.0, 0.0), max: pos2(1.0, 1.0) };

/// A drawing with its skeleton.
struct Figure {
    /// The picture and the skeleton that it was made of.
    of: Made,
    character: Arc<Character>,
    joints: Vec<(String, (f32, f32))>,
    bones: Vec<[u32; 2]>,
    size: Vec2,
}

/// What something was made of.
#[derive(Clone, Debug, Default, PartialEq)]
struct Made {
    picture: Option<Arc<Vec<u8>>>,
    skeleton: Option<Arc<Vec<u8>>>,
    motion: Option<Arc<Vec<u8>>>,
    map: Option<Arc<Vec<u8>>>,
    notes: CharacterNotes,
}

pub(crate) struct CharacterDoor {
    pub(crate) shop: Workshop,
    view: View,
    moving_view: View,
    hand: Hand,
    pub(crate) selected: Option<usize>,
    bones: bool,
    /// The picture as a file, and what it is of.
    file: Option<(Arc<Vec<u8>>, tempfile::NamedTempFile)>,
    figure: Option<Figure>,
    still: Option<Moving>,
    still_pictures: MovingPictures,
    /// What plays was made of.
    moves: Option<Made>,
    /// What a motion has to follow, and which joint follows what of it, as a map.json.
    tracks: Vec<String>,
    followed: serde_json::Value,
    begun: Option<(Step, Made)>,
    failed: Option<(Step, Made)>,
    /// The skeleton with a joint that was moved, in the making.
    moving_joint: Option<Background<std::result::Result<String, String>>>,
    /// A motion that is being read.
    reading: Option<Background<std::result::Result<String, String>>>,
    /// The slider while it is held.
    stretch: Option<f32>,
    panel: Rect,
}

impl CharacterDoor {
    pub(crate) fn new(gui: &Gui, document: Document, around: &mut Around) -> Self {
        let mut door = Self {
            shop: Workshop::new(gui, document, around),
            view: View::default(),
            moving_view: View::default(),
            hand: Hand::default(),
            selected: None,
            bones: true,
            file: None,
            figure: None,
            still: None,
            still_pictures: MovingPictures::new(gui),
            moves: None,
            tracks: Vec::new(),
            followed: serde_json::Value::Null,
            begun: None,
            failed: None,
            moving_joint: None,
            reading: None,
            stretch: None,
            panel: Rect::NOTHING,
        };
        door.go_on(around);
        door
    }

    /// What the character is to be made of.
    fn figure_of(&self) -> Made {
        let part = |part| self.shop.document.part(part).cloned();
        Made { picture: part(Part::Picture), skeleton: part(Part::Skeleton), ..Made::default() }
    }

    /// What is to play.
    fn moves_of(&self) -> Made {
        let part = |part| self.shop.document.part(part).cloned();
        let (motion, map) = (part(Part::Motion), part(Part::Map));
        Made { motion, map, notes: self.shop.document.character_notes(), ..self.figure_of() }
    }

    /// Starts what can be filled in next, after every change.
    fn go_on(&mut self, around: &mut Around) {
        let wanted = self.next_step();
        if let Some(running) = &mut self.shop.running {
            let step = matches!(running.purpose, Purpose::Step(_));
            if step && wanted.is_some() && self.begun != wanted {
                running.give_up();
            }
            return;
        }
        let Some(wanted) = wanted.filter(|w| self.failed.as_ref() != Some(w)) else { return };
        match self.start(&wanted, around) {
            Ok(Some(job)) => {
                self.shop.running = Some(Running::new(job, Purpose::Step(wanted.0)));
                self.begun = Some(wanted);
            }
            Ok(None) => {}
            Err(message) => {
                around.notices.failed(message);
                self.failed = Some(wanted);
            }
        }
    }

    fn next_step(&self) -> Option<(Step, Made)> {
        let figure = self.figure_of();
        figure.picture.as_ref()?;
        if self.figure.as_ref().is_none_or(|f| f.of != figure) {
            return Some((Step::Character, figure));
        }
        if self.still.is_none() {
            return Some((Step::Still, figure));
        }
        let moves = self.moves_of();
        moves.motion.as_ref()?;
        (self.moves.as_ref() != Some(&moves)).then_some((Step::Move, moves))
    }

    fn start(
        &mut self,
        (step, made): &(Step, Made),
        around: &Around,
    ) -> std::result::Result<Option<marey_binding::Job>, String> {
        let said = |e: marey_binding::Error| e.to_string();
        let context = &around.context;
        match (step, &self.figure) {
            (Step::Character, _) => {
                let Some(bytes) = &made.picture else { return Ok(None) };
                if self.file.as_ref().is_none_or(|(of, _)| of != bytes) {
                    let file = picture_file(bytes, &around.places.samples)
                        .map_err(|e| texts::no_folder(&around.places.samples, &e))?;
                    self.file = Some((bytes.clone(), file));
                }
                let path = self.file.as_ref().map(|(_, f)| f.path().to_string_lossy().into_owned());
                let rig = made.skeleton.as_ref().map(|s| String::from_utf8_lossy(s));
                let options = CharacterOptions {
                    picture: path.as_deref().unwrap_or_default(),
                    rig_json: rig.as_deref().unwrap_or_default(),
                    ..CharacterOptions::default()
                };
                context.start_character(&options).map(Some).map_err(said)
            }
            (Step::Still, Some(figure)) => {
                let joints: Vec<(&str, (f32, f32))> = figure.joints.iter().map(|(n, at)| (n.as_str(), *at)).collect();
                let json = one_frame(&joints, (figure.size.x, figure.size.y));
                let start = || {
                    let motion = context.motion_from_json(&json)?;
                    context.start_take_of_motion(&figure.character, &motion, &TakeOptions::default())
                };
                start().map(Some).map_err(said)
            }
            (Step::Move, Some(figure)) => {
                let Some(json) = made.motion.as_ref().map(|m| String::from_utf8_lossy(m)) else { return Ok(None) };
                let map = self.shop.document.text(Part::Map).unwrap_or_default();
                let mut tracks = Vec::new();
                let mut start = || {
                    let motion = context.motion_from_json(&json)?;
                    tracks = motion.info()?.tracks;
                    let retarget = RetargetOptions {
                        absolute: made.notes.absolute,
                        stretch: made.notes.stretch,
                        root_scale: made.notes.on_spot.then_some(0.0),
                        map,
                        ..RetargetOptions::default()
                    };
                    let options = TakeOptions { retarget, ..TakeOptions::default() };
                    context.start_take_of_motion(&figure.character, &motion, &options)
                };
                let started = start().map(Some).map_err(said);
                self.tracks = tracks;
                started
            }
            _ => Ok(None),
        }
    }

    fn watch(&mut self, ui: &Ui, around: &mut Around) {
        let now = ui.input(|i| i.time);
        if let Some(answer) = answered(&mut self.moving_joint)
            && let Some(json) = around.notices.check(answer)
        {
            let set = self.shop.document.set_parts(texts::EDIT_JOINT, &[(Part::Skeleton, Some(json.as_bytes()))]);
            around.notices.check(set);
            self.go_on(around);
        }
        if let Some(answer) = answered(&mut self.reading)
            && let Some(json) = around.notices.check(answer)
        {
            self.set_motion(&json, around);
        }
        let Some(watched) = self.shop.watch(ui, around) else { return };
        match watched {
            Watched::Failed => self.failed = self.begun.take(),
            Watched::Outdated => self.begun = None,
            Watched::Done(step, running) => {
                let begun = self.begun.take();
                let taken = self.take(step, &running, begun.map(|b| b.1).unwrap_or_default(), now);
                around.notices.check(taken);
            }
        }
        self.go_on(around);
    }

    fn take(&mut self, step: Step, running: &Running, of: Made, now: f64) -> Result<()> {
        let job = &running.job;
        match step {
            Step::Character => {
                let character = job.take_character()?;
                let (info, joints, bones) = (character.info()?, character.joints()?, character.bones()?);
                let size = vec2(info.size.0 as f32, info.size.1 as f32);
                self.figure = Some(Figure { of, character: Arc::new(character), joints, bones, size });
                (self.still, self.moves) = (None, None);
            }
            Step::Still => self.still = Some(Moving::Character(Arc::new(job.take_take()?))),
            Step::Move => {
                let take = job.take_take()?;
                let report: serde_json::Value = serde_json::from_str(&take.report()?).unwrap_or_default();
                self.followed = report["followed"]["map"].clone();
                let take = Moving::Character(Arc::new(take));
                self.moves = Some(of);
                self.shop.show_moving(take, now);
            }
            _ => {}
        }
        Ok(())
    }

    fn set_motion(&mut self, json: &str, around: &mut Around) {
        // What was said of another motion does not fit this one.
        let parts = [(Part::Motion, Some(json.as_bytes())), (Part::Map, None)];
        let set = self.shop.document.set_parts(texts::EDIT_MOTION, &parts);
        around.notices.check(set);
        self.go_on(around);
    }

    fn set_notes(&mut self, notes: &CharacterNotes, around: &mut Around) {
        let set = self.shop.document.set_character_notes(texts::EDIT_HOW, notes);
        around.notices.check(set);
        self.go_on(around);
    }

    /// Moves a joint, beside the window: the mesh follows it.
    fn move_joint(&mut self, gui: &Gui, joint: usize, at: (f32, f32), around: &mut Around) {
        let Some(figure) = &self.figure else { return };
        if self.moving_joint.is_some() {
            around.notices.failed(texts::BUSY);
            return;
        }
        let mut places: Vec<(f32, f32)> = figure.joints.iter().map(|j| j.1).collect();
        if let Some(place) = places.get_mut(joint) {
            *place = at;
        }
        let character = figure.character.clone();
        self.moving_joint = Some(Background::start(gui, move || {
            character.set_joints(&places).and_then(|()| character.to_json()).map_err(|e| e.to_string())
        }));
    }

    /// Draws everything, and does what was asked for.
    pub(crate) fn show(&mut self, ui: &mut Ui, around: &mut Around) {
        self.watch(ui, around);
        self.shop.advance(ui, around);
        let frame = self.shop.playback.frame();
        let palette = Palette::of(ui);
        let plain = Frame::new().fill(palette.panel).inner_margin(Margin::symmetric(theme::PAD, 8));
        self.shop.show_progress(ui);
        let transport = Panel::bottom("transport").frame(plain).resizable(false);
        let asked = transport.show(ui, |ui| self.shop.show_transport(ui, around)).inner;
        Panel::left("steps").frame(plain).default_size(250.0).size_range(210.0..=360.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.steps(ui, around));
        });
        let half = (ui.available_width() * 0.5).max(200.0);
        Panel::right("moving").frame(Frame::new()).default_size(half).min_size(200.0).show(ui, |ui| {
            self.show_moving(ui, frame);
        });
        CentralPanel::default().frame(Frame::new()).show(ui, |ui| self.show_figure(ui, around));
        if let Some(command) = shortcuts::space_released(ui.ctx()).filter(|_| ui.memory(|m| m.focused().is_none())) {
            self.command(command, ui.ctx(), around);
        }
        for command in asked {
            self.command(command, ui.ctx(), around);
        }
        self.shop.show_export(ui, around);
    }

    /// The steps, each with what can be corrected of it.
    fn steps(&mut self, ui: &mut Ui, around: &mut Around) {
        widgets::section(ui, texts::PICTURE);
        if ui.button(texts::OTHER_PICTURE).clicked() {
            around.picker.ask(ui.ctx(), Ask::Picture);
        }
        ui.add_space(theme::GAP);
        ui.separator();
        let joints = self.figure.as_ref().map_or(0, |f| f.joints.len());
        widgets::section(ui, &texts::skeleton(joints));
        let own = self.shop.document.part(Part::Skeleton).is_some();
        widgets::remark(ui, if own { texts::SKELETON_OWN } else { texts::SKELETON_HINT });
        if own && ui.button(texts::PROPOSE_SKELETON).on_hover_text(texts::PROPOSE_SKELETON_HINT).clicked() {
            let set = self.shop.document.set_parts(texts::EDIT_SKELETON, &[(Part::Skeleton, None)]);
            around.notices.check(set);
            self.go_on(around);
        }
        self.follow(ui, around);
        ui.add_space(theme::GAP);
        ui.separator();
        widgets::section(ui, texts::MOTION);
        let mut chosen = None;
        let list =
            ComboBox::from_id_salt("motions").width(ui.available_width() - 12.0).selected_text(texts::OUR_MOTIONS);
        let list = list.show_ui(ui, |ui| {
            for (name, json) in sample::MOTIONS {
                if ui.selectable_label(false, name).clicked() {
                    chosen = Some(json);
                }
            }
        });
        list.response.accessible_name(texts::OUR_MOTIONS);
        if let Some(json) = chosen {
            self.set_motion(json, around);
        }
        if ui.button(texts::CHOOSE_MOTION).on_hover_text(texts::CHOOSE_MOTION_HINT).clicked() {
            around.picker.ask(ui.ctx(), Ask::Motion);
        }
        if self.shop.document.part(Part::Motion).is_some() {
            ui.add_space(theme::GAP);
            ui.separator();
            self.correct(ui, around);
        }
    }

    /// What the selected joint follows.
    fn follow(&mut self, ui: &mut Ui, around: &mut Around) {
        let Some(joint) = self.selected.and_then(|j| Some(self.figure.as_ref()?.joints.get(j)?.0.clone())) else {
            return;
        };
        if self.moves.is_none() {
            return;
        }
        let now = self.followed["joints"][&joint]["track"].as_str().map(str::to_owned);
        let mut chosen = now.clone();
        ui.horizontal(|ui| {
            let label = ui.label(texts::follows(&joint));
            let shown = now.as_deref().unwrap_or(texts::FOLLOWS_NOTHING);
            let list = ComboBox::from_id_salt("follows").width(ui.available_width() - 12.0).selected_text(shown);
            let list = list.show_ui(ui, |ui| {
                ui.selectable_value(&mut chosen, None, texts::FOLLOWS_NOTHING);
                for track in &self.tracks {
                    ui.selectable_value(&mut chosen, Some(track.clone()), track);
                }
            });
            list.response.labelled_by(label.id);
        });
        if chosen != now {
            let mut map = self.followed.clone();
            match chosen {
                Some(track) => map["joints"][&joint] = serde_json::json!({ "track": track }),
                None => drop(map["joints"].as_object_mut().map(|joints| joints.remove(&joint))),
            }
            let set =
                self.shop.document.set_parts(texts::EDIT_FOLLOWS, &[(Part::Map, Some(map.to_string().as_bytes()))]);
            around.notices.check(set);
            self.go_on(around);
        }
    }

    /// How the motion is carried over.
    fn correct(&mut self, ui: &mut Ui, around: &mut Around) {
        widgets::section(ui, texts::CARRIED);
        let before = self.shop.document.character_notes();
        let mut notes = before.clone();
        ui.checkbox(&mut notes.on_spot, texts::ON_SPOT).on_hover_text(texts::ON_SPOT_HINT);
        ui.checkbox(&mut notes.absolute, texts::ABSOLUTE).on_hover_text(texts::ABSOLUTE_HINT);
        widgets::remark(ui, texts::STRETCH);
        let mut stretch = self.stretch.unwrap_or(notes.stretch);
        ui.spacing_mut().slider_width = ui.available_width() - 64.0;
        let slider = ui.add(Slider::new(&mut stretch, 1.0..=3.0).custom_formatter(|v, _| texts::times(v)));
        let slider = slider.accessible_name(texts::STRETCH).on_hover_text(texts::STRETCH_HINT);
        if slider.changed() {
            self.stretch = Some(stretch);
        }
        let held = slider.is_pointer_button_down_on() || slider.dragged();
        if let Some(stretch) = self.stretch.filter(|_| !held) {
            self.stretch = None;
            notes.stretch = stretch;
        }
        if notes != before {
            self.set_notes(&notes, around);
        }
    }

    /// The drawing with its skeleton, as it was drawn.
    fn show_figure(&mut self, ui: &mut Ui, around: &mut Around) {
        let palette = Palette::of(ui);
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        self.panel = panel;
        painter.rect_filled(panel, 0.0, palette.canvas);
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, texts::FIGURE_NAME));
        let Some((size, joints, bones)) = self.figure.as_ref().map(|f| (f.size, f.joints.clone(), f.bones.clone()))
        else {
            let middle = FontId::proportional(15.0);
            painter.text(panel.center(), Align2::CENTER_CENTER, texts::SEEING, middle, palette.weak);
            return;
        };
        look_around(ui, &response, &mut self.view, size);
        let placed = self.view.place(panel, size);
        painter.rect_filled(placed.picture(size), 2.0, Color32::WHITE);
        if let Some(still) = &self.still {
            self.still_pictures.update(ui.ctx(), still, 0, placed.scale * ui.pixels_per_point());
            show_picture(&painter, placed, &self.still_pictures);
        }
        let handles: Vec<Handle> =
            (0..joints.len()).map(|number| Handle { number, at: joints[number].1, sure: 1.0, by_hand: true }).collect();
        if self.bones {
            let done = self.hand.act(ui, &response, placed, &handles);
            let at = |joint: u32| placed.to_screen(self.hand.place(&handles[joint as usize]));
            for [from, to] in bones {
                overlay::line(&painter, &[at(from), at(to)], 3.0, theme::limb(to as usize));
            }
            for handle in &handles {
                let place = placed.to_screen(self.hand.place(handle));
                let on = self.selected == Some(handle.number);
                let ring = Stroke::new(if on { 3.0 } else { 1.5 }, if on { Color32::WHITE } else { Color32::BLACK });
                painter.circle(place, if on { 7.0 } else { 6.0 }, theme::limb(handle.number), ring);
            }
            let near = response
                .hover_pos()
                .and_then(|at| handles.iter().find(|h| placed.to_screen(h.at).distance(at) < 12.0).map(|h| h.number));
            if let Some(joint) = near.or(self.selected).filter(|j| *j < joints.len()) {
                let at = placed.to_screen(self.hand.place(&handles[joint])) + vec2(14.0, -14.0);
                let galley =
                    painter.layout_no_wrap(joints[joint].0.clone(), FontId::proportional(13.0), Color32::WHITE);
                let ground = Rect::from_min_size(at - vec2(6.0, 13.0), galley.size() + vec2(12.0, 6.0));
                painter.rect_filled(ground, 4.0, Color32::from_black_alpha(190));
                painter.galley(ground.min + vec2(6.0, 3.0), galley, Color32::WHITE);
            }
            match done {
                Some(Done::Moved(joint, at)) => {
                    self.selected = Some(joint);
                    // It is shown where it was let go until the mesh has followed.
                    if let Some(figure) = &mut self.figure {
                        figure.joints[joint].1 = at;
                    }
                    self.move_joint(ui.ctx(), joint, at, around);
                }
                Some(Done::Selected(joint)) => self.selected = Some(joint),
                Some(Done::Clicked(_)) => self.selected = None,
                None => {}
            }
        }
        toolbar(ui, panel, |ui| {
            if widgets::word_toggle(ui, texts::SKELETON, self.bones, Command::Tracks) {
                self.bones ^= true;
            }
            if widgets::command_button(ui, Icon::Fit, texts::FIT_DRAWING, Command::Fit) {
                self.view.fit();
            }
        });
    }

    /// The character in motion.
    fn show_moving(&mut self, ui: &mut Ui, frame: u64) {
        let palette = Palette::of(ui);
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        painter.rect_filled(panel, 0.0, palette.canvas);
        painter.vline(panel.left(), panel.y_range(), Stroke::new(1.0, palette.outline));
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, texts::MOVING_NAME));
        let Some(moving) = self.shop.moving.clone() else {
            let none = self.shop.document.part(Part::Motion).is_none();
            let text = if none { texts::NO_MOTION } else { texts::SEEING };
            let galley =
                painter.layout(text.to_owned(), FontId::proportional(15.0), palette.weak, panel.width() - 60.0);
            painter.galley(panel.center() - galley.size() / 2.0, galley, palette.weak);
            return;
        };
        let size = self.figure.as_ref().map_or(Vec2::splat(1.0), |f| f.size);
        // All of every frame is to be seen.
        let area = self.shop.pictures.area;
        let whole = if area.is_positive() { area.size() } else { size };
        look_around(ui, &response, &mut self.moving_view, whole);
        let placed = self.moving_view.place(panel, whole);
        self.shop.pictures.update(ui.ctx(), &moving, frame, placed.scale * ui.pixels_per_point());
        let paper = placed.picture(whole);
        painter.rect_filled(paper, 2.0, Color32::WHITE);
        if let Some(texture) = self.shop.pictures.picture() {
            painter.image(texture.id(), paper, WHOLE, Color32::WHITE);
        }
        if let Some(failed) = &self.shop.pictures.failed {
            let galley = painter.layout(failed.clone(), FontId::proportional(14.0), palette.bad, panel.width() - 40.0);
            painter.galley(panel.min + vec2(20.0, 60.0), galley, palette.bad);
        }
    }

    /// What comes next, in the bar. It always leads on.
    pub(crate) fn show_steps(&mut self, ui: &mut Ui, around: &mut Around) {
        let moves = self.shop.document.part(Part::Motion).is_some();
        if widgets::primary_button(ui, if moves { texts::EXPORT } else { texts::CHOOSE_MOTION }).clicked() {
            self.next(ui.ctx(), around);
        }
    }

    fn next(&mut self, gui: &Gui, around: &mut Around) {
        if self.failed.take().is_some() {
            // What was cancelled or went wrong is tried again.
            self.go_on(around);
        } else if self.shop.document.part(Part::Motion).is_some() {
            self.command(Command::Export, gui, around);
        } else {
            around.picker.ask(gui, Ask::Motion);
        }
    }

    pub(crate) fn command(&mut self, command: Command, gui: &Gui, around: &mut Around) {
        match command {
            Command::Make => self.next(gui, around),
            Command::Cancel => {
                if !self.hand.cancel() {
                    self.selected = None;
                }
            }
            Command::NextLimb => {
                let count = self.figure.as_ref().map_or(0, |f| f.joints.len());
                self.selected = (count > 0).then(|| self.selected.map_or(0, |joint| (joint + 1) % count));
            }
            Command::Tracks => self.bones ^= true,
            Command::Fit => {
                self.view.fit();
                self.moving_view.fit();
            }
            Command::ZoomIn | Command::ZoomOut => {
                let by = if command == Command::ZoomIn { 1.25 } else { 0.8 };
                let size = self.figure.as_ref().map_or(Vec2::ZERO, |f| f.size);
                self.view.zoom(self.panel, size, self.panel.center(), by);
            }
            _ => {
                if self.shop.command(command, gui, around) && matches!(command, Command::Undo | Command::Redo) {
                    if self.shop.document.part(Part::Motion).is_none() {
                        self.shop.moving = None;
                        self.shop.pictures.clear();
                        self.moves = None;
                    }
                    self.go_on(around);
                }
            }
        }
    }

    /// What a dropped or chosen file is for here; false for what opens another document. A session gives its motion when
    /// it was `asked` for as one.
    pub(crate) fn take_file(&mut self, gui: &Gui, path: &Path, asked: Option<&Ask>, around: &mut Around) -> bool {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match (ending.as_str(), asked) {
            ("json" | "bvh", _) | (_, Some(Ask::Motion)) => {
                let (context, path) = (around.context.clone(), path.to_string_lossy().into_owned());
                self.reading = Some(Background::start(gui, move || read_motion(&context, &path, &ending)));
            }
            ("jpg" | "jpeg" | "webp", _) | (_, Some(Ask::Picture)) => {
                let read = std::fs::read(path).map_err(|e| texts::unreadable(path, &e));
                if let Some(picture) = around.notices.check(read) {
                    let parts = [(Part::Picture, Some(picture.as_slice())), (Part::Skeleton, None)];
                    let set = self.shop.document.set_parts(texts::EDIT_PICTURE, &parts);
                    around.notices.check(set);
                    self.go_on(around);
                }
            }
            _ => return false,
        }
        true
    }

    /// Where a place of the drawing is on the screen.
    pub(crate) fn on_screen(&self, at: (f32, f32)) -> Pos2 {
        let size = self.figure.as_ref().map_or(Vec2::ZERO, |f| f.size);
        self.view.place(self.panel, size).to_screen(at)
    }

    /// The joints' places.
    pub(crate) fn joints(&self) -> Vec<(String, (f32, f32))> {
        self.figure.as_ref().map_or_else(Vec::new, |f| f.joints.clone())
    }

    /// Whether the mesh follows a joint now.
    pub(crate) fn is_busy(&self) -> bool {
        self.shop.running.is_some() || self.moving_joint.is_some() || self.reading.is_some()
    }
}

fn answered(
    background: &mut Option<Background<std::result::Result<String, String>>>,
) -> Option<std::result::Result<String, String>> {
    let answer = match background.as_ref()?.answer() {
        Ok(None) => return None,
        Ok(Some(answer)) => answer,
        Err(()) => Err(texts::OPENING_BROKE.into()),
    };
    *background = None;
    Some(answer)
}

fn show_picture(painter: &eframe::egui::Painter, placed: crate::view::Placement, pictures: &MovingPictures) {
    if let Some(texture) = pictures.picture() {
        let (low, high) = (pictures.area.min, pictures.area.max);
        let at = Rect::from_min_max(placed.to_screen((low.x, low.y)), placed.to_screen((high.x, high.y)));
        painter.image(texture.id(), at, WHOLE, Color32::WHITE);
    }
}

fn picture_file(bytes: &[u8], folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut file = tempfile::Builder::new().prefix("picture-").tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.flush()?;
    Ok(file)
}

/// The motion of a file: a motion.json, a BVH, or a session in which something was tracked.
fn read_motion(context: &Context, path: &str, ending: &str) -> std::result::Result<String, String> {
    let read = || -> Result<Option<Motion>> {
        match ending {
            "bvh" => context.read_bvh(path, 0).map(Some),
            "marey" => context.open_session(path, Access::ReadOnly)?.motion(),
            _ => context.read_motion(path).map(Some),
        }
    };
    match read() {
        Ok(Some(motion)) => motion.to_json().map_err(|e| e.to_string()),
        Ok(None) => Err(texts::NO_MOTION_THERE.into()),
        Err(e) => Err(e.to_string()),
    }
}
