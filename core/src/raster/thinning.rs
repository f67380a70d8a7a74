//! The middle line of a mask, one pixel wide.
//!
//! Zhang and Suen 1984, "A Fast Parallel Algorithm for Thinning Digital Patterns": rim pixels whose removal neither
//! parts what is left nor shortens an end go, by turns from the lower right and the upper left. What they leave two
//! pixels wide on diagonals goes last. A part never vanishes.

use super::Mask;

/// Neighbours clockwise from the one above.
const AROUND: [(isize, isize); 8] = [(0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1)];

/// The middle line of `mask`. `on_round` is called before each pass and may stop the work.
pub(crate) fn thin<E>(mask: &Mask, mut on_round: impl FnMut() -> Result<(), E>) -> Result<Mask, E> {
    let mut out = mask.clone();
    let neighbours = |m: &Mask, x: usize, y: usize| AROUND.map(|(dx, dy)| m.at(x as isize + dx, y as isize + dy));
    let mut inside: Vec<(usize, usize)> = (0..mask.height())
        .flat_map(|y| (0..mask.width()).map(move |x| (x, y)))
        .filter(|&(x, y)| mask.get(x, y))
        .collect();
    loop {
        on_round()?;
        let mut changed = false;
        for pass in 0..2 {
            let goes: Vec<(usize, usize)> = inside
                .iter()
                .copied()
                .filter(|&(x, y)| {
                    let n = neighbours(&out, x, y);
                    let count = n.iter().filter(|b| **b).count();
                    let rises = (0..8).filter(|&i| !n[i] && n[(i + 1) % 8]).count();
                    let [up, right, down, left] = [n[0], n[2], n[4], n[6]];
                    let sides =
                        if pass == 0 { !(right && down && (up || left)) } else { !(up && left && (right || down)) };
                    (2..=6).contains(&count) && rises == 1 && sides
                })
                .collect();
            // A two by two block fulfils every rule and would go as a whole.
            for (x, y) in goes {
                let n = neighbours(&out, x, y);
                if n.iter().any(|b| *b) {
                    out.set(x, y, false);
                    changed = true;
                }
            }
            inside.retain(|&(x, y)| out.get(x, y));
        }
        if !changed {
            break;
        }
    }
    for &(x, y) in &inside {
        let n = neighbours(&out, x, y);
        // A corner of a staircase: its two sides touch across it, and nothing else hangs from it.
        let corner = [(0, 2), (2, 4), (4, 6), (6, 0)].into_iter().any(|(a, b)| {
            let opposite = [3, 4, 5, 6, 7, 0, 1, 2][(a + 2) % 8];
            n[a] && n[b] && !n[opposite] && !n[(a + 4) % 8] && !n[(b + 4) % 8]
        });
        let rises = (0..8).filter(|&i| !n[i] && n[(i + 1) % 8]).count();
        if corner && rises <= 2 && n.iter().filter(|b| **b).count() >= 2 && keeps_together(&n) {
            out.set(x, y, false);
        }
    }
    Ok(out)
}

/// Whether the neighbours hang together without the pixel between them.
fn keeps_together(n: &[bool; 8]) -> bool {
    let mut group = [usize::MAX; 8];
    let mut groups = 0;
    for i in 0..8 {
        if n[i] && group[i] == usize::MAX {
            groups += 1;
            let mut waiting = vec![i];
            while let Some(j) = waiting.pop() {
                group[j] = groups;
                // Sides touch the two corners beside them and, across those, one another.
                let reach: &[usize] = if j % 2 == 0 { &[1, 2, 6, 7] } else { &[1, 7] };
                for &step in reach {
                    let k = (j + step) % 8;
                    if n[k] && group[k] == usize::MAX {
                        waiting.push(k);
                    }
                }
            }
        }
    }
    groups == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::morphology::parts;
    use proptest::prelude::*;

    fn thinned(mask: &Mask) -> Mask {
        thin(mask, || Ok::<(), ()>(())).expect("never stops")
    }

    #[test]
    fn a_bar_becomes_a_line_through_its_middle() {
        let line = thinned(&Mask::from_fn(60, 21, |x, y| (5..55).contains(&x) && (6..15).contains(&y)));
        let pixels: Vec<(usize, usize)> =
            (0..21).flat_map(|y| (0..60).map(move |x| (x, y))).filter(|&(x, y)| line.get(x, y)).collect();
        assert!(pixels.len() > 35 && pixels.len() < 60);
        assert!(pixels.iter().filter(|(x, _)| (15..45).contains(x)).all(|(_, y)| (9..=11).contains(y)));
    }

    proptest! {
        #[test]
        fn parts_stay_parts(bits in prop::collection::vec(any::<bool>(), 15 * 11)) {
            let mask = Mask::from_fn(15, 11, |x, y| bits[y * 15 + x]);
            prop_assert_eq!(parts(&thinned(&mask)).areas.len(), parts(&mask).areas.len());
        }
    }
}
