//! What of a picture is the drawing: its alpha, or what differs from the paper around it.
//!
//! Without alpha, the paper is a plane of colour fitted to the picture's border, so that a photograph's shading goes with
//! it. What differs by more than a threshold between the two kinds (Otsu 1979) is ink; gaps up to a share of the
//! diagonal are closed, and what paper cannot be reached from outside belongs to the drawing.
//!
//! Known limits: a drawing that runs into the border on most sides, or a background of many colours, needs a mask.

use image::RgbaImage;

use crate::error::{Error, Result};
use crate::raster::distance::{NO_SITE, nearest_site};
use crate::raster::{Grid, Mask};

/// Gaps in the drawing's lines are closed up to twice this share of the diagonal.
const GAP: f32 = 0.006;
/// Colours closer to the paper than this are paper, whatever the threshold: the noise of photographs, in 0..=1 of
/// each channel.
const NOISE: f32 = 0.06;
/// Pieces smaller than this share of the largest are dust.
const DUST: f64 = 0.002;

/// How opaque each pixel of the drawing is, in 0..=1.
///
/// # Errors
/// An empty picture, one with nothing on it, and one that is filled from border to border.
pub(super) fn opacity(picture: &RgbaImage) -> Result<Grid<f32>> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    if width == 0 || height == 0 {
        return Err(Error::invalid("picture", "has no pixels", "give a drawing"));
    }
    let alpha = Grid::from_vec(width, height, picture.pixels().map(|p| f32::from(p.0[3]) / 255.0).collect());
    let clear = alpha.data().iter().filter(|a| **a < 0.5).count();
    if clear == width * height {
        return Err(Error::invalid("picture", "is fully transparent", "give a drawing that can be seen"));
    }
    if clear > 0 {
        return Ok(alpha);
    }
    let drawn = apart_from_paper(picture);
    if drawn.count() == 0 {
        return Err(Error::invalid("picture", "is all of one colour", "give a drawing, or one with transparency"));
    }
    if drawn.count() > width * height * 97 / 100 {
        let remedy = "cut the drawing out: make what lies around it transparent";
        return Err(Error::invalid("picture", "is opaque and no background shows around a drawing", remedy));
    }
    Ok(Grid::from_vec(
        width,
        height,
        (0..width * height).map(|i| f32::from(u8::from(drawn.get(i % width, i / width)))).collect(),
    ))
}

/// The mask of all pieces that are not dust, given the opacity.
pub(super) fn pieces(opacity: &Grid<f32>) -> Mask {
    let mask = Mask::from_fn(opacity.width(), opacity.height(), |x, y| opacity.get(x, y) > 0.5);
    let parts = crate::raster::morphology::parts(&mask);
    let least = parts.areas.iter().copied().max().unwrap_or(0) as f64 * DUST;
    Mask::from_fn(mask.width(), mask.height(), |x, y| {
        let part = parts.labels.get(x, y) as usize;
        part > 0 && parts.areas[part - 1] as f64 >= least
    })
}

fn apart_from_paper(picture: &RgbaImage) -> Mask {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let colour = |x: usize, y: usize| picture.get_pixel(x as u32, y as u32).0.map(|c| f32::from(c) / 255.0);
    let rim: Vec<(usize, usize)> = (0..width)
        .flat_map(|x| [(x, 0), (x, height - 1)])
        .chain((0..height).flat_map(|y| [(0, y), (width - 1, y)]))
        .collect();
    let paper = Paper::fit(&rim, &colour, width, height);
    let apart = Grid::from_vec(
        width,
        height,
        (0..width * height).map(|i| paper.distance(i % width, i / width, colour(i % width, i / width))).collect(),
    );
    let threshold = otsu(apart.data()).max(NOISE);
    let ink = Mask::from_fn(width, height, |x, y| apart.get(x, y) > threshold);
    let reach = (GAP * ((width * width + height * height) as f32).sqrt()).max(1.0);
    let thick = grown(&ink, reach);
    // Paper that is reached from the border past the thickened ink is outside.
    let mut outside = Mask::new(width, height);
    let mut waiting: Vec<(usize, usize)> = rim.into_iter().filter(|&(x, y)| !thick.get(x, y)).collect();
    waiting.iter().for_each(|&(x, y)| outside.set(x, y, true));
    while let Some((x, y)) = waiting.pop() {
        for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let (nx, ny) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            if nx < width && ny < height && !outside.get(nx, ny) && !thick.get(nx, ny) {
                outside.set(nx, ny, true);
                waiting.push((nx, ny));
            }
        }
    }
    let outside = grown(&outside, reach);
    Mask::from_fn(width, height, |x, y| ink.get(x, y) || !outside.get(x, y))
}

