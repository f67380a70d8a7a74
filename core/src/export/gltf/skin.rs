//! The skin of a glTF file: inverse bind matrices, and joints and weights as the format wants them.

use glam::{DMat4, DQuat, DVec3};

use crate::shape::{RiggedModel, SkinnedPart};

/// For every bone the matrix that takes a vertex of the rest pose into the bone's own space, column by column.
/// Computed in doubles; its last row is exactly (0, 0, 0, 1), which readers insist on.
pub(super) fn inverse_bind_matrices(model: &RiggedModel, scale: f32) -> Vec<[f32; 16]> {
    let mut world: Vec<(DQuat, DVec3)> = Vec::with_capacity(model.bones.len());
    for (bone, rest) in model.bones.iter().zip(&model.rest) {
        let own = (rest.rotation.as_dquat().normalize(), rest.translation.as_dvec3() * f64::from(scale));
        let placed = bone.parent.map_or(own, |p| (world[p].0 * own.0, world[p].1 + world[p].0 * own.1));
        world.push(placed);
    }
    world
        .iter()
        .map(|(rotation, translation)| {
            let back = rotation.normalize().conjugate();
            DMat4::from_rotation_translation(back, back * -*translation).as_mat4().to_cols_array()
        })
        .collect()
}

/// Joints and weights of all vertices: heaviest first, every joint once, weights that add up to 1, and joint 0 where
/// there is no weight.
pub(super) fn influences(part: &SkinnedPart) -> (Vec<[u16; 4]>, Vec<[f32; 4]>) {
    part.bones.iter().zip(&part.weights).map(|(bones, weights)| influence(*bones, *weights)).unzip()
}

fn influence(bones: [u16; 4], weights: [f32; 4]) -> ([u16; 4], [f32; 4]) {
    let mut merged: [(f64, u16); 4] = [(0.0, 0); 4];
    let mut used = 0;
    for (bone, weight) in bones.into_iter().zip(weights).filter(|(_, w)| *w > 0.0) {
        match merged[..used].iter_mut().find(|m| m.1 == bone) {
            Some(known) => known.0 += f64::from(weight),
            None => {
                merged[used] = (f64::from(weight), bone);
                used += 1;
            }
        }
    }
    merged[..used].sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let sum: f64 = merged.iter().map(|m| m.0).sum();
    let mut shares = merged.map(|m| (m.0 / sum) as f32);
    // What rounding left over goes where it shows least.
    shares[0] = 1.0 - shares[1..].iter().sum::<f32>();
    for (share, m) in shares.iter().zip(&mut merged) {
        if *share == 0.0 {
            m.1 = 0;
        }
    }
    (merged.map(|m| m.1), shares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn weights_add_up_and_joints_are_used_once(
            bones in prop::array::uniform4(0u16..5),
            weights in prop::array::uniform4(prop_oneof![Just(0f32), 1e-7f32..1.0]),
        ) {
            prop_assume!(weights.iter().sum::<f32>() > 0.0);
            let (joints, shares) = influence(bones, weights);
            prop_assert!((shares.iter().sum::<f32>() - 1.0).abs() <= 2e-7);
            let total: f32 = weights.iter().sum();
            for joint in 0..5u16 {
                let given: f32 = bones.iter().zip(weights).filter(|(b, _)| **b == joint).map(|(_, w)| w).sum();
                let held: Vec<f32> =
                    joints.iter().zip(shares).filter(|(j, s)| **j == joint && *s > 0.0).map(|(_, s)| s).collect();
                prop_assert!(held.len() <= 1);
                prop_assert!((held.iter().sum::<f32>() - given / total).abs() < 1e-6);
            }
            prop_assert!(joints.iter().zip(shares).all(|(j, s)| s >= 0.0 && (s > 0.0 || *j == 0)));
        }
    }
}
