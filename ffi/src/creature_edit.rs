//! Edits. A creature's mesh of one frame goes out to a modelling tool; what was changed there comes back and plays in
//! every frame.

use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec3;
use marey::shape::creature::{EditKind, EditedMesh, apply_edit};

use crate::border::{self, Out, Versioned};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::creature::{Creature, mry_creature};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// No edit has more vertices or triangles.
const MOST: usize = 4_000_000;

/// A mesh that a modelling tool gives back. Start from MRY_EDIT_DESC_INIT; creature must be set, and path or the lists.
///
/// With as many vertices as the creature has, in the order in which mry_creature_read_vertices gives the parts one after
/// the other and OBJ files have them, the change is a displacement in the frames of the bones. Any other mesh is bound
/// anew to the bones of its nearest places, in one part with a texture of its own.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_edit_desc {
    /// sizeof(mry_edit_desc).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// The creature.
    pub creature: mry_creature,
    /// The frame whose mesh was edited.
    pub frame: u64,
    /// The mesh as a file, Wavefront OBJ; empty for the lists below.
    pub path: mry_str,
    /// x, y, z for each vertex, in world coordinates of the frame.
    pub positions: *const f32,
    /// How many vertices.
    pub vertex_count: usize,
    /// Three vertices for each triangle, counter-clockwise seen from outside.
    pub indices: *const u32,
    /// How many triangles.
    pub triangle_count: usize,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and lists and strings that the host vouches for.
unsafe impl Versioned for mry_edit_desc {
    const FIRST_SIZE: usize = 72;
}
const _: () = assert!(size_of::<mry_edit_desc>() == 72);

/// Where the mesh comes from.
enum From {
    File(PathBuf),
    Lists(EditedMesh),
}

impl Call<'_> {
    unsafe fn edit_work(&self, desc: *const mry_edit_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        let creature = self.creature(desc.creature)?;
        let frame = frame_index(desc.frame, creature.model().animation.len())?;
        // SAFETY: as above.
        let from = unsafe {
            if desc.path.len > 0 {
                From::File(PathBuf::from(desc.path.name("desc.path")?))
            } else {
                let positions =
                    border::slice(desc.positions.cast::<[f32; 3]>(), desc.vertex_count, MOST, "desc.positions")?;
                let triangles =
                    border::slice(desc.indices.cast::<[u32; 3]>(), desc.triangle_count, MOST, "desc.indices")?;
                if positions.is_empty() {
                    let message = "neither desc.path nor desc.positions is given";
                    return Err(Failure::argument("desc.path", message));
                }
                From::Lists(EditedMesh {
                    positions: positions.iter().copied().map(Vec3::from_array).collect(),
                    triangles: triangles.to_vec(),
                })
            }
        };
        Ok(Box::new(move |progress| {
            let mesh = match from {
                From::File(path) => EditedMesh::read(&path)?,
                From::Lists(mesh) => mesh,
            };
            let mut made = (*creature.creature).clone();
            let kind = apply_edit(&mut made.model, frame, &mesh, progress.whole())?;
            let report = match kind {
                EditKind::Displaced(vertices) => serde_json::json!({ "kind": "displaced", "vertices": vertices }),
                EditKind::BoundAnew => serde_json::json!({ "kind": "bound_anew", "vertices": mesh.positions.len() }),
            };
            let creature = Creature::new(None, creature.motion.clone(), made);
            let creature = Part::Made(Arc::new(creature));
            Ok(Product { creature, report: Some(report.to_string()), ..Product::default() })
        }))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_edit_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_edit_desc_init(desc: *mut mry_edit_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Starts taking an edited mesh into a creature. Gives a creature, which mry_job_take_creature takes; the one it came
/// from stays as it is. mry_job_get_report says {"kind": "displaced" or "bound_anew", "vertices": how many}.
///
/// @param context  The context.
/// @param desc     The edit. Its lists are copied; its file is read by the job.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame, no mesh), MRY_E_LIMIT, MRY_E_STRUCT_SIZE, MRY_E_STRING.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_edit(
    context: *mut mry_context,
    desc: *const mry_edit_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.edit_work(desc)?;
        out.set(call.keep_job(&call.start("edit", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Takes an edited mesh into a creature, and returns when it is done. Work that was started before comes first.
///
/// @param context       The context.
/// @param desc          The edit.
/// @param out_creature  The edited creature.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_edit and mry_job_wait return; MRY_E_INPUT (a mesh that is damaged or not where the
///         creature is in that frame), MRY_E_NO_FILE, MRY_E_IO.
/// Lifetime: until mry_creature_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_edit(
    context: *mut mry_context,
    desc: *const mry_edit_desc,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        let work = call.edit_work(desc)?;
        let (_, job) = call.run("edit", work)?;
        job.take(|p| &mut p.creature, |creature| call.keep_creature(creature).map(|id| out.set(id)))
    })
}
