//! Bindings. How motions hold a drawing: where tracked points hold it, what stays where it is, which strokes are stiff or do not
//! move, which strokes make a layer, and what holds layers together. mry_job_start_bind proposes one; everything in it is
//! the host's to change.

use std::ffi::c_char;
use std::sync::{Arc, RwLock};

use marey::export::{bind_preview, write_aside};
use marey::job::Progress;
use marey::shape::sketch::{BindPoint, Binding, LayerJoint, MotionUse, Pin, StrokeSetting};

use crate::border::{self, Out, OutStruct, Text, Versioned};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::motion::mry_motion;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_in};
use crate::table::{Slot, Table};
use crate::vector::mry_drawing;

pub(crate) type BindingTable = Table<RwLock<Binding>>;

/// How motions hold a drawing.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_binding {
    /// The id; 0 is no binding.
    pub v: u64,
}

/// What a binding holds.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_binding_info {
    /// sizeof(mry_binding_info).
    pub struct_size: u32,
    /// How many motions it names.
    pub motion_count: u32,
    /// How many points hold the drawing.
    pub point_count: u32,
    /// How many places stay.
    pub pin_count: u32,
    /// How many layers there are; 0 where all strokes are one.
    pub layer_count: u32,
    /// How many joints hold layers together.
    pub joint_count: u32,
    /// Width of the page it was made for, in pixels.
    pub width: f64,
    /// Height of the page.
    pub height: f64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_binding_info {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_binding_info>() == 40);

/// How a motion is used. Start from mry_binding_get_motion or MRY_MOTION_USE_INIT, and set scale.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_motion_use {
    /// sizeof(mry_motion_use).
    pub struct_size: u32,
    /// Pixels of the drawing that a pixel of its clip becomes, above 0.
    pub scale: f32,
    /// How far its movement is turned, in degrees, clockwise as seen.
    pub rotation: f32,
    /// How much of its way over the picture is kept: 1 all, 0 for an animal that walks on the spot.
    pub travel: f32,
    /// The frame in which the drawing is as it was drawn.
    pub frame: u64,
    /// 1 to exchange left and right, before it is turned.
    pub mirror: u32,
    /// 1 to begin again where another motion lasts longer; 0 to stay at the last frame.
    pub repeat: u32,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_motion_use {
    const FIRST_SIZE: usize = 32;
}
const _: () = assert!(size_of::<mry_motion_use>() == 32);

/// No layer has more strokes.
const MOST_STROKES: usize = 1 << 20;
/// No brush has more places.
const MOST_BRUSH_POINTS: usize = 1 << 20;

impl Call<'_> {
    fn binding_slot(&self, binding: mry_binding) -> Outcome<Arc<Slot<RwLock<Binding>>>> {
        self.get(&self.context.bindings, binding.v, "binding")
    }

    /// Reads a binding, unless it is being changed.
    pub(crate) fn binding<T>(&self, binding: mry_binding, read: impl FnOnce(&Binding) -> Outcome<T>) -> Outcome<T> {
        let slot = self.binding_slot(binding)?;
        match slot.value.try_read() {
            Ok(binding) => read(&binding),
            Err(e) => Err(Failure::locked(&e, "binding", "changing")),
        }
    }

    /// Changes a copy, which takes the binding's place where it makes sense.
    fn binding_mut<T>(&self, binding: mry_binding, change: impl FnOnce(&mut Binding) -> Outcome<T>) -> Outcome<T> {
        let slot = self.binding_slot(binding)?;
        match slot.value.try_write() {
            Ok(mut binding) => {
                let mut changed = binding.clone();
                let answer = change(&mut changed)?;
                changed.validate()?;
                *binding = changed;
                Ok(answer)
            }
            Err(e) => Err(Failure::locked(&e, "binding", "changing")),
        }
    }

    pub(crate) fn keep_binding(&self, binding: Binding) -> Outcome<mry_binding> {
        Ok(mry_binding { v: self.context.bindings.insert(RwLock::new(binding))? })
    }
}

