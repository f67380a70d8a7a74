//! A character as it was drawn, with its skeleton, and in motion.

use eframe::egui::{Align2, Color32, FontId, Painter, Rect, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2};

use crate::around::Around;
use crate::character_door::CharacterDoor;
use crate::handles::{Done, Handle};
use crate::icons::Icon;
use crate::looking::{self, WHOLE};
use crate::moving::{Moving, MovingPictures};
use crate::shortcuts::Command;
use crate::theme::{self, Palette};
use crate::view::Placement;
use crate::{overlay, texts, widgets};

impl CharacterDoor {
    /// The drawing with its skeleton, as it was drawn.
    pub(crate) fn show_figure(&mut self, ui: &mut Ui, around: &mut Around) {
        let palette = Palette::of(ui);
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        painter.rect_filled(panel, 0.0, palette.canvas);
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, texts::FIGURE_NAME));
        let Some((size, joints, bones)) = self.figure.as_ref().map(|f| (f.size, f.joints.clone(), f.bones.clone()))
        else {
            let middle = FontId::proportional(15.0);
            painter.text(panel.center(), Align2::CENTER_CENTER, texts::SEEING, middle, palette.weak);
            return;
        };
        let placed = self.looking.show(ui, &response, size);
        painter.rect_filled(placed.picture(size), 2.0, Color32::WHITE);
        if let Some(still) = &self.still {
            self.still_pictures.update(ui.ctx(), still, 0, placed.scale * ui.pixels_per_point());
            show_picture(&painter, placed, &self.still_pictures);
        }
        if self.needles
            && let Some(figure) = &self.figure
        {
            let at: Vec<_> = joints.iter().map(|(_, at)| *at).collect();
            figure.needles.paint_rest(&painter, &at, |p| placed.to_screen(p));
        }
        let handles: Vec<Handle> =
            (0..joints.len()).map(|number| Handle { number, at: joints[number].1, sure: 1.0, by_hand: true }).collect();
        if self.bones {
            let done = self.hand.act(ui, &response, placed, (&handles, self.selected));
            let at = |joint: u32| placed.to_screen(self.hand.place(&handles[joint as usize]));
            for [from, to] in bones {
                overlay::line(&painter, &[at(from), at(to)], 3.0, theme::limb(to as usize));
            }
            if self.shop.document.clip.is_some() {
                // Equal numbers are on the clip.
                self.hand.paint(&painter, placed, &handles, self.selected);
            } else {
                for handle in &handles {
                    let place = placed.to_screen(self.hand.place(handle));
                    let on = self.selected == Some(handle.number);
                    let ring =
                        Stroke::new(if on { 3.0 } else { 1.5 }, if on { Color32::WHITE } else { Color32::BLACK });
                    painter.circle(place, if on { 7.0 } else { 6.0 }, theme::limb(handle.number), ring);
                }
            }
            let near = response
                .hover_pos()
                .and_then(|at| handles.iter().find(|h| placed.to_screen(h.at).distance(at) < 12.0).map(|h| h.number));
            if let Some(joint) = near.or(self.selected).filter(|j| *j < joints.len()) {
                let at = placed.to_screen(self.hand.place(&handles[joint])) + vec2(14.0, -14.0);
                let galley =
                    painter.layout_no_wrap(joints[joint].0.clone(), FontId::proportional(13.0), Color32::WHITE);
                let ground = Rect::from_min_size(at - vec2(6.0, 13.0), galley.size() + vec2(12.0, 6.0));
                painter.rect_filled(ground, 4.0, Color32::from_black_alpha(190));
                painter.galley(ground.min + vec2(6.0, 3.0), galley, Color32::WHITE);
            }
            match done {
                Some(Done::Moved(joint, at)) => {
                    self.selected = Some(joint);
                    // It is shown where it was let go until the mesh has followed.
                    if let Some(figure) = &mut self.figure {
                        figure.joints[joint].1 = at;
                    }
                    self.move_joint(ui.ctx(), joint, at, around);
                }
                Some(Done::Selected(joint)) => self.selected = Some(joint),
                Some(Done::Clicked(_)) => self.selected = None,
                None => {}
            }
        }
        looking::toolbar(ui, panel, 4.0, |ui| {
            if widgets::word_toggle(ui, texts::SKELETON, self.bones, Command::Tracks) {
                self.bones ^= true;
            }
            if self.shop.document.clip.is_some()
                && !self.on_clip
                && widgets::word_toggle(ui, texts::ON_CLIP, false, Command::Clip)
            {
                self.on_clip = true;
            }
            if widgets::command_button(ui, Icon::Fit, texts::FIT_DRAWING, Command::Fit) {
                self.looking.fit();
            }
        });
    }

    /// The character in motion.
    pub(crate) fn show_moving(&mut self, ui: &mut Ui, frame: u64) {
        let palette = Palette::of(ui);
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        painter.rect_filled(panel, 0.0, palette.canvas);
        painter.vline(panel.left(), panel.y_range(), Stroke::new(1.0, palette.outline));
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, texts::MOVING_NAME));
        let Some(moving) = self.shop.moving.clone() else {
            let text = if self.motion().is_none() { texts::NO_MOTION } else { texts::SEEING };
            let galley =
                painter.layout(text.to_owned(), FontId::proportional(15.0), palette.weak, panel.width() - 60.0);
            painter.galley(panel.center() - galley.size() / 2.0, galley, palette.weak);
            return;
        };
        let size = self.figure.as_ref().map_or(Vec2::splat(1.0), |f| f.size);
        // All of every frame is to be seen.
        let area = self.shop.pictures.area;
        let whole = if area.is_positive() { area.size() } else { size };
        let placed = self.moving_looking.show(ui, &response, whole);
        self.shop.pictures.update(ui.ctx(), &moving, frame, placed.scale * ui.pixels_per_point());
        let paper = placed.picture(whole);
        painter.rect_filled(paper, 2.0, Color32::WHITE);
        if let Some(texture) = self.shop.pictures.picture() {
            painter.image(texture.id(), paper, WHOLE, Color32::WHITE);
        }
        if let (Moving::Character(take), Some(figure)) = (&moving, &self.figure)
            && (self.mesh || self.needles)
            && let (Ok(points), Ok(joints)) = (take.points(frame), take.joints(frame))
        {
            let on_screen = |p: (f32, f32)| placed.to_screen((p.0 - area.min.x, p.1 - area.min.y));
            if self.mesh {
                let place = |v: u32| points.get(v as usize).map(|p| on_screen(*p));
                let line = Stroke::new(1.0, palette.accent.gamma_multiply(0.6));
                for [a, b] in &figure.edges {
                    if let (Some(a), Some(b)) = (place(*a), place(*b)) {
                        painter.line_segment([a, b], line);
                    }
                }
            }
            if self.needles {
                figure.needles.paint(&painter, &points, &joints, on_screen);
            }
        }
        looking::toolbar(ui, panel, 4.0, |ui| {
            if widgets::word_toggle(ui, texts::MESH, self.mesh, Command::Mask) {
                self.mesh ^= true;
            }
            if widgets::word_toggle(ui, texts::NEEDLES_SHOWN, self.needles, Command::Overlaps) {
                self.needles ^= true;
            }
            if widgets::command_button(ui, Icon::Fit, texts::FIT_MOVING, Command::Fit) {
                self.moving_looking.fit();
            }
        });
        if let Some(failed) = &self.shop.pictures.failed {
            let galley = painter.layout(failed.clone(), FontId::proportional(14.0), palette.bad, panel.width() - 40.0);
            painter.galley(panel.min + vec2(20.0, 60.0), galley, palette.bad);
        }
    }
}

fn show_picture(painter: &Painter, placed: Placement, pictures: &MovingPictures) {
    if let Some(texture) = pictures.picture() {
        let (low, high) = (pictures.area.min, pictures.area.max);
        let at = Rect::from_min_max(placed.to_screen((low.x, low.y)), placed.to_screen((high.x, high.y)));
        painter.image(texture.id(), at, WHOLE, Color32::WHITE);
    }
}
