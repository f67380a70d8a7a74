//! A creature's limbs. Which bones carry which limb, what it hangs from, and what posing goes by. Limbs count from 0, in
//! the order of the rig; a file that another program wrote may know none.

use std::ffi::c_char;

use crate::border::{self, OutStruct, Text, Versioned};
use crate::context::mry_context;
use crate::creature::mry_creature;
use crate::error::{Failure, mry_error};
use crate::guard::entry;
use crate::limb::side_out;
use crate::status::{mry_status, mry_status_code as Code};

/// A limb of a creature. Its bones stand evenly along its stroke, from the end nearer to the root outward.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_creature_limb {
    /// sizeof(mry_creature_limb).
    pub struct_size: u32,
    /// MRY_SIDE_UNKNOWN, ...
    pub side: i32,
    /// The other of the pair, or -1.
    pub twin: i32,
    /// The limb it hangs from, or -1 for one that holds a root.
    pub parent: i32,
    /// 1 where it hangs from the end of that limb away from the root, 0 where from the start.
    pub parent_at_end: u32,
    /// 1 where its strokes are drawn from the end away from the root.
    pub reversed: u32,
    /// Its first bone; the others follow.
    pub first_bone: u32,
    /// How many bones it has.
    pub bone_count: u32,
    /// Its length when it lies in the image plane, in world units.
    pub length: f32,
    /// Its mean radius, in world units.
    pub radius: f32,
    /// How far beyond its hip it stands from what it hangs from, in world units toward the viewer.
    pub offset: f32,
    /// Zero.
    pub reserved0: u32,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_creature_limb {
    const FIRST_SIZE: usize = 48;
}
const _: () = assert!(size_of::<mry_creature_limb>() == 48);

/// Fills in a creature's limb with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param limb  Where to write; NULL does nothing.
/// @param size  sizeof(mry_creature_limb) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_limb_init(limb: *mut mry_creature_limb, size: u32) {
    // SAFETY: the caller owns `size` bytes at `limb`, or passes NULL.
    unsafe { border::init(limb.cast(), size) }
}

/// A limb's label and what it is.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param limb      Which, below limb_count.
/// @param label     Where the label goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at label.
/// @param out_size  Bytes needed, with the NUL.
/// @param out_limb  The answer, its struct_size set; or NULL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_BUFFER_TOO_SMALL, MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_limb(
    context: *mut mry_context,
    creature: mry_creature,
    limb: u32,
    label: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_limb: *mut mry_creature_limb,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(label, capacity, out_size, "label")?;
        let out_limb = OutStruct::optional(out_limb, "out_limb")?;
        let creature = call.creature(creature)?;
        let limbs = &creature.creature.limbs;
        let none = || Failure::argument("limb", format!("limb is {limb}, and there are {}", limbs.len()));
        let limb = limbs.get(limb as usize).ok_or_else(none)?;
        text.fill(&limb.label)?;
        let index = |limb: Option<usize>| limb.map_or(-1, |l| l as i32);
        out_limb.inspect(|out| {
            out.set(&mry_creature_limb {
                struct_size: 0,
                side: side_out(limb.side),
                twin: index(limb.twin),
                parent: index(limb.parent.map(|p| p.limb)),
                parent_at_end: u32::from(limb.parent.is_some_and(|p| p.at_end)),
                reversed: u32::from(limb.reversed),
                first_bone: limb.first_bone as u32,
                bone_count: limb.bones as u32,
                length: limb.length,
                radius: limb.radius,
                offset: limb.offset,
                reserved0: 0,
            });
        });
        Ok(Code::MRY_OK)
    })
}
