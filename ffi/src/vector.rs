//! Vector drawings. What a motion brings to life: strokes with their pens and fills, from an SVG file or drawn freehand.
//! mry_binding_create and mry_job_start_bind say how a motion holds one, and mry_sketch_create moves it.

use std::ffi::c_char;
use std::sync::{Arc, RwLock};

use marey::export::write_aside;
use marey::job::Progress;
use marey::shape::sketch::{Drawing, Paint, Pen, PenSample, Stroke, SvgIn};

use crate::border::{self, List, Out, OutStruct, Text, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_out};
use crate::table::Table;

/// A drawing and what of its file it could not hold.
#[derive(Clone)]
pub(crate) struct Vector {
    pub(crate) drawing: Drawing,
    left_out: Vec<String>,
}

pub(crate) type DrawingTable = Table<RwLock<Arc<Vector>>>;

/// A vector drawing.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_drawing {
    /// The id; 0 is no drawing.
    pub v: u64,
}

/// What a drawing is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_drawing_info {
    /// sizeof(mry_drawing_info).
    pub struct_size: u32,
    /// How many strokes there are.
    pub stroke_count: u32,
    /// How many groups there are.
    pub group_count: u32,
    /// How many kinds of things its file had that it does not hold: see mry_drawing_get_left_out.
    pub left_out_count: u32,
    /// Width of the page, in pixels.
    pub width: f64,
    /// Height of the page, in pixels.
    pub height: f64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_drawing_info {
    const FIRST_SIZE: usize = 32;
}
const _: () = assert!(size_of::<mry_drawing_info>() == 32);

/// What a stroke of a drawing is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_drawing_stroke {
    /// sizeof(mry_drawing_stroke).
    pub struct_size: u32,
    /// 1 where something fills it.
    pub has_fill: u32,
    /// 1 where a pen draws its line.
    pub has_pen: u32,
    /// Its line's width in pixels; 0 without a pen.
    pub pen_width: f32,
    /// The left upper corner of what its path encloses.
    pub low: mry_point,
    /// The right lower corner.
    pub high: mry_point,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_drawing_stroke {
    const FIRST_SIZE: usize = 32;
}
const _: () = assert!(size_of::<mry_drawing_stroke>() == 32);

/// A place of a pen that draws, and how hard it presses.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_pen_sample {
    /// Pixels from the page's left edge.
    pub x: f32,
    /// Pixels from its top edge.
    pub y: f32,
    /// 0..1; 0.5 for a pen that does not tell.
    pub pressure: f32,
}

/// No more samples make one stroke: an hour of drawing at 240 a second is less.
const MOST_SAMPLES: usize = 1 << 20;

impl Call<'_> {
    pub(crate) fn drawing(&self, drawing: mry_drawing) -> Outcome<Arc<Vector>> {
        let slot = self.get(&self.context.drawings, drawing.v, "drawing")?;
        let vector = slot.value.try_read().map_err(|e| Failure::locked(&e, "drawing", "changing"))?;
        Ok(vector.clone())
    }

    /// Changes a drawing; who shares it keeps it as it was, and so does the table when the change fails.
    fn drawing_mut<T>(&self, drawing: mry_drawing, change: impl FnOnce(&mut Drawing) -> Outcome<T>) -> Outcome<T> {
        let slot = self.get(&self.context.drawings, drawing.v, "drawing")?;
        let mut vector = slot.value.try_write().map_err(|e| Failure::locked(&e, "drawing", "changing"))?;
        let mut changed = Vector::clone(&vector);
        let answer = change(&mut changed.drawing)?;
        *vector = Arc::new(changed);
        Ok(answer)
    }

    fn keep_drawing(&self, drawing: Drawing, left_out: Vec<String>) -> Outcome<mry_drawing> {
        let vector = RwLock::new(Arc::new(Vector { drawing, left_out }));
        Ok(mry_drawing { v: self.context.drawings.insert(vector)? })
    }

    fn keep_svg(&self, svg: SvgIn) -> Outcome<mry_drawing> {
        self.keep_drawing(svg.drawing, svg.left_out)
    }
}

/// Fills in an information struct with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_drawing_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_info_init(info: *mut mry_drawing_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Fills in a stroke struct with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param stroke  Where to write; NULL does nothing.
/// @param size    sizeof(mry_drawing_stroke) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_stroke_init(stroke: *mut mry_drawing_stroke, size: u32) {
    // SAFETY: the caller owns `size` bytes at `stroke`, or passes NULL.
    unsafe { border::init(stroke.cast(), size) }
}

/// Reads an SVG file: its shapes with groups, transforms, styles, gradients and clips. Nothing that the file refers to is
/// opened or fetched, and no script runs; text, pictures, masks and filters are left out, and mry_drawing_get_left_out says
/// so.
///
/// @param context      The context.
/// @param path         The file.
/// @param out_drawing  The drawing.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT (no SVG, or nothing in it that can move), MRY_E_LIMIT, MRY_E_IO,
///         MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_drawing_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_read_svg(
    context: *mut mry_context,
    path: mry_str,
    out_drawing: *mut mry_drawing,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_drawing, "out_drawing")?;
        let svg = Drawing::read_svg(path).map_err(|e| Failure::from(e).about("path"))?;
        out.set(call.keep_svg(svg)?);
        Ok(Code::MRY_OK)
    })
}

