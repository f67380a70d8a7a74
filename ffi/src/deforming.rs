//! Deforming. A few handles move, and a plane mesh follows: points that are held, or bones that the mesh around them turns
//! and stretches with. What does not change while handles move is worked out once, when a mesh is bound to them.

use std::sync::{Arc, Mutex};

use marey::Vec2;
use marey::deform::arap::ArapDeformer;
use marey::deform::needles::NeedleDeformer;
use marey::deform::{Deformation, Deformer, Handle, RestMesh};
use marey::job::Progress;
use marey_plugin_loader::PluginKind;

use crate::border::{self, Buffer, Out, Versioned, reserved};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_in, points_out};
use crate::table::Table;

/// Handles of one mesh, at most.
const MOST_HANDLES: usize = 10_000;
/// Points or triangles of one mesh, at most: a vertex for every other pixel of a large picture.
const MOST_POINTS: usize = 1 << 22;

/// Kind of a handle: a point of the mesh, at a; b is not looked at.
pub const MRY_HANDLE_POINT: i32 = 1;
/// Kind of a handle: a straight bone from its root a to its tip b.
pub const MRY_HANDLE_BONE: i32 = 2;

/// What a person moves to deform a mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_handle {
    /// MRY_HANDLE_POINT or MRY_HANDLE_BONE.
    pub kind: i32,
    /// Zero.
    pub reserved0: u32,
    /// The point, or the bone's root.
    pub a: mry_point,
    /// The bone's tip.
    pub b: mry_point,
}

/// A mesh bound to its handles.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_deformation {
    /// The id; 0 is no deformation.
    pub v: u64,
}

/// What to bind. Start from MRY_DEFORM_DESC_INIT.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_deform_desc {
    /// sizeof(mry_deform_desc).
    pub struct_size: u32,
    /// Steps of one solve of "arap", 1 to 1000; 0 for 10. More steps come closer to the least energy.
    pub iterations: u32,
    /// The mesh's vertices at rest, in pixels.
    pub points: *const mry_point,
    /// How many: at most 4194304.
    pub point_count: u64,
    /// Three vertex indices for each triangle, all turned the same way.
    pub triangles: *const u32,
    /// How many triangles: at most 4194304.
    pub triangle_count: u64,
    /// The handles where they lie on the mesh at rest.
    pub handles: *const mry_handle,
    /// How many: at most 10000.
    pub handle_count: u64,
    /// The deformer: "arap" (as rigid as possible; points and bones), "needles" (bones only, keeps the area), or a
    /// plugin's id; empty for "arap".
    pub deformer: mry_str,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and pointers and a string that the host vouches for.
unsafe impl Versioned for mry_deform_desc {
    const FIRST_SIZE: usize = 72;
}
const _: () = assert!(size_of::<mry_deform_desc>() == 72);

/// A deformation as the context keeps it.
pub(crate) struct Kept {
    deformation: Box<dyn Deformation>,
    rest: Vec<Vec2>,
}

pub(crate) type DeformationTable = Table<Mutex<Kept>>;

fn handles_in(handles: &[mry_handle], param: &'static str) -> Outcome<Vec<Handle>> {
    let one = |(i, handle): (usize, &mry_handle)| {
        reserved(handle.reserved0)?;
        let at = |p: mry_point| Vec2::new(p.x, p.y);
        let placed = match handle.kind {
            MRY_HANDLE_POINT => Handle::Point(at(handle.a)),
            MRY_HANDLE_BONE => Handle::Bone(at(handle.a), at(handle.b)),
            kind => {
                return Err(Failure::argument(param, format!("{param}[{i}].kind is {kind}, which is no MRY_HANDLE")));
            }
        };
        if placed.is_finite() {
            return Ok(placed);
        }
        Err(Failure::new(Code::MRY_E_NON_FINITE, param, format!("{param}[{i}] is not a number")))
    };
    handles.iter().enumerate().map(one).collect()
}

