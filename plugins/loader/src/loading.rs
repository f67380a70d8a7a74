//! From a file to a build that can be used, step by step. Nothing of it runs before it was looked at, and each step that
//! can fail has a status of its own.

use std::path::Path;
use std::sync::atomic::AtomicUsize;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};

use crate::discover::Candidate;
use crate::door::Opened;
use crate::elf::{self, Flaw};
use crate::generation::Generation;
use crate::library;
use crate::options::LogLevel;
use crate::probe::{self, ProbeMode};
use crate::refusal::{Refusal, Status};
use crate::registry::{Inner, Rescan, lock};
use crate::stable::{self, Build, Fingerprint};

impl Inner {
    /// Looks at a file; [`None`] where nothing about it is new.
    pub(crate) fn look(&self, candidate: &Candidate) -> Option<Rescan> {
        let _one = lock(&self.loading);
        let file = &candidate.file;
        let fingerprint = match Fingerprint::of(file) {
            Ok(fingerprint) => fingerprint,
            Err(refusal) => return self.refused(file, refusal),
        };
        if lock(&self.state).files.get(file).is_some_and(|f| f.fingerprint.as_ref() == Some(&fingerprint)) {
            return None;
        }
        let build = match stable::read(file, self.options.settle) {
            Ok(build) => build,
            Err(refusal) => return self.refused(file, refusal),
        };
        {
            let mut state = lock(&self.state);
            let known = state.files.entry(file.clone()).or_default();
            known.fingerprint = Some(build.fingerprint.clone());
            if known.hash.as_ref() == Some(&build.hash) {
                return None;
            }
            known.hash = Some(build.hash.clone());
        }
        match self.load(candidate, &build) {
            Ok(generation) => {
                let plugins: Vec<String> = generation.plugins.iter().map(|p| p.id.clone()).collect();
                let number = generation.number;
                self.publish(&generation);
                let line = format!("{}: loaded as build {number}: {}", file.display(), plugins.join(", "));
                (self.options.log)(LogLevel::Info, &line);
                Some(Rescan::Loaded { file: file.clone(), generation: number, plugins })
            }
            Err(refusal) => {
                if matches!(refusal.status, Status::Crashed | Status::Timeout | Status::Panicked) {
                    self.quarantine.strike(&build.hash, &refusal.problem);
                }
                // Quarantine may end, and a copy may succeed, without any change of the file.
                if matches!(refusal.status, Status::Copy | Status::Generations)
                    && let Some(known) = lock(&self.state).files.get_mut(file)
                {
                    (known.fingerprint, known.hash) = (None, None);
                }
                self.refused(file, refusal)
            }
        }
    }

    /// What can be said of a file without mapping it: it is the one that its manifest describes, and a whole library.
    pub(crate) fn look_at_bytes(candidate: &Candidate, build: &Build) -> Result<(), Refusal> {
        let file = &candidate.file;
        if let Some(expected) = &candidate.sha256
            && *expected != build.hash
        {
            let remedy = "install the bundle again, or leave sha256 out of plugin.json while you write it";
            return Err(Refusal::file(Status::Hash, file, "is not the file that its plugin.json describes", remedy));
        }
        elf::check(&build.bytes).map_err(|flaw| match flaw {
            Flaw::Truncated(what) => {
                Refusal::file(Status::Truncated, file, format!("is cut off: {what}"), "get it again")
            }
            Flaw::Format(what) => {
                let remedy = "name a library built for this machine";
                Refusal::file(Status::Format, file, format!("is no plugin: {what}"), remedy)
            }
        })
    }

    /// The steps from a file's bytes to a build that can be used. Nothing of it runs before it was looked at.
    fn load(&self, candidate: &Candidate, build: &Build) -> Result<Arc<Generation>, Refusal> {
        let file = &candidate.file;
        Self::look_at_bytes(candidate, build)?;
        self.quarantine.check(file, &build.hash)?;
        let number = {
            let state = lock(&self.state);
            let count = state.generations.len();
            if count >= self.options.max_generations {
                let remedy = "start the program again: what is loaded cannot be unloaded";
                return Err(Refusal::file(Status::Generations, file, format!("{count} builds are loaded"), remedy));
            }
            state.generations.last().map_or(1, |g| g.number + 1)
        };
        let copy = self.copies.copy(build, number)?;
        let loaded = self.load_copy(candidate, build, &copy, number);
        // What is mapped stays mapped; the name is never used again.
        let _ = std::fs::remove_file(&copy);
        loaded
    }

    fn load_copy(
        &self,
        candidate: &Candidate,
        build: &Build,
        copy: &Path,
        number: u64,
    ) -> Result<Arc<Generation>, Refusal> {
        let file = &candidate.file;
        let deadline = self.options.load_deadline;
        if let Some(program) = &self.options.probe
            && !self.quarantine.was_tried(&build.hash)
        {
            probe::run(program, ProbeMode::Load, copy, file, deadline)?;
            self.quarantine.tried(&build.hash);
        }
        let _note = self.quarantine.loading(&build.hash);
        // On a thread of its own, so that a library that hangs while it starts does not take the host's thread.
        let (done, wait) = channel();
        let (own_copy, own_file, log) = (copy.to_owned(), file.clone(), self.options.log.clone());
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let line = move |level: i32, line: &str| {
            let level = match level {
                marey_plugin::raw::LOG_ERROR => LogLevel::Error,
                marey_plugin::raw::LOG_WARNING => LogLevel::Warning,
                _ => LogLevel::Info,
            };
            log(level, &format!("{name}: {line}"));
        };
        let door = self.options.door;
        let run = move || {
            let opened = library::open(&own_copy, &own_file, door, Box::new(line));
            let tried = opened.and_then(|opened| library::smoke(&opened, &own_file).map(|()| opened));
            let _ = done.send(tried);
        };
        let cannot = |e: std::io::Error| {
            Refusal::file(Status::Copy, file, format!("no thread can be started: {e}"), "close other programs")
        };
        std::thread::Builder::new().name("plugin loading".to_owned()).spawn(run).map_err(cannot)?;
        let opened: Opened = wait.recv_timeout(deadline).unwrap_or_else(|_| {
            let problem = format!("was not loaded after {:.0} s", deadline.as_secs_f64());
            Err(Refusal::file(Status::Timeout, file, problem, "tell its author"))
        })?;
        if let Some(id) = &candidate.id
            && !opened.plugins.iter().any(|p| p.id == *id)
        {
            let problem = format!("holds no plugin `{id}`, which its plugin.json names");
            return Err(Refusal::file(Status::Descriptor, file, problem, "make the two agree"));
        }
        {
            let state = lock(&self.state);
            for plugin in &opened.plugins {
                if let Some(known) = state.plugins.get(&plugin.id)
                    && known.current.file != *file
                {
                    let problem = format!("`{}` is loaded already, from {}", plugin.id, known.current.file.display());
                    return Err(Refusal::file(Status::Descriptor, file, problem, "remove one of the two"));
                }
            }
        }
        Ok(Arc::new(Generation {
            number,
            file: file.clone(),
            hash: build.hash.clone(),
            bytes: build.bytes.len() as u64,
            door: opened.door,
            kind: opened.kind,
            plugins: opened.plugins,
            instances: AtomicUsize::new(0),
            stages: Mutex::default(),
        }))
    }
}
