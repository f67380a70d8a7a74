//! Pictures of creatures.

use marey_ffi::*;

use super::{Handle, check, sized_list, sized_text, str};
use crate::error::Result;
use crate::render::{Adapter, Camera, RenderFileOptions, RenderOptions};

/// Makes a description and hands it over while the camera that it points at is alive.
fn described<T>(options: &RenderOptions, crowd: mry_crowd, use_it: impl FnOnce(*const mry_render_desc) -> T) -> T {
    let mut camera = sized!(mry_camera_init, mry_camera);
    match options.camera {
        Camera::Fitted { yaw, pitch, fov } => {
            (camera.kind, camera.yaw, camera.pitch, camera.fov) = (MRY_CAMERA_FITTED, yaw, pitch, fov);
        }
        Camera::Clip => camera.kind = MRY_CAMERA_CLIP,
        Camera::Placed { yaw, pitch, fov, reach, target } => {
            (camera.kind, camera.yaw, camera.pitch, camera.fov) = (MRY_CAMERA_PLACED, yaw, pitch, fov);
            (camera.distance, camera.height, camera.target) = (reach, reach, target);
        }
    }
    let mut desc = sized!(mry_render_desc_init, mry_render_desc);
    (desc.width, desc.height) = options.size;
    (desc.style, desc.adapter) = (options.style as i32, options.adapter as i32);
    (desc.hard_edges, desc.shadow) = (u32::from(options.hard_edges), options.shadow);
    (desc.background, desc.frame, desc.camera) = (options.background, options.frame, &camera);
    desc.crowd = crowd;
    use_it(&desc)
}

pub(crate) fn creature_render(handle: &Handle, creature: mry_creature, options: &RenderOptions) -> Result<Vec<u8>> {
    described(options, mry_crowd::default(), |desc| {
        sized_list(|pixels, capacity, count| {
            call!(mry_creature_render(handle, creature, desc, pixels, capacity, count))
        })
    })
}

pub(crate) fn context_renderer(handle: &Handle, adapter: Adapter) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_context_get_renderer(handle, adapter as i32, text, capacity, size)))
}

pub(crate) fn start_render(
    handle: &Handle,
    creature: mry_creature,
    pictures: &RenderOptions,
    file: &RenderFileOptions<'_>,
) -> Result<mry_job> {
    start(handle, pictures, mry_crowd::default(), file, |desc| desc.creature = creature)
}

/// `into` is the clip to put it back into, its masks, and whether the crowd is drawn alone.
pub(crate) fn start_render_crowd(
    handle: &Handle,
    crowd: mry_crowd,
    pictures: &RenderOptions,
    file: &RenderFileOptions<'_>,
    into: Option<(mry_clip, Option<mry_clip>, bool)>,
) -> Result<mry_job> {
    start(handle, pictures, crowd, file, |desc| {
        if let Some((clip, masks, alone)) = into {
            (desc.clip, desc.mask_clip, desc.alone) = (clip, masks.unwrap_or_default(), u32::from(alone));
        }
    })
}

fn start(
    handle: &Handle,
    pictures: &RenderOptions,
    crowd: mry_crowd,
    file: &RenderFileOptions<'_>,
    more: impl FnOnce(&mut mry_render_file_desc),
) -> Result<mry_job> {
    let mut job = mry_job::default();
    described(pictures, crowd, |picture| {
        let mut desc = sized!(mry_render_file_desc_init, mry_render_file_desc);
        (desc.path, desc.format) = (str(file.path), str(file.format));
        (desc.picture, desc.still) = (picture, u32::from(file.still));
        (desc.frame_count, desc.fps, desc.turns) = (file.frames, file.fps, file.turns);
        more(&mut desc);
        call!(mry_job_start_render(handle, &desc, &mut job))
    })?;
    Ok(job)
}

pub(crate) fn crowd_create(handle: &Handle, instances: &[mry_instance], frames: u64, fps: f64) -> Result<mry_crowd> {
    let mut crowd = mry_crowd::default();
    call!(mry_crowd_create(handle, instances.as_ptr(), instances.len(), frames, fps, &mut crowd))?;
    Ok(crowd)
}

pub(crate) fn crowd_herd(handle: &Handle, creature: mry_creature, count: u32, frames: u64) -> Result<mry_crowd> {
    let mut crowd = mry_crowd::default();
    call!(mry_crowd_create_herd(handle, creature, count, frames, &mut crowd))?;
    Ok(crowd)
}

pub(crate) fn crowd_read(handle: &Handle, path: &str) -> Result<mry_crowd> {
    let mut crowd = mry_crowd::default();
    call!(mry_crowd_read(handle, str(path), &mut crowd))?;
    Ok(crowd)
}

pub(crate) fn crowd_info(handle: &Handle, crowd: mry_crowd) -> Result<mry_crowd_info> {
    let mut info = sized!(mry_crowd_info_init, mry_crowd_info);
    call!(mry_crowd_get_info(handle, crowd, &mut info))?;
    Ok(info)
}

pub(crate) fn crowd_write_glb(handle: &Handle, crowd: mry_crowd, path: &str, scale: f32) -> Result<()> {
    call!(mry_crowd_write_glb(handle, crowd, str(path), scale)).map(drop)
}
