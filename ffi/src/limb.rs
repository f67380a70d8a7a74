//! Limbs. A limb is a body part that does not branch. A rig's limbs count from 0 in the order they were added.

use std::ffi::c_char;

use marey::rig::{Limb, Rig, Side};

use crate::border::{Out, Text};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::rig::mry_rig;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// A bound for a rig that grows call by call; the engine's own bound is the same.
const MAX_LIMBS: usize = 256;

/// Side of a limb: not said.
pub const MRY_SIDE_UNKNOWN: i32 = 0;
/// Side of a limb: of a pair, the one toward the viewer.
pub const MRY_SIDE_NEAR: i32 = 1;
/// Side of a limb: of a pair, the one away from the viewer, often hidden.
pub const MRY_SIDE_FAR: i32 = 2;
/// Side of a limb: not of a pair, such as body, neck, head, tail.
pub const MRY_SIDE_MID: i32 = 3;

pub(crate) fn limb_index(rig: &Rig, limb: u32) -> Outcome<usize> {
    let count = rig.limbs.len();
    let inside = (limb as usize) < count;
    if inside {
        Ok(limb as usize)
    } else {
        Err(Failure::argument("limb", format!("limb is {limb}, and there are {count}")))
    }
}

pub(crate) fn side_in(side: i32) -> Outcome<Option<Side>> {
    match side {
        MRY_SIDE_UNKNOWN => Ok(None),
        MRY_SIDE_NEAR => Ok(Some(Side::Near)),
        MRY_SIDE_FAR => Ok(Some(Side::Far)),
        MRY_SIDE_MID => Ok(Some(Side::Mid)),
        _ => Err(Failure::argument("side", format!("side is {side}, which is no MRY_SIDE"))),
    }
}

pub(crate) fn side_out(side: Option<Side>) -> i32 {
    match side {
        None => MRY_SIDE_UNKNOWN,
        Some(Side::Near) => MRY_SIDE_NEAR,
        Some(Side::Far) => MRY_SIDE_FAR,
        Some(Side::Mid) => MRY_SIDE_MID,
    }
}

/// Adds a limb: a body part that does not branch.
///
/// @param context   The context.
/// @param rig       The rig.
/// @param label     Its name, unique in the rig.
/// @param side      MRY_SIDE_UNKNOWN, ...
/// @param out_limb  Its index.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (label in use or empty, side), MRY_E_STRING, MRY_E_LIMIT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_add_limb(
    context: *mut mry_context,
    rig: mry_rig,
    label: mry_str,
    side: i32,
    out_limb: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let label = label.name("label")?;
        let side = side_in(side)?;
        let out = Out::new(out_limb, "out_limb")?;
        call.rig_mut(rig, |rig| {
            if rig.limbs.iter().any(|l| l.label == label) {
                return Err(Failure::argument("label", format!("limb `{label}` is in the rig already")));
            }
            if rig.limbs.len() >= MAX_LIMBS {
                let message = format!("the rig has {MAX_LIMBS} limbs, and no more are allowed");
                return Err(Failure::new(Code::MRY_E_LIMIT, "rig", message));
            }
            rig.limbs.push(Limb { label: label.to_owned(), side });
            out.set(rig.limbs.len() as u32 - 1);
            Ok(Code::MRY_OK)
        })
    })
}

/// How many limbs the rig has.
///
/// @param context    The context.
/// @param rig        The rig.
/// @param out_count  The number.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_get_limb_count(
    context: *mut mry_context,
    rig: mry_rig,
    out_count: *mut u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_count, "out_count")?;
        out.set(call.rig(rig, |rig| Ok(rig.limbs.len() as u32))?);
        Ok(Code::MRY_OK)
    })
}

/// A limb's label and side.
///
/// @param context   The context.
/// @param rig       The rig.
/// @param limb      Its index.
/// @param label     Where the label goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at label.
/// @param out_size  Bytes needed, with the NUL.
/// @param out_side  MRY_SIDE_UNKNOWN, ...; or NULL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_get_limb(
    context: *mut mry_context,
    rig: mry_rig,
    limb: u32,
    label: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_side: *mut i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(label, capacity, out_size, "label")?;
        let out_side = Out::optional(out_side, "out_side")?;
        let limb = call.rig(rig, |rig| Ok(rig.limbs[limb_index(rig, limb)?].clone()))?;
        text.fill(&limb.label)?;
        out_side.inspect(|out| out.set(side_out(limb.side)));
        Ok(Code::MRY_OK)
    })
}

/// The longest drawn length of a limb: what a drawing tool shows a person who draws it again.
///
/// @param context     The context.
/// @param rig         The rig.
/// @param limb        Its index.
/// @param out_length  Clip pixels; 0 for a limb that is not drawn.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_rig_get_length_hint(
    context: *mut mry_context,
    rig: mry_rig,
    limb: u32,
    out_length: *mut f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_length, "out_length")?;
        out.set(call.rig(rig, |rig| Ok(rig.length_hint(limb_index(rig, limb)?)))?);
        Ok(Code::MRY_OK)
    })
}
