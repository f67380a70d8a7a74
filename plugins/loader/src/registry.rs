//! All plugins of a host: what was found, what is loaded, what was chosen, what failed and why.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::describe::{PluginInfo, PluginKind};
use crate::discover;
use crate::door::DoorKind;
use crate::generation::Generation;
use crate::options::{LogLevel, Options};
use crate::probe::{self, ProbeMode};
use crate::quarantine::Quarantine;
use crate::refusal::{Refusal, Status};
use crate::slot::{Policy, Slot};
use crate::stable::{self, CopyFolder, Fingerprint};
use crate::values::{self, Chosen, Value};

/// A slow plugin takes its time on a dozen scenes.
const CHECK_DEADLINE: std::time::Duration = std::time::Duration::from_secs(300);

/// All plugins of a host. Clones are the same registry; threads may share it.
#[derive(Clone)]
pub struct Registry(Arc<Inner>);

impl std::fmt::Debug for Registry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Registry").field("options", &self.0.options).finish_non_exhaustive()
    }
}

/// What a look at a file came to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rescan {
    /// The file, or a new build of it, is loaded as this build, with these plugins.
    Loaded {
        /// The file.
        file: PathBuf,
        /// The number of the build.
        generation: u64,
        /// What is inside.
        plugins: Vec<String>,
    },
    /// The file is not there any more. What was loaded from it stays with those who use it.
    Gone {
        /// The file.
        file: PathBuf,
    },
    /// The file, or its new build, is not loaded. An older build of it stays.
    Refused {
        /// The file.
        file: PathBuf,
        /// Why.
        refusal: Refusal,
    },
}

/// A plugin that is loaded.
#[derive(Clone, Debug)]
pub struct Listed {
    /// What it says of itself.
    pub info: PluginInfo,
    /// The file it came from.
    pub file: PathBuf,
    /// By which door.
    pub door: DoorKind,
    /// The number of the newest build.
    pub generation: u64,
    /// How many instances there are, of all builds.
    pub instances: usize,
    /// Why it is switched off, where it is.
    pub disabled: Option<String>,
}

/// What the registry's clones and slots share.
pub(crate) struct Inner {
    pub(crate) options: Options,
    pub(crate) copies: CopyFolder,
    pub(crate) quarantine: Quarantine,
    /// One file is loaded at a time.
    pub(crate) loading: Mutex<()>,
    pub(crate) state: Mutex<State>,
}

#[derive(Default)]
pub(crate) struct State {
    pub(crate) files: BTreeMap<PathBuf, FileState>,
    pub(crate) plugins: BTreeMap<String, Known>,
    pub(crate) generations: Vec<Arc<Generation>>,
    left: Vec<Left>,
}

#[derive(Default)]
pub(crate) struct FileState {
    /// Of the build that was looked at last.
    pub(crate) fingerprint: Option<Fingerprint>,
    pub(crate) hash: Option<String>,
    /// Why that build is not loaded, where it is not.
    pub(crate) refusal: Option<Refusal>,
}

pub(crate) struct Known {
    pub(crate) current: Arc<Generation>,
    index: usize,
    chosen: Chosen,
    revision: u64,
    disabled: Option<String>,
}

/// An instance that did not stop at a cancel.
pub(crate) struct Left {
    id: String,
    generation: Arc<Generation>,
    since: Instant,
    ended: Arc<AtomicBool>,
}

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unknown(id: &str) -> Refusal {
    let remedy = "`marey plugin list` shows what there is";
    Refusal::new(Status::NotFound, format!("plugin {id}"), "is not loaded", remedy)
}

impl Registry {
    /// A registry without plugins; [`Self::rescan`] looks for them.
    ///
    /// # Errors
    /// The cache folder cannot be written.
    pub fn new(options: Options) -> Result<Self, Refusal> {
        let copies = CopyFolder::new(&options.cache)?;
        let quarantine = Quarantine::new(&options.cache, options.strikes);
        Ok(Self(Arc::new(Inner { options, copies, quarantine, loading: Mutex::new(()), state: Mutex::default() })))
    }

    /// Looks through the folders: loads what is new and new builds of what is known, and says what changed. A file
    /// that has not changed since it was refused is not mentioned again.
    pub fn rescan(&self) -> Vec<Rescan> {
        let found = discover::discover(&self.0.options.folders);
        let mut changes = Vec::new();
        let mut present = Vec::new();
        for candidate in found {
            match candidate {
                Ok(candidate) => {
                    present.push(candidate.file.clone());
                    changes.extend(self.0.look(&candidate));
                }
                Err(refusal) => {
                    let file = PathBuf::from(&refusal.what);
                    present.push(file.clone());
                    changes.extend(self.0.refused(&file, refusal));
                }
            }
        }
        // Files that were named, and those of folders that are not looked in, are not missed.
        let folders: Vec<PathBuf> = self.0.options.folders.iter().filter_map(|f| f.canonicalize().ok()).collect();
        let mut state = lock(&self.0.state);
        let files: Vec<PathBuf> = state.files.keys().cloned().collect();
        for file in files {
            if !present.contains(&file) && folders.iter().any(|f| file.starts_with(f)) {
                state.files.remove(&file);
                state.plugins.retain(|_, known| known.current.file != file);
                changes.push(Rescan::Gone { file });
            }
        }
        changes
    }

