//! Surfaces. A creature's parts, one skin or a tube a limb: vertices, triangles, the bones that hold them, and a texture.
//! Parts and vertices count from 0.

use std::ffi::c_char;

use crate::bones::MRY_REST_POSE;
use crate::border::{self, List, Lists, OutStruct, Text, Versioned};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::creature::mry_creature;
use crate::error::mry_error;
use crate::guard::entry;
use crate::rows::Rows;
use crate::status::{mry_status, mry_status_code as Code};

/// What a part is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_part_info {
    /// sizeof(mry_part_info).
    pub struct_size: u32,
    /// The texture's pixels across.
    pub texture_width: u32,
    /// The texture's pixels down.
    pub texture_height: u32,
    /// Zero.
    pub reserved0: u32,
    /// Its vertices.
    pub vertex_count: u64,
    /// Its triangles.
    pub triangle_count: u64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_part_info {
    const FIRST_SIZE: usize = 32;
}
const _: () = assert!(size_of::<mry_part_info>() == 32);

/// Fills in a part info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_part_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_part_info_init(info: *mut mry_part_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// A part's name and what it is.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param part      Which, below part_count.
/// @param name      Where the limb's label goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at name.
/// @param out_size  Bytes needed, with the NUL.
/// @param out_info  The answer, its struct_size set; or NULL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (part), MRY_E_BUFFER_TOO_SMALL, MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_part(
    context: *mut mry_context,
    creature: mry_creature,
    part: u32,
    name: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_info: *mut mry_part_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let name = Text::new(name, capacity, out_size, "name")?;
        let out_info = OutStruct::optional(out_info, "out_info")?;
        let creature = call.creature(creature)?;
        let part = creature.part(part)?;
        name.fill(&part.name)?;
        out_info.inspect(|out| {
            out.set(&mry_part_info {
                struct_size: 0,
                texture_width: part.texture.width(),
                texture_height: part.texture.height(),
                reserved0: 0,
                vertex_count: part.mesh.positions.len() as u64,
                triangle_count: part.mesh.triangles.len() as u64,
            });
        });
        Ok(Code::MRY_OK)
    })
}

/// A part's surface in one frame, in world coordinates. Lists that are not wanted may be NULL. Reading all parts of a
/// frame before the next frame is fastest.
///
/// @param context    The context.
/// @param creature   The creature.
/// @param part       Which, below part_count.
/// @param frame      Which, below frame_count, or MRY_REST_POSE.
/// @param positions  x, y, z for each vertex; or NULL.
/// @param normals    x, y, z for each vertex, of length 1; or NULL.
/// @param uvs        u, v for each vertex, 0..1, v down; or NULL.
/// @param capacity   Vertices that fit in each list.
/// @param out_count  Vertices of the part.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (part, frame, capacity), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_read_vertices(
    context: *mut mry_context,
    creature: mry_creature,
    part: u32,
    frame: u64,
    positions: *mut f32,
    normals: *mut f32,
    uvs: *mut f32,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let mut lists = Lists::new(capacity, out_count)?;
        let positions = lists.list(positions, 3, "positions")?;
        let normals = lists.list(normals, 3, "normals")?;
        let uvs = lists.list(uvs, 2, "uvs")?;
        let creature = call.creature(creature)?;
        let rest = &creature.part(part)?.mesh;
        let posed;
        let mesh = if frame == MRY_REST_POSE {
            rest
        } else {
            posed = creature.pose(frame_index(frame, creature.model().animation.len())?);
            &posed[part as usize]
        };
        lists.fit(rest.positions.len())?;
        if let Some(positions) = positions {
            positions.write(&mesh.positions.iter().flat_map(|p| p.to_array()).collect::<Vec<f32>>())?;
        }
        if let Some(normals) = normals {
            normals.write(&mesh.normals.iter().flat_map(|n| n.to_array()).collect::<Vec<f32>>())?;
        }
        if let Some(uvs) = uvs {
            uvs.write(&mesh.uvs.iter().flat_map(|t| t.to_array()).collect::<Vec<f32>>())?;
        }
        Ok(Code::MRY_OK)
    })
}

/// A part's triangles, counter-clockwise seen from outside; the same in every frame.
///
/// @param context    The context.
/// @param creature   The creature.
/// @param part       Which, below part_count.
/// @param indices    Three vertex indices for each triangle; NULL with capacity 0 to ask for the count.
/// @param capacity   Triangles that fit.
/// @param out_count  Triangles of the part.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (part, capacity), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_read_triangles(
    context: *mut mry_context,
    creature: mry_creature,
    part: u32,
    indices: *mut u32,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        // The same numbers, three by three.
        let triangles = List::new(indices.cast::<[u32; 3]>(), capacity, out_count, "indices")?;
        triangles.fill(&call.creature(creature)?.part(part)?.mesh.triangles)
    })
}

/// Which bones hold a part's vertices, and how strongly. Lists that are not wanted may be NULL.
///
/// @param context    The context.
/// @param creature   The creature.
/// @param part       Which, below part_count.
/// @param bones      Four bone indices for each vertex; or NULL.
/// @param weights    Their weights, which sum to 1; or NULL.
/// @param capacity   Vertices that fit in each list.
/// @param out_count  Vertices of the part.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (part, capacity), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_read_weights(
    context: *mut mry_context,
    creature: mry_creature,
    part: u32,
    bones: *mut u16,
    weights: *mut f32,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let mut lists = Lists::new(capacity, out_count)?;
        let bones = lists.list(bones, 4, "bones")?;
        let weights = lists.list(weights, 4, "weights")?;
        let creature = call.creature(creature)?;
        let part = creature.part(part)?;
        lists.fit(part.bones.len())?;
        if let Some(bones) = bones {
            bones.write(part.bones.as_flattened())?;
        }
        if let Some(weights) = weights {
            weights.write(part.weights.as_flattened())?;
        }
        Ok(Code::MRY_OK)
    })
}

/// A part's texture as RGB, 8 bits a channel, sRGB, rows from the top.
///
/// @param context       The context.
/// @param creature      The creature.
/// @param part          Which, below part_count.
/// @param pixels        Where the rows go: 3 * texture_width bytes each.
/// @param capacity      Bytes at pixels: at least stride_bytes * (texture_height - 1) + 3 * texture_width.
/// @param stride_bytes  From one row's start to the next's; 0 for rows without gaps. Bytes in gaps are left alone.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (part, stride_bytes), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_read_texture(
    context: *mut mry_context,
    creature: mry_creature,
    part: u32,
    pixels: *mut u8,
    capacity: usize,
    stride_bytes: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let rows = Rows::new(pixels, capacity, stride_bytes, "pixels")?;
        let creature = call.creature(creature)?;
        let texture = &creature.part(part)?.texture;
        rows.write(texture.as_raw(), 3 * texture.width() as usize)?;
        Ok(Code::MRY_OK)
    })
}
