//! Limb labels: every pixel of the creature goes to exactly one limb.
//!
//! Method: orthogonal marching (Reinert 2016, section 3.6). From every place on a stroke the image is walked along
//! both normals until the mask ends; a pixel that several walks reach keeps the nearest stroke, as in a z-buffer of
//! distances. This is no Voronoi diagram: distances count strictly across the stroke, the direction in which the
//! cylinders are measured later. Pixels of the mask that no walk reaches (outside of bends, beyond stroke ends) take
//! the label of the labelled pixel nearest to them inside the mask; islands without a stroke take the nearest stroke.
//!
//! Known limits: a pair of legs side by side is parted midway between the strokes, not along the visible contour.

use std::collections::VecDeque;

use glam::Vec2;

use crate::geometry::polyline;
use crate::raster::{Grid, Mask};
use crate::rig::{Rig, Side};

/// Steps along a stroke and across it, in pixels: short enough that no pixel between two walks of a straight limb is
/// missed.
const STEP: f32 = 0.5;
/// Distances of near limbs are shrunk, those of far limbs stretched by this factor: where both reach, the limb in
/// front shows unless the other's stroke is clearly closer.
const DEPTH_FACTOR: f32 = 1.25;
/// No clip is larger; keeps a walk finite for strokes far outside the image.
const MAX_STEPS: usize = 1 << 16;

/// Labels each pixel of `mask` with the limb it belongs to: 0 outside, limb index + 1 inside. `strokes` are the limbs
/// of one frame, in clip pixels. Limbs with fewer than two finite points get no pixel.
pub fn label_limbs(mask: &Mask, strokes: &[Vec<Vec2>]) -> Grid<u16> {
    label_limbs_by_depth(mask, strokes, &[])
}

/// As [`label_limbs`], with each limb's side as in [`limb_sides`]: near limbs lie in front of far ones where both
/// reach. Missing entries count as neither.
pub fn label_limbs_by_depth(mask: &Mask, strokes: &[Vec<Vec2>], sides: &[Option<Side>]) -> Grid<u16> {
    let (width, height) = (mask.width(), mask.height());
    let mut labels = Grid::new(width, height, 0u16);
    let mut depth = Grid::new(width, height, f32::INFINITY);
    let usable = |s: &&(usize, &Vec<Vec2>)| s.1.len() > 1 && s.1.iter().all(|p| p.is_finite());
    let numbered: Vec<(usize, &Vec<Vec2>)> = strokes.iter().enumerate().take(usize::from(u16::MAX)).collect();
    for &(limb, stroke) in numbered.iter().filter(usable) {
        let factor = match sides.get(limb).copied().flatten() {
            Some(Side::Near) => 1.0 / DEPTH_FACTOR,
            Some(Side::Far) => DEPTH_FACTOR,
            _ => 1.0,
        };
        let count = ((polyline::length(stroke) / STEP).ceil() as usize).clamp(1, MAX_STEPS) + 1;
        let dense = polyline::resample(stroke, count);
        for (place, tangent) in dense.iter().zip(polyline::tangents(&dense)) {
            let normal = tangent.perp();
            march(mask, *place, normal, factor, limb as u16 + 1, &mut labels, &mut depth);
            march(mask, *place, -normal, factor, limb as u16 + 1, &mut labels, &mut depth);
        }
    }
    spread(mask, &mut labels);
    adopt_islands(mask, &numbered, &mut labels);
    labels
}

/// The sides of a rig's limbs, in its order.
pub fn limb_sides(rig: &Rig) -> Vec<Option<Side>> {
    rig.limbs.iter().map(|l| l.side).collect()
}

/// Walks from `start` along the unit vector `direction` until the mask ends.
fn march(
    mask: &Mask,
    start: Vec2,
    direction: Vec2,
    factor: f32,
    label: u16,
    labels: &mut Grid<u16>,
    depth: &mut Grid<f32>,
) {
    for i in 0..MAX_STEPS {
        let distance = i as f32 * STEP;
        let at = start + direction * distance;
        let (x, y) = (at.x.floor() as isize, at.y.floor() as isize);
        if !mask.at(x, y) {
            return;
        }
        let (x, y) = (x as usize, y as usize);
        if distance * factor < depth.get(x, y) {
            depth.set(x, y, distance * factor);
            labels.set(x, y, label);
        }
    }
}

