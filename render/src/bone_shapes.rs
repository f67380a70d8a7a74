//! Bones as they are drawn: octahedra from joint to joint, in front of all.

use glam::{Mat4, Vec3};

use crate::shading::{LAMP, limb_color};

/// How thick a bone is, against its length.
const THICKNESS: f32 = 0.12;
/// How far along a bone is thickest.
const WAIST: f32 = 0.2;
/// What leads from a limb to its parent is so much thinner.
const TIE: f32 = 0.25;

/// A corner of a shape: where, and its colour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    pub(crate) at: Vec3,
    pub(crate) color: Vec3,
}

/// A bone that is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) parent: usize,
    pub(crate) child: usize,
    /// Which limb it belongs to; `None` for the tie between two.
    pub(crate) limb: Option<usize>,
}

/// Corners of triangles, counter-clockwise from outside, for bones whose joints are at these places.
pub(crate) fn octahedra(links: &[Link], joints: &[Mat4], turn: &Mat4, out: &mut Vec<Corner>) {
    for link in links {
        let place = |joint: usize| joints[joint].transform_point3(Vec3::ZERO);
        let (from, to) = (place(link.parent), place(link.child));
        let Some(along) = (to - from).try_normalize() else { continue };
        let side = along.any_orthonormal_vector();
        let other = along.cross(side);
        let thick = from.distance(to) * THICKNESS * if link.limb.is_some() { 1.0 } else { TIE };
        let waist = from.lerp(to, WAIST);
        let ring = [side, other, -side, -other].map(|way| waist + way * thick);
        let base = link.limb.map_or(Vec3::splat(0.55), limb_color);
        for i in 0..4 {
            let (a, b) = (ring[i], ring[(i + 1) % 4]);
            for face in [[from, b, a], [a, b, to]] {
                let normal = (face[1] - face[0]).cross(face[2] - face[0]);
                let normal = turn.transform_vector3(normal).normalize_or(Vec3::Z);
                // More contrast than surfaces have, so that edges tell.
                let bright = 0.45 + 0.75 * normal.dot(LAMP.normalize_or(Vec3::Z)).max(0.0);
                let color = (base * bright).lerp(Vec3::ONE, 0.15).min(Vec3::ONE);
                out.extend(face.map(|at| Corner { at, color }));
            }
        }
    }
}
