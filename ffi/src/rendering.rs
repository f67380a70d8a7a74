//! Rendering. Pictures of creatures and crowds from any side, and animations of them, drawn on a GPU or without one. Yaw is degrees to the right around what is looked
//! at, pitch degrees from above.
//!
//! A context opens a GPU when it is first needed, which may take a good part of a second, and keeps it; one that is lost
//! is opened anew by the next call.

use std::ffi::c_char;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use marey::Error;
use marey::clip::Clip;
use marey::export::animation::AnimationFormat;
use marey::export::write_picture;
use marey::job::{Progress, Stage};
use marey::raster::Mask;
use marey_render::{Adapter, Camera, Film, InClip, Lens, Picture, Renderer, Scene, Style};
use serde_json::json;

use crate::border::{self, List, Out, Text, Versioned};
use crate::clip::{frame_index, mry_clip};
use crate::context::mry_context;
use crate::creature::mry_creature;
use crate::crowd::mry_crowd;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::masks::mry_masks;
use crate::running::{Product, Work};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Who draws: a GPU where there is one, else the CPU.
pub const MRY_ADAPTER_AUTO: i32 = 0;
/// Who draws: a GPU, or one that a driver simulates; where there is none, MRY_E_GPU.
pub const MRY_ADAPTER_GPU: i32 = 1;
/// Who draws: the CPU.
pub const MRY_ADAPTER_CPU: i32 = 2;

/// What is shown: the texture's colours as they are.
pub const MRY_STYLE_TEXTURED: i32 = 0;
/// What is shown: the texture under a lamp.
pub const MRY_STYLE_SHADED: i32 = 1;
/// What is shown: the edges of the triangles.
pub const MRY_STYLE_WIREFRAME: i32 = 2;
/// What is shown: how far the surface is from the bones that move it, dark for thin, bright for thick.
pub const MRY_STYLE_RADIUS: i32 = 3;
/// What is shown: which bones move the surface, and the bones themselves.
pub const MRY_STYLE_BONES: i32 = 4;
/// What is shown: how near it is, white for nearest.
pub const MRY_STYLE_DEPTH: i32 = 5;
/// What is shown: where the surface faces, red to the right, green up, blue to the viewer.
pub const MRY_STYLE_NORMALS: i32 = 6;

/// Where the camera is: far enough from yaw and pitch to show the whole animation.
pub const MRY_CAMERA_FITTED: i32 = 0;
/// Where the camera is: over the clip, so that a picture of the clip's size lies on its frames pixel by pixel. Yaw, pitch
/// and fov are not looked at.
pub const MRY_CAMERA_CLIP: i32 = 1;
/// Where the camera is: around target, at distance, or with height.
pub const MRY_CAMERA_PLACED: i32 = 2;

/// No file has more pictures: over an hour at 24 a second.
const MOST_FRAMES: usize = 100_000;

/// A camera. Start from MRY_CAMERA_INIT.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_camera {
    /// sizeof(mry_camera).
    pub struct_size: u32,
    /// MRY_CAMERA_FITTED, ...
    pub kind: i32,
    /// Degrees around the target, to the right.
    pub yaw: f32,
    /// Degrees above it; 90 looks straight down.
    pub pitch: f32,
    /// Degrees between bottom and top; 0 to look in parallel.
    pub fov: f32,
    /// With MRY_CAMERA_PLACED and fov: world units from the eye to the target.
    pub distance: f32,
    /// With MRY_CAMERA_PLACED and no fov: world units that are as high as the picture.
    pub height: f32,
    /// With MRY_CAMERA_PLACED: the place in the middle of the picture: x, y, z.
    pub target: [f32; 3],
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_camera {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_camera>() == 40);

