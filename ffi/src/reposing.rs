//! Reposing. A creature takes the pose of limbs that are drawn anew, moves from key pose to key pose, or follows any
//! motion; its joints stay closed and its limbs within what they can do. What comes out is a creature like the one that
//! went in, with frames of its own.

use std::ffi::c_char;
use std::sync::Arc;

use marey::job::Progress;
use marey::motion::limb_map::LimbMap;
use marey::motion::retarget::Angles;
use marey::shape::creature::{self, DriveParams, LimbPose, PoseKeys, PoseParams};

use crate::bones::{mry_transform, transforms_out};
use crate::border::{self, List, Out, Text, Versioned};
use crate::context::mry_context;
use crate::creature::{Creature, mry_creature};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::motion::mry_motion;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{facing_in, mry_point, points_in};

/// Lengths of a creature's bones: as long as the strokes for poses, kept for motions.
pub const MRY_LENGTHS_DEFAULT: i32 = 0;
/// Lengths of a creature's bones: kept, so that strokes only show directions.
pub const MRY_LENGTHS_KEPT: i32 = 1;
/// Lengths of a creature's bones: as the strokes have them, within the stretch.
pub const MRY_LENGTHS_DRAWN: i32 = 2;

/// A motion turns limbs as suits it: MRY_TURNS_ABSOLUTE with a body of the same lengths in a picture of the same size, else
/// MRY_TURNS_RELATIVE.
pub const MRY_TURNS_DEFAULT: i32 = 0;
/// Limbs turn as the motion's do, each from its own mean pose; a motion that faces the other way is mirrored.
pub const MRY_TURNS_RELATIVE: i32 = 1;
/// Limbs point where the motion's do.
pub const MRY_TURNS_ABSOLUTE: i32 = 2;

/// How a creature is posed. Start from MRY_REPOSE_DESC_INIT; nothing must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_repose_desc {
    /// sizeof(mry_repose_desc).
    pub struct_size: u32,
    /// MRY_LENGTHS_DEFAULT, ...
    pub lengths: i32,
    /// A limb gets at most this many times its length, 1 to 10; 0 for 1.25.
    pub stretch: f32,
    /// A limb without a facing that is drawn shorter than this share of its length leaves the image plane, up to 1; 0
    /// for 0.5.
    pub foreshortened: f32,
    /// The most that a bone turns against the one before it, in degrees up to 180; 0 for 115.
    pub sharpest: f32,
    /// For motions: what the way of the roots is scaled by; 0 for the ratio of the limbs' lengths.
    pub root_scale: f32,
    /// For motions: 1 to leave the roots where they are; 0 to let them go.
    pub in_place: u32,
    /// For motions: 1 to let left and right change places; 0 to leave them.
    pub mirror: u32,
    /// For key poses: how many frames to make; 0 for up to the last key.
    pub frames: u64,
    /// For motions: MRY_TURNS_DEFAULT, ...
    pub turns: i32,
    /// Zero.
    pub reserved0: u32,
}

// SAFETY: repr(C), starts with its u32 size; numbers.
unsafe impl Versioned for mry_repose_desc {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_repose_desc>() == 48);

/// A limb as drawn for a pose.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_limb_pose {
    /// The limb's label.
    pub limb: mry_str,
    /// The stroke, from the limb's start to its end, in clip pixels.
    pub points: *const mry_point,
    /// 2 or more.
    pub point_count: u64,
    /// MRY_FACING_UNKNOWN, ... With a facing the limb keeps its length: the shorter the stroke, the farther it leaves the
    /// image plane.
    pub facing: i32,
    /// 1 if bend says how far the free end stands from where the limb is held; 0 if its length does.
    pub has_bend: u32,
    /// That, in clip pixels toward the viewer.
    pub bend: f32,
    /// How far the free part stands from where it would, in clip pixels toward the viewer.
    pub depth: f32,
}
const _: () = assert!(size_of::<mry_limb_pose>() == 48);

/// How to pose, once read.
struct Reposing {
    drive: DriveParams,
    pose: PoseParams,
    frames: Option<usize>,
}

