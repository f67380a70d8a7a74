//! What the camera did between two frames: the affine motion that most of the picture agrees on.
//!
//! An animal that walks through a panning shot stays where it is in the picture; one that is followed past a hill does
//! not move as the pixels say. Inertia is of the world, so limbs that hang on nothing are judged against the ground.
//! Iteratively re-weighted least squares on dense flow (Geman and McClure's weights, their scale lowered to the median
//! residual), from the median flow.
//!
//! Known limits: no parallax; an animal that fills most of the picture is taken for the ground.

use glam::{Affine2, DMat3, DVec3, Vec2};

use super::median::median;
use crate::track::flow::FlowField;

/// Places looked at, along either side of the picture.
const PLACES: usize = 24;
/// Rounds of re-weighting.
const ROUNDS: usize = 12;
/// Forward-backward disagreement and residual in pixels that are noise at any scale.
const NOISE: f32 = 0.5;

/// The camera's motion along `flow` (`back` leads back): maps a place of the ground to where it is in the other frame.
pub(in crate::track) fn camera_motion(flow: &FlowField, back: &FlowField) -> Affine2 {
    let size = flow.size();
    let moves: Vec<(Vec2, Vec2, f32)> = (0..PLACES * PLACES)
        .map(|i| {
            let share = Vec2::new((i % PLACES) as f32 + 0.5, (i / PLACES) as f32 + 0.5) / PLACES as f32;
            let place = share * size;
            let motion = flow.at(place);
            let miss = (motion + back.at(place + motion)).length() / NOISE;
            (place, motion, 1.0 / (1.0 + miss * miss))
        })
        .collect();
    let mut camera = Affine2::from_translation(Vec2::new(
        median(moves.iter().map(|m| m.1.x).collect()),
        median(moves.iter().map(|m| m.1.y).collect()),
    ));
    // Places from the picture's centre, in units of its size, keep the normal equations well conditioned.
    let (centre, unit) = (0.5 * size, size.max_element());
    for _ in 0..ROUNDS {
        let residual =
            |(place, motion, _): &(Vec2, Vec2, f32)| (camera.transform_point2(*place) - *place).distance(*motion);
        let scale = median(moves.iter().map(residual).collect()).max(NOISE);
        let (mut normal, mut right) = (DMat3::ZERO, [DVec3::ZERO; 2]);
        for m in &moves {
            let share = residual(m) / scale;
            let weight = f64::from(m.2 / (1.0 + share * share).powi(2));
            let at = ((m.0 - centre) / unit).extend(1.0).as_dvec3();
            normal += DMat3::from_cols(at * at.x, at * at.y, at * at.z) * weight;
            right[0] += at * (weight * f64::from(m.1.x));
            right[1] += at * (weight * f64::from(m.1.y));
        }
        if normal.determinant().abs() < 1e-9 {
            break;
        }
        let inverse = normal.inverse();
        let [x, y] = right.map(|r| (inverse * r).as_vec3());
        let slope = glam::Mat2::from_cols(Vec2::new(x.x, y.x) / unit, Vec2::new(x.y, y.y) / unit);
        let motion = Vec2::new(x.z, y.z) - slope * centre;
        camera = Affine2::from_mat2_translation(glam::Mat2::IDENTITY + slope, motion);
    }
    camera
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn the_ground_moves_as_the_camera_says_whatever_the_animal_does() {
        let truth = Affine2::from_scale_angle_translation(Vec2::splat(1.02), 0.01, vec2(-3.0, 1.5));
        let animal = |p: Vec2| (p - vec2(90.0, 60.0)).length() < 40.0;
        let motion = |p: Vec2| if animal(p) { vec2(4.0, 0.0) } else { truth.transform_point2(p) - p };
        let inverse = truth.inverse();
        let back = |p: Vec2| {
            if animal(p - vec2(4.0, 0.0)) { vec2(-4.0, 0.0) } else { inverse.transform_point2(p) - p }
        };
        let camera = camera_motion(&FlowField::from_fn(180, 120, motion), &FlowField::from_fn(180, 120, back));
        for p in [vec2(5.0, 5.0), vec2(170.0, 20.0), vec2(20.0, 110.0), vec2(90.0, 60.0)] {
            assert!(camera.transform_point2(p).distance(truth.transform_point2(p)) < 0.1, "{p}");
        }
    }
}
