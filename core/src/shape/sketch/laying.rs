//! A motion laid on a drawing: what moves is cut out of the clip, its contour and the drawing's outline are laid on each other,
//! and the tracked points are carried over.

use glam::Vec2;
use serde_json::json;

use super::placing::{bind_automatically, control_points, most_telling_frame};
use super::{Binding, Drawing, Outline};
use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::motion::Motion;
use crate::segment::grab_cut;

/// What to lay on what.
#[derive(Clone, Copy, Debug)]
pub struct Laying<'a> {
    /// The drawing.
    pub drawing: &'a Drawing,
    /// The motion.
    pub motion: &'a Motion,
    /// What to call the motion in the binding.
    pub name: &'a str,
    /// The clip that the motion was tracked in; without it and a contour the points alone suggest a figure.
    pub clip: Option<&'a Clip>,
    /// The frame of the motion that the drawing is like; without it the one in which they are known best.
    pub frame: Option<usize>,
    /// The contour of what moves in that frame, where a person drew it, in clip pixels.
    pub contour: Option<&'a [Vec2]>,
    /// The outline of the drawing, where a person drew it, in its pixels.
    pub outline: Option<&'a [Vec2]>,
    /// Whether the drawing faces the other way, where that is known.
    pub mirror: Option<bool>,
}

/// A motion laid on a drawing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Laid {
    /// The proposal.
    pub binding: Binding,
    /// How far each of its points is to be trusted, 0..=1.
    pub confidence: Vec<f32>,
    /// What a person should know, one sentence each.
    pub warnings: Vec<String>,
}

/// Below this a place is worth a look.
const DOUBTFUL: f32 = 0.5;

impl Laying<'_> {
    /// Lays the motion on the drawing.
    ///
    /// # Errors
    /// The motion has no such frame, or not enough points; the drawing shows nothing; the clip is of another size than the
    /// motion, or one of its frames cannot be read; an outline that is none; a cancel.
    pub fn lay(&self, stage: Stage<'_>) -> Result<Laid> {
        let motion = self.motion;
        let frame = self.frame.unwrap_or_else(|| most_telling_frame(motion));
        if frame >= motion.frames {
            let problem = format!("the motion has {} frames", motion.frames);
            return Err(Error::invalid(format!("frame {frame}"), problem, "frames count from 0"));
        }
        let mut warnings = Vec::new();
        let outline = match self.outline {
            Some(corners) => Outline::given(corners)?,
            None => self.drawing.outline(None, &stage.part(0.0, 0.3))?,
        };
        if outline.apart > 0 {
            warnings.push(format!("{} figures of the drawing lie apart from its outline", outline.apart));
        }
        let found;
        let contour = match (self.contour, self.clip) {
            (Some(contour), _) => Some(contour),
            (None, Some(clip)) => {
                found = self.contour_in(clip, frame, stage.part(0.3, 0.7))?;
                Some(&found[..])
            }
            (None, None) => None,
        };
        let object = contour.map(|contour| (frame, contour));
        let stage = stage.part(0.7, 1.0);
        let (mut binding, confidence) =
            bind_automatically(self.drawing.size, &outline.polygon, motion, object, self.mirror, stage)?;
        for used in &mut binding.motions {
            used.name = self.name.to_owned();
        }
        for (point, confidence) in binding.points.iter().zip(&confidence).filter(|(_, c)| **c < DOUBTFUL) {
            warnings
                .push(format!("where `{}` holds the drawing is a guess ({confidence:.1}); look at it", point.track));
        }
        Ok(Laid { binding, confidence, warnings })
    }

    fn contour_in(&self, clip: &Clip, frame: usize, stage: Stage<'_>) -> Result<Vec<Vec2>> {
        let info = clip.info();
        if (info.width, info.height) != self.motion.size || frame >= info.frames {
            let problem = format!(
                "is {}x{} pixels and {} frames; the motion is of {}x{} and {}",
                info.width, info.height, info.frames, self.motion.size.0, self.motion.size.1, self.motion.frames
            );
            return Err(Error::invalid("clip", problem, "give the one that the motion was tracked in"));
        }
        let places: Vec<Vec2> = control_points(self.motion, frame).iter().map(|p| p.at).collect();
        let mask = grab_cut::object_mask(&*clip.frame(frame)?, &places, &[], stage)?;
        Ok(grab_cut::object_contour(&mask))
    }
}

impl Laid {
    /// What there is to say of it, as JSON.
    pub fn to_json(&self) -> String {
        let point = |(point, confidence): (&super::BindPoint, &f32)| json!({ "track": point.track, "index": point.index, "at": point.at, "confidence": confidence });
        let points: Vec<_> = self.binding.points.iter().zip(&self.confidence).map(point).collect();
        let motion = self.binding.motions.first();
        json!({
            "frame": motion.map(|m| m.frame), "mirror": motion.map(|m| m.mirror), "scale": motion.map(|m| m.scale),
            "points": points, "warnings": self.warnings,
        })
        .to_string()
    }
}
