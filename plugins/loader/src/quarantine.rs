//! Files that failed too often, remembered by their bytes: a new build starts afresh.
//!
//! What is being loaded is noted on the disk before and struck out after. A note of a process that is gone tells of a
//! file that took its host with it, which nobody else could report.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::refusal::{Refusal, Status};
use crate::stable::alive;

/// What a file did.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
struct Record {
    strikes: u32,
    last: String,
}

/// The list, shared by all processes that use one cache.
#[derive(Debug)]
pub(crate) struct Quarantine {
    folder: PathBuf,
    limit: u32,
    lock: Mutex<()>,
}

/// A file is being loaded, until this is dropped.
#[derive(Debug)]
pub(crate) struct Loading(PathBuf);

impl Drop for Loading {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

impl Quarantine {
    pub(crate) fn new(cache: &Path, limit: u32) -> Self {
        let quarantine = Self { folder: cache.to_owned(), limit, lock: Mutex::new(()) };
        quarantine.read_notes();
        quarantine
    }

    fn list(&self) -> PathBuf {
        self.folder.join("quarantine.json")
    }

    fn read(&self) -> BTreeMap<String, Record> {
        // A list that is lost or damaged only means that files are tried again.
        fs::read(self.list()).ok().and_then(|b| serde_json::from_slice(&b).ok()).unwrap_or_default()
    }

    fn change(&self, change: impl FnOnce(&mut BTreeMap<String, Record>)) {
        let _lock = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
        let mut list = self.read();
        change(&mut list);
        let aside = self.folder.join(format!("quarantine.{}.tmp", std::process::id()));
        let text = serde_json::to_string_pretty(&list).unwrap_or_default();
        // A cache that cannot be written to forgets; loading itself will say so.
        if fs::write(&aside, text).is_ok() {
            let _ = fs::rename(&aside, self.list());
        }
    }

    /// Refuses a file that failed too often.
    pub(crate) fn check(&self, file: &Path, hash: &str) -> Result<(), Refusal> {
        match self.read().get(hash) {
            Some(record) if record.strikes >= self.limit => {
                let problem = format!("failed {} times, the last time: {}", record.strikes, record.last);
                let remedy = "get another build of it, or take it out of quarantine to try again";
                Err(Refusal::file(Status::Quarantined, file, problem, remedy))
            }
            _ => Ok(()),
        }
    }

    /// Notes a failure; gives how many there are now.
    pub(crate) fn strike(&self, hash: &str, what: &str) -> u32 {
        let _ = fs::remove_file(self.tried_note(hash));
        let mut strikes = 0;
        self.change(|list| {
            let record = list.entry(hash.to_owned()).or_default();
            record.strikes += 1;
            record.last = what.to_owned();
            strikes = record.strikes;
        });
        strikes
    }

    /// Lets a file start afresh.
    pub(crate) fn forgive(&self, hash: &str) {
        self.change(|list| drop(list.remove(hash)));
    }

    /// Whether a file was tried in another process before, and was good. Another version of the host tries it anew.
    pub(crate) fn was_tried(&self, hash: &str) -> bool {
        self.tried_note(hash).exists()
    }

    /// Notes that a file was tried in another process, and was good.
    pub(crate) fn tried(&self, hash: &str) {
        let note = self.tried_note(hash);
        // Without the note it is only tried again.
        let _ = note.parent().map(fs::create_dir_all);
        let _ = fs::write(note, "");
    }

    fn tried_note(&self, hash: &str) -> PathBuf {
        self.folder.join("tried").join(format!("{hash}-{}", env!("CARGO_PKG_VERSION")))
    }

    /// Notes that a file is being loaded.
    pub(crate) fn loading(&self, hash: &str) -> Loading {
        let note = self.folder.join(format!("loading-{}-{hash}", std::process::id()));
        let _ = fs::write(&note, "");
        Loading(note)
    }

    /// Strikes the files that took their host with them.
    fn read_notes(&self) {
        let Ok(entries) = fs::read_dir(&self.folder) else { return };
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let Some((process, hash)) = name.strip_prefix("loading-").and_then(|n| n.split_once('-')) else { continue };
            // Who removes the note counts it, once.
            if process.parse().is_ok_and(|p: u32| !alive(p)) && fs::remove_file(entry.path()).is_ok() {
                self.strike(hash, "the host ended while it was being loaded");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_strikes_and_forgiveness() {
        let folder = tempfile::tempdir().expect("a folder");
        let quarantine = Quarantine::new(folder.path(), 3);
        let file = Path::new("x.so");
        quarantine.tried("abc");
        assert!(quarantine.was_tried("abc") && !quarantine.was_tried("other"));
        for expected in 1..=3 {
            assert!(quarantine.check(file, "abc").is_ok());
            assert_eq!(quarantine.strike("abc", "it hung"), expected);
        }
        assert!(!quarantine.was_tried("abc"), "what failed is tried again");
        let again = Quarantine::new(folder.path(), 3);
        let refusal = again.check(file, "abc").expect_err("refused");
        assert_eq!(refusal.status, Status::Quarantined);
        assert!(refusal.to_string().contains("it hung"), "{refusal}");
        assert!(again.check(file, "other").is_ok());
        again.forgive("abc");
        assert!(quarantine.check(file, "abc").is_ok());
    }

    #[test]
    fn a_host_that_died_while_loading_is_a_strike() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("loading-4194999-abc"), "").expect("written");
        fs::write(folder.path().join(format!("loading-{}-def", std::process::id())), "").expect("written");
        let quarantine = Quarantine::new(folder.path(), 1);
        assert!(quarantine.check(Path::new("x"), "abc").is_err());
        assert!(quarantine.check(Path::new("x"), "def").is_ok());
    }
}
