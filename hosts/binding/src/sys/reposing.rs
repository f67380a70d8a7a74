//! The calls that pose creatures.

use super::*;
use crate::creature::ReposeOptions;

fn description(options: &ReposeOptions<'_>) -> mry_repose_desc {
    let mut desc = sized!(mry_repose_desc_init, mry_repose_desc);
    desc.lengths = match options.keep_lengths {
        None => MRY_LENGTHS_DEFAULT,
        Some(true) => MRY_LENGTHS_KEPT,
        Some(false) => MRY_LENGTHS_DRAWN,
    };
    (desc.stretch, desc.root_scale) = (options.stretch, options.root_scale.unwrap_or(0.0));
    desc.in_place = u32::from(options.root_scale == Some(0.0));
    desc.turns = match options.absolute {
        None => MRY_TURNS_DEFAULT,
        Some(false) => MRY_TURNS_RELATIVE,
        Some(true) => MRY_TURNS_ABSOLUTE,
    };
    (desc.mirror, desc.frames) = (u32::from(options.mirror), options.frames);
    desc
}

pub(crate) fn creature_repose(
    handle: &Handle,
    creature: mry_creature,
    poses: &str,
    options: &ReposeOptions<'_>,
) -> Result<mry_creature> {
    let mut made = mry_creature::default();
    call!(mry_creature_repose(handle, creature, str(poses), &description(options), &mut made))?;
    Ok(made)
}

pub(crate) fn creature_drive(
    handle: &Handle,
    creature: mry_creature,
    motion: mry_motion,
    options: &ReposeOptions<'_>,
) -> Result<mry_creature> {
    let mut made = mry_creature::default();
    call!(mry_creature_drive(handle, creature, motion, str(options.map), &description(options), &mut made))?;
    Ok(made)
}

pub(crate) fn creature_match(handle: &Handle, creature: mry_creature, motion: mry_motion, map: &str) -> Result<String> {
    sized_text(|text, capacity, size| {
        call!(mry_creature_match(handle, creature, motion, str(map), text, capacity, size))
    })
}

pub(crate) fn creature_strain(handle: &Handle, creature: mry_creature) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_creature_get_strain(handle, creature, text, capacity, size)))
}
