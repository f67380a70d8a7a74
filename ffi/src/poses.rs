//! Poses. Key poses of a character over time, from which a take makes every frame. They belong to the character as it was
//! when they were made; for one that has changed since, make them anew from their text: joints that it does not name
//! hang as they do at rest.

use std::ffi::c_char;
use std::sync::{Arc, RwLock};

use marey::export::write_aside;
use marey::shape::character::{Easing, KeyPose, Poses};

use crate::border::{self, List, Lists, Out, OutStruct, Text, Versioned};
use crate::character::{Drawn, mry_character};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::skeleton::MOST_JOINTS;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_in, points_out};
use crate::table::Table;

/// Key poses with the character that they are of.
#[derive(Clone)]
pub(crate) struct Posed {
    pub(crate) drawn: Arc<Drawn>,
    pub(crate) poses: Poses,
}

pub(crate) type PosesTable = Table<RwLock<Arc<Posed>>>;

/// Key poses.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_poses {
    /// The id; 0 is no poses.
    pub v: u64,
}

/// Easing: evenly to the next key.
pub const MRY_EASING_LINEAR: i32 = 0;
/// Easing: slowly first.
pub const MRY_EASING_IN: i32 = 1;
/// Easing: slowly at last.
pub const MRY_EASING_OUT: i32 = 2;
/// Easing: slowly at both ends.
pub const MRY_EASING_INOUT: i32 = 3;
/// Easing: not at all until the next key.
pub const MRY_EASING_HOLD: i32 = 4;

const EASINGS: [Easing; 5] = [Easing::Linear, Easing::In, Easing::Out, Easing::InOut, Easing::Hold];

pub(crate) fn easing_in(easing: i32) -> Outcome<Easing> {
    let no = || Failure::argument("easing", format!("easing is {easing}, which is no MRY_EASING"));
    usize::try_from(easing).ok().and_then(|e| EASINGS.get(e)).copied().ok_or_else(no)
}

/// What poses are.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_poses_info {
    /// sizeof(mry_poses_info).
    pub struct_size: u32,
    /// Every pose stays for so many frames.
    pub step: u32,
    /// Frames a second.
    pub fps: f64,
    /// How many keys there are.
    pub key_count: u64,
    /// How many frames there are: up to the last key.
    pub frame_count: u64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_poses_info {
    const FIRST_SIZE: usize = 32;
}
const _: () = assert!(size_of::<mry_poses_info>() == 32);

impl Call<'_> {
    pub(crate) fn poses(&self, poses: mry_poses) -> Outcome<Arc<Posed>> {
        let slot = self.get(&self.context.poses, poses.v, "poses")?;
        let posed = slot.value.try_read().map_err(|e| Failure::locked(&e, "poses", "changing"))?;
        Ok(posed.clone())
    }

    /// Changes poses; who shares them keeps them as they were.
    fn poses_mut<T>(&self, poses: mry_poses, change: impl FnOnce(&mut Posed) -> Outcome<T>) -> Outcome<T> {
        let slot = self.get(&self.context.poses, poses.v, "poses")?;
        let mut posed = slot.value.try_write().map_err(|e| Failure::locked(&e, "poses", "changing"))?;
        change(Arc::make_mut(&mut posed))
    }

    fn keep_poses(&self, posed: Posed) -> Outcome<mry_poses> {
        Ok(mry_poses { v: self.context.poses.insert(RwLock::new(Arc::new(posed)))? })
    }

    fn frame_in(&self, frame: u64) -> Outcome<usize> {
        let most = self.context.limits.frames;
        usize::try_from(frame).ok().filter(|_| frame < most).ok_or_else(|| {
            Failure::new(Code::MRY_E_LIMIT, "frame", format!("frame is {frame}, and at most {most} are allowed"))
        })
    }
}

fn rate_in(fps: f64, step: u32) -> Outcome<(f64, usize)> {
    if !fps.is_finite() {
        return Err(Failure::new(Code::MRY_E_NON_FINITE, "fps", format!("fps is {fps}")));
    }
    if fps < 0.0 {
        return Err(Failure::argument("fps", format!("fps is {fps}, and must be above 0")));
    }
    Ok((if fps == 0.0 { 24.0 } else { fps }, step.max(1) as usize))
}

