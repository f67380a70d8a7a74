//! The sequence parameter set of H.264 (ITU-T H.264, 7.3.2.1.1 and E.1.1): size, colours, and whether the embedded
//! decoder can do it.

/// What a sequence parameter set says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Sps {
    pub(super) profile: u8,
    /// Pixels after cropping.
    pub(super) width: u32,
    pub(super) height: u32,
    /// 1 is 4:2:0.
    pub(super) chroma_format: u32,
    pub(super) bit_depth: u32,
    /// Pictures may be stored as two fields.
    pub(super) interlaced: bool,
    pub(super) full_range: Option<bool>,
    /// As H.273 numbers them; 2 is "unspecified".
    pub(super) matrix_coefficients: Option<u16>,
    /// Width and height of a pixel.
    pub(super) pixel_aspect: Option<(u32, u32)>,
}

impl Sps {
    /// Reads a NAL unit of type 7, its header byte included. [`None`] when it is cut off or contradicts itself.
    pub(super) fn parse(nal: &[u8]) -> Option<Self> {
        let mut bits = Bits::new(nal.get(1..)?);
        let profile = bits.take(8)? as u8;
        bits.take(16)?; // constraint flags, level
        bits.golomb()?; // seq_parameter_set_id
        let (mut chroma_format, mut bit_depth, mut separate_planes) = (1, 8, false);
        if matches!(profile, 100 | 110 | 122 | 244 | 44 | 83 | 86 | 118 | 128 | 138 | 139 | 134 | 135) {
            chroma_format = bits.golomb()?;
            if chroma_format == 3 {
                separate_planes = bits.flag()?;
            }
            let luma = bits.golomb()?;
            let chroma = bits.golomb()?;
            bit_depth = 8 + luma.max(chroma);
            if chroma_format > 3 || bit_depth > 14 {
                return None;
            }
            bits.flag()?; // qpprime_y_zero_transform_bypass_flag
            if bits.flag()? {
                for list in 0..if chroma_format == 3 { 12 } else { 8 } {
                    if bits.flag()? {
                        skip_scaling_list(&mut bits, if list < 6 { 16 } else { 64 })?;
                    }
                }
            }
        }
        bits.golomb()?; // log2_max_frame_num_minus4
        match bits.golomb()? {
            0 => {
                bits.golomb()?; // log2_max_pic_order_cnt_lsb_minus4
            }
            1 => {
                bits.flag()?; // delta_pic_order_always_zero_flag
                bits.golomb()?;
                bits.golomb()?;
                for _ in 0..bits.golomb()?.min(256) {
                    bits.golomb()?;
                }
            }
            _ => {}
        }
        bits.golomb()?; // max_num_ref_frames
        bits.flag()?; // gaps_in_frame_num_value_allowed_flag
        let width_mbs = bits.golomb()?.checked_add(1)?;
        let height_units = bits.golomb()?.checked_add(1)?;
        let frames_only = bits.flag()?;
        if !frames_only {
            bits.flag()?; // mb_adaptive_frame_field_flag
        }
        bits.flag()?; // direct_8x8_inference_flag
        let mut crop = [0u32; 4]; // left, right, top, bottom
        if bits.flag()? {
            for side in &mut crop {
                *side = bits.golomb()?;
            }
        }
        let field_factor = if frames_only { 1 } else { 2 };
        let array_type = if separate_planes { 0 } else { chroma_format };
        let unit_x = if matches!(array_type, 1 | 2) { 2 } else { 1 };
        let unit_y = if array_type == 1 { 2 } else { 1 } * field_factor;
        let cropped = |whole: u32, a: u32, b: u32, unit: u32| {
            let cut = a.checked_add(b)?.checked_mul(unit)?;
            whole.checked_mul(16)?.checked_sub(cut).filter(|&v| v > 0)
        };
        let mut sps = Self {
            profile,
            width: cropped(width_mbs, crop[0], crop[1], unit_x)?,
            height: cropped(height_units.checked_mul(field_factor)?, crop[2], crop[3], unit_y)?,
            chroma_format,
            bit_depth,
            interlaced: !frames_only,
            full_range: None,
            matrix_coefficients: None,
            pixel_aspect: None,
        };
        if bits.flag()? {
            // What a damaged end leaves unsaid has defaults.
            sps.read_vui(&mut bits);
        }
        Some(sps)
    }

