//! The journal: what was done since the last save, each finished gesture a record that is synced before the gesture
//! counts as finished. After a crash the session is the saved file and these gestures.
//!
//! The journal's file also carries the lock: as long as one program edits the session, no other can. The system frees
//! the lock with the program, however it ends.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::durable::{beside, replace, sync_folder};
use super::edit::Edit;
use super::record;
use crate::error::{Error, Result};

const FORMAT: &str = "marey-journal";
/// Version 2 has parts; one of version 1 is read as it is.
const VERSION: u32 = 2;

/// What a gesture did to the history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Way {
    Do,
    Undo,
    Redo,
}

/// A finished gesture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Entry {
    /// Counts the session's gestures from 1.
    pub(super) number: u64,
    pub(super) way: Way,
    pub(super) label: String,
    pub(super) edits: Vec<Edit>,
}

#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    session: String,
}

/// What a journal holds for a session.
#[derive(Debug, Default)]
pub(super) struct Read {
    /// The gestures after those that the file has, without a gap, each with the byte after it.
    pub(super) entries: Vec<(Entry, u64)>,
    /// What could not be used, a sentence each.
    pub(super) lost: Vec<String>,
    /// Whether anything but a gesture cut off at the very end could not be used.
    pub(super) damaged: bool,
}

/// Where the journal of a session lies.
pub(super) fn path_of(session: &Path) -> PathBuf {
    beside(session, "-journal")
}

/// Reads the journal of the session `id`, in the file `session`, which has all gestures up to `saved`.
///
/// # Errors
/// It is of a newer version.
pub(super) fn read(bytes: &[u8], session: &Path, id: &str, saved: u64) -> Result<Read> {
    let mut read = Read::default();
    let mut lines = record::lines(bytes);
    let Some(first) = lines.next() else { return Ok(read) };
    let header: Option<Header> = first.text.and_then(|text| serde_json::from_str(text).ok());
    match header {
        None if first.torn => {
            read.lost.push("the first gesture since the last save was cut off".into());
            return Ok(read);
        }
        Some(h) if h.format == FORMAT && h.version > VERSION => {
            let problem = format!("is {FORMAT} version {}", h.version);
            let remedy = format!("this program reads version {VERSION}; open the session with a newer one");
            return Err(Error::file(path_of(session), problem, remedy));
        }
        Some(h) if h.format == FORMAT && h.session == id => {}
        _ => {
            read.lost
                .push("the journal is not of this session, or its beginning is damaged; nothing of it is used".into());
            read.damaged = true;
            return Ok(read);
        }
    }
    // The number of a file that was made to deceive may be the last there is.
    let first = saved.saturating_add(1);
    let mut next = None;
    for line in lines {
        let entry: Option<Entry> = line.text.and_then(|text| serde_json::from_str(text).ok());
        let Some(entry) = entry.filter(|e| next.is_none_or(|n| e.number == n) && (next.is_some() || e.number <= first))
        else {
            let from = next.unwrap_or(first);
            if line.torn {
                read.lost.push(format!("gesture {from} was cut off and is lost"));
            } else {
                read.lost
                    .push(format!("the journal cannot be read from gesture {from} on; that and later ones are lost"));
                read.damaged = true;
            }
            return Ok(read);
        };
        next = Some(entry.number.saturating_add(1));
        if entry.number > saved {
            read.entries.push((entry, line.end as u64));
        }
    }
    Ok(read)
}

/// The bytes of a session's journal; none where there is no journal.
pub(super) fn bytes_of(session: &Path) -> Result<Vec<u8>> {
    let path = path_of(session);
    match std::fs::read(&path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        read => read.map_err(|e| Error::io(&path, "read", e)),
    }
}

/// Whether a program is editing the session at `session` now.
pub(super) fn is_locked(session: &Path) -> bool {
    File::open(path_of(session)).is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// A journal that this program writes, locked.
#[derive(Debug)]
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    session: String,
    /// Bytes of whole records.
    length: u64,
}

