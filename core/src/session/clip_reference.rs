//! The clip of a session, by reference: where it is, and what tells it from another or a changed one.
//!
//! The content is told by its size in bytes and its CRC-32, of a folder the names and contents of its files in the
//! order of their names. That notices every accident; who wants to deceive themselves can.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::clip::ClipInfo;
use crate::error::{Error, Result};
use crate::job::Stage;

/// A clip by reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClipReference {
    /// The file or folder, absolute.
    pub path: PathBuf,
    /// Bytes of its content.
    pub bytes: u64,
    /// CRC-32 of its content.
    pub crc32: u32,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// How many frames it has.
    pub frames: usize,
    /// Mean frames a second.
    pub fps: f64,
}

/// How a referenced clip is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClipState {
    /// As it was.
    Unchanged,
    /// Something else, or nothing readable, lies at its path.
    Changed,
    /// Nothing is there.
    Missing,
}

impl ClipReference {
    /// Refers to the clip at `path`, which was opened as `info` says. Reads all of its content.
    ///
    /// # Errors
    /// The path is not UTF-8, something cannot be read, or a cancel.
    pub fn new(path: &Path, info: &ClipInfo, stage: Stage<'_>) -> Result<Self> {
        let path = std::path::absolute(path).map_err(|e| Error::io(path, "find", e))?;
        if path.to_str().is_none() {
            return Err(Error::file(&path, "has a name that is not UTF-8", "rename it"));
        }
        let (bytes, crc32) = content(&path, u64::MAX, stage)?;
        Ok(Self { path, bytes, crc32, size: (info.width, info.height), frames: info.frames, fps: info.fps })
    }

    /// Whether both are the same clip, wherever they lie.
    pub fn same_content(&self, other: &Self) -> bool {
        let key = |c: &Self| (c.bytes, c.crc32, c.size, c.frames, c.fps.to_bits());
        key(self) == key(other)
    }

    /// What lies at its path now. Reads all of it, unless its size already differs.
    ///
    /// # Errors
    /// Only a cancel: what cannot be read is [`ClipState::Changed`].
    pub fn state(&self, stage: Stage<'_>) -> Result<ClipState> {
        match std::fs::metadata(&self.path) {
            Err(_) => return Ok(ClipState::Missing),
            Ok(meta) if meta.is_dir() || meta.is_file() && meta.len() == self.bytes => {}
            // Another file, or what never ends, such as a device.
            Ok(_) => return Ok(ClipState::Changed),
        }
        match content(&self.path, self.bytes, stage) {
            Err(Error::Cancelled) => Err(Error::Cancelled),
            Ok(found) if found == (self.bytes, self.crc32) => Ok(ClipState::Unchanged),
            _ => Ok(ClipState::Changed),
        }
    }
}

/// Bytes and CRC-32 of a file, or of a folder's files by name; not of all where there are more than `most` bytes.
fn content(path: &Path, most: u64, stage: Stage<'_>) -> Result<(u64, u32)> {
    let mut files = vec![path.to_owned()];
    let folder = path.is_dir();
    if folder {
        let entries = std::fs::read_dir(path).and_then(Iterator::collect::<std::io::Result<Vec<_>>>);
        let entries = entries.map_err(|e| Error::io(path, "read", e))?;
        files = entries.iter().map(std::fs::DirEntry::path).filter(|p| p.is_file()).collect();
        files.sort();
    }
    let (mut sum, mut bytes, mut buffer) = (crc32fast::Hasher::new(), 0, vec![0; 1 << 20]);
    for (done, file) in files.iter().enumerate() {
        if bytes > most {
            break;
        }
        if folder {
            sum.update(file.file_name().unwrap_or_default().as_encoded_bytes());
        }
        let mut open = File::open(file).map_err(|e| Error::io(file, "open", e))?;
        loop {
            stage.at(done as f64 / files.len() as f64)?;
            match open.read(&mut buffer).map_err(|e| Error::io(file, "read", e))? {
                0 => break,
                read => {
                    sum.update(&buffer[..read]);
                    bytes += read as u64;
                }
            }
        }
    }
    Ok((bytes, sum.finalize()))
}
