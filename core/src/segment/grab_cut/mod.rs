//! An object in one frame, found from a few points on it.
//!
//! GrabCut (Rother, Kolmogorov and Blake 2004) as Live Sketch uses it: the box around the points holds the object, what lies
//! outside is background; both sides' colours are Gaussian mixtures, the object is the minimum cut over colours and contrast,
//! and both are found by turns. Beyond the paper: learning begins with the figure that the points suggest, not with the
//! whole box, and what lies far from it is less likely object. Where the picture has transparency, or an even background, that
//! decides and nothing is learnt. What is left is one piece without holes, the one that holds the most points.
//!
//! Known limits: a background of the object's colours in the box, or an object that fills the picture before a busy
//! one, of which little teaches what background is; brush strokes of object and background help. One cut cannot be
//! cancelled half-way.

mod mixture;

use std::ops::Range;

use glam::{DVec3, Vec2, vec2};

use self::mixture::Mixture;
use super::contrast::Contrast;
use super::figure;
use super::grid_cut::{GridCut, Neighbour};
use super::painted::{Known, brush_over, reduce};
use crate::clip::Picture;
use crate::error::{Error, Result};
use crate::geometry::polygon;
use crate::job::Stage;
use crate::raster::distance::distance_to;
use crate::raster::marching_squares::outlines;
use crate::raster::morphology::{parts, without_holes};
use crate::raster::{Grid, Mask, pyramid};
use crate::rig::Paint;

/// The longer side of what is looked at, in working pixels: a cut takes some 50 ms there.
const WORKING: f32 = 320.0;
/// How far the object reaches beyond its points' box, and how much background around that is looked at, as shares of the box's
/// diagonal: points lie inside limbs.
const GROWN: f32 = 0.1;
const AROUND: f32 = 0.15;
/// Rounds of cutting and learning.
const ROUNDS: usize = 5;
/// The share of pixels that change in a round after which it is the last.
const SETTLED: f32 = 0.001;
/// The price of parting equal neighbours beside colours, the paper's, and the fixed point of capacities.
const GAMMA: f32 = 50.0;
const UNIT: f32 = 64.0;
/// Places of what moves that say which piece of a cut is meant.
const SAMPLES: usize = 500;
/// Colours say no more than this, as a natural logarithm.
const LARGEST_ODDS: f64 = 12.0;
/// The radius that the figure is closed with, a share of the diagonal: at 0.18, as good as any for placing points, ground between
/// legs is taken for object.
const FIGURE_CLOSING: f32 = 0.08;
/// What the suggested figure says of a pixel in it, and at what share of the box's diagonal away from it that is 0; farther off
/// it falls on, down to the negative of the bound.
const FIGURE_SAYS: f32 = 1.5;
const FIGURE_REACH: f32 = 0.06;
const FIGURE_BOUND: f32 = 6.0;
/// What moves is known with a rim of ground around it.
const MOVING_REACH: f32 = 0.015;
/// Where this share of what is looked at is surely background, that alone teaches it at first. Where the object fills the picture,
/// pixels do that are farther from the figure than this share of the diagonal.
const ENOUGH: f32 = 0.15;
const CLEAR: f32 = 0.04;
/// More than all else says of a pixel.
const CERTAIN: i32 = 1 << 22;
/// Colours that a mixture is fitted to, at most.
const LEARNT: usize = 6000;
/// An even background: this share of the pixels around is within so many levels of one colour.
const EVEN: f32 = 0.97;
const LEVEL: u8 = 10;
/// What is transparent or even must leave no more than this share of the picture.
const LARGEST: f32 = 0.95;
const EDGES: [(Neighbour, isize, usize, f32); 4] = [
    (Neighbour::Right, 1, 0, 1.0),
    (Neighbour::Below, 0, 1, 1.0),
    (Neighbour::BelowRight, 1, 1, std::f32::consts::SQRT_2),
    (Neighbour::BelowLeft, -1, 1, std::f32::consts::SQRT_2),
];

