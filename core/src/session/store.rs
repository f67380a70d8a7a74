//! Where a session is kept: a file, with a journal beside it while it is edited; or nowhere.
//!
//! A session that has no name yet is a file too, in a folder of the host's choosing, so that a crash does not lose it.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::Session;
use super::durable::{beside, replace};
use super::embedded;
use super::history::History;
use super::journal::{self, Entry, Journal};
use super::session_file::{self, Contents};
use crate::error::{Error, Result};
use crate::job::Stage;

/// What names of files of unnamed sessions start and end with.
const UNTITLED: (&str, &str) = ("untitled-", ".marey");

/// Where a session is kept.
#[derive(Debug, Default)]
pub(super) enum Store {
    /// Nowhere: it ends with the program.
    #[default]
    Memory,
    /// A file that is not written.
    ReadOnly(PathBuf),
    /// A file that is, and its journal.
    File(Box<Kept>),
}

/// A session file that this program edits.
#[derive(Debug)]
pub(super) struct Kept {
    path: PathBuf,
    journal: Journal,
    id: String,
    scratch: bool,
    /// Whether the file holds more than could be read; it is kept aside before it is written anew.
    damaged: bool,
}

/// What a session is opened for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// To be edited; no other program may.
    Edit,
    /// To be read, whoever edits it.
    ReadOnly,
}

impl Store {
    /// Adds a gesture to the journal, where there is one.
    pub(super) fn append(&mut self, entry: &Entry) -> Result<()> {
        match self {
            Self::File(kept) => kept.journal.append(entry),
            Self::Memory | Self::ReadOnly(_) => Ok(()),
        }
    }

    /// Lets every further gesture meet a full disk.
    #[cfg(all(test, target_os = "linux"))]
    pub(super) fn fill_disk(&mut self) {
        if let Self::File(kept) = self {
            kept.journal.fill_disk();
        }
    }
}

impl Session {
    /// An empty session that is kept nowhere until [`Self::save_as`].
    pub fn new() -> Self {
        Self { saved: Some(0), ..Self::default() }
    }

    /// An empty session in a new file.
    ///
    /// # Errors
    /// The file exists, or cannot be written.
    pub fn create(path: &Path) -> Result<Self> {
        if path.exists() {
            return Err(Error::file(path, "exists", "open it, or choose another name"));
        }
        let mut session = Self::new();
        session.keep_at(path, false)?;
        Ok(session)
    }

    /// An empty session without a name, kept in `folder` until it is saved under one or discarded.
    ///
    /// # Errors
    /// Nothing can be written there.
    pub fn create_untitled(folder: &Path) -> Result<Self> {
        let mut session = Self::new();
        session.keep_at(&folder.join(format!("{}{}{}", UNTITLED.0, new_id(), UNTITLED.1)), true)?;
        Ok(session)
    }

