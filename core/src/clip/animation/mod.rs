//! Animated images: GIF, APNG and WebP.
//!
//! On opening, the file's blocks are walked without decoding them, which gives the number of frames and how long each
//! is shown. Each frame changes a canvas that the ones before have left, so decoding always begins with the first.

mod apng;
mod gif;
mod webp;

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::source::{Damage, Decoded, Source, Stream};
use super::{Attempt, ClipInfo, ClipOptions, Opened, Picture, check_pixels};
use crate::error::{Error, Result};
use crate::job::Stage;

pub(super) use self::apng::{is_animated as is_apng, open as open_apng};
pub(super) use self::gif::open as open_gif;
pub(super) use self::webp::{is_animated as is_animated_webp, open as open_webp};

/// What walking over the blocks tells.
#[derive(Debug, Default, PartialEq)]
struct Index {
    width: u32,
    height: u32,
    /// Seconds for which each whole frame is shown.
    delays: Vec<f64>,
    /// Bytes up to the end of the last whole frame.
    whole_bytes: u64,
    /// What is wrong with the file after the last whole frame.
    problem: Option<String>,
}

/// Gives an animation's frames one after the other, on their canvas. An error is what is wrong with the data.
trait Frames: Send {
    fn next(&mut self) -> std::result::Result<Picture, String>;
}

/// A decoder at the first frame of a file, of which the first `whole_bytes` are whole; `max_bytes` is what it may
/// allocate for one frame.
type Start = fn(&Path, whole_bytes: u64, max_bytes: u64) -> Result<Box<dyn Frames>>;

struct Animation {
    path: PathBuf,
    frames: usize,
    whole_bytes: u64,
    max_bytes: u64,
    start: Start,
}

/// More frames than this are no animation; each costs bytes of index.
const MAX_FRAMES: usize = 1 << 20;

fn opened(
    path: &Path,
    options: &ClipOptions,
    source: &'static str,
    index: Index,
    claimed: Option<usize>,
    start: Start,
) -> Attempt<Opened> {
    let Index { width, height, mut delays, whole_bytes, problem } = index;
    delays.truncate(claimed.unwrap_or(usize::MAX).min(MAX_FRAMES));
    let frames = delays.len();
    if frames == 0 {
        let problem = problem.unwrap_or_else(|| "holds no frames".to_owned());
        return Err(Error::file(path, problem, "expected an animation; save it again").into());
    }
    check_pixels(path, width, height, options)?;
    let mut warnings = Vec::new();
    let missing = claimed.is_some_and(|c| c > frames);
    if let Some(problem) = problem.or_else(|| missing.then(|| "ends early".to_owned())) {
        let of = claimed.filter(|_| missing).map_or(String::new(), |c| format!(" of {c}"));
        warnings.push(format!("the file {problem}; {frames}{of} frames can be used, 0 to {}", frames - 1));
    }
    let times: Vec<f64> = delays
        .iter()
        .scan(0.0, |at, delay| {
            let shown = *at;
            *at += delay;
            Some(shown)
        })
        .collect();
    let fps = super::mean_fps(&times, delays[frames - 1]);
    let info = ClipInfo { width, height, frames, fps, source, warnings };
    let max_bytes = options.max_pixels.saturating_mul(8);
    let source = Box::new(Animation { path: path.to_owned(), frames, whole_bytes, max_bytes, start });
    Ok(Opened { info, times, pictures: None, source })
}

impl Source for Animation {
    fn restart(&self, _picture: usize) -> usize {
        0
    }

    fn stream(&self, _picture: usize) -> Result<Box<dyn Stream>> {
        let decoder = (self.start)(&self.path, self.whole_bytes, self.max_bytes)?;
        Ok(Box::new(Playing { decoder, next: 0, frames: self.frames, broken: None }))
    }

    fn max_streams(&self) -> usize {
        2
    }
}

struct Playing {
    decoder: Box<dyn Frames>,
    next: usize,
    frames: usize,
    /// The frame at which decoding failed; the canvas is lost from there on.
    broken: Option<usize>,
}

impl Stream for Playing {
    fn next(&mut self) -> Result<Option<(usize, Decoded)>> {
        let number = self.next;
        if number >= self.frames {
            return Ok(None);
        }
        self.next += 1;
        let decoded = match self.broken {
            Some(first) => {
                Decoded::Damaged(Damage { why: format!("it builds on frame {first}, which is damaged"), first })
            }
            None => match self.decoder.next() {
                Ok(picture) => Decoded::Picture(Arc::new(picture)),
                Err(why) => {
                    self.broken = Some(number);
                    Decoded::Damaged(Damage { why, first: number })
                }
            },
        };
        Ok(Some((number, decoded)))
    }
}

/// Walks over the file at `path` with `scan`.
fn walked<T>(
    path: &Path,
    stage: Stage<'_>,
    scan: impl FnOnce(Walk<'_, BufReader<File>>) -> std::io::Result<T>,
) -> Result<T> {
    let file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
    let found = Walk::new(BufReader::new(file), stage).and_then(scan);
    // A walk that was cancelled ends in an error of its reader.
    stage.at(0.5)?;
    found.map_err(|e| Error::io(path, "read", e))
}

/// A file that is walked over, with its length at hand.
struct Walk<'a, R> {
    reader: R,
    at: u64,
    len: u64,
    stage: Stage<'a>,
}

impl<'a, R: Read + Seek> Walk<'a, R> {
    fn new(mut reader: R, stage: Stage<'a>) -> std::io::Result<Self> {
        let len = reader.seek(SeekFrom::End(0))?;
        reader.seek(SeekFrom::Start(0))?;
        Ok(Self { reader, at: 0, len, stage })
    }

    /// The next bytes, or [`None`] where the file ends before.
    fn take<const N: usize>(&mut self) -> std::io::Result<Option<[u8; N]>> {
        if self.len - self.at < N as u64 {
            return Ok(None);
        }
        self.stage.at(0.0).map_err(|_| std::io::ErrorKind::Interrupted)?;
        let mut bytes = [0; N];
        self.reader.read_exact(&mut bytes)?;
        self.at += N as u64;
        Ok(Some(bytes))
    }

    /// Passes over bytes; false where the file ends before.
    fn skip(&mut self, count: u64) -> std::io::Result<bool> {
        if self.len - self.at < count {
            return Ok(false);
        }
        self.reader.seek_relative(count.cast_signed())?;
        self.at += count;
        Ok(true)
    }
}