/// The object that `points` (clip pixels) lie on, of the picture's size; `paint` is what the user brushed over the picture,
/// if anything.
///
/// # Errors
/// There are fewer than three places in the picture; the picture has nothing at the points; or the work is cancelled.
pub fn object_mask(picture: &Picture, points: &[Vec2], paint: &[Paint], stage: Stage<'_>) -> Result<Mask> {
    stage.name("finding the object")?;
    let (width, height) = picture.rgb.dimensions();
    let size = vec2(width as f32, height as f32);
    let inside = |p: &&Vec2| p.is_finite() && p.cmpge(Vec2::ZERO).all() && p.cmplt(size).all();
    let points: Vec<Vec2> = points.iter().filter(inside).copied().collect();
    let figure = figure::suggested(&points, &[], FIGURE_CLOSING);
    if points.len() < 3 || figure.is_empty() {
        let problem = format!("{} of them lie in the picture, or all in one place", points.len());
        return Err(Error::invalid("control points", problem, "mark three points on the object, or draw its contour"));
    }
    let easy = if paint.is_empty() { plain_mask(picture) } else { None };
    let easy = easy.and_then(|mask| held(&mask, &points, 0.5));
    let mask = match easy {
        Some(mask) => Some(mask),
        None => held(
            &cut(picture, &Hints { points: &points, figure: &figure, reach: FIGURE_REACH, paint }, stage)?,
            &points,
            0.0,
        ),
    };
    let remedy = "paint over the object and its background, or draw its contour";
    mask.ok_or_else(|| Error::invalid("the object", "nothing is found at the points", remedy))
}

/// The object of which `moving`, a mask of the picture's size, is known to move: that itself, where colours tell nothing.
///
/// # Errors
/// The work is cancelled.
pub(crate) fn moving_object(picture: &Picture, moving: &Mask, stage: Stage<'_>) -> Result<Mask> {
    stage.name("finding the object")?;
    let figure = object_contour(moving);
    let mask = cut(picture, &Hints { points: &[], figure: &figure, reach: MOVING_REACH, paint: &[] }, stage)?;
    let width = moving.width();
    let step = moving.count().div_ceil(SAMPLES).max(1);
    let pixels = (0..width * moving.height()).map(|i| (i % width, i / width)).filter(|&(x, y)| moving.get(x, y));
    let samples: Vec<Vec2> = pixels.step_by(step).map(|(x, y)| vec2(x as f32 + 0.5, y as f32 + 0.5)).collect();
    Ok(held(&mask, &samples, 0.0).unwrap_or_else(|| moving.clone()))
}

/// What is opaque, or stands before an even background, where that is not nearly all: nothing is learnt for it.
pub(crate) fn plain_mask(picture: &Picture) -> Option<Mask> {
    opaque(picture).or_else(|| before_even(picture))
}

/// The outer contour of a mask's largest piece, in its pixels, turning from x to y; empty for an empty mask.
pub fn object_contour(mask: &Mask) -> Vec<Vec2> {
    let (width, height) = (mask.width(), mask.height());
    let value = |i: usize| f32::from(u8::from(mask.get(i % width, i / width)));
    let found = outlines(&Grid::from_vec(width, height, (0..width * height).map(value).collect()), 0.5);
    let largest = found.into_iter().max_by(|a, b| polygon::signed_area(a).total_cmp(&polygon::signed_area(b)));
    largest.unwrap_or_default()
}

/// The piece that holds the most points, with its holes filled; `None` where those are no more than the share.
fn held(mask: &Mask, points: &[Vec2], share: f32) -> Option<Mask> {
    let pieces = parts(mask);
    let mut count = vec![0usize; pieces.areas.len() + 1];
    for p in points {
        // Points are marked on outlines, too: a pixel or two beside is on it.
        let near = (-2..=2).flat_map(|y| (-2..=2).map(move |x| (x, y)));
        let at = |(x, y): (isize, isize)| {
            let (x, y) = (p.x as isize + x, p.y as isize + y);
            if mask.at(x, y) { pieces.labels.get(x as usize, y as usize) as usize } else { 0 }
        };
        count[near.map(at).max_by_key(|&piece| if piece == 0 { 0 } else { pieces.areas[piece - 1] }).unwrap_or(0)] += 1;
    }
    let best = (1..count.len()).max_by_key(|&piece| (count[piece], pieces.areas[piece - 1]))?;
    let alone = || Mask::from_fn(mask.width(), mask.height(), |x, y| pieces.labels.get(x, y) as usize == best);
    (count[best] as f32 > share * points.len() as f32).then(|| without_holes(&alone(), usize::MAX))
}

