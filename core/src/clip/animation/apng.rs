//! Animated PNG (PNG specification, third edition, 11.3.6): pictures by the `png` crate, composed here.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use png::{BlendOp, ColorType, DisposeOp, Transformations};

use super::{Frames, Index, MAX_FRAMES, Walk, opened, walked};
use crate::clip::{Attempt, ClipOptions, Opened, Picture};
use crate::error::{Error, Result};
use crate::job::{Progress, Stage};

/// Whether a PNG announces an animation before its first picture.
pub(in crate::clip) fn is_animated(path: &Path) -> Result<bool> {
    let (_, claimed) = read_index(path, true, Progress::new().whole())?;
    Ok(claimed.is_some())
}

pub(in crate::clip) fn open(path: &Path, options: &ClipOptions, stage: Stage<'_>) -> Attempt<Opened> {
    let (index, claimed) = read_index(path, false, stage)?;
    opened(path, options, "apng", index, claimed, start)
}

fn read_index(path: &Path, head_only: bool, stage: Stage<'_>) -> Result<(Index, Option<usize>)> {
    walked(path, stage, |walk| scan(walk, head_only))
}

/// The index, and the number of frames that the file claims if it claims to be an animation.
fn scan<R: Read + Seek>(mut walk: Walk<'_, R>, head_only: bool) -> std::io::Result<(Index, Option<usize>)> {
    let mut index = Index::default();
    let mut claimed = None;
    index.problem = scan_chunks(&mut walk, &mut index, &mut claimed, head_only)?;
    Ok((index, claimed))
}

fn scan_chunks<R: Read + Seek>(
    walk: &mut Walk<'_, R>,
    index: &mut Index,
    claimed: &mut Option<usize>,
    head_only: bool,
) -> std::io::Result<Option<String>> {
    let cut = |walk: &Walk<'_, R>| Ok(Some(format!("is cut off at byte {}", walk.len)));
    let Some(_signature) = walk.take::<8>()? else { return cut(walk) };
    // A frame is whole when what follows its data has begun.
    let mut pending: Option<f64> = None;
    let mut has_data = false;
    loop {
        let Some([l0, l1, l2, l3, name @ ..]) = walk.take::<8>()? else { return cut(walk) };
        let mut left = u64::from(u32::from_be_bytes([l0, l1, l2, l3])) + 4; // with the checksum
        match &name {
            b"IHDR" => {
                let Some([w0, w1, w2, w3, h0, h1, h2, h3]) = walk.take()? else { return cut(walk) };
                index.width = u32::from_be_bytes([w0, w1, w2, w3]);
                index.height = u32::from_be_bytes([h0, h1, h2, h3]);
                left = left.saturating_sub(8);
            }
            b"acTL" => {
                let Some(count) = walk.take()? else { return cut(walk) };
                *claimed = Some(u32::from_be_bytes(count) as usize);
                left = left.saturating_sub(4);
            }
            b"IDAT" | b"fdAT" => has_data = true,
            b"fcTL" | b"IEND" => {
                if let Some(delay) = pending.take().filter(|_| has_data) {
                    index.delays.push(delay);
                    if index.delays.len() >= MAX_FRAMES {
                        return Ok(Some(format!("has more than {MAX_FRAMES} frames")));
                    }
                }
                has_data = false;
                if &name == b"IEND" {
                    return Ok(None);
                }
                if !walk.skip(20)? {
                    return cut(walk);
                }
                let Some([n0, n1, d0, d1]) = walk.take()? else { return cut(walk) };
                let (count, of) = (u16::from_be_bytes([n0, n1]), u16::from_be_bytes([d0, d1]));
                let delay = f64::from(count) / f64::from(if of == 0 { 100 } else { of });
                // "As fast as possible" is shown by browsers as a tenth of a second.
                pending = Some(if count == 0 { 0.1 } else { delay });
                left = left.saturating_sub(24);
            }
            _ => {}
        }
        if head_only && matches!(&name, b"IDAT" | b"acTL") {
            return Ok(None);
        }
        if !walk.skip(left)? {
            return cut(walk);
        }
    }
}

struct ApngFrames {
    reader: png::Reader<BufReader<File>>,
    buffer: Vec<u8>,
    canvas: Vec<u8>,
    width: usize,
    height: usize,
    disposal: Disposal,
}

enum Disposal {
    Keep,
    /// Left, top, width and height, inside the canvas.
    Clear([usize; 4]),
    Restore(Vec<u8>),
}

fn start(path: &Path, _whole_bytes: u64, max_bytes: u64) -> Result<Box<dyn Frames>> {
    let not_png = |e: &dyn std::fmt::Display| {
        Error::file(path, format!("is no readable PNG: {e}"), "expected an animation; save it again")
    };
    let file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
    let limits = png::Limits { bytes: usize::try_from(max_bytes).unwrap_or(usize::MAX) };
    let mut decoder = png::Decoder::new_with_limits(BufReader::new(file), limits);
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16 | Transformations::ALPHA);
    let reader = decoder.read_info().map_err(|e| not_png(&e))?;
    let (width, height) = reader.info().size();
    let bytes = reader.output_buffer_size().filter(|&b| b as u64 <= max_bytes);
    let bytes = bytes.ok_or_else(|| not_png(&"its picture is larger than allowed"))?;
    let (width, height) = (width as usize, height as usize);
    let (buffer, canvas) = (vec![0; bytes], vec![0; width * height * 4]);
    Ok(Box::new(ApngFrames { reader, buffer, canvas, width, height, disposal: Disposal::Keep }))
}

