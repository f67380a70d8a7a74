//! Edits: the smallest changes of a document. Each is applied whole or not at all and gives the edit that takes it
//! back, so that undo costs the memory of what changed.

use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::clip_reference::ClipReference;
use super::document::{Document, Tracked};
use super::parameters::Value;
use super::part::{Part, PartKind};
use crate::error::{Error, Result};
use crate::rig::{Facing, KeyFrame, Limb, LimbDepth, Paint, Rig, Stroke};

/// A stroke without the limb it is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Drawn {
    pub(super) points: Vec<Vec2>,
    pub(super) facing: Option<Facing>,
}

/// A change of a document. Limbs and paint are named by their index, as in [`Rig`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Edit {
    /// Another clip, and the size that is drawn on.
    Clip { clip: Option<Arc<ClipReference>>, size: (u32, u32) },
    /// The whole rig.
    Rig(Arc<Rig>),
    /// A limb with its strokes, by frame; limbs from `at` on move up.
    InsertLimb {
        at: usize,
        limb: Limb,
        strokes: Vec<(usize, Drawn)>,
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        depths: Vec<(usize, LimbDepth)>,
    },
    /// A limb with its strokes goes; limbs behind it move down.
    RemoveLimb { at: usize },
    /// A limb's label and side.
    Limb { at: usize, limb: Limb },
    /// The stroke of a limb on a frame.
    Stroke { limb: usize, frame: usize, drawn: Option<Drawn> },
    /// Where a limb is in depth on a frame.
    Depth { limb: usize, frame: usize, mark: Option<LimbDepth> },
    /// A painted hint; those from `at` on move up.
    InsertPaint { frame: usize, at: usize, paint: Paint },
    /// A painted hint goes; those behind it move down.
    RemovePaint { frame: usize, at: usize },
    /// The painted mask of a frame.
    Mask { frame: usize, mask: Option<PathBuf> },
    /// A parameter.
    Parameter { name: String, value: Option<Value> },
    /// What was tracked.
    Tracked(Option<Tracked>),
    /// A part, or none of its kind.
    Part { kind: PartKind, part: Option<Part> },
}

impl Edit {
    /// Changes `document` and gives the edit that takes it back.
    ///
    /// # Errors
    /// The edit does not fit the document, which stays as it was.
    pub(super) fn apply(&self, document: &mut Document) -> Result<Self> {
        let inputs = &mut document.inputs;
        match self {
            Self::Clip { clip, size } => {
                let was = inputs.rig.size;
                if *size != was {
                    let rig = Rig { size: *size, ..(*inputs.rig).clone() };
                    rig.validate_draft()?;
                    inputs.rig = Arc::new(rig);
                }
                Ok(Self::Clip { clip: std::mem::replace(&mut inputs.clip, clip.clone()), size: was })
            }
            Self::Parameter { name, value } => {
                let value = inputs.settings.set(name, value.clone())?;
                Ok(Self::Parameter { name: name.clone(), value })
            }
            Self::Tracked(tracked) => {
                tracked.as_ref().map_or(Ok(()), Tracked::check)?;
                Ok(Self::Tracked(std::mem::replace(&mut document.tracked, tracked.clone())))
            }
            Self::Part { kind, part } => {
                if part.as_ref().is_some_and(|p| p.kind() != *kind) {
                    return Err(Error::invalid("part", "is of another kind than it says", "set it as what it is"));
                }
                let was = match part {
                    Some(part) => document.parts.insert(*kind, part.clone()),
                    None => document.parts.remove(kind),
                };
                Ok(Self::Part { kind: *kind, part: was })
            }
            Self::Rig(rig) => {
                let mut rig = rig.clone();
                if !is_tidy(&rig) {
                    tidy(Arc::make_mut(&mut rig));
                }
                rig.validate_draft()?;
                Ok(Self::Rig(std::mem::replace(&mut inputs.rig, rig)))
            }
            _ => {
                let before = inputs.rig.clone();
                let rig = Arc::make_mut(&mut inputs.rig);
                let inverse = self.draw(rig).and_then(|inverse| rig.validate_draft().map(|()| inverse));
                inverse.inspect_err(|_| inputs.rig = before)
            }
        }
    }