/// The mask with everything within `reach` pixels of it.
fn grown(mask: &Mask, reach: f32) -> Mask {
    let (width, height) = (mask.width(), mask.height());
    let sites = Grid::from_vec(
        width,
        height,
        (0..width * height).map(|i| if mask.get(i % width, i / width) { i as u32 } else { NO_SITE }).collect(),
    );
    let nearest = nearest_site(&sites);
    Mask::from_fn(width, height, |x, y| match nearest.get(x, y) {
        NO_SITE => false,
        site => {
            let (sx, sy) = (site as usize % width, site as usize / width);
            let (dx, dy) = (sx.abs_diff(x) as f32, sy.abs_diff(y) as f32);
            dx * dx + dy * dy <= reach * reach
        }
    })
}

/// A colour that changes evenly over the picture.
struct Paper {
    size: [f32; 2],
    /// For each channel: at the centre, to the right, and down.
    channels: [[f32; 3]; 3],
}

impl Paper {
    /// Fitted to the rim, and again without what does not fit: drawings touch the border.
    fn fit(
        rim: &[(usize, usize)],
        colour: &impl Fn(usize, usize) -> [f32; 3 + 1],
        width: usize,
        height: usize,
    ) -> Self {
        let size = [width as f32, height as f32];
        let mut kept: Vec<(usize, usize)> = rim.to_vec();
        let mut paper = Self { size, channels: [[0.0; 3]; 3] };
        for round in 0..4 {
            let mut sums = [[0f64; 3]; 3];
            let mut right = [[0f64; 3]; 3];
            for &(x, y) in &kept {
                let place = paper.place(x, y).map(f64::from);
                for i in 0..3 {
                    for j in 0..3 {
                        sums[i][j] += place[i] * place[j];
                        right[j][i] += place[i] * f64::from(colour(x, y)[j]);
                    }
                }
            }
            let matrix = glam::DMat3::from_cols_array_2d(&sums);
            if matrix.determinant().abs() < 1e-9 {
                for (channel, right) in paper.channels.iter_mut().zip(right) {
                    *channel = [(right[0] / sums[0][0].max(1.0)) as f32, 0.0, 0.0];
                }
                return paper;
            }
            for (channel, right) in paper.channels.iter_mut().zip(right) {
                *channel = (matrix.inverse() * glam::DVec3::from_array(right)).as_vec3().to_array();
            }
            let mut gaps: Vec<f32> = kept.iter().map(|&(x, y)| paper.distance(x, y, colour(x, y))).collect();
            gaps.sort_unstable_by(f32::total_cmp);
            let bound = (2.5 * gaps[gaps.len() / 2]).max(NOISE);
            if round < 3 {
                let next: Vec<(usize, usize)> =
                    kept.iter().copied().filter(|&(x, y)| paper.distance(x, y, colour(x, y)) <= bound).collect();
                if next.len() == kept.len() || next.len() < rim.len() / 4 {
                    break;
                }
                kept = next;
            }
        }
        paper
    }

    fn place(&self, x: usize, y: usize) -> [f32; 3] {
        [1.0, x as f32 / self.size[0] - 0.5, y as f32 / self.size[1] - 0.5]
    }

    fn distance(&self, x: usize, y: usize, colour: [f32; 4]) -> f32 {
        let place = self.place(x, y);
        let gap = |channel: usize| {
            let wished: f32 = self.channels[channel].iter().zip(place).map(|(c, p)| c * p).sum();
            (colour[channel] - wished).abs()
        };
        gap(0).max(gap(1)).max(gap(2))
    }
}

/// The threshold that parts values in 0..=1 into two kinds that differ most.
fn otsu(values: &[f32]) -> f32 {
    let mut counts = [0f64; 256];
    values.iter().for_each(|v| counts[(v.clamp(0.0, 1.0) * 255.0) as usize] += 1.0);
    let total = values.len() as f64;
    let mean: f64 = counts.iter().enumerate().map(|(i, c)| i as f64 * c).sum::<f64>() / total;
    let (mut below, mut sum, mut best, mut threshold) = (0.0, 0.0, 0.0, 0);
    for (i, count) in counts.iter().enumerate() {
        below += count;
        sum += i as f64 * count;
        if below == 0.0 || below == total {
            continue;
        }
        let between = (mean * below - sum).powi(2) / (below * (total - below));
        if between > best {
            (best, threshold) = (between, i);
        }
    }
    // Thin pale lines lie below the middle of strong ones.
    0.6 * (threshold as f32 + 1.0) / 255.0
}