impl Journal {
    /// Opens or makes the journal of the session file at `session` and locks it; gives its bytes.
    ///
    /// # Errors
    /// Another program has it open, or the system refuses.
    pub(super) fn lock(session: &Path) -> Result<(Self, Vec<u8>)> {
        let path = path_of(session);
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        loop {
            let new = !path.exists();
            let mut file = options.open(&path).map_err(|e| Error::io(&path, "open", e))?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let remedy = "close it there, or open it read-only here";
                    return Err(Error::file(session, "is being edited by another program", remedy));
                }
                Err(TryLockError::Error(e)) => return Err(Error::io(&path, "lock", e)),
            }
            // Whoever held it may have removed it in between; then this is a lock on nothing.
            if !is_at(&file, &path) {
                continue;
            }
            if new {
                sync_folder(&path)?;
            }
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes).map_err(|e| Error::io(&path, "read", e))?;
            let length = bytes.len() as u64;
            return Ok((Self { path, file, session: String::new(), length }, bytes));
        }
    }

    /// Goes on as the journal of the session `id` behind byte `used`, the end of the last entry that is used; 0 for
    /// none. Where that leaves out anything but a torn end, `bytes`, which is all of it, is kept aside first.
    pub(super) fn resume(&mut self, bytes: &[u8], id: &str, used: u64, damaged: bool) -> Result<()> {
        if damaged {
            replace(&beside(&self.path, "-damaged"), bytes)?;
        }
        self.session = id.to_owned();
        self.cut(used)
    }

    /// Empties it: the file has it all. From here on it is of the session `id`.
    pub(super) fn clear(&mut self, id: &str) -> Result<()> {
        self.session = id.to_owned();
        self.cut(0)
    }

    fn cut(&mut self, length: u64) -> Result<()> {
        let cut = self.shorten(length).and_then(|cut| if cut { self.file.sync_all() } else { Ok(()) });
        cut.map_err(|e| Error::io(&self.path, "write", e))?;
        self.length = length;
        Ok(())
    }

    /// Cuts off what lies behind `length`; whether there was anything.
    fn shorten(&self, length: u64) -> std::io::Result<bool> {
        let longer = self.file.metadata()?.len() > length;
        if longer {
            self.file.set_len(length)?;
        }
        Ok(longer)
    }

    /// Adds a gesture and returns when it is on the disk.
    ///
    /// # Errors
    /// It could not be written; the journal is as it was before.
    pub(super) fn append(&mut self, entry: &Entry) -> Result<()> {
        let mut text = String::new();
        if self.length == 0 {
            let header = Header { format: FORMAT.into(), version: VERSION, session: self.session.clone() };
            text = record::encode(&header)?;
        }
        text += &record::encode(entry)?;
        // Half a record may lie behind the whole ones, left by an append that failed.
        let written = self
            .shorten(self.length)
            .and_then(|_| self.file.seek(SeekFrom::Start(self.length)))
            .and_then(|_| self.file.write_all(text.as_bytes()))
            .and_then(|()| self.file.sync_data());
        if let Err(error) = written {
            // Where this fails too, the next append cuts the half record off, or the next opening finds it out.
            let _ = self.shorten(self.length);
            return Err(Error::io(&self.path, "write", error));
        }
        self.length += text.len() as u64;
        Ok(())
    }
}

#[cfg(all(test, target_os = "linux"))]
impl Journal {
    /// Lets every further append meet a full disk.
    pub(super) fn fill_disk(&mut self) {
        self.file = OpenOptions::new().write(true).open("/dev/full").expect("a device that is always full");
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        // An empty journal says nothing; one that cannot be removed does no harm either.
        if self.length == 0 {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Whether `file` is what lies at `path`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let key = |m: std::fs::Metadata| (m.dev(), m.ino());
    file.metadata().map(key).ok() == std::fs::metadata(path).map(key).ok()
}

/// Whether `file` is what lies at `path`; here an open file cannot be removed.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}
