//! Vector drawings.

use marey_ffi::*;

use super::{Handle, check, sized_list, sized_text, str};
use crate::error::Result;

pub(crate) fn drawing_read_svg(handle: &Handle, path: &str) -> Result<mry_drawing> {
    let mut drawing = mry_drawing::default();
    call!(mry_drawing_read_svg(handle, str(path), &mut drawing))?;
    Ok(drawing)
}

pub(crate) fn drawing_from_svg(handle: &Handle, svg: &str) -> Result<mry_drawing> {
    let mut drawing = mry_drawing::default();
    call!(mry_drawing_from_svg(handle, str(svg), &mut drawing))?;
    Ok(drawing)
}

pub(crate) fn drawing_create(handle: &Handle, (width, height): (f64, f64)) -> Result<mry_drawing> {
    let mut drawing = mry_drawing::default();
    call!(mry_drawing_create(handle, width, height, &mut drawing))?;
    Ok(drawing)
}

pub(crate) fn drawing_add_stroke(
    handle: &Handle,
    drawing: mry_drawing,
    name: &str,
    samples: &[mry_pen_sample],
    width: f32,
    rgba: [u8; 4],
) -> Result<()> {
    let samples = (samples.as_ptr(), samples.len());
    call!(mry_drawing_add_stroke(handle, drawing, str(name), samples.0, samples.1, width, rgba.as_ptr())).map(drop)
}

pub(crate) fn drawing_remove_stroke(handle: &Handle, drawing: mry_drawing, name: &str) -> Result<()> {
    call!(mry_drawing_remove_stroke(handle, drawing, str(name))).map(drop)
}

pub(crate) fn drawing_info(handle: &Handle, drawing: mry_drawing) -> Result<mry_drawing_info> {
    let mut info = sized!(mry_drawing_info_init, mry_drawing_info);
    call!(mry_drawing_get_info(handle, drawing, &mut info))?;
    Ok(info)
}

pub(crate) fn drawing_stroke(
    handle: &Handle,
    drawing: mry_drawing,
    index: u32,
) -> Result<(String, mry_drawing_stroke)> {
    let mut stroke = sized!(mry_drawing_stroke_init, mry_drawing_stroke);
    let name = sized_text(|text, capacity, size| {
        call!(mry_drawing_get_stroke(handle, drawing, index, text, capacity, size, &mut stroke))
    })?;
    Ok((name, stroke))
}

pub(crate) fn drawing_left_out(handle: &Handle, drawing: mry_drawing, index: u32) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_drawing_get_left_out(handle, drawing, index, text, capacity, size)))
}

pub(crate) fn drawing_outline(handle: &Handle, drawing: mry_drawing) -> Result<Vec<mry_point>> {
    sized_list(|points, capacity, count| call!(mry_drawing_read_outline(handle, drawing, points, capacity, count)))
}

pub(crate) fn drawing_to_svg(handle: &Handle, drawing: mry_drawing) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_drawing_to_svg(handle, drawing, text, capacity, size)))
}

pub(crate) fn drawing_write_svg(handle: &Handle, drawing: mry_drawing, path: &str) -> Result<()> {
    call!(mry_drawing_write_svg(handle, drawing, str(path))).map(drop)
}