    fn read_vui(&mut self, bits: &mut Bits<'_>) -> Option<()> {
        if bits.flag()? {
            const TABLE: [(u32, u32); 16] = [
                (1, 1),
                (12, 11),
                (10, 11),
                (16, 11),
                (40, 33),
                (24, 11),
                (20, 11),
                (32, 11),
                (80, 33),
                (18, 11),
                (15, 11),
                (64, 33),
                (160, 99),
                (4, 3),
                (3, 2),
                (2, 1),
            ];
            let aspect = bits.take(8)? as usize;
            self.pixel_aspect = match aspect {
                1..=16 => Some(TABLE[aspect - 1]),
                255 => Some((bits.take(16)?, bits.take(16)?)),
                _ => None,
            }
            .filter(|&(w, h)| w > 0 && h > 0);
        }
        if bits.flag()? {
            bits.flag()?; // overscan_appropriate_flag
        }
        if bits.flag()? {
            bits.take(3)?; // video_format
            self.full_range = Some(bits.flag()?);
            if bits.flag()? {
                bits.take(16)?; // primaries, transfer
                self.matrix_coefficients = Some(bits.take(8)? as u16);
            }
        }
        Some(())
    }

    /// Why the embedded decoder cannot do this stream, if it cannot.
    pub(super) fn unsupported(&self) -> Option<String> {
        if self.bit_depth != 8 {
            Some(format!("H.264 with {} bits a channel", self.bit_depth))
        } else if self.chroma_format != 1 {
            let chroma = ["without colour (4:0:0)", "4:2:0", "4:2:2", "4:4:4"][self.chroma_format.min(3) as usize];
            Some(format!("H.264 {chroma}"))
        } else if self.interlaced {
            Some("interlaced H.264".to_owned())
        } else if self.profile == 88 {
            Some("H.264 of the Extended profile".to_owned())
        } else {
            None
        }
    }
}

fn skip_scaling_list(bits: &mut Bits<'_>, size: usize) -> Option<()> {
    let (mut last, mut next) = (8i32, 8i32);
    for _ in 0..size {
        if next != 0 {
            next = (last + bits.signed_golomb()?).rem_euclid(256);
        }
        if next != 0 {
            last = next;
        }
    }
    Some(())
}

/// The bits of a NAL unit without its emulation prevention bytes (7.3.1).
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    zeros: u32,
    current: u8,
    left: u32,
}

impl<'a> Bits<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, zeros: 0, current: 0, left: 0 }
    }

    fn flag(&mut self) -> Option<bool> {
        if self.left == 0 {
            let mut byte = *self.bytes.get(self.at)?;
            self.at += 1;
            if self.zeros >= 2 && byte == 3 {
                byte = *self.bytes.get(self.at)?;
                self.at += 1;
                self.zeros = 0;
            }
            self.zeros = if byte == 0 { self.zeros + 1 } else { 0 };
            self.current = byte;
            self.left = 8;
        }
        self.left -= 1;
        Some(self.current >> self.left & 1 == 1)
    }

    fn take(&mut self, count: u32) -> Option<u32> {
        (0..count).try_fold(0, |value, _| Some(value << 1 | u32::from(self.flag()?)))
    }

    /// ue(v), 9.1.
    fn golomb(&mut self) -> Option<u32> {
        let mut zeros = 0;
        while !self.flag()? {
            zeros += 1;
            if zeros > 31 {
                return None;
            }
        }
        Some((1 << zeros) - 1 + self.take(zeros)?)
    }

    /// se(v), 9.1.1.
    fn signed_golomb(&mut self) -> Option<i32> {
        let k = i64::from(self.golomb()?);
        i32::try_from(if k % 2 == 1 { (k + 1) / 2 } else { -k / 2 }).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 320x240 cropped from 320x240, Constrained Baseline, no VUI: profile 66, written by hand from 7.3.2.1.1.
    #[test]
    fn reads_a_baseline_set() {
        let mut w = String::new();
        w += "01000010 11000000 00001101"; // 66, constraints, level 13
        w += "1 1 1 011 010 0"; // id 0, frame_num of 4 bits, order type 0 of 6 bits, 1 reference frame, no gaps
        w += "000010100 0001111"; // ue(19) = 20 wide, ue(14) = 15 high
        w += "1 1 0 0 1"; // frames only, direct 8x8, no crop, no VUI, stop bit
        let bits: Vec<u8> = w.bytes().filter(|b| *b != b' ').map(|b| b - b'0').collect();
        let mut nal = vec![0x67];
        nal.extend(bits.chunks(8).map(|c| c.iter().enumerate().fold(0, |v, (i, b)| v | b << (7 - i))));
        let sps = Sps::parse(&nal).expect("well-formed");
        assert_eq!((sps.width, sps.height), (320, 240));
        assert_eq!(sps.unsupported(), None);
        for cut in 0..nal.len() - 1 {
            assert_eq!(Sps::parse(&nal[..cut]), None, "cut to {cut} bytes");
        }
    }
}
