//! What is remembered from one start to the next.
//!
//! A file that cannot be read is as good as none: nothing in it is a person's work. It is written aside and renamed.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::export::ExportSettings;
use crate::onion::Onion;
use crate::plugins::AllRemembered;
use crate::shortcuts::Chosen;

/// How many sessions are remembered.
const RECENT: usize = 12;

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Appearance {
    #[default]
    System,
    Light,
    Dark,
}

/// A session that was open before.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Recent {
    pub(crate) path: PathBuf,
    pub(crate) title: String,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Preferences {
    pub(crate) light: Appearance,
    /// The latest first.
    pub(crate) recent: Vec<Recent>,
    pub(crate) export: ExportSettings,
    /// Playing begins again at the end.
    pub(crate) once: bool,
    pub(crate) onion: Onion,
    /// Keys that were chosen.
    pub(crate) keys: Chosen,
    /// What was chosen about plugins.
    pub(crate) plugins: AllRemembered,
}

impl Preferences {
    pub(crate) fn read(path: &Path) -> Self {
        std::fs::read(path).ok().and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default()
    }

    pub(crate) fn write(&self, path: &Path) -> std::io::Result<()> {
        let mut aside = tempfile::NamedTempFile::new_in(path.parent().unwrap_or(Path::new(".")))?;
        serde_json::to_writer_pretty(&mut aside, self)?;
        aside.flush()?;
        aside.persist(path).map_err(|e| e.error)?;
        Ok(())
    }

    /// Puts a session first among the recent ones.
    pub(crate) fn remember(&mut self, path: &Path, title: &str) {
        self.recent.retain(|r| r.path != path);
        self.recent.insert(0, Recent { path: path.to_owned(), title: title.to_owned() });
        self.recent.truncate(RECENT);
    }

    /// What the session at a path was called.
    pub(crate) fn title(&self, path: &Path) -> Option<&str> {
        self.recent.iter().find(|r| r.path == path).map(|r| r.title.as_str())
    }

    pub(crate) fn forget(&mut self, path: &Path) {
        self.recent.retain(|r| r.path != path);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;

    #[test]
    fn what_is_remembered_comes_back_and_damage_costs_only_that() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("preferences.json");
        let mut preferences = Preferences { light: Appearance::Dark, ..Preferences::default() };
        for name in 0..RECENT + 4 {
            preferences.remember(Path::new(&format!("{name}.marey")), "walk");
        }
        preferences.remember(Path::new("7.marey"), "run");
        preferences.write(&path).unwrap();
        assert_eq!(Preferences::read(&path), preferences);
        let names: Vec<_> = preferences.recent.iter().map(|r| r.path.to_string_lossy().into_owned()).collect();
        assert_eq!(names[..3], ["7.marey", "15.marey", "14.marey"]);
        assert_eq!((names.len(), &*preferences.recent[0].title), (RECENT, "run"));

        std::fs::write(&path, "{\"light\": 3").unwrap();
        assert_eq!(Preferences::read(&path), Preferences::default());
        assert_eq!(Preferences::read(&folder.path().join("none.json")), Preferences::default());
    }
}
