//! The motion that a creature's bones make: what a creature from a file gives to everything that takes a motion.

use glam::vec2;

use super::{Creature, CreatureLimb};
use crate::motion::{Motion, Track, TrackFrame, TrackKind};

impl Creature {
    /// One stroke track a limb: where its bones are in the clip's image in every frame, from the drawn stroke's start
    /// to its end. Everything counts as seen and certain.
    pub fn motion(&self) -> Motion {
        let model = &self.model;
        let height = model.size.1 as f32;
        let poses: Vec<Vec<glam::Vec2>> = model
            .animation
            .iter()
            .map(|local| {
                let places = model.world(local).into_iter().map(|m| m.w_axis);
                places.map(|p| vec2(p.x, height - p.y)).collect()
            })
            .collect();
        let track = |limb: &CreatureLimb| Track {
            name: limb.label.clone(),
            kind: TrackKind::Stroke,
            frames: poses
                .iter()
                .map(|pose| {
                    let mut points = pose[limb.bone_range()].to_vec();
                    if limb.reversed {
                        points.reverse();
                    }
                    TrackFrame::certain(points)
                })
                .collect(),
        };
        let joined = |limb: &CreatureLimb| limb.parent.map(|p| (self.limbs[p.limb].label.clone(), limb.label.clone()));
        Motion {
            size: model.size,
            fps: model.fps,
            frames: model.animation.len(),
            tracks: self.limbs.iter().map(track).collect(),
            bones: self.limbs.iter().filter_map(joined).collect(),
        }
    }
}
