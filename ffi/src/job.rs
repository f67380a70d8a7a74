//! Jobs. Long work runs on the context's threads while the host goes on: start it, poll or wait, take the result,
//! destroy the job. What a job works on is copied when it starts, so clips may be closed and rigs edited meanwhile.
//! Jobs of one context run one after another, each on all threads; those of two contexts run side by side. Results
//! are the same, bit for bit, with any number of threads.
//!
//! A cancel takes effect within 100 ms; a job that has ended is not changed by it. The mry_run functions do the same
//! work as a job and return when it is done.

use std::ffi::c_char;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use marey::clip::Clip;
use marey::export::report::Report;
use marey::export::{FolderOptions, check_mask_folder, write_mask_folder};
use marey::job::Progress;
use marey::motion::Motion;
use marey::pipeline::{self, PipelineOptions};
use marey::rig::Rig;
use marey::segment::{self, CostVolumeSegmenter, SegmentParams, Segmenter};
use marey::track::Tracker;
use marey::track::limb::{self, LimbParams, LimbTracker};

use crate::border::{self, Out, OutStruct, Versioned};
use crate::clip::mry_clip;
use crate::context::{MRY_LOG_ERROR, MRY_LOG_INFO, mry_context};
use crate::creature::{Creature, mry_creature};
use crate::error::{Failure, Outcome, copy_text, mry_error};
use crate::guard::{Call, ending, entry, panic_text};
use crate::masks::{MaskSet, mry_masks};
use crate::motion::mry_motion;
use crate::rig::mry_rig;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;

pub(crate) type JobTable = Table<Arc<Job>>;

/// A job.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_job {
    /// The id; 0 is no job.
    pub v: u64,
}

/// What to track. Start from MRY_TRACK_DESC_INIT; clip and rig must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_track_desc {
    /// sizeof(mry_track_desc).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// The clip.
    pub clip: mry_clip,
    /// The rig; it must be valid for the clip.
    pub rig: mry_rig,
    /// The tracker: "space-time", "paper" (Reinert 2016, section 3.5); empty for the best.
    pub tracker: mry_str,
}

// SAFETY: repr(C), starts with its u32 size; integers, and a string that the host vouches for.
unsafe impl Versioned for mry_track_desc {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_track_desc>() == 40);

/// What to segment. Start from MRY_SEGMENT_DESC_INIT; clip and rig must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_segment_desc {
    /// sizeof(mry_segment_desc).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// The clip.
    pub clip: mry_clip,
    /// The rig; it must be valid for the clip.
    pub rig: mry_rig,
    /// The rig's limbs, tracked; {0} to track them first.
    pub motion: mry_motion,
    /// The tracker, where motion is {0}: as in mry_track_desc.
    pub tracker: mry_str,
    /// The segmenter: "layered", "paper" (Reinert 2016, section 3.6); empty for the best.
    pub segmenter: mry_str,
    /// Where to write the masks, see mry_masks_write_folder; empty for nowhere.
    pub folder: mry_str,
}

// SAFETY: repr(C), starts with its u32 size; integers, and strings that the host vouches for.
unsafe impl Versioned for mry_segment_desc {
    const FIRST_SIZE: usize = 80;
}
const _: () = assert!(size_of::<mry_segment_desc>() == 80);

/// What to make a creature of. Start from MRY_CREATURE_DESC_INIT; clip and rig must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_creature_desc {
    /// sizeof(mry_creature_desc).
    pub struct_size: u32,
    /// With a folder: 1 to write also meshes/00000.obj, ... in world coordinates.
    pub write_obj: u32,
    /// The clip.
    pub clip: mry_clip,
    /// The rig; it must be valid for the clip.
    pub rig: mry_rig,
    /// The tracker: as in mry_track_desc.
    pub tracker: mry_str,
    /// The segmenter: as in mry_segment_desc.
    pub segmenter: mry_str,
    /// Where to write everything, see mry_creature_write_folder; empty for nowhere.
    pub folder: mry_str,
}

