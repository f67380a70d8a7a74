//! The limbs of a rigged model as curved coordinates of its surface: how far along a limb, how far across, how far
//! toward the viewer. Two limbs, or those of two creatures, are compared in them.
//!
//! A limb is a chain of bones "label.0", "label.1" and so on, as reconstruction names them; its axis goes through their
//! places in the rest pose. A bone that is named otherwise is a limb of its own.

use glam::Vec3;

use super::texels::Texels;
use crate::shape::RiggedModel;

/// Sections along a limb whose mean radius is measured.
const SECTIONS: usize = 24;

/// The label of the limb that a bone belongs to.
pub(super) fn label_of(bone: &str) -> &str {
    match bone.rsplit_once('.') {
        Some((label, number)) if !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()) => label,
        _ => bone,
    }
}

/// A place in a limb's coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct OnLimb {
    /// Along the axis as a share; outside 0..=1 beyond the ends.
    pub share: f32,
    /// World units from the axis: onward (at bends), across in the image plane, and toward the viewer.
    pub off: Vec3,
}

#[derive(Clone, Debug)]
pub(super) struct Limb {
    pub label: String,
    axis: Vec<Vec3>,
    /// Length up to each point of the axis.
    reach: Vec<f32>,
    /// Mean distance of the surface from the axis, section by section.
    radius: [f32; SECTIONS],
}

impl Limb {
    fn new(label: String, mut axis: Vec<Vec3>) -> Self {
        axis.dedup_by(|a, b| a.distance(*b) < 1e-3);
        let mut reach = vec![0.0];
        for p in axis.windows(2) {
            reach.push(reach.last().copied().unwrap_or(0.0) + p[0].distance(p[1]));
        }
        Self { label, axis, reach, radius: [0.0; SECTIONS] }
    }

    fn length(&self) -> f32 {
        self.reach.last().copied().unwrap_or(0.0).max(1e-3)
    }

    /// The axis and its direction in the image plane at a share.
    fn frame(&self, share: f32) -> (Vec3, Vec3) {
        let n = self.axis.len();
        if n < 2 {
            return (self.axis[0], Vec3::X);
        }
        let at = share * self.length();
        let k = self.reach[1..n - 1].iter().take_while(|r| **r <= at).count();
        let t = (at - self.reach[k]) / (self.reach[k + 1] - self.reach[k]);
        let place = self.axis[k] + (self.axis[k + 1] - self.axis[k]) * t;
        let way = |k: usize| (self.axis[(k + 1).min(n - 1)] - self.axis[k.saturating_sub(1)]).normalize_or_zero();
        let along = way(k).lerp(way(k + 1), t.clamp(0.0, 1.0));
        (place, along.with_z(0.0).try_normalize().unwrap_or(Vec3::X))
    }

    /// The coordinates of a place.
    pub(super) fn on(&self, p: Vec3) -> OnLimb {
        let (mut best, mut share) = (f32::INFINITY, 0.0);
        let last = self.axis.len().saturating_sub(2);
        for k in 0..self.axis.len().saturating_sub(1) {
            let way = self.axis[k + 1] - self.axis[k];
            let t = (p - self.axis[k]).dot(way) / way.length_squared();
            // Beyond its ends the axis goes straight on.
            let t = t.clamp(if k == 0 { -10.0 } else { 0.0 }, if k == last { 10.0 } else { 1.0 });
            let distance = p.distance_squared(self.axis[k] + way * t);
            if distance < best {
                best = distance;
                share = (self.reach[k] + t * way.length()) / self.length();
            }
        }
        let (center, along) = self.frame(share);
        let d = p - center;
        OnLimb { share, off: Vec3::new(d.dot(along), d.dot(across(along)), d.z) }
    }

    /// The place of coordinates.
    pub(super) fn place(&self, at: OnLimb) -> Vec3 {
        let (center, along) = self.frame(at.share);
        center + along * at.off.x + across(along) * at.off.y + Vec3::Z * at.off.z
    }

    /// The middle of the axis.
    pub(super) fn middle(&self) -> Vec3 {
        self.frame(0.5).0
    }

    /// The mean distance of the surface from the axis at a share.
    pub(super) fn radius(&self, share: f32) -> f32 {
        self.radius[section(share)]
    }
}

fn section(share: f32) -> usize {
    (share.clamp(0.0, 1.0) * (SECTIONS - 1) as f32).round() as usize
}

fn across(along: Vec3) -> Vec3 {
    Vec3::new(-along.y, along.x, 0.0)
}

/// All limbs of a model, and which one each texel is on.
pub(super) struct Limbs {
    pub list: Vec<Limb>,
    pub of_texel: Vec<u16>,
}

impl Limbs {
    pub(super) fn new(model: &RiggedModel, texels: &Texels) -> Self {
        let world = model.world(&model.rest);
        let mut labels: Vec<&str> = Vec::new();
        let mut axes: Vec<Vec<Vec3>> = Vec::new();
        let mut limb_of_bone = Vec::with_capacity(model.bones.len());
        for (bone, matrix) in model.bones.iter().zip(&world) {
            let label = label_of(&bone.name);
            let l = labels.iter().position(|l| *l == label).unwrap_or_else(|| {
                labels.push(label);
                axes.push(Vec::new());
                labels.len() - 1
            });
            axes[l].push(matrix.transform_point3(Vec3::ZERO));
            limb_of_bone.push(l as u16);
        }
        let mut list: Vec<Limb> = labels.iter().zip(axes).map(|(l, a)| Limb::new((*l).to_owned(), a)).collect();
        // The limb that moves a triangle most.
        let of_triangle: Vec<Vec<u16>> = model
            .parts
            .iter()
            .map(|part| {
                let strongest = |t: &[u32; 3]| {
                    let mut sums: Vec<(u16, f32)> = Vec::new();
                    for &v in t {
                        for (b, w) in part.bones[v as usize].iter().zip(part.weights[v as usize]) {
                            let l = limb_of_bone[usize::from(*b)];
                            match sums.iter_mut().find(|s| s.0 == l) {
                                Some(s) => s.1 += w,
                                None => sums.push((l, w)),
                            }
                        }
                    }
                    sums.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map_or(0, |s| s.0)
                };
                part.mesh.triangles.iter().map(strongest).collect()
            })
            .collect();
        let of_texel: Vec<u16> =
            texels.list.iter().map(|t| of_triangle[usize::from(t.part)][t.triangle as usize]).collect();
        let mut sums = vec![[(0.0f32, 0u32); SECTIONS]; list.len()];
        // Every few texels are enough for a mean.
        for i in (0..texels.len()).step_by(5) {
            let l = usize::from(of_texel[i]);
            let at = list[l].on(texels.rest[i]);
            let sum = &mut sums[l][section(at.share)];
            *sum = (sum.0 + at.off.y.hypot(at.off.z), sum.1 + 1);
        }
        for (limb, sums) in list.iter_mut().zip(sums) {
            let whole = sums.iter().fold((0.0, 0), |a, s| (a.0 + s.0, a.1 + s.1));
            let mean = |s: (f32, u32)| if s.1 > 0 { s.0 / s.1 as f32 } else { whole.0 / whole.1.max(1) as f32 };
            limb.radius = sums.map(|s| mean(s).max(0.5));
        }
        Self { list, of_texel }
    }

    pub(super) fn find(&self, label: &str) -> Option<usize> {
        self.list.iter().position(|l| l.label == label)
    }
}
