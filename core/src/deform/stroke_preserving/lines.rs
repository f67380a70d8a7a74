//! What keeps a line's shape: its pieces keep their lengths, and turn with one another.
//!
//! A line is a band of stiffer stuff in the mesh, which moves with the mesh and never leaves it. Along it lie nodes at one
//! spacing. Of each piece between two of them `(|e| - l)^2` counts, and of each two that follow one another
//! `|e2 r1 - e1 r2|^2`, with r the pieces at rest, which vanishes for any similarity. Both are weighed such that the
//! spacing does not matter: together, `STRETCH` times the squared strain and `STRETCH BEND^2` times the squared change of
//! the curvature, along the line's length, in mean edges of its mesh. Straight lines need no other treatment.

use glam::DVec2;

use super::terms::{OfLine, Sum};

/// How stiff a line of rigidity 1 is: so many times the mesh in a band one mean edge wide. A figure's outline and the
/// circles on it then keep the lengths of their pieces to 1.3 % in a bend and 4.3 % in a stretch by a third.
const STRETCH: f64 = 60.0;
/// Half the width, about, of a band that resists bending as a line does.
const BEND: f64 = 0.7;
/// Spacing of the nodes: where a piece crosses several triangles, one is stretched and the next pressed together.
const SPACING: f64 = 0.25;
/// Of how many pieces the ways are whose turns are compared: those within a triangle do not turn.
const STRIDE: usize = 4;
/// A line has at least so many pieces, so that small ones are round.
const PIECES: usize = 8;
/// A line shorter than so many edges counts as if it were so long: it lies in few triangles, and those must not bend it.
const SHORT: f64 = 4.0;
/// A line shorter than this has no shape that anyone sees.
const SPECK: f64 = 0.05;
/// Pieces at most; a longer line has longer ones.
const MANY: usize = 1 << 16;

/// The nodes along a line, and how far apart they are. `None` for a line without length.
pub(super) fn nodes(points: &[DVec2], closed: bool) -> Option<(Vec<DVec2>, f64)> {
    let first = *points.first()?;
    let mut corners = points.to_vec();
    if closed {
        corners.push(first);
    }
    corners.dedup();
    let length: f64 = corners.windows(2).map(|w| w[0].distance(w[1])).sum();
    if length.is_nan() || length < SPECK {
        return None;
    }
    let count = ((length / SPACING).ceil() as usize).clamp(PIECES, MANY);
    let step = length / count as f64;
    let mut nodes = Vec::with_capacity(count + 1);
    let (mut passed, mut k) = (0.0, 0);
    for i in 0..count {
        let at = i as f64 * step;
        while k + 2 < corners.len() && passed + corners[k].distance(corners[k + 1]) <= at {
            passed += corners[k].distance(corners[k + 1]);
            k += 1;
        }
        let part = (at - passed) / corners[k].distance(corners[k + 1]);
        nodes.push(corners[k].lerp(corners[k + 1], part.clamp(0.0, 1.0)));
    }
    if !closed {
        nodes.push(corners[corners.len() - 1]);
    }
    Some((nodes, step))
}

/// The terms of the line number `line` with the nodes `at`, which are the sums `places`.
pub(super) fn terms(
    line: u32,
    (at, step): (&[DVec2], f64),
    closed: bool,
    places: &[Sum],
    stretches: &mut Vec<OfLine>,
    bends: &mut Vec<OfLine>,
) {
    let n = at.len();
    let piece = |i: usize, stride: usize| {
        let (from, to) = (i % n, (i + stride) % n);
        let mut sum = places[to].clone();
        sum.add(&places[from], -DVec2::X);
        (at[to] - at[from], sum)
    };
    let count = if closed { n } else { n - 1 };
    let weight = STRETCH * (SHORT / (count as f64 * step)).max(1.0);
    let first = stretches.len();
    for i in 0..count {
        let (rest, sum) = piece(i, 1);
        let piece = (first + i) as u32;
        stretches.push(OfLine { line, weight: weight / step, length: rest.length(), piece, sum });
    }
    let wide = STRIDE as f64 * step;
    for i in 0..if closed { n } else { n.saturating_sub(2 * STRIDE) } {
        let ((rest, way), (next_rest, next)) = (piece(i, STRIDE), piece(i + STRIDE, STRIDE));
        let mut sum = Sum::default();
        sum.add(&next, rest / wide);
        sum.add(&way, -next_rest / wide);
        let piece = (first + (i + STRIDE) % count) as u32;
        bends.push(OfLine { line, weight: weight * BEND * BEND * step / wide.powi(4), length: 0.0, piece, sum });
    }
}
