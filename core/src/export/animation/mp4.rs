//! An mp4 file with one track of H.264 (ISO/IEC 14496-12 and -15), its index before its pictures, so that it plays while it
//! arrives. Every frame lasts the same whole number of ticks.
//!
//! Ours rather than a crate's: the pictures wait in a file, not in memory, and times are fractions, not floating point.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::export::write_aside::Aside;

/// NAL unit types (H.264, table 7-1).
const SEQUENCE: u8 = 7;
const PICTURE: u8 = 8;
/// The transformation that changes nothing, in the fixed point of the format.
const UPRIGHT: [u32; 9] = [1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30];

/// A file in the making.
pub(super) struct Movie {
    path: PathBuf,
    /// The coded pictures, until there is an index to put before them.
    pictures: Aside,
    size: (u32, u32),
    /// Ticks a second, and for each frame.
    ticks: (u32, u32),
    /// The bytes of each picture.
    lengths: Vec<u32>,
    /// Pictures that stand alone, counted from 1.
    alone: Vec<u32>,
    sequence: Vec<u8>,
    picture: Vec<u8>,
}

impl Movie {
    pub(super) fn begin(path: &Path, size: (u32, u32), ticks: (u32, u32)) -> Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            pictures: Aside::begin(path)?,
            size,
            ticks,
            lengths: Vec::new(),
            alone: Vec::new(),
            sequence: Vec::new(),
            picture: Vec::new(),
        })
    }

    /// Adds a picture as a byte stream (H.264, annex B).
    pub(super) fn add(&mut self, stream: &[u8], alone: bool) -> Result<()> {
        let before = self.pictures.length();
        for unit in units(stream) {
            match unit.first().map(|b| b & 0x1f) {
                Some(SEQUENCE) => self.sequence = unit.to_vec(),
                Some(PICTURE) => self.picture = unit.to_vec(),
                Some(_) => {
                    self.pictures.write(&(unit.len() as u32).to_be_bytes())?;
                    self.pictures.write(unit)?;
                }
                None => {}
            }
        }
        let length = self.pictures.length() - before;
        if length == 0 {
            let problem = format!("gave nothing for frame {}", self.lengths.len());
            return Err(Error::invalid("the H.264 encoder", problem, "write another format"));
        }
        self.lengths.push(length as u32);
        if alone {
            self.alone.push(self.lengths.len() as u32);
        }
        Ok(())
    }

    /// Puts the file in its place.
    pub(super) fn commit(self) -> Result<PathBuf> {
        let duration = self.lengths.len() as u64 * u64::from(self.ticks.1);
        if self.sequence.len() < 4 || duration > u32::MAX.into() {
            let remedy = "write fewer frames, or another format".into();
            let (what, max) = ("the length of an mp4 in ticks".into(), u32::MAX.into());
            return Err(Error::Limit { what, value: duration, max, remedy });
        }
        let brands: [&[u8]; 6] = [b"isom", &0x200u32.to_be_bytes(), b"isom", b"iso2", b"avc1", b"mp41"];
        let kind = boxed(b"ftyp", &brands);
        let bytes = self.pictures.length();
        let head = if bytes + 8 > u32::MAX.into() {
            [&1u32.to_be_bytes()[..], b"mdat", &(bytes + 16).to_be_bytes()].concat()
        } else {
            [&(bytes as u32 + 8).to_be_bytes()[..], b"mdat"].concat()
        };
        // The index is as long wherever it says the pictures are.
        let place = kind.len() + self.index(0, duration as u32).len() + head.len();
        let index = self.index(place as u32, duration as u32);
        let mut file = Aside::begin(&self.path)?;
        [kind, index, head].iter().try_for_each(|part| file.write(part))?;
        file.append(self.pictures)?;
        file.commit()
    }

    fn index(&self, place: u32, duration: u32) -> Vec<u8> {
        let (ticks, each) = self.ticks;
        let (width, height) = self.size;
        let count = self.lengths.len() as u32;
        let numbers = |values: &[u32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_be_bytes()).collect() };
        let upright = numbers(&UPRIGHT);

        // Version 0: made at no time; plays at its own rate and volume; the next track would be the second.
        let movie = [numbers(&[0, 0, 0, ticks, duration, 1 << 16, 1 << 24, 0, 0]), upright.clone(), numbers(&[0; 6])];
        let movie = boxed(b"mvhd", &[&movie.concat(), &numbers(&[2])]);
        // Enabled, in the movie; the first track.
        let track = [numbers(&[3, 0, 0, 1, 0, duration, 0, 0, 0, 0]), upright, numbers(&[width << 16, height << 16])];
        let track = boxed(b"tkhd", &[&track.concat()]);
        // No language.
        let media = boxed(b"mdhd", &[&numbers(&[0, 0, 0, ticks, duration, 0x55c4 << 16])]);
        let handler = boxed(b"hdlr", &[&numbers(&[0, 0]), b"vide", &numbers(&[0; 3]), b"video\0"]);
        let shown = boxed(b"vmhd", &[&numbers(&[1, 0, 0])]);
        let here = boxed(b"url ", &[&numbers(&[1])]);
        let data = boxed(b"dinf", &[&boxed(b"dref", &[&numbers(&[0, 1]), &here])]);

        let mut sample = vec![0u8; 78];
        // The description refers to the first data entry; 72 dots an inch, one frame a sample, 24 bits.
        sample[7] = 1;
        sample[24..28].copy_from_slice(&numbers(&[width << 16 | height]));
        sample[28..36].copy_from_slice(&numbers(&[72 << 16, 72 << 16]));
        sample[41] = 1;
        sample[74..78].copy_from_slice(&[0, 24, 0xff, 0xff]);
        let colour = boxed(b"colr", &[b"nclx", &[0, 1, 0, 1, 0, 1, 0]]);
        let sample = boxed(b"avc1", &[&sample, &boxed(b"avcC", &[&self.configuration()]), &colour]);

        let table = [
            boxed(b"stsd", &[&numbers(&[0, 1]), &sample]),
            boxed(b"stts", &[&numbers(&[0, 1, count, each])]),
            boxed(b"stss", &[&numbers(&[0, self.alone.len() as u32]), &numbers(&self.alone)]),
            // All in one chunk.
            boxed(b"stsc", &[&numbers(&[0, 1, 1, count, 1])]),
            boxed(b"stsz", &[&numbers(&[0, 0, count]), &numbers(&self.lengths)]),
            boxed(b"stco", &[&numbers(&[0, 1, place])]),
        ];
        let information = boxed(b"minf", &[&shown, &data, &boxed(b"stbl", &[&table.concat()])]);
        let media = boxed(b"mdia", &[&media, &handler, &information]);
        boxed(b"moov", &[&movie, &boxed(b"trak", &[&track, &media])])
    }

    /// AVCDecoderConfigurationRecord: profile and level, lengths of four bytes, one parameter set of each kind.
    fn configuration(&self) -> Vec<u8> {
        let length = |unit: &[u8]| (unit.len() as u16).to_be_bytes();
        let [profile, compatible, level] = [1, 2, 3].map(|i| self.sequence[i]);
        let mut out = vec![1, profile, compatible, level, 0xff, 0xe1];
        out.extend(length(&self.sequence));
        out.extend(&self.sequence);
        out.push(1);
        out.extend(length(&self.picture));
        out.extend(&self.picture);
        if matches!(profile, 100 | 110 | 122 | 144) {
            // 4:2:0, eight bits, nothing more.
            out.extend([0xfd, 0xf8, 0xf8, 0]);
        }
        out
    }
}

fn boxed(name: &[u8; 4], parts: &[&[u8]]) -> Vec<u8> {
    let length: usize = 8 + parts.iter().map(|p| p.len()).sum::<usize>();
    let mut out = Vec::with_capacity(length);
    out.extend((length as u32).to_be_bytes());
    out.extend(name);
    parts.iter().for_each(|p| out.extend(*p));
    out
}

/// The NAL units of a byte stream: what lies between start codes, without zeros at the end.
fn units(stream: &[u8]) -> impl Iterator<Item = &[u8]> {
    let start = |from: usize| stream[from..].windows(3).position(|w| w == [0, 0, 1]).map(|at| from + at);
    let mut at = start(0);
    std::iter::from_fn(move || {
        let begin = at? + 3;
        at = start(begin);
        let unit = &stream[begin..at.unwrap_or(stream.len())];
        let end = unit.iter().rposition(|b| *b != 0).map_or(0, |i| i + 1);
        Some(&unit[..end])
    })
}