/// Grows labels inside the mask over its unlabelled pixels, nearest first.
fn spread(mask: &Mask, labels: &mut Grid<u16>) {
    let (width, height) = (mask.width() as isize, mask.height() as isize);
    let mut waiting: VecDeque<(isize, isize)> = VecDeque::new();
    for y in 0..height {
        for x in 0..width {
            if labels.get(x as usize, y as usize) != 0 {
                waiting.push_back((x, y));
            }
        }
    }
    while let Some((x, y)) = waiting.pop_front() {
        let label = labels.get(x as usize, y as usize);
        for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1)] {
            let (nx, ny) = (x + dx, y + dy);
            if mask.at(nx, ny) && labels.get(nx as usize, ny as usize) == 0 {
                labels.set(nx as usize, ny as usize, label);
                waiting.push_back((nx, ny));
            }
        }
    }
}

/// Gives pixels that are still without a label to the stroke with the nearest point.
fn adopt_islands(mask: &Mask, strokes: &[(usize, &Vec<Vec2>)], labels: &mut Grid<u16>) {
    for y in 0..mask.height() {
        for x in 0..mask.width() {
            if !mask.get(x, y) || labels.get(x, y) != 0 {
                continue;
            }
            let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let nearest = strokes
                .iter()
                .flat_map(|(limb, points)| points.iter().map(move |p| (p.distance_squared(centre), *limb)))
                .filter(|(d, _)| d.is_finite())
                .min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, limb)) = nearest {
                labels.set(x, y, limb as u16 + 1);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;
    use proptest::prelude::*;

    #[test]
    fn crossed_bars_are_parted_across_their_strokes() {
        let mask = Mask::from_fn(100, 100, |x, y| (40..60).contains(&y) || ((20..30).contains(&x) && y >= 40));
        let strokes = [vec![vec2(5.0, 50.0), vec2(95.0, 50.0)], vec![vec2(25.0, 60.0), vec2(25.0, 98.0)]];
        let labels = label_limbs(&mask, &strokes);
        assert_eq!(labels.get(80, 45), 1);
        assert_eq!(labels.get(22, 90), 2);
        assert_eq!(labels.get(99, 41), 1, "beyond the end of the stroke");
        assert_eq!(labels.get(80, 80), 0);
    }

    #[test]
    fn the_near_leg_shows_where_both_reach() {
        let mask = Mask::from_fn(60, 100, |x, _| (10..50).contains(&x));
        let strokes = [vec![vec2(20.0, 5.0), vec2(20.0, 95.0)], vec![vec2(40.0, 5.0), vec2(40.0, 95.0)]];
        let count = |sides: &[Option<Side>]| {
            label_limbs_by_depth(&mask, &strokes, sides).data().iter().filter(|&&l| l == 1).count()
        };
        assert!(count(&[Some(Side::Near), Some(Side::Far)]) > count(&[]) + 100);
        assert!(count(&[Some(Side::Far), Some(Side::Near)]) + 100 < count(&[]));
    }

    proptest! {
        #[test]
        fn labels_partition_the_mask(
            strokes in prop::collection::vec(prop::collection::vec((-30f32..90.0, -30f32..90.0), 2..5), 1..5),
            seed in 0usize..1000,
        ) {
            let mask = Mask::from_fn(61, 47, |x, y| (x * 31 + y * 17 + x * y * seed) % 11 < 8);
            let strokes: Vec<Vec<Vec2>> =
                strokes.into_iter().map(|s| s.into_iter().map(Vec2::from).collect()).collect();
            let labels = label_limbs(&mask, &strokes);
            for y in 0..47 {
                for x in 0..61 {
                    prop_assert_eq!(labels.get(x, y) != 0, mask.get(x, y));
                    prop_assert!(usize::from(labels.get(x, y)) <= strokes.len());
                }
            }
        }
    }

    #[test]
    fn no_usable_stroke_leaves_no_label() {
        let mask = Mask::from_fn(8, 8, |_, _| true);
        let strokes = [vec![], vec![Vec2::NAN, Vec2::NAN]];
        assert!(label_limbs(&mask, &strokes).data().iter().all(|&l| l == 0));
    }
}
