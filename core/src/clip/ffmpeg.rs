//! Everything that is not decoded here, through the `ffmpeg` and `ffprobe` programs where they are installed.
//!
//! `ffprobe` lists the packets of the first video stream, which gives the number of frames and their times without
//! decoding; `ffmpeg` then writes the frames, turned upright, into a pipe, each as a PAM image, which carries its own
//! size and opacity. Nothing is linked, so neither its licence nor its bugs become the host's; only local files are
//! opened, whatever a playlist may say.
//!
//! Limits: going back behind what is cached decodes from the beginning again, because seeking is exact for some
//! containers only.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use image::RgbImage;
use serde::Deserialize;

use super::source::{Damage, Decoded, Source, Stream};
use super::yuv::ColorSpace;
use super::{ClipInfo, ClipOptions, Opened, Picture, check_pixels};
use crate::error::{Error, Result};
use crate::job::Stage;

/// Why ffmpeg did not help.
pub(super) enum NoHelp {
    /// The host forbids it.
    Forbidden,
    /// There is none by that name.
    Missing(PathBuf),
    /// It could not read the file, and says why.
    Refused(String),
    /// Another failure.
    Error(Error),
}

impl From<Error> for NoHelp {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

#[derive(Deserialize)]
struct Probe {
    #[serde(default)]
    streams: Vec<ProbeStream>,
    #[serde(default)]
    packets: Vec<ProbePacket>,
}

#[derive(Deserialize)]
struct ProbeStream {
    #[serde(default)]
    codec_name: String,
    #[serde(default)]
    width: u32,
    #[serde(default)]
    height: u32,
    #[serde(default)]
    pix_fmt: String,
    #[serde(default)]
    color_space: String,
    #[serde(default)]
    avg_frame_rate: String,
}

#[derive(Deserialize)]
struct ProbePacket {
    pts_time: Option<String>,
    duration_time: Option<String>,
    #[serde(default)]
    flags: String,
}

/// What it takes to start ffmpeg on a file.
struct Job {
    program: PathBuf,
    path: PathBuf,
    filters: String,
    pixel_format: &'static str,
    frames: usize,
}

/// A listing longer than this is no clip.
const MAX_LISTING_BYTES: u64 = 256 << 20;
/// How much of what ffmpeg complains is kept.
const MAX_COMPLAINT_BYTES: u64 = 4 << 10;

pub(super) fn open(path: &Path, options: &ClipOptions, stage: Stage<'_>) -> std::result::Result<Opened, NoHelp> {
    let Some(program) = options.ffmpeg.clone() else { return Err(NoHelp::Forbidden) };
    let probe = probe(path, &program.with_file_name("ffprobe"), stage)?;
    let stream = probe.streams.first().ok_or_else(|| NoHelp::Refused("it has no video stream".to_owned()))?;
    if matches!(stream.codec_name.as_str(), "ansi" | "bintext" | "xbin" | "idf") {
        return Err(NoHelp::Refused("it is text".to_owned()));
    }
    check_pixels(path, stream.width, stream.height, options)?;
    let shown: Vec<&ProbePacket> = probe.packets.iter().filter(|p| !p.flags.contains('D')).collect();
    if shown.is_empty() {
        return Err(NoHelp::Refused("it has no frames".to_owned()));
    }
    let fps = ratio(&stream.avg_frame_rate);
    let times = frame_times(&shown, fps);
    let seconds = |t: &Option<String>| t.as_ref().and_then(|t| t.parse::<f64>().ok());
    let last = shown.last().and_then(|p| seconds(&p.duration_time)).unwrap_or(1.0 / fps.unwrap_or(24.0));

    // Numbering the frames anew keeps ffmpeg from repeating or dropping some to make the rate even.
    let mut filters = "settb=1/25,setpts=N".to_owned();
    let unnamed = matches!(stream.color_space.as_str(), "" | "unknown") && stream.pix_fmt.starts_with("yuv");
    if unnamed && ColorSpace::default_weights(stream.width, stream.height) == ColorSpace::BT709 {
        filters += ",scale=in_color_matrix=bt709";
    }
    let pixel_format = if has_alpha(&stream.pix_fmt) { "rgba" } else { "rgb24" };
    let job = Job { program, path: path.to_owned(), filters, pixel_format, frames: shown.len() };
    let mut frames = Frames::start(Arc::new(job), options.max_pixels)?;
    let peeked = watched(&mut frames.child, stage, || {
        frames.peeked = read_header(&mut frames.stdout);
    });
    peeked?;
    let (width, height) = match frames.peeked.map(|h| (h.width, h.height)) {
        Some(size) => size,
        None => return Err(NoHelp::Refused(frames.complaint())),
    };
    check_pixels(path, width, height, options)?;
    let info = ClipInfo {
        width,
        height,
        frames: times.len(),
        fps: super::mean_fps(&times, last),
        source: "ffmpeg",
        warnings: Vec::new(),
    };
    let source = Ffmpeg {
        job: Arc::clone(&frames.job),
        size: (width, height),
        max_pixels: options.max_pixels,
        first: Mutex::new(Some(frames)),
    };
    Ok(Opened { info, times, pictures: None, source: Box::new(source) })
}

/// Local files only, and no mistaking a name for an option or a protocol.
fn input(command: &mut Command, path: &Path) {
    let mut url = std::ffi::OsString::from("file:");
    url.push(path);
    command.args(["-protocol_whitelist", "file", "-i"]).arg(url);
}

fn spawn(command: &mut Command, program: &Path) -> std::result::Result<Child, NoHelp> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => NoHelp::Missing(program.to_owned()),
        _ => NoHelp::Error(Error::io(program, "start", e)),
    })
}

