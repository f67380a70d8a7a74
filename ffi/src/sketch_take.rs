//! Sketches in motion. A sketch take is what a drawing does in every frame; it does not change, and keeps its drawing as it
//! was. Take its frames as paths, as pixels, or as files.

use std::sync::Arc;

use image::RgbaImage;
use marey::kurbo::{PathEl, Point};
use marey::motion::Motion;
use marey::shape::sketch::{Sketch, SketchCanvas, SketchParams, SketchTake, draw_sketch};
use serde_json::json;

use crate::binding::mry_binding;
use crate::border::{self, List, Out, OutStruct, Versioned, reserved};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::job::mry_job;
use crate::motion::mry_motion;
use crate::rows::Rows;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::stroke::mry_point;
use crate::table::Table;
use crate::vector::{Vector, mry_drawing};

/// A take with its drawing.
pub(crate) struct Sketched {
    pub(crate) vector: Arc<Vector>,
    pub(crate) take: SketchTake,
}

pub(crate) type SketchTakeTable = Table<Arc<Sketched>>;

/// A drawing in motion.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_sketch_take {
    /// The id; 0 is no take.
    pub v: u64,
}

/// What to make a sketch take of. Start from MRY_SKETCH_TAKE_DESC_INIT; drawing, binding and motions must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_sketch_take_desc {
    /// sizeof(mry_sketch_take_desc).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// The drawing.
    pub drawing: mry_drawing,
    /// How the motions hold it.
    pub binding: mry_binding,
    /// The motions, in the binding's order; the first gives frames and rate.
    pub motions: *const mry_motion,
    /// How many there are.
    pub motion_count: usize,
}

// SAFETY: repr(C), starts with its u32 size; integers and a pointer that the host vouches for.
unsafe impl Versioned for mry_sketch_take_desc {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_sketch_take_desc>() == 40);

/// What a sketch take is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_sketch_take_info {
    /// sizeof(mry_sketch_take_info).
    pub struct_size: u32,
    /// Strokes of the drawing.
    pub stroke_count: u32,
    /// How many frames there are.
    pub frame_count: u64,
    /// Frames a second.
    pub fps: f64,
    /// The left upper corner of what is drawn in all frames.
    pub low: mry_point,
    /// The right lower corner.
    pub high: mry_point,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_sketch_take_info {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_sketch_take_info>() == 40);

/// Element of a path: a new piece begins at its first point.
pub const MRY_PATH_MOVE: i32 = 0;
/// Element of a path: a straight line to its first point.
pub const MRY_PATH_LINE: i32 = 1;
/// Element of a path: a curve by its first point, a control point, to its second.
pub const MRY_PATH_QUADRATIC: i32 = 2;
/// Element of a path: a curve by its first two points, control points, to its third.
pub const MRY_PATH_CUBIC: i32 = 3;
/// Element of a path: a straight line to where the piece began, which is closed.
pub const MRY_PATH_CLOSE: i32 = 4;

/// An element of a path.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_path_element {
    /// MRY_PATH_MOVE, ...
    pub kind: i32,
    /// Its places, in the drawing's pixels; those that its kind does not have are 0.
    pub points: [mry_point; 3],
}

/// No take has more motions.
const MOST_MOTIONS: usize = 64;

pub(crate) fn path_out(elements: &[PathEl]) -> Vec<mry_path_element> {
    let place = |p: Point| mry_point { x: p.x as f32, y: p.y as f32 };
    let none = mry_point::default();
    let one = |element: &PathEl| match *element {
        PathEl::MoveTo(p) => mry_path_element { kind: MRY_PATH_MOVE, points: [place(p), none, none] },
        PathEl::LineTo(p) => mry_path_element { kind: MRY_PATH_LINE, points: [place(p), none, none] },
        PathEl::QuadTo(a, p) => mry_path_element { kind: MRY_PATH_QUADRATIC, points: [place(a), place(p), none] },
        PathEl::CurveTo(a, b, p) => mry_path_element { kind: MRY_PATH_CUBIC, points: [place(a), place(b), place(p)] },
        PathEl::ClosePath => mry_path_element { kind: MRY_PATH_CLOSE, points: [none; 3] },
    };
    elements.iter().map(one).collect()
}

impl Sketched {
    fn canvas(&self, scale: f32, crop: u32) -> Outcome<SketchCanvas> {
        if !scale.is_finite() {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "scale", format!("scale is {scale}")));
        }
        if scale < 0.0 {
            return Err(Failure::argument("scale", format!("scale is {scale}, and must be above 0")));
        }
        if crop > 1 {
            return Err(Failure::argument("crop", format!("crop is {crop}; give 0 or 1")));
        }
        let scale = if scale == 0.0 { 1.0 } else { f64::from(scale) };
        Ok(if crop == 1 {
            SketchCanvas::page(&self.vector.drawing, scale)?
        } else {
            SketchCanvas::around(&self.vector.drawing, &self.take, scale)?
        })
    }
}

