//! Maps. Frames, meshes and textures read where they lie, without a copy. What a map shows does not change and stays
//! until mry_unmap, whatever happens to the object it came from: clips and creatures do not change, and a map keeps
//! what it shows alive. The memory is the library's; it must not be written to.

use std::any::Any;
use std::ops::Deref;
use std::sync::Arc;

use marey::geometry::TriMesh;

use crate::bones::MRY_REST_POSE;
use crate::border::{self, OutStruct, Versioned};
use crate::clip::{frame_index, mry_clip};
use crate::context::mry_context;
use crate::creature::mry_creature;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::table::Table;

/// What keeps mapped memory alive.
pub(crate) type MapTable = Table<Arc<dyn Any + Send + Sync>>;

/// Mapped memory.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_map {
    /// The id; 0 is no map.
    pub v: u64,
}

/// Format of an image: 3 bytes a pixel, red, green, blue, sRGB.
pub const MRY_FORMAT_RGB8: i32 = 1;
/// Format of an image: 4 bytes a pixel, red, green, blue, sRGB, and alpha, which the others are not multiplied by.
pub const MRY_FORMAT_RGBA8: i32 = 2;

/// A picture in memory, rows from the top: of the library's, or what a host hands over.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_image_view {
    /// sizeof(mry_image_view).
    pub struct_size: u32,
    /// MRY_FORMAT_RGB8, ...; accept ones you do not know.
    pub format: i32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Bytes from one row's start to the next's.
    pub stride_bytes: u64,
    /// The first row.
    pub data: *const u8,
    /// What to hand to mry_unmap.
    pub map: mry_map,
}

// SAFETY: repr(C), starts with its u32 size; numbers and a pointer, which the host vouches for where it is read.
unsafe impl Versioned for mry_image_view {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_image_view>() == 40);

/// A part's surface in memory of the library's, in world coordinates. Lists have no gaps.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_mesh_view {
    /// sizeof(mry_mesh_view).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// Its vertices.
    pub vertex_count: u64,
    /// Its triangles.
    pub triangle_count: u64,
    /// x, y, z for each vertex.
    pub positions: *const f32,
    /// x, y, z for each vertex, of length 1.
    pub normals: *const f32,
    /// u, v for each vertex, 0..1, v down.
    pub uvs: *const f32,
    /// Three vertex indices for each triangle, counter-clockwise seen from outside.
    pub triangles: *const u32,
    /// What to hand to mry_unmap.
    pub map: mry_map,
}

// SAFETY: repr(C), starts with its u32 size; numbers and pointers that are only written.
unsafe impl Versioned for mry_mesh_view {
    const FIRST_SIZE: usize = 64;
}
const _: () = assert!(size_of::<mry_mesh_view>() == 64);

impl Call<'_> {
    /// Keeps `shown` until it is unmapped.
    fn map(&self, shown: Arc<dyn Any + Send + Sync>) -> Outcome<mry_map> {
        Ok(mry_map { v: self.context.maps.insert(shown)? })
    }

    fn map_image(
        &self,
        out: &OutStruct<mry_image_view>,
        image: &image::ImageBuffer<image::Rgb<u8>, impl Deref<Target = [u8]>>,
        shown: Arc<dyn Any + Send + Sync>,
    ) -> Outcome<Code> {
        out.set(&mry_image_view {
            struct_size: 0,
            format: MRY_FORMAT_RGB8,
            width: image.width(),
            height: image.height(),
            stride_bytes: 3 * u64::from(image.width()),
            data: image.as_raw().as_ptr(),
            map: self.map(shown)?,
        });
        Ok(Code::MRY_OK)
    }

    fn map_mesh(
        &self,
        out: &OutStruct<mry_mesh_view>,
        mesh: &TriMesh,
        shown: Arc<dyn Any + Send + Sync>,
    ) -> Outcome<Code> {
        out.set(&mry_mesh_view {
            struct_size: 0,
            reserved0: 0,
            vertex_count: mesh.positions.len() as u64,
            triangle_count: mesh.triangles.len() as u64,
            positions: mesh.positions.as_ptr().cast(),
            normals: mesh.normals.as_ptr().cast(),
            uvs: mesh.uvs.as_ptr().cast(),
            triangles: mesh.triangles.as_ptr().cast(),
            map: self.map(shown)?,
        });
        Ok(Code::MRY_OK)
    }
}