/// Reads what a program complains on a thread of its own, so that a full pipe never stops it.
fn listen(child: &mut Child) -> Option<JoinHandle<String>> {
    let mut stderr = child.stderr.take()?;
    Some(std::thread::spawn(move || {
        let mut text = Vec::new();
        // An unreadable complaint is no complaint.
        let _ = stderr.by_ref().take(MAX_COMPLAINT_BYTES).read_to_end(&mut text);
        let _ = std::io::copy(&mut stderr, &mut std::io::sink());
        String::from_utf8_lossy(&text).trim().replace('\n', "; ")
    }))
}

/// Reads from `child` by `read`; a cancel kills it, so that reading ends.
fn watched<T>(child: &mut Child, stage: Stage<'_>, read: impl FnOnce() -> T) -> Result<T> {
    const BETWEEN_CHECKS: Duration = Duration::from_millis(10);
    let done = AtomicBool::new(false);
    let answer = std::thread::scope(|scope| {
        let watcher = scope.spawn(|| {
            while !done.load(Ordering::Acquire) {
                if stage.at(0.0).is_err() {
                    // It may have ended by itself, which is as good.
                    let _ = child.kill();
                    break;
                }
                std::thread::park_timeout(BETWEEN_CHECKS);
            }
        });
        let answer = read();
        done.store(true, Ordering::Release);
        watcher.thread().unpark();
        answer
    });
    stage.at(0.0)?;
    Ok(answer)
}

fn probe(path: &Path, program: &Path, stage: Stage<'_>) -> std::result::Result<Probe, NoHelp> {
    let mut command = Command::new(program);
    command.args(["-v", "error", "-select_streams", "V:0", "-of", "json", "-show_entries"]);
    command
        .arg("stream=codec_name,width,height,pix_fmt,color_space,avg_frame_rate:packet=pts_time,duration_time,flags");
    input(&mut command, path);
    let mut child = spawn(&mut command, program)?;
    let complaint = listen(&mut child);
    let mut listing = Vec::new();
    if let Some(stdout) = child.stdout.take() {
        let read = watched(&mut child, stage, || stdout.take(MAX_LISTING_BYTES).read_to_end(&mut listing));
        if read.is_err() {
            // It was killed; what is left of it is waited for.
            let _ = child.wait();
        }
        let read = read?;
        read.map_err(|e| Error::io(program, "read from", e))?;
    }
    let status = child.wait().map_err(|e| Error::io(program, "wait for", e))?;
    let complaint = complaint.and_then(|c| c.join().ok()).unwrap_or_default();
    let probe: Option<Probe> = serde_json::from_slice(&listing).ok();
    match probe {
        // What comes before a break is worth having, complaints or not.
        Some(probe) if status.success() || !probe.packets.is_empty() => Ok(probe),
        _ if complaint.is_empty() => Err(NoHelp::Refused(format!("{status}"))),
        _ => Err(NoHelp::Refused(complaint)),
    }
}

fn ratio(text: &str) -> Option<f64> {
    let (a, b) = text.split_once('/')?;
    let value = a.parse::<f64>().ok()? / b.parse::<f64>().ok()?;
    (value.is_finite() && value > 0.0).then_some(value)
}

/// Seconds from the first frame. Packets come in decoding order, frames in the order of their times.
fn frame_times(shown: &[&ProbePacket], fps: Option<f64>) -> Vec<f64> {
    let stated: Option<Vec<f64>> = shown
        .iter()
        .map(|p| p.pts_time.as_ref().and_then(|t| t.parse::<f64>().ok()).filter(|t| t.is_finite()))
        .collect();
    match stated {
        Some(mut times) => {
            times.sort_by(f64::total_cmp);
            let first = times[0];
            times.iter().map(|t| t - first).collect()
        }
        None => (0..shown.len()).map(|i| i as f64 / fps.unwrap_or(24.0)).collect(),
    }
}

fn has_alpha(pixel_format: &str) -> bool {
    const WITH_ALPHA: [&str; 9] = ["yuva", "rgba", "argb", "bgra", "abgr", "gbrap", "ya8", "ya16", "pal8"];
    WITH_ALPHA.iter().any(|name| pixel_format.starts_with(name))
}

