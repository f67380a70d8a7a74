//! Binding by likeness. What moves in a clip and a drawing are laid on each other by their outlines, and the tracked points
//! are carried over: a proposal, for the host to correct.

use marey::Vec2;
use marey::shape::sketch::Laying;

use crate::binding::mry_binding;
use crate::border::{self, Out, Versioned};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::motion::mry_motion;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_in};
use crate::vector::mry_drawing;

/// The drawing faces as what moves in the clip does, or the other way: what fits better.
pub const MRY_FACES_EITHER_WAY: i32 = 0;
/// The drawing faces as what moves does.
pub const MRY_FACES_THE_SAME_WAY: i32 = 1;
/// The drawing faces the other way.
pub const MRY_FACES_THE_OTHER_WAY: i32 = 2;

/// What to bind to what. Start from MRY_BIND_DESC_INIT; drawing and motion must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_bind_desc {
    /// sizeof(mry_bind_desc).
    pub struct_size: u32,
    /// MRY_FACES_EITHER_WAY, ...: which way the drawing faces.
    pub faces: i32,
    /// The drawing.
    pub drawing: mry_drawing,
    /// The motion.
    pub motion: mry_motion,
    /// The clip that the motion was tracked in, for the outline of what moves; {0} to go by the points alone.
    pub clip: mry_clip,
    /// The frame of the motion that the drawing is like, counted from 1; 0 to choose one.
    pub frame_from_one: u64,
    /// What to call the motion in the binding; empty for "motion".
    pub name: mry_str,
    /// The outline of what moves in that frame as a person drew it, a closed polygon in clip pixels; or NULL.
    pub contour: *const mry_point,
    /// How many corners it has.
    pub contour_count: usize,
    /// The outline of the drawing as a person drew it, a closed polygon in its pixels; or NULL.
    pub outline: *const mry_point,
    /// How many corners it has.
    pub outline_count: usize,
}

// SAFETY: repr(C), starts with its u32 size; integers, and a string and pointers that the host vouches for.
unsafe impl Versioned for mry_bind_desc {
    const FIRST_SIZE: usize = 88;
}
const _: () = assert!(size_of::<mry_bind_desc>() == 88);

/// No outline that a person drew has more corners.
const MOST_CORNERS: usize = 1 << 20;

impl Call<'_> {
    unsafe fn bind_work(&self, desc: *const mry_bind_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        // SAFETY: as above.
        let (name, contour, outline) = unsafe {
            (
                desc.name.text("desc.name")?.to_owned(),
                corners(desc.contour, desc.contour_count, "desc.contour")?,
                corners(desc.outline, desc.outline_count, "desc.outline")?,
            )
        };
        let mirror = match desc.faces {
            MRY_FACES_EITHER_WAY => None,
            MRY_FACES_THE_SAME_WAY => Some(false),
            MRY_FACES_THE_OTHER_WAY => Some(true),
            _ => return Err(Failure::argument("desc.faces", format!("desc.faces is {}", desc.faces))),
        };
        let vector = self.drawing(desc.drawing).map_err(|e| e.about("desc.drawing"))?;
        let motion = self.motion(desc.motion).map_err(|e| e.about("desc.motion"))?;
        let clip = if desc.clip.v == 0 { None } else { Some(self.clip(desc.clip, "desc.clip")?) };
        let frame = desc.frame_from_one.checked_sub(1).map(|f| usize::try_from(f).unwrap_or(usize::MAX));
        Ok(Box::new(move |progress| {
            let laying = Laying {
                drawing: &vector.drawing,
                motion: &motion,
                name: if name.is_empty() { "motion" } else { &name },
                clip: clip.as_deref(),
                frame,
                contour: contour.as_deref(),
                outline: outline.as_deref(),
                mirror,
            };
            let laid = laying.lay(progress.whole())?;
            let report = laid.to_json();
            Ok(Product { binding: Part::Made(laid.binding), report: Some(report), ..Product::default() })
        }))
    }
}

/// # Safety
/// `points` is NULL or has `count` entries.
unsafe fn corners(points: *const mry_point, count: usize, param: &'static str) -> Outcome<Option<Vec<Vec2>>> {
    // SAFETY: as this function's own.
    let points = unsafe { border::slice(points, count, MOST_CORNERS, param)? };
    if points.is_empty() { Ok(None) } else { points_in(points).map(Some).map_err(|e| e.about(param)) }
}

/// Fills in a struct with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_bind_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_bind_desc_init(desc: *mut mry_bind_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts laying what moves on a drawing. Gives a binding; mry_job_get_report says how far each point is to be trusted, and
/// what outline was used.
///
/// @param context  The context.
/// @param desc     What to bind to what.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_ARGUMENT (faces), MRY_E_STRUCT_SIZE, MRY_E_STRING, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_bind(
    context: *mut mry_context,
    desc: *const mry_bind_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.bind_work(desc)?;
        out.set(call.keep_job(&call.start("bind", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Lays what moves on a drawing, and returns when it is done. Work that was started before comes first.
///
/// @param context      The context.
/// @param desc         What to bind to what.
/// @param out_binding  The binding.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_bind and mry_job_wait return; MRY_E_INPUT (no such frame, an outline that is none).
/// Lifetime: until mry_binding_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_bind(
    context: *mut mry_context,
    desc: *const mry_bind_desc,
    out_binding: *mut mry_binding,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_binding, "out_binding")?;
        let work = call.bind_work(desc)?;
        let (_, job) = call.run("bind", work)?;
        job.take(|p| &mut p.binding, |binding| call.keep_binding(binding).map(|id| out.set(id)))
    })
}
