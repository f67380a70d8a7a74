//! What a person meets first: three doors, a sample, and what was open before.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use eframe::egui::{
    Align, Button, CentralPanel, Color32, ColorImage, CornerRadius, Frame, Label, Layout, Rect, RichText, ScrollArea,
    Sense, Stroke, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use marey_binding::Context;

use crate::background::Background;
use crate::icons::Icon;
use crate::opening::Source;
use crate::preferences::Recent;
use crate::theme::Palette;
use crate::{Places, frames, sample, texts, widgets};

/// Doors side by side.
const WIDE: f32 = 980.0;

/// What a person asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    PickClip,
    /// A picture for a character.
    PickPicture,
    /// A clip for a drawing that lives.
    PickDrawingClip,
    PickSession,
    Open(Source),
    /// Drop a session that was never saved.
    Discard(PathBuf),
    /// Take a session off the list.
    Forget(PathBuf),
}

/// A session that was never saved.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Unsaved {
    path: PathBuf,
    title: String,
    age: String,
}

pub(crate) struct Start {
    unsaved: Vec<Unsaved>,
    recent: Vec<Recent>,
    /// A picture of each sample.
    samples: [Option<TextureHandle>; 3],
    reading: Option<Background<[Option<ColorImage>; 3]>>,
    /// The session that is about to be dropped, when it was asked once.
    sure: Option<PathBuf>,
}

impl Start {
    pub(crate) fn new(ui: &eframe::egui::Context, context: &Context, places: &Places, recent: &[Recent]) -> Self {
        let left = context.sessions_left_in(&places.unsaved.to_string_lossy()).unwrap_or_default();
        let title = |path: &Path| recent.iter().find(|r| r.path == path).map(|r| r.title.clone());
        let unsaved = left.into_iter().map(PathBuf::from).map(|path| Unsaved {
            title: title(&path).unwrap_or_else(|| texts::UNSAVED_ONE.into()),
            age: age(&path),
            path,
        });
        let named = recent.iter().filter(|r| !r.path.starts_with(&places.unsaved) && r.path.exists());
        let (context, samples) = (context.clone(), places.samples.clone());
        let reading = Background::start(ui, move || pictures(&context, &samples));
        Self {
            unsaved: unsaved.collect(),
            recent: named.cloned().collect(),
            samples: [None, None, None],
            reading: Some(reading),
            sure: None,
        }
    }

    pub(crate) fn show(&mut self, ui: &mut Ui) -> Option<Asked> {
        if let Some(reading) = &self.reading {
            match reading.answer() {
                Ok(None) => {}
                Ok(Some(pictures)) => {
                    let load = |picture| ui.ctx().load_texture("sample", picture, TextureOptions::LINEAR);
                    (self.samples, self.reading) = (pictures.map(|picture| picture.map(load)), None);
                }
                Err(()) => self.reading = None,
            }
        }
        let mut asked = None;
        let palette = Palette::of(ui);
        CentralPanel::default().frame(Frame::new().fill(palette.panel)).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                let room = ui.available_width();
                let side = ((room - WIDE) / 2.0).max(24.0);
                ui.add_space((ui.available_height() * 0.07).clamp(16.0, 72.0));
                ui.horizontal_top(|ui| {
                    ui.add_space(side);
                    ui.vertical(|ui| {
                        ui.set_width(room - 2.0 * side);
                        title(ui);
                        ui.add_space(24.0);
                        asked = doors(ui);
                        ui.add_space(28.0);
                        asked = self.lists(ui).or(asked.take());
                        ui.add_space(24.0);
                    });
                });
            });
        });
        asked
    }

    fn lists(&mut self, ui: &mut Ui) -> Option<Asked> {
        let mut asked = None;
        ui.columns(2, |columns| {
            let ui = &mut columns[0];
            head(ui, texts::SAMPLES, None);
            for (sample, picture) in SAMPLES.iter().zip(&self.samples) {
                if sample_card(ui, sample, picture.as_ref()) {
                    asked = Some(Asked::Open(sample.source.clone()));
                }
            }
            let ui = &mut columns[1];
            if !self.unsaved.is_empty() {
                head(ui, texts::UNSAVED, None);
                asked = self.unsaved(ui).or(asked.take());
                ui.add_space(16.0);
            }
            if head(ui, texts::RECENT, Some(texts::OPEN_SESSION)) {
                asked = Some(Asked::PickSession);
            }
            if self.recent.is_empty() {
                ui.with_layout(Layout::top_down(Align::Min), |ui| widgets::remark(ui, texts::NO_RECENT));
            }
            for recent in &self.recent {
                let folder = recent.path.parent().map(|p| p.to_string_lossy().into_owned()).unwrap_or_default();
                match line(ui, &recent.title, &folder, texts::FORGET) {
                    Some(true) => asked = Some(Asked::Open(Source::Session(recent.path.clone()))),
                    Some(false) => asked = Some(Asked::Forget(recent.path.clone())),
                    None => {}
                }
            }
        });
        asked
    }

    fn unsaved(&mut self, ui: &mut Ui) -> Option<Asked> {
        let mut asked = None;
        for unsaved in &self.unsaved {
            if self.sure.as_ref() == Some(&unsaved.path) {
                ui.horizontal(|ui| {
                    ui.label(texts::discard_sure(&unsaved.title));
                    if ui.button(texts::DISCARD).clicked() {
                        asked = Some(Asked::Discard(unsaved.path.clone()));
                    }
                    if ui.button(texts::KEEP).clicked() {
                        self.sure = None;
                    }
                });
                // One at a time.
                break;
            }
            match line(ui, &unsaved.title, &unsaved.age, texts::DISCARD) {
                Some(true) => asked = Some(Asked::Open(Source::Session(unsaved.path.clone()))),
                Some(false) => self.sure = Some(unsaved.path.clone()),
                None => {}
            }
        }
        asked
    }
}

