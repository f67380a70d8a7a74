//! Guided filter: smooths a map so that its edges follow those of a colour image.
//!
//! He, Sun and Tang 2013, "Guided Image Filtering": in every window the map is a linear function of the image's
//! colours, found by least squares; windows are averaged. Constant time a pixel, whatever the radius.

use super::Grid;
use super::gaussian::box_mean;

/// Filters `map` along `guide` (three channels, 0..=1, of the map's size). `radius` is half the window's side in
/// pixels, `smoothness` the variance of colour below which a window counts as flat.
pub(crate) fn guided_filter(guide: &[Grid<f32>; 3], map: &Grid<f32>, radius: usize, smoothness: f32) -> Grid<f32> {
    let (width, height) = (map.width(), map.height());
    let product = |a: &Grid<f32>, b: &Grid<f32>| {
        Grid::from_vec(width, height, a.data().iter().zip(b.data()).map(|(x, y)| x * y).collect())
    };
    let mean = |grid: &Grid<f32>| box_mean(grid, radius);
    let colour: [Grid<f32>; 3] = std::array::from_fn(|c| mean(&guide[c]));
    let average = mean(map);
    let with_map: [Grid<f32>; 3] = std::array::from_fn(|c| mean(&product(&guide[c], map)));
    let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    let square: [Grid<f32>; 6] = pairs.map(|(a, b)| mean(&product(&guide[a], &guide[b])));

    let mut slope: [Grid<f32>; 3] = std::array::from_fn(|_| Grid::new(width, height, 0.0));
    let mut offset = Grid::new(width, height, 0.0f32);
    for i in 0..width * height {
        let m: [f32; 3] = std::array::from_fn(|c| colour[c].data()[i]);
        let p = average.data()[i];
        let cov: [f32; 3] = std::array::from_fn(|c| with_map[c].data()[i] - m[c] * p);
        let s: [f32; 6] = std::array::from_fn(|k| square[k].data()[i] - m[pairs[k].0] * m[pairs[k].1]);
        let a = solve(s, smoothness, cov);
        for c in 0..3 {
            slope[c].data_mut()[i] = a[c];
        }
        offset.data_mut()[i] = p - a[0] * m[0] - a[1] * m[1] - a[2] * m[2];
    }
    let slope: [Grid<f32>; 3] = std::array::from_fn(|c| mean(&slope[c]));
    let mut out = mean(&offset);
    for (i, value) in out.data_mut().iter_mut().enumerate() {
        *value += (0..3).map(|c| slope[c].data()[i] * guide[c].data()[i]).sum::<f32>();
    }
    out
}

/// Solves the symmetric system with upper half `s` plus `ridge` on the diagonal, by cofactors.
fn solve(s: [f32; 6], ridge: f32, v: [f32; 3]) -> [f32; 3] {
    let (a, b, c, d, e, f) = (s[0] + ridge, s[1], s[2], s[3] + ridge, s[4], s[5] + ridge);
    let (ca, cb, cc) = (d * f - e * e, c * e - b * f, b * e - c * d);
    let determinant = a * ca + b * cb + c * cc;
    if determinant.abs() < 1e-20 {
        return [0.0; 3];
    }
    let (cd, ce, cf) = (a * f - c * c, b * c - a * e, a * d - b * b);
    [
        (ca * v[0] + cb * v[1] + cc * v[2]) / determinant,
        (cb * v[0] + cd * v[1] + ce * v[2]) / determinant,
        (cc * v[0] + ce * v[1] + cf * v[2]) / determinant,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shifted_edge_snaps_to_the_image() {
        let (w, h) = (40, 30);
        let edge = |at: usize| Grid::from_vec(w, h, (0..w * h).map(|i| f32::from(u8::from(i % w >= at))).collect());
        let guide = [edge(20), Grid::new(w, h, 0.3), edge(20)];
        let filtered = guided_filter(&guide, &edge(22), 5, 1e-4);
        for y in 0..h {
            assert!(filtered.get(19, y) < 0.5 && filtered.get(20, y) > 0.5, "row {y}");
        }
        let flat = [Grid::new(w, h, 0.5), Grid::new(w, h, 0.5), Grid::new(w, h, 0.5)];
        let blurred = guided_filter(&flat, &edge(22), 2, 1e-4);
        assert!(blurred.get(10, 10).abs() < 1e-4 && (blurred.get(35, 10) - 1.0).abs() < 1e-4);
    }
}
