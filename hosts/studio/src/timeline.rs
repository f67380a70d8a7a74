//! The clip in time: small pictures, key frames as diamonds, where it is unsure, and what plays.

use eframe::egui::{
    Align, Align2, Color32, EventFilter, FontId, Key, Layout, Modifiers, Popup, PopupCloseBehavior, Pos2, Rect,
    Response, RichText, Sense, Shape, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

use crate::document::Document;
use crate::frames::Frames;
use crate::icons::{Icon, diamond};
use crate::onion::Onion;
use crate::playback::Playback;
use crate::shortcuts::Command;
use crate::theme::Palette;
use crate::timing::{self, Timing};
use crate::{canvas, texts, widgets};

/// Room for the diamonds above the pictures, and for the marks below.
const KEYS: f32 = 20.0;
const MARKS: f32 = 10.0;
const PICTURES: f32 = 52.0;
/// A key frame is taken hold of so near to its diamond.
const HOLD: f32 = 8.0;

pub(crate) const HEIGHT: f32 = 28.0 + KEYS + PICTURES + MARKS + 36.0;

/// What a person asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    Seek(u64),
    Do(Command),
    Time(Timing),
    /// Move a key frame.
    MoveKey(u64, u64),
}

#[derive(Debug, Default)]
pub(crate) struct Timeline {
    /// The key frame that is held, and where it is now.
    held: Option<(u64, u64)>,
}

impl Timeline {
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        document: &Document,
        frames: Option<&Frames>,
        playback: &Playback,
        onion: Option<&mut Onion>,
    ) -> Vec<Asked> {
        let mut asked = controls(ui, document, playback, onion);
        if document.clip.is_some() {
            self.strip(ui, document, frames, playback, &mut asked);
        }
        asked
    }

    fn strip(
        &mut self,
        ui: &mut Ui,
        document: &Document,
        frames: Option<&Frames>,
        playback: &Playback,
        asked: &mut Vec<Asked>,
    ) {
        let palette = Palette::of(ui);
        let (count, last) = (document.frames().max(1), playback.last());
        let size = vec2(ui.available_width(), KEYS + PICTURES + MARKS);
        let (response, painter) = ui.allocate_painter(size, Sense::click_and_drag());
        let name = texts::timeline_name(playback.frame(), count);
        response.widget_info(|| WidgetInfo::slider(true, playback.frame() as f64, &name));
        let whole = response.rect.shrink2(vec2(HOLD, 0.0));
        let strip = Rect::from_min_size(whole.min + vec2(0.0, KEYS), vec2(whole.width(), PICTURES));
        // The middle of a frame's share of the strip.
        let x_of = |frame: u64| strip.left() + strip.width() * (frame as f32 + 0.5) / count as f32;
        let frame_at = |x: f32| ((((x - strip.left()) / strip.width()) * count as f32).max(0.0) as u64).min(last);

        if response.has_focus() {
            by_keys(ui, &response, document, playback, asked);
            painter.rect_stroke(strip.expand(2.0), 5.0, Stroke::new(1.5, palette.accent), StrokeKind::Outside);
        }
        painter.rect_filled(strip, 4.0, palette.raised);
        if let Some(frames) = frames {
            pictures(&painter.with_clip_rect(strip), strip, frames, document);
        }
        if let Some(tracked) = &document.tracked {
            for correction in tracked.corrections.iter().take(12) {
                let at = pos2(x_of(correction.frame), strip.bottom() + 3.0);
                let corners = vec![at, at + vec2(4.0, 6.5), at + vec2(-4.0, 6.5)];
                painter.add(Shape::convex_polygon(corners, palette.bad, Stroke::NONE));
            }
        }
        for key in &document.keys {
            let at = pos2(x_of(self.held.filter(|h| h.0 == *key).map_or(*key, |h| h.1)), strip.top() - KEYS / 2.0);
            let now = *key == playback.frame();
            let radius = if now { 7.0 } else { 5.5 };
            diamond(&painter, at, radius, palette.accent, Stroke::new(1.0, palette.panel));
        }
        playhead(&painter, x_of(playback.frame()), strip, &palette, playback.frame());

        let near = |at: Pos2| {
            let far = |key: &u64| (x_of(*key) - at.x).abs();
            let above = at.y < strip.top();
            document.keys.iter().copied().filter(|k| above && far(k) <= HOLD).min_by(|a, b| far(a).total_cmp(&far(b)))
        };
        if response.drag_started() {
            let key = ui.input(|i| i.pointer.press_origin()).and_then(near);
            self.held = key.map(|key| (key, key));
        }
        let at = response.interact_pointer_pos();
        match (&mut self.held, at) {
            (Some(held), Some(at)) if response.dragged() => held.1 = frame_at(at.x),
            (None, Some(at)) if response.dragged() || response.clicked() => {
                asked.push(Asked::Seek(near(at).unwrap_or(frame_at(at.x))));
            }
            _ => {}
        }
        if response.drag_stopped()
            && let Some((from, to)) = self.held.take()
            && from != to
        {
            asked.push(Asked::MoveKey(from, to));
        }
        if let Some(at) = response.hover_pos().filter(|_| !response.dragged()) {
            match near(at) {
                Some(key) => response.show_tooltip_text(texts::key_frame(key)),
                None => response.show_tooltip_text(texts::frame_name(frame_at(at.x))),
            }
        }
    }
}

