//! Recordings: a document as it was, and every gesture that was finished after that, so that what a person did can be
//! done again. A recording is a report of a defect that leads there, and a test of what it led to.
//!
//! It is a session file with the entries of a journal behind it. One that breaks off is played to where it does.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::Session;
use super::document::Document;
use super::history::History;
use super::journal::Entry;
use super::record;
use super::session_file::{self, Contents};
use crate::error::{Error, Result};
use crate::rig::Rig;

/// A recording in progress.
#[derive(Debug)]
pub(super) struct Recording {
    path: PathBuf,
    file: File,
}

impl Recording {
    fn append(&mut self, entry: &Entry) -> Result<()> {
        let text = record::encode(entry)?;
        self.file.write_all(text.as_bytes()).map_err(|e| Error::io(&self.path, "write", e))
    }
}

impl Session {
    /// Begins a recording at `path`, in place of the one in progress, if any.
    ///
    /// # Errors
    /// The file exists or cannot be written, or a gesture is in progress.
    pub fn start_recording(&mut self, path: &Path) -> Result<()> {
        self.check_no_gesture()?;
        let contents = Contents { document: self.document.clone(), saved: self.number, ..Contents::default() };
        let bytes = session_file::encode(&contents, path)?;
        let file = File::create_new(path).and_then(|mut file| file.write_all(&bytes).map(|()| file));
        let file = file.map_err(|e| Error::io(path, "create", e))?;
        self.recording = Some(Recording { path: path.to_owned(), file });
        Ok(())
    }

    /// Ends the recording; whether there was one.
    pub fn stop_recording(&mut self) -> bool {
        self.recording.take().is_some()
    }

    /// Adds a finished gesture to the recording. The gesture counts, whatever becomes of the recording.
    pub(super) fn record(&mut self, entry: &Entry) {
        if let Some(recording) = &mut self.recording
            && let Err(error) = recording.append(entry)
        {
            self.warnings.push(format!("the recording ended early: {error}"));
            self.recording = None;
        }
    }

    /// Plays the first `most` gestures of the recording at `path`; gives the session they lead to, kept nowhere.
    ///
    /// # Errors
    /// It cannot be read, is no recording, or a gesture does not fit what the ones before it led to.
    pub fn replay_recording(path: &Path, most: usize) -> Result<Self> {
        let bytes = session_file::bytes(path)?;
        let begin = session_file::end_of_sections(&bytes)
            .ok_or_else(|| Error::file(path, "is no recording, or its beginning is damaged", "record anew"))?;
        let Contents { document, saved, lost, .. } = session_file::decode(&bytes[..begin], path)?;
        let history = History { state: saved, ..History::default() };
        let mut session = Self { document, history, number: saved, warnings: lost, ..Self::default() };
        for line in record::lines(&bytes[begin..]).take(most) {
            let Some(entry) = line.text.and_then(|text| serde_json::from_str::<Entry>(text).ok()) else {
                session.warnings.push(format!("the recording breaks off after {} gestures", session.replayed));
                break;
            };
            let number = entry.number;
            session.replay(entry).map_err(|e| Error::file(path, format!("gesture {number}: {e}"), "record anew"))?;
        }
        Ok(session)
    }

    /// A number that tells this document from others: of two that are alike to the last bit it is the same, on any
    /// machine and wherever their clips lie.
    pub fn fingerprint(&self) -> u64 {
        let Document { inputs, tracked, parts } = &self.document;
        let content =
            |clip: &super::ClipReference| (clip.bytes, clip.crc32, clip.size, clip.frames, clip.fps.to_bits());
        let rig = |rig: &Rig| {
            let mut rig = rig.clone();
            for mask in rig.keyframes.iter_mut().filter_map(|k| k.mask.as_mut()) {
                *mask = mask.file_name().map(PathBuf::from).unwrap_or_default();
            }
            rig
        };
        let of = |inputs: &super::Inputs| {
            serde_json::json!([inputs.clip.as_deref().map(content), rig(&inputs.rig), inputs.settings])
        };
        let tracked = tracked.as_ref().map(|t| (&*t.motion, of(&t.inputs)));
        let mut text = serde_json::json!([of(inputs), tracked]).to_string();
        // What has no parts has the number that it always had.
        for part in parts.values() {
            text += &serde_json::json!(part).to_string();
        }
        (text.len() as u64) << 32 | u64::from(crc32fast::hash(text.as_bytes()))
    }
}
