//! H.264 samples through openh264, from a picture that stands alone onward.

use std::collections::{BTreeSet, VecDeque};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;

use openh264::OpenH264API;
use openh264::decoder::{DecodedYUV, Decoder, DecoderConfig, Flush};
use openh264::formats::YUVSource;

use super::Movie;
use super::sps::Sps;
use super::track::Track;
use crate::clip::source::{Damage, Decoded, Stream};
use crate::clip::yuv::Planes;
use crate::error::{Error, Result};

/// NAL unit types (H.264, table 7-1).
const SLICE: u8 = 1;
const IDR_SLICE: u8 = 5;
const SEQUENCE_SET: u8 = 7;
const PICTURE_SET: u8 = 8;

/// A coded picture of more bytes than this is damage: it would be larger than the largest picture uncoded.
const MAX_SAMPLE_BYTES: u32 = 256 << 20;

/// The NAL units of a sample, each after its length in `length_bytes` bytes.
fn nal_units(mut data: &[u8], length_bytes: usize) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let (length, rest) = data.split_at_checked(length_bytes)?;
        let length = length.iter().fold(0usize, |v, &b| v << 8 | usize::from(b));
        let (nal, rest) = rest.split_at(length.min(rest.len()));
        data = rest;
        Some(nal)
    })
    .filter(|nal| !nal.is_empty())
}

fn nal_type(nal: &[u8]) -> u8 {
    nal[0] & 0x1f
}

fn read_sample(file: &mut File, track: &Track, sample: usize, most: u32, into: &mut Vec<u8>) -> std::io::Result<()> {
    let sample = track.samples[sample];
    into.resize(sample.size.min(most) as usize, 0);
    file.seek(SeekFrom::Start(sample.offset))?;
    file.read_exact(into)
}

/// The samples among the first `whole` from which decoding can begin. The file's word is checked: some writers mark
/// every sample, and an open group of pictures begins with one that is no clean start.
pub(super) fn starting_points(file: &mut File, track: &Track, whole: usize) -> std::io::Result<Vec<u32>> {
    let mut starts = Vec::new();
    let mut head = Vec::new();
    for sample in (0..whole).filter(|&s| s == 0 || track.samples[s].sync) {
        // The slice comes after parameter sets and remarks, which are short.
        read_sample(file, track, sample, 16 << 10, &mut head)?;
        if nal_units(&head, track.length_bytes).any(|nal| nal_type(nal) == IDR_SLICE) {
            starts.push(sample as u32);
        }
    }
    Ok(starts)
}

/// A sequence parameter set inside a sample.
pub(super) fn sps_in_sample(file: &mut File, track: &Track, sample: usize) -> std::io::Result<Option<Sps>> {
    let mut head = Vec::new();
    read_sample(file, track, sample, 16 << 10, &mut head)?;
    Ok(nal_units(&head, track.length_bytes).find(|nal| nal_type(nal) == SEQUENCE_SET).and_then(Sps::parse))
}

pub(super) struct H264Stream {
    movie: Arc<Movie>,
    file: File,
    decoder: Decoder,
    /// The next sample to decode.
    next: usize,
    /// Places of the pictures that went in and have not come out.
    inside: BTreeSet<u32>,
    ready: VecDeque<(usize, Decoded)>,
    /// The start that has been tried again with a new decoder.
    tried_again: Option<usize>,
    sample: Vec<u8>,
    packet: Vec<u8>,
}

impl H264Stream {
    pub(super) fn new(movie: Arc<Movie>, start: usize) -> Result<Self> {
        let file = File::open(&movie.path).map_err(|e| Error::io(&movie.path, "open", e))?;
        let decoder = new_decoder(&movie)?;
        Ok(Self {
            movie,
            file,
            decoder,
            next: start,
            inside: BTreeSet::new(),
            ready: VecDeque::new(),
            tried_again: None,
            sample: Vec::new(),
            packet: Vec::new(),
        })
    }

