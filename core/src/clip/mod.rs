//! Video in: any clip as frames on demand, behind one type.
//!
//! A [`Clip`] is a video file or a folder of numbered images. Opening it reads only its index; frames are decoded when
//! they are asked for, by decoders that run forward, and kept while they fit a bounded number of bytes. It is judged
//! by its content, never by its name. MP4 and QuickTime with H.264, GIF, APNG, WebP and still images are decoded here;
//! everything else through an ffmpeg program, where there is one.
//!
//! A clip that is damaged is not refused for it: what comes before the break can be read, and
//! [`ClipInfo::warnings`] or the error of the frame says where the break is.

mod animation;
mod cache;
mod ffmpeg;
mod folder;
mod frame_memory;
mod memory;
#[cfg(feature = "h264")]
mod mp4;
mod orientation;
mod pool;
mod source;
mod yuv;

use std::any::Any;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{GrayImage, RgbImage};

pub use self::frame_memory::{FrameBytes, FrameImage, FrameMemory, LentBytes};

use self::cache::Entry;
use self::ffmpeg::NoHelp;
use self::frame_memory::{frame_image, lent_image};
use self::pool::Pool;
use self::source::Source;
use crate::error::{Error, Result};
use crate::job::{Progress, Stage};

/// What a clip is.
#[derive(Clone, Debug)]
pub struct ClipInfo {
    /// Pixels across, after rotation.
    pub width: u32,
    /// Pixels down, after rotation.
    pub height: u32,
    /// How many frames can be read.
    pub frames: usize,
    /// Mean frames a second.
    pub fps: f64,
    /// What reads it: "images", "mp4", "gif", "apng", "webp", "ffmpeg", "memory".
    pub source: &'static str,
    /// What a person should know: "truncated after frame 31".
    pub warnings: Vec<String>,
}

/// One decoded picture.
#[derive(Debug)]
pub struct Picture {
    /// Colours, sRGB.
    pub rgb: FrameImage,
    /// Opacity, where the source has any.
    pub alpha: Option<GrayImage>,
}

impl Picture {
    fn new(rgb: RgbImage, alpha: Option<GrayImage>) -> Self {
        Self { rgb: frame_image(rgb), alpha }
    }

    /// The picture with its colours in memory that is lent, where any is.
    fn lent(self: Arc<Self>, memory: Option<&Arc<dyn FrameMemory>>) -> Result<Arc<Self>> {
        let Some(memory) = memory else { return Ok(self) };
        Ok(Arc::new(Self { rgb: lent_image(&self.rgb, &**memory)?, alpha: self.alpha.clone() }))
    }

    /// Colours and opacity apart; opacity only where any pixel lacks some. `rgba` holds four bytes a pixel.
    fn from_rgba(rgba: &[u8], width: u32, height: u32) -> Self {
        let rgb = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        let opaque = rgba.chunks_exact(4).all(|p| p[3] == 255);
        let alpha = (!opaque).then(|| rgba.chunks_exact(4).map(|p| p[3]).collect());
        let rgb = RgbImage::from_raw(width, height, rgb).unwrap_or_default();
        Self::new(rgb, alpha.and_then(|a| GrayImage::from_raw(width, height, a)))
    }
}

/// How to open a clip, and what it may cost.
#[derive(Clone, Debug)]
pub struct ClipOptions {
    /// The ffmpeg program for what is not decoded here: a path, or a name that the system looks up. `ffprobe` is
    /// expected beside it. [`None`]: no program is ever started.
    pub ffmpeg: Option<PathBuf>,
    /// Bytes of decoded frames that are kept.
    pub cache_bytes: usize,
    /// Pixels of one frame, at most.
    pub max_pixels: u64,
    /// Frames a second of a folder of images, which cannot say.
    pub images_fps: f64,
    /// Who lends the memory for decoded frames; [`None`]: it is the engine's own.
    pub memory: Option<Arc<dyn FrameMemory>>,
}

impl Default for ClipOptions {
    fn default() -> Self {
        Self {
            ffmpeg: Some("ffmpeg".into()),
            cache_bytes: 256 << 20,
            max_pixels: 64 << 20,
            images_fps: 24.0,
            memory: None,
        }
    }
}

/// A clip whose frames are decoded when asked for. Threads may share it.
pub struct Clip {
    name: PathBuf,
    info: ClipInfo,
    times: Vec<f64>,
    /// The picture of each frame, where that is not the frame's own number.
    pictures: Option<Vec<u32>>,
    pool: Pool,
    /// What its files need to stay.
    kept: Option<Arc<dyn Any + Send + Sync>>,
}

/// What each kind of clip gives on opening.
struct Opened {
    info: ClipInfo,
    /// Seconds from the first frame, one for each frame.
    times: Vec<f64>,
    /// The picture of each frame, where that is not the frame's own number.
    pictures: Option<Vec<u32>>,
    source: Box<dyn Source>,
}

