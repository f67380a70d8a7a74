//! GIF (GIF89a specification): blocks walked for the index, pictures by the `gif` crate, composed here.

use std::fs::File;
use std::io::BufReader;
use std::num::NonZeroU64;
use std::path::Path;

use gif::DisposalMethod;

use super::{Frames, Index, MAX_FRAMES, Walk, opened, walked};
use crate::clip::{Attempt, ClipOptions, Opened, Picture};
use crate::error::{Error, Result};
use crate::job::Stage;

/// Delays this short, in hundredths of a second, are shown by browsers as a tenth.
const NO_DELAY: u16 = 1;

pub(in crate::clip) fn open(path: &Path, options: &ClipOptions, stage: Stage<'_>) -> Attempt<Opened> {
    let index = walked(path, stage, scan)?;
    opened(path, options, "gif", index, None, start)
}

fn scan<R: std::io::Read + std::io::Seek>(mut walk: Walk<'_, R>) -> std::io::Result<Index> {
    let mut index = Index::default();
    index.problem = scan_blocks(&mut walk, &mut index)?;
    Ok(index)
}

/// Fills the index up to the end of the animation; the answer is what is wrong there.
fn scan_blocks<R: std::io::Read + std::io::Seek>(
    walk: &mut Walk<'_, R>,
    index: &mut Index,
) -> std::io::Result<Option<String>> {
    let cut = |walk: &Walk<'_, R>| Ok(Some(format!("is cut off at byte {}", walk.len)));
    let Some([.., w0, w1, h0, h1, flags, _, _]) = walk.take::<13>()? else { return cut(walk) };
    index.width = u16::from_le_bytes([w0, w1]).into();
    index.height = u16::from_le_bytes([h0, h1]).into();
    if !walk.skip(color_table_bytes(flags))? {
        return cut(walk);
    }
    let mut delay = 0;
    loop {
        let at = walk.at;
        match walk.take()? {
            None => return cut(walk),
            Some([0x3b]) => return Ok(None),
            Some([0]) => {} // padding that some writers leave between blocks
            Some([0x21]) => {
                let Some([label]) = walk.take()? else { return cut(walk) };
                if label == 0xf9 {
                    let Some([length, _, d0, d1]) = walk.take()? else { return cut(walk) };
                    delay = u16::from_le_bytes([d0, d1]);
                    if !walk.skip(u64::from(length).saturating_sub(3))? {
                        return cut(walk);
                    }
                }
                if !skip_sub_blocks(walk)? {
                    return cut(walk);
                }
            }
            Some([0x2c]) => {
                let Some([.., flags]) = walk.take::<9>()? else { return cut(walk) };
                // The colour table, then one byte of code size.
                if !walk.skip(color_table_bytes(flags) + 1)? || !skip_sub_blocks(walk)? {
                    return cut(walk);
                }
                let hundredths = if delay <= NO_DELAY { 10 } else { delay };
                index.delays.push(f64::from(hundredths) / 100.0);
                delay = 0;
                if index.delays.len() >= MAX_FRAMES {
                    return Ok(Some(format!("has more than {MAX_FRAMES} frames")));
                }
            }
            Some([other]) => return Ok(Some(format!("has an unknown block ({other:#04x}) at byte {at}"))),
        }
    }
}

/// Bytes of the colour table that the flags of a screen or image descriptor announce.
fn color_table_bytes(flags: u8) -> u64 {
    if flags & 0x80 != 0 { 3 << ((flags & 7) + 1) } else { 0 }
}

fn skip_sub_blocks<R: std::io::Read + std::io::Seek>(walk: &mut Walk<'_, R>) -> std::io::Result<bool> {
    loop {
        match walk.take()? {
            None => return Ok(false),
            Some([0]) => return Ok(true),
            Some([length]) => {
                if !walk.skip(length.into())? {
                    return Ok(false);
                }
            }
        }
    }
}

struct GifFrames {
    decoder: gif::Decoder<BufReader<File>>,
    canvas: Vec<u8>,
    /// What the last frame leaves to be done before the next.
    disposal: Disposal,
}

enum Disposal {
    Keep,
    Clear(Area),
    Restore(Vec<u8>),
}

