//! Hints for what is creature and what is not, painted on a frame. A pen that is pressed harder paints wider.

use eframe::egui::{Color32, Event, Painter, Pos2, Shape, Stroke, Ui};

use crate::view::Placement;

/// Radii in pixels of the clip: a whisker, and half of a frame.
pub(crate) const RADII: (f32, f32) = (1.0, 200.0);
const CREATURE: Color32 = Color32::from_rgb(0x52, 0xd6, 0x8f);
const BESIDE: Color32 = Color32::from_rgb(0xff, 0x5a, 0x4f);

/// What the pen does on the clip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tool {
    /// It draws limbs.
    #[default]
    Limbs,
    /// It paints what is creature.
    Creature,
    /// It paints what is not.
    Beside,
}

/// A painted hint, in pixels of the clip.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Painted {
    pub(crate) creature: bool,
    pub(crate) radius: f32,
    pub(crate) points: Vec<(f32, f32)>,
}

#[derive(Debug)]
pub(crate) struct Brush {
    pub(crate) tool: Tool,
    /// Where nothing is pressed.
    pub(crate) radius: f32,
    /// How hard the pen was pressed along the present stroke, 0..=1.
    pressed: Vec<f32>,
}

impl Default for Brush {
    fn default() -> Self {
        Self { tool: Tool::Limbs, radius: 8.0, pressed: Vec::new() }
    }
}

impl Brush {
    pub(crate) fn paints(&self) -> bool {
        self.tool != Tool::Limbs
    }

    pub(crate) fn color(&self) -> Color32 {
        if self.tool == Tool::Creature { CREATURE } else { BESIDE }
    }

    /// Begins a stroke.
    pub(crate) fn begin(&mut self) {
        self.pressed.clear();
    }

    /// Hears how hard the pen is pressed, where the system says so.
    pub(crate) fn hear(&mut self, ui: &Ui) {
        let force = |event: &Event| match event {
            Event::Touch { force, .. } => *force,
            _ => None,
        };
        ui.input(|i| self.pressed.extend(i.events.iter().filter_map(force)));
    }

    /// Half as wide where the pen hardly touches, and half as wide again where it is pressed hard.
    pub(crate) fn width(&self) -> f32 {
        if self.pressed.is_empty() {
            return self.radius;
        }
        let mean = self.pressed.iter().sum::<f32>() / self.pressed.len() as f32;
        (self.radius * (0.5 + mean.clamp(0.0, 1.0))).clamp(RADII.0, RADII.1)
    }

    pub(crate) fn resize(&mut self, factor: f32) {
        self.radius = (self.radius * factor).clamp(RADII.0, RADII.1);
    }

    /// The hint that a stroke is.
    pub(crate) fn hint(&self, points: Vec<(f32, f32)>) -> Painted {
        Painted { creature: self.tool == Tool::Creature, radius: self.width(), points }
    }
}

/// What was painted on a frame.
pub(crate) fn paint(painter: &Painter, placed: Placement, hints: &[Painted]) {
    for hint in hints {
        let points: Vec<Pos2> = hint.points.iter().map(|p| placed.to_screen(*p)).collect();
        band(painter, &points, hint.radius * placed.scale, if hint.creature { CREATURE } else { BESIDE });
    }
}

/// A line as wide as the brush.
pub(crate) fn band(painter: &Painter, points: &[Pos2], radius: f32, color: Color32) {
    let color = color.gamma_multiply(0.45);
    match points {
        [] => {}
        [at] => {
            painter.circle_filled(*at, radius, color);
        }
        _ => {
            painter.add(Shape::line(points.to_vec(), Stroke::new(2.0 * radius, color)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pen_that_is_pressed_paints_wider() {
        let mut brush = Brush { radius: 10.0, tool: Tool::Creature, ..Brush::default() };
        assert_eq!(brush.hint(vec![(1.0, 2.0)]), Painted { creature: true, radius: 10.0, points: vec![(1.0, 2.0)] });
        brush.pressed = vec![0.2, 0.4];
        let soft = brush.width();
        brush.pressed = vec![1.0];
        assert!(soft < 10.0 && brush.width() == 15.0, "{soft}");
        brush.begin();
        brush.resize(1000.0);
        assert_eq!(brush.width(), RADII.1);
    }
}
