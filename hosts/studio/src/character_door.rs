//! The second door: a character that moves. A picture of a drawing gets a mesh and a skeleton, takes a motion, and plays.
//!
//! The skeleton is proposed, and becomes part of the document when a person moves a joint. The picture lies in a file of
//! its own while it is open, for the library reads files.

use std::path::Path;
use std::sync::Arc;

use eframe::egui::{CentralPanel, ComboBox, Context as Gui, Frame, Margin, Panel, Pos2, ScrollArea, Slider, Ui};
use marey_binding::{Access, Context, Motion, Part, PluginKind, Result};

use crate::around::Around;
use crate::background::Background;
use crate::capture::OpeningClip;
use crate::character_steps::{Figure, Made};
use crate::clip_points::ClipPoints;
use crate::document::Document;
use crate::filling::{Filling as _, Steps};
use crate::handles::Hand;
use crate::looking::Looking;
use crate::moving::{Moving, MovingPictures};
use crate::notes::CharacterNotes;
use crate::picker::Ask;
use crate::shortcuts::{self, Command};
use crate::solved::Solved;
use crate::theme::{self, Palette};
use crate::workshop::Workshop;
use crate::{sample, texts, timeline, widgets};

/// The bytes of a part.
type Bytes = Arc<Vec<u8>>;

pub(crate) struct CharacterDoor {
    pub(crate) shop: Workshop,
    pub(crate) steps: Steps<Made>,
    pub(crate) looking: Looking,
    pub(crate) moving_looking: Looking,
    pub(crate) hand: Hand,
    /// The joint that is corrected, or marked on the clip next.
    pub(crate) selected: Option<usize>,
    pub(crate) bones: bool,
    /// Whether the mesh is shown over what moves.
    pub(crate) mesh: bool,
    /// Whether what holds each vertex to its bone is shown, on the drawing and over what moves.
    pub(crate) needles: bool,
    /// Whether the clip that a motion is taken from is shown, with the drawing beside it.
    pub(crate) on_clip: bool,
    pub(crate) clip: ClipPoints,
    pub(crate) opening: Option<OpeningClip>,
    /// Where the marks go, and the motion that was captured of which marks.
    pub(crate) solved: Option<Solved>,
    pub(crate) captured: Option<(Bytes, Bytes)>,
    /// The picture as a file, and what it is of.
    pub(crate) file: Option<(Bytes, tempfile::NamedTempFile)>,
    pub(crate) figure: Option<Figure>,
    pub(crate) still: Option<Moving>,
    pub(crate) still_pictures: MovingPictures,
    /// What plays was made of.
    pub(crate) moves: Option<Made>,
    /// What a motion has to follow, and which joint follows what of it, as a map.json.
    pub(crate) tracks: Vec<String>,
    pub(crate) followed: serde_json::Value,
    /// The skeleton with a joint that was moved, in the making.
    moving_joint: Option<Background<std::result::Result<String, String>>>,
    /// A motion that is being read.
    reading: Option<Background<std::result::Result<String, String>>>,
    /// The slider while it is held.
    stretch: Option<f32>,
}

impl CharacterDoor {
    pub(crate) fn new(gui: &Gui, document: Document, around: &mut Around) -> Self {
        let mut door = Self {
            shop: Workshop::new(gui, document, around),
            steps: Steps::default(),
            looking: Looking::default(),
            moving_looking: Looking::default(),
            hand: Hand::default(),
            selected: None,
            bones: true,
            mesh: false,
            needles: false,
            on_clip: true,
            clip: ClipPoints::default(),
            opening: None,
            solved: None,
            captured: None,
            file: None,
            figure: None,
            still: None,
            still_pictures: MovingPictures::new(gui),
            moves: None,
            tracks: Vec::new(),
            followed: serde_json::Value::Null,
            moving_joint: None,
            reading: None,
            stretch: None,
        };
        door.on_clip = door.shop.document.part(Part::Motion).is_none();
        let first = door.shop.document.keys.first().copied().unwrap_or(0);
        door.shop.playback.seek(first, 0.0);
        door.go_on(around);
        door
    }

    /// Takes in what was made beside the window.
    fn receive(&mut self, ui: &Ui, around: &mut Around) {
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
        self.take_clip(around);
        self.watch(ui, around);
    }

    fn set_motion(&mut self, json: &str, around: &mut Around) {
        // What was said of another motion does not fit this one.
        let parts = [(Part::Points, None), (Part::Motion, Some(json.as_bytes())), (Part::Map, None)];
        let set = self.shop.document.set_clip(texts::EDIT_MOTION, None, &parts);
        around.notices.check(set);
        self.go_on(around);
    }