/// What a picture is like. Start from MRY_RENDER_DESC_INIT; zero shows the creature's first frame and its textures on
/// nothing, at the clip's size.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_render_desc {
    /// sizeof(mry_render_desc).
    pub struct_size: u32,
    /// Pixels across; 0 for the clip's.
    pub width: u32,
    /// Pixels down; 0 for the clip's.
    pub height: u32,
    /// MRY_STYLE_TEXTURED, ...
    pub style: i32,
    /// MRY_ADAPTER_AUTO, ...
    pub adapter: i32,
    /// 1 to draw without smooth edges; 0 for four samples a pixel.
    pub hard_edges: u32,
    /// How dark the shadow on the floor is, 0 for none to 1.
    pub shadow: f32,
    /// What lies behind: red, green, blue, alpha.
    pub background: [u8; 4],
    /// The frame; of an animation the first.
    pub frame: u64,
    /// From where; NULL for fitted from the front.
    pub camera: *const mry_camera,
    /// What stands in the picture; {0} for the creature alone.
    pub crowd: mry_crowd,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and pointers that the host vouches for.
unsafe impl Versioned for mry_render_desc {
    const FIRST_SIZE: usize = 56;
}
const _: () = assert!(size_of::<mry_render_desc>() == 56);

/// What a rendered file is like. Start from MRY_RENDER_FILE_DESC_INIT; creature and path must be set.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_render_file_desc {
    /// sizeof(mry_render_file_desc).
    pub struct_size: u32,
    /// 1 to show one frame all the time, 0 to let the creature move.
    pub still: u32,
    /// The creature.
    pub creature: mry_creature,
    /// The file or folder.
    pub path: mry_str,
    /// "png", "png-dir", "sprite-sheet", "gif", "apng", "webp" or "mp4"; empty to go by the path's ending, where .png is one
    /// picture where there is one frame, else an animated PNG, and no ending a folder of PNG pictures.
    pub format: mry_str,
    /// What the pictures are like; NULL for all zero.
    pub picture: *const mry_render_desc,
    /// How many pictures; 0 for as many as the animation has.
    pub frame_count: u64,
    /// Pictures a second; 0 for the creature's.
    pub fps: f64,
    /// How often the camera goes around, to the right: 1 is a turntable that closes.
    pub turns: f32,
    /// With a clip: 1 to draw the crowd alone, on nothing, with what hides it cut out.
    pub alone: u32,
    /// With a crowd: the clip to put it back into, seen as it was filmed; {0} for none. Size, camera, background, shadow,
    /// frame_count, fps and turns are not looked at.
    pub clip: mry_clip,
    /// With a clip: masks of who was filmed, who hides what is behind it (z below 0); {0} for none.
    pub masks: mry_masks,
    /// The same as a clip of pictures that are bright where who was filmed is, such as the masks/ of a creature's folder;
    /// {0} for none.
    pub mask_clip: mry_clip,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and strings and a pointer that the host vouches for.
unsafe impl Versioned for mry_render_file_desc {
    const FIRST_SIZE: usize = 104;
}
const _: () = assert!(size_of::<mry_render_file_desc>() == 104);

/// The renderers of a context, each made when first needed.
#[derive(Default)]
pub(crate) struct Renderers(Mutex<[Option<Arc<Renderer>>; 3]>);

impl Renderers {
    /// Those that were made for this; a new one where there is none, or where its device is gone.
    fn get(&self, adapter: Adapter) -> marey::Result<Arc<Renderer>> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let held = &mut all[adapter as usize];
        match held {
            Some(renderer) if !renderer.is_lost() => Ok(renderer.clone()),
            _ => Ok(held.insert(Arc::new(Renderer::new(adapter)?)).clone()),
        }
    }
}

/// What the device says is not what a plugin says.
fn of_gpu(error: Error) -> Error {
    match error {
        Error::Helper { what, problem, remedy, code: 0 } => {
            Error::Helper { what, problem, remedy, code: Code::MRY_E_GPU as i32 }
        }
        other => other,
    }
}

