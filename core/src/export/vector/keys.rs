//! Which frames of a movement are written: as few as will do, where players go in straight lines from one to the next.
//!
//! The fewest keys by dynamic programming over the frames: from a key to a later one where all frames between lie within a
//! tolerance of the line. Lines through the frames themselves lie on one side of a bend; so keys are taken for a larger
//! tolerance, their values are those of least squares, and keys are added where a frame is off. Where that does not need
//! fewer keys, frames are keys as they are. No frame is farther off than the tolerance, rounding included.

/// Longest way from key to key, in frames: bounds the work on what hardly moves.
const LONGEST: usize = 240;
/// After so many ways in a row that miss a frame, longer ones are not tried: what turns away seldom comes back.
const MISSES: usize = 6;

/// How much farther off lines through frames may be than those of least squares. It is twice where frames bend evenly and
/// keys may lie anywhere; as they are frames, one that is a little less often needs fewer keys.
const SPREADS: [f64; 4] = [2.2, 1.9, 1.6, 1.3];

/// Keys of numbers over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Keys {
    /// Their frames, rising; a single one where nothing moves.
    pub(super) at: Vec<usize>,
    /// The numbers at each key, in units of the grid.
    pub(super) values: Vec<Vec<i64>>,
}

/// How finely movements are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Precision {
    /// How far a number may be off in any frame.
    pub(super) tolerance: f64,
    /// Decimals of keys.
    pub(super) decimals: u32,
}

impl Keys {
    /// Of the numbers in each frame. Rounding counts: where the grid is coarser than the tolerance, what it adds is allowed.
    pub(super) fn new(frames: &[Vec<f64>], precision: Precision) -> Self {
        let round = |frame: &[f64]| frame.iter().map(|v| super::units(*v, precision.decimals)).collect::<Vec<i64>>();
        let Some(first) = frames.first() else { return Self::default() };
        let scale = 10f64.powi(precision.decimals as i32);
        let tolerance = precision.tolerance.max(0.51 / scale);
        let still = Self { at: vec![0], values: vec![round(first)] };
        if still.worst(frames, scale).1 <= tolerance {
            return still;
        }
        let taken = |at: Vec<usize>| Self { values: at.iter().map(|f| round(&frames[*f])).collect(), at };
        let plain = taken(fewest(frames, tolerance - 0.5 / scale));
        let mut best = plain;
        for spread in SPREADS {
            let mut fitted = taken(fewest(frames, spread * tolerance));
            let most = (fitted.at.len() + fitted.at.len() / 6 + 2).min(best.at.len());
            while fitted.at.len() < most {
                fitted.values = fit(frames, &fitted.at).iter().map(|v| round(v)).collect();
                let (frame, off) = fitted.worst(frames, scale);
                if off <= tolerance {
                    best = fitted;
                    break;
                }
                // A key that is off itself has too long a way on one of its sides.
                match fitted.at.binary_search(&frame) {
                    Err(place) => fitted.at.insert(place, frame),
                    Ok(place) => {
                        let sides = [place.checked_sub(1), (place + 1 < fitted.at.len()).then_some(place)];
                        let ways = sides.into_iter().flatten().map(|i| (fitted.at[i + 1] - fitted.at[i], i));
                        let Some((2.., i)) = ways.max() else { break };
                        fitted.at.insert(i + 1, (fitted.at[i] + fitted.at[i + 1]) / 2);
                    }
                }
            }
        }
        best
    }

    /// The frame that is farthest off, and by how much.
    fn worst(&self, frames: &[Vec<f64>], scale: f64) -> (usize, f64) {
        let mut worst = (0, 0.0);
        let mut next = 0;
        for (f, own) in frames.iter().enumerate() {
            next += usize::from(next + 1 < self.at.len() && f > self.at[next]);
            let before = next.saturating_sub(1);
            let way = self.at[next] - self.at[before];
            let share = if way == 0 { 0.0 } else { (f - self.at[before]) as f64 / way as f64 };
            for ((a, b), own) in self.values[before].iter().zip(&self.values[next]).zip(own) {
                let (a, b) = (*a as f64 / scale, *b as f64 / scale);
                let off = (a + (b - a) * share - own).abs();
                if off > worst.1 {
                    worst = (f, off);
                }
            }
        }
        worst
    }
}

