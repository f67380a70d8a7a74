//! The clip with what is drawn on it: strokes by the pen, zoom at the cursor, pan by Space or the middle button.

use eframe::egui::{
    Color32, CursorIcon, DragValue, Event, Key, Painter, PointerButton, Popup, Pos2, Rect, Response, Role, Sense,
    Stroke, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use marey_binding::Masks;

use crate::brush::{self, Brush, Painted, RADII, Tool};
use crate::document::Document;
use crate::frames::Frames;
use crate::icons::Icon;
use crate::onion::Onion;
use crate::overlay::{self, MaskPicture, Overlays};
use crate::shortcuts::Command;
use crate::theme::{self, Palette};
use crate::view::{Placement, View};
use crate::{shortcuts, texts, widgets};

/// A stroke that begins or ends so near to another's end is meant to meet it, in points of the screen.
const MEET: f32 = 12.0;
/// A click so near to a limb selects it.
const NEAR: f32 = 10.0;
/// Places of a stroke are so far apart, in points of the screen: finer than a hand is.
const STEP: f32 = 2.0;
/// The edges of a panel are taken hold of so far inside of it.
const EDGE: f32 = 5.0;
/// A shorter stroke is a click that slipped.
const SHORTEST: f32 = 8.0;

/// What a person did.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Done {
    /// Drew a stroke, in clip pixels.
    Drew(Vec<(f32, f32)>),
    /// Painted a hint for cutting out.
    Painted(Painted),
    /// Takes all hints off the frame.
    RemovePaint,
    /// Clicked on a limb, or beside all.
    Selected(Option<usize>),
    /// Clicked on a stroke's end, to say how it lies to the camera.
    Turned(usize),
}

pub(crate) struct Canvas {
    pub(crate) view: View,
    pub(crate) overlays: Overlays,
    /// The stroke in the making, in clip pixels.
    stroke: Option<Vec<(f32, f32)>>,
    /// Space was held to pan with, so that letting it go does not play.
    panned: bool,
    mask: MaskPicture,
    brush: Brush,
    /// Where the tools lie.
    tools: Rect,
}

impl Default for Canvas {
    fn default() -> Self {
        Self {
            view: View::default(),
            overlays: Overlays::default(),
            stroke: None,
            panned: false,
            mask: MaskPicture::default(),
            brush: Brush::default(),
            tools: Rect::NOTHING,
        }
    }
}

/// What the canvas shows.
pub(crate) struct Shown<'a> {
    pub(crate) document: &'a Document,
    pub(crate) frames: Option<&'a Frames>,
    pub(crate) masks: Option<&'a Masks>,
    pub(crate) frame: u64,
    pub(crate) selected: Option<usize>,
    pub(crate) onion: Onion,
    /// Whether the first frame comes after the last.
    pub(crate) looped: bool,
}

impl Canvas {
    /// Whether a stroke is in the making.
    pub(crate) fn drawing(&self) -> bool {
        self.stroke.is_some()
    }

    /// Drops the stroke in the making.
    pub(crate) fn cancel(&mut self) {
        self.stroke = None;
    }

    /// Another creature has other masks.
    pub(crate) fn forget_mask(&mut self) {
        self.mask.clear();
    }

