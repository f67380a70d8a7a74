//! Characters. A character is a cut-out drawing that moves by its skeleton: a mesh over the picture, named joints, bones
//! between them, and for each bone the region of the mesh that follows it. Pixels are those of the picture: x right, y
//! down. They are the mesh's texture coordinates too, once divided by the picture's size.

use std::ffi::c_char;
use std::sync::{Arc, RwLock};

use image::RgbaImage;
use marey::export::write_aside;
use marey::shape::character::{self, RigParams, VertexClass};

use crate::border::{self, Lists, Out, OutStruct, Text, Versioned, reserved};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::job::mry_job;
use crate::maps::{MRY_FORMAT_RGB8, MRY_FORMAT_RGBA8, mry_image_view};
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_out};
use crate::table::Table;

/// Pixels of a picture at most, as the engine has it.
const MOST_PIXELS: usize = 1 << 28;

/// A character and the picture that it was drawn in.
#[derive(Clone)]
pub(crate) struct Drawn {
    pub(crate) character: character::Character,
    pub(crate) picture: Option<Arc<RgbaImage>>,
}

impl Drawn {
    pub(crate) fn picture(&self) -> marey::Result<&Arc<RgbaImage>> {
        let none = || marey::Error::invalid("character", "has no picture", "make it from its rig and its picture");
        self.picture.as_ref().ok_or_else(none)
    }
}

pub(crate) type CharacterTable = Table<RwLock<Arc<Drawn>>>;

/// A character.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_character {
    /// The id; 0 is no character.
    pub v: u64,
}

/// What to make a character of. Start from MRY_CHARACTER_DESC_INIT; a picture, or a rig, or both must be set. With a rig
/// the character is as it says, without one its mesh and its skeleton are proposed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_character_desc {
    /// sizeof(mry_character_desc).
    pub struct_size: u32,
    /// About how many vertices the mesh has away from joints, at most 200000; 0 for 1200.
    pub vertices: u32,
    /// How much closer vertices are at joints, 1 to 8; 0 for 2.
    pub finer_at_joints: f32,
    /// Zero.
    pub reserved0: u32,
    /// The drawing's file: what is opaque, or, where everything is, what differs from the paper. Empty for pixels.
    pub picture: mry_str,
    /// A picture of the same size that cuts the drawing out: bright is the drawing. Empty for none.
    pub mask: mry_str,
    /// A rig.json file; empty for none.
    pub rig: mry_str,
    /// The text of a rig.json; empty for none.
    pub rig_json: mry_str,
    /// The drawing in memory, in place of a file: MRY_FORMAT_RGBA8 with straight alpha, or MRY_FORMAT_RGB8. NULL for none.
    /// map is not looked at.
    pub pixels: *const mry_image_view,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and strings and a pointer that the host vouches for.
unsafe impl Versioned for mry_character_desc {
    const FIRST_SIZE: usize = 88;
}
const _: () = assert!(size_of::<mry_character_desc>() == 88);

/// What a character is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_character_info {
    /// sizeof(mry_character_info).
    pub struct_size: u32,
    /// The picture's pixels across.
    pub width: u32,
    /// The picture's pixels down.
    pub height: u32,
    /// How many joints there are.
    pub joint_count: u32,
    /// How many bones there are.
    pub bone_count: u32,
    /// 1 where the picture is there, 0 where the character was made of a rig alone.
    pub has_picture: u32,
    /// The mesh's vertices.
    pub vertex_count: u64,
    /// The mesh's triangles.
    pub triangle_count: u64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_character_info {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_character_info>() == 40);

/// Class of a vertex: on the mesh's rim.
pub const MRY_VERTEX_SILHOUETTE: u8 = 1;
/// Class of a vertex: inside one bone's region.
pub const MRY_VERTEX_INTERIOR: u8 = 2;
/// Class of a vertex: where regions join.
pub const MRY_VERTEX_JOINT: u8 = 3;

