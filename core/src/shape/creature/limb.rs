//! One limb as a generalized cylinder: an axis in space over time and a cross-section at every sample.

use glam::{Vec2, Vec3, vec3};

use super::axis::Axis;
use super::radius::Radii;
use crate::rig::Side;

/// A limb, measured.
#[derive(Clone, Debug)]
pub(super) struct LimbShape {
    /// The user's name for it.
    pub label: String,
    /// Its side, where it is one of a pair.
    pub side: Option<Side>,
    /// The other of the pair.
    pub twin: Option<usize>,
    /// The limb it hangs from, and whether from that limb's end (else its start), counted from the root.
    pub parent: Option<(usize, bool)>,
    /// The thicker limb that it is part of where it begins, and whether that one ends there (else begins): a leg's is the
    /// body, whatever stroke the skeleton's root lies on.
    pub trunk: Option<(usize, bool)>,
    /// Whether other limbs are joined to its start and to its end.
    pub joined: (bool, bool),
    /// The axis in the image.
    pub axis: Axis,
    /// The axis' depth toward the viewer, `[frame][sample]`.
    pub z: Vec<Vec<f32>>,
    /// How far toward the viewer its end stands from its start in every frame.
    pub rise: Vec<f32>,
    /// How far its free part stands from where it would in every frame, toward the viewer.
    pub depth: Vec<f32>,
    /// How far beyond its hip it stands from what it hangs from, toward the viewer.
    pub offset: f32,
    /// Radii in the image plane.
    pub radii: Radii,
    /// Half depth over half width at every sample.
    pub depth_ratio: Vec<f32>,
    /// Height of the clip, to turn image places into world places.
    pub clip_height: f32,
}

impl LimbShape {
    /// The axis at a fractional sample of a frame, in world coordinates.
    pub(super) fn place(&self, frame: usize, sample: f32) -> Vec3 {
        let (points, z) = (&self.axis.frames[frame], &self.z[frame]);
        let sample = sample.clamp(0.0, (points.len() - 1) as f32);
        let i = (sample as usize).min(points.len().saturating_sub(2));
        let j = (i + 1).min(points.len() - 1);
        let share = sample - i as f32;
        let p = points[i].lerp(points[j], share);
        vec3(p.x, self.clip_height - p.y, z[i] + (z[j] - z[i]) * share)
    }

    /// The stroke itself in a frame, from the end nearer to the root, in world coordinates.
    pub(super) fn curve(&self, frame: usize) -> Vec<Vec3> {
        (self.axis.first..=self.axis.last).map(|i| self.place(frame, i as f32)).collect()
    }

    /// The mean radius along the stroke.
    pub(super) fn mean_radius(&self) -> f32 {
        self.mean_radius_from(0.0)
    }

    /// The mean radius from `share` of the stroke to its end.
    pub(super) fn mean_radius_from(&self, share: f32) -> f32 {
        let from = self.axis.first + ((self.axis.last - self.axis.first) as f32 * share) as usize;
        let range = from..=self.axis.last;
        let count = range.clone().count().max(1) as f32;
        range.map(|i| self.half_width(i)).sum::<f32>() / count
    }

    /// Half the width at a sample.
    pub(super) fn half_width(&self, sample: usize) -> f32 {
        (self.radii.left[sample] + self.radii.right[sample]) / 2.0
    }

    /// How far the middle of the cross-section is from the axis, along the normal.
    pub(super) fn shift(&self, sample: usize) -> f32 {
        (self.radii.left[sample] - self.radii.right[sample]) / 2.0
    }

    /// Unit normals of the axis in the image plane of one frame, image coordinates.
    pub(super) fn normals(&self, frame: usize) -> Vec<Vec2> {
        super::axis::normals(&self.axis.frames[frame])
    }
}
