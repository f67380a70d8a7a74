//! Printing. A solid is one frame of a creature as a closed surface in millimetres, z up, standing on z = 0: without inner
//! faces or holes, with thin parts made thick enough, and on a base where one is wanted. Every edge has two triangles
//! whatever the creature; slicers have nothing to repair. Solids do not change.

use std::path::Path;
use std::sync::Arc;

use marey::export::print::{PrintFormat, write_print};
use marey::job::Progress;
use marey::shape::solid::{self, Solid, SolidOptions, SolidSize};

use crate::border::{self, List, Lists, Out, OutStruct, Versioned, reserved};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::creature::mry_creature;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::job::mry_job;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;

pub(crate) type SolidTable = Table<Arc<Solid>>;

/// A solid.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_solid {
    /// The id; 0 is no solid.
    pub v: u64,
}

/// Size of a print: its longest side, in mm.
pub const MRY_PRINT_LONGEST: i32 = 0;
/// Size of a print: its height, in mm.
pub const MRY_PRINT_HEIGHT: i32 = 1;
/// Size of a print: millimetres a world unit, so that frames of one creature keep their relative size.
pub const MRY_PRINT_UNIT: i32 = 2;

/// What to print. Start from MRY_PRINT_DESC_INIT; creature must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_print_desc {
    /// sizeof(mry_print_desc).
    pub struct_size: u32,
    /// What size means: MRY_PRINT_LONGEST, ...
    pub size_kind: i32,
    /// The creature.
    pub creature: mry_creature,
    /// Which frame, below frame_count.
    pub frame: u64,
    /// How large, before thin parts and a base make it larger; 0 for 100.
    pub size: f32,
    /// No part is thinner, in mm; 0 for 1. Below 0 thin parts stay as they are.
    pub min_thickness: f32,
    /// The size of the smallest detail, in mm; 0 chooses by size and thickness.
    pub detail: f32,
    /// 1 for a plate under the feet, joined to all of them.
    pub base: u32,
    /// At most so many triangles, from 100 on; 0 for as many as the detail takes.
    pub max_triangles: u32,
    /// Zero.
    pub reserved0: u32,
    /// Where to write it, a name that ends in .stl or .3mf; empty for nowhere.
    pub path: mry_str,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and a string that the host vouches for.
unsafe impl Versioned for mry_print_desc {
    const FIRST_SIZE: usize = 64;
}
const _: () = assert!(size_of::<mry_print_desc>() == 64);

/// What a solid is, and what was done to make it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_solid_info {
    /// sizeof(mry_solid_info).
    pub struct_size: u32,
    /// Feet that the base holds; 0 without one.
    pub feet: u32,
    /// Vertices.
    pub vertex_count: u64,
    /// Triangles.
    pub triangle_count: u64,
    /// In cubic mm.
    pub volume: f64,
    /// In mm.
    pub width: f32,
    /// In mm.
    pub depth: f32,
    /// In mm.
    pub height: f32,
    /// Millimetres a world unit.
    pub mm_per_unit: f32,
    /// How much of the surface belonged to parts that were too thin, 0..1.
    pub thickened: f32,
    /// Loose bits that bars join to the rest.
    pub joined: u32,
    /// Loose bits that were left out.
    pub dropped: u32,
    /// Hollows inside that were filled.
    pub filled: u32,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_solid_info {
    const FIRST_SIZE: usize = 64;
}
const _: () = assert!(size_of::<mry_solid_info>() == 64);

/// A length of a description, in mm; 0 is the default.
fn length(value: f32, default: f32, param: &'static str) -> Outcome<f32> {
    if !value.is_finite() {
        return Err(Failure::new(Code::MRY_E_NON_FINITE, param, format!("{param} is {value}")));
    }
    if value < 0.0 {
        return Err(Failure::argument(param, format!("{param} is {value}, and must be above 0")));
    }
    Ok(if value == 0.0 { default } else { value })
}

