//! Active contours (Kass, Witkin and Terzopoulos 1988): a closed curve that shrinks until it lies on the ink.
//!
//! Membrane and thin plate by the semi-implicit step (A + gamma I) v' = gamma v + force. On a closed curve of even points
//! A is circulant, so its inverse is one row, by its eigenvalues. The force is a step of one pixel down the distance to the
//! ink, the blurred distance transform, and fades out over the last pixel. The curve is sampled evenly again after every
//! step, or its points would run together where it is pulled. It shrinks from outside only, and bridges bays narrower
//! than the pull reaches into.

use std::f64::consts::TAU;

use glam::Vec2;

use crate::error::Result;
use crate::geometry::polygon;
use crate::job::Stage;
use crate::raster::Grid;
use crate::raster::sample;

/// How much the curve resists being stretched and bent, against a pull of one pixel a step.
const STRETCH: f64 = 0.1;
const BEND: f64 = 0.3;
const STEPS: usize = 400;
/// It rests once no point moves farther in a step, in pixels.
const REST: f32 = 0.02;
const MAX_POINTS: usize = 512;

/// Shrinks the closed polygon `start` onto the ink. `distance` has each pixel's distance to the nearest ink, smoothed;
/// places and lengths are in its pixels.
///
/// # Errors
/// Cancelled.
pub(crate) fn shrink_wrap(start: &[Vec2], distance: &Grid<f32>, stage: &Stage<'_>) -> Result<Vec<Vec2>> {
    let spaced = polygon::resample(start, |_| 3.0);
    let count = spaced.len().clamp(16, MAX_POINTS);
    let mut curve = evenly(&spaced, count);
    let row = inverse_row(count);
    for step in 0..STEPS {
        stage.at(step as f64 / STEPS as f64)?;
        let pulled: Vec<Vec2> = curve.iter().map(|&p| p + pull(distance, p)).collect();
        let next: Vec<Vec2> = (0..count)
            .map(|i| {
                let terms = row.iter().map(|&(k, w)| pulled[(i + k) % count].as_dvec2() * w);
                terms.sum::<glam::DVec2>().as_vec2()
            })
            .collect();
        let moved = curve.iter().zip(&next).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        curve = evenly(&next, count);
        if moved < REST {
            break;
        }
    }
    Ok(curve)
}

/// One pixel down the slope, less within a pixel of the ink.
fn pull(distance: &Grid<f32>, p: Vec2) -> Vec2 {
    let at = |x: f32, y: f32| sample::bilinear(distance, p + Vec2::new(x, y));
    let slope = Vec2::new(at(1.0, 0.0) - at(-1.0, 0.0), at(0.0, 1.0) - at(0.0, -1.0));
    -slope.normalize_or_zero() * at(0.0, 0.0).clamp(0.0, 1.0)
}

/// The first row of (A + I)^-1 for `count` points: column and value where it is not next to nothing.
fn inverse_row(count: usize) -> Vec<(usize, f64)> {
    let angle = |k: usize| TAU * k as f64 / count as f64;
    let values: Vec<f64> = (0..count)
        .map(|k| {
            let second = 2.0 - 2.0 * angle(k).cos();
            1.0 / (1.0 + STRETCH * second + BEND * second * second)
        })
        .collect();
    let entry =
        |j: usize| values.iter().enumerate().map(|(k, v)| v * angle(j * k % count).cos()).sum::<f64>() / count as f64;
    (0..count).map(|j| (j, entry(j))).filter(|(_, w)| w.abs() > 1e-9).collect()
}

/// Exactly `count` points along the closed polygon.
fn evenly(closed: &[Vec2], count: usize) -> Vec<Vec2> {
    let mut way = closed.to_vec();
    way.extend(closed.first());
    let mut points = crate::geometry::polyline::resample(&way, count + 1);
    points.pop();
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Progress;

    #[test]
    fn a_ring_around_a_disc_closes_on_it() {
        let disc = Grid::from_vec(
            160,
            160,
            (0..160 * 160)
                .map(|i| {
                    let p = Vec2::new((i % 160) as f32 + 0.5, (i / 160) as f32 + 0.5);
                    (p.distance(Vec2::splat(80.0)) - 30.0).max(0.0)
                })
                .collect(),
        );
        let ring: Vec<Vec2> = (0..100)
            .map(|i| Vec2::splat(80.0) + 70.0 * Vec2::from_angle(i as f32 / 100.0 * std::f32::consts::TAU))
            .collect();
        let curve = shrink_wrap(&ring, &disc, &Progress::new().whole()).expect("not cancelled");
        for p in curve {
            let r = p.distance(Vec2::splat(80.0));
            assert!((28.0..32.0).contains(&r), "a point at {r}");
        }
    }
}
