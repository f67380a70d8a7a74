//! The motion that a creature's bones make: what a creature from a file gives to everything that takes a motion.

use glam::{Vec2, Vec3, vec2};

use super::chain::{self, Placed};
use super::{Creature, CreatureLimb};
use crate::motion::{Motion, Track, TrackFrame, TrackKind};

impl Creature {
    /// One stroke track a limb: the stroke along which its bones lie in the clip's image in every frame, as it would be
    /// drawn, from start to end; posing along it brings the bones back. Everything counts as seen and certain.
    pub fn motion(&self) -> Motion {
        let model = &self.model;
        let height = model.size.1 as f32;
        let poses: Vec<Vec<Placed>> = model.animation.iter().map(|l| chain::all_world(&model.bones, l)).collect();
        let track = |limb: &CreatureLimb| Track {
            name: limb.label.clone(),
            kind: TrackKind::Stroke,
            frames: poses
                .iter()
                .map(|pose| {
                    let curve = through(&pose[limb.bone_range()]);
                    let mut points: Vec<Vec2> = curve.into_iter().map(|p| vec2(p.x, height - p.y)).collect();
                    limb.settle(&mut points, true);
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

/// Points from one bone to the next.
const STEPS: usize = 4;

/// A curve through all bones in their directions: cubic Hermite pieces.
fn through(bones: &[Placed]) -> Vec<Vec3> {
    let piece = |pair: &[Placed], step: usize| {
        let t = step as f32 / STEPS as f32;
        let ((a, from), (b, to)) = (pair[0], pair[1]);
        let way = Vec3::X * a.distance(b);
        let (t2, t3) = (t * t, t * t * t);
        a * (2.0 * t3 - 3.0 * t2 + 1.0)
            + b * (3.0 * t2 - 2.0 * t3)
            + from * way * (t3 - 2.0 * t2 + t)
            + to * way * (t3 - t2)
    };
    let pieces = bones.windows(2).flat_map(|pair| (0..STEPS).map(move |step| piece(pair, step)));
    pieces.chain(bones.last().map(|(end, _)| *end)).collect()
}
