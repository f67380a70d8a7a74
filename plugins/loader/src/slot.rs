//! A place for a plugin to work in: an instance of a build, exchanged for one of a newer build between two calls.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use marey::job::Stage;

use crate::describe::{PluginInfo, PluginKind};
use crate::door::{Fault, FaultKind, Instance};
use crate::generation::Generation;
use crate::options::LogLevel;
use crate::post::Post;
use crate::refusal::{Refusal, Status};
use crate::registry::Inner;
use crate::values;
use crate::worker::{Stop, Worker};

/// What happens to an instance when a newer build of its plugin is loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// It stays; new slots take the newer build.
    Keep,
    /// One of the newer build takes its place before the next call, with its state. Where that fails, it stays.
    Migrate,
    /// It ends; the next call takes the newer build without the old one's state.
    Drop,
}

/// What an instance of a newer build took over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carried {
    /// Its state, and the values of its parameters.
    State,
    /// The values of its parameters.
    Parameters,
    /// Nothing: it has the defaults.
    Defaults,
}

/// An instance at work.
pub(crate) struct Live {
    pub(crate) generation: Arc<Generation>,
    pub(crate) info: PluginInfo,
    pub(crate) worker: Arc<Worker>,
    /// How often values had been chosen when it was made.
    revision: u64,
}

#[derive(Default)]
struct State {
    live: Option<Live>,
    /// The newest build that could not take over.
    refused: u64,
    carried: Option<Carried>,
}

/// A place for a plugin to work in. It is a tracker, a segmenter or a deformer to the engine; calls come one at a time.
pub struct Slot {
    pub(crate) registry: Arc<Inner>,
    pub(crate) id: String,
    pub(crate) kind: PluginKind,
    policy: Policy,
    state: Mutex<State>,
}

impl std::fmt::Debug for Slot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Slot").field("id", &self.id).field("kind", &self.kind).finish_non_exhaustive()
    }
}

impl Slot {
    pub(crate) fn new(registry: Arc<Inner>, id: &str, kind: PluginKind, policy: Policy) -> Self {
        Self { registry, id: id.to_owned(), kind, policy, state: Mutex::default() }
    }

    /// The plugin's id.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// The number of the build that the instance is of; [`None`] before the first call and after a failure.
    pub fn generation(&self) -> Option<u64> {
        self.lock().live.as_ref().map(|l| l.generation.number)
    }

    /// What the instance took over from the one before it, once one took over.
    pub fn carried(&self) -> Option<Carried> {
        self.lock().carried
    }

