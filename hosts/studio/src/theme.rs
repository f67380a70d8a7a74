//! Colours, sizes and type, light and dark.

use eframe::egui::style::{Selection, WidgetVisuals, Widgets};
use eframe::egui::{
    Color32, Context, CornerRadius, FontFamily, FontId, Frame, Margin, Shadow, Stroke, TextStyle, Theme, Ui, Visuals,
    vec2,
};

use crate::preferences::Appearance;

/// Between things that belong together.
pub(crate) const GAP: f32 = 8.0;
/// Inside of panels and cards.
pub(crate) const PAD: i8 = 12;
pub(crate) const RADIUS: u8 = 6;

/// Colours beyond those of egui.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Palette {
    /// What to do next.
    pub(crate) accent: Color32,
    pub(crate) on_accent: Color32,
    /// Behind pictures.
    pub(crate) canvas: Color32,
    pub(crate) panel: Color32,
    /// Cards, buttons.
    pub(crate) raised: Color32,
    pub(crate) hovered: Color32,
    pub(crate) outline: Color32,
    pub(crate) text: Color32,
    pub(crate) weak: Color32,
    pub(crate) good: Color32,
    pub(crate) bad: Color32,
}

/// Contrast of text on panel, weak on panel: 13.6 and 6.6 to 1.
const DARK: Palette = Palette {
    accent: Color32::from_rgb(0xf2, 0xa6, 0x5a),
    on_accent: Color32::from_rgb(0x22, 0x18, 0x0d),
    canvas: Color32::from_rgb(0x11, 0x13, 0x16),
    panel: Color32::from_rgb(0x1b, 0x1e, 0x23),
    raised: Color32::from_rgb(0x28, 0x2c, 0x33),
    hovered: Color32::from_rgb(0x34, 0x39, 0x42),
    outline: Color32::from_rgb(0x3a, 0x40, 0x4a),
    text: Color32::from_rgb(0xe8, 0xea, 0xee),
    weak: Color32::from_rgb(0x9d, 0xa6, 0xb4),
    good: Color32::from_rgb(0x6f, 0xce, 0x8a),
    bad: Color32::from_rgb(0xff, 0x7b, 0x6b),
};

/// 14.2 and 5.6 to 1.
const LIGHT: Palette = Palette {
    accent: Color32::from_rgb(0xb3, 0x56, 0x12),
    on_accent: Color32::WHITE,
    canvas: Color32::from_rgb(0xdc, 0xd9, 0xd3),
    panel: Color32::from_rgb(0xf7, 0xf5, 0xf1),
    raised: Color32::from_rgb(0xff, 0xff, 0xff),
    hovered: Color32::from_rgb(0xec, 0xe8, 0xe1),
    outline: Color32::from_rgb(0xcf, 0xca, 0xc1),
    text: Color32::from_rgb(0x22, 0x25, 0x2a),
    weak: Color32::from_rgb(0x61, 0x66, 0x6e),
    good: Color32::from_rgb(0x1d, 0x7a, 0x3c),
    bad: Color32::from_rgb(0xb4, 0x2a, 0x1c),
};

impl Palette {
    pub(crate) fn of(ui: &Ui) -> Self {
        Self::of_visuals(ui.visuals())
    }

    pub(crate) fn of_visuals(visuals: &Visuals) -> Self {
        if visuals.dark_mode { DARK } else { LIGHT }
    }
}

/// Limbs in the order in which they are added: as far apart as ten colours on a filmed picture can be.
const LIMBS: [Color32; 10] = [
    Color32::from_rgb(0x4c, 0xc2, 0xff),
    Color32::from_rgb(0xff, 0xb0, 0x1f),
    Color32::from_rgb(0x7d, 0xdc, 0x6f),
    Color32::from_rgb(0xff, 0x6f, 0x91),
    Color32::from_rgb(0xb4, 0x8c, 0xff),
    Color32::from_rgb(0xf4, 0xe4, 0x4f),
    Color32::from_rgb(0x3f, 0xd6, 0xc6),
    Color32::from_rgb(0xff, 0x8a, 0x4c),
    Color32::from_rgb(0x9f, 0xb3, 0xff),
    Color32::from_rgb(0xe0, 0x7b, 0xe0),
];

/// What is sure is drawn in its own colour, what is not in this.
const UNSURE: Color32 = Color32::from_rgb(0xff, 0x3b, 0x30);

