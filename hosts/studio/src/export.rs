//! One dialog for everything that can be written, with what it will look like. It remembers; one key does it again.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::{
    Align, Button, Color32, ColorImage, ComboBox, Context as Ui, Grid, Id, Label, Layout, Modal, Rect, RichText,
    ScrollArea, Sense, TextEdit, TextureHandle, TextureOptions, pos2, vec2,
};
use marey_binding::{
    Camera, ClipInfo, Context, Creature, CreatureFile, Error, Job, RenderFileOptions, RenderOptions, SketchFileOptions,
    Style, TakeFileOptions,
};
use serde::{Deserialize, Serialize};

use crate::around::Around;
use crate::background::Background;
use crate::document::Door;
use crate::moving::Moving;
use crate::picker::Ask;
use crate::playback::Played;
use crate::running::{Purpose, Running};
use crate::theme::{self, Palette};
use crate::{looking, texts, view3d, widgets};

/// Pixels of the preview, which lies on as many points at most.
const PREVIEW: (u32, u32) = (300, 225);
/// Points across of the list of formats.
const FORMATS: f32 = 340.0;
/// What can be chosen for the height of pictures; 0 for the clip's.
const HEIGHTS: [u32; 5] = [0, 360, 480, 720, 1080];
/// What can be chosen for the size of pictures of a drawing, in percent of it; 0 for its own.
const PERCENTS: [u32; 4] = [50, 0, 200, 400];

/// What is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Format {
    #[default]
    Glb,
    Folder,
    Gif,
    Apng,
    Webp,
    Mp4,
    Pictures,
    Sheet,
    Svg,
    Lottie,
    Spine,
    DragonBones,
}

impl Format {
    /// What there is for what is made behind a door.
    fn all(door: Door) -> &'static [Self] {
        use Format::{Apng, DragonBones, Folder, Gif, Glb, Lottie, Mp4, Pictures, Sheet, Spine, Svg, Webp};
        match door {
            Door::Creature => &[Glb, Folder, Gif, Apng, Webp, Mp4, Pictures, Sheet],
            Door::Character => &[Gif, Apng, Webp, Mp4, Lottie, Glb, Spine, DragonBones, Pictures, Sheet],
            Door::Drawing => &[Svg, Lottie, Gif, Apng, Webp, Mp4, Pictures, Sheet],
        }
    }

    fn name_and_use(self) -> (&'static str, &'static str) {
        match self {
            Self::Glb => (texts::GLB, texts::GLB_USE),
            Self::Folder => (texts::FOLDER, texts::FOLDER_USE),
            Self::Gif => (texts::GIF, texts::GIF_USE),
            Self::Apng => (texts::APNG, texts::APNG_USE),
            Self::Webp => (texts::WEBP, texts::WEBP_USE),
            Self::Mp4 => (texts::MP4, texts::MP4_USE),
            Self::Pictures => (texts::PICTURES, texts::PICTURES_USE),
            Self::Sheet => (texts::SHEET, texts::SHEET_USE),
            Self::Svg => (texts::SVG, texts::SVG_USE),
            Self::Lottie => (texts::LOTTIE, texts::LOTTIE_USE),
            Self::Spine => (texts::SPINE, texts::SPINE_USE),
            Self::DragonBones => (texts::DRAGONBONES, texts::DRAGONBONES_USE),
        }
    }

    /// As the library calls it; none for what is no picture.
    fn animation(self) -> Option<&'static str> {
        match self {
            Self::Glb | Self::Folder | Self::Svg | Self::Lottie | Self::Spine | Self::DragonBones => None,
            Self::Gif => Some("gif"),
            Self::Apng => Some("apng"),
            Self::Webp => Some("webp"),
            Self::Mp4 => Some("mp4"),
            Self::Pictures => Some("png-dir"),
            Self::Sheet => Some("sprite-sheet"),
        }
    }

    /// As the library calls it for what moves.
    fn moving(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Svg => "svg",
            Self::Lottie => "lottie",
            Self::Spine => "spine",
            Self::DragonBones => "dragonbones",
            other => other.animation().unwrap_or_default(),
        }
    }

    fn ending(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Folder | Self::Pictures | Self::Spine | Self::DragonBones => "",
            Self::Svg => "svg",
            Self::Lottie => "json",
            Self::Gif => "gif",
            Self::Apng | Self::Sheet => "png",
            Self::Webp => "webp",
            Self::Mp4 => "mp4",
        }
    }

    pub(crate) fn is_folder(self) -> bool {
        self.ending().is_empty()
    }
}

