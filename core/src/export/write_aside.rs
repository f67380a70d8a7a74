//! Single files, written aside and renamed: a reader sees the old file or the new one, never half of one.

use std::path::Path;

use crate::error::{Error, Result};

/// Writes `bytes` to `path`, whole or not at all. The folder it lies in must exist.
pub fn write_aside(path: impl AsRef<Path>, bytes: &[u8]) -> Result<()> {
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
    // Inside a private folder of our own the file gets the permissions that any new file would get here.
    let aside = super::folder::private_folder_in(folder)?;
    let staged = aside.path().join(name);
    std::fs::write(&staged, bytes).map_err(|e| Error::io(path, "write", e))?;
    std::fs::rename(&staged, path).map_err(|e| Error::io(path, "write", e))
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
