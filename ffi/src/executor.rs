//! A context's own threads: a pool of the size the host asked for, and one thread that hands it the jobs in turn.
//!
//! Jobs run one after another, each on the whole pool. That bounds memory to one job's, and keeps a cancel prompt: on
//! a pool that is shared, a worker of one job that waits may pick up all of another.

use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::thread::{Builder, JoinHandle, ThreadId};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{Failure, Outcome};
use crate::status::mry_status_code;

type Task = Box<dyn FnOnce() + Send>;

/// More threads than this are a mistake.
pub(crate) const MAX_THREADS: usize = 1024;

/// Threads that are waited for when dropped.
struct Joined(Vec<JoinHandle<()>>);

impl Drop for Joined {
    fn drop(&mut self) {
        // A thread that panicked has nothing more to say.
        self.0.drain(..).for_each(|thread| {
            thread.join().ok();
        });
    }
}

/// The threads of a context. Dropping it waits for the queued tasks and for all threads to end: the queue closes, the
/// conductor ends, the pool lets its workers go, and they end. The fields are in that order.
pub(crate) struct Executor {
    queue: Sender<Task>,
    conductor_id: ThreadId,
    _conductor: Joined,
    pool: Arc<ThreadPool>,
    _workers: Joined,
}

impl Executor {
    /// Starts `threads` workers, or one for each core for 0.
    pub(crate) fn new(threads: usize) -> Outcome<Self> {
        let refused = |e: &dyn std::fmt::Display| {
            Failure::new(mry_status_code::MRY_E_THREADS, "threads", format!("cannot start threads: {e}; ask for fewer"))
        };
        let mut workers = Joined(Vec::new());
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .spawn_handler(|worker| {
                let mut builder = Builder::new().name(format!("marey {}", worker.index()));
                if let Some(size) = worker.stack_size() {
                    builder = builder.stack_size(size);
                }
                workers.0.push(builder.spawn(|| worker.run())?);
                Ok(())
            })
            .build()
            .map_err(|e| refused(&e))?;
        let (queue, tasks) = channel::<Task>();
        let conductor = Builder::new().name("marey jobs".into()).spawn(move || tasks.iter().for_each(|task| task()));
        let conductor = conductor.map_err(|e| refused(&e))?;
        let conductor_id = conductor.thread().id();
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
        std::thread::current().id() == self.conductor_id || self.pool.current_thread_index().is_some()
    }
}