impl Call<'_> {
    pub(crate) fn sketch_take(&self, take: mry_sketch_take) -> Outcome<Arc<Sketched>> {
        Ok(self.get(&self.context.sketch_takes, take.v, "take")?.value.clone())
    }

    pub(crate) fn keep_sketch_take(&self, take: Arc<Sketched>) -> Outcome<mry_sketch_take> {
        Ok(mry_sketch_take { v: self.context.sketch_takes.insert(take)? })
    }

    /// # Safety
    /// `motions` is valid, as the header asks.
    pub(crate) unsafe fn motions_in(
        &self,
        motions: *const mry_motion,
        count: usize,
        param: &'static str,
    ) -> Outcome<Vec<Arc<Motion>>> {
        // SAFETY: as this function's own.
        let motions = unsafe { border::slice(motions, count, MOST_MOTIONS, param)? };
        motions.iter().map(|m| self.motion(*m).map_err(|e| e.about(param))).collect()
    }

    unsafe fn sketch_take_work(&self, desc: *const mry_sketch_take_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        reserved(desc.reserved0)?;
        let vector = self.drawing(desc.drawing).map_err(|e| e.about("desc.drawing"))?;
        let binding = self.binding(desc.binding, |b| Ok(b.clone())).map_err(|e| e.about("desc.binding"))?;
        // SAFETY: as above.
        let motions = unsafe { self.motions_in(desc.motions, desc.motion_count, "desc.motions")? };
        let all: Vec<&Motion> = motions.iter().map(|m| &**m).collect();
        binding.check(&vector.drawing, Some(&all)).map_err(|e| Failure::from(e).about("desc.binding"))?;
        Ok(Box::new(move |progress| {
            let began = std::time::Instant::now();
            let all: Vec<&Motion> = motions.iter().map(|m| &**m).collect();
            let stage = progress.whole();
            let (drawing, params) = (vector.drawing.clone(), SketchParams::default());
            let mut sketch = Sketch::new(drawing, binding, params, stage.part(0.0, 0.2))?;
            let take = sketch.take(&all, stage.part(0.2, 1.0))?;
            let outside = |i: &usize| {
                let track = sketch.binding().points.get(*i).map_or("", |p| &p.track);
                format!("`{track}` lies outside the drawing and holds the nearest place of it")
            };
            let report = json!({
                "strokes": vector.drawing.strokes.len(), "points": sketch.binding().points.len(),
                "frames": take.frames.len(), "fps": take.fps,
                "warnings": sketch.points_outside().iter().map(outside).collect::<Vec<_>>(),
                "timings": { "sketch": began.elapsed().as_secs_f64() },
            });
            let sketched = Arc::new(Sketched { vector: vector.clone(), take });
            Ok(Product { sketch_take: Part::Made(sketched), report: Some(report.to_string()), ..Product::default() })
        }))
    }
}

/// Fills in a struct with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_sketch_take_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_take_desc_init(desc: *mut mry_sketch_take_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a struct with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_sketch_take_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_take_info_init(info: *mut mry_sketch_take_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Starts moving a drawing: from a drawing, a binding and its motions to what every stroke does in every frame. Gives a sketch
/// take; mry_job_get_report says what a person should know of it.
///
/// @param context  The context.
/// @param desc     What to move, and by what.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a binding that does not fit the drawing or the motions), MRY_E_STRUCT_SIZE, MRY_E_LIMIT,
///         MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_sketch_take(
    context: *mut mry_context,
    desc: *const mry_sketch_take_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.sketch_take_work(desc)?;
        out.set(call.keep_job(&call.start("sketch", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Moves a drawing, and returns when it is done. Work that was started before comes first.
///
/// @param context   The context.
/// @param desc      What to move, and by what.
/// @param out_take  The take.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_sketch_take and mry_job_wait return.
/// Lifetime: until mry_sketch_take_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_sketch_take(
    context: *mut mry_context,
    desc: *const mry_sketch_take_desc,
    out_take: *mut mry_sketch_take,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_take, "out_take")?;
        let work = call.sketch_take_work(desc)?;
        let (_, job) = call.run("sketch", work)?;
        job.take(|p| &mut p.sketch_take, |take| call.keep_sketch_take(take).map(|id| out.set(id)))
    })
}

/// Counts, rate and size of a sketch take.
///
/// @param context   The context.
/// @param take      The take.
/// @param out_info  The answer.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_take_get_info(
    context: *mut mry_context,
    take: mry_sketch_take,
    out_info: *mut mry_sketch_take_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let sketched = call.sketch_take(take)?;
        let shown = sketched.canvas(1.0, 0)?.shown();
        let corner = |x: f64, y: f64| mry_point { x: x as f32, y: y as f32 };
        out.set(&mry_sketch_take_info {
            struct_size: 0,
            stroke_count: sketched.vector.drawing.strokes.len() as u32,
            frame_count: sketched.take.frames.len() as u64,
            fps: sketched.take.fps,
            low: corner(shown.x0, shown.y0),
            high: corner(shown.x1, shown.y1),
        });
        Ok(Code::MRY_OK)
    })
}

