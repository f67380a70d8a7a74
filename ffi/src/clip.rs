//! Clips. A clip is a video, read-only: a video file, an animated image, or a folder of numbered images. Frames are
//! decoded when asked for and count from 0. Pixels: x right, y down, the centre of the top-left pixel is (0.5, 0.5).

use std::ffi::c_char;
use std::sync::Arc;

use marey::clip::{Clip, ClipOptions, Picture};

use crate::border::{self, Out, OutStruct, Text, Versioned};
use crate::context::{Context, MRY_LOG_WARNING, mry_context};
use crate::error::{Failure, Outcome, copy_text, mry_error};
use crate::guard::{Call, ending, entry};
use crate::rows::Rows;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;

pub(crate) type ClipTable = Table<Arc<Clip>>;

/// An open clip.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_clip {
    /// The id; 0 is no clip.
    pub v: u64,
}

/// How to open a clip. Start from MRY_CLIP_OPTIONS_INIT.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_clip_options {
    /// sizeof(mry_clip_options).
    pub struct_size: u32,
    /// 1 to start no other program; 0 to ask ffmpeg for formats that the library does not decode itself.
    pub no_ffmpeg: u32,
    /// The ffmpeg program: a path, or a name that the system looks up; empty for "ffmpeg".
    pub ffmpeg: mry_str,
    /// Bytes of decoded frames that are kept; 0 for 256 MB.
    pub cache_bytes: u64,
    /// Pixels of one frame, at most; 0 for 64 million.
    pub max_pixels: u64,
    /// Frames a second of a folder of images, which cannot say; 0 for 24.
    pub images_fps: f64,
}

// SAFETY: repr(C), starts with its u32 size; numbers, and a string that the host vouches for.
unsafe impl Versioned for mry_clip_options {
    const FIRST_SIZE: usize = 48;
}
const _: () = assert!(size_of::<mry_clip_options>() == 48);

/// What a clip is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_clip_info {
    /// sizeof(mry_clip_info).
    pub struct_size: u32,
    /// Pixels across, after rotation.
    pub width: u32,
    /// Pixels down, after rotation.
    pub height: u32,
    /// How many warnings mry_clip_get_warning has.
    pub warning_count: u32,
    /// How many frames can be read.
    pub frame_count: u64,
    /// Mean frames a second.
    pub fps: f64,
    /// What reads it: "mp4", "gif", "apng", "webp", "images", "ffmpeg"; NUL-terminated.
    pub source: [c_char; 16],
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_clip_info {
    const FIRST_SIZE: usize = 48;
}
const _: () = assert!(size_of::<mry_clip_info>() == 48);

impl Call<'_> {
    pub(crate) fn clip(&self, clip: mry_clip, param: &'static str) -> Outcome<Arc<Clip>> {
        Ok(self.get(&self.context.clips, clip.v, param)?.value.clone())
    }

    /// A frame that fits into rows of so many bytes a pixel, and how many bytes those have.
    fn decoded(&self, clip: mry_clip, frame: u64, bytes: usize, rows: &Rows) -> Outcome<(Arc<Picture>, usize)> {
        let clip = self.clip(clip, "clip")?;
        let info = clip.info();
        let row_bytes = bytes * info.width as usize;
        let frame = frame_index(frame, info.frames)?;
        rows.fits(row_bytes, info.height as usize)?;
        let picture = clip.frame(frame).map_err(|e| Failure::from(e).about("clip"))?;
        Ok((picture, row_bytes))
    }

    pub(crate) fn keep_clip(&self, clip: Arc<Clip>) -> Outcome<mry_clip> {
        for warning in &clip.info().warnings {
            self.context.log(MRY_LOG_WARNING, &format!("{}: {warning}", clip.name().display()));
        }
        let (frames, most) = (clip.info().frames as u64, self.context.limits.frames);
        if frames > most {
            let message = format!("the clip has {frames} frames, and at most {most} are allowed; cut it");
            return Err(Failure::new(Code::MRY_E_LIMIT, "path", message));
        }
        Ok(mry_clip { v: self.context.clips.insert(clip)? })
    }
}