/// What the keys do while the timeline has them: arrows go along the clip, with Shift they take the key frame along.
fn by_keys(ui: &Ui, response: &Response, document: &Document, playback: &Playback, asked: &mut Vec<Asked>) {
    let arrows = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
    let frame = playback.frame();
    for (key, to, command) in [
        (Key::ArrowLeft, frame.checked_sub(1), Command::PreviousFrame),
        (Key::ArrowRight, Some(frame + 1).filter(|to| *to <= playback.last()), Command::NextFrame),
    ] {
        if ui.input_mut(|i| i.consume_key(Modifiers::SHIFT, key)) {
            asked.extend(to.filter(|_| document.keys.contains(&frame)).map(|to| Asked::MoveKey(frame, to)));
        } else if ui.input_mut(|i| i.consume_key(Modifiers::NONE, key)) {
            asked.push(Asked::Do(command));
        }
    }
    if ui.input(|i| i.key_released(Key::Space)) {
        asked.push(Asked::Do(Command::Play));
    }
}

/// Playing, the frame's number, and what is next to correct.
fn controls(ui: &mut Ui, document: &Document, playback: &Playback, onion: Option<&mut Onion>) -> Vec<Asked> {
    let mut asked = Vec::new();
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.add_enabled_ui(document.clip.is_some(), |ui| {
            let mut button = |ui: &mut Ui, icon, text, command| {
                if widgets::command_button(ui, icon, text, command) {
                    asked.push(Asked::Do(command));
                }
            };
            button(ui, Icon::First, texts::FIRST_FRAME, Command::FirstFrame);
            button(ui, Icon::Previous, texts::PREVIOUS_FRAME, Command::PreviousFrame);
            let (icon, text) = if playback.playing() { (Icon::Pause, texts::PAUSE) } else { (Icon::Play, texts::PLAY) };
            let play =
                widgets::icon_toggle(ui, icon, text, false).on_hover_text(canvas::play_hint(ui, playback.playing()));
            if play.clicked() {
                asked.push(Asked::Do(Command::Play));
            }
            let mut button = |ui: &mut Ui, icon, text, command| {
                if widgets::command_button(ui, icon, text, command) {
                    asked.push(Asked::Do(command));
                }
            };
            button(ui, Icon::Next, texts::NEXT_FRAME, Command::NextFrame);
            button(ui, Icon::Last, texts::LAST_FRAME, Command::LastFrame);
            if widgets::icon_toggle(ui, Icon::Loop, texts::LOOP, playback.looped).clicked() {
                asked.push(Asked::Do(Command::Loop));
            }
        });
        ui.add_space(6.0);
        asked.extend(timing::menu(ui, &document.timing()).map(Asked::Time));
        ui.add_space(8.0);
        if let Some(onion) = onion {
            let hint = crate::shortcuts::hint(ui.ctx(), texts::ONION, Command::Onion);
            if widgets::icon_toggle(ui, Icon::Onion, texts::ONION, onion.on).on_hover_text(hint).clicked() {
                onion.on ^= true;
            }
            let menu = widgets::icon_button(ui, Icon::Sliders, texts::ONION_SETTINGS);
            Popup::menu(&menu).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| onion.settings(ui));
            ui.add_space(8.0);
        }
        let seconds = playback.frame() as f64 / playback.fps();
        ui.label(RichText::new(texts::place_in_time(playback.frame(), document.frames(), seconds)).monospace());
        let corrections = document.tracked.as_ref().map_or(0, |t| t.corrections.len());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 12.0;
            if corrections > 0 {
                let hint = crate::shortcuts::hint(ui.ctx(), texts::NEXT_CORRECTION_HINT, Command::NextCorrection);
                if ui.button(texts::NEXT_CORRECTION).on_hover_text(hint).clicked() {
                    asked.push(Asked::Do(Command::NextCorrection));
                }
            }
            widgets::remark(ui, texts::key_frames(document.keys.len()));
        });
    });
    asked
}

