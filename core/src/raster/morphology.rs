//! Connected parts and holes of masks.

use super::{Grid, Mask};

/// The connected parts of a mask (eight neighbours), in reading order of their first pixels.
pub(crate) struct Parts {
    /// 0 outside, part number + 1 inside.
    pub(crate) labels: Grid<u32>,
    /// Pixels of each part.
    pub(crate) areas: Vec<usize>,
}

/// Finds the connected parts of `mask`.
pub(crate) fn parts(mask: &Mask) -> Parts {
    let every = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1)];
    flood(mask.width(), mask.height(), |x, y| mask.get(x, y), &every)
}

/// The largest part of `mask`; `None` of nothing.
pub(crate) fn largest_part(mask: &Mask) -> Option<Mask> {
    let parts = parts(mask);
    let largest = (0..parts.areas.len()).max_by_key(|&part| parts.areas[part])?;
    Some(Mask::from_fn(mask.width(), mask.height(), |x, y| parts.labels.get(x, y) as usize == largest + 1))
}

/// The mask without its holes of at most `largest` pixels. A hole is background that does not reach the border
/// through four neighbours.
pub(crate) fn without_holes(mask: &Mask, largest: usize) -> Mask {
    let (width, height) = (mask.width(), mask.height());
    let outside = flood(width, height, |x, y| !mask.get(x, y), &[(1, 0), (-1, 0), (0, 1), (0, -1)]);
    let mut open = vec![false; outside.areas.len() + 1];
    for y in 0..height {
        for x in 0..width {
            if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
                open[outside.labels.get(x, y) as usize] = true;
            }
        }
    }
    Mask::from_fn(width, height, |x, y| {
        let part = outside.labels.get(x, y) as usize;
        part == 0 || (!open[part] && outside.areas[part - 1] <= largest)
    })
}

fn flood(width: usize, height: usize, inside: impl Fn(usize, usize) -> bool, steps: &[(isize, isize)]) -> Parts {
    let mut labels = Grid::new(width, height, 0u32);
    let mut areas = Vec::new();
    let mut waiting = Vec::new();
    for y in 0..height {
        for x in 0..width {
            if labels.get(x, y) != 0 || !inside(x, y) {
                continue;
            }
            let label = areas.len() as u32 + 1;
            labels.set(x, y, label);
            waiting.push((x, y));
            let mut area = 0;
            while let Some((x, y)) = waiting.pop() {
                area += 1;
                for (dx, dy) in steps {
                    let (nx, ny) = (x.wrapping_add_signed(*dx), y.wrapping_add_signed(*dy));
                    if nx < width && ny < height && labels.get(nx, ny) == 0 && inside(nx, ny) {
                        labels.set(nx, ny, label);
                        waiting.push((nx, ny));
                    }
                }
            }
            areas.push(area);
        }
    }
    Parts { labels, areas }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_holes_close_and_large_ones_and_bays_stay() {
        let solid = |x: usize, y: usize| (2..38).contains(&x) && (2..28).contains(&y);
        let small = |x: usize, y: usize| (5..7).contains(&x) && (5..7).contains(&y);
        let large = |x: usize, y: usize| (15..25).contains(&x) && (10..20).contains(&y);
        let bay = |x: usize, y: usize| (30..32).contains(&x) && y > 25;
        let mask = Mask::from_fn(40, 30, |x, y| solid(x, y) && !small(x, y) && !large(x, y) && !bay(x, y));
        let filled = without_holes(&mask, 20);
        assert_eq!(filled, Mask::from_fn(40, 30, |x, y| solid(x, y) && !large(x, y) && !bay(x, y)));
    }

    #[test]
    fn parts_touching_at_a_corner_are_one() {
        let mask = Mask::from_fn(12, 4, |x, y| (x < 2 && y < 2) || (x == 2 && y == 2) || x > 8);
        assert_eq!(parts(&mask).areas, vec![5, 12]);
    }
}
