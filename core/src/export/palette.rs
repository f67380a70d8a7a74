//! A palette for many frames, and the nearest of its colours to any other.
//!
//! Variance-driven splitting (Wu, "Efficient statistical computations for optimal color quantization", 1991): the box
//! with the largest squared error is cut at the mean of its widest axis, until there are enough; a few rounds of
//! k-means settle the rest. Colours that must not drift (lines, labels) are given and stay. Distances are plain sRGB
//! with the eye's rough weights.

use image::RgbaImage;
use rayon::prelude::*;

/// Colours a palette holds at most: one index of 256 is left for "as before".
pub(super) const MAX_COLORS: usize = 255;
/// Bits of red, green and blue that tell colours apart.
const BITS: [u32; 3] = [5, 6, 5];
const BINS: usize = 1 << (BITS[0] + BITS[1] + BITS[2]);
/// How much a difference in red, green and blue counts.
const WEIGHTS: [f32; 3] = [2.0, 4.0, 3.0];
const ROUNDS: usize = 4;

/// Up to 255 colours.
#[derive(Clone, Debug)]
pub(super) struct Palette {
    colors: Vec<[u8; 3]>,
    /// The nearest colour of every bin.
    nearest: Vec<u8>,
}

/// The pixels that fell into one bin.
#[derive(Clone, Copy)]
struct Bin {
    color: [f32; 3],
    weight: f32,
}

impl Palette {
    /// The palette that fits what is opaque of `pictures` best and holds `fixed`, as many of them as there is room for.
    pub(super) fn build(pictures: &[RgbaImage], fixed: &[[u8; 3]]) -> Self {
        let mut bins = histogram(pictures);
        let mut colors: Vec<[f32; 3]> = fixed.iter().take(MAX_COLORS).map(|c| c.map(f32::from)).collect();
        let kept = colors.len();
        colors.extend(split(&mut bins, MAX_COLORS - kept));
        for _ in 0..ROUNDS {
            settle(&bins, &mut colors, kept);
        }
        let mut rounded: Vec<[u8; 3]> = colors.iter().map(|c| c.map(|v| v.round().clamp(0.0, 255.0) as u8)).collect();
        if rounded.is_empty() {
            rounded.push([0; 3]);
        }
        let exact: Vec<[f32; 3]> = rounded.iter().map(|c| c.map(f32::from)).collect();
        let mut nearest: Vec<u8> = (0..BINS).into_par_iter().map(|bin| nearest_of(&exact, center(bin)) as u8).collect();
        for (i, color) in rounded[..kept].iter().enumerate() {
            nearest[bin_of(*color)] = i as u8;
        }
        Self { colors: rounded, nearest }
    }

    /// The colours.
    pub(super) fn colors(&self) -> &[[u8; 3]] {
        &self.colors
    }

    /// The index of the colour nearest to `color`.
    #[inline]
    pub(super) fn nearest(&self, color: [u8; 3]) -> u8 {
        self.nearest[bin_of(color)]
    }
}

#[inline]
fn bin_of([r, g, b]: [u8; 3]) -> usize {
    let part = |value: u8, bits: u32| usize::from(value) >> (8 - bits);
    (part(r, BITS[0]) << (BITS[1] + BITS[2])) | (part(g, BITS[1]) << BITS[2]) | part(b, BITS[2])
}

fn center(bin: usize) -> [f32; 3] {
    let part = |shift: u32, bits: u32| {
        let value = (bin >> shift) & ((1 << bits) - 1);
        (value as f32 + 0.5) * f32::from(1u16 << (8 - bits)) - 0.5
    };
    [part(BITS[1] + BITS[2], BITS[0]), part(BITS[2], BITS[1]), part(0, BITS[2])]
}

/// Occupied bins with their mean colours. Large even areas weigh less than their size, or details starve.
fn histogram(pictures: &[RgbaImage]) -> Vec<Bin> {
    let mut sums = vec![[0u64; 4]; BINS];
    let pixels = pictures.iter().flat_map(|p| p.as_raw().chunks_exact(4));
    for pixel in pixels.filter(|p| p[3] >= super::gif::OPAQUE) {
        let sum = &mut sums[bin_of([pixel[0], pixel[1], pixel[2]])];
        for c in 0..3 {
            sum[c] += u64::from(pixel[c]);
        }
        sum[3] += 1;
    }
    sums.iter()
        .filter(|s| s[3] > 0)
        .map(|s| {
            let n = s[3] as f32;
            Bin { color: [s[0], s[1], s[2]].map(|v| v as f32 / n), weight: n.sqrt() * n.sqrt().sqrt() }
        })
        .collect()
}