fn adapter(adapter: i32) -> Outcome<Adapter> {
    match adapter {
        MRY_ADAPTER_AUTO => Ok(Adapter::Auto),
        MRY_ADAPTER_GPU => Ok(Adapter::Gpu),
        MRY_ADAPTER_CPU => Ok(Adapter::Cpu),
        _ => Err(Failure::argument("adapter", format!("adapter is {adapter}, which is no MRY_ADAPTER"))),
    }
}

fn style(style: i32) -> Outcome<Style> {
    let none = || Failure::argument("desc.style", format!("desc.style is {style}, which is no MRY_STYLE"));
    Ok(usize::try_from(style).ok().and_then(|style| Style::ALL.get(style)).ok_or_else(none)?.0)
}

/// From where a picture is taken, once it is known how far the scene reaches.
#[derive(Clone, Copy)]
enum Viewpoint {
    Fitted { yaw: f32, pitch: f32, fov: Option<f32> },
    Clip((u32, u32)),
    Placed(Camera),
}

impl Viewpoint {
    fn camera(&self, scene: &Scene, size: (u32, u32), turning: bool, stage: Stage<'_>) -> marey::Result<Camera> {
        Ok(match *self {
            Self::Placed(camera) => camera,
            Self::Clip(clip) => Camera::of_clip(clip, size),
            Self::Fitted { yaw, pitch, fov } => {
                let extent = scene.extent(stage)?;
                let fit = if turning { Camera::turning } else { Camera::around };
                fit(&extent, yaw, pitch, fov, size)
            }
        })
    }
}

/// What is to be drawn.
struct Shot {
    adapter: Adapter,
    scene: Scene,
    frame: usize,
    from: Viewpoint,
    /// But for the camera.
    picture: Picture,
}

impl Shot {
    fn draw(&self, renderer: &Renderer, stage: Stage<'_>) -> marey::Result<image::RgbaImage> {
        let camera = self.from.camera(&self.scene, self.picture.size, false, stage)?;
        renderer.draw(&self.scene, self.frame, &Picture { camera, ..self.picture }, stage)
    }
}

