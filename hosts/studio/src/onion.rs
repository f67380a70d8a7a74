//! Onion skin: the poses before and after the one that is shown, in two tints, fainter the farther they are.
//!
//! It follows the limbs as they were tracked. Before they are, it shows what is drawn on the key frames before and after.

use eframe::egui::{Color32, DragValue, Grid, Painter, Pos2, Sense, Shape, Stroke, Ui, vec2};
use serde::{Deserialize, Serialize};

use crate::document::Document;
use crate::texts;
use crate::view::Placement;

/// So many poses on a side are still told apart.
const MOST: u64 = 8;
/// Frames from one pose to the next.
const FARTHEST: u64 = 24;
const BEFORE: Color32 = Color32::from_rgb(0x52, 0xd6, 0x8f);
const AFTER: Color32 = Color32::from_rgb(0x63, 0xa6, 0xff);

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Onion {
    pub(crate) on: bool,
    before: u64,
    after: u64,
    /// Frames from one pose to the next.
    every: u64,
}

impl Default for Onion {
    fn default() -> Self {
        Self { on: false, before: 2, after: 2, every: 2 }
    }
}

impl Onion {
    /// Draws the poses around `frame`, the farthest first; beyond the ends the clip begins again where it is looped.
    pub(crate) fn paint(&self, painter: &Painter, placed: Placement, document: &Document, frame: u64, looped: bool) {
        if !self.on {
            return;
        }
        for (far, count, at) in self.poses(document, frame, looped) {
            let tint = if far < 0 { BEFORE } else { AFTER };
            let share = 1.0 - (far.unsigned_abs() - 1) as f32 / count as f32;
            let color = tint.gamma_multiply(0.25 + 0.5 * share);
            for limb in 0..document.limbs.len() {
                let drawn = document.stroke(limb, at).map(|s| &s.points[..]);
                let tracked = || Some(&document.tracked.as_ref()?.limbs.get(limb)?.get(at as usize)?.points[..]);
                let Some(points) = drawn.or_else(tracked) else { continue };
                let points: Vec<Pos2> = points.iter().map(|p| placed.to_screen(*p)).collect();
                painter.add(Shape::line(points, Stroke::new(2.0, color)));
            }
        }
    }

    /// How far in poses, of how many, and the frame of each pose.
    fn poses(&self, document: &Document, frame: u64, looped: bool) -> Vec<(i64, u64, u64)> {
        let keys = document.tracked.is_none().then_some(&document.keys[..]);
        let sides = [(-1, self.before.min(MOST)), (1, self.after.min(MOST))];
        let of_side = |(side, count): (i64, u64)| {
            let every = self.every.clamp(1, FARTHEST) as i64;
            (1..=count).rev().filter_map(move |far| {
                let at = match keys {
                    Some(keys) => key_beside(keys, frame, side * far as i64)?,
                    None => frame_beside(document.frames(), frame, side * far as i64 * every, looped)?,
                };
                Some((side * far as i64, count, at))
            })
        };
        sides.into_iter().flat_map(of_side).collect()
    }

    /// What can be chosen about it.
    pub(crate) fn settings(&mut self, ui: &mut Ui) {
        Grid::new("onion").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
            let most = 0..=MOST;
            let rows = [
                (texts::ONION_BEFORE, &mut self.before, most.clone(), Some(BEFORE)),
                (texts::ONION_AFTER, &mut self.after, most, Some(AFTER)),
                (texts::ONION_EVERY, &mut self.every, 1..=FARTHEST, None),
            ];
            for (text, value, range, tint) in rows {
                let label = ui
                    .horizontal(|ui| {
                        let (dot, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
                        if let Some(tint) = tint {
                            ui.painter().circle_filled(dot.center(), 5.0, tint);
                        }
                        ui.label(text)
                    })
                    .inner;
                ui.add(DragValue::new(value).range(range).speed(0.05)).labelled_by(label.id);
                ui.end_row();
            }
        });
    }
}

fn frame_beside(frames: u64, frame: u64, by: i64, looped: bool) -> Option<u64> {
    let (at, frames) = (frame as i64 + by, frames as i64);
    match (0..frames).contains(&at) {
        true => Some(at as u64),
        // Once around: a pose that has been shown as one before is none after.
        false if looped && by.abs() < frames => Some(at.rem_euclid(frames) as u64),
        false => None,
    }
}

fn key_beside(keys: &[u64], frame: u64, far: i64) -> Option<u64> {
    let far_of = |index: usize| keys.get(index).copied();
    if far < 0 {
        let before = keys.iter().filter(|k| **k < frame).count();
        before.checked_sub(far.unsigned_abs() as usize).and_then(far_of)
    } else {
        let after = keys.iter().filter(|k| **k <= frame).count();
        far_of(after + far as usize - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_counted_from_the_shown_frame() {
        let frames = |by, looped| frame_beside(10, 2, by, looped);
        assert_eq!([frames(-2, false), frames(-4, false), frames(7, false)], [Some(0), None, Some(9)]);
        assert_eq!([frames(-4, true), frames(8, true), frames(-10, true)], [Some(8), Some(0), None]);
        assert_eq!(frame_beside(0, 0, 1, true), None);
        let keys = [3, 8, 20];
        let of = |frame, far| key_beside(&keys, frame, far);
        assert_eq!([of(8, -1), of(8, -2), of(8, 1), of(8, 2)], [Some(3), None, Some(20), None]);
        assert_eq!([of(10, -1), of(10, -2), of(10, 1)], [Some(8), Some(3), Some(20)]);
    }
}
