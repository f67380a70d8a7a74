//! A job while it lives: its state, shared by its id and the thread that runs it, and what it made.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use marey::clip::Clip;
use marey::job::Progress;
use marey::motion::Motion;
use marey::rig::PointMarks;
use marey::shape::sketch::Binding;
use marey::shape::solid::Solid;

use crate::character::Drawn;
use crate::context::{MRY_LOG_ERROR, MRY_LOG_INFO};
use crate::creature::Creature;
use crate::error::{Failure, Outcome};
use crate::guard::{Call, panic_text};
use crate::job::mry_job;
use crate::masks::MaskSet;
use crate::session_jobs::ForSession;
use crate::sketch_take::Sketched;
use crate::status::{mry_status, mry_status_code as Code};
use crate::take::Played;

/// A part of a job's result.
#[derive(Default)]
pub(crate) enum Part<T> {
    /// The job does not make it.
    #[default]
    None,
    Made(T),
    Taken,
}

/// What a job made.
#[derive(Default)]
pub(crate) struct Product {
    pub(crate) clip: Part<Arc<Clip>>,
    pub(crate) motion: Part<Arc<Motion>>,
    pub(crate) control_points: Part<PointMarks>,
    pub(crate) masks: Part<Arc<MaskSet>>,
    pub(crate) creature: Part<Arc<Creature>>,
    pub(crate) for_session: Part<ForSession>,
    pub(crate) character: Part<Arc<Drawn>>,
    pub(crate) take: Part<Arc<Played>>,
    pub(crate) binding: Part<Binding>,
    pub(crate) sketch_take: Part<Arc<Sketched>>,
    pub(crate) solid: Part<Arc<Solid>>,
    /// What it says of its work.
    pub(crate) report: Option<String>,
}

enum State {
    Waiting,
    Running,
    Done(Box<Product>),
    Cancelled,
    Failed(Failure),
}

/// What a poll last said, to tell when it changes.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Told {
    pub(crate) status: mry_status,
    pub(crate) fraction: f64,
    pub(crate) stage: &'static str,
    pub(crate) stage_fraction: f64,
}