// SAFETY: repr(C), starts with its u32 size; integers, and strings that the host vouches for.
unsafe impl Versioned for mry_creature_desc {
    const FIRST_SIZE: usize = 72;
}
const _: () = assert!(size_of::<mry_creature_desc>() == 72);

/// How a job is doing.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_job_state {
    /// sizeof(mry_job_state).
    pub struct_size: u32,
    /// MRY_PENDING, MRY_OK, MRY_CANCELLED, or the error it ended with.
    pub status: mry_status,
    /// The share of the work that is done, 0..1; never goes back.
    pub fraction: f64,
    /// Rises whenever anything else in this struct has changed since the last poll.
    pub revision: u64,
    /// What is being done, a word or two, NUL-terminated: "waiting" before the job's turn.
    pub stage: [c_char; 48],
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_job_state {
    const FIRST_SIZE: usize = 72;
}
const _: () = assert!(size_of::<mry_job_state>() == 72);

/// Where the stages of a segment job end, as shares of its time.
const TRACKED: f64 = 0.6;
const SEGMENTED: f64 = 0.95;

/// A part of a job's result.
enum Part<T> {
    /// The job does not make it.
    None,
    Made(T),
    Taken,
}

/// What a job made.
struct Product {
    motion: Part<Arc<Motion>>,
    masks: Part<Arc<MaskSet>>,
    creature: Part<Arc<Creature>>,
}

enum State {
    Waiting,
    Running,
    Done(Product),
    Cancelled,
    Failed(Failure),
}

/// What a poll last said, to tell when it changes.
#[derive(Clone, Copy, PartialEq)]
struct Told {
    status: mry_status,
    fraction: f64,
    stage: &'static str,
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

    fn poll(&self) -> (Told, u64) {
        let (status, waiting) = match &*lock(&self.state) {
            State::Waiting => (Code::MRY_PENDING as mry_status, true),
            State::Running => (Code::MRY_PENDING as mry_status, false),
            State::Done(_) => (Code::MRY_OK as mry_status, false),
            State::Cancelled => (Code::MRY_CANCELLED as mry_status, false),
            State::Failed(failure) => (failure.status, false),
        };
        let stage = if waiting { "waiting" } else { self.progress.stage_name() };
        let fraction = if status == Code::MRY_OK as mry_status { 1.0 } else { self.progress.fraction() };
        let now = Told { status, fraction, stage };
        let mut told = lock(&self.told);
        if told.0 != Some(now) {
            *told = (Some(now), told.1 + 1);
        }
        (now, told.1)
    }