/// What is more opaque than not, where that is not nearly all.
fn opaque(picture: &Picture) -> Option<Mask> {
    let mask = Mask::from_image(picture.alpha.as_ref()?);
    small(mask)
}

fn small(mask: Mask) -> Option<Mask> {
    let all = (mask.width() * mask.height()) as f32;
    (mask.count() as f32 <= LARGEST * all).then_some(mask)
}

/// What an even background that reaches around the picture leaves.
fn before_even(picture: &Picture) -> Option<Mask> {
    let (width, height) = (picture.rgb.width() as usize, picture.rgb.height() as usize);
    let pixel = |x: usize, y: usize| picture.rgb.get_pixel(x as u32, y as u32).0;
    let rim: Vec<[u8; 3]> = (0..width)
        .flat_map(|x| [pixel(x, 0), pixel(x, height - 1)])
        .chain((0..height).flat_map(|y| [pixel(0, y), pixel(width - 1, y)]))
        .collect();
    let median: [u8; 3] = std::array::from_fn(|c| {
        let mut levels: Vec<u8> = rim.iter().map(|p| p[c]).collect();
        *levels.select_nth_unstable(rim.len() / 2).1
    });
    let even = |p: [u8; 3]| p.iter().zip(median).all(|(a, b)| a.abs_diff(b) <= LEVEL);
    if rim.iter().filter(|p| even(**p)).count() < (EVEN * rim.len() as f32) as usize {
        return None;
    }
    // Even pixels inside the object do not reach the picture's rim.
    let differs = Mask::from_fn(width, height, |x, y| !even(pixel(x, y)));
    small(without_holes(&differs, usize::MAX))
}

/// What is known of an object, in clip pixels.
struct Hints<'a> {
    /// Places that are certain.
    points: &'a [Vec2],
    /// A contour about which it lies.
    figure: &'a [Vec2],
    /// The share of the diagonal of their box away from it at which the figure says nothing.
    reach: f32,
    /// What the user brushed over the picture.
    paint: &'a [Paint],
}

