//! How hard an animation pulls a creature's limbs: what tells a torn or folded pose from a good one.

use super::{Creature, chain};

/// A limb over all frames.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LimbStrain {
    /// The limb's label.
    pub limb: String,
    /// Its least length in space, as a share of its length.
    pub shortest: f32,
    /// Its greatest length in space, as a share of its length.
    pub longest: f32,
    /// The most that a bone turns against the one before it, in degrees.
    pub sharpest: f32,
    /// The farthest that it comes away from the joint that holds it in the rest pose, in clip pixels.
    pub gap: f32,
}

impl Creature {
    /// How hard the animation pulls each limb, in the limbs' order.
    pub fn strain(&self) -> Vec<LimbStrain> {
        let model = &self.model;
        let blank = |limb: &super::CreatureLimb| LimbStrain {
            limb: limb.label.clone(),
            shortest: f32::INFINITY,
            longest: 0.0,
            sharpest: 0.0,
            gap: 0.0,
        };
        let mut out: Vec<LimbStrain> = self.limbs.iter().map(blank).collect();
        for local in &model.animation {
            let placed = chain::all_world(&model.bones, local);
            for (limb, strain) in self.limbs.iter().zip(&mut out) {
                let places: Vec<glam::Vec3> = placed[limb.bone_range()].iter().map(|p| p.0).collect();
                let length = chain::length(&places) / limb.length.max(f32::MIN_POSITIVE);
                strain.shortest = strain.shortest.min(length);
                strain.longest = strain.longest.max(length);
                let turn = |p: &[glam::Vec3]| (p[1] - p[0]).angle_between(p[2] - p[1]);
                let sharpest = places.windows(3).map(turn).filter(|t| t.is_finite()).fold(0.0, f32::max);
                strain.sharpest = strain.sharpest.max(sharpest.to_degrees());
                if model.bones[limb.first_bone].parent.is_some() {
                    let (now, rest) = (local[limb.first_bone], model.rest[limb.first_bone]);
                    strain.gap = strain.gap.max(now.translation.distance(rest.translation));
                }
            }
        }
        out
    }
}
