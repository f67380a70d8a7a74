//! The video track of an MP4 or QuickTime file: where its samples lie, when they are shown, and how to look at them.
//!
//! ISO/IEC 14496-12: sample tables (8.6, 8.7), edit lists (8.6.6), track header (8.3.2), colour information (12.1.5);
//! ISO/IEC 14496-15: the decoder configuration of H.264 (5.3.3).

use super::boxes::{Fields, child, children, descendant, readable};
use super::sps::Sps;
use crate::clip::orientation::Orientation;

/// One coded picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Bytes from the start of the file.
    pub(super) offset: u64,
    pub(super) size: u32,
    /// Decoding can begin here, by the file's word.
    pub(super) sync: bool,
    /// When it is shown, ticks.
    pub(super) shown_at: i64,
    /// Ticks until the next in decoding order.
    pub(super) duration: u32,
}

/// A stretch of the track that is shown (an entry of the edit list).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edit {
    /// Ticks of the track.
    pub(super) from: i64,
    pub(super) to: i64,
}

#[derive(Debug)]
pub(super) struct Track {
    pub(super) id: u32,
    /// Ticks a second.
    pub(super) timescale: u32,
    pub(super) samples: Vec<Sample>,
    /// All of it when empty.
    pub(super) edits: Vec<Edit>,
    pub(super) orientation: Orientation,
    /// Sequence parameter sets, then picture parameter sets, each a NAL unit.
    pub(super) parameter_sets: Vec<Vec<u8>>,
    /// Bytes of the number before each NAL unit.
    pub(super) length_bytes: usize,
    /// matrix_coefficients and range of a colr box.
    pub(super) container_color: Option<(u16, Option<bool>)>,
    pub(super) warnings: Vec<String>,
}

/// Why there is no track.
#[derive(Debug)]
pub(super) enum NoTrack {
    /// The file is broken: what is wrong with it.
    Broken(String),
    /// The file is whole, but this is not for the embedded decoder.
    Unsupported(String),
}

/// More pictures than a day of film at 30 a second holds.
pub(super) const MAX_SAMPLES: usize = 1 << 22;

fn broken(what: &str) -> NoTrack {
    NoTrack::Broken(what.to_owned())
}

impl Track {
    /// The first H.264 track of the movie box's contents.
    pub(super) fn from_movie(moov: &[u8]) -> Result<Self, NoTrack> {
        let movie_timescale = child(moov, b"mvhd").and_then(|b| times_header(b).map(|(_, t)| t)).unwrap_or(0);
        let mut other = None;
        for (_, trak) in children(moov).filter(|(name, _)| name == b"trak") {
            let Some(mdia) = child(trak, b"mdia") else { continue };
            if child(mdia, b"hdlr").and_then(|h| h.get(8..12)) != Some(b"vide") {
                continue;
            }
            match Self::from_trak(trak, mdia, movie_timescale) {
                Ok(track) => return Ok(track),
                Err(why) => {
                    other.get_or_insert(why);
                }
            }
        }
        Err(other.unwrap_or_else(|| broken("holds no video track")))
    }

    fn from_trak(trak: &[u8], mdia: &[u8], movie_timescale: u32) -> Result<Self, NoTrack> {
        let tkhd = child(trak, b"tkhd").ok_or_else(|| broken("has a track without a header (tkhd)"))?;
        let timescale = child(mdia, b"mdhd").and_then(|b| times_header(b).map(|(_, t)| t)).filter(|&t| t > 0);
        let timescale = timescale.ok_or_else(|| broken("has a track without a time scale (mdhd)"))?;
        let stbl = descendant(mdia, &[b"minf", b"stbl"]).ok_or_else(|| broken("has a track without samples (stbl)"))?;
        let stsd = child(stbl, b"stsd").ok_or_else(|| broken("has a track without a description (stsd)"))?;
        let mut track = Self {
            id: 0,
            timescale,
            samples: Vec::new(),
            edits: Vec::new(),
            orientation: Orientation::default(),
            parameter_sets: Vec::new(),
            length_bytes: 4,
            container_color: None,
            warnings: Vec::new(),
        };
        track.read_description(stsd)?;
        track.read_header(tkhd).ok_or_else(|| broken("has a track header (tkhd) that is cut off"))?;
        if let Some(elst) = descendant(trak, &[b"edts", b"elst"]) {
            track.read_edits(elst, movie_timescale);
        }
        track.read_samples(stbl)?;
        Ok(track)
    }

