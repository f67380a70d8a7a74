//! Where a picture lies in a panel: fitted, or zoomed and moved.

use eframe::egui::{Pos2, Rect, Vec2};

/// One pixel of a picture as large as a thumb, and a picture as small as one.
const SCALES: (f32, f32) = (0.05, 40.0);
/// Air around a fitted picture, points.
const AIR: f32 = 16.0;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct View {
    /// Points a pixel, and the pixel in the panel's middle; fitted without.
    placed: Option<(f32, Vec2)>,
}

/// A [`View`] in a panel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    pub(crate) scale: f32,
    centre: Vec2,
    panel: Rect,
}

impl Placement {
    pub(crate) fn to_screen(self, at: (f32, f32)) -> Pos2 {
        self.panel.center() + (Vec2::new(at.0, at.1) - self.centre) * self.scale
    }

    pub(crate) fn to_picture(self, at: Pos2) -> (f32, f32) {
        let at = self.centre + (at - self.panel.center()) / self.scale;
        (at.x, at.y)
    }

    pub(crate) fn picture(self, size: Vec2) -> Rect {
        Rect::from_min_max(self.to_screen((0.0, 0.0)), self.to_screen((size.x, size.y)))
    }
}

impl View {
    pub(crate) fn fit(&mut self) {
        self.placed = None;
    }

    pub(crate) fn place(&self, panel: Rect, size: Vec2) -> Placement {
        let (scale, centre) = self.placed.unwrap_or_else(|| {
            let room = (panel.size() - Vec2::splat(2.0 * AIR)).max(Vec2::splat(1.0));
            let scale = (room / size.max(Vec2::splat(1.0))).min_elem();
            (scale.clamp(SCALES.0, SCALES.1), size / 2.0)
        });
        Placement { scale, centre, panel }
    }

    /// Zooms so that what is at `at` stays there.
    pub(crate) fn zoom(&mut self, panel: Rect, size: Vec2, at: Pos2, factor: f32) {
        let now = self.place(panel, size);
        let scale = (now.scale * factor).clamp(SCALES.0, SCALES.1);
        let under = now.to_picture(at);
        let centre = Vec2::new(under.0, under.1) - (at - panel.center()) / scale;
        self.placed = Some((scale, within(centre, size)));
    }

    pub(crate) fn pan(&mut self, panel: Rect, size: Vec2, by: Vec2) {
        let now = self.place(panel, size);
        self.placed = Some((now.scale, within(now.centre - by / now.scale, size)));
    }
}

/// Something of the picture stays in sight.
fn within(centre: Vec2, size: Vec2) -> Vec2 {
    centre.clamp(Vec2::ZERO, size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{pos2, vec2};

    const PANEL: Rect = Rect { min: Pos2::new(100.0, 50.0), max: Pos2::new(900.0, 650.0) };
    const SIZE: Vec2 = Vec2::new(640.0, 360.0);

    #[test]
    fn a_fitted_picture_is_whole_and_in_the_middle() {
        let placed = View::default().place(PANEL, SIZE).picture(SIZE);
        assert!(PANEL.contains_rect(placed));
        assert!((placed.center() - PANEL.center()).length() < 0.01);
        assert!((placed.width() / placed.height() - SIZE.x / SIZE.y).abs() < 1e-4);
    }

    #[test]
    fn zooming_holds_what_is_under_the_cursor() {
        let (mut view, cursor) = (View::default(), pos2(450.0, 300.0));
        let before = view.place(PANEL, SIZE).to_picture(cursor);
        for _ in 0..3 {
            view.zoom(PANEL, SIZE, cursor, 1.3);
        }
        let after = view.place(PANEL, SIZE);
        let now = after.to_picture(cursor);
        assert!((now.0 - before.0).abs() < 0.01 && (now.1 - before.1).abs() < 0.01, "{before:?} {now:?}");
        let there = after.to_screen(now);
        assert!((there - cursor).length() < 0.01);
    }

    #[test]
    fn nobody_gets_lost() {
        let mut view = View::default();
        for _ in 0..100 {
            view.pan(PANEL, SIZE, vec2(500.0, -300.0));
            view.zoom(PANEL, SIZE, pos2(110.0, 60.0), 0.2);
        }
        let placed = view.place(PANEL, SIZE);
        assert!(placed.scale >= SCALES.0);
        assert!(placed.picture(SIZE).expand(1.0).contains(PANEL.center()));
        for _ in 0..100 {
            view.zoom(PANEL, SIZE, pos2(700.0, 600.0), 9.0);
        }
        assert!(view.place(PANEL, SIZE).scale <= SCALES.1);
        view.fit();
        assert!(PANEL.contains_rect(view.place(PANEL, SIZE).picture(SIZE)));
    }

    #[test]
    fn a_panel_without_room_is_no_trouble() {
        let none = Rect::from_min_size(pos2(3.0, 3.0), Vec2::ZERO);
        let placed = View::default().place(none, Vec2::ZERO);
        assert!(placed.scale.is_finite() && placed.to_picture(pos2(0.0, 0.0)).0.is_finite());
    }
}