impl Posed {
    fn key(&mut self, frame: usize) -> Outcome<&mut KeyPose> {
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "frame", format!("frame {frame} has no key pose"));
        self.poses.keys.iter_mut().find(|k| k.frame == frame).ok_or_else(none)
    }
}

/// Fills in a poses info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_poses_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_info_init(info: *mut mry_poses_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Creates poses without a key.
///
/// @param context    The context.
/// @param character  The character.
/// @param fps        Frames a second; 0 for 24.
/// @param step       Frames that every pose stays for, 2 for animation "on twos"; 0 for 1.
/// @param out_poses  The poses.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (fps), MRY_E_NON_FINITE, MRY_E_BUSY.
/// Lifetime: until mry_poses_destroy or the end of the context; the character may change or go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_create(
    context: *mut mry_context,
    character: mry_character,
    fps: f64,
    step: u32,
    out_poses: *mut mry_poses,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_poses, "out_poses")?;
        let (fps, step) = rate_in(fps, step)?;
        let drawn = call.character(character)?;
        out.set(call.keep_poses(Posed { drawn, poses: Poses { fps, step, keys: Vec::new() } })?);
        Ok(Code::MRY_OK)
    })
}

/// Reads a poses.json file for a character.
///
/// @param context    The context.
/// @param character  The character.
/// @param path       The file.
/// @param out_poses  The poses.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Lifetime: until mry_poses_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_read(
    context: *mut mry_context,
    character: mry_character,
    path: mry_str,
    out_poses: *mut mry_poses,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_poses, "out_poses")?;
        let drawn = call.character(character)?;
        let poses = Poses::read(path, &drawn.character).map_err(|e| Failure::from(e).about("path"))?;
        out.set(call.keep_poses(Posed { drawn, poses })?);
        Ok(Code::MRY_OK)
    })
}

/// Reads the text of a poses.json for a character.
///
/// @param context    The context.
/// @param character  The character.
/// @param json       The text.
/// @param out_poses  The poses.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_STRING, MRY_E_BUSY.
/// Lifetime: until mry_poses_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_from_json(
    context: *mut mry_context,
    character: mry_character,
    json: mry_str,
    out_poses: *mut mry_poses,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let json = json.text("json")?;
        let out = Out::new(out_poses, "out_poses")?;
        let drawn = call.character(character)?;
        let poses = Poses::from_json(json, &drawn.character).map_err(|e| Failure::from(e).about("json"))?;
        out.set(call.keep_poses(Posed { drawn, poses })?);
        Ok(Code::MRY_OK)
    })
}

/// Poses as the text of a poses.json.
///
/// @param context   The context.
/// @param poses     The poses.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_to_json(
    context: *mut mry_context,
    poses: mry_poses,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let posed = call.poses(poses)?;
        text.fill(&posed.poses.to_json(&posed.drawn.character))
    })
}

/// Writes poses.json; the file appears whole or not at all.
///
/// @param context  The context.
/// @param poses    The poses.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_write(
    context: *mut mry_context,
    poses: mry_poses,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let posed = call.poses(poses)?;
        let text = posed.poses.to_json(&posed.drawn.character);
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// What poses are: counts and rate.
///
/// @param context   The context.
/// @param poses     The poses.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_get_info(
    context: *mut mry_context,
    poses: mry_poses,
    out_info: *mut mry_poses_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let posed = call.poses(poses)?;
        let Poses { fps, step, keys } = &posed.poses;
        out.set(&mry_poses_info {
            struct_size: 0,
            step: *step as u32,
            fps: *fps,
            key_count: keys.len() as u64,
            frame_count: keys.last().map_or(0, |k| k.frame as u64 + 1),
        });
        Ok(Code::MRY_OK)
    })
}