impl Call<'_> {
    pub(crate) fn deformer(&self, id: &str, iterations: usize) -> Outcome<Arc<dyn Deformer>> {
        match id {
            "" | "arap" => return Ok(Arc::new(ArapDeformer { iterations })),
            "needles" => return Ok(Arc::new(NeedleDeformer::default())),
            _ => {}
        }
        let slot = self.context.plugins.slot(id, PluginKind::Deformer).map_err(|e| e.about("desc.deformer"))?;
        let unknown = || self.unknown("desc.deformer", id, "arap, needles", PluginKind::Deformer);
        slot.map(|slot| slot as Arc<dyn Deformer>).ok_or_else(unknown)
    }

    unsafe fn bind(&self, desc: *const mry_deform_desc) -> Outcome<Kept> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        let iterations = match desc.iterations {
            0 => 10,
            n @ 1..=1000 => n as usize,
            n => return Err(Failure::argument("desc", format!("desc.iterations is {n}; give 1 to 1000"))),
        };
        // What does not fit is far past what is allowed.
        let count =
            |n: u64, each: usize| usize::try_from(n).ok().and_then(|n| n.checked_mul(each)).unwrap_or(usize::MAX);
        // SAFETY: as above.
        let (points, indices, handles, id) = unsafe {
            (
                border::slice(desc.points, count(desc.point_count, 1), MOST_POINTS, "desc.points")?,
                border::slice(desc.triangles, count(desc.triangle_count, 3), 3 * MOST_POINTS, "desc.triangles")?,
                border::slice(desc.handles, count(desc.handle_count, 1), MOST_HANDLES, "desc.handles")?,
                desc.deformer.text("desc.deformer")?,
            )
        };
        let deformer = self.deformer(id, iterations)?;
        let rest = points_in(points).map_err(|e| e.about("desc.points"))?;
        let triangles: Vec<[u32; 3]> = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        let handles = handles_in(handles, "desc.handles")?;
        let mesh = RestMesh { points: &rest, triangles: &triangles };
        let bound = self.context.executor.run(|| deformer.bind(mesh, &handles, Progress::new().whole()));
        let deformation = bound.map_err(|e| Failure::from(e).about("desc"))?;
        Ok(Kept { deformation, rest })
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_deform_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_deform_desc_init(desc: *mut mry_deform_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Binds a mesh to handles: milliseconds for thousands of vertices. What is described is copied.
///
/// @param context          The context.
/// @param desc             The mesh, the handles, and who deforms it.
/// @param out_deformation  The deformation.
/// @param err              Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no triangles, an index without its vertex, a handle that cannot be used),
///         MRY_E_ARGUMENT (iterations, a handle's kind), MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_STRING,
///         MRY_E_STRUCT_SIZE, MRY_E_UNSUPPORTED (no such deformer), what a plugin's work may return.
/// Lifetime: until mry_deformation_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_deformation_create(
    context: *mut mry_context,
    desc: *const mry_deform_desc,
    out_deformation: *mut mry_deformation,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let out = Out::new(out_deformation, "out_deformation")?;
        let kept = call.bind(desc)?;
        out.set(mry_deformation { v: call.context.deformations.insert(Mutex::new(kept))? });
        Ok(Code::MRY_OK)
    })
}

/// Moves the mesh so that every handle is where the targets say.
///
/// @param context       The context.
/// @param deformation   The deformation.
/// @param targets       As many handles as were bound, of the same kinds in the same order.
/// @param target_count  How many.
/// @param start         The shape to start from, such as the one of the frame before, which makes a drag quick and
///                      steady: as many points as the mesh has; NULL for the mesh at rest.
/// @param points        Where the new shape goes; may be start.
/// @param point_count   Points at start and at points: as many as the mesh has.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (other handles than were bound), MRY_E_ARGUMENT (point_count, a handle's kind),
///         MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_BUSY (another thread is at it), what a plugin's work may return.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_deformation_solve(
    context: *mut mry_context,
    deformation: mry_deformation,
    targets: *const mry_handle,
    target_count: usize,
    start: *const mry_point,
    points: *mut mry_point,
    point_count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        border::check(points, "points")?;
        let out = Buffer::new(points, point_count, "points")?;
        let targets = handles_in(border::slice(targets, target_count, MOST_HANDLES, "targets")?, "targets")?;
        let slot = call.get(&call.context.deformations, deformation.v, "deformation")?;
        let mut kept = slot.value.try_lock().map_err(|e| Failure::locked(&e, "deformation", "using"))?;
        let count = kept.rest.len();
        if point_count != count {
            let message = format!("point_count is {point_count}, and the mesh has {count} points");
            return Err(Failure::argument("point_count", message));
        }
        let mut shape = if start.is_null() {
            kept.rest.clone()
        } else {
            points_in(border::slice(start, count, count, "start")?).map_err(|e| e.about("start"))?
        };
        let deformation = &mut kept.deformation;
        let solve = || deformation.solve(&targets, &mut shape, Progress::new().whole());
        call.context.executor.run(solve).map_err(|e| Failure::from(e).about("targets"))?;
        out.write(&points_out(&shape))?;
        Ok(Code::MRY_OK)
    })
}

/// Destroys a deformation.
///
/// @param context      The context.
/// @param deformation  The deformation; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_deformation_destroy(
    context: *mut mry_context,
    deformation: mry_deformation,
) -> mry_status {
    ending!(context, |call| {
        if deformation.v != 0 {
            call.context.deformations.remove(deformation.v, "deformation")?;
        }
        Ok(Code::MRY_OK)
    })
}