fn options(desc: &mry_print_desc) -> Outcome<SolidOptions> {
    reserved(desc.reserved0)?;
    let mut options = SolidOptions::default();
    let size = length(desc.size, 100.0, "desc.size")?;
    options.size = match desc.size_kind {
        MRY_PRINT_LONGEST => SolidSize::Longest(size),
        MRY_PRINT_HEIGHT => SolidSize::Height(size),
        MRY_PRINT_UNIT => SolidSize::Unit(size),
        kind => {
            return Err(Failure::argument(
                "desc.size_kind",
                format!("desc.size_kind is {kind}, which is no MRY_PRINT"),
            ));
        }
    };
    options.min_thickness = match desc.min_thickness {
        thin if thin < 0.0 && thin.is_finite() => 0.0,
        least => length(least, options.min_thickness, "desc.min_thickness")?,
    };
    options.detail = Some(length(desc.detail, 0.0, "desc.detail")?).filter(|d| *d > 0.0);
    if desc.base > 1 {
        return Err(Failure::argument("desc.base", format!("desc.base is {}; give 0 or 1", desc.base)));
    }
    options.base = desc.base == 1;
    if (1..100).contains(&desc.max_triangles) {
        let message = format!("desc.max_triangles is {}, and must be 0 or at least 100", desc.max_triangles);
        return Err(Failure::argument("desc.max_triangles", message));
    }
    options.max_triangles = (desc.max_triangles > 0).then_some(desc.max_triangles as usize);
    Ok(options)
}

impl Call<'_> {
    fn solid(&self, solid: mry_solid) -> Outcome<Arc<Solid>> {
        Ok(self.get(&self.context.solids, solid.v, "solid")?.value.clone())
    }

    pub(crate) fn keep_solid(&self, solid: Arc<Solid>) -> Outcome<mry_solid> {
        Ok(mry_solid { v: self.context.solids.insert(solid)? })
    }

    unsafe fn print_work(&self, desc: *const mry_print_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        let options = options(&desc)?;
        let path = if desc.path.len == 0 {
            None
        } else {
            // SAFETY: as above.
            let path = unsafe { desc.path.name("desc.path")? }.to_owned();
            PrintFormat::of(path.as_ref()).map_err(|e| Failure::from(e).about("desc.path"))?;
            Some(path)
        };
        let creature = self.creature(desc.creature).map_err(|e| e.about("desc.creature"))?;
        let frame = frame_index(desc.frame, creature.model().animation.len()).map_err(|e| e.about("desc.frame"))?;
        Ok(Box::new(move |progress| {
            let stage = progress.whole();
            let solid = solid::solid(creature.model(), frame, &options, stage.part(0.0, 0.95))?;
            if let Some(path) = &path {
                stage.part(0.95, 1.0).name("writing the file")?;
                write_print(path.as_ref(), &solid, stage.part(0.95, 1.0))?;
            }
            let report = serde_json::to_string(&solid.report).ok();
            Ok(Product { solid: Part::Made(Arc::new(solid)), report, ..Product::default() })
        }))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_print_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_print_desc_init(desc: *mut mry_print_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a struct with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_solid_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_solid_info_init(info: *mut mry_solid_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Starts making a solid of one frame of a creature, and a file of it where desc.path is set, which appears whole or not
/// at all. Gives a solid; mry_job_get_report says what was done and what a person should know of it.
///
/// @param context  The context.
/// @param desc     What to print.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame, size_kind, a length below 0, base, max_triangles), MRY_E_NON_FINITE, MRY_E_INPUT
///         (path ends in neither .stl nor .3mf), MRY_E_STRUCT_SIZE, MRY_E_STRING. The job itself ends with MRY_E_INPUT
///         where the print would be smaller than its thickness asks for, and MRY_E_LIMIT where the detail is too fine.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_print(
    context: *mut mry_context,
    desc: *const mry_print_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.print_work(desc)?;
        out.set(call.keep_job(&call.start("print", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Makes a solid of one frame of a creature, and returns when it is done. Work that was started before comes first.
///
/// @param context    The context.
/// @param desc       What to print.
/// @param out_solid  The solid.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_print and mry_job_wait return.
/// Lifetime: until mry_solid_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_print(
    context: *mut mry_context,
    desc: *const mry_print_desc,
    out_solid: *mut mry_solid,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_solid, "out_solid")?;
        let work = call.print_work(desc)?;
        let (_, job) = call.run("print", work)?;
        job.take(|p| &mut p.solid, |solid| call.keep_solid(solid).map(|id| out.set(id)))
    })
}

/// What a solid is, and what was done to make it.
///
/// @param context   The context.
/// @param solid     The solid.
/// @param out_info  The answer.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_solid_get_info(
    context: *mut mry_context,
    solid: mry_solid,
    out_info: *mut mry_solid_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let solid = call.solid(solid)?;
        let report = &solid.report;
        let [width, depth, height] = report.size_mm;
        out.set(&mry_solid_info {
            struct_size: 0,
            feet: report.feet as u32,
            vertex_count: solid.positions.len() as u64,
            triangle_count: solid.triangles.len() as u64,
            volume: report.volume_mm3,
            width,
            depth,
            height,
            mm_per_unit: report.mm_per_unit,
            thickened: report.thickened,
            joined: report.joined as u32,
            dropped: report.dropped as u32,
            filled: report.filled as u32,
        });
        Ok(Code::MRY_OK)
    })
}

