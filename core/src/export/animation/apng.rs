//! Animated PNG (PNG specification, third edition, 11.3.6): each frame holds what changed, and replaces it. Opacity is exact,
//! and so are times: fractions of whole numbers.

use std::path::{Path, PathBuf};

use super::{Animation, Rect, rate};
use crate::error::{Error, Result};
use crate::export::png::encode_rgba;
use crate::export::write_aside::Aside;
use crate::job::Stage;

const SIGNATURE: [u8; 8] = [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n'];

pub(super) fn write(path: &Path, animation: &Animation<'_>, stage: Stage<'_>) -> Result<Vec<PathBuf>> {
    let (width, height) = animation.size;
    let Ok(count) = u32::try_from(animation.frames) else {
        return Err(Error::invalid("an animated PNG", "has too many frames", "write fewer"));
    };
    let (of, delay) = rate::fraction(animation.fps, u16::MAX.into());
    let mut file = Aside::begin(path)?;
    file.write(&SIGNATURE)?;
    let [w, h] = [width, height].map(u32::to_be_bytes);
    // 8 bits, colours with alpha, the only compression and filtering there are, not interlaced.
    chunk(&mut file, b"IHDR", &[&w, &h, &[8, 6, 0, 0, 0]])?;
    // Forever.
    chunk(&mut file, b"acTL", &[&count.to_be_bytes(), &0u32.to_be_bytes()])?;
    let mut sequence = 0u32;
    let pack = |_: usize, before: Option<&_>, now: &_| {
        let rect = Rect::changed(before, now);
        Ok((rect, encode_rgba(&rect.cut(now))?))
    };
    animation.each(stage, pack, |frame, (rect, png)| {
        let mut next = || {
            sequence += 1;
            (sequence - 1).to_be_bytes()
        };
        let Rect { x, y, width, height } = rect;
        let [w, h, x, y] = [width, height, x, y].map(u32::to_be_bytes);
        let [delay, of] = [delay, of].map(|v| (v as u16).to_be_bytes());
        // It stays, and replaces what is there.
        chunk(&mut file, b"fcTL", &[&next(), &w, &h, &x, &y, &delay, &of, &[0, 0]])?;
        for data in data_of(&png) {
            if frame == 0 {
                chunk(&mut file, b"IDAT", &[data])?;
            } else {
                chunk(&mut file, b"fdAT", &[&next(), data])?;
            }
        }
        Ok(())
    })?;
    chunk(&mut file, b"IEND", &[])?;
    file.commit()?;
    Ok(vec![path.to_owned()])
}

fn chunk(file: &mut Aside, name: &[u8; 4], parts: &[&[u8]]) -> Result<()> {
    let length: usize = parts.iter().map(|p| p.len()).sum();
    let mut sum = crc32fast::Hasher::new();
    file.write(&(length as u32).to_be_bytes())?;
    for part in std::iter::once(&&name[..]).chain(parts) {
        sum.update(part);
        file.write(part)?;
    }
    file.write(&sum.finalize().to_be_bytes())
}

/// The compressed pixels of a PNG.
fn data_of(png: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = png.get(SIGNATURE.len()..).unwrap_or_default();
    std::iter::from_fn(move || {
        loop {
            let (head, body) = rest.split_at_checked(8)?;
            let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
            let data = body.get(..length)?;
            rest = body.get(length + 4..)?;
            if &head[4..] == b"IDAT" {
                return Some(data);
            }
        }
    })
}