fn at_index<'a, T>(all: &'a [T], index: u32, what: &str) -> Outcome<&'a T> {
    let wrong = || Failure::argument("index", format!("index is {index}, and there are {} {what}", all.len()));
    all.get(index as usize).ok_or_else(wrong)
}

/// Fills in a struct with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param value  Where to write; NULL does nothing.
/// @param size   sizeof(mry_binding_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_info_init(value: *mut mry_binding_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `value`, or passes NULL.
    unsafe { border::init(value.cast(), size) }
}

/// Fills in a struct with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param value  Where to write; NULL does nothing.
/// @param size   sizeof(mry_motion_use) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_use_init(value: *mut mry_motion_use, size: u32) {
    // SAFETY: the caller owns `size` bytes at `value`, or passes NULL.
    unsafe { border::init(value.cast(), size) }
}

/// Creates a binding of a drawing by which nothing is held yet.
///
/// @param context      The context.
/// @param drawing      The drawing.
/// @param out_binding  The binding.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUSY.
/// Lifetime: until mry_binding_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_create(
    context: *mut mry_context,
    drawing: mry_drawing,
    out_binding: *mut mry_binding,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_binding, "out_binding")?;
        let size = call.drawing(drawing)?.drawing.size;
        out.set(call.keep_binding(Binding { size, ..Binding::default() })?);
        Ok(Code::MRY_OK)
    })
}

/// Reads a bind.json file.
///
/// @param context      The context.
/// @param path         The file.
/// @param out_binding  The binding.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT, MRY_E_LIMIT, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_binding_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_read(
    context: *mut mry_context,
    path: mry_str,
    out_binding: *mut mry_binding,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_binding, "out_binding")?;
        let binding = Binding::read(path).map_err(|e| Failure::from(e).about("path"))?;
        out.set(call.keep_binding(binding)?);
        Ok(Code::MRY_OK)
    })
}

/// Reads the text of a bind.json.
///
/// @param context      The context.
/// @param json         The text.
/// @param out_binding  The binding.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_STRING.
/// Lifetime: until mry_binding_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_from_json(
    context: *mut mry_context,
    json: mry_str,
    out_binding: *mut mry_binding,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let json = json.text("json")?;
        let out = Out::new(out_binding, "out_binding")?;
        let binding = Binding::from_json(json).map_err(|e| Failure::from(e).about("json"))?;
        out.set(call.keep_binding(binding)?);
        Ok(Code::MRY_OK)
    })
}

/// The binding as the text of a bind.json.
///
/// @param context   The context.
/// @param binding   The binding.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_to_json(
    context: *mut mry_context,
    binding: mry_binding,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let json = call.binding(binding, |binding| Ok(binding.to_json()))?;
        text.fill(&json)
    })
}

/// Writes the binding as bind.json; the file appears whole or not at all.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_write(
    context: *mut mry_context,
    binding: mry_binding,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = call.binding(binding, |binding| Ok(binding.to_json()))?;
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// Whether a sketch can be made of the binding and a drawing: every stroke that it names is there, and so on.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param drawing  The drawing.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_validate(
    context: *mut mry_context,
    binding: mry_binding,
    drawing: mry_drawing,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let vector = call.drawing(drawing)?;
        let check = |binding: &Binding| Ok(binding.check(&vector.drawing, None)?);
        call.binding(binding, check).map_err(|e| e.about("binding"))?;
        Ok(Code::MRY_OK)
    })
}

/// Counts of a binding.
///
/// @param context   The context.
/// @param binding   The binding.
/// @param out_info  The answer.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_get_info(
    context: *mut mry_context,
    binding: mry_binding,
    out_info: *mut mry_binding_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        call.binding(binding, |binding| {
            out.set(&mry_binding_info {
                struct_size: 0,
                motion_count: binding.motions.len() as u32,
                point_count: binding.points.len() as u32,
                pin_count: binding.pins.len() as u32,
                layer_count: binding.layers.len() as u32,
                joint_count: binding.joints.len() as u32,
                width: binding.size.0,
                height: binding.size.1,
            });
            Ok(Code::MRY_OK)
        })
    })
}

