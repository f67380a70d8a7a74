//! Output folders that appear whole or not at all.
//!
//! Everything is written into a hidden folder first and then renamed into place, so that a failure, a cancel or a
//! full disk leaves what was there before. A folder that is new is renamed as a whole. In one that exists only the
//! entries that are ours are replaced, one rename each, undone in reverse when one fails; whatever else lies in it is
//! left alone. Entries of our names in a folder that we did not write (it holds no report of ours) are somebody's
//! data, and the folder is refused.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::report;
use crate::error::{Error, Result};

/// The file that marks a folder as ours.
pub(super) const REPORT: &str = "report.json";

/// An output folder in the making. Dropped without [`Self::commit`] it leaves no trace.
#[derive(Debug)]
pub struct StagedFolder {
    target: PathBuf,
    /// Removed with all that is left in it on drop.
    aside: TempDir,
    staged: PathBuf,
    is_ours: fn(&str) -> bool,
}

impl StagedFolder {
    /// Prepares to write `target`. `is_ours` says which names at its top level are this output's.
    ///
    /// # Errors
    /// When `target` is a file, cannot be written to, or holds entries of those names and no report of ours.
    pub fn begin(target: impl AsRef<Path>, is_ours: fn(&str) -> bool) -> Result<Self> {
        let target = target.as_ref().to_owned();
        if target.exists() && !target.is_dir() {
            return Err(Error::file(&target, "is a file", "give the name of a folder"));
        }
        let ours = ours_in(&target, is_ours)?;
        if !ours.is_empty() && !has_report(&target) {
            return Err(Error::file(
                &target,
                format!("already holds `{}`, and no report that says it was written by this program", ours[0]),
                "choose another folder, or move that away",
            ));
        }
        // On the same file system as the target, or the renames would be copies.
        let beside =
            target.ancestors().skip(usize::from(!target.is_dir())).find(|p| p.is_dir() || p.as_os_str().is_empty());
        let beside = match beside {
            Some(p) if !p.as_os_str().is_empty() => p,
            _ => Path::new("."),
        };
        let aside = private_folder_in(beside).map_err(|e| match e {
            Error::Io { source, .. } => Error::io(&target, "write", source),
            other => other,
        })?;
        let staged = aside.path().join("new");
        std::fs::create_dir(&staged).map_err(|e| Error::io(&target, "write", e))?;
        Ok(Self { target, aside, staged, is_ours })
    }

    /// The folder aside that files are written into; it becomes the target, or part of it, when all are there.
    pub fn path(&self) -> &Path {
        &self.staged
    }

    /// Writes one file, at a path relative to the folder.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        std::fs::write(self.staged.join(name), bytes).map_err(|e| Error::io(self.target.join(name), "write", e))
    }

    /// Makes a folder in it.
    pub fn create_dir(&self, name: &str) -> Result<()> {
        std::fs::create_dir(self.staged.join(name)).map_err(|e| Error::io(self.target.join(name), "create", e))
    }

    /// Puts everything in place.
    pub fn commit(self) -> Result<()> {
        if self.target.is_dir() {
            return self.replace_entries();
        }
        let parent = self.target.parent().filter(|p| !p.as_os_str().is_empty());
        if let Some(parent) = parent {
            std::fs::create_dir_all(parent).map_err(|e| Error::io(parent, "create", e))?;
        }
        std::fs::rename(&self.staged, &self.target).map_err(|e| Error::io(&self.target, "write", e))
    }

    fn replace_entries(&self) -> Result<()> {
        let old = self.aside.path().join("old");
        std::fs::create_dir(&old).map_err(|e| Error::io(&self.target, "write", e))?;
        // The report goes last: while it is the old one, the folder is still known as ours.
        let last_report = |names: &mut Vec<String>| names.sort_by_key(|n| (n == REPORT, n.clone()));
        let mut leaving = ours_in(&self.target, self.is_ours)?;
        let mut coming = ours_in(&self.staged, |_| true)?;
        last_report(&mut leaving);
        last_report(&mut coming);
        let moves: Vec<(PathBuf, PathBuf)> = leaving
            .iter()
            .map(|name| (self.target.join(name), old.join(name)))
            .chain(coming.iter().map(|name| (self.staged.join(name), self.target.join(name))))
            .collect();
        for (done, (from, to)) in moves.iter().enumerate() {
            if let Err(error) = std::fs::rename(from, to) {
                for (from, to) in moves[..done].iter().rev() {
                    // Nothing better can be done where even the way back fails; the first error says why.
                    let _ = std::fs::rename(to, from);
                }
                return Err(Error::io(&self.target, "replace the outputs in", error));
            }
        }
        Ok(())
    }
}

