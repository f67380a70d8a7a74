//! How wide a limb is around its stroke on a drawn frame, from colours alone.
//!
//! From every stroke vertex two colour profiles run outward along the stroke's normal. A limb ends where the colours
//! before a place differ most from those just behind it; the median over neighbouring vertices and both sides removes
//! folds, shadows and spots. Where nothing differs the limb counts as wide as the search reaches. This only weighs pixels
//! of matching patches; it is not a segmentation.

use glam::Vec2;

use crate::geometry::polyline;
use crate::raster::Planes;

/// Profiles are means over so many pixels along the stroke, either way.
const ALONG: i32 = 2;
/// How deep the band behind a place is that must look different, in pixels.
const BAND: usize = 4;
/// Neighbouring vertices, either way, that share a median.
const NEIGHBOURS: usize = 2;

/// The half width in pixels at every point of a stroke drawn on `image`, at least 2 and at most `reach`.
pub(crate) fn half_widths(image: &Planes, stroke: &[Vec2], reach: f32) -> Vec<f32> {
    let steps = (reach.max(2.0) as usize).max(2);
    let tangents = polyline::tangents(stroke);
    let edges: Vec<[f32; 2]> = stroke
        .iter()
        .zip(&tangents)
        .map(|(&at, tangent)| [1.0, -1.0].map(|side| edge(&profile(image, at, *tangent, side, steps + BAND)) as f32))
        .collect();
    (0..stroke.len())
        .map(|i| {
            let around = &edges[i.saturating_sub(NEIGHBOURS)..(i + NEIGHBOURS + 1).min(edges.len())];
            let mut both: Vec<f32> = around.iter().flatten().copied().collect();
            both.sort_by(f32::total_cmp);
            both[both.len() / 2].clamp(2.0, reach.max(2.0))
        })
        .collect()
}

/// Colours from the stroke outward, one a pixel.
fn profile(image: &Planes, at: Vec2, tangent: Vec2, side: f32, length: usize) -> Vec<[f32; 3]> {
    let normal = tangent.perp() * side;
    (0..length)
        .map(|r| {
            let mut mean = [0.0; 3];
            for along in -ALONG..=ALONG {
                let colour = image.at(at + normal * r as f32 + tangent * along as f32);
                for c in 0..3 {
                    mean[c] += colour[c] / (2 * ALONG + 1) as f32;
                }
            }
            mean
        })
        .collect()
}

/// The place in a profile where what lies before and the band behind differ most; the last place when they do not.
fn edge(profile: &[[f32; 3]]) -> usize {
    let mut inside = [0.0f32; 3];
    let mut best = (1e-3, profile.len().saturating_sub(BAND));
    for place in 1..=profile.len().saturating_sub(BAND) {
        let mut difference = 0.0;
        for c in 0..3 {
            inside[c] += profile[place - 1][c];
            let behind = profile[place..place + BAND].iter().map(|p| p[c]).sum::<f32>() / BAND as f32;
            difference += (inside[c] / place as f32 - behind).powi(2);
        }
        if place >= 2 && difference > best.0 {
            best = (difference, place);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn a_bar_is_as_wide_as_it_is_drawn() {
        let image = image::RgbImage::from_fn(120, 60, |x, y| {
            let speckle = ((x * 31 + y * 17) % 13) as u8;
            let inside = (f32::from(y as u16) + 0.5 - 30.0).abs() < 9.0;
            image::Rgb(if inside { [150 + speckle, 90, 40] } else { [60, 120 + speckle, 70] })
        });
        let stroke: Vec<Vec2> = (1..11).map(|i| vec2(i as f32 * 10.0, 30.0)).collect();
        for width in half_widths(&Planes::lab(&image), &stroke, 25.0) {
            assert!((width - 9.0).abs() <= 1.5, "{width}");
        }
        let flat = Planes::lab(&image::RgbImage::from_pixel(120, 60, image::Rgb([90, 90, 90])));
        assert!(half_widths(&flat, &stroke, 25.0).iter().all(|w| *w == 25.0));
    }
}
