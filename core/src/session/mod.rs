//! The document that a host edits: a clip by reference, the rig drawn on it, chosen parameters, the motion that was
//! tracked, and parts for characters and sketches: marked points, a drawing, what binds them, a picture, its skeleton.
//!
//! Edits come in gestures: what a person does in one go, such as drawing a stroke or dragging a slider, and takes back
//! in one go. There is no end to undo. A session with a file is always safe: a finished gesture is on the disk before
//! the call that finishes it returns, and a crash loses at most the gesture in progress. A save writes the file anew
//! and is whole or not at all.
//!
//! Limits: one clip and one rig a session. Masks and creatures are made anew from it, not kept in it. The undo history
//! lives as long as the session is open; after a crash it reaches back to the last save.

mod clip_reference;
mod document;
mod durable;
mod edit;
mod editing;
mod embedded;
mod history;
mod incremental;
mod journal;
mod outdated;
mod parameters;
mod part;
mod record;
mod recording;
mod session_file;
mod store;
#[cfg(test)]
mod tests;

pub use clip_reference::{ClipReference, ClipState};
pub use document::{Document, Inputs, Tracked};
pub use embedded::UnpackedMedia;
pub use incremental::Incremental;
pub use outdated::{Outdated, OutdatedLimb};
pub use parameters::{Chosen, Helpers, Kind, LONGEST, PARAMETERS, Parameter, Settings, Value};
pub use part::{LARGEST_PART, Part, PartKind};
pub use store::Access;

use std::sync::Arc;

use crate::error::{Error, Result};
use edit::Edit;
use history::{Gesture, History, apply_all, take_back};
use journal::{Entry, Way};
use recording::Recording;
use store::Store;

/// A document with its history, and where it is kept.
#[derive(Debug, Default)]
pub struct Session {
    document: Document,
    history: History,
    gesture: Option<Gesture>,
    /// How many gestures were finished since the session was made, undo and redo included.
    number: u64,
    /// The state that the file has.
    saved: Option<u64>,
    /// What masks and creature were last made of.
    creature_of: Option<Inputs>,
    store: Store,
    /// Sections of the file that this version does not know.
    unknown: Vec<serde_json::Value>,
    warnings: Vec<String>,
    replayed: usize,
    recording: Option<Recording>,
    /// Whether a save puts the clip and the masks into the file.
    embeds: bool,
    unpacked: Option<Arc<UnpackedMedia>>,
}

impl Session {
    /// The document as it is now, the gesture in progress included.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// What is out of date, of the motion and of the masks and creature that were made last.
    pub fn outdated(&self) -> Outdated {
        let now = &self.document.inputs;
        let tracked = self.document.tracked.as_ref();
        let limbs = tracked.map_or_else(|| Outdated::all(now), |t| Outdated::between(&t.inputs, now)).limbs;
        let creature = self.creature_of.as_ref().is_none_or(|of| Outdated::between(of, now).creature);
        Outdated { limbs, creature }
    }

    /// How many gestures were finished since the session was made; undo and redo are gestures too.
    pub fn gestures(&self) -> u64 {
        self.number
    }

    /// Whether the file lacks anything that the document has; a session without a file is modified once anything was
    /// done.
    pub fn is_modified(&self) -> bool {
        self.gesture.as_ref().is_some_and(|g| !g.done.is_empty()) || self.saved != Some(self.history.state)
    }

    /// What opening recovered, lost or did not find, a sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// How many gestures that were never saved opening took from the journal.
    pub fn replayed(&self) -> usize {
        self.replayed
    }

    /// Begins a gesture: the edits until its end are one step of undo. `label` says what it does, for a menu.
    ///
    /// # Errors
    /// One is in progress, or the session is read-only.
    pub fn begin_gesture(&mut self, label: &str) -> Result<()> {
        self.check_editable()?;
        self.check_no_gesture()?;
        let before = self.document.inputs.clone();
        self.gesture = Some(Gesture { label: label.to_owned(), before, done: Vec::new(), inverses: Vec::new() });
        Ok(())
    }

    /// Ends the gesture and returns when it is on the disk; says what it put out of date. One that changed nothing
    /// leaves no step.
    ///
    /// # Errors
    /// None is in progress, or it could not be written; then its edits are taken back.
    pub fn end_gesture(&mut self) -> Result<Outdated> {
        let mut gesture = self.gesture.take().ok_or_else(no_gesture)?;
        if gesture.done.is_empty() {
            return Ok(Outdated::default());
        }
        if let Err(error) = self.finish(Way::Do, &gesture.label, std::mem::take(&mut gesture.done)) {
            take_back(&mut self.document, &gesture.inverses);
            return Err(error);
        }
        let outdated = Outdated::between(&gesture.before, &self.document.inputs);
        let inverse = gesture.take_inverse();
        self.history.did(gesture.label, inverse, self.number);
        Ok(outdated)
    }

    /// Takes the gesture in progress back.
    ///
    /// # Errors
    /// None is in progress.
    pub fn cancel_gesture(&mut self) -> Result<()> {
        let gesture = self.gesture.take().ok_or_else(no_gesture)?;
        take_back(&mut self.document, &gesture.inverses);
        Ok(())
    }

    /// Whether a gesture is in progress.
    pub fn in_gesture(&self) -> bool {
        self.gesture.is_some()
    }