// The lists of a mesh are handed out as plain floats.
const _: () = assert!(size_of::<marey::Vec3>() == 12 && size_of::<marey::Vec2>() == 8);

/// Fills in an image view with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param view  Where to write; NULL does nothing.
/// @param size  sizeof(mry_image_view) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_image_view_init(view: *mut mry_image_view, size: u32) {
    // SAFETY: the caller owns `size` bytes at `view`, or passes NULL.
    unsafe { border::init(view.cast(), size) }
}

/// Fills in a mesh view with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param view  Where to write; NULL does nothing.
/// @param size  sizeof(mry_mesh_view) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_mesh_view_init(view: *mut mry_mesh_view, size: u32) {
    // SAFETY: the caller owns `size` bytes at `view`, or passes NULL.
    unsafe { border::init(view.cast(), size) }
}

/// Maps a decoded frame.
///
/// @param context   The context.
/// @param clip      The clip.
/// @param frame     Which, counted from 0.
/// @param out_view  The picture; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame), MRY_E_STRUCT_SIZE, MRY_E_INPUT (a broken frame), MRY_E_IO, MRY_E_LIMIT.
/// Lifetime: until mry_unmap or the end of the context; the clip may be closed before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_map_frame(
    context: *mut mry_context,
    clip: mry_clip,
    frame: u64,
    out_view: *mut mry_image_view,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_view, "out_view")?;
        let clip = call.clip(clip, "clip")?;
        let frame = frame_index(frame, clip.info().frames)?;
        let picture = clip.frame(frame).map_err(|e| Failure::from(e).about("clip"))?;
        call.map_image(&out, &picture.rgb, picture.clone())
    })
}

/// Maps a part's surface in one frame. Mapping all parts of a frame before the next frame is fastest.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param part      Which, below part_count.
/// @param frame     Which, below frame_count, or MRY_REST_POSE.
/// @param out_view  The surface; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (part, frame), MRY_E_STRUCT_SIZE, MRY_E_LIMIT.
/// Lifetime: until mry_unmap or the end of the context; the creature may be destroyed before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_map_part(
    context: *mut mry_context,
    creature: mry_creature,
    part: u32,
    frame: u64,
    out_view: *mut mry_mesh_view,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_view, "out_view")?;
        let creature = call.creature(creature)?;
        let rest = &creature.part(part)?.mesh;
        if frame == MRY_REST_POSE {
            return call.map_mesh(&out, rest, creature.clone());
        }
        let posed = creature.pose(frame_index(frame, creature.model().animation.len())?);
        call.map_mesh(&out, &posed[part as usize], posed.clone())
    })
}

/// Maps a part's texture.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param part      Which, below part_count.
/// @param out_view  The picture; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (part), MRY_E_STRUCT_SIZE, MRY_E_LIMIT.
/// Lifetime: until mry_unmap or the end of the context; the creature may be destroyed before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_map_texture(
    context: *mut mry_context,
    creature: mry_creature,
    part: u32,
    out_view: *mut mry_image_view,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_view, "out_view")?;
        let creature = call.creature(creature)?;
        call.map_image(&out, &creature.part(part)?.texture, creature.clone())
    })
}

/// Gives mapped memory back; it must not be read any more.
///
/// @param context  The context.
/// @param map      The map; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_unmap(context: *mut mry_context, map: mry_map) -> mry_status {
    ending!(context, |call| {
        if map.v != 0 {
            call.context.maps.remove(map.v, "map")?;
        }
        Ok(Code::MRY_OK)
    })
}
