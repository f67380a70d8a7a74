//! Retargeting. Any motion moves any character: its joints follow tracks by a map, by their names, or, where neither says
//! it, by the likeness of the two figures. Motions come from tracking, from other programs by mry_motion_add_track, and
//! from BVH files, which motion capture writes.

use std::ffi::c_char;
use std::sync::Arc;

use marey::Vec2;
use marey::export::write_aside;
use marey::motion::Motion;
use marey::motion::bvh::{View, from_bvh, to_bvh};
use marey::motion::matching::{MadeFrom, complete};
use marey::motion::retarget::{Angles, RestSkeleton, RetargetMap, RetargetParams, retarget};
use marey::shape::character::Skeleton;

use crate::border::{self, Out, Text, Versioned, reserved};
use crate::character::mry_character;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::motion::mry_motion;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// What of a bone's direction is carried over: how far it turned since the reference frame.
pub const MRY_ANGLES_RELATIVE: i32 = 0;
/// What of a bone's direction is carried over: where it points.
pub const MRY_ANGLES_ABSOLUTE: i32 = 1;

/// From where a BVH file is seen: along z, x to the right.
pub const MRY_VIEW_FRONT: i32 = 0;
/// From where a BVH file is seen: along x, z to the right.
pub const MRY_VIEW_SIDE: i32 = 1;
/// From where a BVH file with z up is seen: x to the right.
pub const MRY_VIEW_FRONT_Z_UP: i32 = 2;
/// From where a BVH file with z up is seen: y to the right.
pub const MRY_VIEW_SIDE_Z_UP: i32 = 3;

/// How a motion is carried over. Start from MRY_RETARGET_DESC_INIT; nothing must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_retarget_desc {
    /// sizeof(mry_retarget_desc).
    pub struct_size: u32,
    /// MRY_ANGLES_RELATIVE or MRY_ANGLES_ABSOLUTE.
    pub angles: i32,
    /// The frame of the motion that the character at rest corresponds to.
    pub reference: u64,
    /// Bones change their length with the motion's up to this factor either way; 1 keeps all lengths, 0 is for 3.
    pub stretch: f32,
    /// What the way of the roots is scaled by; 0 for the ratio of the figures' sizes.
    pub root_scale: f32,
    /// 1 to leave the roots where they are; 0 to let them go.
    pub in_place: u32,
    /// Zero.
    pub reserved0: u32,
    /// The text of a map.json; empty to match by names or by likeness.
    pub map: mry_str,
    /// Names of joints that stay where they come down, such as feet.
    pub planted: *const mry_str,
    /// How many.
    pub planted_count: u64,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and strings that the host vouches for.
unsafe impl Versioned for mry_retarget_desc {
    const FIRST_SIZE: usize = 64;
}
const _: () = assert!(size_of::<mry_retarget_desc>() == 64);

/// How a motion is carried over, once read.
#[derive(Clone, Default)]
pub(crate) struct Carrying {
    pub(crate) map: Option<RetargetMap>,
    pub(crate) params: RetargetParams,
}

impl Carrying {
    /// # Safety
    /// The description is NULL or valid, as the header asks.
    pub(crate) unsafe fn read(desc: *const mry_retarget_desc, param: &'static str) -> Outcome<Self> {
        if desc.is_null() {
            return Ok(Self::default());
        }
        // SAFETY: as this function's own.
        let desc = unsafe { border::read(desc, param)? };
        reserved(desc.reserved0)?;
        let mut params = RetargetParams {
            angles: match desc.angles {
                MRY_ANGLES_RELATIVE => Angles::Relative,
                MRY_ANGLES_ABSOLUTE => Angles::Absolute,
                n => {
                    return Err(Failure::argument(
                        "desc.angles",
                        format!("desc.angles is {n}, which is no MRY_ANGLES"),
                    ));
                }
            },
            reference: usize::try_from(desc.reference).unwrap_or(usize::MAX),
            ..RetargetParams::default()
        };
        for (value, name) in [(desc.stretch, "desc.stretch"), (desc.root_scale, "desc.root-scale")] {
            if !value.is_finite() {
                return Err(Failure::new(Code::MRY_E_NON_FINITE, name, format!("{name} is {value}")));
            }
        }
        if desc.in_place > 1 {
            return Err(Failure::argument("desc.in_place", format!("desc.in_place is {}; give 0 or 1", desc.in_place)));
        }
        if desc.stretch != 0.0 {
            params.stretch = f64::from(desc.stretch);
        }
        params.root_scale = match (desc.in_place, desc.root_scale) {
            (1, _) => Some(0.0),
            (_, 0.0) => None,
            (_, scale) => Some(f64::from(scale)),
        };
        let count = usize::try_from(desc.planted_count).unwrap_or(usize::MAX);
        // SAFETY: as this function's own.
        for name in unsafe { border::slice(desc.planted, count, crate::skeleton::MOST_JOINTS, "desc.planted")? } {
            // SAFETY: as this function's own.
            params.planted.push(unsafe { name.text("desc.planted")? }.to_owned());
        }
        // SAFETY: as this function's own.
        let map = if desc.map.len == 0 { None } else { Some(unsafe { desc.map.text("desc.map")? }) };
        let map = map.map(RetargetMap::from_json).transpose().map_err(|e| Failure::from(e).about("desc.map"))?;
        Ok(Self { map, params })
    }