/// From where pictures are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum From {
    /// As the clip was.
    #[default]
    Filmed,
    /// As the studio shows it.
    Shown,
    /// Once around while it plays.
    Around,
}

/// What is remembered of the last export.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct ExportSettings {
    /// Of a creature.
    pub(crate) format: Format,
    pub(crate) character: Format,
    pub(crate) drawing: Format,
    /// Of pictures of what was drawn, in percent of it; 0 for its own.
    pub(crate) percent: u32,
    /// Where the last one went.
    pub(crate) folder: Option<PathBuf>,
    /// Of pictures; 0 for the clip's.
    pub(crate) height: u32,
    /// Behind the creature; none for nothing.
    pub(crate) background: Option<[u8; 3]>,
    pub(crate) from: From,
}

impl Default for ExportSettings {
    fn default() -> Self {
        Self {
            format: Format::Glb,
            character: Format::Gif,
            drawing: Format::Svg,
            percent: 0,
            folder: None,
            height: 0,
            background: None,
            from: From::Filmed,
        }
    }
}

/// What is exported.
pub(crate) enum Exported<'a> {
    Creature(ShownCreature<'a>),
    Moving(&'a Moving, Played),
}

/// A creature, and how the studio shows it.
pub(crate) struct ShownCreature<'a> {
    pub(crate) creature: &'a Arc<Creature>,
    pub(crate) clip: &'a ClipInfo,
    pub(crate) played: Played,
    /// Style and camera of the 3D view.
    pub(crate) style: Style,
    pub(crate) camera: Camera,
}

impl Exported<'_> {
    fn door(&self) -> Door {
        match self {
            Self::Creature(_) => Door::Creature,
            Self::Moving(Moving::Character(_), ..) => Door::Character,
            Self::Moving(Moving::Drawing(_), ..) => Door::Drawing,
        }
    }
}

impl ExportSettings {
    /// The format for what is made behind a door.
    pub(crate) fn format(&self, door: Door) -> Format {
        match door {
            Door::Creature => self.format,
            Door::Character => self.character,
            Door::Drawing => self.drawing,
        }
    }

    fn set_format(&mut self, door: Door, format: Format) {
        match door {
            Door::Creature => self.format = format,
            Door::Character => self.character = format,
            Door::Drawing => self.drawing = format,
        }
    }

    /// Pixels a pixel of what was drawn.
    fn scale(&self) -> f32 {
        if self.percent == 0 { 1.0 } else { self.percent as f32 / 100.0 }
    }

    fn behind(&self) -> [u8; 4] {
        let [r, g, b] = self.background.unwrap_or_default();
        [r, g, b, if self.background.is_some() { 255 } else { 0 }]
    }

    fn size(&self, clip: &ClipInfo) -> (u32, u32) {
        if self.height == 0 {
            return (clip.width, clip.height);
        }
        let width = f64::from(self.height) * f64::from(clip.width) / f64::from(clip.height.max(1));
        // Films have even sides.
        (((width / 2.0).round() as u32 * 2).max(2), self.height)
    }

    fn pictures(&self, exported: &ShownCreature<'_>, size: (u32, u32)) -> RenderOptions {
        let camera = match (self.from, exported.camera) {
            (From::Filmed, _) => Camera::Clip,
            (From::Around, Camera::Placed { yaw, pitch, fov, .. }) => Camera::Fitted { yaw, pitch, fov },
            (From::Shown | From::Around, camera) => camera,
        };
        RenderOptions { size, style: exported.style, background: self.behind(), camera, ..RenderOptions::default() }
    }