impl Call<'_> {
    /// # Safety
    /// By the header's contract pointers in the description are NULL or valid; see `entry`.
    unsafe fn shot(&self, creature: mry_creature, desc: &mry_render_desc) -> Outcome<Shot> {
        let (clip, scene) = if desc.crowd.v == 0 {
            let own = self.creature(creature)?;
            (own.model().size, Scene::of(own.drawable()?))
        } else {
            let crowd = self.crowd(desc.crowd).map_err(|e| e.about("desc.crowd"))?;
            (crowd.crowd.size, crowd.scene()?)
        };
        let style = style(desc.style)?;
        if desc.hard_edges > 1 {
            return Err(Failure::argument(
                "desc.hard_edges",
                format!("desc.hard_edges is {}; give 0 or 1", desc.hard_edges),
            ));
        }
        let size = match (desc.width, desc.height) {
            (0, 0) => clip,
            size => size,
        };
        let from = if desc.camera.is_null() {
            Viewpoint::Fitted { yaw: 0.0, pitch: 0.0, fov: None }
        } else {
            // SAFETY: as this function's own.
            seen_from(&unsafe { border::read(desc.camera, "desc.camera")? }, clip)?
        };
        let frame = frame_index(desc.frame, scene.frames)?;
        let picture = Picture {
            style,
            background: desc.background,
            smooth: desc.hard_edges == 0,
            shadow: desc.shadow,
            // Replaced before anything is drawn.
            ..Picture::new(size, Camera::of_clip(clip, size))
        };
        Ok(Shot { adapter: adapter(desc.adapter)?, scene, frame, from, picture })
    }

    fn renderer(&self, adapter: Adapter) -> Outcome<Arc<Renderer>> {
        Ok(self.context.renderers.get(adapter).map_err(of_gpu)?)
    }

    unsafe fn render_work(&self, desc: *const mry_render_file_desc) -> Outcome<Work> {
        // SAFETY: by the header's contract, as for all descriptions; see `entry`.
        let desc = unsafe { border::read(desc, "desc")? };
        if desc.alone > 1 {
            return Err(Failure::argument("desc.alone", format!("desc.alone is {}; give 0 or 1", desc.alone)));
        }
        // SAFETY: as above.
        let (path, format) = unsafe { (desc.path.name("desc.path")?, desc.format.text("desc.format")?) };
        if desc.still > 1 {
            return Err(Failure::argument("desc.still", format!("desc.still is {}; give 0 or 1", desc.still)));
        }
        if !(desc.fps.is_finite() && desc.turns.is_finite()) {
            let message = format!("desc.fps is {}, desc.turns is {}", desc.fps, desc.turns);
            return Err(Failure::new(Code::MRY_E_NON_FINITE, "desc.fps", message));
        }
        let picture = if desc.picture.is_null() {
            // SAFETY: zero is a valid value of each of its fields.
            unsafe { std::mem::zeroed() }
        } else {
            // SAFETY: as above.
            unsafe { border::read(desc.picture, "desc.picture")? }
        };
        if desc.clip.v != 0 {
            return self.clip_work(&desc, &picture, path, format);
        }
        // SAFETY: as above.
        let shot = unsafe { self.shot(desc.creature, &picture)? };
        let frames = match desc.frame_count {
            0 => shot.scene.frames,
            frames => usize::try_from(frames).unwrap_or(usize::MAX),
        };
        if frames > MOST_FRAMES {
            let message = format!("desc.frame_count is {frames}, and at most {MOST_FRAMES} are allowed");
            return Err(Failure::new(Code::MRY_E_LIMIT, "desc.frame_count", message));
        }
        let fps = if desc.fps == 0.0 { shot.scene.fps } else { desc.fps };
        let plays = desc.still == 0;
        let film = Film { picture: shot.picture, frames, fps, first: shot.frame, plays, turns: desc.turns };
        let path = PathBuf::from(path);
        let format = format_of(format, &path, frames)?;
        let renderer = self.renderer(shot.adapter)?;
        Ok(Box::new(move |progress| {
            let began = std::time::Instant::now();
            let stage = progress.whole();
            stage.name("rendering")?;
            let files = match format {
                None => {
                    write_picture(&path, &shot.draw(&renderer, stage).map_err(of_gpu)?)?;
                    vec![path]
                }
                Some(format) => {
                    let turning = film.turns != 0.0;
                    let camera = shot.from.camera(&shot.scene, film.picture.size, turning, stage.part(0.0, 0.02))?;
                    let film = Film { picture: Picture { camera, ..film.picture }, ..film };
                    let rest = stage.part(0.02, 1.0);
                    film.write(&renderer, &shot.scene, &path, format, rest).map_err(of_gpu)?
                }
            };
            let report = report_of(&files, film.frames, film.fps, film.picture.size, &renderer, began);
            Ok(Product { report: Some(report), ..Product::default() })
        }))
    }

    /// Puts a crowd back into a clip.
    fn clip_work(
        &self,
        desc: &mry_render_file_desc,
        picture: &mry_render_desc,
        path: &str,
        format: &str,
    ) -> Outcome<Work> {
        let crowd = self.crowd(picture.crowd).map_err(|e| e.about("desc.picture.crowd"))?;
        let clip = self.clip(desc.clip, "desc.clip")?;
        let masks = if desc.masks.v == 0 { Vec::new() } else { self.masks(desc.masks)?.masks.clone() };
        let painted = if desc.mask_clip.v == 0 { None } else { Some(self.clip(desc.mask_clip, "desc.mask_clip")?) };
        let style = style(picture.style)?;
        let path = PathBuf::from(path);
        let format = AnimationFormat::choose(Some(format).filter(|n| !n.is_empty()), &path)
            .map_err(|e| Failure::from(e).about("desc.format"))?;
        let renderer = self.renderer(adapter(picture.adapter)?)?;
        let alone = desc.alone == 1;
        let still = match desc.still {
            1 => Some(frame_index(picture.frame, crowd.crowd.frames)?),
            _ => None,
        };
        Ok(Box::new(move |progress| {
            let began = std::time::Instant::now();
            let stage = progress.whole();
            stage.name("rendering")?;
            let masks = match painted {
                Some(painted) => masks_of(&painted, crowd.crowd.frames)?,
                None => masks,
            };
            let mut film = InClip::new(&crowd.crowd, clip, masks)?;
            (film.picture.style, film.alone, film.still) = (style, alone, still);
            let files = film.write(&renderer, &path, format, stage).map_err(of_gpu)?;
            let report = report_of(&files, film.frames(), crowd.crowd.fps, film.picture.size, &renderer, began);
            Ok(Product { report: Some(report), ..Product::default() })
        }))
    }
}

