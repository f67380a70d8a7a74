//! The built-in segmenter: reads the clip at working size, finds the masks, and brings them to the clip's size.
//!
//! A clip with opacity is taken at its word: one that is mostly transparent is a cut-out, and what is opaque by half
//! is the mask; in any other, nothing transparent is creature. What the user painted overrides everything.

use super::painted::Painted;
use super::params::{Method, SegmentParams};
use super::refine::refine;
use super::scene::Scene;
use super::working::{Limbs, SPACING, Working, for_batches};
use super::{Segmenter, layered, paper};
use crate::clip::{Clip, Picture};
use crate::error::Result;
use crate::job::Stage;
use crate::motion::Motion;
use crate::raster::Mask;
use crate::rig::Rig;

/// Cuts a creature out of its clip along its tracked strokes.
#[derive(Clone, Debug, Default)]
pub struct CostVolumeSegmenter {
    /// How.
    pub params: SegmentParams,
}

impl Segmenter for CostVolumeSegmenter {
    fn segment(&self, clip: &Clip, rig: &Rig, motion: &Motion, stage: Stage<'_>) -> Result<Vec<Mask>> {
        let info = clip.info();
        rig.validate(Some(((info.width, info.height), info.frames)))?;
        let painted = Painted::read(rig)?;
        let working = Working::read(clip, self.params.working_side, stage.part(0.0, 0.15))?;
        if let Some(mut masks) = working.cut_out() {
            masks.iter_mut().enumerate().for_each(|(frame, mask)| painted.apply(frame, mask));
            stage.at(1.0)?;
            return Ok(masks);
        }
        let small = match self.params.method {
            Method::Layered => {
                let limbs = Limbs::new(rig, motion, working.scale, info.frames, SPACING);
                let scene = Scene::new(&working, &limbs, &self.params, &painted, stage.part(0.15, 0.2))?;
                layered::masks(&scene, stage.part(0.2, 0.85))?
            }
            Method::Paper => {
                let limbs = Limbs::new(rig, motion, working.scale, info.frames, 1.0);
                paper::masks(&working, &limbs, &self.params.paper, stage.part(0.15, 0.85))?
            }
        };
        let mut masks = Vec::with_capacity(info.frames);
        let finish = |frame: usize, picture: &Picture| {
            let mut mask = refine(&picture.rgb, &small[frame]);
            if let Some(opaque) = &working.opaque[frame] {
                mask.intersect(opaque);
            }
            painted.apply(frame, &mut mask);
            Ok(mask)
        };
        for_batches(clip, stage.part(0.85, 1.0), finish, &mut masks)?;
        Ok(masks)
    }
}
