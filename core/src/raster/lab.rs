//! sRGB to CIE L*a*b* (IEC 61966-2-1, CIE 1976, white D65), where equal distances look about equally different.
//! Both curves come from tables: the cube root is within 2e-4 of exact.

use image::RgbImage;

use super::Grid;

/// Entries of the table of the lightness curve over 0..=1.
const STEPS: usize = 4096;

/// L*, a* and b* of every pixel, each divided by 100.
pub(super) fn planes(image: &RgbImage) -> [Grid<f32>; 3] {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let linear: [f32; 256] = std::array::from_fn(|v| to_linear(v as f32 / 255.0));
    // Values and what they rise by to the next.
    let value = |i: usize| lightness_curve(i as f32 / STEPS as f32);
    let curve: Vec<[f32; 2]> = (0..=STEPS).map(|i| [value(i), value(i + 1) - value(i)]).collect();
    let curved = |t: f32| {
        let place = t.clamp(0.0, 1.0) * STEPS as f32;
        let index = place as usize;
        let [value, rise] = curve[index];
        value + rise * (place - index as f32)
    };
    let mut out: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; width * height]);
    let [l, a, b] = &mut out;
    for (((pixel, l), a), b) in image.as_raw().chunks_exact(3).zip(l).zip(a).zip(b) {
        let [red, green, blue] = [pixel[0], pixel[1], pixel[2]].map(|v| linear[usize::from(v)]);
        // The matrix of the standard, each row divided by the white's X, Y, Z.
        let x = curved(0.433_953 * red + 0.376_219 * green + 0.189_828 * blue);
        let y = curved(0.212_673 * red + 0.715_152 * green + 0.072_175 * blue);
        let z = curved(0.017_758 * red + 0.109_477 * green + 0.872_765 * blue);
        *l = 1.16 * y - 0.16;
        *a = 5.0 * (x - y);
        *b = 2.0 * (y - z);
    }
    out.map(|values| Grid::from_vec(width, height, values))
}

fn to_linear(v: f32) -> f32 {
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn lightness_curve(t: f32) -> f32 {
    const EDGE: f32 = 6.0 / 29.0;
    if t > EDGE * EDGE * EDGE { t.cbrt() } else { t / (3.0 * EDGE * EDGE) + 4.0 / 29.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_colours_come_out_right() {
        // Reference values of the standard's transform, rounded to two decimals.
        let cases = [
            ([255, 255, 255], [100.0, 0.0, 0.0]),
            ([0, 0, 0], [0.0, 0.0, 0.0]),
            ([255, 0, 0], [53.24, 80.09, 67.20]),
            ([0, 255, 0], [87.73, -86.18, 83.18]),
            ([0, 0, 255], [32.30, 79.19, -107.86]),
            ([119, 119, 119], [50.03, 0.0, 0.0]),
        ];
        for (rgb, expected) in cases {
            let image = RgbImage::from_pixel(1, 1, image::Rgb(rgb));
            let got = planes(&image).map(|g| g.get(0, 0) * 100.0);
            for c in 0..3 {
                assert!((got[c] - expected[c]).abs() < 0.1, "{rgb:?}: {got:?} is not {expected:?}");
            }
        }
    }
}