/// Masks from pictures: bright is inside.
pub(crate) fn masks_of(clip: &Clip, frames: usize) -> marey::Result<Vec<Mask>> {
    let mask = |frame: usize| {
        let picture = clip.frame(frame)?;
        Ok(Mask::from_image(&image::imageops::grayscale(&picture.rgb)))
    };
    (0..frames.min(clip.info().frames)).map(mask).collect()
}

/// What a job's report says of what it drew.
fn report_of(
    files: &[PathBuf],
    frames: usize,
    fps: f64,
    size: (u32, u32),
    renderer: &Renderer,
    began: std::time::Instant,
) -> String {
    json!({
        "files": files, "frames": frames, "fps": fps, "size": [size.0, size.1],
        "renderer": renderer.describe(), "timings": { "rendering": began.elapsed().as_secs_f64() },
    })
    .to_string()
}

fn seen_from(camera: &mry_camera, clip: (u32, u32)) -> Outcome<Viewpoint> {
    let numbers = [camera.yaw, camera.pitch, camera.fov, camera.distance, camera.height];
    if !numbers.iter().chain(&camera.target).all(|n| n.is_finite()) {
        return Err(Failure::new(Code::MRY_E_NON_FINITE, "desc.camera", "desc.camera has a number that is none"));
    }
    let fov = (camera.fov != 0.0).then_some(camera.fov);
    if fov.is_some_and(|fov| !(1.0..=170.0).contains(&fov)) {
        let message = format!("desc.camera.fov is {} degrees; give 1 to 170, or 0 to look in parallel", camera.fov);
        return Err(Failure::argument("desc.camera", message));
    }
    let (yaw, pitch) = (camera.yaw, camera.pitch);
    match camera.kind {
        MRY_CAMERA_FITTED => Ok(Viewpoint::Fitted { yaw, pitch, fov }),
        MRY_CAMERA_CLIP => Ok(Viewpoint::Clip(clip)),
        MRY_CAMERA_PLACED => {
            let lens = match fov {
                Some(fov) => Lens::Perspective { fov, distance: camera.distance },
                None => Lens::Parallel { height: camera.height },
            };
            let camera = Camera { yaw, pitch, target: camera.target.into(), lens };
            camera.validate().map_err(|e| Failure::argument("desc.camera", e.to_string()))?;
            Ok(Viewpoint::Placed(camera))
        }
        kind => Err(Failure::argument("desc.camera", format!("desc.camera.kind is {kind}, which is no MRY_CAMERA"))),
    }
}

/// The format of a file; `None` for one PNG picture.
fn format_of(name: &str, path: &Path, frames: usize) -> Outcome<Option<AnimationFormat>> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let one = name == "png" || (name.is_empty() && frames == 1 && ending.as_deref() == Some("png"));
    if one {
        return Ok(None);
    }
    let format = AnimationFormat::choose(Some(name).filter(|n| !n.is_empty()), path);
    format.map(Some).map_err(|e| Failure::from(e).about("desc.format"))
}