    /// Loads a library or a bundle by its name; one that is loaded already is looked at again.
    ///
    /// # Errors
    /// It is not loaded, for this reason.
    pub fn load(&self, path: &Path) -> Result<Vec<String>, Refusal> {
        let candidate = discover::named(path)?;
        match self.0.look(&candidate) {
            Some(Rescan::Refused { refusal, .. }) => return Err(refusal),
            Some(Rescan::Loaded { plugins, .. }) => return Ok(plugins),
            Some(Rescan::Gone { .. }) | None => {}
        }
        let state = lock(&self.0.state);
        if let Some(refusal) = state.files.get(&candidate.file).and_then(|f| f.refusal.clone()) {
            return Err(refusal);
        }
        let of_file = state.plugins.iter().filter(|(_, known)| known.current.file == candidate.file);
        Ok(of_file.map(|(id, _)| id.clone()).collect())
    }

    /// Puts a library or a bundle through the conformance suite, in another process where there is a probe, and gives
    /// the report. Nothing of it is loaded here then.
    ///
    /// # Errors
    /// It cannot even be loaded, or it ended the process that tried it.
    pub fn check(&self, path: &Path) -> Result<serde_json::Value, Refusal> {
        let candidate = discover::named(path)?;
        let build = stable::read(&candidate.file, self.0.options.settle)?;
        Inner::look_at_bytes(&candidate, &build)?;
        let copy = self.0.copies.copy(&build, 0)?;
        let report = match &self.0.options.probe {
            Some(program) => probe::run(program, ProbeMode::Check, &copy, &candidate.file, CHECK_DEADLINE),
            None => crate::conformance::run(&copy, &copy.with_extension("check")),
        };
        let _ = std::fs::remove_file(&copy);
        report
    }

    /// The plugins that are loaded, by their ids.
    pub fn plugins(&self) -> Vec<Listed> {
        let state = lock(&self.0.state);
        let instances = |id: &str| {
            let of = |g: &&Arc<Generation>| g.plugins.iter().any(|p| p.id == id);
            state.generations.iter().filter(of).map(|g| g.count()).sum()
        };
        let listed = state.plugins.iter().map(|(id, known)| Listed {
            info: known.current.plugins[known.index].clone(),
            file: known.current.file.clone(),
            door: known.current.kind,
            generation: known.current.number,
            instances: instances(id),
            disabled: known.disabled.clone(),
        });
        listed.collect()
    }

    /// The files whose newest build is not loaded, and why.
    pub fn failures(&self) -> Vec<(PathBuf, Refusal)> {
        let state = lock(&self.0.state);
        state.files.iter().filter_map(|(file, f)| Some((file.clone(), f.refusal.clone()?))).collect()
    }

    /// How many builds are loaded that nobody uses any more, and the bytes of their files. They stay loaded.
    pub fn retired(&self) -> (usize, u64) {
        let state = lock(&self.0.state);
        let current = |g: &Arc<Generation>| state.plugins.values().any(|k| Arc::ptr_eq(&k.current, g));
        let retired = state.generations.iter().filter(|g| g.count() == 0 && !current(g));
        retired.fold((0, 0), |(count, bytes), g| (count + 1, bytes + g.bytes))
    }

    /// A place for the plugin `id` to work in.
    ///
    /// # Errors
    /// There is no such plugin, it is of another kind, or it is switched off.
    pub fn slot(&self, id: &str, kind: PluginKind, policy: Policy) -> Result<Slot, Refusal> {
        self.0.current(id, kind)?;
        Ok(Slot::new(self.0.clone(), id, kind, policy))
    }

    /// Chooses a parameter's value, for instances that are made from now on.
    ///
    /// # Errors
    /// There is no such plugin or parameter, or it does not take the value.
    pub fn choose(&self, id: &str, parameter: &str, value: Value) -> Result<(), Refusal> {
        let mut state = lock(&self.0.state);
        let known = state.plugins.get_mut(id).ok_or_else(|| unknown(id))?;
        values::check(&known.current.plugins[known.index], parameter, &value)?;
        if known.chosen.get(parameter) != Some(&value) {
            known.chosen.insert(parameter.to_owned(), value);
            known.revision += 1;
        }
        Ok(())
    }

    /// A parameter's value: what was chosen, or the default.
    ///
    /// # Errors
    /// There is no such plugin or parameter.
    pub fn value(&self, id: &str, parameter: &str) -> Result<Value, Refusal> {
        let state = lock(&self.0.state);
        let known = state.plugins.get(id).ok_or_else(|| unknown(id))?;
        let all = values::complete(&known.current.plugins[known.index], &known.chosen);
        let found = all.into_iter().find(|(name, _)| name == parameter).map(|(_, value)| value);
        found.ok_or_else(|| {
            let what = format!("parameter `{parameter}` of {id}");
            Refusal::new(Status::NotFound, what, "is not known", "see what the plugin declares")
        })
    }

