//! What a host can change about a session. Each call is a gesture of its own, or part of the one in progress, and says
//! what it put out of date.
//!
//! Limbs count from 0 in the rig's order. A call that fails changes nothing.

use std::path::Path;
use std::sync::Arc;

use glam::Vec2;

use super::Session;
use super::clip_reference::ClipReference;
use super::document::{Inputs, Tracked};
use super::edit::{Drawn, Edit};
use super::outdated::Outdated;
use super::parameters::Value;
use super::part::{Part, PartKind};
use crate::error::{Error, Result};
use crate::motion::Motion;
use crate::rig::{Facing, Limb, LimbDepth, Paint, Rig, Side};

impl Session {
    /// Chooses the clip, or none. As long as nothing is drawn the rig takes the clip's size; what is drawn keeps the
    /// size that it was drawn on.
    ///
    /// # Errors
    /// It could not be written.
    pub fn set_clip(&mut self, clip: Option<ClipReference>) -> Result<Outdated> {
        let rig = &self.document.inputs.rig;
        let size = clip.as_ref().filter(|_| rig.keyframes.is_empty()).map_or(rig.size, |clip| clip.size);
        self.edit("choose the clip", Edit::Clip { clip: clip.map(Arc::new), size })
    }

    /// Replaces everything that is drawn.
    ///
    /// # Errors
    /// The rig is not well-formed ([`Rig::validate_draft`]).
    pub fn set_rig(&mut self, rig: Rig) -> Result<Outdated> {
        self.edit("replace the strokes", Edit::Rig(Arc::new(rig)))
    }

    /// Adds a limb behind the others, without a stroke yet.
    ///
    /// # Errors
    /// The label is empty or taken, or there are too many.
    pub fn add_limb(&mut self, label: &str, side: Option<Side>) -> Result<Outdated> {
        let limb = Limb { label: label.to_owned(), side };
        let at = self.document.inputs.rig.limbs.len();
        self.edit(&format!("add `{label}`"), Edit::InsertLimb { at, limb, strokes: Vec::new(), depths: Vec::new() })
    }

    /// Removes a limb with its strokes; those behind it move down.
    ///
    /// # Errors
    /// There is no such limb.
    pub fn remove_limb(&mut self, limb: usize) -> Result<Outdated> {
        self.edit(&format!("remove `{}`", self.label(limb)), Edit::RemoveLimb { at: limb })
    }

    /// Gives a limb another label or side. Its track, where it has one, goes with the label.
    ///
    /// # Errors
    /// There is no such limb, or the label is empty or taken.
    pub fn set_limb(&mut self, limb: usize, label: &str, side: Option<Side>) -> Result<Outdated> {
        let old = self.label(limb);
        let new = Limb { label: label.to_owned(), side };
        let relabelled = self.document.tracked.as_ref().and_then(|tracked| relabel(tracked, &old, label));
        self.in_one(&format!("change `{old}`"), |session| {
            session.edit("", Edit::Limb { at: limb, limb: new })?;
            if relabelled.is_some() {
                session.edit("", Edit::Tracked(relabelled))?;
            }
            Ok(())
        })
    }

    /// Draws a limb on a frame, in clip pixels from its start to its end, instead of what was drawn of it there.
    ///
    /// # Errors
    /// There is no such limb, or the points make no stroke.
    pub fn set_stroke(
        &mut self,
        limb: usize,
        frame: usize,
        points: Vec<Vec2>,
        facing: Option<Facing>,
    ) -> Result<Outdated> {
        let label = format!("draw `{}` on frame {frame}", self.label(limb));
        self.edit(&label, Edit::Stroke { limb, frame, drawn: Some(Drawn { points, facing }) })
    }

    /// Takes a limb's stroke off a frame, where there is one.
    ///
    /// # Errors
    /// There is no such limb.
    pub fn remove_stroke(&mut self, limb: usize, frame: usize) -> Result<Outdated> {
        let label = format!("wipe `{}` off frame {frame}", self.label(limb));
        self.edit(&label, Edit::Stroke { limb, frame, drawn: None })
    }