    /// Waits for the end, at most until `until`.
    fn wait(&self, until: Option<Instant>) -> Outcome<Code> {
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

    /// Takes one part of the result and keeps it by `keep`; a part that cannot be kept stays to be taken.
    fn take<T: Clone>(
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

type Work = Box<dyn FnOnce(&Progress) -> marey::Result<Product> + Send>;

impl Call<'_> {
    fn job(&self, job: mry_job) -> Outcome<Arc<Job>> {
        Ok(self.get(&self.context.jobs, job.v, "job")?.value.clone())
    }

    /// Queues `work`.
    fn start(&self, name: &'static str, work: Work) -> Outcome<Arc<Job>> {
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
                    State::Done(product)
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
    fn run(&self, name: &'static str, work: Work) -> Outcome<(Code, Arc<Job>)> {
        self.context.refuse_callbacks()?;
        let job = self.start(name, work)?;
        let code = job.wait(None)?;
        Ok((code, job))
    }

    fn keep_job(&self, job: &Arc<Job>) -> Outcome<mry_job> {
        let id = self.context.jobs.insert(job.clone());
        // A job without an id could not be cancelled.
        id.map(|v| mry_job { v }).inspect_err(|_| job.cancel())
    }

    unsafe fn track_work(&self, desc: *const mry_track_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        reserved(desc.reserved0)?;
        // SAFETY: as above.
        let tracker = unsafe { tracker(desc.tracker)? };
        let (clip, rig) = self.clip_and_rig(desc.clip, desc.rig)?;
        Ok(Box::new(move |progress| {
            let motion = tracker.track(&clip, &rig, progress.whole())?;
            Ok(Product { motion: Part::Made(Arc::new(motion)), masks: Part::None, creature: Part::None })
        }))
    }

    unsafe fn segment_work(&self, desc: *const mry_segment_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        reserved(desc.reserved0)?;
        // SAFETY: as above.
        let (tracker, segmenter) = unsafe { (tracker(desc.tracker)?, segmenter(desc.segmenter)?) };
        // SAFETY: as above.
        let (settings, folder) = unsafe { (settings(desc.tracker, desc.segmenter)?, folder(desc.folder)?) };
        let (clip, rig) = self.clip_and_rig(desc.clip, desc.rig)?;
        let given = if desc.motion.v == 0 { None } else { Some(self.motion(desc.motion)?) };
        if let Some(motion) = &given {
            fits(motion, &clip, &rig)?;
        }
        Ok(Box::new(move |progress| {
            if let Some(folder) = &folder {
                check_mask_folder(folder.as_ref())?;
            }
            let stage = progress.whole();
            let began = Instant::now();
            let motion = match given {
                Some(motion) => motion,
                None => Arc::new(tracker.track(&clip, &rig, stage.part(0.0, TRACKED))?),
            };
            let tracked = began.elapsed();
            let segmenting = stage.part(TRACKED, SEGMENTED);
            segmenting.name("segmenting")?;
            let masks = segmenter.segment(&clip, &rig, &motion, segmenting)?;
            let mut report = Report::new(clip.info(), &rig, &motion);
            report.settings = settings;
            report.stage("track", tracked.as_secs_f64());
            report.stage("segment", (began.elapsed() - tracked).as_secs_f64());
            if let Some(folder) = &folder {
                let writing = stage.part(SEGMENTED, 1.0);
                writing.name("writing")?;
                write_mask_folder(folder.as_ref(), &masks, &report, writing)?;
            }
            let masks = Arc::new(MaskSet { masks, report });
            Ok(Product { motion: Part::Made(motion), masks: Part::Made(masks), creature: Part::None })
        }))
    }

    unsafe fn creature_work(&self, desc: *const mry_creature_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        // SAFETY: as above.
        let (tracker, segmenter) = unsafe { (tracker(desc.tracker)?, segmenter(desc.segmenter)?) };
        // SAFETY: as above.
        let (settings, folder) = unsafe { (settings(desc.tracker, desc.segmenter)?, folder(desc.folder)?) };
        let files = folder_options(desc.write_obj, 0.0)?;
        let (clip, rig) = self.clip_and_rig(desc.clip, desc.rig)?;
        Ok(Box::new(move |progress| {
            let mut options = PipelineOptions::new(&tracker, &segmenter);
            options.settings = settings;
            let made = match &folder {
                None => pipeline::creature(&clip, &rig, &options, progress.whole())?,
                Some(folder) => {
                    pipeline::creature_to_folder(&clip, &rig, &options, folder.as_ref(), &files, progress.whole())?
                }
            };
            let motion = Arc::new(made.motion);
            let masks = Arc::new(MaskSet { masks: made.masks, report: made.report });
            let creature = Creature::new(clip, rig, motion.clone(), masks.clone(), made.model);
            Ok(Product {
                motion: Part::Made(motion),
                masks: Part::Made(masks),
                creature: Part::Made(Arc::new(creature)),
            })
        }))
    }

    /// The clip and a copy of the rig, which fits it.
    fn clip_and_rig(&self, clip: mry_clip, rig: mry_rig) -> Outcome<(Arc<Clip>, Rig)> {
        let clip = self.clip(clip, "desc.clip")?;
        let info = clip.info();
        let fit = Some(((info.width, info.height), info.frames));
        let rig = self.rig(rig, |rig| {
            rig.validate(fit).map_err(|e| Failure::from(e).about("desc.rig"))?;
            Ok(rig.clone())
        })?;
        Ok((clip, rig))
    }
}

/// A motion from anywhere must be of this clip and rig.
fn fits(motion: &Motion, clip: &Clip, rig: &Rig) -> Outcome<()> {
    let info = clip.info();
    let same = motion.size == (info.width, info.height)
        && motion.frames == info.frames
        && motion.tracks.iter().map(|t| &t.name).eq(rig.limbs.iter().map(|l| &l.label));
    if same {
        return Ok(());
    }
    let message = "the motion is not of this clip and rig: its size, its frames or its track names are others";
    Err(Failure::new(Code::MRY_E_INPUT, "desc.motion", message))
}

fn reserved(value: u32) -> Outcome<()> {
    if value == 0 {
        return Ok(());
    }
    Err(Failure::new(Code::MRY_E_UNSUPPORTED, "desc", "desc.reserved0 is not zero"))
}

/// # Safety
/// The string is valid, as the header asks.
unsafe fn tracker(id: mry_str) -> Outcome<LimbTracker> {
    // SAFETY: as this function's own.
    let method = match unsafe { id.text("desc.tracker")? } {
        "" | "space-time" => limb::Method::SpaceTime,
        "paper" => limb::Method::Paper,
        other => return Err(unknown("desc.tracker", other, "space-time, paper")),
    };
    Ok(LimbTracker { params: LimbParams { method, ..LimbParams::default() } })
}

/// # Safety
/// The string is valid, as the header asks.
unsafe fn segmenter(id: mry_str) -> Outcome<CostVolumeSegmenter> {
    // SAFETY: as this function's own.
    let method = match unsafe { id.text("desc.segmenter")? } {
        "" | "layered" => segment::Method::Layered,
        "paper" => segment::Method::Paper,
        other => return Err(unknown("desc.segmenter", other, "layered, paper")),
    };
    Ok(CostVolumeSegmenter { params: SegmentParams { method, ..SegmentParams::default() } })
}

fn unknown(param: &'static str, id: &str, known: &str) -> Failure {
    Failure::new(Code::MRY_E_UNSUPPORTED, param, format!("{param}: `{id}` is not known; there are {known}"))
}

/// What the report says about how a job was run.
///
/// # Safety
/// The strings are valid, as the header asks.
unsafe fn settings(tracker: mry_str, segmenter: mry_str) -> Outcome<serde_json::Value> {
    // SAFETY: as this function's own.
    let (tracker, segmenter) = unsafe { (tracker.text("desc.tracker")?, segmenter.text("desc.segmenter")?) };
    let or = |id: &str, best: &str| if id.is_empty() { best.to_owned() } else { id.to_owned() };
    Ok(serde_json::json!({ "tracker": or(tracker, "space-time"), "segmenter": or(segmenter, "layered") }))
}

/// The folder to write into, where one is named.
///
/// # Safety
/// The string is valid, as the header asks.
unsafe fn folder(folder: mry_str) -> Outcome<Option<String>> {
    if folder.len == 0 {
        return Ok(None);
    }
    // SAFETY: as this function's own.
    unsafe { folder.name("desc.folder").map(|name| Some(name.to_owned())) }
}

/// Which files a creature's folder has. A scale of 0 is the default, 1.
pub(crate) fn folder_options(obj: u32, scale: f32) -> Outcome<FolderOptions> {
    if obj > 1 {
        return Err(Failure::argument("write_obj", format!("write_obj is {obj}, and must be 0 or 1")));
    }
    let mut options = FolderOptions::default();
    options.obj = obj == 1;
    options.scale = metres(scale)?;
    Ok(options)
}

/// Metres a world unit. A scale of 0 is the default, 1.
pub(crate) fn metres(scale: f32) -> Outcome<f32> {
    if !scale.is_finite() {
        return Err(Failure::new(Code::MRY_E_NON_FINITE, "scale", format!("scale is {scale}")));
    }
    if scale < 0.0 {
        return Err(Failure::argument("scale", format!("scale is {scale}, and must be above 0")));
    }
    Ok(if scale == 0.0 { 1.0 } else { scale })
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_track_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_track_desc_init(desc: *mut mry_track_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_segment_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_segment_desc_init(desc: *mut mry_segment_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_creature_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_desc_init(desc: *mut mry_creature_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a job state with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param state  Where to write; NULL does nothing.
/// @param size   sizeof(mry_job_state) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_state_init(state: *mut mry_job_state, size: u32) {
    // SAFETY: the caller owns `size` bytes at `state`, or passes NULL.
    unsafe { border::init(state.cast(), size) }
}

/// Starts tracking: from strokes on key frames to strokes on every frame. Gives a motion.
///
/// @param context  The context.
/// @param desc     What to track.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the rig is not valid for the clip), MRY_E_UNSUPPORTED (no such tracker),
///         MRY_E_STRUCT_SIZE, MRY_E_STRING, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_track(
    context: *mut mry_context,
    desc: *const mry_track_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.track_work(desc)?;
        out.set(call.keep_job(&call.start("track", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Starts segmenting: from tracked strokes to the creature's mask in every frame. Gives a motion and masks.
///
/// @param context  The context.
/// @param desc     What to segment.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the rig or the motion is not of the clip), MRY_E_UNSUPPORTED (no such tracker or
///         segmenter), MRY_E_STRUCT_SIZE, MRY_E_STRING, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_segment(
    context: *mut mry_context,
    desc: *const mry_segment_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.segment_work(desc)?;
        out.set(call.keep_job(&call.start("segment", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Starts the whole job: track, segment, reconstruct, and write into a folder where one is given. Gives a motion,
/// masks and a creature.
///
/// @param context  The context.
/// @param desc     What to make a creature of.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the rig is not valid for the clip), MRY_E_UNSUPPORTED (no such tracker or
///         segmenter), MRY_E_STRUCT_SIZE, MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_creature(
    context: *mut mry_context,
    desc: *const mry_creature_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.creature_work(desc)?;
        out.set(call.keep_job(&call.start("creature", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// How a job is doing. Never waits.
///
/// @param context    The context.
/// @param job        The job.
/// @param out_state  The answer; its struct_size must be set.
/// @param err        Detail of a failure of the poll, not of the job; or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_poll(
    context: *mut mry_context,
    job: mry_job,
    out_state: *mut mry_job_state,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_state, "out_state")?;
        let (now, revision) = call.job(job)?.poll();
        let mut state =
            mry_job_state { struct_size: 0, status: now.status, fraction: now.fraction, revision, stage: [0; 48] };
        copy_text(now.stage, &mut state.stage);
        out.set(&state);
        Ok(Code::MRY_OK)
    })
}

/// Waits for a job's end.
///
/// @param context     The context.
/// @param job         The job.
/// @param timeout_ns  Nanoseconds to wait at most; 0 not to wait, MRY_FOREVER without an end.
/// @param err         Detail of the job's failure, or NULL.
/// @return MRY_OK when it is done, MRY_CANCELLED, the error it ended with, MRY_PENDING when the time is over;
///         MRY_E_REENTRANT.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_wait(
    context: *mut mry_context,
    job: mry_job,
    timeout_ns: u64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let job = call.job(job)?;
        // A time past what the clock can count is no end either.
        let until =
            if timeout_ns == u64::MAX { None } else { Instant::now().checked_add(Duration::from_nanos(timeout_ns)) };
        job.wait(until)
    })
}

/// Asks a job to stop and returns at once. The job ends within 100 ms with MRY_CANCELLED, or with its result when it
/// was just done; nothing half-written stays. On a job that has ended, and a second time, it does nothing.
///
/// @param context  The context.
/// @param job      The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_cancel(context: *mut mry_context, job: mry_job, err: *mut mry_error) -> mry_status {
    entry!(context, err, |call| {
        call.job(job)?.cancel();
        Ok(Code::MRY_OK)
    })
}

/// Takes the motion that a job made; once.
///
/// @param context     The context.
/// @param job         The job.
/// @param out_motion  The motion.
/// @param err         Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN.
/// Lifetime: until mry_motion_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_motion(
    context: *mut mry_context,
    job: mry_job,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        call.job(job)?.take(|p| &mut p.motion, |motion| call.keep_motion(motion).map(|id| out.set(id)))
    })
}

/// Takes the masks that a segment or creature job made; once.
///
/// @param context    The context.
/// @param job        The job.
/// @param out_masks  The masks.
/// @param err        Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_masks_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_masks(
    context: *mut mry_context,
    job: mry_job,
    out_masks: *mut mry_masks,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_masks, "out_masks")?;
        call.job(job)?.take(|p| &mut p.masks, |masks| call.keep_masks(masks).map(|id| out.set(id)))
    })
}

