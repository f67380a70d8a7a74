//! Takes. A take is what a character does in every frame: of key poses with what lies between them, or of a motion. Takes do
//! not change; they keep their character as it was.

use std::ffi::c_char;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use image::RgbaImage;
use marey::shape::character::{Animation, Canvas, Drawing, Posture, Take, cut_out};
use serde_json::json;

use crate::border::{self, List, Out, OutStruct, Text, Versioned};
use crate::character::{Drawn, mry_character};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::job::mry_job;
use crate::motion::mry_motion;
use crate::poses::mry_poses;
use crate::posing::Who;
use crate::retargeting::{Carrying, mry_retarget_desc};
use crate::rows::Rows;
use crate::running::{Part, Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::stroke::{mry_point, points_out};
use crate::table::Table;

/// A take with its character and the report of the job that made it.
pub(crate) struct Played {
    pub(crate) drawn: Arc<Drawn>,
    pub(crate) take: Take,
    pub(crate) report: String,
    /// The drawing cut out of its picture, once a frame was drawn.
    cut: OnceLock<RgbaImage>,
}

impl Played {
    pub(crate) fn new(drawn: Arc<Drawn>, take: Take, report: String) -> Self {
        Self { drawn, take, report, cut: OnceLock::new() }
    }

    fn canvas(&self, scale: f32, crop: u32) -> Outcome<Canvas> {
        if !scale.is_finite() {
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "scale", format!("scale is {scale}")));
        }
        if scale < 0.0 {
            return Err(Failure::argument("scale", format!("scale is {scale}, and must be above 0")));
        }
        if crop > 1 {
            return Err(Failure::argument("crop", format!("crop is {crop}; give 0 or 1")));
        }
        let scale = if scale == 0.0 { 1.0 } else { scale };
        Ok(Canvas::new(&self.drawn.character, &self.take, scale, crop == 0)?)
    }
}

pub(crate) type TakeTable = Table<Arc<Played>>;

/// A character in motion.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_take {
    /// The id; 0 is no take.
    pub v: u64,
}

/// What to make a take of. Start from MRY_TAKE_DESC_INIT; poses, or character and motion must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_take_desc {
    /// sizeof(mry_take_desc).
    pub struct_size: u32,
    /// What keeps the area, with "needles": MRY_AREA_EXACT, ...
    pub area: i32,
    /// Key poses, of their own character; or {0}.
    pub poses: mry_poses,
    /// With a motion: the character.
    pub character: mry_character,
    /// The motion; or {0}.
    pub motion: mry_motion,
    /// "needles", "arap" or a plugin's id; empty for "needles".
    pub deformer: mry_str,
    /// With a motion: how it is carried over; NULL for the defaults.
    pub retarget: *const mry_retarget_desc,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and a string and a pointer that the host vouches for.
unsafe impl Versioned for mry_take_desc {
    const FIRST_SIZE: usize = 56;
}
const _: () = assert!(size_of::<mry_take_desc>() == 56);

/// What a take is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_take_info {
    /// sizeof(mry_take_info).
    pub struct_size: u32,
    /// Joints of the character.
    pub joint_count: u32,
    /// Bones of the character.
    pub bone_count: u32,
    /// Zero.
    pub reserved0: u32,
    /// Vertices of the character.
    pub vertex_count: u64,
    /// How many frames there are.
    pub frame_count: u64,
    /// Frames a second.
    pub fps: f64,
    /// The left upper corner of the mesh in all frames.
    pub low: mry_point,
    /// The right lower corner of the mesh in all frames.
    pub high: mry_point,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_take_info {
    const FIRST_SIZE: usize = 56;
}
const _: () = assert!(size_of::<mry_take_info>() == 56);

/// What a take is made of.
enum From {
    Poses(marey::shape::character::Poses),
    Motion(Arc<marey::motion::Motion>, Carrying),
}

