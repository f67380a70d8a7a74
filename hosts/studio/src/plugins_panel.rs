//! The plugins in a list: what is loaded, what is not and why.

use eframe::egui::{
    Align, Checkbox, CollapsingHeader, Context, Frame, Id, Label, Layout, Modal, RichText, ScrollArea, Stroke, Ui,
};
use marey_binding::PluginKind;

use crate::icons::Icon;
use crate::plugins::{Ask, Failed, Loaded, Plugins};
use crate::theme::{self, Palette};
use crate::{parameters, texts, widgets};

/// Shows them; gives what a person asked for, and false once it is to be closed.
pub(crate) fn show(ctx: &Context, plugins: &Plugins, folder: &str) -> (Option<Ask>, bool) {
    let mut asked = None;
    let modal = Modal::new(Id::unique("plugins")).frame(theme::dialog(ctx)).show(ctx, |ui| {
        ui.set_width(640.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading(texts::PLUGINS);
        ui.add_space(theme::GAP);
        widgets::remark(ui, texts::plugins_about(folder));
        ui.add_space(theme::GAP);
        ScrollArea::vertical().max_height(ctx.content_rect().height() - 260.0).show(ui, |ui| {
            for failed in &plugins.found.failed {
                refused(ui, failed, &mut asked);
            }
            for loaded in &plugins.found.loaded {
                ui.push_id(&loaded.plugin.id, |ui| card(ui, loaded, &mut asked));
            }
            if plugins.found.failed.is_empty() && plugins.found.loaded.is_empty() {
                widgets::remark(ui, texts::NO_PLUGINS);
            }
        });
        ui.add_space(theme::GAP);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let close = widgets::primary_button(ui, texts::CLOSE).clicked();
            if ui.button(texts::LOOK_AGAIN).clicked() {
                asked = Some(Ask::Look);
            }
            close
        })
        .inner
    });
    (asked, !(modal.inner || modal.should_close()))
}

fn card(ui: &mut Ui, loaded: &Loaded, asked: &mut Option<Ask>) {
    let palette = Palette::of(ui);
    let plugin = &loaded.plugin;
    framed(ui, palette.outline, |ui| {
        ui.horizontal(|ui| {
            ui.label(RichText::new(&plugin.name).size(16.0).strong());
            ui.label(RichText::new(texts::plugin_by(&plugin.version, &plugin.vendor)).color(palette.weak));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let mut on = plugin.enabled;
                let check = ui.add(Checkbox::new(&mut on, texts::PLUGIN_ON));
                if check.accessible_name(texts::with_name(texts::PLUGIN_ON, &plugin.name)).changed() {
                    *asked = Some(Ask::Enable(plugin.id.clone(), on));
                }
                let kind = match plugin.kind {
                    PluginKind::Tracker => texts::KIND_TRACKER,
                    PluginKind::Segmenter => texts::KIND_SEGMENTER,
                    PluginKind::Deformer => texts::KIND_DEFORMER,
                };
                ui.label(RichText::new(kind).color(palette.accent));
            });
        });
        if !plugin.about.is_empty() {
            ui.add(Label::new(&plugin.about).wrap());
        }
        widgets::remark(ui, texts::plugin_file(&plugin.file, plugin.generation));
        if loaded.parameters.iter().any(|(p, _)| !p.hidden) {
            let name = texts::with_name(texts::SETTINGS, &plugin.name);
            CollapsingHeader::new(texts::SETTINGS)
                .show(ui, |ui| {
                    if let Some((name, value)) = parameters::show(ui, &plugin.id, &loaded.parameters) {
                        *asked = Some(Ask::Set(plugin.id.clone(), name, value));
                    }
                })
                .header_response
                .accessible_name(name);
        }
    });
}

fn refused(ui: &mut Ui, failed: &Failed, asked: &mut Option<Ask>) {
    let palette = Palette::of(ui);
    framed(ui, palette.bad, |ui| {
        ui.horizontal(|ui| {
            Icon::Warning.show(ui, 18.0, palette.bad);
            ui.label(RichText::new(texts::NOT_LOADED).strong());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let file = std::path::Path::new(&failed.file).file_name().unwrap_or_default().to_string_lossy();
                let retry = ui.button(texts::TRY_AGAIN);
                if retry.accessible_name(texts::with_name(texts::TRY_AGAIN, &file)).clicked() {
                    *asked = Some(Ask::Retry(failed.file.clone()));
                }
            });
        });
        ui.add(Label::new(&failed.reason).wrap());
    });
}

fn framed(ui: &mut Ui, outline: eframe::egui::Color32, show: impl FnOnce(&mut Ui)) {
    let fill = Palette::of(ui).raised;
    let frame = Frame::new().fill(fill).stroke(Stroke::new(1.0, outline)).corner_radius(8).inner_margin(theme::PAD);
    frame.show(ui, |ui| {
        ui.set_width(ui.available_width());
        show(ui);
    });
}