/// Reads the text of an SVG file, as mry_drawing_read_svg does.
///
/// @param context      The context.
/// @param svg          The text.
/// @param out_drawing  The drawing.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_STRING.
/// Lifetime: until mry_drawing_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_from_svg(
    context: *mut mry_context,
    svg: mry_str,
    out_drawing: *mut mry_drawing,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = svg.text("svg")?;
        let out = Out::new(out_drawing, "out_drawing")?;
        let svg = Drawing::from_svg(text).map_err(|e| Failure::from(e).about("svg"))?;
        out.set(call.keep_svg(svg)?);
        Ok(Code::MRY_OK)
    })
}

/// Creates a drawing without strokes, to be drawn by mry_drawing_add_stroke.
///
/// @param context      The context.
/// @param width        Width of the page in pixels, above 0.
/// @param height       Height of the page in pixels, above 0.
/// @param out_drawing  The drawing.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT, MRY_E_NON_FINITE.
/// Lifetime: until mry_drawing_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_create(
    context: *mut mry_context,
    width: f64,
    height: f64,
    out_drawing: *mut mry_drawing,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_drawing, "out_drawing")?;
        for (value, param) in [(width, "width"), (height, "height")] {
            if !value.is_finite() {
                return Err(Failure::new(Code::MRY_E_NON_FINITE, param, format!("{param} is {value}")));
            }
            if value <= 0.0 {
                return Err(Failure::argument(param, format!("{param} is {value}, and must be above 0")));
            }
        }
        let drawing = Drawing { size: (width, height), ..Drawing::default() };
        out.set(call.keep_drawing(drawing, Vec::new())?);
        Ok(Code::MRY_OK)
    })
}

/// Adds a stroke over the others, as a pen drew it: the samples become a smooth line, as wide as the pen was pressed.
///
/// @param context       The context.
/// @param drawing       The drawing.
/// @param name          A name that no other stroke has; empty to have one made.
/// @param samples       Where the pen was, one after the other.
/// @param sample_count  How many; at least 1, which makes a dot.
/// @param width         The line's width in pixels at a pressure of 0.5, above 0.
/// @param rgba          Red, green, blue, alpha: 4 bytes.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a name that is taken), MRY_E_NON_FINITE, MRY_E_ARGUMENT, MRY_E_LIMIT, MRY_E_STRING,
///         MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_add_stroke(
    context: *mut mry_context,
    drawing: mry_drawing,
    name: mry_str,
    samples: *const mry_pen_sample,
    sample_count: usize,
    width: f32,
    rgba: *const u8,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.text("name")?;
        let rgba: [u8; 4] = match border::slice(rgba, 4, 4, "rgba")? {
            &[r, g, b, a] => [r, g, b, a],
            _ => return Err(border::null("rgba")),
        };
        if sample_count == 0 {
            return Err(Failure::argument("sample_count", "sample_count is 0; give at least 1"));
        }
        let samples = border::slice(samples, sample_count, MOST_SAMPLES, "samples")?;
        if let Some(i) = samples.iter().position(|s| !(s.x.is_finite() && s.y.is_finite() && s.pressure.is_finite())) {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "samples", format!("samples[{i}] is no place")));
        }
        if !width.is_finite() {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "width", format!("width is {width}")));
        }
        if width <= 0.0 {
            return Err(Failure::argument("width", format!("width is {width}, and must be above 0")));
        }
        let sample = |s: &mry_pen_sample| PenSample { at: (s.x, s.y).into(), pressure: f64::from(s.pressure) };
        let samples: Vec<PenSample> = samples.iter().map(sample).collect();
        let [red, green, blue, alpha] = rgba;
        let pen = Pen {
            paint: Paint::Color([red, green, blue]),
            opacity: f32::from(alpha) / 255.0,
            ..Pen::plain(width.into())
        };
        call.drawing_mut(drawing, |drawing| {
            let free = |n: &usize| drawing.stroke(&format!("stroke{n}")).is_none();
            let name = match name {
                "" => (1..).find(free).map_or_else(String::new, |n| format!("stroke{n}")),
                name => name.to_owned(),
            };
            // A hand is no steadier than a thousandth of the page.
            let tolerance = drawing.size.0.hypot(drawing.size.1) / 1000.0;
            drawing.strokes.push(Stroke::freehand(name, &samples, pen, tolerance)?);
            Ok(drawing.validate()?)
        })?;
        Ok(Code::MRY_OK)
    })
}

