//! An instance on a thread of its own, under a deadline.
//!
//! A plugin that hangs cannot be stopped: nothing can stop a thread from outside. So the thread that needs the result
//! is never the one that the plugin runs on. It waits, passes on progress and cancels, and leaves when nothing was
//! heard for too long; the plugin's thread stays behind with everything it may still touch.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use marey::job::Stage;

use crate::door::{Fault, FaultKind, Instance};
use crate::generation::Generation;
use crate::post::Post;
use crate::values::Value;

/// How often the waiting thread looks up: together with the grace well within the 100 ms that a cancel may take.
const TICK: Duration = Duration::from_millis(10);
/// How long after a cancel a plugin is waited for before it is left to itself.
const GRACE: Duration = Duration::from_millis(60);

type Task = Box<dyn FnOnce(&mut dyn Instance) + Send>;

/// Why there is no result.
#[derive(Debug)]
pub(crate) enum Stop {
    /// The plugin says why.
    Fault(Fault),
    /// Cancelled, and the plugin stopped.
    Cancelled,
    /// Cancelled, and the plugin goes on, on its own.
    LeftAtCancel,
    /// Nothing was heard of the plugin for too long.
    Hung(Duration),
}

/// An instance at work.
pub(crate) struct Worker {
    tasks: Sender<Task>,
    /// Whether the thread has ended.
    pub(crate) ended: Arc<AtomicBool>,
}

/// Counts an instance, for as long as its thread lives.
struct Counted(Arc<Generation>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.instances.fetch_sub(1, Ordering::AcqRel);
    }
}

impl Worker {
    /// Makes an instance of a plugin of `generation` on a new thread.
    pub(crate) fn start(
        generation: &Arc<Generation>,
        index: usize,
        values: Vec<(String, Value)>,
        deadline: Duration,
    ) -> Result<Self, Stop> {
        let (tasks, queue) = channel::<Task>();
        let (made, wait) = channel();
        let ended = Arc::new(AtomicBool::new(false));
        let (own, at_end) = (generation.clone(), ended.clone());
        generation.instances.fetch_add(1, Ordering::AcqRel);
        let counted = Counted(generation.clone());
        let run = move || {
            let _counted = counted;
            match own.door.create(index, &values) {
                Ok(mut instance) => {
                    let _ = made.send(Ok(()));
                    queue.iter().for_each(|task| task(&mut *instance));
                    drop(instance);
                }
                Err(fault) => drop(made.send(Err(fault))),
            }
            at_end.store(true, Ordering::Release);
        };
        let id = generation.plugins.get(index).map_or("plugin", |p| p.id.as_str());
        let spawned = std::thread::Builder::new().name(format!("plugin {id}")).spawn(run);
        spawned.map_err(|e| Stop::Fault(Fault::new(FaultKind::Failed, format!("no thread can be started: {e}"))))?;
        match wait.recv_timeout(deadline) {
            Ok(Ok(())) => Ok(Self { tasks, ended }),
            Ok(Err(fault)) => Err(Stop::Fault(fault)),
            Err(RecvTimeoutError::Timeout) => Err(Stop::Hung(deadline)),
            Err(RecvTimeoutError::Disconnected) => Err(gone()),
        }
    }

    /// Sends work without waiting for it.
    pub(crate) fn send(&self, task: impl FnOnce(&mut dyn Instance) + Send + 'static) {
        // A thread that has ended has dropped its instance too.
        let _ = self.tasks.send(Box::new(task));
    }

    /// Gives the instance work and waits for what comes of it. `post` is this work's, and `stage` the engine's; `slow`
    /// is told once of a silence that has lasted a third of what makes a hang.
    pub(crate) fn call<R: Send + 'static>(
        &self,
        post: &Arc<Post>,
        stage: Stage<'_>,
        generation: &Generation,
        silence: Duration,
        slow: &dyn Fn(Duration),
        work: impl FnOnce(&mut dyn Instance, &Post) -> Result<R, Fault> + Send + 'static,
    ) -> Result<R, Stop> {
        let (done, wait) = channel();
        let own = post.clone();
        self.send(move |instance| {
            own.begin();
            let result = work(instance, &own);
            let _ = done.send(result);
        });
        let result = wait_for(&wait, post, stage, generation, silence, slow);
        if matches!(result, Err(Stop::LeftAtCancel | Stop::Hung(_))) {
            post.detach();
        }
        result
    }
}

fn gone() -> Stop {
    Stop::Fault(Fault::new(FaultKind::Failed, "the plugin's thread has ended"))
}

fn wait_for<R>(
    wait: &Receiver<Result<R, Fault>>,
    post: &Post,
    stage: Stage<'_>,
    generation: &Generation,
    silence: Duration,
    slow: &dyn Fn(Duration),
) -> Result<R, Stop> {
    let mut cancelled: Option<Instant> = None;
    let mut told = false;
    loop {
        match wait.recv_timeout(TICK) {
            Ok(Ok(result)) => return Ok(result),
            Ok(Err(fault)) if fault.kind == FaultKind::Cancelled && cancelled.is_some() => return Err(Stop::Cancelled),
            Ok(Err(fault)) => return Err(Stop::Fault(fault)),
            Err(RecvTimeoutError::Disconnected) => return Err(gone()),
            Err(RecvTimeoutError::Timeout) => {}
        }
        match cancelled {
            Some(since) if since.elapsed() >= GRACE => return Err(Stop::LeftAtCancel),
            Some(_) => continue,
            None => {}
        }
        let named = post.new_stage().map_or(Ok(()), |name| stage.name(generation.stage(&name)));
        if named.and_then(|()| stage.at(post.fraction())).is_err() {
            post.cancel();
            cancelled = Some(Instant::now());
        } else if post.silence() >= silence {
            return Err(Stop::Hung(silence));
        } else if !told && post.silence() >= silence / 3 {
            told = true;
            slow(post.silence());
        }
    }
}