/// A folder that only we use and that is removed on drop.
pub(super) fn private_folder_in(folder: &Path) -> Result<TempDir> {
    tempfile::Builder::new().prefix(".marey-").tempdir_in(folder).map_err(|e| Error::io(folder, "write into", e))
}

/// The names in `folder` that are ours, in order; none when it does not exist.
fn ours_in(folder: &Path, is_ours: fn(&str) -> bool) -> Result<Vec<String>> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|e| Error::io(folder, "read", e))? {
        let entry = entry.map_err(|e| Error::io(folder, "read", e))?;
        if let Some(name) = entry.file_name().to_str().filter(|n| is_ours(n)) {
            names.push(name.to_owned());
        }
    }
    names.sort();
    Ok(names)
}

fn has_report(folder: &Path) -> bool {
    #[derive(serde::Deserialize)]
    struct Mark {
        format: String,
    }
    std::fs::read_to_string(folder.join(REPORT))
        .ok()
        .and_then(|text| serde_json::from_str::<Mark>(&text).ok())
        .is_some_and(|mark| mark.format == report::FORMAT)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ours(name: &str) -> bool {
        name == "a" || name == "b" || name == REPORT
    }

    #[test]
    fn a_rename_that_fails_is_undone() {
        let root = tempfile::tempdir().expect("a folder");
        let target = root.path().join("out");
        let first = StagedFolder::begin(&target, ours).expect("begun");
        first.write("a", b"old").expect("written");
        first.write("b", b"old").expect("written");
        first.write(REPORT, br#"{"format":"marey-report"}"#).expect("written");
        first.commit().expect("put in place");
        std::fs::create_dir_all(target.join("c/full")).expect("a folder");

        let second = StagedFolder::begin(&target, ours).expect("begun");
        second.write("a", b"new").expect("written");
        // A file cannot take the place of a folder, and `c` is not ours to move away.
        second.write("c", b"new").expect("written");
        let error = second.commit().expect_err("c is in the way");
        assert!(error.to_string().contains("out"), "{error}");
        for name in ["a", "b"] {
            assert_eq!(std::fs::read(target.join(name)).expect("still there"), b"old");
        }
        let mut names = ours_in(&target, |_| true).expect("listed");
        names.sort();
        assert_eq!(names, ["a", "b", "c", REPORT]);
    }

    #[test]
    fn dropped_without_commit_it_leaves_no_trace() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = StagedFolder::begin(root.path().join("deep/out"), ours).expect("begun");
        folder.write("a", b"half").expect("written");
        drop(folder);
        assert_eq!(std::fs::read_dir(root.path()).expect("listed").count(), 0);
    }

    #[test]
    fn a_damaged_report_does_not_make_a_folder_ours() {
        let root = tempfile::tempdir().expect("a folder");
        for text in ["", "{\"format\":\"marey-rep", "[]", "{\"format\":\"other\"}"] {
            std::fs::write(root.path().join(REPORT), text).expect("written");
            assert!(StagedFolder::begin(root.path(), ours).is_err(), "{text}");
        }
    }
}
