//! Bilateral filter by a bilateral grid.
//!
//! Paris and Durand 2006 ("A Fast Approximation of the Bilateral Filter"); Chen, Paris and Durand 2007: colours are
//! summed into coarse cells of place and brightness, the cells are blurred, and the picture is read back between them.
//! The cost does not depend on the filter's size. Closeness of colours is judged by brightness alone, so colours of
//! equal brightness mix across edges; that is the price of the grid having three dimensions instead of five.

use super::Grid;

/// Sums of red, green, blue and of weights in one cell.
type Cell = [f32; 4];

/// Filters `image` (sRGB bytes) with standard deviations of `space` pixels and `range` of brightness (0..=1).
pub(crate) fn bilateral(image: &Grid<[u8; 3]>, space: f32, range: f32) -> Grid<[u8; 3]> {
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 || space.is_nan() || range.is_nan() || space <= 0.0 || range <= 0.0 {
        return image.clone();
    }
    let (space, range) = (space.max(1.0), range.max(1.0 / 255.0));
    let across = ((width - 1) as f32 / space) as usize + 3;
    let down = ((height - 1) as f32 / space) as usize + 3;
    let deep = (1.0 / range) as usize + 3;
    let mut cells: Vec<Cell> = vec![[0.0; 4]; across * down * deep];
    let place = |x: usize, y: usize, colour: [u8; 3]| {
        [x as f32 / space + 0.5, y as f32 / space + 0.5, brightness(colour) / range + 0.5]
    };
    for y in 0..height {
        for (x, &colour) in image.row(y).iter().enumerate() {
            let at = place(x, y, colour).map(|v| v.round() as usize);
            let cell = &mut cells[(at[2] * down + at[1]) * across + at[0]];
            for (sum, value) in cell.iter_mut().zip(colour) {
                *sum += f32::from(value);
            }
            cell[3] += 1.0;
        }
    }
    for (step, count) in [(1, across), (across, down), (across * down, deep)] {
        cells = blurred(&cells, step, count);
    }
    let mut out = image.clone();
    for y in 0..height {
        for (x, value) in out.row_mut(y).iter_mut().enumerate() {
            let at = place(x, y, *value);
            let low = at.map(|v| v as usize);
            let part: [f32; 3] = std::array::from_fn(|i| at[i] - low[i] as f32);
            let mut sum: Cell = [0.0; 4];
            for corner in 0..8 {
                let up: [usize; 3] = std::array::from_fn(|i| corner >> i & 1);
                let weight: f32 = (0..3).map(|i| if up[i] == 1 { part[i] } else { 1.0 - part[i] }).product();
                let cell = &cells[((low[2] + up[2]) * down + low[1] + up[1]) * across + low[0] + up[0]];
                sum.iter_mut().zip(cell).for_each(|(s, c)| *s += weight * c);
            }
            if sum[3] > 1e-6 {
                *value = std::array::from_fn(|c| (sum[c] / sum[3] + 0.5) as u8);
            }
        }
    }
    out
}

fn brightness([r, g, b]: [u8; 3]) -> f32 {
    (0.299 * f32::from(r) + 0.587 * f32::from(g) + 0.114 * f32::from(b)) / 255.0
}

/// A blur of one cell's standard deviation along one axis: (1 4 6 4 1) / 16.
fn blurred(cells: &[Cell], step: usize, count: usize) -> Vec<Cell> {
    let mut out = vec![[0.0; 4]; cells.len()];
    for (i, target) in out.iter_mut().enumerate() {
        let at = i / step % count;
        for (offset, weight) in [(-2isize, 1.0), (-1, 4.0), (0, 6.0), (1, 4.0), (2, 1.0)] {
            if at.checked_add_signed(offset).is_some_and(|n| n < count) {
                let source = &cells[i.wrapping_add_signed(offset * step as isize)];
                target.iter_mut().zip(source).for_each(|(t, s)| *t += weight / 16.0 * s);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_goes_and_edges_stay() {
        let mut image = Grid::new(60, 40, [0u8; 3]);
        for y in 0..40 {
            for x in 0..60 {
                let noise = ((x * 7 + y * 13) % 5) as u8;
                image.set(x, y, if x < 30 { [60 + noise; 3] } else { [180 + noise; 3] });
            }
        }
        let smooth = bilateral(&image, 6.0, 0.04);
        for y in 0..40 {
            for x in 0..60 {
                let expected = if x < 30 { 62 } else { 182 };
                assert!(smooth.get(x, y)[0].abs_diff(expected) <= 1, "{x} {y}: {:?}", smooth.get(x, y));
            }
        }
    }
}
