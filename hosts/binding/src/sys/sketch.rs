//! Bindings, and drawings in motion.

use marey_ffi::*;

use super::{Handle, check, sized_list, sized_text, str, taken};
use crate::error::Result;
use crate::sketch::{BindOptions, SketchFileOptions};

pub(crate) fn binding_create(handle: &Handle, drawing: mry_drawing) -> Result<mry_binding> {
    let mut binding = mry_binding::default();
    call!(mry_binding_create(handle, drawing, &mut binding))?;
    Ok(binding)
}

pub(crate) fn binding_read(handle: &Handle, path: &str) -> Result<mry_binding> {
    let mut binding = mry_binding::default();
    call!(mry_binding_read(handle, str(path), &mut binding))?;
    Ok(binding)
}

pub(crate) fn binding_from_json(handle: &Handle, json: &str) -> Result<mry_binding> {
    let mut binding = mry_binding::default();
    call!(mry_binding_from_json(handle, str(json), &mut binding))?;
    Ok(binding)
}

pub(crate) fn binding_to_json(handle: &Handle, binding: mry_binding) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_binding_to_json(handle, binding, text, capacity, size)))
}

pub(crate) fn binding_write(handle: &Handle, binding: mry_binding, path: &str) -> Result<()> {
    call!(mry_binding_write(handle, binding, str(path))).map(drop)
}

pub(crate) fn binding_validate(handle: &Handle, binding: mry_binding, drawing: mry_drawing) -> Result<()> {
    call!(mry_binding_validate(handle, binding, drawing)).map(drop)
}

pub(crate) fn binding_info(handle: &Handle, binding: mry_binding) -> Result<mry_binding_info> {
    let mut info = sized!(mry_binding_info_init, mry_binding_info);
    call!(mry_binding_get_info(handle, binding, &mut info))?;
    Ok(info)
}

pub(crate) fn motion_use() -> mry_motion_use {
    sized!(mry_motion_use_init, mry_motion_use)
}

pub(crate) fn binding_set_motion(
    handle: &Handle,
    binding: mry_binding,
    name: &str,
    how: &mry_motion_use,
) -> Result<()> {
    call!(mry_binding_set_motion(handle, binding, str(name), how)).map(drop)
}

pub(crate) fn binding_motion(handle: &Handle, binding: mry_binding, index: u32) -> Result<(String, mry_motion_use)> {
    let mut how = motion_use();
    let name = sized_text(|text, capacity, size| {
        call!(mry_binding_get_motion(handle, binding, index, text, capacity, size, &mut how))
    })?;
    Ok((name, how))
}

pub(crate) fn binding_set_point(
    handle: &Handle,
    binding: mry_binding,
    [motion, track, layer]: [&str; 3],
    index: u32,
    at: mry_point,
) -> Result<()> {
    call!(mry_binding_set_point(handle, binding, str(motion), str(track), index, at, str(layer))).map(drop)
}

pub(crate) fn binding_remove_point(
    handle: &Handle,
    binding: mry_binding,
    [motion, track]: [&str; 2],
    index: u32,
) -> Result<()> {
    call!(mry_binding_remove_point(handle, binding, str(motion), str(track), index)).map(drop)
}

pub(crate) fn binding_point(handle: &Handle, binding: mry_binding, index: u32) -> Result<(String, u32, mry_point)> {
    let (mut point, mut at) = (0, mry_point::default());
    let track = sized_text(|text, capacity, size| {
        call!(mry_binding_get_point(handle, binding, index, text, capacity, size, &mut point, &mut at))
    })?;
    Ok((track, point, at))
}

pub(crate) fn binding_add_pin(handle: &Handle, binding: mry_binding, at: mry_point, layer: &str) -> Result<()> {
    call!(mry_binding_add_pin(handle, binding, at, str(layer))).map(drop)
}

pub(crate) fn binding_remove_pin(handle: &Handle, binding: mry_binding, index: u32) -> Result<()> {
    call!(mry_binding_remove_pin(handle, binding, index)).map(drop)
}

pub(crate) fn binding_set_stroke(
    handle: &Handle,
    binding: mry_binding,
    stroke: &str,
    rigidity: f32,
    decoration: bool,
) -> Result<()> {
    call!(mry_binding_set_stroke(handle, binding, str(stroke), rigidity, decoration.into())).map(drop)
}

pub(crate) fn binding_stroke(handle: &Handle, binding: mry_binding, stroke: &str) -> Result<(f32, bool)> {
    let (mut rigidity, mut decoration) = (0.0, 0);
    call!(mry_binding_get_stroke(handle, binding, str(stroke), &mut rigidity, &mut decoration))?;
    Ok((rigidity, decoration != 0))
}

pub(crate) fn binding_paint_layer(
    handle: &Handle,
    (binding, drawing): (mry_binding, mry_drawing),
    layer: &str,
    brush: &[mry_point],
    radius: f32,
) -> Result<u32> {
    let (mut count, points) = (0, (brush.as_ptr(), brush.len()));
    let layer = str(layer);
    call!(mry_binding_paint_layer(handle, binding, drawing, layer, points.0, points.1, radius, &mut count))?;
    Ok(count)
}

