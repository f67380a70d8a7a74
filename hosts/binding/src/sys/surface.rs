//! The calls that change what a creature wears and how it is formed.

use super::*;
use crate::creature_surface::{EditedMesh, Texture, TextureOptions};

pub(crate) fn start_texture(
    handle: &Handle,
    creature: mry_creature,
    texture: &Texture<'_>,
    options: &TextureOptions<'_>,
) -> Result<mry_job> {
    let mut desc = sized!(mry_texture_desc_init, mry_texture_desc);
    desc.creature = creature;
    match *texture {
        Texture::Frames { clip, masks, ref frames } => {
            (desc.from, desc.clip, desc.mask_clip) = (MRY_TEXTURE_FRAMES, clip.id, masks.id);
            if let Some(frames) = frames {
                (desc.first_frame, desc.frame_count) = (frames.start, frames.end.saturating_sub(frames.start));
            }
        }
        Texture::Creature(source) => (desc.from, desc.source) = (MRY_TEXTURE_CREATURE, source.id),
        Texture::Side(picture) => (desc.from, desc.picture) = (MRY_TEXTURE_SIDE, str(picture)),
        Texture::Repeated { picture, width } => {
            (desc.from, desc.picture, desc.width) = (MRY_TEXTURE_REPEATED, str(picture), width);
        }
    }
    let limbs: Vec<mry_str> = options.limbs.iter().map(|label| str(label)).collect();
    (desc.limbs, desc.limb_count) = (limbs.as_ptr(), limbs.len());
    (desc.soft, desc.region) = (options.soft, str(options.region));
    let mut job = mry_job::default();
    call!(mry_job_start_texture(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn write_textures(handle: &Handle, creature: mry_creature, folder: &str) -> Result<()> {
    call!(mry_creature_write_textures(handle, creature, str(folder)))?;
    Ok(())
}

pub(crate) fn read_textures(handle: &Handle, creature: mry_creature, folder: &str) -> Result<mry_creature> {
    let mut made = mry_creature::default();
    call!(mry_creature_read_textures(handle, creature, str(folder), &mut made))?;
    Ok(made)
}

pub(crate) fn start_edit(
    handle: &Handle,
    creature: mry_creature,
    frame: u64,
    mesh: &EditedMesh<'_>,
) -> Result<mry_job> {
    let mut desc = sized!(mry_edit_desc_init, mry_edit_desc);
    (desc.creature, desc.frame) = (creature, frame);
    match *mesh {
        EditedMesh::File(path) => desc.path = str(path),
        EditedMesh::Lists { positions, triangles } => {
            (desc.positions, desc.vertex_count) = (positions.as_ptr().cast(), positions.len());
            (desc.indices, desc.triangle_count) = (triangles.as_ptr().cast(), triangles.len());
        }
    }
    let mut job = mry_job::default();
    call!(mry_job_start_edit(handle, &desc, &mut job))?;
    Ok(job)
}