/// A running ffmpeg and the frames that it writes.
struct Frames {
    job: Arc<Job>,
    child: Child,
    stdout: BufReader<ChildStdout>,
    complaint: Option<JoinHandle<String>>,
    /// The header of the next frame, when it was already read.
    peeked: Option<Header>,
    size: Option<(u32, u32)>,
    max_pixels: u64,
    next: usize,
}

#[derive(Clone, Copy)]
struct Header {
    width: u32,
    height: u32,
    channels: usize,
}

impl Frames {
    fn start(job: Arc<Job>, max_pixels: u64) -> std::result::Result<Self, NoHelp> {
        let mut command = Command::new(&job.program);
        command.args(["-v", "error", "-nostdin"]);
        input(&mut command, &job.path);
        command.args(["-map", "0:V:0", "-r", "25", "-f", "image2pipe", "-c:v", "pam"]);
        command.args(["-sws_flags", "bicubic+accurate_rnd+full_chroma_int", "-pix_fmt", job.pixel_format]);
        command.args(["-vf", &job.filters, "-"]);
        let mut child = spawn(&mut command, &job.program)?;
        let complaint = listen(&mut child);
        let stdout = child.stdout.take().ok_or_else(|| NoHelp::Refused("it has no output".to_owned()))?;
        let stdout = BufReader::with_capacity(1 << 16, stdout);
        Ok(Self { job, child, stdout, complaint, peeked: None, size: None, max_pixels, next: 0 })
    }

    fn read(&mut self) -> Option<std::result::Result<Picture, String>> {
        let header = self.peeked.take().or_else(|| read_header(&mut self.stdout))?;
        let (width, height) = (header.width, header.height);
        if u64::from(width) * u64::from(height) > self.max_pixels {
            return None;
        }
        let mut data = vec![0; width as usize * height as usize * header.channels];
        self.stdout.read_exact(&mut data).ok()?;
        if (width, height) != *self.size.get_or_insert((width, height)) {
            return Some(Err("changes the size of the picture".to_owned()));
        }
        Some(Ok(match header.channels {
            4 => Picture::from_rgba(&data, width, height),
            _ => Picture::new(RgbImage::from_raw(width, height, data).unwrap_or_default(), None),
        }))
    }

    /// Ends it; what it complained.
    fn complaint(&mut self) -> String {
        self.stop();
        let text = self.complaint.take().and_then(|c| c.join().ok()).unwrap_or_default();
        if text.is_empty() { "it gave no frames".to_owned() } else { text }
    }

    fn stop(&mut self) {
        // It may have ended by itself, which is as good.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        self.stop();
    }
}

/// The header of a PAM image; [`None`] at the end of the output.
fn read_header(from: &mut impl BufRead) -> Option<Header> {
    let mut header = Header { width: 0, height: 0, channels: 0 };
    for count in 0..16 {
        let mut line = Vec::new();
        from.by_ref().take(80).read_until(b'\n', &mut line).ok()?;
        let line = std::str::from_utf8(&line).ok()?.trim_end();
        let (key, value) = line.split_once(' ').unwrap_or((line, ""));
        match key {
            "P7" if count == 0 => {}
            _ if count == 0 => return None,
            "WIDTH" => header.width = value.parse().ok()?,
            "HEIGHT" => header.height = value.parse().ok()?,
            "DEPTH" => header.channels = value.parse().ok().filter(|c| matches!(c, 3 | 4))?,
            "ENDHDR" => return (header.width > 0 && header.height > 0 && header.channels > 0).then_some(header),
            _ => {}
        }
    }
    None
}

struct Ffmpeg {
    job: Arc<Job>,
    size: (u32, u32),
    max_pixels: u64,
    /// The program that was started on opening.
    first: Mutex<Option<Frames>>,
}

impl Source for Ffmpeg {
    fn restart(&self, _picture: usize) -> usize {
        0
    }

    fn stream(&self, _picture: usize) -> Result<Box<dyn Stream>> {
        let first = self.first.lock().unwrap_or_else(PoisonError::into_inner).take();
        let mut frames = match first {
            Some(frames) => frames,
            None => Frames::start(Arc::clone(&self.job), self.max_pixels).map_err(|why| match why {
                NoHelp::Error(error) => error,
                _ => Error::file(&self.job.program, "cannot be started any more", "is it still installed?"),
            })?,
        };
        frames.size = Some(self.size);
        Ok(Box::new(frames))
    }

    fn max_streams(&self) -> usize {
        2
    }
}

impl Stream for Frames {
    fn next(&mut self) -> Result<Option<(usize, Decoded)>> {
        if self.next >= self.job.frames {
            return Ok(None);
        }
        let number = self.next;
        self.next += 1;
        Ok(Some((
            number,
            match self.read() {
                Some(Ok(picture)) => Decoded::Picture(Arc::new(picture)),
                Some(Err(why)) => Decoded::Damaged(Damage { why, first: number }),
                None => {
                    self.next = self.job.frames;
                    let why = format!("ffmpeg gave no more frames: {}", self.complaint());
                    Decoded::Damaged(Damage { why, first: number })
                }
            },
        )))
    }
}
