//! The needles of a character: what holds each vertex of its mesh to its bone. The engine keeps a vertex' angle and its place
//! along the bone (but near joints, where bones share it), so that the foot is the bone's nearest point at rest, wherever
//! the bone goes.

use eframe::egui::{Painter, Pos2, Stroke};
use marey_binding::{Character, Result};

use crate::theme;

/// One vertex on its bone.
#[derive(Clone, Copy, Debug)]
struct Needle {
    /// The joints of the bone.
    bone: [u32; 2],
    /// How far along the bone its foot is, 0 to 1.
    along: f32,
}

/// One for each vertex.
#[derive(Debug)]
pub(crate) struct Needles {
    needles: Vec<Needle>,
    /// The mesh at rest.
    rest: Vec<(f32, f32)>,
}

impl Needles {
    /// `joints` and `bones` are those of the character.
    pub(crate) fn of(character: &Character, joints: &[(String, (f32, f32))], bones: &[[u32; 2]]) -> Result<Needles> {
        let rest = character.vertices()?;
        let needle = |(&(x, y), bone): (&(f32, f32), u32)| {
            let bone = *bones.get(bone as usize)?;
            let [from, to] = bone.map(|joint| joints.get(joint as usize).map(|(_, at)| Pos2::from(*at)));
            let (from, along) = (from?, to? - from?);
            let share = (Pos2::new(x, y) - from).dot(along) / along.length_sq().max(f32::MIN_POSITIVE);
            Some(Needle { bone, along: share.clamp(0.0, 1.0) })
        };
        let needles = rest.iter().zip(character.vertex_bones()?).filter_map(needle).collect();
        Ok(Needles { needles, rest })
    }

    /// Draws them as they are at rest.
    pub(crate) fn paint_rest(&self, painter: &Painter, joints: &[(f32, f32)], to_screen: impl Fn((f32, f32)) -> Pos2) {
        self.paint(painter, &self.rest, joints, to_screen);
    }

    /// Draws them from the `joints` to the mesh's `points` of a frame, in the colours of their bones.
    pub(crate) fn paint(
        &self,
        painter: &Painter,
        points: &[(f32, f32)],
        joints: &[(f32, f32)],
        to_screen: impl Fn((f32, f32)) -> Pos2,
    ) {
        for (needle, &tip) in self.needles.iter().zip(points) {
            let [Some(&from), Some(&to)] = needle.bone.map(|joint| joints.get(joint as usize)) else { continue };
            let foot = to_screen(from).lerp(to_screen(to), needle.along);
            let color = theme::limb(needle.bone[1] as usize).gamma_multiply(0.8);
            painter.line_segment([foot, to_screen(tip)], Stroke::new(1.0, color));
        }
    }
}
