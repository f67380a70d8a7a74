//! Nearest-site transform: for every pixel the site closest to it, exactly, in linear time.
//!
//! Lower envelope of parabolas, columns first, then rows (Felzenszwalb and Huttenlocher 2012, "Distance Transforms of
//! Sampled Functions"), carrying which site a distance belongs to. Distances are between pixel centres.

use super::{Grid, Mask};

/// No site.
pub(crate) const NO_SITE: u32 = u32::MAX;
/// Larger than any squared distance in an image, small enough to add without loss.
const FAR: f64 = 1e12;

/// How far every pixel of `mask` is from the nearest one that is `inside` or not; infinite where there is none.
pub(crate) fn distance_to(mask: &Mask, inside: bool) -> Grid<f32> {
    let (width, height) = (mask.width(), mask.height());
    let site = |i: usize| if mask.get(i % width, i / width) == inside { i as u32 } else { NO_SITE };
    let near = nearest_site(&Grid::from_vec(width, height, (0..width * height).map(site).collect()));
    let away = |i: usize| match near.data()[i] {
        NO_SITE => f32::INFINITY,
        site => {
            let site = site as usize;
            let (dx, dy) = ((site % width).abs_diff(i % width), (site / width).abs_diff(i / width));
            ((dx * dx + dy * dy) as f32).sqrt()
        }
    };
    Grid::from_vec(width, height, (0..width * height).map(away).collect())
}

/// For every pixel of `sites` the value of the nearest pixel that is not [`NO_SITE`]; [`NO_SITE`] everywhere when
/// there is none. Equal distances go to the lower row, then to the left column.
pub(crate) fn nearest_site(sites: &Grid<u32>) -> Grid<u32> {
    let (width, height) = (sites.width(), sites.height());
    // Columns: the nearest site above or below, by two sweeps; 1D distances need no envelope.
    let mut column_row = Grid::new(width, height, NO_SITE);
    for y in 0..height {
        for x in 0..width {
            if sites.get(x, y) != NO_SITE {
                column_row.set(x, y, y as u32);
            } else if y > 0 {
                column_row.set(x, y, column_row.get(x, y - 1));
            }
        }
    }
    for y in (0..height.saturating_sub(1)).rev() {
        for x in 0..width {
            let below = column_row.get(x, y + 1);
            let own = column_row.get(x, y);
            let gap = |row: u32| (i64::from(row) - y as i64).abs();
            if below != NO_SITE && (own == NO_SITE || gap(below) < gap(own)) {
                column_row.set(x, y, below);
            }
        }
    }
    let mut out = Grid::new(width, height, NO_SITE);
    let mut hull: Vec<usize> = Vec::with_capacity(width);
    let mut from: Vec<f64> = Vec::with_capacity(width);
    for y in 0..height {
        let height_of = |x: usize| match column_row.get(x, y) {
            NO_SITE => FAR,
            row => (f64::from(row) - y as f64).powi(2),
        };
        hull.clear();
        from.clear();
        for x in 0..width {
            let h = height_of(x);
            if h >= FAR {
                continue;
            }
            loop {
                let Some(&last) = hull.last() else {
                    hull.push(x);
                    from.push(f64::NEG_INFINITY);
                    break;
                };
                let meet = ((h + (x * x) as f64) - (height_of(last) + (last * last) as f64)) / (2 * (x - last)) as f64;
                if from.last().is_some_and(|f| meet <= *f) {
                    hull.pop();
                    from.pop();
                } else {
                    hull.push(x);
                    from.push(meet);
                    break;
                }
            }
        }
        if hull.is_empty() {
            continue;
        }
        let mut k = 0;
        for x in 0..width {
            while k + 1 < hull.len() && from[k + 1] < x as f64 {
                k += 1;
            }
            let column = hull[k];
            out.set(x, y, sites.get(column, column_row.get(column, y) as usize));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_exhaustive_search(places in prop::collection::vec((0usize..23, 0usize..17), 0..12)) {
            let mut sites = Grid::new(23, 17, NO_SITE);
            for (x, y) in &places {
                sites.set(*x, *y, (y * 23 + x) as u32);
            }
            let found = nearest_site(&sites);
            let squared = |x: usize, y: usize, site: u32| {
                let (sx, sy) = (site as usize % 23, site as usize / 23);
                sx.abs_diff(x).pow(2) + sy.abs_diff(y).pow(2)
            };
            for y in 0..17 {
                for x in 0..23 {
                    let best = places.iter().map(|(sx, sy)| sx.abs_diff(x).pow(2) + sy.abs_diff(y).pow(2)).min();
                    match best {
                        None => prop_assert_eq!(found.get(x, y), NO_SITE),
                        Some(best) => prop_assert_eq!(squared(x, y, found.get(x, y)), best),
                    }
                }
            }
        }
    }
}