    /// Decodes the next sample, or says what is wrong with it.
    fn decode(&mut self) -> std::result::Result<(), String> {
        let movie = Arc::clone(&self.movie);
        let number = self.next;
        if movie.track.samples[number].size > MAX_SAMPLE_BYTES {
            return Err("claims an absurd size".to_owned());
        }
        read_sample(&mut self.file, &movie.track, number, MAX_SAMPLE_BYTES, &mut self.sample)
            .map_err(|e| format!("cannot be read: {e}"))?;
        self.packet.clear();
        let mut has_slice = false;
        let mut add = |nal: &[u8]| {
            self.packet.extend([0, 0, 0, 1]);
            self.packet.extend(nal);
        };
        if movie.starts.binary_search(&(number as u32)).is_ok() {
            movie.track.parameter_sets.iter().for_each(|nal| add(nal));
        }
        for nal in nal_units(&self.sample, movie.track.length_bytes) {
            match nal_type(nal) {
                SEQUENCE_SET => {
                    let size = Sps::parse(nal).map(|s| (s.width, s.height));
                    if size != Some(movie.size) {
                        return Err("changes the size of the picture".to_owned());
                    }
                    add(nal);
                }
                SLICE | IDR_SLICE => {
                    // The first slice begins with macroblock 0 (first_mb_in_slice, 7.3.3, is the bit 1). The decoder
                    // would take one that does not for a later slice, and wait.
                    if !has_slice && nal.get(1).is_none_or(|b| b & 0x80 == 0) {
                        return Err("is damaged".to_owned());
                    }
                    has_slice = true;
                    add(nal);
                }
                PICTURE_SET => add(nal),
                // Remarks, delimiters, and the layers of other views are not for this decoder.
                _ => {}
            }
        }
        if !has_slice {
            return Err("holds no picture".to_owned());
        }
        let out = self.decoder.decode(&self.packet).map_err(|_| "is damaged".to_owned())?;
        self.inside.insert(movie.rank[number]);
        if let Some(picture) = out {
            take(&movie, &mut self.inside, &mut self.ready, &picture);
        }
        Ok(())
    }

    /// Gets out what is still inside the decoder.
    fn flush(&mut self) {
        if let Ok(pictures) = self.decoder.flush_remaining() {
            for picture in &pictures {
                take(&self.movie, &mut self.inside, &mut self.ready, picture);
            }
        }
        for place in std::mem::take(&mut self.inside) {
            let why = format!("the decoder gave no picture for its data at byte {}", self.offset_of(place));
            let first = place as usize;
            self.ready.push_back((first, Decoded::Damaged(Damage { why, first })));
        }
    }

    /// After damage the decoder forgets the good pictures that it still held: decodes those once more, up to the damage.
    fn recover(&mut self) -> Result<()> {
        /// Damage that stops the picture short is noticed with the next sample only, so a few before it are suspect.
        const SUSPECTS: usize = 3;
        let lost = std::mem::take(&mut self.inside);
        let Some(&first) = lost.first() else { return Ok(()) };
        let is_lost = |place: usize| lost.contains(&(place as u32));
        let start = self.movie.starts[self.movie.start_before(first as usize)] as usize;
        let mut saved = BTreeSet::new();
        for stop in (self.next.saturating_sub(SUSPECTS)..=self.next).rev().filter(|&stop| stop > start) {
            let mut again = Self::new(Arc::clone(&self.movie), start)?;
            while again.next < stop && again.decode().is_ok() {
                again.next += 1;
                again.ready.retain(|(place, _)| is_lost(*place));
            }
            again.flush();
            // With a picture for every sample, each surely has its own.
            if again.next == stop && again.ready.iter().all(|(_, d)| !matches!(d, Decoded::Damaged(_))) {
                again.ready.retain(|(place, _)| is_lost(*place));
                saved.extend(again.ready.iter().map(|(place, _)| *place as u32));
                self.ready.extend(again.ready);
                break;
            }
        }
        for &place in lost.difference(&saved) {
            let why = format!("its data at byte {} is damaged", self.offset_of(place));
            self.ready.push_back((place as usize, Decoded::Damaged(Damage { why, first: place as usize })));
        }
        Ok(())
    }

