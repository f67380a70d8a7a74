//! What is drawn over a frame: strokes, limbs as they were tracked, the paths of their ends, the mask.

use eframe::egui::{
    Color32, ColorImage, Context, FontId, Painter, Pos2, Rect, Shape, Stroke, TextureHandle, TextureOptions, pos2, vec2,
};
use marey_binding::{Facing, Masks};

use crate::document::Document;
use crate::theme;
use crate::view::Placement;

/// Which are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Overlays {
    pub(crate) strokes: bool,
    pub(crate) tracks: bool,
    pub(crate) paths: bool,
    pub(crate) mask: bool,
    /// Which of two limbs is in front.
    pub(crate) overlaps: bool,
}

impl Default for Overlays {
    fn default() -> Self {
        Self { strokes: true, tracks: true, paths: false, mask: false, overlaps: true }
    }
}

/// Dark under every line, so that it is seen on any picture.
const UNDER: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 150);
/// What lies beside the creature.
const BESIDE: [u8; 4] = [12, 14, 18, 170];

/// What was drawn on this frame.
pub(crate) fn strokes(painter: &Painter, placed: Placement, document: &Document, frame: u64, selected: Option<usize>) {
    for (limb, stroke) in document.strokes_on(frame) {
        let points: Vec<Pos2> = stroke.points.iter().map(|p| placed.to_screen(*p)).collect();
        let wide = if selected == Some(limb) { 5.0 } else { 3.0 };
        line(painter, &points, wide, theme::limb(limb));
        ends(painter, &points, wide, theme::limb(limb));
        facing(painter, &points, stroke.facing, theme::limb(limb));
    }
}

/// Limbs as they were tracked; those that are drawn on this frame are drawn by [`strokes`].
pub(crate) fn tracks(painter: &Painter, placed: Placement, document: &Document, frame: u64, selected: Option<usize>) {
    let Some(tracked) = &document.tracked else { return };
    for (limb, frames) in tracked.limbs.iter().enumerate() {
        let Some(at) = frames.get(frame as usize) else { continue };
        if document.stroke(limb, frame).is_some() {
            continue;
        }
        let points: Vec<Pos2> = at.points.iter().map(|p| placed.to_screen(*p)).collect();
        let wide = if selected == Some(limb) { 4.0 } else { 2.0 };
        painter.add(Shape::line(points.clone(), Stroke::new(wide + 2.0, UNDER)));
        for (i, pair) in points.windows(2).enumerate() {
            let sure = at.confidence[i].min(at.confidence[i + 1]);
            let seen = at.visible[i] && at.visible[i + 1];
            let pen = Stroke::new(wide, theme::trusted(theme::limb(limb), sure));
            let part = [pair[0], pair[1]];
            if seen {
                painter.line_segment(part, pen);
            } else {
                painter.extend(Shape::dashed_line(&part, pen, 4.0, 4.0));
            }
        }
        ends(painter, &points, wide, theme::limb(limb));
    }
}

/// Where the limbs' ends go over the whole clip, red where they are not sure.
/// `numbers` are those of the limbs, or points, for colours and for which is selected.
pub(crate) fn paths(
    painter: &Painter,
    placed: Placement,
    document: &Document,
    frame: u64,
    selected: Option<usize>,
    numbers: &[usize],
) {
    let Some(tracked) = &document.tracked else { return };
    for (limb, frames) in tracked.limbs.iter().enumerate() {
        let Some(number) = numbers.get(limb).copied().filter(|number| selected.is_none_or(|s| s == *number)) else {
            continue;
        };
        let end = |i: usize| Some((placed.to_screen(*frames[i].points.last()?), *frames[i].confidence.last()?));
        for i in 1..frames.len() {
            let (Some(from), Some(to)) = (end(i - 1), end(i)) else { continue };
            let color = theme::trusted(theme::limb(number), from.1.min(to.1));
            painter.line_segment([from.0, to.0], Stroke::new(1.6, color));
        }
        for key in &document.keys {
            if let Some(at) = document.stroke(limb, *key).and_then(|s| s.points.last()) {
                let outline = Stroke::new(1.0, UNDER);
                crate::icons::diamond(painter, placed.to_screen(*at), 4.0, theme::limb(number), outline);
            }
        }
        if let Some((now, _)) = (frame < frames.len() as u64).then(|| end(frame as usize)).flatten() {
            painter.circle_filled(now, 4.0, theme::limb(number));
        }
    }
}