impl Reposing {
    /// # Safety
    /// The description is NULL or valid, as the header asks.
    unsafe fn read(desc: *const mry_repose_desc) -> Outcome<Self> {
        let (mut drive, mut pose) = (DriveParams::default(), PoseParams::default());
        if desc.is_null() {
            return Ok(Self { drive, pose, frames: None });
        }
        // SAFETY: as this function's own.
        let desc = unsafe { border::read(desc, "desc")? };
        let numbers = [
            (desc.stretch, "desc.stretch"),
            (desc.foreshortened, "desc.foreshortened"),
            (desc.sharpest, "desc.sharpest"),
            (desc.root_scale, "desc.root_scale"),
        ];
        if let Some((value, name)) = numbers.into_iter().find(|(value, _)| !value.is_finite()) {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, name, format!("{name} is {value}")));
        }
        for (value, name) in [(desc.in_place, "desc.in_place"), (desc.mirror, "desc.mirror")] {
            if value > 1 {
                return Err(Failure::argument(name, format!("{name} is {value}; give 0 or 1")));
            }
        }
        let kept = match desc.lengths {
            MRY_LENGTHS_DEFAULT => None,
            MRY_LENGTHS_KEPT => Some(true),
            MRY_LENGTHS_DRAWN => Some(false),
            n => {
                return Err(Failure::argument("desc.lengths", format!("desc.lengths is {n}, which is no MRY_LENGTHS")));
            }
        };
        for params in [&mut pose, &mut drive.pose] {
            let or = |value: f32, default: f32| if value == 0.0 { default } else { value };
            params.keep_lengths = kept.unwrap_or(params.keep_lengths);
            params.stretch = or(desc.stretch, params.stretch);
            params.foreshortened = or(desc.foreshortened, params.foreshortened);
            params.sharpest = or(desc.sharpest.to_radians(), params.sharpest);
        }
        drive.angles = match desc.turns {
            MRY_TURNS_DEFAULT => None,
            MRY_TURNS_RELATIVE => Some(Angles::Relative),
            MRY_TURNS_ABSOLUTE => Some(Angles::Absolute),
            n => return Err(Failure::argument("desc.turns", format!("desc.turns is {n}, which is no MRY_TURNS"))),
        };
        drive.mirror = desc.mirror == 1;
        drive.root_scale = match (desc.in_place, desc.root_scale) {
            (1, _) => Some(0.0),
            (_, 0.0) => None,
            (_, scale) => Some(scale),
        };
        let frames = usize::try_from(desc.frames).unwrap_or(usize::MAX);
        Ok(Self { drive, pose, frames: (frames > 0).then_some(frames) })
    }
}

impl Call<'_> {
    fn keep_reposed(&self, creature: creature::Creature) -> Outcome<mry_creature> {
        let motion = Arc::new(creature.motion());
        self.keep_creature(Arc::new(Creature::new(None, motion, creature)))
    }
}

/// # Safety
/// The text is as the header asks.
unsafe fn map_in(map: mry_str) -> Outcome<Option<LimbMap>> {
    if map.len == 0 {
        return Ok(None);
    }
    // SAFETY: as this function's own.
    let text = unsafe { map.text("map")? };
    LimbMap::from_json(text).map(Some).map_err(|e| Failure::from(e).about("map"))
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_repose_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_repose_desc_init(desc: *mut mry_repose_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// The bones of a creature in the pose of limbs that are drawn anew. A limb starts at the joint that holds it, wherever
/// its stroke does; one that is not drawn keeps its rest pose against what it hangs from. Nothing else changes, which is
/// what a drag of a limb asks for; mry_creature_repose makes a creature of poses.
///
/// @param context     The context.
/// @param creature    The creature.
/// @param limbs       The limbs, at most one entry each.
/// @param limb_count  How many.
/// @param desc        Within what limits; NULL for the defaults.
/// @param transforms  Where the bones go, one a bone; NULL with capacity 0 to ask for the count.
/// @param capacity    Transforms that fit.
/// @param out_count   Bones of the creature.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a limb that the creature has not or that is drawn twice, a stroke that is none, a limit
///         out of range), MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRING, MRY_E_STRUCT_SIZE, MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_pose(
    context: *mut mry_context,
    creature: mry_creature,
    limbs: *const mry_limb_pose,
    limb_count: usize,
    desc: *const mry_repose_desc,
    transforms: *mut mry_transform,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let transforms = List::new(transforms, capacity, out_count, "transforms")?;
        let how = Reposing::read(desc)?;
        let creature = call.creature(creature)?;
        let most = call.context.limits.points;
        let mut drawn = Vec::with_capacity(limb_count.min(creature.creature.limbs.len()));
        for limb in border::slice(limbs, limb_count, usize::from(u16::MAX), "limbs")? {
            let count = usize::try_from(limb.point_count).unwrap_or(usize::MAX);
            let facing = facing_in(limb.facing)?;
            if limb.has_bend > 1 {
                return Err(Failure::argument("limbs.has_bend", format!("has_bend is {}; give 0 or 1", limb.has_bend)));
            }
            drawn.push(LimbPose {
                limb: limb.limb.text("limbs.limb")?.to_owned(),
                points: points_in(border::slice(limb.points, count, most, "limbs.points")?)?,
                facing,
                bend: (limb.has_bend == 1).then_some(limb.bend),
                depth: limb.depth,
            });
        }
        let pose = creature.creature.posed(&drawn, &how.pose).map_err(|e| Failure::from(e).about("limbs"))?;
        transforms.fill(&transforms_out(&pose))
    })
}