    /// Starts writing; the purpose says where to.
    fn start(&self, context: &Context, exported: &Exported<'_>, path: &Path) -> Result<(Job, Purpose), Error> {
        let at = path.to_string_lossy();
        let exported = match exported {
            Exported::Creature(creature) => creature,
            Exported::Moving(moving, played) => {
                let moving = moving.retimed(played.timing)?;
                let (format, background, scale) = (self.format(exported.door()).moving(), self.behind(), self.scale());
                let job = match moving {
                    Moving::Drawing(take) => {
                        let options = SketchFileOptions { path: &at, format, name: "", crop: false, scale, background };
                        context.start_sketch_file(&take, &options)?
                    }
                    Moving::Character(take) => {
                        let options = TakeFileOptions { path: &at, format, name: "", crop: false, scale, background };
                        context.start_take_file(&take, &options)?
                    }
                };
                return Ok((job, Purpose::Export { path: path.to_owned(), pictures: false }));
            }
        };
        // The folder is what the frames of the clip gave.
        let timing = exported.played.timing.options().filter(|_| self.format != Format::Folder);
        let creature = match timing {
            Some(how) => &Arc::new(exported.creature.retimed(&how)?),
            None => exported.creature,
        };
        let Some(format) = self.format.animation() else {
            let what = if self.format == Format::Glb { CreatureFile::Glb } else { CreatureFile::Folder };
            let job = context.start_export(creature, what, &at, false, 0.0)?;
            return Ok((job, Purpose::Export { path: path.to_owned(), pictures: false }));
        };
        let pictures = self.pictures(exported, self.size(exported.clip));
        let turns = if self.from == From::Around { 1.0 } else { 0.0 };
        let file = RenderFileOptions { path: &at, format, turns, ..RenderFileOptions::default() };
        let job = context.start_render(creature, &pictures, &file)?;
        Ok((job, Purpose::Export { path: path.to_owned(), pictures: true }))
    }
}

/// Starts an export, and remembers where it goes. What was typed may be a name alone, which is one in the person's folder.
pub(crate) fn start(exported: &Exported<'_>, path: &Path, around: &mut Around) -> Option<Running> {
    let path = around.places.home.join(path);
    let started = around.preferences.export.start(&around.context, exported, &path);
    let (job, purpose) = around.notices.check(started)?;
    around.preferences.export.folder = path.parent().map(Path::to_owned);
    Some(Running::new(job, purpose))
}

/// The file that an export of `title` is written to when nothing else is said.
pub(crate) fn path_for(settings: &ExportSettings, door: Door, home: &Path, title: &str) -> PathBuf {
    let format = settings.format(door);
    let clean: String = title.chars().map(|c| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '-' }).collect();
    let name = match format {
        Format::Folder => texts::folder_name(&clean),
        Format::Pictures => texts::pictures_name(&clean),
        Format::Sheet => texts::sheet_name(&clean),
        Format::Spine | Format::DragonBones => texts::bones_name(&clean, format == Format::Spine),
        _ => clean,
    };
    let folder = settings.folder.as_deref().filter(|f| f.is_dir()).unwrap_or(home);
    folder.join(name).with_added_ending(format.ending())
}

trait AddedEnding {
    fn with_added_ending(self, ending: &str) -> PathBuf;
}

impl AddedEnding for PathBuf {
    /// A title may have dots of its own.
    fn with_added_ending(self, ending: &str) -> PathBuf {
        if ending.is_empty() {
            return self;
        }
        let mut name = self.into_os_string();
        name.push(".");
        name.push(ending);
        name.into()
    }
}

/// What a person asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    Close,
    /// To be asked where to.
    Browse,
    Export(PathBuf),
}

/// A drawn picture of the preview.
type Picture = Result<ColorImage, String>;

/// What a preview shows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Previewed {
    Creature(RenderOptions),
    /// A frame of what moves, at that scale.
    Moving(u64, f32),
}

pub(crate) struct ExportDialog {
    path: String,
    exists: bool,
    asked: Option<Previewed>,
    drawing: Option<Background<Picture>>,
    preview: Option<TextureHandle>,
    failed: Option<String>,
}

impl ExportDialog {
    pub(crate) fn new(settings: &ExportSettings, door: Door, home: &Path, title: &str) -> Self {
        let path = path_for(settings, door, home, title).to_string_lossy().into_owned();
        let exists = Path::new(&path).exists();
        Self { path, exists, asked: None, drawing: None, preview: None, failed: None }
    }

    /// Where it goes was chosen.
    pub(crate) fn set_path(&mut self, path: &Path) {
        self.path = path.to_string_lossy().into_owned();
        self.exists = path.exists();
    }

    /// The question for another place, a folder's where `folders`.
    pub(crate) fn browse(&self, folders: bool, home: &Path) -> Ask {
        let path = Path::new(&self.path);
        let folder = path.parent().filter(|p| p.is_dir()).unwrap_or(home).to_owned();
        if folders {
            return Ask::ExportFolder { folder };
        }
        Ask::ExportFile { folder, name: path.file_name().unwrap_or_default().to_string_lossy().into_owned() }
    }

