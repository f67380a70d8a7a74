//! One dialog for everything that can be written, with what it will look like. It remembers; one key does it again.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::{
    Align, Button, Color32, ColorImage, ComboBox, Context as Ui, Grid, Id, Label, Layout, Modal, Rect, RichText,
    ScrollArea, Sense, TextEdit, TextureHandle, TextureOptions, pos2, vec2,
};
use marey_binding::{
    Camera, ClipInfo, Context, Creature, CreatureFile, Error, Job, RenderFileOptions, RenderOptions, Style,
};
use serde::{Deserialize, Serialize};

use crate::background::Background;
use crate::running::Purpose;
use crate::theme::{self, Palette};
use crate::{texts, view3d, widgets};

/// Pixels of the preview, which lies on as many points at most.
const PREVIEW: (u32, u32) = (300, 225);
/// Points across of the list of formats.
const FORMATS: f32 = 340.0;
/// What can be chosen for the height of pictures; 0 for the clip's.
const HEIGHTS: [u32; 5] = [0, 360, 480, 720, 1080];

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
}

impl Format {
    const ALL: [Self; 8] =
        [Self::Glb, Self::Folder, Self::Gif, Self::Apng, Self::Webp, Self::Mp4, Self::Pictures, Self::Sheet];

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
        }
    }

    /// As the library calls it; none for what is no picture.
    fn animation(self) -> Option<&'static str> {
        match self {
            Self::Glb | Self::Folder => None,
            Self::Gif => Some("gif"),
            Self::Apng => Some("apng"),
            Self::Webp => Some("webp"),
            Self::Mp4 => Some("mp4"),
            Self::Pictures => Some("png-dir"),
            Self::Sheet => Some("sprite-sheet"),
        }
    }

    fn ending(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Folder | Self::Pictures => "",
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct ExportSettings {
    pub(crate) format: Format,
    /// Where the last one went.
    pub(crate) folder: Option<PathBuf>,
    /// Of pictures; 0 for the clip's.
    pub(crate) height: u32,
    /// Behind the creature; none for nothing.
    pub(crate) background: Option<[u8; 3]>,
    pub(crate) from: From,
}

/// What is exported, and how the studio shows it.
pub(crate) struct Exported<'a> {
    pub(crate) creature: &'a Arc<Creature>,
    pub(crate) clip: &'a ClipInfo,
    pub(crate) frame: u64,
    /// Style and camera of the 3D view.
    pub(crate) style: Style,
    pub(crate) camera: Camera,
}

impl ExportSettings {
    fn size(&self, clip: &ClipInfo) -> (u32, u32) {
        if self.height == 0 {
            return (clip.width, clip.height);
        }
        let width = f64::from(self.height) * f64::from(clip.width) / f64::from(clip.height.max(1));
        // Films have even sides.
        (((width / 2.0).round() as u32 * 2).max(2), self.height)
    }

    fn pictures(&self, exported: &Exported<'_>, size: (u32, u32)) -> RenderOptions {
        let [r, g, b] = self.background.unwrap_or_default();
        let camera = match (self.from, exported.camera) {
            (From::Filmed, _) => Camera::Clip,
            (From::Around, Camera::Placed { yaw, pitch, fov, .. }) => Camera::Fitted { yaw, pitch, fov },
            (From::Shown | From::Around, camera) => camera,
        };
        RenderOptions {
            size,
            style: exported.style,
            background: [r, g, b, if self.background.is_some() { 255 } else { 0 }],
            camera,
            ..RenderOptions::default()
        }
    }

