//! Another time.

use super::*;
use crate::retiming::RetimeOptions;

/// Makes a description of `options` and hands it over while what it points at is alive.
fn retiming<T>(options: &RetimeOptions<'_>, use_it: impl FnOnce(*const mry_retime_desc) -> T) -> T {
    let keys = options.time_keys();
    let mut desc = sized!(mry_retime_desc_init, mry_retime_desc);
    (desc.direction, desc.easing, desc.hold) = (options.direction, options.easing, options.hold);
    (desc.speed, desc.seconds, desc.fps) = (options.speed, options.seconds, options.fps);
    (desc.closed, desc.smooth) = (u32::from(options.closed), u32::from(options.smooth));
    (desc.keys, desc.key_count) = (keys.as_ptr(), keys.len());
    use_it(&desc)
}

pub(crate) fn motion_retime(handle: &Handle, motion: mry_motion, options: &RetimeOptions<'_>) -> Result<mry_motion> {
    let mut made = mry_motion::default();
    retiming(options, |desc| call!(mry_motion_retime(handle, motion, desc, &mut made)))?;
    Ok(made)
}

pub(crate) fn creature_retime(
    handle: &Handle,
    creature: mry_creature,
    options: &RetimeOptions<'_>,
) -> Result<mry_creature> {
    let mut made = mry_creature::default();
    retiming(options, |desc| call!(mry_creature_retime(handle, creature, desc, &mut made)))?;
    Ok(made)
}

pub(crate) fn take_retime(handle: &Handle, take: mry_take, options: &RetimeOptions<'_>) -> Result<mry_take> {
    let mut made = mry_take::default();
    retiming(options, |desc| call!(mry_take_retime(handle, take, desc, &mut made)))?;
    Ok(made)
}

pub(crate) fn sketch_take_retime(
    handle: &Handle,
    sketch_take: mry_sketch_take,
    options: &RetimeOptions<'_>,
) -> Result<mry_sketch_take> {
    let mut made = mry_sketch_take::default();
    retiming(options, |desc| call!(mry_sketch_take_retime(handle, sketch_take, desc, &mut made)))?;
    Ok(made)
}

pub(crate) fn retime_places(handle: &Handle, frames: (u64, f64), options: &RetimeOptions<'_>) -> Result<Vec<f64>> {
    retiming(options, |desc| {
        sized_list(|places, capacity, count| {
            call!(mry_retime_read_places(handle, frames.0, frames.1, desc, places, capacity, count))
        })
    })
}