/// A heading, and perhaps what leads on from it: whether that was asked for.
fn head(ui: &mut Ui, text: &str, link: Option<&str>) -> bool {
    let row = ui.horizontal(|ui| {
        ui.set_min_height(24.0);
        widgets::section(ui, text);
        let right =
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| link.is_some_and(|link| ui.link(link).clicked()));
        right.inner
    });
    row.inner
}

fn title(ui: &mut Ui) {
    ui.label(RichText::new(texts::PROGRAM).size(34.0).strong());
    let weak = Palette::of(ui).weak;
    ui.label(RichText::new(texts::SUBTITLE).size(16.0).color(weak));
}

fn doors(ui: &mut Ui) -> Option<Asked> {
    let mut asked = None;
    ui.columns(3, |columns| {
        let doors = [
            (Icon::Clip, texts::DOOR_CREATURE, texts::DOOR_CREATURE_TEXT, texts::CHOOSE_CLIP, Asked::PickClip),
            (
                Icon::Figure,
                texts::DOOR_CHARACTER,
                texts::DOOR_CHARACTER_TEXT,
                texts::CHOOSE_PICTURE,
                Asked::PickPicture,
            ),
            (
                Icon::Pencil,
                texts::DOOR_DRAWING,
                texts::DOOR_DRAWING_TEXT,
                texts::CHOOSE_DRAWING_CLIP,
                Asked::PickDrawingClip,
            ),
        ];
        for (column, (icon, title, text, button, ask)) in columns.iter_mut().zip(doors) {
            if door(column, icon, title, text, button) {
                asked = Some(ask);
            }
        }
    });
    asked
}

fn door(ui: &mut Ui, icon: Icon, title: &str, text: &str, button: &str) -> bool {
    let palette = Palette::of(ui);
    let outline = Stroke::new(1.0, palette.accent);
    let card = Frame::new().fill(palette.raised).stroke(outline).corner_radius(10).inner_margin(18);
    let card = card.show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.set_min_height(190.0);
        // Columns press what is in them to their width.
        ui.with_layout(Layout::top_down(Align::Min), |ui| card_of(ui, icon, title, text, button)).inner
    });
    card.inner
}

fn card_of(ui: &mut Ui, icon: Icon, title: &str, text: &str, button: &str) -> bool {
    let palette = Palette::of(ui);
    icon.show(ui, 34.0, palette.accent);
    ui.add_space(4.0);
    ui.label(RichText::new(title).size(18.0).color(palette.text).strong());
    ui.add(Label::new(RichText::new(text).color(palette.weak)).wrap());
    // Buttons of all doors in one line.
    ui.add_space((132.0 - ui.min_rect().height()).max(6.0));
    let clicked = widgets::primary_button(ui, button).clicked();
    if title == texts::DOOR_CREATURE {
        ui.label(RichText::new(texts::OR_DROP).size(12.0).color(palette.weak));
    }
    clicked
}

