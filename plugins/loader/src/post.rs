//! The host's end of one piece of work: what a plugin may ask, answered on its own thread.
//!
//! A post outlives the call it belongs to, because a plugin that hangs may go on asking. What it may use of the
//! caller's, the clip, it loses when the caller leaves ([`Post::detach`]): from then on every answer is "cancelled".
//! What a plugin gives is checked here, before anything of it is kept.

use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::{Duration, Instant};

use marey::Vec2;
use marey::clip::{Clip, Picture};
use marey::motion::TrackFrame;
use marey::raster::Mask;
use marey_plugin::raw;

use crate::brief::Brief;

/// Places farther away than this many image sizes are a mistake.
const MAX_OUTSIDE: f32 = 100.0;
/// Frames that a plugin may hold at a time: the whole of a long clip would not fit into memory.
const MAX_LENT: usize = 4096;

/// The caller's clip, while the caller waits.
struct Borrowed(*const Clip);
// SAFETY: a Clip may be shared by threads; that it is alive is what `Post::clip`'s lock is for.
unsafe impl Send for Borrowed {}
// SAFETY: as above.
unsafe impl Sync for Borrowed {}

/// What is to come out.
enum Output {
    Nothing,
    Tracks(Vec<LimbOutput>),
    Masks(Vec<Option<Mask>>),
}

struct LimbOutput {
    points: usize,
    frames: Vec<Option<TrackFrame>>,
}