    /// Whether this edit sets what `earlier` set, so that after it the earlier one makes no difference.
    pub(super) fn replaces(&self, earlier: &Self) -> bool {
        match (self, earlier) {
            (Self::Clip { .. }, Self::Clip { .. })
            | (Self::Rig(_), Self::Rig(_))
            | (Self::Tracked(_), Self::Tracked(_)) => true,
            (Self::Depth { limb: a, frame: f, .. }, Self::Depth { limb: b, frame: g, .. }) => (a, f) == (b, g),
            (Self::Limb { at: a, .. }, Self::Limb { at: b, .. }) => a == b,
            (Self::Stroke { limb: a, frame: f, .. }, Self::Stroke { limb: b, frame: g, .. }) => (a, f) == (b, g),
            (Self::Mask { frame: a, .. }, Self::Mask { frame: b, .. }) => a == b,
            (Self::Parameter { name: a, .. }, Self::Parameter { name: b, .. }) => a == b,
            (Self::Part { kind: a, .. }, Self::Part { kind: b, .. }) => a == b,
            _ => false,
        }
    }

    /// The part of [`Self::apply`] that changes places in the rig.
    fn draw(&self, rig: &mut Rig) -> Result<Self> {
        match self {
            Self::InsertLimb { at, limb, strokes, depths } => {
                inside("limb", *at, rig.limbs.len() + 1)?;
                rig.limbs.insert(*at, limb.clone());
                renumber(rig, |l| Some(if l >= *at { l + 1 } else { l }));
                for (frame, drawn) in strokes {
                    set_stroke(rig, *at, *frame, Some(drawn));
                }
                for (frame, mark) in depths {
                    set_depth(rig, *at, *frame, Some(*mark));
                }
                Ok(Self::RemoveLimb { at: *at })
            }
            Self::RemoveLimb { at } => {
                inside("limb", *at, rig.limbs.len())?;
                let drawn = |s: &Stroke| Drawn { points: s.points.clone(), facing: s.facing };
                let strokes = rig.keys_of(*at).map(|(frame, s)| (frame, drawn(s))).collect();
                let marks = |k: &KeyFrame| Some((k.frame, *k.depths.iter().find(|d| d.limb == *at)?));
                let depths = rig.keyframes.iter().filter_map(marks).collect();
                let limb = rig.limbs.remove(*at);
                renumber(rig, |l| (l != *at).then_some(if l > *at { l - 1 } else { l }));
                Ok(Self::InsertLimb { at: *at, limb, strokes, depths })
            }
            Self::Limb { at, limb } => {
                inside("limb", *at, rig.limbs.len())?;
                Ok(Self::Limb { at: *at, limb: std::mem::replace(&mut rig.limbs[*at], limb.clone()) })
            }
            Self::Stroke { limb, frame, drawn } => {
                inside("limb", *limb, rig.limbs.len())?;
                let drawn = set_stroke(rig, *limb, *frame, drawn.as_ref());
                Ok(Self::Stroke { limb: *limb, frame: *frame, drawn })
            }
            Self::Depth { limb, frame, mark } => {
                inside("limb", *limb, rig.limbs.len())?;
                let mark = set_depth(rig, *limb, *frame, *mark);
                Ok(Self::Depth { limb: *limb, frame: *frame, mark })
            }
            Self::InsertPaint { frame, at, paint } => on_frame(rig, *frame, |key| {
                inside("paint", *at, key.paint.len() + 1)?;
                key.paint.insert(*at, paint.clone());
                Ok(Self::RemovePaint { frame: *frame, at: *at })
            }),
            Self::RemovePaint { frame, at } => on_frame(rig, *frame, |key| {
                inside("paint", *at, key.paint.len())?;
                Ok(Self::InsertPaint { frame: *frame, at: *at, paint: key.paint.remove(*at) })
            }),
            Self::Mask { frame, mask } => {
                if let Some(path) = mask.as_ref().filter(|p| p.to_str().is_none()) {
                    return Err(Error::file(path, "has a name that is not UTF-8", "rename it"));
                }
                on_frame(rig, *frame, |key| {
                    Ok(Self::Mask { frame: *frame, mask: std::mem::replace(&mut key.mask, mask.clone()) })
                })
            }
            Self::Clip { .. } | Self::Rig(_) | Self::Parameter { .. } | Self::Tracked(_) | Self::Part { .. } => {
                Err(Error::invalid("edit", "is not of the rig", "apply it to the document"))
            }
        }
    }
}