impl Call<'_> {
    pub(crate) fn character(&self, character: mry_character) -> Outcome<Arc<Drawn>> {
        let slot = self.get(&self.context.characters, character.v, "character")?;
        let drawn = slot.value.try_read().map_err(|e| Failure::locked(&e, "character", "changing"))?;
        Ok(drawn.clone())
    }

    /// Changes a character; who shares it keeps it as it was, and so does the table when the change fails.
    pub(crate) fn character_mut<T>(
        &self,
        character: mry_character,
        change: impl FnOnce(&mut character::Character) -> Outcome<T>,
    ) -> Outcome<T> {
        let slot = self.get(&self.context.characters, character.v, "character")?;
        let mut drawn = slot.value.try_write().map_err(|e| Failure::locked(&e, "character", "changing"))?;
        let mut changed = drawn.character.clone();
        let answer = change(&mut changed)?;
        *drawn = Arc::new(Drawn { character: changed, picture: drawn.picture.clone() });
        Ok(answer)
    }

    pub(crate) fn keep_character(&self, drawn: Arc<Drawn>) -> Outcome<mry_character> {
        Ok(mry_character { v: self.context.characters.insert(RwLock::new(drawn))? })
    }

    unsafe fn character_work(&self, desc: *const mry_character_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        reserved(desc.reserved0)?;
        // SAFETY: as above.
        let (file, mask, rig, rig_json, pixels) = unsafe {
            (
                path(desc.picture, "desc.picture")?,
                path(desc.mask, "desc.mask")?,
                path(desc.rig, "desc.rig")?,
                if desc.rig_json.len == 0 { None } else { Some(desc.rig_json.text("desc.rig_json")?.to_owned()) },
                if desc.pixels.is_null() { None } else { Some(pixels(desc.pixels)?) },
            )
        };
        let both = |param, a: bool, b: bool, what| {
            if a && b { Err(Failure::argument(param, format!("{param}: give {what}, not both"))) } else { Ok(()) }
        };
        both("desc.picture", file.is_some(), pixels.is_some(), "a file or pixels")?;
        both("desc.rig", rig.is_some(), rig_json.is_some(), "a file or its text")?;
        if file.is_none() && pixels.is_none() && rig.is_none() && rig_json.is_none() {
            return Err(Failure::argument("desc.picture", "desc.picture: give a picture, a rig, or both"));
        }
        let mut params = RigParams::default();
        if desc.vertices != 0 {
            params.vertices = desc.vertices as usize;
        }
        if !desc.finer_at_joints.is_finite() {
            let message = format!("desc.finer_at_joints is {}", desc.finer_at_joints);
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "desc.finer_at_joints", message));
        }
        if desc.finer_at_joints != 0.0 {
            params.finer_at_joints = desc.finer_at_joints;
        }
        Ok(Box::new(move |progress| {
            let stage = progress.whole();
            stage.name("reading")?;
            let mut picture = match &file {
                Some(file) => Some(character::read_drawing(file)?),
                None => pixels,
            };
            if let (Some(picture), Some(mask)) = (&mut picture, &mask) {
                character::apply_mask(picture, &character::read_cut(mask)?)?;
            }
            stage.at(0.1)?;
            let read = match (&rig, &rig_json) {
                (Some(rig), _) => Some(character::Character::read(rig)?),
                (_, Some(json)) => Some(character::Character::from_json(json)?),
                _ => None,
            };
            let character = match (read, &picture) {
                (Some(read), picture) => {
                    let size = picture.as_ref().map_or(read.size, RgbaImage::dimensions);
                    if size != read.size {
                        let ((w, h), (rw, rh)) = (size, read.size);
                        let problem = format!("is for a picture of {rw}x{rh} pixels, and this one has {w}x{h}");
                        return Err(marey::Error::invalid("rig", problem, "give the picture that it was made of"));
                    }
                    read
                }
                (None, Some(picture)) => {
                    let named = |e| match (e, &file) {
                        (marey::Error::Invalid { what, problem, remedy }, Some(file)) if what == "picture" => {
                            marey::Error::file(file, problem, remedy)
                        }
                        (other, _) => other,
                    };
                    let part = stage.part(0.1, 1.0);
                    character::Character::from_picture(picture, &params, part).map_err(named)?
                }
                (None, None) => return Err(marey::Error::invalid("character", "has no picture", "give one")),
            };
            let drawn = Drawn { character, picture: picture.map(Arc::new) };
            Ok(Product { character: Part::Made(Arc::new(drawn)), ..Product::default() })
        }))
    }
}