/// A limb's name beside the middle of where it is.
pub(crate) fn name(painter: &Painter, placed: Placement, document: &Document, frame: u64, limb: usize) {
    let drawn = document.stroke(limb, frame).map(|s| &s.points);
    let followed = || Some(&document.tracked.as_ref()?.limbs.get(limb)?.get(frame as usize)?.points);
    let Some(points) = drawn.or_else(followed).filter(|p| !p.is_empty()) else { return };
    let at = placed.to_screen(points[points.len() / 2]) + vec2(12.0, -12.0);
    let label = document.limbs.get(limb).map_or("", |l| &l.label);
    let galley = painter.layout_no_wrap(label.to_owned(), FontId::proportional(13.0), Color32::WHITE);
    let ground = Rect::from_min_size(at - vec2(6.0, galley.size().y / 2.0 + 3.0), galley.size() + vec2(12.0, 6.0));
    painter.rect_filled(ground, 4.0, Color32::from_black_alpha(190));
    painter.galley(ground.min + vec2(6.0, 3.0), galley, Color32::WHITE);
}

pub(crate) fn line(painter: &Painter, points: &[Pos2], wide: f32, color: Color32) {
    painter.add(Shape::line(points.to_vec(), Stroke::new(wide + 2.5, UNDER)));
    painter.add(Shape::line(points.to_vec(), Stroke::new(wide, color)));
}

/// A limb begins with a ring and ends with a dot.
fn ends(painter: &Painter, points: &[Pos2], wide: f32, color: Color32) {
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        painter.circle(*first, wide + 1.5, Color32::from_black_alpha(200), Stroke::new(1.5, color));
        painter.circle(*last, wide + 1.0, color, Stroke::new(1.0, UNDER));
    }
}

/// A cross at an end that goes away, a dot in a ring at one that comes near: the feathers and the point of an arrow.
fn facing(painter: &Painter, points: &[Pos2], facing: Facing, color: Color32) {
    let Some(last) = points.last() else { return };
    match facing {
        Facing::Unknown => {}
        Facing::Toward => {
            painter.circle_stroke(*last, 9.0, Stroke::new(1.5, color));
        }
        Facing::Away => {
            for turn in [vec2(1.0, 1.0), vec2(1.0, -1.0)] {
                painter.line_segment([*last - turn * 7.0, *last + turn * 7.0], Stroke::new(2.0, color));
            }
        }
    }
}

/// The mask of one frame as a texture that darkens what is beside the creature.
#[derive(Default)]
pub(crate) struct MaskPicture(Option<(u64, TextureHandle)>);

impl MaskPicture {
    /// Another creature has other masks.
    pub(crate) fn clear(&mut self) {
        self.0 = None;
    }

    pub(crate) fn show(
        &mut self,
        ctx: &Context,
        painter: &Painter,
        at: Rect,
        masks: &Masks,
        size: [usize; 2],
        frame: u64,
    ) -> marey_binding::Result<()> {
        if self.0.as_ref().is_none_or(|(held, _)| *held != frame) {
            let rgba: Vec<u8> =
                masks.frame(frame)?.iter().flat_map(|inside| if *inside > 0 { [0; 4] } else { BESIDE }).collect();
            let picture = ColorImage::from_rgba_unmultiplied(size, &rgba);
            self.0 = Some((frame, ctx.load_texture("mask", picture, TextureOptions::LINEAR)));
        }
        if let Some((_, texture)) = &self.0 {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(texture.id(), at, whole, Color32::WHITE);
        }
        Ok(())
    }
}
