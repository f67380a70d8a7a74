//! Small widgets that more than one panel uses. Each has an accessible name.

use eframe::egui::{
    Button, Context, CornerRadius, Response, RichText, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2,
};

use crate::icons::Icon;
use crate::shortcuts::{self, Command};
use crate::theme::{Palette, RADIUS};

const ICON_BUTTON: f32 = 28.0;
const ICON: f32 = 16.0;

/// A square button with an icon. `text` is its name and its tooltip.
pub(crate) fn icon_button(ui: &mut Ui, icon: Icon, text: &str) -> Response {
    icon_toggle(ui, icon, text, false)
}

/// The same for a command, with its key in the tooltip.
pub(crate) fn command_button(ui: &mut Ui, icon: Icon, text: &str, command: Command) -> bool {
    let hint = shortcuts::hint(ui.ctx(), text, command);
    plain_icon(ui, icon, text, false).on_hover_text(hint).clicked()
}

/// A square button that is on or off.
pub(crate) fn icon_toggle(ui: &mut Ui, icon: Icon, text: &str, on: bool) -> Response {
    plain_icon(ui, icon, text, on).on_hover_text(text)
}

/// Without a tooltip.
pub(crate) fn plain_icon(ui: &mut Ui, icon: Icon, text: &str, on: bool) -> Response {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(ICON_BUTTON), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, ui.is_enabled(), on, text));
    let palette = Palette::of(ui);
    let visuals = ui.style().interact(&response);
    let enabled = ui.is_enabled();
    if on {
        ui.painter().rect_filled(rect, CornerRadius::same(RADIUS), ui.visuals().selection.bg_fill);
    } else if enabled && (response.hovered() || response.has_focus()) {
        ui.painter().rect_filled(rect, CornerRadius::same(RADIUS), visuals.bg_fill);
    }
    if response.has_focus() {
        let outline = Stroke::new(1.5, palette.accent);
        ui.painter().rect_stroke(rect, RADIUS, outline, eframe::egui::StrokeKind::Inside);
    }
    let color = match (enabled, on) {
        (false, _) => palette.weak.gamma_multiply(0.5),
        (true, true) => palette.accent,
        (true, false) => palette.text,
    };
    icon.paint(ui.painter(), rect.shrink((ICON_BUTTON - ICON) / 2.0), color);
    response
}

/// The button that leads on: one on a screen.
pub(crate) fn primary_button(ui: &mut Ui, text: &str) -> Response {
    let palette = Palette::of(ui);
    let button = Button::new(RichText::new(text).color(palette.on_accent).strong())
        .fill(palette.accent)
        .stroke(Stroke::NONE)
        .min_size(vec2(0.0, 30.0));
    ui.add(button)
}

/// A word that switches something on or off.
pub(crate) fn word_toggle(ui: &mut Ui, text: &str, on: bool, command: Command) -> bool {
    let hint = shortcuts::hint(ui.ctx(), text, command);
    ui.add(Button::selectable(on, text)).on_hover_text(hint).clicked()
}

/// A heading inside a panel.
pub(crate) fn section(ui: &mut Ui, text: &str) {
    let weak = Palette::of(ui).weak;
    ui.label(RichText::new(text).size(12.0).color(weak).strong());
}

/// Words beside something, less important than it.
pub(crate) fn remark(ui: &mut Ui, text: impl Into<String>) -> Response {
    let weak = Palette::of(ui).weak;
    ui.add(eframe::egui::Label::new(RichText::new(text).color(weak)).wrap())
}

/// Draws again before long, for what moves.
pub(crate) fn keep_moving(ctx: &Context) {
    // As often as a screen shows pictures; a window that is hidden is not drawn.
    ctx.request_repaint_after(std::time::Duration::from_millis(16));
}