    /// Sample description (8.5.2) with the AVC configuration.
    fn read_description(&mut self, stsd: &[u8]) -> Result<(), NoTrack> {
        let entries = children(stsd.get(8..).unwrap_or_default());
        let mut described = false;
        for (name, entry) in entries {
            if &name != b"avc1" && &name != b"avc3" {
                return Err(NoTrack::Unsupported(format!("video of the kind `{}`", readable(&name))));
            }
            if described {
                return Err(NoTrack::Unsupported("H.264 that changes its description midway".to_owned()));
            }
            described = true;
            // A VisualSampleEntry has 78 bytes before its own boxes.
            let inner = entry.get(78..).unwrap_or_default();
            let avcc =
                child(inner, b"avcC").ok_or_else(|| broken("describes H.264 without its configuration (avcC)"))?;
            self.read_avcc(avcc).ok_or_else(|| broken("has an H.264 configuration (avcC) that is cut off"))?;
            self.container_color = child(inner, b"colr").and_then(read_colr);
        }
        if described { Ok(()) } else { Err(broken("has a track without a description (stsd)")) }
    }

    fn read_avcc(&mut self, avcc: &[u8]) -> Option<()> {
        let mut fields = Fields(avcc);
        fields.take(4)?; // version, profile, constraints, level
        self.length_bytes = usize::from(fields.u8()? & 3) + 1;
        for mask in [0x1f, 0xff] {
            for _ in 0..fields.u8()? & mask {
                let length = fields.u16()?;
                self.parameter_sets.push(fields.take(usize::from(length))?.to_vec());
            }
        }
        Some(())
    }

    fn read_header(&mut self, tkhd: &[u8]) -> Option<()> {
        let mut fields = Fields(tkhd);
        let long = fields.version_and_flags()?.0 == 1;
        fields.take(if long { 16 } else { 8 })?;
        self.id = fields.u32()?;
        fields.take(if long { 12 } else { 8 })?;
        fields.take(16)?; // reserved, layer, group, volume
        let mut matrix = [0i32; 5];
        for value in &mut matrix {
            *value = fields.i32()?;
        }
        let [a, b, _, c, d] = matrix;
        match Orientation::from_matrix([a, b, c, d]) {
            Some(orientation) => self.orientation = orientation,
            None => self.warnings.push("turned by other than a quarter turn; shown as stored".to_owned()),
        }
        Some(())
    }

    fn read_edits(&mut self, elst: &[u8], movie_timescale: u32) -> Option<()> {
        let mut fields = Fields(elst);
        let long = fields.version_and_flags()?.0 == 1;
        for _ in 0..fields.u32()? {
            let (duration, from) = if long {
                (fields.u64()?, fields.u64()?.cast_signed())
            } else {
                (u64::from(fields.u32()?), i64::from(fields.i32()?))
            };
            fields.u32()?; // rate
            if from < 0 {
                continue; // an empty edit only delays
            }
            let ticks = u128::from(duration) * u128::from(self.timescale) / u128::from(movie_timescale.max(1));
            // Fragmented files are written before their duration is known, with 0.
            let length = if duration == 0 { i64::MAX } else { i64::try_from(ticks).unwrap_or(i64::MAX) };
            self.edits.push(Edit { from, to: from.saturating_add(length) });
            if self.edits.len() > 10_000 {
                self.warnings.push("has more than 10000 edits; the rest is left out".to_owned());
                break;
            }
        }
        Some(())
    }

    fn read_samples(&mut self, stbl: &[u8]) -> Result<(), NoTrack> {
        let table = |name| {
            let mut fields = Fields(child(stbl, name).unwrap_or_default());
            fields.version_and_flags();
            fields
        };
        let mut sizes = Sizes::new(child(stbl, b"stsz"), child(stbl, b"stz2"))
            .ok_or_else(|| broken("has a track without sample sizes (stsz)"))?;
        let mut durations = Runs::new(table(b"stts"));
        let mut delays = Runs::new(table(b"ctts"));
        let mut syncs = child(stbl, b"stss").map(|_| Syncs::new(table(b"stss")));
        let long = child(stbl, b"co64").is_some();
        let mut offsets = table(if long { b"co64" } else { b"stco" });
        let chunk_count = offsets.u32().unwrap_or(0);
        let mut chunk_runs = ChunkRuns::new(table(b"stsc"));
        let mut time = 0i64;
        for chunk in 1..=chunk_count {
            if sizes.left == 0 {
                break;
            }
            let offset = if long { offsets.u64() } else { offsets.u32().map(u64::from) };
            let (Some(mut offset), Some(in_chunk)) = (offset, chunk_runs.samples_in(chunk)) else { break };
            for _ in 0..in_chunk {
                let Some(size) = sizes.next() else { break };
                if self.samples.len() >= MAX_SAMPLES {
                    return Err(NoTrack::Broken(format!("claims more than {MAX_SAMPLES} pictures")));
                }
                let duration = durations.next().unwrap_or(0);
                // Version 0 says unsigned, yet QuickTime writes negative numbers there too.
                let delay = delays.next().unwrap_or(0).cast_signed();
                let sync = syncs.as_mut().is_none_or(|s| s.contains(self.samples.len() as u32 + 1));
                self.samples.push(Sample { offset, size, sync, shown_at: time.saturating_add(delay.into()), duration });
                time = time.saturating_add(duration.into());
                offset = offset.saturating_add(size.into());
            }
        }
        if sizes.left > 0 {
            self.warnings.push(format!("the index ends {} pictures early; the ones before can be used", sizes.left));
        }
        Ok(())
    }

