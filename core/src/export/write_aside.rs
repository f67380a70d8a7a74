//! Single files, written aside and renamed: a reader sees the old file or the new one, never half of one.

use std::fs::File;
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::error::{Error, Result};

/// Writes `bytes` to `path`, whole or not at all. The folder it lies in must exist.
pub fn write_aside(path: impl AsRef<Path>, bytes: &[u8]) -> Result<()> {
    let mut file = Aside::begin(path)?;
    file.write(bytes)?;
    file.commit().map(drop)
}

/// Writes files that belong together into one folder, all or none of them. The folder must exist.
pub(super) fn write_all_aside<B: AsRef<[u8]>>(files: &[(PathBuf, B)]) -> Result<()> {
    let Some((first, _)) = files.first() else { return Ok(()) };
    for (path, _) in files {
        if path.is_dir() {
            return Err(Error::file(path, "is a folder", "give the name of a file"));
        }
        if path.file_name().is_none() {
            return Err(Error::file(path, "names no file", "give the name of a file"));
        }
    }
    let folder = match first.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(Error::file(folder, "is no folder to write into", "create it first or write elsewhere"));
    }
    // Inside a private folder of our own the files get the permissions that any new file would get here.
    let aside = super::folder::private_folder_in(folder)?;
    let staged = |i: usize| aside.path().join(format!("new{i}"));
    let old = |i: usize| aside.path().join(format!("old{i}"));
    for (i, (path, bytes)) in files.iter().enumerate() {
        std::fs::write(staged(i), bytes).map_err(|e| Error::io(path, "write", e))?;
    }
    for (i, (path, _)) in files.iter().enumerate() {
        // A lone file is replaced in one step; of several the old ones are kept until all are there.
        let replaced = if files.len() > 1 && path.exists() { std::fs::rename(path, old(i)) } else { Ok(()) };
        if let Err(error) = replaced.and_then(|()| std::fs::rename(staged(i), path)) {
            for (i, (path, _)) in files[..=i].iter().enumerate().rev() {
                // Nothing better can be done where even the way back fails; the first error says why.
                let _ = if old(i).exists() { std::fs::rename(old(i), path) } else { undo(path, &staged(i)) };
            }
            return Err(Error::io(path, "write", error));
        }
    }
    Ok(())
}

/// Takes back a file that was not there before, unless it never came.
fn undo(path: &Path, staged: &Path) -> std::io::Result<()> {
    if staged.exists() { Ok(()) } else { std::fs::remove_file(path) }
}

/// A file in the making. Dropped without [`Self::commit`] it leaves no trace.
#[derive(Debug)]
pub(super) struct Aside {
    target: PathBuf,
    /// Inside a private folder of our own the file gets the permissions that any new file would get there. Removed with all
    /// that is left in it on drop.
    folder: TempDir,
    staged: PathBuf,
    file: BufWriter<File>,
    length: u64,
}

impl Aside {
    /// A new file that will be `path`. The folder it lies in must exist.
    pub(super) fn begin(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        if path.is_dir() {
            return Err(Error::file(path, "is a folder", "give the name of a file"));
        }
        let Some(name) = path.file_name() else {
            return Err(Error::file(path, "names no file", "give the name of a file"));
        };
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(Error::file(folder, "is no folder to write into", "create it first or write elsewhere"));
        }
        let aside = super::folder::private_folder_in(folder)?;
        let staged = aside.path().join(name);
        let mut options = File::options();
        let file = options.read(true).write(true).create_new(true).open(&staged);
        let file = BufWriter::new(file.map_err(|e| Error::io(path, "write", e))?);
        Ok(Self { target: path.to_owned(), folder: aside, staged, file, length: 0 })
    }

    /// Adds to its end.
    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.length += bytes.len() as u64;
        self.file.write_all(bytes).map_err(|e| Error::io(&self.target, "write", e))
    }

    /// How much was written.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Writes over what was written before.
    pub(super) fn write_at(&mut self, place: u64, bytes: &[u8]) -> Result<()> {
        let mut write = || {
            self.file.seek(SeekFrom::Start(place))?;
            self.file.write_all(bytes)?;
            self.file.seek(SeekFrom::Start(self.length)).map(drop)
        };
        write().map_err(|e| Error::io(&self.target, "write", e))
    }

    /// Adds all that was written to another one.
    #[cfg(feature = "h264")]
    pub(super) fn append(&mut self, mut other: Self) -> Result<()> {
        let mut write = || {
            other.file.flush()?;
            let from = other.file.get_mut();
            from.seek(SeekFrom::Start(0))?;
            std::io::copy(&mut from.take(other.length), &mut self.file)
        };
        self.length += write().map_err(|e| Error::io(&self.target, "write", e))?;
        Ok(())
    }

    /// Puts it in its place, and says where that is.
    pub(super) fn commit(self) -> Result<PathBuf> {
        let Self { target, folder, staged, mut file, .. } = self;
        let put = || {
            file.flush()?;
            drop(file);
            std::fs::rename(&staged, &target)
        };
        put().map_err(|e| Error::io(&target, "write", e))?;
        drop(folder);
        Ok(target)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_whole_files_and_leaves_nothing_beside_them() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("motion.json");
        write_aside(&path, b"old and long").expect("written");
        write_aside(&path, b"new").expect("written");
        assert_eq!(std::fs::read(&path).expect("read"), b"new");
        assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 1);
    }

    #[test]
    fn refuses_what_is_no_place_for_a_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = folder.path().join("missing/motion.json");
        let error = write_aside(&missing, b"x").expect_err("there is no such folder");
        assert!(error.to_string().contains("missing"), "{error}");
        assert!(write_aside(folder.path(), b"x").is_err());
        assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 0);
    }
}