    pub(crate) fn show(&mut self, ui: &mut Ui, shown: &Shown<'_>) -> Vec<Done> {
        let palette = Palette::of(ui);
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        painter.rect_filled(panel, 0.0, palette.canvas);
        let Some((_, info)) = &shown.document.clip else {
            message(&painter, panel, texts::NO_CLIP, palette.weak);
            response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, texts::NO_CLIP));
            return Vec::new();
        };
        let size = vec2(info.width as f32, info.height as f32);
        let name = texts::canvas_name(shown.frame, info.frames);
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, &name));

        self.look_around(ui, &response, size);
        let placed = self.view.place(panel, size);
        let mut done = self.hand(ui, &response, placed, shown);

        let picture = placed.picture(size);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        match shown.frames.and_then(Frames::picture) {
            Some(texture) => {
                painter.image(texture.id(), picture, whole, Color32::WHITE);
            }
            None => {
                painter.rect_filled(picture, 0.0, palette.raised);
            }
        }
        if let Some(masks) = shown.masks.filter(|_| self.overlays.mask) {
            let size = [info.width as usize, info.height as usize];
            // A mask that cannot be read is not shown; the job's report says why.
            let _ = self.mask.show(ui.ctx(), &painter, picture, masks, size, shown.frame);
        }
        self.overlay(&painter, placed, shown);
        self.pen(&painter, &response, placed, shown);
        if self.toolbar(ui, panel, shown) {
            done.push(Done::RemovePaint);
        }
        if self.brush.paints() {
            hint(&painter, panel, texts::PAINT_HINT);
        } else if shown.document.limbs.is_empty() && self.stroke.is_none() {
            hint(&painter, panel, texts::DRAW_HINT);
        }
        done
    }

    /// Zoom and pan.
    fn look_around(&mut self, ui: &Ui, response: &Response, size: Vec2) {
        let panel = response.rect;
        if let Some(at) = response.hover_pos() {
            let (zoom, scroll, ctrl) =
                ui.input(|i| (i.zoom_delta(), i.smooth_scroll_delta(), i.modifiers.command || i.modifiers.ctrl));
            let by_wheel = if ctrl { 1.0 } else { (scroll.y / 240.0).exp2() };
            if zoom * by_wheel != 1.0 {
                self.view.zoom(panel, size, at, zoom * by_wheel);
            }
        }
        let space = ui.input(|i| i.key_down(Key::Space)) && !ui.ctx().text_edit_focused();
        if response.dragged_by(PointerButton::Middle) || (space && response.dragged_by(PointerButton::Primary)) {
            self.view.pan(panel, size, response.drag_delta());
            self.panned |= space;
            ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
        } else if space && response.hovered() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
    }

    /// Whether Space, let go now, was for playing; asked once for each time it is let go.
    pub(crate) fn space_was_to_play(&mut self) -> bool {
        !std::mem::take(&mut self.panned)
    }

    /// Draws and selects.
    fn hand(&mut self, ui: &Ui, response: &Response, placed: Placement, shown: &Shown<'_>) -> Vec<Done> {
        let mut done = Vec::new();
        self.brush.hear(ui);
        // The events themselves: of a stroke that lies within one slow frame, nothing else is left.
        for event in ui.input(|i| i.events.clone()) {
            match event {
                Event::PointerButton { pos, button: PointerButton::Primary, pressed: true, .. } => {
                    self.stroke = self.begins(ui, response, pos).then(|| {
                        self.brush.begin();
                        let met = meeting(placed, shown, pos).filter(|_| !self.brush.paints());
                        vec![met.unwrap_or(placed.to_picture(pos))]
                    });
                }
                Event::PointerMoved(at) => self.go_on(placed, at),
                Event::PointerButton { pos, button: PointerButton::Primary, pressed: false, .. } => {
                    self.go_on(placed, pos);
                    let stroke = self.stroke.take().unwrap_or_default();
                    done.extend(self.ended(placed, shown, stroke));
                }
                _ => {}
            }
        }
        if !ui.input(|i| i.pointer.primary_down()) {
            // The button was let go where the window did not see it.
            self.stroke = None;
        }
        if response.clicked_by(PointerButton::Primary)
            && let Some(at) = response.interact_pointer_pos()
        {
            done.push(if self.brush.paints() {
                self.brush.begin();
                Done::Painted(self.brush.hint(vec![placed.to_picture(at)]))
            } else {
                Done::Selected(limb_at(placed, shown, at))
            });
        }
        if response.clicked_by(PointerButton::Secondary)
            && let Some(at) = response.interact_pointer_pos()
        {
            done.extend(end_at(placed, shown, at).map(Done::Turned));
        }
        done
    }

    /// Whether a stroke begins where the button was pressed: on the clip, and on nothing that lies over it.
    fn begins(&self, ui: &Ui, response: &Response, at: Pos2) -> bool {
        let layer = ui.ctx().layer_id_at(at).unwrap_or(response.layer_id);
        // The panel's edges resize it.
        let inside = response.rect.shrink(EDGE).contains(at) && !self.tools.contains(at);
        let moves = ui.input(|i| i.key_down(Key::Space));
        response.enabled() && layer == response.layer_id && inside && !moves && !Popup::is_any_open(ui.ctx())
    }

    fn go_on(&mut self, placed: Placement, at: Pos2) {
        let Some(stroke) = &mut self.stroke else { return };
        if stroke.last().is_none_or(|last| placed.to_screen(*last).distance(at) >= STEP) {
            stroke.push(placed.to_picture(at));
        }
    }

    /// What a stroke is, once it has ended; nothing where it was a click.
    fn ended(&self, placed: Placement, shown: &Shown<'_>, mut stroke: Vec<(f32, f32)>) -> Option<Done> {
        if length(&stroke) * placed.scale < SHORTEST {
            return None;
        }
        if self.brush.paints() {
            return Some(Done::Painted(self.brush.hint(stroke)));
        }
        if let Some(last) = stroke.last_mut()
            && let Some(met) = meeting(placed, shown, placed.to_screen(*last))
        {
            *last = met;
        }
        Some(Done::Drew(stroke))
    }

    fn overlay(&self, painter: &Painter, placed: Placement, shown: &Shown<'_>) {
        let Shown { document, frame, selected, .. } = *shown;
        brush::paint(painter, placed, document.painted(frame));
        shown.onion.paint(painter, placed, document, frame, shown.looped);
        if self.overlays.paths {
            overlay::paths(painter, placed, document, frame, selected);
        }
        if self.overlays.tracks {
            overlay::tracks(painter, placed, document, frame, selected);
        }
        if self.overlays.strokes {
            overlay::strokes(painter, placed, document, frame, selected);
        }
        if let Some(limb) = selected {
            overlay::name(painter, placed, document, frame, limb);
        }
    }

    /// The stroke in the making, how long its limb is, and where a stroke would meet another.
    fn pen(&self, painter: &Painter, response: &Response, placed: Placement, shown: &Shown<'_>) {
        if self.brush.paints() {
            let radius = self.brush.width() * placed.scale;
            if let Some(stroke) = &self.stroke {
                let points: Vec<Pos2> = stroke.iter().map(|p| placed.to_screen(*p)).collect();
                brush::band(painter, &points, radius, self.brush.color());
            }
            if let Some(at) = response.hover_pos() {
                painter.circle_stroke(at, radius, Stroke::new(1.5, self.brush.color()));
            }
            return;
        }
        let limb = shown.selected.unwrap_or(shown.document.limbs.len());
        let color = theme::limb(limb);
        if let Some(stroke) = &self.stroke {
            let points: Vec<Pos2> = stroke.iter().map(|p| placed.to_screen(*p)).collect();
            overlay::line(painter, &points, 4.0, color);
            let length = shown.document.limbs.get(limb).map_or(0.0, |l| l.length);
            if length > 0.0 {
                painter.circle_stroke(points[0], length * placed.scale, Stroke::new(1.0, color.gamma_multiply(0.7)));
            }
        }
        let at = response.hover_pos().or_else(|| response.interact_pointer_pos());
        if let Some(met) = at.and_then(|at| meeting(placed, shown, at)) {
            painter.circle_stroke(placed.to_screen(met), MEET * 0.75, Stroke::new(2.0, Color32::WHITE));
        }
    }

    /// What is shown, by words in a corner, and what the pen does; whether all paint of the frame is to go.
    fn toolbar(&mut self, ui: &mut Ui, panel: Rect, shown: &Shown<'_>) -> bool {
        let mut remove = false;
        let palette = Palette::of(ui);
        let at = Rect::from_min_size(panel.min + vec2(10.0, 10.0), vec2(panel.width() - 20.0, 36.0));
        let builder = eframe::egui::UiBuilder::new().max_rect(at);
        ui.scope_builder(builder, |ui| {
            let frame = eframe::egui::Frame::new()
                .fill(palette.panel.gamma_multiply(0.92))
                .corner_radius(8)
                .inner_margin(eframe::egui::Margin::symmetric(6, 3));
            let tools = frame.show(ui, |ui| {
                ui.horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = 2.0;
                    let Overlays { strokes, tracks, paths, mask } = &mut self.overlays;
                    let tracked = shown.document.tracked.is_some();
                    for (on, text, command, there) in [
                        (strokes, texts::STROKES, Command::Strokes, true),
                        (tracks, texts::TRACKS, Command::Tracks, tracked),
                        (paths, texts::PATHS, Command::Paths, tracked),
                        (mask, texts::MASK, Command::Mask, shown.masks.is_some()),
                    ] {
                        ui.add_enabled_ui(there, |ui| {
                            if widgets::word_toggle(ui, text, *on && there, command) {
                                *on = !*on;
                            }
                        });
                    }
                    ui.add_space(4.0);
                    if widgets::command_button(ui, Icon::Fit, texts::FIT, Command::Fit) {
                        self.view.fit();
                    }
                    ui.add_space(4.0);
                    for (tool, icon, text, command) in [
                        (Tool::Limbs, Icon::Pencil, texts::TOOL_LIMBS, Command::ToolLimbs),
                        (Tool::Creature, Icon::Brush, texts::TOOL_CREATURE, Command::ToolCreature),
                        (Tool::Beside, Icon::Eraser, texts::TOOL_BESIDE, Command::ToolBeside),
                    ] {
                        let hint = shortcuts::hint(ui.ctx(), text, command);
                        if widgets::plain_icon(ui, icon, text, self.brush.tool == tool).on_hover_text(hint).clicked() {
                            self.brush.tool = tool;
                        }
                    }
                    if self.brush.paints() {
                        let radius = DragValue::new(&mut self.brush.radius).range(RADII.0..=RADII.1).suffix(" px");
                        ui.add(radius.max_decimals(0)).accessible_name(texts::BRUSH).on_hover_text(texts::BRUSH);
                    }
                    if !shown.document.painted(shown.frame).is_empty() {
                        remove = ui.button(texts::REMOVE_PAINT).clicked();
                    }
                });
            });
            self.tools = tools.response.rect;
        });
        remove
    }

    /// Does what a key asked for; false for what is not the canvas's.
    pub(crate) fn command(&mut self, command: Command, panel: Rect, size: Vec2) -> bool {
        let zoom = 1.25;
        match command {
            Command::Fit => self.view.fit(),
            Command::ZoomIn => self.view.zoom(panel, size, panel.center(), zoom),
            Command::ZoomOut => self.view.zoom(panel, size, panel.center(), 1.0 / zoom),
            Command::Strokes => self.overlays.strokes ^= true,
            Command::Tracks => self.overlays.tracks ^= true,
            Command::Paths => self.overlays.paths ^= true,
            Command::Mask => self.overlays.mask ^= true,
            Command::ToolLimbs => self.brush.tool = Tool::Limbs,
            Command::ToolCreature => self.brush.tool = Tool::Creature,
            Command::ToolBeside => self.brush.tool = Tool::Beside,
            Command::Narrower => self.brush.resize(1.0 / zoom),
            Command::Wider => self.brush.resize(zoom),
            _ => return false,
        }
        true
    }
}