    pub(crate) fn show(
        &mut self,
        ctx: &Ui,
        settings: &mut ExportSettings,
        exported: &Exported<'_>,
        home: &Path,
        title: &str,
    ) -> Option<Asked> {
        let mut asked = None;
        let before = settings.clone();
        let modal = Modal::new(Id::unique("export")).frame(theme::dialog(ctx)).show(ctx, |ui| {
            ui.set_width(FORMATS + 24.0 + PREVIEW.0 as f32);
            let door = exported.door();
            ui.heading(texts::export_title(door));
            ui.add_space(theme::GAP);
            ui.horizontal_top(|ui| {
                ui.vertical(|ui| {
                    ui.set_width(FORMATS);
                    formats(ui, settings, door);
                });
                ui.add_space(24.0 - 2.0 * theme::GAP);
                ui.vertical(|ui| {
                    ui.set_width(PREVIEW.0 as f32);
                    self.preview(ui, settings, exported);
                    ui.add_space(theme::GAP);
                    let pictured = settings.format(door).animation().is_some();
                    match exported {
                        Exported::Creature(shown) if pictured => pictures(ui, settings, shown),
                        Exported::Creature(shown) => model(ui, settings, shown),
                        Exported::Moving(moving, played) if pictured => drawn(ui, settings, moving, *played, door),
                        Exported::Moving(_, played) => about(ui, *played, Format::Svg),
                    }
                });
            });
            ui.add_space(theme::GAP);
            ui.separator();
            self.destination(ui, settings.format(door), &mut asked);
        });
        let door = exported.door();
        if settings.format(door) != before.format(door) {
            self.set_path(&path_for(settings, door, home, title));
        }
        if modal.should_close() {
            asked = asked.or(Some(Asked::Close));
        }
        asked
    }

    fn destination(&mut self, ui: &mut eframe::egui::Ui, format: Format, asked: &mut Option<Asked>) {
        ui.horizontal(|ui| {
            let label = ui.label(if format.is_folder() { texts::TO_FOLDER } else { texts::TO_FILE });
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button(texts::BROWSE).clicked() {
                    *asked = Some(Asked::Browse);
                }
                let edit = ui.add(TextEdit::singleline(&mut self.path).desired_width(ui.available_width()));
                if edit.labelled_by(label.id).changed() {
                    self.exists = Path::new(&self.path).exists();
                }
            });
        });
        ui.horizontal(|ui| {
            if self.exists {
                let color = Palette::of(ui).accent;
                ui.add(Label::new(RichText::new(texts::REPLACES).color(color)));
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let sure = !self.path.trim().is_empty();
                let export = ui.add_enabled_ui(sure, |ui| widgets::primary_button(ui, texts::EXPORT_NOW)).inner;
                if export.clicked() {
                    *asked = Some(Asked::Export(PathBuf::from(self.path.trim())));
                }
                if ui.add(Button::new(texts::CANCEL).min_size(vec2(0.0, 30.0))).clicked() {
                    *asked = Some(Asked::Close);
                }
            });
        });
    }

    /// The frame that is shown, as it will be written.
    fn preview(&mut self, ui: &mut eframe::egui::Ui, settings: &ExportSettings, exported: &Exported<'_>) {
        let palette = Palette::of(ui);
        let full = match exported {
            Exported::Creature(shown) => settings.size(shown.clip),
            Exported::Moving(moving, ..) => moving.measure(1.0).map_or((1, 1), |m| m.0),
        };
        let most = PREVIEW;
        let share = (most.0 as f32 / full.0 as f32).min(most.1 as f32 / full.1 as f32);
        let small = |v: u32| ((v as f32 * share).round() as u32).max(1);
        let size = (small(full.0), small(full.1));
        let options = match exported {
            Exported::Creature(shown) => {
                Previewed::Creature(RenderOptions { frame: shown.played.frame, ..settings.pictures(shown, size) })
            }
            Exported::Moving(_, played) => Previewed::Moving(played.frame, share),
        };

        let (rect, response) = ui.allocate_exact_size(vec2(most.0 as f32, most.1 as f32), Sense::hover());
        response
            .widget_info(|| eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Image, true, texts::PREVIEW_NAME));
        ui.painter().rect_filled(rect, 6.0, palette.canvas);
        let at = Rect::from_center_size(rect.center(), vec2(size.0 as f32, size.1 as f32));
        match (settings.background, settings.format(exported.door()).animation()) {
            (Some([r, g, b]), Some(_)) => drop(ui.painter().rect_filled(at, 0.0, Color32::from_rgb(r, g, b))),
            _ if exported.door() == Door::Creature => looking::checkers(ui.painter(), at, ui.visuals().dark_mode),
            // Ink is seen on paper.
            _ => drop(ui.painter().rect_filled(at, 0.0, Color32::WHITE)),
        }
        if let Some(texture) = &self.preview {
            ui.painter().image(texture.id(), at, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        }
        if let Some(failed) = &self.failed {
            ui.label(RichText::new(failed).color(palette.bad));
        }

        if let Some(background) = &self.drawing {
            let answer = background.answer().unwrap_or_else(|()| Some(Err(texts::DRAWING_BROKE.into())));
            if let Some(answer) = answer {
                match answer {
                    Ok(picture) => {
                        let texture = ui.ctx().load_texture("preview", picture, TextureOptions::LINEAR);
                        (self.preview, self.failed) = (Some(texture), None);
                    }
                    Err(message) => self.failed = Some(message),
                }
                self.drawing = None;
            }
        }
        if self.drawing.is_none() && self.asked != Some(options) {
            self.asked = Some(options);
            self.drawing = Some(match (exported, options) {
                (Exported::Moving(moving, ..), Previewed::Moving(frame, scale)) => {
                    let moving = (*moving).clone();
                    Background::start(ui.ctx(), move || moving.draw(frame, scale))
                }
                (Exported::Creature(shown), Previewed::Creature(options)) => {
                    let creature = shown.creature.clone();
                    Background::start(ui.ctx(), move || view3d::picture(&creature, &options))
                }
                _ => return,
            });
        }
    }
}