/// A job, shared by its id and the thread that runs it.
pub(crate) struct Job {
    progress: Progress,
    state: Mutex<State>,
    ended: Condvar,
    told: Mutex<(Option<Told>, u64)>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Job {
    pub(crate) fn cancel(&self) {
        self.progress.cancel();
        let mut state = lock(&self.state);
        // One that waits for its turn ends here and now; a running one at its next check.
        if matches!(*state, State::Waiting) {
            *state = State::Cancelled;
            self.ended.notify_all();
        }
    }

    fn end(&self, state: State) {
        *lock(&self.state) = state;
        self.ended.notify_all();
    }

    pub(crate) fn poll(&self) -> (Told, u64) {
        let (status, waiting) = match &*lock(&self.state) {
            State::Waiting => (Code::MRY_PENDING as mry_status, true),
            State::Running => (Code::MRY_PENDING as mry_status, false),
            State::Done(_) => (Code::MRY_OK as mry_status, false),
            State::Cancelled => (Code::MRY_CANCELLED as mry_status, false),
            State::Failed(failure) => (failure.status, false),
        };
        let stage = if waiting { "waiting" } else { self.progress.stage_name() };
        let fraction = if status == Code::MRY_OK as mry_status { 1.0 } else { self.progress.fraction() };
        let stage_fraction = match stage {
            _ if waiting => 0.0,
            _ if status == Code::MRY_OK as mry_status => 1.0,
            _ => self.progress.stage_fraction(),
        };
        let now = Told { status, fraction, stage, stage_fraction };
        let mut told = lock(&self.told);
        if told.0 != Some(now) {
            *told = (Some(now), told.1 + 1);
        }
        (now, told.1)
    }

    /// Waits for the end, at most until `until`.
    pub(crate) fn wait(&self, until: Option<Instant>) -> Outcome<Code> {
        let mut state = lock(&self.state);
        loop {
            match &*state {
                State::Done(_) => return Ok(Code::MRY_OK),
                State::Cancelled => return Ok(Code::MRY_CANCELLED),
                State::Failed(failure) => return Err(failure.clone()),
                State::Waiting | State::Running => {}
            }
            state = match until {
                None => self.ended.wait(state).unwrap_or_else(PoisonError::into_inner),
                Some(until) => {
                    let left = until.saturating_duration_since(Instant::now());
                    if left.is_zero() {
                        return Ok(Code::MRY_PENDING);
                    }
                    self.ended.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
    }

    /// What the job says of its work; it can be asked for again.
    pub(crate) fn report(&self, tell: impl FnOnce(&str) -> Outcome<Code>) -> Outcome<Code> {
        match &*lock(&self.state) {
            State::Waiting | State::Running => Ok(Code::MRY_PENDING),
            State::Cancelled => Ok(Code::MRY_CANCELLED),
            State::Failed(failure) => Err(failure.clone()),
            State::Done(product) => {
                let none = || Failure::new(Code::MRY_E_KIND, "job", "the job makes no report");
                tell(product.report.as_deref().ok_or_else(none)?)
            }
        }
    }

    /// Takes one part of the result and keeps it by `keep`; a part that cannot be kept stays to be taken.
    pub(crate) fn take<T: Clone>(
        &self,
        part: impl FnOnce(&mut Product) -> &mut Part<T>,
        keep: impl FnOnce(T) -> Outcome<()>,
    ) -> Outcome<Code> {
        let mut state = lock(&self.state);
        match &mut *state {
            State::Waiting | State::Running => Ok(Code::MRY_PENDING),
            State::Cancelled => Ok(Code::MRY_CANCELLED),
            State::Failed(failure) => Err(failure.clone()),
            State::Done(product) => {
                let part = part(product);
                match part {
                    Part::None => Err(Failure::new(Code::MRY_E_KIND, "job", "the job makes a result of another kind")),
                    Part::Taken => Err(Failure::new(Code::MRY_E_TAKEN, "job", "the job's result was taken before")),
                    Part::Made(value) => {
                        keep(value.clone())?;
                        *part = Part::Taken;
                        Ok(Code::MRY_OK)
                    }
                }
            }
        }
    }
}

/// What a job does.
pub(crate) type Work = Box<dyn FnOnce(&Progress) -> marey::Result<Product> + Send>;

impl Call<'_> {
    pub(crate) fn job(&self, job: mry_job) -> Outcome<Arc<Job>> {
        Ok(self.get(&self.context.jobs, job.v, "job")?.value.clone())
    }

    /// Queues `work`.
    pub(crate) fn start(&self, name: &'static str, work: Work) -> Outcome<Arc<Job>> {
        let job = Arc::new(Job {
            progress: Progress::new(),
            state: Mutex::new(State::Waiting),
            ended: Condvar::new(),
            told: Mutex::new((None, 0)),
        });
        let (running, pool, log) = (job.clone(), self.context.executor.pool(), self.context.logger());
        #[cfg(feature = "test-panic")]
        let work: Work =
            if crate::test_panic::in_job(self.context) { Box::new(|_| panic!("a forced defect")) } else { work };
        self.context.executor.enqueue(Box::new(move || {
            {
                let mut state = lock(&running.state);
                if !matches!(*state, State::Waiting) {
                    return;
                }
                *state = State::Running;
            }
            let began = Instant::now();
            let result = catch_unwind(AssertUnwindSafe(|| pool.install(|| work(&running.progress))));
            let seconds = began.elapsed().as_secs_f64();
            let state = match result {
                Ok(Ok(product)) => {
                    log(MRY_LOG_INFO, &format!("{name}: done in {seconds:.2} s"));
                    State::Done(Box::new(product))
                }
                Ok(Err(marey::Error::Cancelled)) => {
                    log(MRY_LOG_INFO, &format!("{name}: cancelled after {seconds:.2} s"));
                    State::Cancelled
                }
                Ok(Err(error)) => {
                    log(MRY_LOG_INFO, &format!("{name}: failed after {seconds:.2} s: {error}"));
                    State::Failed(error.into())
                }
                Err(payload) => {
                    let text = panic_text(&*payload);
                    log(MRY_LOG_ERROR, &format!("{name}: {text}"));
                    State::Failed(Failure::new(Code::MRY_E_PANIC, "", text))
                }
            };
            running.end(state);
        }))?;
        Ok(job)
    }

    /// Runs `work` as a job and waits for it.
    pub(crate) fn run(&self, name: &'static str, work: Work) -> Outcome<(Code, Arc<Job>)> {
        self.context.refuse_callbacks()?;
        let job = self.start(name, work)?;
        let code = job.wait(None)?;
        Ok((code, job))
    }

    pub(crate) fn keep_job(&self, job: &Arc<Job>) -> Outcome<mry_job> {
        let id = self.context.jobs.insert(job.clone());
        // A job without an id could not be cancelled.
        id.map(|v| mry_job { v }).inspect_err(|_| job.cancel())
    }
}