/// The fewest frames, the first and the last among them, from which lines pass within `tolerance` of all others.
fn fewest(frames: &[Vec<f64>], tolerance: f64) -> Vec<usize> {
    let last = frames.len() - 1;
    let fits = |from: usize, to: usize| {
        let one = |frame: usize| {
            let share = (frame - from) as f64 / (to - from) as f64;
            let off = |((a, b), own): ((&f64, &f64), &f64)| (a + (b - a) * share - own).abs() <= tolerance;
            frames[from].iter().zip(&frames[to]).zip(&frames[frame]).all(off)
        };
        // The middle first, where lines are farthest off.
        one((from + to) / 2) && (from + 1..to).all(one)
    };
    // Keys up to each frame, and the key before it.
    let mut best = vec![(usize::MAX, 0); frames.len()];
    best[0] = (1, 0);
    for from in 0..last {
        let mut misses = 0;
        for to in from + 1..=last.min(from + LONGEST) {
            if to > from + 1 && !fits(from, to) {
                misses += 1;
                if misses > MISSES {
                    break;
                }
            } else {
                misses = 0;
                if best[from].0 + 1 < best[to].0 {
                    best[to] = (best[from].0 + 1, from);
                }
            }
        }
    }
    let mut at = vec![last];
    while let Some(key) = at.last().copied().filter(|k| *k > 0) {
        at.push(best[key].1);
    }
    at.reverse();
    at
}

/// The values at these keys from which lines pass all frames with the least squares.
fn fit(frames: &[Vec<f64>], at: &[usize]) -> Vec<Vec<f64>> {
    let (keys, width) = (at.len(), frames[0].len());
    // Each frame depends on two keys: the normal equations have three diagonals, and a right side for each number.
    let (mut middle, mut side) = (vec![0.0; keys], vec![0.0; keys]);
    let mut right = vec![vec![0.0; width]; keys];
    let mut next = 0;
    for (f, own) in frames.iter().enumerate() {
        next += usize::from(f > at[next]);
        let before = next.saturating_sub(1);
        let way = at[next] - at[before];
        let share = if way == 0 { 1.0 } else { (f - at[before]) as f64 / way as f64 };
        for (key, weight) in [(before, 1.0 - share), (next, share)] {
            middle[key] += weight * weight;
            right[key].iter_mut().zip(own).for_each(|(r, v)| *r += weight * v);
        }
        side[before] += share * (1.0 - share);
    }
    // Every key is a frame, so no pivot is below 1.
    for k in 1..keys {
        let factor = side[k - 1] / middle[k - 1];
        middle[k] -= factor * side[k - 1];
        let (done, rest) = right.split_at_mut(k);
        rest[0].iter_mut().zip(&done[k - 1]).for_each(|(r, before)| *r -= factor * before);
    }
    for k in (0..keys).rev() {
        let (rest, done) = right.split_at_mut(k + 1);
        let after = done.first().map_or(&[][..], |d| d);
        rest[k].iter_mut().zip(after).for_each(|(r, after)| *r -= side[k] * after);
        rest[k].iter_mut().for_each(|r| *r /= middle[k]);
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FINE: Precision = Precision { tolerance: 0.1, decimals: 2 };

    #[test]
    fn straight_ways_need_two_keys_and_corners_one_more() {
        let line = |f: usize| vec![f as f64 * 0.37, 5.0 - f as f64];
        assert_eq!(Keys::new(&(0..90).map(line).collect::<Vec<_>>(), FINE).at, [0, 89]);
        let corner = |f: usize| vec![(f as f64 - 31.0).abs()];
        assert_eq!(Keys::new(&(0..90).map(corner).collect::<Vec<_>>(), FINE).at, [0, 31, 89]);
        let still = Keys::new(&vec![vec![1.004]; 90], FINE);
        assert_eq!((still.at, still.values), (vec![0], vec![vec![100]]));
        assert_eq!(Keys::new(&[], FINE), Keys::default());
    }

    #[test]
    fn bends_are_met_on_both_sides() {
        let wave: Vec<Vec<f64>> =
            (0..97).map(|f| vec![20.0 * (f as f64 * 0.13).sin(), 20.0 * (f as f64 * 0.13).cos()]).collect();
        let keys = Keys::new(&wave, Precision { tolerance: 0.5, decimals: 1 });
        let through = fewest(&wave, 0.5).len();
        assert!(keys.at.len() * 6 <= through * 5, "{} of {through}", keys.at.len());
    }

    proptest! {
        #[test]
        fn no_frame_is_farther_off_than_the_tolerance(
            frames in proptest::collection::vec(proptest::collection::vec(-3.0..3.0f64, 3), 1..40), tolerance in 0.0..2.0f64,
        ) {
            let keys = Keys::new(&frames, Precision { tolerance, decimals: 1 });
            for (f, own) in frames.iter().enumerate() {
                let next = keys.at.iter().position(|k| *k >= f).unwrap_or(keys.at.len() - 1);
                let before = next.saturating_sub(1);
                let span = (keys.at[next] - keys.at[before]).max(1) as f64;
                let share = if next == before { 0.0 } else { (f - keys.at[before]) as f64 / span };
                for (c, own) in own.iter().enumerate() {
                    let [a, b] = [before, next].map(|k| keys.values[k][c] as f64 / 10.0);
                    prop_assert!((a + (b - a) * share - own).abs() <= tolerance.max(0.051) + 1e-9);
                }
            }
        }
    }
}
