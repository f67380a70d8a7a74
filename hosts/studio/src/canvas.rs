//! The clip with what is drawn on it: strokes by the pen, zoom at the cursor, pan by Space or the middle button.

use eframe::egui::{
    Color32, DragValue, Event, Key, Painter, PointerButton, Popup, Pos2, Rect, Response, Role, Sense, SetOpenCommand,
    Stroke, Ui, WidgetInfo, pos2, vec2,
};
use marey_binding::Masks;

use crate::brush::{self, Brush, Painted, RADII, Tool};
use crate::document::Document;
use crate::frames::Frames;
use crate::icons::Icon;
use crate::looking::{Looking, WHOLE};
use crate::onion::Onion;
use crate::overlaps::{self, Overlap};
use crate::overlay::{self, MaskPicture, Overlays};
use crate::shortcuts::Command;
use crate::theme::{self, Palette};
use crate::view::Placement;
use crate::{looking, shortcuts, texts, widgets};

/// A stroke that begins or ends so near to another's end is meant to meet it, in points of the screen.
const MEET: f32 = 12.0;
/// A click so near to a limb selects it.
const NEAR: f32 = 10.0;
/// Places of a stroke are so far apart, in points of the screen: finer than a hand is.
const STEP: f32 = 2.0;
/// What a key makes the brush wider or narrower by.
const RESIZE: f32 = 1.25;
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
    /// Said that a limb is in front of another, or behind it.
    Ordered { limb: usize, before: bool, other: usize },
    /// Takes back what was said of a limb's depth on the frame.
    Unordered(usize),
}

pub(crate) struct Canvas {
    pub(crate) looking: Looking,
    pub(crate) overlays: Overlays,
    /// The stroke in the making, in clip pixels.
    stroke: Option<Vec<(f32, f32)>>,
    mask: MaskPicture,
    brush: Brush,
    /// The limb that the open menu is of.
    menu: Option<usize>,
    /// Where the tools lie.
    tools: Rect,
}

impl Default for Canvas {
    fn default() -> Self {
        Self {
            looking: Looking::default(),
            overlays: Overlays::default(),
            stroke: None,
            mask: MaskPicture::default(),
            brush: Brush::default(),
            menu: None,
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
    /// Where limbs lie over each other; none while it plays.
    pub(crate) overlaps: &'a [Overlap],
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

        let placed = self.looking.show(ui, &response, size);
        let mut done = self.hand(ui, &response, placed, shown);

        let picture = placed.picture(size);
        match shown.frames.and_then(Frames::picture) {
            Some(texture) => {
                if shown.frames.is_some_and(|frames| frames.see_through) {
                    looking::checkers(&painter, picture, ui.visuals().dark_mode);
                }
                painter.image(texture.id(), picture, WHOLE, Color32::WHITE);
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
        if self.overlaps_shown() {
            let hovered = response.hover_pos().and_then(|at| overlaps::at(shown.overlaps, placed, at));
            overlaps::paint(&painter, placed, shown.overlaps, hovered);
            if let Some(overlap) = hovered.filter(|_| !self.drawing()) {
                let label = |limb: usize| shown.document.limbs.get(limb).map_or("", |l| &l.label);
                let text = texts::overlap(label(overlap.front), label(overlap.behind));
                response.clone().on_hover_text_at_pointer(text);
            }
        }
        done.extend(self.ask_order(&response, shown));
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
            } else if let Some(o) = overlaps::at(shown.overlaps, placed, at).filter(|_| self.overlaps_shown()) {
                Done::Ordered { limb: o.behind, before: true, other: o.front }
            } else {
                Done::Selected(limb_at(placed, shown, at))
            });
        }
        if response.clicked_by(PointerButton::Secondary)
            && let Some(at) = response.interact_pointer_pos()
        {
            match end_at(placed, shown, at) {
                Some(limb) => {
                    self.menu = None;
                    done.push(Done::Turned(limb));
                }
                None => {
                    self.menu =
                        limb_at(placed, shown, at).filter(|limb| overlaps::of(shown.overlaps, *limb).next().is_some());
                }
            }
        }
        done
    }

    /// Whether marks lie where limbs cross: they are for the pen that draws limbs.
    fn overlaps_shown(&self) -> bool {
        self.overlays.overlaps && !self.brush.paints()
    }

    /// The menu of a limb: in front of which it is, and behind which.
    fn ask_order(&mut self, response: &Response, shown: &Shown<'_>) -> Option<Done> {
        let limb = self.menu?;
        let opens = response.secondary_clicked().then_some(SetOpenCommand::Bool(true));
        let menu = Popup::context_menu(response).open_memory(opens);
        let asked = menu.show(|ui| {
            let mut asked = None;
            for (before, other) in overlaps::of(shown.overlaps, limb) {
                let label = shown.document.limbs.get(other).map_or("", |l| &l.label);
                let text = if before { texts::behind(label) } else { texts::in_front_of(label) };
                if ui.button(text).clicked() {
                    asked = Some(Done::Ordered { limb, before: !before, other });
                }
            }
            let said = shown.document.depth(limb, shown.frame).depth.is_some();
            if said && ui.button(texts::ORDER_UNSAID).clicked() {
                asked = Some(Done::Unordered(limb));
            }
            asked
        });
        match asked {
            Some(asked) => asked.inner,
            None => {
                self.menu = None;
                None
            }
        }
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
            let numbers: Vec<usize> = (0..document.limbs.len()).collect();
            overlay::paths(painter, placed, document, frame, selected, &numbers);
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
        self.tools = looking::toolbar(ui, panel, 2.0, |ui| {
            let Overlays { strokes, tracks, paths, mask, overlaps } = &mut self.overlays;
            let tracked = shown.document.tracked.is_some();
            for (on, text, command, there) in [
                (strokes, texts::STROKES, Command::Strokes, true),
                (tracks, texts::TRACKS, Command::Tracks, tracked),
                (paths, texts::PATHS, Command::Paths, tracked),
                (mask, texts::MASK, Command::Mask, shown.masks.is_some()),
                (overlaps, texts::OVERLAPS, Command::Overlaps, shown.masks.is_some()),
            ] {
                ui.add_enabled_ui(there, |ui| {
                    if widgets::word_toggle(ui, text, *on && there, command) {
                        *on = !*on;
                    }
                });
            }
            ui.add_space(4.0);
            if widgets::command_button(ui, Icon::Fit, texts::FIT, Command::Fit) {
                self.looking.fit();
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
        remove
    }

    /// Does what a key asked for; false for what is not the canvas's.
    pub(crate) fn command(&mut self, command: Command) -> bool {
        if self.looking.command(command) {
            return true;
        }
        match command {
            Command::Strokes => self.overlays.strokes ^= true,
            Command::Tracks => self.overlays.tracks ^= true,
            Command::Paths => self.overlays.paths ^= true,
            Command::Mask => self.overlays.mask ^= true,
            Command::Overlaps => self.overlays.overlaps ^= true,
            Command::ToolLimbs => self.brush.tool = Tool::Limbs,
            Command::ToolCreature => self.brush.tool = Tool::Creature,
            Command::ToolBeside => self.brush.tool = Tool::Beside,
            Command::Narrower => self.brush.resize(1.0 / RESIZE),
            Command::Wider => self.brush.resize(RESIZE),
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
