//! Creatures. A creature is a textured mesh in parts, one a limb, on bones that move over the clip's frames: linear
//! blend skinning as glTF 2.0 has it. World coordinates: right-handed, x right, y up, z toward the viewer, 1 unit =
//! 1 pixel of the clip, origin at the clip's bottom left. Bones, parts, vertices count from 0, parents come before
//! children. Creatures do not change.

use std::ffi::c_char;
use std::sync::{Arc, Mutex, PoisonError};

use marey::clip::Clip;
use marey::export::gltf::{self, GltfOptions};
use marey::export::{CreatureFiles, write_aside, write_creature};
use marey::geometry::TriMesh;
use marey::job::Progress;
use marey::motion::Motion;
use marey::rig::Rig;
use marey::shape::{RiggedModel, SkinnedPart, Transform};

use crate::border::{self, Buffer, Out, OutStruct, Rows, Versioned};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::job::{folder_options, metres};
use crate::masks::{MaskSet, mry_masks};
use crate::motion::mry_motion;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;

/// A creature with what it came from, so that its folder can be written at any time.
pub(crate) struct Creature {
    clip: Arc<Clip>,
    rig: Rig,
    motion: Arc<Motion>,
    masks: Arc<MaskSet>,
    model: RiggedModel,
    /// The frame that was posed last: a host reads all parts of one frame in turn.
    posed: Mutex<Option<(usize, Arc<Vec<TriMesh>>)>>,
}

impl Creature {
    pub(crate) fn new(clip: Arc<Clip>, rig: Rig, motion: Arc<Motion>, masks: Arc<MaskSet>, model: RiggedModel) -> Self {
        Self { clip, rig, motion, masks, model, posed: Mutex::new(None) }
    }

    fn pose(&self, frame: usize) -> Arc<Vec<TriMesh>> {
        let last = self.posed.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match last {
            Some((posed, meshes)) if posed == frame => meshes,
            _ => {
                let meshes = Arc::new(self.model.pose(frame));
                *self.posed.lock().unwrap_or_else(PoisonError::into_inner) = Some((frame, meshes.clone()));
                meshes
            }
        }
    }

    fn part(&self, part: u32) -> Outcome<&SkinnedPart> {
        let count = self.model.parts.len();
        let none = || Failure::argument("part", format!("part is {part}, and there are {count}"));
        self.model.parts.get(part as usize).ok_or_else(none)
    }
}

pub(crate) type CreatureTable = Table<Arc<Creature>>;

/// A creature.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_creature {
    /// The id; 0 is no creature.
    pub v: u64,
}

/// In place of a frame: the rest pose, which the mesh was built in.
pub const MRY_REST_POSE: u64 = u64::MAX;

/// What a creature is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_creature_info {
    /// sizeof(mry_creature_info).
    pub struct_size: u32,
    /// The clip's pixels across.
    pub width: u32,
    /// The clip's pixels down.
    pub height: u32,
    /// How many bones there are.
    pub bone_count: u32,
    /// How many parts there are.
    pub part_count: u32,
    /// Zero.
    pub reserved0: u32,
    /// How many frames the animation has.
    pub frame_count: u64,
    /// Frames a second.
    pub fps: f64,
    /// Vertices of all parts.
    pub vertex_count: u64,
    /// Triangles of all parts.
    pub triangle_count: u64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_creature_info {
    const FIRST_SIZE: usize = 56;
}
const _: () = assert!(size_of::<mry_creature_info>() == 56);

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

/// A bone's place relative to its parent; roots are relative to the world. There is no scale.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_transform {
    /// Moved by x, y, z, in world units.
    pub translation: [f32; 3],
    /// Turned by the unit quaternion x, y, z, w.
    pub rotation: [f32; 4],
}

impl Call<'_> {
    fn creature(&self, creature: mry_creature) -> Outcome<Arc<Creature>> {
        Ok(self.get(&self.context.creatures, creature.v, "creature")?.value.clone())
    }

    pub(crate) fn keep_creature(&self, creature: Arc<Creature>) -> Outcome<mry_creature> {
        Ok(mry_creature { v: self.context.creatures.insert(creature)? })
    }
}

fn transforms_out(transforms: &[Transform]) -> Vec<mry_transform> {
    let out = |t: &Transform| mry_transform { translation: t.translation.into(), rotation: t.rotation.into() };
    transforms.iter().map(out).collect()
}

/// A buffer for `capacity` groups of `each` values.
///
/// # Safety
/// As for [`Buffer::new`], with `capacity * each` values.
unsafe fn grouped<T: Copy>(
    ptr: *mut T,
    capacity: usize,
    each: usize,
    param: &'static str,
) -> Outcome<Option<Buffer<T>>> {
    let capacity = capacity
        .checked_mul(each)
        .ok_or_else(|| Failure::argument("capacity", format!("capacity is {capacity}, which is absurd")))?;
    // SAFETY: as this function's own.
    unsafe { Buffer::optional(ptr, capacity, param) }
}

