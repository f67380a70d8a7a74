//! Luma and chroma planes to colours, by the matrix and the range that the stream names.
//!
//! The matrices are those of ITU-T H.273, table 4. Chroma of 4:2:0 is interpolated linearly from where H.264 puts it
//! by default (H.264 E.2.1, chroma_sample_loc_type 0): on the even columns, halfway between two rows.
//! Transfer curves and primaries are taken as they come: no tone mapping of HDR.

use std::sync::Arc;

use image::RgbImage;

use super::orientation::Orientation;
use super::{FrameBytes, FrameMemory, Picture};
use crate::error::Result;

/// How to get from numbers to colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ColorSpace {
    /// Weights of red and blue in luma.
    pub(super) kr: f64,
    pub(super) kb: f64,
    /// Luma and chroma use all of 0..=255, not 16..=235 and 16..=240.
    pub(super) full_range: bool,
}

impl ColorSpace {
    /// Weights of red and blue in BT.709 and BT.601.
    pub(super) const BT709: (f64, f64) = (0.2126, 0.0722);
    pub(super) const BT601: (f64, f64) = (0.299, 0.114);

    /// The weights of red and blue that matrix_coefficients (H.273) names, if it names any.
    pub(super) fn weights(matrix_coefficients: u16) -> Option<(f64, f64)> {
        match matrix_coefficients {
            1 => Some(Self::BT709),
            4 => Some((0.30, 0.11)),
            5 | 6 => Some(Self::BT601),
            7 => Some((0.212, 0.087)),
            9 => Some((0.2627, 0.0593)),
            _ => None,
        }
    }

    /// What players assume when nothing is named: BT.709 from 720 lines on, BT.601 below.
    pub(super) fn default_weights(width: u32, height: u32) -> (f64, f64) {
        if width.max(height) >= 1280 || width.min(height) >= 720 { Self::BT709 } else { Self::BT601 }
    }
}

/// A decoded picture in planes: 4:2:0, 8 bits, rows without padding.
#[derive(Debug)]
pub(super) struct Planes {
    pub(super) width: usize,
    pub(super) height: usize,
    /// `width * height` values, then twice `ceil(width / 2) * ceil(height / 2)`: luma, blue and red difference.
    pub(super) data: FrameBytes,
    pub(super) color: ColorSpace,
    pub(super) orientation: Orientation,
}

/// Fractional bits of the fixed-point coefficients.
const BITS: u32 = 16;
/// Interpolated chroma is a sum with weights of 8 in all.
const CHROMA_SCALE: i32 = 8;

impl Planes {
    pub(super) fn bytes(&self) -> usize {
        self.data.len()
    }

    /// The planes in memory that is lent, where any is.
    pub(super) fn lent(self, memory: Option<&Arc<dyn FrameMemory>>) -> Result<Self> {
        let Some(memory) = memory else { return Ok(self) };
        Ok(Self { data: self.data.lent(&**memory)?, ..self })
    }

    /// The colours, turned upright.
    pub(super) fn to_picture(&self) -> Picture {
        let (w, h) = (self.width, self.height);
        let (cw, ch) = (w.div_ceil(2), h.div_ceil(2));
        let (luma, chroma) = self.data.split_at(w * h);
        let (blue, red) = chroma.split_at(cw * ch);
        let k = Coefficients::new(self.color);
        let mut rgb = vec![0u8; w * h * 3];
        let mut column = vec![0i32; cw + 1];
        let (mut u, mut v) = (vec![0i32; cw * 2], vec![0i32; cw * 2]);
        for (y, out) in rgb.chunks_exact_mut(w * 3).enumerate() {
            upsample_row(blue, cw, ch, y, &mut column, &mut u);
            upsample_row(red, cw, ch, y, &mut column, &mut v);
            let row = &luma[y * w..(y + 1) * w];
            for (((px, &l), &u), &v) in out.chunks_exact_mut(3).zip(row).zip(&u).zip(&v) {
                let l = k.luma * i32::from(l) + k.offset;
                px[0] = clamp((l + k.red_from_v * v) >> BITS);
                px[1] = clamp((l - k.green_from_u * u - k.green_from_v * v) >> BITS);
                px[2] = clamp((l + k.blue_from_u * u) >> BITS);
            }
        }
        let rgb = RgbImage::from_raw(w as u32, h as u32, rgb).unwrap_or_default();
        Picture::new(self.orientation.apply(rgb), None)
    }
}

fn clamp(value: i32) -> u8 {
    value.clamp(0, 255) as u8
}

