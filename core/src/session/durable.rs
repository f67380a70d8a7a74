//! Files that are replaced whole and stay replaced: written aside, synced, renamed, and the folder synced, so that
//! neither a crash of the program nor of the machine leaves half a file or takes a finished one back.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Puts a file of these bytes at `path`. The caller holds the lock on it, so the name aside is its own.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    let aside = beside(path, "-new");
    let mut file = File::create(&aside).map_err(|e| Error::io(&aside, "create", e))?;
    let written = file.write_all(bytes).and_then(|()| file.sync_all()).map_err(|e| Error::io(path, "write", e));
    let renamed = written.and_then(|()| std::fs::rename(&aside, path).map_err(|e| Error::io(path, "replace", e)));
    if renamed.is_err() {
        // The error that is returned says more than one about the remains would.
        let _ = std::fs::remove_file(&aside);
    }
    renamed?;
    sync_folder(path)
}

/// Makes the names in the folder of `path` durable.
pub(super) fn sync_folder(path: &Path) -> Result<()> {
    // Only Unix opens folders; elsewhere the rename itself is all there is.
    if cfg!(unix) {
        let folder = folder_of(path);
        File::open(folder).and_then(|f| f.sync_all()).map_err(|e| Error::io(folder, "sync", e))?;
    }
    Ok(())
}

/// The folder that `path` lies in.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The path with `suffix` behind its file name.
pub(super) fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}
