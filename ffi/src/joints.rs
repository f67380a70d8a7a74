//! Joints. What a person marks to capture the motion of a character: small rectangles around its joints on one frame,
//! bones between them, and corrections, which are more rectangles of the same joints on other frames. Joints under
//! construction may be incomplete; mry_joints_validate says what is missing, and every job validates its copy first.

use std::ffi::c_char;
use std::sync::{Arc, RwLock};

use marey::export::write_aside;
use marey::rig::{JointMark, JointMarks};

use crate::border::{Out, Text};
use crate::clip::mry_clip;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::{Slot, Table};

pub(crate) type JointsTable = Table<RwLock<JointMarks>>;

/// Marked joints.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_joints {
    /// The id; 0 is none.
    pub v: u64,
}

impl Call<'_> {
    fn joints_slot(&self, joints: mry_joints) -> Outcome<Arc<Slot<RwLock<JointMarks>>>> {
        self.get(&self.context.joints, joints.v, "joints")
    }

    /// Reads joints, unless they are being changed.
    pub(crate) fn joints<T>(&self, joints: mry_joints, read: impl FnOnce(&JointMarks) -> Outcome<T>) -> Outcome<T> {
        let slot = self.joints_slot(joints)?;
        match slot.value.try_read() {
            Ok(joints) => read(&joints),
            Err(e) => Err(Failure::locked(&e, "joints", "changing")),
        }
    }

    /// Changes a copy, which takes the joints' place where it is still a draft that makes sense.
    fn joints_mut(&self, joints: mry_joints, change: impl FnOnce(&mut JointMarks) -> Outcome<()>) -> Outcome<Code> {
        let slot = self.joints_slot(joints)?;
        match slot.value.try_write() {
            Ok(mut joints) => {
                let mut changed = joints.clone();
                change(&mut changed)?;
                changed.validate_draft(None)?;
                *joints = changed;
                Ok(Code::MRY_OK)
            }
            Err(e) => Err(Failure::locked(&e, "joints", "changing")),
        }
    }

    fn keep_joints(&self, joints: JointMarks) -> Outcome<mry_joints> {
        Ok(mry_joints { v: self.context.joints.insert(RwLock::new(joints))? })
    }
}

/// Creates joints of which none is marked.
///
/// @param context     The context.
/// @param width       The clip's pixels across, at least 1.
/// @param height      The clip's pixels down, at least 1.
/// @param out_joints  The joints.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT.
/// Lifetime: until mry_joints_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_create(
    context: *mut mry_context,
    width: u32,
    height: u32,
    out_joints: *mut mry_joints,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_joints, "out_joints")?;
        for (value, param) in [(width, "width"), (height, "height")] {
            if value == 0 {
                return Err(Failure::argument(param, format!("{param} is 0; give the clip's")));
            }
        }
        out.set(call.keep_joints(JointMarks { size: (width, height), ..JointMarks::default() })?);
        Ok(Code::MRY_OK)
    })
}

/// Reads a joints.json file.
///
/// @param context     The context.
/// @param path        The file.
/// @param out_joints  The joints, valid.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT, MRY_E_LIMIT, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_joints_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_read(
    context: *mut mry_context,
    path: mry_str,
    out_joints: *mut mry_joints,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_joints, "out_joints")?;
        let joints = JointMarks::read(path).map_err(|e| Failure::from(e).about("path"))?;
        out.set(call.keep_joints(joints)?);
        Ok(Code::MRY_OK)
    })
}

/// Reads the text of a joints.json.
///
/// @param context     The context.
/// @param json        The text.
/// @param out_joints  The joints, valid.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_STRING.
/// Lifetime: until mry_joints_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_from_json(
    context: *mut mry_context,
    json: mry_str,
    out_joints: *mut mry_joints,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let json = json.text("json")?;
        let out = Out::new(out_joints, "out_joints")?;
        let joints = JointMarks::from_json(json).map_err(|e| Failure::from(e).about("json"))?;
        out.set(call.keep_joints(joints)?);
        Ok(Code::MRY_OK)
    })
}