    /// The label of the step that [`Self::undo`] would take back; [`None`] where there is none.
    pub fn undo_label(&self) -> Option<&str> {
        self.history.back.last().map(|step| step.label.as_str())
    }

    /// The label of the step that [`Self::redo`] would do again; [`None`] where there is none.
    pub fn redo_label(&self) -> Option<&str> {
        self.history.forward.last().map(|step| step.label.as_str())
    }

    /// Takes the last step back; says what that put out of date, or [`None`] where there was no step.
    ///
    /// # Errors
    /// A gesture is in progress, or the undo could not be written; then nothing is changed.
    pub fn undo(&mut self) -> Result<Option<Outdated>> {
        self.step(Way::Undo)
    }

    /// Does the last step that was taken back again; as [`Self::undo`].
    ///
    /// # Errors
    /// As for [`Self::undo`].
    pub fn redo(&mut self) -> Result<Option<Outdated>> {
        self.step(Way::Redo)
    }

    fn step(&mut self, way: Way) -> Result<Option<Outdated>> {
        self.check_editable()?;
        self.check_no_gesture()?;
        let steps = if way == Way::Undo { &self.history.back } else { &self.history.forward };
        let Some(step) = steps.last().cloned() else { return Ok(None) };
        let before = self.document.inputs.clone();
        let inverse = apply_all(&mut self.document, &step.edits)?;
        if let Err(error) = self.finish(way, &step.label, step.edits) {
            apply_all(&mut self.document, &inverse)?;
            return Err(error);
        }
        self.history.moved(way == Way::Undo, step.label, inverse, self.number);
        Ok(Some(Outdated::between(&before, &self.document.inputs)))
    }

    /// Does an edit, as part of the gesture in progress or as one of its own.
    fn edit(&mut self, label: &str, edit: Edit) -> Result<Outdated> {
        if let Some(gesture) = &mut self.gesture {
            let before = self.document.inputs.clone();
            gesture.apply(&mut self.document, edit)?;
            return Ok(Outdated::between(&before, &self.document.inputs));
        }
        self.in_one(label, |session| session.edit(label, edit).map(drop))
    }

    /// Does several edits as one gesture, or as part of the one in progress.
    fn in_one(&mut self, label: &str, edits: impl FnOnce(&mut Self) -> Result<()>) -> Result<Outdated> {
        if self.in_gesture() {
            let before = self.document.inputs.clone();
            edits(self)?;
            return Ok(Outdated::between(&before, &self.document.inputs));
        }
        self.begin_gesture(label)?;
        if let Err(error) = edits(self) {
            self.cancel_gesture()?;
            return Err(error);
        }
        self.end_gesture()
    }

    /// Counts a finished gesture, once it is in the journal.
    fn finish(&mut self, way: Way, label: &str, edits: Vec<Edit>) -> Result<()> {
        let number = self.number.saturating_add(1);
        let entry = Entry { number, way, label: label.to_owned(), edits };
        self.store.append(&entry)?;
        self.record(&entry);
        self.number = number;
        Ok(())
    }

    /// Does again what the journal says was done.
    fn replay(&mut self, entry: Entry) -> Result<()> {
        let inverse = apply_all(&mut self.document, &entry.edits)?;
        self.number = entry.number;
        match entry.way {
            Way::Do => self.history.did(entry.label, inverse, self.number),
            way => self.history.moved(way == Way::Undo, entry.label, inverse, self.number),
        }
        self.replayed += 1;
        Ok(())
    }

    /// Whether a recording is in progress.
    pub fn is_recording(&self) -> bool {
        self.recording.is_some()
    }

    /// Whether a save puts the clip and the masks into the file, rather than references to them.
    pub fn is_embedded(&self) -> bool {
        self.embeds
    }

    /// Lets further saves embed the clip and the masks, or refer to them.
    ///
    /// # Errors
    /// The session is read-only, or is all that has them.
    pub fn set_embedded(&mut self, embedded: bool) -> Result<()> {
        self.check_editable()?;
        let Inputs { clip, rig, .. } = &self.document.inputs;
        let only_here = |unpacked: &Arc<UnpackedMedia>| {
            let masks = rig.keyframes.iter().filter_map(|k| k.mask.as_ref());
            clip.iter().map(|c| &c.path).chain(masks).any(|path| unpacked.has(path))
        };
        if !embedded && self.unpacked.as_ref().is_some_and(only_here) {
            let remedy = "choose the clip and the masks from files of your own first";
            return Err(Error::invalid("session", "is all that has its clip or its masks", remedy));
        }
        if self.embeds != embedded {
            self.embeds = embedded;
            self.saved = None;
        }
        Ok(())
    }

    /// The embedded media, unpacked; whoever works with their paths holds this meanwhile.
    pub fn unpacked_media(&self) -> Option<Arc<UnpackedMedia>> {
        self.unpacked.clone()
    }

    fn check_no_gesture(&self) -> Result<()> {
        if self.in_gesture() {
            return Err(Error::invalid("session", "a gesture is in progress", "end or cancel it first"));
        }
        Ok(())
    }

    fn check_editable(&self) -> Result<()> {
        if matches!(self.store, Store::ReadOnly(_)) {
            return Err(Error::invalid("session", "is open read-only", "save it under another name to edit it"));
        }
        Ok(())
    }
}

fn no_gesture() -> Error {
    Error::invalid("session", "no gesture is in progress", "begin one first")
}