/// A kind of clip's opening.
type Attempt<T> = std::result::Result<T, Refusal>;

/// Why a kind of clip did not open.
enum Refusal {
    /// Nobody could.
    Error(Error),
    /// Another decoder may: what the file has that this one lacks.
    Unsupported(String),
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

impl std::fmt::Debug for Clip {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kept = self.kept.is_some();
        let (name, info) = (&self.name, &self.info);
        f.debug_struct("Clip").field("name", name).field("info", info).field("kept", &kept).finish_non_exhaustive()
    }
}

impl Clip {
    /// Opens a video file or a folder of numbered images.
    ///
    /// # Errors
    /// The file cannot be read, is no video, is damaged before its first frame, or is larger than the default
    /// [`ClipOptions`] allow.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Self::open_with(path, &ClipOptions::default())
    }

    /// Opens a video file or a folder of numbered images.
    ///
    /// # Errors
    /// As for [`Self::open`], with other bounds.
    pub fn open_with(path: impl AsRef<Path>, options: &ClipOptions) -> Result<Self> {
        Self::open_staged(path, options, Progress::new().whole())
    }

    /// Opens a video file or a folder of numbered images, which takes its time where there are thousands of images or
    /// another program has to list the frames.
    ///
    /// # Errors
    /// As for [`Self::open_with`], or a cancel.
    pub fn open_staged(path: impl AsRef<Path>, options: &ClipOptions, stage: Stage<'_>) -> Result<Self> {
        let path = path.as_ref();
        stage.name("opening")?;
        let opened = match Kind::of(path)? {
            Kind::Folder => folder::open(path, options, stage),
            Kind::Still => folder::open_still(path, options, stage),
            Kind::Gif => animation::open_gif(path, options, stage),
            Kind::Apng => animation::open_apng(path, options, stage),
            Kind::WebP => animation::open_webp(path, options, stage),
            #[cfg(feature = "h264")]
            Kind::Mp4 => mp4::open(path, options),
            #[cfg(not(feature = "h264"))]
            Kind::Mp4 => Err(Refusal::Unsupported("MP4, and this build has no H.264 decoder".to_owned())),
            Kind::Other => Err(Refusal::Unsupported("no kind of video that is known here".to_owned())),
        };
        let unsupported = match opened {
            Ok(opened) => {
                let clip = Self::new(path, opened, options);
                // What the embedded decoder cannot do shows at the first frame.
                match clip.frame(0) {
                    Err(Error::File { problem, .. }) if clip.info.source == "mp4" => problem,
                    Err(error) => return Err(error),
                    Ok(_) => return Ok(clip),
                }
            }
            Err(Refusal::Error(error)) => return Err(error),
            Err(Refusal::Unsupported(what)) => format!("is {what}"),
        };
        let remedy =
            |first: &str| format!("{first}, or convert it: ffmpeg -i IN -c:v libx264 -pix_fmt yuv420p OUT.mp4");
        match ffmpeg::open(path, options, stage) {
            Ok(opened) => Ok(Self::new(path, opened, options)),
            Err(NoHelp::Error(error)) => Err(error),
            Err(NoHelp::Forbidden) => {
                Err(Error::file(path, unsupported, remedy("allow the use of ffmpeg, which may read it")))
            }
            Err(NoHelp::Missing(program)) => {
                let remedy = remedy("install ffmpeg, which may read it");
                Err(Error::file(path, format!("{unsupported}; there is no program {}", program.display()), remedy))
            }
            Err(NoHelp::Refused(why)) => {
                let remedy = "expected MP4, MOV, GIF, APNG, WebP, a folder of images, or what ffmpeg reads";
                Err(Error::file(path, format!("{unsupported}, and ffmpeg cannot read it: {why}"), remedy))
            }
        }
    }

    /// A clip of frames that are in memory, shown at an even rate.
    ///
    /// # Errors
    /// There are no frames, one differs in size from the first, or the rate is not above 0.
    pub fn from_frames(frames: Vec<RgbImage>, fps: f64) -> Result<Self> {
        memory::open(frames, fps)
            .map(|opened| Self::new(Path::new("frames in memory"), opened, &ClipOptions::default()))
    }

    fn new(path: &Path, opened: Opened, options: &ClipOptions) -> Self {
        let Opened { info, times, pictures, source } = opened;
        Self { name: path.to_owned(), info, times, pictures, pool: Pool::new(source, options), kept: None }
    }

    /// The clip, which keeps `what` alive for as long as it is read: a folder that is removed with its last user.
    pub fn keeping(mut self, what: Arc<dyn Any + Send + Sync>) -> Self {
        self.kept = Some(what);
        self
    }

    /// The file or folder that it was opened from.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// What the clip is.
    pub fn info(&self) -> &ClipInfo {
        &self.info
    }

    /// When frame `index` is shown, in seconds from the first frame.
    ///
    /// # Errors
    /// There is no such frame.
    pub fn time(&self, index: usize) -> Result<f64> {
        self.times.get(index).copied().ok_or_else(|| self.no_such_frame(index))
    }

    fn no_such_frame(&self, index: usize) -> Error {
        Error::invalid(
            format!("frame {index}"),
            format!("the clip has {} frames", self.info.frames),
            "frames count from 0",
        )
    }

    /// Frame `index`, counted from 0, from the cache or decoded now. Any number of threads may ask at once.
    ///
    /// # Errors
    /// There is no such frame, or its data is damaged; the message says which frames before it are good.
    pub fn frame(&self, index: usize) -> Result<Arc<Picture>> {
        if index >= self.info.frames {
            return Err(self.no_such_frame(index));
        }
        let number = self.pictures.as_ref().map_or(index, |p| p[index] as usize);
        match self.pool.get(number)? {
            Some(Entry::Picture(picture)) => Ok(picture),
            Some(Entry::Planes(planes)) => {
                let picture = Arc::new(planes.to_picture()).lent(self.pool.memory())?;
                self.pool.keep(number, Entry::Picture(Arc::clone(&picture)));
                Ok(picture)
            }
            Some(Entry::Damaged(damage)) => Err(self.damaged(index, number, &damage.why, damage.first)),
            None => Err(self.damaged(index, number, "the file ends before it", number)),
        }
    }

    /// The error of a frame, which says how many frames before the damage are known to be good: those of the same run
    /// of decoding, or the first spoiled one would have been another.
    fn damaged(&self, index: usize, number: usize, why: &str, first: usize) -> Error {
        let first_frame = index.saturating_sub(number.saturating_sub(first));
        let run = first.saturating_sub(self.pool.restart(number)).min(first_frame);
        let place = if first_frame == index { "it".to_owned() } else { format!("frame {first_frame}") };
        let good = match run {
            0 => format!("the frames before {place} are not touched by it"),
            1 => format!("the frame before {place} is good"),
            run => format!("the {run} frames before {place} are good"),
        };
        Error::file(&self.name, format!("frame {index} cannot be decoded: {why}"), good)
    }
}