/// One piece of work. See the head of this file.
pub(crate) struct Post {
    clip: RwLock<Option<Borrowed>>,
    size: (u32, u32),
    frames: usize,
    cancelled: AtomicBool,
    fraction: AtomicU64,
    stage: Mutex<Option<String>>,
    began: Instant,
    /// Microseconds after `began` at which the plugin last asked for anything.
    heard: AtomicU64,
    lent: Mutex<HashMap<usize, Arc<Picture>>>,
    output: Mutex<Output>,
    /// The first thing that was not as it must be.
    flaw: Mutex<Option<String>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Post {
    fn new(clip: Option<&Clip>, output: Output) -> Arc<Self> {
        let info = clip.map(Clip::info);
        Arc::new(Self {
            clip: RwLock::new(clip.map(|c| Borrowed(c))),
            size: info.map_or((0, 0), |i| (i.width, i.height)),
            frames: info.map_or(0, |i| i.frames),
            cancelled: AtomicBool::new(false),
            fraction: AtomicU64::new(0),
            stage: Mutex::new(None),
            began: Instant::now(),
            heard: AtomicU64::new(0),
            lent: Mutex::default(),
            output: Mutex::new(output),
            flaw: Mutex::new(None),
        })
    }

    /// For a tracker.
    pub(crate) fn for_tracks(clip: &Clip, brief: &Brief) -> Arc<Self> {
        let limb = |l: &crate::brief::Limb| {
            let frames = (0..clip.info().frames).map(|_| None).collect();
            LimbOutput { points: l.points as usize, frames }
        };
        Self::new(Some(clip), Output::Tracks(brief.limbs.iter().map(limb).collect()))
    }

    /// For a segmenter.
    pub(crate) fn for_masks(clip: &Clip) -> Arc<Self> {
        Self::new(Some(clip), Output::Masks(vec![None; clip.info().frames]))
    }

    /// For a deformer.
    pub(crate) fn for_mesh() -> Arc<Self> {
        Self::new(None, Output::Nothing)
    }

    /// Takes back all that is the caller's. Waits for an answer that is being given, not for the plugin.
    pub(crate) fn detach(&self) {
        self.cancel();
        *self.clip.write().unwrap_or_else(PoisonError::into_inner) = None;
    }

    pub(crate) fn cancel(&self) {
        self.cancelled.store(true, Ordering::Release);
    }

    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Acquire)
    }

    /// How far the plugin says it is.
    pub(crate) fn fraction(&self) -> f64 {
        f64::from_bits(self.fraction.load(Ordering::Relaxed))
    }

    /// The name of a stage that was begun since the last time.
    pub(crate) fn new_stage(&self) -> Option<String> {
        lock(&self.stage).take()
    }

    /// How long nothing was heard of the plugin.
    pub(crate) fn silence(&self) -> Duration {
        self.began.elapsed().saturating_sub(Duration::from_micros(self.heard.load(Ordering::Relaxed)))
    }

    /// The plugin is given new work.
    pub(crate) fn begin(&self) {
        self.hear();
    }

    fn hear(&self) {
        self.heard.store(self.began.elapsed().as_micros() as u64, Ordering::Relaxed);
    }

    /// What the plugin did wrong, though it said that all is well.
    pub(crate) fn flaw(&self) -> Option<String> {
        lock(&self.flaw).clone()
    }

    fn refuse(&self, what: String) -> i32 {
        lock(&self.flaw).get_or_insert(what);
        raw::E_INVALID
    }

    /// Frames that the plugin did not give back.
    pub(crate) fn take_back(&self) -> usize {
        lock(&self.lent).drain().count()
    }

    pub(crate) fn progress(&self, fraction: f64, stage: Option<&str>) -> bool {
        self.hear();
        // Bits of numbers in 0..=1 order like the numbers; what is none says nothing.
        if (0.0..=1.0).contains(&fraction) {
            self.fraction.fetch_max(fraction.to_bits(), Ordering::Relaxed);
        }
        if let Some(stage) = stage {
            *lock(&self.stage) = Some(stage.chars().filter(|c| !c.is_control()).take(40).collect());
        }
        !self.is_cancelled()
    }

    pub(crate) fn get_frame(&self, index: u64) -> Result<raw::Frame, i32> {
        self.hear();
        if self.is_cancelled() {
            return Err(raw::CANCELLED);
        }
        let clip = self.clip.read().unwrap_or_else(PoisonError::into_inner);
        let Some(Borrowed(clip)) = &*clip else { return Err(raw::CANCELLED) };
        // SAFETY: the caller takes the clip out, behind the lock that is held here, before it lets go of it.
        let clip = unsafe { &**clip };
        let Ok(index) = usize::try_from(index) else { return Err(raw::E_INVALID) };
        if index >= self.frames {
            return Err(raw::E_INVALID);
        }
        let picture = catch_unwind(AssertUnwindSafe(|| clip.frame(index))).ok().and_then(Result::ok);
        let Some(picture) = picture else { return Err(raw::E_FAILED) };
        if picture.rgb.dimensions() != self.size {
            return Err(raw::E_FAILED);
        }
        let mut lent = lock(&self.lent);
        if lent.len() >= MAX_LENT {
            return Err(self.refuse(format!("{MAX_LENT} frames are held at a time; give some back")));
        }
        // A token of its own for each loan of a frame that is lent twice.
        let mut token = Arc::as_ptr(&picture) as usize;
        while lent.contains_key(&token) {
            token = token.wrapping_add(1);
        }
        let frame = raw::Frame {
            struct_size: size_of::<raw::Frame>() as u32,
            width: self.size.0,
            height: self.size.1,
            stride_bytes: 3 * self.size.0,
            pixels: picture.rgb.as_raw().as_ptr(),
            token: token as *mut c_void,
        };
        lent.insert(token, picture);
        Ok(frame)
    }

    pub(crate) fn release_frame(&self, token: *mut c_void) {
        // A token that is not lent, or given back twice, is nobody's.
        lock(&self.lent).remove(&(token as usize));
    }

    pub(crate) fn put_stroke(
        &self,
        limb: u32,
        frame: u64,
        points: &[raw::Point],
        visible: Option<&[u8]>,
        confidence: Option<&[f32]>,
    ) -> i32 {
        self.hear();
        if self.is_cancelled() {
            return raw::CANCELLED;
        }
        let mut output = lock(&self.output);
        let Output::Tracks(limbs) = &mut *output else {
            return self.refuse("it gave a stroke, and it is no tracker".to_owned());
        };
        let limb_count = limbs.len();
        let Some(to) = limbs.get_mut(limb as usize) else {
            return self.refuse(format!("it gave limb {limb}, and there are {limb_count}"));
        };
        let what = format_args!("limb {limb} on frame {frame}");
        if points.len() != to.points {
            return self.refuse(format!("{what}: it gave {} points, and the limb has {}", points.len(), to.points));
        }
        let most = MAX_OUTSIDE * self.size.0.max(self.size.1) as f32;
        if let Some(i) = points.iter().position(|p| !p.is_finite() || p.x.abs() > most || p.y.abs() > most) {
            return self.refuse(format!("{what}: point {i} is ({}, {})", points[i].x, points[i].y));
        }
        if let Some(i) = confidence.and_then(|c| c.iter().position(|c| !(0.0..=1.0).contains(c))) {
            return self.refuse(format!("{what}: the confidence of point {i} is not in 0 to 1"));
        }
        let frames = to.frames.len();
        let Some(place) = usize::try_from(frame).ok().and_then(|f| to.frames.get_mut(f)) else {
            return self.refuse(format!("it gave frame {frame} of limb {limb}, and the clip has {frames}"));
        };
        let mut kept = TrackFrame::certain(points.iter().map(|p| Vec2::new(p.x, p.y)).collect());
        if let Some(visible) = visible {
            kept.visible = visible.iter().map(|v| *v != 0).collect();
        }
        if let Some(confidence) = confidence {
            kept.confidence = confidence.to_vec();
        }
        *place = Some(kept);
        raw::OK
    }

    /// `pixels` holds all rows.
    pub(crate) fn put_mask(&self, frame: u64, pixels: &[u8], stride: usize) -> i32 {
        self.hear();
        if self.is_cancelled() {
            return raw::CANCELLED;
        }
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let mask = Mask::from_fn(width, height, |x, y| pixels.get(y * stride + x).is_some_and(|v| *v != 0));
        let mut output = lock(&self.output);
        let Output::Masks(masks) = &mut *output else {
            return self.refuse("it gave a mask, and it is no segmenter".to_owned());
        };
        let frames = masks.len();
        match usize::try_from(frame).ok().and_then(|f| masks.get_mut(f)) {
            Some(place) => {
                *place = Some(mask);
                raw::OK
            }
            None => self.refuse(format!("it gave a mask of frame {frame}, and the clip has {frames}")),
        }
    }

    /// A mask of the size that the plugin says, refused where it is not the clip's.
    pub(crate) fn mask_bytes(&self, frame: u64, size: (u32, u32), stride: usize) -> Result<usize, i32> {
        if size != self.size {
            let (own, clip) = (size, self.size);
            let problem =
                format!("the mask of frame {frame} is {}x{}, and the clip {}x{}", own.0, own.1, clip.0, clip.1);
            return Err(self.refuse(problem));
        }
        let (width, height) = (size.0 as usize, size.1 as usize);
        let bytes = height.checked_sub(1).and_then(|h| h.checked_mul(stride)?.checked_add(width));
        match bytes.filter(|b| stride >= width && *b <= isize::MAX as usize / 2) {
            Some(bytes) => Ok(bytes),
            None => {
                Err(self.refuse(format!("the mask of frame {frame} has rows of {stride} bytes, and needs {width}")))
            }
        }
    }

    /// All strokes, where each limb was given on each frame that it is not drawn on.
    pub(crate) fn take_tracks(&self, brief: &Brief) -> Result<Vec<Vec<Option<TrackFrame>>>, String> {
        let Output::Tracks(limbs) = std::mem::replace(&mut *lock(&self.output), Output::Nothing) else {
            return Err("it gave no strokes".to_owned());
        };
        for (l, limb) in limbs.iter().enumerate() {
            if let Some(frame) = (0..limb.frames.len()).find(|f| limb.frames[*f].is_none() && !brief.is_drawn(l, *f)) {
                let label = brief.limbs[l].label.to_string_lossy();
                return Err(format!("it did not give limb `{label}` on frame {frame}"));
            }
        }
        Ok(limbs.into_iter().map(|l| l.frames).collect())
    }

    /// All masks.
    pub(crate) fn take_masks(&self) -> Result<Vec<Mask>, String> {
        let Output::Masks(masks) = std::mem::replace(&mut *lock(&self.output), Output::Nothing) else {
            return Err("it gave no masks".to_owned());
        };
        let each = masks.into_iter().enumerate();
        each.map(|(f, mask)| mask.ok_or_else(|| format!("it did not give the mask of frame {f}"))).collect()
    }

    /// The job as C has it. It is valid while the post is.
    pub(crate) fn job(&self) -> raw::Job {
        raw::Job {
            struct_size: size_of::<raw::Job>() as u32,
            reserved0: 0,
            data: std::ptr::from_ref(self).cast_mut().cast(),
            progress: Some(c_progress),
            get_frame: Some(c_get_frame),
            release_frame: Some(c_release_frame),
            put_stroke: Some(c_put_stroke),
            put_mask: Some(c_put_mask),
        }
    }
}