/// Part of the canvas, inside it.
#[derive(Clone, Copy)]
struct Area {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

fn start(path: &Path, _whole_bytes: u64, max_bytes: u64) -> Result<Box<dyn Frames>> {
    let file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    if let Some(bytes) = NonZeroU64::new(max_bytes) {
        options.set_memory_limit(gif::MemoryLimit::Bytes(bytes));
    }
    let decoder = options
        .read_info(BufReader::new(file))
        .map_err(|e| Error::file(path, format!("is no GIF: {e}"), "expected an animation; save it again"))?;
    let canvas = vec![0; usize::from(decoder.width()) * usize::from(decoder.height()) * 4];
    Ok(Box::new(GifFrames { decoder, canvas, disposal: Disposal::Keep }))
}

impl Frames for GifFrames {
    fn next(&mut self) -> std::result::Result<Picture, String> {
        let (width, height) = (usize::from(self.decoder.width()), usize::from(self.decoder.height()));
        match std::mem::replace(&mut self.disposal, Disposal::Keep) {
            Disposal::Keep => {}
            Disposal::Restore(before) => self.canvas = before,
            Disposal::Clear(area) => {
                for y in area.top..area.top + area.height {
                    self.canvas[(y * width + area.left) * 4..][..area.width * 4].fill(0);
                }
            }
        }
        let frame = match self.decoder.read_next_frame() {
            Ok(Some(frame)) => frame,
            Ok(None) => return Err("the file ends before it".to_owned()),
            Err(e) => return Err(format!("its data is damaged ({e})")),
        };
        let (left, top) = (usize::from(frame.left).min(width), usize::from(frame.top).min(height));
        let area = Area {
            left,
            top,
            width: usize::from(frame.width).min(width - left),
            height: usize::from(frame.height).min(height - top),
        };
        self.disposal = match frame.dispose {
            DisposalMethod::Any | DisposalMethod::Keep => Disposal::Keep,
            // To transparency, as browsers do, not to the background colour that the format names.
            DisposalMethod::Background => Disposal::Clear(area),
            DisposalMethod::Previous => Disposal::Restore(self.canvas.clone()),
        };
        let rows = frame.buffer.chunks_exact(usize::from(frame.width).max(1) * 4);
        for (y, row) in (area.top..area.top + area.height).zip(rows) {
            let canvas = &mut self.canvas[(y * width + area.left) * 4..][..area.width * 4];
            for (to, from) in canvas.chunks_exact_mut(4).zip(row.chunks_exact(4)) {
                if from[3] != 0 {
                    to.copy_from_slice(from);
                }
            }
        }
        Ok(Picture::from_rgba(&self.canvas, width as u32, height as u32))
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;

    #[test]
    fn each_way_of_disposal_leaves_its_canvas() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("disposal.gif");
        let palette = [200, 0, 0, 0, 200, 0, 0, 0, 200, 250, 250, 250];
        let mut encoder = gif::Encoder::new(File::create(&path).expect("created"), 4, 4, &palette).expect("begun");
        let mut write = |left, top, side: u16, colour, dispose| {
            let buffer = Cow::Owned(vec![colour; usize::from(side * side)]);
            let frame = gif::Frame { left, top, width: side, height: side, dispose, buffer, ..gif::Frame::default() };
            encoder.write_frame(&frame).expect("written");
        };
        write(0, 0, 4, 0, DisposalMethod::Keep);
        write(1, 1, 2, 1, DisposalMethod::Previous);
        write(0, 0, 1, 2, DisposalMethod::Background);
        // Half of this one lies outside.
        write(3, 3, 2, 3, DisposalMethod::Keep);
        drop(encoder);
        let clip = crate::clip::Clip::open(&path).expect("opened");
        let seen = |frame, x, y| {
            let picture = clip.frame(frame).expect("decoded");
            let alpha = picture.alpha.as_ref().map_or(255, |a| a.get_pixel(x, y).0[0]);
            (picture.rgb.get_pixel(x, y).0, alpha)
        };
        const RED: ([u8; 3], u8) = ([200, 0, 0], 255);
        assert_eq!([seen(1, 0, 0), seen(1, 2, 2)], [RED, ([0, 200, 0], 255)]);
        assert_eq!([seen(2, 0, 0), seen(2, 2, 2)], [([0, 0, 200], 255), RED]);
        assert_eq!([seen(3, 3, 3), seen(3, 2, 2)], [([250; 3], 255), RED]);
        assert_eq!(seen(3, 0, 0).1, 0, "cleared to nothing");
    }
}