    /// Starts writing; the purpose says where to.
    pub(crate) fn start(
        &self,
        context: &Context,
        exported: &Exported<'_>,
        path: &Path,
    ) -> Result<(Job, Purpose), Error> {
        let at = path.to_string_lossy();
        let Some(format) = self.format.animation() else {
            let what = if self.format == Format::Glb { CreatureFile::Glb } else { CreatureFile::Folder };
            let job = context.start_export(exported.creature, what, &at, false, 0.0)?;
            return Ok((job, Purpose::Export { path: path.to_owned(), pictures: false }));
        };
        let pictures = self.pictures(exported, self.size(exported.clip));
        let turns = if self.from == From::Around { 1.0 } else { 0.0 };
        let file = RenderFileOptions { path: &at, format, turns, ..RenderFileOptions::default() };
        let job = context.start_render(exported.creature, &pictures, &file)?;
        Ok((job, Purpose::Export { path: path.to_owned(), pictures: true }))
    }
}

/// The file that an export of `title` is written to when nothing else is said.
pub(crate) fn path_for(settings: &ExportSettings, home: &Path, title: &str) -> PathBuf {
    let clean: String = title.chars().map(|c| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '-' }).collect();
    let name = match settings.format {
        Format::Folder => texts::folder_name(&clean),
        Format::Pictures => texts::pictures_name(&clean),
        Format::Sheet => texts::sheet_name(&clean),
        _ => clean,
    };
    let folder = settings.folder.as_deref().filter(|f| f.is_dir()).unwrap_or(home);
    folder.join(name).with_added_ending(settings.format.ending())
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

pub(crate) struct ExportDialog {
    path: String,
    exists: bool,
    asked: Option<RenderOptions>,
    drawing: Option<(RenderOptions, Background<Picture>)>,
    preview: Option<(TextureHandle, (u32, u32))>,
    failed: Option<String>,
}

impl ExportDialog {
    pub(crate) fn new(settings: &ExportSettings, home: &Path, title: &str) -> Self {
        let path = path_for(settings, home, title).to_string_lossy().into_owned();
        let exists = Path::new(&path).exists();
        Self { path, exists, asked: None, drawing: None, preview: None, failed: None }
    }

    /// Where it goes was chosen.
    pub(crate) fn set_path(&mut self, path: &Path) {
        self.path = path.to_string_lossy().into_owned();
        self.exists = path.exists();
    }

    pub(crate) fn path(&self) -> &Path {
        Path::new(&self.path)
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
            ui.heading(texts::EXPORT_TITLE);
            ui.add_space(theme::GAP);
            ui.horizontal_top(|ui| {
                ui.vertical(|ui| {
                    ui.set_width(FORMATS);
                    formats(ui, settings);
                });
                ui.add_space(24.0 - 2.0 * theme::GAP);
                ui.vertical(|ui| {
                    ui.set_width(PREVIEW.0 as f32);
                    self.preview(ui, settings, exported);
                    ui.add_space(theme::GAP);
                    if settings.format.animation().is_some() {
                        pictures(ui, settings, exported.clip);
                    } else {
                        model(ui, exported.creature);
                    }
                });
            });
            ui.add_space(theme::GAP);
            ui.separator();
            self.destination(ui, settings, &mut asked);
        });
        if settings.format != before.format {
            self.set_path(&path_for(settings, home, title));
        }
        if modal.should_close() {
            asked = asked.or(Some(Asked::Close));
        }
        asked
    }

    fn destination(&mut self, ui: &mut eframe::egui::Ui, settings: &ExportSettings, asked: &mut Option<Asked>) {
        ui.horizontal(|ui| {
            let label = ui.label(if settings.format.is_folder() { texts::TO_FOLDER } else { texts::TO_FILE });
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
        let (full, most) = (settings.size(exported.clip), PREVIEW);
        let share = (most.0 as f32 / full.0 as f32).min(most.1 as f32 / full.1 as f32);
        let small = |v: u32| ((v as f32 * share).round() as u32).max(1);
        let size = (small(full.0), small(full.1));
        let options = RenderOptions { frame: exported.frame, ..settings.pictures(exported, size) };

        let (rect, response) = ui.allocate_exact_size(vec2(most.0 as f32, most.1 as f32), Sense::hover());
        response
            .widget_info(|| eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Image, true, texts::PREVIEW_NAME));
        ui.painter().rect_filled(rect, 6.0, palette.canvas);
        let at = Rect::from_center_size(rect.center(), vec2(size.0 as f32, size.1 as f32));
        if options.background[3] == 0 {
            checkers(ui, at);
        }
        if let Some((texture, drawn)) = &self.preview {
            let at = Rect::from_center_size(rect.center(), vec2(drawn.0 as f32, drawn.1 as f32));
            ui.painter().image(texture.id(), at, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        }
        if let Some(failed) = &self.failed {
            ui.label(RichText::new(failed).color(palette.bad));
        }

        if let Some((drawn, background)) = &self.drawing {
            let answer = background.answer().unwrap_or_else(|()| Some(Err(texts::DRAWING_BROKE.into())));
            if let Some(answer) = answer {
                match answer {
                    Ok(picture) => {
                        let texture = ui.ctx().load_texture("preview", picture, TextureOptions::LINEAR);
                        (self.preview, self.failed) = (Some((texture, drawn.size)), None);
                    }
                    Err(message) => self.failed = Some(message),
                }
                self.drawing = None;
            }
        }
        if self.drawing.is_none() && self.asked != Some(options) {
            let creature = exported.creature.clone();
            let draw = move || view3d::picture(&creature, &options);
            self.asked = Some(options);
            self.drawing = Some((options, Background::start(ui.ctx(), draw)));
        }
    }
}

fn formats(ui: &mut eframe::egui::Ui, settings: &mut ExportSettings) {
    ScrollArea::vertical().max_height(380.0).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 3.0;
        for format in Format::ALL {
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
            let button = Button::selectable(settings.format == format, job).min_size(vec2(ui.available_width(), 0.0));
            let button = ui.add(button.right_text(""));
            if button.accessible_name(name).clicked() {
                settings.format = format;
            }
        }
    });
}