impl Call<'_> {
    pub(crate) fn take(&self, take: mry_take) -> Outcome<Arc<Played>> {
        Ok(self.get(&self.context.takes, take.v, "take")?.value.clone())
    }

    pub(crate) fn keep_take(&self, take: Arc<Played>) -> Outcome<mry_take> {
        Ok(mry_take { v: self.context.takes.insert(take)? })
    }

    unsafe fn take_work(&self, desc: *const mry_take_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        // SAFETY: as above.
        let (who, carrying) = unsafe {
            (
                self.who_poses(desc.deformer, desc.area, ["desc.deformer", "desc.area"])?,
                Carrying::read(desc.retarget, "desc.retarget")?,
            )
        };
        let (drawn, from) = if desc.poses.v != 0 {
            if desc.motion.v != 0 {
                return Err(Failure::argument("desc.poses", "desc.poses: give poses or a motion, not both"));
            }
            let posed = self.poses(desc.poses)?;
            (posed.drawn.clone(), From::Poses(posed.poses.clone()))
        } else {
            (self.character(desc.character)?, From::Motion(self.motion(desc.motion)?, carrying))
        };
        Ok(Box::new(move |progress| {
            let (began, stage, character) = (Instant::now(), progress.whole(), &drawn.character);
            let skeleton = &character.skeleton;
            let mut warnings = Vec::new();
            for (bone, &[a, b]) in skeleton.bones.iter().enumerate() {
                if !character.regions.bone.contains(&(bone as u32)) {
                    let name = |j: usize| &skeleton.joints[j].name;
                    warnings.push(format!("bone `{}`-`{}` moves nothing: it lies outside", name(a), name(b)));
                }
            }
            let mut followed = serde_json::Value::Null;
            let take = match (&from, &who) {
                (From::Poses(poses), Who::Needles(needles)) => {
                    let animation = Animation::new(character, needles, poses.clone(), stage.part(0.0, 0.6))?;
                    Take::of_poses(&animation, stage.part(0.6, 1.0))?
                }
                (From::Poses(poses), Who::Other(other)) => {
                    let plain = marey::deform::needles::NeedleDeformer { joint_areas: false, ..Default::default() };
                    let animation = Animation::new(character, &plain, poses.clone(), stage.part(0.0, 0.3))?;
                    let postures = (0..animation.frames()).map(|f| animation.posture(f)).collect();
                    Take::by_deformer(character, &**other, animation.fps(), postures, stage.part(0.3, 1.0))?
                }
                (From::Motion(motion, carrying), who) => {
                    stage.name("retargeting")?;
                    let (carried, map, made_from) = carrying.carry(motion, skeleton, character.size)?;
                    let still: Vec<&str> = skeleton.joints.iter().map(|j| j.name.as_str()).collect();
                    let still: Vec<&str> = still.into_iter().filter(|j| !map.joints.contains_key(*j)).collect();
                    if !still.is_empty() {
                        warnings.push(format!("joints that follow nothing: {}", still.join(", ")));
                    }
                    let own: serde_json::Value = serde_json::from_str(&map.to_json()).unwrap_or_default();
                    followed = json!({ "made_from": made_from, "map": own });
                    match who {
                        Who::Needles(needles) => {
                            let mut poser = character.poser(needles, stage.part(0.1, 0.2))?;
                            Take::of_motion(&mut poser, &carried, &[], stage.part(0.2, 1.0))?
                        }
                        Who::Other(other) => {
                            let depths = vec![0; skeleton.bones.len()];
                            let place = |frame: usize| -> Posture {
                                let at = carried.tracks.iter().filter_map(|t| t.frames.get(frame)?.points.first());
                                Posture { joints: at.copied().collect(), depths: depths.clone(), moved: Vec::new() }
                            };
                            let postures = (0..carried.frames).map(place).collect();
                            Take::by_deformer(character, &**other, carried.fps, postures, stage.part(0.1, 1.0))?
                        }
                    }
                }
            };
            let report = json!({
                "character": {
                    "size": character.size,
                    "vertices": character.mesh.points.len(),
                    "triangles": character.mesh.triangles.len(),
                    "joints": skeleton.joints.len(),
                    "bones": skeleton.bones.len(),
                },
                "frames": take.frames.len(),
                "fps": take.fps,
                "followed": followed,
                "warnings": warnings,
                "timings": { "posing": began.elapsed().as_secs_f64() },
            });
            let played = Played::new(drawn.clone(), take, report.to_string());
            Ok(Product { take: Part::Made(Arc::new(played)), ..Product::default() })
        }))
    }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_take_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_desc_init(desc: *mut mry_take_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a take info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_take_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_info_init(info: *mut mry_take_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Starts making a take. Gives a take.
///
/// @param context  The context.
/// @param desc     What to make it of.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (area, poses and a motion, what mry_motion_retarget refuses of its description),
///         MRY_E_INPUT (a map that is not readable), MRY_E_UNSUPPORTED (no such deformer), MRY_E_NON_FINITE,
///         MRY_E_STRUCT_SIZE, MRY_E_STRING, MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_take(
    context: *mut mry_context,
    desc: *const mry_take_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.take_work(desc)?;
        out.set(call.keep_job(&call.start("take", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Makes a take, and returns when it is done. Work that was started before comes first.
///
/// @param context   The context.
/// @param desc      What to make it of.
/// @param out_take  The take.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_take and mry_job_wait return; MRY_E_INPUT (poses without a key, a motion that
///         matches nothing).
/// Lifetime: until mry_take_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_take(
    context: *mut mry_context,
    desc: *const mry_take_desc,
    out_take: *mut mry_take,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_take, "out_take")?;
        let work = call.take_work(desc)?;
        let (_, job) = call.run("take", work)?;
        job.take(|p| &mut p.take, |take| call.keep_take(take).map(|id| out.set(id)))
    })
}

/// Destroys a take.
///
/// @param context  The context.
/// @param take     The take; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_destroy(context: *mut mry_context, take: mry_take) -> mry_status {
    ending!(context, |call| {
        if take.v != 0 {
            call.context.takes.remove(take.v, "take")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// What a take is: counts, rate and bounds.
///
/// @param context   The context.
/// @param take      The take.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_get_info(
    context: *mut mry_context,
    take: mry_take,
    out_info: *mut mry_take_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let played = call.take(take)?;
        let character = &played.drawn.character;
        let (low, high) = played.take.bounds().unwrap_or_default();
        let at = |p: marey::Vec2| mry_point { x: p.x, y: p.y };
        out.set(&mry_take_info {
            struct_size: 0,
            joint_count: character.skeleton.joints.len() as u32,
            bone_count: character.skeleton.bones.len() as u32,
            reserved0: 0,
            vertex_count: character.mesh.points.len() as u64,
            frame_count: played.take.frames.len() as u64,
            fps: played.take.fps,
            low: at(low),
            high: at(high),
        });
        Ok(Code::MRY_OK)
    })
}

/// Where the mesh's vertices are in a frame.
///
/// @param context    The context.
/// @param take       The take.
/// @param frame      Which, below frame_count.
/// @param points     Where they go; NULL with capacity 0 to ask for the count.
/// @param capacity   Points that fit.
/// @param out_count  Vertices of the mesh.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_read_points(
    context: *mut mry_context,
    take: mry_take,
    frame: u64,
    points: *mut mry_point,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let points = List::new(points, capacity, out_count, "points")?;
        let played = call.take(take)?;
        let frames = &played.take.frames;
        points.fill(&points_out(&frames[frame_index(frame, frames.len())?].points))
    })
}