/// # Safety
/// The string is valid, as the header asks.
unsafe fn path(path: mry_str, param: &'static str) -> Outcome<Option<String>> {
    // SAFETY: as this function's own.
    if path.len == 0 { Ok(None) } else { unsafe { path.name(param).map(|p| Some(p.to_owned())) } }
}

/// # Safety
/// The view is NULL or describes memory that may be read until the call returns, as the header asks.
unsafe fn pixels(view: *const mry_image_view) -> Outcome<RgbaImage> {
    const PARAM: &str = "desc.pixels";
    // SAFETY: as this function's own.
    let view = unsafe { border::read(view, PARAM)? };
    let each = match view.format {
        MRY_FORMAT_RGB8 => 3,
        MRY_FORMAT_RGBA8 => 4,
        format => return Err(Failure::argument(PARAM, format!("{PARAM}.format is {format}, which is none of these"))),
    };
    let (width, height) = (view.width as usize, view.height as usize);
    if width.saturating_mul(height) > MOST_PIXELS {
        let message = format!("{PARAM} has {width}x{height} pixels, and at most {MOST_PIXELS} are allowed");
        return Err(Failure::new(Code::MRY_E_LIMIT, PARAM, message));
    }
    let row = each * width;
    let stride = if view.stride_bytes == 0 { row } else { usize::try_from(view.stride_bytes).unwrap_or(usize::MAX) };
    let bytes = height.checked_sub(1).map_or(Some(0), |n| stride.checked_mul(n)?.checked_add(row));
    let bytes = bytes.filter(|b| stride >= row && *b <= 16 * MOST_PIXELS).ok_or_else(|| {
        Failure::argument(PARAM, format!("{PARAM}.stride_bytes is {stride}, and a row has {row} bytes"))
    })?;
    // SAFETY: as this function's own.
    let data = unsafe { border::slice(view.data, bytes, usize::MAX, PARAM)? };
    let pixel = |x: u32, y: u32| {
        let at = &data[y as usize * stride + each * x as usize..][..each];
        image::Rgba([at[0], at[1], at[2], at.get(3).copied().unwrap_or(255)])
    };
    Ok(RgbaImage::from_fn(view.width, view.height, pixel))
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_character_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_desc_init(desc: *mut mry_character_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a character info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_character_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_info_init(info: *mut mry_character_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Starts making a character. Gives a character. Pixels and texts are copied when it starts, files are read later.
///
/// @param context  The context.
/// @param desc     What to make it of.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (nothing given, a picture or a rig given twice, the pixels' format or stride),
///         MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_STRUCT_SIZE, MRY_E_STRING.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_character(
    context: *mut mry_context,
    desc: *const mry_character_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.character_work(desc)?;
        out.set(call.keep_job(&call.start("character", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Makes a character, and returns when it is done. Work that was started before comes first.
///
/// @param context        The context.
/// @param desc           What to make it of.
/// @param out_character  The character.
/// @param err            Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_character and mry_job_wait return; MRY_E_INPUT (no drawing is found, a rig for
///         another size), MRY_E_NO_FILE.
/// Lifetime: until mry_character_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_character(
    context: *mut mry_context,
    desc: *const mry_character_desc,
    out_character: *mut mry_character,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_character, "out_character")?;
        let work = call.character_work(desc)?;
        let (_, job) = call.run("character", work)?;
        job.take(|p| &mut p.character, |drawn| call.keep_character(drawn).map(|id| out.set(id)))
    })
}

/// Copies a character, to change it. What is large is shared.
///
/// @param context        The context.
/// @param character      The character.
/// @param out_character  The copy.
/// @param err            Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUSY.
/// Lifetime: until mry_character_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_copy(
    context: *mut mry_context,
    character: mry_character,
    out_character: *mut mry_character,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_character, "out_character")?;
        let drawn = call.character(character)?;
        out.set(call.keep_character(drawn)?);
        Ok(Code::MRY_OK)
    })
}