    /// The sequence parameter set of the configuration.
    pub(super) fn sps(&self) -> Option<Sps> {
        self.parameter_sets
            .iter()
            .find(|nal| nal.first().is_some_and(|b| b & 0x1f == 7))
            .and_then(|nal| Sps::parse(nal))
    }
}

/// Duration and time scale of an mvhd or mdhd.
fn times_header(data: &[u8]) -> Option<(u64, u32)> {
    let mut fields = Fields(data);
    let long = fields.version_and_flags()?.0 == 1;
    fields.take(if long { 16 } else { 8 })?;
    let timescale = fields.u32()?;
    let duration = if long { fields.u64()? } else { fields.u32()?.into() };
    Some((duration, timescale))
}

fn read_colr(colr: &[u8]) -> Option<(u16, Option<bool>)> {
    let mut fields = Fields(colr);
    let kind = fields.take(4)?;
    fields.take(4)?; // primaries, transfer
    let matrix = fields.u16()?;
    match kind {
        b"nclx" => Some((matrix, fields.u8().map(|b| b & 0x80 != 0))),
        b"nclc" => Some((matrix, None)),
        _ => None,
    }
}

/// Sample sizes (8.7.3), whatever their form.
struct Sizes<'a> {
    fields: Fields<'a>,
    same: u32,
    /// Bits an entry, where they differ: 4, 8, 16 or 32.
    bits: u8,
    low_half: Option<u8>,
    left: u32,
}

impl<'a> Sizes<'a> {
    fn new(stsz: Option<&'a [u8]>, stz2: Option<&'a [u8]>) -> Option<Self> {
        let (mut fields, compact) = (Fields(stsz.or(stz2)?), stsz.is_none());
        fields.version_and_flags()?;
        let first = fields.u32()?;
        let left = fields.u32()?;
        let (same, bits) = if compact { (0, first as u8) } else { (first, 32) };
        matches!(bits, 4 | 8 | 16 | 32).then_some(Self { fields, same, bits, low_half: None, left })
    }

    fn next(&mut self) -> Option<u32> {
        if self.left == 0 {
            return None;
        }
        let size = match (self.same, self.bits) {
            (0, 32) => self.fields.u32()?,
            (0, 16) => self.fields.u16()?.into(),
            (0, 8) => self.fields.u8()?.into(),
            (0, _) => match self.low_half.take() {
                Some(low) => low.into(),
                None => {
                    let both = self.fields.u8()?;
                    self.low_half = Some(both & 15);
                    (both >> 4).into()
                }
            },
            (same, _) => same,
        };
        self.left -= 1;
        Some(size)
    }
}

/// Runs of (count, value): stts and ctts (8.6.1). The last value goes on.
struct Runs<'a> {
    fields: Fields<'a>,
    left: u32,
    value: Option<u32>,
}

impl<'a> Runs<'a> {
    fn new(mut fields: Fields<'a>) -> Self {
        fields.u32();
        Self { fields, left: 0, value: None }
    }

    fn next(&mut self) -> Option<u32> {
        while self.left == 0 {
            let (Some(count), Some(value)) = (self.fields.u32(), self.fields.u32()) else { return self.value };
            (self.left, self.value) = (count, Some(value));
        }
        self.left -= 1;
        self.value
    }
}

/// Numbers of the samples that stand alone (8.6.2), asked for in rising order.
struct Syncs<'a> {
    fields: Fields<'a>,
    next: Option<u32>,
}

impl<'a> Syncs<'a> {
    fn new(mut fields: Fields<'a>) -> Self {
        fields.u32();
        let next = fields.u32();
        Self { fields, next }
    }

    fn contains(&mut self, number: u32) -> bool {
        while self.next.is_some_and(|n| n < number) {
            self.next = self.fields.u32();
        }
        self.next == Some(number)
    }
}

/// How many samples each chunk has (8.7.4), asked for in rising order.
struct ChunkRuns<'a> {
    fields: Fields<'a>,
    current: Option<u32>,
    following: Option<(u32, u32)>,
}

impl<'a> ChunkRuns<'a> {
    fn new(mut fields: Fields<'a>) -> Self {
        fields.u32();
        let mut runs = Self { fields, current: None, following: None };
        runs.following = runs.entry();
        runs
    }

    fn entry(&mut self) -> Option<(u32, u32)> {
        let first_chunk = self.fields.u32()?;
        let samples = self.fields.u32()?;
        self.fields.u32()?; // sample description
        Some((first_chunk, samples))
    }

    fn samples_in(&mut self, chunk: u32) -> Option<u32> {
        while let Some((first, samples)) = self.following.filter(|f| f.0 <= chunk) {
            debug_assert!(first <= chunk);
            self.current = Some(samples);
            self.following = self.entry();
        }
        self.current
    }
}
