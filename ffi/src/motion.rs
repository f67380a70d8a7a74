//! Motions. A motion is named tracks over time, one a limb in the rig's order: for each frame where the limb's points
//! are, which are seen, and how far each is to be trusted.

use std::ffi::c_char;
use std::sync::{Arc, RwLock};

use marey::export::write_aside;
use marey::motion::Motion;

use crate::border::{self, Out, OutStruct, Text, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;

pub(crate) type MotionTable = Table<RwLock<Arc<Motion>>>;

/// A motion.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_motion {
    /// The id; 0 is no motion.
    pub v: u64,
}

/// What a motion is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_motion_info {
    /// sizeof(mry_motion_info).
    pub struct_size: u32,
    /// The clip's pixels across.
    pub width: u32,
    /// The clip's pixels down.
    pub height: u32,
    /// How many tracks there are.
    pub track_count: u32,
    /// How many frames every track has.
    pub frame_count: u64,
    /// Frames a second.
    pub fps: f64,
    /// How many pairs of tracks mry_motion_get_bone has.
    pub bone_count: u32,
    /// Zero.
    pub reserved0: u32,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_motion_info {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_motion_info>() == 40);

impl Call<'_> {
    pub(crate) fn motion(&self, motion: mry_motion) -> Outcome<Arc<Motion>> {
        let slot = self.get(&self.context.motions, motion.v, "motion")?;
        let motion = slot.value.try_read().map_err(|e| Failure::locked(&e, "motion", "changing"))?;
        Ok(motion.clone())
    }

    pub(crate) fn keep_motion(&self, motion: Arc<Motion>) -> Outcome<mry_motion> {
        Ok(mry_motion { v: self.context.motions.insert(RwLock::new(motion))? })
    }
}

/// Fills in a motion info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_motion_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_info_init(info: *mut mry_motion_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Reads a motion.json file.
///
/// @param context     The context.
/// @param path        The file.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_read(
    context: *mut mry_context,
    path: mry_str,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_motion, "out_motion")?;
        let motion = Motion::read(path).map_err(|e| Failure::from(e).about("path"))?;
        out.set(call.keep_motion(Arc::new(motion))?);
        Ok(Code::MRY_OK)
    })
}

/// Reads the text of a motion.json.
///
/// @param context     The context.
/// @param json        The text.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_STRING.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_from_json(
    context: *mut mry_context,
    json: mry_str,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let json = json.text("json")?;
        let out = Out::new(out_motion, "out_motion")?;
        let motion = Motion::from_json(json).map_err(|e| Failure::from(e).about("json"))?;
        out.set(call.keep_motion(Arc::new(motion))?);
        Ok(Code::MRY_OK)
    })
}

/// Writes a motion as motion.json; the file appears whole or not at all.
///
/// @param context  The context.
/// @param motion   The motion.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_write(
    context: *mut mry_context,
    motion: mry_motion,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = call.motion(motion)?.to_json();
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// The motion as the text of a motion.json.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_to_json(
    context: *mut mry_context,
    motion: mry_motion,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        text.fill(&call.motion(motion)?.to_json())
    })
}

/// Destroys a motion.
///
/// @param context  The context.
/// @param motion   The motion; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_destroy(context: *mut mry_context, motion: mry_motion) -> mry_status {
    ending!(context, |call| {
        if motion.v != 0 {
            call.context.motions.remove(motion.v, "motion")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// What a motion is: size, tracks, frames.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_get_info(
    context: *mut mry_context,
    motion: mry_motion,
    out_info: *mut mry_motion_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let motion = call.motion(motion)?;
        out.set(&mry_motion_info {
            struct_size: 0,
            width: motion.size.0,
            height: motion.size.1,
            track_count: motion.tracks.len() as u32,
            frame_count: motion.frames as u64,
            fps: motion.fps,
            bone_count: motion.bones.len() as u32,
            reserved0: 0,
        });
        Ok(Code::MRY_OK)
    })
}
