//! Printing.

use marey_ffi::*;

use super::{Handle, check, sized_list, str, taken};
use crate::error::Result;
use crate::print::{PrintOptions, PrintSize};

pub(crate) fn start_print(handle: &Handle, creature: mry_creature, options: &PrintOptions<'_>) -> Result<mry_job> {
    let mut desc = sized!(mry_print_desc_init, mry_print_desc);
    (desc.size_kind, desc.size) = match options.size {
        PrintSize::Longest(mm) => (MRY_PRINT_LONGEST, mm),
        PrintSize::Height(mm) => (MRY_PRINT_HEIGHT, mm),
        PrintSize::Unit(mm) => (MRY_PRINT_UNIT, mm),
    };
    desc.creature = creature;
    desc.frame = options.frame;
    desc.min_thickness = options.min_thickness.unwrap_or(-1.0);
    desc.detail = options.detail;
    desc.base = u32::from(options.base);
    desc.max_triangles = options.max_triangles;
    desc.path = str(options.path);
    let mut job = mry_job::default();
    call!(mry_job_start_print(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn take_solid(handle: &Handle, job: mry_job) -> Result<mry_solid> {
    taken(|out| call!(mry_job_take_solid(handle, job, out)))
}

pub(crate) fn solid_info(handle: &Handle, solid: mry_solid) -> Result<mry_solid_info> {
    let mut info = sized!(mry_solid_info_init, mry_solid_info);
    call!(mry_solid_get_info(handle, solid, &mut info))?;
    Ok(info)
}

pub(crate) fn solid_vertices(handle: &Handle, solid: mry_solid) -> Result<(Vec<f32>, Vec<u8>)> {
    let mut count = solid_info(handle, solid)?.vertex_count as usize;
    let (mut positions, mut colours) = (vec![0.0f32; 3 * count], vec![0u8; 3 * count]);
    let capacity = count;
    call!(mry_solid_read_vertices(handle, solid, positions.as_mut_ptr(), colours.as_mut_ptr(), capacity, &mut count))?;
    Ok((positions, colours))
}

pub(crate) fn solid_triangles(handle: &Handle, solid: mry_solid) -> Result<Vec<u32>> {
    let triangles: Vec<[u32; 3]> = sized_list(|indices: *mut [u32; 3], capacity, count| {
        call!(mry_solid_read_triangles(handle, solid, indices.cast(), capacity, count))
    })?;
    Ok(triangles.into_flattened())
}

pub(crate) fn solid_write(handle: &Handle, solid: mry_solid, path: &str) -> Result<()> {
    call!(mry_solid_write(handle, solid, str(path)))?;
    Ok(())
}