/// What a file of the model holds.
fn model(ui: &mut eframe::egui::Ui, creature: &Creature) {
    if let Ok(info) = creature.info() {
        widgets::remark(ui, texts::model_about(info.vertices, info.triangles, info.bones, info.frames));
    }
}

/// How pictures are.
fn pictures(ui: &mut eframe::egui::Ui, settings: &mut ExportSettings, clip: &ClipInfo) {
    const WIDE: f32 = 190.0;
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
        ui.horizontal(|ui| background(ui, settings));
        ui.end_row();
    });
    let (film, gif) = (settings.format == Format::Mp4, settings.format == Format::Gif);
    widgets::remark(ui, texts::animation_about(clip.frames, clip.fps, film, gif));
}

fn background(ui: &mut eframe::egui::Ui, settings: &mut ExportSettings) {
    let opaque = settings.format == Format::Mp4;
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

/// What is see-through.
fn checkers(ui: &eframe::egui::Ui, at: Rect) {
    const SIDE: f32 = 10.0;
    let dark = ui.visuals().dark_mode;
    let shades = if dark { [44, 56] } else { [236, 250] };
    let painter = ui.painter().with_clip_rect(at);
    painter.rect_filled(at, 0.0, Color32::from_gray(shades[0]));
    let (columns, rows) = ((at.width() / SIDE).ceil() as i32, (at.height() / SIDE).ceil() as i32);
    for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).filter(|(x, y)| (x + y) % 2 == 1) {
        let corner = at.min + vec2(x as f32, y as f32) * SIDE;
        painter.rect_filled(Rect::from_min_size(corner, vec2(SIDE, SIDE)), 0.0, Color32::from_gray(shades[1]));
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
        assert_eq!(path_for(&settings, home.path(), "a/b: v1.2"), home.path().join("a-b- v1-2.gif"));
        let folder = ExportSettings { format: Format::Folder, ..settings.clone() };
        assert!(path_for(&folder, home.path(), "fox").extension().is_none());
        for format in Format::ALL {
            let path = path_for(&ExportSettings { format, ..settings.clone() }, home.path(), "fox");
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