/// Small pictures side by side, each as wide as it is; the strip is filled whatever its width.
fn pictures(painter: &eframe::egui::Painter, strip: Rect, frames: &Frames, document: &Document) {
    let Some((_, info)) = &document.clip else { return };
    let wide = strip.height() * info.width as f32 / info.height.max(1) as f32;
    let slots = ((strip.width() / wide).ceil() as usize).max(1);
    let wide = strip.width() / slots as f32;
    let small = frames.small();
    for slot in 0..slots {
        let at = Rect::from_min_size(strip.min + vec2(slot as f32 * wide, 0.0), vec2(wide, strip.height()));
        let frame = ((slot as f64 + 0.5) / slots as f64 * info.frames as f64) as u64;
        let Some((_, Some(texture))) = small.iter().min_by_key(|(f, _)| f.abs_diff(frame)) else { continue };
        // Cut at the sides rather than pressed.
        let share = (wide / strip.height()) / (info.width as f32 / info.height.max(1) as f32);
        let (left, right) = (0.5 - 0.5 * share.min(1.0), 0.5 + 0.5 * share.min(1.0));
        painter.image(texture.id(), at, Rect::from_min_max(pos2(left, 0.0), pos2(right, 1.0)), Color32::WHITE);
    }
}

fn playhead(painter: &eframe::egui::Painter, x: f32, strip: Rect, palette: &Palette, frame: u64) {
    let line = Rect::from_min_max(pos2(x - 1.0, strip.top() - 2.0), pos2(x + 1.0, strip.bottom() + 2.0));
    painter.rect_filled(line.expand(1.0), 2.0, Color32::from_black_alpha(140));
    painter.rect_filled(line, 1.0, Color32::WHITE);
    let galley = painter.layout_no_wrap((frame + 1).to_string(), FontId::proportional(11.0), Color32::WHITE);
    let size = galley.size() + vec2(8.0, 2.0);
    let flag = Align2::CENTER_BOTTOM.anchor_size(pos2(x, strip.bottom() + MARKS + 1.0), size);
    painter.rect(flag, 3.0, Color32::from_black_alpha(220), Stroke::new(1.0, palette.outline), StrokeKind::Inside);
    painter.galley(flag.min + vec2(4.0, 1.0), galley, Color32::WHITE);
}