pub(crate) fn limb(index: usize) -> Color32 {
    LIMBS[index % LIMBS.len()]
}

/// A colour for how far a tracked place is trusted, 0..=1: below a half it turns to red.
pub(crate) fn trusted(color: Color32, confidence: f32) -> Color32 {
    color.lerp_to_gamma(UNSURE, (1.0 - 2.0 * confidence).clamp(0.0, 1.0))
}

/// Sets both themes up.
pub(crate) fn apply(ctx: &Context) {
    for (theme, palette) in [(Theme::Dark, DARK), (Theme::Light, LIGHT)] {
        ctx.style_mut_of(theme, |style| {
            style.visuals = visuals(theme, &palette);
            let font = |size| FontId::new(size, FontFamily::Proportional);
            style.text_styles = [
                (TextStyle::Heading, font(24.0)),
                (TextStyle::Body, font(14.0)),
                (TextStyle::Button, font(14.0)),
                (TextStyle::Small, font(12.0)),
                (TextStyle::Monospace, FontId::new(13.0, FontFamily::Monospace)),
            ]
            .into();
            let spacing = &mut style.spacing;
            spacing.item_spacing = vec2(GAP, GAP);
            spacing.button_padding = vec2(10.0, 5.0);
            spacing.interact_size = vec2(40.0, 28.0);
            spacing.menu_margin = Margin::same(6);
            style.interaction.selectable_labels = false;
        });
    }
}

/// What dialogs lie on.
pub(crate) fn dialog(ctx: &Context) -> Frame {
    Frame::window(&ctx.global_style()).inner_margin(20)
}

pub(crate) fn set_light(ctx: &Context, light: Appearance) {
    use eframe::egui::ThemePreference;
    ctx.set_theme(match light {
        Appearance::System => ThemePreference::System,
        Appearance::Light => ThemePreference::Light,
        Appearance::Dark => ThemePreference::Dark,
    });
}

fn visuals(theme: Theme, p: &Palette) -> Visuals {
    let state = |fill: Color32, outline: Color32, text: Color32| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, outline),
        corner_radius: CornerRadius::same(RADIUS),
        fg_stroke: Stroke::new(1.2, text),
        expansion: 0.0,
    };
    let widgets = Widgets {
        noninteractive: state(p.panel, p.outline, p.text),
        inactive: state(p.raised, p.outline, p.text),
        hovered: state(p.hovered, p.weak, p.text),
        active: state(p.hovered, p.accent, p.text),
        open: state(p.hovered, p.outline, p.text),
    };
    Visuals {
        widgets,
        selection: Selection {
            bg_fill: p.accent.linear_multiply(if theme == Theme::Dark { 0.28 } else { 0.22 }),
            stroke: Stroke::new(1.5, p.accent),
        },
        weak_text_color: Some(p.weak),
        hyperlink_color: p.accent,
        faint_bg_color: p.hovered,
        extreme_bg_color: if theme == Theme::Dark { p.canvas } else { p.raised },
        warn_fg_color: p.accent,
        error_fg_color: p.bad,
        panel_fill: p.panel,
        window_fill: p.panel,
        window_stroke: Stroke::new(1.0, p.outline),
        window_corner_radius: CornerRadius::same(10),
        menu_corner_radius: CornerRadius::same(8),
        window_shadow: Shadow { offset: [0, 8], blur: 32, spread: 0, color: Color32::from_black_alpha(110) },
        slider_trailing_fill: true,
        ..theme.default_visuals()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance and contrast by WCAG 2.2.
    fn contrast(a: Color32, b: Color32) -> f32 {
        let luminance = |c: Color32| {
            let channel = |v: u8| {
                let v = f32::from(v) / 255.0;
                if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
            };
            0.2126 * channel(c.r()) + 0.7152 * channel(c.g()) + 0.0722 * channel(c.b())
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn texts_can_be_read() {
        for p in [DARK, LIGHT] {
            for ground in [p.panel, p.raised] {
                // WCAG 2.2, 1.4.3: 4.5 to 1 for texts.
                for text in [p.text, p.weak, p.bad, p.good] {
                    assert!(contrast(text, ground) >= 4.5, "{text:?} on {ground:?}: {}", contrast(text, ground));
                }
            }
            assert!(contrast(p.on_accent, p.accent) >= 4.5, "{}", contrast(p.on_accent, p.accent));
        }
    }
}
