//! Blurs of float grids: separable Gaussian, and box means in constant time a pixel.
//!
//! Both renormalise at the border, so that a constant image stays itself. Filters run along rows; the vertical pass
//! adds whole rows, which keeps memory traffic sequential.

use super::Grid;

/// Weights reach this many standard deviations.
const REACH: f32 = 3.0;

/// Gaussian blur with standard deviation `sigma` in pixels; none at or below 0.
pub(crate) fn gaussian(grid: &Grid<f32>, sigma: f32) -> Grid<f32> {
    if sigma.is_nan() || sigma <= 0.0 || grid.width() == 0 || grid.height() == 0 {
        return grid.clone();
    }
    let reach = (sigma * REACH).ceil() as usize;
    let weights: Vec<f32> = (0..=reach).map(|i| (-0.5 * (i as f32 / sigma).powi(2)).exp()).collect();
    let (width, height) = (grid.width(), grid.height());
    let mut rows = Grid::new(width, height, 0.0f32);
    for y in 0..height {
        let (source, target) = (grid.row(y), rows.row_mut(y));
        for (x, out) in target.iter_mut().enumerate() {
            let (from, to) = (x.saturating_sub(reach), (x + reach).min(width - 1));
            let (mut sum, mut total) = (0.0, 0.0);
            for (i, value) in source[from..=to].iter().enumerate() {
                let w = weights[(from + i).abs_diff(x)];
                sum += w * value;
                total += w;
            }
            *out = sum / total;
        }
    }
    let mut out = Grid::new(width, height, 0.0f32);
    for y in 0..height {
        let (from, to) = (y.saturating_sub(reach), (y + reach).min(height - 1));
        let total: f32 = (from..=to).map(|r| weights[r.abs_diff(y)]).sum();
        for r in from..=to {
            let w = weights[r.abs_diff(y)] / total;
            for (o, v) in out.row_mut(y).iter_mut().zip(rows.row(r)) {
                *o += w * v;
            }
        }
    }
    out
}

/// Mean over the square of side `2 * radius + 1` around each pixel, as far as it lies inside.
pub(crate) fn box_mean(grid: &Grid<f32>, radius: usize) -> Grid<f32> {
    let (width, height) = (grid.width(), grid.height());
    if width == 0 || height == 0 || radius == 0 {
        return grid.clone();
    }
    let mut rows = Grid::new(width, height, 0.0f32);
    for y in 0..height {
        let (source, target) = (grid.row(y), rows.row_mut(y));
        // Running sums in f64: additions and removals must cancel.
        let mut sum: f64 = source[..radius.min(width)].iter().map(|&v| f64::from(v)).sum();
        for x in 0..width {
            if x + radius < width {
                sum += f64::from(source[x + radius]);
            }
            if x > radius {
                sum -= f64::from(source[x - radius - 1]);
            }
            let count = (x + radius).min(width - 1) - x.saturating_sub(radius) + 1;
            target[x] = (sum / count as f64) as f32;
        }
    }
    let mut out = Grid::new(width, height, 0.0f32);
    let mut sums = vec![0.0f64; width];
    for y in 0..radius.min(height) {
        sums.iter_mut().zip(rows.row(y)).for_each(|(s, v)| *s += f64::from(*v));
    }
    for y in 0..height {
        if y + radius < height {
            sums.iter_mut().zip(rows.row(y + radius)).for_each(|(s, v)| *s += f64::from(*v));
        }
        if y > radius {
            sums.iter_mut().zip(rows.row(y - radius - 1)).for_each(|(s, v)| *s -= f64::from(*v));
        }
        let count = ((y + radius).min(height - 1) - y.saturating_sub(radius) + 1) as f64;
        out.row_mut(y).iter_mut().zip(&sums).for_each(|(o, s)| *o = (s / count) as f32);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_stay_and_mass_spreads_evenly() {
        let flat = Grid::new(19, 11, 0.25f32);
        for blurred in [gaussian(&flat, 2.0), box_mean(&flat, 3)] {
            assert!(blurred.data().iter().all(|v| (v - 0.25).abs() < 1e-5));
        }
        let mut dot = Grid::new(41, 41, 0.0f32);
        dot.set(20, 20, 1.0);
        let blurred = gaussian(&dot, 3.0);
        let variance: f32 = (0..41)
            .flat_map(|y| (0..41).map(move |x| (x, y)))
            .map(|(x, y)| blurred.get(x, y) * (x as f32 - 20.0).powi(2))
            .sum();
        assert!((variance - 9.0).abs() < 0.5, "{variance}");
    }

    #[test]
    fn box_mean_is_the_mean_of_the_box() {
        let grid = Grid::from_vec(7, 5, (0..35).map(|i| ((i * 13) % 17) as f32).collect());
        let mean = box_mean(&grid, 2);
        for y in 0..5usize {
            for x in 0..7usize {
                let ys = y.saturating_sub(2)..=(y + 2).min(4);
                let values: Vec<f32> = ys
                    .flat_map(|v| (x.saturating_sub(2)..=(x + 2).min(6)).map(move |u| (u, v)))
                    .map(|(u, v)| grid.get(u, v))
                    .collect();
                let expected = values.iter().sum::<f32>() / values.len() as f32;
                assert!((mean.get(x, y) - expected).abs() < 1e-4);
            }
        }
    }
}