/// Says how a motion is used. A name that is new adds a motion behind the others; motions are given to mry_sketch_create in
/// this order.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param name     Its name in the binding.
/// @param how      How.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_NON_FINITE, MRY_E_STRUCT_SIZE, MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_set_motion(
    context: *mut mry_context,
    binding: mry_binding,
    name: mry_str,
    how: *const mry_motion_use,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.text("name")?.to_owned();
        let how = border::read(how, "how")?;
        for (value, param) in [(how.scale, "how.scale"), (how.rotation, "how.rotation"), (how.travel, "how.travel")] {
            if !value.is_finite() {
                return Err(Failure::new(Code::MRY_E_NON_FINITE, param, format!("{param} is {value}")));
            }
        }
        for (value, param) in [(how.mirror, "how.mirror"), (how.repeat, "how.repeat")] {
            if value > 1 {
                return Err(Failure::argument(param, format!("{param} is {value}; give 0 or 1")));
            }
        }
        let frame = usize::try_from(how.frame).unwrap_or(usize::MAX);
        let mry_motion_use { scale, rotation, travel, .. } = how;
        let used = MotionUse { name, scale, rotation, mirror: how.mirror == 1, frame, travel, repeat: how.repeat == 1 };
        call.binding_mut(binding, |binding| {
            match binding.motions.iter_mut().find(|m| m.name == used.name) {
                Some(old) => *old = used,
                None => binding.motions.push(used),
            }
            Ok(Code::MRY_OK)
        })
    })
}

/// How a motion is used. Motions count from 0.
///
/// @param context   The context.
/// @param binding   The binding.
/// @param index     Which, below motion_count.
/// @param name      Where its name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at name.
/// @param out_size  Bytes needed, with the NUL.
/// @param out_use   How; or NULL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_BUFFER_TOO_SMALL, MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_get_motion(
    context: *mut mry_context,
    binding: mry_binding,
    index: u32,
    name: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_use: *mut mry_motion_use,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = Text::new(name, capacity, out_size, "name")?;
        let out = OutStruct::optional(out_use, "out_use")?;
        call.binding(binding, |binding| {
            let used = at_index(&binding.motions, index, "motions")?;
            name.fill(&used.name)?;
            if let Some(out) = out {
                out.set(&mry_motion_use {
                    struct_size: 0,
                    scale: used.scale,
                    rotation: used.rotation,
                    travel: used.travel,
                    frame: used.frame as u64,
                    mirror: used.mirror.into(),
                    repeat: used.repeat.into(),
                });
            }
            Ok(Code::MRY_OK)
        })
    })
}

/// Says where a tracked point holds the drawing, in place of where it held it before.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param motion   The motion's name; empty for the first.
/// @param track    The track's name.
/// @param index    The point of the track; 0 for tracks of one.
/// @param at       The place on the drawing, in its pixels.
/// @param layer    The layer it moves; empty for the nearest.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_set_point(
    context: *mut mry_context,
    binding: mry_binding,
    motion: mry_str,
    track: mry_str,
    index: u32,
    at: mry_point,
    layer: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (motion, track) = (motion.text("motion")?.to_owned(), track.text("track")?.to_owned());
        let (at, layer) = (at.place("at")?, layer.text("layer")?.to_owned());
        let point = BindPoint { motion, track, index: index as usize, at, layer };
        call.binding_mut(binding, |binding| {
            match binding
                .points
                .iter_mut()
                .find(|p| (&p.motion, &p.track, p.index) == (&point.motion, &point.track, point.index))
            {
                Some(old) => *old = point,
                None => binding.points.push(point),
            }
            Ok(Code::MRY_OK)
        })
    })
}

/// Lets a tracked point hold the drawing no longer.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param motion   The motion's name; empty for the first.
/// @param track    The track's name.
/// @param index    The point of the track; 0 for tracks of one.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_remove_point(
    context: *mut mry_context,
    binding: mry_binding,
    motion: mry_str,
    track: mry_str,
    index: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (motion, track) = (motion.text("motion")?, track.text("track")?);
        call.binding_mut(binding, |binding| {
            let before = binding.points.len();
            binding.points.retain(|p| (&*p.motion, &*p.track, p.index) != (motion, track, index as usize));
            if binding.points.len() < before {
                return Ok(Code::MRY_OK);
            }
            let message = format!("point {index} of `{track}` does not hold the drawing");
            Err(Failure::new(Code::MRY_E_NOT_FOUND, "track", message))
        })
    })
}