pub(crate) fn binding_set_layer(
    handle: &Handle,
    (binding, drawing): (mry_binding, mry_drawing),
    layer: &str,
    strokes: &[&str],
) -> Result<()> {
    let strokes: Vec<mry_str> = strokes.iter().map(|s| str(s)).collect();
    call!(mry_binding_set_layer(handle, binding, drawing, str(layer), strokes.as_ptr(), strokes.len())).map(drop)
}

pub(crate) fn binding_write_preview(
    handle: &Handle,
    (binding, drawing): (mry_binding, mry_drawing),
    motion: mry_motion,
    clip: mry_clip,
    path: &str,
) -> Result<()> {
    call!(mry_binding_write_preview(handle, binding, drawing, motion, clip, str(path))).map(drop)
}

pub(crate) fn binding_propose_joints(handle: &Handle, binding: mry_binding, drawing: mry_drawing) -> Result<()> {
    call!(mry_binding_propose_joints(handle, binding, drawing)).map(drop)
}

pub(crate) fn start_bind(
    handle: &Handle,
    (drawing, motion): (mry_drawing, mry_motion),
    options: &BindOptions<'_>,
    (contour, outline): (&[mry_point], &[mry_point]),
) -> Result<mry_job> {
    let mut desc = sized!(mry_bind_desc_init, mry_bind_desc);
    (desc.drawing, desc.motion) = (drawing, motion);
    desc.clip = options.clip.map_or(mry_clip::default(), |c| c.id);
    desc.frame_from_one = options.frame.map_or(0, |f| f + 1);
    desc.faces = options
        .mirror
        .map_or(MRY_FACES_EITHER_WAY, |m| if m { MRY_FACES_THE_OTHER_WAY } else { MRY_FACES_THE_SAME_WAY });
    desc.name = str(options.name);
    (desc.contour, desc.contour_count) = (contour.as_ptr(), contour.len());
    (desc.outline, desc.outline_count) = (outline.as_ptr(), outline.len());
    let mut job = mry_job::default();
    call!(mry_job_start_bind(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn take_binding(handle: &Handle, job: mry_job) -> Result<mry_binding> {
    taken(|out| call!(mry_job_take_binding(handle, job, out)))
}

pub(crate) fn start_sketch_take(
    handle: &Handle,
    drawing: mry_drawing,
    binding: mry_binding,
    motions: &[mry_motion],
) -> Result<mry_job> {
    let mut desc = sized!(mry_sketch_take_desc_init, mry_sketch_take_desc);
    (desc.drawing, desc.binding) = (drawing, binding);
    (desc.motions, desc.motion_count) = (motions.as_ptr(), motions.len());
    let mut job = mry_job::default();
    call!(mry_job_start_sketch_take(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn take_sketch_take(handle: &Handle, job: mry_job) -> Result<mry_sketch_take> {
    taken(|out| call!(mry_job_take_sketch_take(handle, job, out)))
}

pub(crate) fn sketch_take_info(handle: &Handle, take: mry_sketch_take) -> Result<mry_sketch_take_info> {
    let mut info = sized!(mry_sketch_take_info_init, mry_sketch_take_info);
    call!(mry_sketch_take_get_info(handle, take, &mut info))?;
    Ok(info)
}

pub(crate) fn sketch_take_stroke(
    handle: &Handle,
    take: mry_sketch_take,
    frame: u64,
    stroke: u32,
) -> Result<Vec<mry_path_element>> {
    sized_list(|elements, capacity, count| {
        call!(mry_sketch_take_read_stroke(handle, take, frame, stroke, elements, capacity, count))
    })
}

pub(crate) fn sketch_take_measure(
    handle: &Handle,
    take: mry_sketch_take,
    scale: f32,
    crop: bool,
) -> Result<(u32, u32, mry_point)> {
    let (mut width, mut height, mut corner) = (0, 0, mry_point::default());
    call!(mry_sketch_take_measure(handle, take, scale, crop.into(), &mut width, &mut height, &mut corner))?;
    Ok((width, height, corner))
}

/// Width, height and pixels.
pub(crate) fn sketch_take_draw(
    handle: &Handle,
    take: mry_sketch_take,
    frame: u64,
    scale: f32,
    crop: bool,
) -> Result<(u32, u32, Vec<u8>)> {
    let (width, height, _) = sketch_take_measure(handle, take, scale, crop)?;
    let crop = crop.into();
    let mut pixels = vec![0; 4 * width as usize * height as usize];
    let (at, capacity) = (pixels.as_mut_ptr(), pixels.len());
    call!(mry_sketch_take_draw_frame(handle, take, frame, scale, crop, at, capacity, 0))?;
    Ok((width, height, pixels))
}

pub(crate) fn start_sketch_file(
    handle: &Handle,
    take: mry_sketch_take,
    options: &SketchFileOptions<'_>,
) -> Result<mry_job> {
    let mut desc = sized!(mry_sketch_file_desc_init, mry_sketch_file_desc);
    desc.take = take;
    (desc.path, desc.format, desc.name) = (str(options.path), str(options.format), str(options.name));
    (desc.crop, desc.scale, desc.background) = (options.crop.into(), options.scale, options.background);
    let mut job = mry_job::default();
    call!(mry_job_start_sketch_file(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn motion_from_paths(handle: &Handle, json: &str) -> Result<mry_motion> {
    taken(|out| call!(mry_motion_from_paths(handle, str(json), out)))
}