/// Fills in a camera with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param camera  Where to write; NULL does nothing.
/// @param size    sizeof(mry_camera) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_camera_init(camera: *mut mry_camera, size: u32) {
    // SAFETY: the caller owns `size` bytes at `camera`, or passes NULL.
    unsafe { border::init(camera.cast(), size) }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_render_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_render_desc_init(desc: *mut mry_render_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Fills in a description with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param desc  Where to write; NULL does nothing.
/// @param size  sizeof(mry_render_file_desc) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_render_file_desc_init(desc: *mut mry_render_file_desc, size: u32) {
    // SAFETY: the caller owns `size` bytes at `desc`, or passes NULL.
    unsafe { border::init(desc.cast(), size) }
}

/// Who draws for this choice of adapter, such as "NVIDIA H100 (vulkan)" or "CPU". Opens a GPU that was not needed before.
///
/// @param context   The context.
/// @param adapter   MRY_ADAPTER_AUTO, ...
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (adapter), MRY_E_GPU, MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_context_get_renderer(
    context: *mut mry_context,
    adapter: i32,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        text.fill(&call.renderer(self::adapter(adapter)?)?.describe())
    })
}

/// Draws a picture of a creature: RGBA, 8 bits a channel, sRGB, rows from the top without gaps; colours are not multiplied
/// by alpha.
///
/// @param context    The context.
/// @param creature   The creature.
/// @param desc       What the picture is like; NULL for all zero.
/// @param pixels     Where the rows go; NULL with capacity 0 to ask for the size, for which nothing is drawn.
/// @param capacity   Bytes at pixels.
/// @param out_count  Bytes needed: 4 * width * height.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL, MRY_E_ARGUMENT (style, adapter, hard_edges, camera, frame), MRY_E_NON_FINITE,
///         MRY_E_INPUT (the size, the shadow, more than the GPU draws), MRY_E_LIMIT, MRY_E_GPU, MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_creature_render(
    context: *mut mry_context,
    creature: mry_creature,
    desc: *const mry_render_desc,
    pixels: *mut u8,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let list = List::new(pixels, capacity, out_count, "pixels")?;
        let desc = if desc.is_null() { std::mem::zeroed() } else { border::read(desc, "desc")? };
        let shot = call.shot(creature, &desc)?;
        let (width, height) = shot.picture.size;
        list.fits(4 * width as usize * height as usize)?;
        let renderer = call.renderer(shot.adapter)?;
        let progress = Progress::new();
        let drawn = call.context.executor.run(|| shot.draw(&renderer, progress.whole()));
        list.fill(drawn.map_err(of_gpu)?.as_raw())
    })
}

/// Starts drawing a creature into a file: a picture, an animation, or both with the camera going around. The file or
/// folder appears whole or not at all. There is nothing to take; mry_job_get_report names the files and who drew.
///
/// @param context  The context.
/// @param desc     What to draw, and where to.
/// @param out_job  The job.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (still, path, and as mry_creature_render), MRY_E_INPUT (no such format),
///         MRY_E_NON_FINITE, MRY_E_LIMIT, MRY_E_GPU, MRY_E_STRUCT_SIZE, MRY_E_STRING.
/// Lifetime: until mry_job_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_job_start_render(
    context: *mut mry_context,
    desc: *const mry_render_file_desc,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.render_work(desc)?;
        out.set(call.keep_job(&call.start("render", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Draws a creature into a file, and returns when it is done. Work that was started before comes first.
///
/// @param context  The context.
/// @param desc     What to draw, and where to.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; what mry_job_start_render and mry_job_wait return; MRY_E_INPUT (the size, the shadow, what the format
///         cannot hold), MRY_E_IO.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_run_render(
    context: *mut mry_context,
    desc: *const mry_render_file_desc,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let work = call.render_work(desc)?;
        call.run("render", work).map(|(code, _)| code)
    })
}
