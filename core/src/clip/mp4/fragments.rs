//! Samples of a fragmented file (ISO/IEC 14496-12, 8.8): cameras and browsers write a movie box without samples, then
//! a fragment every few seconds, so that a recording that is cut off keeps what came before.

use super::boxes::{Fields, child, children};
use super::track::{MAX_SAMPLES, Sample, Track};

/// What holds for a fragment's samples where nothing else is said.
#[derive(Clone, Copy, Default)]
pub(super) struct Defaults {
    duration: u32,
    size: u32,
    flags: u32,
}

impl Defaults {
    /// From the movie box's contents, for the track (trex).
    pub(super) fn from_movie(moov: &[u8], track: u32) -> Self {
        child(moov, b"mvex")
            .into_iter()
            .flat_map(children)
            .filter(|(name, _)| name == b"trex")
            .find_map(|(_, trex)| {
                let mut fields = Fields(trex);
                fields.version_and_flags()?;
                (fields.u32()? == track).then_some(())?;
                fields.u32()?; // sample description
                Some(Self { duration: fields.u32()?, size: fields.u32()?, flags: fields.u32()? })
            })
            .unwrap_or_default()
    }
}

/// Appends the samples of a fragment, whose box began at `start` in the file. [`None`] when it is cut off.
pub(super) fn append(track: &mut Track, moof: &[u8], start: u64, defaults: Defaults) -> Option<()> {
    let mut data_end = start;
    for (_, traf) in children(moof).filter(|(name, _)| name == b"traf") {
        let mut fields = Fields(child(traf, b"tfhd")?);
        let (_, flags) = fields.version_and_flags()?;
        let ours = fields.u32()? == track.id;
        let base = if flags & 0x1 != 0 {
            fields.u64()?
        } else if flags & 0x2_0000 != 0 {
            start
        } else {
            data_end
        };
        if flags & 0x2 != 0 {
            fields.u32()?; // sample description
        }
        let mut or_default = |flag: u32, default: u32| if flags & flag != 0 { fields.u32() } else { Some(default) };
        let own = Defaults {
            duration: or_default(0x8, defaults.duration)?,
            size: or_default(0x10, defaults.size)?,
            flags: or_default(0x20, defaults.flags)?,
        };
        let mut time = match child(traf, b"tfdt") {
            Some(tfdt) => {
                let mut fields = Fields(tfdt);
                let long = fields.version_and_flags()?.0 == 1;
                let time = if long { fields.u64()? } else { fields.u32()?.into() };
                i64::try_from(time).ok()?
            }
            None => track.samples.last().map_or(0, |s| s.shown_at.saturating_add(s.duration.into())),
        };
        data_end = base;
        for (_, trun) in children(traf).filter(|(name, _)| name == b"trun") {
            let mut run = Fields(trun);
            let (_, flags) = run.version_and_flags()?;
            let count = run.u32()?;
            if flags & 0x1 != 0 {
                data_end = base.saturating_add_signed(run.i32()?.into());
            }
            if !ours && flags & 0x200 == 0 {
                data_end = data_end.saturating_add(u64::from(count) * u64::from(own.size));
                continue;
            }
            let mut first_flags = if flags & 0x4 != 0 { Some(run.u32()?) } else { None };
            for _ in 0..count {
                let mut or_own = |flag: u32, own: u32| if flags & flag != 0 { run.u32() } else { Some(own) };
                let duration = or_own(0x100, own.duration)?;
                let size = or_own(0x200, own.size)?;
                let sample_flags = or_own(0x400, own.flags)?;
                let delay = or_own(0x800, 0)?.cast_signed();
                let sample_flags = first_flags.take().unwrap_or(sample_flags);
                if ours {
                    // Samples of no bytes in a run without an entry each would cost nothing to claim by the billion.
                    if track.samples.len() >= MAX_SAMPLES || size == 0 {
                        return None;
                    }
                    // Bit 16 is sample_is_non_sync_sample (8.8.3.1).
                    let sync = sample_flags >> 16 & 1 == 0;
                    let shown_at = time.saturating_add(delay.into());
                    track.samples.push(Sample { offset: data_end, size, sync, shown_at, duration });
                }
                time = time.saturating_add(duration.into());
                data_end = data_end.saturating_add(size.into());
            }
        }
    }
    Some(())
}