/// The end of a stroke that one at `at` would meet.
fn meeting(placed: Placement, shown: &Shown<'_>, at: Pos2) -> Option<(f32, f32)> {
    let drawn = shown.document.strokes_on(shown.frame).filter(|(limb, _)| Some(*limb) != shown.selected);
    let ends = drawn.flat_map(|(_, s)| [s.points.first(), s.points.last()]).flatten();
    let distance = |p: &(f32, f32)| placed.to_screen(*p).distance(at);
    ends.copied().filter(|p| distance(p) <= MEET).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// The limb whose stroke on this frame ends at a place.
fn end_at(placed: Placement, shown: &Shown<'_>, at: Pos2) -> Option<usize> {
    let ends = shown.document.strokes_on(shown.frame);
    let ends = ends.filter_map(|(limb, s)| Some((limb, placed.to_screen(*s.points.last()?).distance(at))));
    ends.filter(|(_, far)| *far <= MEET).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(limb, _)| limb)
}

/// The limb whose stroke or track is at a place.
fn limb_at(placed: Placement, shown: &Shown<'_>, at: Pos2) -> Option<usize> {
    let document = shown.document;
    let points = |limb: usize| {
        let drawn = document.stroke(limb, shown.frame).map(|s| &s.points[..]);
        let followed = || Some(&document.tracked.as_ref()?.limbs.get(limb)?.get(shown.frame as usize)?.points[..]);
        drawn.or_else(followed).unwrap_or(&[])
    };
    let distance = |limb: usize| {
        let line: Vec<Pos2> = points(limb).iter().map(|p| placed.to_screen(*p)).collect();
        line.windows(2).map(|pair| to_segment(at, pair[0], pair[1])).fold(f32::INFINITY, f32::min)
    };
    let all = (0..document.limbs.len()).map(|limb| (limb, distance(limb)));
    all.filter(|(_, d)| *d <= NEAR).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(limb, _)| limb)
}

