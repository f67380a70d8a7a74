//! What can be made of a motion.

use super::*;
use crate::motion_shaping::{LimbMapOptions, LoopOptions, PlantOptions};

pub(crate) fn motion_cycle(handle: &Handle, motion: mry_motion) -> Result<mry_cycle> {
    let mut cycle = sized!(mry_cycle_init, mry_cycle);
    call!(mry_motion_find_cycle(handle, motion, &mut cycle))?;
    Ok(cycle)
}

pub(crate) fn motion_phases(handle: &Handle, motion: mry_motion) -> Result<Vec<(f64, f64)>> {
    let mut count = motion_info(handle, motion)?.track_count as usize;
    let (mut phases, mut swings) = (vec![0.0; count], vec![0.0; count]);
    call!(mry_motion_read_phases(handle, motion, phases.as_mut_ptr(), swings.as_mut_ptr(), count, &mut count))?;
    Ok(phases.into_iter().zip(swings).collect())
}

pub(crate) fn motion_loop(
    handle: &Handle,
    motion: mry_motion,
    options: &LoopOptions,
) -> Result<(mry_motion, mry_seam)> {
    let mut desc = sized!(mry_loop_desc_init, mry_loop_desc);
    desc.keep_travel = u32::from(options.keep_travel);
    (desc.start, desc.period) = options.range.unwrap_or_default();
    (desc.cycles, desc.frame_count, desc.fps) = (options.cycles, options.frames, options.fps);
    (desc.fade, desc.no_fade) = (options.fade.unwrap_or_default(), u32::from(options.fade == Some(0.0)));
    let (mut made, mut seam) = (mry_motion::default(), sized!(mry_seam_init, mry_seam));
    call!(mry_motion_loop(handle, motion, &desc, &mut made, &mut seam))?;
    Ok((made, seam))
}

pub(crate) fn motion_smooth(
    handle: &Handle,
    motion: mry_motion,
    period: f64,
    held: Option<&[u64]>,
) -> Result<mry_motion> {
    let mut desc = sized!(mry_smooth_desc_init, mry_smooth_desc);
    desc.period = period;
    let frames = held.unwrap_or_default();
    (desc.only_frames, desc.frames, desc.frame_count) = (u32::from(held.is_some()), frames.as_ptr(), frames.len());
    let mut made = mry_motion::default();
    call!(mry_motion_smooth(handle, motion, &desc, &mut made))?;
    Ok(made)
}

/// Makes a description of `options` and hands it over while what it points at is alive.
fn planting<T>(options: &PlantOptions<'_>, use_it: impl FnOnce(*const mry_plant_desc) -> T) -> T {
    let feet: Vec<mry_str> = options.feet.iter().map(|name| str(name)).collect();
    let mut desc = sized!(mry_plant_desc_init, mry_plant_desc);
    (desc.still, desc.closed) = (u32::from(options.still), u32::from(options.closed));
    (desc.has_ground, desc.ground) = (u32::from(options.ground.is_some()), options.ground.unwrap_or_default());
    (desc.ease, desc.feet, desc.foot_count) = (options.ease, feet.as_ptr(), feet.len());
    use_it(&desc)
}

pub(crate) fn motion_plant(handle: &Handle, motion: mry_motion, options: &PlantOptions<'_>) -> Result<mry_motion> {
    let mut made = mry_motion::default();
    planting(options, |desc| call!(mry_motion_plant(handle, motion, desc, &mut made)))?;
    Ok(made)
}

pub(crate) fn motion_contacts(handle: &Handle, motion: mry_motion, options: &PlantOptions<'_>) -> Result<String> {
    planting(options, |desc| {
        sized_text(|text, capacity, size| call!(mry_motion_get_contacts(handle, motion, desc, text, capacity, size)))
    })
}

fn limb_map_desc(options: &LimbMapOptions<'_>) -> mry_limb_map_desc {
    let mut desc = sized!(mry_limb_map_desc_init, mry_limb_map_desc);
    desc.angles = i32::from(options.absolute);
    desc.faces = options
        .mirror
        .map_or(MRY_FACES_EITHER_WAY, |m| if m { MRY_FACES_THE_OTHER_WAY } else { MRY_FACES_THE_SAME_WAY });
    desc.reference_from_one = options.reference.map_or(0, |f| f.saturating_add(1));
    desc.rest_from_one = options.rest.map_or(0, |f| f.saturating_add(1));
    (desc.stretch, desc.travel) = (options.stretch, options.travel.unwrap_or_default());
    (desc.in_place, desc.map) = (u32::from(options.travel == Some(0.0)), str(options.map));
    desc
}

pub(crate) fn motion_map_limbs(
    handle: &Handle,
    (motion, creature): (mry_motion, mry_motion),
    options: &LimbMapOptions<'_>,
) -> Result<mry_motion> {
    let (desc, mut made) = (limb_map_desc(options), mry_motion::default());
    call!(mry_motion_map_limbs(handle, motion, creature, &desc, &mut made))?;
    Ok(made)
}

pub(crate) fn motion_match_limbs(
    handle: &Handle,
    (motion, creature): (mry_motion, mry_motion),
    options: &LimbMapOptions<'_>,
) -> Result<String> {
    let desc = limb_map_desc(options);
    sized_text(|text, capacity, size| {
        call!(mry_motion_match_limbs(handle, motion, creature, &desc, text, capacity, size))
    })
}