/// Writes joints as joints.json, complete or not; the file appears whole or not at all.
///
/// @param context  The context.
/// @param joints   The joints.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_write(
    context: *mut mry_context,
    joints: mry_joints,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = call.joints(joints, |joints| Ok(joints.to_json()))?;
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// The joints as the text of a joints.json.
///
/// @param context   The context.
/// @param joints    The joints.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_to_json(
    context: *mut mry_context,
    joints: mry_joints,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let json = call.joints(joints, |joints| Ok(joints.to_json()))?;
        text.fill(&json)
    })
}

/// Marks a joint on a frame, in place of an earlier mark there. The first mark of a name makes the joint; all joints
/// have to be marked on one frame, and marks on other frames are corrections.
///
/// @param context  The context.
/// @param joints   The joints.
/// @param name     The joint's name.
/// @param frame    The frame.
/// @param x        Left of the rectangle in clip pixels; the joint is at its centre.
/// @param y        Its top.
/// @param width    Its width, above 0.
/// @param height   Its height, above 0.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a rectangle outside the clip, or no rectangle), MRY_E_NON_FINITE, MRY_E_LIMIT,
///         MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_mark(
    context: *mut mry_context,
    joints: mry_joints,
    name: mry_str,
    frame: u64,
    x: f32,
    y: f32,
    width: f32,
    height: f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.text("name")?.to_owned();
        for (value, param) in [(x, "x"), (y, "y"), (width, "width"), (height, "height")] {
            if !value.is_finite() {
                return Err(Failure::new(Code::MRY_E_NON_FINITE, param, format!("{param} is {value}")));
            }
        }
        let frame = usize::try_from(frame).unwrap_or(usize::MAX);
        call.joints_mut(joints, |joints| {
            joints.put(JointMark { name, frame, rect: [x, y, width, height] });
            Ok(())
        })
    })
}

/// Takes back a joint's mark on a frame. A joint without marks, and without bones, is gone.
///
/// @param context  The context.
/// @param joints   The joints.
/// @param name     The joint's name.
/// @param frame    The frame.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND, MRY_E_INPUT (the last mark of a joint that has bones), MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_unmark(
    context: *mut mry_context,
    joints: mry_joints,
    name: mry_str,
    frame: u64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = name.text("name")?;
        let found = usize::try_from(frame).unwrap_or(usize::MAX);
        call.joints_mut(joints, |joints| {
            if joints.remove(name, found) {
                Ok(())
            } else {
                Err(Failure::new(
                    Code::MRY_E_NOT_FOUND,
                    "name",
                    format!("joint `{name}` is not marked on frame {frame}"),
                ))
            }
        })
    })
}

/// Adds a bone between two marked joints. Bones make a tree, or several.
///
/// @param context  The context.
/// @param joints   The joints.
/// @param parent   The joint that the other hangs on.
/// @param child    The other.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no such joint, a circle, a second parent), MRY_E_LIMIT, MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_add_bone(
    context: *mut mry_context,
    joints: mry_joints,
    parent: mry_str,
    child: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let bone = (parent.text("parent")?.to_owned(), child.text("child")?.to_owned());
        call.joints_mut(joints, |joints| {
            joints.bones.push(bone);
            Ok(())
        })
    })
}

/// Destroys joints. Jobs that were started with them keep their copy.
///
/// @param context  The context.
/// @param joints   The joints; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_destroy(context: *mut mry_context, joints: mry_joints) -> mry_status {
    ending!(context, |call| {
        if joints.v != 0 {
            call.context.joints.remove(joints.v, "joints")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// Whether jobs can work with the joints: all marked on one frame, rectangles inside the clip, and so on.
///
/// @param context  The context.
/// @param joints   The joints.
/// @param clip     The clip they are for, whose size and length they must fit; {0} to leave that out.
/// @param err      What is missing or wrong, where, and what to do; or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_joints_validate(
    context: *mut mry_context,
    joints: mry_joints,
    clip: mry_clip,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let clip = if clip.v == 0 { None } else { Some(call.clip(clip, "clip")?) };
        let fit = clip.map(|c| ((c.info().width, c.info().height), c.info().frames));
        call.joints(joints, |joints| joints.validate(fit).map_err(|e| Failure::from(e).about("joints")))?;
        Ok(Code::MRY_OK)
    })
}