/// The object as a minimum cut.
fn cut(picture: &Picture, hints: &Hints<'_>, stage: Stage<'_>) -> Result<Mask> {
    let &Hints { points, figure, reach: figure_reach, paint } = hints;
    let (width, height) = (picture.rgb.width() as usize, picture.rgb.height() as usize);
    let mut mask = Mask::new(width, height);
    let box_of = if points.is_empty() { figure } else { points };
    let Some((low, high)) = polygon::extent(box_of) else { return Ok(mask) };
    let diagonal = low.distance(high);
    let scale = (WORKING / ((high - low).max_element() + 2.0 * (GROWN + AROUND) * diagonal)).min(1.0);
    let (across, down) =
        ((width as f32 * scale).ceil().max(1.0) as usize, (height as f32 * scale).ceil().max(1.0) as usize);
    let to = vec2(across as f32 / width as f32, down as f32 / height as f32);
    let image = pyramid::shrunk(&picture.rgb, across as u32, down as u32);
    stage.at(0.1)?;
    let image = Grid::from_vec(across, down, image.pixels().map(|p| p.0).collect());
    let reach = |by: f32, x: usize, y: usize| {
        let at = vec2(x as f32 + 0.5, y as f32 + 0.5) / to;
        at.cmpge(low - by * diagonal).all() && at.cmple(high + by * diagonal).all()
    };
    let window = {
        let (from, until) = ((low - (GROWN + AROUND) * diagonal) * to, (high + (GROWN + AROUND) * diagonal) * to);
        let range = |from: f32, until: f32, all: usize| (from.max(0.0) as usize)..(until.ceil() as usize).min(all);
        (range(from.x, until.x, across), range(from.y, until.y, down))
    };
    let mut brushed = Grid::new(width, height, Known::Nothing);
    brush_over(&mut brushed, paint);
    let mut known = reduce(&brushed, across, down);
    for p in points {
        known.set(((p.x * to.x) as usize).min(across - 1), ((p.y * to.y) as usize).min(down - 1), Known::Creature);
    }
    stage.at(0.2)?;
    let away = away_from(figure, to, &window);
    stage.at(0.25)?;
    let (columns, rows) = window.clone();
    let (wide, tall) = (columns.len(), rows.len());
    let place = |i: usize| (columns.start + i % wide.max(1), rows.start + i / wide.max(1));
    let contrast = Contrast::of(&image, &window);
    // Whether each pixel of the window is object; at first what teaches which side.
    let decided = |x: usize, y: usize| match known.get(x, y) {
        Known::Creature => Some(true),
        Known::Background => Some(false),
        Known::Nothing => (!reach(GROWN, x, y)).then_some(false),
    };
    let outside = (0..wide * tall).map(place).filter(|&(x, y)| decided(x, y) == Some(false)).count();
    let clear = if outside as f32 >= ENOUGH * (wide * tall) as f32 { f32::INFINITY } else { CLEAR };
    let first = |i: usize| {
        let (x, y) = place(i);
        let share = away.data()[i] / diagonal;
        decided(x, y).or(if share <= 0.0 { Some(true) } else { (share > clear).then_some(false) })
    };
    let mut labels: Vec<Option<bool>> = (0..wide * tall).map(first).collect();
    let colour = |x: usize, y: usize| DVec3::from_array(image.get(x, y).map(f64::from));
    for round in 0..ROUNDS {
        stage.at(0.25 + 0.75 * round as f64 / ROUNDS as f64)?;
        let learn = |side: bool| {
            let own: Vec<usize> = (0..labels.len()).filter(|&i| labels[i] == Some(side)).collect();
            let step = own.len().div_ceil(LEARNT).max(1);
            let colours: Vec<DVec3> = own.iter().step_by(step).map(|&i| place(i)).map(|(x, y)| colour(x, y)).collect();
            Mixture::fit(&colours)
        };
        let (Some(object), Some(background)) = (learn(true), learn(false)) else { break };
        stage.at(0.25 + 0.75 * (round as f64 + 0.5) / ROUNDS as f64)?;
        let mut problem = GridCut::new(wide, tall);
        for i in 0..labels.len() {
            let (x, y) = place(i);
            let (column, row) = (i % wide, i / wide);
            problem.add_terminal(
                column,
                row,
                match decided(x, y) {
                    Some(true) => CERTAIN,
                    Some(false) => -CERTAIN,
                    None => {
                        let says = object.log_density(colour(x, y)) - background.log_density(colour(x, y));
                        let near = 1.0 - away.data()[i] / (figure_reach * diagonal);
                        let near = (FIGURE_SAYS * near).max(-FIGURE_BOUND);
                        ((says.clamp(-LARGEST_ODDS, LARGEST_ODDS) as f32 + near) * UNIT) as i32
                    }
                },
            );
            for (to, dx, dy, far) in EDGES {
                let (nx, ny) = (column.wrapping_add_signed(dx), row + dy);
                if nx < wide && ny < tall {
                    let weight = contrast.weight(image.get(x, y), image.get(columns.start + nx, rows.start + ny));
                    problem.set_edge(column, row, to, (GAMMA * weight / far * UNIT) as i32);
                }
            }
        }
        problem.solve();
        let mut changed = 0;
        for (i, label) in labels.iter_mut().enumerate() {
            let now = Some(problem.on_source_side(i % wide, i / wide));
            changed += usize::from(*label != now);
            *label = now;
        }
        if (changed as f32) < SETTLED * labels.len() as f32 {
            break;
        }
    }
    for y in 0..height {
        for x in 0..width {
            let (column, row) = ((x as f32 + 0.5) * to.x, (y as f32 + 0.5) * to.y);
            let (column, row) = (column as usize, row as usize);
            if columns.contains(&column) && rows.contains(&row) {
                mask.set(x, y, labels[(row - rows.start) * wide + column - columns.start] == Some(true));
            }
        }
    }
    stage.at(1.0)?;
    Ok(mask)
}