/// Takes the creature that a creature job made; once.
///
/// @param context       The context.
/// @param job           The job.
/// @param out_creature  The creature.
/// @param err           Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (no output), the error the job ended with, MRY_E_TAKEN, MRY_E_KIND.
/// Lifetime: until mry_creature_destroy or the end of the context; the job may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_take_creature(
    context: *mut mry_context,
    job: mry_job,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        call.job(job)?.take(|p| &mut p.creature, |creature| call.keep_creature(creature).map(|id| out.set(id)))
    })
}

/// Destroys a job, cancelling it when it has not ended. Returns at once; the work stops behind it.
///
/// @param context  The context.
/// @param job      The job; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_destroy(context: *mut mry_context, job: mry_job) -> mry_status {
    ending!(context, |call| {
        if job.v != 0 {
            call.context.jobs.remove(job.v, "job")?.value.cancel();
        }
        Ok(Code::MRY_OK)
    })
}

/// Tracks, and returns when it is done. Work that was started before comes first.
///
/// @param context     The context.
/// @param desc        What to track.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_track and mry_job_wait return.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_track(
    context: *mut mry_context,
    desc: *const mry_track_desc,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let work = call.track_work(desc)?;
        let (_, job) = call.run("track", work)?;
        job.take(|p| &mut p.motion, |motion| call.keep_motion(motion).map(|id| out.set(id)))
    })
}

/// Segments, and returns when it is done. Work that was started before comes first.
///
/// @param context    The context.
/// @param desc       What to segment.
/// @param out_masks  The masks.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_segment and mry_job_wait return.
/// Lifetime: until mry_masks_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_segment(
    context: *mut mry_context,
    desc: *const mry_segment_desc,
    out_masks: *mut mry_masks,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_masks, "out_masks")?;
        let work = call.segment_work(desc)?;
        let (_, job) = call.run("segment", work)?;
        job.take(|p| &mut p.masks, |masks| call.keep_masks(masks).map(|id| out.set(id)))
    })
}

/// Makes a creature, and returns when it is done. Work that was started before comes first.
///
/// @param context       The context.
/// @param desc          What to make a creature of.
/// @param out_creature  The creature; its motion and masks come from mry_creature_get_motion and _get_masks.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_creature and mry_job_wait return.
/// Lifetime: until mry_creature_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_creature(
    context: *mut mry_context,
    desc: *const mry_creature_desc,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        let work = call.creature_work(desc)?;
        let (_, job) = call.run("creature", work)?;
        job.take(|p| &mut p.creature, |creature| call.keep_creature(creature).map(|id| out.set(id)))
    })
}