/// A solid's vertices. Lists that are not wanted may be NULL.
///
/// @param context    The context.
/// @param solid      The solid.
/// @param positions  x, y, z in mm for each vertex; or NULL.
/// @param colours    Red, green, blue for each vertex, sRGB, from the creature's texture; or NULL.
/// @param capacity   Vertices that fit in each list.
/// @param out_count  How many there are.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (capacity), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_solid_read_vertices(
    context: *mut mry_context,
    solid: mry_solid,
    positions: *mut f32,
    colours: *mut u8,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let mut lists = Lists::new(capacity, out_count)?;
        let positions = lists.list(positions, 3, "positions")?;
        let colours = lists.list(colours, 3, "colours")?;
        let solid = call.solid(solid)?;
        lists.fit(solid.positions.len())?;
        if let Some(positions) = positions {
            positions.write(&solid.positions.iter().flat_map(|p| p.to_array()).collect::<Vec<f32>>())?;
        }
        if let Some(colours) = colours {
            colours.write(solid.colours.as_flattened())?;
        }
        Ok(Code::MRY_OK)
    })
}

/// A solid's triangles, counter-clockwise seen from outside. Each edge belongs to two.
///
/// @param context    The context.
/// @param solid      The solid.
/// @param indices    Three vertex indices for each triangle; NULL with capacity 0 to ask for the count.
/// @param capacity   Triangles that fit.
/// @param out_count  How many there are.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (capacity), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_solid_read_triangles(
    context: *mut mry_context,
    solid: mry_solid,
    indices: *mut u32,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        // The same numbers, three by three.
        let triangles = List::new(indices.cast::<[u32; 3]>(), capacity, out_count, "indices")?;
        triangles.fill(&call.solid(solid)?.triangles)
    })
}

/// Writes a solid to a file, which appears whole or not at all: binary STL, or 3MF with a colour for each vertex.
///
/// @param context  The context.
/// @param solid    The solid.
/// @param path     The file, in a folder that exists; its name ends in .stl or .3mf.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (another ending, no place for a file), MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_solid_write(
    context: *mut mry_context,
    solid: mry_solid,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path: &Path = path.name("path")?.as_ref();
        let solid = call.solid(solid)?;
        let progress = Progress::new();
        write_print(path, &solid, progress.whole()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// Destroys a solid.
///
/// @param context  The context.
/// @param solid    The solid; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_solid_destroy(context: *mut mry_context, solid: mry_solid) -> mry_status {
    ending!(context, |call| {
        if solid.v != 0 {
            call.context.solids.remove(solid.v, "solid")?;
        }
        Ok(Code::MRY_OK)
    })
}