/// The order in which a take's strokes are painted, the farthest first: layers may differ from the drawing's own order.
///
/// @param context    The context.
/// @param take       The take.
/// @param order      Where the strokes go; NULL with capacity 0 to ask for their count.
/// @param capacity   Strokes that fit.
/// @param out_count  How many there are.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_take_read_order(
    context: *mut mry_context,
    take: mry_sketch_take,
    order: *mut u32,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let list = List::new(order, capacity, out_count, "order")?;
        let order: Vec<u32> = call.sketch_take(take)?.take.order.iter().map(|s| *s as u32).collect();
        list.fill(&order)
    })
}

/// The path of a stroke in a frame. Its elements are of the same kinds in all frames.
///
/// @param context    The context.
/// @param take       The take.
/// @param frame      Which, below frame_count.
/// @param stroke     Which, below stroke_count, as mry_drawing_get_stroke counts them.
/// @param elements   Where the path goes; NULL with capacity 0 to ask for its size.
/// @param capacity   Elements that fit.
/// @param out_count  How many there are.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame, stroke), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_take_read_stroke(
    context: *mut mry_context,
    take: mry_sketch_take,
    frame: u64,
    stroke: u32,
    elements: *mut mry_path_element,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let list = List::new(elements, capacity, out_count, "elements")?;
        let sketched = call.sketch_take(take)?;
        let frames = &sketched.take.frames;
        let paths = &frames[frame_index(frame, frames.len())?].paths;
        let wrong = || Failure::argument("stroke", format!("stroke is {stroke}, and there are {}", paths.len()));
        list.fill(&path_out(paths.get(stroke as usize).ok_or_else(wrong)?.elements()))
    })
}

/// What pictures of a take show: the same rectangle in every frame.
///
/// @param context     The context.
/// @param take        The take.
/// @param scale       Pixels a pixel of the drawing; 0 for 1.
/// @param crop        1 to show the drawing's page; 0 to show all of every frame.
/// @param out_width   Pixels across.
/// @param out_height  Pixels down.
/// @param out_corner  Where their left upper corner lies, in pixels of the drawing; or NULL.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (scale, crop), MRY_E_NON_FINITE, MRY_E_LIMIT (larger than pictures may be).
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_take_measure(
    context: *mut mry_context,
    take: mry_sketch_take,
    scale: f32,
    crop: u32,
    out_width: *mut u32,
    out_height: *mut u32,
    out_corner: *mut mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (width, height) = (Out::new(out_width, "out_width")?, Out::new(out_height, "out_height")?);
        let corner = Out::optional(out_corner, "out_corner")?;
        let canvas = call.sketch_take(take)?.canvas(scale, crop)?;
        width.set(canvas.size().0);
        height.set(canvas.size().1);
        let shown = canvas.shown();
        corner.inspect(|out| out.set(mry_point { x: shown.x0 as f32, y: shown.y0 as f32 }));
        Ok(Code::MRY_OK)
    })
}

/// Draws a frame: 4 bytes a pixel, red, green, blue, sRGB, and alpha, which the others are not multiplied by. The same
/// pixels as in files.
///
/// @param context       The context.
/// @param take          The take.
/// @param frame         Which, below frame_count.
/// @param scale         Pixels a pixel of the drawing; 0 for 1.
/// @param crop          1 to show the drawing's page; 0 to show all of every frame.
/// @param pixels        Where the rows go: 4 * width bytes each, as mry_sketch_take_measure says.
/// @param capacity      Bytes at pixels: at least stride_bytes * (height - 1) + 4 * width.
/// @param stride_bytes  From one row's start to the next's; 0 for rows without gaps. Bytes in gaps are left alone.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame, scale, crop, stride_bytes), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUFFER_TOO_SMALL.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_take_draw_frame(
    context: *mut mry_context,
    take: mry_sketch_take,
    frame: u64,
    scale: f32,
    crop: u32,
    pixels: *mut u8,
    capacity: usize,
    stride_bytes: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let rows = Rows::new(pixels, capacity, stride_bytes, "pixels")?;
        let sketched = call.sketch_take(take)?;
        let frame = frame_index(frame, sketched.take.frames.len())?;
        let canvas = sketched.canvas(scale, crop)?;
        let row = 4 * canvas.size().0 as usize;
        rows.fits(row, canvas.size().1 as usize)?;
        let draw = || -> RgbaImage { draw_sketch(&sketched.vector.drawing, &sketched.take, frame, &canvas) };
        rows.write(call.context.executor.run(draw).as_raw(), row)?;
        Ok(Code::MRY_OK)
    })
}

/// Destroys a sketch take.
///
/// @param context  The context.
/// @param take     The take; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_sketch_take_destroy(context: *mut mry_context, take: mry_sketch_take) -> mry_status {
    ending!(context, |call| {
        if take.v != 0 {
            call.context.sketch_takes.remove(take.v, "take")?;
        }
        Ok(Code::MRY_OK)
    })
}
