//! The notes of a session, a part of it that is the studio's own: behind which door it is, how a motion is carried over to a
//! character, the time it takes, for which picture its joints are marked, and of what the motion is that was followed.

use std::sync::Arc;

use marey_binding::{Part, Result};
use serde::{Deserialize, Serialize};

use crate::document::{Document, Door};
use crate::marks::Marks;
use crate::solved::Stamp;
use crate::texts;
use crate::timing::Timing;

/// The session's notes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Notes {
    pub(crate) door: Door,
    pub(crate) character: CharacterNotes,
    pub(crate) timing: Timing,
    /// Points of the clip that do not hold the drawing, by name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) left_off: Vec<String>,
    /// On which picture a character's joints are those that are marked on the clip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) marked_for: Option<u64>,
    /// Of what the motion is that was followed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) solved: Option<Stamp>,
}

/// How a motion is carried over to a character.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct CharacterNotes {
    /// Bones change their length up to this factor.
    pub(crate) stretch: f32,
    /// It stays where it is.
    pub(crate) on_spot: bool,
    /// Bones point where the motion's do, rather than turn as they do.
    pub(crate) absolute: bool,
    /// What bends the drawing: "arap" or a plugin's id; empty for what is built in for characters.
    pub(crate) deformer: String,
}

impl Default for CharacterNotes {
    fn default() -> Self {
        // A figure of other proportions tears at more, and looks stiff at none.
        Self { stretch: 1.2, on_spot: true, absolute: false, deformer: String::new() }
    }
}

impl Notes {
    /// Those of a session without notes, or with damaged ones, are the usual.
    pub(crate) fn parse(bytes: Option<&Arc<Vec<u8>>>) -> Self {
        bytes.and_then(|notes| serde_json::from_slice(notes).ok()).unwrap_or_default()
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }
}

impl Document {
    /// What is made of it.
    pub(crate) fn door(&self) -> Door {
        self.notes.door
    }

    /// How a motion is carried over.
    pub(crate) fn character_notes(&self) -> CharacterNotes {
        self.notes.character.clone()
    }

    pub(crate) fn set_character_notes(&mut self, label: &str, character: &CharacterNotes) -> Result<()> {
        self.set_notes(label, &Notes { character: character.clone(), ..self.notes.clone() })
    }

    /// The time that what is made takes.
    pub(crate) fn timing(&self) -> Timing {
        self.notes.timing
    }

    pub(crate) fn set_timing(&mut self, timing: Timing) -> Result<()> {
        self.set_notes(texts::EDIT_TIMING, &Notes { timing, ..self.notes.clone() })
    }

    fn set_notes(&mut self, label: &str, notes: &Notes) -> Result<()> {
        self.set_parts(label, &[(Part::Notes, Some(&notes.bytes()))])
    }

    /// Whether a point of the clip holds the drawing.
    pub(crate) fn is_on_drawing(&self, point: &str) -> bool {
        !self.notes.left_off.iter().any(|name| name == point)
    }

    /// Lets a point hold the drawing or not, one step of undo.
    pub(crate) fn set_on_drawing(&mut self, point: &str, on: bool) -> Result<()> {
        let mut left_off = self.notes.left_off.clone();
        left_off.retain(|name| name != point);
        if !on {
            left_off.push(point.to_owned());
        }
        self.set_notes(texts::EDIT_ON_DRAWING, &Notes { left_off, ..self.notes.clone() })
    }

    /// Marks points otherwise, one step of undo. A point that is no more is not left off either: its name may be given again.
    pub(crate) fn set_marks(&mut self, label: &str, change: impl FnOnce(&mut Marks)) -> Result<()> {
        let mut marks = self.marks.clone();
        change(&mut marks);
        let (bytes, mut notes) = (marks.bytes(), self.notes.clone());
        notes.left_off.retain(|name| marks.points.iter().any(|p| p.name == *name));
        let points = (Part::Points, bytes.as_deref());
        if notes == self.notes {
            return self.set_parts(label, &[points]);
        }
        self.set_parts(label, &[points, (Part::Notes, Some(&notes.bytes()))])
    }

    /// For which picture of a character joints are marked, by its fingerprint.
    pub(crate) fn marked_for(&self) -> Option<u64> {
        self.notes.marked_for
    }

    /// Marks joints of the character with this picture, one step of undo.
    pub(crate) fn set_joint_marks(&mut self, label: &str, marks: &[u8], picture: Option<u64>) -> Result<()> {
        let notes = Notes { marked_for: picture, ..self.notes.clone() }.bytes();
        self.set_parts(label, &[(Part::Points, Some(marks)), (Part::Notes, Some(&notes))])
    }

    /// Of what the motion is that was followed and kept.
    pub(crate) fn stamp(&self) -> Option<Stamp> {
        self.notes.solved
    }

    /// Keeps where marked points go, as a part of the step that they were followed for. While something can be done again
    /// it is not kept, for nothing could be done again after it.
    pub(crate) fn keep_solved(&mut self, points: &Arc<Vec<u8>>, motion: &str) -> Result<()> {
        let Some((_, clip)) = &self.clip else { return Ok(()) };
        if self.part(Part::Points) != Some(points) || self.redo.is_some() {
            return Ok(());
        }
        let notes = Notes { solved: Some(Stamp::new(points, clip)), ..self.notes.clone() }.bytes();
        let label = format!("{}{}", self.undo.as_deref().unwrap_or(texts::EDIT_OPEN), texts::EDIT_FOLLOWED);
        // Nobody did anything.
        let worked_on = self.worked_on;
        let kept = self.set_parts(&label, &[(Part::Motion, Some(motion.as_bytes())), (Part::Notes, Some(&notes))]);
        self.worked_on = worked_on;
        kept
    }
}
