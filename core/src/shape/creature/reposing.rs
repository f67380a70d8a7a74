//! A creature's animation from key poses: as drawn on the keys, between them by turning bones against what they hang
//! from, so that limbs keep their lengths.
//!
//! Every limb has its own keys: one that a key does not draw is on its way between the keys that do.

use super::posing::{Key, Poser};
use super::{Creature, LimbPose, PoseKeys, PoseParams};
use crate::error::{Error, Result};
use crate::job::Stage;

impl Creature {
    /// The creature moving from key to key, over `frames` frames: up to the last key where none are given, and holding
    /// the last pose beyond it. Keys of a picture of the same shape and another size are scaled.
    ///
    /// # Errors
    /// What [`Creature::posed`] refuses, keys of a picture of another shape, or a cancel.
    pub fn reposed(
        &self,
        keys: &PoseKeys,
        frames: Option<usize>,
        params: &PoseParams,
        stage: Stage<'_>,
    ) -> Result<Creature> {
        stage.name("posing")?;
        keys.validate()?;
        let poser = Poser::new(self, params, false)?;
        let scale = self.scale_of(keys.size)?;
        let scaled: Vec<Vec<LimbPose>> =
            keys.keys.iter().map(|k| k.limbs.iter().map(|l| by(l, scale)).collect()).collect();
        let mut by_limb: Vec<Vec<Key<'_>>> = vec![Vec::new(); self.limbs.len()];
        for (key, limbs) in keys.keys.iter().zip(&scaled) {
            let drawn = poser.by_limb(limbs, &format!("the key pose of frame {}", key.frame))?;
            for (keys, pose) in by_limb.iter_mut().zip(drawn) {
                keys.extend(pose.map(|pose| Key { frame: key.frame, pose, easing: key.easing }));
            }
        }
        let frames = frames.unwrap_or_else(|| keys.keys.last().map_or(1, |k| k.frame.saturating_add(1)));
        if frames == 0 {
            return Err(Error::invalid("the number of frames", "is 0", "give at least 1"));
        }
        let animation = poser.animate(&by_limb, frames, keys.step, stage)?;
        let mut out = self.clone();
        out.model.animation = animation;
        out.model.fps = keys.fps.unwrap_or(self.model.fps);
        Ok(out)
    }

    /// What places in a picture of this size are multiplied by to be in the creature's clip.
    fn scale_of(&self, size: (u32, u32)) -> Result<f32> {
        let own = self.model.size;
        let (x, y) = (f64::from(own.0) / f64::from(size.0), f64::from(own.1) / f64::from(size.1));
        // A hundredth covers sizes that were rounded to even numbers.
        if !(x.is_finite() && y.is_finite() && (x / y - 1.0).abs() < 0.01) {
            return Err(Error::invalid(
                "the key poses",
                format!("are drawn on {}x{}, and the creature's clip is {}x{}", size.0, size.1, own.0, own.1),
                "draw them on the clip, or on a picture of its shape",
            ));
        }
        Ok(if size == own { 1.0 } else { x as f32 })
    }
}

fn by(pose: &LimbPose, scale: f32) -> LimbPose {
    LimbPose {
        points: pose.points.iter().map(|p| *p * scale).collect(),
        bend: pose.bend.map(|b| b * scale),
        depth: pose.depth * scale,
        ..pose.clone()
    }
}
