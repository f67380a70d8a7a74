//! The bone hierarchy of a creature and its animation.
//!
//! Every limb has a few bones, evenly along its stroke. A bone stands on the axis and points along it, so a surface
//! point that is shared by linear weights between the two bones around it follows a smooth curve through all bones with
//! the right tangents, and stretches with the limb without scaling. Limbs hang from the bone of their parent limb that
//! is nearest to where they are joined.

use glam::{Quat, Vec3};

use super::limb::LimbShape;
use crate::shape::{Bone, Transform};

/// The bones of all limbs.
#[derive(Clone, Debug, Default)]
pub(super) struct Bones {
    /// The hierarchy, parents before children.
    pub bones: Vec<Bone>,
    /// For each limb its bones from the root outward.
    pub of_limb: Vec<Vec<usize>>,
    /// `[frame][bone]`, relative to the parent.
    pub animation: Vec<Vec<Transform>>,
}

/// Lays bones along all limbs. `order` lists the limbs, parents before children.
pub(super) fn lay(limbs: &[LimbShape], order: &[usize], frames: usize, max_bones: usize) -> Bones {
    let mut out = Bones { of_limb: vec![Vec::new(); limbs.len()], ..Bones::default() };
    // World pose of every bone: place and direction.
    let mut world: Vec<Vec<(Vec3, Quat)>> = vec![Vec::new(); frames];
    for &l in order {
        let limb = &limbs[l];
        let count = bone_count(limb, max_bones);
        for k in 0..count {
            let parent = if k > 0 {
                Some(out.bones.len() - 1)
            } else {
                limb.parent.and_then(|(p, at_end)| {
                    let chain = &out.of_limb[p];
                    if at_end { chain.last() } else { chain.first() }.copied()
                })
            };
            out.of_limb[l].push(out.bones.len());
            out.bones.push(Bone { name: format!("{}.{k}", limb.label), parent });
            let at = bone_sample(limb, k, count);
            for (f, world) in world.iter_mut().enumerate() {
                world.push((limb.place(f, at), direction(limb, f, at)));
            }
        }
    }
    let local = |(place, turn): (Vec3, Quat), parent: Option<(Vec3, Quat)>| match parent {
        None => Transform { translation: place, rotation: turn },
        Some((from, base)) => {
            let back = base.inverse();
            Transform { translation: back * (place - from), rotation: (back * turn).normalize() }
        }
    };
    out.animation = world
        .iter()
        .map(|w| out.bones.iter().enumerate().map(|(b, bone)| local(w[b], bone.parent.map(|p| w[p]))).collect())
        .collect();
    for b in 0..out.bones.len() {
        // q and -q are one rotation, but an importer that blends between frames takes the way that the signs say.
        for f in 1..frames {
            if out.animation[f][b].rotation.dot(out.animation[f - 1][b].rotation) < 0.0 {
                out.animation[f][b].rotation = -out.animation[f][b].rotation;
            }
        }
    }
    out
}

/// About one bone for every 1.2 widths of the limb, four at least.
fn bone_count(limb: &LimbShape, max_bones: usize) -> usize {
    let wanted = limb.axis.length / (2.4 * limb.mean_radius()).max(8.0);
    (wanted.round() as usize).clamp(4, max_bones.max(4))
}

/// The sample at which bone `k` of `count` stands.
fn bone_sample(limb: &LimbShape, k: usize, count: usize) -> f32 {
    limb.axis.first as f32 + (limb.axis.last - limb.axis.first) as f32 * k as f32 / (count - 1).max(1) as f32
}

/// Where along the limb's chain of `count` bones a sample lies: two bones and the second one's weight.
fn bone_weights(limb: &LimbShape, sample: f32, count: usize) -> (usize, usize, f32) {
    let t = (limb.axis.share(sample) * (count - 1) as f32).clamp(0.0, (count - 1) as f32);
    let k = (t.floor() as usize).min(count.saturating_sub(2));
    (k, (k + 1).min(count - 1), t - k as f32)
}

/// The turn that takes +x to the limb's direction and leaves +y in the image plane, so that limbs never roll.
fn direction(limb: &LimbShape, frame: usize, sample: f32) -> Quat {
    let reach = (limb.axis.last - limb.axis.first) as f32 * 0.06;
    let (low, high) = (limb.axis.first as f32, limb.axis.last as f32);
    let along = limb.place(frame, (sample + reach).min(high)) - limb.place(frame, (sample - reach).max(low));
    frame_along(along)
}

/// The rotation of a bone that points along `along`.
fn frame_along(along: Vec3) -> Quat {
    let Some(x) = along.try_normalize() else { return Quat::IDENTITY };
    let flat = Vec3::new(-x.y, x.x, 0.0);
    let Some(y) = flat.try_normalize() else {
        return Quat::from_rotation_y(-x.z.signum() * std::f32::consts::FRAC_PI_2);
    };
    Quat::from_mat3(&glam::Mat3::from_cols(x, y, x.cross(y))).normalize()
}

/// Bones and weights of vertices at these samples of a limb with this chain of bones.
pub(super) fn bind(limb: &LimbShape, samples: &[f32], chain: &[usize]) -> (Vec<[u16; 4]>, Vec<[f32; 4]>) {
    samples
        .iter()
        .map(|&s| {
            let (a, b, share) = bone_weights(limb, s, chain.len());
            let bone = |k: usize, weight: f32| if weight > 0.0 { chain[k] as u16 } else { 0 };
            ([bone(a, 1.0 - share), bone(b, share), 0, 0], [1.0 - share, share, 0.0, 0.0])
        })
        .unzip()
}