    fn offset_of(&self, place: u32) -> u64 {
        self.movie.track.samples[self.movie.shown[place as usize] as usize].offset
    }

    /// After damage: what was good comes out, everything up to the next start is damaged, and decoding goes on there.
    fn skip_damage(&mut self, why: &str) -> Result<()> {
        self.recover()?;
        let starts = &self.movie.starts;
        let resume = starts.get(starts.partition_point(|&s| s as usize <= self.next));
        let resume = resume.map_or(self.movie.whole, |&s| s as usize);
        let at = self.movie.track.samples[self.next].offset;
        let spoiled = &self.movie.rank[self.next..resume];
        // Damage can also show as a picture that never came out.
        let missing = self.ready.iter().filter(|(_, d)| matches!(d, Decoded::Damaged(_))).map(|(place, _)| *place);
        let first = spoiled.iter().map(|&place| place as usize).chain(missing).min().unwrap_or(0);
        for (i, &place) in spoiled.iter().enumerate() {
            let whose = if i == 0 { "its data" } else { "it builds on data" };
            let why = format!("{whose} at byte {at} {}{why}", if i == 0 { "" } else { "that " });
            self.ready.push_back((place as usize, Decoded::Damaged(Damage { why, first })));
        }
        self.ready.make_contiguous().sort_by_key(|r| r.0);
        self.next = resume;
        self.decoder = new_decoder(&self.movie)?;
        Ok(())
    }
}

fn new_decoder(movie: &Movie) -> Result<Decoder> {
    // Flushing after each sample, the crate's default, breaks streams whose pictures are reordered.
    let config = DecoderConfig::new().flush_after_decode(Flush::NoFlush);
    Decoder::with_api_config(OpenH264API::from_source(), config)
        .map_err(|_| Error::file(&movie.path, "the H.264 decoder cannot be started", "free some memory and try again"))
}

/// Copies a decoded picture out and gives it the earliest place among those inside.
fn take(movie: &Movie, inside: &mut BTreeSet<u32>, ready: &mut VecDeque<(usize, Decoded)>, picture: &DecodedYUV<'_>) {
    let Some(place) = inside.pop_first() else { return };
    let (width, height) = picture.dimensions();
    let decoded = if (width as u32, height as u32) == movie.size {
        let (cw, ch) = (width.div_ceil(2), height.div_ceil(2));
        let (sy, su, sv) = picture.strides();
        let mut data = Vec::with_capacity(width * height + 2 * cw * ch);
        for (plane, stride, w, h) in
            [(picture.y(), sy, width, height), (picture.u(), su, cw, ch), (picture.v(), sv, cw, ch)]
        {
            plane.chunks(stride.max(1)).take(h).for_each(|row| data.extend_from_slice(&row[..w.min(row.len())]));
        }
        Decoded::Planes(Planes {
            width,
            height,
            data: data.into(),
            color: movie.color,
            orientation: movie.track.orientation,
        })
    } else {
        Decoded::Damaged(Damage { why: "it changes the size of the picture".to_owned(), first: place as usize })
    };
    ready.push_back((place as usize, decoded));
}

impl Stream for H264Stream {
    fn next(&mut self) -> Result<Option<(usize, Decoded)>> {
        loop {
            if let Some(out) = self.ready.pop_front() {
                return Ok(Some(out));
            }
            if self.next < self.movie.whole {
                let at_start = self.movie.starts.binary_search(&(self.next as u32)).is_ok();
                match self.decode() {
                    // What the decoder minds may be the sample before.
                    Err(_) if at_start && self.tried_again != Some(self.next) => {
                        self.tried_again = Some(self.next);
                        self.recover()?;
                        self.decoder = new_decoder(&self.movie)?;
                    }
                    Ok(()) => self.next += 1,
                    Err(why) => self.skip_damage(&why)?,
                }
            } else if self.inside.is_empty() {
                return Ok(None);
            } else {
                self.flush();
            }
        }
    }
}
