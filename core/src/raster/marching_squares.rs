//! Outlines of a field where it crosses a level, between the pixels.
//!
//! Marching squares with linear interpolation; a saddle is decided by the mean of its four values. Values lie at pixel
//! centres, and outside the grid everything is below, so that every outline is closed.

use glam::{Vec2, vec2};

use super::Grid;

/// The closed outlines of where `field` is above `level`, without their first point again at the end. What is above
/// lies to the right of the way (as seen with y down: outer outlines turn from x to y, holes the other way). In reading
/// order of their first squares.
pub(crate) fn outlines(field: &Grid<f32>, level: f32) -> Vec<Vec<Vec2>> {
    let (width, height) = (field.width() as isize, field.height() as isize);
    let value = |x: isize, y: isize| {
        let inside = x >= 0 && y >= 0 && x < width && y < height;
        if inside { field.get(x as usize, y as usize) } else { f32::NEG_INFINITY }
    };
    let above = |x: isize, y: isize| value(x, y) > level;
    // Square (x, y) lies between the centres of pixels (x, y) and (x + 1, y + 1), from -1 on. Its sides: top, right,
    // bottom, left.
    let columns = (width + 1) as usize;
    let at = |x: isize, y: isize| (y + 1) as usize * columns + (x + 1) as usize;
    let mut open = vec![[false; 4]; columns * (height + 1) as usize];
    // Which side the way leaves by when it enters by another; `None` where it does not enter there.
    let leave = |x: isize, y: isize, enter: usize| {
        let corners = [above(x, y), above(x + 1, y), above(x + 1, y + 1), above(x, y + 1)];
        // Side i lies between corners i and i + 1, clockwise. With what is above on the right, the way enters by a side
        // whose first corner is above, and leaves by one whose second is.
        let enters = |i: usize| corners[i] && !corners[(i + 1) % 4];
        let leaves = |i: usize| !corners[i] && corners[(i + 1) % 4];
        if !enters(enter) {
            return None;
        }
        let mean =
            [(0, 0), (1, 0), (1, 1), (0, 1)].iter().map(|&(i, j)| value(x + i, y + j).max(-1e9)).sum::<f32>() / 4.0;
        // At a saddle: around the corner that is above beside the way in when the middle is below, else past it.
        let turns: [usize; 3] = if mean > level { [1, 2, 3] } else { [3, 2, 1] };
        turns.into_iter().map(|k| (enter + k) % 4).find(|&side| leaves(side))
    };
    for y in -1..height {
        for x in -1..width {
            for side in 0..4 {
                open[at(x, y)][side] = leave(x, y, side).is_some();
            }
        }
    }
    let crossing = |x: isize, y: isize, side: usize| {
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
        let ((ax, ay), (bx, by)) = (corners[side], corners[(side + 1) % 4]);
        let (a, b) = (value(ax, ay), value(bx, by));
        // Beyond the rim lies the same distance below the level as the pixel lies above it, half a pixel out.
        let share = if a.is_finite() && b.is_finite() { ((level - a) / (b - a)).clamp(0.0, 1.0) } else { 0.5 };
        vec2(ax as f32 + 0.5, ay as f32 + 0.5).lerp(vec2(bx as f32 + 0.5, by as f32 + 0.5), share)
    };
    let mut outlines = Vec::new();
    for y in -1..height {
        for x in -1..width {
            for side in 0..4 {
                if !open[at(x, y)][side] {
                    continue;
                }
                let (mut sx, mut sy, mut enter) = (x, y, side);
                let mut outline: Vec<Vec2> = Vec::new();
                while open[at(sx, sy)][enter] {
                    open[at(sx, sy)][enter] = false;
                    let Some(out) = leave(sx, sy, enter) else { break };
                    let point = crossing(sx, sy, out);
                    if outline.last().is_none_or(|last| last.distance_squared(point) > 1e-10) {
                        outline.push(point);
                    }
                    let (dx, dy) = [(0, -1), (1, 0), (0, 1), (-1, 0)][out];
                    (sx, sy, enter) = (sx + dx, sy + dy, (out + 2) % 4);
                }
                if outline.len() > 1 && outline[0].distance_squared(outline[outline.len() - 1]) <= 1e-10 {
                    outline.pop();
                }
                if outline.len() >= 3 {
                    outlines.push(outline);
                }
            }
        }
    }
    outlines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::polygon::signed_area;
    use proptest::prelude::*;

    fn area(outline: &[Vec2]) -> f64 {
        signed_area(outline)
    }

    #[test]
    fn a_disc_is_found_between_the_pixels() {
        let field = Grid::from_vec(
            40,
            40,
            (0..1600)
                .map(|i| {
                    let p = vec2((i % 40) as f32 + 0.5, (i / 40) as f32 + 0.5);
                    (12.3 - p.distance(vec2(20.2, 19.7))).clamp(-2.0, 2.0)
                })
                .collect(),
        );
        let found = outlines(&field, 0.0);
        assert_eq!(found.len(), 1);
        assert!(found[0].iter().all(|p| (p.distance(vec2(20.2, 19.7)) - 12.3).abs() < 0.05));
        assert!((area(&found[0]) - std::f64::consts::PI * 12.3 * 12.3).abs() < 1.0);
    }

    #[test]
    fn a_hole_turns_the_other_way_and_the_rim_closes() {
        let field = Grid::from_vec(
            9,
            9,
            (0..81).map(|i| if (3..6).contains(&(i % 9)) && (3..6).contains(&(i / 9)) { 0.0 } else { 1.0 }).collect(),
        );
        let found = outlines(&field, 0.5);
        assert_eq!(found.len(), 2);
        assert!(area(&found[0]) > 79.0 && area(&found[1]) < -7.0);
        assert!(outlines(&Grid::new(0, 0, 1.0), 0.5).is_empty());
        assert!(outlines(&Grid::new(5, 4, 0.0), 0.5).is_empty());
    }

    proptest! {
        #[test]
        fn outlines_hold_the_area_of_any_bits(bits in prop::collection::vec(any::<bool>(), 63)) {
            let field = Grid::from_vec(9, 7, bits.iter().map(|b| f32::from(u8::from(*b))).collect());
            let total: f64 = outlines(&field, 0.5).iter().map(|o| area(o)).sum();
            let count = bits.iter().filter(|b| **b).count() as f64;
            // Corners are cut, outer ones off what is in and inner ones off what is out: at most half of either.
            let (least, most) = (0.5 * count - 1e-3, count + 0.5 * (63.0 - count) + 1e-3);
            prop_assert!((least..=most).contains(&total), "{} of {}", total, count);
        }
    }
}
