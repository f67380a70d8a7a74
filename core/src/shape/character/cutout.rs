//! What of a picture is the drawing: its alpha, or what differs from the paper around it.
//!
//! Without alpha, the paper is a plane of colour fitted to the picture's border, so that a photograph's shading goes with
//! it. What differs by more than a threshold between the two kinds (Otsu 1979) is ink; gaps up to a share of the
//! diagonal are closed, and what paper cannot be reached from outside belongs to the drawing.
//!
//! The cut-out's rim is unmixed: a rim pixel is paper and the strongest ink beside it in shares, of which ink stays. Under
//! what is clear lie the colours of the rim (push and pull), so that no reader between the pixels finds paper or black.
//!
//! Known limits: a drawing that runs into the border on most sides, or a background of many colours, needs a mask. Where a
//! drawing has no outline and is coloured like the paper, its rim is as coarse as the pixels.

use glam::{Vec2, Vec3};
use image::RgbaImage;

use crate::error::{Error, Result};
use crate::raster::distance::{NO_SITE, nearest_site};
use crate::raster::{Grid, Mask, Wrap, push_pull};

/// Gaps in the drawing's lines are closed up to twice this share of the diagonal.
const GAP: f32 = 0.006;
/// Colours closer to the paper than this are paper, whatever the threshold: the noise of photographs, in 0..=1 of
/// each channel.
const NOISE: f32 = 0.06;
/// Pieces smaller than this share of the largest are dust.
const DUST: f64 = 0.002;
/// Ink that shares a rim pixel with paper lies at most so many pixels away: scanners and cameras blur over two.
const RIM: isize = 2;
/// Of a pixel with less ink than this, what is left after taking the paper off is noise: the ink beside it is taken.
const UNMIXED: f32 = 0.4;
/// Colours that are less opaque than this, of 255, are too coarse to spread.
const SPREADS: u8 = 64;

/// How opaque each pixel of the drawing is, in 0..=1.
///
/// # Errors
/// An empty picture, one with nothing on it, and one that is filled from border to border.
pub(super) fn opacity(picture: &RgbaImage) -> Result<Grid<f32>> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    Ok(match found(picture)? {
        Found::Alpha => Grid::from_vec(width, height, picture.pixels().map(|p| f32::from(p.0[3]) / 255.0).collect()),
        Found::OnPaper(drawn, _) => {
            let on = |i: usize| f32::from(u8::from(drawn.get(i % width, i / width)));
            Grid::from_vec(width, height, (0..width * height).map(on).collect())
        }
    })
}

/// Where a drawing is on its picture.
enum Found {
    /// Where the picture is opaque.
    Alpha,
    /// Where it differs from the paper.
    OnPaper(Mask, Paper),
}

fn found(picture: &RgbaImage) -> Result<Found> {
    let pixels = picture.width() as usize * picture.height() as usize;
    if pixels == 0 {
        return Err(Error::invalid("picture", "has no pixels", "give a drawing"));
    }
    let clear = picture.pixels().filter(|p| p.0[3] < 128).count();
    if clear == pixels {
        return Err(Error::invalid("picture", "is fully transparent", "give a drawing that can be seen"));
    }
    if clear > 0 {
        return Ok(Found::Alpha);
    }
    let (drawn, paper) = apart_from_paper(picture);
    if drawn.count() == 0 {
        return Err(Error::invalid("picture", "is all of one colour", "give a drawing, or one with transparency"));
    }
    if drawn.count() > pixels * 97 / 100 {
        let remedy = "cut the drawing out: make what lies around it transparent";
        return Err(Error::invalid("picture", "is opaque and no background shows around a drawing", remedy));
    }
    Ok(Found::OnPaper(drawn, paper))
}

/// The drawing cut out of its picture: straight alpha, with clean colours at the rim and under what is clear. A picture that
/// is clear somewhere keeps its alpha, and its colours where it is not fully clear.
///
/// # Errors
/// As for [`super::Character::from_picture`]: an empty picture, one with nothing on it, one filled from border to border.
pub fn cut_out(picture: &RgbaImage) -> Result<RgbaImage> {
    let mut out = picture.clone();
    if let Found::OnPaper(drawn, paper) = found(picture)? {
        unmix(&mut out, picture, &drawn, &paper);
    }
    spread(&mut out);
    Ok(out)
}