fn to_segment(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let along = to - from;
    let share = ((at - from).dot(along) / along.length_sq().max(f32::EPSILON)).clamp(0.0, 1.0);
    at.distance(from + along * share)
}

fn length(points: &[(f32, f32)]) -> f32 {
    points.windows(2).map(|p| vec2(p[1].0 - p[0].0, p[1].1 - p[0].1).length()).sum()
}

fn message(painter: &Painter, panel: Rect, text: &str, color: Color32) {
    let font = eframe::egui::FontId::proportional(15.0);
    painter.text(panel.center(), eframe::egui::Align2::CENTER_CENTER, text, font, color);
}

/// What to do, at the lower edge of the picture.
pub(crate) fn hint(painter: &Painter, panel: Rect, text: &str) {
    let font = eframe::egui::FontId::proportional(15.0);
    let galley = painter.layout(text.to_owned(), font, Color32::WHITE, (panel.width() - 80.0).clamp(120.0, 620.0));
    let size = galley.size() + vec2(28.0, 18.0);
    let ground = Rect::from_center_size(pos2(panel.center().x, panel.bottom() - size.y / 2.0 - 14.0), size);
    painter.rect_filled(ground, 8.0, Color32::from_black_alpha(200));
    painter.galley(ground.min + vec2(14.0, 9.0), galley, Color32::WHITE);
}

/// The tooltip for playing says its key; kept here because the key also pans.
pub(crate) fn play_hint(ui: &Ui, playing: bool) -> String {
    shortcuts::hint(ui.ctx(), if playing { texts::PAUSE } else { texts::PLAY }, Command::Play)
}