impl Frames for ApngFrames {
    fn next(&mut self) -> std::result::Result<Picture, String> {
        match std::mem::replace(&mut self.disposal, Disposal::Keep) {
            Disposal::Keep => {}
            Disposal::Restore(before) => self.canvas = before,
            Disposal::Clear([left, top, width, height]) => {
                for y in top..top + height {
                    self.canvas[(y * self.width + left) * 4..][..width * 4].fill(0);
                }
            }
        }
        let damaged = |e| format!("its data is damaged ({e})");
        let mut out = self.reader.next_frame(&mut self.buffer).map_err(damaged)?;
        if self.reader.info().frame_control().is_none() {
            // The picture for viewers that know no animation is not part of it.
            out = self.reader.next_frame(&mut self.buffer).map_err(damaged)?;
        }
        let info = self.reader.info();
        let control = *info.frame_control().ok_or("its place is not given")?;
        let (left, top) = (control.x_offset as usize, control.y_offset as usize);
        let (width, height) = (out.width as usize, out.height as usize);
        if left + width > self.width || top + height > self.height {
            return Err("it lies outside the picture".to_owned());
        }
        self.disposal = match control.dispose_op {
            DisposeOp::None => Disposal::Keep,
            DisposeOp::Background => Disposal::Clear([left, top, width, height]),
            DisposeOp::Previous => Disposal::Restore(self.canvas.clone()),
        };
        let gray = match out.color_type {
            ColorType::GrayscaleAlpha => true,
            ColorType::Rgba => false,
            other => return Err(format!("its colours are of the kind {other:?}")),
        };
        // Rows of an interlaced part come as wide as the whole picture.
        let interlaced_stride = self.reader.output_line_size(self.width as u32);
        let stride = if info.interlaced { interlaced_stride.unwrap_or(out.line_size) } else { out.line_size };
        for (y, row) in (top..top + height).zip(self.buffer.chunks(stride.max(1))) {
            let canvas = &mut self.canvas[(y * self.width + left) * 4..][..width * 4];
            let pixels = canvas.chunks_exact_mut(4);
            if gray {
                pixels.zip(row.chunks_exact(2)).for_each(|(to, p)| put(to, [p[0], p[0], p[0], p[1]], control.blend_op));
            } else {
                pixels.zip(row.chunks_exact(4)).for_each(|(to, p)| put(to, [p[0], p[1], p[2], p[3]], control.blend_op));
            }
        }
        Ok(Picture::from_rgba(&self.canvas, self.width as u32, self.height as u32))
    }
}

/// Lays a pixel on the canvas; neither is premultiplied by its opacity (13.16 of the specification).
fn put(to: &mut [u8], from: [u8; 4], blend: BlendOp) {
    let opaque = u32::from(from[3]);
    if blend == BlendOp::Source || opaque == 255 {
        to.copy_from_slice(&from);
    } else if opaque > 0 {
        let under = u32::from(to[3]) * (255 - opaque);
        let over = opaque * 255;
        let both = over + under;
        for c in 0..3 {
            to[c] = ((u32::from(from[c]) * over + u32::from(to[c]) * under + both / 2) / both) as u8;
        }
        to[3] = ((both + 127) / 255) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disposal_and_blending_follow_the_specification() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("disposal.png");
        let mut encoder = png::Encoder::new(File::create(&path).expect("created"), 4, 4);
        encoder.set_color(ColorType::Rgba);
        encoder.set_animated(4, 0).expect("animated");
        encoder.set_frame_delay(1, 10).expect("delayed");
        let mut writer = encoder.write_header().expect("begun");
        let mut write = |at: u32, side: u32, colour: [u8; 4], dispose, blend| {
            writer.reset_frame_position().expect("placed");
            writer.set_frame_dimension(side, side).expect("sized");
            writer.set_frame_position(at, at).expect("placed");
            writer.set_dispose_op(dispose).expect("set");
            writer.set_blend_op(blend).expect("set");
            writer.write_image_data(&colour.repeat((side * side) as usize)).expect("written");
        };
        write(0, 4, [200, 0, 0, 255], DisposeOp::None, BlendOp::Source);
        write(1, 2, [0, 200, 0, 255], DisposeOp::Background, BlendOp::Source);
        // What is restored after this one is the canvas with the green cleared away.
        write(1, 2, [0, 0, 200, 255], DisposeOp::Previous, BlendOp::Source);
        write(0, 1, [250, 250, 250, 51], DisposeOp::None, BlendOp::Over);
        writer.finish().expect("ended");
        let clip = crate::clip::Clip::open(&path).expect("opened");
        let seen = |frame, x, y| {
            let picture = clip.frame(frame).expect("decoded");
            let alpha = picture.alpha.as_ref().map_or(255, |a| a.get_pixel(x, y).0[0]);
            (picture.rgb.get_pixel(x, y).0, alpha)
        };
        assert_eq!([seen(1, 0, 0), seen(1, 1, 1)], [([200, 0, 0], 255), ([0, 200, 0], 255)]);
        assert_eq!(seen(2, 2, 2), ([0, 0, 200], 255));
        assert_eq!(seen(3, 2, 2).1, 0, "cleared before, restored to cleared");
        assert_eq!(seen(3, 0, 0), ([210, 50, 50], 255), "a fifth of 250 over red");
        assert_eq!(clip.info().fps, 10.0);
    }
}