    /// The motion on the skeleton, and what followed what.
    pub(crate) fn carry(
        &self,
        motion: &Motion,
        skeleton: &Skeleton,
        size: (u32, u32),
    ) -> marey::Result<(Motion, RetargetMap, MadeFrom)> {
        let joints: Vec<(String, Vec2)> = skeleton.joints.iter().map(|j| (j.name.clone(), j.at)).collect();
        let rest = RestSkeleton { joints: &joints, bones: &skeleton.bones, size };
        let (map, from) = complete(motion, rest, self.map.as_ref(), self.params.reference)?;
        Ok((retarget(motion, rest, &map, &self.params)?, map, from))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_retarget_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_retarget_desc_init(desc: *mut mry_retarget_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Carries a motion over to a character: a motion of joint tracks, one for each of its joints, in its pixels.
///
/// @param context     The context.
/// @param motion      The motion.
/// @param character   The character.
/// @param desc        How; NULL for the defaults.
/// @param out_motion  The motion of the character's joints.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (nothing matches, a map or a planted joint that names what is not there, a reference
///         beyond the end, a stretch below 1), MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRING, MRY_E_STRUCT_SIZE,
///         MRY_E_BUSY.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_retarget(
    context: *mut mry_context,
    motion: mry_motion,
    character: mry_character,
    desc: *const mry_retarget_desc,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let carrying = Carrying::read(desc, "desc")?;
        let (motion, drawn) = (call.motion(motion)?, call.character(character)?);
        let (carried, ..) = carrying.carry(&motion, &drawn.character.skeleton, drawn.character.size)?;
        out.set(call.keep_motion(Arc::new(carried))?);
        Ok(Code::MRY_OK)
    })
}

/// Which joint of a character follows what of a motion, as the text of a map.json that a person can correct.
///
/// @param context    The context.
/// @param motion     The motion.
/// @param character  The character.
/// @param desc       How; NULL for the defaults. A map in it is completed.
/// @param text       Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity   Bytes at text.
/// @param out_size   Bytes needed, with the NUL.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, and what mry_motion_retarget returns.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_match(
    context: *mut mry_context,
    motion: mry_motion,
    character: mry_character,
    desc: *const mry_retarget_desc,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let carrying = Carrying::read(desc, "desc")?;
        let (motion, drawn) = (call.motion(motion)?, call.character(character)?);
        let (_, map, _) = carrying.carry(&motion, &drawn.character.skeleton, drawn.character.size)?;
        text.fill(&map.to_json())
    })
}

fn view_in(view: i32) -> Outcome<View> {
    match view {
        MRY_VIEW_FRONT => Ok(View::Front),
        MRY_VIEW_SIDE => Ok(View::Side),
        MRY_VIEW_FRONT_Z_UP => Ok(View::FrontZUp),
        MRY_VIEW_SIDE_Z_UP => Ok(View::SideZUp),
        _ => Err(Failure::argument("view", format!("view is {view}, which is no MRY_VIEW"))),
    }
}

/// Reads a BVH file as a motion of joints: its skeleton in space, seen from one side.
///
/// @param context     The context.
/// @param path        The file.
/// @param view        From where: MRY_VIEW_FRONT, ...
/// @param height      Pixels that its way and its height are scaled to, with a margin; 0 for 512.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT (what is not BVH, with its line), MRY_E_IO, MRY_E_ARGUMENT (view, path),
///         MRY_E_STRING.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_read_bvh(
    context: *mut mry_context,
    path: mry_str,
    view: i32,
    height: u32,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_motion, "out_motion")?;
        let view = view_in(view)?;
        let about = |e| Failure::from(e).about("path");
        let text = std::fs::read_to_string(path).map_err(|e| about(marey::Error::io(path, "read", e)))?;
        let motion = from_bvh(&text, view, if height == 0 { 512 } else { height });
        let named = |e| match e {
            marey::Error::Invalid { what, problem, remedy } => {
                marey::Error::file(path, format!("{what}: {problem}"), remedy)
            }
            other => other,
        };
        out.set(call.keep_motion(Arc::new(motion.map_err(named).map_err(about)?))?);
        Ok(Code::MRY_OK)
    })
}

/// Writes a motion's joints as a BVH file; strokes and points are left out. The file appears whole or not at all.
///
/// @param context  The context.
/// @param motion   The motion.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no joints, bones in a circle, no place for a file), MRY_E_IO, MRY_E_STRING,
///         MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_write_bvh(
    context: *mut mry_context,
    motion: mry_motion,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = to_bvh(&*call.motion(motion)?)?;
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}
