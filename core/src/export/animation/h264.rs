//! H.264 by the embedded encoder, in mp4 ([`super::mp4`]). Every frame is kept, at a quality at which drawings look as they
//! are; colours are BT.709 in the narrow range, and the stream says so. Over white, with a last column or row repeated where
//! the size is odd.
//!
//! Limits: the encoder takes pictures up to 3840x2160; 4:2:0 halves the resolution of colour.

use std::path::{Path, PathBuf};

use image::RgbaImage;
use openh264::encoder::{
    BitRate, Complexity, Encoder, EncoderConfig, FrameRate, FrameType, IntraFramePeriod, QpRange, RateControlMode,
    UsageType, VuiConfig,
};
use openh264::formats::YUVSlices;
use openh264::{OpenH264API, Timestamp};

use super::mp4::Movie;
use super::{Animation, rate};
use crate::error::{Error, Result};
use crate::job::Stage;

/// Longer and shorter side, at most.
const LARGEST: (u32, u32) = (3840, 2160);
/// Pixels a side, at least: smaller ones the encoder refuses.
const SMALLEST: u32 = 16;
/// Quantization: of a drawing, frames come back within one of 255 on average.
const QUALITY: QpRange = QpRange::new(12, 18);
/// Bits a second that no drawing needs, so that only the quality counts.
const BITS: u32 = 200_000_000;
/// Seconds from one picture that stands alone to the next: how far a player looks back when it seeks.
const INTRA_SECONDS: f64 = 2.0;

pub(super) fn write(path: &Path, animation: &Animation<'_>, stage: Stage<'_>) -> Result<Vec<PathBuf>> {
    let (width, height) = animation.size;
    let (width, height) = (width.next_multiple_of(2).max(SMALLEST), height.next_multiple_of(2).max(SMALLEST));
    let (longer, shorter) = (width.max(height), width.min(height));
    if longer > LARGEST.0 || shorter > LARGEST.1 {
        let (what, value, max) = if longer > LARGEST.0 {
            ("the longer side of an mp4", longer, LARGEST.0)
        } else {
            ("the shorter side of an mp4", shorter, LARGEST.1)
        };
        let remedy = "scale it down".into();
        return Err(Error::Limit { what: what.into(), value: value.into(), max: max.into(), remedy });
    }
    let failed = |e: openh264::Error| Error::invalid("an mp4", e.to_string(), "draw it smaller, or in another format");
    let config = EncoderConfig::new()
        // The only one that keeps to the quality, drops no frame and says nothing about it.
        .rate_control_mode(RateControlMode::Bufferbased)
        .bitrate(BitRate::from_bps(BITS))
        .max_frame_rate(FrameRate::from_hz((animation.fps as f32).clamp(1.0, 60.0)))
        .usage_type(UsageType::CameraVideoRealTime)
        .complexity(Complexity::Medium)
        .qp(QUALITY)
        .skip_frames(false)
        .scene_change_detect(false)
        .background_detection(false)
        .adaptive_quantization(false)
        .num_threads(1)
        .intra_frame_period(IntraFramePeriod::from_num_frames((INTRA_SECONDS * animation.fps).ceil() as u32))
        .vui(VuiConfig::bt709());
    let mut encoder = Encoder::with_api_config(OpenH264API::from_source(), config).map_err(failed)?;
    let ticks = rate::fraction(animation.fps, u16::MAX.into());
    let mut movie = Movie::begin(path, (width, height), ticks)?;
    let size = (width as usize, height as usize);
    animation.each(
        stage,
        |_, _, now| Ok(planes(now, size)),
        |frame, planes| {
            let (luma, chroma) = planes.split_at(size.0 * size.1);
            let (blue, red) = chroma.split_at(chroma.len() / 2);
            let picture = YUVSlices::new((luma, blue, red), size, (size.0, size.0 / 2, size.0 / 2));
            let at = Timestamp::from_millis((1000.0 * frame as f64 / animation.fps).round() as u64);
            let coded = encoder.encode_at(&picture, at).map_err(failed)?;
            let alone = coded.frame_type() == FrameType::IDR;
            movie.add(&coded.to_vec(), alone)
        },
    )?;
    movie.commit()?;
    Ok(vec![path.to_owned()])
}

/// Luma, blue and red difference of a picture over white, 4:2:0, chroma where H.264 puts it by default: on the even columns,
/// between two rows. The last column and row are repeated up to `size`.
fn planes(picture: &RgbaImage, (width, height): (usize, usize)) -> Vec<u8> {
    // BT.709 in the narrow range (ITU-T H.273, equations 38 to 43).
    const KR: f32 = 0.2126;
    const KB: f32 = 0.0722;
    let (from_width, from_height) = (picture.width() as usize, picture.height() as usize);
    let mut luma = vec![0u8; width * height];
    // The differences of one pair of rows, summed.
    let mut sums = vec![[0.0f32; 2]; width];
    let (mut blue, mut red) = (Vec::new(), Vec::new());
    for y in 0..height {
        let row = y.min(from_height - 1) * from_width;
        for x in 0..width {
            let at = 4 * (row + x.min(from_width - 1));
            let [r, g, b, a] = [0, 1, 2, 3].map(|c| f32::from(picture.as_raw()[at + c]) / 255.0);
            let [r, g, b] = [r, g, b].map(|v| v * a + 1.0 - a);
            let light = KR * r + (1.0 - KR - KB) * g + KB * b;
            luma[y * width + x] = (16.5 + 219.0 * light) as u8;
            sums[x][0] += (b - light) / (2.0 * (1.0 - KB));
            sums[x][1] += (r - light) / (2.0 * (1.0 - KR));
        }
        if y % 2 == 1 {
            for x in (0..width).step_by(2) {
                let (left, right) = (sums[x.saturating_sub(1)], sums[x + 1]);
                let mean = |c: usize| (left[c] + 2.0 * sums[x][c] + right[c]) / 8.0;
                blue.push((128.5 + 224.0 * mean(0)) as u8);
                red.push((128.5 + 224.0 * mean(1)) as u8);
            }
            sums.fill([0.0; 2]);
        }
    }
    luma.extend(blue);
    luma.extend(red);
    luma
}