/// Takes a stroke away.
///
/// @param context  The context.
/// @param drawing  The drawing.
/// @param name     The stroke's name.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_remove_stroke(
    context: *mut mry_context,
    drawing: mry_drawing,
    name: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.text("name")?;
        call.drawing_mut(drawing, |drawing| match drawing.strokes.iter().position(|s| s.name == name) {
            Some(i) => {
                drawing.strokes.remove(i);
                Ok(())
            }
            None => Err(Failure::new(Code::MRY_E_NOT_FOUND, "name", format!("no stroke is called `{name}`"))),
        })?;
        Ok(Code::MRY_OK)
    })
}

/// Size and counts of a drawing.
///
/// @param context   The context.
/// @param drawing   The drawing.
/// @param out_info  The answer.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_get_info(
    context: *mut mry_context,
    drawing: mry_drawing,
    out_info: *mut mry_drawing_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let vector = call.drawing(drawing)?;
        let (width, height) = vector.drawing.size;
        out.set(&mry_drawing_info {
            struct_size: 0,
            stroke_count: vector.drawing.strokes.len() as u32,
            group_count: vector.drawing.groups.len() as u32,
            left_out_count: vector.left_out.len() as u32,
            width,
            height,
        });
        Ok(Code::MRY_OK)
    })
}

/// A stroke of a drawing. Strokes count from 0, the farthest first.
///
/// @param context     The context.
/// @param drawing     The drawing.
/// @param stroke      Which, below stroke_count.
/// @param name        Where its name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity    Bytes at name.
/// @param out_size    Bytes needed, with the NUL.
/// @param out_stroke  What it is; or NULL.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (stroke), MRY_E_BUFFER_TOO_SMALL, MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_get_stroke(
    context: *mut mry_context,
    drawing: mry_drawing,
    stroke: u32,
    name: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_stroke: *mut mry_drawing_stroke,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = Text::new(name, capacity, out_size, "name")?;
        let out = OutStruct::optional(out_stroke, "out_stroke")?;
        let vector = call.drawing(drawing)?;
        let strokes = &vector.drawing.strokes;
        let wrong = || Failure::argument("stroke", format!("stroke is {stroke}, and there are {}", strokes.len()));
        let stroke = strokes.get(stroke as usize).ok_or_else(wrong)?;
        name.fill(&stroke.name)?;
        if let Some(out) = out {
            let corner = |x: f64, y: f64| mry_point { x: x as f32, y: y as f32 };
            let around = stroke.bounds().unwrap_or_default();
            out.set(&mry_drawing_stroke {
                struct_size: 0,
                has_fill: stroke.fill.is_some().into(),
                has_pen: stroke.pen.is_some().into(),
                pen_width: stroke.pen.as_ref().map_or(0.0, |p| p.width as f32),
                low: corner(around.x0, around.y0),
                high: corner(around.x1, around.y1),
            });
        }
        Ok(Code::MRY_OK)
    })
}

/// What the drawing's file had that the drawing does not hold, in a sentence.
///
/// @param context   The context.
/// @param drawing   The drawing.
/// @param index     Which, below left_out_count.
/// @param text      Where the sentence goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_get_left_out(
    context: *mut mry_context,
    drawing: mry_drawing,
    index: u32,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let vector = call.drawing(drawing)?;
        let all = &vector.left_out;
        let wrong = || Failure::argument("index", format!("index is {index}, and there are {}", all.len()));
        text.fill(all.get(index as usize).ok_or_else(wrong)?)
    })
}

/// The outline around a drawing as a closed polygon, as it is matched with the outline of what moves in a clip.
///
/// @param context    The context.
/// @param drawing    The drawing.
/// @param points     Where the corners go; NULL with capacity 0 to ask for their count.
/// @param capacity   Corners that fit.
/// @param out_count  How many there are.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (nothing is drawn), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_read_outline(
    context: *mut mry_context,
    drawing: mry_drawing,
    points: *mut mry_point,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let points = List::new(points, capacity, out_count, "points")?;
        let vector = call.drawing(drawing)?;
        let progress = Progress::new();
        let outline = call.context.executor.run(|| vector.drawing.outline(None, &progress.whole()));
        points.fill(&points_out(&outline.map_err(|e| Failure::from(e).about("drawing"))?.polygon))
    })
}

/// The drawing as the text of an SVG file.
///
/// @param context   The context.
/// @param drawing   The drawing.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_to_svg(
    context: *mut mry_context,
    drawing: mry_drawing,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        text.fill(&call.drawing(drawing)?.drawing.to_svg())
    })
}

/// Writes the drawing as an SVG file; it appears whole or not at all.
///
/// @param context  The context.
/// @param drawing  The drawing.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_write_svg(
    context: *mut mry_context,
    drawing: mry_drawing,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = call.drawing(drawing)?.drawing.to_svg();
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// Destroys a drawing. What was made of it keeps it as it was.
///
/// @param context  The context.
/// @param drawing  The drawing; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_drawing_destroy(context: *mut mry_context, drawing: mry_drawing) -> mry_status {
    ending!(context, |call| {
        if drawing.v != 0 {
            call.context.drawings.remove(drawing.v, "drawing")?;
        }
        Ok(Code::MRY_OK)
    })
}