    /// Says where a limb is in depth on a frame, or with [`None`] no longer. The mark's limb is `limb`.
    ///
    /// # Errors
    /// There is no such limb, or the depth is no place that a limb can be.
    pub fn set_depth(&mut self, limb: usize, frame: usize, mark: Option<LimbDepth>) -> Result<Outdated> {
        let mark = mark.filter(|m| m.depth.is_some() || m.bend.is_some());
        let label = format!("depth of `{}` on frame {frame}", self.label(limb));
        self.edit(&label, Edit::Depth { limb, frame, mark })
    }

    /// Paints a hint for the segmenter on a frame, over those that are there.
    ///
    /// # Errors
    /// The points or the radius are no brush stroke.
    pub fn add_paint(&mut self, frame: usize, paint: Paint) -> Result<Outdated> {
        let at = self.document.inputs.rig.keyframes.iter().find(|k| k.frame == frame).map_or(0, |k| k.paint.len());
        self.edit(&format!("paint on frame {frame}"), Edit::InsertPaint { frame, at, paint })
    }

    /// Removes a painted hint of a frame; those behind it move down.
    ///
    /// # Errors
    /// There is no such hint.
    pub fn remove_paint(&mut self, frame: usize, index: usize) -> Result<Outdated> {
        self.edit(&format!("wipe paint off frame {frame}"), Edit::RemovePaint { frame, at: index })
    }

    /// Gives a frame a painted mask, by the path of an image, or takes it away.
    ///
    /// # Errors
    /// The path cannot be made absolute, or is not UTF-8.
    pub fn set_mask(&mut self, frame: usize, mask: Option<&Path>) -> Result<Outdated> {
        let mask = mask.map(|p| std::path::absolute(p).map_err(|e| Error::io(p, "find", e))).transpose()?;
        self.edit(&format!("mask of frame {frame}"), Edit::Mask { frame, mask })
    }

    /// Chooses the value of a parameter, or [`None`] for its default.
    ///
    /// # Errors
    /// There is no such parameter, or it does not take the value.
    pub fn set_parameter(&mut self, name: &str, value: Option<Value>) -> Result<Outdated> {
        self.edit(&format!("set {name}"), Edit::Parameter { name: name.to_owned(), value })
    }

    /// Takes in a motion that was tracked from `inputs`, or takes the motion away.
    ///
    /// # Errors
    /// The motion is not of those inputs.
    pub fn set_motion(&mut self, tracked: Option<Tracked>) -> Result<Outdated> {
        self.edit("track", Edit::Tracked(tracked))
    }

    /// Takes in what a creature was made of: its motion as a step of undo, and that it is up to date with `inputs`.
    ///
    /// # Errors
    /// The motion is not of those inputs.
    pub fn set_creature(&mut self, motion: Arc<Motion>, inputs: Inputs) -> Result<Outdated> {
        let outdated = self.edit("make a creature", Edit::Tracked(Some(Tracked { motion, inputs: inputs.clone() })))?;
        self.creature_of = Some(inputs);
        Ok(outdated)
    }

    /// Sets a part, or with [`None`] takes the one of its kind away.
    ///
    /// # Errors
    /// It is of another kind, or could not be written.
    pub fn set_part(&mut self, kind: PartKind, part: Option<Part>) -> Result<Outdated> {
        self.edit(&format!("change the {}", kind.name()), Edit::Part { kind, part })
    }

    fn label(&self, limb: usize) -> String {
        self.document.inputs.rig.limbs.get(limb).map_or_else(|| limb.to_string(), |l| l.label.clone())
    }
}

/// What was tracked, with one limb's label changed; [`None`] where that changes nothing or cannot be.
fn relabel(tracked: &Tracked, old: &str, new: &str) -> Option<Tracked> {
    let mut tracked = tracked.clone();
    if old == new || tracked.motion.track(new).is_some() {
        return None;
    }
    tracked.motion.track(old)?;
    let change = |label: &mut String| {
        if label == old {
            new.clone_into(label);
        }
    };
    let motion = Arc::make_mut(&mut tracked.motion);
    motion.tracks.iter_mut().for_each(|t| change(&mut t.name));
    for (parent, child) in &mut motion.bones {
        change(parent);
        change(child);
    }
    Arc::make_mut(&mut tracked.inputs.rig).limbs.iter_mut().for_each(|l| change(&mut l.label));
    Some(tracked)
}
