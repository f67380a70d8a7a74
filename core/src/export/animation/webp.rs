//! Animated WebP (RFC 9649), lossless: stills by the `image-webp` crate, in the extended container with what changed in each
//! frame. Times are whole thousandths of a second that add up to the animation's.

use std::path::{Path, PathBuf};

use image_webp::{ColorType, WebPEncoder};

use super::{Animation, Rect, milliseconds};
use crate::error::{Error, Result};
use crate::export::write_aside::Aside;
use crate::job::Stage;

/// Pixels a side.
const LONGEST: u32 = 1 << 14;
/// `RIFF`, the size, `WEBP`, and the head of a chunk.
const STILL_HEAD: usize = 12;

pub(super) fn write(path: &Path, animation: &Animation<'_>, stage: Stage<'_>) -> Result<Vec<PathBuf>> {
    let (width, height) = animation.size;
    if width.max(height) > LONGEST {
        return Err(Error::Limit {
            what: "the longer side of an animated WebP".into(),
            value: width.max(height).into(),
            max: LONGEST.into(),
            remedy: "scale it down".into(),
        });
    }
    let mut file = Aside::begin(path)?;
    let u24 = |v: u32| [v as u8, (v >> 8) as u8, (v >> 16) as u8];
    file.write(b"RIFF\0\0\0\0WEBP")?;
    let [w, h] = [width, height].map(|v| u24(v - 1));
    // With opacity, and animated.
    let head = [&[0x12, 0, 0, 0][..], &w, &h].concat();
    chunk(&mut file, b"VP8X", &[&head])?;
    // Nothing behind it; forever.
    chunk(&mut file, b"ANIM", &[&[0; 6]])?;
    let pack = |_: usize, before: Option<&_>, now: &_| {
        let mut rect = Rect::changed(before, now);
        // Places are counted in pairs of pixels.
        (rect.width, rect.height) = (rect.width + rect.x % 2, rect.height + rect.y % 2);
        (rect.x, rect.y) = (rect.x - rect.x % 2, rect.y - rect.y % 2);
        let mut still = Vec::new();
        WebPEncoder::new(&mut still)
            .encode(rect.cut(now).as_raw(), rect.width, rect.height, ColorType::Rgba8)
            .map_err(|e| Error::invalid("an animated WebP", e.to_string(), "draw it smaller"))?;
        Ok((rect, still))
    };
    animation.each(stage, pack, |frame, (rect, still)| {
        let shown = u24(milliseconds(frame, animation.fps).max(1));
        let place = [rect.x / 2, rect.y / 2, rect.width - 1, rect.height - 1].map(u24);
        // It stays, and replaces what is there.
        chunk(&mut file, b"ANMF", &[place.as_flattened(), &shown, &[2], &still[STILL_HEAD..]])
    })?;
    let length = file.length() - 8;
    let Ok(length) = u32::try_from(length) else {
        let remedy = "write fewer frames, or scale them down".into();
        return Err(Error::Limit {
            what: "the size of an animated WebP".into(),
            value: length,
            max: u32::MAX.into(),
            remedy,
        });
    };
    file.write_at(4, &length.to_le_bytes())?;
    file.commit()?;
    Ok(vec![path.to_owned()])
}

fn chunk(file: &mut Aside, name: &[u8; 4], parts: &[&[u8]]) -> Result<()> {
    let length: usize = parts.iter().map(|p| p.len()).sum();
    file.write(name)?;
    file.write(&(length as u32).to_le_bytes())?;
    parts.iter().try_for_each(|p| file.write(p))?;
    if length % 2 == 1 { file.write(&[0]) } else { Ok(()) }
}