/// What a file is, by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Folder,
    Still,
    Gif,
    Apng,
    WebP,
    Mp4,
    Other,
}

impl Kind {
    fn of(path: &Path) -> Result<Self> {
        let meta = std::fs::metadata(path).map_err(|e| Error::io(path, "open", e))?;
        if meta.is_dir() {
            return Ok(Self::Folder);
        }
        if !meta.is_file() {
            return Err(Error::file(path, "is no ordinary file", "expected a video file or a folder of images"));
        }
        if meta.len() == 0 {
            return Err(Error::file(path, "is empty", "expected a video file"));
        }
        let mut head = Vec::with_capacity(16);
        let file = std::fs::File::open(path).map_err(|e| Error::io(path, "open", e))?;
        file.take(16).read_to_end(&mut head).map_err(|e| Error::io(path, "read", e))?;
        Ok(match *head.as_slice() {
            [0x89, b'P', b'N', b'G', ..] if animation::is_apng(path)? => Self::Apng,
            [0x89, b'P', b'N', b'G', ..] | [0xff, 0xd8, 0xff, ..] => Self::Still,
            [b'G', b'I', b'F', b'8', ..] => Self::Gif,
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => {
                if animation::is_animated_webp(path)? {
                    Self::WebP
                } else {
                    Self::Still
                }
            }
            [_, _, _, _, a, b, c, d, ..] => match &[a, b, c, d] {
                b"ftyp" | b"moov" | b"mdat" | b"wide" | b"free" | b"skip" | b"pnot" | b"styp" => Self::Mp4,
                _ => Self::Other,
            },
            _ => Self::Other,
        })
    }
}

/// Refuses frames larger than allowed, before anything is allocated for them.
fn check_pixels(path: &Path, width: u32, height: u32, options: &ClipOptions) -> Result<()> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(Error::file(path, format!("is {width}x{height} pixels"), "expected at least one pixel"));
    }
    if pixels > options.max_pixels {
        return Err(Error::Limit {
            what: format!("a frame of {} ({width}x{height} pixels)", path.display()),
            value: pixels,
            max: options.max_pixels,
            remedy: "scale the clip down".to_owned(),
        });
    }
    Ok(())
}

/// Mean frames a second of frames shown at `times`, the last one for `last` seconds.
fn mean_fps(times: &[f64], last: f64) -> f64 {
    let span = times.last().copied().unwrap_or(0.0) - times.first().copied().unwrap_or(0.0);
    let fps = if span > 0.0 { (times.len() - 1) as f64 / span } else { 1.0 / last };
    // Seconds are rounded sums of ticks; 30 frames a second must say 30.
    let fps = (fps * 1e9).round() / 1e9;
    if fps.is_finite() && fps > 0.0 { fps } else { 24.0 }
}
