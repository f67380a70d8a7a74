//! Rigs. A rig is what a person draws on a clip: labelled limbs, one stroke a limb on each key frame, and hints for
//! the segmenter. A rig under construction may be incomplete; mry_rig_validate says what is missing, and every job
//! validates its copy first.

use std::ffi::c_char;
use std::sync::{Arc, RwLock};

use marey::export::write_aside;
use marey::rig::Rig;

use crate::border::{Out, Text};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::{Slot, Table};

pub(crate) type RigTable = Table<RwLock<Rig>>;

/// A rig.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_rig {
    /// The id; 0 is no rig.
    pub v: u64,
}

impl Call<'_> {
    fn rig_slot(&self, rig: mry_rig) -> Outcome<Arc<Slot<RwLock<Rig>>>> {
        self.get(&self.context.rigs, rig.v, "rig")
    }

    /// Reads a rig, unless it is being changed.
    pub(crate) fn rig<T>(&self, rig: mry_rig, read: impl FnOnce(&Rig) -> Outcome<T>) -> Outcome<T> {
        let slot = self.rig_slot(rig)?;
        match slot.value.try_read() {
            Ok(rig) => read(&rig),
            Err(e) => Err(Failure::locked(&e, "rig", "changing")),
        }
    }

    pub(crate) fn rig_mut<T>(&self, rig: mry_rig, change: impl FnOnce(&mut Rig) -> Outcome<T>) -> Outcome<T> {
        let slot = self.rig_slot(rig)?;
        match slot.value.try_write() {
            Ok(mut rig) => change(&mut rig),
            Err(e) => Err(Failure::locked(&e, "rig", "changing")),
        }
    }
}

/// Creates an empty rig.
///
/// @param context  The context.
/// @param width    The clip's pixels across, at least 1.
/// @param height   The clip's pixels down, at least 1.
/// @param out_rig  The rig.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT.
/// Lifetime: until mry_rig_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_create(
    context: *mut mry_context,
    width: u32,
    height: u32,
    out_rig: *mut mry_rig,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_rig, "out_rig")?;
        for (value, param) in [(width, "width"), (height, "height")] {
            if value == 0 {
                return Err(Failure::argument(param, format!("{param} is 0; give the clip's")));
            }
        }
        let rig = Rig { size: (width, height), limbs: Vec::new(), keyframes: Vec::new() };
        out.set(mry_rig { v: call.context.rigs.insert(RwLock::new(rig))? });
        Ok(Code::MRY_OK)
    })
}

/// Reads a strokes.json file.
///
/// @param context  The context.
/// @param path     The file; masks are looked for beside it.
/// @param out_rig  The rig, valid.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT, MRY_E_LIMIT, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_rig_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_read(
    context: *mut mry_context,
    path: mry_str,
    out_rig: *mut mry_rig,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_rig, "out_rig")?;
        let rig = Rig::read(path).map_err(|e| Failure::from(e).about("path"))?;
        out.set(mry_rig { v: call.context.rigs.insert(RwLock::new(rig))? });
        Ok(Code::MRY_OK)
    })
}

/// Reads the text of a strokes.json.
///
/// @param context  The context.
/// @param json     The text.
/// @param out_rig  The rig, valid.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_STRING.
/// Lifetime: until mry_rig_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_from_json(
    context: *mut mry_context,
    json: mry_str,
    out_rig: *mut mry_rig,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let json = json.text("json")?;
        let out = Out::new(out_rig, "out_rig")?;
        let rig = Rig::from_json(json).map_err(|e| Failure::from(e).about("json"))?;
        out.set(mry_rig { v: call.context.rigs.insert(RwLock::new(rig))? });
        Ok(Code::MRY_OK)
    })
}

/// Writes a rig as strokes.json, complete or not; the file appears whole or not at all.
///
/// @param context  The context.
/// @param rig      The rig.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_write(
    context: *mut mry_context,
    rig: mry_rig,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = call.rig(rig, |rig| Ok(rig.to_json()))?;
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// The rig as the text of a strokes.json.
///
/// @param context   The context.
/// @param rig       The rig.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_to_json(
    context: *mut mry_context,
    rig: mry_rig,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let json = call.rig(rig, |rig| Ok(rig.to_json()))?;
        text.fill(&json)
    })
}

/// Destroys a rig. Jobs that were started with it keep their copy.
///
/// @param context  The context.
/// @param rig      The rig; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_destroy(context: *mut mry_context, rig: mry_rig) -> mry_status {
    ending!(context, |call| {
        if rig.v != 0 {
            call.context.rigs.remove(rig.v, "rig")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// Whether jobs can work with the rig: each limb drawn somewhere, strokes within reach of the image, and so on.
///
/// @param context  The context.
/// @param rig      The rig.
/// @param clip     The clip it is for, whose size and length it must fit; {0} to leave that out.
/// @param err      What is missing or wrong, where, and what to do; or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_validate(
    context: *mut mry_context,
    rig: mry_rig,
    clip: mry_clip,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let clip = if clip.v == 0 { None } else { Some(call.clip(clip, "clip")?) };
        let fit = clip.map(|c| ((c.info().width, c.info().height), c.info().frames));
        call.rig(rig, |rig| rig.validate(fit).map_err(|e| Failure::from(e).about("rig")))?;
        Ok(Code::MRY_OK)
    })
}