/// A tracked point that holds the drawing. They count from 0.
///
/// @param context    The context.
/// @param binding    The binding.
/// @param index      Which, below point_count.
/// @param track      Where its track's name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity   Bytes at track.
/// @param out_size   Bytes needed, with the NUL.
/// @param out_point  The point of the track; or NULL.
/// @param out_at     The place on the drawing; or NULL.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_get_point(
    context: *mut mry_context,
    binding: mry_binding,
    index: u32,
    track: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_point: *mut u32,
    out_at: *mut mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let track = Text::new(track, capacity, out_size, "track")?;
        let (out_point, out_at) = (Out::optional(out_point, "out_point")?, Out::optional(out_at, "out_at")?);
        call.binding(binding, |binding| {
            let point = at_index(&binding.points, index, "points")?;
            track.fill(&point.track)?;
            out_point.inspect(|out| out.set(point.index as u32));
            out_at.inspect(|out| out.set(mry_point { x: point.at.x, y: point.at.y }));
            Ok(Code::MRY_OK)
        })
    })
}

/// Pins a place of the drawing, which then stays where it is.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param at       The place, in the drawing's pixels.
/// @param layer    The layer; empty for the nearest.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_add_pin(
    context: *mut mry_context,
    binding: mry_binding,
    at: mry_point,
    layer: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (at, layer) = (at.place("at")?, layer.text("layer")?.to_owned());
        call.binding_mut(binding, |binding| {
            binding.pins.push(Pin { at, layer });
            Ok(Code::MRY_OK)
        })
    })
}

/// Takes a pin away; those behind it move down.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param index    Which, below pin_count.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_remove_pin(
    context: *mut mry_context,
    binding: mry_binding,
    index: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.binding_mut(binding, |binding| {
            at_index(&binding.pins, index, "pins")?;
            binding.pins.remove(index as usize);
            Ok(Code::MRY_OK)
        })
    })
}

/// A pin. They count from 0.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param index    Which, below pin_count.
/// @param out_at   The place on the drawing.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_get_pin(
    context: *mut mry_context,
    binding: mry_binding,
    index: u32,
    out_at: *mut mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_at, "out_at")?;
        call.binding(binding, |binding| {
            let at = at_index(&binding.pins, index, "pins")?.at;
            out.set(mry_point { x: at.x, y: at.y });
            Ok(Code::MRY_OK)
        })
    })
}

/// Says how a stroke is treated.
///
/// @param context     The context.
/// @param binding     The binding.
/// @param stroke      Its name.
/// @param rigidity    How much more its shape is kept than by default: 1 for the default, to 1000.
/// @param decoration  1 where it stands still, whatever moves; else 0.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (rigidity), MRY_E_ARGUMENT (decoration), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_STRING,
///         MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_set_stroke(
    context: *mut mry_context,
    binding: mry_binding,
    stroke: mry_str,
    rigidity: f32,
    decoration: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let stroke = stroke.text("stroke")?.to_owned();
        if !rigidity.is_finite() {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "rigidity", format!("rigidity is {rigidity}")));
        }
        if decoration > 1 {
            return Err(Failure::argument("decoration", format!("decoration is {decoration}; give 0 or 1")));
        }
        let setting = StrokeSetting { stroke, rigidity, decoration: decoration == 1 };
        call.binding_mut(binding, |binding| {
            match binding.strokes.iter_mut().find(|s| s.stroke == setting.stroke) {
                Some(old) => *old = setting,
                None => binding.strokes.push(setting),
            }
            Ok(Code::MRY_OK)
        })
    })
}