/// # Safety
/// `job` is null or was made by [`Post::job`] of a post that is alive.
unsafe fn post<'a>(job: *const raw::Job) -> Option<&'a Post> {
    // SAFETY: as this function's own.
    unsafe { job.as_ref()?.data.cast::<Post>().as_ref() }
}

/// Answers a plugin: a panic of the host's is not to end it either.
fn answer(body: impl FnOnce() -> i32) -> i32 {
    catch_unwind(AssertUnwindSafe(body)).unwrap_or(raw::E_FAILED)
}

unsafe extern "C" fn c_progress(job: *const raw::Job, fraction: f64, stage: *const c_char) -> i32 {
    answer(|| {
        // SAFETY: plugin.h: the job that the host gave, while the work lasts. So for all of these.
        let Some(post) = (unsafe { post(job) }) else { return raw::CANCEL };
        // SAFETY: plugin.h: a NUL-terminated string, or NULL.
        let stage = (!stage.is_null()).then(|| unsafe { CStr::from_ptr(stage) }.to_string_lossy());
        if post.progress(fraction, stage.as_deref()) { raw::CONTINUE } else { raw::CANCEL }
    })
}

unsafe extern "C" fn c_get_frame(job: *const raw::Job, index: u64, frame: *mut raw::Frame) -> i32 {
    answer(|| {
        // SAFETY: as for `c_progress`.
        let Some(post) = (unsafe { post(job) }) else { return raw::CANCELLED };
        // SAFETY: plugin.h: a frame whose struct_size is set, or NULL.
        let size = unsafe { frame.as_ref() }.map_or(0, |f| f.struct_size as usize);
        if size < size_of::<raw::Frame>() {
            return post.refuse(format!("get_frame: frame is NULL, or its struct_size is {size}"));
        }
        match post.get_frame(index) {
            Ok(lent) => {
                // SAFETY: not NULL, and as large as was checked; the plugin's struct_size stays.
                unsafe { frame.write(raw::Frame { struct_size: size as u32, ..lent }) };
                raw::OK
            }
            Err(status) => status,
        }
    })
}