/// Refuses when any of the lists is wanted and `count` entries do not fit; all have one capacity.
fn all_fit(wanted: bool, count: usize, capacity: usize, out_count: &Out<usize>) -> Outcome<()> {
    if wanted && count > capacity {
        out_count.set(count);
        let message = format!("capacity is {capacity}, and {count} are needed");
        return Err(Failure::new(Code::MRY_E_BUFFER_TOO_SMALL, "capacity", message));
    }
    Ok(())
}

/// Fills in a creature info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_creature_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_info_init(info: *mut mry_creature_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

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

/// Destroys a creature. A motion and masks that were got from it live on.
///
/// @param context   The context.
/// @param creature  The creature; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_destroy(context: *mut mry_context, creature: mry_creature) -> mry_status {
    ending!(context, |call| {
        if creature.v != 0 {
            call.context.creatures.remove(creature.v, "creature")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// What a creature is: counts, frames, rate.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_info(
    context: *mut mry_context,
    creature: mry_creature,
    out_info: *mut mry_creature_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let creature = call.creature(creature)?;
        let model = &creature.model;
        out.set(&mry_creature_info {
            struct_size: 0,
            width: model.size.0,
            height: model.size.1,
            bone_count: model.bones.len() as u32,
            part_count: model.parts.len() as u32,
            reserved0: 0,
            frame_count: model.animation.len() as u64,
            fps: model.fps,
            vertex_count: model.parts.iter().map(|p| p.mesh.positions.len() as u64).sum(),
            triangle_count: model.parts.iter().map(|p| p.mesh.triangles.len() as u64).sum(),
        });
        Ok(Code::MRY_OK)
    })
}

/// The motion that drives the creature.
///
/// @param context     The context.
/// @param creature    The creature.
/// @param out_motion  The motion, an object of its own.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_LIMIT.
/// Lifetime: until mry_motion_destroy or the end of the context; the creature may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_motion(
    context: *mut mry_context,
    creature: mry_creature,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let creature = call.creature(creature)?;
        out.set(call.keep_motion(creature.motion.clone())?);
        Ok(Code::MRY_OK)
    })
}

/// The masks that the creature was built from.
///
/// @param context    The context.
/// @param creature   The creature.
/// @param out_masks  The masks, an object of their own.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_LIMIT.
/// Lifetime: until mry_masks_destroy or the end of the context; the creature may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_masks(
    context: *mut mry_context,
    creature: mry_creature,
    out_masks: *mut mry_masks,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_masks, "out_masks")?;
        let creature = call.creature(creature)?;
        out.set(call.keep_masks(creature.masks.clone())?);
        Ok(Code::MRY_OK)
    })
}

/// The report of the job that made the creature, as the text of its report.json: counts, seconds, warnings,
/// corrections.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_report(
    context: *mut mry_context,
    creature: mry_creature,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (text, out) = (Buffer::new(text, capacity, "text")?, Out::new(out_size, "out_size")?);
        text.fill_text(&call.creature(creature)?.masks.report.to_json(), &out)?;
        Ok(Code::MRY_OK)
    })
}

/// A bone's name and parent.
///
/// @param context     The context.
/// @param creature    The creature.
/// @param bone        Which, below bone_count.
/// @param name        Where the name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity    Bytes at name.
/// @param out_size    Bytes needed, with the NUL.
/// @param out_parent  The parent's index, or -1 for a root; or NULL.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (bone), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_get_bone(
    context: *mut mry_context,
    creature: mry_creature,
    bone: u32,
    name: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    out_parent: *mut i32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (name, out) = (Buffer::new(name, capacity, "name")?, Out::new(out_size, "out_size")?);
        let out_parent = Out::optional(out_parent, "out_parent")?;
        let creature = call.creature(creature)?;
        let bones = &creature.model.bones;
        let none = || Failure::argument("bone", format!("bone is {bone}, and there are {}", bones.len()));
        let bone = bones.get(bone as usize).ok_or_else(none)?;
        name.fill_text(&bone.name, &out)?;
        out_parent.inspect(|out| out.set(bone.parent.map_or(-1, |p| p as i32)));
        Ok(Code::MRY_OK)
    })
}

