//! What solved limbs cover in every frame, so that those behind them do not take their pixels.

use glam::Vec2;

use super::footage::Footage;
use super::strip::CLAIM_CELL;
use crate::raster::Mask;

/// Share of the half width that surely belongs to the limb.
const CORE: f32 = 0.9;

/// One coarse mask a frame.
#[derive(Clone, Debug)]
pub(super) struct Claims {
    masks: Vec<Mask>,
}

impl Claims {
    pub(super) fn new(footage: &Footage) -> Self {
        Self { masks: footage.lab.iter().map(|_| Self::blank(footage)).collect() }
    }

    pub(super) fn frame(&self, frame: usize) -> &Mask {
        &self.masks[frame]
    }

    /// Adds one limb: a disc of its half width along every edge.
    pub(super) fn cover(&mut self, poses: &[Vec<Vec2>], radii: &[f32]) {
        for (mask, pose) in self.masks.iter_mut().zip(poses) {
            cover(mask, pose, radii);
        }
    }

    /// An empty mask of one frame's size.
    pub(super) fn blank(footage: &Footage) -> Mask {
        let cells = |n: u32| (n as f32 / CLAIM_CELL).ceil() as usize;
        Mask::new(cells(footage.size.0), cells(footage.size.1))
    }
}

/// Adds one pose to a mask.
pub(super) fn cover(mask: &mut Mask, pose: &[Vec2], radii: &[f32]) {
    for e in 0..pose.len() - 1 {
        // Discs half a radius apart leave no notch that matters.
        let step = (0.5 * radii[e].min(radii[e + 1])).max(CLAIM_CELL);
        let steps = (pose[e].distance(pose[e + 1]) / step).ceil().clamp(1.0, 200.0) as usize;
        for s in 0..=steps {
            let share = s as f32 / steps as f32;
            let centre = pose[e].lerp(pose[e + 1], share) / CLAIM_CELL;
            disc(mask, centre, (radii[e] + (radii[e + 1] - radii[e]) * share) * CORE / CLAIM_CELL);
        }
    }
}

fn disc(mask: &mut Mask, centre: Vec2, radius: f32) {
    let (w, h) = (mask.width() as f32, mask.height() as f32);
    let rows = (centre.y - radius).clamp(0.0, h) as usize..(centre.y + radius).ceil().clamp(0.0, h) as usize;
    for y in rows {
        let dy = y as f32 + 0.5 - centre.y;
        let half = (radius * radius - dy * dy).max(0.0).sqrt();
        let columns = (centre.x - half).clamp(0.0, w) as usize..(centre.x + half).ceil().clamp(0.0, w) as usize;
        mask.fill(y, columns);
    }
}