unsafe extern "C" fn c_release_frame(job: *const raw::Job, frame: *mut raw::Frame) {
    answer(|| {
        // SAFETY: as for `c_get_frame`.
        if let (Some(post), Some(frame)) = unsafe { (post(job), frame.as_mut()) } {
            post.release_frame(frame.token);
            (frame.pixels, frame.token) = (std::ptr::null(), std::ptr::null_mut());
        }
        raw::OK
    });
}

/// # Safety
/// `ptr` is null or points at `count` values.
unsafe fn optional<'a, T>(ptr: *const T, count: usize) -> Option<&'a [T]> {
    // SAFETY: as this function's own.
    (!ptr.is_null()).then(|| unsafe { std::slice::from_raw_parts(ptr, count) })
}

unsafe extern "C" fn c_put_stroke(
    job: *const raw::Job,
    limb: u32,
    frame: u64,
    points: *const raw::Point,
    visible: *const u8,
    confidence: *const f32,
    count: u32,
) -> i32 {
    answer(|| {
        // SAFETY: as for `c_progress`; each list is NULL or has `count` entries.
        unsafe {
            let Some(post) = post(job) else { return raw::CANCELLED };
            // A count that is not the limb's is refused without reading so many.
            let known = match &*lock(&post.output) {
                Output::Tracks(limbs) => limbs.get(limb as usize).map_or(0, |l| l.points),
                _ => 0,
            };
            if count as usize != known {
                let problem = format!("limb {limb} on frame {frame}: it gave {count} points, and the limb has {known}");
                return post.refuse(problem);
            }
            let Some(points) = optional(points, known) else {
                return post.refuse(format!("limb {limb} on frame {frame}: points is NULL"));
            };
            post.put_stroke(limb, frame, points, optional(visible, known), optional(confidence, known))
        }
    })
}

unsafe extern "C" fn c_put_mask(
    job: *const raw::Job,
    frame: u64,
    pixels: *const u8,
    width: u32,
    height: u32,
    stride: usize,
) -> i32 {
    answer(|| {
        // SAFETY: as for `c_progress`; the pixels are NULL or hold all rows.
        unsafe {
            let Some(post) = post(job) else { return raw::CANCELLED };
            let bytes = match post.mask_bytes(frame, (width, height), stride) {
                Ok(bytes) => bytes,
                Err(status) => return status,
            };
            let Some(pixels) = optional(pixels, bytes) else {
                return post.refuse(format!("the mask of frame {frame}: pixels is NULL"));
            };
            post.put_mask(frame, pixels, stride)
        }
    })
}