/// Destroys a character. Posers, poses and takes made of it live on.
///
/// @param context    The context.
/// @param character  The character; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_destroy(context: *mut mry_context, character: mry_character) -> mry_status {
    ending!(context, |call| {
        if character.v != 0 {
            call.context.characters.remove(character.v, "character")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// What a character is: size and counts.
///
/// @param context    The context.
/// @param character  The character.
/// @param out_info   The answer; its struct_size must be set.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_get_info(
    context: *mut mry_context,
    character: mry_character,
    out_info: *mut mry_character_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let drawn = call.character(character)?;
        let character = &drawn.character;
        out.set(&mry_character_info {
            struct_size: 0,
            width: character.size.0,
            height: character.size.1,
            joint_count: character.skeleton.joints.len() as u32,
            bone_count: character.skeleton.bones.len() as u32,
            has_picture: u32::from(drawn.picture.is_some()),
            vertex_count: character.mesh.points.len() as u64,
            triangle_count: character.mesh.triangles.len() as u64,
        });
        Ok(Code::MRY_OK)
    })
}

/// The mesh's vertices at rest.
///
/// @param context    The context.
/// @param character  The character.
/// @param points     Where they are; or NULL.
/// @param bones      The bone that each follows; or NULL.
/// @param classes    MRY_VERTEX_SILHOUETTE, ...; or NULL.
/// @param capacity   Vertices that fit into each list.
/// @param out_count  Vertices of the mesh.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_ARGUMENT (capacity), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_read_vertices(
    context: *mut mry_context,
    character: mry_character,
    points: *mut mry_point,
    bones: *mut u32,
    classes: *mut u8,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let mut lists = Lists::new(capacity, out_count)?;
        let points = lists.list(points, 1, "points")?;
        let bones = lists.list(bones, 1, "bones")?;
        let classes = lists.list(classes, 1, "classes")?;
        let drawn = call.character(character)?;
        let (mesh, regions) = (&drawn.character.mesh, &drawn.character.regions);
        lists.fit(mesh.points.len())?;
        if let Some(points) = points {
            points.write(&points_out(&mesh.points))?;
        }
        if let Some(bones) = bones {
            bones.write(&regions.bone)?;
        }
        if let Some(classes) = classes {
            let class = |c: &VertexClass| match c {
                VertexClass::Silhouette => MRY_VERTEX_SILHOUETTE,
                VertexClass::Interior => MRY_VERTEX_INTERIOR,
                VertexClass::Joint => MRY_VERTEX_JOINT,
            };
            classes.write(&regions.class.iter().map(class).collect::<Vec<u8>>())?;
        }
        Ok(Code::MRY_OK)
    })
}

/// The mesh's triangles, all turned from x to y.
///
/// @param context    The context.
/// @param character  The character.
/// @param indices    Three vertex indices for each triangle; NULL with capacity 0 to ask for the count.
/// @param capacity   Triangles that fit.
/// @param out_count  Triangles of the mesh.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_ARGUMENT (capacity), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_read_triangles(
    context: *mut mry_context,
    character: mry_character,
    indices: *mut u32,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let mut lists = Lists::new(capacity, out_count)?;
        let indices = lists.list(indices, 3, "indices")?;
        let drawn = call.character(character)?;
        let triangles = &drawn.character.mesh.triangles;
        lists.fit(triangles.len())?;
        if let Some(indices) = indices {
            indices.write(triangles.as_flattened())?;
        } else if !triangles.is_empty() && capacity > 0 {
            return Err(border::null("indices"));
        }
        Ok(Code::MRY_OK)
    })
}

/// The character as the text of a rig.json. Its picture is not in it.
///
/// @param context    The context.
/// @param character  The character.
/// @param text       Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity   Bytes at text.
/// @param out_size   Bytes needed, with the NUL.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_to_json(
    context: *mut mry_context,
    character: mry_character,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        text.fill(&call.character(character)?.character.to_json())
    })
}

/// Writes rig.json; the file appears whole or not at all.
///
/// @param context    The context.
/// @param character  The character.
/// @param path       The file, in a folder that exists.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_write(
    context: *mut mry_context,
    character: mry_character,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let text = call.character(character)?.character.to_json();
        write_aside(path, text.as_bytes()).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// Writes a PNG of the rig over the picture: the mesh with each bone's region in a colour, bones, and joints.
///
/// @param context    The context.
/// @param character  The character, with its picture.
/// @param path       The file, in a folder that exists.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no picture, no place for a file), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_character_write_preview(
    context: *mut mry_context,
    character: mry_character,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let drawn = call.character(character)?;
        let png = marey::export::rig_preview(&drawn.character, drawn.picture()?)?;
        write_aside(path, &png).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}
