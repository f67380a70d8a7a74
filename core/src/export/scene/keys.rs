//! Which frames are keys: as few as reproduce all others.

use glam::DVec2;

/// The frames that all others follow from by linear interpolation. `fits(from, to)` says whether those strictly between
/// two frames do. Greedy: every span is as long as doubling and halving find it. The first and the last frame are keys.
pub(super) fn linear(frames: usize, mut fits: impl FnMut(usize, usize) -> bool) -> Vec<usize> {
    let mut keys = vec![0];
    let mut from = 0;
    while from + 1 < frames {
        let (mut good, mut step) = (from + 1, 2);
        let mut bad = frames;
        while from + step < frames && fits(from, from + step) {
            good = from + step;
            step *= 2;
        }
        if from + step < frames {
            bad = from + step;
        }
        while good + 1 < bad {
            let middle = (good + bad) / 2;
            if fits(from, middle) { good = middle } else { bad = middle }
        }
        keys.push(good);
        from = good;
    }
    keys
}

/// The frames at which something changes, the first among them.
pub(super) fn stepped(frames: usize, mut same: impl FnMut(usize, usize) -> bool) -> Vec<usize> {
    let mut keys = vec![0];
    for frame in 1..frames {
        if !same(keys[keys.len() - 1], frame) {
            keys.push(frame);
        }
    }
    keys
}

/// How far `frame` is from one key to the next.
pub(super) fn share(frame: usize, from: usize, to: usize) -> f64 {
    (frame - from) as f64 / (to - from).max(1) as f64
}

/// A quantity over time: its keys, with frames that rise. Without keys it stays at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Channel {
    /// What it is at rest.
    pub(super) rest: DVec2,
    /// Frames and values.
    pub(super) keys: Vec<(usize, DVec2)>,
}

impl Channel {
    /// The channel through `values`, one a frame, rounded to multiples of `step` and right within `tolerance` in each
    /// component. No span changes a component by more than `most`, which turns need: readers take the shorter way round.
    pub(super) fn through(rest: DVec2, values: &[DVec2], step: f64, tolerance: f64, most: f64, holds: bool) -> Self {
        let round = |v: DVec2| (v / step).round() * step;
        let rest = round(rest);
        let near = |a: DVec2, b: DVec2| (a - b).abs().max_element() <= tolerance;
        if values.iter().all(|v| near(*v, rest)) {
            return Self { rest, keys: Vec::new() };
        }
        let frames = if values.iter().all(|v| near(*v, values[0])) {
            vec![0]
        } else if holds {
            stepped(values.len(), |a, b| near(values[a], values[b]))
        } else {
            linear(values.len(), |a, b| {
                (values[b] - values[a]).abs().max_element() <= most
                    && (a + 1..b).all(|f| near(values[a].lerp(values[b], share(f, a, b)), values[f]))
            })
        };
        Self { rest, keys: frames.into_iter().map(|f| (f, round(values[f]))).collect() }
    }

    /// Its value in `frame`, as players find it.
    pub(super) fn at(&self, frame: usize, holds: bool) -> DVec2 {
        let after = self.keys.partition_point(|k| k.0 <= frame);
        match (after.checked_sub(1).map(|k| self.keys[k]), self.keys.get(after)) {
            (Some((from, a)), Some(&(to, b))) if !holds => a.lerp(b, share(frame, from, to)),
            (Some((_, a)), _) => a,
            (None, Some(&(_, b))) => b,
            (None, None) => self.rest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;
    use proptest::prelude::*;

    #[test]
    fn a_straight_way_has_two_keys_and_a_bend_three() {
        let bent: Vec<DVec2> = (0..30).map(|f| dvec2(f64::from(f32::from(12 - i16::abs(12 - f))), 1.0)).collect();
        let own = Channel::through(DVec2::ZERO, &bent, 0.001, 0.01, f64::INFINITY, false);
        assert_eq!(own.keys.iter().map(|k| k.0).collect::<Vec<_>>(), [0, 12, 29]);
        let still = Channel::through(DVec2::ZERO, &[dvec2(3.0, 4.0); 9], 0.001, 0.01, f64::INFINITY, false);
        assert_eq!(still.keys, [(0, dvec2(3.0, 4.0))]);
        assert!(Channel::through(dvec2(3.0, 4.0), &[dvec2(3.0, 4.0); 9], 0.001, 0.01, 1.0, false).keys.is_empty());
    }

    proptest! {
        #[test]
        fn all_frames_come_back(values in prop::collection::vec(-200.0..200.0f64, 1..60), holds in any::<bool>()) {
            let values: Vec<DVec2> = values.into_iter().map(|v| dvec2(v, -v / 3.0)).collect();
            let own = Channel::through(DVec2::ZERO, &values, 0.001, 0.5, 120.0, holds);
            for (frame, value) in values.iter().enumerate() {
                prop_assert!((own.at(frame, holds) - *value).abs().max_element() <= 0.501);
            }
            if !holds {
                let jumps = own.keys.windows(2).all(|k| k[1].0 == k[0].0 + 1 || (k[1].1 - k[0].1).abs().max_element() <= 120.01);
                prop_assert!(jumps);
            }
        }
    }
}