    /// Switches a plugin off, or on again: also one that hung. Slots that are at work are not disturbed.
    ///
    /// # Errors
    /// There is no such plugin.
    pub fn set_enabled(&self, id: &str, enabled: bool) -> Result<(), Refusal> {
        let mut state = lock(&self.0.state);
        let known = state.plugins.get_mut(id).ok_or_else(|| unknown(id))?;
        known.disabled = (!enabled).then(|| "switched off by the user".to_owned());
        Ok(())
    }

    /// Takes a file out of quarantine, and tries it again at the next look.
    pub fn retry(&self, file: &Path) {
        let mut state = lock(&self.0.state);
        let full = file.canonicalize().unwrap_or_else(|_| file.to_owned());
        if let Some(known) = state.files.get_mut(&full) {
            if let Some(hash) = known.hash.take() {
                self.0.quarantine.forgive(&hash);
            }
            known.fingerprint = None;
        }
    }
}

impl Inner {
    /// The newest build of a plugin that may be used: its place, what was chosen, and how often.
    pub(crate) fn current(&self, id: &str, kind: PluginKind) -> Result<(Arc<Generation>, usize, Chosen, u64), Refusal> {
        self.judge_left();
        let state = lock(&self.state);
        let known = state.plugins.get(id).ok_or_else(|| unknown(id))?;
        let what = format!("plugin {id}");
        let own = known.current.plugins[known.index].kind;
        if own != kind {
            let (own, kind) = (format!("{own:?}").to_lowercase(), format!("{kind:?}").to_lowercase());
            return Err(Refusal::new(Status::NotFound, what, format!("is a {own}, not a {kind}"), "choose another"));
        }
        if let Some(why) = &known.disabled {
            return Err(Refusal::new(Status::Disabled, what, format!("is off: {why}"), "choose another, or enable it"));
        }
        Ok((known.current.clone(), known.index, known.chosen.clone(), known.revision))
    }

    /// Notes a failure of a build at work; `off` switches the plugin off until the host is started again.
    pub(crate) fn strike(&self, id: &str, generation: &Generation, what: &str, off: bool) {
        let strikes = self.quarantine.strike(&generation.hash, what);
        let limit = self.options.strikes;
        (self.options.log)(LogLevel::PluginMisbehaving, &format!("plugin {id}: {what} (strike {strikes} of {limit})"));
        let mut state = lock(&self.state);
        if let Some(known) = state.plugins.get_mut(id)
            && known.current.number == generation.number
            && (off || strikes >= limit)
        {
            known.disabled = Some(format!("it failed {strikes} times, the last time: {what}"));
        }
    }

    /// Remembers an instance that did not stop at a cancel.
    pub(crate) fn leave(&self, id: &str, generation: &Arc<Generation>, ended: Arc<AtomicBool>) {
        let left = Left { id: id.to_owned(), generation: generation.clone(), since: Instant::now(), ended };
        lock(&self.state).left.push(left);
    }

    /// Strikes the plugins whose instances never stopped after a cancel.
    fn judge_left(&self) {
        let mut late = Vec::new();
        lock(&self.state).left.retain(|left| {
            if left.ended.load(Ordering::Acquire) {
                return false;
            }
            let over = left.since.elapsed() >= self.options.silence;
            if over {
                late.push((left.id.clone(), left.generation.clone()));
            }
            !over
        });
        for (id, generation) in late {
            self.strike(&id, &generation, "did not stop when it was cancelled", true);
        }
    }

    pub(crate) fn refused(&self, file: &Path, refusal: Refusal) -> Option<Rescan> {
        let mut state = lock(&self.state);
        let known = state.files.entry(file.to_owned()).or_default();
        if known.refusal.as_ref() == Some(&refusal) {
            return None;
        }
        (self.options.log)(LogLevel::Warning, &refusal.to_string());
        known.refusal = Some(refusal.clone());
        Some(Rescan::Refused { file: file.to_owned(), refusal })
    }

    /// Makes a build the newest of its plugins, all at once.
    pub(crate) fn publish(&self, generation: &Arc<Generation>) {
        let mut state = lock(&self.state);
        state.generations.push(generation.clone());
        if let Some(known) = state.files.get_mut(&generation.file) {
            known.refusal = None;
        }
        let ids: Vec<&str> = generation.plugins.iter().map(|p| p.id.as_str()).collect();
        state.plugins.retain(|id, known| known.current.file != generation.file || ids.contains(&id.as_str()));
        for (index, plugin) in generation.plugins.iter().enumerate() {
            let current = generation.clone();
            match state.plugins.get_mut(&plugin.id) {
                // A new build starts afresh; what the user chose stays.
                Some(known) => (known.current, known.index, known.disabled) = (current, index, None),
                None => {
                    let known = Known { current, index, chosen: Chosen::new(), revision: 0, disabled: None };
                    state.plugins.insert(plugin.id.clone(), known);
                }
            }
        }
    }
}
