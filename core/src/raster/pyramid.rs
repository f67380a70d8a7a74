//! Smaller versions of images: exact halves for coarse-to-fine work, and area averages for any size.

use std::ops::Deref;

use image::{ImageBuffer, Rgb, RgbImage};

use super::Grid;

/// Half the size (rounded up) through the binomial filter (1 3 3 1) / 8, whose centre keeps pixels where they are: a
/// place `p` of the grid lies at `p / 2` of its half.
pub fn halved(grid: &Grid<f32>) -> Grid<f32> {
    let (width, height) = (grid.width(), grid.height());
    let (half_width, half_height) = (width.div_ceil(2), height.div_ceil(2));
    let mut out = Vec::with_capacity(half_width * half_height);
    // Between a repeated first pixel and two repeated last ones.
    let mut columns = vec![0.0f32; width + 3];
    for y in 0..half_height {
        let row = |offset: isize| grid.row((2 * y as isize + offset).clamp(0, height as isize - 1) as usize);
        let (a, b, c, d) = (row(-1), row(0), row(1), row(2));
        for ((((column, a), b), c), d) in columns[1..=width].iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *column = (a + d + 3.0 * (b + c)) * 0.125;
        }
        columns[0] = columns[1];
        let last = columns[width];
        columns[width + 1..].fill(last);
        out.extend(columns.windows(4).step_by(2).map(|c| (c[0] + c[3] + 3.0 * (c[1] + c[2])) * 0.125));
    }
    Grid::from_vec(half_width, half_height, out)
}

/// The size, of the same aspect, whose longest side is at most `longest`.
pub fn fitted(width: u32, height: u32, longest: u32) -> (u32, u32) {
    let long = width.max(height);
    if long <= longest || longest == 0 {
        return (width, height);
    }
    let side = |n: u32| ((f64::from(n) * f64::from(longest) / f64::from(long)).round() as u32).max(1);
    (side(width), side(height))
}

/// The image at another, not larger, size: every new pixel is the mean of what it covers.
pub fn shrunk<B: Deref<Target = [u8]>>(image: &ImageBuffer<Rgb<u8>, B>, width: u32, height: u32) -> RgbImage {
    if (width, height) == image.dimensions() || width == 0 || height == 0 || image.is_empty() {
        let (width, height) = image.dimensions();
        return RgbImage::from_raw(width, height, image.as_raw().to_vec()).unwrap_or_default();
    }
    let (from_width, from_height) = (image.width() as usize, image.height() as usize);
    let (across, down) = (coverage(from_width, width as usize), coverage(from_height, height as usize));
    let mut rows = vec![0.0f32; width as usize * 3 * from_height];
    for (source, target) in image.as_raw().chunks_exact(from_width * 3).zip(rows.chunks_exact_mut(width as usize * 3)) {
        for (pixel, (start, weights)) in target.chunks_exact_mut(3).zip(&across) {
            for (i, weight) in weights.iter().enumerate() {
                for c in 0..3 {
                    pixel[c] += weight * f32::from(source[(start + i) * 3 + c]);
                }
            }
        }
    }
    let mut out = RgbImage::new(width, height);
    let stride = width as usize * 3;
    let mut sum = vec![0.0f32; stride];
    for (target, (start, weights)) in out.chunks_exact_mut(stride).zip(&down) {
        sum.fill(0.0);
        for (i, weight) in weights.iter().enumerate() {
            for (s, v) in sum.iter_mut().zip(&rows[(start + i) * stride..]) {
                *s += weight * v;
            }
        }
        for (t, s) in target.iter_mut().zip(&sum) {
            *t = (s + 0.5) as u8;
        }
    }
    out
}

/// For each of `to` cells over `from` pixels: the first pixel it covers and the share of every covered one.
fn coverage(from: usize, to: usize) -> Vec<(usize, Vec<f32>)> {
    let step = from as f64 / to as f64;
    (0..to)
        .map(|i| {
            let (low, high) = (i as f64 * step, (i + 1) as f64 * step);
            let first = (low as usize).min(from - 1);
            let last = (high.ceil() as usize).clamp(first + 1, from);
            let shares: Vec<f64> =
                (first..last).map(|p| (high.min((p + 1) as f64) - low.max(p as f64)).max(0.0)).collect();
            let total: f64 = shares.iter().sum();
            let weight = |s: f64| if total > 0.0 { (s / total) as f32 } else { 1.0 / (last - first) as f32 };
            (first, shares.into_iter().map(weight).collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_keeps_a_slope_where_it_is() {
        let grid = Grid::from_vec(17, 9, (0..17 * 9).map(|i| (i % 17) as f32 + 0.5).collect());
        let half = halved(&grid);
        assert_eq!((half.width(), half.height()), (9, 5));
        for x in 1..7 {
            assert!((half.get(x, 2) - 2.0 * (x as f32 + 0.5)).abs() < 1e-5);
        }
    }

    #[test]
    fn shrinking_keeps_the_mean_and_the_place() {
        let image = RgbImage::from_fn(100, 60, |x, y| Rgb([(x * 2) as u8, (y * 4) as u8, 7]));
        let small = shrunk(&image, 37, 23);
        for (x, y, p) in small.enumerate_pixels() {
            let centre = ((x as f32 + 0.5) / 0.37 - 0.5, (y as f32 + 0.5) * 60.0 / 23.0 - 0.5);
            assert!((f32::from(p.0[0]) - 2.0 * centre.0).abs() < 1.1, "{x}");
            assert!((f32::from(p.0[1]) - 4.0 * centre.1).abs() < 1.1, "{y}");
            assert_eq!(p.0[2], 7);
        }
        assert_eq!(fitted(854, 480, 768), (768, 432));
        assert_eq!(fitted(400, 224, 768), (400, 224));
    }
}