/// Where the joints are in a frame.
///
/// @param context    The context.
/// @param take       The take.
/// @param frame      Which, below frame_count.
/// @param joints     Where they go; NULL with capacity 0 to ask for the count.
/// @param capacity   Joints that fit.
/// @param out_count  Joints of the character.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_read_joints(
    context: *mut mry_context,
    take: mry_take,
    frame: u64,
    joints: *mut mry_point,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let joints = List::new(joints, capacity, out_count, "joints")?;
        let played = call.take(take)?;
        let frames = &played.take.frames;
        joints.fill(&points_out(&frames[frame_index(frame, frames.len())?].joints))
    })
}

/// How near to the viewer each bone's region is in a frame; larger is nearer.
///
/// @param context    The context.
/// @param take       The take.
/// @param frame      Which, below frame_count.
/// @param depths     Where they go; NULL with capacity 0 to ask for the count.
/// @param capacity   Depths that fit.
/// @param out_count  Bones of the character.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_read_depths(
    context: *mut mry_context,
    take: mry_take,
    frame: u64,
    depths: *mut i32,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let depths = List::new(depths, capacity, out_count, "depths")?;
        let played = call.take(take)?;
        let frames = &played.take.frames;
        depths.fill(&frames[frame_index(frame, frames.len())?].depths)
    })
}