/// How a stroke is treated; strokes that nothing was said of are as by default.
///
/// @param context         The context.
/// @param binding         The binding.
/// @param stroke          Its name.
/// @param out_rigidity    How much more its shape is kept than by default.
/// @param out_decoration  1 where it stands still.
/// @param err             Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_get_stroke(
    context: *mut mry_context,
    binding: mry_binding,
    stroke: mry_str,
    out_rigidity: *mut f32,
    out_decoration: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let stroke = stroke.text("stroke")?;
        let (rigidity, decoration) =
            (Out::new(out_rigidity, "out_rigidity")?, Out::new(out_decoration, "out_decoration")?);
        call.binding(binding, |binding| {
            let default = StrokeSetting::default();
            let setting = binding.strokes.iter().find(|s| s.stroke == stroke).unwrap_or(&default);
            rigidity.set(setting.rigidity);
            decoration.set(setting.decoration.into());
            Ok(Code::MRY_OK)
        })
    })
}

/// Puts the strokes that a brush touches into a layer, out of those they were in. A name that is new makes a layer in front
/// of the others.
///
/// @param context      The context.
/// @param binding      The binding.
/// @param drawing      The drawing.
/// @param layer        The layer's name.
/// @param points       Where the brush goes, in the drawing's pixels.
/// @param point_count  How many.
/// @param radius       The brush's, in pixels, above 0.
/// @param out_count    How many strokes it touched; or NULL.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_NON_FINITE, MRY_E_ARGUMENT (radius), MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_paint_layer(
    context: *mut mry_context,
    binding: mry_binding,
    drawing: mry_drawing,
    layer: mry_str,
    points: *const mry_point,
    point_count: usize,
    radius: f32,
    out_count: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let layer = layer.text("layer")?;
        let count = Out::optional(out_count, "out_count")?;
        let brush = points_in(border::slice(points, point_count, MOST_BRUSH_POINTS, "points")?)?;
        if !radius.is_finite() {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "radius", format!("radius is {radius}")));
        }
        if radius <= 0.0 {
            return Err(Failure::argument("radius", format!("radius is {radius}, and must be above 0")));
        }
        let vector = call.drawing(drawing)?;
        let touched =
            call.binding_mut(binding, |binding| Ok(binding.paint_layer(&vector.drawing, layer, &brush, radius).len()))?;
        count.inspect(|out| out.set(touched as u32));
        Ok(Code::MRY_OK)
    })
}

/// Puts strokes into a layer, out of those they were in. A name that is new makes a layer in front of the others; with the first,
/// all other strokes make one behind it.
///
/// @param context       The context.
/// @param binding       The binding.
/// @param drawing       The drawing.
/// @param layer         The layer's name.
/// @param strokes       The names of the strokes.
/// @param stroke_count  How many.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no such stroke), MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_set_layer(
    context: *mut mry_context,
    binding: mry_binding,
    drawing: mry_drawing,
    layer: mry_str,
    strokes: *const mry_str,
    stroke_count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let layer = layer.text("layer")?;
        let vector = call.drawing(drawing)?;
        let names = border::slice(strokes, stroke_count, MOST_STROKES, "strokes")?;
        let found = names.iter().map(|name| {
            let name = name.text("strokes")?;
            let missing = || Failure::new(Code::MRY_E_INPUT, "strokes", format!("no stroke is called `{name}`"));
            vector.drawing.stroke(name).ok_or_else(missing)
        });
        let strokes = found.collect::<Outcome<Vec<usize>>>()?;
        call.binding_mut(binding, |binding| {
            binding.put_in_layer(&vector.drawing, &strokes, layer);
            Ok(Code::MRY_OK)
        })
    })
}

/// Writes a PNG of the drawing with numbers where tracked points hold it, and beside it, where a clip is given, the frame of the
/// clip that the drawing is like, with the same numbers.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param drawing  The drawing.
/// @param motion   The motion that the points are of.
/// @param clip     The clip it was tracked in; {0} for the drawing alone.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT, MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_write_preview(
    context: *mut mry_context,
    binding: mry_binding,
    drawing: mry_drawing,
    motion: mry_motion,
    clip: mry_clip,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let path = path.name("path")?;
        let (vector, motion) = (call.drawing(drawing)?, call.motion(motion)?);
        let clip = if clip.v == 0 { None } else { Some(call.clip(clip, "clip")?) };
        let binding = call.binding(binding, |binding| Ok(binding.clone()))?;
        let png = || bind_preview(&vector.drawing, &binding, &motion, clip.as_deref());
        write_aside(path, &call.context.executor.run(png)?).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// Takes a layer away, with its joints: its strokes go to the farthest of the others, its points and pins to the nearest.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param layer    Its name.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_remove_layer(
    context: *mut mry_context,
    binding: mry_binding,
    layer: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let layer = layer.text("layer")?;
        call.binding_mut(binding, |binding| {
            if binding.layers.iter().all(|l| l.name != layer) {
                return Err(Failure::new(Code::MRY_E_NOT_FOUND, "layer", format!("no layer is called `{layer}`")));
            }
            binding.remove_layer(layer);
            Ok(Code::MRY_OK)
        })
    })
}