fn sample_card(ui: &mut Ui, sample: &Sample, picture: Option<&TextureHandle>) -> bool {
    let palette = Palette::of(ui);
    let size = vec2(ui.available_width().min(460.0), 84.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| WidgetInfo::labeled(eframe::egui::Role::Button, true, sample.open));
    let active = response.hovered() || response.has_focus();
    let (fill, outline) = if active { (palette.hovered, palette.accent) } else { (palette.raised, palette.outline) };
    let painter = ui.painter();
    painter.rect(rect, 8.0, fill, Stroke::new(1.0, outline), eframe::egui::StrokeKind::Inside);
    let inner = rect.shrink(8.0);
    let image = Rect::from_min_size(inner.min, Vec2::new(inner.height() * 4.0 / 3.0, inner.height()));
    match picture {
        Some(texture) => {
            // The paper of a drawing goes on beside it.
            painter.rect_filled(image, 5.0, Color32::WHITE);
            let of = texture.size_vec2();
            let image = Rect::from_center_size(image.center(), of * (image.size() / of).min_elem());
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            let shape = eframe::egui::epaint::RectShape::filled(image, CornerRadius::same(5), Color32::WHITE);
            painter.add(shape.with_texture(texture.id(), whole));
        }
        None => {
            painter.rect_filled(image, 5.0, palette.canvas);
        }
    }
    let text = |size: f32, color: Color32, at: f32, text: &str| {
        let room = inner.right() - image.right() - 20.0;
        let galley = painter.layout(text.to_owned(), eframe::egui::FontId::proportional(size), color, room);
        painter.galley(pos2(image.right() + 14.0, inner.top() + at), galley, color);
    };
    text(16.0, palette.text, 4.0, sample.name);
    text(13.0, palette.weak, 28.0, sample.text);
    response.clicked()
}

/// A line that can be opened, `true`, or taken off, `false`.
fn line(ui: &mut Ui, title: &str, more: &str, off: &str) -> Option<bool> {
    let mut asked = None;
    let weak = Palette::of(ui).weak;
    ui.horizontal(|ui| {
        let room = ui.available_width() - 40.0;
        let more = RichText::new(more).size(12.0).color(weak);
        let button = Button::new(title).right_text(more).min_size(vec2(room, 32.0)).truncate();
        if ui.add_sized(vec2(room, 32.0), button).accessible_name(texts::open_named(title)).clicked() {
            asked = Some(true);
        }
        if widgets::icon_button(ui, Icon::Close, &texts::with_name(off, title)).clicked() {
            asked = Some(false);
        }
    });
    asked
}

/// How long ago a session was worked on: its journal is written to with every gesture.
fn age(path: &Path) -> String {
    let newest = [path.to_owned(), path.with_extension("marey-journal")]
        .iter()
        .filter_map(|p| std::fs::metadata(p).ok()?.modified().ok())
        .max();
    newest
        .and_then(|at| SystemTime::now().duration_since(at).ok())
        .map_or_else(String::new, |age| texts::ago(age.as_secs()))
}

/// Something to try.
struct Sample {
    source: Source,
    name: &'static str,
    text: &'static str,
    open: &'static str,
}

/// One for each door.
const SAMPLES: [Sample; 3] = [
    Sample { source: Source::Fox, name: texts::FOX, text: texts::FOX_TEXT, open: texts::OPEN_FOX },
    Sample { source: Source::Child, name: texts::CHILD, text: texts::CHILD_TEXT, open: texts::OPEN_CHILD },
    Sample { source: Source::Horse, name: texts::HORSE, text: texts::HORSE_TEXT, open: texts::OPEN_HORSE },
];

/// A picture of each sample, small.
fn pictures(context: &Context, samples: &Path) -> [Option<ColorImage>; 3] {
    let first = |path: std::io::Result<PathBuf>| {
        let clip = context.open_clip(&path.ok()?.to_string_lossy()).ok()?;
        let info = clip.info().ok()?;
        Some(frames::read(&clip, 0, [info.width as usize, info.height as usize], Some(160)).ok()?.0)
    };
    [first(sample::clip(samples)), first(sample::child_picture(samples)), first(sample::gallop(samples))]
}