    /// The sessions without a name that a crash left in `folder`, to be opened or removed; not those being edited.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn left_in(folder: &Path) -> Result<Vec<PathBuf>> {
        let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<std::io::Result<Vec<_>>>);
        let entries = entries.map_err(|e| Error::io(folder, "read", e))?;
        let untitled = |e: &std::fs::DirEntry| {
            e.file_name().to_str().is_some_and(|n| n.starts_with(UNTITLED.0) && n.ends_with(UNTITLED.1))
        };
        let mut left: Vec<PathBuf> = entries.iter().filter(|e| untitled(e)).map(std::fs::DirEntry::path).collect();
        left.retain(|path| !journal::is_locked(path));
        left.sort();
        Ok(left)
    }

    /// Opens a session file, with every gesture that was finished since its last save. Damage costs what it touches;
    /// [`Self::warnings`] says what was lost, and whether the clip is still the one that was drawn on.
    ///
    /// # Errors
    /// There is no such file, nothing of a session is in it, it is of a newer version, another program edits it, or a
    /// cancel.
    pub fn open(path: &Path, access: Access, stage: Stage<'_>) -> Result<Self> {
        stage.name("opening")?;
        let path = std::fs::canonicalize(path).map_err(|e| Error::io(path, "open", e))?;
        // The journal comes first: what it lacks because of a save meanwhile, the file has.
        let (journal, bytes) = match access {
            Access::Edit => Journal::lock(&path).map(|(journal, bytes)| (Some(journal), bytes))?,
            Access::ReadOnly => (None, journal::bytes_of(&path)?),
        };
        let Contents { mut document, id, saved, scratch, unknown, mut lost, media, .. } = session_file::read(&path)?;
        let mut unpacked = None;
        if !media.is_empty() {
            let (media, mut damaged) = embedded::unpack(&media, &path, &mut document.inputs)?;
            unpacked = Some(media);
            lost.append(&mut damaged);
        }
        let damaged = !lost.is_empty();
        let history = History { state: saved, ..History::default() };
        let was_saved = (!damaged).then_some(saved);
        let mut session =
            Self { document, history, number: saved, saved: was_saved, unknown, warnings: lost, ..Self::default() };
        (session.embeds, session.unpacked) = (unpacked.is_some(), unpacked);

        let mut read = journal::read(&bytes, &path, id.as_deref().unwrap_or_default(), saved)?;
        session.warnings.append(&mut read.lost);
        let mut used = 0;
        for (entry, end) in read.entries {
            let number = entry.number;
            if let Err(error) = session.replay(entry) {
                session.warnings.push(format!("gesture {number} and later ones are lost: {error}"));
                read.damaged = true;
                break;
            }
            used = end;
        }
        session.warnings.extend(session_file::check_media(&session.document.inputs, stage)?);
        let Some(mut journal) = journal else {
            session.store = Store::ReadOnly(path);
            return Ok(session);
        };
        let headless = id.is_none();
        let id = id.unwrap_or_else(new_id);
        journal.resume(&bytes, &id, used, read.damaged)?;
        let mut kept = Kept { path, journal, id, scratch, damaged };
        if headless {
            // No journal could ever be matched to this file, and the next crash would lose what is edited now.
            write(&mut kept, &session, saved)?;
        }
        session.store = Store::File(Box::new(kept));
        Ok(session)
    }

    /// Where the session is kept; [`None`] where it is not.
    pub fn path(&self) -> Option<&Path> {
        match &self.store {
            Store::Memory => None,
            Store::ReadOnly(path) => Some(path),
            Store::File(kept) => Some(&kept.path),
        }
    }

    /// Whether it can only be read.
    pub fn is_read_only(&self) -> bool {
        matches!(self.store, Store::ReadOnly(_))
    }

    /// Whether the user never gave it a name.
    pub fn is_untitled(&self) -> bool {
        match &self.store {
            Store::Memory => true,
            Store::ReadOnly(_) => false,
            Store::File(kept) => kept.scratch,
        }
    }

    /// Writes the file anew, whole or not at all, and empties the journal. Returns when it is on the disk.
    ///
    /// # Errors
    /// The session has no file or is read-only, a gesture is in progress, or the system refuses.
    pub fn save(&mut self) -> Result<()> {
        self.check_no_gesture()?;
        self.check_editable()?;
        let mut store = std::mem::take(&mut self.store);
        let written = match &mut store {
            Store::File(kept) => write(kept, self, self.number),
            _ => Err(Error::invalid("session", "has no file yet", "save it under a name")),
        };
        self.store = store;
        written?;
        self.saved = Some(self.history.state);
        Ok(())
    }

    /// Saves under another name and goes on there. A session that had no name leaves its place.
    ///
    /// # Errors
    /// Another program edits that file, a gesture is in progress, or the system refuses; then nothing is changed.
    pub fn save_as(&mut self, path: &Path) -> Result<()> {
        self.check_no_gesture()?;
        if !self.is_read_only() && std::fs::canonicalize(path).is_ok_and(|p| Some(p.as_path()) == self.path()) {
            return self.save();
        }
        let old = self.keep_at(path, false)?;
        remove_untitled(old)
    }

    /// Closes the session without what was not saved. One that has no name is gone.
    ///
    /// # Errors
    /// The journal cannot be emptied.
    pub fn discard(mut self) -> Result<()> {
        match std::mem::take(&mut self.store) {
            Store::File(kept) if !kept.scratch => {
                let Kept { mut journal, id, .. } = *kept;
                journal.clear(&id)
            }
            store => remove_untitled(store),
        }
    }

    /// Writes the session at `path` and keeps it there from now on; gives where it was kept.
    fn keep_at(&mut self, path: &Path, scratch: bool) -> Result<Store> {
        let path = std::path::absolute(path).map_err(|e| Error::io(path, "find", e))?;
        // A link is followed, or the file would take its place.
        let path = std::fs::canonicalize(&path).unwrap_or(path);
        if path.is_dir() {
            return Err(Error::file(path, "is a folder", "give the name of a file"));
        }
        let (journal, _) = Journal::lock(&path)?;
        let mut kept = Kept { path, journal, id: new_id(), scratch, damaged: false };
        write(&mut kept, self, self.number)?;
        self.saved = Some(self.history.state);
        Ok(std::mem::replace(&mut self.store, Store::File(Box::new(kept))))
    }
}

/// Writes the file, then empties the journal: between the two a crash leaves gestures in both, told by their numbers.
fn write(kept: &mut Kept, session: &Session, saved: u64) -> Result<()> {
    let contents = Contents {
        document: session.document.clone(),
        id: Some(kept.id.clone()),
        saved,
        scratch: kept.scratch,
        unknown: session.unknown.clone(),
        embeds: session.embeds,
        ..Contents::default()
    };
    let bytes = session_file::encode(&contents, &kept.path)?;
    if kept.damaged {
        let aside = beside(&kept.path, "-damaged");
        std::fs::copy(&kept.path, &aside).map_err(|e| Error::io(&aside, "write", e))?;
        kept.damaged = false;
    }
    replace(&kept.path, &bytes)?;
    kept.journal.clear(&kept.id)
}

/// Removes the file of a session that has no name, and its journal.
fn remove_untitled(store: Store) -> Result<()> {
    if let Store::File(kept) = store
        && kept.scratch
    {
        let Kept { path, mut journal, id, .. } = *kept;
        std::fs::remove_file(&path).map_err(|e| Error::io(&path, "remove", e))?;
        journal.clear(&id)?;
    }
    Ok(())
}

/// Tells sessions apart: when it was made, and by which process.
fn new_id() -> String {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    format!("{:x}-{:x}", now.as_nanos(), std::process::id())
}