/// Chroma for luma row `y`, [`CHROMA_SCALE`] times the distance from 128.
fn upsample_row(plane: &[u8], cw: usize, ch: usize, y: usize, column: &mut [i32], out: &mut [i32]) {
    let near = y / 2;
    let far = if y.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(ch - 1) };
    let (near, far) = (&plane[near * cw..][..cw], &plane[far * cw..][..cw]);
    for ((c, &n), &f) in column.iter_mut().zip(near).zip(far) {
        *c = 3 * i32::from(n) + i32::from(f) - 4 * 128;
    }
    column[cw] = column[cw - 1];
    for (x, pair) in out.chunks_exact_mut(2).enumerate() {
        pair[0] = 2 * column[x];
        pair[1] = column[x] + column[x + 1];
    }
}

struct Coefficients {
    luma: i32,
    offset: i32,
    red_from_v: i32,
    green_from_u: i32,
    green_from_v: i32,
    blue_from_u: i32,
}

impl Coefficients {
    fn new(color: ColorSpace) -> Self {
        let one = f64::from(1u32 << BITS);
        let (luma, black, chroma) =
            if color.full_range { (1.0, 0.0, 1.0) } else { (255.0 / 219.0, 16.0, 255.0 / 224.0) };
        let chroma = chroma * one / f64::from(CHROMA_SCALE);
        let (kr, kb) = (color.kr, color.kb);
        let kg = 1.0 - kr - kb;
        let luma = (luma * one).round();
        Self {
            luma: luma as i32,
            offset: (0.5 * one - luma * black).round() as i32,
            red_from_v: (2.0 * (1.0 - kr) * chroma).round() as i32,
            green_from_u: (2.0 * (1.0 - kb) * kb / kg * chroma).round() as i32,
            green_from_v: (2.0 * (1.0 - kr) * kr / kg * chroma).round() as i32,
            blue_from_u: (2.0 * (1.0 - kb) * chroma).round() as i32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BT601: ColorSpace = ColorSpace { kr: 0.299, kb: 0.114, full_range: false };
    const BT709_FULL: ColorSpace = ColorSpace { kr: 0.2126, kb: 0.0722, full_range: true };

    fn flat(color: ColorSpace, [y, u, v]: [u8; 3], width: usize, height: usize) -> Planes {
        let chroma = width.div_ceil(2) * height.div_ceil(2);
        let data = [vec![y; width * height], vec![u; chroma], vec![v; chroma]].concat();
        Planes { width, height, data: data.into(), color, orientation: Orientation::default() }
    }

    /// The definition, H.273 equations 38 to 43, in floating point.
    fn encode(color: ColorSpace, rgb: [u8; 3]) -> [u8; 3] {
        let [r, g, b] = rgb.map(|v| f64::from(v) / 255.0);
        let y = color.kr * r + (1.0 - color.kr - color.kb) * g + color.kb * b;
        let u = 0.5 * (b - y) / (1.0 - color.kb);
        let v = 0.5 * (r - y) / (1.0 - color.kr);
        let (ys, yo, cs) = if color.full_range { (255.0, 0.0, 255.0) } else { (219.0, 16.0, 224.0) };
        [ys * y + yo, cs * u + 128.0, cs * v + 128.0].map(|v| v.round().clamp(0.0, 255.0) as u8)
    }

    #[test]
    fn colours_survive_the_round_trip_in_every_space() {
        for color in [BT601, BT709_FULL, ColorSpace { full_range: true, ..BT601 }] {
            for rgb in [[0, 0, 0], [255, 255, 255], [255, 0, 0], [0, 255, 0], [0, 0, 255], [90, 140, 200], [17, 5, 3]] {
                let shown = flat(color, encode(color, rgb), 5, 3).to_picture();
                for px in shown.rgb.pixels() {
                    for c in 0..3 {
                        assert!(px.0[c].abs_diff(rgb[c]) <= 2, "{rgb:?} became {:?} in {color:?}", px.0);
                    }
                }
            }
        }
    }

    #[test]
    fn chroma_ramps_are_interpolated_not_repeated() {
        let mut planes = flat(BT709_FULL, [128, 128, 128], 16, 4);
        let mut data = planes.data.to_vec();
        for row in 0..2 {
            for x in 0..8 {
                data[64 + 16 + row * 8 + x] = (128 + 4 * x) as u8;
            }
        }
        planes.data = data.into();
        let shown = planes.to_picture().rgb;
        let reds: Vec<u8> = (0..15).map(|x| shown.get_pixel(x, 1).0[0]).collect();
        assert!(reds.windows(2).all(|w| w[1] > w[0]), "a ramp in chroma must rise at every pixel: {reds:?}");
    }
}
