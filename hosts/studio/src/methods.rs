//! By what a creature is made: the tracker and the segmenter of a session, with what can be chosen about them.

use eframe::egui::{Align, ComboBox, Context, Id, Layout, Modal, RichText, ScrollArea, Ui};
use marey_binding::PluginKind;

use crate::document::{Document, Step};
use crate::plugins::{Ask, Plugins};
use crate::theme::{self, Palette};
use crate::{parameters, texts, widgets};

/// What a person asked for.
pub(crate) enum Asked {
    /// To use the plugin with this id, or what is built in where it is empty.
    Use(Step, String),
    Plugin(Ask),
    /// To see all plugins.
    Plugins,
}

/// Shows them; false once it is to be closed.
pub(crate) fn show(ctx: &Context, document: &Document, plugins: &Plugins) -> (Option<Asked>, bool) {
    let mut asked = None;
    let modal = Modal::new(Id::unique("methods")).frame(theme::dialog(ctx)).show(ctx, |ui| {
        ui.set_width(520.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading(texts::METHODS);
        ui.add_space(theme::GAP);
        ScrollArea::vertical().max_height(ctx.content_rect().height() - 220.0).show(ui, |ui| {
            let steps = [
                (Step::Track, PluginKind::Tracker, texts::FOLLOWED_BY),
                (Step::Segment, PluginKind::Segmenter, texts::CUT_BY),
            ];
            for (step, kind, label) in steps {
                asked = one(ui, document.method(step), step, kind, label, plugins).or(asked.take());
                ui.add_space(theme::GAP);
            }
        });
        ui.horizontal(|ui| {
            if ui.link(texts::ALL_PLUGINS).clicked() {
                asked = Some(Asked::Plugins);
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                widgets::primary_button(ui, texts::CLOSE).clicked()
            })
            .inner
        })
        .inner
    });
    (asked, !(modal.inner || modal.should_close()))
}

fn one(ui: &mut Ui, now: &str, step: Step, kind: PluginKind, label: &str, plugins: &Plugins) -> Option<Asked> {
    let mut asked = None;
    let chosen = plugins.by_id(now);
    ui.horizontal(|ui| {
        let label = ui.label(RichText::new(label).strong());
        let text = match chosen {
            None if now.is_empty() => texts::BUILT_IN,
            None => now,
            Some(loaded) => &loaded.plugin.name,
        };
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let list = ComboBox::from_id_salt(label.id).width(240.0).selected_text(text).show_ui(ui, |ui| {
                let built_in = ("", texts::BUILT_IN, texts::BUILT_IN_ABOUT);
                let all = plugins.of_kind(kind).map(|l| &l.plugin).map(|p| (&*p.id, &*p.name, &*p.about));
                for (id, name, about) in std::iter::once(built_in).chain(all) {
                    if ui.selectable_label(now == id, name).on_hover_text(about).clicked() && now != id {
                        asked = Some(Asked::Use(step, id.to_owned()));
                    }
                }
            });
            list.response.labelled_by(label.id);
        });
    });
    match chosen {
        None if now.is_empty() => {}
        Some(loaded) if loaded.plugin.enabled => {
            widgets::remark(ui, &*loaded.plugin.about);
            if let Some((name, value)) = parameters::show(ui, now, &loaded.parameters) {
                asked = Some(Asked::Plugin(Ask::Set(now.to_owned(), name, value)));
            }
        }
        _ => {
            ui.label(RichText::new(texts::PLUGIN_GONE).color(Palette::of(ui).bad));
        }
    }
    asked
}