fn formats(ui: &mut eframe::egui::Ui, settings: &mut ExportSettings, door: Door) {
    ScrollArea::vertical().max_height(380.0).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 3.0;
        for format in Format::all(door).iter().copied() {
            let (name, of_use) = format.name_and_use();
            let weak = Palette::of(ui).weak;
            let mut job = eframe::egui::text::LayoutJob::default();
            let style = ui.style().clone();
            let align = Align::Center;
            RichText::new(name).strong().append_to(&mut job, &style, eframe::egui::FontSelection::Default, align);
            RichText::new(format!("\n{of_use}")).size(12.0).color(weak).append_to(
                &mut job,
                &style,
                eframe::egui::FontSelection::Default,
                align,
            );
            let button =
                Button::selectable(settings.format(door) == format, job).min_size(vec2(ui.available_width(), 0.0));
            let button = ui.add(button.right_text(""));
            if button.accessible_name(name).clicked() {
                settings.set_format(door, format);
            }
        }
    });
}

/// What a file of the model holds.
fn model(ui: &mut eframe::egui::Ui, settings: &ExportSettings, shown: &ShownCreature<'_>) {
    let Ok(info) = shown.creature.info() else { return };
    // The folder is what the frames of the clip gave.
    let frames = if settings.format == Format::Folder { info.frames } else { shown.played.frames };
    widgets::remark(ui, texts::model_about(info.vertices, info.triangles, info.bones, frames));
}

/// How long what is written takes.
fn about(ui: &mut eframe::egui::Ui, played: Played, format: Format) {
    let (film, gif) = (format == Format::Mp4, format == Format::Gif);
    widgets::remark(ui, texts::animation_about(played.frames, played.fps, film, gif));
}

/// Points across of lists.
const WIDE: f32 = 190.0;