/// An index of a frame, within `count`.
pub(crate) fn frame_index(frame: u64, count: usize) -> Outcome<usize> {
    let inside = usize::try_from(frame).ok().filter(|f| *f < count);
    inside.ok_or_else(|| Failure::argument("frame", format!("frame is {frame}, and there are {count}, counted from 0")))
}

/// # Safety
/// The string is valid, as the header asks.
unsafe fn clip_options(options: &mry_clip_options) -> Outcome<ClipOptions> {
    let mut answer = ClipOptions::default();
    // SAFETY: as this function's own.
    let ffmpeg = if options.ffmpeg.len == 0 { None } else { Some(unsafe { options.ffmpeg.name("options.ffmpeg")? }) };
    match (options.no_ffmpeg, ffmpeg) {
        (0, None) => {}
        (0, Some(program)) => answer.ffmpeg = Some(program.into()),
        (1, _) => answer.ffmpeg = None,
        (other, _) => {
            return Err(Failure::argument("options", format!("options.no_ffmpeg is {other}, and must be 0 or 1")));
        }
    }
    if options.cache_bytes > 0 {
        answer.cache_bytes = usize::try_from(options.cache_bytes).unwrap_or(usize::MAX);
    }
    if options.max_pixels > 0 {
        answer.max_pixels = options.max_pixels;
    }
    let fps = options.images_fps;
    if !fps.is_finite() {
        return Err(Failure::new(Code::MRY_E_NON_FINITE, "options", format!("options.images_fps is {fps}")));
    }
    if fps < 0.0 {
        return Err(Failure::argument("options", format!("options.images_fps is {fps}, and must be above 0")));
    }
    if fps > 0.0 {
        answer.images_fps = fps;
    }
    Ok(answer)
}

/// The options, or the defaults for NULL.
///
/// # Safety
/// As for [`border::read`], and the string in it is valid, as the header asks.
pub(crate) unsafe fn options_in(options: *const mry_clip_options, context: &Context) -> Outcome<ClipOptions> {
    let asked = if options.is_null() {
        ClipOptions::default()
    } else {
        // SAFETY: as this function's own.
        unsafe { clip_options(&border::read(options, "options")?)? }
    };
    Ok(context.clip_options(asked))
}

/// Fills in clip options with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param options  Where to write; NULL does nothing.
/// @param size     sizeof(mry_clip_options) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_options_init(options: *mut mry_clip_options, size: u32) {
    // SAFETY: the caller owns `size` bytes at `options`, or passes NULL.
    unsafe { border::init(options.cast(), size) }
}

/// Fills in a clip info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_clip_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_info_init(info: *mut mry_clip_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Opens a video file or a folder of numbered images. A file that breaks off is opened up to there, with a warning.
///
/// @param context   The context.
/// @param path      The file or folder.
/// @param options   How to open it; NULL for the defaults.
/// @param out_clip  The clip.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT (not a clip, or broken from the start), MRY_E_LIMIT, MRY_E_IO,
///         MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_clip_close or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_open(
    context: *mut mry_context,
    path: mry_str,
    options: *const mry_clip_options,
    out_clip: *mut mry_clip,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_clip, "out_clip")?;
        let options = options_in(options, call.context)?;
        let clip = Clip::open_with(path, &options).map_err(|e| Failure::from(e).about("path"))?;
        out.set(call.keep_clip(Arc::new(clip))?);
        Ok(Code::MRY_OK)
    })
}

/// Closes a clip. Jobs that were started with it keep what they need.
///
/// @param context  The context.
/// @param clip     The clip; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_close(context: *mut mry_context, clip: mry_clip) -> mry_status {
    ending!(context, |call| {
        if clip.v != 0 {
            call.context.clips.remove(clip.v, "clip")?;
            call.context.footages.forget(clip);
        }
        Ok(Code::MRY_OK)
    })
}