    fn set_notes(&mut self, notes: &CharacterNotes, around: &mut Around) {
        let set = self.shop.document.set_character_notes(texts::EDIT_HOW, notes);
        around.notices.check(set);
        self.go_on(around);
    }

    /// Moves a joint, beside the window: the mesh follows it.
    pub(crate) fn move_joint(&mut self, gui: &Gui, joint: usize, at: (f32, f32), around: &mut Around) {
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
        self.receive(ui, around);
        self.shop.follow_clip(ui.ctx());
        self.shop.advance(ui, around);
        let frame = self.shop.playback.frame();
        let palette = Palette::of(ui);
        let plain = Frame::new().fill(palette.panel).inner_margin(Margin::symmetric(theme::PAD, 8));
        self.shop.show_progress(ui);
        let bottom = Panel::bottom("transport").frame(plain).resizable(false);
        let asked = if self.shop.document.clip.is_some() {
            let timeline = bottom.show(ui, |ui| {
                ui.set_min_height(timeline::HEIGHT - 36.0);
                let Workshop { document, frames, timeline, playback, .. } = &mut self.shop;
                timeline.show(ui, document, frames.as_ref(), playback, None)
            });
            timeline.inner
        } else {
            let transport = bottom.show(ui, |ui| self.shop.show_transport(ui, around));
            transport.inner.into_iter().map(timeline::Asked::Do).collect()
        };
        Panel::left("steps").frame(plain).default_size(250.0).size_range(210.0..=360.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.panel(ui, around));
        });
        let half = (ui.available_width() * 0.5).max(200.0);
        let marking = self.is_marking();
        Panel::right("moving").frame(Frame::new()).default_size(half).min_size(200.0).show(ui, |ui| {
            // While joints are marked, the drawing with the same numbers, unless it plays.
            if marking && !(self.shop.playback.playing() && self.shop.moving.is_some()) {
                self.show_figure(ui, around);
            } else {
                self.show_moving(ui, frame);
            }
        });
        CentralPanel::default().frame(Frame::new()).show(ui, |ui| {
            if marking {
                self.show_clip(ui, around);
            } else {
                self.show_figure(ui, around);
            }
        });
        if let Some(command) = shortcuts::space_released(ui.ctx()) {
            let all = [&mut self.looking, &mut self.moving_looking, &mut self.clip.looking];
            let panned = all.into_iter().fold(false, |panned, looking| looking.space_was_to_pan() | panned);
            if !panned && ui.memory(|m| m.focused().is_none()) {
                self.command(command, ui.ctx(), around);
            }
        }
        for asked in asked {
            match asked {
                timeline::Asked::Time(timing) => {
                    around.notices.check(self.shop.document.set_timing(timing));
                }
                timeline::Asked::Seek(frame) => self.shop.playback.seek(frame, ui.input(|i| i.time)),
                timeline::Asked::Do(command) => self.command(command, ui.ctx(), around),
                timeline::Asked::MoveKey(from, to) => {
                    self.move_marks(from, to, around);
                    self.shop.playback.seek(to, 0.0);
                }
            }
        }
        self.shop.show_export(ui, around);
    }

    /// The steps, each with what can be corrected of it.
    fn panel(&mut self, ui: &mut Ui, around: &mut Around) {
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
        if ui.button(texts::CAPTURE).on_hover_text(texts::CAPTURE_HINT).clicked() {
            around.picker.ask(ui.ctx(), Ask::MotionClip);
        }
        if self.shop.document.clip.is_some() {
            let (marked, joints) = self.marked();
            widgets::remark(
                ui,
                if self.marks_are_own() {
                    texts::marked_joints(marked, joints)
                } else {
                    texts::MARKS_OF_ANOTHER.into()
                },
            );
        }
        if self.motion().is_some() {
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
        bent_by(ui, &mut notes.deformer, around);
        if notes != before {
            self.set_notes(&notes, around);
        }
    }

    /// What comes next, in the bar. It always leads on.
    pub(crate) fn show_steps(&mut self, ui: &mut Ui, around: &mut Around) {
        let text = match (self.motion().is_some(), self.shop.document.clip.is_some()) {
            (true, _) => texts::EXPORT,
            (false, true) => texts::NEXT_MARK_JOINTS,
            (false, false) => texts::CHOOSE_MOTION,
        };
        if widgets::primary_button(ui, text).clicked() {
            self.next(ui.ctx(), around);
        }
    }

    fn next(&mut self, gui: &Gui, around: &mut Around) {
        if self.steps.try_again() {
            // What was cancelled or went wrong is tried again.
            self.go_on(around);
        } else if self.motion().is_some() {
            self.command(Command::Export, gui, around);
        } else if self.shop.document.clip.is_some() {
            self.on_clip = true;
            self.selected = self.selected.or(Some(0));
            around.notices.failed(texts::MARK_JOINTS);
        } else {
            around.picker.ask(gui, Ask::Motion);
        }
    }

    pub(crate) fn command(&mut self, command: Command, gui: &Gui, around: &mut Around) {
        match command {
            Command::Make => self.next(gui, around),
            Command::Cancel => {
                if !(self.hand.cancel() | self.clip.cancel()) {
                    self.selected = None;
                }
            }
            Command::NextLimb => {
                let count = self.figure.as_ref().map_or(0, |f| f.joints.len());
                self.selected = (count > 0).then(|| self.selected.map_or(0, |joint| (joint + 1) % count));
            }
            Command::Tracks => self.bones ^= true,
            Command::Mask => self.mesh ^= true,
            Command::Overlaps => self.needles ^= true,
            Command::Paths => self.clip.paths ^= true,
            Command::Clip => self.on_clip ^= true,
            Command::RemoveStroke => self.unmark(around),
            Command::NextCorrection => self.next_correction(),
            Command::Fit => {
                for looking in [&mut self.looking, &mut self.moving_looking, &mut self.clip.looking] {
                    looking.fit();
                }
            }
            Command::ZoomIn | Command::ZoomOut => {
                let looking = if self.is_marking() { &mut self.clip.looking } else { &mut self.looking };
                looking.command(command);
            }
            _ => {
                if self.shop.command(command, gui, around) && matches!(command, Command::Undo | Command::Redo) {
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
            (_, Some(Ask::MotionClip)) => self.open_clip(gui, path, around),
            ("jpg" | "jpeg" | "webp" | "png", _) | (_, Some(Ask::Picture)) => {
                let read = std::fs::read(path).map_err(|e| texts::unreadable(path, &e));
                if let Some(picture) = around.notices.check(read) {
                    // What was said of another skeleton does not fit this one's.
                    let parts = [(Part::Picture, Some(picture.as_slice())), (Part::Skeleton, None), (Part::Map, None)];
                    let set = self.shop.document.set_parts(texts::EDIT_PICTURE, &parts);
                    around.notices.check(set);
                    // It is looked at as it takes the motion that is there.
                    self.on_clip = self.motion().is_none();
                    self.selected = None;
                    self.go_on(around);
                }
            }
            _ => return false,
        }
        true
    }

    /// Where a place of the drawing is on the screen.
    pub(crate) fn on_screen(&self, at: (f32, f32)) -> Pos2 {
        self.looking.on_screen(at)
    }

    /// Where a place of the clip is on the screen.
    pub(crate) fn on_clip(&self, at: (f32, f32)) -> Pos2 {
        self.clip.looking.on_screen(at)
    }

    /// The joints' places.
    pub(crate) fn joints(&self) -> Vec<(String, (f32, f32))> {
        self.figure.as_ref().map_or_else(Vec::new, |f| f.joints.clone())
    }

    /// Whether the mesh follows a joint now.
    pub(crate) fn is_busy(&self) -> bool {
        self.shop.running.is_some() || self.moving_joint.is_some() || self.reading.is_some() || self.opening.is_some()
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

/// What bends the drawing: what is built in, or a plugin.
fn bent_by(ui: &mut Ui, deformer: &mut String, around: &Around) {
    let built_in = [("", texts::NEEDLES, texts::NEEDLES_ABOUT), ("arap", texts::RIGID, texts::RIGID_ABOUT)];
    let plugins = around.plugins.iter().flat_map(|plugins| plugins.of_kind(PluginKind::Deformer));
    let plugins = plugins.map(|l| (&*l.plugin.id, &*l.plugin.name, &*l.plugin.about));
    let all: Vec<(&str, &str, &str)> = built_in.into_iter().chain(plugins).collect();
    let label = widgets::remark(ui, texts::BENT_BY);
    // What is gone is called as the session calls it; making the motion says what is missing.
    let shown = all.iter().find(|d| d.0 == deformer).map_or(&**deformer, |d| d.1).to_owned();
    let list = ComboBox::from_id_salt("deformer").width(ui.available_width() - 12.0).selected_text(shown);
    let list = list.show_ui(ui, |ui| {
        for (id, name, about) in all {
            if ui.selectable_label(deformer == id, name).on_hover_text(about).clicked() {
                id.clone_into(deformer);
            }
        }
    });
    list.response.labelled_by(label.id);
}
