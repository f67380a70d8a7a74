//! A context's own threads: a pool of the size the host asked for, and one thread that hands it the jobs in turn.
//!
//! Jobs run one after another, each on the whole pool. That bounds memory to one job's, and keeps a cancel prompt: on
//! a pool that is shared, a worker of one job that waits may pick up all of another.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, OnceLock};
use std::thread::ThreadId;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{Failure, Outcome};
use crate::status::mry_status_code;
use crate::threads::{Running, Spawn};

type Task = Box<dyn FnOnce() + Send>;

/// More threads than this are a mistake.
pub(crate) const MAX_THREADS: usize = 1024;

/// Threads that are waited for when dropped.
struct Joined(Vec<Running>);

impl Drop for Joined {
    fn drop(&mut self) {
        self.0.drain(..).for_each(Running::join);
    }
}

/// The threads of a context. Dropping it waits for the queued tasks and for all threads to end: the queue closes, the
/// conductor ends, the pool lets its workers go, and they end. The fields are in that order.
pub(crate) struct Executor {
    queue: Sender<Task>,
    conductor_id: Arc<OnceLock<ThreadId>>,
    _conductor: Joined,
    pool: Arc<ThreadPool>,
    _workers: Joined,
}

impl Executor {
    /// Starts `threads` workers, or one for each core for 0.
    pub(crate) fn new(threads: usize, spawn: &Spawn) -> Outcome<Self> {
        let refused = |e: &dyn std::fmt::Display| {
            Failure::new(mry_status_code::MRY_E_THREADS, "threads", format!("cannot start threads: {e}; ask for fewer"))
        };
        let mut workers = Joined(Vec::new());
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .spawn_handler(|worker| {
                let (name, stack) = (format!("marey {}", worker.index()), worker.stack_size());
                workers.0.push(spawn.start(name, stack, Box::new(|| worker.run()))?);
                Ok(())
            })
            .build()
            .map_err(|e| refused(&e))?;
        let (queue, tasks) = channel::<Task>();
        let conductor_id = Arc::new(OnceLock::new());
        let own_id = conductor_id.clone();
        let conduct = move || {
            own_id.get_or_init(|| std::thread::current().id());
            tasks.iter().for_each(|task| task());
        };
        let conductor = spawn.start("marey jobs".into(), None, Box::new(conduct)).map_err(|e| refused(&e))?;
        let pool = Arc::new(pool);
        Ok(Self { queue, conductor_id, _conductor: Joined(vec![conductor]), pool, _workers: workers })
    }

    /// How many workers there are.
    pub(crate) fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// The pool, for a task to run on.
    pub(crate) fn pool(&self) -> Arc<ThreadPool> {
        self.pool.clone()
    }

    /// Runs `work` on the pool now, beside whatever job is running, and waits for it.
    pub(crate) fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    /// Puts `task`, which must not panic, at the end of the queue.
    pub(crate) fn enqueue(&self, task: Task) -> Outcome<()> {
        let ended = |_| Failure::new(mry_status_code::MRY_E_THREADS, "", "the job thread has ended");
        self.queue.send(task).map_err(ended)
    }

    /// Whether the calling thread is one of these: waiting for a job here would be waiting for itself.
    pub(crate) fn is_own_thread(&self) -> bool {
        let own = std::thread::current().id();
        self.conductor_id.get() == Some(&own) || self.pool.current_thread_index().is_some()
    }
}