/// A creature that moves from key pose to key pose: on the keys as drawn, between them by turning its bones, so that
/// limbs keep their lengths.
///
/// @param context       The context.
/// @param creature      The creature, which stays as it is.
/// @param poses         The text of a strokes.json whose key frames are the poses. Beyond limbs and strokes it may have
///                      "fps" and "step", and a key frame "easing": linear, in, out, inout or hold.
/// @param desc          How; NULL for the defaults.
/// @param out_creature  The creature in its new motion.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (text that is no strokes.json, what mry_creature_pose refuses, a picture of another
///         shape), MRY_E_LIMIT, MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRING, MRY_E_STRUCT_SIZE.
/// Lifetime: until mry_creature_destroy or the end of the context; the first creature may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_repose(
    context: *mut mry_context,
    creature: mry_creature,
    poses: mry_str,
    desc: *const mry_repose_desc,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        let creature = call.creature(creature)?;
        let text = poses.text("poses")?;
        let how = Reposing::read(desc)?;
        let about = |e| Failure::from(e).about("poses");
        let poses = PoseKeys::from_json(text).map_err(about)?;
        let progress = Progress::new();
        let reposed = creature.creature.reposed(&poses, how.frames, &how.pose, progress.whole()).map_err(about)?;
        out.set(call.keep_reposed(reposed)?);
        Ok(Code::MRY_OK)
    })
}

/// A creature that moves as a motion does: of its own clip, of another one, of a character, or captured.
///
/// @param context       The context.
/// @param creature      The creature, which stays as it is.
/// @param motion        The motion.
/// @param map           The text of a map.json that says which limb follows what: {"limbs": {"leg": {"tracks": ["hip",
///                      "knee", "foot"], "facing": "toward"}, "tail": {"tracks": ["tail"], "reversed": true}}}; a limb
///                      that it leaves out rests. Empty to match strokes by their names, or where no name is the same by likeness.
/// @param desc          How; NULL for the defaults.
/// @param out_creature  The creature in its new motion.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (nothing matches, a map that names what is not there, a limit out of range), MRY_E_LIMIT,
///         MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRING, MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Lifetime: until mry_creature_destroy or the end of the context; the first creature and the motion may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_drive(
    context: *mut mry_context,
    creature: mry_creature,
    motion: mry_motion,
    map: mry_str,
    desc: *const mry_repose_desc,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        let (creature, motion) = (call.creature(creature)?, call.motion(motion)?);
        let map = map_in(map)?;
        let how = Reposing::read(desc)?;
        let progress = Progress::new();
        let driven = creature.creature.driven(&motion, map.as_ref(), &how.drive, progress.whole())?;
        out.set(call.keep_reposed(driven)?);
        Ok(Code::MRY_OK)
    })
}

/// Which limb of a creature follows what of a motion, as the text of a map.json that a person can correct.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param motion    The motion.
/// @param map       The text of a map.json to check; empty to match by names.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_INPUT (as for mry_creature_drive), MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_match(
    context: *mut mry_context,
    creature: mry_creature,
    motion: mry_motion,
    map: mry_str,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let (creature, motion) = (call.creature(creature)?, call.motion(motion)?);
        let map = map_in(map)?;
        text.fill(&creature.creature.matched(&motion, map.as_ref())?.to_json())
    })
}

/// How hard the animation pulls a creature's limbs, as JSON: a list with, for each limb, its label, its least and
/// greatest length as shares of its length ("shortest", "longest"), the most that a bone turns against the one before it
/// in degrees ("sharpest"), and how far it comes away from its joint in clip pixels ("gap").
///
/// @param context   The context.
/// @param creature  The creature.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_strain(
    context: *mut mry_context,
    creature: mry_creature,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let strain = call.creature(creature)?.creature.strain();
        text.fill(&serde_json::to_string(&strain).unwrap_or_default())
    })
}
