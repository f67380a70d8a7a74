//! Limb maps. Any motion moves the limbs of any creature: another clip's limbs, a character's joints, motion capture. Each
//! limb follows a stroke or a chain of joints, by a map that a person can correct, and keeps its own lengths and its own
//! bearing.

use std::ffi::c_char;
use std::sync::Arc;

use marey::motion::Motion;
use marey::motion::limb_map::{LimbMap, LimbMapParams, RestLimb, map_limbs, propose_map, rest_limbs};
use marey::motion::retarget::Angles;

use crate::bind_job::{MRY_FACES_EITHER_WAY, MRY_FACES_THE_OTHER_WAY, MRY_FACES_THE_SAME_WAY};
use crate::border::{self, Out, Text, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::motion::mry_motion;
use crate::motion_cycle::{given, switch};
use crate::retargeting::{MRY_ANGLES_ABSOLUTE, MRY_ANGLES_RELATIVE};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// How a motion is carried over to limbs. Start from MRY_LIMB_MAP_DESC_INIT; nothing must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_limb_map_desc {
    /// sizeof(mry_limb_map_desc).
    pub struct_size: u32,
    /// MRY_ANGLES_RELATIVE or MRY_ANGLES_ABSOLUTE.
    pub angles: i32,
    /// MRY_FACES_EITHER_WAY, ...: whether the creature faces as what moves does; the other way, the motion is mirrored.
    pub faces: i32,
    /// 1 to leave the whole where it is; 0 to let it go.
    pub in_place: u32,
    /// The frame of the motion that the limbs at rest correspond to, counted from 1; 0 for its mean pose.
    pub reference_from_one: u64,
    /// The frame of the creature's own motion in which its limbs are at rest, counted from 1; 0 for its mean pose.
    pub rest_from_one: u64,
    /// Limbs change their length with the motion's up to this factor either way; 0 for 1, which keeps all lengths.
    pub stretch: f64,
    /// What the way of the whole is scaled by; 0 for the ratio of the figures' sizes.
    pub travel: f64,
    /// The text of a limb map: which limb follows what; empty to propose one.
    pub map: mry_str,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and a string that the host vouches for.
unsafe impl Versioned for mry_limb_map_desc {
    const FIRST_SIZE: usize = 64;
}
const _: () = assert!(size_of::<mry_limb_map_desc>() == 64);

struct Mapping {
    rest: Option<usize>,
    map: Option<LimbMap>,
    params: LimbMapParams,
}

impl Mapping {
    unsafe fn read(desc: *const mry_limb_map_desc) -> Outcome<Self> {
        let mut params = LimbMapParams::default();
        if desc.is_null() {
            return Ok(Self { rest: None, map: None, params });
        }
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        params.angles = match desc.angles {
            MRY_ANGLES_RELATIVE => Angles::Relative,
            MRY_ANGLES_ABSOLUTE => Angles::Absolute,
            n => return Err(Failure::argument("desc.angles", format!("desc.angles is {n}, which is no MRY_ANGLES"))),
        };
        params.mirror = match desc.faces {
            MRY_FACES_EITHER_WAY => None,
            MRY_FACES_THE_SAME_WAY => Some(false),
            MRY_FACES_THE_OTHER_WAY => Some(true),
            n => return Err(Failure::argument("desc.faces", format!("desc.faces is {n}, which is no MRY_FACES"))),
        };
        let frame = |from_one: u64| from_one.checked_sub(1).map(|f| usize::try_from(f).unwrap_or(usize::MAX));
        params.reference = frame(desc.reference_from_one);
        params.stretch = given(desc.stretch, "desc.stretch")?.unwrap_or(params.stretch);
        params.travel = given(desc.travel, "desc.travel")?;
        if switch(desc.in_place, "desc.in_place")? {
            params.travel = Some(0.0);
        }
        // SAFETY: as above.
        let map = if desc.map.len == 0 { None } else { Some(unsafe { desc.map.text("desc.map")? }) };
        let map = map.map(LimbMap::from_json).transpose().map_err(|e| Failure::from(e).about("desc.map"))?;
        Ok(Self { rest: frame(desc.rest_from_one), map, params })
    }

    fn limbs_and_map(&self, motion: &Motion, creature: &Motion) -> marey::Result<(Vec<RestLimb>, LimbMap)> {
        let limbs = rest_limbs(creature, self.rest)?;
        let map = match &self.map {
            Some(map) => map.clone(),
            None => propose_map(motion, &limbs)?,
        };
        Ok((limbs, map))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_limb_map_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_limb_map_desc_init(desc: *mut mry_limb_map_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Carries a motion over to the limbs of a creature: a motion with a stroke for each of them, under its label.
///
/// @param context     The context.
/// @param motion      The motion: strokes, or joints with bones.
/// @param creature    The creature's own motion, whose strokes are its limbs.
/// @param desc        How; NULL for the defaults.
/// @param out_motion  The motion of the creature's limbs, in its clip's pixels.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (nothing matches, a map that names what is not there, a frame beyond the end, a factor
///         out of range), MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRING, MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_map_limbs(
    context: *mut mry_context,
    motion: mry_motion,
    creature: mry_motion,
    desc: *const mry_limb_map_desc,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let mapping = Mapping::read(desc)?;
        let (motion, creature) = (call.motion(motion)?, call.motion(creature).map_err(|e| e.about("creature"))?);
        let (limbs, map) = mapping.limbs_and_map(&motion, &creature)?;
        let made = map_limbs(&motion, &limbs, creature.size, &map, &mapping.params)?;
        out.set(call.keep_motion(Arc::new(made))?);
        Ok(Code::MRY_OK)
    })
}

/// Which limb of a creature follows what of a motion, as the text of a limb map that a person can correct: `{"format":
/// "marey-limb-map", "version": 1, "limbs": {"fore_near": {"tracks": ["LeftArm", "LeftForeArm"], "reversed": false}}}`.
///
/// @param context   The context.
/// @param motion    The motion.
/// @param creature  The creature's own motion.
/// @param desc      How; NULL for the defaults.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, and what mry_motion_map_limbs returns.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_match_limbs(
    context: *mut mry_context,
    motion: mry_motion,
    creature: mry_motion,
    desc: *const mry_limb_map_desc,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let mapping = Mapping::read(desc)?;
        let (motion, creature) = (call.motion(motion)?, call.motion(creature).map_err(|e| e.about("creature"))?);
        let (_, map) = mapping.limbs_and_map(&motion, &creature)?;
        text.fill(&map.to_json())
    })
}