/// Sets the alpha of a drawing on paper, and takes the paper out of its rim.
fn unmix(out: &mut RgbaImage, picture: &RgbaImage, drawn: &Mask, paper: &Paper) {
    let (width, height) = (drawn.width(), drawn.height());
    let opacity = Grid::from_vec(
        width,
        height,
        (0..width * height).map(|i| f32::from(u8::from(drawn.get(i % width, i / width)))).collect(),
    );
    let mut kept = pieces(&opacity);
    let colour = |x: isize, y: isize| {
        let p = picture.get_pixel(x as u32, y as u32).0;
        Vec3::new(f32::from(p[0]), f32::from(p[1]), f32::from(p[2])) / 255.0
    };
    open(&mut kept, |x, y| paper.strength(x, y, colour(x as isize, y as isize)) <= NOISE);
    let inside = |x: isize, y: isize| kept.at(x, y);
    let in_picture = |x: isize, y: isize| x >= 0 && y >= 0 && (x as usize) < width && (y as usize) < height;
    let around = || (-RIM..=RIM).flat_map(|dy| (-RIM..=RIM).map(move |dx| (dx, dy)));
    for (px, py, pixel) in out.enumerate_pixels_mut() {
        let (x, y) = (px as isize, py as isize);
        let own = inside(x, y);
        pixel.0[3] = if own { 255 } else { 0 };
        // A drawing that runs out of the picture has no rim there.
        let beside = |dx: isize, dy: isize| dx.abs() <= 1 && dy.abs() <= 1;
        let outside = |(dx, dy)| beside(dx, dy) && in_picture(x + dx, y + dy) && !inside(x + dx, y + dy);
        if own && !around().any(outside) {
            continue;
        }
        let strength = |c: Vec3| paper.strength(px as usize, py as usize, c);
        let of_drawing = || around().filter(|&(dx, dy)| inside(x + dx, y + dy));
        let (inward_x, inward_y) = of_drawing().fold((0, 0), |sum, (dx, dy)| (sum.0 + dx, sum.1 + dy));
        let inward = Vec2::new(inward_x as f32, inward_y as f32).normalize_or_zero();
        let strongest = |found: &dyn Fn(f32) -> bool| {
            let ways =
                of_drawing().filter(|&(dx, dy)| found(Vec2::new(dx as f32, dy as f32).normalize_or_zero().dot(inward)));
            ways.map(|(dx, dy)| colour(x + dx, y + dy)).max_by(|a, b| strength(*a).total_cmp(&strength(*b)))
        };
        let mixed = colour(x, y);
        let Some(ink) = strongest(&|way| way > 0.0).filter(|ink| strength(*ink) > strength(mixed).max(NOISE)) else {
            continue;
        };
        // On the inner side of a line, which no paper touches, the drawing goes on, paler; in a notch the line lies on both
        // sides.
        let touched = around().any(|(dx, dy)| dx.abs() + dy.abs() == 1 && outside((dx, dy)));
        let lined = |found: &dyn Fn(f32) -> bool| strongest(found).is_some_and(|c| strength(c) > strength(mixed));
        if own && !touched && lined(&|way| way < -0.7) && !lined(&|way| way > 0.7) {
            continue;
        }
        let (ground, faint) = (paper.colour(px as usize, py as usize), !own && strength(mixed) <= NOISE);
        let way = ink - ground;
        let share = ((mixed - ground).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let share = if faint { 0.0 } else { share };
        let clean = if share >= UNMIXED { (mixed - ground * (1.0 - share)) / share } else { ink };
        let rgb = clean.clamp(Vec3::ZERO, Vec3::ONE) * 255.0 + 0.5;
        pixel.0 = [rgb.x as u8, rgb.y as u8, rgb.z as u8, (share * 255.0 + 0.5) as u8];
    }
}

/// Takes the paper that closing the lines' gaps has added out again, as far as it reaches in from outside.
fn open(drawn: &mut Mask, is_paper: impl Fn(usize, usize) -> bool) {
    let (width, height) = (drawn.width(), drawn.height());
    let steps = 2 * closing(width, height).ceil() as usize;
    let every = (0..width * height).map(|i| (i % width, i / width));
    let mut edge: Vec<(usize, usize)> = every.filter(|&(x, y)| !drawn.get(x, y)).collect();
    for _ in 0..steps {
        let mut next = Vec::new();
        for (x, y) in edge {
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let (nx, ny) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                if nx < width && ny < height && drawn.get(nx, ny) && is_paper(nx, ny) {
                    drawn.set(nx, ny, false);
                    next.push((nx, ny));
                }
            }
        }
        edge = next;
    }
}

/// How far lines are thickened to close their gaps, in pixels.
fn closing(width: usize, height: usize) -> f32 {
    (GAP * ((width * width + height * height) as f32).sqrt()).max(1.0)
}

/// Puts the colours of what can be seen under what is clear.
fn spread(picture: &mut RgbaImage) {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let known = Grid::from_vec(width, height, picture.pixels().map(|p| p.0[3] >= SPREADS).collect());
    let mut colours: Vec<[f32; 3]> = picture.pixels().map(|p| [p.0[0], p.0[1], p.0[2]].map(f32::from)).collect();
    push_pull(&mut colours, &known, Wrap::default(), [0.0; 3]);
    for (pixel, c) in picture.pixels_mut().zip(colours) {
        if pixel.0[3] == 0 {
            let [r, g, b] = c.map(|v| (v + 0.5) as u8);
            pixel.0 = [r, g, b, 0];
        }
    }
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

fn apart_from_paper(picture: &RgbaImage) -> (Mask, Paper) {
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
    let reach = closing(width, height);
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
    (Mask::from_fn(width, height, |x, y| ink.get(x, y) || !outside.get(x, y)), paper)
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

    fn colour(&self, x: usize, y: usize) -> Vec3 {
        let place = Vec3::from(self.place(x, y));
        Vec3::from(self.channels.map(|c| Vec3::from(c).dot(place)))
    }

    fn distance(&self, x: usize, y: usize, [r, g, b, _]: [f32; 4]) -> f32 {
        self.strength(x, y, Vec3::new(r, g, b))
    }

    /// How far a colour is from the paper there, in the channel where it is farthest.
    fn strength(&self, x: usize, y: usize, colour: Vec3) -> f32 {
        (colour - self.colour(x, y)).abs().max_element()
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