/// How what was drawn is written.
fn drawn(ui: &mut eframe::egui::Ui, settings: &mut ExportSettings, moving: &Moving, played: Played, door: Door) {
    let format = settings.format(door);
    Grid::new("drawn").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label(texts::SIZE);
        let named = |percent: u32| {
            let scale = ExportSettings { percent, ..settings.clone() }.scale();
            let ((width, height), _) = moving.measure(scale).unwrap_or_default();
            texts::drawn_size_name(width, height, percent)
        };
        let options = PERCENTS.map(|percent| (percent, named(percent)));
        let list = ComboBox::from_id_salt("percent").width(WIDE).selected_text(named(settings.percent));
        let list = list.show_ui(ui, |ui| {
            for (percent, name) in options {
                ui.selectable_value(&mut settings.percent, percent, name);
            }
        });
        list.response.labelled_by(label.id);
        ui.end_row();

        ui.label(texts::BEHIND);
        ui.horizontal(|ui| background(ui, settings, format == Format::Mp4));
        ui.end_row();
    });
    about(ui, played, format);
}

/// How pictures are.
fn pictures(ui: &mut eframe::egui::Ui, settings: &mut ExportSettings, shown: &ShownCreature<'_>) {
    let clip = shown.clip;
    let film = settings.format == Format::Mp4;
    Grid::new("pictures").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label(texts::FROM);
        let names =
            [(From::Filmed, texts::FROM_FILMED), (From::Shown, texts::FROM_SHOWN), (From::Around, texts::FROM_AROUND)];
        let name = names.iter().find(|(from, _)| *from == settings.from).map_or("", |(_, name)| name);
        let list = ComboBox::from_id_salt("from").width(WIDE).selected_text(name);
        let list = list.show_ui(ui, |ui| {
            for (from, name) in names {
                ui.selectable_value(&mut settings.from, from, name);
            }
        });
        list.response.labelled_by(label.id);
        ui.end_row();

        let label = ui.label(texts::SIZE);
        let named = |height: u32| {
            let (w, h) = ExportSettings { height, ..settings.clone() }.size(clip);
            texts::size_name(w, h, height == 0)
        };
        let list = ComboBox::from_id_salt("size").width(WIDE).selected_text(named(settings.height));
        let options: Vec<(u32, String)> = HEIGHTS.iter().map(|h| (*h, named(*h))).collect();
        let list = list.show_ui(ui, |ui| {
            for (height, name) in options {
                ui.selectable_value(&mut settings.height, height, name);
            }
        });
        list.response.labelled_by(label.id);
        ui.end_row();

        ui.label(texts::BEHIND);
        ui.horizontal(|ui| background(ui, settings, film));
        ui.end_row();
    });
    about(ui, shown.played, settings.format);
}

fn background(ui: &mut eframe::egui::Ui, settings: &mut ExportSettings, opaque: bool) {
    if opaque && settings.background.is_none() {
        settings.background = Some([255; 3]);
    }
    ui.add_enabled_ui(!opaque, |ui| {
        if ui.radio(settings.background.is_none(), texts::NOTHING).clicked() {
            settings.background = None;
        }
    });
    if ui.radio(settings.background.is_some(), texts::COLOR).clicked() && settings.background.is_none() {
        settings.background = Some([255; 3]);
    }
    if let Some(color) = &mut settings.background {
        ui.color_edit_button_srgb(color).accessible_name(texts::COLOR_NAME);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_safe_and_end_as_their_format_does() {
        let home = tempfile::tempdir().unwrap();
        let gone = Some(home.path().join("gone"));
        let settings = ExportSettings { format: Format::Gif, folder: gone, ..ExportSettings::default() };
        assert_eq!(path_for(&settings, Door::Creature, home.path(), "a/b: v1.2"), home.path().join("a-b- v1-2.gif"));
        let folder = ExportSettings { format: Format::Folder, ..settings.clone() };
        assert!(path_for(&folder, Door::Creature, home.path(), "fox").extension().is_none());
        let doors = [Door::Creature, Door::Character, Door::Drawing];
        for (door, format) in doors.into_iter().flat_map(|d| Format::all(d).iter().map(move |f| (d, *f))) {
            let mut settings = settings.clone();
            settings.set_format(door, format);
            let path = path_for(&settings, door, home.path(), "fox");
            assert_eq!(path.extension().map_or("", |e| e.to_str().unwrap()), format.ending());
        }
    }

    #[test]
    fn pictures_keep_the_clips_shape_with_even_sides() {
        let clip =
            ClipInfo { width: 854, height: 480, frames: 10, fps: 24.0, source: "mp4".into(), warnings: Vec::new() };
        let at = |height| ExportSettings { height, ..ExportSettings::default() }.size(&clip);
        assert_eq!([at(0), at(360), at(1080)], [(854, 480), (640, 360), (1922, 1080)]);
    }
}