/// Mean and weighted squared error along each axis.
fn moments(bins: &[Bin]) -> ([f32; 3], [f32; 3]) {
    let total: f32 = bins.iter().map(|b| b.weight).sum();
    let mean: [f32; 3] =
        std::array::from_fn(|c| bins.iter().map(|b| b.weight * b.color[c]).sum::<f32>() / total.max(f32::MIN_POSITIVE));
    let error = std::array::from_fn(|c| {
        WEIGHTS[c] * bins.iter().map(|b| b.weight * (b.color[c] - mean[c]).powi(2)).sum::<f32>()
    });
    (mean, error)
}

/// Means of at most `count` boxes around all bins.
fn split(bins: &mut [Bin], count: usize) -> Vec<[f32; 3]> {
    struct Part {
        from: usize,
        to: usize,
        mean: [f32; 3],
        error: [f32; 3],
    }
    let part = |bins: &[Bin], from: usize, to: usize| {
        let (mean, error) = moments(&bins[from..to]);
        Part { from, to, mean, error }
    };
    if bins.is_empty() || count == 0 {
        return Vec::new();
    }
    let mut parts = vec![part(bins, 0, bins.len())];
    while parts.len() < count {
        let total = |p: &Part| p.error.iter().sum::<f32>();
        let Some(worst) = (0..parts.len()).max_by(|&a, &b| total(&parts[a]).total_cmp(&total(&parts[b]))) else {
            break;
        };
        let Part { from, to, mean, error } = parts[worst];
        let axis = (0..3).max_by(|&a, &b| error[a].total_cmp(&error[b])).unwrap_or(1);
        let mut middle = from;
        for i in from..to {
            if bins[i].color[axis] < mean[axis] {
                bins.swap(i, middle);
                middle += 1;
            }
        }
        if middle == from || middle == to {
            break;
        }
        parts[worst] = part(bins, from, middle);
        parts.push(part(bins, middle, to));
    }
    parts.into_iter().map(|p| p.mean).collect()
}

/// One round of k-means; the first `kept` colours stay where they are.
fn settle(bins: &[Bin], colors: &mut [[f32; 3]], kept: usize) {
    let owner: Vec<usize> = bins.par_iter().map(|bin| nearest_of(colors, bin.color)).collect();
    let mut sums = vec![([0.0f32; 3], 0.0f32); colors.len()];
    for (bin, owner) in bins.iter().zip(owner) {
        let sum = &mut sums[owner];
        for c in 0..3 {
            sum.0[c] += bin.weight * bin.color[c];
        }
        sum.1 += bin.weight;
    }
    for (color, (sum, weight)) in colors.iter_mut().zip(sums).skip(kept) {
        if weight > 0.0 {
            *color = sum.map(|v| v / weight);
        }
    }
}

fn nearest_of(colors: &[[f32; 3]], color: [f32; 3]) -> usize {
    let mut best = (f32::INFINITY, 0);
    for (i, c) in colors.iter().enumerate() {
        let d = [c[0] - color[0], c[1] - color[1], c[2] - color[2]];
        let distance = WEIGHTS[0] * d[0] * d[0] + WEIGHTS[1] * d[1] * d[1] + WEIGHTS[2] * d[2] * d[2];
        if distance < best.0 {
            best = (distance, i);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_as_they_are() {
        let given = [[0u8, 0, 0], [255, 255, 255], [200, 30, 40], [12, 90, 200]];
        let picture = RgbaImage::from_fn(40, 40, |x, y| {
            let [r, g, b] = given[((x / 7 + y / 5) % 4) as usize];
            image::Rgba([r, g, b, 255])
        });
        let palette = Palette::build(&[picture], &[[90, 2, 3]]);
        for color in given {
            let got = palette.colors()[usize::from(palette.nearest(color))];
            assert!(got.iter().zip(color).all(|(a, b)| a.abs_diff(b) <= 1), "{got:?} for {color:?}");
        }
        assert_eq!(palette.colors()[0], [90, 2, 3]);
    }

    #[test]
    fn smooth_colours_are_met_closely_and_rare_given_ones_exactly() {
        let picture = RgbaImage::from_fn(256, 256, |x, y| image::Rgba([x as u8, y as u8, ((x + y) / 2) as u8, 255]));
        let palette = Palette::build(std::slice::from_ref(&picture), &[[255, 0, 255]]);
        assert_eq!(palette.colors().len(), MAX_COLORS);
        assert_eq!(palette.colors()[usize::from(palette.nearest([255, 0, 255]))], [255, 0, 255]);
        let error: f64 = picture
            .pixels()
            .map(|p| {
                let [r, g, b, _] = p.0;
                let q = palette.colors()[usize::from(palette.nearest([r, g, b]))];
                p.0.iter().zip(q).map(|(a, b)| f64::from(a.abs_diff(b)).powi(2)).sum::<f64>()
            })
            .sum::<f64>()
            / (256.0 * 256.0 * 3.0);
        // A regular 8x8x4 grid of this plane would be off by about 9 in the root mean square.
        assert!(error.sqrt() < 7.0, "root mean square error {}", error.sqrt());
    }
}