    /// Makes the instance now, or exchanges it, instead of at the next call.
    ///
    /// # Errors
    /// There is no such plugin any more, or its instance cannot be made.
    pub fn renew(&self) -> Result<(), Refusal> {
        self.renewed(&mut self.lock()).map(|_| ())
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The instance for a call, made or exchanged as the policy says.
    fn renewed<'a>(&self, state: &'a mut State) -> Result<&'a Live, Refusal> {
        let (current, index, chosen, revision) = self.registry.current(&self.id, self.kind)?;
        let fits = state.live.as_ref().is_some_and(|live| {
            let newest = live.generation.number == current.number
                || self.policy == Policy::Keep
                || self.policy == Policy::Migrate && state.refused == current.number;
            newest && live.revision == revision
        });
        if !fits {
            match (state.live.take(), self.policy) {
                (Some(old), Policy::Migrate) if old.revision == revision => {
                    match self.migrate(&old, &current, index, &chosen, revision) {
                        Ok((live, carried)) => {
                            (state.live, state.carried) = (Some(live), Some(carried));
                        }
                        Err(why) => {
                            state.refused = current.number;
                            let line = format!("{why}; the build before it goes on");
                            (self.registry.options.log)(LogLevel::Warning, &line);
                            state.live = Some(old);
                        }
                    }
                }
                (Some(old), Policy::Keep) if old.generation.number != current.number => {
                    // Other values, the same build.
                    let generation = old.generation.clone();
                    let at = generation.plugins.iter().position(|p| p.id == self.id).unwrap_or(index);
                    state.live = Some(self.create(&generation, at, &chosen, revision)?);
                }
                (_, _) => state.live = Some(self.create(&current, index, &chosen, revision)?),
            }
        }
        let gone = || Refusal::new(Status::NotFound, format!("plugin {}", self.id), "is gone", "rescan for plugins");
        state.live.as_ref().ok_or_else(gone)
    }

    fn create(
        &self,
        generation: &Arc<Generation>,
        index: usize,
        chosen: &values::Chosen,
        revision: u64,
    ) -> Result<Live, Refusal> {
        let info = generation.plugins[index].clone();
        let values = values::complete(&info, chosen);
        let worker = Worker::start(generation, index, values, self.registry.options.load_deadline);
        let worker = worker.map_err(|stop| self.refuse(stop, generation))?;
        Ok(Live { generation: generation.clone(), info, worker: Arc::new(worker), revision })
    }

    /// One of the newer build with the old one's state; else with its values; else with the defaults.
    fn migrate(
        &self,
        old: &Live,
        current: &Arc<Generation>,
        index: usize,
        chosen: &values::Chosen,
        revision: u64,
    ) -> Result<(Live, Carried), Refusal> {
        let log = |line: String| (self.registry.options.log)(LogLevel::Info, &line);
        let own = format!("plugin {}: build {} takes over from {}", self.id, current.number, old.generation.number);
        let fresh = match self.create(current, index, chosen, revision) {
            Ok(live) => live,
            Err(why) => {
                let live = self.create(current, index, &values::Chosen::new(), revision).map_err(|_| why.clone())?;
                log(format!("{own} with its defaults: {why}"));
                return Ok((live, Carried::Defaults));
            }
        };
        let state = self.ask(old, |instance| instance.save());
        match state {
            Ok(Some(state)) => {
                let version = old.info.state_version;
                match self.ask(&fresh, move |instance| instance.load(version, &state)) {
                    Ok(()) => {
                        log(format!("{own} with its state"));
                        Ok((fresh, Carried::State))
                    }
                    Err(why) => {
                        // What half a load left behind is not worked with.
                        let fresh = self.create(current, index, chosen, revision)?;
                        log(format!("{own} with its parameters only: {why}"));
                        Ok((fresh, Carried::Parameters))
                    }
                }
            }
            Ok(None) => {
                log(format!("{own} with its parameters; it keeps no state"));
                Ok((fresh, Carried::Parameters))
            }
            Err(why) => {
                log(format!("{own} with its parameters only: {why}"));
                Ok((fresh, Carried::Parameters))
            }
        }
    }

    /// A short question to an instance, under the deadline for loading.
    fn ask<R: Send + 'static>(
        &self,
        live: &Live,
        question: impl FnOnce(&mut dyn Instance) -> Result<R, Fault> + Send + 'static,
    ) -> Result<R, Refusal> {
        let progress = marey::job::Progress::new();
        let (post, deadline) = (Post::for_mesh(), self.registry.options.load_deadline);
        let work = move |instance: &mut dyn Instance, _: &Post| question(instance);
        let answer = live.worker.call(&post, progress.whole(), &live.generation, deadline, &|_| {}, work);
        answer.map_err(|stop| self.refuse(stop, &live.generation))
    }

    /// Saves the state of the instance: its version and bytes; [`None`] where the plugin keeps none.
    ///
    /// # Errors
    /// The instance cannot be made, or does not save.
    pub fn save(&self) -> Result<Option<(u32, Vec<u8>)>, Refusal> {
        let mut state = self.lock();
        let live = self.renewed(&mut state)?;
        let version = live.info.state_version;
        Ok(self.ask(live, |instance| instance.save())?.map(|bytes| (version, bytes)))
    }

    /// Loads a state that was saved.
    ///
    /// # Errors
    /// The instance cannot be made, or does not take it.
    pub fn load(&self, version: u32, bytes: &[u8]) -> Result<(), Refusal> {
        let mut state = self.lock();
        let live = self.renewed(&mut state)?;
        let bytes = bytes.to_vec();
        self.ask(live, move |instance| instance.load(version, &bytes))
    }

    /// Gives the plugin a piece of work. The answer of `work` counts only where nothing that came with it is wrong.
    pub(crate) fn run<R: Send + 'static>(
        &self,
        post: &Arc<Post>,
        stage: Stage<'_>,
        work: impl FnOnce(&mut dyn Instance, &Post) -> Result<R, Fault> + Send + 'static,
    ) -> marey::Result<(R, Arc<Generation>, Arc<Worker>)> {
        let mut state = self.lock();
        let live = self.renewed(&mut state)?;
        let (generation, worker) = (live.generation.clone(), live.worker.clone());
        let result = self.on(&worker, &generation, post, stage, work);
        if let Err((_, true)) = result {
            state.live = None;
        }
        result.map(|answer| (answer, generation, worker)).map_err(|(error, _)| error)
    }

    /// The same on a given instance. The flag of an error: whether the instance can do no more work.
    pub(crate) fn on<R: Send + 'static>(
        &self,
        worker: &Arc<Worker>,
        generation: &Arc<Generation>,
        post: &Arc<Post>,
        stage: Stage<'_>,
        work: impl FnOnce(&mut dyn Instance, &Post) -> Result<R, Fault> + Send + 'static,
    ) -> Result<R, (marey::Error, bool)> {
        // Whatever happens here, the plugin keeps nothing of the caller's.
        struct Detach<'a>(&'a Post);
        impl Drop for Detach<'_> {
            fn drop(&mut self) {
                self.0.detach();
            }
        }
        let answer = {
            let _detach = Detach(post);
            let slow = |silent: Duration| {
                let line = format!("plugin {}: gave no sign of life for {:.1} s", self.id, silent.as_secs_f64());
                (self.registry.options.log)(LogLevel::Warning, &line);
            };
            worker.call(post, stage, generation, self.registry.options.silence, &slow, work)
        };
        let log = |level, line: String| (self.registry.options.log)(level, &line);
        if !matches!(answer, Err(Stop::Hung(_) | Stop::LeftAtCancel)) {
            let kept = post.take_back();
            if kept > 0 {
                log(LogLevel::PluginMisbehaving, format!("plugin {}: did not give {kept} frames back", self.id));
            }
        }
        let output = |problem: String| {
            let line = format!("plugin {}: {problem}", self.id);
            log(LogLevel::PluginMisbehaving, line);
            let what = format!("plugin {}", self.id);
            Refusal::new(Status::Output, what, problem, "choose another plugin, and tell its author").into()
        };
        match answer {
            Ok(answer) => match post.flaw() {
                None => Ok(answer),
                Some(flaw) => Err((output(flaw), false)),
            },
            Err(Stop::Cancelled) => Err((marey::Error::Cancelled, false)),
            Err(Stop::LeftAtCancel) => {
                self.registry.leave(&self.id, generation, worker.ended.clone());
                Err((marey::Error::Cancelled, true))
            }
            Err(stop) => {
                let spent = match &stop {
                    Stop::Fault(fault) => matches!(fault.kind, FaultKind::Panicked | FaultKind::Poisoned),
                    _ => true,
                };
                let failed =
                    matches!(&stop, Stop::Fault(f) if matches!(f.kind, FaultKind::Invalid | FaultKind::Failed));
                // What the host refused is the better reason.
                match post.flaw().filter(|_| failed) {
                    Some(flaw) => Err((output(flaw), spent)),
                    None => Err((self.refuse(stop, generation).into(), spent)),
                }
            }
        }
    }

    /// A failed call as a refusal, with its strike.
    pub(crate) fn refuse(&self, stop: Stop, generation: &Generation) -> Refusal {
        let what = format!("plugin {}", self.id);
        match stop {
            Stop::Fault(fault) => {
                let panicked = fault.kind == FaultKind::Panicked;
                let refusal = fault.refusal(&self.id);
                if panicked {
                    self.registry.strike(&self.id, generation, &refusal.problem, false);
                }
                refusal
            }
            Stop::Hung(after) => {
                let problem = format!("gave no sign of life for {:.1} s", after.as_secs_f64());
                self.registry.strike(&self.id, generation, &problem, true);
                let remedy = "it is switched off until the host is started again; choose another, and tell its author";
                Refusal::new(Status::Timeout, what, problem, remedy)
            }
            Stop::Cancelled | Stop::LeftAtCancel => Refusal::new(Status::Failed, what, "was cancelled", "start again"),
        }
    }
}