/// What pictures of a take show: the same rectangle in every frame.
///
/// @param context     The context.
/// @param take        The take.
/// @param scale       Pixels a pixel of the drawing; 0 for 1.
/// @param crop        1 to cut pictures to the drawing's; 0 to show all of every frame.
/// @param out_width   Pixels across.
/// @param out_height  Pixels down.
/// @param out_corner  Where their left upper corner lies, in pixels of the drawing; or NULL.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (scale, crop), MRY_E_NON_FINITE, MRY_E_LIMIT (larger than pictures may be).
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_measure(
    context: *mut mry_context,
    take: mry_take,
    scale: f32,
    crop: u32,
    out_width: *mut u32,
    out_height: *mut u32,
    out_corner: *mut mry_point,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (width, height) = (Out::new(out_width, "out_width")?, Out::new(out_height, "out_height")?);
        let corner = Out::optional(out_corner, "out_corner")?;
        let canvas = call.take(take)?.canvas(scale, crop)?;
        width.set(canvas.size.0);
        height.set(canvas.size.1);
        let at = canvas.origin.as_vec2() / canvas.scale;
        corner.inspect(|out| out.set(mry_point { x: at.x, y: at.y }));
        Ok(Code::MRY_OK)
    })
}

/// Draws a frame: 4 bytes a pixel, red, green, blue, sRGB, and alpha, which the others are not multiplied by. The same
/// pixels as in files.
///
/// @param context       The context.
/// @param take          The take, of a character with its picture.
/// @param frame         Which, below frame_count.
/// @param scale         Pixels a pixel of the drawing; 0 for 1.
/// @param crop          1 to cut the picture to the drawing's; 0 to show all of every frame.
/// @param pixels        Where the rows go: 4 * width bytes each, as mry_take_measure says.
/// @param capacity      Bytes at pixels: at least stride_bytes * (height - 1) + 4 * width.
/// @param stride_bytes  From one row's start to the next's; 0 for rows without gaps. Bytes in gaps are left alone.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame, scale, crop, stride_bytes), MRY_E_INPUT (no picture), MRY_E_NON_FINITE,
///         MRY_E_LIMIT, MRY_E_BUFFER_TOO_SMALL.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_draw_frame(
    context: *mut mry_context,
    take: mry_take,
    frame: u64,
    scale: f32,
    crop: u32,
    pixels: *mut u8,
    capacity: usize,
    stride_bytes: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.context.refuse_callbacks()?;
        let rows = Rows::new(pixels, capacity, stride_bytes, "pixels")?;
        let played = call.take(take)?;
        let frames = &played.take.frames;
        let frame = &frames[frame_index(frame, frames.len())?];
        let canvas = played.canvas(scale, crop)?;
        let row = 4 * canvas.size.0 as usize;
        rows.fits(row, canvas.size.1 as usize)?;
        let draw = || -> marey::Result<RgbaImage> {
            let cut = match played.cut.get() {
                Some(cut) => cut,
                None => {
                    let cut = cut_out(played.drawn.picture()?)?;
                    played.cut.get_or_init(|| cut)
                }
            };
            let drawing = Drawing::new(&played.drawn.character, cut, canvas.scale)?;
            Ok(drawing.draw(frame, &canvas, [0; 4]))
        };
        rows.write(call.context.executor.run(draw)?.as_raw(), row)?;
        Ok(Code::MRY_OK)
    })
}

/// The report of the job that made the take, as JSON: counts, seconds, warnings, and with a motion which joint followed
/// what of it.
///
/// @param context   The context.
/// @param take      The take.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_take_get_report(
    context: *mut mry_context,
    take: mry_take,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        text.fill(&call.take(take)?.report)
    })
}