fn inside(what: &str, index: usize, count: usize) -> Result<()> {
    if index < count {
        return Ok(());
    }
    Err(Error::invalid(format!("{what} {index}"), "does not exist", format!("{what}s count from 0, below {count}")))
}

/// Gives the strokes' limbs other numbers, in the same order; strokes of [`None`] go.
fn renumber(rig: &mut Rig, number: impl Fn(usize) -> Option<usize>) {
    for key in &mut rig.keyframes {
        key.strokes.retain_mut(|s| number(s.limb).map(|l| s.limb = l).is_some());
        key.depths.retain_mut(|d| number(d.limb).map(|l| d.limb = l).is_some());
    }
    drop_empty(rig);
}

/// Draws or wipes a stroke; gives the one before it.
fn set_stroke(rig: &mut Rig, limb: usize, frame: usize, drawn: Option<&Drawn>) -> Option<Drawn> {
    let change = |key: &mut KeyFrame| {
        let at = key.strokes.partition_point(|s| s.limb < limb);
        let old = key.strokes.get(at).is_some_and(|s| s.limb == limb).then(|| key.strokes.remove(at));
        if let Some(Drawn { points, facing }) = drawn.cloned() {
            key.strokes.insert(at, Stroke { limb, points, facing });
        }
        old.map(|s| Drawn { points: s.points, facing: s.facing })
    };
    on_frame(rig, frame, change)
}

/// Marks or unmarks a limb's depth; gives the mark before it.
fn set_depth(rig: &mut Rig, limb: usize, frame: usize, mark: Option<LimbDepth>) -> Option<LimbDepth> {
    on_frame(rig, frame, |key| {
        let at = key.depths.partition_point(|d| d.limb < limb);
        let old = key.depths.get(at).is_some_and(|d| d.limb == limb).then(|| key.depths.remove(at));
        if let Some(mark) = mark {
            key.depths.insert(at, LimbDepth { limb, ..mark });
        }
        old
    })
}

/// Changes the key frame at `frame`, which is made where there is none and goes when nothing is left on it.
fn on_frame<T>(rig: &mut Rig, frame: usize, change: impl FnOnce(&mut KeyFrame) -> T) -> T {
    let at = rig.keyframes.partition_point(|k| k.frame < frame);
    if rig.keyframes.get(at).is_none_or(|k| k.frame != frame) {
        rig.keyframes.insert(at, KeyFrame { frame, ..KeyFrame::default() });
    }
    let result = change(&mut rig.keyframes[at]);
    drop_empty(rig);
    result
}

fn is_empty(key: &KeyFrame) -> bool {
    key.strokes.is_empty() && key.depths.is_empty() && key.paint.is_empty() && key.mask.is_none()
}

fn drop_empty(rig: &mut Rig) {
    rig.keyframes.retain(|k| !is_empty(k));
}

/// Edits rely on this order, and undo restores it.
fn is_tidy(rig: &Rig) -> bool {
    rig.keyframes.is_sorted_by_key(|k| k.frame)
        && rig
            .keyframes
            .iter()
            .all(|k| !is_empty(k) && k.strokes.is_sorted_by_key(|s| s.limb) && k.depths.is_sorted_by_key(|d| d.limb))
}

fn tidy(rig: &mut Rig) {
    drop_empty(rig);
    rig.keyframes.sort_by_key(|k| k.frame);
    for key in &mut rig.keyframes {
        key.strokes.sort_by_key(|s| s.limb);
        key.depths.sort_by_key(|d| d.limb);
    }
}