/// What a clip is: size, frames, rate.
///
/// @param context   The context.
/// @param clip      The clip.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_get_info(
    context: *mut mry_context,
    clip: mry_clip,
    out_info: *mut mry_clip_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let clip = call.clip(clip, "clip")?;
        let info = clip.info();
        let mut answer = mry_clip_info {
            struct_size: 0,
            width: info.width,
            height: info.height,
            warning_count: info.warnings.len() as u32,
            frame_count: info.frames as u64,
            fps: info.fps,
            source: [0; 16],
        };
        copy_text(info.source, &mut answer.source);
        out.set(&answer);
        Ok(Code::MRY_OK)
    })
}

/// When a frame is shown.
///
/// @param context      The context.
/// @param clip         The clip.
/// @param frame        Which, counted from 0.
/// @param out_seconds  Seconds from the first frame.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame).
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_get_time(
    context: *mut mry_context,
    clip: mry_clip,
    frame: u64,
    out_seconds: *mut f64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_seconds, "out_seconds")?;
        let clip = call.clip(clip, "clip")?;
        out.set(clip.time(frame_index(frame, clip.info().frames)?)?);
        Ok(Code::MRY_OK)
    })
}

/// One thing that a person should know about the clip, such as "truncated after frame 31".
///
/// @param context   The context.
/// @param clip      The clip.
/// @param index     Which, below warning_count.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (index), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_get_warning(
    context: *mut mry_context,
    clip: mry_clip,
    index: u32,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let clip = call.clip(clip, "clip")?;
        let warnings = &clip.info().warnings;
        let warning = warnings.get(index as usize).ok_or_else(|| {
            Failure::argument("index", format!("index is {index}, and there are {} warnings", warnings.len()))
        })?;
        text.fill(warning)
    })
}

/// Decodes one frame to RGB, 8 bits a channel, sRGB, rows from the top.
///
/// @param context       The context.
/// @param clip          The clip.
/// @param frame         Which, counted from 0.
/// @param pixels        Where the rows go: 3 * width bytes each.
/// @param capacity      Bytes at pixels: at least stride_bytes * (height - 1) + 3 * width.
/// @param stride_bytes  From one row's start to the next's; 0 for rows without gaps. Bytes in gaps are left alone.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame, stride_bytes), MRY_E_BUFFER_TOO_SMALL, MRY_E_INPUT (a broken frame),
///         MRY_E_IO.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_read_frame(
    context: *mut mry_context,
    clip: mry_clip,
    frame: u64,
    pixels: *mut u8,
    capacity: usize,
    stride_bytes: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let rows = Rows::new(pixels, capacity, stride_bytes, "pixels")?;
        let (picture, row_bytes) = call.decoded(clip, frame, 3, &rows)?;
        rows.write(picture.rgb.as_raw(), row_bytes)?;
        Ok(Code::MRY_OK)
    })
}

/// Decodes how opaque one frame is, 8 bits a pixel, 255 for what hides all behind it, rows from the top.
///
/// @param context       The context.
/// @param clip          The clip.
/// @param frame         Which, counted from 0.
/// @param pixels        Where the rows go: width bytes each.
/// @param capacity      Bytes at pixels: at least stride_bytes * (height - 1) + width.
/// @param stride_bytes  From one row's start to the next's; 0 for rows without gaps. Bytes in gaps are left alone.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame, stride_bytes), MRY_E_BUFFER_TOO_SMALL, MRY_E_INPUT (a broken frame),
///         MRY_E_IO.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_clip_read_alpha(
    context: *mut mry_context,
    clip: mry_clip,
    frame: u64,
    pixels: *mut u8,
    capacity: usize,
    stride_bytes: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let rows = Rows::new(pixels, capacity, stride_bytes, "pixels")?;
        let (picture, row_bytes) = call.decoded(clip, frame, 1, &rows)?;
        match &picture.alpha {
            Some(alpha) => rows.write(alpha.as_raw(), row_bytes)?,
            None => rows.write(&vec![255; row_bytes * picture.rgb.height() as usize], row_bytes)?,
        }
        Ok(Code::MRY_OK)
    })
}
