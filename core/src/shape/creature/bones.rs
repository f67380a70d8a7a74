//! The bone hierarchy of a creature and its animation.
//!
//! Every limb has a few bones, evenly along its stroke. A bone stands on the axis and points along it, so a surface
//! point that is shared by linear weights between the two bones around it follows a smooth curve through all bones with
//! the right tangents, and stretches with the limb without scaling. Limbs hang from the bone of their parent limb that
//! is nearest to where they are joined.

use super::chain::{self, Placed};
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
    let mut world: Vec<Vec<Placed>> = vec![Vec::new(); frames];
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
        }
        for (f, world) in world.iter_mut().enumerate() {
            world.extend(chain::along(&limb.curve(f), count));
        }
    }
    let local = |w: &Vec<Placed>| {
        out.bones.iter().enumerate().map(|(b, bone)| chain::local(w[b], bone.parent.map(|p| w[p]))).collect()
    };
    out.animation = world.iter().map(local).collect();
    chain::keep_signs(&mut out.animation);
    out
}

/// About one bone for every 1.2 widths of the limb, four at least.
fn bone_count(limb: &LimbShape, max_bones: usize) -> usize {
    let wanted = limb.axis.length / (2.4 * limb.mean_radius()).max(8.0);
    (wanted.round() as usize).clamp(4, max_bones.max(4))
}

/// Where along the limb's chain of `count` bones a sample lies: two bones and the second one's weight.
pub(super) fn bone_weights(limb: &LimbShape, sample: f32, count: usize) -> (usize, usize, f32) {
    let t = (limb.axis.share(sample) * (count - 1) as f32).clamp(0.0, (count - 1) as f32);
    let k = (t.floor() as usize).min(count.saturating_sub(2));
    (k, (k + 1).min(count - 1), t - k as f32)
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
