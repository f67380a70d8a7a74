//! MP4 and QuickTime files with H.264, decoded by the embedded openh264.
//!
//! The container is read here (ISO/IEC 14496-12 and -15) and only the index is kept in memory; coded pictures are read
//! when they are decoded. The decoder gives pictures in the order in which they are shown but without their times, so
//! the n-th picture out belongs to the n-th smallest time among the samples that went in.
//!
//! Limits: one description a track, progressive 4:2:0 with 8 bits. Everything else is left to ffmpeg.

mod boxes;
mod fragments;
mod sps;
mod stream;
mod track;

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::boxes::TopBox;
use self::fragments::Defaults;
use self::sps::Sps;
use self::stream::H264Stream;
use self::track::{NoTrack, Track};
use super::source::{Source, Stream};
use super::yuv::ColorSpace;
use super::{Attempt, ClipInfo, ClipOptions, Opened, Refusal, check_pixels};
use crate::error::{Error, Result};

/// An index larger than this is no video that fits a session; it is held in memory while it is read.
const MAX_INDEX_BYTES: u64 = 256 << 20;

/// What all streams of a file share.
#[derive(Debug)]
struct Movie {
    path: PathBuf,
    track: Track,
    color: ColorSpace,
    size: (u32, u32),
    /// Samples in the order in which they are shown.
    shown: Vec<u32>,
    /// The place of each sample in that order.
    rank: Vec<u32>,
    /// Samples from which decoding can begin, rising.
    starts: Vec<u32>,
    /// Samples before the first whose bytes are missing.
    whole: usize,
}

pub(super) fn open(path: &Path, options: &ClipOptions) -> Attempt<Opened> {
    let mut file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
    let file_len = file.metadata().map_err(|e| Error::io(path, "read", e))?.len();
    let boxes = boxes::top_level(&mut file, file_len).map_err(|e| Error::io(path, "read", e))?;
    let mut track = read_index(path, &mut file, file_len, &boxes)?;
    let mut warnings = std::mem::take(&mut track.warnings);

    let claimed = track.samples.len();
    let whole = track.samples.iter().position(|s| s.offset.saturating_add(s.size.into()) > file_len).unwrap_or(claimed);
    if whole == 0 {
        let problem = if claimed == 0 { "holds no pictures" } else { "is cut off before its first picture ends" };
        return Err(Error::file(path, problem, "record or copy it again").into());
    }
    let damaged = |e| Error::io(path, "read", e);
    let starts = stream::starting_points(&mut file, &track, whole).map_err(damaged)?;
    if starts.first() != Some(&0) {
        return Err(Refusal::Unsupported("H.264 that does not begin with a picture that stands alone".to_owned()));
    }
    let sps = match track.sps() {
        Some(sps) => Some(sps),
        None => stream::sps_in_sample(&mut file, &track, 0).map_err(damaged)?,
    };
    let Some(sps) = sps else {
        return Err(Error::file(path, "has no readable H.264 parameters", "convert it to MP4 again").into());
    };
    if let Some(why) = sps.unsupported() {
        return Err(Refusal::Unsupported(why));
    }
    let size = (sps.width, sps.height);
    check_pixels(path, size.0, size.1, options)?;
    if let Some((w, h)) = sps.pixel_aspect.filter(|(w, h)| w != h) {
        warnings.push(format!("its pixels are not square ({w}:{h}); they are taken as they are"));
    }

    let mut shown: Vec<u32> = (0..claimed as u32).collect();
    shown.sort_by_key(|&s| (track.samples[s as usize].shown_at, s));
    let mut rank = vec![0u32; claimed];
    for (place, &sample) in shown.iter().enumerate() {
        rank[sample as usize] = place as u32;
    }
    // Pictures are shown from the first on without a hole, so a missing one ends the clip.
    let usable = rank[whole..].iter().min().map_or(claimed, |&r| r as usize);

    let frames = presented(&track, &shown, usable);
    let all_frames = if usable < claimed { presented(&track, &shown, claimed).len() } else { frames.len() };
    if frames.is_empty() {
        return Err(
            Error::file(path, "shows none of its pictures before it is cut off", "record or copy it again").into()
        );
    }
    if frames.len() < all_frames {
        warnings.push(format!(
            "the file is cut off: {} of {all_frames} frames can be used, 0 to {}",
            frames.len(),
            frames.len() - 1
        ));
    } else if boxes.last().is_some_and(|b| b.end > file_len || (b.end < file_len && &b.name != b"mdat")) {
        warnings.push(format!("the file is damaged near its end; the {} frames before that can be used", frames.len()));
    }

    let (width, height) = track.orientation.size(size);
    let times: Vec<f64> = frames.iter().map(|f| f.1).collect();
    let last_ticks = track.samples[shown[frames[frames.len() - 1].0 as usize] as usize].duration;
    let info = ClipInfo {
        width,
        height,
        frames: frames.len(),
        fps: super::mean_fps(&times, f64::from(last_ticks) / f64::from(track.timescale)),
        source: "mp4",
        warnings,
    };
    let in_order = frames.iter().enumerate().all(|(i, f)| i as u32 == f.0);
    let pictures = if in_order { None } else { Some(frames.iter().map(|f| f.0).collect()) };
    let color = color_space(&sps, &track);
    let movie = Movie { path: path.to_owned(), track, color, size, shown, rank, starts, whole };
    Ok(Opened { info, times, pictures, source: Box::new(Mp4(Arc::new(movie))) })
}