/// How far the working pixels of a window are from the figure, in clip pixels, row by row; 0 inside.
fn away_from(figure: &[Vec2], to: Vec2, (columns, rows): &(Range<usize>, Range<usize>)) -> Grid<f32> {
    let coarse = [polygon::resample(figure, |_| 4.0 / to.min_element())];
    let place = |x: usize, y: usize| vec2((columns.start + x) as f32 + 0.5, (rows.start + y) as f32 + 0.5) / to;
    let inside = Mask::from_fn(columns.len(), rows.len(), |x, y| polygon::contain(&coarse, place(x, y)));
    let mut away = distance_to(&inside, true);
    away.data_mut().iter_mut().for_each(|d| *d /= to.min_element());
    away
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Progress;
    use image::{GrayImage, Luma, Rgb, RgbImage};

    /// A body with a neck.
    fn object(x: u32, y: u32) -> bool {
        let (x, y) = (x as f32 - 100.0, y as f32 - 90.0);
        (x / 50.0).powi(2) + (y / 28.0).powi(2) < 1.0 || (x > 25.0 && x < 45.0 && y < 0.0 && y > -60.0)
    }

    fn truth() -> Mask {
        Mask::from_fn(200, 150, |x, y| object(x as u32, y as u32))
    }

    /// The object, even or speckled, before a background that is even or speckled.
    fn picture(speckled: bool, alpha: bool) -> Picture {
        let speck = |x: u32, y: u32| if speckled { (x * 31 + y * 57 + x * y % 13) as u8 % 40 } else { 0 };
        let rgb = RgbImage::from_fn(200, 150, |x, y| {
            let s = speck(x, y);
            if object(x, y) { Rgb([150 + s, 60, 40 + s]) } else { Rgb([60 + s, 130 - s, 60]) }
        });
        let opacity = |x, y| Luma([if object(x, y) { 255 } else { 0 }]);
        let shown = if alpha { RgbImage::from_pixel(200, 150, Rgb([9, 9, 9])) } else { rgb };
        Picture {
            rgb: image::ImageBuffer::from_raw(200, 150, shown.into_raw().into()).expect("its size"),
            alpha: alpha.then(|| GrayImage::from_fn(200, 150, opacity)),
        }
    }

    const POINTS: [Vec2; 5] =
        [vec2(60.0, 90.0), vec2(100.0, 100.0), vec2(140.0, 92.0), vec2(135.0, 40.0), vec2(100.0, 112.0)];

    #[test]
    fn the_object_is_found_whatever_is_behind_it() {
        let progress = Progress::new();
        for (speckled, alpha) in [(false, false), (true, false), (true, true)] {
            let mask = object_mask(&picture(speckled, alpha), &POINTS, &[], progress.whole()).expect("found");
            assert!(mask.iou(&truth()) > 0.97, "{speckled} {alpha}: {}", mask.iou(&truth()));
            let contour = object_contour(&mask);
            assert!((polygon::signed_area(&contour) / truth().count() as f64 - 1.0).abs() < 0.03);
        }
    }

    #[test]
    fn what_is_brushed_is_kept() {
        let stroke = |foreground, from: Vec2, to: Vec2| Paint { foreground, radius: 4.0, points: vec![from, to] };
        let paint =
            [stroke(false, vec2(130.0, 32.0), vec2(140.0, 32.0)), stroke(true, vec2(100.0, 115.0), vec2(100.0, 126.0))];
        let points = [POINTS[0], POINTS[1], POINTS[2], POINTS[4]];
        let progress = Progress::new();
        let mask = object_mask(&picture(true, false), &points, &paint, progress.whole()).expect("found");
        assert!(!mask.get(135, 32) && mask.get(100, 125), "brushes decide");
    }

    #[test]
    fn mistakes_are_named_and_a_cancel_stops() {
        let progress = Progress::new();
        let picture = picture(true, false);
        let nan = Vec2::splat(f32::NAN);
        for points in
            [&[][..], &POINTS[..2], &[POINTS[0]; 4], &[nan; 5], &[vec2(-9.0, 4.0), vec2(900.0, 3.0), POINTS[0]]]
        {
            let message = object_mask(&picture, points, &[], progress.whole()).expect_err("too little").to_string();
            assert!(message.contains("three points"), "{message}");
        }
        progress.cancel();
        assert!(matches!(object_mask(&picture, &POINTS, &[], progress.whole()), Err(Error::Cancelled)));
        assert!(object_contour(&Mask::new(9, 9)).is_empty());
    }
}