/// All bones in one frame, or in the rest pose.
///
/// @param context     The context.
/// @param creature    The creature.
/// @param frame       Which, below frame_count, or MRY_REST_POSE.
/// @param transforms  Where they go, one a bone; NULL with capacity 0 to ask for the count.
/// @param capacity    Transforms that fit.
/// @param out_count   Bones of the creature.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_read_pose(
    context: *mut mry_context,
    creature: mry_creature,
    frame: u64,
    transforms: *mut mry_transform,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (transforms, out) = (Buffer::new(transforms, capacity, "transforms")?, Out::new(out_count, "out_count")?);
        let creature = call.creature(creature)?;
        let model = &creature.model;
        let pose = if frame == MRY_REST_POSE {
            &model.rest
        } else {
            &model.animation[frame_index(frame, model.animation.len())?]
        };
        transforms.fill(&transforms_out(pose), &out)?;
        Ok(Code::MRY_OK)
    })
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
        let (name, out) = (Buffer::new(name, capacity, "name")?, Out::new(out_size, "out_size")?);
        let out_info = if out_info.is_null() { None } else { Some(OutStruct::new(out_info, "out_info")?) };
        let creature = call.creature(creature)?;
        let part = creature.part(part)?;
        name.fill_text(&part.name, &out)?;
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
        let positions = grouped(positions, capacity, 3, "positions")?;
        let normals = grouped(normals, capacity, 3, "normals")?;
        let uvs = grouped(uvs, capacity, 2, "uvs")?;
        let out = Out::new(out_count, "out_count")?;
        let creature = call.creature(creature)?;
        let rest = &creature.part(part)?.mesh;
        let count = rest.positions.len();
        all_fit(positions.is_some() || normals.is_some() || uvs.is_some(), count, capacity, &out)?;
        let posed;
        let mesh = if frame == MRY_REST_POSE {
            rest
        } else {
            posed = creature.pose(frame_index(frame, creature.model.animation.len())?);
            &posed[part as usize]
        };
        if let Some(positions) = positions {
            positions.write(&mesh.positions.iter().flat_map(|p| p.to_array()).collect::<Vec<f32>>())?;
        }
        if let Some(normals) = normals {
            normals.write(&mesh.normals.iter().flat_map(|n| n.to_array()).collect::<Vec<f32>>())?;
        }
        if let Some(uvs) = uvs {
            uvs.write(&mesh.uvs.iter().flat_map(|t| t.to_array()).collect::<Vec<f32>>())?;
        }
        out.set(count);
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
        let (triangles, out) =
            (Buffer::new(indices.cast::<[u32; 3]>(), capacity, "indices")?, Out::new(out_count, "out_count")?);
        triangles.fill(&call.creature(creature)?.part(part)?.mesh.triangles, &out)?;
        Ok(Code::MRY_OK)
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
        let bones = grouped(bones, capacity, 4, "bones")?;
        let weights = grouped(weights, capacity, 4, "weights")?;
        let out = Out::new(out_count, "out_count")?;
        let creature = call.creature(creature)?;
        let part = creature.part(part)?;
        all_fit(bones.is_some() || weights.is_some(), part.bones.len(), capacity, &out)?;
        if let Some(bones) = bones {
            bones.write(part.bones.as_flattened())?;
        }
        if let Some(weights) = weights {
            weights.write(part.weights.as_flattened())?;
        }
        out.set(part.bones.len());
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

/// Writes the creature as one glTF 2.0 binary: meshes, skin, animation, textures. The file appears whole or not at
/// all.
///
/// @param context   The context.
/// @param creature  The creature.
/// @param path      The file, in a folder that exists.
/// @param scale     Metres a world unit; 0 for 1.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_LIMIT, MRY_E_ARGUMENT, MRY_E_NON_FINITE,
///         MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_write_glb(
    context: *mut mry_context,
    creature: mry_creature,
    path: mry_str,
    scale: f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let mut options = GltfOptions::default();
        options.scale = metres(scale)?;
        let creature = call.creature(creature)?;
        let progress = Progress::new();
        let write = || write_aside(path, &gltf::glb(&creature.model, &options, progress.whole())?);
        call.context.executor.run(write).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// Writes everything into a folder, which appears whole or not at all: creature.glb, motion.json, masks/, overlay.gif,
/// preview.gif, report.json, and meshes/ on request. A folder that was written before is replaced, anything else in
/// the way is left alone and refused.
///
/// @param context    The context.
/// @param creature   The creature.
/// @param folder     The folder.
/// @param write_obj  1 for meshes/00000.obj, ... in world coordinates; 0 for none.
/// @param scale      Metres a world unit in creature.glb; 0 for 1.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (something is in the way), MRY_E_ARGUMENT, MRY_E_NON_FINITE, MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_write_folder(
    context: *mut mry_context,
    creature: mry_creature,
    folder: mry_str,
    write_obj: u32,
    scale: f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let folder = folder.name("folder")?;
        let options = folder_options(write_obj, scale)?;
        let creature = call.creature(creature)?;
        let Creature { clip, rig, motion, masks, model, .. } = &*creature;
        let files = CreatureFiles { clip, rig, motion, masks: &masks.masks, model };
        let mut report = masks.report.clone();
        // It may tell of another folder that the job has written.
        report.outputs.clear();
        let progress = Progress::new();
        let write = || write_creature(folder.as_ref(), &files, &options, &mut report, progress.whole());
        call.context.executor.run(write).map_err(|e| Failure::from(e).about("folder"))?;
        Ok(Code::MRY_OK)
    })
}
