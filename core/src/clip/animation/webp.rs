//! Animated WebP (RFC 9649): chunks walked for the index, pictures composed by the `image` crate's decoder.

use std::fs::File;
use std::io::{BufReader, Read, Seek, Take};
use std::path::Path;

use image_webp::WebPDecoder;

use super::{Frames, Index, MAX_FRAMES, Walk, opened, walked};
use crate::clip::{Attempt, ClipOptions, Opened, Picture};
use crate::error::{Error, Result};
use crate::job::Stage;

/// Whether a WebP file says that it is animated.
pub(in crate::clip) fn is_animated(path: &Path) -> Result<bool> {
    let mut file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
    let mut head = [0; 21];
    Ok(file.read_exact(&mut head).is_ok() && &head[12..16] == b"VP8X" && head[20] & 2 != 0)
}

pub(in crate::clip) fn open(path: &Path, options: &ClipOptions, stage: Stage<'_>) -> Attempt<Opened> {
    let index = walked(path, stage, scan)?;
    opened(path, options, "webp", index, None, start)
}

fn scan<R: Read + Seek>(mut walk: Walk<'_, R>) -> std::io::Result<Index> {
    let mut index = Index::default();
    index.problem = scan_chunks(&mut walk, &mut index)?;
    Ok(index)
}

fn scan_chunks<R: Read + Seek>(walk: &mut Walk<'_, R>, index: &mut Index) -> std::io::Result<Option<String>> {
    let cut = |walk: &Walk<'_, R>| Ok(Some(format!("is cut off at byte {}", walk.len)));
    let Some([_, _, _, _, s0, s1, s2, s3, ..]) = walk.take::<12>()? else { return cut(walk) };
    let end = u64::from(u32::from_le_bytes([s0, s1, s2, s3])) + 8;
    while walk.at + 8 <= end {
        let Some([n0, n1, n2, n3, l0, l1, l2, l3]) = walk.take()? else { return cut(walk) };
        let size = u64::from(u32::from_le_bytes([l0, l1, l2, l3]));
        let mut left = size + size % 2;
        let mut shown = None;
        match &[n0, n1, n2, n3] {
            b"VP8X" => {
                let Some([_, _, _, _, w0, w1, w2, h0, h1, h2]) = walk.take()? else { return cut(walk) };
                index.width = u32::from_le_bytes([w0, w1, w2, 0]) + 1;
                index.height = u32::from_le_bytes([h0, h1, h2, 0]) + 1;
                left = left.saturating_sub(10);
            }
            b"ANMF" => {
                let Some([.., d0, d1, d2]) = walk.take::<15>()? else { return cut(walk) };
                let milliseconds = u32::from_le_bytes([d0, d1, d2, 0]);
                // Browsers show what is hardly a delay as a tenth of a second.
                shown = Some(if milliseconds <= 10 { 0.1 } else { f64::from(milliseconds) / 1000.0 });
                left = left.saturating_sub(15);
            }
            _ => {}
        }
        if !walk.skip(left)? {
            return cut(walk);
        }
        index.delays.extend(shown);
        index.whole_bytes = walk.at;
        if index.delays.len() >= MAX_FRAMES {
            return Ok(Some(format!("has more than {MAX_FRAMES} frames")));
        }
    }
    Ok(None)
}

struct WebPFrames {
    decoder: WebPDecoder<BufReader<Take<File>>>,
    buffer: Vec<u8>,
}

fn start(path: &Path, whole_bytes: u64, max_bytes: u64) -> Result<Box<dyn Frames>> {
    let not_webp = |e: &dyn std::fmt::Display| {
        Error::file(path, format!("is no readable WebP: {e}"), "expected an animation; save it again")
    };
    let file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
    // The decoder refuses a file that ends within a frame; without that frame it is whole.
    let mut decoder = WebPDecoder::new(BufReader::new(file.take(whole_bytes))).map_err(|e| not_webp(&e))?;
    decoder.set_memory_limit(usize::try_from(max_bytes).unwrap_or(usize::MAX));
    // Without it the decoder leaves what a frame asks to have cleared.
    decoder.set_background_color([0; 4]).map_err(|e| not_webp(&e))?;
    let bytes = decoder.output_buffer_size().filter(|&b| b as u64 <= max_bytes);
    let bytes = bytes.ok_or_else(|| not_webp(&"its picture is larger than allowed"))?;
    Ok(Box::new(WebPFrames { decoder, buffer: vec![0; bytes] }))
}

impl Frames for WebPFrames {
    fn next(&mut self) -> std::result::Result<Picture, String> {
        if !self.decoder.is_animated() {
            return Err("its data is damaged".to_owned());
        }
        self.decoder.read_frame(&mut self.buffer).map_err(|e| format!("its data is damaged ({e})"))?;
        let (width, height) = self.decoder.dimensions();
        if self.decoder.has_alpha() {
            return Ok(Picture::from_rgba(&self.buffer, width, height));
        }
        let rgb = image::RgbImage::from_raw(width, height, self.buffer.clone()).unwrap_or_default();
        Ok(Picture::new(rgb, None))
    }
}