/// Sets the rate.
///
/// @param context  The context.
/// @param poses    The poses.
/// @param fps      Frames a second; 0 for 24.
/// @param step     Frames that every pose stays for; 0 for 1.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (fps), MRY_E_NON_FINITE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_set_rate(
    context: *mut mry_context,
    poses: mry_poses,
    fps: f64,
    step: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (fps, step) = rate_in(fps, step)?;
        call.poses_mut(poses, |posed| {
            (posed.poses.fps, posed.poses.step) = (fps, step);
            Ok(Code::MRY_OK)
        })
    })
}

/// Sets the joints of a frame, which becomes a key; what else was set for it stays.
///
/// @param context      The context.
/// @param poses        The poses.
/// @param frame        The frame, counted from 0.
/// @param joints       Where each joint is.
/// @param joint_count  How many: joint_count of the character.
/// @param easing       How the way to the next key is spread: MRY_EASING_LINEAR, ...
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (joint_count, easing), MRY_E_NON_FINITE, MRY_E_LIMIT (frame, keys), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_set_key(
    context: *mut mry_context,
    poses: mry_poses,
    frame: u64,
    joints: *const mry_point,
    joint_count: usize,
    easing: i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let joints =
            points_in(border::slice(joints, joint_count, MOST_JOINTS, "joints")?).map_err(|e| e.about("joints"))?;
        let frame = call.frame_in(frame)?;
        let easing = easing_in(easing)?;
        let most = call.context.limits.key_frames;
        call.poses_mut(poses, |posed| {
            let count = posed.drawn.character.skeleton.joints.len();
            if joints.len() != count {
                let message = format!("joint_count is {joint_count}, and the skeleton has {count}");
                return Err(Failure::argument("joint_count", message));
            }
            let keys = &mut posed.poses.keys;
            let at = keys.partition_point(|k| k.frame < frame);
            if keys.get(at).is_none_or(|k| k.frame != frame) {
                if keys.len() >= most {
                    let message = format!("there are {most} keys, and no more are allowed");
                    return Err(Failure::new(Code::MRY_E_LIMIT, "frame", message));
                }
                keys.insert(at, KeyPose { frame, ..KeyPose::default() });
            }
            (keys[at].joints, keys[at].easing) = (joints, easing);
            Ok(Code::MRY_OK)
        })
    })
}

/// Takes a key away.
///
/// @param context  The context.
/// @param poses    The poses.
/// @param frame    Its frame.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (no key), MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_remove_key(
    context: *mut mry_context,
    poses: mry_poses,
    frame: u64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let frame = call.frame_in(frame)?;
        call.poses_mut(poses, |posed| {
            posed.key(frame)?;
            posed.poses.keys.retain(|k| k.frame != frame);
            Ok(Code::MRY_OK)
        })
    })
}

/// One key: its frame, its easing, and where the joints are.
///
/// @param context     The context.
/// @param poses       The poses.
/// @param key         Which, below key_count, by rising frames.
/// @param out_frame   Its frame; or NULL.
/// @param out_easing  Its easing; or NULL.
/// @param joints      Where each joint is; NULL with capacity 0 to ask for the count.
/// @param capacity    Joints that fit.
/// @param out_count   Joints of the character.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (key), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_get_key(
    context: *mut mry_context,
    poses: mry_poses,
    key: u64,
    out_frame: *mut u64,
    out_easing: *mut i32,
    joints: *mut mry_point,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let joints = List::new(joints, capacity, out_count, "joints")?;
        let (out_frame, out_easing) =
            (Out::optional(out_frame, "out_frame")?, Out::optional(out_easing, "out_easing")?);
        let posed = call.poses(poses)?;
        let keys = &posed.poses.keys;
        let none = || Failure::argument("key", format!("key is {key}, and there are {}", keys.len()));
        let key = usize::try_from(key).ok().and_then(|k| keys.get(k)).ok_or_else(none)?;
        joints.fill(&points_out(&key.joints))?;
        out_frame.inspect(|out| out.set(key.frame as u64));
        let easing = EASINGS.iter().position(|e| *e == key.easing).unwrap_or(0);
        out_easing.inspect(|out| out.set(easing as i32));
        Ok(Code::MRY_OK)
    })
}

