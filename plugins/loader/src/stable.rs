//! From a file that anybody may write to a copy that nobody will: the only thing that is ever mapped.
//!
//! The system's loader knows a library by its name and by its inode: a new build under an old name, or a link to the
//! file that is loaded already, would give the old library. And a mapped file that is written to takes the host with
//! it. So each build is copied under a name that was never used, once its file has been left alone for a while.

use std::fs::{self, File};
use std::io::Read as _;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use sha2::{Digest as _, Sha256};

use crate::refusal::{Refusal, Status};

/// A larger library is a mistake.
const MAX_BYTES: u64 = 512 << 20;

/// What tells one build of a file from another without reading it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Fingerprint {
    size: u64,
    modified: Option<SystemTime>,
    inode: u64,
}

impl Fingerprint {
    pub(crate) fn of(file: &Path) -> Result<Self, Refusal> {
        let meta = fs::metadata(file).map_err(|e| {
            Refusal::file(Status::NotFound, file, format!("cannot be read: {e}"), "check its name and permissions")
        })?;
        if !meta.is_file() {
            return Err(Refusal::file(Status::Format, file, "is no ordinary file", "name a library"));
        }
        if meta.len() > MAX_BYTES {
            let problem = format!("has {} bytes, and at most {MAX_BYTES} are allowed", meta.len());
            return Err(Refusal::file(Status::Format, file, problem, "strip it of its debug information"));
        }
        Ok(Self { size: meta.len(), modified: meta.modified().ok(), inode: meta.ino() })
    }

    fn age(&self) -> Duration {
        self.modified.and_then(|m| SystemTime::now().duration_since(m).ok()).unwrap_or_default()
    }
}

/// A build of a file, read whole.
pub(crate) struct Build {
    pub(crate) bytes: Vec<u8>,
    /// SHA-256, in hexadecimal.
    pub(crate) hash: String,
    pub(crate) fingerprint: Fingerprint,
}

/// Reads `file` once it has been left alone for `settle`.
pub(crate) fn read(file: &Path, settle: Duration) -> Result<Build, Refusal> {
    let writing =
        || Refusal::file(Status::UnstableFile, file, "is being written", "it is loaded when it is left alone");
    let fingerprint = Fingerprint::of(file)?;
    let left = settle.saturating_sub(fingerprint.age());
    if !left.is_zero() {
        std::thread::sleep(left);
        if Fingerprint::of(file)? != fingerprint {
            return Err(writing());
        }
    }
    let denied = |e| Refusal::file(Status::NotFound, file, format!("cannot be read: {e}"), "check its permissions");
    let mut bytes = Vec::with_capacity(fingerprint.size as usize);
    File::open(file).and_then(|f| f.take(MAX_BYTES).read_to_end(&mut bytes)).map_err(denied)?;
    if Fingerprint::of(file)? != fingerprint || bytes.len() as u64 != fingerprint.size {
        return Err(writing());
    }
    let hash = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
    Ok(Build { bytes, hash, fingerprint })
}

/// The folder for the copies of one registry. Those that dead processes left are removed.
#[derive(Debug)]
pub(crate) struct CopyFolder(PathBuf);

impl CopyFolder {
    pub(crate) fn new(cache: &Path) -> Result<Self, Refusal> {
        let refuse = |e: std::io::Error| {
            Refusal::file(Status::Copy, cache, format!("cannot be written: {e}"), "choose another cache folder")
        };
        let all = cache.join("loaded");
        fs::create_dir_all(&all).map_err(refuse)?;
        for old in fs::read_dir(&all).map_err(refuse)?.flatten() {
            let name = old.file_name().to_string_lossy().into_owned();
            let process = name.split('-').next().and_then(|p| p.parse::<u32>().ok());
            if process.is_some_and(|p| !alive(p)) {
                let _ = fs::remove_dir_all(old.path());
            }
        }
        for number in 0.. {
            let folder = all.join(format!("{}-{number}", std::process::id()));
            match fs::create_dir(&folder) {
                Ok(()) => return Ok(Self(folder)),
                Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(refuse(e)),
            }
        }
        unreachable!("there is always a next number")
    }

    /// Writes the private copy of a build, as generation `number`.
    pub(crate) fn copy(&self, build: &Build, number: u64) -> Result<PathBuf, Refusal> {
        let path = self.0.join(format!("g{number}-{}.so", &build.hash[..8.min(build.hash.len())]));
        let refuse = |e: std::io::Error| {
            Refusal::file(Status::Copy, &path, format!("cannot be written: {e}"), "make room in the cache folder")
        };
        fs::write(&path, &build.bytes).map_err(refuse)?;
        fs::set_permissions(&path, fs::Permissions::from_mode(0o500)).map_err(refuse)?;
        Ok(path)
    }
}

impl Drop for CopyFolder {
    fn drop(&mut self) {
        // What is mapped stays mapped.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Whether a process of this number runs.
pub(crate) fn alive(process: u32) -> bool {
    // Without /proc nobody is known to be dead.
    !Path::new("/proc/self").exists() || Path::new(&format!("/proc/{process}")).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_in_the_making_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("a.so");
        fs::write(&file, b"one").expect("written");
        assert_eq!(read(&file, Duration::from_millis(20)).expect("settled").bytes, b"one");
        let writer = file.clone();
        let writing = std::thread::spawn(move || {
            for i in 0..40 {
                fs::write(&writer, vec![7; 100 + i]).expect("written");
                std::thread::sleep(Duration::from_millis(10));
            }
        });
        std::thread::sleep(Duration::from_millis(30));
        let refusal = read(&file, Duration::from_millis(200)).err().expect("refused");
        assert_eq!(refusal.status, Status::UnstableFile);
        writing.join().expect("written");
    }

    #[test]
    fn copies_of_the_dead_are_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let old = folder.path().join("loaded/4194999-0");
        fs::create_dir_all(&old).expect("a folder");
        let own = CopyFolder::new(folder.path()).expect("a folder");
        assert!(!old.exists() && own.0.exists());
        let kept = own.0.clone();
        drop(own);
        assert!(!kept.exists());
    }
}
