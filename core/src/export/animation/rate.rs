//! Frames a second as a fraction of whole numbers, for formats that count time in ticks.

/// The simplest fraction of numbers up to `most` that is as near to `fps` as can be told (continued fractions): 24000 and
/// 1001 for 23.976023976. `fps` is above 0.
pub(super) fn fraction(fps: f64, most: u32) -> (u32, u32) {
    let most = f64::from(most);
    let (mut before, mut best) = ((0.0, 1.0), (1.0, 0.0));
    let mut left = fps;
    for _ in 0..40 {
        let whole = left.floor();
        let next = (whole * best.0 + before.0, whole * best.1 + before.1);
        if next.0 > most || next.1 > most {
            break;
        }
        (before, best) = (best, next);
        // What is nearer than this was rounded on the way here.
        if (best.0 / best.1 / fps - 1.0).abs() < 1e-9 || left == whole {
            break;
        }
        left = 1.0 / (left - whole);
    }
    ((best.0 as u32).max(1), (best.1 as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_rates_are_exact() {
        for (fps, expected) in [
            (24.0, (24, 1)),
            (24_000.0 / 1001.0, (24_000, 1001)),
            (23.976_023_976, (24_000, 1001)),
            (30_000.0 / 1001.0, (30_000, 1001)),
            (12.5, (25, 2)),
            (0.01, (1, 100)),
            (1000.0, (1000, 1)),
            (1.0 / 3.0, (1, 3)),
        ] {
            assert_eq!(fraction(fps, 65_535), expected, "{fps}");
        }
        for i in 1..2000 {
            let fps = f64::from(i) * 0.377_124_9;
            let (num, den) = fraction(fps, 65_535);
            assert!(num <= 65_535 && den <= 65_535);
            assert!((f64::from(num) / f64::from(den) / fps - 1.0).abs() < 1e-4, "{fps}");
        }
    }
}