/// The name of a layer. Layers count from 0, the farthest first; bind.json lists their strokes.
///
/// @param context   The context.
/// @param binding   The binding.
/// @param index     Which, below layer_count.
/// @param name      Where its name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at name.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_get_layer(
    context: *mut mry_context,
    binding: mry_binding,
    index: u32,
    name: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = Text::new(name, capacity, out_size, "name")?;
        call.binding(binding, |binding| name.fill(&at_index(&binding.layers, index, "layers")?.name))
    })
}

/// Proposes what holds layers together: a joint in the middle of each place where two of them cross. Joints that were there
/// are replaced.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param drawing  The drawing.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_BUSY.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_propose_joints(
    context: *mut mry_context,
    binding: mry_binding,
    drawing: mry_drawing,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let vector = call.drawing(drawing)?;
        call.binding_mut(binding, |binding| {
            let progress = Progress::new();
            binding.joints = call.context.executor.run(|| vector.drawing.propose_joints(binding, progress.whole()))?;
            Ok(Code::MRY_OK)
        })
    })
}

/// Moves a joint. They count from 0.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param index    Which, below joint_count.
/// @param at       The place on the drawing, in its pixels.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_NON_FINITE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_set_joint(
    context: *mut mry_context,
    binding: mry_binding,
    index: u32,
    at: mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let at = at.place("at")?;
        call.binding_mut(binding, |binding| {
            at_index(&binding.joints, index, "joints")?;
            binding.joints[index as usize].at = at;
            Ok(Code::MRY_OK)
        })
    })
}

/// Holds two layers together at a place.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param layer    One layer's name.
/// @param other    The other's.
/// @param at       The place on the drawing, in its pixels.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no such layer), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_add_joint(
    context: *mut mry_context,
    binding: mry_binding,
    layer: mry_str,
    other: mry_str,
    at: mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let layers = (layer.text("layer")?.to_owned(), other.text("other")?.to_owned());
        let at = at.place("at")?;
        call.binding_mut(binding, |binding| {
            binding.joints.push(LayerJoint { layers, at });
            Ok(Code::MRY_OK)
        })
    })
}

/// Takes a joint away; those behind it move down.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param index    Which, below joint_count.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_remove_joint(
    context: *mut mry_context,
    binding: mry_binding,
    index: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.binding_mut(binding, |binding| {
            at_index(&binding.joints, index, "joints")?;
            binding.joints.remove(index as usize);
            Ok(Code::MRY_OK)
        })
    })
}

/// Where a joint holds two layers together.
///
/// @param context  The context.
/// @param binding  The binding.
/// @param index    Which, below joint_count.
/// @param out_at   The place on the drawing.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_get_joint(
    context: *mut mry_context,
    binding: mry_binding,
    index: u32,
    out_at: *mut mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_at, "out_at")?;
        call.binding(binding, |binding| {
            let at = at_index(&binding.joints, index, "joints")?.at;
            out.set(mry_point { x: at.x, y: at.y });
            Ok(Code::MRY_OK)
        })
    })
}

/// Destroys a binding. Sketches that were made with it keep it as it was.
///
/// @param context  The context.
/// @param binding  The binding; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_binding_destroy(context: *mut mry_context, binding: mry_binding) -> mry_status {
    ending!(context, |call| {
        if binding.v != 0 {
            call.context.bindings.remove(binding.v, "binding")?;
        }
        Ok(Code::MRY_OK)
    })
}
