//! Icons as lines, drawn at any size in any colour.

use std::f32::consts::TAU;

use eframe::egui::{Color32, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Icon {
    Play,
    Pause,
    First,
    Last,
    Previous,
    Next,
    Loop,
    Undo,
    Redo,
    Home,
    Close,
    Trash,
    Plus,
    Check,
    Warning,
    Fit,
    Help,
    Sun,
    Filmed,
    Clip,
    Figure,
    Pencil,
    Plug,
    Sliders,
    Onion,
    Brush,
    Eraser,
}

impl Icon {
    /// A square with the icon, which does nothing.
    pub(crate) fn show(self, ui: &mut Ui, size: f32, color: Color32) {
        let (rect, _) = ui.allocate_exact_size(Vec2::splat(size), Sense::hover());
        self.paint(ui.painter(), rect, color);
    }

    /// Fills the larger part of `rect`.
    pub(crate) fn paint(self, painter: &Painter, rect: Rect, color: Color32) {
        let side = rect.width().min(rect.height());
        // Drawn in a square of 16.
        let at = |x: f32, y: f32| rect.center() + vec2(x - 8.0, y - 8.0) * (side / 16.0);
        let pen = Stroke::new((side / 11.0).max(1.2), color);
        let line = |points: &[(f32, f32)]| {
            painter.add(Shape::line(points.iter().map(|p| at(p.0, p.1)).collect(), pen));
        };
        let ring = |points: &[(f32, f32)]| {
            painter.add(Shape::closed_line(points.iter().map(|p| at(p.0, p.1)).collect(), pen));
        };
        let solid = |points: &[(f32, f32)]| {
            let points: Vec<Pos2> = points.iter().map(|p| at(p.0, p.1)).collect();
            painter.add(Shape::convex_polygon(points, color, Stroke::NONE));
        };
        let arc = |centre: (f32, f32), radius: f32, from: f32, to: f32| {
            let point = |i: i32| {
                let angle = (from + (to - from) * i as f32 / 24.0) * TAU;
                (centre.0 + radius * angle.cos(), centre.1 + radius * angle.sin())
            };
            line(&(0..=24).map(point).collect::<Vec<_>>());
        };
        match self {
            Self::Play => solid(&[(4.5, 2.5), (13.5, 8.0), (4.5, 13.5)]),
            Self::Pause => {
                solid(&[(4.0, 3.0), (6.7, 3.0), (6.7, 13.0), (4.0, 13.0)]);
                solid(&[(9.3, 3.0), (12.0, 3.0), (12.0, 13.0), (9.3, 13.0)]);
            }
            Self::First => {
                line(&[(4.0, 3.5), (4.0, 12.5)]);
                solid(&[(12.5, 3.0), (12.5, 13.0), (5.5, 8.0)]);
            }
            Self::Last => {
                line(&[(12.0, 3.5), (12.0, 12.5)]);
                solid(&[(3.5, 3.0), (10.5, 8.0), (3.5, 13.0)]);
            }
            Self::Previous => line(&[(10.0, 3.5), (5.5, 8.0), (10.0, 12.5)]),
            Self::Next => line(&[(6.0, 3.5), (10.5, 8.0), (6.0, 12.5)]),
            Self::Loop => {
                arc((8.0, 8.0), 5.2, -0.18, 0.62);
                line(&[(8.2, 2.2), (10.4, 3.5), (8.9, 5.6)]);
            }
            Self::Undo | Self::Redo => {
                let flip = |x: f32| if self == Self::Undo { x } else { 16.0 - x };
                let hook: Vec<_> = (0..=16)
                    .map(|i| {
                        let angle = -0.25 + 0.5 * i as f32 / 16.0;
                        (flip(9.0 + 3.7 * (angle * TAU).cos()), 8.9 + 3.7 * (angle * TAU).sin())
                    })
                    .collect();
                line(&hook);
                line(&[(flip(9.0), 5.2), (flip(3.4), 5.2)]);
                line(&[(flip(6.0), 2.4), (flip(3.2), 5.2), (flip(6.0), 8.0)]);
                line(&[(flip(9.0), 12.6), (flip(6.0), 12.6)]);
            }
            Self::Home => {
                line(&[(2.5, 8.0), (8.0, 2.8), (13.5, 8.0)]);
                line(&[(4.2, 7.0), (4.2, 13.0), (11.8, 13.0), (11.8, 7.0)]);
            }
            Self::Close => {
                line(&[(4.2, 4.2), (11.8, 11.8)]);
                line(&[(11.8, 4.2), (4.2, 11.8)]);
            }
            Self::Trash => {
                line(&[(3.0, 4.6), (13.0, 4.6)]);
                line(&[(6.2, 4.6), (6.2, 2.8), (9.8, 2.8), (9.8, 4.6)]);
                line(&[(4.4, 4.6), (5.0, 13.2), (11.0, 13.2), (11.6, 4.6)]);
            }
            Self::Plus => {
                line(&[(8.0, 3.0), (8.0, 13.0)]);
                line(&[(3.0, 8.0), (13.0, 8.0)]);
            }
            Self::Check => line(&[(3.2, 8.6), (6.6, 12.0), (12.8, 4.4)]),
            Self::Warning => {
                ring(&[(8.0, 2.4), (14.2, 13.2), (1.8, 13.2)]);
                line(&[(8.0, 6.4), (8.0, 9.6)]);
                painter.circle_filled(at(8.0, 11.5), side / 16.0, color);
            }
            Self::Fit => {
                for (x, y) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                    let corner = |dx: f32, dy: f32| (8.0 + x * dx, 8.0 + y * dy);
                    line(&[corner(5.2, 2.2), corner(5.2, 5.2), corner(2.2, 5.2)]);
                }
            }
            Self::Help => {
                arc((8.0, 5.6), 2.9, -0.5, 0.14);
                line(&[(9.9, 7.8), (8.0, 9.2), (8.0, 10.6)]);
                painter.circle_filled(at(8.0, 13.0), side / 14.0, color);
            }
            Self::Sun => {
                painter.circle_stroke(at(8.0, 8.0), side * 0.19, pen);
                for i in 0..8 {
                    let ray = Vec2::angled(TAU * i as f32 / 8.0) * (side / 16.0);
                    painter.line_segment([at(8.0, 8.0) + ray * 5.0, at(8.0, 8.0) + ray * 6.6], pen);
                }
            }
            Self::Filmed => {
                ring(&[(2.0, 5.0), (10.0, 5.0), (10.0, 11.5), (2.0, 11.5)]);
                ring(&[(10.0, 7.6), (14.0, 5.2), (14.0, 11.3), (10.0, 8.9)]);
            }
            Self::Clip => {
                ring(&[(1.5, 3.5), (14.5, 3.5), (14.5, 12.5), (1.5, 12.5)]);
                for y in [3.5, 12.5] {
                    for x in [4.0, 8.0, 12.0] {
                        let inward = if y < 8.0 { 2.0 } else { -2.0 };
                        line(&[(x, y), (x, y + inward)]);
                    }
                }
            }
            Self::Figure => {
                painter.circle_stroke(at(8.0, 3.6), side * 0.12, pen);
                line(&[(8.0, 5.6), (8.0, 9.6), (5.0, 14.0)]);
                line(&[(8.0, 9.6), (11.4, 13.6)]);
                line(&[(3.6, 8.6), (8.0, 6.8), (12.8, 5.4)]);
            }
            Self::Plug => {
                line(&[(6.0, 2.0), (6.0, 5.5)]);
                line(&[(10.0, 2.0), (10.0, 5.5)]);
                ring(&[(3.8, 5.5), (12.2, 5.5), (11.2, 9.6), (9.0, 10.8), (7.0, 10.8), (4.8, 9.6)]);
                line(&[(8.0, 10.8), (8.0, 14.0)]);
            }
            Self::Sliders => {
                for (y, knob) in [(4.0, 10.5), (8.0, 5.0), (12.0, 9.0)] {
                    line(&[(2.5, y), (knob - 1.6, y)]);
                    line(&[(knob + 1.6, y), (13.5, y)]);
                    painter.circle_stroke(at(knob, y), side * 0.1, pen);
                }
            }
            Self::Onion => {
                for (x, share) in [(6.0, 0.45), (10.0, 1.0)] {
                    let pen = Stroke::new(pen.width, color.gamma_multiply(share));
                    painter.circle_stroke(at(x, 8.0), side * 0.26, pen);
                }
            }
            Self::Brush => {
                line(&[(13.4, 2.6), (8.2, 8.6)]);
                ring(&[(8.2, 8.6), (9.0, 10.6), (7.0, 13.0), (2.8, 13.4), (4.6, 11.2), (5.6, 8.8)]);
            }
            Self::Eraser => {
                ring(&[(2.8, 10.2), (9.6, 3.4), (13.4, 7.2), (7.4, 13.2), (5.8, 13.2)]);
                line(&[(6.4, 6.6), (10.2, 10.4)]);
            }
            Self::Pencil => {
                ring(&[(3.0, 13.0), (3.8, 9.8), (10.8, 2.8), (13.2, 5.2), (6.2, 12.2)]);
                line(&[(9.2, 4.4), (11.6, 6.8)]);
            }
        }
    }
}

/// A diamond around a place: the mark of a key frame.
pub(crate) fn diamond(painter: &Painter, at: Pos2, radius: f32, fill: Color32, outline: Stroke) {
    let corners = [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)];
    let corners = corners.map(|(x, y)| pos2(at.x + x * radius, at.y + y * radius)).to_vec();
    painter.add(Shape::convex_polygon(corners, fill, outline));
}
