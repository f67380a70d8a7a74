//! Folders of the program's own.

use std::path::{Path, PathBuf};

use crate::texts;

/// Where the program keeps what is not a person's file yet.
#[derive(Clone, Debug)]
pub struct Places {
    /// Sessions without a name.
    pub(crate) unsaved: PathBuf,
    /// Clips of samples.
    pub(crate) samples: PathBuf,
    /// What is remembered.
    pub(crate) preferences: PathBuf,
    /// Where a person puts plugins.
    pub(crate) plugins: PathBuf,
    /// Their private copies; none for where the environment says, and then it names more folders with plugins too.
    pub(crate) plugin_cache: Option<PathBuf>,
    /// The program that tries plugins in another process.
    pub(crate) probe: Option<PathBuf>,
    /// Where exports go until another folder was chosen.
    pub(crate) home: PathBuf,
}

impl Places {
    /// In the user's folder for data of programs.
    ///
    /// # Errors
    /// There is none, or it cannot be written to; for a person.
    pub fn of_user() -> Result<Self, String> {
        let of = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let home = of(if cfg!(windows) { "USERPROFILE" } else { "HOME" });
        let data = if cfg!(windows) {
            of("APPDATA")
        } else if cfg!(target_os = "macos") {
            home.as_ref().map(|home| home.join("Library/Application Support"))
        } else {
            of("XDG_DATA_HOME").or_else(|| home.as_ref().map(|home| home.join(".local/share")))
        };
        let data = data.ok_or(texts::NO_HOME)?;
        let places = Self::in_folder(&data.join("marey-studio"), home.as_deref().unwrap_or(&data))?;
        // This program tries plugins for itself, in a process of their own.
        let probe = std::env::current_exe().ok();
        Ok(Self { plugins: data.join("marey/plugins"), plugin_cache: None, probe, ..places })
    }

    /// The same, with a program that tries plugins in another process before they are loaded.
    #[must_use]
    pub fn with_probe(self, program: &Path) -> Self {
        Self { probe: Some(program.to_owned()), ..self }
    }

    /// In a folder, which is made.
    ///
    /// # Errors
    /// It cannot be written to; for a person.
    pub fn in_folder(folder: &Path, home: &Path) -> Result<Self, String> {
        let places = Self {
            unsaved: folder.join("unsaved"),
            samples: folder.join("samples"),
            preferences: folder.join("preferences.json"),
            plugins: folder.join("plugins"),
            plugin_cache: Some(folder.join("plugin-cache")),
            probe: None,
            home: home.to_owned(),
        };
        let made = [&places.unsaved, &places.samples, &places.plugins];
        for made in made.into_iter().chain(&places.plugin_cache) {
            std::fs::create_dir_all(made).map_err(|e| texts::no_folder(made, &e))?;
        }
        Ok(places)
    }
}