/// Sets the vertices that a key drags by hand, in place of those set before.
///
/// @param context   The context.
/// @param poses     The poses.
/// @param frame     The key's frame.
/// @param vertices  Vertices of the mesh.
/// @param ways      How far each is from where the deformation puts it.
/// @param count     How many; 0 for none.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (no key), MRY_E_ARGUMENT (a vertex), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_set_moved(
    context: *mut mry_context,
    poses: mry_poses,
    frame: u64,
    vertices: *const u32,
    ways: *const mry_point,
    count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        const MOST: usize = 1 << 22;
        let vertices = border::slice(vertices, count, MOST, "vertices")?;
        let ways = points_in(border::slice(ways, count, MOST, "ways")?).map_err(|e| e.about("ways"))?;
        let frame = call.frame_in(frame)?;
        call.poses_mut(poses, |posed| {
            let most = posed.drawn.character.mesh.points.len();
            if let Some(v) = vertices.iter().find(|v| **v as usize >= most) {
                return Err(Failure::argument("vertices", format!("vertex {v} is named, and there are {most}")));
            }
            posed.key(frame)?.moved = vertices.iter().copied().zip(ways).collect();
            Ok(Code::MRY_OK)
        })
    })
}

/// The vertices that a key drags by hand.
///
/// @param context    The context.
/// @param poses      The poses.
/// @param frame      The key's frame.
/// @param vertices   Vertices of the mesh; or NULL.
/// @param ways       How far each is from where the deformation puts it; or NULL.
/// @param capacity   Vertices that fit into each list.
/// @param out_count  How many there are.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (no key), MRY_E_BUFFER_TOO_SMALL, MRY_E_ARGUMENT (capacity), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_get_moved(
    context: *mut mry_context,
    poses: mry_poses,
    frame: u64,
    vertices: *mut u32,
    ways: *mut mry_point,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let mut lists = Lists::new(capacity, out_count)?;
        let vertices = lists.list(vertices, 1, "vertices")?;
        let ways = lists.list(ways, 1, "ways")?;
        let frame = call.frame_in(frame)?;
        let mut posed = (*call.poses(poses)?).clone();
        let moved = &posed.key(frame)?.moved;
        lists.fit(moved.len())?;
        if let Some(vertices) = vertices {
            vertices.write(&moved.iter().map(|m| m.0).collect::<Vec<u32>>())?;
        }
        if let Some(ways) = ways {
            ways.write(&points_out(&moved.iter().map(|m| m.1).collect::<Vec<_>>()))?;
        }
        Ok(Code::MRY_OK)
    })
}

/// Sets how near to the viewer a bone's region is from a key to the next.
///
/// @param context  The context.
/// @param poses    The poses.
/// @param frame    The key's frame.
/// @param bone     Which, below bone_count of the character.
/// @param depth    Larger is nearer; regions of one depth are drawn in the mesh's order. 0 where it was not set.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (no key), MRY_E_ARGUMENT (bone), MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_set_depth(
    context: *mut mry_context,
    poses: mry_poses,
    frame: u64,
    bone: u32,
    depth: i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let frame = call.frame_in(frame)?;
        call.poses_mut(poses, |posed| {
            let count = posed.drawn.character.skeleton.bones.len();
            if bone as usize >= count {
                return Err(Failure::argument("bone", format!("bone is {bone}, and there are {count}")));
            }
            let depths = &mut posed.key(frame)?.depth;
            depths.retain(|d| d.0 != bone);
            if depth != 0 {
                depths.push((bone, depth));
            }
            Ok(Code::MRY_OK)
        })
    })
}

/// Destroys poses.
///
/// @param context  The context.
/// @param poses    The poses; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_poses_destroy(context: *mut mry_context, poses: mry_poses) -> mry_status {
    ending!(context, |call| {
        if poses.v != 0 {
            call.context.poses.remove(poses.v, "poses")?;
        }
        Ok(Code::MRY_OK)
    })
}