fn read_index(path: &Path, file: &mut File, file_len: u64, boxes: &[TopBox]) -> Attempt<Track> {
    let broken = |problem: String| Error::file(path, problem, "convert it to MP4 again, or record it again");
    let mut budget = MAX_INDEX_BYTES;
    let mut read = |b: &TopBox| -> Result<Vec<u8>> {
        let length = b.end.min(file_len).saturating_sub(b.body);
        if length > budget {
            return Err(Error::Limit {
                what: format!("the index of {}", path.display()),
                value: length,
                max: budget,
                remedy: "cut the clip into shorter ones".to_owned(),
            });
        }
        budget -= length;
        let mut data = vec![0; length as usize];
        file.seek(SeekFrom::Start(b.body)).map_err(|e| Error::io(path, "read", e))?;
        file.read_exact(&mut data).map_err(|e| Error::io(path, "read", e))?;
        Ok(data)
    };
    let Some(moov) = boxes.iter().find(|b| &b.name == b"moov") else {
        let cut = boxes.last().is_some_and(|b| b.end >= file_len);
        let problem =
            if cut { "is cut off: its index (moov), written last, is missing" } else { "has no index (moov)" };
        return Err(
            Error::file(path, problem, "copy it again from the camera, or rebuild it with a repair tool").into()
        );
    };
    let cut = moov.end > file_len;
    let moov = read(moov)?;
    let mut track = Track::from_movie(&moov).map_err(|why| match why {
        NoTrack::Unsupported(what) => Refusal::Unsupported(what),
        NoTrack::Broken(what) if cut => broken(format!("is cut off inside its index (moov) and {what}")).into(),
        NoTrack::Broken(what) => broken(what).into(),
    })?;
    let defaults = Defaults::from_movie(&moov, track.id);
    for moof in boxes.iter().filter(|b| &b.name == b"moof") {
        if fragments::append(&mut track, &read(moof)?, moof.start, defaults).is_none() {
            let have = track.samples.len();
            track.warnings.push(format!("a fragment of its index is damaged; {have} pictures come before that"));
            break;
        }
    }
    Ok(track)
}

/// What is shown: (place among the pictures, seconds), through the edit list, of the first `usable` pictures.
///
/// Like players, a picture belongs to an edit when its own time does.
fn presented(track: &Track, shown: &[u32], usable: usize) -> Vec<(u32, f64)> {
    let time = |place: usize| track.samples[shown[place] as usize].shown_at;
    let mut frames: Vec<(u32, i64)> = Vec::new();
    if track.edits.is_empty() {
        frames.extend((0..usable).map(|p| (p as u32, time(p))));
    }
    let mut start = 0i64;
    for edit in &track.edits {
        let first = shown.partition_point(|&s| track.samples[s as usize].shown_at < edit.from);
        for place in first..shown.len() {
            let at = time(place);
            if at >= edit.to || frames.len() >= track::MAX_SAMPLES {
                break;
            }
            if place >= usable {
                // Nothing that comes after the break is offered, not even in a later edit.
                return in_seconds(&frames, track.timescale);
            }
            frames.push((place as u32, start.saturating_add(at - edit.from)));
        }
        start = start.saturating_add(edit.to.saturating_sub(edit.from));
    }
    in_seconds(&frames, track.timescale)
}

fn in_seconds(frames: &[(u32, i64)], timescale: u32) -> Vec<(u32, f64)> {
    let first = frames.first().map_or(0, |f| f.1);
    frames.iter().map(|&(p, t)| (p, t.saturating_sub(first) as f64 / f64::from(timescale))).collect()
}

/// What the stream says, else what the container says, else what players assume.
fn color_space(sps: &Sps, track: &Track) -> ColorSpace {
    let named = |matrix: Option<u16>| matrix.and_then(ColorSpace::weights);
    let (kr, kb) = named(sps.matrix_coefficients)
        .or_else(|| named(track.container_color.map(|c| c.0)))
        .unwrap_or_else(|| ColorSpace::default_weights(sps.width, sps.height));
    let full_range = sps.full_range.or(track.container_color.and_then(|c| c.1)).unwrap_or(false);
    ColorSpace { kr, kb, full_range }
}

struct Mp4(Arc<Movie>);

impl Movie {
    /// The sample from which decoding has to begin to reach `picture`, as an index into `starts`.
    fn start_before(&self, picture: usize) -> usize {
        let sample = self.shown[picture];
        self.starts.partition_point(|&s| s <= sample).saturating_sub(1)
    }
}

impl Source for Mp4 {
    fn restart(&self, picture: usize) -> usize {
        let start = self.0.starts[self.0.start_before(picture)];
        (self.0.rank[start as usize] as usize).min(picture)
    }

    fn stream(&self, picture: usize) -> Result<Box<dyn Stream>> {
        let start = self.0.starts[self.0.start_before(picture)];
        Ok(Box::new(H264Stream::new(Arc::clone(&self.0), start as usize)?))
    }

    fn max_streams(&self) -> usize {
        4
    }
}
